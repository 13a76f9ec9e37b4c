/* Events that end a run: a length, an angle, a push, a stall, the first contact, or that of a rod
   that may cross itself. Here is what they are and where on the rod; the time stepping locates them
   in time. */
#ifndef TENDRIL_EVENT_H
#define TENDRIL_EVENT_H

#include "record/observe.h"

typedef enum {
  EVENT_NONE,
  EVENT_SELF_CONTACT,
  EVENT_LENGTH,
  EVENT_ANGLE,
  EVENT_CONTACT,
  EVENT_FORCE,
  EVENT_STALL,
  EVENT_KINDS
} EventKind;
extern const char *const event_name[EVENT_KINDS];

/* What to watch for. */
typedef struct {
  PetscBool watched[EVENT_KINDS], any;
  PetscReal bound[EVENT_KINDS]; /* diameter, length, angle, force, speed */
} Watch;

/* What happened: s the one or two labels concerned, x the place (in the clamp's frame). */
typedef struct {
  EventKind kind;
  PetscReal t, s[2], x[3];
} Event;

extern const OptionGroup event_options;

PetscErrorCode WatchSetFromOptions(Watch *watch, Scene scene);
PetscErrorCode WatchLook(const Watch *watch, Observer observer, Scene scene, PetscReal t,
                         const Node *nodes, Event *event);
PetscReal PushLargest(PetscBool space, PetscInt cells, const Node *nodes, PetscInt *where);
PetscErrorCode EventContact(PetscInt cells, const PetscReal s[], const Node *nodes,
                            PetscReal diameter, Event *event);

#endif
