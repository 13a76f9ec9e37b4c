#include "world/surfaces.h"
#include "base/extremes.h"
#include "base/vectors.h"
#include <stdint.h>
#include <string.h>

static const SurfaceKind *const kinds[] = {&surface_plane, &surface_sphere, &surface_cylinder,
                                           &surface_cone,  &surface_torus,  &surface_tube,
                                           &surface_body};
enum { KINDS = PETSC_STATIC_ARRAY_LENGTH(kinds), OF_PLANE = 6 };

static const SurfaceKind *KindOf(const char *name) {
  for (size_t k = 0; k < KINDS; k++)
    if (!strcmp(name, kinds[k]->name)) return kinds[k];
  return NULL;
}

/* SurfacesKnow - do the words of a line say a surface in space? One word, plane, is known in the
   plane, too: there with four numbers. */
PetscBool SurfacesKnow(PetscInt n, char *const word[]) {
  const SurfaceKind *kind = KindOf(word[0]);
  PetscInt numbers = 0;

  while (numbers + 1 < n && strcmp(word[numbers + 1], "friction") && !MotionWord(word[numbers + 1]))
    numbers++;
  return (PetscBool)(kind && (kind != &surface_plane || numbers >= OF_PLANE));
}

/* SurfaceNumber - word k of a line as a number; lengths may carry units. Collective. */
PetscErrorCode SurfaceNumber(const SurfaceLine *line, PetscInt k, Dimension dimension,
                             PetscReal *value) {
  char what[PETSC_MAX_PATH_LEN];

  PetscFunctionBegin;
  (void)snprintf(what, sizeof(what), "-wall_file %s, line %d:", line->file, line->line);
  PetscCall(OptionQuantity(what, line->word[k], dimension, value));
  PetscFunctionReturn(0);
}

/* SurfaceMalformed - the error of a line that does not have the form of its kind. */
PetscErrorCode SurfaceMalformed(const SurfaceLine *line, const SurfaceKind *kind) {
  PetscFunctionBegin;
  UserCheck(
      PETSC_FALSE, OptionsComm(),
      "-wall_file %s, line %d: give %s; behind it moves or turns, if it moves, and friction MU "
      "last, if it has its own",
      line->file, line->line, kind->form);
  PetscFunctionReturn(0);
}

/* Takes `friction MU` off the end of a line's words. */
static PetscErrorCode TakeFriction(SurfaceLine *line, Surface *surface) {
  PetscFunctionBegin;
  if (line->n < 3 || strcmp(line->word[line->n - 2], "friction")) PetscFunctionReturn(0);
  PetscCall(SurfaceNumber(line, line->n - 1, UNIT_NONE, &surface->friction));
  UserCheck(surface->friction >= 0 && surface->friction <= 100, OptionsComm(),
            "-wall_file %s, line %d: friction must be from 0 to 100", line->file, line->line);
  line->n -= 2;
  PetscFunctionReturn(0);
}

/* SurfacesAdd - one more surface, as a line says; friction if it has none of its own. Collective on
   OptionsComm(). */
PetscErrorCode SurfacesAdd(const SurfaceLine *line, PetscReal friction, Surfaces *surfaces) {
  SurfaceLine rest = *line;
  Surface *surface;

  PetscFunctionBegin;
  if (surfaces->n == surfaces->room) {
    surfaces->room = 2 * surfaces->room + 4;
    PetscCall(PetscRealloc(surfaces->room * sizeof(Surface), &surfaces->surface));
  }
  surface = &surfaces->surface[surfaces->n++];
  PetscCall(PetscMemzero(surface, sizeof(*surface)));
  surface->kind = KindOf(line->word[0]);
  surface->line = line->line;
  for (PetscInt k = 1; k < line->n; k++)
    if (!strcmp(line->word[k], "inside")) surface->hollow = PETSC_TRUE;
  surface->friction = friction;
  surface->box = SurfaceEverywhere();
  surface->smallest = surface->core = surface->room = PETSC_MAX_REAL;
  PetscCall(TakeFriction(&rest, surface));
  PetscCall(MotionTake(rest.file, rest.line, &rest.n, rest.word, &surface->motion));
  PetscCall(surface->kind->make(&rest, surface));
  if (!surface->ridges && surface->smallest < PETSC_MAX_REAL)
    surface->ridge[surface->ridges++] =
        (SurfaceRidge){surface->data, surface->smallest, PETSC_MAX_REAL};
  PetscFunctionReturn(0);
}

