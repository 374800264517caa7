/* team.c - processes that come together: what all of them say, statuses, bytes. */
#include <sched.h>
#include <time.h>

#include "process.h"

/* Bytes of one call of MPI, whose counts are ints. */
#define SLICE ((size_t)1 << 30)
/* A process that waits looks again and again for so long, then it sleeps in between. */
#define EAGER_SECONDS 2e-3
#define SLEEP_LEAST 50000 /* nanoseconds */
#define SLEEP_MOST 1000000

ylm_status ylm__mpi_status(int code, ylm_error *e) {
  char text[MPI_MAX_ERROR_STRING + 1] = "";
  int length = 0;
  if (code == MPI_SUCCESS) return YLM_OK;
  MPI_Error_string(code, text, &length);
  return ylm_fail(e, YLM_EPEER, "MPI failed: %.300s", text);
}

/* Does nothing for a while, longer the longer has been waited. */
static void pause_for(double waited, long *nanoseconds) {
  if (waited < EAGER_SECONDS) {
    sched_yield();
    return;
  }
  nanosleep(&(struct timespec){.tv_nsec = *nanoseconds}, NULL);
  if (*nanoseconds < SLEEP_MOST) *nanoseconds += *nanoseconds / 4;
}

ylm_status ylm__mpi_wait(process *p, MPI_Request *r, double patience, ylm_error *e) {
  double begin = ylm_seconds();
  long nanoseconds = SLEEP_LEAST;
  for (;;) {
    int done = 0;
    pthread_mutex_lock(&p->lock);
    int code = MPI_Test(r, &done, MPI_STATUS_IGNORE);
    if (p->team.rank == 0 && !done) ylm__mpi_answer(p);
    pthread_mutex_unlock(&p->lock);
    if (code != MPI_SUCCESS) return ylm__mpi_status(code, e);
    if (done) return YLM_OK;
    double waited = ylm_seconds() - begin;
    if (patience > 0 && waited > patience) return YLM_ELIMIT;
    pause_for(waited, &nanoseconds);
  }
}

ylm_status ylm__mpi_say(process *p, word w, double patience, ylm_error *e) {
  MPI_Request r;
  word *mine = &p->words[p->team.size];
  *mine = w;
  pthread_mutex_lock(&p->lock);
  int code = MPI_Iallgather(mine, sizeof w, MPI_BYTE, p->words, sizeof w, MPI_BYTE, p->comm, &r);
  pthread_mutex_unlock(&p->lock);
  ylm_status s = ylm__mpi_status(code, e);
  if (s == YLM_OK) s = ylm__mpi_wait(p, &r, patience, e);
  if (s != YLM_OK) p->alone = true;
  return s;
}

/* Nobody may have ended: what comes next needs all. */
static ylm_status check_present(process *p, ylm_error *e) {
  for (int i = 0; i < p->team.size; i++) {
    if (p->words[i].call != CALL_LEAVE) continue;
    p->alone = true;
    return ylm_fail(e, YLM_EPEER, "process %d has ended while others wait for it", i + 1);
  }
  return YLM_OK;
}

/* Every process has to call the same. */
static ylm_status check_calls(process *p, int call, ylm_error *e) {
  for (int i = 0; i < p->team.size; i++) {
    if (p->words[i].call == call) continue;
    p->alone = true;
    return ylm_fail(e, YLM_EPEER,
                    "processes %d and %d of the team do different things: a program has to call "
                    "its functions in the same order on every process",
                    p->team.rank + 1, i + 1);
  }
  return YLM_OK;
}

/* The first process that failed; the size of the team where none did. */
static int first_failed(const process *p) {
  int i = 0;
  while (i < p->team.size && p->words[i].status == YLM_OK) i++;
  return i;
}

static ylm_status broadcast(process *p, void *data, size_t bytes, int root, ylm_error *e) {
  ylm_status s = YLM_OK;
  for (size_t at = 0; at < bytes && s == YLM_OK; at += SLICE) {
    MPI_Request r;
    size_t n = bytes - at < SLICE ? bytes - at : SLICE;
    pthread_mutex_lock(&p->lock);
    int code = MPI_Ibcast((char *)data + at, (int)n, MPI_BYTE, root, p->comm, &r);
    pthread_mutex_unlock(&p->lock);
    s = ylm__mpi_status(code, e);
    if (s == YLM_OK) s = ylm__mpi_wait(p, &r, 0, e);
  }
  return s;
}

