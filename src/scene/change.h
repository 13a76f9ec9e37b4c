/* What may be changed in a run, from a time on. */
#ifndef TENDRIL_CHANGE_H
#define TENDRIL_CHANGE_H

#include "scene/scene.h"

const OptionRow *SceneChangedOption(const char *name);
PetscErrorCode SceneMayChange(Scene scene, const char *name, const char *value, PetscReal t);
PetscErrorCode SceneChange(Scene scene, const char *name, const char *value, PetscReal t);
PetscErrorCode SceneLampHasRoom(Scene scene, const char *value, PetscReal t, PetscInt n,
                                const PetscReal x[][3], PetscBool *has);
PetscErrorCode SceneHasRoom(Scene scene, const char *value, PetscReal t, PetscInt n,
                            const PetscReal x[][3], PetscBool *has);
PetscErrorCode SceneChangesCheck(Scene scene, PetscReal from);
void SceneChangeAbout(const ChangeRow *row);

#endif
