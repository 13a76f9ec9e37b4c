/* Vectors of a plane, by value. */
#ifndef TENDRIL_PLANE_H
#define TENDRIL_PLANE_H

#include <petscsys.h>

typedef struct {
  PetscReal x, y;
} Vector2;

/* The first two of an array, and back. */
static inline Vector2 From2(const PetscReal a[]) {
  return (Vector2){a[0], a[1]};
}

/* Column c of a matrix of two rows, each of n. */
static inline Vector2 Column2(const PetscReal *M, int n, int c) {
  return (Vector2){M[c], M[n + c]};
}

static inline void Put2(Vector2 a, PetscReal to[]) {
  to[0] = a.x;
  to[1] = a.y;
}

/* Adds to the first two of an array. */
static inline void Add2(Vector2 a, PetscReal to[]) {
  to[0] += a.x;
  to[1] += a.y;
}

static inline Vector2 Plus2(Vector2 a, Vector2 b) {
  return (Vector2){a.x + b.x, a.y + b.y};
}

static inline Vector2 Minus2(Vector2 a, Vector2 b) {
  return (Vector2){a.x - b.x, a.y - b.y};
}

static inline Vector2 Times2(PetscReal s, Vector2 a) {
  return (Vector2){s * a.x, s * a.y};
}

static inline Vector2 Over2(Vector2 a, PetscReal s) {
  return (Vector2){a.x / s, a.y / s};
}

/* a + s b */
static inline Vector2 Along2(Vector2 a, PetscReal s, Vector2 b) {
  return (Vector2){a.x + s * b.x, a.y + s * b.y};
}

static inline Vector2 Direction2(PetscReal angle) {
  return (Vector2){PetscCosReal(angle), PetscSinReal(angle)};
}

/* b turned by an angle, of which a is cosine and sine; and back. */
static inline Vector2 Turned2(Vector2 a, Vector2 b) {
  return (Vector2){a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x};
}

static inline Vector2 TurnedBack2(Vector2 a, Vector2 b) {
  return (Vector2){a.x * b.x + a.y * b.y, a.x * b.y - a.y * b.x};
}

/* turned to the left by a quarter */
static inline Vector2 Left2(Vector2 a) {
  return (Vector2){-a.y, a.x};
}

static inline PetscReal Dot2(Vector2 a, Vector2 b) {
  return a.x * b.x + a.y * b.y;
}

/* positive where b is to the left of a */
static inline PetscReal Cross2(Vector2 a, Vector2 b) {
  return a.x * b.y - a.y * b.x;
}

static inline PetscReal Size2(Vector2 a) {
  return hypot(a.x, a.y);
}

#endif
