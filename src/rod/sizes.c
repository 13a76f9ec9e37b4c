/* How large the fields of a rod are, and by what changes of them are measured. */
#include "rod/learned.h"
#include "rod/rules.h"

/* RodFieldSizes - max |U| of each field over the rod (LargerSize()). Collective. */
PetscErrorCode RodFieldSizes(Rod rod, Vec U, PetscReal size[MAX_FIELDS]) {
  PetscInt fields = rod->model->fields, n = (rod->end - rod->first) * fields;
  const PetscScalar *u;

  PetscFunctionBegin;
  for (PetscInt f = 0; f < fields; f++) size[f] = 0;
  PetscCall(VecGetArrayRead(U, &u));
  for (PetscInt i = 0; i < n; i += fields)
    for (PetscInt f = 0; f < fields; f++) size[f] = LargerSize(size[f], PetscAbsReal(u[i + f]));
  PetscCall(VecRestoreArrayRead(U, &u));
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, size, (PetscMPIInt)fields, MPIU_REAL, MPI_MAX, rod->scene->comm));
  PetscFunctionReturn(0);
}

/*
  Axes across. Of a rod in space that is bent in a plane, what happens in it is measured against how
  far it is bent, what happens out of it against what is out of it, however that plane is turned
  about the axis of the clamp: along the principal axes of the sum over the nodes of the second
  moments of (x2, x3), which for a rod all but in the plane of x1 and x2 are the coordinates, to the
  last of 250 orders of magnitude between them. All pairs of fields across are taken along these.
*/

static const Vector2 coordinate = {1, 0};

/* RodAxes - the first of the axes across along which a state is measured, at most 45 degrees from
   that of the coordinates; (1, 0) for a rod in the plane. Collective. */
PetscErrorCode RodAxes(Rod rod, Vec U, const PetscReal size[MAX_FIELDS], Vector2 *axis) {
  const RodModel *model = rod->model;
  const Pair *x = model->pair;
  PetscInt fields = model->fields, n = (rod->end - rod->first) * fields;
  PetscReal sum[3] = {0}, ratio, angle, most, least;
  const PetscScalar *u;

  PetscFunctionBegin;
  *axis = coordinate;
  if (!model->pairs) PetscFunctionReturn(0);
  most = PetscMax(size[x->along], size[x->beside]);
  least = PetscMin(size[x->along], size[x->beside]);
  if (!(least > 0) || least <= rod_rule.vanished || PetscIsInfOrNanReal(most))
    PetscFunctionReturn(0);
  PetscCall(VecGetArrayRead(U, &u));
  for (PetscInt i = 0; i < n; i += fields) {
    PetscReal a = u[i + x->along] / size[x->along], b = u[i + x->beside] / size[x->beside];
    sum[0] += a * a;
    sum[1] += a * b;
    sum[2] += b * b;
  }
  PetscCall(VecRestoreArrayRead(U, &u));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 3, MPIU_REAL, MPI_SUM, rod->scene->comm));
  ratio = least / most; /* its square may be below the smallest number, and is of no account then */
  sum[1] *= ratio;
  sum[size[x->along] < size[x->beside] ? 0 : 2] *= ratio * ratio;
  if (sum[1] == 0) PetscFunctionReturn(0);
  angle = sum[0] == sum[2] ? PETSC_PI / 4 : atan(2 * sum[1] / (sum[0] - sum[2])) / 2;
  *axis = (Vector2){PetscCosReal(angle), PetscSinReal(angle)};
  PetscFunctionReturn(0);
}

/* The values of a pair at a node along the axes. */
static inline Vector2 Along(const Pair *pair, Vector2 axis, const PetscScalar *u) {
  const Vector2 across = {u[pair->along], pair->sign * u[pair->beside]};

  return (Vector2){Dot2(axis, across), Cross2(axis, across)};
}

