/*
** valid.c - whether a flat chart covers no place twice.
**
** All triangles turn the same way, the angles about an inner vertex make one turn, those about a vertex of the border less
** than one, and no two edges of the border meet but at their common vertex. The border is then one outer loop with holes, and
** each place inside of it is covered once: the border's loops wind around no place more often than once.
*/
#include <math.h>
#include <stdlib.h>

#include "unwrap.h"

#define FLAT_LEAST 1e-9 /* of a flat triangle's area over the surface's */
#define TOUCH 1e-12     /* over the lengths of two edges: they touch */
static const double pi = 3.14159265358979323846;

typedef struct border {
  double at[2][2], low[2], high[2];
  uint32_t end[2];
} border;

static int by_low(const void *a, const void *b) {
  const border *p = a, *q = b;
  if (p->low[0] != q->low[0]) return p->low[0] < q->low[0] ? -1 : 1;
  return p->end[0] < q->end[0] ? -1 : p->end[0] > q->end[0];
}

/* Twice the area of a triangle. */
static double turn(const double p[2], const double q[2], const double r[2]) {
  return (q[0] - p[0]) * (r[1] - p[1]) - (r[0] - p[0]) * (q[1] - p[1]);
}

static bool meet(const border *a, const border *b) {
  for (int i = 0; i < 4; i++)
    if (a->end[i / 2] == b->end[i % 2]) return false; /* what the angles tell */
  for (int k = 0; k < 2; k++)
    if (a->low[k] > b->high[k] || b->low[k] > a->high[k]) return false;
  double touch = TOUCH * hypot(a->at[1][0] - a->at[0][0], a->at[1][1] - a->at[0][1]) *
                 hypot(b->at[1][0] - b->at[0][0], b->at[1][1] - b->at[0][1]);
  double p = turn(a->at[0], a->at[1], b->at[0]), q = turn(a->at[0], a->at[1], b->at[1]);
  double r = turn(b->at[0], b->at[1], a->at[0]), s = turn(b->at[0], b->at[1], a->at[1]);
  bool apart = (p > touch && q > touch) || (p < -touch && q < -touch) || (r > touch && s > touch) ||
               (r < -touch && s < -touch);
  return !apart;
}

/* Whether no two of the n edges meet: by a sweep. */
static bool is_simple(size_t n, border *list) {
  qsort(list, n, sizeof *list, by_low);
  for (size_t i = 0; i < n; i++)
    for (size_t k = i + 1; k < n && list[k].low[0] <= list[i].high[0]; k++)
      if (meet(&list[i], &list[k])) return false;
  return true;
}

static border edge_of(const unwrap_chart *c, uint32_t from, uint32_t to) {
  border b = {.end = {from, to}};
  for (int a = 0; a < 2; a++) {
    b.at[0][a] = c->flat[from][a];
    b.at[1][a] = c->flat[to][a];
    b.low[a] = fmin(b.at[0][a], b.at[1][a]);
    b.high[a] = fmax(b.at[0][a], b.at[1][a]);
  }
  return b;
}

/* Adds the angles of triangle t to those of its vertices; false: it is turned over, or hardly there. */
static bool add_angles(const ylm_unwrap *u, const unwrap_surface *s, const unwrap_chart *c,
                       size_t t, double *angle) {
  const uint32_t *v = u->corner + 3 * t;
  double twice = turn(c->flat[v[0]], c->flat[v[1]], c->flat[v[2]]);
  if (!(twice > 2 * FLAT_LEAST * s->area[t]) || !isfinite(twice)) return false;
  for (int k = 0; k < 3; k++) {
    const double *p = c->flat[v[k]], *q = c->flat[v[(k + 1) % 3]], *r = c->flat[v[(k + 2) % 3]];
    angle[v[k]] += atan2(twice, (q[0] - p[0]) * (r[0] - p[0]) + (q[1] - p[1]) * (r[1] - p[1]));
  }
  return true;
}

ylm_status ylm__unwrap_valid(const ylm_unwrap *u, const unwrap_surface *s, const unwrap_chart *c,
                             bool *valid) {
  double *angle = ylm_alloc_zero(c->vertices, sizeof *angle);
  bool *outer = ylm_alloc_zero(c->vertices, sizeof *outer);
  border *list = ylm_alloc(c->triangles, 3 * sizeof *list);
  size_t n = 0;
  ylm_status status = angle && outer && list ? YLM_OK : YLM_ENOMEM;
  uint32_t chart = s->of[u->list[c->first]];
  *valid = status == YLM_OK;
  for (size_t i = c->first; *valid && i < c->first + c->triangles; i++) {
    size_t t = u->list[i];
    *valid = add_angles(u, s, c, t, angle);
    for (size_t k = 3 * t; *valid && k < 3 * t + 3; k++) {
      if (s->across[k] != UNWRAP_NONE && s->of[s->across[k] / 3] == chart) continue;
      list[n++] = edge_of(c, u->corner[k], u->corner[unwrap_next(k)]);
      outer[u->corner[k]] = outer[u->corner[unwrap_next(k)]] = true;
    }
  }
  for (size_t i = 0; *valid && i < c->vertices; i++)
    *valid = angle[i] < (outer[i] ? 2 * pi - 1e-6 : 3 * pi);
  *valid = *valid && is_simple(n, list);
  ylm_free(angle);
  ylm_free(outer);
  ylm_free(list);
  return status;
}
