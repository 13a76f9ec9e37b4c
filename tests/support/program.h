/* A program of its own that only runs one function, within all that tendril's begins and ends with.
 */
#ifndef TENDRIL_PROGRAM_OF_A_TEST_H
#define TENDRIL_PROGRAM_OF_A_TEST_H

#include "tasks/program.h"

#define PROGRAM(Run)                                                                               \
  int main(int argc, char **argv) {                                                                \
    Program program;                                                                               \
    PetscBool done;                                                                                \
    int failed = ProgramBegin(&program, &argc, &argv, &done);                                      \
    if (done) return failed;                                                                       \
    if (!failed) failed = Run() != 0;                                                              \
    return ProgramEnd(&program) || failed;                                                         \
  }

#endif
