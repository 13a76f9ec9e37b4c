/* Laboratory units: those that a value may carry, and those in which a number is told. */
#include "base/options.h"

/* By which a mass per length is a weight per length, in m/s^2. */
#define standard_gravity 9.80665

/* in SI; shown: the least number of SI units that is told in it, -1: none is. Of each dimension the
   larger come first. */
static const struct {
  const char *name;
  Dimension dimension;
  PetscReal si, shown;
} units[] = {{"m", UNIT_LENGTH, 1, 1},
             {"cm", UNIT_LENGTH, 1e-2, 1e-2},
             {"mm", UNIT_LENGTH, 1e-3, 1e-3},
             {"um", UNIT_LENGTH, 1e-6, 0},
             {"in", UNIT_LENGTH, 0.0254, -1},
             {"ft", UNIT_LENGTH, 0.3048, -1},
             {"mil", UNIT_LENGTH, 25.4e-6, -1},
             {"Fr", UNIT_LENGTH, 1e-3 / 3, -1}, /* French, of diameters: that of a catheter */
             {"d", UNIT_TIME, 86400, 864000},
             {"h", UNIT_TIME, 3600, 36000},
             {"min", UNIT_TIME, 60, 600},
             {"s", UNIT_TIME, 1, 1e-1},
             {"ms", UNIT_TIME, 1e-3, 0},
             {"N", UNIT_FORCE, 1, 1},
             {"mN", UNIT_FORCE, 1e-3, 1e-3},
             {"uN", UNIT_FORCE, 1e-6, 0},
             {"1/m", UNIT_CURVATURE, 1, 0},
             {"/m", UNIT_CURVATURE, 1, -1},
             {"1/cm", UNIT_CURVATURE, 1e2, -1},
             {"/cm", UNIT_CURVATURE, 1e2, -1},
             {"1/mm", UNIT_CURVATURE, 1e3, -1},
             {"/mm", UNIT_CURVATURE, 1e3, -1},
             {"1/in", UNIT_CURVATURE, 1 / 0.0254, -1},
             {"/in", UNIT_CURVATURE, 1 / 0.0254, -1},
             {"1/ft", UNIT_CURVATURE, 1 / 0.3048, -1},
             {"/ft", UNIT_CURVATURE, 1 / 0.3048, -1},
             {"N/m", UNIT_LOAD, 1, 1},
             {"mN/m", UNIT_LOAD, 1e-3, 0},
             {"N/cm", UNIT_LOAD, 1e2, -1},
             {"N/mm", UNIT_LOAD, 1e3, -1},
             {"mN/cm", UNIT_LOAD, 1e-1, -1},
             {"mN/mm", UNIT_LOAD, 1, -1},
             {"N/in", UNIT_LOAD, 1 / 0.0254, -1},
             {"N/ft", UNIT_LOAD, 1 / 0.3048, -1},
             {"kg/m", UNIT_LOAD, standard_gravity, -1},
             {"g/m", UNIT_LOAD, 1e-3 * standard_gravity, -1},
             {"g/cm", UNIT_LOAD, 1e-1 * standard_gravity, -1},
             {"lb/ft", UNIT_LOAD, 0.45359237 / 0.3048 * standard_gravity, -1},
             {"rad", UNIT_ANGLE, 1, -1},
             {"deg", UNIT_ANGLE, PETSC_PI / 180, -1},
             {"m/s", UNIT_SPEED, 1, 0},
             {"mm/s", UNIT_SPEED, 1e-3, -1},
             {"in/s", UNIT_SPEED, 0.0254, -1},
             {"ft/s", UNIT_SPEED, 0.3048, -1},
             {"m/s", SI_SPEED, 1, -1},
             {"cm/s", SI_SPEED, 1e-2, -1},
             {"mm/s", SI_SPEED, 1e-3, -1},
             {"um/s", SI_SPEED, 1e-6, -1},
             {"m/min", SI_SPEED, 1. / 60, -1},
             {"cm/min", SI_SPEED, 1e-2 / 60, -1},
             {"mm/min", SI_SPEED, 1e-3 / 60, -1},
             {"cm/h", SI_SPEED, 1e-2 / 3600, -1},
             {"mm/h", SI_SPEED, 1e-3 / 3600, -1},
             {"um/h", SI_SPEED, 1e-6 / 3600, -1},
             {"mm/d", SI_SPEED, 1e-3 / 86400, -1},
             {"in/s", SI_SPEED, 0.0254, -1},
             {"ft/s", SI_SPEED, 0.3048, -1},
             {"in/min", SI_SPEED, 0.0254 / 60, -1},
             {"ft/min", SI_SPEED, 0.3048 / 60, -1},
             {"in/h", SI_SPEED, 0.0254 / 3600, -1},
             {"ft/h", SI_SPEED, 0.3048 / 3600, -1},
             {"Nm^2", SI_STIFFNESS, 1, -1},
             {"Ncm^2", SI_STIFFNESS, 1e-4, -1},
             {"Nmm^2", SI_STIFFNESS, 1e-6, -1},
             {"Nin^2", SI_STIFFNESS, 0.0254 * 0.0254, -1},
             {"Nft^2", SI_STIFFNESS, 0.3048 * 0.3048, -1},
             {"N/m", SI_DRY, 1, -1},
             {"N/cm", SI_DRY, 1e2, -1},
             {"N/mm", SI_DRY, 1e3, -1},
             {"mN/m", SI_DRY, 1e-3, -1},
             {"mN/cm", SI_DRY, 1e-1, -1},
             {"mN/mm", SI_DRY, 1, -1},
             {"N/in", SI_DRY, 1 / 0.0254, -1},
             {"N/ft", SI_DRY, 1 / 0.3048, -1},
             {"Ns/m^2", SI_VISCOUS, 1, -1},
             {"mNs/m^2", SI_VISCOUS, 1e-3, -1},
             {"Pas", SI_VISCOUS, 1, -1},
             {"mPas", SI_VISCOUS, 1e-3, -1},
             {"/s", UNIT_RATE, 1, 0},
             {"1/s", UNIT_RATE, 1, -1},
             {"/min", UNIT_RATE, 1. / 60, -1},
             {"1/min", UNIT_RATE, 1. / 60, -1},
             {"/h", UNIT_RATE, 1. / 3600, -1},
             {"1/h", UNIT_RATE, 1. / 3600, -1},
             {"/d", UNIT_RATE, 1. / 86400, -1},
             {"1/d", UNIT_RATE, 1. / 86400, -1}};
