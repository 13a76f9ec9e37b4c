#include "base/handout.h"
#include "base/signals.h"
#include <unistd.h>

/* Rank 0 hands out the jobs, and works at jobs of its own in between: whoever works calls
   HandoutMeanwhile() often, and what has come in is answered there. A shared counter in a window
   would need no one to answer, but MPI need not move it forward either while its owner computes. A
   team has one job ahead of the one it is at, so that it need not wait for an answer, until few are
   left. Who has nothing to do sleeps between looks: MPI's own waiting takes a whole core. */
enum { AHEAD = 2, FEW = 4 }; /* jobs a team holds at most; jobs a team that are few */
enum { NAP_FIRST = 10, NAP_LONGEST = 2000 }; /* microseconds */
enum { TAG_JOB, TAG_RESULT, TAG_STOP, TAG_BYE };
enum { NO_MORE = -1, DROP = -2, GO = -3 }; /* in the place of a job */

struct _Handout {
  MPI_Comm comm, team;
  PetscMPIInt rank, each, mine; /* mine: the rank in the team */
  PetscMPIInt teams;
  PetscBool stop; /* no job is begun any more, and the one under way ends */
  useconds_t nap;
  /* the other teams' leaders */
  PetscInt queue[AHEAD], queued;
  PetscBool last, go; /* no more jobs come; all are through */
  char *sending;
  MPI_Request sent;
  /* rank 0 */
  PetscInt n, next, *jobs;
  PetscInt *held;       /* jobs of each team */
  PetscBool *told;      /* that no more come */
  PetscMPIInt goodbyes; /* of teams that are through */
  HandoutTake take;
  HandoutTick tick;
  void *ctx;
};

static PetscBool Leads(Handout self) {
  return (PetscBool)!self->mine;
}

static void Nap(Handout self) {
  (void)usleep(self->nap);
  self->nap = PetscMin(2 * self->nap, NAP_LONGEST);
}

static PetscErrorCode Tell(Handout self, PetscMPIInt team, PetscInt job) {
  PetscFunctionBegin;
  PetscCallMPI(MPI_Send(&job, 1, MPIU_INT, team * self->each, TAG_JOB, self->comm));
  PetscFunctionReturn(0);
}

/* Gives a team what it may have. */
static PetscErrorCode HandOut(Handout self, PetscMPIInt team) {
  PetscFunctionBegin;
  while (!self->stop && self->next < self->n &&
         self->held[team] < (self->n - self->next > FEW * self->teams ? AHEAD : 1)) {
    PetscCall(Tell(self, team, self->jobs[self->next++]));
    self->held[team]++;
  }
  if (self->told[team] || (self->next < self->n && !self->stop)) PetscFunctionReturn(0);
  PetscCall(Tell(self, team, NO_MORE));
  self->told[team] = PETSC_TRUE;
  PetscFunctionReturn(0);
}

/* Rank 0: ends the work of all teams. */
static PetscErrorCode StopAll(Handout self) {
  PetscFunctionBegin;
  if (self->stop) PetscFunctionReturn(0);
  self->stop = PETSC_TRUE;
  for (PetscMPIInt team = 1; team < self->teams; team++) PetscCall(Tell(self, team, DROP));
  PetscFunctionReturn(0);
}

/* Rank 0: one message has come. */
static PetscErrorCode Answer(Handout self, MPI_Message *message, const MPI_Status *status) {
  PetscMPIInt team = status->MPI_SOURCE / self->each, bytes;
  char *result;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Get_count(status, MPI_BYTE, &bytes));
  PetscCall(PetscMalloc1(bytes, &result));
  PetscCallMPI(MPI_Mrecv(result, bytes, MPI_BYTE, message, MPI_STATUS_IGNORE));
  if (status->MPI_TAG == TAG_STOP)
    PetscCall(StopAll(self));
  else if (status->MPI_TAG == TAG_BYE)
    self->goodbyes++;
  else {
    self->held[team]--;
    PetscCall(HandOut(self, team));
    PetscCall(self->take(self->ctx, (size_t)bytes, result));
  }
  PetscCall(PetscFree(result));
  PetscFunctionReturn(0);
}

/* Rank 0: answers all that has come in. */
static PetscErrorCode Serve(Handout self) {
  MPI_Message message;
  MPI_Status status;
  int come = 1;

  PetscFunctionBegin;
  if (SignalCaught()) PetscCall(StopAll(self));
  while (self->teams > 1 && come) {
    PetscCallMPI(MPI_Improbe(MPI_ANY_SOURCE, MPI_ANY_TAG, self->comm, &come, &message, &status));
    if (!come) break;
    PetscCall(Answer(self, &message, &status));
    self->nap = NAP_FIRST;
  }
  PetscCall(self->tick(self->ctx));
  PetscFunctionReturn(0);
}

