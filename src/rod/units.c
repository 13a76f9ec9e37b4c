/*
  A scene without units is one of many that are the same but for their scales: lengths times c,
  times as friction has it. What is no option's, the first step, say, must not tell them apart. So
  it is a part of what the scene itself makes units of:

    length l, time tau   of a rod that grows, or is fed, at the speed u: over l a bend takes what
                         friction gives, B/l^3 = N ((1 - mu) u + mu), in l/u. Else its length, and
                         its own time, or l over the speed that friction's beta tells from rest.
    own time             (1 - mu) N L^4/B: in it viscous friction lets a rod of length L change its
                         shape, in waves of it in a part of it. What happens within it must be
                         stepped through: a step that is longer damps what should grow. 0 if
  friction is dry: such a rod moves at once.

  All as the run begins: a restarted one has those of the unbroken one.
*/
#include "rod/rod.h"
#include "rod/rules.h"

/* Of its least and its mean: what friction is multiplied by along the initial shape. unheld: by 0
   somewhere. */
static PetscErrorCode FactorAlong(Rod rod, PetscReal *factor, PetscBool *unheld) {
  const Load *load = &rod->scene->load;
  PetscReal least = PETSC_MAX_REAL, sum = 0, slope[3];
  Node *nodes;

  PetscFunctionBegin;
  *factor = load->factor > 0 ? load->factor : 1;
  *unheld = PETSC_FALSE;
  if (!load->field) PetscFunctionReturn(0);
  PetscCall(PetscMalloc1(rod->end - rod->first, &nodes));
  PetscCall(RodInitialNodes(rod, 0, nodes));
  for (PetscInt i = 0; i < rod->end - rod->first; i++) {
    const PetscReal N = LoadFactor(load, nodes[i].x, 0, slope);
    least = PetscMin(least, N);
    sum += N;
  }
  PetscCall(PetscFree(nodes));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPIU_REAL, MPI_MIN, rod->scene->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPIU_REAL, MPI_SUM, rod->scene->comm));
  *factor = PetscMax(least, rod_rule.least_friction * sum / (PetscReal)(rod->last + 1));
  *unheld = (PetscBool)(least <= 0);
  if (!(*factor > 0)) *factor = 1; /* there is no friction at all where it begins */
  PetscFunctionReturn(0);
}

/* The largest bending stiffness along the rod. */
static PetscErrorCode StiffnessAlong(Scene scene, PetscReal *most) {
  PetscReal B;

  PetscFunctionBegin;
  *most = 0;
  for (PetscInt i = 0; i <= scene->mesh.cells; i++) {
    PetscCall(SceneStiffness(scene, scene->mesh.s[i], 0, &B, NULL));
    *most = PetscMax(*most, B);
  }
  if (scene->space.rod) *most *= PetscMax(1, scene->space.ratio);
  PetscFunctionReturn(0);
}

/* The speed at which a rod grows, or is fed: the fastest of a table. */
static PetscErrorCode GrowthOf(Scene scene, PetscReal *speed) {
  const PetscReal all = scene->growth->end_time, /* of a table: whenever the run ends */
      end = all < PETSC_MAX_REAL ? all : scene->end_time;
  PetscReal length, rate;

  PetscFunctionBegin;
  *speed = scene->growth->fastest;
  for (int k = 0;
       k <= rod_rule.times_looked_at && !scene->growth->still && scene->growth->fastest == 0; k++) {
    PetscCall(GrowthLength(scene->growth, end * k / rod_rule.times_looked_at, &length, &rate));
    *speed = PetscMax(*speed, PetscAbsReal(rate));
  }
  PetscFunctionReturn(0);
}

/* What short steps are part of. */
static PetscReal Brief(const struct _Scene *scene, PetscReal own, PetscReal length,
                       PetscReal speed) {
  const PetscReal T = scene->end_time;
  PetscReal brief = own;

  if (LoadIsDry(&scene->load)) return T;
  if (scene->contact.any) brief = PetscMax(brief, rod_rule.brief_of_run * T);
  if (scene->contact.any && speed > 0) brief = PetscMax(brief, length / speed);
  return PetscMin(T, brief);
}

static PetscErrorCode Find(Rod rod) {
  const Scene scene = rod->scene;
  const Load *load = &scene->load;
  const PetscReal T = scene->end_time, beta = load->friction.beta;
  SceneUnits *units = &scene->units;
  PetscReal N, B, L, speed;

  PetscFunctionBegin;
  units->straight = (PetscBool)(scene->shape.type == SHAPE_STRAIGHT);
  PetscCall(FactorAlong(rod, &N, &units->unheld));
  PetscCall(StiffnessAlong(scene, &B));
  PetscCall(GrowthLength(scene->growth, 0, &L, NULL));
  PetscCall(GrowthOf(scene, &speed));
  units->stiffness = B;
  units->speed = speed > 0 ? speed : L / T; /* what does not grow may be led */
  units->own =
      LoadLeastViscous(load, units->speed) * N * PetscMin(1, load->across) * PetscSqr(L * L) / B;
  if (units->own > 0) units->own = PetscMax(units->own, rod_rule.least_own_time * T);
  units->brief = Brief(scene, units->own, L, speed);
  if (speed > 0) {
    units->length = PetscPowReal(B / (N * (load->viscous * speed + 1 - load->viscous)), 1. / 3);
    units->time = units->length / speed;
  } else {
    units->length = L;
    units->time = load->viscous > 0
                      ? units->own
                      : L / (beta > 0 ? PetscSqrtReal(beta / rod_rule.beta_of_growth) : 1);
  }
  scene->tip.per_turn = units->stiffness / units->length;
  scene->tip.per_place = units->stiffness / (units->length * units->length * units->length);
  units->found = PETSC_TRUE;
  PetscFunctionReturn(0);
}

/* RodFindUnits - finds them for the rod's scene, unless that is done, and gives dry friction the
   least viscous share that goes with them. Collective. */
PetscErrorCode RodFindUnits(Rod rod) {
  Scene scene = rod->scene;

  PetscFunctionBegin;
  if (!scene->units.found) PetscCall(Find(rod));
  LoadShareLeast(&scene->load, scene->units.speed);
  PetscFunctionReturn(0);
}

/* RodFieldUnit - the scene's unit of a field, and of the equations that are its rows. */
PetscReal RodFieldUnit(const Rod rod, PetscInt field) {
  const SceneUnits *units = &rod->scene->units;
  const PetscReal L = units->length, B = units->stiffness;

  switch (rod->model->field[field][0]) {
  case 'x':
  case 'y':
  case 'L':
    return L;
  case 'm':
    return B / L;
  case 'n':
  case 'l': /* lambda, a force */
    return B / (L * L);
  case 'k':
  case 'f': /* what sets a bend */
    return 1 / L;
  default:
    return 1;
  }
}
