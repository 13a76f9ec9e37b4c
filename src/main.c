/* tendril: the growth of an elastic fibre that friction holds back. Options -> scene -> task. */
#include "tasks/tendril.h"

int main(int argc, char **argv) {
  PetscBool done;
  int failed = TendrilInitialize(&argc, &argv, &done);

  if (done) return failed;
  if (!failed) failed = TendrilRun() != 0;
  return TendrilFinalize() || failed;
}
