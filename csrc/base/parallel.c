/* parallel.c - blocks of items on OpenMP threads, progress on the caller's. */
#include "environment.h"

#include <omp.h>
#include <stdatomic.h>
#include <time.h>

/* A batch between two reports aims at this long. */
#define REPORT_SECONDS 0.1

double ylm_seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

int ylm_threads(int asked) {
  if (asked <= 0) asked = ylm__environment_threads(NULL);
  if (asked <= 0) asked = omp_get_num_procs();
  return asked < 1 ? 1 : asked > YLM__MOST_THREADS ? YLM__MOST_THREADS : asked;
}

ylm_status ylm_report(const ylm_progress *p, uint64_t done, uint64_t total, const char *stage) {
  if (!p || !p->step) return YLM_OK;
  return p->step(p->user, done, total, stage) ? YLM_OK : YLM_ECANCELLED;
}

/* Runs blocks first .. last-1. */
static ylm_status run_blocks(size_t first, size_t last, size_t n, size_t grain, int threads,
                             ylm_range_fn *fn, void *context) {
  atomic_int failed = YLM_OK;
  if (threads > 1 && last - first > 1) {
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
    for (size_t b = first; b < last; b++) {
      if (atomic_load_explicit(&failed, memory_order_relaxed) != YLM_OK) continue;
      size_t begin = b * grain, end = n - begin < grain ? n : begin + grain;
      ylm_status s = fn(context, begin, end, omp_get_thread_num());
      int ok = YLM_OK;
      if (s != YLM_OK) atomic_compare_exchange_strong(&failed, &ok, (int)s);
    }
    return (ylm_status)failed;
  }
  for (size_t b = first; b < last; b++) {
    size_t begin = b * grain, end = n - begin < grain ? n : begin + grain;
    ylm_status s = fn(context, begin, end, 0);
    if (s != YLM_OK) return s;
  }
  return YLM_OK;
}

ylm_status ylm_parallel(size_t n, size_t grain, int threads, ylm_range_fn *fn, void *context,
                        const ylm_progress *progress, const char *stage) {
  threads = ylm_threads(threads);
  if (grain == 0) grain = 1;
  size_t blocks = n / grain + (n % grain != 0);
  if (!progress) return run_blocks(0, blocks, n, grain, threads, fn, context);
  size_t batch = (size_t)threads, done = 0;
  while (done < blocks) {
    double t = ylm_seconds();
    size_t last = blocks - done < batch ? blocks : done + batch;
    ylm_status s = run_blocks(done, last, n, grain, threads, fn, context);
    if (s != YLM_OK) return s;
    done = last;
    s = ylm_report(progress, done < blocks ? done * grain : n, n, stage);
    if (s != YLM_OK) return s;
    t = ylm_seconds() - t;
    if (t < REPORT_SECONDS / 2)
      batch *= 2;
    else if (t > REPORT_SECONDS * 2 && batch > (size_t)threads)
      batch /= 2;
  }
  return YLM_OK;
}