/* Whether a surface stays somewhere, in its box. */
static PetscBool IsPlaced(const Surface *surface) {
  const PetscReal bound = 1e299;

  if (surface->motion.any) return PETSC_FALSE;
  for (int d = 0; d < 3; d++)
    if (surface->box.low[d] < -bound || surface->box.high[d] > bound) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* What stands out of them: first what may be anywhere. */
static PetscErrorCode IndexRidges(Surfaces *self) {
  PetscInt n = 0, far = 0;
  Block *block;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++) n += self->surface[k].ridges;
  PetscCall(PetscMalloc1(n, &self->ridge));
  PetscCall(PetscMalloc1(n, &block));
  for (int placed = 0; placed < 2; placed++) {
    for (PetscInt k = 0; k < self->n; k++)
      for (PetscInt j = 0; j < self->surface[k].ridges; j++) {
        if ((int)IsPlaced(&self->surface[k]) != placed) continue;
        if (placed) block[self->ridges - far] = self->surface[k].box;
        self->ridge[self->ridges++] = (struct SurfaceRidgeItem){k, j};
      }
    if (!placed) self->far_ridges = far = self->ridges;
  }
  PetscCall(BlocksCreate(3, self->ridges - far, block, &self->near_ridges));
  PetscCall(PetscFree(block));
  PetscFunctionReturn(0);
}

/*
  What is seen from a place. Residual, derivatives, observer and all that looks at a step ask for
  the same places, one after the other: each is looked from once, and what is told again is what was
  told, to the last digit.
*/
enum { VIEW_BITS = 11, VIEWS = 1 << VIEW_BITS, VIEW_MOST = 2 };
struct _SurfaceView {
  PetscReal x[3], time;
  PetscReal none;    /* nothing is nearer than this */
  PetscReal nearest; /* the distance of the nearest surface, which; PETSC_MAX_REAL: not known */
  PetscInt which;
  PetscReal within; /* all that are nearer than this are listed; 0: none is */
  PetscInt n, list[VIEW_MOST];
  SurfacePoint point[VIEW_MOST];
};

/* (To see a plane takes no longer than to look up what was seen of it.) */
static PetscErrorCode OpenViews(Surfaces *self) {
  PetscBool worth = PETSC_FALSE;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++)
    if (self->surface[k].kind != &surface_plane) worth = PETSC_TRUE;
  if (!worth) PetscFunctionReturn(0);
  PetscCall(PetscCalloc1(VIEWS, &self->view));
  for (PetscInt k = 0; k < VIEWS; k++) self->view[k].time = NAN;
  PetscFunctionReturn(0);
}

/* The view from a place at this time, in place of another if it is new; NULL: none is kept. */
static SurfaceView *ViewFrom(const Surfaces *self, const PetscReal x[3]) {
  SurfaceView *view;
  uint64_t bits[3];

  if (!self->view) return NULL;
  memcpy(bits, x, sizeof(bits));
  bits[0] = (bits[0] ^ bits[1] * 0xC2B2AE3D27D4EB4Fu ^ bits[2] * 0x165667B19E3779F9u) *
            0x9E3779B97F4A7C15u;
  view = &self->view[bits[0] >> (64 - VIEW_BITS)];
  if (view->x[0] == x[0] && view->x[1] == x[1] && view->x[2] == x[2] && view->time == self->time)
    return view;
  for (int d = 0; d < 3; d++) view->x[d] = x[d];
  view->time = self->time;
  view->none = view->within = 0;
  view->nearest = PETSC_MAX_REAL;
  return view;
}

