/*
** grow.c - charts as parts of a surface: grown from triangles by their normals, and cut in two.
**
** The largest triangle that has no chart begins one. Of the triangles beside a chart the one whose normal is nearest to the
** mean of the chart's comes next, until none is within the angle.
*/
#include <math.h>
#include <stdlib.h>

#include "unwrap.h"
#include "ylm_list.h"
#include "ylm_vector.h"

ylm_status ylm__unwrap_add(ylm_unwrap *u, size_t first, size_t triangles) {
  if (!ylm_list_reserve(&u->chart, u->charts, u->charts + 1, &u->room, sizeof *u->chart))
    return YLM_ENOMEM;
  u->chart[u->charts++] = (unwrap_chart){.first = first, .triangles = triangles};
  return YLM_OK;
}

/* -- a heap of triangles, the cheapest first ------------------------------------------------------ */

typedef struct offer {
  double cost;
  uint32_t triangle;
} offer;

typedef struct offers {
  offer *list;
  size_t n, room;
} offers;

static bool is_before(const offer *a, const offer *b) {
  return a->cost != b->cost ? a->cost < b->cost : a->triangle < b->triangle;
}

static bool push(offers *h, offer x) {
  if (!ylm_list_reserve(&h->list, h->n, h->n + 1, &h->room, sizeof *h->list)) return false;
  size_t at = h->n++;
  for (; at && is_before(&x, &h->list[(at - 1) / 2]); at = (at - 1) / 2)
    h->list[at] = h->list[(at - 1) / 2];
  h->list[at] = x;
  return true;
}

static offer pop(offers *h) {
  offer first = h->list[0], last = h->list[--h->n];
  size_t at = 0;
  for (;;) {
    size_t child = 2 * at + 1;
    if (child >= h->n) break;
    if (child + 1 < h->n && is_before(&h->list[child + 1], &h->list[child])) child++;
    if (!is_before(&h->list[child], &last)) break;
    h->list[at] = h->list[child];
    at = child;
  }
  if (h->n) h->list[at] = last;
  return first;
}

/* -- growth --------------------------------------------------------------------------------------- */

typedef struct growth {
  const unwrap_surface *s;
  offers heap;
  double mean[3], length; /* the sum of area times normal, and its length */
  uint32_t chart;
  double cosine;
} growth;

static double facing(const growth *g, size_t t) {
  return ylm_dot3d(g->s->normal[t], g->mean) / g->length;
}

/* Takes a triangle into the chart, and offers those beside it. */
static ylm_status take(growth *g, size_t t, uint32_t *list, size_t *n) {
  const unwrap_surface *s = g->s;
  s->of[t] = g->chart;
  list[(*n)++] = (uint32_t)t;
  for (int c = 0; c < 3; c++) g->mean[c] += s->area[t] * s->normal[t][c];
  g->length = sqrt(ylm_dot3d(g->mean, g->mean));
  for (size_t k = 3 * t; k < 3 * t + 3; k++) {
    if (s->across[k] == UNWRAP_NONE) continue;
    uint32_t beside = s->across[k] / 3;
    double cosine = facing(g, beside);
    if (s->of[beside] != UNWRAP_NONE || !(cosine >= g->cosine)) continue;
    if (s->label && s->label[beside] != s->label[t]) continue;
    if (!push(&g->heap, (offer){1 - cosine, beside})) return YLM_ENOMEM;
  }
  return YLM_OK;
}

static ylm_status grow_from(growth *g, size_t seed, uint32_t *list, size_t *n) {
  memset(g->mean, 0, sizeof g->mean);
  g->heap.n = 0;
  ylm_status s = take(g, seed, list, n);
  while (s == YLM_OK && g->heap.n) {
    offer next = pop(&g->heap);
    if (g->s->of[next.triangle] == UNWRAP_NONE && facing(g, next.triangle) >= g->cosine)
      s = take(g, next.triangle, list, n);
  }
  return s;
}

static int by_area(const void *a, const void *b) {
  const offer *p = a, *q = b;
  if (p->cost != q->cost) return p->cost > q->cost ? -1 : 1;
  return p->triangle < q->triangle ? -1 : p->triangle > q->triangle;
}

ylm_status ylm__unwrap_grow(ylm_unwrap *u, const unwrap_surface *s, double cosine) {
  growth g = {.s = s, .cosine = cosine};
  size_t seeds = 0, used = 0;
  offer *seed = ylm_alloc(s->triangles, sizeof *seed);
  ylm_status status = seed ? YLM_OK : YLM_ENOMEM;
  for (size_t t = 0; seed && t < s->triangles; t++) {
    s->of[t] = UNWRAP_NONE;
    if (s->area[t] > 0) seed[seeds++] = (offer){s->area[t], (uint32_t)t};
  }
  if (seed) qsort(seed, seeds, sizeof *seed, by_area);
  for (size_t i = 0; status == YLM_OK && i < seeds; i++) {
    if (s->of[seed[i].triangle] != UNWRAP_NONE) continue;
    size_t first = used;
    g.chart = (uint32_t)u->charts;
    status = grow_from(&g, seed[i].triangle, u->list, &used);
    if (status == YLM_OK) status = ylm__unwrap_add(u, first, used - first);
  }
  ylm_free(g.heap.list);
  ylm_free(seed);
  return status;
}

