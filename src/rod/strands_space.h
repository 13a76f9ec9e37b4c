/* Strands of a rod in space: it touches itself. Samples, evenly spread over each cell and close
   enough for strands that cross, look for the nearest place of every other strand on the smooth
   curve of the rod. With W a sample's share of the rod's length, halved because both strands look,

     E = sum_i W_i U(gamma_i),   gamma = |x_i - x(foot)| - D,   foot: (x_i - x(foot)).x' = 0,

   and the forces are those of this energy: p W n on the sample, the opposite on the foot, each
   handed to the four points around it (curve/spread.h). So they cancel, in force and moment.
   Friction acts where the surfaces touch, against the velocity at which they slip by each other,

     f = p n - mu p w(V),   V = (I - n n^T)(v_i - v_foot) + omega_i a_i + omega_foot a_foot,
     a = -D/2 t x n,   w as the law of friction has it,

   omega a strand's spin about its tangent t, and bears on both the couple a.f t: two strands roll
   on each other, and what friction takes is mu p w.V. (That tangents turn, and the couples across
   them, are left out as on walls: contact_space.h.) */
#ifndef TENDRIL_STRANDS_SPACE_H
#define TENDRIL_STRANDS_SPACE_H

#include "scene/scene.h"

typedef struct _Strands3 *Strands3;

/* The state of the whole rod: x and p of node i at u[i * stride]; rates likewise, or NULL. */
typedef struct {
  PetscReal t;
  PetscInt stride;
  const PetscReal *u, *u_t;
} StrandState3;

enum { STRAND3_NODE = 7, STRAND3_CELL = 2 * STRAND3_NODE, STRAND3_UNKNOWNS = 2 * STRAND3_CELL };
enum { STRAND3_TAKERS = 8 };

/* One contact: the unknowns it depends on are x and p of nodes a and b of two cells, that of the
   sample and that of the foot; the points that take its force: n' = -load of point k changes by
   `by` times them. */
typedef struct {
  PetscInt cell[2]; /* of the sample, of the foot */
  PetscInt takers;
  PetscInt taker[STRAND3_TAKERS]; /* points (curve/spread.h); the force on the tip is 2 cells + 1 */
  PetscReal by[STRAND3_TAKERS][3][STRAND3_UNKNOWNS];
  PetscBool couples; /* there are: m' changes likewise */
  PetscReal couple_by[STRAND3_TAKERS][3][STRAND3_UNKNOWNS];
} StrandSlope3;

/* What all contacts amount to. */
typedef struct {
  PetscReal energy, loss; /* int U, power lost to friction */
  PetscReal normal;       /* sum of normal forces */
  PetscReal clamp[3];     /* what the clamp of a rod that is fed in bears of them */
  PetscReal sum[3];       /* of all forces, with that: 0 */
  PetscReal strain;       /* power of material that is laid down where it is pressed, and of a law
                             that changes in time */
  PetscReal nearest;      /* the smallest gap, if any is small */
  PetscReal at[2], x[3];  /* the labels where it is, and the place between them */
  PetscInt zones;         /* stretches of the rod that touch what lies farther along it */
} StrandSum3;

PetscErrorCode Strands3Create(Scene scene, Strands3 *strands);
PetscErrorCode Strands3Destroy(Strands3 *strands);
PetscErrorCode Strands3Search(Strands3 strands, const StrandState3 *state);
PetscErrorCode Strands3Load(Strands3 strands, const StrandState3 *state);
const PetscReal (*Strands3Forces(Strands3 strands))[3];
const PetscReal (*Strands3Couples(Strands3 strands))[3];
PetscErrorCode Strands3Linearise(Strands3 strands, const StrandState3 *state,
                                 const PetscReal shift[STRAND3_NODE], PetscBool fresh, PetscInt *n,
                                 const StrandSlope3 **slopes);
void Strands3Sum(Strands3 strands, StrandSum3 *sum);
PetscErrorCode Strands3Near(Strands3 strands, PetscInt *n, PetscInt (**cells)[2]);

#endif
