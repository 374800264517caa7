/* radius.c - how wide lights are: by the lights around them, by the way of their particle, or as told. */
#include <stdlib.h>

#include "emit.h"

#define NEIGHBOURS 10
#define FACING 0.5      /* the cosine between normals of neighbours, at least */
#define FLAT 0.5        /* the distance from the tangent plane over the distance, at most */
#define MOST_LOOKS 4096 /* lights that are looked at for one light's neighbours */
#define LEAF 8
#define GRAIN 256
#define MOST_MEDIANS 4

/* A balanced tree of places: the middle of a range splits it along `axis`. */
typedef struct tree {
  size_t n;
  const emit_landing *landing;
  uint32_t *order; /* [n] */
  uint8_t *axis;   /* [n] of the split at this place */
} tree;

static float at(const tree *t, size_t k, int axis) { return t->landing[t->order[k]].at[axis]; }

/* The axis along which the range is longest. */
static int longest(const tree *t, size_t low, size_t high) {
  float size[3];
  int axis = 0;
  for (int a = 0; a < 3; a++) {
    float least = INFINITY, most = -INFINITY;
    for (size_t k = low; k < high; k++) {
      least = fminf(least, at(t, k, a));
      most = fmaxf(most, at(t, k, a));
    }
    size[a] = most - least;
    if (size[a] > size[axis]) axis = a;
  }
  return axis;
}

/* Whether light a comes before b: places that are equal keep the order of numbers. */
static bool before(const tree *t, uint32_t a, uint32_t b, int axis) {
  float x = t->landing[a].at[axis], y = t->landing[b].at[axis];
  return x < y || (x == y && a < b);
}

/* Puts the light that belongs there at `middle`, lesser ones before it (Hoare 1961). */
static void divide(tree *t, size_t low, size_t high, size_t middle, int axis) {
  uint32_t *o = t->order;
  while (high - low > 1) {
    uint32_t pivot = o[low + (high - low) / 2];
    size_t i = low, j = high - 1;
    for (;;) {
      while (before(t, o[i], pivot, axis)) i++;
      while (before(t, pivot, o[j], axis)) j--;
      if (i >= j) break;
      uint32_t x = o[i];
      o[i++] = o[j];
      o[j--] = x;
    }
    if (i == j && middle == j) return; /* the pivot's place */
    if (middle <= j)
      high = i == j ? j : j + 1;
    else
      low = j + 1;
  }
}

static void plant(tree *t, size_t low, size_t high) {
  while (high - low > LEAF) {
    size_t middle = low + (high - low) / 2;
    int axis = longest(t, low, high);
    divide(t, low, high, middle, axis);
    t->axis[middle] = (uint8_t)axis;
    plant(t, low, middle);
    low = middle + 1;
  }
}

/* Neighbours of one light: the squares of their distances, the largest first in a heap. */
typedef struct search {
  const tree *t;
  const emit_landing *of;
  uint32_t self;
  size_t found, looks;
  float d2[NEIGHBOURS];
} search;

static void push(search *s, float d2) {
  size_t k;
  if (s->found < NEIGHBOURS)
    k = s->found++;
  else if (d2 < s->d2[NEIGHBOURS - 1])
    k = NEIGHBOURS - 1;
  else
    return;
  while (k > 0 && s->d2[k - 1] > d2) { /* kept in order, the least first */
    s->d2[k] = s->d2[k - 1];
    k--;
  }
  s->d2[k] = d2;
}

static void look(search *s, uint32_t i) {
  const emit_landing *a = s->of, *b = &s->t->landing[i];
  float v[3], d2 = 0, up = 0;
  s->looks++;
  if (i == s->self) return;
  for (int k = 0; k < 3; k++) {
    v[k] = b->at[k] - a->at[k];
    d2 += v[k] * v[k];
    up += v[k] * a->normal[k];
  }
  if (ylm_dot3(a->normal, b->normal) < (float)FACING) return;
  if (up * up > (float)(FLAT * FLAT) * d2) return;
  push(s, d2);
}

static void walk(search *s, size_t low, size_t high) {
  const tree *t = s->t;
  if (s->looks >= MOST_LOOKS) return;
  if (high - low <= LEAF) {
    for (size_t k = low; k < high; k++) look(s, t->order[k]);
    return;
  }
  size_t middle = low + (high - low) / 2;
  int axis = t->axis[middle];
  float beyond = s->of->at[axis] - at(t, middle, axis);
  if (beyond < 0)
    walk(s, low, middle);
  else
    walk(s, middle + 1, high);
  look(s, t->order[middle]);
  if (s->found == NEIGHBOURS && beyond * beyond >= s->d2[NEIGHBOURS - 1]) return;
  if (beyond < 0)
    walk(s, middle + 1, high);
  else
    walk(s, low, middle);
}

