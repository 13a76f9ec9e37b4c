/* -task grow: what is printed. */
#include "scene/scales.h"
#include "tasks/accuracy.h"
#include "tasks/growing.h"
#include "tasks/grow_rules.h"
#include <petsctime.h>

/* The lines of progress are in the units of the laboratory, if it is known: those that suit the end
   of the run. */
static const char *TimeUnit(const Grow *self, PetscReal *factor) {
  return OptionShownIn(self->end, UNIT_TIME, factor);
}

static const char *LengthUnit(const Grow *self, PetscReal *factor) {
  return OptionShownIn(self->reach, UNIT_LENGTH, factor);
}

/* GrowFindEnd - when the run ends, as far as that is known beforehand. Collective. */
PetscErrorCode GrowFindEnd(Grow *self) {
  PetscReal low = 0, middle, length, stop = self->watch.bound[EVENT_LENGTH];

  PetscFunctionBegin;
  self->end = self->scene->end_time;
  self->reach = self->scene->reach;
  if (!self->watch.watched[EVENT_LENGTH] || stop > self->reach) PetscFunctionReturn(0);
  self->reach = stop;
  if (self->scene->growth->yield > 0) PetscFunctionReturn(0); /* how it grows is not known yet */
  for (int i = 0; i < 40; i++) {
    middle = (low + self->end) / 2;
    PetscCall(GrowthLength(self->scene->growth, middle, &length, NULL));
    *(length < stop ? &low : &self->end) = middle;
  }
  PetscFunctionReturn(0);
}

/* A column's name with its unit. */
static const char *Column(const char *name, const char *unit, char text[16]) {
  (void)snprintf(text, 16, unit ? "%s, %s" : "%s", name, unit);
  return text;
}

/* GrowHeading - above the lines of progress. Collective. */
PetscErrorCode GrowHeading(Grow *self) {
  PetscReal factor;
  const char *length, *time;
  char text[4][16];

  PetscFunctionBegin;
  length = LengthUnit(self, &factor);
  time = TimeUnit(self, &factor);
  PetscCall(GrowPaceBegin(&self->pace));
  if (!self->quiet) PetscCall(OptionsTellPlain());
  if (!self->quiet)
    PetscCall(ScalesTell(self->scene, &self->scene->mesh, "-rod_cells", self->scene->mesh.cells,
                         self->end)); /* -stop_length may end it long before -ts_max_time */
  if (!self->quiet)
    PetscCall(PetscPrintf(self->scene->comm, "%10s %10s %12s %10s %7s %8s %11s\n",
                          Column("t", time, text[0]), Column("length", length, text[1]),
                          Column("|x2|", length, text[2]), Column("step", time, text[3]), "Newton",
                          "model", "time left"));
  PetscFunctionReturn(0);
}

/* GrowShared - says from when on dry friction has a viscous share, or a larger one, if it has
   (LoadShareMore()). Collective. */
PetscErrorCode GrowShared(Grow *self, PetscReal t) {
  const Load *load = &self->scene->load;
  const PetscReal share = 1 - load->friction.mu;
  char text[64];

  PetscFunctionBegin;
  if (!load->shared || share == self->shared) PetscFunctionReturn(0);
  OptionBoth(t, UNIT_TIME, text);
  if (!self->quiet && self->shared > 0)
    PetscCall(PetscPrintf(self->scene->comm,
                          "t = %s: the rod slips and sticks, again and again: from here on a part "
                          "of %.0e of dry friction is viscous\n",
                          text, (double)share));
  else if (!self->quiet)
    PetscCall(PetscPrintf(self->scene->comm,
                          "t = %s: the rod snaps or slips, and dry friction that is weaker across "
                          "(-friction_across %g) does not say how fast: from here on a part of "
                          "%.0e of it is viscous\n",
                          text, (double)load->across, (double)share));
  self->shared = share;
  PetscFunctionReturn(0);
}

/* GrowPaceBegin - a run begins now. */
PetscErrorCode GrowPaceBegin(Pace *self) {
  PetscFunctionBegin;
  PetscCall(PetscTime(&self->begin));
  self->reported = self->begin;
  PetscFunctionReturn(0);
}

/* GrowPaceDue - is a line of progress due: every tenth of the run, and every second, and where it
   is over? left: the time that is left, where that can be reported. */
