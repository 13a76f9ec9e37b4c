/* Where rods touch each other, zone by zone. */
#include "rod/strand_pairs.h"

/* A zone that is being summed up: samples of its first rod, one after the other. */
typedef struct {
  StrandPlace sum;  /* labels times weights */
  PetscReal weight; /* normal forces */
  PetscInt until;   /* the last of its samples; -1: only the other rod's have been seen */
} Zone;

typedef struct {
  PetscInt n, room;
  Zone *zone;
} Zones;

/* The label of a place. */
static PetscReal LabelAt(const struct _Strands *self, const Spot *spot) {
  const PetscReal *s = self->s + spot->cell;
  return s[0] + spot->on.z * (s[1] - s[0]);
}

static PetscErrorCode AddZone(Zones *zones, PetscInt a, PetscInt b, Zone **zone) {
  PetscFunctionBegin;
  if (zones->n == zones->room) {
    zones->room = 2 * zones->room + 16;
    PetscCall(PetscRealloc((size_t)zones->room * sizeof(Zone), &zones->zone));
  }
  *zone = &zones->zone[zones->n++];
  **zone = (Zone){.sum = {.rod = {a, b}, .gap = PETSC_MAX_REAL}, .until = -1};
  PetscFunctionReturn(0);
}

/* The zone that a sample goes on with, of the rod that comes first; NULL: none. */
static Zone *GoesOn(const Zones *zones, const Pair *pair, PetscInt a, PetscInt b) {
  for (PetscInt k = zones->n - 1; k >= 0; k--) {
    Zone *zone = &zones->zone[k];
    if (zone->sum.rod[0] == a && zone->sum.rod[1] == b && zone->until >= pair->sample - 1)
      return zone;
  }
  return NULL;
}

/* The zone nearest to the foot of a sample, of the rod that comes second; NULL: none. */
static Zone *Nearest(const Zones *zones, PetscReal at, PetscInt a, PetscInt b) {
  PetscReal least = PETSC_MAX_REAL;
  Zone *nearest = NULL;

  for (PetscInt k = 0; k < zones->n; k++) {
    Zone *zone = &zones->zone[k];
    const PetscReal away = PetscAbsReal(zone->sum.s[0] / zone->weight - at);
    if (zone->sum.rod[0] != a || zone->sum.rod[1] != b || away >= least) continue;
    least = away;
    nearest = zone;
  }
  return nearest;
}

/* Adds what a pair has, whose sample is on the zone's first rod, or else on its second. */
static void AddToZone(const struct _Strands *self, const Pair *pair, PetscBool second, Zone *zone) {
  const Spot *spot[] = {second ? &pair->foot : &pair->at, second ? &pair->at : &pair->foot};
  PetscReal share[2], f[3], length;

  PairShares(self, pair, share);
  PairForce(self, pair, f);
  length = share[0] + share[1];
  for (int d = 0; d < 3; d++) zone->sum.force[d] += (second ? -length : length) * f[d];
  for (int k = 0; k < 2; k++) zone->sum.s[k] += length * pair->p * LabelAt(self, spot[k]);
  zone->weight += length * pair->p;
  zone->sum.gap = PetscMin(zone->sum.gap, pair->gap);
  if (!second) zone->until = pair->sample;
}

/* Looks at all pairs of two rods whose sample is on the first, or on the second. */
static PetscErrorCode LookAtPairs(const struct _Strands *self, PetscBool second, Zones *zones) {
  PetscFunctionBegin;
  for (PetscInt sample = 0; sample < self->samples; sample++)
    for (PetscInt k = self->first[sample]; k >= 0; k = self->pair[k].next) {
      const Pair *pair = &self->pair[k];
      const PetscInt at = self->of[pair->at.cell], foot = self->of[pair->foot.cell];
      Zone *zone;
      if (!pair->active || pair->p <= 0 || (second ? at <= foot : at >= foot)) continue;
      zone = second ? Nearest(zones, LabelAt(self, &pair->foot), foot, at)
                    : GoesOn(zones, pair, at, foot);
      if (!zone) PetscCall(AddZone(zones, second ? foot : at, second ? at : foot, &zone));
      AddToZone(self, pair, second, zone);
    }
  PetscFunctionReturn(0);
}

/* StrandsPlaces - where rods touch each other in the state of the latest load. The caller frees
   them. */
PetscErrorCode StrandsPlaces(Strands self, PetscInt *n, StrandPlace **places) {
  Zones zones = {.n = 0};

  PetscFunctionBegin;
  PetscCall(LookAtPairs(self, PETSC_FALSE, &zones));
  PetscCall(LookAtPairs(self, PETSC_TRUE, &zones));
  PetscCall(PetscMalloc1(zones.n, places));
  for (PetscInt k = 0; k < zones.n; k++) {
    StrandPlace *place = &(*places)[k];
    *place = zones.zone[k].sum;
    for (int e = 0; e < 2; e++) place->s[e] /= zones.zone[k].weight;
  }
  *n = zones.n;
  PetscCall(PetscFree(zones.zone));
  PetscFunctionReturn(0);
}
