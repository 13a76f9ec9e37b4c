/* A program of a user's own: grows a rod with the installed library and reads off its tip. */
#include <rod/rod.h>
#include <tasks/grow.h>
#include <tasks/tendril.h>

static PetscErrorCode Grow(void) {
  Scene scene;

  PetscFunctionBegin;
  PetscCall(PetscOptionsSetValue(NULL, "-growth_initial_length", "2"));
  PetscCall(PetscOptionsSetValue(NULL, "-shape_amplitude", "0.1"));
  PetscCall(PetscOptionsSetValue(NULL, "-ts_max_time", "1"));
  PetscCall(SceneCreate(&scene));
  PetscCall(GrowRun(scene, "", ""));
  PetscCall(SceneDestroy(&scene));
  PetscFunctionReturn(0);
}

int main(int argc, char **argv) {
  PetscBool done;
  int failed = TendrilInitialize(&argc, &argv, &done);

  if (done) return failed;
  if (!failed) failed = Grow() != 0;
  return TendrilFinalize() || failed;
}
