/* A run that steps keep for ever, for whatever reason: none of them gets it anywhere. */
#ifndef TENDRIL_CRAWL_H
#define TENDRIL_CRAWL_H

#include <petscts.h>

/* All 0 at the start of a run. */
typedef struct {
  PetscBool counts;        /* it is looked at the sooner the more iterations its steps take */
  PetscBool chosen;        /* how long steps are, see CrawlAllowed(): none is looked at */
  PetscBool allowed;       /* how many there may be: the run does not end for it */
  PetscReal way, half, by; /* when it was looked, and half-way since; how far it had come then */
  PetscReal at;            /* t then */
  PetscInt steps;          /* since */
} Crawl;

PetscErrorCode CrawlAllowed(TS ts, Crawl *crawl);
PetscBool CrawlStep(Crawl *crawl, PetscReal t, PetscReal way, PetscReal least, PetscInt iterations);
void CrawlTell(const Crawl *crawl, PetscReal beta, PetscBool held, char line[], size_t room);

extern const char *const crawl_held;

#endif
