/*
  A growth law seen from labels that go with material where other rods are joined to it, and by a
  clock that starts when the rod is born.

  Material of a rod that is fed, or that grows at its tip, slides past its labels S. Labels s that
  are those of the start, S(s, 0) = s, and stay with the material at the places s_j,

    S(s_j, t) = S_j(t),   dS_j/dt = c/g,   S(0, t) = 0,   S(1, t) = 1,

  and between them go by a monotone cubic through these, make of the law

    g S_s,   c - g S_t,   p(S),   V(S),   strain S_s,

  of which the model knows no more than of any law: at s_j nothing slides, and a double node there
  stays with the material. Slopes at s_j are harmonic means of those on both sides, so that the
  cubic is nowhere flatter than half its mean slope.

  Fed material keeps its distance d from the tip: S_j = 1 - d/L. Where growth is at the tip alone,
  material behind its zone, of length z, rests at p = y: S_j = y/L. Before it has left the zone no
  rod is joined to it, and where the node is then is of no account: it keeps ahead of those whose
  material left earlier,

    S_j = y/M(L),   M = L from L = y + z on, and constant below y + z/2.
*/
#include "material/growth.h"
#include <string.h>

/* S at a label, and its derivatives by the label and by time. */
typedef struct {
  PetscReal S, t, s, st, ss;
} Label;

/* A place, its label, and what S is there. */
typedef struct {
  PetscReal along, s, S, S_t, slope, slope_t;
} Knot;

typedef struct {
  struct _Growth law; /* that is seen so */
  PetscReal born;
  PetscInt knots; /* the ends and the places between; 0: labels are its own */
  Knot *knot;
  PetscReal time; /* of the law, at which they are known */
} View;

/* Time by the law's clock. */
static PetscReal Clock(const View *view, PetscReal t) {
  return PetscMax(0, t - view->born);
}

/* M(L), and its slope. */
static PetscReal Bound(PetscReal L, PetscReal rests, PetscReal zone, PetscReal *slope) {
  const PetscReal way = zone / 2, u = PetscMax(0, 1 + (L - rests) / way);

  *slope = u < 1 ? u * u * u * (10 - 15 * u + 6 * u * u) : 1;
  return u < 1 ? rests - way / 2 + way * u * u * u * u * (2.5 - 3 * u + u * u) : L;
}

/* S of a place that is followed, and its rate. */
static PetscErrorCode Follow(Growth law, PetscReal along, PetscReal t, PetscReal *S,
                             PetscReal *S_t) {
  PetscReal L, L_t, M, slope;

  PetscFunctionBegin;
  PetscCall(GrowthLength(law, t, &L, &L_t));
  if (law->rests) {
    M = Bound(L, along + law->finest, law->finest, &slope);
    *S = along / M;
    *S_t = -along / (M * M) * slope * L_t;
  } else {
    *S = 1 - along / L;
    *S_t = along / (L * L) * L_t;
  }
  PetscFunctionReturn(0);
}

/* The mean slope of S between a knot and the next, and its rate. */
static void MeanSlope(const Knot *knot, PetscReal *mean, PetscReal *mean_t) {
  *mean = (knot[1].S - knot[0].S) / (knot[1].s - knot[0].s);
  *mean_t = (knot[1].S_t - knot[0].S_t) / (knot[1].s - knot[0].s);
}

/* Slopes at the knots: 2 a b/(a + b) of the mean slopes a, b beside it, or that of the only one. */
static void Slopes(View *view) {
  PetscReal a, a_t, b = 0, b_t = 0;

  for (PetscInt k = 0; k < view->knots; k++) {
    Knot *knot = &view->knot[k];
    a = b;
    a_t = b_t;
    if (k + 1 < view->knots) MeanSlope(knot, &b, &b_t);
    if (k == 0 || k + 1 == view->knots) {
      knot->slope = b;
      knot->slope_t = b_t;
    } else {
      knot->slope = 2 * a * b / (a + b);
      knot->slope_t = 2 * (a * a * b_t + b * b * a_t) / PetscSqr(a + b);
    }
  }
}

/* Where the places are at a time of the law. */
static PetscErrorCode FollowAll(View *view, PetscReal t) {
  PetscFunctionBegin;
  if (view->time == t) PetscFunctionReturn(0);
  for (PetscInt k = 1; k + 1 < view->knots; k++)
    PetscCall(Follow(&view->law, view->knot[k].along, t, &view->knot[k].S, &view->knot[k].S_t));
  Slopes(view);
  view->time = t;
  PetscFunctionReturn(0);
}

