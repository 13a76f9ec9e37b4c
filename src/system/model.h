/* Several rods that go together: one vector of unknowns, rod by rod, in which each has its own part
   and its own equations. What steps them sees one rod (rod/ask.h). */
#ifndef TENDRIL_SYSTEM_MODEL_H
#define TENDRIL_SYSTEM_MODEL_H

#include "system/joints.h"

PetscErrorCode SystemCreate(PetscInt n, Rod each[], Joints joints, Strands strands, Rod *rod);

#endif
