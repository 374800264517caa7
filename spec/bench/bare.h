/*
** bare.h - rays traced in batches and nothing done with what they hit: the rate that bounds whatever
** traces the same rays. bench_seconds(bare_nearest, &rays) is the time of all of them on one thread.
*/
#ifndef YLM_BENCH_BARE_H
#define YLM_BENCH_BARE_H

#include "bench.h"
#include "ylm_trace.h"

#define BARE_BATCH 1024
#define BARE_LAMPS 16

typedef struct bare_rays {
  const ylm_trace *trace;
  size_t n;
  const ylm_trace_ray *ray; /* [n] */
  size_t met;               /* lamps, by bare_lamps */
} bare_rays;

/* First hits of a kind: of what occludes, of all, of all by rays that run alike. */
static inline void bare_hits(const bare_rays *b, int kind) {
  ylm_trace_hit hit[BARE_BATCH];
  for (size_t i = 0; i < b->n; i += BARE_BATCH) {
    size_t n = b->n - i < BARE_BATCH ? b->n - i : BARE_BATCH;
    if (kind == 0)
      ylm_trace_nearest(b->trace, n, b->ray + i, false, hit);
    else
      ylm_trace_intersect(b->trace, n, b->ray + i, kind == 2, hit);
  }
}
static inline void bare_nearest(void *context) { bare_hits(context, 0); }
static inline void bare_first(void *context) { bare_hits(context, 1); }
static inline void bare_camera(void *context) { bare_hits(context, 2); }

/* Shadow rays. */
static inline void bare_occluded(void *context) {
  const bare_rays *b = context;
  ylm_trace_ray ray[BARE_BATCH];
  for (size_t i = 0; i < b->n; i += BARE_BATCH) {
    size_t n = b->n - i < BARE_BATCH ? b->n - i : BARE_BATCH;
    memcpy(ray, b->ray + i, n * sizeof *ray);
    ylm_trace_occluded(b->trace, n, ray);
  }
}

/* All lamps that each ray meets. */
static inline void bare_lamps(void *context) {
  bare_rays *b = context;
  ylm_trace_meeting met[BARE_LAMPS];
  b->met = 0;
  for (size_t i = 0; i < b->n; i++) {
    size_t n = ylm_trace_next_lamps(b->trace, &b->ray[i], NULL, BARE_LAMPS, met);
    for (b->met += n; n == BARE_LAMPS; b->met += n)
      n = ylm_trace_next_lamps(b->trace, &b->ray[i], &met[n - 1], BARE_LAMPS, met);
  }
}

#endif
