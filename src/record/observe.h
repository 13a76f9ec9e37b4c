/* What is measured on a rod after each step: norms, energies, distances, folds. */
#ifndef TENDRIL_OBSERVE_H
#define TENDRIL_OBSERVE_H

#include "rod/rod.h"

/* X(name, description): the series of the result file, in this order. All dimensionless. */
#define OBSERVABLES(X)                                                                             \
  X(t, "time")                                                                                     \
  X(length, "length of the rod, L(t)")                                                             \
  X(tip_x1, "x1 at s = 1")                                                                         \
  X(tip_x2, "x2 at s = 1")                                                                         \
  X(norm_x2, "sqrt(int x2^2 ds)")                                                                  \
  X(norm_x2_length, "sqrt(int x2^2 g ds)")                                                         \
  X(max_angle, "largest |theta| against the clamp, radians")                                       \
  X(energy, "bending energy, 1/2 int m^2 g ds")                                                    \
  X(growth_power, "power of growth W")                                                             \
  X(dissipation, "power lost to friction, int g phi |v|^2 ds")                                     \
  X(energy_defect, "|E - E(0) - int (W - dissipation) dt| over the work of growth so far")         \
  X(end_distance, "|x(1) - x(0)|")                                                                 \
  X(mid_distance, "|x(1/2) - x(0)|")                                                               \
  X(width, "extent of the shape across the direction of the clamp")                                \
  X(tip_speed, "|v| at s = 1")                                                                     \
  X(mid_speed, "|v| at s = 1/2")                                                                   \
  X(base_force_1, "force of the clamp on the rod along x1, -n1(0)")                                \
  X(base_force_2, "force of the clamp on the rod along x2, -n2(0)")                                \
  X(inflections, "sign changes of the curvature along the rod")                                    \
  X(self_crossings, "points in which the rod crosses itself")                                      \
  X(step, "size of the step that led here")                                                        \
  X(newton_iterations, "Newton iterations of that step, rejected tries included")                  \
  X(model, "model of that step: 0 linear, 1 frame, 2 mixed")

typedef struct {
#define X(name, text) PetscReal name;
  OBSERVABLES(X)
#undef X
} Observation;

enum { OBSERVED = sizeof(Observation) / sizeof(PetscReal) };
extern const char *const observed_name[OBSERVED], *const observed_text[OBSERVED];

typedef struct _Observer *Observer;
enum { BALANCE_POINTS = 5, BALANCE_STATE = 3 * BALANCE_POINTS + 4 };

PetscErrorCode ObserverCreate(Scene scene, Observer *observer);
PetscErrorCode ObserverDestroy(Observer *observer);
PetscErrorCode ObserverGather(Observer observer, Rod rod, PetscReal t, Vec U, Vec U_t,
                              const Node **nodes);
PetscErrorCode ObserverMeasure(Observer observer, Rod rod, PetscReal t, Vec U, Vec U_t,
                               Observation *seen);
PetscErrorCode ObserverGetBalance(Observer observer, PetscReal state[BALANCE_STATE]);
PetscErrorCode ObserverSetBalance(Observer observer, const PetscReal state[BALANCE_STATE]);
void ObserverJump(Observer observer);
PetscInt ObserveCrossings(PetscInt n, const Node *nodes);

#endif
