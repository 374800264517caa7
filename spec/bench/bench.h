/*
** bench.h - timing for the programs in spec/bench.
**
** A measurement is the least of repeated short runs, each long enough for the clock: on a machine
** that is shared, what other processes do meanwhile only adds. Each program prints lines of text
*and takes no input;
** BENCH=quick in the environment measures a tenth as long.
*/
#ifndef YLM_BENCH_H
#define YLM_BENCH_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ylm_base.h"

typedef void bench_fn(void *context);

static inline int bench_is_quick(void) {
  const char *s = getenv("BENCH");
  return s && strcmp(s, "quick") == 0;
}

/* The least seconds of one call of `fn`: 15 samples of about 2 ms each (5 of 0.4 ms if quick). */
static inline double bench_seconds(bench_fn *fn, void *context) {
  double least = 1e30, aim = bench_is_quick() ? 4e-4 : 2e-3;
  int n = bench_is_quick() ? 5 : 15;
  long calls = 1;
  fn(context);
  for (;;) { /* how many calls take long enough? */
    double t = ylm_seconds();
    for (long i = 0; i < calls; i++) fn(context);
    t = ylm_seconds() - t;
    if (t >= aim / 2 || calls > 1L << 40) break;
    calls = t > aim / 50 ? (long)((double)calls * aim / t) + 1 : calls * 8;
  }
  for (int s = 0; s < n; s++) {
    double t = ylm_seconds();
    for (long i = 0; i < calls; i++) fn(context);
    t = (ylm_seconds() - t) / (double)calls;
    if (t < least) least = t;
  }
  return least;
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
