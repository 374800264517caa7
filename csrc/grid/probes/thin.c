/*
** thin.c - fewer points: points of a brick become one where that costs little.
**
** A point's cost matrix is that of the squared errors at places around it, the others as they are: H. Two points that become one
** cost (x - y)' (H^-1 + G^-1)^-1 (x - y). Rounds of joins that share no point follow each other, with matrices made anew.
*/
#include "fit.h"

#include <stdlib.h>
#include <string.h>

#define MOST 9       /* numbers of a point */
#define ROUND 0.12   /* of the points that are left, which a round joins at most */
#define CHEAPEST 0.5 /* of the pairs at hand, which a round looks at */

typedef struct pair {
  double cost;
  uint32_t a, b;
} pair;

typedef struct thinning {
  ylm_grid_probes *p;
  const ylm_grid_probes_places *at;
  probes_place *found; /* [places] which joins leave as they are */
  double *matrix;      /* [points][count][count] */
  pair *pair;
  size_t pairs;
  uint32_t *to;     /* [points] what a point becomes */
  uint32_t *number; /* [points] its number then */
} thinning;

/* -- matrices -------------------------------------------------------------------------------------- */

/* A place's part of the matrices. */
static void add_place(thinning *t, const probes_rows *r, size_t i) {
  size_t n = (size_t)t->p->count;
  const float *basis = r->basis + i * n;
  for (size_t k = r->first[i]; k < r->first[i + 1]; k++) {
    double share = (double)r->share[k], w = (double)t->at->weight[i] * share * share;
    double *m = t->matrix + r->point[k] * n * n;
    for (size_t a = 0; a < n; a++)
      for (size_t b = 0; b < n; b++) m[a * n + b] += w * (double)basis[a] * (double)basis[b];
  }
}

static ylm_status make_matrices(thinning *t) {
  probes_rows r = {NULL};
  size_t n = (size_t)t->p->count;
  ylm_status s = ylm__probes_rows(t->p, t->at, t->found, &r);
  if (s != YLM_OK) return s;
  memset(t->matrix, 0, t->p->points * n * n * sizeof *t->matrix);
  for (size_t i = 0; i < t->p->points; i++)
    for (size_t a = 0; a < n; a++)
      t->matrix[(i * n + a) * n + a] = (double)r.hold[i] * (double)ylm__probes_norm[a];
  for (size_t i = 0; i < t->at->n; i++) add_place(t, &r, i);
  ylm__probes_leave(&r);
  return YLM_OK;
}

/* Cholesky's factor of a symmetric positive definite matrix, in its lower half. */
static void factor(size_t n, double m[MOST * MOST]) {
  for (size_t j = 0; j < n; j++) {
    for (size_t k = 0; k < j; k++)
      for (size_t i = j; i < n; i++) m[i * n + j] -= m[i * n + k] * m[j * n + k];
    double d = sqrt(fmax(m[j * n + j], 1e-30));
    for (size_t i = j; i < n; i++) m[i * n + j] /= d;
  }
}

/* x of m m' x = y, in place of y; m as `factor` leaves it. */
static void solve(size_t n, const double m[MOST * MOST], double y[MOST]) {
  for (size_t i = 0; i < n; i++) {
    for (size_t k = 0; k < i; k++) y[i] -= m[i * n + k] * y[k];
    y[i] /= m[i * n + i];
  }
  for (size_t i = n; i-- > 0;) {
    for (size_t k = i + 1; k < n; k++) y[i] -= m[k * n + i] * y[k];
    y[i] /= m[i * n + i];
  }
}

/* The cost of two points that become one, and, where `joined` is not NULL, that one. */
static double join(const thinning *t, uint32_t a, uint32_t b, float *joined) {
  size_t n = (size_t)t->p->count;
  const double *h = t->matrix + a * n * n, *g = t->matrix + b * n * n;
  double cost = 0, sum[MOST * MOST];
  for (size_t i = 0; i < n * n; i++) sum[i] = h[i] + g[i];
  factor(n, sum);
  for (size_t c = 0; c < 3; c++) {
    const float *x = t->p->value + (a * 3 + c) * n, *y = t->p->value + (b * 3 + c) * n;
    double off[MOST] = {0}, own[MOST] = {0};
    for (size_t i = 0; i < n; i++)
      for (size_t j = 0; j < n; j++) {
        double d = (double)y[j] - (double)x[j];
        off[i] += g[i * n + j] * d;
        own[i] += h[i * n + j] * d;
      }
    solve(n, sum, off);
    for (size_t i = 0; i < n; i++) {
      cost += own[i] * off[i];
      if (joined) joined[c * n + i] = (float)((double)x[i] + off[i]);
    }
  }
  return cost;
}

/* -- pairs ----------------------------------------------------------------------------------------- */

static int by_names(const void *x, const void *y) {
  const pair *a = x, *b = y;
  if (a->a != b->a) return a->a < b->a ? -1 : 1;
  return a->b < b->b ? -1 : a->b > b->b;
}

static int by_cost(const void *x, const void *y) {
  const pair *a = x, *b = y;
  if (a->cost != b->cost) return a->cost < b->cost ? -1 : 1;
  return by_names(x, y);
}

static bool is_free(const ylm_grid_probes *p, uint32_t point) {
  return !p->tie || p->tie[point][0] == YLM_GRID_NONE;
}

