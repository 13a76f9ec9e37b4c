#include "rod/learned_parts.h"

/* By what part of a turn the law bends a straight rod, as long as it becomes, towards x2 and x3. */
static void FindDrive(Rod rod) {
  const Tropism *law = &rod->scene->tropism;
  const PetscReal clamp[3] = {0};
  PetscReal pull[3] = {0};

  if (law->senses) TropismPull(law, clamp, pull, NULL);
  for (int d = 0; d < MIRRORS; d++)
    rod->learned->drive[d] =
        rod->scene->reach * (PetscAbsReal(pull[1 + d]) + PetscAbsReal(law->nutation[d]));
}

/* LearnedCreate - for a rod whose model has such states, behind so many unknowns of its mechanics:
   lead, and the extra ones of growth that feels force. */
PetscErrorCode LearnedCreate(Rod rod, PetscInt lead, PetscInt extra, PetscInt bends) {
  const Tropism *law = &rod->scene->tropism;
  const PetscInt nodes = rod->end - rod->first + 2, places = 2 * nodes, mech = lead + extra;
  Learned self;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  rod->learned = self;
  self->lead = lead;
  self->extra = extra;
  self->mech = mech;
  self->bends = bends;
  self->per = (rod->model->fields - mech) / 2;
  self->remembers = (PetscBool)(self->per > bends);
  self->at_tip = law->at_tip;
  self->kind = LearnedKindOf(rod);
  FindDrive(rod);
  PetscCall(PetscCalloc4(nodes * mech, &self->u, nodes * mech, &self->u_t, places * self->per,
                         &self->k, places * self->per, &self->k_t));
  PetscCall(PetscCalloc4(places * bends, &self->given, places, &self->clock, nodes * mech,
                         &self->row, places * self->per, &self->rows));
  PetscCall(PetscCalloc5(nodes * extra, &self->w, nodes * extra, &self->w_t, nodes * extra,
                         &self->w_row, places * bends, &self->drives, extra ? places : 0,
                         &self->stretch));
  PetscCall(PetscCalloc2(nodes, &self->node, nodes, &self->cell));
  PetscCall(PetscCalloc5(nodes * mech, &self->b, nodes * mech, &self->x, places * self->per,
                         &self->free, places * self->per, &self->rhs, nodes * mech, &self->beside));
  if (extra) PetscCall(PetscMalloc1(2 * nodes * mech, &self->turned));
  for (int b = 0; b < TROPISM_BENDS; b++)
    PetscCall(PetscCalloc1(self->at_tip ? nodes * mech : 0, &self->border[b]));
  PetscFunctionReturn(0);
}

PetscErrorCode LearnedDestroy(Rod rod) {
  Learned self = rod->learned;

  PetscFunctionBegin;
  if (!self) PetscFunctionReturn(0);
  PetscCall(PetscFree4(self->u, self->u_t, self->k, self->k_t));
  PetscCall(PetscFree4(self->given, self->clock, self->row, self->rows));
  PetscCall(PetscFree5(self->w, self->w_t, self->w_row, self->drives, self->stretch));
  PetscCall(PetscFree2(self->node, self->cell));
  PetscCall(PetscFree5(self->b, self->x, self->free, self->rhs, self->beside));
  for (int b = 0; b < TROPISM_BENDS; b++) PetscCall(PetscFree(self->border[b]));
  PetscCall(PetscFree(self->turned));
  PetscCall(PetscFree(self->label));
  PetscCall(PetscFree(self->over));
  PetscCall(PetscFree(rod->learned));
  PetscFunctionReturn(0);
}

/* LearnedBegin - the signal of a tip that remembers nothing is what it senses at the start, too.
   Collective. */
PetscErrorCode LearnedBegin(Rod rod, Vec U) {
  const Learned self = rod->learned;
  const PetscInt fields = rod->model->fields;
  RodState at = {.t = 0, .U = U};
  PetscScalar *u;
  Vec F;

  PetscFunctionBegin;
  if (!self->at_tip || rod->scene->tropism.memory > 0) PetscFunctionReturn(0);
  PetscCall(VecDuplicate(U, &at.U_t));
  PetscCall(VecDuplicate(U, &F));
  PetscCall(VecZeroEntries(at.U_t));
  PetscCall(rod->model->residual(rod, &at, F));
  PetscCall(VecGetArray(U, &u));
  for (PetscInt b = 0; b < self->bends && rod->end > rod->last; b++)
    u[(rod->last - rod->first) * fields + self->mech + self->per + b] -=
        self->rows[LearnedSignalPlace(rod) * self->per + b];
  PetscCall(VecRestoreArray(U, &u));
  PetscCall(VecDestroy(&at.U_t));
  PetscCall(VecDestroy(&F));
  PetscFunctionReturn(0);
}

/* LearnedScale - what a change of a state is measured against is no less than the bend that turns
   the whole rod by what its turns are measured against. */
