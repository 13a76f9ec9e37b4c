/* PETSc's own options that users set. They are listed for what PETSc lacks: its message for a
   malformed number does not name the option, it has no ranges and no units, and it knows no nearest
   name to a mistyped one. All others of its objects are taken as they are. */
#include "base/options.h"

static const OptionRow rows[] = {
    ROW_WORD("-ts_type", "vbdf", "vbdf,bdf,beuler,theta,cn", PETSCS,
             "time stepper: tendril's BDF of variable order, or PETSc's; others are wrong for "
             "friction that is nonlinear in the velocity"),
    ROW_INT("-ts_bdf_order", "6", 1, 6, PETSCS, "highest order of vbdf; order of bdf, there 2"),
    ROW_INT(
        "-ts_bdf_factor", "2", 0, 3, PETSCS,
        "of vbdf: degree of the logarithm of the factor taken out of the fields across the rod, "
        "which decay and grow; 0: none is"),
    ROW_REAL("-ts_dt", "", 1e-300, 1e300, UNIT_TIME, PETSCS | PASSING,
             "first step: if not given a 1e-4 of the scene's unit of time, and of a bent rod in "
             "viscous friction no more than 1e-6 of its own, (1 - mu) N L^4/B; every step of "
             "beuler, theta and cn (0.01)"),
    ROW_INT("-ts_max_steps", "", 0, 2e9, PETSCS | PASSING, "ends the run after so many steps"),
    ROW_WORD("-ts_adapt_type", "basic", "none,basic,dsp,cfl,glee,history", PETSCS,
             "PETSc's choice of steps; none: fixed steps; vbdf takes basic or none"),
    ROW_REAL("-ts_adapt_dt_max", "", 1e-300, 1e300, UNIT_TIME, PETSCS, "largest step"),
    ROW_REAL("-ts_adapt_dt_min", "", 1e-300, 1e300, UNIT_TIME, PETSCS,
             "smallest step of PETSc's steppers; vbdf refuses it"),
    ROW_INT("-ts_max_snes_failures", "-1", -2e9, 2e9, PETSCS, "Newton failures that end a run"),
    ROW_INT("-ts_max_reject", "50", -2e9, 2e9, PETSCS, "rejections of a step that end a run"),
    ROW_TEXT("-ts_monitor", PETSCS | PASSING, "prints every step"),
    ROW_TEXT("-ts_view", PETSCS | PASSING | LATE, "prints the stepper and its solvers"),
    ROW_TEXT("-snes_type", PETSCS, "Newton's method"),
    ROW_TEXT("-snes_linesearch_type", PETSCS, "its line search"),
    ROW_REAL("-snes_atol", "", 1e-300, 1e300, UNIT_NONE, PETSCS, "no effect on tendril's test"),
    ROW_REAL("-snes_rtol", "", 1e-300, 1e300, UNIT_NONE, PETSCS, "no effect on tendril's test"),
    ROW_REAL("-snes_stol", "", 1e-300, 1e300, UNIT_NONE, PETSCS, "no effect on tendril's test"),
    ROW_INT("-snes_max_it", "40", 1, 2e9, PETSCS, "most iterations of a solve"),
    ROW_TEXT("-snes_monitor", PETSCS | PASSING, "prints every iteration"),
    ROW_TEXT("-snes_converged_reason", PETSCS | PASSING, "prints why a solve ended"),
    ROW_TEXT("-snes_view", PETSCS | PASSING | LATE, "prints the solver"),
    ROW_TEXT("-ksp_type", PETSCS, "linear solver"),
    ROW_REAL("-ksp_rtol", "", 1e-300, 1e300, UNIT_NONE, PETSCS, "its relative tolerance"),
    ROW_INT("-ksp_max_it", "", 1, 2e9, PETSCS, "its most iterations"),
    ROW_TEXT("-ksp_converged_reason", PETSCS | PASSING | LATE, "prints why it ended"),
    ROW_TEXT("-pc_type", PETSCS, "its preconditioner: a direct solver unless another is given"),
    ROW_TEXT("-pc_factor_mat_solver_type", PETSCS, "whose factorisation"),
    ROW_TEXT("-eps_type", PETSCS, "eigenvalue solver"),
    ROW_INT("-eps_nev", "", 1, 2e9, PETSCS, "eigenvalues wanted"),
    ROW_INT("-eps_ncv", "", 1, 2e9, PETSCS, "size of its subspace"),
    ROW_INT("-eps_max_it", "", 1, 2e9, PETSCS, "its most iterations"),
    ROW_REAL("-eps_tol", "", 1e-300, 1e300, UNIT_NONE, PETSCS, "its tolerance"),
    ROW_TEXT("-st_type", PETSCS, "spectral transformation"),
    ROW_TEXT("-options_file", INPUT_FILE | PETSCS | PASSING | LATE | PROGRAM,
             "a scene: a file of options"),
    ROW_TEXT("-options_left", PETSCS | PASSING | LATE | PROGRAM,
             "lists what was not read, at the end"),
    ROW_TEXT("-options_view", PETSCS | PASSING | LATE | PROGRAM, "lists all options"),
    ROW_TEXT("-log_view", PETSCS | PASSING | LATE | PROGRAM, "where the time went"),
    ROW_TEXT("-malloc_dump", PETSCS | PASSING | LATE | PROGRAM, "lists memory that was not freed"),
    ROW_TEXT("-malloc_view", PETSCS | PASSING | LATE | PROGRAM, "lists memory in use"),
    ROW_TEXT("-memory_view", PETSCS | PASSING | LATE | PROGRAM, "how much memory was used"),
    ROW_TEXT("-info", PETSCS | PASSING | LATE | PROGRAM, "what the solvers do, at length"),
    ROW_TEXT("-help", PETSCS | PASSING | LATE | PROGRAM, "this; -help petsc: PETSc's own"),
    ROW_TEXT("-version", PETSCS | PASSING | LATE | PROGRAM,
             "versions of tendril, PETSc and SLEPc")};
const OptionGroup petsc_options = OPTION_GROUP("PETSc's own, as far as they are used often", rows);

/* PETSc 3.25 gave these another name, and has a warning for the old one. In tendril the old one
   stands for both, in the table as in result files, whichever PETSc wrote them. */
static const char *const renamed[][2] = {{"-ts_dt", "-ts_time_step"},
                                         {"-ts_max_reject", "-ts_max_step_rejections"}};

/* OptionsRename - moves what was given for options that PETSc has renamed to their new names, for
   PETSc to read, or to the old ones. Collective. */
PetscErrorCode OptionsRename(PetscBool new_names) {
  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(renamed); i++) {
    const char *from = renamed[i][!new_names], *to = renamed[i][new_names];
    char value[128] = "";
    PetscBool given;
    PetscCall(PetscOptionsGetString(NULL, NULL, from, value, sizeof(value), &given));
    if (!given) continue;
    PetscCall(PetscOptionsSetValue(NULL, to, value));
    PetscCall(PetscOptionsClearValue(NULL, from));
    if (!new_names) PetscCall(PetscOptionsHasName(NULL, NULL, to, &given)); /* counts as read */
  }
  PetscFunctionReturn(0);
}
