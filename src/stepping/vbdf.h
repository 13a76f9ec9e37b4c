/* TS type "vbdf": backward differentiation formulas of variable order 1 to 6 and variable step for
   F(t, U, U_t) = 0, differential-algebraic of index 2. PETSc's own "bdf" keeps one order, restarts
   by a first-order half step and cannot be handed a history.

   Fields that are one shape times a factor that falls and rises by many orders of magnitude are
   stepped with that factor taken out (VBDFSetFactored()). */
#ifndef TENDRIL_VBDF_H
#define TENDRIL_VBDF_H

#include <petscts.h>

#define TSVBDF "vbdf"
enum { VBDF_POINTS = 9 };  /* the new one and up to 8 past ones */
enum { VBDF_FIELDS = 23 }; /* most unknowns of a node */
enum { VBDF_FACTORS = 2 };
enum { VBDF_MEMORY = 4 }; /* what it remembers besides */

typedef PetscErrorCode (*VBDFGuess)(TS ts, PetscReal t0, PetscReal t1, Vec U0, Vec U1, void *ctx);

/* Before the equations of a step, which could not be solved, are tried once more from the same
   guess in another way; and behind that, when the usual one is to be back. */
typedef PetscErrorCode (*VBDFOtherWay)(TS ts, PetscBool other);

/* Is a step from U0 at t0 to U1 at t1 one that cannot be, whatever its error? */
typedef PetscErrorCode (*VBDFCheck)(TS ts, PetscReal t0, PetscReal t1, Vec U0, Vec U1,
                                    PetscBool *impossible);

/* What is known of a step that would be accepted: its error; but little, for it is the first of a
   history; nothing, for its error is above the tolerance and does not fall: a jump. */
typedef enum { VBDF_SEEN, VBDF_BLIND, VBDF_JUMP } VBDFSight;

/* Does the step just solved, to U, cross a mode that grows, at a rate above the shift of the step?
   Its sign would turn. */
typedef PetscErrorCode (*VBDFCross)(TS ts, Vec U, VBDFSight sight, PetscBool *crosses);

/* The first time behind t at which a step has to end, whatever its error; PETSC_MAX_REAL: there is
   none. */
typedef PetscReal (*VBDFNextEnd)(TS ts, PetscReal t);
/* Does what drives it kink there? Then what was before says nothing of what comes. */
typedef PetscBool (*VBDFKinks)(TS ts, PetscReal t);

/* Makes of a sum of m points at earlier times, each times its weights for the fields of a node, at
   fixed labels, that along the material: of fields that belong to it U_t is then its own rate. */
typedef PetscErrorCode (*VBDFCarry)(TS ts, PetscReal t, PetscInt m, const PetscReal times[],
                                    const Vec points[], PetscReal weight[][VBDF_FIELDS], Vec sum);

/* Turns an error, in place, into the axes along which the tolerances are. */
typedef PetscErrorCode (*VBDFMeasure)(TS ts, Vec error);

PetscErrorCode VBDFRegister(void);
PetscErrorCode VBDFSetGuess(TS ts, VBDFGuess guess, void *ctx);
PetscErrorCode VBDFSetHighestOrder(TS ts, PetscInt order);
PetscErrorCode VBDFSetOtherWay(TS ts, VBDFOtherWay other_way);
PetscErrorCode VBDFSetResolves(TS ts, PetscBool resolves);
PetscErrorCode VBDFSetScale(TS ts, PetscReal scale);
PetscErrorCode VBDFSetAgain(TS ts, PetscReal own, PetscReal again, PetscBool unheld);
PetscErrorCode VBDFSetHeld(TS ts, Vec held, PetscBool free);
PetscErrorCode VBDFSetCheck(TS ts, VBDFCheck check);
PetscErrorCode VBDFSetCross(TS ts, VBDFCross cross);
PetscErrorCode VBDFSetNextEnd(TS ts, VBDFNextEnd next_end);
PetscErrorCode VBDFSetKinks(TS ts, VBDFKinks kinks);
PetscErrorCode VBDFSetCarry(TS ts, VBDFCarry carry);
PetscErrorCode VBDFSetMeasure(TS ts, VBDFMeasure measure);
PetscErrorCode VBDFSetFactored(TS ts, PetscInt fields, const int factored[]);
PetscErrorCode VBDFSetLeast(TS ts, const PetscReal least[VBDF_FACTORS]);
PetscErrorCode VBDFGetFactorRate(TS ts, PetscReal rate[VBDF_FACTORS]);
PetscErrorCode VBDFGetHistory(TS ts, PetscInt *n, PetscReal times[], Vec points[], PetscInt *order);
PetscErrorCode VBDFSetHistory(TS ts, PetscInt n, const PetscReal times[], const Vec points[],
                              PetscInt order);
PetscErrorCode VBDFBeginAnew(TS ts);
PetscErrorCode VBDFGetMemory(TS ts, PetscReal memory[VBDF_MEMORY]);
PetscErrorCode VBDFSetMemory(TS ts, const PetscReal memory[VBDF_MEMORY]);
PetscErrorCode VBDFInterpolate(TS ts, PetscReal t, Vec U, Vec U_t, PetscBool *done);
PetscErrorCode VBDFGetJumps(TS ts, PetscInt *jumps);
PetscErrorCode VBDFGetLocalError(TS ts, PetscInt fields, PetscInt *n,
                                 PetscReal weight[VBDF_POINTS][VBDF_FIELDS]);
PetscErrorCode VBDFGetFormula(TS ts, PetscInt *n, PetscReal weight[][VBDF_FIELDS]);
PetscErrorCode VBDFGetDense(TS ts, PetscReal t, PetscInt *n, PetscReal value[][VBDF_FIELDS],
                            PetscReal slope[][VBDF_FIELDS]);
PetscErrorCode VBDFGetOrder(TS ts, PetscInt *order);

#endif
