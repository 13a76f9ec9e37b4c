/* -task grow: can a rod begin where it is, beside what it touches? */
#include "rod/passing.h"
#include "tasks/growing.h"
#include "tasks/grow_rules.h"

/* Refuses surfaces in space that are hollow and hardly wider than the rod: in their middle contact
   would press from all sides at once. */
static PetscErrorCode CheckRoom(Grow *self) {
  const Contact *contact = &self->scene->contact;
  char text[2][64];

  PetscFunctionBegin;
  for (PetscInt k = 0; k < contact->surfaces.n; k++) {
    const Surface *surface = &contact->surfaces.surface[k];
    const PetscReal stiffer = PetscPowReal(2 * contact->smooth / surface->room, 4. / 3);
    if (surface->room > contact->smooth) continue;
    UserCheck(PETSC_FALSE, self->scene->comm,
              "-wall_file, line %d: the %s is wider than the rod by only %s on all sides, and "
              "contact sets in %s from a wall: make it wider, or give -contact_stiffness %.1e",
              surface->line, surface->kind->name, OptionBoth(surface->room, UNIT_LENGTH, text[0]),
              OptionBoth(contact->smooth, UNIT_LENGTH, text[1]),
              (double)(contact->stiffness * stiffer));
  }
  PetscFunctionReturn(0);
}

/* Refuses a clamp that is behind a surface in space. */
static PetscErrorCode CheckClamp(Grow *self) {
  const Surfaces *surfaces = &self->scene->contact.surfaces;
  const PetscReal *clamp = self->scene->space.place;
  const Surface *surface;
  PetscInt nearest = -1;
  char text[96];

  PetscFunctionBegin;
  if (self->scene->clamp == CLAMP_FREE) PetscFunctionReturn(0);
  (void)SurfacesDistance(surfaces, clamp, 0, &nearest);
  if (nearest < 0) PetscFunctionReturn(0);
  surface = &surfaces->surface[nearest];
  UserCheck(
      !surface->hollow, self->scene->comm,
      "-wall_file, line %d: the rod starts in a wall: the clamp, at %s, is out of the %s that "
      "the rod is to be inside of; move it, or give outside",
      surface->line, OptionPlace(clamp, text), surface->kind->name);
  UserCheck(
      PETSC_FALSE, self->scene->comm,
      "-wall_file, line %d: the rod starts in a wall: the clamp, at %s, is behind the %s; move "
      "it, or take its other side",
      surface->line, OptionPlace(clamp, text), surface->kind->name);
  PetscFunctionReturn(0);
}

/* Says how near a rod begins to a wall, if contact sets in there already. */
static PetscErrorCode TellNear(const Grow *self, const TouchSum *touch) {
  const Contact *contact = &self->scene->contact;
  const PetscReal off = self->scene->stands_off;
  char text[2][64];

  PetscFunctionBegin;
  if (self->quiet) PetscFunctionReturn(0);
  OptionBoth(contact->smooth, UNIT_LENGTH, text[0]);
  if (off > 0)
    PetscCall(PetscPrintf(self->scene->comm,
                          "-wall_file: the rod begins at a wall, %s from it; contact sets in %s "
                          "before surfaces meet, and so the wall is taken so much farther off\n",
                          OptionBoth(contact->smooth - off, UNIT_LENGTH, text[1]), text[0]));
  if (touch->nearest < (1 - grow_rule.start_nearer) * contact->smooth && touch->at[1] < 0)
    PetscCall(PetscPrintf(
        self->scene->comm,
        "-wall_file: the rod begins %s from a wall at s = %g, and contact sets in "
        "%s before surfaces meet: it is pushed off at once; leave more room\n",
        OptionBoth(touch->nearest, UNIT_LENGTH, text[1]), (double)touch->at[0], text[0]));
  PetscFunctionReturn(0);
}

