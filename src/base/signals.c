#include "base/signals.h"
#include <signal.h>

static volatile sig_atomic_t caught; /* on this rank */

static void Note(int number) {
  if (caught && number != SIGUSR1) signal(number, SIG_DFL);
  caught = number;
}

/* SignalsCatch - from here on SIGTERM, SIGINT and SIGUSR1 are noted: what is under way looks for
   them and ends in good order. Who cannot wait for that says it three times. (SIGUSR1 is what batch
   systems send some time before the end, and what mpiexec hands to the ranks and does nothing more:
   of SIGTERM it makes an end of its own, a second later, in which their last words are lost.) They
   belong to the process, so whoever is outermost calls this: a run, or the sweep that it is a
   member of. Not collective. */
void SignalsCatch(void) {
  caught = 0;
  signal(SIGTERM, Note);
  signal(SIGINT, Note);
  signal(SIGUSR1, Note);
}

/* SignalCaught - the signal that this rank has been sent since; 0: none. Not collective. */
int SignalCaught(void) {
  return caught;
}
