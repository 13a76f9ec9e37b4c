#include "scene/scene.h"

/* What is given over time by rows. */
static PetscErrorCode InTime(Scene scene, PetscReal tolerance, Bends *bends) {
  const Growth growth = scene->growth;

  PetscFunctionBegin;
  if (growth->bends) PetscCall(growth->bends(growth, tolerance, bends));
  PetscCall(CurvatureBendsInTime(&scene->curvature, tolerance, bends));
  if (scene->load.field) PetscCall(FieldBendsInTime(scene->load.field, tolerance, bends));
  if (scene->tip.resistance.field)
    PetscCall(FieldBendsInTime(scene->tip.resistance.field, tolerance, bends));
  if (scene->tip.path) PetscCall(PathBends(scene->tip.path, tolerance, bends));
  if (scene->space.clamp_path) PetscCall(ScheduleBends(scene->space.clamp_path, tolerance, bends));
  PetscFunctionReturn(0);
}

/* Adds the arc lengths of a rod along its clamp at which a field bends, and the same farther by so
   much. */
static PetscErrorCode AlongRod(Scene scene, const Load *load, PetscReal farther,
                               PetscReal tolerance, Bends *arcs) {
  const PetscReal across = 1e-8;

  PetscFunctionBegin;
  for (int d = 0; d < 3; d++) {
    const PetscReal along = load->lab[d][0]; /* of the clamp's direction */
    Bends places = {0};
    if (PetscAbsReal(along) < across) continue;
    PetscCall(FieldBendsAlong(load->field, d, tolerance, &places));
    for (PetscInt k = 0; k < places.n; k++) {
      const PetscReal p = places.at[k] / along;
      PetscCall(BendsAdd(arcs, p));
      if (farther > 0) PetscCall(BendsAdd(arcs, p + farther));
    }
    PetscCall(BendsDestroy(&places));
  }
  PetscFunctionReturn(0);
}

/* When, between two times, the rod is as long as so. */
static PetscErrorCode WhenSoLong(Scene scene, PetscReal a, PetscReal b, PetscReal longer,
                                 PetscReal length, PetscReal *t) {
  PetscReal L;

  PetscFunctionBegin;
  for (*t = (a + b) / 2; *t > a && *t < b; *t = (a + b) / 2) {
    PetscCall(GrowthLength(scene->growth, *t, &L, NULL));
    if ((longer > 0) == (L > length))
      b = *t;
    else
      a = *t;
  }
  PetscFunctionReturn(0);
}

/* Adds the times at which the tip passes places along the rod, each between two of those at which
   its length bends, so that it goes one way only. */
static PetscErrorCode Passes(Scene scene, Bends *arcs, Bends *bends) {
  const PetscInt n = bends->n;
  PetscReal a = 0, b, L[2], t, longest = scene->reach;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < n; k++) {
    PetscCall(GrowthLength(scene->growth, bends->at[k], &L[0], NULL));
    longest = PetscMax(longest, L[0]);
  }
  PetscCall(BendsSort(arcs, 0, longest));
  PetscCall(GrowthLength(scene->growth, 0, &L[0], NULL));
  for (PetscInt k = 0; k <= n; k++, a = b, L[0] = L[1]) {
    b = k < n ? bends->at[k] : scene->end_time;
    PetscCall(GrowthLength(scene->growth, b, &L[1], NULL));
    for (PetscReal p = BendsNext(arcs, PetscMin(L[0], L[1])); p < PetscMax(L[0], L[1]);
         p = BendsNext(arcs, p)) {
      PetscCall(WhenSoLong(scene, a, b, L[1] - L[0], p, &t));
      PetscCall(BendsAdd(bends, t));
    }
  }
  PetscFunctionReturn(0);
}

/*
  SceneBends - the times up to the end, in order, at which what tables give bends (base/bends.h):
  over time, and along the rod where its tip comes by, if its force changes there, or if the rod
  grows in a zone at its tip only. Without tables there are none. Not collective.

  tolerance   between the times no table is farther from a straight line, as a part of its size
  bends       the caller frees it with BendsDestroy(), also after an error
*/
PetscErrorCode SceneBends(Scene scene, PetscReal tolerance, Bends *bends) {
  const Load *tip = &scene->tip.resistance;
  PetscErrorCode error = 0;
  Bends arcs = {0};

  PetscFunctionBegin;
  *bends = (Bends){0};
  PetscCall(InTime(scene, tolerance, bends));
  PetscCall(BendsSort(bends, 0, scene->end_time));
  if (tip->field) PetscCall(AlongRod(scene, tip, 0, tolerance, &arcs));
  if (scene->load.field && scene->growth->finest > 0)
    PetscCall(AlongRod(scene, &scene->load, scene->growth->finest, tolerance, &arcs));
  if (arcs.n && scene->growth->yield == 0) error = Passes(scene, &arcs, bends);
  PetscCall(BendsDestroy(&arcs));
  PetscCall(error);
  PetscCall(BendsSort(bends, 0, scene->end_time));
  PetscFunctionReturn(0);
}

/* SceneFewBends - the same for who has no time for more than so many: those of noise are passed
   over first. On exit the tolerance is what that took; of size 1 and more nothing is passed over
   any further. */
PetscErrorCode SceneFewBends(Scene scene, PetscInt most, PetscReal *tolerance, Bends *bends) {
  PetscErrorCode error = SceneBends(scene, *tolerance, bends);

  PetscFunctionBegin;
  while (!error && bends->n > most && *tolerance < 1) {
    PetscCall(BendsDestroy(bends));
    *tolerance *= 4;
    error = SceneBends(scene, *tolerance, bends);
  }
  PetscCall(error);
  PetscFunctionReturn(0);
}
