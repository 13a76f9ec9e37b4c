/* The backward differentiation formula of variable step, 1 to 6 steps: the history, the polynomials
   through it, and the factor that is taken out of fields that decay and grow. It knows no time
   stepper: what the next step is, the controller says. */
#ifndef TENDRIL_FORMULA_H
#define TENDRIL_FORMULA_H

#include "stepping/vbdf.h"

/* Sizes: of the fields of each factor, and of those of all together. */
enum { FORMULA_ALL = VBDF_FACTORS, FORMULA_SIZES };

typedef struct {
  /* The history. point[0] is the new solution, at time[0]; point[1], point[2], ... those of the
     steps before. Times count from the latest of these: however late it is in a run, a step may be
     as short as in its beginning. */
  PetscInt n;                       /* past points */
  PetscBool given;                  /* it was handed over: there is no new solution yet */
  PetscBool done;                   /* the step to the new solution has been accepted */
  PetscReal time[VBDF_POINTS], now; /* now: of the new solution, as the run counts */
  Vec point[VBDF_POINTS];
  /* The present step: U_t = shift U + affine, and rho U more for the fields factored, of each of
     their factors. */
  PetscReal shift, rho[VBDF_FACTORS];
  VBDFCarry carry;  /* of affine along the material; NULL: fields are at labels */
  TS ts;            /* borrowed, for that */
  Vec affine, rate; /* rate: U_t of the state that FormulaRate() was given last */
  /* The factor. */
  PetscInt fields;                            /* of a node, if any are factored */
  int factored[VBDF_FIELDS];                  /* bit k: by factor k; of several, by their product */
  PetscBool plain;                            /* nothing is factored in the present step */
  PetscInt degree, taken[VBDF_FACTORS];       /* of log A at most; points that it goes through */
  PetscReal size[VBDF_POINTS][FORMULA_SIZES]; /* log of the size of the fields of each factor in
                                                 point[i], and of those of all */
  PetscReal least[VBDF_FACTORS];              /* size below which no factor is taken */
  int column[VBDF_FACTORS];                   /* of size, that the factor is taken from */
  PetscReal ratio[VBDF_FACTORS][VBDF_POINTS]; /* A(time[0]) / A(time[i]) */
} Formula;

PetscErrorCode FormulaSetUp(Formula *formula, Vec U);
PetscErrorCode FormulaReset(Formula *formula);
PetscErrorCode FormulaMeasureSize(Formula *formula, PetscInt i);
PetscErrorCode FormulaPush(Formula *formula, Vec U);
void FormulaTakeFactor(Formula *formula, PetscInt order);
PetscReal FormulaEfoldings(const Formula *formula);
PetscErrorCode FormulaExtrapolate(Formula *formula, PetscInt m, Vec X);
PetscErrorCode FormulaBegin(Formula *formula, PetscInt order);
PetscErrorCode FormulaRate(Formula *formula, Vec U);
PetscErrorCode FormulaWithoutError(Formula *formula, PetscInt order, Vec X);
PetscErrorCode FormulaInterpolate(Formula *formula, PetscInt order, PetscReal t, Vec U, Vec U_t);
PetscInt FormulaDenseWeights(const Formula *formula, PetscInt order, PetscReal t,
                             PetscReal value[][VBDF_FIELDS], PetscReal slope[][VBDF_FIELDS]);
PetscInt FormulaRateWeights(Formula *formula, PetscInt order, PetscReal weight[][VBDF_FIELDS]);
PetscInt FormulaErrorWeights(Formula *formula, PetscInt order, PetscInt fields,
                             PetscReal weight[][VBDF_FIELDS]);

#endif
