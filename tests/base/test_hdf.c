/* Files: what is written is read, a file is whole or as it was, one process at a time.
   test: what is written is read and a file is whole or as it was */
#include "harness.h"
#include "base/lock.h"
#include <sys/wait.h>

static const PetscInt two = 2;

static void TestRows(void **state) {
  const PetscReal rows[6] = {1, 2, 3, 4, 5, 6}, whole[2] = {7, 8};
  PetscReal *back, row[2];
  PetscInt dims[2];
  char path[64], fault[HDF_FAULT];
  HdfFile file;

  OpenScratch(path);
  CHECK(HdfCreate(path, &file));
  CHECK(HdfAppendable(file, "/rows", 1, &two, "m", "rows"));
  CHECK(HdfAppend(file, "/rows", 2, rows));
  CHECK(HdfAppend(file, "/rows", 1, rows + 4));
  CHECK(HdfWrite(file, "/whole", 1, &two, whole, "1", "whole"));
  CHECK(HdfWrite(file, "/whole", 1, &two, rows, "1", "in its place"));
  CHECK(HdfText(file, "/", "version", "a"));
  CHECK(HdfText(file, "/", "version", "longer"));
  CHECK(HdfClose(&file, fault));
  EXPECT(!fault[0], "%s", fault);
  CHECK(HdfRead("-x", path, "/rows", 2, dims, &back));
  EXPECT(dims[0] == 3 && dims[1] == 2, "%d x %d", (int)dims[0], (int)dims[1]);
  for (int k = 0; k < 6; k++) EXPECT(back[k] == rows[k], "row %d is %g", k, (double)back[k]);
  CHECK(PetscFree(back));
  CHECK(HdfReadRow(path, "/rows", 1, 2, row, fault));
  EXPECT(!fault[0] && row[0] == 3 && row[1] == 4, "%s", fault);
  CHECK(HdfReadRow(path, "/rows", 3, 2, row, fault));
  EXPECT(fault[0], "a row that is not there is read");
  CHECK(HdfAmend(path, path, &file));
  CHECK(HdfTruncate(file, "/rows", 1));
  CHECK(HdfDelete(file, "/whole"));
  CHECK(HdfClose(&file, fault));
  CHECK(HdfRead("-x", path, "/rows", 2, dims, &back));
  EXPECT(dims[0] == 1 && back[1] == 2, "%d rows", (int)dims[0]);
  CHECK(PetscFree(back));
  RemoveFile(path);
}

/* What is dropped, or cannot be written, leaves what was there. */
static void TestWhole(void **state) {
  char path[64], fault[HDF_FAULT], *text;
  HdfFile file;

  OpenScratch(path);
  CHECK(HdfCreate(path, &file));
  CHECK(HdfText(file, "/", "version", "first"));
  CHECK(HdfClose(&file, fault));
  CHECK(HdfAmend(path, path, &file));
  CHECK(HdfText(file, "/", "version", "second"));
  CHECK(HdfDrop(&file));
  CHECK(HdfReadText("-x", path, "version", &text));
  EXPECT(!strcmp(text, "first"), "%s", text);
  CHECK(PetscFree(text));
  CHECK(HdfCreate("/nowhere/at/all.h5", &file));
  EXPECT(HdfFault(file), "a file where no directory is");
  CHECK(HdfGroup(file, "/series")); /* it takes everything and keeps nothing */
  CHECK(HdfClose(&file, fault));
  EXPECT(strstr(fault, "No such file"), "%s", fault);
  RemoveFile(path);
}

/* The line that a lock is refused in by another process; "": it is given. */
static void OtherTakes(const char *path, char line[256]) {
  int ends[2], status;
  ssize_t n;
  pid_t child;

  assert_int_equal(pipe(ends), 0);
  child = fork();
  if (!child) {
    ErrorState errors;
    if (!ErrorsBegin(PETSC_COMM_SELF, PETSC_TRUE, &errors))
      (void)LockTake(PETSC_COMM_SELF, "-output", path);
    _exit(write(ends[1], errors.message, strlen(errors.message) + 1) < 0);
  }
  close(ends[1]);
  n = read(ends[0], line, 255);
  line[n > 0 ? n : 0] = 0;
  close(ends[0]);
  assert_true(waitpid(child, &status, 0) == child);
}

static void TestLock(void **state) {
  char path[64], line[256], name[72], who[32];

  OpenScratch(path);
  snprintf(name, sizeof(name), "%s.lock", path);
  snprintf(who, sizeof(who), "process %ld on ", (long)getpid());
  CHECK(LockTake(PETSC_COMM_SELF, "-output", path));
  CHECK(LockTake(PETSC_COMM_SELF, "-output", path)); /* what is ours may be taken again */
  EXPECT(!access(name, F_OK), "no lock beside it");
  OtherTakes(path, line);
  EXPECT(strstr(line, who) && strstr(line, path), "%s, not %s", line, who);
  CHECK(LockGive(path));
  EXPECT(access(name, F_OK), "the lock is left");
  OtherTakes(path, line);
  EXPECT(!line[0], "%s", line);
  OtherTakes(path, line); /* that one ended without giving it */
  EXPECT(!line[0], "%s", line);
  CHECK(LockTake(PETSC_COMM_SELF, "-output", path));
  LocksEnd();
  EXPECT(access(name, F_OK), "the lock is left at the end");
  RemoveFile(path);
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestRows), cmocka_unit_test(TestWhole),
                                          cmocka_unit_test(TestLock)};
MAIN(tests)
