/* A program of a user's own, with the installed library: grows a rod, pushes on its tip half-way,
   and reads off where that is. */
#include <stdio.h>
#include <tendril.h>

static int Grow(Tendril rod) {
  const TendrilNode *nodes;
  const double *force;
  int n, failed = 0;

  failed = failed || TendrilSet(rod, "growth_initial_length", "2");
  failed = failed || TendrilSet(rod, "shape_amplitude", "0.1");
  failed = failed || TendrilSet(rod, "ts_max_time", "1");
  failed = failed || TendrilAdvance(rod, 0.5);
  failed = failed || TendrilSet(rod, "tip_force", "0.1"); /* from here on */
  failed = failed || TendrilAdvance(rod, 1);
  failed = failed || TendrilNodes(rod, 0, &n, &nodes);
  if (!failed) printf("tip (%.4f, %.4f)\n", nodes[n - 1].x[0], nodes[n - 1].x[1]);
  failed = failed || TendrilSeries(rod, "base_force_1", &n, &force);
  if (!failed) printf("%d steps, %.4f on the clamp\n", n - 1, force[n - 1]);
  return failed;
}

int main(void) {
  Tendril rod;
  int failed = TendrilCreate(MPI_COMM_SELF, &rod) || Grow(rod);

  if (failed) fprintf(stderr, "%s\n", TendrilMessage(rod));
  TendrilDestroy(&rod);
  return failed;
}