PetscBool GrowPaceDue(Pace *self, PetscReal start, PetscReal t, PetscReal end, PetscBool last,
                      char left[32]) {
  PetscLogDouble now;

  left[0] = 0;
  if (PetscTime(&now)) return last;
  if (!last && now - self->reported < 1 && t < self->next) return PETSC_FALSE;
  self->reported = now;
  self->next = t + end / 10;
  if (now - self->begin > 0.5 && t > start + 0.02 * end && !last)
    (void)snprintf(left, 32, "%9.1f s", (now - self->begin) * (end - t) / (t - start));
  return PETSC_TRUE;
}

/* GrowProgress - a line where one is due. Collective. */
PetscErrorCode GrowProgress(Grow *self, PetscBool last) {
  const Observation *seen = &self->seen;
  PetscReal time, length;
  char left[32];

  PetscFunctionBegin;
  if (self->quiet || !GrowPaceDue(&self->pace, self->start, seen->t, self->end, last, left))
    PetscFunctionReturn(0);
  (void)TimeUnit(self, &time);
  (void)LengthUnit(self, &length);
  PetscCall(PetscPrintf(self->scene->comm, "%10.4f %10.4f %12.4e %10.2e %7d %8s %s\n",
                        (double)(time * seen->t), (double)(length * seen->length),
                        (double)(length * seen->norm_x2), (double)(time * seen->step),
                        (int)seen->newton_iterations, grow_models[(int)seen->model]->name, left));
  PetscFunctionReturn(0);
}

/* The stiffness with which the same force would press the rod in by half of that: a point load
   sinks in by k^(-3/4) (ContactSetStiffness()). */
static PetscReal Stiffer(const Grow *self) {
  const Contact *contact = &self->scene->contact;
  const PetscReal allowed = grow_rule.depth_reported / 2 * contact->diameter;

  return contact->stiffness *
         PetscPowReal(ContactSoftDepth(contact, self->kept.depth) / allowed, 4. / 3);
}

/* Strands in space rub by a law that is rounded off: what sticks there creeps. */
static PetscErrorCode TellRounded(const Grow *self) {
  const Contact *contact = &self->scene->contact;

  PetscFunctionBegin;
  if (!self->scene->space.rod || !contact->self || contact->friction <= 0 ||
      contact->rub.beta > 0 || !self->kept.pressed)
    PetscFunctionReturn(0);
  PetscCall(PetscPrintf(self->scene->comm,
                        "Friction between strands in space is not held exactly: with "
                        "-friction_beta 0 it is rounded off at a speed of %g.\n",
                        (double)PetscSqrtReal(friction_tiny)));
  PetscFunctionReturn(0);
}

/* A length, with the part of the diameter that it is. */
static const char *Deep(const Grow *self, PetscReal length, char text[], size_t room) {
  const PetscReal D = self->scene->contact.diameter;
  char number[64];

  OptionBoth(length, UNIT_LENGTH, number);
  (void)snprintf(text, room, D > 0 ? "%s (%.2g %% of the diameter)" : "%s", number,
                 (double)(D > 0 ? 100 * length / D : 0));
  return text;
}

/* What there is of contact. How far off it holds a rod that it presses in nowhere is reported, too.
 */
static PetscErrorCode TellContact(const Grow *self) {
  const Contact *contact = &self->scene->contact;
  char deep[160], off[160], held[192] = "";

  PetscFunctionBegin;
  if (!contact->any) PetscFunctionReturn(0);
  PetscCall(SceneContactAt(self->scene, self->seen.t));
  if (self->kept.off > 0)
    (void)snprintf(held, sizeof(held), ", held off by at most %s",
                   Deep(self, self->kept.off, off, sizeof(off)));
  PetscCall(PetscPrintf(self->scene->comm,
                        "contact of stiffness %.3g: at the end in %d zone%s, penetration at most "
                        "%s%s\n",
                        (double)contact->stiffness, (int)self->seen.contacts,
                        self->seen.contacts == 1 ? "" : "s",
                        Deep(self, self->kept.depth, deep, sizeof(deep)), held));
  if (contact->diameter > 0 && self->kept.depth > grow_rule.depth_reported * contact->diameter)
    PetscCall(PetscPrintf(self->scene->comm,
                          "The rod is pressed in by more than %.0f %% of its diameter: give "
                          "-contact_stiffness %.1e%s.\n",
                          100 * (double)grow_rule.depth_reported, (double)Stiffer(self),
                          contact->chosen && !(contact->firm || contact->given || contact->fine)
                              ? ", or -contact_firm"
                              : ""));
  PetscCall(TellRounded(self));
  PetscFunctionReturn(0);
}

