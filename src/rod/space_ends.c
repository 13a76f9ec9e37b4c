/* The ends of a rod in space: what clamp, hinge or nothing asks of its first node, and the tip of
   its last (space.c has the equations). */
#include "base/vectors.h"
#include "rod/space_cells.h"
#include <string.h>

/* SpaceTipOf - what the tip's conditions are about. */
TipState SpaceTipOf(const Load *load, const Point *end) {
  TipState tip = {.at = end->at};

  if (load->arm > 0) {
    tip.per_W = 1 / load->arm;
    tip.spin = end->at.v[SPIN] / load->arm;
  }
  memcpy(tip.p, end->p, sizeof(tip.p));
  memcpy(tip.m, end->m, sizeof(tip.m));
  memcpy(tip.n, end->n, sizeof(tip.n));
  DirectorSlope(end->p, end->size, end->at.axes[0], 0, tip.q_p);
  return tip;
}

/* SpaceTipDual - the dual of the friction on the tip. Borrowed. */
FrictionDual *SpaceTipDual(Rod rod) {
  return Duals((const Space_ *)rod->data, 2 * (rod->last - rod->first + 1) + 1);
}

/* The four of a hinge beside x = 0, and their derivatives; each changes sign with the field of its
   row in the mirrors. How a section has turned about d1 is counted against the smallest rotation
   that takes the clamp's axis there, as links are: 2 atan2(p1, p0), that of the clamp. The twisting
   moment goes along with d1, as that at the tip does. */
static void HingeResidual(const PetscReal u[FIELDS], const PetscReal clamp[4], PetscReal r[4]) {
  const PetscReal *p = u + P, *m = u + M, size = QuaternionSize(p);
  PetscReal d[3][3];

  Directors(p, size, d);
  r[0] = (size - 1) / 2;
  r[1] = clamp[0] * p[1] - clamp[1] * p[0];
  for (int k = 1; k < 3; k++) r[1 + k] = Dot3(m, d[k]);
}

static void HingeBlock(const PetscReal u[FIELDS], const PetscReal clamp[4],
                       PetscReal by[4][FIELDS]) {
  const PetscReal *p = u + P, *m = u + M, size = QuaternionSize(p);
  PetscReal d[3][3], slope[3][4];

  Directors(p, size, d);
  for (int j = 0; j < 4; j++) by[0][P + j] = p[j];
  by[1][P] = -clamp[1];
  by[1][P + 1] = clamp[0];
  for (int k = 1; k < 3; k++) {
    DirectorSlope(p, size, d[k], k, slope);
    for (int i = 0; i < 3; i++) {
      by[1 + k][M + i] = d[k][i];
      for (int j = 0; j < 4; j++) by[1 + k][P + j] += m[i] * slope[i][j];
    }
  }
}

/* SpaceClampResidual - the seven conditions at the beginning, r = 0; of one that another rod holds
   they are not known here: 0. */
void SpaceClampResidual(Scene scene, PetscReal t, const PetscReal u[FIELDS], PetscReal r[FIELDS]) {
  PetscReal p[4];

  if (SceneCarried(scene)) {
    memset(r, 0, LEFT * sizeof(*r));
    return;
  }
  if (scene->clamp == CLAMP_FREE) {
    for (int d = 0; d < 6; d++) r[d] = u[M + (d + 3) % 6];
    r[LEFT - 1] = (QuaternionSize(u + P) - 1) / 2;
    return;
  }
  SpaceClampTurn(&scene->space, t, p);
  for (int f = 0; f < LEFT; f++) r[f] = u[f] - (f < P ? 0 : p[f - P]);
  if (scene->clamp == CLAMP_HINGED) HingeResidual(u, p, r + P);
}

/* SpaceClampBlock - ... and their derivatives. */
void SpaceClampBlock(Scene scene, PetscReal t, const PetscReal u[FIELDS],
                     PetscReal by[LEFT][FIELDS]) {
  PetscReal p[4];

  memset(by, 0, LEFT * sizeof(*by));
  if (SceneCarried(scene)) return;
  if (scene->clamp == CLAMP_FREE) {
    for (int d = 0; d < 6; d++) by[d][M + (d + 3) % 6] = 1;
    for (int k = 0; k < 4; k++) by[LEFT - 1][P + k] = u[P + k];
    return;
  }
  for (int f = 0; f < (scene->clamp == CLAMP_HINGED ? P : LEFT); f++) by[f][f] = 1;
  if (scene->clamp != CLAMP_HINGED) return;
  SpaceClampTurn(&scene->space, t, p);
  HingeBlock(u, p, by + P);
}