/* RodTurn - turns a vector into the axes: the fields of each pair become its values along them. */
PetscErrorCode RodTurn(Rod rod, Vector2 axis, Vec V) {
  const RodModel *model = rod->model;
  PetscInt fields = model->fields, n = (rod->end - rod->first) * fields;
  PetscScalar *v;

  PetscFunctionBegin;
  if (axis.y == 0) PetscFunctionReturn(0);
  PetscCall(VecGetArray(V, &v));
  for (PetscInt i = 0; i < n; i += fields)
    for (PetscInt k = 0; k < model->pairs; k++) {
      const Vector2 value = Along(&model->pair[k], axis, v + i);
      v[i + model->pair[k].along] = value.x;
      v[i + model->pair[k].beside] = value.y;
    }
  PetscCall(VecRestoreArray(V, &v));
  PetscFunctionReturn(0);
}

/* RodSizesAlong - as RodFieldSizes(), of the pairs across along axes. Collective. */
PetscErrorCode RodSizesAlong(Rod rod, Vec U, Vector2 axis, PetscReal size[MAX_FIELDS]) {
  const RodModel *model = rod->model;
  PetscInt fields = model->fields, n = (rod->end - rod->first) * fields;
  PetscReal most[MAX_FIELDS] = {0};
  const PetscScalar *u;

  PetscFunctionBegin;
  PetscCall(RodFieldSizes(rod, U, size));
  if (axis.y == 0) PetscFunctionReturn(0);
  PetscCall(VecGetArrayRead(U, &u));
  for (PetscInt i = 0; i < n; i += fields)
    for (PetscInt k = 0; k < model->pairs; k++) {
      const Vector2 value = Along(&model->pair[k], axis, u + i);
      most[2 * k] = LargerSize(most[2 * k], PetscAbsReal(value.x));
      most[2 * k + 1] = LargerSize(most[2 * k + 1], PetscAbsReal(value.y));
    }
  PetscCall(VecRestoreArrayRead(U, &u));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, most, (PetscMPIInt)(2 * model->pairs), MPIU_REAL,
                             MPI_MAX, rod->scene->comm));
  for (PetscInt k = 0; k < model->pairs; k++) {
    size[model->pair[k].along] = most[2 * k];
    size[model->pair[k].beside] = most[2 * k + 1];
  }
  PetscFunctionReturn(0);
}

/* The sizes along the axes, none below what the coordinates, of these sizes, leave there. */
static void LeaveRoundOff(const RodModel *model, Vector2 axis, const PetscReal of[],
                          PetscReal size[]) {
  const PetscReal c = PetscAbsReal(axis.x), s = PetscAbsReal(axis.y);

  for (PetscInt k = 0; k < model->pairs && s > 0; k++) {
    const PetscInt a = model->pair[k].along, b = model->pair[k].beside;
    size[a] = PetscMax(size[a], rod_rule.across_round_off * (c * of[a] + s * of[b]));
    size[b] = PetscMax(size[b], rod_rule.across_round_off * (c * of[b] + s * of[a]));
  }
}

/* The larger of two vectors across, by their larger component. */
static Vector2 Larger(Vector2 n, Vector2 most) {
  const PetscReal of_n = PetscMax(PetscAbsReal(n.x), PetscAbsReal(n.y)),
                  so_far = PetscMax(PetscAbsReal(most.x), PetscAbsReal(most.y));

  return of_n > so_far ? n : most;
}

/* The walls that press on a node: the part of their normals that is across. */
static Vector2 PressedAcross(const Rod rod, const Node *node, Vector2 most) {
  Touch touch[MOST_TOUCHES];
  PetscInt n = ContactTouches(RodDims(rod->model), &rod->scene->contact, node->x, touch);

  for (PetscInt k = 0; k < n; k++) most = Larger(From2(touch[k].normal + 1), most);
  return most;
}

