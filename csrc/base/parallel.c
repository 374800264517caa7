/* parallel.c - blocks of items on OpenMP threads, progress on the caller's. */
#include "environment.h"
#include "ylm_pace.h"

#include <math.h>
#include <omp.h>
#include <stdatomic.h>
#include <time.h>
#ifdef __SANITIZE_THREAD__
#include <pthread.h>
#endif

/* Between two reports, where nobody asked for another pace. */
#define REPORT_SECONDS 0.1

static _Thread_local double pace; /* 0: REPORT_SECONDS */
static _Thread_local bool is_still;

void ylm_progress_pace(double every) {
  pace = every > 0 ? every : 0;
  is_still = false;
}

void ylm_progress_still(bool still) { is_still = still; }

double ylm_seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

int ylm_threads(int asked) {
  if (asked <= 0) asked = ylm__environment_threads(NULL);
  if (asked <= 0) asked = omp_get_num_procs();
  return asked < 1 ? 1 : asked > YLM_THREADS_MOST ? YLM_THREADS_MOST : asked;
}

ylm_status ylm_report(const ylm_progress *p, uint64_t done, uint64_t total, const char *stage) {
  if (!p || !p->step) return YLM_OK;
  return p->step(p->user, done, total, stage) ? YLM_OK : YLM_ECANCELLED;
}

static bool step_part(void *user, uint64_t done, uint64_t total, const char *stage) {
  const ylm_progress_part *p = user;
  uint64_t here = total ? (uint64_t)((double)p->steps * (double)done / (double)total) : 0;
  return ylm_report(p->whole, p->begin + here, p->of, p->stage ? p->stage : stage) == YLM_OK;
}

const ylm_progress *ylm_progress_part_of(ylm_progress_part *p, const ylm_progress *whole,
                                         const char *stage, uint64_t begin, uint64_t steps,
                                         uint64_t of) {
  *p = (ylm_progress_part){{step_part, p}, whole, stage, begin, steps, of};
  return whole ? &p->base : NULL;
}

/* Work in blocks, and what the calling thread tells of it in between. */
typedef struct job {
  size_t n, grain, blocks;
  ylm_range_fn *fn;
  void *context;
  const ylm_progress *progress;
  const char *stage;
  bool still;                      /* the team has stopped where it reports */
  double every;                    /* seconds between two reports */
  size_t stride, left;             /* blocks of the calling thread between two looks at the clock */
  double looked, told;             /* when it looked, and when it told of them */
  atomic_int failed;               /* the first status other than YLM_OK */
  _Alignas(64) atomic_size_t done; /* blocks; away from what all threads read */
} job;

static void fail(job *j, ylm_status s) {
  int ok = YLM_OK;
  if (s != YLM_OK) atomic_compare_exchange_strong(&j->failed, &ok, (int)s);
}

/* Tells how much is done if that is due; on the calling thread only. */
static void tell(job *j, double now) {
  j->looked = now;
  if (now - j->told < j->every) return;
  size_t done = atomic_load(&j->done);
  if (done < j->blocks) fail(j, ylm_report(j->progress, done * j->grain, j->n, j->stage));
  j->looked = j->told = ylm_seconds();
}

/* The blocks that take so many seconds, where `blocks` have taken `passed`: `least` to four times as many. */
static size_t fitting(size_t blocks, double seconds, double passed, int least) {
  double wanted = passed > 0 ? seconds * (double)blocks / passed : INFINITY;
  return (size_t)fmax(least, fmin(wanted, 4 * (double)blocks));
}

/* The clock, which may cost as much as a small block, is looked at some twenty times between two reports. */
static void tell_between(job *j) {
  if (--j->left > 0) return;
  double now = ylm_seconds();
  j->stride = fitting(j->stride, j->every / 20, now - j->looked, 1);
  j->left = j->stride;
  tell(j, now);
}

static void run_block(job *j, size_t b, int worker) {
  if (atomic_load_explicit(&j->failed, memory_order_relaxed) != YLM_OK) return;
  size_t begin = b * j->grain, end = j->n - begin < j->grain ? j->n : begin + j->grain;
  fail(j, j->fn(j->context, begin, end, worker));
  atomic_fetch_add_explicit(&j->done, 1, memory_order_relaxed);
  if (j->progress && worker == 0 && !j->still && atomic_load(&j->failed) == YLM_OK) tell_between(j);
}

#ifdef __SANITIZE_THREAD__
/* ThreadSanitizer does not see how the threads of libgomp wait for one another, and would report
   every hand-over as a race. It sees how these do. */
typedef struct member {
  job *j;
  atomic_size_t *next;
  size_t end;
  pthread_t thread;
  int worker;
  bool runs;
} member;

static void *work(void *user) {
  member *m = user;
  for (size_t b; (b = atomic_fetch_add(m->next, 1)) < m->end;) run_block(m->j, b, m->worker);
  return NULL;
}

static void run_team(job *j, int threads, size_t begin, size_t end) {
  atomic_size_t next = begin;
  member team[YLM_THREADS_MOST];
  for (int w = 0; w < threads; w++)
    team[w] = (member){.j = j, .next = &next, .end = end, .worker = w};
  for (int w = 1; w < threads; w++)
    team[w].runs = pthread_create(&team[w].thread, NULL, work, &team[w]) == 0;
  work(&team[0]);
  for (int w = 1; w < threads; w++)
    if (team[w].runs) pthread_join(team[w].thread, NULL);
}
#else
static void run_team(job *j, int threads, size_t begin, size_t end) {
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
  for (size_t b = begin; b < end; b++) run_block(j, b, omp_get_thread_num());
}
#endif

/* Turns take half of the seconds between two reports. */
static void run_in_turns(job *j, int threads) {
  size_t turn = (size_t)threads;
  for (size_t b = 0, end; b < j->blocks && j->failed == YLM_OK; b = end) {
    double began = ylm_seconds(), now;
    end = j->blocks - b < turn ? j->blocks : b + turn;
    run_team(j, threads, b, end);
    now = ylm_seconds();
    if (j->failed == YLM_OK) tell(j, now);
    turn = fitting(turn, j->every / 2, now - began, threads);
  }
}

ylm_status ylm_parallel(size_t n, size_t grain, int threads, ylm_range_fn *fn, void *context,
                        const ylm_progress *progress, const char *stage) {
  threads = ylm_threads(threads);
  if (grain == 0) grain = 1;
  size_t blocks = n / grain + (n % grain != 0);
  bool team = threads > 1 && blocks > 1;
  job j = {.n = n,
           .grain = grain,
           .blocks = blocks,
           .fn = fn,
           .context = context,
           .progress = progress,
           .stage = stage,
           .still = team && progress && is_still,
           .every = pace > 0 ? pace : REPORT_SECONDS,
           .stride = 1,
           .left = 1};
  j.told = -j.every;
  if (j.still)
    run_in_turns(&j, threads);
  else if (team)
    run_team(&j, threads, 0, blocks);
  else
    for (size_t b = 0; b < blocks && j.failed == YLM_OK; b++) run_block(&j, b, 0);
  if (j.failed == YLM_OK && blocks > 0) fail(&j, ylm_report(progress, n, n, stage));
  return (ylm_status)j.failed;
}
