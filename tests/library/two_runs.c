/* The library as a host program sees it, which links libtendril alone: simulations side by side are
   each as if it were alone, errors are codes with a sentence, laws are functions, what is saved
   goes on to the last digit. On several ranks one simulation is of all of them, another of each.

     two_runs DIRECTORY */
#include <tendril.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static int failures;

static void Expect(int good, const char *what, Tendril sim) {
  if (good) return;
  failures++;
  fprintf(stderr, "not so: %s (%s)\n", what, TendrilMessage(sim));
}

/* A rod that bends while it grows, and in contact with itself or not. */
static void Describe(Tendril sim, const char *mu) {
  static const char *const options[][2] = {{"growth_initial_length", "2"},
                                           {"shape_amplitude", "0.1"},
                                           {"rod_cells", "40"},
                                           {"-ts_max_time", "0.3"}};

  for (int k = 0; k < 4; k++)
    Expect(!TendrilSet(sim, options[k][0], options[k][1]), options[k][0], sim);
  Expect(!TendrilSet(sim, "friction_mu", mu), "friction_mu", sim);
}

static Tendril New(MPI_Comm comm, const char *mu) {
  Tendril sim;

  Expect(!TendrilCreate(comm, &sim), "created", sim);
  Describe(sim, mu);
  return sim;
}

/* Are the series of two simulations the same, to the last digit? Errors that were followed on
   several ranks, and saved, are but for rounding: their parts are summed on one. */
static int Same(Tendril a, Tendril b) {
  const double *x, *y;
  const char *name;
  int n, m;

  for (int k = 0; (name = TendrilSeriesName(a, k)); k++) {
    if (TendrilSeries(a, name, &n, &x) || TendrilSeries(b, name, &m, &y) || n != m || n < 10)
      return 0;
    for (int i = 0; i < n; i++)
      if (x[i] != y[i] && (strncmp(name, "error_", 6) != 0 || fabs(x[i] - y[i]) > 1e-7)) return 0;
  }
  return 1;
}

/* Two by turns, and each alone. */
static void TestSideBySide(MPI_Comm comm) {
  Tendril one = New(comm, "0.5"), other = New(MPI_COMM_SELF, "1"), alone[2];
  double t = 0;
  int going[2] = {1, 1};

  while (going[0] || going[1]) {
    if (going[0]) going[0] = !TendrilStep(one, &t);
    if (going[1]) going[1] = !TendrilStep(other, NULL);
  }
  Expect(t == 0.3 && TendrilStep(one, NULL) == TENDRIL_ENDED, "it ends at its end", one);
  alone[0] = New(comm, "0.5");
  Expect(TendrilAdvance(alone[0], 1) == TENDRIL_ENDED, "the end is before 1", alone[0]);
  alone[1] = New(MPI_COMM_SELF, "1");
  for (int k = 1; k <= 7; k++) Expect(!TendrilAdvance(alone[1], 0.3 * k / 7), "on", alone[1]);
  Expect(Same(one, alone[0]), "one by turns is as alone", one);
  Expect(Same(other, alone[1]), "the other by turns is as alone, looked at on the way", other);
  for (int k = 0; k < 2; k++) TendrilDestroy(&alone[k]);
  TendrilDestroy(&one);
  TendrilDestroy(&other);
  Expect(!one, "destroyed", one);
}

