/* What is measured on a rod after each step: norms, energies, distances, e-foldings. */
#ifndef TENDRIL_OBSERVE_H
#define TENDRIL_OBSERVE_H

#include "record/touching.h"
#include "stepping/leg.h"

/* X(name, units, description): the series of the result file, in this order. */
#define OBSERVABLES(X)                                                                             \
  X(t, "l/V", "time")                                                                              \
  X(length, "l", "length of the rod, L(t)")                                                        \
  X(tip_x1, "l", "x1 at s = 1")                                                                    \
  X(tip_x2, "l", "x2 at s = 1")                                                                    \
  X(norm_x2, "l", "sqrt(int x2^2 ds)")                                                             \
  X(norm_x2_length, "l^(3/2)", "sqrt(int x2^2 g ds)")                                              \
  X(max_angle, "rad", "largest |theta| against the clamp, radians")                                \
  X(energy, "N l^2", "energy of bending and twist, 1/2 int m^2/B g ds")                            \
  X(growth_power, "N l V", "power of growth W")                                                    \
  X(dissipation, "N l V", "power lost to friction along the rod, int g F.v ds, and in contact")    \
  X(energy_defect, "1",                                                                            \
    "|E - E(0) - int (all powers - dissipation)| over the largest of friction's work, E and E(0)") \
  X(end_distance, "l", "|x(1) - x(0)|")                                                            \
  X(mid_distance, "l", "|x(1/2) - x(0)|")                                                          \
  X(width, "l", "extent of the shape across the direction of the clamp")                           \
  X(tip_speed, "V", "|v| at s = 1")                                                                \
  X(mid_speed, "V", "|v| at s = 1/2")                                                              \
  X(base_force_1, "N l", "force of the clamp on the rod along x1, -n1(0)")                         \
  X(base_force_2, "N l", "force of the clamp on the rod along x2, -n2(0)")                         \
  X(feed_force, "N l", "force against which the rod is fed at the clamp, -n.q - m^2/2B - m k0")    \
  X(tip_force_1, "N l", "force on the tip along x1, n1(1), but for contact")                       \
  X(tip_force_2, "N l", "force on the tip along x2, n2(1), but for contact")                       \
  X(tip_power, "N l V", "power of the force on the tip, n(1).v(1), but for contact")               \
  X(contact_force, "N l", "sum of the normal forces of contact")                                   \
  X(wall_force_1, "N l", "force of the walls on the rod along x1")                                 \
  X(wall_force_2, "N l", "force of the walls on the rod along x2")                                 \
  X(friction_force_1, "N l", "force of the friction along the rod on it along x1")                 \
  X(friction_force_2, "N l", "force of the friction along the rod on it along x2")                 \
  X(contact_energy, "N l^2", "energy of contact, int U ds")                                        \
  X(penetration, "l",                                                                              \
    "how deep the rod is in a wall or in itself, at most; below 0: what presses is so far off")    \
  X(contacts, "1", "zones of contact along the rod")                                               \
  X(inflections, "1", "sign changes of the curvature along the rod")                               \
  X(self_crossings, "1", "points in which the rod crosses itself")                                 \
  X(step, "l/V", "size of the step that led here")                                                 \
  X(newton_iterations, "1", "Newton iterations of that step, rejected tries included")             \
  X(model, "1", "model of that step: 0 linear, 1 frame, 2 mixed, 3 space")                         \
  X(error_tip, "1", "estimated error of the tip's place, over its distance from the clamp")        \
  X(error_norm_x2, "1", "estimated relative error of |x2|, in space of the larger of |x2|, |x3|")  \
  X(error_energy, "1", "estimated relative error of the energy")

/* Of a rod that weighs something, and of one in space. */
#define OBSERVABLES_OF_WEIGHT(X)                                                                   \
  X(weight_power, "N l V", "power of the rod's weight")                                            \
  X(weight_force_1, "N l", "weight of the rod along x1")                                           \
  X(weight_force_2, "N l", "weight of the rod along x2")
#define OBSERVABLES_IN_SPACE(X)                                                                    \
  X(tip_x3, "l", "x3 at s = 1")                                                                    \
  X(norm_x3, "l", "sqrt(int x3^2 ds)")                                                             \
  X(twist, "rad", "twist of the rod, int u1 g ds, natural and elastic")                            \
  X(writhe, "1", "turns by which the centre line writhes against the clamp's axis (Fuller)")       \
  X(link, "1", "turns of the tip against the clamp: twist / 2 pi + writhe")                        \
  X(energy_twist, "N l^2", "the part of twist in the energy, 1/2 int (m.d1)^2 / C g ds")           \
  X(base_force_3, "N l", "force of the clamp on the rod along x3, -n3(0)")                         \
  X(base_moment_1, "N l^2", "moment of the clamp on the rod about x1, -m1(0)")                     \
  X(base_moment_2, "N l^2", "moment of the clamp on the rod about x2, -m2(0)")                     \
  X(base_moment_3, "N l^2", "moment of the clamp on the rod about x3, -m3(0)")                     \
  X(tip_force_3, "N l", "force on the tip along x3, n3(1), but for contact")                       \
  X(wall_force_3, "N l", "force of the walls on the rod along x3")                                 \
  X(friction_force_3, "N l", "force of the friction along the rod on it along x3")                 \
  X(weight_force_3, "N l", "weight of the rod along x3")                                           \
  X(wall_power, "N l V", "power of walls that move, and of other rods")                            \
  X(tip_spin, "V/l", "rate at which the material at the tip turns about its tangent")              \
  X(clamp_power, "N l V", "power of the turning clamp")