/*
  RodFeelWalls - how oblique the walls are that press on the rod, by the part of their normals that
  is across: by a push of order 1 they drive a rod that is straight, or all but, so far from where
  it was, and what it was says nothing of how far. It begins with next to nothing, as the push does.
  On a wall that is met straight on, or by a tip that goes round a post, that part is of the order
  of what is across already. Sets it for RodFieldScales(). Collective.
*/
PetscErrorCode RodFeelWalls(Rod rod, PetscReal t, Vec U) {
  PetscReal of_all[4];
  Vector2 most = {0, 0};
  PetscInt n = rod->end - rod->first;
  Node *nodes;

  PetscFunctionBegin;
  if (!rod->scene->contact.walls.n && !rod->scene->contact.surfaces.n) PetscFunctionReturn(0);
  PetscCall(SceneContactAt(rod->scene, t));
  PetscCall(PetscMalloc1(n, &nodes));
  PetscCall(rod->model->get(rod, t, U, NULL, nodes));
  for (PetscInt i = 0; i < n; i++) most = PressedAcross(rod, &nodes[i], most);
  PetscCall(PetscFree(nodes));
  Put2(most, of_all);
  Put2(Times2(-1, most), of_all + 2);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, of_all, 4, MPIU_REAL, MPI_MAX, rod->scene->comm));
  rod->oblique.x = of_all[0] >= of_all[2] ? of_all[0] : -of_all[2];
  rod->oblique.y = of_all[1] >= of_all[3] ? of_all[1] : -of_all[3];
  PetscFunctionReturn(0);
}

/* RodIsPlace - is this field a place? */
PetscBool RodIsPlace(const RodModel *model, PetscInt f) {
  return (PetscBool)(strchr("xy", model->field[f][0]) != NULL);
}

/* RodReach - the largest along any axis of the sizes of places, or of their rates. */
PetscReal RodReach(const RodModel *model, const PetscReal size[]) {
  PetscReal reach = 0;

  for (PetscInt f = 0; f < model->fields; f++)
    if (RodIsPlace(model, f)) reach = PetscMax(reach, size[f]);
  return reach;
}

/* What round-off of walls leaves of the groups ACROSS_2 and ACROSS_3, as a part of what is across:
   where their push is blurred, and where the axes are turned, for the coordinates are summed up. */
static void Blur(const Rod rod, Vector2 axis, PetscReal part[MIRRORS]) {
  const PetscReal c = PetscAbsReal(axis.x), s = PetscAbsReal(axis.y);
  const Contact *contact = &rod->scene->contact;

  for (int d = 0; d < MIRRORS; d++)
    part[d] = rod->finest * ((ContactBlurs(contact, 1 + d) ? c : 0) + s);
}

/* How far across a rod goes, as a part of its reach: by its places, its turns, or where it is
   pushed to. */
static PetscReal Across(const Rod rod, PetscReal reach, const PetscReal size[]) {
  const Pair *place = &rod->model->pair[0], *turn = &rod->model->pair[1];
  const PetscReal push = Size2(rod->oblique);
  PetscReal most =
      PetscMax(size[place->along], size[place->beside]) / PetscMax(reach, rod_rule.vanished);

  if (rod->model->pairs > 1) most = PetscMax(most, PetscMax(size[turn->along], size[turn->beside]));
  return PetscMax(most, push);
}

/* Can round-off of walls be more than what there is across a rod? */
static PetscBool MayBlur(const Rod rod) {
  const Contact *contact = &rod->scene->contact;

  return (PetscBool)(rod->model->pairs && (contact->walls.n || contact->surfaces.n));
}

/*
  LeaveBlur - the scales along the axes, none below what round-off of walls leaves there. A rod that
  is straight but for it, or bent in a plane but for it, would else be measured against that, and no
  step is right to a part of it, nor is an iteration ever: one that sinks onto a cylinder lengthways
  has nothing else out of the plane of its fall, nor has one that is bent by a sphere, whatever the
  frame is in which the wall is told. That is a part of each vector across; of place and turn, of
  how far across the rod goes by any of them; and where walls rub, what turns it about itself, too.
*/
static void LeaveBlur(const Rod rod, Vector2 axis, const PetscReal size[], PetscReal scale[]) {
  const RodModel *model = rod->model;
  const PetscBool rubs = ContactWallsRub(&rod->scene->contact);
  PetscReal reach, across, part[GROUPS] = {0};

  if (!MayBlur(rod)) return;
  reach = RodReach(model, size);
  across = Across(rod, reach, size);
  Blur(rod, axis, &part[ACROSS_2]);
  if (rubs) part[TWIST] = PetscMax(part[ACROSS_2], part[ACROSS_3]);
  for (PetscInt k = 0; k < model->pairs; k++) {
    const PetscInt a = model->pair[k].along, b = model->pair[k].beside;
    const PetscReal most = PetscMax(size[a], size[b]);
    scale[a] = PetscMax(scale[a], part[ACROSS_2] * most);
    scale[b] = PetscMax(scale[b], part[ACROSS_3] * most);
  }
  for (PetscInt f = 0; f < model->fields; f++)
    if (model->followed[f])
      scale[f] =
          PetscMax(scale[f], part[model->group[f]] * across * (RodIsPlace(model, f) ? reach : 1));
}

