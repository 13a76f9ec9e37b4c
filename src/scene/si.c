#include "scene/si.h"
#include "base/options.h"

enum { LENGTH, FORCE, TIME, SPEED, ENERGY, POWER, CURVATURE };
const char *const si_name[SI_SCALES] = {"length", "force", "time",     "speed",
                                        "energy", "power", "curvature"};
const char *const si_unit[SI_SCALES] = {"m", "N", "s", "m/s", "J", "W", "1/m"};

/*
  SiSetFromOptions - reads the physical rod, if one is given, and sets the scales and the dry share
  of friction from it: the unit of length is (YI/N)^(1/3), that of force N times it, with the
  friction per length N = mu + nu V at the speed V of growth.

  Without -si_speed purely dry friction still has scales of length and force, but not of time.
*/
PetscErrorCode SiSetFromOptions(Si *si, Friction *friction) {
  PetscBool given[4], mu_given;
  PetscReal N, mu, l;
  char text[32];

  PetscFunctionBegin;
  PetscCall(PetscMemzero(si, sizeof(*si)));
  PetscCall(OptionsHeading("Laboratory units"));
  PetscCall(
      OptionReal("-si_bending_stiffness", "YI, in N m^2", 0, 1e30, &si->stiffness, &given[0]));
  PetscCall(OptionReal("-si_friction_dry", "dry friction per length, in N/m", 0, 1e30, &si->dry,
                       &given[1]));
  PetscCall(OptionReal("-si_friction_viscous", "viscous friction per length and speed, in N s/m^2",
                       0, 1e30, &si->viscous, &given[2]));
  PetscCall(OptionReal("-si_speed", "V, the speed at which the rod grows, in m/s", 0, 1e30,
                       &si->speed, &given[3]));
  si->given = (PetscBool)(given[0] || given[1] || given[2] || given[3]);
  if (!si->given) PetscFunctionReturn(0);
  UserCheck(si->stiffness > 0, PETSC_COMM_WORLD,
            "-si_bending_stiffness: give YI in N m^2, above 0, with the other -si_ options");
  UserCheck(!given[3] || si->speed > 0, PETSC_COMM_WORLD, "-si_speed: give more than 0");
  UserCheck(si->viscous == 0 || si->speed > 0, PETSC_COMM_WORLD,
            "-si_friction_viscous: needs -si_speed, in m/s");
  N = si->dry + si->viscous * si->speed;
  UserCheck(N > 0, PETSC_COMM_WORLD,
            "-si_friction_dry or -si_friction_viscous: give one of them above 0");
  mu = si->dry / N;
  PetscCall(PetscOptionsHasName(NULL, NULL, "-friction_mu", &mu_given));
  UserCheck(!mu_given || PetscAbsReal(friction->mu - mu) < 1e-4, PETSC_COMM_WORLD,
            "-friction_mu: the -si_ options make it %s; leave it out", OptionNumber(mu, text));
  friction->mu = mu;
  l = PetscPowReal(si->stiffness / N, 1. / 3);
  si->scale[LENGTH] = l;
  si->scale[FORCE] = N * l;
  si->scale[TIME] = si->speed > 0 ? l / si->speed : 0;
  si->scale[SPEED] = si->speed;
  si->scale[ENERGY] = N * l * l;
  si->scale[POWER] = N * l * si->speed;
  si->scale[CURVATURE] = 1 / l;
  PetscFunctionReturn(0);
}

/* SiPrint - the table of conversion, for a rod of dry share mu that grows from length start to end.
   Collective. */
PetscErrorCode SiPrint(const Si *si, PetscReal mu, PetscReal start, PetscReal end) {
  char text[32];

  PetscFunctionBegin;
  UserCheck(si->given, PETSC_COMM_WORLD,
            "-task units: give the rod, -si_bending_stiffness, -si_friction_dry and the like");
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%-12s %22s %22s\n", "1 of", "is, in SI units",
                        "and 1 SI unit is"));
  for (int k = 0; k < SI_SCALES; k++) {
    char to[32] = "unknown: -si_speed", from[32] = "";
    if (si->scale[k] > 0) {
      (void)snprintf(to, sizeof(to), "%.8g %s", si->scale[k], si_unit[k]);
      (void)snprintf(from, sizeof(from), "%.8g", 1 / si->scale[k]);
    }
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%-12s %22s %22s\n", si_name[k], to, from));
  }
  PetscCall(PetscPrintf(PETSC_COMM_WORLD,
                        "The rod grows from %g m to %g m; the dry share of friction is %s.\n",
                        (double)(start * si->scale[LENGTH]), (double)(end * si->scale[LENGTH]),
                        OptionNumber(mu, text)));
  PetscFunctionReturn(0);
}
