#include "record/event.h"
#include "rod/directors.h"
#include "base/blocks.h"
#include <string.h>

static const OptionRow rows[] = {
    ROW_REAL(
        "-stop_self_contact", "", 0, 1e3, UNIT_LENGTH, EVENT,
        "ends the run where a rod of this diameter touches itself; 0: crosses; off unless given"),
    ROW_REAL("-stop_length", "", 0, 1e9, UNIT_LENGTH, EVENT,
             "ends the run at this length; off unless given"),
    ROW_BOOL("-stop_contact", "false", EVENT,
             "ends the run where the rod first touches a wall, or itself (-contact_self)"),
    ROW_REAL(
        "-stop_angle", "", 0, 1e4, UNIT_ANGLE, EVENT,
        "ends the run when an angle against the clamp reaches this, radians; off unless given"),
    ROW_REAL("-stop_force", "", 0, 1e9, UNIT_FORCE, EVENT,
             "ends the run when the rod is pushed by this force along itself, anywhere: -n.q; off "
             "unless given"),
    ROW_REAL(
        "-stop_stall", "", 0, 1, UNIT_NONE, EVENT,
        "ends the run when growth that feels force (-growth_yield) is slowed down to this part "
        "of its speed without; off unless given")};
const OptionGroup event_options = OPTION_GROUP_OF_ROD("Events", rows);

const char *const event_name[EVENT_KINDS] = {"none",    "self_contact", "length", "angle",
                                             "contact", "force",        "stall"};

/* WatchSetFromOptions - reads and checks which events end the run. */
PetscErrorCode WatchSetFromOptions(Watch *watch, Scene scene) {
  PetscReal length;
  char text[64];

  PetscFunctionBegin;
  PetscCall(PetscMemzero(watch, sizeof(*watch)));
  PetscCall(SceneLength(scene, 0, &length));
  PetscCall(OptionReal("-stop_self_contact", &watch->bound[EVENT_SELF_CONTACT],
                       &watch->watched[EVENT_SELF_CONTACT]));
  UserCheck(
      !scene->space.rod || !watch->watched[EVENT_SELF_CONTACT], OptionsComm(),
      "-stop_self_contact: is looked for in the plane only, and this rod is in space; take it "
      "out");
  watch->bound[EVENT_LENGTH] = PETSC_MAX_REAL;
  PetscCall(OptionReal("-stop_length", &watch->bound[EVENT_LENGTH], &watch->watched[EVENT_LENGTH]));
  UserCheck(watch->bound[EVENT_LENGTH] > length, OptionsComm(),
            "-stop_length: the rod is %s long at the start, give more",
            OptionBoth(length, UNIT_LENGTH, text));
  PetscCall(OptionReal("-stop_angle", &watch->bound[EVENT_ANGLE], &watch->watched[EVENT_ANGLE]));
  PetscCall(OptionReal("-stop_force", &watch->bound[EVENT_FORCE], &watch->watched[EVENT_FORCE]));
  PetscCall(OptionReal("-stop_stall", &watch->bound[EVENT_STALL], &watch->watched[EVENT_STALL]));
  UserCheck(!watch->watched[EVENT_STALL] || scene->growth->yield > 0, OptionsComm(),
            "-stop_stall: this growth feels no force, and never stalls; give -growth_yield");
  PetscCall(OptionBool("-stop_contact", &watch->watched[EVENT_CONTACT], NULL));
  UserCheck(!watch->watched[EVENT_CONTACT] || scene->contact.any, OptionsComm(),
            "-stop_contact: there is nothing to touch; %s", ContactRemedy());
  for (int k = 0; k < EVENT_KINDS; k++) watch->any = (PetscBool)(watch->any || watch->watched[k]);
  PetscFunctionReturn(0);
}

/* The search for the nearest pair of segments that touch. */
typedef struct {
  const Node *nodes;
  const PetscReal *s;
  PetscReal *p;              /* arc length */
  PetscReal diameter, apart; /* parts farther apart than this along the rod are not neighbours */
  PetscReal nearest;
  Event *event;
} Approach;