/* -- halves --------------------------------------------------------------------------------------- */

static void middle_of(const unwrap_surface *s, size_t t, double at[3]) {
  for (int c = 0; c < 3; c++)
    at[c] = (s->point[t][0][c] + s->point[t][1][c] + s->point[t][2][c]) / 3;
}

/* The middle of a chart's triangles, and the direction in which they spread most: by powers of the covariance. */
static void find_axis(const ylm_unwrap *u, const unwrap_surface *s, const unwrap_chart *c,
                      double middle[3], double axis[3]) {
  double square[3][3] = {{0}}, area = 0, at[3];
  memset(middle, 0, 3 * sizeof *middle);
  for (size_t i = c->first; i < c->first + c->triangles; i++) {
    middle_of(s, u->list[i], at);
    area += s->area[u->list[i]];
    for (int k = 0; k < 3; k++) middle[k] += s->area[u->list[i]] * at[k];
  }
  for (int k = 0; k < 3; k++) middle[k] /= area;
  for (size_t i = c->first; i < c->first + c->triangles; i++) {
    middle_of(s, u->list[i], at);
    for (int k = 0; k < 9; k++)
      square[k / 3][k % 3] +=
          s->area[u->list[i]] * (at[k / 3] - middle[k / 3]) * (at[k % 3] - middle[k % 3]);
  }
  int most = square[1][1] > square[0][0];
  if (square[2][2] > square[most][most]) most = 2;
  memcpy(axis, square[most], 3 * sizeof *axis);
  for (int step = 0; step < 32; step++) {
    double next[3];
    if (!ylm_unit3(axis)) break;
    for (int k = 0; k < 3; k++) next[k] = ylm_dot3d(square[k], axis);
    memcpy(axis, next, sizeof next);
  }
  if (!ylm_unit3(axis)) memcpy(axis, (double[3]){1, 0, 0}, 3 * sizeof *axis);
}

/* The part of a chart's triangles that joins triangle `seed`, all of number `part`: they become `chart`. */
static void flood(const unwrap_surface *s, uint32_t seed, uint32_t part, uint32_t chart,
                  uint32_t *list, size_t *n) {
  size_t next = *n;
  s->of[seed] = chart;
  list[(*n)++] = seed;
  for (; next < *n; next++)
    for (size_t k = 3 * (size_t)list[next]; k < 3 * (size_t)list[next] + 3; k++) {
      uint32_t beside = s->across[k] == UNWRAP_NONE ? UNWRAP_NONE : s->across[k] / 3;
      if (beside == UNWRAP_NONE || s->of[beside] != part) continue;
      s->of[beside] = chart;
      list[(*n)++] = beside;
    }
}

ylm_status ylm__unwrap_halve(ylm_unwrap *u, const unwrap_surface *s, size_t chart) {
  unwrap_chart c = u->chart[chart];
  size_t n = 0, beyond = 0;
  double middle[3], axis[3], at[3];
  uint32_t *old = ylm_alloc(c.triangles, sizeof *old),
           sides[2] = {UNWRAP_NONE - 2, UNWRAP_NONE - 1};
  if (!old) return YLM_ENOMEM;
  memcpy(old, u->list + c.first, c.triangles * sizeof *old);
  find_axis(u, s, &c, middle, axis);
  for (size_t i = 0; i < c.triangles; i++) {
    middle_of(s, old[i], at);
    bool far = ylm_dot3d(at, axis) > ylm_dot3d(middle, axis);
    s->of[old[i]] = sides[far];
    beyond += far;
  }
  for (size_t i = 0; (beyond == 0 || beyond == c.triangles) && i < c.triangles; i++)
    s->of[old[i]] = sides[2 * i >= c.triangles]; /* all in one place */
  ylm_status status = YLM_OK;
  for (size_t i = 0, first = 0; status == YLM_OK && i < c.triangles; i++, first = n) {
    uint32_t part = s->of[old[i]];
    if (part != sides[0] && part != sides[1]) continue;
    flood(s, old[i], part, (uint32_t)(first ? u->charts : chart), u->list + c.first, &n);
    if (first)
      status = ylm__unwrap_add(u, c.first + first, n - first);
    else
      u->chart[chart] = (unwrap_chart){.first = c.first, .triangles = n};
  }
  ylm_free(old);
  return status;
}
