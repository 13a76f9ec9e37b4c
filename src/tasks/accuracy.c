#include "tasks/accuracy.h"

static const OptionRow rows[] = {ROW_REAL(
    "-accuracy", "", 1e-7, 0.1, UNIT_NONE, 0,
    "asked relative error of tip, |x2| and energy in the last state: sets -rod_cells and -ts_rtol "
    "where they are not given; off unless given")};
const OptionGroup accuracy_options = OPTION_GROUP("Accuracy", rows);

/*
  What chart.sh and accuracy.py of scripts/lab have taught. The largest relative error of tip, |x2|
  and energy is, with vbdf,
    in time   per_efolding F (rtol / 1e-6)^(6/7), F of e-foldings by which x2 falls or grows: each
              adds its local errors, and the energy doubles them (the mixed model, which has no
              angle to follow, twice that; so the linear one after a run: where friction
              changes along the rod its energy is in shorter waves than the x2 that it follows);
    in space  arc_error h^order of the largest cell, h its arc length at the end of the run, and
              label_error F / N^order, because an error in a rate of decay adds up over these.
    of the linear model also graded_error F J^4, J the most by which the logarithm of the stretch
              differs from one end of a cell to the other: its splines are smooth in labels;
    in contact  contact_error / N^3, for the mesh decides how stiff contact is (world/contact.c).
  A quarter of the asked error is for time and a sixth for space: the error is then below what is
  asked, and not far below.
*/
static const PetscReal per_efolding = 3e-6;
static const PetscReal arc_error[] = {0.2, 0.06}, label_error[] = {20, 400}; /* order 2, 4 */
static const PetscReal graded_error = 0.5;
static const PetscReal contact_error = 1600, share_of_contact = 0.5;
static const PetscReal share_of_time = 0.15, share_of_space = 0.1;
/* What is measured is an error to first order, on a coarse mesh: an upper estimate is so many times
   that. */
static const PetscReal of_measured = 6;
/* What it would be without a beta, of what beta dU/dbeta is: it goes with a small power of beta. */
static const PetscReal of_beta = 9;
/* Likewise, contact that is rigid: depths go with k^(-3/4), and it is not quite linear. */
static const PetscReal of_stiffness = 2;
/* Strands in space that touch are held from sliding and rolling on each other by little but
   friction, so that their errors are more than those of first order: above them then in 70 of 73
   random scenes, where it was 62, and of 52 within ten times in 29 (30). */
static const PetscReal of_strands = 3;
/* Of a rod that is fed and whose material learns its bend what has learned ends at a front within a
   cell, which is of second order: of 22 random scenes 8 were above it, with this all. */
static const PetscReal of_front = 5;
static const PetscReal least_rtol = 1e-13;
static const PetscReal margin = 1.5, by_weight = 3; /* of the estimate after a run */

typedef struct {
  PetscReal tolerance, length0, mu, amplitude, time;
  PetscReal curvature; /* natural, about; 0: none */
  PetscInt order;      /* in space */
  PetscBool graded;    /* growth differs along the rod */
  PetscBool mixed;     /* the model */
  PetscBool contact;
} Asked;

static PetscErrorCode Is(const char *name, const char *word, PetscBool *is) {
  char given[64] = "";

  PetscFunctionBegin;
  *is = PETSC_FALSE;
  PetscCall(PetscOptionsGetString(NULL, NULL, name, given, sizeof(given), NULL));
  PetscCall(PetscStrcmp(given, word, is));
  PetscFunctionReturn(0);
}

/* How many e-foldings the deflection of the straight rod falls and grows: y_t = -(1.875/L)^4 y /
   (friction 1 to 1.4) until buckling, then back up until it is visible, if the run is that long.
   That of a rod with a natural curvature does not fall below it. */
