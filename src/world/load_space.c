#include "world/load_space.h"
#include "base/vectors.h"

/* f <- N M f, and the couple */
static void Vary(const Load *load, const Place *at, PetscReal f[RUBS]) {
  PetscReal by[3], N = load->field ? LoadFactor(load, at->x, at->t, by) : load->factor,
                   a = load->across, more = (1 - a) * Dot3(at->q, f);

  for (int d = 0; d < 3; d++) f[d] = N * (a * f[d] + more * at->q[d]);
  f[SPIN] *= N;
}

/* LoadSetArm - of W, once friction and walls are known. */
void LoadSetArm(Load *load) {
  load->arm = load->radius;
  if (load->arm == 0 && load->duals3 > 1) load->arm = load->walls->diameter / 2;
}

/* Does friction along the rod not feel the spin that W has? */
static inline PetscBool Deaf(const Load *load) {
  return (PetscBool)(load->arm != load->radius);
}

/* Takes off f what walls push with; returns the power of those that move. */
static PetscReal ForceWalls(const Load *load, const Place *at, const FrictionDual4 *dual,
                            PetscReal f[RUBS]) {
  const FrictionDual4 *slots = load->duals3 > 1 ? dual + 1 : NULL;
  const Rubbed rubbed = LoadRubbed(load, at);
  Touch3 touch[MOST_TOUCHES3];
  PetscInt n = ContactTouches3(load->walls, at->x, touch);
  PetscReal moved = 0;
  Push3 push;

  for (PetscInt k = 0; k < n; k++) {
    ContactPush3(load->walls, &touch[k], &rubbed, slots, &push);
    for (int d = 0; d < 3; d++) f[d] -= push.force[d];
    f[SPIN] -= push.couple;
    if (touch[k].moves) moved += Dot3(push.force, touch[k].v);
  }
  return moved;
}

/* LoadForce3 - the force F that the rod overcomes, per length, and the couple about its tangent. */
void LoadForce3(const Load *load, const Place *at, const FrictionDual4 *dual, PetscReal f[RUBS]) {
  PetscReal W[RUBS] = {at->v[0], at->v[1], at->v[2], Deaf(load) ? 0 : at->v[SPIN]};

  FrictionForce4(&load->friction, W, dual, f);
  if (load->varied) Vary(load, at, f);
  for (int d = 0; d < 3 && load->weighs; d++) f[d] -= load->weight[d];
  f[SPIN] *= load->radius;
  if (load->walls) (void)ForceWalls(load, at, dual, f);
}

/* LoadParts3 - the forces of friction and of walls on the rod, per length, and the power of walls
   that move. */
void LoadParts3(const Load *load, const Place *at, const FrictionDual4 *dual, PetscReal friction[3],
                PetscReal walls[3], PetscReal *moved) {
  PetscReal W[RUBS] = {at->v[0], at->v[1], at->v[2], Deaf(load) ? 0 : at->v[SPIN]};
  PetscReal f[RUBS], of_walls[RUBS] = {0};

  FrictionForce4(&load->friction, W, dual, f);
  if (load->varied) Vary(load, at, f);
  *moved = load->walls ? ForceWalls(load, at, dual, of_walls) : 0;
  for (int d = 0; d < 3; d++) {
    friction[d] = -f[d];
    walls[d] = -of_walls[d];
  }
}

/* LoadSeen3 - the same where nothing is held, as an observer sees it, and without weight. */
void LoadSeen3(const Load *load, const Place *at, PetscReal f[RUBS]) {
  const PetscReal spin = Deaf(load) ? 0 : at->v[SPIN];
  PetscReal drag = FrictionPhi(&load->friction, Dot3(at->v, at->v) + spin * spin);

  for (int d = 0; d < 3; d++) f[d] = drag * at->v[d];
  f[SPIN] = drag * spin;
  if (load->varied) Vary(load, at, f);
  f[SPIN] *= load->radius;
}