/* The failure of process i, told to all: they have said that it has one. */
static ylm_status failure_of(process *p, int i, ylm_error *e) {
  ylm_error told = {.status = (ylm_status)p->words[i].status};
  if (i == p->team.rank && e) told = *e;
  told.status = (ylm_status)p->words[i].status;
  ylm_status s = broadcast(p, told.text, sizeof told.text, i, e);
  told.text[sizeof told.text - 1] = 0;
  if (s != YLM_OK) return s;
  const char *text = *told.text ? told.text : ylm_status_text(told.status);
  if (told.status == YLM_ECANCELLED || i == 0) return ylm_fail(e, told.status, "%s", text);
  return ylm_fail(e, told.status, "process %d: %.380s", i + 1, text);
}

/* Status `mine` and the call of every process; the failure of the first that has one. */
static ylm_status meet(process *p, word w, ylm_error *e) {
  if (p->alone) return ylm_fail(e, YLM_EPEER, "the team has failed before");
  ylm_error own = {.status = (ylm_status)w.status};
  if (w.status != YLM_OK && e && e->status == own.status) own = *e;
  ylm_status s = ylm__mpi_say(p, w, w.status == YLM_OK ? 0 : PATIENCE, e);
  if (s == YLM_ELIMIT && w.status != YLM_OK) { /* nobody hears it */
    const char *text = *own.text ? own.text : ylm_status_text(own.status);
    return p->team.rank == 0
               ? ylm_fail(e, own.status, "%s", text)
               : ylm_fail(e, own.status, "process %d: %.380s", p->team.rank + 1, text);
  }
  if (s == YLM_OK) s = check_present(p, e);
  if (s != YLM_OK) return s;
  int failed = first_failed(p);
  if (e) *e = own;
  if (failed < p->team.size) return failure_of(p, failed, e);
  return check_calls(p, w.call, e);
}

ylm_status ylm__mpi_agree(void *self, ylm_status mine, ylm_error *e) {
  return meet(self, (word){.call = CALL_AGREE, .status = (int32_t)mine}, e);
}

/* -- bytes ------------------------------------------------------------------------------------- */

static ylm_status gather_all(process *p, const void *mine, const size_t *bytes, void *all,
                             ylm_error *e) {
  int size = p->team.size, *count = p->count, *place = count + size;
  size_t at = 0;
  for (int i = 0; i < size; at += bytes[i++]) count[i] = (int)bytes[i], place[i] = (int)at;
  MPI_Request r;
  pthread_mutex_lock(&p->lock);
  int code = MPI_Iallgatherv(mine, count[p->team.rank], MPI_BYTE, all, count, place, MPI_BYTE,
                             p->comm, &r);
  pthread_mutex_unlock(&p->lock);
  ylm_status s = ylm__mpi_status(code, e);
  return s == YLM_OK ? ylm__mpi_wait(p, &r, 0, e) : s;
}

/* More than MPI counts in one call: one process after another, in slices. */
static ylm_status gather_slices(process *p, const void *mine, const size_t *bytes, void *all,
                                ylm_error *e) {
  char *to = all;
  ylm_status s = YLM_OK;
  for (int i = 0; i < p->team.size && s == YLM_OK; to += bytes[i++]) {
    if (i == p->team.rank && bytes[i]) memmove(to, mine, bytes[i]);
    s = broadcast(p, to, bytes[i], i, e);
  }
  return s;
}

ylm_status ylm__mpi_exchange(void *self, const void *mine, const size_t *bytes, void *all,
                             ylm_error *e) {
  process *p = self;
  size_t size = (size_t)p->team.size, sum = 0;
  for (size_t i = 0; i < size; i++) sum += bytes[i];
  uint64_t crc = ylm_crc64(0, bytes, size * sizeof *bytes);
  ylm_status s = meet(p, (word){.call = CALL_EXCHANGE, .value = crc}, e);
  for (size_t i = 0; s == YLM_OK && i < size; i++)
    if (p->words[i].value != crc)
      s = ylm_fail(e, YLM_EPEER, "processes of a team expect different numbers of bytes");
  if (s != YLM_OK) return s;
  return sum <= SLICE ? gather_all(p, mine, bytes, all, e) : gather_slices(p, mine, bytes, all, e);
}