/* The point of segment ab nearest to c: its place z in [0,1], and its distance. */
static PetscReal PointDistance(Vector2 a, Vector2 b, Vector2 c, PetscReal *z) {
  const Vector2 e = Minus2(b, a), o = Minus2(c, a);
  const PetscReal ee = Dot2(e, e);

  *z = ee > 0 ? PetscMin(1, PetscMax(0, Dot2(e, o) / ee)) : 0;
  return Size2(Along2(o, -*z, e));
}

/* The distance between two segments from nodes to those behind them, 0 where they cross, and the
   places z on them. */
static PetscReal SegmentDistance(const Node *ab, const Node *cd, PetscReal z[]) {
  const Vector2 a = From2(ab[0].x), b = From2(ab[1].x), c = From2(cd[0].x), d = From2(cd[1].x),
                r = Minus2(b, a), q = Minus2(d, c), o = Minus2(c, a);
  const PetscReal det = Cross2(r, q);
  PetscReal best, at, now;

  if (det != 0) {
    z[0] = Cross2(o, q) / det;
    z[1] = Cross2(o, r) / det;
    if (z[0] >= 0 && z[0] <= 1 && z[1] >= 0 && z[1] <= 1) return 0;
  }
  best = PointDistance(c, d, a, &z[1]);
  z[0] = 0;
  if ((now = PointDistance(c, d, b, &at)) < best) best = now, z[0] = 1, z[1] = at;
  if ((now = PointDistance(a, b, c, &at)) < best) best = now, z[0] = at, z[1] = 0;
  if ((now = PointDistance(a, b, d, &at)) < best) best = now, z[0] = at, z[1] = 1;
  return best;
}

/* Is one box too near the other along the rod to touch it? */
static PetscBool TooNear(const Block *a, PetscInt first_a, PetscInt last_a, const Block *b,
                         PetscInt first_b, PetscInt last_b, void *ctx) {
  const Approach *self = (const Approach *)ctx;
  return (PetscBool)(self->p[last_b] - self->p[first_a] < self->apart);
}

static void Meet(PetscInt i, PetscInt j, void *ctx) {
  Approach *self = (Approach *)ctx;
  const Node *a = self->nodes + i, *c = self->nodes + j;
  PetscReal z[2], distance;

  if (j <= i + 1 || self->p[j] - self->p[i + 1] < self->apart) return;
  distance = SegmentDistance(a, c, z);
  if (distance > self->diameter || distance >= self->nearest) return;
  self->nearest = distance;
  self->event->kind = EVENT_SELF_CONTACT;
  self->event->s[0] = self->s[i] + z[0] * (self->s[i + 1] - self->s[i]);
  self->event->s[1] = self->s[j] + z[1] * (self->s[j + 1] - self->s[j]);
  const Vector2 on_a = Along2(From2(a[0].x), z[0], Minus2(From2(a[1].x), From2(a[0].x)));
  Put2(Over2(Along2(Plus2(on_a, From2(c[0].x)), z[1], Minus2(From2(c[1].x), From2(c[0].x))), 2),
       self->event->x);
}

/*
  EventContact - does a rod of this diameter (0: its centre line) touch itself? Not collective.

  event  kind, s and x of the nearest pair, if any; else kind EVENT_NONE

  Two parts are neighbours if they are within pi/2 diameters along the rod: half a circle as tight
  as the rod can be, whose ends just touch.
*/
PetscErrorCode EventContact(PetscInt cells, const PetscReal s[], const Node *nodes,
                            PetscReal diameter, Event *event) {
  Approach self = {.nodes = nodes, .s = s, .diameter = diameter, .event = event};
  Blocks line;

  PetscFunctionBegin;
  event->kind = EVENT_NONE;
  self.apart = PETSC_PI / 2 * diameter;
  self.nearest = PETSC_MAX_REAL;
  PetscCall(PetscMalloc1(cells + 1, &self.p));
  self.p[0] = 0;
  for (PetscInt i = 0; i < cells; i++)
    self.p[i + 1] = self.p[i] + Size2(Minus2(From2(nodes[i + 1].x), From2(nodes[i].x)));
  PetscCall(BlocksOfLine(2, cells, NODE_VALUES, nodes[0].x, NULL, NULL, &line));
  BlocksPairs(line, diameter, TooNear, Meet, &self);
  PetscCall(BlocksDestroy(&line));
  PetscCall(PetscFree(self.p));
  PetscFunctionReturn(0);
}

