/* Points of the rod are its nodes and the middles of its cells, in turn: node i is 2 i, the middle
   behind it 2 i + 1. A force at any place is handed to the four points around it, by the cubic
   convolution kernel (Keys, IEEE Trans. Acoust. 29, 1981). It keeps the force, its moment and the
   next moment, and goes over smoothly as the place moves along; at the ends of the rod the missing
   point is that of the parabola through its neighbours. */
#ifndef TENDRIL_SPREAD_H
#define TENDRIL_SPREAD_H

#include <petscsys.h>

typedef struct {
  PetscInt point[4];
  PetscReal share[4], share_z[4]; /* and by z */
} Spread;

/* SpreadAt - who takes what acts at place z of a cell, of a rod of so many points. */
static inline void SpreadAt(PetscInt points, PetscInt cell, PetscReal z, Spread *spread) {
  PetscInt j = 2 * cell + PetscMin((PetscInt)(2 * z), 1);
  PetscReal u = 2 * cell + 2 * z - j, *a = spread->share, *b = spread->share_z;
  const PetscReal value[4] = {(-u + 2 * u * u - u * u * u) / 2, (2 - 5 * u * u + 3 * u * u * u) / 2,
                              (u + 4 * u * u - 3 * u * u * u) / 2, (-u * u + u * u * u) / 2},
                  slope[4] = {-1 + 4 * u - 3 * u * u, -10 * u + 9 * u * u, 1 + 8 * u - 9 * u * u,
                              -2 * u + 3 * u * u};
  int missing = j == 0 ? 0 : j == points - 2 ? 3 : -1;

  for (int k = 0; k < 4; k++) {
    spread->point[k] = j - 1 + k;
    a[k] = value[k];
    b[k] = slope[k];
  }
  if (missing < 0) return;
  for (int k = 1; k <= 3; k++) {
    const PetscReal part = k == 1 ? 3 : k == 2 ? -3 : 1;
    int to = missing ? 3 - k : k;
    a[to] += part * value[missing];
    b[to] += part * slope[missing];
  }
  a[missing] = b[missing] = 0;
  spread->point[missing] = j;
}

/*
  SpreadEvenly - the same for what acts all along the rod, from place to place. The collocation
  counts a middle as four times either end of its cell (Simpson), but by the kernel every point is
  handed as much as the others: an even load would come out as 3/2 of itself at nodes, and as 3/4
  between them. Third differences of what is handed to four points change neither force nor moments:
    b(u) (-1, 3, -3, 1),    b = -+5/4 u^2 (1 - u)^2 behind a node and behind a middle,
  leave in the mean a third to each node, two thirds to each middle.
*/
static inline void SpreadEvenly(PetscInt points, PetscInt cell, PetscReal z, Spread *spread) {
  static const PetscReal third[4] = {-1, 3, -3, 1};
  const PetscInt j = 2 * cell + PetscMin((PetscInt)(2 * z), 1);
  const PetscReal u = 2 * cell + 2 * z - j, all = j % 2 ? 1.25 : -1.25,
                  b = all * u * u * (1 - u) * (1 - u), slope = all * 4 * u * (1 - u) * (1 - 2 * u);

  SpreadAt(points, cell, z, spread);
  if (j == 0 || j == points - 2) return; /* (the missing point's parabola takes it up) */
  for (int k = 0; k < 4; k++) {
    spread->share[k] += b * third[k];
    spread->share_z[k] += slope * third[k];
  }
}

#endif
