#include "world/load_space.h"

/* N at a place, and its derivatives there. */
static PetscReal Factor3(const Load *load, const Place3 *at, PetscReal slope[3]) {
  PetscReal lab[3], by[3], factor;

  for (int d = 0; d < 3; d++)
    lab[d] = load->lab[d][0] * at->x[0] + load->lab[d][1] * at->x[1] + load->lab[d][2] * at->x[2];
  FieldAt(load->field, lab, load->stopped ? load->stopped_at : at->t, &factor, by);
  for (int d = 0; d < 3; d++)
    slope[d] = load->lab[0][d] * by[0] + load->lab[1][d] * by[1] + load->lab[2][d] * by[2];
  return factor;
}

static inline PetscReal Along(const PetscReal q[3], const PetscReal f[3]) {
  return q[0] * f[0] + q[1] * f[1] + q[2] * f[2];
}

/* f <- N M f, and the couple */
static void Vary(const Load *load, const Place3 *at, PetscReal f[RUBS]) {
  PetscReal by[3], N = load->field ? Factor3(load, at, by) : 1, a = load->across,
                   more = (1 - a) * Along(at->q, f);

  for (int d = 0; d < 3; d++) f[d] = N * (a * f[d] + more * at->q[d]);
  f[SPIN] *= N;
}

/* LoadForce3 - the force F that the rod overcomes, per length, and the couple about its tangent. */
void LoadForce3(const Load *load, const Place3 *at, const FrictionDual4 *dual, PetscReal f[RUBS]) {
  FrictionForce4(&load->friction, at->W, dual, f);
  if (load->varied) Vary(load, at, f);
  for (int d = 0; d < 3 && load->weighs; d++) f[d] -= load->weight[d];
  f[SPIN] *= load->radius;
}

/* LoadSeen3 - the same where nothing is held, as an observer sees it, and without weight. */
void LoadSeen3(const Load *load, const Place3 *at, PetscReal f[RUBS]) {
  PetscReal drag = FrictionPhi(&load->friction, Along(at->W, at->W) + PetscSqr(at->W[SPIN]));

  for (int d = 0; d < RUBS; d++) f[d] = drag * at->W[d];
  if (load->varied) Vary(load, at, f);
  f[SPIN] *= load->radius;
}

/* dN M f: by W, by q and by x. */
static void SlopeVaried(const Load *load, const Place3 *at, const FrictionDual4 *dual,
                        LoadSlope3 *slope) {
  PetscReal by[3] = {0}, N = load->field ? Factor3(load, at, by) : 1, a = load->across, f[RUBS],
            along;

  for (int c = 0; c < RUBS; c++) {
    along = (1 - a) *
            (at->q[0] * slope->W[0][c] + at->q[1] * slope->W[1][c] + at->q[2] * slope->W[2][c]);
    for (int d = 0; d < 3; d++) slope->W[d][c] = N * (a * slope->W[d][c] + along * at->q[d]);
    slope->W[SPIN][c] *= N;
  }
  FrictionForce4(&load->friction, at->W, dual, f);
  along = Along(at->q, f);
  for (int d = 0; d < 3; d++)
    for (int c = 0; c < 3; c++) {
      slope->q[d][c] = N * (1 - a) * ((d == c) * along + at->q[d] * f[c]);
      slope->x[d][c] = (a * f[d] + (1 - a) * along * at->q[d]) * by[c];
    }
  for (int c = 0; c < 3; c++) slope->x[SPIN][c] = load->radius * f[SPIN] * by[c];
}

/* LoadLinearise3 - the slope of force and couple for Newton's method, the dual brought up to the
   present velocity first; fresh: a Newton solve begins. Those by q and x are set only where the
   load varies. */
void LoadLinearise3(const Load *load, const Place3 *at, PetscBool fresh, FrictionDual4 *dual,
                    LoadSlope3 *slope) {
  FrictionLinearise4(&load->friction, at->W, fresh, dual, slope->W);
  if (load->varied) SlopeVaried(load, at, dual, slope);
  for (int c = 0; c < RUBS; c++) slope->W[SPIN][c] *= load->radius;
}

/* LoadInSpace - does it act out of the plane of x1 and x2, whatever the rod does? */
PetscBool LoadInSpace(const Load *load) {
  return FieldInSpace(load->field);
}