enum { UNITS = PETSC_STATIC_ARRAY_LENGTH(units) };

static const char *const dimension_name[DIMENSIONS] = {[UNIT_LENGTH] = "length",
                                                       [UNIT_FORCE] = "force",
                                                       [UNIT_TIME] = "time",
                                                       [UNIT_SPEED] = "speed",
                                                       [UNIT_ENERGY] = "energy",
                                                       [UNIT_POWER] = "power",
                                                       [UNIT_CURVATURE] = "curvature",
                                                       [UNIT_LOAD] = "force per length",
                                                       [SI_STIFFNESS] = "stiffness",
                                                       [SI_DRY] = "force per length",
                                                       [SI_SPEED] = "speed",
                                                       [SI_VISCOUS] = "force per length and speed",
                                                       [UNIT_RATE] = "rate"};
/* what 1 of each is in tendril's own units, as result files have it */
static const char *const own_unit[DIMENSIONS] = {
    [UNIT_LENGTH] = "l",     [UNIT_FORCE] = "N l",   [UNIT_TIME] = "l/V",      [UNIT_SPEED] = "V",
    [UNIT_ENERGY] = "N l^2", [UNIT_POWER] = "N l V", [UNIT_CURVATURE] = "1/l", [UNIT_RATE] = "V/l"};

