#include "scene/si.h"

const char *const si_name[UNIT_ALL] = {NULL,     "length", "force",     "time", "speed",
                                       "energy", "power",  "curvature", NULL,   "load"};
const char *const si_unit[UNIT_ALL] = {NULL, "m", "N", "s", "m/s", "J", "W", "1/m", NULL, "N/m"};

static const OptionRow rows[] = {
    ROW_REAL("-si_bending_stiffness", "", 0, 1e30, SI_STIFFNESS, 0,
             "YI, in N m^2 or with its unit (Nmm^2)"),
    ROW_REAL("-si_friction_dry", "", 0, 1e30, SI_DRY, 0,
             "dry friction per length, in N/m or with its unit (mN/mm)"),
    ROW_REAL("-si_friction_viscous", "", 0, 1e30, SI_VISCOUS, 0,
             "viscous friction per length and speed, in N s/m^2 or with its unit (mPas)"),
    ROW_REAL("-si_speed", "", 0, 1e30, SI_SPEED, 0,
             "V, the speed at which the rod grows, in m/s or with its unit (mm/h)")};
const OptionGroup si_options = OPTION_GROUP("Laboratory units", rows);

/* The scales: the unit of length is (YI/N)^(1/3), that of force N times it. */
static void SetScales(Si *si, PetscReal N) {
  PetscReal l = PetscPowReal(si->stiffness / N, 1. / 3);

  si->scale[UNIT_LENGTH] = l;
  si->scale[UNIT_FORCE] = N * l;
  si->scale[UNIT_TIME] = si->speed > 0 ? l / si->speed : 0;
  si->scale[UNIT_SPEED] = si->speed;
  si->scale[UNIT_ENERGY] = N * l * l;
  si->scale[UNIT_POWER] = N * l * si->speed;
  si->scale[UNIT_CURVATURE] = 1 / l;
  si->scale[UNIT_LOAD] = N;
}

/* The friction per length that is the unit of force per length for a rod without friction: the one
   that makes its initial length, which says its unit, the unit of length. */
static PetscErrorCode WithoutFriction(const Si *si, PetscReal *N) {
  static const char *const only = "0:0", *const option = "-friction_layers";
  const PetscReal metre[UNIT_ALL] = {[UNIT_LENGTH] = 1};
  char text[PETSC_MAX_PATH_LEN] = "", *end;
  PetscBool given, field;
  PetscReal length;

  PetscFunctionBegin;
  PetscCall(OptionText(option, text, &given));
  PetscCall(OptionGiven("-friction_field", &field));
  UserCheck((!given || !strcmp(text, only)) && !field, OptionsComm(),
            "%s: has nothing to multiply where -si_friction_dry is 0; take it out",
            field ? "-friction_field" : option);
  PetscCall(PetscOptionsSetValue(NULL, option, only));
  PetscCall(
      PetscOptionsGetString(NULL, NULL, "-growth_initial_length", text, sizeof(text), &given));
  (void)strtod(text, &end);
  UserCheck(
      given && end != text && *end, OptionsComm(),
      "-growth_initial_length: give it with a unit (30cm), for of a rod without friction it is "
      "the unit of length");
  PetscCall(OptionsSetScales(metre));
  PetscCall(OptionQuantity("-growth_initial_length", text, UNIT_LENGTH, &length));
  UserCheck(length > 0, OptionsComm(), "-growth_initial_length %s: give more than 0", text);
  *N = si->stiffness / (length * length * length);
  PetscFunctionReturn(0);
}

/*
  SiSetFromOptions - reads the physical rod, if one is given, and sets the scales and the dry share
  of friction (-friction_mu) from it, with the friction per length N = mu + nu V at the speed V of
  growth. Before other options are read: from here on they may carry units. Collective.

  Without -si_speed purely dry friction still has scales of length and force, but not of time. A
  friction that is given as 0 is none: N is then a unit alone.
*/
PetscErrorCode SiSetFromOptions(Si *si) {
  PetscBool given[4], mu_given;
  PetscReal N, mu, mu_asked = 0;
  char text[32];

  PetscFunctionBegin;
  PetscCall(PetscMemzero(si, sizeof(*si)));
  PetscCall(OptionReal("-si_bending_stiffness", &si->stiffness, &given[0]));
  PetscCall(OptionReal("-si_friction_dry", &si->dry, &given[1]));
  PetscCall(OptionReal("-si_friction_viscous", &si->viscous, &given[2]));
  PetscCall(OptionReal("-si_speed", &si->speed, &given[3]));
  si->given = (PetscBool)(given[0] || given[1] || given[2] || given[3]);
  if (!si->given) PetscFunctionReturn(0);
  UserCheck(si->stiffness > 0, OptionsComm(),
            "-si_bending_stiffness: give YI in N m^2, above 0, with the other -si_ options");
  UserCheck(!given[3] || si->speed > 0, OptionsComm(), "-si_speed: give more than 0");
  UserCheck(si->viscous == 0 || si->speed > 0, OptionsComm(),
            "-si_friction_viscous: needs -si_speed, in m/s");
  N = si->dry + si->viscous * si->speed;
  UserCheck(N > 0 || given[1], OptionsComm(),
            "-si_friction_dry or -si_friction_viscous: give one of them above 0, or "
            "-si_friction_dry 0 for a rod without friction");
  mu = N > 0 ? si->dry / N : 0;
  if (!(N > 0)) PetscCall(WithoutFriction(si, &N));
  PetscCall(OptionReal("-friction_mu", &mu_asked, &mu_given));
  UserCheck(!mu_given || PetscAbsReal(mu_asked - mu) < 1e-4, OptionsComm(),
            "-friction_mu: the -si_ options make it %s; leave it out", OptionNumber(mu, text));
  PetscCall(PetscSNPrintf(text, sizeof(text), "%.17g", (double)mu));
  PetscCall(PetscOptionsSetValue(NULL, "-friction_mu", text));
  SetScales(si, N);
  PetscCall(OptionsSetScales(si->scale));
  PetscFunctionReturn(0);
}

/* SiPrint - the table of conversion, for a rod of dry share mu that grows from length start to end.
   Collective. */
PetscErrorCode SiPrint(const Si *si, PetscReal mu, PetscReal start, PetscReal end) {
  char text[32];

  PetscFunctionBegin;
  UserCheck(si->given, OptionsComm(),
            "-task units: give the rod, -si_bending_stiffness, -si_friction_dry and the like");
  PetscCall(PetscPrintf(OptionsComm(), "%-12s %22s %22s\n", "1 of", "is, in SI units",
                        "and 1 SI unit is"));
  for (int k = UNIT_LENGTH; k < UNIT_ALL; k++) {
    if (!si_name[k]) continue;
    char to[32] = "unknown: -si_speed", from[32] = "";
    if (si->scale[k] > 0) {
      (void)snprintf(to, sizeof(to), "%.8g %s", si->scale[k], si_unit[k]);
      (void)snprintf(from, sizeof(from), "%.8g", 1 / si->scale[k]);
    }
    PetscCall(PetscPrintf(OptionsComm(), "%-12s %22s %22s\n", si_name[k], to, from));
  }
  PetscCall(PetscPrintf(OptionsComm(),
                        "The rod grows from %g m to %g m; the dry share of friction is %s.\n",
                        (double)(start * si->scale[UNIT_LENGTH]),
                        (double)(end * si->scale[UNIT_LENGTH]), OptionNumber(mu, text)));
  PetscFunctionReturn(0);
}
