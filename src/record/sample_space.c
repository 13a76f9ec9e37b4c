#include "record/sample_space.h"
#include "curve/cell.h"
#include "rod/directors.h"
#include "rod/spin.h"

/* SampleLaws - what the laws give at nodes from first to end, and between them. */
PetscErrorCode SampleLaws(Scene scene, PetscReal t, PetscInt first, PetscInt end, SampleLaw law[]) {
  PetscInt nodes;
  const PetscReal *mesh = SceneLabels(scene, &nodes);

  PetscFunctionBegin;
  for (PetscInt k = 2 * first; k <= 2 * end; k++, law++) {
    const PetscReal s = k % 2 ? (mesh[k / 2] + mesh[k / 2 + 1]) / 2 : mesh[k / 2];
    PetscCall(SceneMaterial(scene, s, t, law));
  }
  PetscFunctionReturn(0);
}

/* What follows at a point from its node and the laws, but for friction. */
static PetscErrorCode Fill(Scene scene, PetscReal s, PetscReal t, const SampleLaw *law,
                           Sample3 *p) {
  const Node *node = &p->node;
  PetscReal size = QuaternionSize(node->p);

  PetscFunctionBegin;
  PetscCall(ScenePlace(scene, s, t, &p->at));
  p->law = *law;
  Directors(node->p, size, p->at.axes);
  for (int k = 0; k < 3; k++) {
    p->moment[k] = Dot3(p->at.axes[k], node->m3);
    p->u[k] = p->moment[k] / p->law.S[k] + p->law.u0[k];
  }
  p->turns = QuaternionSpin(node->p, size, node->p_t);
  for (int k = 0; k < 3; k++) {
    p->at.x[k] = node->x[k];
    p->at.v[k] = node->x_t[k] + p->law.c * p->at.axes[0][k];
  }
  PetscFunctionReturn(0);
}

/* What the material at a point has learned, beside the natural strains that are
   given, and how fast that changes; before what follows from strains. */
static void Learned3(Scene scene, const NodeLearned *learned, Sample3 *p) {
  const Tropism *law = &scene->tropism;
  const PetscReal clock = law->by_rate ? law->rate : p->law.strain / p->law.g;

  p->drive[0] = p->ironing[0] = 0;
  for (int b = 0; b < TROPISM_BENDS; b++) {
    const int k = 2 - b;
    const PetscReal elastic = p->moment[k] / p->law.S[k];
    p->law.u0[k] += learned->bend[b];
    p->u[k] = elastic + p->law.u0[k];
    p->drive[k] = clock * TropismDriveAt(law, &p->at, b, learned->signal[b], p->law.u0[k], elastic);
    p->ironing[k] = clock * law->ironing * elastic;
  }
}

/* The friction at a point whose directors turn at p->turns. */
static void Rub(Scene scene, Sample3 *p) {
  p->spin = p->turns + p->law.c * p->u[0];
  p->at.v[SPIN] = scene->load.arm * p->spin;
  LoadSeen(3, &scene->load, &p->at, p->F);
}

/* SampleFill3 - what follows at a point from its node and the laws. */
PetscErrorCode SampleFill3(Scene scene, PetscReal s, PetscReal t, const SampleLaw *law,
                           Sample3 *p) {
  PetscFunctionBegin;
  PetscCall(Fill(scene, s, t, law, p));
  if (scene->tropism.any) Learned3(scene, p->node.learned, p);
  Rub(scene, p);
  PetscFunctionReturn(0);
}

/* Adds what an end of a cell gives to its middle, y_mid = (y_a + y_b)/2 + k (y'_a - y'_b); turns:
   the like of its spin. */
static void AddEnd(Scene scene, const Sample3 *p, const TwistRate *rate, PetscReal k, Node *mid,
                   PetscReal *turns) {
  const Node *n = &p->node;
  const PetscReal *q = p->at.axes[0];
  const PetscReal none[PUSH] = {0}, *push = p->push ? p->push : none;
  PetscReal turn[4], size = QuaternionSize(n->p), D[3][4], d1_t[3];

  QuaternionTurn(n->p, p->u, turn);
  DirectorSlope(n->p, size, q, 0, D);
  for (int i = 0; i < 4; i++) {
    mid->p[i] += CurveMidOf(k * p->law.g / 2, n->p[i], turn[i]);
    mid->p_t[i] += n->p_t[i] / 2;
  }
  for (int i = 0; i < 3; i++) {
    int j = (i + 1) % 3, l = (i + 2) % 3;
    d1_t[i] = Dot4(D[i], n->p_t);
    mid->x[i] += CurveMidOf(k * p->law.g, n->x[i], q[i]);
    mid->x_t[i] += CurveMidOf(k, n->x_t[i], p->law.g_t * q[i] + p->law.g * d1_t[i]);
    mid->m3[i] +=
        CurveMidOf(-k * p->law.g, n->m3[i],
                   q[j] * n->force[l] - q[l] * n->force[j] - (p->F[SPIN] - push[SPIN]) * q[i]);
    mid->force[i] +=
        CurveMidOf(k * p->law.g, n->force[i], p->F[i] - push[i] - scene->load.weight[i]);
  }
  *turns += CurveMidOf(k, p->turns,
                       SpinSlope(p->law.g, p->law.g_t, rate, 1 / p->law.S[0], p->at.axes, p->u,
                                 n->m3, n->m3_t, d1_t));
}

/* SampleMid3 - the point in the middle of the cell between two, with no push yet. feet: what they
   add to n' and m' at a, between and at b; NULL: none. */
PetscErrorCode SampleMid3(Scene scene, PetscReal sa, PetscReal sb, PetscReal t,
                          const SampleLaw *law, const Sample3 *a, const Sample3 *b,
                          const PetscReal (*feet)[FOOT_LOAD], Sample3 *mid) {
  const PetscBool feels = (PetscBool)(scene->load.radius > 0);
  PetscReal h = sb - sa, turns = 0;
  TwistRate rate[2] = {{0, 0}, {0, 0}};

  PetscFunctionBegin;
  PetscCall(PetscMemzero(mid, sizeof(*mid)));
  if (feels) {
    PetscCall(SceneTwistRate(scene, sa, t, &rate[0]));
    PetscCall(SceneTwistRate(scene, sb, t, &rate[1]));
  }
  AddEnd(scene, a, &rate[0], h / 8, &mid->node, &turns);
  AddEnd(scene, b, &rate[1], -h / 8, &mid->node, &turns);
  for (int i = 0; i < 3 && feet; i++) {
    mid->node.force[i] += h / 8 * (feet[AT_A][i] - feet[AT_B][i]);
    mid->node.m3[i] += h / 8 * (feet[AT_A][3 + i] - feet[AT_B][3 + i]);
  }
  PetscCall(Fill(scene, (sa + sb) / 2, t, law, mid));
  if (scene->tropism.any) Learned3(scene, a->node.learned + 1, mid);
  if (feels) mid->turns = turns;
  Rub(scene, mid);
  PetscFunctionReturn(0);
}