/* c0 + c1 u + c2 u^2 + c3 u^3 from values and slopes by u at 0 and 1. */
static void Cubic(PetscReal y0, PetscReal y1, PetscReal d0, PetscReal d1, PetscReal c[4]) {
  c[0] = y0;
  c[1] = d0;
  c[2] = 3 * (y1 - y0) - 2 * d0 - d1;
  c[3] = d0 + d1 - 2 * (y1 - y0);
}

/* S at a label, at a time of the law. */
static PetscErrorCode At(View *view, PetscReal s, PetscReal t, Label *at) {
  PetscReal c[4], r[4], h, u;
  PetscInt k = 0;

  PetscFunctionBegin;
  *at = (Label){.S = s, .s = 1};
  if (!view->knots) PetscFunctionReturn(0);
  PetscCall(FollowAll(view, t));
  while (k + 2 < view->knots && s >= view->knot[k + 1].s) k++;
  const Knot *a = &view->knot[k], *b = a + 1;
  h = b->s - a->s;
  u = (s - a->s) / h;
  Cubic(a->S, b->S, h * a->slope, h * b->slope, c);
  Cubic(a->S_t, b->S_t, h * a->slope_t, h * b->slope_t, r);
  at->S = u < 1 ? c[0] + u * (c[1] + u * (c[2] + u * c[3])) : b->S;
  at->t = u < 1 ? r[0] + u * (r[1] + u * (r[2] + u * r[3])) : b->S_t;
  at->s = (c[1] + u * (2 * c[2] + 3 * u * c[3])) / h;
  at->st = (r[1] + u * (2 * r[2] + 3 * u * r[3])) / h;
  at->ss = (2 * c[2] + 6 * u * c[3]) / (h * h);
  PetscFunctionReturn(0);
}

/* The label at which S is that, at a time of the law. */
static PetscErrorCode LabelOf(View *view, PetscReal S, PetscReal t, PetscReal *s) {
  PetscReal low = 0, high = 1;
  Label at;

  PetscFunctionBegin;
  *s = S;
  if (!view->knots || S <= 0 || S >= 1) PetscFunctionReturn(0);
  for (int i = 0; i < 60; i++) {
    *s = (low + high) / 2;
    PetscCall(At(view, *s, t, &at));
    if (at.S > S)
      high = *s;
    else
      low = *s;
  }
  PetscFunctionReturn(0);
}

/* ---- the law as it is seen ---- */

static PetscErrorCode StretchSeen(Growth self, PetscReal s, PetscReal t, PetscReal *g,
                                  PetscReal *g_t, PetscReal *g_s) {
  View *view = (View *)self->data;
  const PetscReal clock = Clock(view, t);
  PetscReal own, own_t, own_s;
  Label at;

  PetscFunctionBegin;
  PetscCall(At(view, s, clock, &at));
  PetscCall(view->law.stretch(&view->law, at.S, clock, &own, &own_t, &own_s));
  *g = own * at.s;
  *g_t = (own_t + own_s * at.t) * at.s + own * at.st;
  *g_s = own_s * at.s * at.s + own * at.ss;
  PetscFunctionReturn(0);
}

static PetscErrorCode ArcSeen(Growth self, PetscReal s, PetscReal t, PetscReal *p, PetscReal *p_t) {
  View *view = (View *)self->data;
  const PetscReal clock = Clock(view, t);
  PetscReal g, g_t, g_s;
  Label at;

  PetscFunctionBegin;
  PetscCall(At(view, s, clock, &at));
  PetscCall(view->law.arc(&view->law, at.S, clock, p, p_t));
  if (at.t == 0) PetscFunctionReturn(0);
  PetscCall(view->law.stretch(&view->law, at.S, clock, &g, &g_t, &g_s));
  *p_t += g * at.t;
  PetscFunctionReturn(0);
}

static PetscReal SlideSeen(Growth self, PetscReal s, PetscReal t) {
  View *view = (View *)self->data;
  const PetscReal clock = Clock(view, t);
  PetscReal g = 0, g_t, g_s;
  Label at;

  if (At(view, s, clock, &at)) return NAN;
  if (at.t != 0 && view->law.stretch(&view->law, at.S, clock, &g, &g_t, &g_s)) return NAN;
  return view->law.slide(&view->law, at.S, clock) - g * at.t;
}

static PetscReal SpeedSeen(Growth self, PetscReal s, PetscReal t) {
  View *view = (View *)self->data;
  Label at;

  if (At(view, s, Clock(view, t), &at)) return NAN;
  return view->law.speed(&view->law, at.S, Clock(view, t));
}

static PetscReal StrainSeen(Growth self, PetscReal s, PetscReal t) {
  View *view = (View *)self->data;
  Label at;

  if (At(view, s, Clock(view, t), &at)) return NAN;
  return view->law.strain(&view->law, at.S, Clock(view, t)) * at.s;
}

