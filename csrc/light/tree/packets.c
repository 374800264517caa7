/*
** packets.c - the order in which points are taken: packets of points that lie together, and
** blocks of such packets.
**
** Points are halved across the longest extent of their places, so many at a time that all packets
** but the last are full; a block is at most as large as it may be. The order depends on the points alone.
*/
#include "tree.h"

#include <math.h>

typedef struct cutter {
  ylm_dtype type;
  const void *points;
  size_t most; /* points of a block */
  size_t *order;
  ylm__packing *out;
} cutter;

static double coordinate(const cutter *c, size_t i, int axis) {
  size_t at = 3 * c->order[i] + (size_t)axis;
  return c->type == YLM_DOUBLE ? ((const double *)c->points)[at]
                               : (double)((const float *)c->points)[at];
}

static int longest_axis(const cutter *c, size_t begin, size_t end) {
  double lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (size_t i = begin; i < end; i++)
    for (int a = 0; a < 3; a++) {
      double x = coordinate(c, i, a);
      lo[a] = fmin(lo[a], x), hi[a] = fmax(hi[a], x);
    }
  int axis = 0;
  for (int a = 1; a < 3; a++)
    if (hi[a] - lo[a] > hi[axis] - lo[axis]) axis = a;
  return axis;
}

/* Does the point `p` come before the i-th? By an axis, then by the others. */
static bool before(const cutter *c, const double *p, size_t i, int axis) {
  for (int a = 0; a < 3; a++) {
    double x = coordinate(c, i, (axis + a) % 3), y = p[(axis + a) % 3];
    if (y != x) return y < x;
  }
  return false;
}

static bool after(const cutter *c, const double *p, size_t i, int axis) {
  for (int a = 0; a < 3; a++) {
    double x = coordinate(c, i, (axis + a) % 3), y = p[(axis + a) % 3];
    if (y != x) return y > x;
  }
  return false;
}

/* Partial sort of begin .. end-1: what comes before `middle` is before it. */
static void part(const cutter *c, size_t begin, size_t end, size_t middle, int axis) {
  while (end - begin > 1) {
    size_t i = begin, j = end - 1, half = begin + (end - begin - 1) / 2;
    double pivot[3];
    for (int a = 0; a < 3; a++) pivot[a] = coordinate(c, half, a);
    for (;;) {
      while (after(c, pivot, i, axis)) i++;
      while (before(c, pivot, j, axis)) j--;
      if (i >= j) break;
      size_t swap = c->order[i];
      c->order[i++] = c->order[j], c->order[j--] = swap;
    }
    if (middle <= j)
      end = j + 1;
    else
      begin = j + 1;
  }
}

/* Cuts begin .. end-1 into packets, `whole` if that is part of a block already. */
static void cut(cutter *c, size_t begin, size_t end, bool whole) {
  for (;;) {
    if (!whole && end - begin <= c->most) {
      c->out->block[c->out->blocks++] = begin;
      whole = true;
    }
    if (end - begin <= YLM__PACKET) return;
    size_t packets = (end - begin + YLM__PACKET - 1) / YLM__PACKET;
    size_t middle = begin + packets / 2 * YLM__PACKET;
    part(c, begin, end, middle, longest_axis(c, begin, end));
    cut(c, begin, middle, whole);
    begin = middle;
  }
}

ylm_status ylm__packing_create(ylm_dtype type, size_t n, const void *points, size_t most,
                               ylm__packing *out) {
  *out = (ylm__packing){ylm_alloc(n, sizeof *out->order),
                        ylm_alloc(n / YLM__PACKET + 2, sizeof *out->block), 0};
  if (!out->order || !out->block) return YLM_ENOMEM;
  cutter c = {type, points, most, out->order, out};
  for (size_t i = 0; i < n; i++) c.order[i] = i;
  cut(&c, 0, n, false);
  out->block[out->blocks] = n;
  return YLM_OK;
}

/* Reports points where blocks are done. */
typedef struct points_done {
  const ylm_progress *progress;
  const ylm__packing *packing;
} points_done;

static bool report(void *user, uint64_t done, uint64_t total, const char *stage) {
  const points_done *d = user;
  const size_t *block = d->packing->block;
  return ylm_report(d->progress, block[done], block[total], stage) == YLM_OK;
}

ylm_status ylm__packing_run(const ylm__packing *p, const ylm_field_query *q, ylm_range_fn *fn,
                            void *job) {
  points_done done = {q->progress, p};
  ylm_progress blocks = {report, &done};
  return ylm_parallel(p->blocks, 1, q->threads, fn, job, q->progress ? &blocks : NULL, "lights");
}

void ylm__packing_free(ylm__packing *p) {
  ylm_free(p->order);
  ylm_free(p->block);
}
