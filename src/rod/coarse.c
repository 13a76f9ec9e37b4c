#include "rod/coarse.h"

/* Errors obey the slope of friction itself. That which Newton's method is better off with has a
   memory of the solve before, and none is made here: friction would hold errors along the motion,
   too, where it gives way to them. */
static void TakeSlopes(Scene coarse) {
  coarse->load.friction.newton = NEWTON_PRIMAL;
  coarse->contact.rub.newton = NEWTON_PRIMAL;
  coarse->tip.resistance.friction.newton = NEWTON_PRIMAL;
}

/* What its scene has of its own. */
static void MakeOwn(Scene own, PetscInt nodes, PetscReal *s, PetscBool meets) {
  own->comm = PETSC_COMM_SELF;
  TakeSlopes(own);
  own->contact.self = (PetscBool)(own->contact.self && meets);
  own->mesh.cells = nodes - 1;
  own->mesh.s = s;
  SceneLinkWalls(own);
}

/*
  RodCoarsen - a rod of the same scene with fewer nodes, on this rank alone. Not collective; the
  caller ends it with RodCoarseEnd(), before the rod.

  nodes, stride  node k of it is that of stride k, the last one the tip
  meets          it meets itself, if the rod does
*/
PetscErrorCode RodCoarsen(Rod rod, PetscInt nodes, PetscInt stride, PetscBool meets, Rod *coarse) {
  Scene own;
  PetscReal *s;

  PetscFunctionBegin;
  PetscCall(SceneShare(rod->scene, &own));
  PetscCall(PetscMalloc1(nodes, &s));
  for (PetscInt k = 0; k < nodes; k++) s[k] = rod->s[PetscMin(k * stride, rod->last)];
  MakeOwn(own, nodes, s, meets);
  PetscCall(RodCreate(own, rod->model, coarse));
  PetscFunctionReturn(0);
}

/* RodCoarseEnd - frees it, and the scene that it has. */
PetscErrorCode RodCoarseEnd(Rod *coarse) {
  Scene scene;

  PetscFunctionBegin;
  if (!*coarse) PetscFunctionReturn(0);
  scene = (*coarse)->scene;
  PetscCall(RodDestroy(coarse));
  PetscCall(PetscFree(scene->mesh.s));
  PetscCall(SceneShareEnd(&scene));
  PetscFunctionReturn(0);
}

/* RodCoarseTake - the rod's scene has been changed in the run: that of the coarse one is as it is
   now. */
void RodCoarseTake(Rod coarse, Rod rod, PetscBool meets) {
  Scene own = coarse->scene;
  PetscReal *const s = own->mesh.s;

  *own = *rod->scene;
  MakeOwn(own, coarse->last + 1, s, meets);
  own->contact.time = PETSC_MIN_REAL;
}

/* RodCoarseFollow - its laws are what those of the rod have become: a snap may change friction, and
   that of contact is the run's, whose mesh it may follow. */
void RodCoarseFollow(Rod coarse, Rod rod) {
  const Friction *law = &rod->scene->load.friction;
  const Contact *contact = &rod->scene->contact;
  Scene own = coarse->scene;

  own->load.friction.mu = law->mu;
  own->load.friction.viscous = law->viscous;
  own->load.friction.least = law->least;
  SceneAtSpeed(own, rod->scene->falls);
  own->contact.given = PETSC_TRUE;
  own->contact.stiffness = contact->stiffness;
  own->contact.firm = contact->firm;
  own->contact.time = PETSC_MIN_REAL;
}

/* RodCoarseGet - such a number. */
PetscReal RodCoarseGet(const Rod coarse, CoarseNumber number) {
  const struct _Scene *own = coarse->scene;

  return number == COARSE_BETA ? own->load.friction.beta : own->contact.stiffness;
}

/* RodCoarseSet - gives it another one. */
void RodCoarseSet(Rod coarse, CoarseNumber number, PetscReal value) {
  Scene own = coarse->scene;

  *(number == COARSE_BETA ? &own->load.friction.beta : &own->contact.stiffness) = value;
  own->contact.time = PETSC_MIN_REAL;
}