static PetscReal Efoldings(const Asked *asked) {
  PetscReal L = asked->length0, end = L + asked->time, fall;

  if (asked->curvature > 0)
    return PetscMax(FEWEST_EFOLDINGS, -2 * PetscLogReal(PetscMax(1e-30, asked->curvature)));
  fall = 4.12 * (1 - 0.3 * asked->mu) * (1 / (L * L * L) - 1 / (end * end * end));
  return PetscMax(FEWEST_EFOLDINGS,
                  2 * PetscMin(fall, 80) +
                      PetscMax(0, -PetscLogReal(PetscMax(1e-30, asked->amplitude))));
}

/* The cells that see a length which an option gives, if that is in use: so many a length at 1e-4,
   of order 4. */
static PetscErrorCode CellsFor(const char *given, const char *length, PetscReal cells_of_it,
                               const Asked *asked, PetscReal *cells) {
  PetscReal value;
  PetscBool set;

  PetscFunctionBegin;
  PetscCall(OptionGiven(given, &set));
  if (!set) PetscFunctionReturn(0);
  PetscCall(OptionReal(length, &value, NULL));
  *cells = PetscMax(*cells, cells_of_it * PetscPowReal(1e-4 / asked->tolerance, 0.25) / value *
                                (asked->length0 + asked->time));
  PetscFunctionReturn(0);
}

/* What options say of a run of which an accuracy is asked; set: one is. */
static PetscErrorCode Read(Asked *asked, PetscBool *set) {
  PetscReal constant = 0, random = 0;
  PetscBool second, from_file, walls;

  PetscFunctionBegin;
  PetscCall(OptionReal("-accuracy", &asked->tolerance, set));
  if (!*set) PetscFunctionReturn(0);
  PetscCall(OptionReal("-growth_initial_length", &asked->length0, NULL));
  PetscCall(OptionReal("-friction_mu", &asked->mu, NULL));
  PetscCall(OptionReal("-shape_amplitude", &asked->amplitude, NULL));
  PetscCall(OptionReal("-ts_max_time", &asked->time, NULL));
  PetscCall(Is("-growth_type", "gaussian", &asked->graded));
  PetscCall(Is("-rod_order", "2", &second));
  PetscCall(Is("-rod_model", "mixed", &asked->mixed));
  PetscCall(OptionReal("-rod_curvature", &constant, NULL));
  PetscCall(OptionReal("-rod_curvature_random", &random, NULL));
  PetscCall(OptionGiven("-rod_curvature_file", &from_file));
  PetscCall(OptionGiven("-wall_file", &walls));
  PetscCall(OptionBool("-contact_self", &asked->contact, NULL));
  asked->contact = (PetscBool)(asked->contact || walls);
  asked->curvature = PetscMax(PetscMax(PetscAbsReal(constant), random), from_file ? 0.01 : 0);
  asked->amplitude = PetscAbsReal(asked->amplitude);
  asked->order = second || asked->mixed ? 2 : 4;
  PetscFunctionReturn(0);
}

/*
  AccuracyApply - reads -accuracy and sets -rod_cells from it unless they are given.

  Collective; call it before the scene is read. The model stays the frame of order 4 unless another
  is asked for: the chart has it on the front at every accuracy.
*/
PetscErrorCode AccuracyApply(void) {
  PetscReal space, cells, h;
  PetscBool set, apical;
  Asked asked;

  PetscFunctionBegin;
  PetscCall(Read(&asked, &set));
  if (!set) PetscFunctionReturn(0);
  space = share_of_space * asked.tolerance;
  h = PetscPowReal(space / arc_error[asked.order == 4], 1. / asked.order);
  cells = (asked.graded ? 1.5 : 1) * (asked.length0 + asked.time) / h;
  cells = PetscMax(cells, PetscPowReal(label_error[asked.order == 4] * Efoldings(&asked) / space,
                                       1. / asked.order));
  PetscCall(CellsFor("-friction_layers", "-friction_layer_width", 6, &asked, &cells));
  PetscCall(Is("-growth_type", "apical", &apical));
  if (apical) /* whatever its length, the zone has a part of the cells (material/mesh.c) */
    cells = PetscMax(cells, 600 * PetscPowReal(1e-4 / asked.tolerance, 0.25));
  if (asked.contact)
    cells =
        PetscMax(cells, PetscPowReal(contact_error / (share_of_contact * asked.tolerance), 1. / 3));
  PetscCall(OptionDefault("-rod_cells", "%.0f", PetscCeilReal(PetscMax(32, PetscMin(1e6, cells)))));
  PetscFunctionReturn(0);
}

