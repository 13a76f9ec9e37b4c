/* What -task stability prints and stores: verdicts, the table of curves, the largest transient
   growth. */
#include "tasks/stability_run.h"
#include "straight/transient.h"

const CurveText stability_curve[CURVES] = {
    {"lambda_max_A", "lambda(A)", "largest real part of the eigenvalues of A(t) [k]",
     "every mode, frozen in time, decays"},
    {"lambda_max_A_plus_AT", "lambda(A+A^T)",
     "largest eigenvalue of A + A^T in the discrete L2 norm, twice the rate in it [k]",
     "stable in plain L2"},
    {"lambda_max_C", "lambda(C)",
     "largest eigenvalue of C(t) = W^T W A + transpose against the L2 norm, W the left "
     "eigenvectors "
     "of A(t_cr) [k]",
     "stable in the W norm"},
    {"rate_friction_norm", "friction rate",
     "largest growth rate of any deflection in the friction norm [k]",
     "stable in the friction norm"}};

/* Is A self-adjoint in the friction norm, and that norm the same at all times but for a factor? For
   uniform growth it is, with friction that is the same in all directions and places, and a tip that
   is free or pushed along the clamp; weight along the rod changes nothing of that. */
static PetscBool IsSelfAdjoint(Scene scene) {
  return (PetscBool)(scene->growth->even && !scene->growth->slides && !scene->load.varied &&
                     !StraightIsTwisted(scene) &&
                     (scene->tip.force == 0 || scene->tip.law == TIP_DEAD));
}

PetscErrorCode StabilityPrint(const Stability *self) {
  const PetscBool slides = self->scene->growth->slides;
  const PetscReal start = self->set.start;
  PetscReal best = start;

  PetscFunctionBegin;
  for (int c = 0; c < CURVES; c++) {
    if (!self->has[c]) continue;
    if (c != CURVE_A && (c != CURVE_W || !slides)) best = PetscMax(best, self->until[c]);
    if (self->until[c] <= start)
      PetscCall(PetscPrintf(OptionsComm(), "%-32s not even at t = %g\n", stability_curve[c].verdict,
                            (double)start));
    else
      PetscCall(PetscPrintf(OptionsComm(), "%-32s on [%g, %.10g)%s\n", stability_curve[c].verdict,
                            (double)start, (double)self->until[c],
                            self->beyond[c] ? " at least" : ""));
  }
  if (self->bends.n)
    PetscCall(PetscPrintf(OptionsComm(),
                          "(Looked at between the times above, too, wherever tables bend by more "
                          "than %.1g %% of what they give.)\n",
                          (double)(100 * self->straight_on)));
  if (!self->has[CURVE_FRICTION]) PetscFunctionReturn(0);
  if (IsSelfAdjoint(self->scene))
    PetscCall(PetscPrintf(OptionsComm(),
                          "Uniform growth: A is self-adjoint in the friction norm, so the rod is "
                          "exponentially stable exactly up to t_cr.\n"));
  else
    PetscCall(
        PetscPrintf(OptionsComm(),
                    "Best norm: decay for certain up to t = %.8g; the frozen modes grow from t_cr "
                    "= %.8g on; gap %.2g.\n",
                    (double)best, (double)self->critical.t, (double)(self->critical.t - best)));
  if (slides && self->has[CURVE_W])
    PetscCall(
        PetscPrintf(OptionsComm(),
                    "(The W norm, as the modes, is judged on a rod of frozen length: no proof for "
                    "one that is fed.)\n"));
  if (best > self->critical.t * (1 + 1e-6))
    PetscCall(PetscPrintf(
        OptionsComm(), "(The friction norm follows D(t) and may see decay for longer than a mode "
                       "frozen in time does.)\n"));
  PetscFunctionReturn(0);
}

static PetscErrorCode WriteScalar(HdfFile file, const char *name, PetscReal value,
                                  const char *units, const char *text) {
  PetscFunctionBegin;
  PetscCall(HdfWrite(file, name, 0, NULL, &value, units, text));
  PetscFunctionReturn(0);
}

PetscErrorCode StabilityWrite(HdfFile file, Stability *self) {
  const PetscInt k = self->set.points;
  char name[80];
  PetscReal *L;

  PetscFunctionBegin;
  if (!file) PetscFunctionReturn(0);
  PetscCall(HdfGroup(file, "/stability"));
  PetscCall(PetscMalloc1(k, &L));
  for (PetscInt i = 0; i < k; i++)
    PetscCall(GrowthLength(self->scene->growth, self->t[i], &L[i], NULL));
  PetscCall(HdfWrite(file, "/stability/t", 1, &k, self->t, "l/V", "times [k]"));
  PetscCall(HdfWrite(file, "/stability/length", 1, &k, L, "l", "lengths [k]"));
  PetscCall(HdfWrite(file, "/stability/frequency_A", 1, &k, self->frequency, "rad V/l",
                     "imaginary part that belongs to lambda_max_A [k]"));
  PetscCall(PetscFree(L));
  for (int c = 0; c < CURVES; c++) {
    if (!self->has[c]) continue;
    PetscCall(PetscSNPrintf(name, sizeof(name), "/stability/%s", stability_curve[c].name));
    PetscCall(HdfWrite(file, name, 1, &k, self->value[c], "V/l", stability_curve[c].text));
    PetscCall(PetscSNPrintf(name, sizeof(name), "/stability/%s_until", stability_curve[c].name));
    PetscCall(
        WriteScalar(file, name, self->until[c], "l/V", "negative from the first time up to here"));
  }
  for (PetscInt k = 0; k < self->ways && self->ways > 1; k++) {
    PetscCall(PetscSNPrintf(name, sizeof(name), "/stability/lambda_max_A_x%d",
                            self->of[k].way == WAY_X2 ? 2 : 3));
    PetscCall(HdfWrite(file, name, 1, &self->set.points, self->modes[k], "V/l",
                       "lambda_max_A of deflections in this direction [k]"));
  }
  if (!self->critical.n) PetscFunctionReturn(0);
  PetscCall(WriteScalar(file, "/stability/t_cr", self->critical.t, "l/V", "critical time"));
  PetscCall(WriteScalar(file, "/stability/t_cr_error", self->critical.error, "l/V",
                        "bound on its error"));
  PetscFunctionReturn(0);
}

