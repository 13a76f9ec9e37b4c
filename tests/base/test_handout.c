/* Jobs handed out to teams: each is done once, whoever is slow; all ends in good order.
   test: each job is done once whoever is slow | ranks 1 2 3 */
#include "harness.h"
#include "base/handout.h"
#include "base/signals.h"
#include <signal.h>

enum { JOBS = 200, FIRST = 7 };

/* What rank 0 has been handed. */
typedef struct {
  int done[JOBS], by_others, ticks;
} Account;

typedef struct {
  PetscInt job, rank;
  char more[70000]; /* longer than what MPI sends at once */
} Result;

static PetscErrorCode Take(void *ctx, size_t bytes, const void *result) {
  const Result *got = (const Result *)result;
  Account *self = (Account *)ctx;

  PetscFunctionBegin;
  assert_int_equal(bytes, sizeof(*got));
  assert_true(got->job >= FIRST && got->job < FIRST + JOBS);
  assert_int_equal(got->more[sizeof(got->more) - 1], got->job % 100);
  self->done[got->job - FIRST]++;
  self->by_others += got->rank > 0;
  PetscFunctionReturn(0);
}

static PetscErrorCode Tick(void *ctx) {
  PetscFunctionBegin;
  ((Account *)ctx)->ticks++;
  PetscFunctionReturn(0);
}

/* A job of some milliseconds; every seventh takes longer. Returns whether it came to its end. */
static PetscBool Work(Handout handout, PetscInt job) {
  PetscBool stop = PETSC_FALSE;

  for (int k = 0; k < (job % 7 ? 2 : 10) && !stop; k++) {
    usleep(200);
    CHECK(HandoutMeanwhile(handout, &stop));
  }
  return (PetscBool)!stop;
}

/* Does jobs until there are none, or one of them is last; returns how many this team has done. */
static int WorkOn(Handout handout, PetscInt last) {
  static Result result;
  PetscInt job;
  PetscMPIInt rank;
  int n = 0;

  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  for (;;) {
    CHECK(HandoutNext(handout, &job));
    if (job < 0) break;
    if (job == last) CHECK(HandoutStop(handout));
    if (!Work(handout, job)) continue;
    result.job = job;
    result.rank = rank;
    result.more[sizeof(result.more) - 1] = (char)(job % 100);
    CHECK(HandoutReturn(handout, sizeof(result), &result));
    n++;
  }
  return n;
}

static void Begin(PetscInt each, PetscInt n, Account *account, Handout *handout) {
  PetscInt jobs[JOBS];

  memset(account, 0, sizeof(*account));
  for (PetscInt k = 0; k < n; k++) jobs[k] = FIRST + k;
  CHECK(HandoutCreate(PETSC_COMM_WORLD, each, n, jobs, Take, Tick, account, handout));
}

/* Is what rank 0 counts, as told to all, as it should be? */
static int Count(const Account *account, int *most) {
  int n = 0;

  *most = 0;
  for (int k = 0; k < JOBS; k++) {
    n += account->done[k];
    *most = PetscMax(*most, account->done[k]);
  }
  MPI_Bcast(&n, 1, MPI_INT, 0, PETSC_COMM_WORLD);
  MPI_Bcast(most, 1, MPI_INT, 0, PETSC_COMM_WORLD);
  return n;
}

static void TestAllAreDoneOnce(void **state) {
  const int numbers[] = {0, 1, 2, 3, 5, JOBS};
  Account account;
  PetscMPIInt rank, ranks;
  Handout handout;

  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  for (int i = 0; i < 6; i++) {
    int most, n, mine;
    Begin(1, numbers[i], &account, &handout);
    mine = WorkOn(handout, -1);
    CHECK(HandoutEnd(&handout));
    n = Count(&account, &most);
    EXPECT(n == numbers[i] && most <= 1, "%d of %d done, one %d times", n, numbers[i], most);
    EXPECT(!rank || numbers[i] < ranks || mine > 0, "no job on rank %d", (int)rank);
    EXPECT(rank || account.by_others == n - mine, "%d by others", account.by_others);
    EXPECT(rank || numbers[i] < JOBS || account.ticks > mine, "%d ticks", account.ticks);
  }
}

/* A team of all ranks does each job together. */
static void TestTeam(void **state) {
  Account account;
  PetscMPIInt ranks, team;
  Handout handout;
  int most, n, mine, all;

  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  Begin(ranks, 40, &account, &handout);
  MPI_Comm_size(HandoutTeam(handout), &team);
  mine = WorkOn(handout, -1);
  CHECK(HandoutEnd(&handout));
  n = Count(&account, &most);
  EXPECT(team == ranks, "a team of %d", (int)team);
  EXPECT(n == 40 && most == 1, "%d done, one %d times", n, most);
  MPI_Allreduce(&mine, &all, 1, MPI_INT, MPI_MIN, PETSC_COMM_WORLD);
  EXPECT(all == 40, "one rank has seen %d", all);
}

/* Whoever ends it, all end; nothing is done twice, and not much more than was under way. */
static void TestStop(void **state) {
  Account account;
  Handout handout;
  int most, n;

  Begin(1, JOBS, &account, &handout);
  (void)WorkOn(handout, FIRST + 50);
  CHECK(HandoutEnd(&handout));
  n = Count(&account, &most);
  EXPECT(most == 1 && n > 30 && n < JOBS - 50, "%d done, one %d times", n, most);
}

/* A signal that reaches the last rank only. */
static void TestSignal(void **state) {
  Account account;
  PetscMPIInt rank, ranks;
  Handout handout;
  int most, n;

  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  SignalsCatch();
  if (rank == ranks - 1) raise(SIGTERM);
  Begin(1, JOBS, &account, &handout);
  (void)WorkOn(handout, -1);
  CHECK(HandoutEnd(&handout));
  EXPECT((SignalCaught() == SIGTERM) == (rank == ranks - 1), "signal %d", SignalCaught());
  SignalsCatch(); /* forgets it */
  n = Count(&account, &most);
  EXPECT(most <= 1 && n < JOBS - 50, "%d done", n);
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestAllAreDoneOnce),
                                          cmocka_unit_test(TestTeam), cmocka_unit_test(TestStop),
                                          cmocka_unit_test(TestSignal)};

MAIN(tests)
