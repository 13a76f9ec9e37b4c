#include "base/options.h"
#include <string.h>

/* OptionVector - reads a vector, "a,b,c" or "a,b" (c is then 0). Collective on OptionsComm(). */
PetscErrorCode OptionVector(const char *name, Dimension dimension, PetscReal v[3],
                            PetscBool *given) {
  char text[PETSC_MAX_PATH_LEN] = "", *part, *rest, *end;
  PetscBool bare = PETSC_FALSE, units = PETSC_FALSE;
  int n = 0;

  PetscFunctionBegin;
  v[0] = v[1] = v[2] = 0;
  PetscCall(OptionText(name, text, given));
  if (!*given) PetscFunctionReturn(0);
  UserCheck(text[0] != ',' && !strstr(text, ",,") && text[strlen(text) - 1] != ',', OptionsComm(),
            "%s %s: a number is missing at a comma; give a,b,c", name, text);
  for (part = strtok_r(text, ",", &rest); part; part = strtok_r(NULL, ",", &rest)) {
    UserCheck(n < 3, OptionsComm(), "%s: more than three numbers; give a,b,c", name);
    PetscCall(OptionQuantity(name, part, dimension, &v[n]));
    (void)strtod(part, &end);
    if (*end)
      units = PETSC_TRUE;
    else if (v[n] != 0)
      bare = PETSC_TRUE;
    n++;
  }
  UserCheck(!(bare && units), OptionsComm(),
            "%s: some of its numbers have a unit and some have none; give all of them one", name);
  UserCheck(n >= 2, OptionsComm(), "%s: give three numbers, a,b,c, or two in the plane, a,b", name);
  PetscFunctionReturn(0);
}

/* OptionPlace - a place as a person writes it; that of the origin is 0. */
const char *OptionPlace(const PetscReal x[3], char text[96]) {
  if (x[0] == 0 && x[1] == 0 && x[2] == 0)
    (void)snprintf(text, 96, "0");
  else
    (void)snprintf(text, 96, "%.6g,%.6g,%.6g", (double)x[0], (double)x[1], (double)x[2]);
  return text;
}