static PetscBool Known(const char *unit) {
  for (int i = 0; i < UNITS; i++)
    if (!strcmp(unit, units[i].name)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* OptionIsLength - is it the name of a unit of length? */
PetscBool OptionIsLength(const char *unit) {
  for (int i = 0; i < UNITS; i++)
    if (units[i].dimension == UNIT_LENGTH && !strcmp(unit, units[i].name)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* The line for a unit that does not belong there. */
static PetscErrorCode Refuse(const char *what, const char *unit, Dimension dimension) {
  char list[256] = "";

  PetscFunctionBegin;
  UserCheck(dimension != UNIT_ANGLE, OptionsComm(),
            "%s%s: give a number (of radians, or with deg behind it)", what, unit);
  UserCheck(dimension != UNIT_NONE, OptionsComm(), "%s%s: give a number%s", what, unit,
            Known(unit) ? "; this takes no unit" : "");
  for (int i = 0; i < UNITS; i++)
    if (units[i].dimension == dimension)
      (void)snprintf(list + strlen(list), sizeof(list) - strlen(list), "%s%s", list[0] ? ", " : "",
                     units[i].name);
  UserCheck(PETSC_FALSE, OptionsComm(),
            "%s%s: not a unit of %s; give a number, or one with a unit without a blank: %s", what,
            unit, dimension_name[dimension], list);
  PetscFunctionReturn(0);
}

/*
  OptionUnit - the factor by which a quantity in a unit becomes one of tendril's numbers.

  what   names it in the message, with the number it stands behind
  unit   as the table above has it; empty, or tendril's own (l, l/V, ...): 1
*/
PetscErrorCode OptionUnit(const char *what, const char *unit, Dimension dimension,
                          PetscReal *factor) {
  PetscReal scale = OptionsScale(dimension);

  PetscFunctionBegin;
  *factor = 1;
  if (!unit[0] || (own_unit[dimension] && !strcmp(unit, own_unit[dimension])))
    PetscFunctionReturn(0);
  for (int i = 0; dimension && i < UNITS; i++) {
    if (strcmp(unit, units[i].name) || units[i].dimension != dimension) continue;
    UserCheck(scale > 0, OptionsComm(),
              "%s%s: a unit needs the rod in the laboratory: -si_bending_stiffness, "
              "-si_friction_dry and the like%s",
              what, unit,
              dimension == UNIT_TIME || dimension == UNIT_SPEED || dimension == UNIT_RATE
                  ? ", here also -si_speed"
                  : "");
    *factor = units[i].si / scale;
    PetscFunctionReturn(0);
  }
  PetscCall(Refuse(what, unit, dimension));
  PetscFunctionReturn(0);
}

/* OptionShownIn - the unit that suits one of tendril's numbers, and the factor that leads there;
   NULL and 1 if the laboratory does not say what it is. */
const char *OptionShownIn(PetscReal value, Dimension dimension, PetscReal *factor) {
  PetscReal scale = OptionsScale(dimension);
  const char *name = NULL;

  *factor = 1;
  for (int i = 0; scale > 0 && i < UNITS; i++) {
    if (units[i].dimension != dimension || units[i].shown < 0) continue;
    name = units[i].name;
    *factor = scale / units[i].si;
    /* what is told to 6 digits as the next larger unit is told in it */
    if (PetscAbsReal(value) * scale >= units[i].shown * (1 - 1e-6)) break;
  }
  return name;
}

/* OptionInLaboratory - a number in the laboratory, "30 cm"; empty if that is not known. */
const char *OptionInLaboratory(PetscReal value, Dimension dimension, char text[32]) {
  PetscReal factor;
  const char *unit = OptionShownIn(value, dimension, &factor);

  text[0] = 0;
  if (unit) (void)snprintf(text, 32, "%.6g %s", (double)(value * factor), unit);
  return text;
}

/* OptionBoth - a number as OptionNumber() has it and, if the laboratory is known, what it is there:
   "18.28 (30 cm)". */
const char *OptionBoth(PetscReal value, Dimension dimension, char text[64]) {
  char there[32], number[32];

  OptionNumber(value, number);
  OptionInLaboratory(value, dimension, there);
  (void)snprintf(text, 64, there[0] ? "%s (%s)" : "%s", number, there);
  return text;
}