/* Of one whose natural curvature is steered. */
#define OBSERVABLES_OF_STEERING(X)                                                                 \
  X(curvature_power, "N l V", "power of a natural curvature that changes over time")

/* Of one whose material learns its natural curvature. */
#define OBSERVABLES_OF_TROPISM(X)                                                                  \
  X(tip_angle, "rad", "angle of the tip against x1; in space against the clamp")                   \
  X(natural_angle, "rad", "natural bend about d3 along the rod, int u0 g ds")                      \
  X(natural_angle_2, "rad", "the same about d2, in space")                                         \
  X(natural_bend, "l^(-1/2)", "sqrt(int u0^2 g ds), of both bends")                                \
  X(tropism_power, "N l V", "power of the bend that the material learns against its load")         \
  X(ironing_power, "N l V", "the part of it by which moments are ironed out, lost")                \
  X(growth_rate, "V", "how fast the rod lengthens, L_t")

#define EVERY_OBSERVABLE(X)                                                                        \
  OBSERVABLES(X)                                                                                   \
  OBSERVABLES_OF_WEIGHT(X)                                                                         \
  OBSERVABLES_IN_SPACE(X)                                                                          \
  OBSERVABLES_OF_STEERING(X)                                                                       \
  OBSERVABLES_OF_TROPISM(X)

typedef struct {
#define X(name, units, text) PetscReal name;
  EVERY_OBSERVABLE(X)
#undef X
} Observation;

#define X(name, units, text) +1
enum {
  OBSERVED = sizeof(Observation) / sizeof(PetscReal),
  OBSERVED_ALWAYS = 0 OBSERVABLES(X),
  OBSERVED_OF_WEIGHT = 0 OBSERVABLES_OF_WEIGHT(X),
  OBSERVED_IN_SPACE = OBSERVED_ALWAYS + OBSERVED_OF_WEIGHT OBSERVABLES_IN_SPACE(X),
  OBSERVED_STEERED = OBSERVED_IN_SPACE OBSERVABLES_OF_STEERING(X)
};
#undef X
extern const char *const observed_name[OBSERVED], *const observed_units[OBSERVED],
                                                      *const observed_text[OBSERVED];

typedef struct _Observer *Observer;
enum { BALANCE_POINTS = 6, BALANCE_PARTS = 4, BALANCE_SUMS = 3 };
enum { BALANCE_STATE = BALANCE_PARTS * BALANCE_POINTS + BALANCE_SUMS + 1 };

PetscInt ObservedOf(Scene scene);
PetscBool ObservedIn(Scene scene, PetscInt observed);
PetscErrorCode ObservePlane(Scene scene, PetscReal t, PetscInt first, PetscInt end,
                            const Node *node, const PetscReal (*push)[PUSH], const PetscReal tip[],
                            PetscInt n, const TouchFeet *feet, PetscReal lift, Observation *seen);
PetscErrorCode ObserveSpace(Scene scene, PetscReal t, PetscInt first, PetscInt end,
                            const Node node[], const SampleLaw law[], const PetscReal (*push)[PUSH],
                            const PetscReal contact[PUSH], PetscInt n, const TouchFeet feet[],
                            Observation *seen);
PetscErrorCode ObserverCreate(Scene scene, Observer *observer);
PetscErrorCode ObserverDestroy(Observer *observer);
void ObserverAmong(Observer observer, TouchingTell tell, void *ctx, PetscInt rod);
PetscErrorCode ObserverGather(Observer observer, Rod rod, PetscReal t, Vec U, Vec U_t,
                              const Node **nodes);
PetscErrorCode ObserverContact(Observer observer, PetscReal t, const Node *nodes,
                               const PetscReal (**force)[PUSH]);
PetscErrorCode ObserverTouch(Observer observer, PetscReal t, const Node *nodes, TouchSum *sum);
PetscErrorCode ObserverLook(Observer observer, Rod rod, PetscReal t, Vec U, Observation *seen);
PetscErrorCode ObserverLookMoving(Observer observer, Rod rod, PetscReal t, Vec U, Vec U_t,
                                  Observation *seen);
PetscErrorCode ObserverMeasure(Observer observer, Rod rod, PetscReal t, Vec U, Vec U_t, Leg *leg,
                               Observation *seen);
void ObserverGetBalance(Observer observer, PetscReal state[BALANCE_STATE]);
void ObserverSetBalance(Observer observer, const PetscReal state[BALANCE_STATE]);
void ObserverClose(Observer observer, const Observation *last, PetscBool broken);

#endif