static void find_pairs(thinning *t) {
  ylm_grid_probes *p = t->p;
  size_t n = 0;
  for (size_t i = 0; i < p->bricks; i++)
    for (int j = 0; j < 8; j++)
      for (int k = 0; k < j; k++) {
        uint32_t a = p->corner[i][j], b = p->corner[i][k];
        if (a != b && is_free(p, a) && is_free(p, b))
          t->pair[n++] = (pair){0, a < b ? a : b, a < b ? b : a};
      }
  qsort(t->pair, n, sizeof *t->pair, by_names);
  t->pairs = 0;
  for (size_t i = 0; i < n; i++)
    if (!i || by_names(&t->pair[i - 1], &t->pair[i]) != 0) t->pair[t->pairs++] = t->pair[i];
  for (size_t i = 0; i < t->pairs; i++) t->pair[i].cost = join(t, t->pair[i].a, t->pair[i].b, NULL);
  qsort(t->pair, t->pairs, sizeof *t->pair, by_cost);
}

/* Joins up to `most` pairs that have no point in common, the cheapest first. Returns their number. */
static size_t join_pairs(thinning *t, size_t most) {
  ylm_grid_probes *p = t->p;
  size_t joins = 0, width = 3 * (size_t)p->count, last = (size_t)ceil(CHEAPEST * (double)t->pairs);
  for (size_t i = 0; i < p->points; i++) t->to[i] = (uint32_t)i;
  for (size_t i = 0; i < last && joins < most; i++) {
    uint32_t a = t->pair[i].a, b = t->pair[i].b;
    float one[3 * MOST];
    if (t->to[a] != a || t->to[b] != b || p->ghost[a] > 1 || p->ghost[b] > 1) continue;
    join(t, a, b, one);
    memcpy(p->value + a * width, one, width * sizeof *one);
    p->ghost[a] = (p->ghost[a] && p->ghost[b]) | 2; /* 2: it was joined in this round */
    t->to[b] = a;
    joins++;
  }
  return joins;
}

/* The point that a point has become, over others. */
static uint32_t last_of(const uint32_t *to, uint32_t point) {
  while (to[point] != point) point = to[point];
  return point;
}

/* A point between four that are one by now is that one. */
static void join_ties(thinning *t) {
  ylm_grid_probes *p = t->p;
  bool again = p->tie != NULL;
  while (again) {
    again = false;
    for (size_t i = 0; i < p->points; i++) {
      uint32_t *tie = p->tie[i];
      if (t->to[i] != i || tie[0] == YLM_GRID_NONE) continue;
      for (int k = 0; k < 4; k++) tie[k] = last_of(t->to, tie[k]);
      if (tie[0] != tie[1] || tie[0] != tie[2] || tie[0] != tie[3]) continue;
      t->to[i] = tie[0];
      again = true;
    }
  }
}

/* Points that are left, in their order. */
static void renumber(thinning *t) {
  ylm_grid_probes *p = t->p;
  size_t width = 3 * (size_t)p->count, n = 0;
  join_ties(t);
  for (size_t i = 0; i < p->points; i++)
    if (t->to[i] == i) t->number[i] = (uint32_t)n++;
  for (size_t i = 0; i < p->points; i++) {
    if (t->to[i] != i) continue;
    size_t to = t->number[i];
    memmove(p->value + to * width, p->value + i * width, width * sizeof *p->value);
    p->ghost[to] = p->ghost[i] & 1;
    for (int k = 0; p->tie && k < 4; k++) {
      uint32_t end = p->tie[i][k];
      bool free = p->tie[i][0] == YLM_GRID_NONE;
      p->tie[to][k] = free ? YLM_GRID_NONE : t->number[last_of(t->to, end)];
    }
  }
  for (size_t i = 0; i < p->bricks; i++)
    for (int k = 0; k < 8; k++) p->corner[i][k] = t->number[last_of(t->to, p->corner[i][k])];
  p->points = n;
}

ylm_status ylm_grid_probes_thin(ylm_grid_probes *p, const ylm_grid_probes_places *at,
                                size_t points) {
  size_t n = (size_t)p->count;
  if (ylm__probes_free_points(p) <= points || !at->n || !p->ghost) return YLM_OK;
  thinning t = {.p = p,
                .at = at,
                .found = ylm_alloc(at->n, sizeof *t.found),
                .matrix = ylm_alloc(p->points, n * n * sizeof *t.matrix),
                .pair = ylm_alloc(p->bricks, 28 * sizeof *t.pair),
                .to = ylm_alloc(p->points, sizeof *t.to),
                .number = ylm_alloc(p->points, sizeof *t.number)};
  ylm_status s = t.found && t.matrix && t.pair && t.to && t.number ? YLM_OK : YLM_ENOMEM;
  size_t left;
  for (size_t i = 0; s == YLM_OK && i < at->n; i++)
    t.found[i] = ylm__probes_find(p, at->point[i], at->normal[i]);
  while (s == YLM_OK && (left = ylm__probes_free_points(p)) > points) {
    size_t most = (size_t)ceil(ROUND * (double)left), more = left - points;
    s = make_matrices(&t);
    if (s != YLM_OK) break;
    find_pairs(&t);
    if (!join_pairs(&t, more < most ? more : most)) break;
    renumber(&t);
  }
  ylm_free(t.found);
  ylm_free(t.matrix);
  ylm_free(t.pair);
  ylm_free(t.to);
  ylm_free(t.number);
  if (s == YLM_OK) s = ylm__probes_compact(p);
  if (s == YLM_OK) ylm__probes_follow_ties(p);
  return s;
}
