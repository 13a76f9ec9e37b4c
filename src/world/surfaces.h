/* Surfaces in space: what stands around a rod that is not confined to a plane (there: walls.h).
   Each is a signed distance d(x), positive where the rod may be, with its gradient n, |n| = 1, and
   its Hessian H, all smooth where the rod can touch. All here is in the laboratory's frame. */
#ifndef TENDRIL_SURFACES_H
#define TENDRIL_SURFACES_H

#include "base/blocks.h"
#include "world/motion.h"

/* A surface near a point. */
typedef struct {
  PetscReal distance;   /* d of the point: below 0 behind the surface */
  PetscReal normal[3];  /* n = grad d, into the free side */
  PetscReal bend[3][3]; /* H, dn = H dx: symmetric, H n = 0 */
} SurfacePoint;

typedef struct _Surface Surface;

/* What stands out of a surface and may be narrower than a cell of the rod (rod/feet.h):
   itself a surface of that kind, no part of which is in front of it. What is flat has none. */
typedef struct {
  void *data;
  PetscReal smallest; /* the least radius of curvature */
  PetscReal beside; /* an edge's: radius of what is round, ends in it and is met in its place where
                       that is narrow, too; PETSC_MAX_REAL: none */
} SurfaceRidge;
enum { MOST_RIDGES = 3 };

/* The line of a file that says what a surface is: word[0] is its kind; what every surface may have
   (motion, friction) has been taken off its end. */
typedef struct {
  const char *file;
  int line;
  PetscInt n;
  char **word;
  PetscReal radius; /* of the rod */
} SurfaceLine;

/* How well a surface's distance is known: to the last digit; from points, whose numbers mirror each
   other to round-off only; or interpolated between those of a grid, too, so that n is not quite of
   length 1. */
typedef enum { SURFACE_EXACT, SURFACE_OF_POINTS, SURFACE_ON_A_GRID } SurfaceKnown;

/* A kind of surface. */
typedef struct {
  const char *name;
  const char *form; /* what it is given by, for who has it wrong */
  SurfaceKnown known;
  /* reads a line: sets data, box, smallest, core and what is to be drawn; collective. What it has
     set is destroyed also after an error. */
  PetscErrorCode (*make)(const SurfaceLine *line, Surface *surface);
  /* the surface as seen from x; false: farther away than `within`, and point is not set. Behind the
     surface, however deep, it is true. Not collective; called at every point of the rod. */
  PetscBool (*at)(const void *data, const PetscReal x[3], PetscReal within, SurfacePoint *point);
  PetscErrorCode (*destroy)(void **data);
} SurfaceKind;

struct _Surface {
  const SurfaceKind *kind;
  void *data;
  int line;         /* of the file, where it stands */
  PetscBool hollow; /* the rod is to be in it */
  PetscReal room; /* how far a rod on its axis is from it, at the narrowest; PETSC_MAX_REAL: far */
  PetscBool bare; /* does not say its own friction */
  PetscReal friction;
  PetscReal off; /* by so much it is farther away than given: see ContactStandOff() */
  SurfaceMotion motion;
  Block box;          /* d is not less than the distance from it; SurfaceEverywhere(): no bound */
  PetscReal smallest; /* where it stands out, the least radius of curvature, 0 of a sharp edge;
                         PETSC_MAX_REAL: nowhere */
  PetscInt ridges;
  SurfaceRidge
      ridge[MOST_RIDGES]; /* where a kind sets none and it stands out, the surface itself */
  PetscReal core; /* depth of the deepest place behind it, with free space on its other side;
                     PETSC_MAX_REAL: it has no other side */
  /* to be drawn, and to be given again: the words of its line but for motion and friction,
     dimensionless */
  char *text;
};

typedef struct _SurfaceView SurfaceView;

typedef struct {
  PetscInt n, room;
  Surface *surface;
  PetscBool rub;                  /* any has friction */
  PetscReal time;                 /* at which they are looked at: see SurfaceMotion */
  PetscReal smallest;             /* of all */
  Blocks near;                    /* those that are somewhere: item k is surface placed[k] */
  PetscInt *placed, *open, opens; /* the others are looked at from everywhere */
  /* what stands out, item by item; those from near_ridges on are somewhere, as blocks of the tree
   */
  PetscInt ridges, far_ridges;
  struct SurfaceRidgeItem {
    PetscInt surface, ridge;
  } * ridge;
  Blocks near_ridges;
  SurfaceView *view; /* what was seen from places looked from of late; NULL: they are not kept */
} Surfaces;

enum { MOST_SURFACES = 16 }; /* at one place */

extern const SurfaceKind surface_plane, surface_sphere, surface_cylinder, surface_cone,
    surface_torus, surface_tube, surface_body;

PetscBool SurfacesKnow(PetscInt n, char *const word[]);
PetscErrorCode SurfacesAdd(const SurfaceLine *line, PetscReal friction, Surfaces *surfaces);
PetscErrorCode SurfacesIndex(Surfaces *surfaces);
PetscErrorCode SurfacesIndexAnew(Surfaces *surfaces);
PetscErrorCode SurfacesDestroy(Surfaces *surfaces);
PetscErrorCode SurfacesText(const Surfaces *surfaces, char **text);
PetscInt SurfacesNear(const Surfaces *surfaces, const PetscReal x[3], PetscReal within,
                      PetscInt which[MOST_SURFACES], SurfacePoint point[MOST_SURFACES]);
PetscReal SurfacesDistance(const Surfaces *surfaces, const PetscReal x[3], PetscReal within,
                           PetscInt *nearest);
void SurfacesRidgesNear(const Surfaces *surfaces, const Block *place, PetscReal reach,
                        BlocksMeet meet, void *ctx);
PetscBool SurfacesRidgeAt(const Surfaces *surfaces, PetscInt item, const PetscReal x[3],
                          PetscReal within, SurfacePoint *point);
PetscReal SurfaceShifted(const Surface *surface, PetscReal t, const PetscReal shift[3],
                         const PetscReal x[3]);
void SurfaceMiddle(const Surface *surface, PetscReal x[3]);
PetscBool SurfacesJerk(const Surfaces *surfaces, PetscReal t0, PetscReal t1);
PetscReal SurfacesNextTurn(const Surfaces *surfaces, PetscReal t);
PetscErrorCode SurfaceNumber(const SurfaceLine *line, PetscInt k, Dimension dimension,
                             PetscReal *value);
PetscErrorCode SurfaceMalformed(const SurfaceLine *line, const SurfaceKind *kind);

/* SurfaceAt - the surface, where it is given, as seen from x; false: it is farther away than
 * `within`. */
static inline PetscBool SurfaceAt(const Surface *surface, const PetscReal x[3], PetscReal within,
                                  SurfacePoint *point) {
  return surface->kind->at(surface->data, x, within, point);
}

/* SurfaceHolds - is the rod, at x, where a surface that it is to be inside of can push it? Beyond
 * the open ends of one there is no wall, and beside it none, either. */
static inline PetscBool SurfaceHolds(const Surface *surface, const PetscReal x[3]) {
  SurfacePoint point;

  return (PetscBool)(!surface->hollow || SurfaceAt(surface, x, PETSC_MAX_REAL, &point));
}

/* The box of a surface that has no bounds. */
static inline Block SurfaceEverywhere(void) {
  const PetscReal far = 1e300;
  return (Block){{-far, -far, -far}, {far, far, far}};
}

#endif
