#include "material/growth.h"
#include "base/hermite.h"

static const OptionRow rows[] = {
    ROW_WORD("-growth_type", "uniform", "uniform,gaussian,feed,apical,table,none", 0,
             "the law g(s,t); none: a rod that does not grow"),
    ROW_REAL("-growth_initial_length", "0.5", 1e-6, 1e6, UNIT_LENGTH, 0,
             "L0, length at t = 0, in (YI/N)^(1/3)"),
    ROW_REAL("-growth_speed", "1", 1e-9, 1e9, UNIT_NONE, 0,
             "of one of several rods: its speed of growth over that of the scales"),
    ROW_REAL("-growth_width", "0.5", 1e-6, 1e6, UNIT_NONE, 0,
             "a, width in s of the growth zone at the clamp (gaussian)"),
    ROW_REAL("-growth_zone", "0.5", 1e-6, 1e6, UNIT_LENGTH, 0,
             "length of the growth zone behind the tip (apical)"),
    ROW_REAL("-growth_yield", "", 1e-6, 1e6, UNIT_FORCE, 0,
             "Pi, the thrust at which growth stalls: it is slower by 1 - thrust/Pi, and faster "
             "under tension (uniform, apical, feed); off unless given"),
    ROW_WORD("-growth_profile", "bell", "bell,even", 0,
             "how growth is shared out in the zone (apical): as a bell, or all alike"),
    ROW_TEXT("-growth_path", INPUT_FILE,
             "CSV or HDF5 file with t and length, or t and speed: how a rod is fed over time, and "
             "pulled out again (feed)"),
    ROW_TEXT("-growth_table", INPUT_FILE, "HDF5 file with /s [ns], /t [nt], /g [nt, ns] (table)")};
const OptionGroup growth_options = OPTION_GROUP_OF_ROD("Growth", rows);

/* GrowthDestroyData - for laws whose data is one block. */
PetscErrorCode GrowthDestroyData(Growth self) {
  PetscFunctionBegin;
  PetscCall(PetscFree(self->data));
  PetscFunctionReturn(0);
}

/* uniform: g = L0 + t; feed: the same map of s to arc length, with sliding material */
static PetscErrorCode StretchUniform(Growth self, PetscReal s, PetscReal t, PetscReal *g,
                                     PetscReal *g_t, PetscReal *g_s) {
  *g = self->initial_length + self->rate * t;
  *g_t = self->rate;
  *g_s = 0;
  return 0;
}

static PetscErrorCode ArcUniform(Growth self, PetscReal s, PetscReal t, PetscReal *p,
                                 PetscReal *p_t) {
  *p = s * (self->initial_length + self->rate * t);
  *p_t = s * self->rate;
  return 0;
}

static PetscErrorCode CreateUniform(Growth self) {
  PetscFunctionBegin;
  self->even = self->similar = PETSC_TRUE;
  self->stretch = StretchUniform;
  self->arc = ArcUniform;
  PetscFunctionReturn(0);
}

static PetscReal SlideFeed(Growth self, PetscReal s, PetscReal t) {
  return (1 - s) * self->rate;
}

static PetscReal SpeedFeed(Growth self, PetscReal s, PetscReal t) {
  return self->rate;
}

static PetscReal StrainFeed(Growth self, PetscReal s, PetscReal t) {
  return 0;
}

static PetscErrorCode OriginFeed(Growth self, PetscReal s, PetscReal t, PetscReal *d,
                                 PetscReal *d_t) {
  *d = (1 - s) * (self->initial_length + self->rate * t);
  *d_t = 0;
  return 0;
}

/* GrowthDepartFed - for laws that feed: material keeps its distance from the tip. */
PetscErrorCode GrowthDepartFed(Growth self, PetscReal t, PetscReal before, PetscInt n,
                               const PetscReal s[], PetscReal from[]) {
  PetscReal now, then;

  PetscFunctionBegin;
  PetscCall(GrowthLength(self, t, &now, NULL));
  PetscCall(GrowthLength(self, before, &then, NULL));
  for (PetscInt i = 0; i < n; i++) from[i] = 1 - (1 - s[i]) * (now / then);
  PetscFunctionReturn(0);
}

