/* Friction of one's own, in the place of the built-in one: TendrilSetLaw(). */
#include "world/friction_law.h"

static PetscErrorCode OwnCreate(void **law) {
  PetscFunctionBegin;
  *law = OptionsLaw(OWN_FRICTION);
  PetscFunctionReturn(0);
}

static void OwnDrag(void *law, const Place *at, PetscReal speed2, PetscReal drag[]) {
  const TendrilPlace place = {.speed2 = speed2};
  PetscReal value[OWN_VALUES] = {0};

  OwnValue((OwnLaw *)law, &place, value);
  drag[0] = value[0];
  drag[1] = value[1];
}

const FrictionLaw friction_own = {
    .option = "the friction law of one's own", .create = OwnCreate, .drag = OwnDrag};