/* AccuracyTolerance - likewise sets -ts_rtol, of a run. Collective. */
PetscErrorCode AccuracyTolerance(void) {
  PetscBool set;
  PetscReal time;
  Asked asked;

  PetscFunctionBegin;
  PetscCall(Read(&asked, &set));
  if (!set) PetscFunctionReturn(0);
  time =
      share_of_time * asked.tolerance / (per_efolding * (asked.mixed ? 2 : 1) * Efoldings(&asked));
  PetscCall(OptionDefault("-ts_rtol", "%.3g",
                          PetscMax(least_rtol, PetscMin(0.01, 1e-6 * PetscPowReal(time, 7. / 6)))));
  PetscFunctionReturn(0);
}

/* AccuracyTimes - how many times the error that was followed a part is reported as. */
PetscReal AccuracyTimes(int part) {
  if (part == ESTIMATE_LIMIT) return of_beta;
  return part == ESTIMATE_SOFT ? of_stiffness : of_measured;
}

/* AccuracyBeyond - how much larger errors are taken for than the estimate has them: of strands in
   space that touch, of a rod that is fed and learns its bend. */
PetscReal AccuracyBeyond(PetscBool strands, PetscBool front) {
  return (strands ? of_strands : 1) * (front ? of_front : 1);
}

/*
  AccuracyMeasured - from the errors that were followed (stepping/estimate.c), of a state or the
  largest of a run, an upper estimate of their parts and of what is seen: they are off by a factor
  of 2 or 3, as a rule. (Of all of it the caller says: all is left as it is.)

  least    of the steps: none of them is without an error
  beside   what comes on top of them
  beyond   AccuracyBeyond()
*/
void AccuracyMeasured(const PetscReal least[ESTIMATE_SEEN],
                      PetscReal worst[ESTIMATE_PARTS][ESTIMATE_SEEN], PetscReal beside,
                      PetscReal beyond, Errors *error) {
  for (int i = 0; i < ESTIMATE_SEEN; i++) error->seen[i] = beside;
  for (int k = 0; k < ESTIMATE_PARTS; k++) {
    error->part[k] = 0;
    for (int i = 0; i < ESTIMATE_SEEN; i++) {
      PetscReal here = PetscMin(1, beyond * AccuracyTimes(k) * worst[k][i]);
      if (k == ESTIMATE_TIME) here = PetscMax(here, least[i]);
      error->seen[i] += here;
      error->part[k] = PetscMax(error->part[k], here);
    }
  }
}

/* AccuracyMissing - what gives each part of an error the share that is left to it of an accuracy,
   by a method of that order. */
AccuracyNeeds AccuracyMissing(const Errors *error, PetscReal asked, PetscInt order) {
  const PetscReal share = 0.4 * asked, *part = error->part;

  return (AccuracyNeeds){
      .cells = PetscPowReal(PetscMax(1, part[ESTIMATE_SPACE] / share), 1. / order),
      .steps = PetscPowReal(PetscMax(1, part[ESTIMATE_TIME] / share), 7. / 6),
      .stiffness = PetscPowReal(PetscMax(1, part[ESTIMATE_SOFT] / share), 4. / 3)};
}

