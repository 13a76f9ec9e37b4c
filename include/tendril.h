/*
  tendril.h - the slow growth of an elastic fibre that friction holds back, as a library.

  A simulation is created, given options by their names, set up, and taken on step by step; its
  nodes and series can be read at any time. Any number of simulations live side by side in a
  process, each with its own options, errors and ranks; nothing is shared but PETSc itself.
  docs/library.md has an example; docs/options.md all options; all quantities are in the units of
  docs/theory/README.md unless an option carries one.

  Every function returns 0 (TENDRIL_OK) or one of the codes below, and keeps a sentence for
  TendrilMessage(). None of them ends the program. Calls are collective on the simulation's ranks;
  TendrilTime(), TendrilSeries(), TendrilRods(), names and TendrilMessage() are not. Different
  simulations may be called in any order, but not from two threads at a time: PETSc does not allow
  it.
*/
#ifndef TENDRIL_H
#define TENDRIL_H

#include <mpi.h>

#ifdef __GNUC__
#define TENDRIL_API __attribute__((visibility("default")))
#else
#define TENDRIL_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* One system of rods. */
typedef struct Tendril_ *Tendril;

/* What a call returns. */
enum {
  TENDRIL_OK = 0,
  TENDRIL_ENDED = 1, /* the run is at its end (-ts_max_time, or an event): nothing was done */
  TENDRIL_WATCH = 2, /* the watch said stop; the run can go on */
  TENDRIL_USER = 3,  /* what was asked for cannot be, and has changed nothing */
  TENDRIL_RUN = 4,   /* the run has given up; what it has found can be read and saved */
  TENDRIL_LAW = 5,   /* a law of one's own has returned something other than 0 */
  TENDRIL_PETSC = 6  /* an error of PETSc, or of memory: only TendrilDestroy() is left */
};

/* A node, in the laboratory. In the plane x3 = 0 and d3 = e3; vectors have their third component 0
   but for curvature and moment, which have only that one. */
typedef struct {
  double s;       /* material label: 0 at the clamp, 1 at the tip */
  double stretch; /* g = |dx/ds| */
  double theta;   /* angle of the tangent: in the plane from e1; in space from the clamp's axis */
  double x[3];    /* position */
  double v[3];    /* velocity of the material there */
  double d[3][3]; /* directors: tangent, and two across */
  double curvature[3]; /* twist about d1, bends about d2 and d3, natural ones included */
  double moment[3];    /* internal moment m */
  double force[3];     /* internal force n */
  double contact[3];   /* force of contact on the rod per length, without friction */
} TendrilNode;

/* Where a law of one's own is asked for. */
typedef struct {
  double s, t;   /* label and time, of growth and curvature */
  double speed2; /* |v|^2, of friction */
} TendrilPlace;

/* A law of one's own: fills value, see TendrilSetLaw(). Returns 0 if all is well; anything else
   ends the step with TENDRIL_LAW. It is called many times a step, on every rank, and must give the
   same for the same place. */
typedef int (*TendrilLaw)(void *ctx, const TendrilPlace *at, double value[]);

/* Is called after every accepted step of TendrilAdvance(); anything but 0 stops there. */
typedef int (*TendrilWatch)(void *ctx, Tendril simulation);

/*
  TendrilCreate - a simulation. Collective on comm; the caller ends it with TendrilDestroy().

  comm        the ranks that share it; it is duplicated. MPI_COMM_SELF: this process alone
  simulation  is set also after an error, for TendrilMessage()

  The first one begins MPI, PETSc and SLEPc, if the host has not; what it has begun ends with the
  process. It takes no signal handlers and reads no ~/.petscrc.
*/
TENDRIL_API int TendrilCreate(MPI_Comm comm, Tendril *simulation);

/* TendrilCreateFortran - the same with a communicator's Fortran handle, as MPI_Comm_c2f() and
   mpi4py's py2f() give it; any negative number: MPI_COMM_SELF. */
TENDRIL_API int TendrilCreateFortran(int comm, Tendril *simulation);

/* TendrilDestroy - frees all that a simulation has, and sets it to NULL. Collective. */
TENDRIL_API void TendrilDestroy(Tendril *simulation);

/*
  TendrilSet - an option, with or without its dash: "friction_mu", "0.5". "options_file" takes the
  options of a scene's file, one after the other, and its rods; a later one wins. "NAME_friction_mu"
  is that of rod NAME. value NULL: true.

  Once the simulation is set up only what can change in a run is taken, from the present time on, as
  docs/live.md lists it: tip_force, feed_speed, friction_factor, wall_to ... Anything else is
  refused.
*/
TENDRIL_API int TendrilSet(Tendril simulation, const char *option, const char *value);

