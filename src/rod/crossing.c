#include "rod/crossing.h"
#include "base/boxes.h"

/* Does segment ab cross segment cd? Touching in an end point does not count twice: half-open. */
static PetscBool SegmentsCross(const PetscReal a[2], const PetscReal b[2], const PetscReal c[2],
                               const PetscReal d[2]) {
  PetscReal r[2] = {b[0] - a[0], b[1] - a[1]}, q[2] = {d[0] - c[0], d[1] - c[1]},
            o[2] = {c[0] - a[0], c[1] - a[1]};
  PetscReal det = r[0] * q[1] - r[1] * q[0], u = o[0] * q[1] - o[1] * q[0],
            w = o[0] * r[1] - o[1] * r[0];
  if (det == 0) return PETSC_FALSE;
  u /= det;
  w /= det;
  return (PetscBool)(u >= 0 && u < 1 && w >= 0 && w < 1);
}

/* The polygon whose crossings are counted. */
typedef struct {
  const Node *nodes;
  PetscInt count;
} Crossings;

/* An arc whose angles span less than pi cannot meet itself, nor its neighbour in the same arc. */
static PetscBool CannotCross(const Box *a, PetscInt first_a, PetscInt last_a, const Box *b,
                             PetscInt first_b, PetscInt last_b, void *ctx) {
  PetscReal span = PetscMax(a->high[2], b->high[2]) - PetscMin(a->low[2], b->low[2]);
  return (PetscBool)(span < PETSC_PI && (last_a == first_b || first_a == first_b));
}

static void CountCrossing(PetscInt i, PetscInt j, void *ctx) {
  Crossings *self = (Crossings *)ctx;
  const Node *a = self->nodes + i, *c = self->nodes + j;
  if (j > i + 1)
    self->count += SegmentsCross(a[0].x, a[1].x, c[0].x, c[1].x); /* else: a node in common */
}

/* RodCrossings - in how many points the polygon through n nodes crosses itself. Not collective.
 */
PetscErrorCode RodCrossings(PetscInt n, const Node *nodes, PetscInt *count) {
  Crossings self = {nodes, 0};
  Boxes boxes;

  PetscFunctionBegin;
  *count = 0;
  if (n < 4) PetscFunctionReturn(0);
  PetscCall(BoxesCreate(n - 1, NODE_VALUES, nodes[0].x, &nodes[0].theta, &boxes));
  BoxesPairs(boxes, 0, CannotCross, CountCrossing, &self);
  PetscCall(BoxesDestroy(&boxes));
  *count = self.count;
  PetscFunctionReturn(0);
}