/* Which of what is seen is off most. */
static int Worst(const PetscReal seen[ESTIMATE_SEEN]) {
  int worst = 0;

  for (int k = 1; k < ESTIMATE_SEEN; k++)
    if (seen[k] > seen[worst]) worst = k;
  return worst;
}

/* What the last state may be off in, and where in the run most was. */
static PetscErrorCode TellSeen(const Grow *self) {
  static const char *const name[ESTIMATE_SEEN] = {"tip", "|x2|", "energy"},
                           *const why[WHYS] = {
                               "by its mesh",       "by its steps",
                               "by exact friction", "by contact, which is not rigid",
                               "as it touches",     "as it lets go",
                               "as it snaps"};
  const ErrorEstimate *error = &self->error;
  const PetscReal *end = error->end.seen;
  const int k = Worst(error->most.seen);
  char text[64], at[96] = "";

  PetscFunctionBegin;
  OptionBoth(error->when[k], UNIT_TIME, text);
  if (error->when[k] > 0)
    (void)snprintf(at, sizeof(at), " at t = %s, %s", text, why[error->why[k]]);
  PetscCall(PetscPrintf(
      self->scene->comm,
      "errors at the end: tip %.1e, |x2| %.1e, energy %.1e; the largest of the run: %s %.1e%s\n",
      (double)end[ESTIMATE_TIP], (double)end[ESTIMATE_NORM], (double)end[ESTIMATE_ENERGY], name[k],
      (double)error->most.seen[k], at));
  PetscFunctionReturn(0);
}

/* What rigid contact would do, to first order: where contact is off by more, nothing is known. */
static PetscErrorCode TellRigid(const Grow *self) {
  const ErrorEstimate *error = &self->error;
  const PetscReal *rigid = error->rigid;
  char text[4][32], third[40] = "";

  PetscFunctionBegin;
  if (!self->kept.pressed || error->end.part[ESTIMATE_SOFT] > grow_rule.rigid_known)
    PetscFunctionReturn(0);
  if (self->scene->space.rod)
    (void)snprintf(third, sizeof(third), ", %s", OptionNumber(rigid[RIGID_TIP + 2], text[2]));
  PetscCall(PetscPrintf(
      self->scene->comm, "in rigid contact, to first order: tip (%s, %s%s), energy %s\n",
      OptionNumber(rigid[RIGID_TIP], text[0]), OptionNumber(rigid[RIGID_TIP + 1], text[1]), third,
      OptionNumber(rigid[RIGID_ENERGY], text[3])));
  PetscFunctionReturn(0);
}

/* How large its errors may be. */
static PetscErrorCode TellErrors(const Grow *self, PetscInt snaps) {
  const ErrorEstimate *error = &self->error;
  const Errors *end = &error->end;
  MPI_Comm comm = self->scene->comm;
  const PetscReal defect = self->seen.energy_defect;
  char friction[32] = "", soft[32] = "";

  PetscFunctionBegin;
  PetscCall(PetscPrintf(comm, "energy defect %.1e", (double)defect));
  if (error->kind != ESTIMATE_NONE)
    PetscCall(PetscPrintf(comm, ", error estimate %.1e", (double)end->all));
  if (self->scene->load.limit)
    (void)snprintf(friction, sizeof(friction), ", friction %.1e",
                   (double)end->part[ESTIMATE_LIMIT]);
  if (self->kept.pressed)
    (void)snprintf(soft, sizeof(soft), ", contact %.1e", (double)end->part[ESTIMATE_SOFT]);
  if (error->kind == ESTIMATE_MEASURED)
    PetscCall(PetscPrintf(comm, " (space %.1e, time %.1e%s%s)", (double)end->part[ESTIMATE_SPACE],
                          (double)end->part[ESTIMATE_TIME], friction, soft));
  else if (error->kind == ESTIMATE_FITTED)
    PetscCall(PetscPrintf(comm, " (a fit)"));
  if (snaps) PetscCall(PetscPrintf(comm, "; %d snap%s", (int)snaps, snaps > 1 ? "s" : ""));
  if (self->scene->load.shared)
    PetscCall(
        PetscPrintf(comm, "; viscous share %.0e", (double)(1 - self->scene->load.friction.mu)));
  PetscCall(PetscPrintf(comm, "\n"));
  if (error->kind == ESTIMATE_MEASURED) {
    PetscCall(TellSeen(self));
    PetscCall(TellRigid(self));
  }
  PetscCall(AccuracyTell(error, self->rtol, self->now->rod, comm));
  if (defect > 1e-3)
    PetscCall(PetscPrintf(
        comm,
        "The energy balance is off by more than 1e-3: lower -ts_rtol or raise -rod_cells.\n"));
  PetscFunctionReturn(0);
}

