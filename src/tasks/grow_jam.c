/* -task grow: a run that gets nowhere. A rod that is jammed cannot grow on, and nothing tells so
   but that it is pressed ever harder into what is around it, or that steps get nowhere; one that
   slips and sticks in no time keeps steps for ever (as does one that crawls for any other reason:
   crawl.c). */
#include "tasks/growing.h"
#include "tasks/grow_rules.h"

/* GrowPressedHard - is it pressed with forces far above those of bending and of friction along the
   rod? */
PetscBool GrowPressedHard(const Grow *self) {
  return (PetscBool)(self->seen.contacts > 0 &&
                     self->seen.contact_force > grow_rule.jam_force * self->scene->contact.force);
}

/* Is it farther in a wall, or in itself, than a law of contact may let it? */
static PetscBool PressedDeep(const Contact *contact, const Observation *seen) {
  const PetscReal most = contact->diameter <= 0 ? grow_rule.jam_depth_thin * contact->tip
                         : contact->firm        ? grow_rule.jam_depth_stiffened * contact->smooth
                                                : grow_rule.jam_depth * contact->diameter;
  return (PetscBool)(ContactSoftDepth(contact, seen->penetration) > most);
}

/* GrowStalls - does a rod whose growth feels force hardly grow any more? */
PetscBool GrowStalls(const Grow *self) {
  return (PetscBool)(self->scene->growth->yield > 0 && self->seen.growth_rate < grow_rule.stalled);
}

/*
  GrowIsJammed - is the rod jammed, as far as the latest step tells? The same on every rank.
*/
PetscBool GrowIsJammed(Grow *self) {
  const Contact *contact = &self->scene->contact;
  const Observation *seen = &self->seen;

  if (!contact->any || seen->contacts == 0 ||
      self->kept.way > self->kept.window + grow_rule.jam_progress * seen->length) {
    self->kept.window = self->kept.way;
    self->kept.window_steps = 0;
  } else
    self->kept.window_steps++;
  if (!contact->any || GrowStalls(self) || !GrowPressedHard(self)) return PETSC_FALSE;
  return (PetscBool)(self->kept.window_steps >= grow_rule.jam_steps || PressedDeep(contact, seen));
}

/*
  GrowSlips - does a rod with weak friction across slip and slip again, each time in no time, so
  that it gets nowhere? The same on every rank. If so, it begins to count again.
*/
PetscBool GrowSlips(Grow *self) {
  if (!LoadMaySlip(&self->scene->load) ||
      self->kept.way > self->kept.slips_at + grow_rule.slip_progress * self->scene->end_time) {
    self->kept.slips_at = self->kept.way;
    self->kept.slips_steps = 0;
  } else
    self->kept.slips_steps++;
  if (self->kept.slips_steps < (LoadSharesMost(&self->scene->load)
                                    ? grow_rule.slip_at_last * grow_rule.slip_steps
                                    : grow_rule.slip_steps))
    return PETSC_FALSE;
  self->kept.slips_steps = 0;
  return PETSC_TRUE;
}

/* Did contact get firm of itself? */
static PetscBool GotFirm(const Contact *contact) {
  return (PetscBool)(contact->deepest && contact->firm);
}

/* Is it in touch with a wall that rubs? */
static PetscBool RubsOnWalls(const Grow *self) {
  return (PetscBool)(self->seen.contact_force > 0 && ContactWallsRub(&self->scene->contact));
}

/* GrowHeldTwice - ... while dry friction holds it, too: see crawl_held. */
PetscBool GrowHeldTwice(const Grow *self) {
  return (PetscBool)(RubsOnWalls(self) && 1 - self->scene->load.friction.mu < grow_rule.held_twice);
}

/* GrowCrawls - does the run advance too slowly to come to its end? The same on every rank. */
PetscBool GrowCrawls(Grow *self) {
  if (self->seen.t >= self->scene->end_time) return PETSC_FALSE;
  self->crawl.counts = (PetscBool)(GotFirm(&self->scene->contact) || RubsOnWalls(self));
  return (PetscBool)(CrawlStep(&self->crawl, self->seen.t, self->kept.way,
                               grow_rule.crawl_part * PetscMin(self->seen.length, self->end),
                               (PetscInt)self->seen.newton_iterations) &&
                     !self->crawl.allowed);
}

/* GrowFindsNoWay - has firm contact led it nowhere, so that it is to begin again with soft contact?
   Not if it gave up under great force: it is jammed, as it would be in soft contact a little later.
   Nor can a run that goes on from where another one ended. */