/* Refuses a rod that starts in a wall, or touching itself. */
static PetscErrorCode CheckStart(Grow *self) {
  const Contact *contact = &self->scene->contact;
  TouchSum touch = {.nearest = PETSC_MAX_REAL};
  const Node *nodes;
  char text[64];

  PetscFunctionBegin;
  if (!contact->any) PetscFunctionReturn(0);
  PetscCall(CheckClamp(self));
  PetscCall(CheckRoom(self));
  PetscCall(ObserverGather(self->observer, self->now->rod, 0, NULL, NULL, &nodes));
  if (nodes) PetscCall(ObserverTouch(self->observer, 0, nodes, &touch));
  PetscCallMPI(MPI_Bcast(&touch, sizeof(touch), MPI_BYTE, 0, self->scene->comm));
  OptionBoth(-touch.nearest, UNIT_LENGTH, text);
  UserCheck(
      touch.nearest >= -contact->smooth || touch.at[1] >= 0, self->scene->comm,
      "-wall_file: the rod starts in a wall, %s deep at s = %g; move the wall or make the rod "
      "thinner (-contact_diameter)",
      text, (double)touch.at[0]);
  UserCheck(touch.nearest >= -contact->smooth, self->scene->comm,
            "-contact_self: the rod touches itself at the start, at s = %g and %g; give another "
            "shape or a smaller -contact_diameter",
            (double)touch.at[0], (double)touch.at[1]);
  PetscCall(TellNear(self, &touch));
  PetscFunctionReturn(0);
}

/* Refuses a rod that starts behind a polygon's surface, or across a wall that is between two nodes.
 */
static PetscErrorCode CheckWalls(Grow *self) {
  const Walls *walls = &self->scene->contact.walls;
  const PetscReal *clamp = self->scene->contact.stand; /* in the frame of walls */
  const PetscInt behind = WallsBehind(walls, clamp);
  Rod rod = self->now->rod;
  PetscBool passes;

  PetscFunctionBegin;
  UserCheck(behind < 0, self->scene->comm,
            "-wall_file: the rod starts in a wall: the clamp is %s wall %d, a polygon %s; take the "
            "other of outside and inside, or move it",
            walls->wall[behind].inside ? "out of" : "in", (int)behind + 1,
            walls->wall[behind].inside ? "inside" : "outside");
  PetscCall(RodBegin(rod, self->now->U));
  PetscCall(RodPassesWalls(rod, 0, 0, self->now->U, self->now->U, &passes));
  UserCheck(!passes, self->scene->comm,
            "-wall_file: the rod starts in a wall, between two of its nodes: move the wall");
  PetscFunctionReturn(0);
}

/* Names what the rod is to be inside of and what does not hold its clamp. */
static PetscErrorCode NameBeside(Grow *self) {
  const Walls *walls = &self->scene->contact.walls;
  const Surfaces *surfaces = &self->scene->contact.surfaces;
  const PetscReal *clamp = self->scene->space.place;

  PetscFunctionBegin;
  if (self->quiet) PetscFunctionReturn(0);
  for (PetscInt w = 0; w < walls->n; w++)
    if (!WallsHold(walls, w, self->scene->contact.stand))
      PetscCall(
          PetscPrintf(self->scene->comm,
                      "-wall_file: wall %d, a path, does not hold the clamp: the rod is out of "
                      "it, unless it comes in through a mouth\n",
                      (int)w + 1));
  if (self->scene->clamp == CLAMP_FREE) PetscFunctionReturn(0);
  for (PetscInt k = 0; k < surfaces->n; k++)
    if (!SurfaceHolds(&surfaces->surface[k], clamp))
      PetscCall(
          PetscPrintf(self->scene->comm,
                      "-wall_file, line %d: the %s does not hold the clamp: the rod is out of "
                      "it, unless it comes in through an open end\n",
                      surfaces->surface[k].line, surfaces->surface[k].kind->name));
  PetscFunctionReturn(0);
}

/* GrowCheckStart - refuses a rod that begins in something, and names what is beside it. Collective.
 */
PetscErrorCode GrowCheckStart(Grow *self) {
  PetscFunctionBegin;
  PetscCall(CheckStart(self));
  if (self->scene->contact.walls.n || self->scene->contact.surfaces.n) PetscCall(CheckWalls(self));
  PetscCall(NameBeside(self));
  PetscFunctionReturn(0);
}
