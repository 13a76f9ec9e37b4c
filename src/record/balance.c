/* The balance of energy: what powers do between the times at which a rod is measured. */
#include "record/balance.h"
#include "base/lagrange.h"

/* Does a value stay between those of n points, by so much at most? */
static PetscBool StaysBetween(PetscReal value, PetscInt n, const PetscReal f[], PetscReal beside) {
  PetscReal least = f[0], most = f[0];

  for (PetscInt i = 1; i < n; i++) {
    least = PetscMin(least, f[i]);
    most = PetscMax(most, f[i]);
  }
  return (PetscBool)(least - beside * (most - least) <= value &&
                     value <= most + beside * (most - least));
}

/* The integral from the last but one to the last time of the polynomial through all of them, times
   the exponential of another one through logs; NULL: 1. good: false if either leaves what it goes
   through, and says nothing of what is between. */
static PetscReal Through(PetscInt n, const PetscReal time[], const PetscReal f[],
                         const PetscReal logs[], PetscBool *good) {
  PetscReal a = time[n - 2], h = time[n - 1] - a, sum = 0, L[BALANCE_POINTS];

  *good = PETSC_TRUE;
  for (int q = 0; q < GAUSS; q++) {
    PetscReal value = 0, log_now = 0;
    LagrangeValues(n, time, a + h * gauss_point[q], L);
    for (PetscInt i = 0; i < n; i++) {
      value += L[i] * f[i];
      if (logs) log_now += L[i] * logs[i];
    }
    if (!StaysBetween(value, n, f, 1) || (logs && !StaysBetween(log_now, n, logs, 0.25)))
      *good = PETSC_FALSE;
    sum += h * gauss_weight[q] * value * PetscExpReal(log_now);
  }
  return sum;
}

/* An integral over the last interval. */
typedef struct {
  PetscReal sum, doubt; /* and by how much a point less says another */
  PetscBool good;       /* false: it says nothing */
} Integral;

static Integral IntegralThrough(PetscInt n, const PetscReal time[], const PetscReal f[],
                                const PetscReal logs[]) {
  Integral all;
  PetscReal less = (time[n - 1] - time[n - 2]) * f[n - 1]; /* of one */
  PetscBool any;

  all.sum = Through(n, time, f, logs, &all.good);
  if (n > 2) less = Through(n - 1, time + 1, f + 1, logs ? logs + 1 : NULL, &any);
  all.doubt = PetscAbsReal(all.sum - less);
  return all;
}

/* What changes like energy is divided by it first, and its logarithm taken for a polynomial, too:
   while a wobble decays, a step may be many times longer than the energy lasts. */
static Integral IntegralOverEnergy(PetscInt n, const PetscReal time[], const PetscReal f[],
                                   const PetscReal energy[]) {
  PetscReal logs[BALANCE_POINTS] = {0}, part[BALANCE_POINTS] = {0};

  for (PetscInt i = 0; i < n; i++) {
    logs[i] = PetscLogReal(energy[i]);
    part[i] = f[i] / energy[i];
  }
  return IntegralThrough(n, time, part, logs);
}

/* The integral of f over the last interval: over the energy, NULL: not; nor where f itself is
   nearer to a polynomial, of which a point less says more nearly the same: powers of a rod that is
   led, say. Behind a kink, where steps begin again and double, a polynomial through points on both
   sides may go anywhere between the last two: then through fewer points, down to the chord. */
static Integral LastInterval(PetscInt n, const PetscReal time[], const PetscReal f[],
                             const PetscReal energy[]) {
  Integral over = {.good = PETSC_FALSE}, plain;

  if (energy) over = IntegralOverEnergy(n, time, f, energy);
  if (over.good && n == 2) return over;
  plain = IntegralThrough(n, time, f, NULL);
  if (over.good) return plain.good && plain.doubt < over.doubt ? plain : over;
  for (PetscInt m = n - 1; m > 1 && !plain.good; m--)
    plain = IntegralThrough(m, time + n - m, f + n - m, NULL);
  return plain;
}

/* Can energies be divided by? Not if there is none, or none to speak of beside what friction took,
   which is then round-off; nor if they are so far apart that the round-off of a balance of large
   powers would grow. */
static PetscBool Comparable(PetscInt n, const PetscReal energy[], PetscReal lost) {
  const PetscReal rounding = 1e-14, apart = 1e4;
  PetscReal least = energy[0], most = energy[0];

  for (PetscInt i = 1; i < n; i++) {
    least = PetscMin(least, energy[i]);
    most = PetscMax(most, energy[i]);
  }
  return (PetscBool)(least > rounding * lost && most < apart * least);
}

/* BalancePower - that of all that acts less what is lost. */
PetscReal BalancePower(const Observation *seen) {
  return seen->growth_power + seen->tip_power + seen->weight_power + seen->clamp_power +
         seen->wall_power + seen->curvature_power + seen->tropism_power - seen->dissipation;
}

