/* What a run remembers. Each number is one row here: it is then a field of the struct, in every
   restart by its name, and 0 where a file has none of that name. All are reals, counts and verdicts
   too. */
#ifndef TENDRIL_REMEMBERED_H
#define TENDRIL_REMEMBERED_H

#include "base/hdf.h"
#include "record/observe.h"
#include "stepping/estimate.h"
#include "stepping/vbdf.h"

/* The largest error of its kind beyond the start, when it was, and why. */
typedef struct {
  PetscReal error, at, why;
} WorstError;

/* X(type, name, [how many], what it is): of the run, besides its stepper. */
#define REMEMBERED(X)                                                                              \
  X(PetscReal, folds, , "of |x2|, up and down, so far")                                            \
  X(PetscReal, neglected, , "largest part that the linear model left out")                         \
  X(PetscReal, snaps, , "of this run, and of what it goes on with")                                \
  X(PetscReal, crossings, , "of these, its start was crossed by")                                  \
  X(PetscReal, crossed, , "what steps that cross its start have changed, see GrowCross()")         \
  X(PetscReal, vanished, , "|x2| has fallen below the numbers that there are")                     \
  X(PetscReal, depth, , "largest penetration so far")                                              \
  X(PetscReal, energy_folds, , "of the energy of the linear model, up and down")                   \
  X(PetscReal, weighed, , "the folds, by what they weigh in its energy")                           \
  X(PetscReal, gave_way, , "its start did, at once: a jump in that layer")                         \
  X(PetscReal, pressed, , "there has been contact")                                                \
  X(PetscReal, blind, , "steps that have crossed a mode that grows (LegCrosses())")                \
  X(PetscReal, layered, , "steps have crossed the layer of its start")                             \
  X(PetscReal, event_at, , "when it last touched, let go or snapped; 0: never")                    \
  X(PetscReal, event_is, , "which, as WHY_TOUCH")                                                  \
  X(WorstError, worst, [ESTIMATE_SEEN], "errors that are followed")                                \
  X(PetscReal, off, , "largest distance at which it was held off, pressed in nowhere")             \
  X(PetscReal, crawl_way, , "of its Crawl")                                                        \
  X(PetscReal, crawl_half, , "likewise")                                                           \
  X(PetscReal, crawl_steps, , "likewise")                                                          \
  X(PetscReal, crawl_at, , "likewise")                                                             \
  X(PetscReal, slips_at, , "the way when it last got on, though it slips: see grow_jam.c")         \
  X(PetscReal, slips_steps, , "and steps since")                                                   \
  X(PetscReal, window, , "the way when it last got on: see grow_jam.c")                            \
  X(PetscReal, window_steps, , "and steps since")                                                  \
  X(PetscReal, way, , "how far the run has come, in time and as the rod has moved")                \
  X(Astray, astray, , "where it may have gone to another side")                                    \
  X(PetscReal, changed, , "something has been, since the latest step; -1: a file does not say")    \
  X(Observation, began, , "where steps began to cross the layer of its start")

enum { RESTART_KICKS = 13 }; /* of the fields of the mechanics */

/* ... of its stepper, and of what its laws have become. */
#define REMEMBERED_BY_STEPS(X)                                                                     \
  X(PetscReal, t, , "where the run is")                                                            \
  X(PetscReal, step, , "size of its next step")                                                    \
  X(PetscReal, points, , "of the stepper's history")                                               \
  X(PetscReal, order, , "its next order")                                                          \
  X(PetscReal, model, , "as the series `model` has it")                                            \
  X(PetscReal, fields, , "of a node of that")                                                      \
  X(PetscReal, steps, , "so far")                                                                  \
  X(PetscReal, memory, [VBDF_MEMORY], "of the stepper, beside its points")                         \
  X(PetscReal, wants, , "of the leg: its Ease")                                                    \
  X(PetscReal, ease, , "likewise")                                                                 \
  X(PetscReal, others, , "likewise")                                                               \
  X(PetscReal, kick, [RESTART_KICKS], "what a wall's kick is measured against")                    \
  X(PetscReal, kick_ends, , "until when")                                                          \
  X(PetscReal, counted, [2], "so far: Newton iterations, rejected tries of steps")                 \
  X(PetscReal, errors, [ESTIMATE_PARTS][ESTIMATE_SEEN], "followed so far")                         \
  X(PetscReal, following, [ESTIMATE_MEMORY], "how they are followed on")                           \
  X(PetscReal, follows, , "are they?")                                                             \
  X(PetscReal, errors_sum, , "as sum, of /restart/errors")                                         \
  X(PetscReal, time, [VBDF_POINTS], "of the points, since t")                                      \
  X(PetscReal, balance, [BALANCE_STATE], "of the energy balance")                                  \
  X(PetscReal, sum, , "of the absolute values of /restart/points: a torn file shows")              \
  X(SceneMemory, laws, , "what laws have become")                                                  \
  X(Observation, seen, , "at t")

#define X(type, name, many, text) type name many;
typedef struct {
  REMEMBERED(X)
} Remembered;
typedef struct {
  REMEMBERED_BY_STEPS(X)
  Remembered kept;
} RestartState;
#undef X
enum { RESTART_STATE = sizeof(RestartState) / sizeof(PetscReal) };

PetscErrorCode RememberedWrite(HdfFile file, const RestartState *state);
PetscErrorCode RememberedRead(const char *file, MPI_Comm comm, RestartState *state);
PetscErrorCode RememberedWriteEach(HdfFile file, PetscInt n, const RestartState state[]);
PetscErrorCode RememberedReadEach(const char *file, MPI_Comm comm, PetscInt n,
                                  RestartState state[]);

#endif