PetscBool GrowFindsNoWay(const Grow *self) {
  return (PetscBool)(!self->stopped && self->start == 0 && GotFirm(&self->scene->contact) &&
                     !(self->scene->changes && self->scene->changes->done) &&
                     (self->crawls || (self->reason < 0 && !GrowPressedHard(self))));
}

/* Where the tip is in the frame of the clamp. */
static void TipInClamp(const Scene scene, const Observation *seen, PetscReal x[3]) {
  const PetscReal *place = scene->space.place,
                  lab[3] = {seen->tip_x1 - place[0], seen->tip_x2 - place[1],
                            seen->tip_x3 - place[2]};

  SpaceFromLab(&scene->space, lab, x);
}

/*
  GrowFollowLamp - has the tip come nearer to the lamp than it can be sensed? There the direction
  to it turns round within a cell, or within next to nothing of the rod's length.

  last  the state before
*/
void GrowFollowLamp(Grow *self, const Observation *last) {
  const Scene scene = self->scene;
  const Mesh *mesh = &scene->mesh;
  PetscReal from[3], to[3], cell;

  if (scene->tropism.light == 0) return;
  TipInClamp(scene, last, from);
  TipInClamp(scene, &self->seen, to);
  cell = (mesh->s[mesh->cells] - mesh->s[mesh->cells - 1]) * self->seen.length;
  self->to_lamp = TropismNearLamp(&scene->tropism, from, to);
  self->blinded =
      (PetscBool)(self->to_lamp < PetscMax(cell, grow_rule.lamp_near * self->seen.length));
}

/* GrowTellLamp - the line for a run that ends for that; kept says what is left of it. */
PetscErrorCode GrowTellLamp(const Grow *self, const char *kept) {
  char text[2][64];

  PetscFunctionBegin;
  OptionBoth(self->seen.t, UNIT_TIME, text[0]);
  OptionBoth(self->to_lamp, UNIT_LENGTH, text[1]);
  UserCheck(!self->blinded, self->scene->comm,
            "-tropism_source: stopped at t = %s, where the tip came as near to the lamp as %s: so "
            "near the direction to it means nothing; %s; end the run before with -ts_max_time or "
            "-stop_length, or put the lamp farther away",
            text[0], text[1], kept);
  PetscFunctionReturn(0);
}

/*
  GrowTellJam - the line for a rod that is jammed, or that gave up under forces as large: where it
  is pressed in most, and with which push. Collective.

  gave_up  the stepper did
  line     empty if it is not jammed
*/
PetscErrorCode GrowTellJam(Grow *self, PetscBool gave_up, char line[], size_t room) {
  const Observation *seen = &self->seen;
  TouchSum touch = {.nearest = PETSC_MAX_REAL};
  PetscReal push = 0;
  const Node *nodes;
  char text[5][64], on[96];
  PetscInt where = 0;

  PetscFunctionBegin;
  line[0] = 0;
  /* (One that has not left its start is pressed by how it was laid down.) */
  if (!self->jammed && !(gave_up && seen->t > 0 && GrowPressedHard(self))) PetscFunctionReturn(0);
  PetscCall(ObserverGather(self->observer, self->now->rod, seen->t, self->now->U, NULL, &nodes));
  if (nodes) {
    PetscCall(ObserverTouch(self->observer, seen->t, nodes, &touch));
    push = PushLargest(self->scene->space.rod, self->scene->mesh.cells, nodes, &where);
  }
  OptionBoth(seen->t, UNIT_TIME, text[0]);
  OptionBoth(push, UNIT_FORCE, text[1]);
  OptionBoth(PetscMax(0, -touch.nearest), UNIT_LENGTH, text[2]);
  OptionNumber(touch.x[0], text[3]);
  OptionNumber(touch.x[1], text[4]);
  if (touch.at[1] < 0)
    (void)snprintf(on, sizeof(on), "into a wall at s = %.4g", (double)touch.at[0]);
  else
    (void)snprintf(on, sizeof(on), "into itself at s = %.4g and %.4g", (double)touch.at[0],
                   (double)touch.at[1]);
  (void)snprintf(line, room,
                 "jammed at t = %s: a push of %s presses the rod by %s %s, x = (%s, %s)", text[0],
                 text[1], text[2], on, text[3], text[4]);
  PetscFunctionReturn(0);
}