/* dN M f: by W, as friction feels it, by q and by x. */
static void SlopeVaried(const Load *load, const Place *at, const PetscReal W[RUBS],
                        const FrictionDual4 *dual, LoadSlope3 *slope) {
  PetscReal by[3] = {0}, N = load->field ? LoadFactor(load, at->x, at->t, by) : load->factor,
            a = load->across, f[RUBS], along;

  for (int c = 0; c < RUBS; c++) {
    along = (1 - a) *
            (at->q[0] * slope->W[0][c] + at->q[1] * slope->W[1][c] + at->q[2] * slope->W[2][c]);
    for (int d = 0; d < 3; d++) slope->W[d][c] = N * (a * slope->W[d][c] + along * at->q[d]);
    slope->W[SPIN][c] *= N;
  }
  FrictionForce4(&load->friction, W, dual, f);
  along = Dot3(at->q, f);
  for (int d = 0; d < 3; d++)
    for (int c = 0; c < 3; c++) {
      slope->q[d][c] = N * (1 - a) * ((d == c) * along + at->q[d] * f[c]);
      slope->x[d][c] = (a * f[d] + (1 - a) * along * at->q[d]) * by[c];
    }
  for (int c = 0; c < 3; c++) {
    slope->x[SPIN][c] = load->radius * f[SPIN] * by[c];
    slope->q[SPIN][c] = 0;
  }
}

/* The same of walls. */
static void SlopeWalls(const Load *load, const Place *at, PetscBool fresh, FrictionDual4 *dual,
                       LoadSlope3 *slope) {
  FrictionDual4 *slots = load->duals3 > 1 ? dual + 1 : NULL;
  const Rubbed rubbed = LoadRubbed(load, at);
  Touch3 touch[MOST_TOUCHES3];
  PetscInt n = ContactTouches3(load->walls, at->x, touch);
  Push3 push;

  if (slots) ContactSlots(n, touch, slots);
  for (PetscInt k = 0; k < n; k++) {
    ContactPushSlope3(load->walls, &touch[k], &rubbed, fresh, ContactSlot(&touch[k], slots), &push);
    for (int d = 0; d < RUBS; d++) {
      for (int c = 0; c < 3; c++) {
        slope->x[d][c] -= push.x[d][c];
        slope->q[d][c] -= push.q[d][c];
        slope->W[d][c] -= push.W[d][c];
      }
      if (load->arm > 0) slope->W[d][SPIN] -= push.W[d][SPIN] / load->arm;
    }
  }
}

/* LoadLinearise3 - the slope of force and couple for Newton's method, the duals brought up to the
   present velocity first; fresh: a Newton solve begins. Those by q and x are set only where
   LoadPlaced(). */
void LoadLinearise3(const Load *load, const Place *at, PetscBool fresh, FrictionDual4 *dual,
                    LoadSlope3 *slope) {
  PetscReal W[RUBS] = {at->v[0], at->v[1], at->v[2], Deaf(load) ? 0 : at->v[SPIN]};

  FrictionLinearise4(&load->friction, W, fresh, dual, slope->W);
  if (load->varied)
    SlopeVaried(load, at, W, dual, slope);
  else if (load->walls)
    for (int d = 0; d < RUBS; d++)
      for (int c = 0; c < 3; c++) slope->q[d][c] = slope->x[d][c] = 0;
  for (int c = 0; c < RUBS; c++) slope->W[SPIN][c] *= load->radius;
  for (int d = 0; d < RUBS && Deaf(load); d++) slope->W[d][SPIN] = 0;
  if (load->walls) SlopeWalls(load, at, fresh, dual, slope);
}

/* LoadHold3 - moves what holds a sticking place; returns the speed at which it creeps. */
PetscReal LoadHold3(const Load *load, const Place *at, PetscReal seen, FrictionDual4 dual[]) {
  PetscReal W[RUBS] = {at->v[0], at->v[1], at->v[2], Deaf(load) ? 0 : at->v[SPIN]};
  const Rubbed rubbed = LoadRubbed(load, at);
  PetscReal creep = FrictionDualHold4(W, seen, friction_hold, dual);

  if (load->duals3 == 1) return creep;
  return LargerOf(creep, ContactHold3(load->walls, &rubbed, seen, dual + 1));
}

/* LoadInSpace - does it act out of the plane of x1 and x2, whatever the rod does? */
PetscBool LoadInSpace(const Load *load) {
  return FieldInSpace(load->field);
}
