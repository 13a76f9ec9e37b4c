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

/* Of several that go together, one beside each. */
static PetscErrorCode CoarsenEach(Rod rod, PetscBool meets, Rod *coarse) {
  Rod *each;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(rod->rods, &each));
  for (PetscInt k = 0; k < rod->rods; k++)
    PetscCall(RodCoarsen(rod->each[k], rod->each[k]->last + 1, 1, meets, &each[k]));
  PetscCall(rod->model->again(rod, each, coarse));
  PetscCall(PetscFree(each));
  PetscFunctionReturn(0);
}

/*
  RodCoarsen - a rod of the same scene with fewer nodes, on this rank alone. Not collective; the
  caller ends it with RodCoarseEnd(), before the rod.

  nodes, stride  node k of it is that of stride k, the last one the tip; several that go together
                 have all their nodes
  meets          it meets itself, if the rod does
*/
PetscErrorCode RodCoarsen(Rod rod, PetscInt nodes, PetscInt stride, PetscBool meets, Rod *coarse) {
  Scene own;
  PetscReal *s;

  PetscFunctionBegin;
  if (rod->at) {
    PetscCall(CoarsenEach(rod, meets, coarse));
    PetscFunctionReturn(0);
  }
  PetscCall(SceneShare(rod->scene, &own));
  PetscCall(PetscMalloc1(nodes, &s));
  for (PetscInt k = 0; k < nodes; k++) s[k] = rod->s[PetscMin(k * stride, rod->last)];
  MakeOwn(own, nodes, s, meets);
  PetscCall(RodCreate(own, rod->model, coarse));
  PetscFunctionReturn(0);
}

/* RodCoarseEnd - frees it, and the scene that it has, or each of several. */
PetscErrorCode RodCoarseEnd(Rod *coarse) {
  PetscInt n;
  Scene *scene;

  PetscFunctionBegin;
  if (!*coarse) PetscFunctionReturn(0);
  n = (*coarse)->rods;
  PetscCall(PetscMalloc1(n, &scene));
  for (PetscInt k = 0; k < n; k++) scene[k] = (*coarse)->each[k]->scene;
  PetscCall(RodDestroy(coarse));
  for (PetscInt k = 0; k < n; k++) {
    PetscCall(PetscFree(scene[k]->mesh.s));
    PetscCall(SceneShareEnd(&scene[k]));
  }
  PetscCall(PetscFree(scene));
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

/* One rod's laws. */
static void Follow(Rod coarse, Rod rod) {
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

/* RodCoarseFollow - its laws are what those of the rod have become: a snap may change friction, and
   that of contact is the run's, whose mesh it may follow. */
void RodCoarseFollow(Rod coarse, Rod rod) {
  for (PetscInt k = 0; k < rod->rods; k++) Follow(coarse->each[k], rod->each[k]);
}

/* RodCoarseGet - such a number, of one rod. */
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
