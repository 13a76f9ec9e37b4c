/* tendril: the growth of an elastic fibre that friction holds back. Options -> scene -> task. */
#include "tasks/program.h"

int main(int argc, char **argv) {
  Program program;
  PetscBool done;
  int failed = ProgramBegin(&program, &argc, &argv, &done);

  if (done) return failed;
  if (!failed) failed = ProgramRun() != 0;
  return ProgramEnd(&program) || failed;
}