void LearnedScale(Rod rod, PetscReal scale[]) {
  const RodModel *model = rod->model;
  const PetscInt mech = rod->learned->mech;

  for (PetscInt f = mech; f < model->fields; f++)
    for (PetscInt turn = 0; turn < mech; turn++) {
      const char name = model->field[turn][0];
      const PetscReal angle = name == 't' ? 1 : name == 'p' ? 2 : 0;
      if (model->group[turn] == model->group[f])
        scale[f] = PetscMax(scale[f], angle * scale[turn] / rod->scene->reach);
    }
}

/* LearnedPart - mechanics and states of the nodes first - 1 .. end of a vector, apart; states NULL:
   not these. w: the extra unknowns go there; NULL: they stay behind the others. */
PetscErrorCode LearnedPart(Rod rod, Vec V, PetscReal *mech, PetscReal *w, PetscReal *states) {
  const Learned self = rod->learned;
  const PetscInt fields = rod->model->fields, from = PetscMax(rod->first - 1, 0),
                 to = PetscMin(rod->end, rod->last), lead = w ? self->lead : self->mech;
  const PetscReal *v;
  Vec local;

  PetscFunctionBegin;
  PetscCall(RodOpen(rod, V, &local, &v));
  for (PetscInt i = from; i <= to; i++) {
    const PetscInt n = i - rod->first + 1;
    memcpy(mech + n * lead, v + i * fields, (size_t)lead * sizeof(*v));
    if (w && self->extra)
      memcpy(w + n * self->extra, v + i * fields + lead, (size_t)self->extra * sizeof(*v));
    if (states)
      memcpy(states + 2 * n * self->per, v + i * fields + self->mech,
             2 * (size_t)self->per * sizeof(*v));
  }
  PetscCall(RodClose(rod, &local, &v));
  PetscFunctionReturn(0);
}

/* LearnedFromLastRank - what the last rank has of a signal, to all. */
PetscErrorCode LearnedFromLastRank(const Rod rod, PetscReal signal[]) {
  PetscMPIInt ranks;

  PetscFunctionBegin;
  if (rod->alone) PetscFunctionReturn(0);
  PetscCallMPI(MPI_Comm_size(rod->scene->comm, &ranks));
  PetscCallMPI(MPI_Bcast(signal, TROPISM_BENDS, MPIU_REAL, ranks - 1, rod->scene->comm));
  PetscFunctionReturn(0);
}

/* LearnedShareSignal - ... among its states. */
PetscErrorCode LearnedShareSignal(Rod rod, const PetscReal *states, PetscReal signal[]) {
  PetscFunctionBegin;
  if (!rod->learned->at_tip) PetscFunctionReturn(0);
  if (rod->end > rod->last)
    memcpy(signal, states + LearnedSignalPlace(rod) * rod->learned->per,
           (size_t)rod->learned->bends * sizeof(*signal));
  PetscCall(LearnedFromLastRank(rod, signal));
  PetscFunctionReturn(0);
}

/* LearnedFront - does a front go along the rod, between what was there at first and what has come
   in, in which what is learned has a corner? */
PetscBool LearnedFront(const Rod rod) {
  const Growth growth = rod->scene->growth;

  return (PetscBool)(rod->learned && growth->slides && !growth->rests);
}

/* LearnedOpen - takes a state and its rates apart. Collective. */
PetscErrorCode LearnedOpen(Rod rod, const RodState *at) {
  Learned self = rod->learned;

  PetscFunctionBegin;
  PetscCall(LearnedPart(rod, at->U, self->u, self->w, self->k));
  PetscCall(LearnedPart(rod, at->U_t, self->u_t, self->w_t, self->k_t));
  self->born =
      (PetscBool)(rod->first == 0 && rod->scene->growth->slides && !rod->scene->growth->rests &&
                  GrowthSpeed(rod->scene->growth, 0, at->t, 0) > 0);
  PetscCall(LearnedShareSignal(rod, self->k, self->signal));
  PetscCall(LearnedShareSignal(rod, self->k_t, self->signal_t));
  for (int b = 0; b < TROPISM_BENDS; b++)
    self->nutation[b] = TropismNutation(&rod->scene->tropism, b, at->t);
  PetscFunctionReturn(0);
}

/* LearnedFill - an array for the residual of the mechanics, indexed by node; that of states is
   beside it. */
PetscErrorCode LearnedFill(Rod rod, void *array) {
  Learned self = rod->learned;

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(self->rows, 2 * (rod->end - rod->first + 2) * self->per));
  *(PetscReal **)array = self->row - rod->first * self->lead;
  PetscFunctionReturn(0);
}

/* LearnedFilled - both are those of F. */
PetscErrorCode LearnedFilled(Rod rod, Vec F) {
  const Learned self = rod->learned;
  const PetscInt fields = rod->model->fields;
  PetscReal *f;

  PetscFunctionBegin;
  if (rod->end > rod->last && !self->at_tip) /* places that are none: they stay 0 */
    PetscCall(PetscArraycpy(self->rows + LearnedSignalPlace(rod) * self->per,
                            self->k + LearnedSignalPlace(rod) * self->per, self->per));
  PetscCall(VecGetArrayWrite(F, (PetscScalar **)&f));
  for (PetscInt n = 0; n < rod->end - rod->first; n++) {
    memcpy(f + n * fields, self->row + n * self->lead, (size_t)self->lead * sizeof(*f));
    memcpy(f + n * fields + self->lead, self->w_row + (n + 1) * self->extra,
           (size_t)self->extra * sizeof(*f));
    memcpy(f + n * fields + self->mech, self->rows + 2 * (n + 1) * self->per,
           2 * (size_t)self->per * sizeof(*f));
  }
  PetscCall(VecRestoreArrayWrite(F, (PetscScalar **)&f));
  PetscFunctionReturn(0);
}

