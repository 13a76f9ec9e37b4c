/* The front in a rod that is fed and learns: material that was there at first has learned since the
   start, that behind it since it came in, so what is learned has a corner between them, which goes
   along with the material. Here each side is followed by polynomials through its own places. */
#include "base/hermite.h"
#include "base/lagrange.h"
#include "rod/learned_front.h"

/* Places within a side, and at the front itself; how many times as far in as what is looked for is
   beyond the clamp it is taken from. */
enum { WIDE = LEARNED_STENCIL, NEAR = 4, AFAR = 4 };

/* The states at a label by the polynomials through n places from one on, and through the front
   where it is to be one more point. */
static void Through(const LearnedSides *sides, PetscInt first, PetscInt n, PetscBool front,
                    PetscReal at, PetscReal k[]) {
  PetscReal points[WIDE + 1], w[WIDE + 1];

  for (PetscInt i = 0; i < n; i++) points[i] = sides->label[first + i];
  if (front) points[n] = sides->at;
  LagrangeValues(n + (front ? 1 : 0), points, at, w);
  for (PetscInt c = 0; c < sides->per; c++) {
    k[c] = front ? w[n] * sides->front[c] : 0;
    for (PetscInt i = 0; i < n; i++) k[c] += w[i] * sides->all[(first + i) * sides->per + c];
  }
}

/* ... through the clamp, where they have learned nothing and their slopes are known, and n places
   behind it: k = slope s + s^2 q(s). */
static void FromClamp(const LearnedSides *sides, PetscInt n, PetscReal at, PetscReal k[]) {
  const PetscReal *s = sides->label + 1;
  PetscReal w[WIDE];

  LagrangeValues(n, s, at, w);
  for (PetscInt c = 0; c < sides->per; c++) {
    PetscReal q = 0;
    for (PetscInt i = 0; i < n; i++)
      q += w[i] * (sides->all[(1 + i) * sides->per + c] - s[i] * sides->inflow[c]) / (s[i] * s[i]);
    k[c] = at * sides->inflow[c] + at * at * q;
  }
}

/* The last of the places from one on, up to another, that is at a label or before it. */
static PetscInt Before(const LearnedSides *sides, PetscInt from, PetscInt to, PetscReal at) {
  while (to - from > 1) {
    const PetscInt mid = (from + to) / 2;
    if (sides->label[mid] <= at)
      from = mid;
    else
      to = mid;
  }
  return from;
}

/* While the front is in front of all places but the clamp: from there, by its slope, to what there
   is at the front. */
static void Begun(const LearnedSides *sides, PetscReal at, PetscReal k[]) {
  const PetscReal part = at / sides->at;

  for (PetscInt c = 0; c < sides->per; c++) {
    const PetscReal slope = sides->inflow ? sides->inflow[c] : sides->front[c] / sides->at;
    k[c] = at * slope + part * part * (sides->front[c] - sides->at * slope);
  }
}

/* Of what has come in. Next to the clamp there are as many points to the one side as to the other:
   what comes in goes by where it comes from. */
static void New(const LearnedSides *sides, PetscReal at, PetscReal k[]) {
  const PetscInt end = sides->behind, before = Before(sides, 0, end, at),
                 balanced = PetscMin(2 * (before + 1), end - 1);

  if (end == 1 && sides->at > 0)
    Begun(sides, at, k);
  else if (end > NEAR && at > sides->label[end - 1])
    Through(sides, end - NEAR, NEAR, PETSC_FALSE, at, k);
  else if (before >= WIDE / 2 - 1 && end >= WIDE)
    Through(sides, PetscMin(before - (WIDE / 2 - 1), end - WIDE), WIDE, PETSC_FALSE, at, k);
  else if (sides->inflow)
    FromClamp(sides, PetscMin(balanced, NEAR), at, k);
  else
    Through(sides, 0, PetscMin(balanced, NEAR) + 1, PETSC_FALSE, at, k);
}

/* Of what was there at first, by the places from one on, and next to the front by what what has
   come in tells of that. */
static void OldFrom(const LearnedSides *sides, PetscInt from, PetscReal at, PetscReal k[]) {
  const PetscInt end = sides->places,
                 before = at < sides->label[from] ? from - 1 : Before(sides, from, end, at),
                 first = PetscMin(before - (WIDE / 2 - 1), end - WIDE);

  if (first >= from)
    Through(sides, first, WIDE, PETSC_FALSE, at, k);
  else
    Through(sides, from, PetscMin(before <= from ? NEAR - 1 : WIDE - 1, end - from), PETSC_TRUE, at,
            k);
}

/* The nearer the nearest place is to the front, the less it counts: both would be one. */
static void Old(const LearnedSides *sides, PetscReal at, PetscReal k[]) {
  const PetscReal *s = sides->label;
  const PetscInt nearest = sides->behind;
  const PetscReal apart = 2 * (s[nearest] - sides->at) / (s[nearest] - s[nearest - 1]),
                  part = apart < 1 ? HermiteRise(apart) : 1;
  PetscReal without[2 * TROPISM_BENDS];

  OldFrom(sides, nearest, at, k);
  if (part == 1 || nearest + 1 >= sides->places) return;
  OldFrom(sides, nearest + 1, at, without);
  for (PetscInt c = 0; c < sides->per; c++) k[c] = part * k[c] + (1 - part) * without[c];
}

