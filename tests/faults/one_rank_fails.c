/* A run in which one rank alone meets an error, in the midst of a Newton iteration: its line
   appears, and no rank is left waiting.   one_rank_fails RANK */
#include "tasks/grow.h"
#include "support/program.h"

static PetscErrorCode (*stretch)(Growth, PetscReal, PetscReal, PetscReal *, PetscReal *,
                                 PetscReal *);
static PetscInt who;

static PetscErrorCode Planted(Growth growth, PetscReal s, PetscReal t, PetscReal *g, PetscReal *g_t,
                              PetscReal *g_s) {
  PetscMPIInt rank;

  PetscFunctionBegin;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  UserCheck(rank != who || t < 0.01, PETSC_COMM_SELF, "planted on rank %d", (int)rank);
  PetscCall(stretch(growth, s, t, g, g_t, g_s));
  PetscFunctionReturn(0);
}

static PetscErrorCode Run(void) {
  Scene scene;

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-who", &who, NULL));
  PetscCall(SceneCreate(&scene));
  stretch = scene->growth->stretch;
  scene->growth->stretch = Planted;
  PetscCall(GrowRun(scene, "", ""));
  PetscCall(SceneDestroy(&scene));
  PetscFunctionReturn(0);
}

PROGRAM(Run)