/* What was to end the run and did not. */
static PetscErrorCode TellNotReached(const Grow *self, const char *rod) {
  MPI_Comm comm = self->scene->comm;
  const Watch *watch = &self->watch;
  char text[2][64];

  PetscFunctionBegin;
  for (int k = EVENT_NONE + 1; k < EVENT_KINDS; k++) {
    if (!watch->watched[k] || self->event.kind) continue;
    OptionBoth(self->seen.t, UNIT_TIME, text[0]);
    OptionBoth(watch->bound[k], k == EVENT_ANGLE || k == EVENT_STALL ? UNIT_NONE : UNIT_LENGTH,
               text[1]);
    PetscCall(PetscPrintf(comm, "%snot reached by t = %s: -stop_%s%s%s\n", rod, text[0],
                          event_name[k], k == EVENT_CONTACT ? "" : " ",
                          k == EVENT_CONTACT ? "" : text[1]));
  }
  PetscFunctionReturn(0);
}

/* x2 is the laboratory's: of a clamp that points elsewhere it is not the deflection. */
static PetscErrorCode TellClamp(const Grow *self) {
  const Observation *seen = &self->seen;
  PetscReal alpha = self->scene->clamp_angle;
  char text[64];

  PetscFunctionBegin;
  if (alpha == 0) PetscFunctionReturn(0);
  OptionBoth(PetscCosReal(alpha) * seen->tip_x2 - PetscSinReal(alpha) * seen->tip_x1, UNIT_LENGTH,
             text);
  PetscCall(PetscPrintf(self->scene->comm,
                        "x1 and x2 are the laboratory's; from the line of the clamp, at %.4g rad, "
                        "the tip is %s off\n",
                        (double)alpha, text));
  PetscFunctionReturn(0);
}

/* Where on the rod an event was, or what it reached. */
static PetscErrorCode TellEvent(const Grow *self, const char *rod) {
  MPI_Comm comm = self->scene->comm;
  const Event *event = &self->event;
  char text[4][64];

  PetscFunctionBegin;
  if (event->kind == EVENT_NONE) PetscFunctionReturn(0);
  OptionBoth(event->t, UNIT_TIME, text[0]);
  OptionNumber(event->s[0], text[1]);
  OptionNumber(event->s[1], text[2]);
  OptionBoth(self->watch.bound[event->kind],
             event->kind == EVENT_LENGTH  ? UNIT_LENGTH
             : event->kind == EVENT_FORCE ? UNIT_FORCE
                                          : UNIT_NONE,
             text[3]);
  PetscCall(PetscPrintf(comm, "%sstopped at t = %s: ", rod, text[0]));
  if (event->kind == EVENT_LENGTH)
    PetscCall(PetscPrintf(comm, "length %s\n", text[3]));
  else if (event->kind == EVENT_CONTACT && event->s[1] < 0)
    PetscCall(PetscPrintf(comm, "touches a wall at s = %s\n", text[1]));
  else if (event->kind == EVENT_FORCE)
    PetscCall(PetscPrintf(comm, "pushed with %s at s = %s\n", text[3], text[1]));
  else if (event->kind == EVENT_STALL)
    PetscCall(PetscPrintf(comm, "growth slowed down to %s of its speed without force\n", text[3]));
  else if (event->kind == EVENT_ANGLE)
    PetscCall(PetscPrintf(comm, "an angle of %s at s = %s\n", text[3], text[1]));
  else if (*rod)
    PetscCall(PetscPrintf(comm, "touches a rod at s = %s\n", text[1]));
  else
    PetscCall(PetscPrintf(comm, "touches itself at s = %s and %s\n", text[1], text[2]));
  PetscFunctionReturn(0);
}

