/*
** bench.h - timing for the programs in spec/bench.
**
** A measurement is the least of repeated runs, each long enough for the clock, of this thread's
** processor time: on a machine that others use, wall times measure the others. Where threads share
** the work (bench_wall) it is the least wall time. Each program prints lines of text and takes no
** input. BENCH in the environment: `quick` measures a tenth as long, other words select programs.
*/
#ifndef YLM_BENCH_H
#define YLM_BENCH_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "ylm_base.h"

typedef void bench_fn(void *context);

static inline int bench_is_quick(void) {
  const char *s = getenv("BENCH");
  return s && strcmp(s, "quick") == 0;
}

/* Seconds of processor time of this thread. */
static inline double bench_cpu(void) {
  struct timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Least seconds of one call of `fn` by a clock: samples of about 2 ms, at least 3 of them and at
   most 15 or 40 ms in all (a tenth if quick). */
static inline double bench_least(bench_fn *fn, void *context, double (*clock)(void)) {
  double scale = bench_is_quick() ? 0.1 : 1, aim = 2e-3 * scale, least = 1e30, spent = 0;
  long calls = 1;
  fn(context);
  for (;;) { /* how many calls take long enough? */
    double t = clock();
    for (long i = 0; i < calls; i++) fn(context);
    t = clock() - t;
    if (t >= aim / 2 || calls > 1L << 40) break;
    calls = t > aim / 50 ? (long)((double)calls * aim / t) + 1 : calls * 8;
  }
  for (int s = 0; s < 3 || (s < 15 && spent < 0.04 * scale); s++) {
    double t = clock();
    for (long i = 0; i < calls; i++) fn(context);
    t = clock() - t;
    spent += t;
    if (t / (double)calls < least) least = t / (double)calls;
  }
  return least;
}
static inline double bench_seconds(bench_fn *fn, void *context) {
  return bench_least(fn, context, bench_cpu);
}
static inline double bench_wall(bench_fn *fn, void *context) {
  return bench_least(fn, context, ylm_seconds);
}

/* Random numbers in -1 .. 1, always the same. */
static inline void bench_fill(ylm_dtype t, void *x, size_t n) {
  ylm_rng r;
  ylm_rng_seed(&r, 1, 1);
  for (size_t i = 0; i < n; i++) {
    double v = 2 * ylm_rng_double(&r) - 1;
    if (t == YLM_DOUBLE)
      ((double *)x)[i] = v;
    else
      ((float *)x)[i] = (float)v;
  }
}

#endif