typedef struct job {
  tree t;
  double scale;
  double *radius;
} job;

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  for (size_t i = begin; i < end; i++) {
    search s = {.t = &j->t, .of = &j->t.landing[i], .self = (uint32_t)i};
    walk(&s, 0, j->t.n);
    j->radius[i] = s.found ? j->scale * sqrt((double)s.d2[s.found - 1] / (double)s.found) : 0;
  }
  return YLM_OK;
}

static ylm_status by_density(const emit_landing *landing, const ylm_emit_options *o,
                             ylm_emit_lights *l) {
  job j = {.t = {.n = l->n, .landing = landing}, .scale = o->scale, .radius = l->radius};
  j.t.order = ylm_alloc(l->n, sizeof *j.t.order);
  j.t.axis = ylm_alloc(l->n, 1);
  ylm_status s = j.t.order && j.t.axis ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < l->n; i++) j.t.order[i] = (uint32_t)i;
  if (s == YLM_OK) plant(&j.t, 0, l->n);
  if (s == YLM_OK) s = ylm_parallel(l->n, GRAIN, o->threads, run, &j, o->progress, "radius");
  ylm_free(j.t.order);
  ylm_free(j.t.axis);
  return s;
}

/* The radius of a disk that has the n-th part of the surface of the box around all lights. */
static double even(const ylm_emit_lights *l, double scale) {
  double size[3], area;
  for (size_t a = 0; a < 3; a++) {
    double least = INFINITY, most = -INFINITY;
    for (size_t i = 0; i < l->n; i++) {
      least = fmin(least, l->at[3 * i + a]);
      most = fmax(most, l->at[3 * i + a]);
    }
    size[a] = most - least;
  }
  area = 2 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]);
  return area > 0 ? scale * sqrt(area / EMIT_PI / (double)l->n) : scale;
}

static int compare(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Cuts radii at some medians, and fills those that are not known; tells least, median and largest. */
static ylm_status settle(const ylm_emit_options *o, ylm_emit_lights *l, ylm_emit_report *report) {
  size_t n = 0;
  double *sorted = ylm_alloc(l->n, sizeof *sorted);
  if (!sorted) return YLM_ENOMEM;
  for (size_t i = 0; i < l->n; i++)
    if (l->radius[i] > 0) sorted[n++] = l->radius[i];
  qsort(sorted, n, sizeof *sorted, compare);
  double median = n > 0 ? sorted[n / 2] : even(l, o->scale), most = MOST_MEDIANS * median;
  report->radius[0] = n > 0 ? sorted[0] : median;
  report->radius[1] = report->radius[2] = median;
  for (size_t i = 0; i < l->n; i++) {
    double *r = &l->radius[i];
    if (!(*r > 0)) *r = median;
    if (*r > most) {
      *r = most;
      report->cut++;
    }
    report->radius[2] = fmax(report->radius[2], *r);
  }
  ylm_free(sorted);
  return YLM_OK;
}

ylm_status ylm__emit_radii(const emit_landing *landing, const ylm_emit_options *o,
                           ylm_emit_lights *l, ylm_emit_report *report) {
  ylm_status s = YLM_OK;
  double lights = (double)(o->lights ? o->lights : o->particles);
  double angle = acos(fmax(0, 1 - 2 / lights));
  if (l->n == 0) return YLM_OK;
  if (o->radius == YLM_EMIT_DENSITY) s = by_density(landing, o, l);
  if (o->radius == YLM_EMIT_FOOTPRINT)
    for (size_t i = 0; i < l->n; i++)
      l->radius[i] = o->scale * sqrt((double)landing[i].area / EMIT_PI);
  bool other = o->radius == YLM_EMIT_FIXED || o->radius == YLM_EMIT_ANGLE;
  for (size_t i = 0; i < l->n && other; i++)
    l->radius[i] = o->radius == YLM_EMIT_FIXED
                       ? o->fixed
                       : o->scale * (double)landing[i].way * tan(fmin(angle, EMIT_PI / 4));
  return s == YLM_OK ? settle(o, l, report) : s;
}