/* LearnedResidual - that of the states of a place: Dk/Dt - a (f - G u + I m/B + nutation), and
   T Df/Dt + f - S. */
void LearnedResidual(Rod rod, PetscInt place, const LearnedPoint *point) {
  Learned self = rod->learned;
  const Tropism *law = &rod->scene->tropism;
  const PetscReal *k = self->k + place * self->per, *k_t = self->k_t + place * self->per;
  PetscReal *row = self->rows + place * self->per;

  for (PetscInt c = 0; c < self->per && LearnedIsBorn(rod, place); c++) row[c] = k[c];
  if (LearnedIsBorn(rod, place)) return;
  for (PetscInt b = 0; b < self->bends; b++) {
    const PetscReal f = self->at_tip      ? self->signal[b]
                        : self->remembers ? k[self->bends + b]
                                          : point->sensed[b];
    const PetscReal drive =
        TropismDrive(law, f, point->natural[b], point->elastic[b], self->nutation[b]);
    self->drives[place * self->bends + b] = drive;
    row[b] = k_t[b] - self->clock[place] * drive;
    if (self->remembers)
      row[self->bends + b] = law->memory * k_t[self->bends + b] + f - point->sensed[b];
  }
}

/* LearnedSignalResidual - of the tip's signal. */
void LearnedSignalResidual(Rod rod, const PetscReal sensed[]) {
  Learned self = rod->learned;

  for (PetscInt b = 0; b < self->bends; b++)
    self->rows[LearnedSignalPlace(rod) * self->per + b] =
        rod->scene->tropism.memory * self->signal_t[b] + self->signal[b] - sensed[b];
}

/* LearnedPut - writes owned mechanics, or states of places, into a vector. */
PetscErrorCode LearnedPut(Rod rod, const PetscReal *mech, const PetscReal *states, Vec V) {
  const Learned self = rod->learned;
  const PetscInt fields = rod->model->fields;
  PetscReal *v;

  PetscFunctionBegin;
  PetscCall(VecGetArray(V, (PetscScalar **)&v));
  for (PetscInt n = 0; n < rod->end - rod->first; n++) {
    if (mech) memcpy(v + n * fields, mech + n * self->mech, (size_t)self->mech * sizeof(*v));
    if (states)
      memcpy(v + n * fields + self->mech, states + 2 * (n + 1) * self->per,
             2 * (size_t)self->per * sizeof(*v));
  }
  PetscCall(VecRestoreArray(V, (PetscScalar **)&v));
  PetscFunctionReturn(0);
}

/* LearnedGet - what owned nodes, and the middles of the cells behind them, have learned, and what
   they go by. Collective. */
PetscErrorCode LearnedGet(Rod rod, Vec U, Node *nodes) {
  const Learned self = rod->learned;
  PetscReal signal[TROPISM_BENDS] = {0}, *states = self->rhs;

  PetscFunctionBegin;
  PetscCall(LearnedPart(rod, U, self->beside, NULL, states));
  PetscCall(LearnedShareSignal(rod, states, signal));
  for (PetscInt i = rod->first; i < rod->end; i++)
    for (int half = 0; half < 2; half++)
      for (PetscInt b = 0; b < self->bends; b++) {
        const PetscReal *k = states + (2 * (i - rod->first + 1) + half) * self->per;
        NodeLearned *learned = &nodes[i - rod->first].learned[half];
        learned->bend[b] = half && i == rod->last ? 0 : k[b];
        learned->signal[b] = self->at_tip ? signal[b] : self->remembers ? k[self->bends + b] : 0;
      }
  PetscFunctionReturn(0);
}

/* LearnedSet - a state that has learned what nodes say; the tip's signal is what the last of them
   says. */
PetscErrorCode LearnedSet(Rod rod, const Node *nodes, Vec U) {
  const Learned self = rod->learned;
  PetscReal *states = self->rhs;

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(states, 2 * (rod->end - rod->first + 2) * self->per));
  for (PetscInt i = rod->first; i < rod->end; i++)
    for (int half = 0; half < 2; half++)
      for (PetscInt b = 0; b < self->bends; b++) {
        PetscReal *k = states + (2 * (i - rod->first + 1) + half) * self->per;
        const NodeLearned *learned = &nodes[i - rod->first].learned[half];
        const PetscBool ends = (PetscBool)(half && i == rod->last);
        k[b] = !ends ? learned->bend[b] : self->at_tip ? learned->signal[b] : 0;
        if (self->remembers && !ends) k[self->bends + b] = learned->signal[b];
      }
  PetscCall(LearnedPut(rod, NULL, states, U));
  PetscFunctionReturn(0);
}