/* Another leader: takes what rank 0 has sent. */
static PetscErrorCode Listen(Handout self) {
  int come = 1;

  PetscFunctionBegin;
  if (SignalCaught()) PetscCall(HandoutStop(self));
  for (;;) {
    PetscInt job;
    PetscCallMPI(MPI_Iprobe(0, TAG_JOB, self->comm, &come, MPI_STATUS_IGNORE));
    if (!come) break;
    PetscCallMPI(MPI_Recv(&job, 1, MPIU_INT, 0, TAG_JOB, self->comm, MPI_STATUS_IGNORE));
    self->nap = NAP_FIRST;
    if (job >= 0)
      self->queue[self->queued++] = job;
    else if (job == GO)
      self->go = PETSC_TRUE;
    else
      self->last = PETSC_TRUE;
    if (job == DROP) self->stop = PETSC_TRUE;
  }
  PetscFunctionReturn(0);
}

/* Another leader: waits until its latest result is under way, so that it can have another. */
static PetscErrorCode Sent(Handout self) {
  int done = 0;

  PetscFunctionBegin;
  for (self->nap = NAP_FIRST;;) {
    PetscCallMPI(MPI_Test(&self->sent, &done, MPI_STATUS_IGNORE));
    if (done) break;
    PetscCall(Listen(self));
    Nap(self);
  }
  PetscCall(PetscFree(self->sending));
  PetscFunctionReturn(0);
}

/* The next job of rank 0's team, or NO_MORE when all teams are through. */
static PetscErrorCode NextOfFirst(Handout self, PetscInt *job) {
  PetscFunctionBegin;
  for (self->nap = NAP_FIRST;;) {
    PetscCall(Serve(self));
    if (!self->stop && self->next < self->n) {
      *job = self->jobs[self->next++];
      break;
    }
    *job = NO_MORE;
    if (self->goodbyes == self->teams - 1) break;
    Nap(self);
  }
  PetscFunctionReturn(0);
}

/* The next job of another team, or NO_MORE when none is left for it. */
static PetscErrorCode NextOfOther(Handout self, PetscInt *job) {
  PetscFunctionBegin;
  for (self->nap = NAP_FIRST;;) {
    PetscCall(Listen(self));
    if (self->stop || (self->last && !self->queued)) {
      *job = NO_MORE;
      break;
    }
    if (self->queued) {
      *job = self->queue[0];
      self->queue[0] = self->queue[--self->queued];
      break;
    }
    Nap(self);
  }
  PetscFunctionReturn(0);
}