/* GrowthFrontFed - ... and so does the front between them and what has come in. */
PetscReal GrowthFrontFed(Growth self, PetscReal t) {
  PetscReal length;

  (void)GrowthLength(self, t, &length, NULL);
  return 1 - self->initial_length / length;
}

static PetscErrorCode CreateFeed(Growth self) {
  PetscFunctionBegin;
  PetscCall(CreateUniform(self));
  self->slides = PETSC_TRUE;
  self->slide = SlideFeed;
  self->speed = SpeedFeed;
  self->strain = StrainFeed;
  self->origin = OriginFeed;
  self->depart = GrowthDepartFed;
  self->front = GrowthFrontFed;
  PetscFunctionReturn(0);
}

/*
  apical: growth in a zone of length l behind the tip (the whole rod while it is shorter), at the
  rate w of the distance z l from the tip, a bell or even. Labels share out the length evenly,
  g = L; material behind is at rest, so it slides past them:
    V = L_t (1 - W(z)),   c = V - s L_t,
    bell: w = 30 z^2 (1-z)^2 / l,   W = z^3 (10 - 15z + 6z^2);   even: w = 1/l,   W = z.
*/
typedef struct {
  PetscReal length;
  PetscBool even;
} Zone;

static PetscReal ZoneAt(Growth self, PetscReal s, PetscReal t, PetscReal *L_over_zone) {
  PetscReal L = self->initial_length + self->rate * t;
  *L_over_zone = L / PetscMin(((Zone *)self->data)->length, L);
  return PetscMin(1, (1 - s) * *L_over_zone);
}

/* W, the part of growth that is between a place and the tip. */
static PetscReal ZoneShare(const Zone *zone, PetscReal z) {
  return zone->even ? z : HermiteRise(z);
}

static PetscReal SlideApical(Growth self, PetscReal s, PetscReal t) {
  PetscReal ratio, z = ZoneAt(self, s, t, &ratio);
  return ((1 - s) - ZoneShare((Zone *)self->data, z)) * self->rate;
}

static PetscReal SpeedApical(Growth self, PetscReal s, PetscReal t) {
  PetscReal ratio, z = ZoneAt(self, s, t, &ratio);
  return (((Zone *)self->data)->even ? 1 - z : HermiteFall(z)) * self->rate;
}

static PetscReal StrainApical(Growth self, PetscReal s, PetscReal t) {
  PetscReal ratio, z = ZoneAt(self, s, t, &ratio);
  if (((Zone *)self->data)->even) return z < 1 ? ratio * self->rate : 0;
  return HermiteRiseSlope(z) * ratio * self->rate;
}

/* What is laid down keeps its place; while it stretches it takes on that of where it is. */
static PetscErrorCode OriginApical(Growth self, PetscReal s, PetscReal t, PetscReal *d,
                                   PetscReal *d_t) {
  *d = self->initial_length - s * (self->initial_length + self->rate * t);
  *d_t = -SlideApical(self, s, t) - s * self->rate;
  return 0;
}

/* How fast the distance from the tip grows with the length, of what is so far from it. */
static PetscReal Recedes(PetscReal distance, PetscReal length, const Zone *zone) {
  return ZoneShare(zone, PetscMin(1, distance / PetscMin(zone->length, length)));
}

/* The distance from the tip that material had when the rod was shorter, in a zone in which it
   recedes as it is far, d' = d/l; of a rod that is shorter than the zone d' = d/L. */
static PetscReal DepartEven(PetscReal d, PetscReal L, PetscReal then, PetscReal zone) {
  const PetscReal whole = PetscMin(L, PetscMax(then, zone)); /* it is as long as the zone */
  const PetscReal rested = PetscMin(PetscMax(0, d - zone), L - whole);

  if (d > zone && d - rested > zone) return d - (L - then); /* all along */
  d = (d - rested) * PetscExpReal(-(L - rested - whole) / zone);
  return d * then / whole;
}

/* Distances from the tip that material had, by the classical method of Runge and Kutta where there
   is no formula: behind the zone it rests. */