/* What to give to be as accurate as that. */
static PetscErrorCode Advise(const Errors *error, PetscReal asked, PetscReal rtol, Rod rod,
                             char advice[], size_t room) {
  const AccuracyNeeds needs = AccuracyMissing(error, asked, rod->order);
  char by_cells[48] = "", by_steps[48] = "", stiffer[48] = "";

  PetscFunctionBegin;
  if (needs.cells > 1)
    (void)snprintf(by_cells, sizeof(by_cells), " -rod_cells %.0f",
                   (double)PetscCeilReal(rod->scene->mesh.cells * needs.cells));
  if (needs.steps > 1)
    (void)snprintf(by_steps, sizeof(by_steps), " -ts_rtol %.1e",
                   (double)PetscMax(least_rtol, rtol / needs.steps));
  if (needs.stiffness > 1)
    (void)snprintf(stiffer, sizeof(stiffer), " -contact_stiffness %.1e",
                   (double)(rod->scene->contact.stiffness * needs.stiffness));
  if (by_cells[0] || by_steps[0] || stiffer[0])
    (void)snprintf(advice, room, "; give%s%s%s", by_cells, by_steps, stiffer);
  else
    (void)snprintf(advice, room,
                   "; it is not that of its mesh and steps (a snap, "
                   "a start too far from rest, friction next to exact)");
  PetscFunctionReturn(0);
}

/*
  AccuracyTell - says so if the accuracy that was asked for may not be met. Collective on comm.

  rtol  of the steps of the rod
*/
PetscErrorCode AccuracyTell(const ErrorEstimate *error, PetscReal rtol, Rod rod, MPI_Comm comm) {
  char advice[160] = "";
  PetscReal asked;
  PetscBool set;

  PetscFunctionBegin;
  PetscCall(OptionReal("-accuracy", &asked, &set));
  if (!set || error->kind == ESTIMATE_NONE || error->end.all <= asked) PetscFunctionReturn(0);
  if (error->kind == ESTIMATE_MEASURED)
    PetscCall(Advise(&error->end, asked, rtol, rod, advice, sizeof(advice)));
  PetscCall(PetscPrintf(comm, "-accuracy %g may not be met, the estimate is above it%s.\n",
                        (double)asked, advice));
  PetscFunctionReturn(0);
}

/*
  AccuracyEstimate - an upper estimate of the largest relative error of tip, |x2| and energy over a
  run of vbdf, by the fits at the head of this file. Not collective.

  rod    at the end of the run, t      rtol   of its steps
  efoldings  how often |x2| fell or grew e-fold
  weighed these, from the fewest on, as what was added in each weighs in the energy now
  linear was it of the linear model, for a part of the run at least?
  error  out; of the linear model without what it neglects (grow_model.c)
*/
PetscErrorCode AccuracyEstimate(Rod rod, PetscReal t, PetscReal rtol, PetscReal efoldings,
                                PetscReal weighed, PetscBool linear, PetscReal *error) {
  const Mesh *mesh = &rod->scene->mesh;
  PetscBool fourth = (PetscBool)(rod->order == 4);
  PetscReal h = 0, jump = 0, *g;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(mesh->cells + 1, &g));
  PetscCall(GrowthStretch(rod->scene->growth, mesh->cells + 1, mesh->s, t, g, NULL, NULL));
  for (PetscInt i = 0; i < mesh->cells; i++)
    h = PetscMax(h, (mesh->s[i + 1] - mesh->s[i]) * (g[i] + g[i + 1]) / 2);
  for (PetscInt i = 0; i < mesh->cells && rod->model->linear; i++)
    jump = PetscMax(jump, PetscAbsReal(PetscLogReal(g[i + 1] / g[i])));
  PetscCall(PetscFree(g));
  efoldings += FEWEST_EFOLDINGS;
  *error = margin * per_efolding * (linear || rod->model == &rod_mixed ? 2 : 1) *
               (efoldings + by_weight * PetscMax(0, weighed - efoldings)) *
               PetscPowReal(rtol / 1e-6, 6. / 7) +
           arc_error[fourth] * PetscPowReal(h, rod->order) +
           label_error[fourth] * efoldings / PetscPowReal(mesh->cells, rod->order) +
           graded_error * efoldings * PetscSqr(PetscSqr(jump));
  PetscFunctionReturn(0);
}