static PetscErrorCode WriteOptimal(HdfFile file, const Optimal *best, const char *norm) {
  const PetscInt n = best->n;
  const struct {
    const char *name, *units, *text;
    const PetscReal *data;
  } sets[] = {{"s", "1", "material label [n]", best->s},
              {"initial_y", "l", "deflection that grows most, norm 1 at t1 [n]", best->y1},
              {"initial_theta", "rad", "its angle [n]", best->theta1},
              {"final_y", "l", "what it has become at t2 [n]", best->y2},
              {"final_theta", "rad", "its angle [n]", best->theta2}};
  char name[80];

  PetscFunctionBegin;
  if (!file) PetscFunctionReturn(0);
  PetscCall(PetscSNPrintf(name, sizeof(name), "/transient/%s", norm));
  PetscCall(HdfGroup(file, name));
  PetscCall(PetscSNPrintf(name, sizeof(name), "/transient/%s/amplification", norm));
  PetscCall(WriteScalar(file, name, best->amplification, "1", "largest |y(t2)| / |y(t1)|"));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(sets); i++) {
    PetscCall(PetscSNPrintf(name, sizeof(name), "/transient/%s/%s", norm, sets[i].name));
    PetscCall(HdfWrite(file, name, 1, &n, sets[i].data, sets[i].units, sets[i].text));
  }
  PetscFunctionReturn(0);
}

/* The optimal shape as -shape_type file reads it, scaled to -shape_amplitude. */
static PetscErrorCode WriteShapeFile(HdfFile file, const Optimal *best, PetscReal amplitude) {
  const PetscInt n = best->n;
  PetscReal *theta, most = 0;

  PetscFunctionBegin;
  if (!file) PetscFunctionReturn(0);
  PetscCall(PetscMalloc1(best->n, &theta));
  for (PetscInt i = 0; i < best->n; i++) most = PetscMax(most, PetscAbsReal(best->theta1[i]));
  for (PetscInt i = 0; i < best->n; i++) theta[i] = i ? best->theta1[i] * amplitude / most : 0;
  PetscCall(HdfWrite(file, "/s", 1, &n, best->s, "1", "material label [n]"));
  PetscCall(HdfWrite(file, "/theta", 1, &n, theta, "rad", "angle against the clamp [n]"));
  PetscCall(PetscFree(theta));
  PetscFunctionReturn(0);
}

/* The larger of two amplifications is kept. */
static PetscErrorCode TakeLarger(Propagator *propagator, TransientNorm norm, Optimal *best) {
  Optimal other;

  PetscFunctionBegin;
  PetscCall(TransientOptimal(propagator, norm, &other));
  if (other.amplification > best->amplification) {
    Optimal less = *best;
    *best = other;
    other = less;
  }
  PetscCall(OptimalDestroy(&other));
  PetscFunctionReturn(0);
}

/* The transient growth over a window in both norms, in the direction in which it is larger; every
   rank computes it for itself. */
PetscErrorCode StabilityTransient(Stability *self, HdfFile file, HdfFile shape) {
  const char *const names[] = {"L2", "friction"};
  const Settings *set = &self->set;
  Propagator propagator[MOST_WAYS];
  Scene scene = self->scene;
  Mesh mesh;

  PetscFunctionBegin;
  PetscCall(MeshCreate(set->transient_cells, PETSC_FALSE, scene->growth, set->t2, &mesh));
  for (PetscInt w = 0; w < self->ways; w++)
    PetscCall(
        PropagatorCreate(scene, &mesh, self->of[w].way, set->t1, set->t2, 1e-9, &propagator[w]));
  if (file) {
    PetscCall(HdfGroup(file, "/transient"));
    PetscCall(WriteScalar(file, "/transient/t1", set->t1, "l/V", "start of the window"));
    PetscCall(WriteScalar(file, "/transient/t2", set->t2, "l/V", "end of the window"));
  }
  for (int k = 0; k < 2; k++) {
    Optimal best;
    PetscCall(TransientOptimal(&propagator[0], (TransientNorm)k, &best));
    if (self->ways > 1) PetscCall(TakeLarger(&propagator[1], (TransientNorm)k, &best));
    PetscCall(PetscPrintf(OptionsComm(),
                          "largest amplification from t = %g to %g, %s norm: %.10g\n",
                          (double)set->t1, (double)set->t2, names[k], (double)best.amplification));
    PetscCall(WriteOptimal(file, &best, names[k]));
    if (k == TRANSIENT_L2) PetscCall(WriteShapeFile(shape, &best, scene->shape.amplitude));
    PetscCall(OptimalDestroy(&best));
  }
  for (PetscInt w = 0; w < self->ways; w++) PetscCall(PropagatorDestroy(&propagator[w]));
  PetscCall(MeshDestroy(&mesh));
  PetscFunctionReturn(0);
}