/* SurfacesIndex - puts them where a place finds those near it. Not collective. */
PetscErrorCode SurfacesIndex(Surfaces *self) {
  PetscInt placed = 0;
  Block *block;

  PetscFunctionBegin;
  self->smallest = PETSC_MAX_REAL;
  PetscCall(PetscMalloc1(self->n, &block));
  PetscCall(PetscMalloc2(self->n, &self->placed, self->n, &self->open));
  for (PetscInt k = 0; k < self->n; k++) {
    const Surface *surface = &self->surface[k];
    if (IsPlaced(surface)) {
      block[placed] = surface->box;
      self->placed[placed++] = k;
    } else
      self->open[self->opens++] = k;
    if (surface->friction > 0) self->rub = PETSC_TRUE;
    self->smallest = PetscMin(self->smallest, surface->smallest);
  }
  PetscCall(BlocksCreate(3, placed, block, &self->near));
  PetscCall(PetscFree(block));
  PetscCall(IndexRidges(self));
  PetscCall(OpenViews(self));
  PetscFunctionReturn(0);
}

static PetscErrorCode DropIndex(Surfaces *self) {
  PetscFunctionBegin;
  PetscCall(PetscFree(self->view));
  PetscCall(BlocksDestroy(&self->near));
  PetscCall(BlocksDestroy(&self->near_ridges));
  PetscCall(PetscFree(self->ridge));
  PetscCall(PetscFree2(self->placed, self->open));
  self->opens = self->ridges = self->far_ridges = 0;
  PetscFunctionReturn(0);
}

/* SurfacesIndexAnew - the same again, where what moves has changed; nothing is known any more of
   what was seen. Not collective. */
PetscErrorCode SurfacesIndexAnew(Surfaces *self) {
  PetscFunctionBegin;
  PetscCall(DropIndex(self));
  PetscCall(SurfacesIndex(self));
  PetscFunctionReturn(0);
}

PetscErrorCode SurfacesDestroy(Surfaces *self) {
  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++) {
    Surface *surface = &self->surface[k];
    for (PetscInt j = 0; j < surface->ridges; j++)
      if (surface->ridge[j].data != surface->data)
        PetscCall(surface->kind->destroy(&surface->ridge[j].data));
    if (surface->data) PetscCall(surface->kind->destroy(&surface->data));
    PetscCall(MotionDestroy(&surface->motion));
    PetscCall(PetscFree(surface->text));
  }
  PetscCall(DropIndex(self));
  PetscCall(PetscFree(self->surface));
  self->n = self->room = 0;
  PetscFunctionReturn(0);
}

/* SurfacesText - the surfaces as a file has them, dimensionless. The caller frees the text
   (PetscFree). */
PetscErrorCode SurfacesText(const Surfaces *self, char **text) {
  enum { MORE = 40 };
  size_t room = 1, at = 0;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(room, text));
  for (PetscInt k = 0; k < self->n; k++) {
    const Surface *surface = &self->surface[k];
    char *moves;
    PetscCall(MotionText(&surface->motion, &moves));
    room += strlen(surface->text) + strlen(moves) + MORE;
    PetscCall(PetscRealloc(room, text));
    at += (size_t)snprintf(*text + at, room - at, "%s%s friction %.17g\n", surface->text, moves,
                           (double)surface->friction);
    PetscCall(PetscFree(moves));
  }
  PetscFunctionReturn(0);
}

/* ---- moving ---- */

/* A surface that moves, or what stands out of it, where it is at the time. */
static PetscBool MovedAt(const Surfaces *self, const Surface *surface, const void *data,
                         const PetscReal x[3], PetscReal within, SurfacePoint *point) {
  const SurfaceMotion *m = &surface->motion;
  const PetscReal angle = MotionTurned(m, self->time);
  PetscReal shift[3], o[3], y[3], H[3][3], part[3];
  SurfacePoint given;

  MotionShift(m, self->time, shift);
  for (int d = 0; d < 3; d++) o[d] = x[d] - shift[d] - m->at[d];
  TurnAbout3(m->axis, -angle, o, y);
  for (int d = 0; d < 3; d++) y[d] += m->at[d];
  if (!surface->kind->at(data, y, within, &given)) return PETSC_FALSE;
  point->distance = given.distance;
  TurnAbout3(m->axis, angle, given.normal, point->normal);
  for (int d = 0; d < 3; d++) TurnAbout3(m->axis, angle, given.bend[d], H[d]); /* rows: H R^T */
  for (int c = 0; c < 3; c++) {
    PetscReal column[3];
    Column3(H[0], 3, c, column);
    TurnAbout3(m->axis, angle, column, part);
    for (int d = 0; d < 3; d++) point->bend[d][c] = part[d];
  }
  return PETSC_TRUE;
}