/*
  TendrilSetLaw - a law of one's own in the place of what options say; before TendrilSetUp().

  kind  "friction": value[0] = phi, value[1] = dphi/d(v^2). The force per length is -phi(|v|^2) v;
          the built-in one has phi = (1 - mu) + mu/sqrt(v^2 + beta)
        "growth": value[0..2] = g, dg/dt, dg/ds; value[3..4] = p = int_0^s g, dp/dt
        "curvature": natural curvature about d3, about d2, twist: value[0..2]; and the rates at
  which they change for the material there: value[3..5] law   NULL: none any more
*/
TENDRIL_API int TendrilSetLaw(Tendril simulation, const char *kind, TendrilLaw law, void *ctx);

/* TendrilSetWatch - what TendrilAdvance() calls after every step; NULL: nothing. */
TENDRIL_API int TendrilSetWatch(Tendril simulation, TendrilWatch watch, void *ctx);

/* TendrilSetUp - reads and checks all options, and places the rod as it begins. After an error
   options can be set anew, and it be tried again. The first step does it if nobody has. */
TENDRIL_API int TendrilSetUp(Tendril simulation);

/* TendrilStep - goes on to the end of the next accepted step. t: the time there; may be NULL. */
TENDRIL_API int TendrilStep(Tendril simulation, double *t);

/*
  TendrilAdvance - goes on to a time. Steps are those of a run that nobody looks at, so that the
  result does not depend on what is asked for: between two of them nodes and series are known by the
  stepper's dense output. TENDRIL_ENDED: the run has ended before.
*/
TENDRIL_API int TendrilAdvance(Tendril simulation, double until);

/* TendrilTime - where it is. */
TENDRIL_API int TendrilTime(Tendril simulation, double *t);

/*
  TendrilNodes - the nodes of a rod, now.

  rod    which; 0: the first
  n      how many
  nodes  theirs, on the first rank (elsewhere n = 0); the library's, until the next call for nodes
*/
TENDRIL_API int TendrilNodes(Tendril simulation, int rod, int *n, const TendrilNode **nodes);

/*
  TendrilSeries - a series by its name in the result file (docs/results.md): one value for each
  accepted step so far, the start included; and a last one for the present time, if that is within a
  step.

  values  the library's. Those of accepted steps stay where they are, unchanged, until
          TendrilDestroy(); the one of a present time within a step is there until the next call
*/
TENDRIL_API int TendrilSeries(Tendril simulation, const char *name, int *n, const double **values);

/* TendrilRodSeries - the same of one of several rods; 0: the first. TendrilSeries() has sums of
   all, or the largest. */
TENDRIL_API int TendrilRodSeries(Tendril simulation, int rod, const char *name, int *n,
                                 const double **values);

/* TendrilRodSeriesName - the name of the k-th series that a rod has; NULL: there are no more. */
TENDRIL_API const char *TendrilRodSeriesName(Tendril simulation, int rod, int k);

/* TendrilRods - how many rods it has; 0 before TendrilSetUp(). */
TENDRIL_API int TendrilRods(Tendril simulation, int *n);

/* TendrilRodName - what one of several rods is called; "": it is the only one; NULL: there is no
   such rod. */
TENDRIL_API const char *TendrilRodName(Tendril simulation, int rod);

/* TendrilSeriesName - the name of the k-th series that this simulation has; NULL: there are no
 * more. */
TENDRIL_API const char *TendrilSeriesName(Tendril simulation, int k);

/* TendrilSave - writes a result file of the run so far, for any program that reads them, and from
   which TendrilLoad() or -restart go on: behind an accepted step to the last digit. */
TENDRIL_API int TendrilSave(Tendril simulation, const char *file);

/* TendrilSaveAt - the same as of an earlier time at which a shape was stored (-output_shapes,
   -output_interval), or of the present one. What goes on from there begins with short steps, unless
   it is the present one behind an accepted step. */
TENDRIL_API int TendrilSaveAt(Tendril simulation, double t, const char *file);

/* TendrilLoad - goes on from a result file, in the place of TendrilSetUp(): with the options that
   are in it, but for those that were set here. Laws of one's own must be set as they were. */
TENDRIL_API int TendrilLoad(Tendril simulation, const char *file);

/* TendrilMessage - a sentence about the latest call that failed; "" if none has. */
TENDRIL_API const char *TendrilMessage(Tendril simulation);

/* TendrilVersion - "0.2.0". */
TENDRIL_API const char *TendrilVersion(void);

#ifdef __cplusplus
}
#endif

#endif