/* RodBlurred - places across, by the coordinates, that are no larger are round-off of walls; 0:
   there is none. Collective. */
PetscErrorCode RodBlurred(Rod rod, Vec U, PetscReal place[MIRRORS]) {
  PetscReal size[MAX_FIELDS], reach;

  PetscFunctionBegin;
  place[0] = place[1] = 0;
  if (!MayBlur(rod)) PetscFunctionReturn(0);
  Blur(rod, coordinate, place);
  if (place[0] == 0 && place[1] == 0) PetscFunctionReturn(0);
  PetscCall(RodFieldSizes(rod, U, size));
  reach = RodReach(rod->model, size);
  for (int d = 0; d < MIRRORS; d++) place[d] *= Across(rod, reach, size) * reach;
  PetscFunctionReturn(0);
}

/* By how much a vector across adds to what drives a group of fields, along the axes. */
static PetscReal Drives(Vector2 drive, int group, Vector2 axis) {
  if (group == ACROSS_2) return PetscAbsReal(Dot2(axis, drive));
  if (group == ACROSS_3) return PetscAbsReal(Cross2(axis, drive));
  return 0;
}

/* How strongly a group of fields is moved from 0, along the axes. */
static PetscReal Prescribed(const Rod rod, int group, Vector2 axis) {
  const Scene scene = rod->scene;
  const Space *space = &scene->space;
  const SceneUnits *units = &scene->units;
  const PetscReal L = units->length, force = units->stiffness / (L * L);
  PetscReal sum =
      space->turned[group] + space->moved[group] / L + Drives(rod->oblique, group, axis);

  if (scene->tropism.any && rod->learned) sum += Drives(From2(rod->learned->drive), group, axis);
  sum += Drives(From2(scene->load.weight + 1), group, axis) / (force / L);
  sum += Drives(From2(scene->tip.push + 1), group, axis) / force;
  if (group == TWIST)
    sum += PetscAbsReal(scene->tip.torque) / (force * L) + PetscAbsReal(space->spin) * units->time;
  return sum;
}

/* What twists a rod that is bent in one direction drives it in the other, by a part of that bend.
 */
static void TwistAcross(const Rod rod, PetscReal part, PetscReal scale[]) {
  const PetscReal prescribed = part * PetscMin(1, Prescribed(rod, TWIST, coordinate));

  for (PetscInt k = 0; k < rod->model->pairs && prescribed > 0; k++) {
    const PetscInt a = rod->model->pair[k].along, b = rod->model->pair[k].beside;
    const Vector2 across = {scale[a], scale[b]};
    if (!rod->model->followed[a]) continue;
    scale[a] = PetscMax(scale[a], prescribed * across.y);
    scale[b] = PetscMax(scale[b], prescribed * across.x);
  }
}

/* A roll moves the surface of a rod that can touch by half of its diameter times the angle, and is
   measured by that against how far the rod reaches, as places are: never finer than an angle of 1,
   for it turns what is bent by nature, too. (p1 is the sine of half of it.) */
static void RollByItsArm(const Rod rod, const PetscReal size[], PetscReal scale[]) {
  const Contact *contact = &rod->scene->contact;
  const PetscReal reach = RodReach(rod->model, size);

  if (!contact->any) return;
  for (PetscInt f = 0; f < rod->model->fields; f++)
    if (rod->model->followed[f] && rod->model->group[f] == TWIST)
      scale[f] = PetscMax(scale[f], reach < contact->diameter ? reach / contact->diameter : 1);
}

