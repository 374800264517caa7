/* serve.c - tasks: process 0 hands them out, the others ask for them. */
#include <signal.h>
#include <time.h>

#include "process.h"

#define NONE UINT64_MAX            /* no task is left */
#define DIFFERENT (UINT64_MAX - 1) /* the job has another size elsewhere */
#define ANSWER_NANOSECONDS 500000

/* The job begins with the first process that speaks of it. */
static void meet(process *p, uint32_t job, uint64_t n) {
  counter *c = &p->counter;
  if (job != c->job) *c = (counter){.job = job, .n = n, .open = p->team.size - 1};
  c->differs |= n != c->n;
  if (p->threaded) pthread_cond_signal(&p->wake);
}

static uint64_t hand_out(counter *c) {
  if (c->differs) return DIFFERENT;
  return c->next < c->n && !c->stopped ? c->next++ : NONE;
}

void ylm__mpi_answer(process *p) {
  int there = 1;
  while (there) {
    MPI_Status from;
    request r;
    if (MPI_Iprobe(MPI_ANY_SOURCE, TAG_REQUEST, p->comm, &there, &from) != MPI_SUCCESS) return;
    if (!there) return;
    if (MPI_Recv(&r, sizeof r, MPI_BYTE, from.MPI_SOURCE, TAG_REQUEST, p->comm,
                 MPI_STATUS_IGNORE) != MPI_SUCCESS)
      return;
    if (r.stop) {
      if (r.job == p->counter.job) p->counter.stopped = true;
      continue;
    }
    meet(p, r.job, r.n);
    uint64_t task = hand_out(&p->counter);
    if (task >= DIFFERENT) p->counter.open--;
    MPI_Send(&task, sizeof task, MPI_BYTE, from.MPI_SOURCE, TAG_TASK, p->comm);
  }
}

void ylm__mpi_serve(void *self) {
  process *p = self;
  if (p->team.rank != 0 || p->threaded || p->alone) return;
  pthread_mutex_lock(&p->lock);
  ylm__mpi_answer(p);
  pthread_mutex_unlock(&p->lock);
}

/* A message of 8 or 16 bytes leaves at once, whether or not it is waited for. */
static ylm_status send(process *p, const request *r, ylm_error *e) {
  pthread_mutex_lock(&p->lock);
  int code = MPI_Send(r, sizeof *r, MPI_BYTE, 0, TAG_REQUEST, p->comm);
  pthread_mutex_unlock(&p->lock);
  return ylm__mpi_status(code, e);
}

static ylm_status ask(process *p, uint32_t job, size_t n, uint64_t *task, ylm_error *e) {
  MPI_Request answer;
  pthread_mutex_lock(&p->lock);
  int code = MPI_Irecv(task, sizeof *task, MPI_BYTE, 0, TAG_TASK, p->comm, &answer);
  pthread_mutex_unlock(&p->lock);
  ylm_status s = ylm__mpi_status(code, e);
  if (s == YLM_OK) s = send(p, &(request){.job = job, .n = n}, e);
  return s == YLM_OK ? ylm__mpi_wait(p, &answer, 0, e) : s;
}

ylm_status ylm__mpi_next(void *self, uint32_t job, size_t n, size_t *task, ylm_error *e) {
  process *p = self;
  uint64_t given = NONE;
  ylm_status s = YLM_OK;
  *task = n;
  if (p->alone) return ylm_fail(e, YLM_EPEER, "the team has failed before");
  if (p->team.rank == 0) {
    pthread_mutex_lock(&p->lock);
    ylm__mpi_answer(p);
    meet(p, job, n);
    given = hand_out(&p->counter);
    pthread_mutex_unlock(&p->lock);
  } else {
    s = ask(p, job, n, &given, e);
  }
  if (s != YLM_OK) return s;
  if (given == DIFFERENT)
    return ylm_fail(e, YLM_EINVAL, "processes of a team were given different numbers of tasks");
  if (given != NONE) *task = (size_t)given;
  return YLM_OK;
}

void ylm__mpi_stop(void *self, uint32_t job) {
  process *p = self;
  if (p->alone) return;
  if (p->team.rank > 0) {
    send(p, &(request){.job = job, .stop = 1}, NULL);
    return;
  }
  pthread_mutex_lock(&p->lock);
  if (p->counter.job == job) p->counter.stopped = true;
  pthread_mutex_unlock(&p->lock);
}

/* -- the thread -------------------------------------------------------------------------------- */

/* Answers as long as a job is under way. */
static void *answer_others(void *context) {
  process *p = context;
  pthread_mutex_lock(&p->lock);
  while (!p->quit) {
    if (p->counter.open <= 0) {
      pthread_cond_wait(&p->wake, &p->lock);
      continue;
    }
    ylm__mpi_answer(p);
    pthread_mutex_unlock(&p->lock);
    nanosleep(&(struct timespec){.tv_nsec = ANSWER_NANOSECONDS}, NULL);
    pthread_mutex_lock(&p->lock);
  }
  pthread_mutex_unlock(&p->lock);
  return NULL;
}

void ylm__mpi_thread_begin(process *p) {
  sigset_t all, before;
  if (pthread_cond_init(&p->wake, NULL) != 0) return;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before); /* signals are the interpreter's */
  p->threaded = pthread_create(&p->thread, NULL, answer_others, p) == 0;
  pthread_sigmask(SIG_SETMASK, &before, NULL);
}

void ylm__mpi_thread_end(process *p) {
  if (!p->threaded) return;
  pthread_mutex_lock(&p->lock);
  p->quit = true;
  pthread_cond_signal(&p->wake);
  pthread_mutex_unlock(&p->lock);
  pthread_join(p->thread, NULL);
  p->threaded = false;
}
