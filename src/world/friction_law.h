/* Laws of friction beside the built-in one (friction.h): F/v of a place and a speed, which is added
   to that of friction along the rod and varies with it (load.h). Each has a file of its own, which
   says what its row here is called, and a row. */
#ifndef TENDRIL_FRICTION_LAW_H
#define TENDRIL_FRICTION_LAW_H

#include "base/options.h"
#include "curve/place.h"

typedef struct {
  const char *option;         /* which asks for it; in messages */
  const OptionGroup *options; /* its own; NULL: it has none */
  /* what it needs to know, NULL: it was not asked for; and its end, NULL: that is borrowed */
  PetscErrorCode (*create)(void **law);
  PetscErrorCode (*destroy)(void **law);
  /* F/v, and how that changes with |v|^2 */
  void (*drag)(void *law, const Place *at, PetscReal speed2, PetscReal drag[]);
  PetscBool along;  /* it varies along the rod */
  PetscBool linear; /* it does not depend on the speed */
} FrictionLaw;

/* X(law): one row each */
#define FRICTION_LAWS(X) X(friction_own)

#define DECLARED(law) extern const FrictionLaw law;
FRICTION_LAWS(DECLARED)
#undef DECLARED

#define COUNTED(law) +1
enum { ALL_FRICTION_LAWS = FRICTION_LAWS(COUNTED) };
#undef COUNTED

#endif
