/* A rod in space at a point, at nodes and between them, with all that is measured there. */
#ifndef TENDRIL_SAMPLE_SPACE_H
#define TENDRIL_SAMPLE_SPACE_H

#include "rod/feet.h"
#include "rod/rod.h"

enum {
  PUSH = 4
}; /* a force of contact per length: x1, x2, and in space x3 and the couple about d1 */

typedef Material SampleLaw; /* what the laws give at a point */

typedef struct {
  Node node;
  SampleLaw law;
  PetscReal moment[3], u[3]; /* moment and strains about the directors, which are axes of */
  Place at;
  PetscReal turns, spin, F[RUBS]; /* spin of the directors, of the material; load of friction */
  PetscReal drive[3], ironing[3]; /* Dk/Dt of what its material has learned, and that by ironing */
  const PetscReal *push;          /* of contact, per length; NULL: none */
} Sample3;

PetscErrorCode SampleLaws(Scene scene, PetscReal t, PetscInt first, PetscInt end, SampleLaw law[]);
PetscErrorCode SampleFill3(Scene scene, PetscReal s, PetscReal t, const SampleLaw *law,
                           Sample3 *sample);
PetscErrorCode SampleMid3(Scene scene, PetscReal sa, PetscReal sb, PetscReal t,
                          const SampleLaw *law, const Sample3 *a, const Sample3 *b,
                          const PetscReal (*feet)[FOOT_LOAD], Sample3 *mid);

#endif