/* The state once more, in the laboratory: all lengths in one unit. */
static PetscErrorCode TellLaboratory(const Grow *self) {
  const Observation *seen = &self->seen;
  PetscReal f;
  const char *unit = OptionShownIn(seen->length, UNIT_LENGTH, &f);
  char time[32], third[32] = "";

  PetscFunctionBegin;
  if (!unit) PetscFunctionReturn(0);
  if (self->scene->space.rod)
    (void)snprintf(third, sizeof(third), ", %.6g", (double)(f * seen->tip_x3));
  OptionInLaboratory(seen->t, UNIT_TIME, time);
  PetscCall(
      PetscPrintf(self->scene->comm,
                  "in the laboratory: %s%s%slength %.6g %s, tip (%.6g, %.6g%s) %s, |x2| %.6g %s\n",
                  time[0] ? "t = " : "", time, time[0] ? ", " : "", (double)(f * seen->length),
                  unit, (double)(f * seen->tip_x1), (double)(f * seen->tip_x2), third, unit,
                  (double)(f * seen->norm_x2), unit));
  PetscFunctionReturn(0);
}

/* Where a step was longer than a mode takes to grow, the rod may have gone to either side. */
static PetscErrorCode TellSides(const Grow *self) {
  TSType type;

  PetscFunctionBegin;
  if (!self->kept.blind) PetscFunctionReturn(0);
  PetscCall(TSGetType(self->now->ts, &type));
  PetscCall(
      PetscPrintf(self->scene->comm,
                  "In %d step%s of -ts_type %s a bend grew faster than they can follow: to "
                  "which side the rod gave way is not known; take vbdf, or a shorter -ts_dt.\n",
                  (int)self->kept.blind, self->kept.blind == 1 ? "" : "s", type));
  PetscFunctionReturn(0);
}

/* Where nothing pushes a rod in space out of its plane, it stays in that, stable or not. */
static PetscErrorCode TellPlane(const Grow *self) {
  char text[64];
  PetscBool leaves;

  PetscFunctionBegin;
  PetscCall(LegLeavesPlane(self->now, self->now->U, self->seen.t, &leaves));
  if (!leaves) PetscFunctionReturn(0);
  PetscCall(PetscPrintf(
      self->scene->comm,
      "The shape is unstable out of its plane, and nothing here pushes the rod out of that: to see "
      "where it falls give it a slight push, -rod_curvature_2 %s, or 1e-5 of -rod_weight along "
      "x3.\n",
      OptionBoth(grow_rule.slight_push / self->seen.length, UNIT_CURVATURE, text)));
  PetscFunctionReturn(0);
}

/* A rod that is straight, and is not bent by nature, has nothing that says to which side it bends:
   either it began so, or it has forgotten how it began. (Of one that gave up while it was pressed
   against something another line says so.) */
static PetscErrorCode TellStraight(const Grow *self) {
  const PetscReal angle = self->seen.max_angle;
  const Shape *shape = &self->scene->shape;
  const PetscReal began = shape->type == SHAPE_FILE       ? 1
                          : shape->type == SHAPE_STRAIGHT ? 0
                                                          : PetscAbsReal(shape->amplitude);

  PetscFunctionBegin;
  if (CurvatureBends(&self->scene->curvature)) PetscFunctionReturn(0);
  if (self->seen.contacts > 0 && self->seen.t < self->scene->end_time && !self->event.kind)
    PetscFunctionReturn(0);
  if (began == 0 && angle <= grow_rule.straight_angle)
    PetscCall(PetscPrintf(self->scene->comm,
                          "The rod stayed straight: nothing bends it; give it a -rod_curvature, or "
                          "to begin with a -shape_type and its -shape_amplitude.\n"));
  else if (angle <= grow_rule.straight_forgotten * began)
    PetscCall(PetscPrintf(self->scene->comm,
                          "The rod has become straight, to an angle of %.0e: it has forgotten the "
                          "shape it began with; a -rod_curvature bends it for good.\n",
                          (double)angle));
  PetscFunctionReturn(0);
}

/* GrowCount - Newton iterations and rejected tries of steps: of this run and
   of those that it goes on with. */