/* LearnedFrontFind - takes what places have learned at a time apart at the front.

   label, all  of all places, a number for each of `per` states of a place
   inflow      their slopes where material comes in, by the label; NULL: not known */
void LearnedFrontFind(const Rod rod, PetscReal t, const PetscReal *label, const PetscReal *all,
                      const PetscReal *inflow, LearnedSides *sides) {
  const PetscInt places = 2 * rod->last + 1;

  *sides = (LearnedSides){
      .per = rod->learned->per, .places = places, .label = label, .all = all, .inflow = inflow};
  sides->at = PetscMax(0, GrowthFront(rod->scene->growth, t));
  sides->behind = PetscMin(1 + Before(sides, 0, places, sides->at), places - 1);
  if (sides->behind > 1 || sides->at <= 0)
    New(sides, sides->at, sides->front);
  else
    Through(sides, 1, PetscMin(NEAR, places - 1), PETSC_FALSE, sides->at, sides->front);
}

/* Beyond the clamp it goes on as it comes in, by its slope there, and as it bends behind: what is
   not in yet has learned less than nothing, so that it has learned nothing when it comes in. What
   is taken from inside is taken from afar, so that errors of steps do not feed on themselves. */
static void Beyond(const LearnedSides *sides, PetscReal x, PetscReal k[]) {
  const PetscReal y = PetscMin(AFAR * x, sides->at),
                  part = HermiteFall(PetscMax(0, PetscMin(1, AFAR * x / sides->at - 1)));
  PetscReal inside[2 * TROPISM_BENDS];

  if (!sides->inflow) { /* (changes of it: they come in as none) */
    LearnedFrontStates(sides, x, k);
    for (PetscInt c = 0; c < sides->per; c++) k[c] = -k[c];
    return;
  }
  for (PetscInt c = 0; c < sides->per; c++) k[c] = -x * sides->inflow[c];
  if (!(part > 0)) return;
  New(sides, y, inside);
  for (PetscInt c = 0; c < sides->per; c++)
    k[c] += part * PetscSqr(x / y) * (inside[c] - y * sides->inflow[c]);
}

/* LearnedFrontStates - the states of a place where the material was that is at a label, below 0
   where it was not in yet. */
void LearnedFrontStates(const LearnedSides *sides, PetscReal at, PetscReal k[]) {
  at = PetscMin(1, at);
  if (at < 0)
    Beyond(sides, -at, k);
  else if (at <= sides->at)
    New(sides, at, k);
  else
    Old(sides, at, k);
}

/* What k is over a cell, as LearnedFrontStates() has it: its integral, that up to the middle, and
   that times the way to the end. */
typedef struct {
  PetscReal all[2 * TROPISM_BENDS], half[2 * TROPISM_BENDS], moment[2 * TROPISM_BENDS];
} Integrals;

static void AddPart(const LearnedSides *sides, PetscReal from, PetscReal to, PetscReal mid,
                    PetscReal end, Integrals *sum) {
  PetscReal k[2 * TROPISM_BENDS];

  for (int i = 0; i < GAUSS && to > from; i++) {
    const PetscReal s = from + gauss_point[i] * (to - from), w = gauss_weight[i] * (to - from);
    LearnedFrontStates(sides, s, k);
    for (PetscInt c = 0; c < sides->per; c++) {
      sum->all[c] += w * k[c];
      sum->moment[c] += w * (end - s) * k[c];
      if (to <= mid) sum->half[c] += w * k[c];
    }
  }
}

/*
  LearnedFrontTurns - the rule of a cell takes k for smooth: what the front's corner adds to the
  turn over its cell, to that times the way from the middle, and to that in the middle, all by a
  stretch of
  1. The last is what makes the rule right for whatever goes by the angle: that of the middle
  itself, and the rule's own error.

    y_b - y_a = h/6 (f_a + 4 f_mid + f_b),   y_mid = (y_a + y_b)/2 + h/8 (f_a - f_b)
*/
void LearnedFrontTurns(const LearnedSides *sides, LearnedCorner *corner) {
  const PetscReal end_weight = 1. / 6, mid_weight = 4. / 6, bow = 1. / 8;
  const PetscInt cell = PetscMin(PetscMax(sides->behind - 1, 0), sides->places - 2) / 2;
  const PetscReal *s = sides->label + 2 * cell, *k = sides->all + 2 * cell * sides->per,
                  h = s[2] - s[0], low = PetscMin(s[1], sides->at),
                  high = PetscMax(s[1], sides->at);
  Integrals sum = {{0}, {0}, {0}};

  AddPart(sides, s[0], low, s[1], s[2], &sum);
  AddPart(sides, low, high, s[1], s[2], &sum);
  AddPart(sides, high, s[2], s[1], s[2], &sum);
  corner->cell = cell;
  for (PetscInt c = 0; c < TROPISM_BENDS && c < sides->per; c++) {
    const PetscReal ka = k[c], km = k[sides->per + c], kb = k[2 * sides->per + c],
                    mid = sum.half[c] - sum.all[c] / 2 - bow * h * (ka - kb),
                    rule = sum.moment[c] / h - mid_weight * sum.half[c] - end_weight * sum.all[c];
    corner->turn[c] = sum.all[c] - h * (end_weight * (ka + kb) + mid_weight * km);
    corner->moment[c] = h / 2 * sum.all[c] - sum.moment[c] - h * end_weight * h / 2 * (kb - ka);
    corner->mid[c] = mid + rule / mid_weight;
  }
}
