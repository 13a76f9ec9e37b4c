#include "tasks/crawl.h"
#include "base/options.h"
#include "tasks/grow_rules.h"

/* CrawlAllowed - has whoever runs it said how long steps are to be? Then none of them crawls. Or
   how many there may be? Then the run does not end for it. */
PetscErrorCode CrawlAllowed(TS ts, Crawl *self) {
  PetscBool longest, fixed;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(PetscOptionsHasName(NULL, NULL, "-ts_max_steps", &self->allowed));
  PetscCall(PetscOptionsHasName(NULL, NULL, "-ts_adapt_dt_max", &longest));
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTNONE, &fixed));
  self->chosen = (PetscBool)(longest || fixed);
  PetscFunctionReturn(0);
}

/*
  CrawlStep - a step was taken: has the run got nowhere in the latest of them, while nothing says
  that it will? The same on every rank.

  t, way      at its end: the time, and how far the run has come, in time or otherwise
  least       what is next to nothing
  iterations  that it took
*/
PetscBool CrawlStep(Crawl *self, PetscReal t, PetscReal way, PetscReal least, PetscInt iterations) {
  const PetscInt before = self->steps;
  PetscBool crawls;

  if (self->chosen) return PETSC_FALSE;
  self->steps += self->counts ? PetscMax(1, iterations / grow_rule.crawl_iterations) : 1;
  if (before < grow_rule.crawl_steps / 2 && self->steps >= grow_rule.crawl_steps / 2)
    self->half = way;
  if (self->steps < grow_rule.crawl_steps && way < self->way + least) return PETSC_FALSE;
  crawls = (PetscBool)(way - self->way < least &&
                       way - self->half < grow_rule.crawl_faster * (self->half - self->way));
  self->by = t - self->at;
  self->at = t;
  self->way = way;
  self->steps = 0;
  return crawls;
}

/* A rod that sticks to a wall and is held by dry friction along itself, too, slides on at a force
   that neither tells, and may chatter. The least viscous share along it tells how fast. */
const char *const crawl_held =
    "friction with a wall and dry friction along the rod hold it at once: let a hundredth of the "
    "latter or more be viscous, by -friction_mu 0.99, in SI by -si_friction_viscous";

/*
  CrawlTell - the line for a run that crawls: where, and what to try.

  beta  of its friction      held  it is in touch with a wall that rubs, and dry friction holds it,
  too
*/
void CrawlTell(const Crawl *self, PetscReal beta, PetscBool held, char line[], size_t room) {
  char text[2][64];

  OptionBoth(self->at, UNIT_TIME, text[0]);
  OptionBoth(self->by, UNIT_TIME, text[1]);
  (void)snprintf(line, room,
                 "crawls at t = %s: the latest %d steps%s have brought it on by %s; %s%s%sanother "
                 "-ts_rtol or other -rod_cells, or give -ts_max_steps, and it goes on as long as "
                 "that",
                 text[0], grow_rule.crawl_steps, self->counts ? ", or 20000 iterations," : "",
                 text[1], held ? crawl_held : "", held ? "; or try " : "try ",
                 beta < 1e-3 ? "a larger -friction_beta, " : "");
}