/* A power that is not known; a number, for a restart file holds no others. */
static const PetscReal unknown = PETSC_MAX_REAL;

/* BalanceAdd - the next point; known: its powers are, but behind a break. */
void BalanceAdd(Balance *self, const Observation *seen, PetscBool known) {
  PetscReal energy = seen->energy + seen->contact_energy;

  if (self->closed) { /* what bending lost, friction took: the powers on both sides do not tell */
    self->lost_work += PetscMax(0, self->left - energy);
    self->net_work += energy - self->left;
    self->n = 0;
  } else if (!self->n)
    self->first_energy = energy;
  known = (PetscBool)(known && !self->broken);
  self->closed = self->broken = PETSC_FALSE;
  if (self->n == BALANCE_POINTS) {
    for (int i = 1; i < BALANCE_POINTS; i++) {
      self->time[i - 1] = self->time[i];
      self->net[i - 1] = self->net[i];
      self->loss[i - 1] = self->loss[i];
      self->energy[i - 1] = self->energy[i];
    }
    self->n--;
  }
  self->time[self->n] = seen->t;
  self->net[self->n] = known ? BalancePower(seen) : unknown;
  self->loss[self->n] = seen->dissipation;
  self->energy[self->n] = seen->energy;
  self->n++;
  if (self->n == 2 && self->net[0] == unknown) { /* then the first step's hold for it */
    self->net[0] = self->net[1];
    self->loss[0] = self->loss[1];
  }
}

/* What the defect is a part of. */
static PetscReal Scale(const Balance *self, const Scene scene, const Observation *seen) {
  PetscReal scale = PetscMax(seen->energy + seen->contact_energy, self->first_energy);

  if (scale <= CurvatureRounding(&scene->curvature, seen->length))
    /* none: at rest, too, round-off of its places works against friction of 1, and bends it */
    scale = PETSC_MACHINE_EPSILON * PetscMax(PetscSqr(seen->length), 1 / seen->length);
  return PetscMax(scale, PetscAbsReal(self->lost_work));
}

/* BalanceFromTimes - work by the powers at the latest times. Of a rod that touches something these
   have kinks, wherever a place begins to touch or to slide: where a point less says another work,
   by more than this part of the scale, they do not tell what is between. (Not in the first steps,
   which see no kinks.) */
void BalanceFromTimes(const Balance *self, const Scene scene, const Observation *seen, Work *work) {
  const PetscReal sure = 1e-7, *energy = self->energy;
  Integral net;

  work->loss = LastInterval(self->n, self->time, self->loss, NULL).sum;
  if (!Comparable(self->n, energy, PetscAbsReal(self->lost_work + work->loss))) energy = NULL;
  net = LastInterval(self->n, self->time, self->net, energy);
  work->net = net.sum;
  work->doubt = net.doubt;
  work->unsure = (PetscBool)(scene->contact.any && self->n == BALANCE_POINTS &&
                             net.doubt > sure * Scale(self, scene, seen));
}

/* BalanceClose - follows it: dE/dt = W + power at the tip, of weight and clamp - dissipation. */
void BalanceClose(Balance *self, const Scene scene, const Work *work, Observation *seen) {
  PetscReal energy = seen->energy + seen->contact_energy;

  self->lost_work += work->loss;
  self->net_work += work->net;
  seen->energy_defect =
      PetscAbsReal(energy - self->first_energy - self->net_work) / Scale(self, scene, seen);
}

/* The sums of the energy balance and the points they are built on, which rank 0 has. */
static void Parts(Balance *self, PetscReal *part[BALANCE_PARTS], PetscReal *sum[BALANCE_SUMS]) {
  part[0] = self->time;
  part[1] = self->net;
  part[2] = self->loss;
  part[3] = self->energy;
  sum[0] = &self->first_energy;
  sum[1] = &self->net_work;
  sum[2] = &self->lost_work;
}

/* BalanceGet - what it needs to go on. */
void BalanceGet(Balance *self, PetscReal state[BALANCE_STATE]) {
  PetscReal *part[BALANCE_PARTS], *sum[BALANCE_SUMS];

  Parts(self, part, sum);
  *state++ = self->n;
  for (int k = 0; k < BALANCE_SUMS; k++) *state++ = *sum[k];
  for (int k = 0; k < BALANCE_PARTS; k++)
    for (int i = 0; i < BALANCE_POINTS; i++) *state++ = part[k][i];
}

/* BalanceSet - gives back what BalanceGet() gave. */
void BalanceSet(Balance *self, const PetscReal state[BALANCE_STATE]) {
  PetscReal *part[BALANCE_PARTS], *sum[BALANCE_SUMS];

  Parts(self, part, sum);
  self->n = (PetscInt)*state++;
  for (int k = 0; k < BALANCE_SUMS; k++) *sum[k] = *state++;
  for (int k = 0; k < BALANCE_PARTS; k++)
    for (int i = 0; i < BALANCE_POINTS; i++) part[k][i] = *state++;
}