static PetscErrorCode OriginSeen(Growth self, PetscReal s, PetscReal t, PetscReal *d,
                                 PetscReal *d_t) {
  View *view = (View *)self->data;
  Label at;

  PetscFunctionBegin;
  PetscCall(At(view, s, Clock(view, t), &at));
  PetscCall(view->law.origin(&view->law, at.S, Clock(view, t), d, d_t));
  PetscFunctionReturn(0);
}

static PetscErrorCode DepartSeen(Growth self, PetscReal t, PetscReal before, PetscInt n,
                                 const PetscReal s[], PetscReal from[]) {
  View *view = (View *)self->data;
  Label at;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; i++) {
    PetscCall(At(view, s[i], Clock(view, t), &at));
    from[i] = at.S;
  }
  PetscCall(view->law.depart(&view->law, Clock(view, t), Clock(view, before), n, from, from));
  for (PetscInt i = 0; i < n; i++) PetscCall(LabelOf(view, from[i], Clock(view, before), &from[i]));
  PetscFunctionReturn(0);
}

static PetscReal NextTurnSeen(Growth self, PetscReal t) {
  View *view = (View *)self->data;
  const PetscReal next = view->law.next_turn(&view->law, Clock(view, t));

  return next < PETSC_MAX_REAL ? view->born + next : next;
}

static PetscBool JerksSeen(Growth self, PetscReal t0, PetscReal t1) {
  View *view = (View *)self->data;
  return t1 > view->born ? view->law.jerks(&view->law, t0 - view->born, t1 - view->born)
                         : PETSC_FALSE;
}

static PetscErrorCode DestroyView(Growth self) {
  View *view = (View *)self->data;

  PetscFunctionBegin;
  if (view->law.destroy) PetscCall(view->law.destroy(&view->law));
  PetscCall(PetscFree(view->knot));
  PetscCall(PetscFree(self->data));
  PetscFunctionReturn(0);
}

/* Makes of a law one that is seen so, unless it is. */
static PetscErrorCode OpenView(Growth self, View **view) {
  PetscFunctionBegin;
  *view = (View *)self->data;
  if (self->destroy == DestroyView) PetscFunctionReturn(0);
  PetscCall(PetscNew(view));
  (*view)->law = *self;
  (*view)->time = PETSC_MIN_REAL;
  self->data = *view;
  self->destroy = DestroyView;
  self->stretch = StretchSeen;
  self->arc = ArcSeen;
  if (self->slides) {
    self->slide = SlideSeen;
    self->speed = SpeedSeen;
    self->strain = StrainSeen;
    self->origin = OriginSeen;
    self->depart = DepartSeen;
  }
  if (self->next_turn) self->next_turn = NextTurnSeen;
  if (self->jerks) self->jerks = JerksSeen;
  self->bends = NULL;
  PetscFunctionReturn(0);
}

/* GrowthDelay - the law counts time from the birth of its rod, and before that says what it does at
   the start. */
PetscErrorCode GrowthDelay(Growth growth, PetscReal born) {
  View *view;

  PetscFunctionBegin;
  PetscCall(OpenView(growth, &view));
  view->born = born;
  if (growth->end_time < PETSC_MAX_REAL) growth->end_time += born;
  PetscFunctionReturn(0);
}

/* GrowthRests - when, of a rod that grows at its tip alone, what is so far from its beginning has
   left the growth zone: the length that the rod must have. */
PetscReal GrowthRests(Growth growth, PetscReal distance) {
  return distance + growth->finest;
}

/*
  GrowthFollow - labels go with the material at n places, from the first to the last along the rod,
  none at an end: see above. The law is one whose material slides, and followed once.

  along  what tells the places: their distance from the clamp of a rod that grows at its tip alone,
         where they rest; from the tip of one that is fed
  label  of each

  Labels that nodes are to have at time `end` become those that they have all along.
*/
PetscErrorCode GrowthFollow(Growth growth, PetscInt n, const PetscReal along[], PetscReal end,
                            PetscInt nodes, PetscReal s[], PetscReal label[]) {
  PetscReal rate;
  View *view;

  PetscFunctionBegin;
  PetscCall(OpenView(growth, &view));
  growth->even = growth->similar = PETSC_FALSE;
  view->knots = n + 2;
  PetscCall(PetscCalloc1(n + 2, &view->knot));
  view->knot[n + 1].s = view->knot[n + 1].S = 1;
  for (PetscInt k = 0; k < n; k++) {
    PetscCall(Follow(&view->law, along[k], 0, &label[k], &rate));
    view->knot[k + 1].along = along[k];
    view->knot[k + 1].s = label[k];
  }
  for (PetscInt i = 0; i < nodes; i++) PetscCall(LabelOf(view, s[i], Clock(view, end), &s[i]));
  PetscFunctionReturn(0);
}
