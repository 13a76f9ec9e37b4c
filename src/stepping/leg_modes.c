/* Modes of a rod that grow faster than a step sees. */
#include "stepping/leg.h"
#include "rod/ask.h"
#include "rod/rules.h"

/* Is there anything across? (Twist alone leaves a rod straight.) */
static PetscErrorCode IsBent(const Rod rod, Vec U, PetscBool *bent) {
  PetscReal size[MAX_FIELDS];

  PetscFunctionBegin;
  *bent = PETSC_FALSE;
  PetscCall(RodFieldSizes(rod, U, size));
  for (PetscInt f = 0; f < rod->model->fields; f++)
    if (rod->model->group[f] != ALONG && rod->model->group[f] != TWIST &&
        size[f] > rod_rule.vanished)
      *bent = PETSC_TRUE;
  PetscFunctionReturn(0);
}

/* Does a rod in space lie in the plane of x1 and x2, to the last digit? Then none of what happens
   within the plane can bring it out of that, and no mode that leads out of it is there to be
   crossed.
 */
static PetscErrorCode IsPlane(const Rod rod, Vec U, PetscBool *plane) {
  PetscReal size[MAX_FIELDS];

  PetscFunctionBegin;
  *plane = rod->model->space;
  if (!*plane) PetscFunctionReturn(0);
  PetscCall(RodFieldSizes(rod, U, size));
  for (PetscInt f = 0; f < rod->model->fields; f++)
    if (rod->model->group[f] & ACROSS_3 && size[f] > rod_rule.vanished) *plane = PETSC_FALSE;
  PetscFunctionReturn(0);
}

/* Do modes of one rod, which can be counted, grow faster than the shift? U is its own. */
static PetscErrorCode RodCrosses(Leg *leg, PetscInt k, Vec U, PetscBool *crosses,
                                 PetscBool *known) {
  const Rod rod = leg->rod->each[k];
  PetscInt index;

  PetscFunctionBegin;
  *crosses = PETSC_FALSE;
  PetscCall(IsPlane(rod, U, &leg->newton.plane));
  PetscCall(NewtonIndex(&leg->newton, k, &index, known));
  if (!*known || (index <= 0 && index % 2 == 0)) PetscFunctionReturn(0);
  PetscCall(IsBent(rod, U, crosses));
  if (*crosses) PetscCall(PetscInfo(leg->ts, "crosses modes that grow: index %d\n", (int)index));
  PetscFunctionReturn(0);
}

/* Do modes of any rod at the latest Jacobian's state grow faster than its shift? known: can those
   of all be counted? */
static PetscErrorCode ModesCrossed(Leg *leg, Vec U, PetscBool *crosses, PetscBool *known) {
  PetscBool one = PETSC_FALSE, seen = PETSC_TRUE;
  Vec part;

  PetscFunctionBegin;
  *crosses = PETSC_FALSE;
  PetscCall(NewtonCounts(&leg->newton, known));
  if (!*known) PetscFunctionReturn(0);
  for (PetscInt k = 0; k < leg->rod->rods; k++) {
    PetscCall(RodPartOpenRead(leg->rod, k, U, &part));
    PetscCall(RodCrosses(leg, k, part, &one, &seen));
    PetscCall(RodPartCloseRead(leg->rod, k, U, &part));
    if (one) *crosses = PETSC_TRUE;
    if (!seen) *known = PETSC_FALSE;
  }
  PetscFunctionReturn(0);
}

/* Is anything across any rod? */
static PetscErrorCode AnyIsBent(const Rod all, Vec U, PetscBool *any) {
  Vec part;

  PetscFunctionBegin;
  *any = PETSC_FALSE;
  for (PetscInt k = 0; k < all->rods && !*any; k++) {
    PetscCall(RodPartOpenRead(all, k, U, &part));
    PetscCall(IsBent(all->each[k], part, any));
    PetscCall(RodPartCloseRead(all, k, U, &part));
  }
  PetscFunctionReturn(0);
}

/* The modes of the latest Jacobian's state, as its matrix is by now. */
static PetscErrorCode CrossedNow(Leg *leg, Vec U, PetscBool *crosses) {
  PetscBool known;

  PetscFunctionBegin;
  PetscCall(NewtonEliminate(&leg->newton, leg->newton.elimination));
  PetscCall(ModesCrossed(leg, U, crosses, &known));
  PetscFunctionReturn(0);
}

