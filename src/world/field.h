/* A factor that varies in space and in time: what friction, or the force on the tip, is
   multiplied by. Positions are those of the laboratory. */
#ifndef TENDRIL_FIELD_H
#define TENDRIL_FIELD_H

#include "base/bends.h"
#include "base/options.h"

typedef struct _Field *Field;

PetscErrorCode FieldFromFile(const char *option, const char *file, Field *field);
PetscErrorCode FieldFromLayers(const char *option, const char *text, PetscReal width, Field *field);
PetscErrorCode FieldDestroy(Field *field);
PetscBool FieldIsLayered(Field field);
PetscReal FieldFinest(Field field, PetscReal reach);
PetscBool FieldInSpace(Field field);
PetscReal FieldNextTurn(Field field, PetscReal t);
PetscErrorCode FieldBendsInTime(Field field, PetscReal tolerance, Bends *bends);
PetscErrorCode FieldBendsAlong(Field field, int axis, PetscReal tolerance, Bends *bends);
void FieldAt(Field field, const PetscReal x[3], PetscReal t, PetscReal *factor, PetscReal slope[3]);

#endif