/* A mistake is a code and a sentence, and can be put right; another simulation does not notice. */
static void TestErrors(MPI_Comm comm) {
  Tendril sim = New(comm, "0.5"), other = New(comm, "0.5");
  const double *values;
  const TendrilNode *nodes;
  int n;

  Expect(TendrilSet(sim, "friction_mux", "1") == TENDRIL_USER &&
             strstr(TendrilMessage(sim), "friction_mu?"),
         "an unknown option", sim);
  Expect(TendrilSet(sim, "output", "x.h5") == TENDRIL_USER &&
             strstr(TendrilMessage(sim), "TendrilSave"),
         "an option of the program", sim);
  Expect(TendrilNodes(sim, 0, &n, &nodes) == TENDRIL_USER, "nodes before the set-up", sim);
  Expect(!TendrilSet(sim, "friction_mu", "2"), "it is looked at later", sim);
  Expect(TendrilSetUp(sim) == TENDRIL_USER && strstr(TendrilMessage(sim), "too large"),
         "a value out of range", sim);
  Expect(!TendrilSet(sim, "friction_mu", "0.5"), "put right", sim);
  Expect(!TendrilStep(other, NULL), "the other one steps", other);
  Expect(!TendrilSetUp(sim), "set up", sim);
  Expect(TendrilSetUp(sim) == TENDRIL_USER, "but once", sim);
  Expect(TendrilSet(sim, "rod_cells", "50") == TENDRIL_USER &&
             strstr(TendrilMessage(sim), "cannot be changed"),
         "what cannot change", sim);
  Expect(TendrilSeries(sim, "no_such", &n, &values) == TENDRIL_USER, "no such series", sim);
  Expect(TendrilNodes(sim, 1, &n, &nodes) == TENDRIL_USER, "no such rod", sim);
  Expect(TendrilLoad(other, "no-such-file.h5") == TENDRIL_USER, "no such file", other);
  Expect(!TendrilStep(sim, NULL) && !TendrilMessage(sim)[0], "and it goes on", sim);
  TendrilDestroy(&sim);
  TendrilDestroy(&other);
}

typedef struct {
  double mu, beta;
  int calls, fails_after;
} Law;

/* The built-in law. */
static int Phi(void *ctx, const TendrilPlace *at, double value[]) {
  Law *law = (Law *)ctx;
  const double r2 = at->speed2 + law->beta;

  value[0] = 1 - law->mu + law->mu / sqrt(r2);
  value[1] = -law->mu / 2 / (r2 * sqrt(r2));
  return law->calls++ >= law->fails_after ? 7 : 0;
}

static int Uniform(void *ctx, const TendrilPlace *at, double value[]) {
  const double L = 2 + at->t;

  value[0] = L;
  value[1] = 1;
  value[2] = 0;
  value[3] = at->s * L;
  value[4] = at->s;
  return 0;
}

static int Bent(void *ctx, const TendrilPlace *at, double value[]) {
  for (int k = 0; k < 6; k++) value[k] = 0;
  value[0] = *(double *)ctx;
  return 0;
}

static double Last(Tendril sim, const char *name) {
  const double *values;
  int n;

  return TendrilSeries(sim, name, &n, &values) || !n ? NAN : values[n - 1];
}

/* A law of one's own that says what the built-in one says gives the same. */
static void TestLaws(MPI_Comm comm) {
  Law law = {0.5, 1e-3, 0, 1 << 30}, late = {0.5, 1e-3, 0, 20000};
  double k0 = 0.3, near = 1e-5;
  Tendril built = New(comm, "0.5"), own = New(comm, "0"), fails = New(comm, "0"), all[2];

  Expect(!TendrilSetLaw(own, "friction", Phi, &law), "friction", own);
  Expect(TendrilAdvance(built, 0.3) == 0 && TendrilAdvance(own, 0.3) == 0, "both run", own);
  Expect(law.calls > 1000 && fabs(Last(own, "tip_x2") / Last(built, "tip_x2") - 1) < near &&
             fabs(Last(own, "dissipation") / Last(built, "dissipation") - 1) < near,
         "friction of one's own", own);
  Expect(!TendrilSetLaw(fails, "friction", Phi, &late), "friction", fails);
  Expect(TendrilAdvance(fails, 0.3) == TENDRIL_LAW && strstr(TendrilMessage(fails), "7"),
         "a law that fails", fails);
  Expect(TendrilSetLaw(own, "gravity", Phi, &law) == TENDRIL_USER, "no such law", own);
  for (int k = 0; k < 2; k++) {
    Expect(!TendrilCreate(comm, &all[k]), "created", all[k]);
    Expect(!TendrilSet(all[k], "rod_cells", "40") && !TendrilSet(all[k], "ts_max_time", "0.2"),
           "options", all[k]);
  }
  Expect(!TendrilSetLaw(all[0], "growth", Uniform, NULL), "growth", all[0]);
  Expect(!TendrilSetLaw(all[0], "curvature", Bent, &k0), "curvature", all[0]);
  Expect(!TendrilSet(all[1], "growth_initial_length", "2") &&
             !TendrilSet(all[1], "rod_curvature", "0.3"),
         "the same", all[1]);
  for (int k = 0; k < 2; k++) Expect(!TendrilAdvance(all[k], 0.2), "runs", all[k]);
  Expect(Same(all[0], all[1]), "growth and curvature of one's own, to the last digit", all[0]);
  for (int k = 0; k < 2; k++) TendrilDestroy(&all[k]);
  TendrilDestroy(&built);
  TendrilDestroy(&own);
  TendrilDestroy(&fails);
}