PetscErrorCode GrowCount(const Grow *self, PetscReal counted[2]) {
  PetscInt n;

  PetscFunctionBegin;
  for (int k = 0; k < 2; k++) counted[k] = self->counted[k];
  for (int m = 0; m < MODELS; m++)
    if (self->leg[m].ts) {
      PetscCall(TSGetSNESIterations(self->leg[m].ts, &n));
      counted[0] += n;
      PetscCall(TSGetStepRejections(self->leg[m].ts, &n));
      counted[1] += n;
    }
  PetscFunctionReturn(0);
}

/* Growth that feels force and has stalled: by what most of the thrust is taken. */
static PetscErrorCode TellStall(const Grow *self) {
  const Observation *seen = &self->seen;
  const Load *load = &self->scene->load;
  const PetscReal taken[] = {hypot(seen->friction_force_1, seen->friction_force_2),
                             hypot(seen->wall_force_1, seen->wall_force_2),
                             hypot(seen->tip_force_1, seen->tip_force_2),
                             load->weighs ? hypot(seen->weight_force_1, seen->weight_force_2) : 0};
  static const char *const by[] = {"friction takes", "walls take", "what presses on the tip takes",
                                   "the rod's weight takes"};
  char text[2][64];
  int most = 0;

  PetscFunctionBegin;
  if (!GrowStalls(self)) PetscFunctionReturn(0);
  for (int k = 1; k < (int)PETSC_STATIC_ARRAY_LENGTH(taken); k++)
    if (taken[k] > taken[most]) most = k;
  PetscCall(PetscPrintf(self->scene->comm,
                        "stalled at length %s: %s all that growth can push (-growth_yield %s)\n",
                        OptionBoth(seen->length, UNIT_LENGTH, text[0]), by[most],
                        OptionBoth(self->scene->growth->yield, UNIT_FORCE, text[1])));
  PetscFunctionReturn(0);
}

/* GrowTellEvents - what has ended the run, or was to and has not.

   rod  "NAME: " of several; "": there is one */
PetscErrorCode GrowTellEvents(const Grow *self, const char *rod) {
  PetscFunctionBegin;
  PetscCall(TellEvent(self, rod));
  PetscCall(TellNotReached(self, rod));
  PetscFunctionReturn(0);
}

/* GrowSummary - the last words on a run. Collective. */
PetscErrorCode GrowSummary(Grow *self) {
  const Observation *seen = &self->seen;
  const PetscBool space = self->scene->space.rod;
  PetscInt steps;
  PetscReal counted[2];
  char text[4][32];
  PetscLogDouble now;

  PetscFunctionBegin;
  PetscCall(TSGetStepNumber(self->now->ts, &steps));
  PetscCall(GrowCount(self, counted));
  PetscCall(PetscTime(&now));
  if (self->quiet) PetscFunctionReturn(0);
  PetscCall(PetscPrintf(self->scene->comm, "t = %s: length %s, tip (%s, %s",
                        OptionNumber(seen->t, text[0]), OptionNumber(seen->length, text[1]),
                        OptionNumber(seen->tip_x1, text[2]), OptionNumber(seen->tip_x2, text[3])));
  if (space)
    PetscCall(PetscPrintf(self->scene->comm, ", %s), |x2| %.8e, |x3| %.8e\n",
                          OptionNumber(seen->tip_x3, text[0]), (double)seen->norm_x2,
                          (double)seen->norm_x3));
  else
    PetscCall(PetscPrintf(self->scene->comm, "), |x2| %.8e\n", (double)seen->norm_x2));
  PetscCall(TellLaboratory(self));
  PetscCall(TellClamp(self));
  PetscCall(PetscPrintf(self->scene->comm, "%d steps, %d rejected, %d Newton iterations, %.3f s; ",
                        (int)steps, (int)counted[1], (int)counted[0], now - self->pace.begin));
  PetscCall(TellErrors(self, self->kept.snaps));
  PetscCall(TellSides(self));
  PetscCall(TellPlane(self));
  PetscCall(TellStraight(self));
  PetscCall(TellContact(self));
  PetscCall(TellStall(self));
  PetscCall(GrowTellEvents(self, ""));
  if (!OutputStores(self->output))
    PetscCall(PetscPrintf(self->scene->comm, "nothing is stored; -output FILE keeps the result\n"));
  PetscFunctionReturn(0);
}
