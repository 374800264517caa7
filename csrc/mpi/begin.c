/* begin.c - MPI's beginning and end. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* sched_getaffinity, on_exit */
#endif
#include <sched.h>
#include <stdlib.h>
#include <unistd.h>

#include "process.h"

/* One for each program: MPI itself can begin but once. */
static process own;
static bool begun;
static pthread_mutex_t beginning = PTHREAD_MUTEX_INITIALIZER;
static pid_t begun_by;

static char version[MPI_MAX_LIBRARY_VERSION_STRING];

static void find_version(void) {
  int n = 0;
  MPI_Get_library_version(version, &n);
  for (n = 0; version[n] && version[n] != ',' && version[n] != '\n'; n++) continue;
  version[n] = 0;
}

const char *ylm_mpi_version(void) {
  static pthread_once_t once = PTHREAD_ONCE_INIT;
  pthread_once(&once, find_version);
  return version;
}

bool ylm_mpi_is_alone(void) { return own.alone; }

/* -- threads ------------------------------------------------------------------------------------ */

typedef struct mask {
  unsigned char bit[128]; /* of 1024 processors */
} mask;

static mask own_mask(void) {
  mask m = {{0}};
#ifdef __linux__
  cpu_set_t set;
  if (sched_getaffinity(0, sizeof set, &set) == 0)
    for (int i = 0; i < 1024 && i < CPU_SETSIZE; i++)
      if (CPU_ISSET(i, &set)) m.bit[i / 8] |= (unsigned char)(1 << i % 8);
#endif
  return m;
}

/* Processors of the mask over the processes of this machine that have one of them, of masks [size]. */
static int share_of_threads(MPI_Comm comm, mask *all) {
  MPI_Comm machine;
  int size = 1, sharing = 0, processors = 0;
  mask mine = own_mask();
  if (MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine) != MPI_SUCCESS)
    return 1;
  MPI_Comm_size(machine, &size);
  MPI_Allgather(&mine, sizeof mine, MPI_BYTE, all, sizeof mine, MPI_BYTE, machine);
  MPI_Comm_free(&machine);
  for (int i = 0; i < size; i++) {
    bool meets = false;
    for (size_t k = 0; k < sizeof mine.bit; k++) meets |= mine.bit[k] & all[i].bit[k];
    sharing += meets;
  }
  for (size_t k = 0; k < sizeof mine.bit; k++) processors += __builtin_popcount(mine.bit[k]);
  return sharing && processors > sharing ? processors / sharing : 1;
}

/* -- the end ------------------------------------------------------------------------------------- */

/* Until all processes have come here, each with what it had to say, or PATIENCE has passed. */
static void meet_at_end(process *p) {
  MPI_Request r;
  pthread_mutex_lock(&p->lock);
  int code = MPI_Ibarrier(p->end, &r);
  pthread_mutex_unlock(&p->lock);
  if (code == MPI_SUCCESS) ylm__mpi_wait(p, &r, PATIENCE, NULL);
}

/* Ends MPI where all processes end; else ends them all. */
static void leave(int status, void *context) {
  process *p = context;
  int over = 0;
  if (getpid() != begun_by) return; /* a copy by fork, which is no process of the team */
  MPI_Finalized(&over);
  if (over) return;
  fflush(NULL); /* MPI_Abort does not */
  if (!p->alone) {
    word w = {.call = CALL_LEAVE};
    ylm_status s = ylm__mpi_say(p, w, status ? PATIENCE : 0, NULL);
    bool all = s == YLM_OK;
    for (int i = 0; all && i < p->team.size; i++) all = p->words[i].call == CALL_LEAVE;
    if (all) {
      ylm__mpi_thread_end(p);
      MPI_Comm_free(&p->end);
      MPI_Comm_free(&p->comm);
      MPI_Finalize();
      return;
    }
  }
  meet_at_end(p);
  ylm__mpi_thread_end(p);
  MPI_Abort(MPI_COMM_WORLD, status ? status : 1);
}

#ifndef __GLIBC__
static void leave_well(void) { leave(0, &own); }
#endif

/* -- the beginning ------------------------------------------------------------------------------- */

static ylm_status begin(process *p, ylm_error *e) {
  int level = MPI_THREAD_SINGLE, before = 0;
  MPI_Initialized(&before);
  if (!before) {
    ylm_status s = ylm__mpi_status(MPI_Init_thread(NULL, NULL, MPI_THREAD_SERIALIZED, &level), e);
    if (s != YLM_OK) return s;
  } else {
    MPI_Query_thread(&level);
  }
  if (level < MPI_THREAD_SERIALIZED)
    return ylm_fail(e, YLM_EPEER,
                    "this MPI library cannot be called by several threads (MPI_THREAD_SERIALIZED)");
  if (MPI_Comm_dup(MPI_COMM_WORLD, &p->comm) != MPI_SUCCESS ||
      MPI_Comm_dup(MPI_COMM_WORLD, &p->end) != MPI_SUCCESS)
    return ylm_fail(e, YLM_EPEER, "MPI failed: no communicator");
  MPI_Comm_set_errhandler(p->comm, MPI_ERRORS_RETURN);
  MPI_Comm_set_errhandler(p->end, MPI_ERRORS_RETURN);
  ylm_team *t = &p->team;
  *t = (ylm_team){.self = p,
                  .next = ylm__mpi_next,
                  .stop = ylm__mpi_stop,
                  .serve = ylm__mpi_serve,
                  .exchange = ylm__mpi_exchange,
                  .agree = ylm__mpi_agree};
  MPI_Comm_rank(p->comm, &t->rank);
  MPI_Comm_size(p->comm, &t->size);
  pthread_mutex_init(&p->lock, NULL);
  size_t size = (size_t)t->size;
  mask *masks = ylm_alloc(size, sizeof *masks);
  p->words = ylm_alloc(size + 1, sizeof *p->words);
  p->count = ylm_alloc(2 * size, sizeof *p->count);
  bool room = masks && p->words && p->count;
  if (room) p->threads = share_of_threads(p->comm, masks);
  ylm_free(masks);
  if (!room) return ylm_fail(e, YLM_ENOMEM, "no memory for a team");
  if (t->rank == 0 && t->size > 1) ylm__mpi_thread_begin(p);
  begun_by = getpid();
#ifdef __GLIBC__
  on_exit(leave, p);
#else
  atexit(leave_well);
#endif
  return YLM_OK;
}

ylm_status ylm_mpi_begin(ylm_team **team, int *threads, ylm_error *e) {
  *team = NULL;
  pthread_mutex_lock(&beginning);
  ylm_status s = begun ? YLM_OK : begin(&own, e);
  if (s == YLM_OK) begun = true;
  pthread_mutex_unlock(&beginning);
  if (s != YLM_OK) return s;
  *team = &own.team;
  *threads = own.threads;
  return YLM_OK;
}