/* What is saved goes on to the last digit, from a stored time nearly so; saving changes nothing. */
static void TestSave(MPI_Comm comm, const char *directory, int rank) {
  char file[2][512];
  Tendril sim = New(comm, "0.5"), on, earlier;
  double t = 0;

  for (int k = 0; k < 2; k++)
    (void)snprintf(file[k], sizeof(file[k]), "%s/saved-%d.h5", directory, k);
  Expect(!TendrilSet(sim, "output_shapes", "3"), "shapes", sim);
  while (t < 0.15) Expect(!TendrilStep(sim, &t), "a step", sim);
  Expect(!TendrilSave(sim, file[0]), "saved", sim);
  Expect(!TendrilSaveAt(sim, 0.1, file[1]), "saved as of a stored time", sim);
  Expect(TendrilSaveAt(sim, 0.11, file[1]) == TENDRIL_USER, "none that is stored", sim);
  Expect(!TendrilCreate(comm, &on) && !TendrilLoad(on, file[0]), "loaded", on);
  Expect(!TendrilCreate(comm, &earlier) && !TendrilLoad(earlier, file[1]), "loaded", earlier);
  Expect(!TendrilTime(on, &t) && t == Last(sim, "t"), "it is where it was", on);
  Expect(!TendrilTime(earlier, &t) && fabs(t - 0.1) < 1e-12, "it is where it was then", earlier);
  Expect(!TendrilAdvance(sim, 0.3) && !TendrilAdvance(on, 0.3) && !TendrilAdvance(earlier, 0.3),
         "they go on", on);
  Expect(Same(sim, on), "as if it had not been saved", on);
  Expect(fabs(Last(earlier, "tip_x2") / Last(sim, "tip_x2") - 1) < 1e-4, "nearly so", earlier);
  TendrilDestroy(&sim);
  TendrilDestroy(&on);
  TendrilDestroy(&earlier);
  for (int k = 0; k < 2 && !rank; k++) (void)remove(file[k]);
}

/* A tip that is pushed from now on. */
static void TestChange(MPI_Comm comm) {
  Tendril sim = New(comm, "0.5");
  double t;

  Expect(!TendrilAdvance(sim, 0.1), "on", sim);
  Expect(TendrilSet(sim, "tip_force", "much") == TENDRIL_USER, "no number", sim);
  Expect(!TendrilSet(sim, "tip_force", "0.25"), "changed", sim);
  Expect(!TendrilTime(sim, &t) && t == 0.1, "there", sim);
  Expect(!TendrilStep(sim, NULL) && fabs(Last(sim, "tip_force_1") + 0.25) < 1e-9, "felt", sim);
  Expect(!TendrilAdvance(sim, 0.3) && Last(sim, "energy_defect") < 1e-4, "energy balances", sim);
  TendrilDestroy(&sim);
}

int main(int argc, char **argv) {
  int rank, ranks, all, host = argc > 2;
  Tendril first;

  if (host) MPI_Init(&argc, &argv);
  Expect(!TendrilCreate(host ? MPI_COMM_WORLD : MPI_COMM_SELF, &first), "the first", first);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  TestSideBySide(MPI_COMM_WORLD);
  TestErrors(MPI_COMM_WORLD);
  TestLaws(MPI_COMM_WORLD);
  TestSave(MPI_COMM_WORLD, argv[1], rank);
  TestChange(MPI_COMM_WORLD);
  TendrilDestroy(&first);
  MPI_Allreduce(&failures, &all, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
  if (!rank) printf("%d failure(s) on %d rank(s)\n", all, ranks);
  if (host) MPI_Finalize();
  return all != 0;
}
