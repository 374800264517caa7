/* process.h - a process of the team, and its messages. Private to csrc/mpi. */
#ifndef YLM_MPI_PROCESS_H
#define YLM_MPI_PROCESS_H

#include <mpi.h>
#include <pthread.h>

#include "ylm_mpi.h"

/* Seconds that a failure waits for the others to hear of it. */
#define PATIENCE 2.0

/* The function that a process calls: all of them have to call the same. */
enum call { CALL_AGREE = 1, CALL_EXCHANGE, CALL_LEAVE };

/* Said by every process to every process before each call. */
typedef struct word {
  int32_t call, status;
  uint64_t value; /* of CALL_EXCHANGE: a checksum of the counts */
} word;

/* A request for a task, or the wish that no more are handed out (n = STOP). */
typedef struct request {
  uint32_t job, stop;
  uint64_t n;
} request;

enum tag { TAG_REQUEST = 1, TAG_TASK };

/* The job whose tasks process 0 hands out. */
typedef struct counter {
  uint32_t job;
  bool stopped, differs; /* processes gave it different sizes */
  uint64_t n, next;
  int open; /* other processes that have not been told that none is left */
} counter;

typedef struct process {
  ylm_team team;
  MPI_Comm comm;
  MPI_Comm end; /* of the barrier before MPI_Abort: calls of comm may be open then */
  word *words;  /* [size], and its own behind them, which is read until all have heard it */
  int *count;   /* [2][size] scratch */
  int threads;  /* ylm_mpi_begin */
  bool alone;   /* it has gone on alone */
  counter counter;
  /* Process 0: the thread that hands out tasks while the process computes. */
  bool threaded, quit;
  pthread_t thread;
  pthread_cond_t wake;
  pthread_mutex_t lock; /* around every call of MPI, and the counter */
} process;

/* -- serve.c: tasks ------------------------------------------------------------------------- */

ylm_status ylm__mpi_next(void *self, uint32_t job, size_t n, size_t *task, ylm_error *e);
void ylm__mpi_stop(void *self, uint32_t job);
void ylm__mpi_serve(void *self);
/* Answers requests that have come; the lock is held. */
void ylm__mpi_answer(process *p);
/* Starts and ends the thread that answers. */
void ylm__mpi_thread_begin(process *p);
void ylm__mpi_thread_end(process *p);

/* -- team.c: all together -------------------------------------------------------------------- */

/* Waits for a request of MPI, answering the others meanwhile; until `patience` seconds have passed
   (0: for ever). YLM_ELIMIT then. */
ylm_status ylm__mpi_wait(process *p, MPI_Request *r, double patience, ylm_error *e);
/* Translates what MPI returned. */
ylm_status ylm__mpi_status(int code, ylm_error *e);
/* Says w to all and hears what they say, in p->words. */
ylm_status ylm__mpi_say(process *p, word w, double patience, ylm_error *e);
ylm_status ylm__mpi_exchange(void *self, const void *mine, const size_t *bytes, void *all,
                             ylm_error *e);
ylm_status ylm__mpi_agree(void *self, ylm_status mine, ylm_error *e);

#endif
