#include "record/shapes.h"
#include "rod/directors.h"
#include <stddef.h>

#define AT(field) offsetof(LabNode, field)

const ShapeSet shape_sets[SHAPE_SETS] = {
    {"/shapes/t", "l/V", "times of the stored shapes", 0, 0},
    {"/shapes/x", "l", "position x1, x2 [k, n, 2]", 2, AT(x)},
    {"/shapes/theta", "rad", "tangent angle [k, n]", 1, AT(theta)},
    {"/shapes/curvature", "1/l", "curvature theta'/g: of the moment, m/B, and natural, k0 [k, n]",
     1, AT(strain[2])},
    {"/shapes/force", "N l", "internal force n1, n2 [k, n, 2]", 2, AT(force)},
    {"/shapes/natural_curvature", "1/l", "natural curvature k0 [k, n]", 1, AT(natural[2])},
    {"/shapes/stretch", "l", "stretch g = |x'| [k, n]", 1, AT(stretch)},
    {"/shapes/contact", "N", "force of contact per length, on the rod; without friction [k, n, 2]",
     2, AT(contact)}};

static const ShapeSet space_sets[MOST_SHAPE_SETS] = {
    {"/shapes/t", "l/V", "times of the stored shapes", 0, 0},
    {"/shapes/x", "l", "position x1, x2, x3 [k, n, 3]", 3, AT(x)},
    {"/shapes/theta", "rad", "angle of the tangent against the clamp's axis, 0 to pi [k, n]", 1,
     AT(theta)},
    {"/shapes/strain", "1/l", "twist u1 and bends u2, u3 about the directors [k, n, 3]", 3,
     AT(strain)},
    {"/shapes/force", "N l", "internal force n1, n2, n3 [k, n, 3]", 3, AT(force)},
    {"/shapes/natural_strain", "1/l", "natural twist and bends about the directors [k, n, 3]", 3,
     AT(natural)},
    {"/shapes/stretch", "l", "stretch g = |x'| [k, n]", 1, AT(stretch)},
    {"/shapes/moment", "N l^2", "internal moment m1, m2, m3 [k, n, 3]", 3, AT(moment)},
    {"/shapes/d1", "1", "director d1, the tangent [k, n, 3]", 3, AT(d[0])},
    {"/shapes/d2", "1", "director d2 of the cross-section [k, n, 3]", 3, AT(d[1])},
    {"/shapes/d3", "1", "director d3 of the cross-section [k, n, 3]", 3, AT(d[2])},
    {"/shapes/curvature", "1/l", "curvature of the centre line, |u2, u3| [k, n]", 1, AT(bend)},
    {"/shapes/contact", "N", "force of contact per length, on the rod; without friction [k, n, 3]",
     3, AT(contact)}};

/*
  ShapeSets - which fields of its labels are stored of the rod of a scene.

  n  how many; MOST_SHAPE_SETS at most
*/
const ShapeSet *ShapeSets(Scene scene, int *n) {
  const PetscBool space = scene->space.rod;

  *n = (space ? MOST_SHAPE_SETS : SHAPE_SETS) - !scene->contact.any;
  return space ? space_sets : shape_sets;
}

static void InPlane(Scene scene, const Node *node, const Material *at, LabNode *lab) {
  const PetscReal *x_t = node->x_t, q[3] = {PetscCosReal(node->theta), PetscSinReal(node->theta)},
                  across[3] = {-q[1], q[0]}, v[3] = {x_t[0] + at->c * q[0], x_t[1] + at->c * q[1]};

  lab->theta = node->theta + scene->clamp_angle;
  lab->strain[2] = at->u0[2] + node->moment / at->S[2];
  lab->moment[2] = node->moment;
  SceneToLab(scene, node->x, lab->x);
  SceneToLab(scene, v, lab->v);
  SceneToLab(scene, q, lab->d[0]);
  SceneToLab(scene, across, lab->d[1]);
  lab->d[2][2] = 1;
  SceneToLab(scene, node->force, lab->force);
}

static void InSpace(Scene scene, const Node *node, const Material *at, LabNode *lab) {
  PetscReal d[3][3], v[3];

  Directors(node->p, QuaternionSize(node->p), d);
  for (int k = 0; k < 3; k++) {
    lab->strain[k] = at->u0[k] + Dot3(d[k], node->m3) / at->S[k];
    v[k] = node->x_t[k] + at->c * d[0][k];
    SceneToLab(scene, d[k], lab->d[k]);
  }
  lab->bend = PetscSqrtReal(lab->strain[1] * lab->strain[1] + lab->strain[2] * lab->strain[2]);
  lab->theta = node->theta;
  ScenePlaceToLab(scene, node->x, lab->x);
  SceneToLab(scene, v, lab->v);
  SceneToLab(scene, node->force, lab->force);
  SceneToLab(scene, node->m3, lab->moment);
}

/* LabNodeAt - the node at a label in the laboratory, but for contact. */
PetscErrorCode LabNodeAt(Scene scene, PetscReal t, PetscReal s, const Node *node, LabNode *lab) {
  Material at;

  PetscFunctionBegin;
  PetscCall(SceneMaterial(scene, s, t, &at));
  PetscCall(PetscMemzero(lab, sizeof(*lab)));
  for (int b = 0; b < TROPISM_BENDS && scene->tropism.any; b++)
    at.u0[2 - b] += node->learned[0].bend[b];
  PetscCall(PetscArraycpy(lab->natural, at.u0, 3));
  lab->stretch = at.g;
  (scene->space.rod ? InSpace : InPlane)(scene, node, &at, lab);
  PetscFunctionReturn(0);
}