static PetscErrorCode DepartApical(Growth self, PetscReal t, PetscReal before, PetscInt n,
                                   const PetscReal s[], PetscReal from[]) {
  const Zone *zone = (Zone *)self->data;
  const PetscReal longest = 0.02, /* step, in zones */
      L = self->initial_length + self->rate * t, then = self->initial_length + self->rate * before;
  const PetscInt steps =
      PetscMax(1, (PetscInt)PetscCeilReal((L - then) / (longest * zone->length)));
  const PetscReal h = (then - L) / steps;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; i++) {
    PetscReal d = (1 - s[i]) * L;
    if (d >= PetscMin(zone->length, L) + (L - then)) {
      from[i] = s[i] * L / then;
      continue;
    }
    if (zone->even) {
      from[i] = PetscMax(0, 1 - DepartEven(d, L, then, zone->length) / then);
      continue;
    }
    for (PetscInt k = 0; k < steps; k++) {
      const PetscReal at = L + k * h;
      const PetscReal k1 = Recedes(d, at, zone), k2 = Recedes(d + h / 2 * k1, at + h / 2, zone),
                      k3 = Recedes(d + h / 2 * k2, at + h / 2, zone),
                      k4 = Recedes(d + h * k3, at + h, zone);
      d += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
    from[i] = PetscMax(0, 1 - d / then);
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode CreateApical(Growth self) {
  PetscInt profile;
  Zone *zone;

  PetscFunctionBegin;
  PetscCall(CreateUniform(self));
  self->similar = PETSC_FALSE;
  self->slides = PETSC_TRUE;
  PetscCall(PetscNew(&zone));
  self->data = zone;
  self->destroy = GrowthDestroyData;
  PetscCall(OptionReal("-growth_zone", &zone->length, NULL));
  PetscCall(OptionWord("-growth_profile", &profile, NULL));
  zone->even = (PetscBool)(profile == 1);
  self->slide = SlideApical;
  self->speed = SpeedApical;
  self->strain = StrainApical;
  self->origin = OriginApical;
  self->depart = DepartApical;
  self->finest = zone->length;
  self->rests = PETSC_TRUE;
  PetscFunctionReturn(0);
}

/* gaussian: g = L0 + b exp(-s^2/a^2) t, b = 2 / (a sqrt(pi) erf(1/a)), so that L = L0 + t */
typedef struct {
  PetscReal a, b;
} Gaussian;

static PetscErrorCode StretchGaussian(Growth self, PetscReal s, PetscReal t, PetscReal *g,
                                      PetscReal *g_t, PetscReal *g_s) {
  Gaussian *law = (Gaussian *)self->data;
  *g_t = self->rate * law->b * PetscExpReal(-PetscSqr(s / law->a));
  *g = self->initial_length + *g_t * t;
  *g_s = -2 * s / PetscSqr(law->a) * *g_t * t;
  return 0;
}

static PetscErrorCode ArcGaussian(Growth self, PetscReal s, PetscReal t, PetscReal *p,
                                  PetscReal *p_t) {
  Gaussian *law = (Gaussian *)self->data;
  *p_t = self->rate * erf(s / law->a) / erf(1 / law->a);
  *p = self->initial_length * s + *p_t * t;
  return 0;
}

static PetscErrorCode CreateGaussian(Growth self) {
  Gaussian *law;

  PetscFunctionBegin;
  PetscCall(PetscNew(&law));
  self->data = law;
  self->destroy = GrowthDestroyData;
  PetscCall(OptionReal("-growth_width", &law->a, NULL));
  self->narrow = law->a;
  law->b = 2 / (law->a * PetscSqrtReal(PETSC_PI) * erf(1 / law->a));
  self->stretch = StretchGaussian;
  self->arc = ArcGaussian;
  PetscFunctionReturn(0);
}

/* none: g = L0 */
static PetscErrorCode StretchNone(Growth self, PetscReal s, PetscReal t, PetscReal *g,
                                  PetscReal *g_t, PetscReal *g_s) {
  *g = self->initial_length;
  *g_t = *g_s = 0;
  return 0;
}

static PetscErrorCode ArcNone(Growth self, PetscReal s, PetscReal t, PetscReal *p, PetscReal *p_t) {
  *p = s * self->initial_length;
  *p_t = 0;
  return 0;
}

static PetscErrorCode CreateNone(Growth self) {
  PetscFunctionBegin;
  self->even = self->still = PETSC_TRUE;
  self->stretch = StretchNone;
  self->arc = ArcNone;
  PetscFunctionReturn(0);
}

/* A law of one's own (TendrilSetLaw()): it says g and p with their derivatives. */
static PetscErrorCode StretchOwn(Growth self, PetscReal s, PetscReal t, PetscReal *g,
                                 PetscReal *g_t, PetscReal *g_s) {
  const TendrilPlace at = {.s = s, .t = t};
  PetscReal value[OWN_VALUES] = {0};

  OwnValue((OwnLaw *)self->data, &at, value);
  *g = value[0];
  *g_t = value[1];
  *g_s = value[2];
  return 0;
}

static PetscErrorCode ArcOwn(Growth self, PetscReal s, PetscReal t, PetscReal *p, PetscReal *p_t) {
  const TendrilPlace at = {.s = s, .t = t};
  PetscReal value[OWN_VALUES] = {0};

  OwnValue((OwnLaw *)self->data, &at, value);
  *p = value[3];
  *p_t = value[4];
  return 0;
}

/* What it says at places all over the run must be that of a rod: p begins at 0 and rises as g says,
   which is positive. Whether g depends on s, and the rod's velocity on t, shows there, too. */
static PetscErrorCode LookAtOwn(Growth self, PetscReal end) {
  enum { PLACES = 33, TIMES = 9 };
  const PetscReal off = 1e-3; /* of the sum, by Simpson's rule */
  PetscReal rate[PLACES] = {0};

  PetscFunctionBegin;
  self->even = self->similar = self->still = PETSC_TRUE;
  for (int k = 0; k < TIMES; k++) {
    const PetscReal t = end * k / (TIMES - 1), h = 1. / (PLACES - 1);
    PetscReal g[PLACES], g_t, g_s, p, p_t, sum = 0;
    for (int i = 0; i < PLACES; i++) {
      PetscCall(StretchOwn(self, i * h, t, &g[i], &g_t, &g_s));
      PetscCall(ArcOwn(self, i * h, t, &p, &p_t));
      UserCheck(g[i] > 0 && g[i] < PETSC_MAX_REAL, OptionsComm(),
                "the growth law of one's own: g = %g at s = %g, t = %g; it must be positive",
                (double)g[i], (double)(i * h), (double)t);
      if (i && i % 2 == 0) sum += h / 3 * (g[i - 2] + 4 * g[i - 1] + g[i]);
      UserCheck(i % 2 || PetscAbsReal(p - sum) <= off * PetscMax(sum, g[0] * h), OptionsComm(),
                "the growth law of one's own: p = %g at s = %g, t = %g, where the integral of g is "
                "%g",
                (double)p, (double)(i * h), (double)t, (double)sum);
      if (g_s != 0) self->even = PETSC_FALSE;
      if (k && p_t != rate[i]) self->similar = PETSC_FALSE;
      if (p_t != 0) self->still = PETSC_FALSE;
      rate[i] = p_t;
    }
    if (!k) self->initial_length = p;
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode CreateOwn(Growth self, OwnLaw *law) {
  PetscReal end;
  PetscBool given;

  PetscFunctionBegin;
  for (int k = 0; k < 2; k++) {
    const char *const option = k ? "-growth_initial_length" : "-growth_type";
    PetscCall(OptionGiven(option, &given));
    UserCheck(!given, OptionsComm(), "%s: the growth law of one's own says it; take this out",
              option);
  }
  PetscCall(OptionReal("-ts_max_time", &end, NULL));
  self->type = "own";
  self->data = law;
  self->stretch = StretchOwn;
  self->arc = ArcOwn;
  PetscCall(LookAtOwn(self, end));
  PetscFunctionReturn(0);
}

/* To add a law: a creator above, a line here, in the order of -growth_type's words. */
static const struct {
  const char *name;
  PetscErrorCode (*create)(Growth);
} laws[] = {{"uniform", CreateUniform}, {"gaussian", CreateGaussian}, {"feed", CreateFeed},
            {"apical", CreateApical},   {"table", GrowthCreateTable}, {"none", CreateNone}};

/* How fast it is, of one of several rods: what tables say in time, they say it all. */
static PetscErrorCode ReadRate(Growth self, PetscBool by_path) {
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(OptionReal("-growth_speed", &self->rate, &given));
  UserCheck(!given || !(by_path || self->stretch == StretchNone || self->steep > 0), OptionsComm(),
            "-growth_speed: not with %s, which says itself how fast the rod grows; leave one out",
            by_path           ? "-growth_path"
            : self->steep > 0 ? "-growth_table"
                              : "-growth_type none");
  UserCheck(!given || self->yield == 0, OptionsComm(),
            "-growth_speed: not of growth that feels force (-growth_yield); leave one out");
  PetscFunctionReturn(0);
}

/*
  GrowthCreate - the growth law asked for by -growth_type and its options. Collective.
  The caller destroys it with GrowthDestroy().
*/
PetscErrorCode GrowthCreate(Growth *growth) {
  OwnLaw *own = OptionsLaw(OWN_GROWTH);
  PetscBool by_path;
  PetscInt choice;
  Growth self;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  *growth = self; /* whole or not, the caller destroys it */
  self->end_time = PETSC_MAX_REAL;
  self->rate = 1;
  if (own) {
    PetscCall(CreateOwn(self, own));
    PetscFunctionReturn(0);
  }
  PetscCall(OptionWord("-growth_type", &choice, NULL));
  if (laws[choice].create != GrowthCreateTable)
    PetscCall(OptionReal("-growth_initial_length", &self->initial_length, NULL));
  self->type = laws[choice].name;
  PetscCall(GrowthPathGiven(self, &by_path));
  PetscCall(laws[choice].create(self));
  if (by_path) PetscCall(GrowthFeedByPath(self));
  PetscCall(GrowthYields(self));
  PetscCall(ReadRate(self, by_path));
  PetscFunctionReturn(0);
}

PetscErrorCode GrowthDestroy(Growth *growth) {
  PetscFunctionBegin;
  if (!*growth) PetscFunctionReturn(0);
  if ((*growth)->destroy) PetscCall((*growth)->destroy(*growth));
  PetscCall(PetscFree(*growth));
  PetscFunctionReturn(0);
}

/* GrowthStretch - g, its rate g_t and its slope g_s = dg/ds (both may be NULL) at n labels s, at
   time t. Arrays of n, the caller's. */
PetscErrorCode GrowthStretch(Growth growth, PetscInt n, const PetscReal s[], PetscReal t,
                             PetscReal g[], PetscReal g_t[], PetscReal g_s[]) {
  PetscReal rate, slope;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; i++)
    PetscCall(
        growth->stretch(growth, s[i], t, &g[i], g_t ? &g_t[i] : &rate, g_s ? &g_s[i] : &slope));
  PetscFunctionReturn(0);
}

/* GrowthArc - the arc length p = int_0^s g and its rate p_t (may be NULL) at n labels, at time t.
 */
PetscErrorCode GrowthArc(Growth growth, PetscInt n, const PetscReal s[], PetscReal t, PetscReal p[],
                         PetscReal p_t[]) {
  PetscReal rate;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; i++)
    PetscCall(growth->arc(growth, s[i], t, &p[i], p_t ? &p_t[i] : &rate));
  PetscFunctionReturn(0);
}

/* GrowthOutlook - words for who is told that a rod is stable up to the end: where it may give way.
 */
const char *GrowthOutlook(Growth growth) {
  if (strcmp(growth->type, "none")) return "look further";
  return "and with -growth_type none it does not lengthen: begin longer, or load it more";
}

/* GrowthLongest - how long a rod that is fed by a schedule is at most up to a time; another is as
   long as it is then, or at the start. */
PetscErrorCode GrowthLongest(Growth growth, PetscReal end, PetscReal *length) {
  PetscReal L;

  PetscFunctionBegin;
  PetscCall(GrowthLength(growth, end, length, NULL));
  *length = PetscMax(*length, growth->initial_length);
  if (growth->fastest == 0) PetscFunctionReturn(0);
  for (PetscReal t = growth->next_turn(growth, 0); t < end; t = growth->next_turn(growth, t)) {
    PetscCall(GrowthLength(growth, t, &L, NULL));
    *length = PetscMax(*length, L);
  }
  PetscFunctionReturn(0);
}

/* GrowthLength - L(t) and dL/dt (may be NULL). */
PetscErrorCode GrowthLength(Growth growth, PetscReal t, PetscReal *length, PetscReal *length_t) {
  const PetscReal tip = 1;

  PetscFunctionBegin;
  PetscCall(GrowthArc(growth, 1, &tip, t, length, length_t));
  PetscFunctionReturn(0);
}