/*
  LeaveTurned - the scales across of a rod so short that round-off turns dry friction. With l the
  length over which friction bends it, what friction holds it bent by is gone in the time in which
  it grows by 0.1 L (L/l)^3. Steps of a tenth of that know the velocity along it to about

    e = 100 eps (l/L)^3,    eps round-off

  of that at which it grows, so which way friction pulls, and what is across: no step is right to
  less, and shorter ones are right to more still. So a change across is measured against at least so
  much of the length that all that friction holds is next to nothing beside it.
*/
static void LeaveTurned(const Rod rod, const PetscReal size[], PetscReal scale[]) {
  const Scene scene = rod->scene;
  const PetscReal reach = RodReach(rod->model, size),
                  slow = PetscPowReal(scene->units.length / PetscMax(reach, rod_rule.vanished), 3);

  if (!LoadIsDry(&scene->load) || scene->growth->still) return;
  if (slow * rod->finest < rod_rule.turned_from) return;
  for (PetscInt f = 0; f < rod->model->fields; f++)
    if (rod->model->followed[f] && rod->model->group[f] != ALONG)
      scale[f] = PetscMax(scale[f], rod_rule.turned_part * rod->finest *
                                        (RodIsPlace(rod->model, f) ? reach : 1));
}

/* The scales of a rod that others hold or push: what these are off by is a part of their own size,
   and their round-off is more than the whole of what a rod that has hardly moved does. */
static void LeaveOthers(const Rod rod, PetscReal scale[]) {
  for (PetscInt f = 0; f < rod->model->fields && rod->least > 0; f++)
    if (rod->model->followed[f])
      scale[f] = PetscMax(scale[f], RodIsPlace(rod->model, f) ? rod->least : rod_rule.joined_part);
}

/*
  RodFieldScales - what a change of each field is measured against: its size, but for fields that
  are made of products of others, and may be no more than what these leave of round-off; and for
  those that begin at 0 and are prescribed from there by a force across the rod, or by a wall that
  is oblique, or by what twists a bent rod, or by what breaks a symmetry otherwise: these are
  measured against a small part of what they will be, places in the scene's own unit of length.
  Collective.

  axis  on exit, the first of those along which the changes of the fields across are to be
        measured; NULL: the coordinates
*/
PetscErrorCode RodFieldScales(Rod rod, Vec U, Vector2 *axis, PetscReal scale[MAX_FIELDS]) {
  PetscReal size[MAX_FIELDS];
  Vector2 along = coordinate;

  PetscFunctionBegin;
  PetscCall(RodFieldSizes(rod, U, size));
  if (axis) {
    PetscCall(RodAxes(rod, U, size, &along));
    *axis = along;
  }
  PetscCall(PetscArraycpy(scale, size, rod->model->fields));
  if (along.y != 0) {
    PetscCall(RodSizesAlong(rod, U, along, scale));
    LeaveRoundOff(rod->model, along, size, scale);
  }
  for (PetscInt f = 0; f < rod->model->fields; f++) {
    PetscReal prescribed = Prescribed(rod, rod->model->group[f], along),
              unit = RodFieldUnit(rod, f);
    if (!rod->model->followed[f]) continue;
    if (prescribed > 0)
      scale[f] = PetscMax(scale[f],
                          rod_rule.prescribed_part *
                              PetscMax(rod_rule.prescribed_least, PetscMin(1, prescribed)) * unit);
    else if (scale[f] == 0)
      scale[f] = rod_rule.unprescribed_part * unit;
  }
  LeaveBlur(rod, along, size, scale);
  LeaveTurned(rod, size, scale);
  TwistAcross(rod, rod_rule.prescribed_part, scale);
  if (rod->model->scale) rod->model->scale(scale);
  RollByItsArm(rod, size, scale);
  LeaveOthers(rod, scale);
  if (rod->learned) LearnedScale(rod, scale);
  PetscFunctionReturn(0);
}