/* SurfaceShifted - how far a place would be from a surface that is displaced by so much at t. */
PetscReal SurfaceShifted(const Surface *surface, PetscReal t, const PetscReal shift[3],
                         const PetscReal x[3]) {
  Surface moved = *surface;
  const Surfaces one = {.n = 1, .surface = &moved, .time = t};
  SurfacePoint point;

  for (int d = 0; d < 3; d++) LeadTo(&moved.motion.lead[d], t, shift[d], 0, t, shift[d]);
  moved.motion.any = moved.motion.led = PETSC_TRUE;
  return MovedAt(&one, &moved, moved.data, x, PETSC_MAX_REAL, &point) ? point.distance
                                                                      : PETSC_MAX_REAL;
}

/* SurfaceMiddle - about which one turns whose line does not say it: the first place in that, or, of
   what a file gives, the middle of the box that holds it. */
void SurfaceMiddle(const Surface *self, PetscReal x[3]) {
  double at[3];

  if (self->kind->known == SURFACE_EXACT &&
      sscanf(self->text, "%*s %lf %lf %lf", &at[0], &at[1], &at[2]) == 3) {
    for (int d = 0; d < 3; d++) x[d] = at[d];
    return;
  }
  for (int d = 0; d < 3; d++) x[d] = (self->box.low[d] + self->box.high[d]) / 2;
}

