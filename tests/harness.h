/* What the unit tests share: a main under MPI, verdicts that all ranks share, scenes from options,
   a random number that is the same for the same place on any number of ranks. */
#ifndef TENDRIL_HARNESS_H
#define TENDRIL_HARNESS_H

#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdlib.h>
#include <unistd.h>
#include <cmocka.h>
#include "base/hdf.h"
#include "base/options.h"
#include "scene/scene.h"
#include "tasks/program.h"

/* A failed call ends all ranks: nothing hangs. */
#define CHECK(call) PetscCallAbort(PETSC_COMM_WORLD, call)

/* Collective: fails on all ranks if it does on one. */
#define EXPECT(cond, ...)                                                                          \
  do {                                                                                             \
    int good_ = (cond) ? 1 : 0, mine_ = good_;                                                     \
    MPI_Allreduce(MPI_IN_PLACE, &good_, 1, MPI_INT, MPI_MIN, PETSC_COMM_WORLD);                    \
    if (!mine_) {                                                                                  \
      print_error("%s:%d: not %s: ", __FILE__, __LINE__, #cond);                                   \
      print_error(__VA_ARGS__);                                                                    \
      print_error("\n");                                                                           \
    }                                                                                              \
    if (!good_) fail();                                                                            \
  } while (0)

/* The slope of log2 of an error that a halving brought from coarse to fine. */
static inline PetscReal Order(PetscReal coarse, PetscReal fine) {
  return PetscLog2Real(coarse / fine);
}

static inline PetscReal AllMax(PetscReal value) {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPIU_REAL, MPI_MAX, PETSC_COMM_WORLD);
  return value;
}

/* In [-1, 1], fixed by the two numbers. */
static inline PetscReal Scatter(uint64_t a, uint64_t b) {
  uint64_t z = (a + 1) * 0x9E3779B97F4A7C15u + (b + 1) * 0xD1B54A32D192ED03u;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return (PetscReal)((z ^ (z >> 31)) >> 11) / 4503599627370496.0 - 1;
}

/* The options of one test, and nothing else; printf's format. */
static inline void SetOptions(const char *format, ...) {
  char text[1024];
  va_list list;
  va_start(list, format);
  vsnprintf(text, sizeof(text), format, list);
  va_end(list);
  CHECK(PetscOptionsClear(NULL));
  CHECK(PetscOptionsInsertString(NULL, text));
}

/* The name of a new file, the same on all ranks. */
static inline void OpenScratch(char path[64]) {
  PetscMPIInt rank;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (!rank) {
    int handle;
    strcpy(path, "/tmp/tendril-table-XXXXXX");
    handle = mkstemp(path);
    assert_true(handle >= 0);
    close(handle);
  }
  MPI_Bcast(path, 64, MPI_CHAR, 0, PETSC_COMM_WORLD);
}

/* A file of text, as of walls, whose name is left in path. */
static inline void WriteWalls(char path[64], const char *text) {
  PetscMPIInt rank;
  OpenScratch(path);
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (!rank) {
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    fputs(text, f);
    fclose(f);
  }
  MPI_Barrier(PETSC_COMM_WORLD);
}

/* n datasets, with their ranks, dimensions and values, into a file that OpenScratch() named. */
static inline void WriteScratch(const char *path, int n, const char *const name[],
                                const int rank_of[], const PetscInt *const dims[],
                                const PetscReal *const values[]) {
  PetscMPIInt rank;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (!rank) {
    char fault[HDF_FAULT];
    HdfFile file;
    CHECK(HdfCreate(path, &file));
    for (int i = 0; i < n; i++)
      CHECK(HdfWrite(file, name[i], rank_of[i], dims[i], values[i], "1", name[i] + 1));
    CHECK(HdfClose(&file, fault));
    assert_string_equal(fault, "");
  }
  MPI_Barrier(PETSC_COMM_WORLD);
}

/* A file with /s [ns], /t [nt] and /g [nt, ns] of a function; its name is left in path. */
static inline void WriteTable(char path[64], PetscInt ns, PetscInt nt, PetscReal end,
                              PetscReal (*g)(PetscReal s, PetscReal t)) {
  PetscMPIInt rank;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (!rank) {
    PetscInt dims[2] = {nt, ns};
    PetscReal *s, *t, *values;
    char fault[HDF_FAULT];
    HdfFile file;
    int handle;
    strcpy(path, "/tmp/tendril-table-XXXXXX");
    handle = mkstemp(path);
    assert_true(handle >= 0);
    close(handle);
    CHECK(PetscMalloc3(ns, &s, nt, &t, ns * nt, &values));
    for (PetscInt i = 0; i < ns; i++) s[i] = (PetscReal)i / (ns - 1);
    for (PetscInt j = 0; j < nt; j++) t[j] = end * j / (nt - 1);
    for (PetscInt j = 0; j < nt; j++)
      for (PetscInt i = 0; i < ns; i++) values[j * ns + i] = g(s[i], t[j]);
    CHECK(HdfCreate(path, &file));
    CHECK(HdfWrite(file, "/s", 1, &dims[1], s, "1", "labels"));
    CHECK(HdfWrite(file, "/t", 1, &dims[0], t, "l/V", "times"));
    CHECK(HdfWrite(file, "/g", 2, dims, values, "l", "stretch"));
    CHECK(HdfClose(&file, fault));
    assert_string_equal(fault, "");
    CHECK(PetscFree3(s, t, values));
  }
  MPI_Bcast(path, 64, MPI_CHAR, 0, PETSC_COMM_WORLD);
}

static inline void RemoveFile(const char *path) {
  PetscMPIInt rank;
  MPI_Barrier(PETSC_COMM_WORLD);
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (!rank) unlink(path);
}

/* int main of a test; the environment's TENDRIL_CASE picks one of its cases. */
#define MAIN(tests)                                                                                \
  int main(int argc, char **argv) {                                                                \
    Program program;                                                                               \
    PetscBool done;                                                                                \
    int failed = ProgramBegin(&program, &argc, &argv, &done);                                      \
    if (done || failed) return 1;                                                                  \
    ErrorsOptionsRead();                                                                           \
    if (getenv("TENDRIL_CASE")) cmocka_set_test_filter(getenv("TENDRIL_CASE"));                    \
    failed = cmocka_run_group_tests(tests, NULL, NULL);                                            \
    return ProgramEnd(&program) || failed != 0;                                                    \
  }

#endif