/* Does the rod touch a wall or itself? */
static PetscErrorCode LookForContact(Observer observer, Scene scene, PetscReal t, const Node *nodes,
                                     Event *event) {
  TouchSum touch;

  PetscFunctionBegin;
  PetscCall(ObserverTouch(observer, t, nodes, &touch));
  if (touch.nearest >= scene->contact.smooth) PetscFunctionReturn(0);
  event->kind = EVENT_CONTACT;
  for (int k = 0; k < 2; k++) event->s[k] = touch.at[k];
  for (int d = 0; d < 3; d++) event->x[d] = touch.x[d];
  PetscFunctionReturn(0);
}

/* The force by which the rod is pushed along itself at a node, -n.q. */
static PetscReal PushAt(PetscBool space, const Node *node) {
  const PetscReal *n = node->force, theta = node->theta;
  PetscReal d[3][3];

  if (!space) return -n[0] * PetscCosReal(theta) - n[1] * PetscSinReal(theta);
  Directors(node->p, QuaternionSize(node->p), d);
  return -Dot3(n, d[0]);
}

/*
  PushLargest - the largest force by which the rod is pushed along itself, -n.q, and the node where
  it is. Not collective.

  space  the rod is in space      nodes  cells + 1 of them, all of the rod
*/
PetscReal PushLargest(PetscBool space, PetscInt cells, const Node *nodes, PetscInt *where) {
  PetscReal push = PETSC_MIN_REAL;

  for (PetscInt i = 0; i <= cells; i++) {
    const PetscReal here = PushAt(space, &nodes[i]);
    if (here <= push) continue;
    push = here;
    *where = i;
  }
  return push;
}

/* Is the rod pushed as hard as that? */
static void LookForPush(Scene scene, const Node *nodes, PetscReal bound, Event *event) {
  PetscInt nodes_n, where = 0;
  const PetscReal *s = SceneLabels(scene, &nodes_n);

  if (PushLargest(scene->space.rod, nodes_n - 1, nodes, &where) < bound) return;
  event->kind = EVENT_FORCE;
  event->s[0] = event->s[1] = s[where];
  memcpy(event->x, nodes[where].x, sizeof(event->x));
}

/*
  WatchLook - has an event happened at time t? Not collective.

  nodes  cells + 1 nodes, all of the rod
  event  the event; kind EVENT_NONE if none has
*/
PetscErrorCode WatchLook(const Watch *watch, Observer observer, Scene scene, PetscReal t,
                         const Node *nodes, Event *event) {
  PetscInt n;
  const PetscReal *s = SceneLabels(scene, &n);
  const PetscInt last = n - 1;
  PetscReal length, rate;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(event, sizeof(*event)));
  if (watch->watched[EVENT_SELF_CONTACT])
    PetscCall(EventContact(last, s, nodes, watch->bound[EVENT_SELF_CONTACT], event));
  for (PetscInt i = 0; i <= last && watch->watched[EVENT_ANGLE] && !event->kind; i++)
    if (PetscAbsReal(nodes[i].theta) >= watch->bound[EVENT_ANGLE]) {
      event->kind = EVENT_ANGLE;
      event->s[0] = event->s[1] = s[i];
      memcpy(event->x, nodes[i].x, sizeof(event->x));
    }
  if (watch->watched[EVENT_FORCE] && !event->kind)
    LookForPush(scene, nodes, watch->bound[EVENT_FORCE], event);
  if (watch->watched[EVENT_CONTACT] && !event->kind)
    PetscCall(LookForContact(observer, scene, t, nodes, event));
  PetscCall(GrowthLength(scene->growth, t, &length, &rate));
  if (watch->watched[EVENT_LENGTH] && !event->kind && length >= watch->bound[EVENT_LENGTH])
    event->kind = EVENT_LENGTH;
  if (watch->watched[EVENT_STALL] && !event->kind && rate <= watch->bound[EVENT_STALL])
    event->kind = EVENT_STALL;
  if (event->kind == EVENT_LENGTH || event->kind == EVENT_STALL) {
    event->s[0] = event->s[1] = 1;
    memcpy(event->x, nodes[last].x, sizeof(event->x));
  }
  event->t = t;
  PetscFunctionReturn(0);
}