/* Waits for a request of the whole team without taking a core. */
static PetscErrorCode Await(Handout self, MPI_Request *request) {
  int done = 0;

  PetscFunctionBegin;
  for (self->nap = NAP_FIRST;;) {
    PetscCallMPI(MPI_Test(request, &done, MPI_STATUS_IGNORE));
    if (done) break;
    Nap(self);
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode CreateTeams(MPI_Comm comm, PetscInt each, Handout self) {
  PetscMPIInt ranks;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_dup(comm, &self->comm));
  PetscCallMPI(MPI_Comm_rank(self->comm, &self->rank));
  PetscCallMPI(MPI_Comm_size(self->comm, &ranks));
  PetscCall(PetscMPIIntCast(each, &self->each));
  self->teams = ranks / self->each;
  self->mine = self->rank % self->each;
  if (self->each == 1)
    self->team = PETSC_COMM_SELF;
  else
    PetscCallMPI(MPI_Comm_split(self->comm, self->rank / self->each, self->rank, &self->team));
  PetscFunctionReturn(0);
}

/*
  HandoutCreate - shares out jobs among teams of ranks. Collective on comm; all of it ends with
  HandoutEnd().

  each   ranks of a team; a divisor of the number of ranks
  n      how many jobs there are
  jobs   their numbers, 0 or more, in the order in which they are handed out; on rank 0
  take   called on rank 0 with each result, in the order in which they come
  tick   called on rank 0 often, whatever it is doing
  ctx    of both

  A team calls HandoutNext(), works, and calls HandoutReturn(), until no job is left. While it works
  it calls HandoutMeanwhile() as often as it can.
*/
PetscErrorCode HandoutCreate(MPI_Comm comm, PetscInt each, PetscInt n, const PetscInt jobs[],
                             HandoutTake take, HandoutTick tick, void *ctx, Handout *handout) {
  Handout self;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  *handout = self;
  PetscCall(CreateTeams(comm, each, self));
  self->sent = MPI_REQUEST_NULL;
  self->take = take;
  self->tick = tick;
  self->ctx = ctx;
  if (self->rank) PetscFunctionReturn(0);
  self->n = n;
  PetscCall(PetscMalloc1(n, &self->jobs));
  PetscCall(PetscArraycpy(self->jobs, jobs, n));
  PetscCall(PetscCalloc2(self->teams, &self->held, self->teams, &self->told));
  for (PetscMPIInt team = 1; team < self->teams; team++) PetscCall(HandOut(self, team));
  PetscFunctionReturn(0);
}

/* HandoutTeam - the ranks that work together with this one. */
MPI_Comm HandoutTeam(Handout self) {
  return self->team;
}

/* HandoutNext - the next job of the team; negative: there is none any more. Collective on the
   team. */
PetscErrorCode HandoutNext(Handout self, PetscInt *job) {
  MPI_Request request;

  PetscFunctionBegin;
  *job = NO_MORE;
  if (!self->rank)
    PetscCall(NextOfFirst(self, job));
  else if (Leads(self))
    PetscCall(NextOfOther(self, job));
  if (self->each == 1) PetscFunctionReturn(0);
  PetscCallMPI(MPI_Ibcast(job, 1, MPIU_INT, 0, self->team, &request));
  PetscCall(Await(self, &request));
  PetscFunctionReturn(0);
}

/* HandoutReturn - hands in the result of the job. Not collective: the team's first rank does it,
   the others may. */
PetscErrorCode HandoutReturn(Handout self, size_t bytes, const void *result) {
  PetscMPIInt n;

  PetscFunctionBegin;
  if (!self->rank) PetscCall(self->take(self->ctx, bytes, result));
  if (!self->rank || !Leads(self)) PetscFunctionReturn(0);
  PetscCall(Sent(self));
  PetscCheck(bytes <= PETSC_MPI_INT_MAX, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "a result of %g bytes is too large to be sent", (double)bytes);
  n = (PetscMPIInt)bytes;
  PetscCall(PetscMalloc1(bytes, &self->sending));
  PetscCall(PetscMemcpy(self->sending, result, bytes));
  PetscCallMPI(MPI_Isend(self->sending, n, MPI_BYTE, 0, TAG_RESULT, self->comm, &self->sent));
  PetscFunctionReturn(0);
}

/* HandoutMeanwhile - to be called often while a job is done; it costs next to nothing. Not
   collective.

   stop   the job is to end at once; what it has left is not wanted */
PetscErrorCode HandoutMeanwhile(Handout self, PetscBool *stop) {
  int done;

  PetscFunctionBegin;
  if (!self->rank)
    PetscCall(Serve(self));
  else if (Leads(self)) {
    PetscCall(Listen(self));
    PetscCallMPI(MPI_Test(&self->sent, &done, MPI_STATUS_IGNORE)); /* moves it forward */
  }
  *stop = self->stop;
  PetscFunctionReturn(0);
}

/* HandoutStop - ends the work of all teams, as a signal does. Not collective: on the first rank of
   any team; on others it does nothing. */
PetscErrorCode HandoutStop(Handout self) {
  PetscFunctionBegin;
  if (self->stop || !Leads(self)) PetscFunctionReturn(0);
  if (!self->rank)
    PetscCall(StopAll(self));
  else
    PetscCallMPI(MPI_Send(NULL, 0, MPI_BYTE, 0, TAG_STOP, self->comm));
  self->stop = PETSC_TRUE;
  PetscFunctionReturn(0);
}

/* Another leader: takes its leave, when all it has sent has arrived, and hears what rank 0 has
   still to say. */
static PetscErrorCode TakeLeave(Handout self) {
  PetscFunctionBegin;
  PetscCall(Sent(self));
  self->stop = PETSC_TRUE; /* what a signal would ask for */
  PetscCallMPI(MPI_Send(NULL, 0, MPI_BYTE, 0, TAG_BYE, self->comm));
  for (self->nap = NAP_FIRST; !self->go; Nap(self)) PetscCall(Listen(self));
  PetscFunctionReturn(0);
}

static PetscErrorCode Free(Handout self) {
  PetscFunctionBegin;
  PetscCall(PetscFree(self->jobs));
  PetscCall(PetscFree2(self->held, self->told));
  if (self->each > 1) PetscCallMPI(MPI_Comm_free(&self->team));
  PetscCallMPI(MPI_Comm_free(&self->comm));
  PetscFunctionReturn(0);
}

/* HandoutEnd - frees it, when all teams are through: no rank returns before rank 0 has called it,
   so that what rank 0 does before costs the others nothing. Collective. */
PetscErrorCode HandoutEnd(Handout *handout) {
  Handout self = *handout;
  MPI_Request request;

  PetscFunctionBegin;
  if (!self) PetscFunctionReturn(0);
  for (PetscMPIInt team = 1; !self->rank && team < self->teams; team++)
    PetscCall(Tell(self, team, GO));
  if (self->rank && Leads(self)) PetscCall(TakeLeave(self));
  if (self->each > 1) {
    PetscCallMPI(MPI_Ibarrier(self->team, &request));
    PetscCall(Await(self, &request));
  }
  PetscCall(Free(self));
  PetscCall(PetscFree(*handout));
  PetscFunctionReturn(0);
}