/* SurfacesJerk - does any of them set out or stop at once between two times? */
PetscBool SurfacesJerk(const Surfaces *self, PetscReal t0, PetscReal t1) {
  for (PetscInt k = 0; k < self->n; k++)
    if (MotionJerks(&self->surface[k].motion, t0, t1)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* SurfacesNextTurn - the first time behind t at which one that moves as given in time sets out,
   stops or turns back; PETSC_MAX_REAL if there is none. */
PetscReal SurfacesNextTurn(const Surfaces *self, PetscReal t) {
  PetscReal next = PETSC_MAX_REAL;

  for (PetscInt k = 0; k < self->n; k++)
    next = SmallerOf(next, MotionNextTurn(&self->surface[k].motion, t));
  return next;
}

/* ---- looking ---- */

/* One look from a place. */
typedef struct {
  const Surfaces *self;
  const PetscReal *x;
  PetscReal within; /* what is nearer is taken note of, or, if only the nearest is wanted, the
                       distance so far */
  PetscInt n, *which;
  SurfacePoint *point; /* NULL: only the nearest is wanted */
} Look;

/* Takes note of a surface, in the order of their numbers: what is summed up does not depend on the
   order in which they are found. */
static void LookAt(Look *look, PetscInt k) {
  const Surface *surface = &look->self->surface[k];
  SurfacePoint at;
  PetscInt i = look->n;

  if (surface->motion.any) {
    if (!MovedAt(look->self, surface, surface->data, look->x, look->within, &at)) return;
  } else if (!SurfaceAt(surface, look->x, look->within, &at))
    return;
  if (at.distance >= look->within) return;
  if (!look->point) {
    look->within = at.distance;
    *look->which = k;
    return;
  }
  if (look->n == MOST_SURFACES) return;
  for (; i > 0 && look->which[i - 1] > k; i--) {
    look->which[i] = look->which[i - 1];
    look->point[i] = look->point[i - 1];
  }
  look->which[i] = k;
  look->point[i] = at;
  look->n++;
}

static PetscReal Meet(PetscInt item, PetscReal reach, void *ctx) {
  Look *look = (Look *)ctx;

  LookAt(look, look->self->placed[item]);
  return PetscMax(0, look->point ? reach : PetscMin(reach, look->within));
}

static void LookAround(Look *look) {
  const Block place = BlockAt(3, look->x);

  for (PetscInt k = 0; k < look->self->opens; k++) LookAt(look, look->self->open[k]);
  BlocksNear(look->self->near, &place, PetscMax(0, look->within), Meet, look);
}

/*
  SurfacesNear - the surfaces that are nearer to x than `within`.

  which, point  of each, its number and how it looks, by numbers
  Returns how many there are; MOST_SURFACES: there may be more.
*/
PetscInt SurfacesNear(const Surfaces *self, const PetscReal x[3], PetscReal within,
                      PetscInt which[MOST_SURFACES], SurfacePoint point[MOST_SURFACES]) {
  Look look = {.self = self, .x = x, .within = within, .which = which, .point = point};
  SurfaceView *view;

  if (!self->n) return 0;
  view = ViewFrom(self, x);
  if (view && within > 0 && within <= view->none) return 0;
  if (view && within > 0 && within == view->within) {
    for (PetscInt k = 0; k < view->n; k++) {
      which[k] = view->list[k];
      point[k] = view->point[k];
    }
    return view->n;
  }
  LookAround(&look);
  if (view && !look.n) view->none = PetscMax(view->none, within);
  if (view && look.n <= VIEW_MOST) {
    view->within = within;
    view->n = look.n;
    for (PetscInt k = 0; k < look.n; k++) {
      view->list[k] = which[k];
      view->point[k] = point[k];
    }
  }
  return look.n;
}

/* What a view tells of the nearest surface, if it does. */
static PetscBool Tells(const SurfaceView *view, PetscReal within, PetscReal *distance,
                       PetscInt *nearest) {
  PetscReal known = view->nearest;
  PetscInt which = view->which;

  *distance = within;
  if (within <= view->none) return PETSC_TRUE;
  if (known == PETSC_MAX_REAL && view->within > 0 && view->n == 1) { /* (of two as near, one) */
    known = view->point[0].distance;
    which = view->list[0];
  }
  if (known == PETSC_MAX_REAL) return PETSC_FALSE;
  if (known < within) {
    *distance = known;
    *nearest = which;
  }
  return PETSC_TRUE;
}

/* SurfacesDistance - the least distance of x to any surface, if that is below `within`; else that.
   nearest: its number, unchanged if there is none. */
PetscReal SurfacesDistance(const Surfaces *self, const PetscReal x[3], PetscReal within,
                           PetscInt *nearest) {
  PetscInt found = -1;
  Look look = {.self = self, .x = x, .within = within, .which = &found};
  SurfaceView *view;
  PetscReal distance;

  if (!self->n) return within;
  view = ViewFrom(self, x);
  if (view && within > 0 && Tells(view, within, &distance, nearest)) return distance;
  LookAround(&look);
  if (found >= 0) *nearest = found;
  if (view && found >= 0) {
    view->nearest = look.within;
    view->which = found;
  } else if (view)
    view->none = PetscMax(view->none, within);
  return look.within;
}

/* ---- what stands out ---- */

/* SurfacesRidgesNear - tells of all that stands out of surfaces within reach of a place, and of
   what is not known to be farther, by numbers of items; see BlocksNear(). */
void SurfacesRidgesNear(const Surfaces *self, const Block *place, PetscReal reach, BlocksMeet meet,
                        void *ctx) {
  for (PetscInt k = 0; k < self->far_ridges; k++) (void)meet(k, reach, ctx);
  BlocksNearBehind(self->near_ridges, self->far_ridges, place, reach, meet, ctx);
}

/* SurfacesRidgeAt - an item of what stands out, as seen from x; false: it is farther away than
   `within`, or has nothing there. */
PetscBool SurfacesRidgeAt(const Surfaces *self, PetscInt item, const PetscReal x[3],
                          PetscReal within, SurfacePoint *point) {
  const Surface *surface = &self->surface[self->ridge[item].surface];
  const void *data = surface->ridge[self->ridge[item].ridge].data;

  if (surface->motion.any) return MovedAt(self, surface, data, x, within, point);
  return surface->kind->at(data, x, within, point);
}
