/* A law of one's own: a function of whoever uses tendril as a library, in the place of what options
   say (TendrilSetLaw()). */
#ifndef TENDRIL_OWN_H
#define TENDRIL_OWN_H

#include <petscsys.h>
#include <tendril.h>

typedef enum { OWN_FRICTION, OWN_GROWTH, OWN_CURVATURE, OWN_LAWS } OwnKind;

static const char *const own_name[OWN_LAWS] = {"friction", "growth", "curvature"};

enum { OWN_VALUES = 6 }; /* most values of a law */

typedef struct {
  TendrilLaw value; /* NULL: options say it */
  void *ctx;
  int failed; /* what it has returned that is not 0 */
} OwnLaw;

/* Asks it. What has failed gives no numbers: the step is not taken, and the call ends. */
static inline void OwnValue(OwnLaw *self, const TendrilPlace *at, double value[OWN_VALUES]) {
  const int failed = self->failed ? self->failed : self->value(self->ctx, at, value);

  if (!failed) return;
  self->failed = failed;
  for (int k = 0; k < OWN_VALUES; k++) value[k] = NAN;
}

#endif