/*
  LegCrossesSlippery - would the modes grow, too, if no wall had friction? A first step, and a jump,
  go far in no time, and friction is against what that was: of a rod that has arrived nothing is
  told by it. Without it energy is behind the equations again, and a rod that does not give way on
  slippery walls does not on rough ones. Collective.

  crosses  in: with friction they do
*/
PetscErrorCode LegCrossesSlippery(Leg *leg, Vec U, PetscBool *crosses) {
  PetscErrorCode error;

  PetscFunctionBegin;
  if (!*crosses || !RodRubsOnWalls(leg->rod) || !leg->newton.elimination) PetscFunctionReturn(0);
  RodMakeSlippery(leg->rod, PETSC_TRUE);
  error = CrossedNow(leg, U, crosses);
  RodMakeSlippery(leg->rod, PETSC_FALSE); /* whatever came of it */
  PetscCall(error);
  PetscCall(NewtonEliminate(&leg->newton, leg->newton.elimination));
  PetscFunctionReturn(0);
}

/*
  LegCrossesMode - a VBDFCross: does a mode of the rod grow faster than the shift of the step? The
  elimination has counted them. On a straight rod, x2 = 0, none is there to be crossed. Where they
  cannot be counted (other models, a free rod), a jump is none that may be taken:
  the step is cut until its error is seen. (A first step whose error is within the tolerance has
  changed the rod by less than a crossed mode would that is more than 1e-3 of it.)

  With friction on walls or strands, or other friction across than along, or friction that feels a
  spin, no energy is behind the equations, and the modes of a state that is frozen are not those of
  the rod that moves on: what slides along a wall has left a place before a mode of it has grown.
  There only steps are looked at of which no error is known; likewise where far parts of a rod press
  on each other, which the count does not know, and where material comes to rest behind a growth
  zone: frozen, it gives way at once along itself where dry friction is next to exact, but it is
  laid down faster than that.
*/
PetscErrorCode LegCrossesMode(TS ts, Vec U, VBDFSight sight, PetscBool *crosses) {
  PetscBool known;
  Leg *leg;

  PetscFunctionBegin;
  PetscCall(TSGetApplicationContext(ts, &leg));
  *crosses = leg->crosses = PETSC_FALSE;
  if (sight == VBDF_SEEN && !RodHasModes(leg->rod)) PetscFunctionReturn(0);
  PetscCall(ModesCrossed(leg, U, crosses, &known));
  PetscCall(LegCrossesSlippery(leg, U, crosses));
  if (!known && sight == VBDF_JUMP) PetscCall(AnyIsBent(leg->rod, U, crosses));
  leg->crosses = *crosses;
  PetscFunctionReturn(0);
}

/*
  LegCrosses - has the step that has led to U crossed a mode that grows, so that to which side the
  rod gives way is not known? For steppers that do not ask (vbdf does, and takes none that has);
  false where that cannot be told. Collective.
*/
PetscErrorCode LegCrosses(Leg *leg, Vec U, PetscBool *crosses) {
  PetscBool vbdf, known;

  PetscFunctionBegin;
  *crosses = PETSC_FALSE;
  PetscCall(PetscObjectTypeCompare((PetscObject)leg->ts, TSVBDF, &vbdf));
  if (!vbdf && RodHasModes(leg->rod)) PetscCall(ModesCrossed(leg, U, crosses, &known));
  PetscFunctionReturn(0);
}

/* Counts the modes out of the plane that grow faster than a rate: a look, which leaves what
   Newton's method remembers as it is. */
static PetscErrorCode CountOutOfPlane(Leg *leg, PetscReal rate, PetscInt *out) {
  Vec memory = NULL;
  DM da = NULL;

  PetscFunctionBegin;
  if (leg->rod->memory) PetscCall(RodCreateMemory(leg->rod, &da, &memory));
  if (memory) PetscCall(RodRemember(leg->rod, memory));
  PetscCall(NewtonOutOfPlane(&leg->newton, rate, out));
  if (memory) PetscCall(RodRecall(leg->rod, memory));
  PetscCall(VecDestroy(&memory));
  PetscCall(DMDestroy(&da));
  PetscFunctionReturn(0);
}

/*
  LegLeavesPlane - would a rod in space, which lies in the plane of x1 and x2 to the last digit,
  leave it if anything pushed it out: do modes that nothing has begun grow by themselves within so
  much time, at the state of the latest step? False where they cannot be counted. Collective.
*/
PetscErrorCode LegLeavesPlane(Leg *leg, Vec U, PetscReal within, PetscBool *leaves) {
  PetscBool plane, bent;
  PetscInt out;

  PetscFunctionBegin;
  *leaves = PETSC_FALSE;
  PetscCall(IsPlane(leg->rod, U, &plane));
  if (!plane) PetscFunctionReturn(0);
  PetscCall(IsBent(leg->rod, U, &bent));
  if (!bent) PetscFunctionReturn(0);
  PetscCall(CountOutOfPlane(leg, 1 / within, &out));
  *leaves = (PetscBool)(out > 0);
  PetscFunctionReturn(0);
}
