/*
** build.c - cuts lights into groups of nodes, down to leaves of a few lights.
**
** A set is halved across the longest of the extents of its centres and radii, at the middle of that extent. Nodes stay
** compact so, and lights of unlike size part. Lights of positive and of negative luminance are parted first: near
** cancellation would make poor proxies.
*/
#include "proxy.h"
#include "tree.h"
#include "ylm_list.h"

#include <math.h>
#include <string.h>

/* Deeper than this, sets are halved by count: no arrangement of lights makes deeper trees than
   twice as deep. */
#define DEEP 40

typedef struct builder {
  ylm_light_tree *t;
  uint32_t *order;     /* [active] */
  ylm__branch *branch; /* [groups][YLM__GROUP]: what each node holds */
  size_t room;         /* groups */
} builder;

static double coordinate(const ylm__lamp_d *l, int axis) {
  return axis < 3 ? l->at[axis] : l->radius;
}

/* The longest extent of a set, and across which axis (3: the radii). */
static double longest(const builder *b, ylm__branch s, int *axis, double *middle) {
  double lo[4], hi[4], most = -1;
  for (int a = 0; a < 4; a++) lo[a] = INFINITY, hi[a] = -INFINITY;
  for (uint32_t i = s.begin; i < s.end; i++) {
    const ylm__lamp_d *l = &b->t->lights->lamp_d[b->order[i]];
    for (int a = 0; a < 4; a++) {
      double x = coordinate(l, a);
      lo[a] = fmin(lo[a], x), hi[a] = fmax(hi[a], x);
    }
  }
  for (int a = 0; a < 4; a++)
    if (hi[a] - lo[a] > most) most = hi[a] - lo[a], *axis = a, *middle = lo[a] + most / 2;
  return most;
}

/* Puts lights with a coordinate up to the middle first; how many there are. */
static uint32_t part(builder *b, ylm__branch s, int axis, double middle) {
  uint32_t i = s.begin;
  for (uint32_t k = s.begin; k < s.end; k++) {
    uint32_t light = b->order[k];
    if (coordinate(&b->t->lights->lamp_d[light], axis) > middle) continue;
    b->order[k] = b->order[i], b->order[i++] = light;
  }
  return i - s.begin;
}

static ylm__branch halve(builder *b, ylm__branch *s, bool deep) {
  int axis;
  double middle;
  uint32_t n = 0, all = s->end - s->begin;
  if (!deep && longest(b, *s, &axis, &middle) > 0) n = part(b, *s, axis, middle);
  if (n == 0 || n == all) n = all / 2;
  ylm__branch rest = {s->begin + n, s->end};
  s->end = rest.begin;
  return rest;
}

/* Cuts one of `n` sets, the one with the longest extent, until a group is full or none is large. */
static int divide(builder *b, ylm__branch s[YLM__GROUP], int n, bool deep) {
  while (n < YLM__GROUP) {
    int best = -1, axis;
    double most = -1, middle;
    for (int i = 0; i < n; i++) {
      if (s[i].end - s[i].begin <= YLM__LEAF) continue;
      double extent = deep ? (double)(s[i].end - s[i].begin) : longest(b, s[i], &axis, &middle);
      if (extent > most) most = extent, best = i;
    }
    if (best < 0) break;
    s[n] = halve(b, &s[best], deep);
    n++;
  }
  return n;
}

/* A new group, all of whose places are empty. */
static ylm_status new_group(builder *b, uint32_t *at) {
  ylm_light_tree *t = b->t;
  if (t->groups == b->room) {
    size_t n = t->groups, room = ylm_list_room(b->room, n + 1);
    if (!ylm_list_resize(&t->group, n, room, sizeof *t->group) ||
        !ylm_list_resize(&b->branch, n, room, YLM__GROUP * sizeof *b->branch))
      return YLM_ENOMEM;
    b->room = room;
  }
  *at = t->groups++;
  memset(&t->group[*at], 0, sizeof *t->group);
  memset(&b->branch[(size_t)*at * YLM__GROUP], 0, YLM__GROUP * sizeof *b->branch);
  for (int k = 0; k < YLM__GROUP; k++) t->group[*at].child[k] = YLM__NO_NODE;
  return YLM_OK;
}

/* Makes the group of n sets and all below it. */
static ylm_status build(builder *b, ylm__branch *s, int n, int depth, uint32_t *at) {
  ylm_light_tree *t = b->t;
  ylm_status status = new_group(b, at);
  if (status != YLM_OK) return status;
  if (depth > t->depth) t->depth = depth;
  n = divide(b, s, n, depth > DEEP);
  for (int k = 0; k < n && status == YLM_OK; k++) {
    uint32_t count = s[k].end - s[k].begin, child;
    b->branch[(size_t)*at * YLM__GROUP + (size_t)k] = s[k];
    t->group[*at].proxies[k] = 2 * t->blocks;
    t->blocks += count > YLM__MANY ? 2 : count > YLM__PROXIES ? 1 : 0;
    if (count <= YLM__LEAF) {
      t->group[*at].child[k] = YLM__IS_LEAF | count << YLM__COUNT_AT | t->leaves++;
      continue;
    }
    ylm__branch below[YLM__GROUP] = {s[k]};
    status = build(b, below, 1, depth + 1, &child);
    t->group[*at].child[k] = child;
  }
  return status;
}

/* The tree's units: a box around all lights, and all their strength. */
static void find_units(ylm_light_tree *t) {
  const ylm__lamp_d *l = t->lights->lamp_d;
  const size_t n = t->lights->active, step = sizeof *l / sizeof(double);
  t->total = 0;
  for (size_t i = 0; i < n; i++) {
    double e2 = 0;
    for (int a = 0; a < 3; a++) e2 += l[i].rgb[a] * l[i].rgb[a];
    t->total += sqrt(e2) * l[i].radius * l[i].radius;
  }
  t->size = ylm__tree_units(n, l->at, step, &l->radius, step, t->centre);
  if (!(t->total > 0) || !isfinite(t->total)) t->total = 1;
}

/* Copies the lights of a leaf to its block. */
static void fill_leaf(ylm_light_tree *t, uint32_t leaf, const uint32_t *order, uint32_t n) {
  memset(t->leaf_d[leaf], 0, sizeof t->leaf_d[leaf]);
  memset(t->leaf_f[leaf], 0, sizeof t->leaf_f[leaf]);
  for (uint32_t i = 0; i < n; i++) {
    const ylm__lamp_d *d = &t->lights->lamp_d[order[i]];
    const ylm__lamp_f *f = &t->lights->lamp_f[order[i]];
    for (int a = 0; a < 3; a++) {
      t->leaf_d[leaf][YLM__X + a][i] = d->at[a], t->leaf_d[leaf][YLM__E + a][i] = d->rgb[a];
      t->leaf_f[leaf][YLM__X + a][i] = f->at[a], t->leaf_f[leaf][YLM__E + a][i] = f->rgb[a];
    }
    t->leaf_d[leaf][YLM__R][i] = d->radius, t->leaf_d[leaf][YLM__LUM][i] = d->luminance;
    t->leaf_f[leaf][YLM__R][i] = f->radius, t->leaf_f[leaf][YLM__LUM][i] = f->luminance;
  }
}

/* Fills groups begin .. end-1. */
static ylm_status fill(void *context, size_t begin, size_t end, int worker) {
  const builder *b = context;
  (void)worker;
  for (size_t g = begin; g < end; g++)
    for (int k = 0; k < YLM__GROUP; k++) {
      ylm__branch s = b->branch[g * YLM__GROUP + (size_t)k];
      uint32_t child = b->t->group[g].child[k];
      if (child == YLM__NO_NODE) continue;
      ylm__tree_node(b->t, (uint32_t)g, k, b->order + s.begin, s.end - s.begin);
      if (child & YLM__IS_LEAF)
        fill_leaf(b->t, child & YLM__LEAF_MASK, b->order + s.begin, s.end - s.begin);
    }
  return YLM_OK;
}

static ylm_status allocate_blocks(ylm_light_tree *t) {
  t->leaf_f = ylm_alloc(t->leaves, sizeof *t->leaf_f);
  t->leaf_d = ylm_alloc(t->leaves, sizeof *t->leaf_d);
  t->proxies_f = ylm_alloc_zero(t->blocks, sizeof *t->proxies_f);
  t->proxies_d = ylm_alloc_zero(t->blocks, sizeof *t->proxies_d);
  return t->leaf_f && t->leaf_d && t->proxies_f && t->proxies_d ? YLM_OK : YLM_ENOMEM;
}

ylm_status ylm__tree_create(const ylm_lights *lights, int threads, ylm_light_tree **tree) {
  *tree = NULL;
  size_t n = lights->active;
  if (n < YLM__FEW || n > YLM__LEAF_MASK) return YLM_OK;
  ylm_light_tree *t = ylm_alloc_zero(1, sizeof *t);
  if (!t) return YLM_ENOMEM;
  t->lights = lights;
  find_units(t);
  builder b = {.t = t, .order = ylm_alloc(n, sizeof *b.order)};
  uint32_t root;
  ylm_status s = b.order ? new_group(&b, &root) : YLM_ENOMEM; /* group 0 stays empty */
  if (s == YLM_OK) {
    uint32_t positive = ylm__tree_part_signs(lights->lamp_d, (uint32_t)n, b.order);
    ylm__branch sets[YLM__GROUP] = {{0, positive}, {positive, (uint32_t)n}};
    bool both = positive > 0 && positive < n;
    if (!both) sets[0].end = (uint32_t)n;
    s = build(&b, sets, both ? 2 : 1, 1, &root);
  }
  if (s == YLM_OK) s = allocate_blocks(t);
  if (s == YLM_OK) s = ylm_parallel(t->groups, TREE_GRAIN, threads, fill, &b, NULL, NULL);
  ylm_free(b.order);
  ylm_free(b.branch);
  if (s != YLM_OK) {
    ylm__tree_free(t);
    return s;
  }
  *tree = t;
  return YLM_OK;
}

void ylm__tree_free(ylm_light_tree *t) {
  if (!t) return;
  ylm_free(t->group);
  ylm_free(t->leaf_f);
  ylm_free(t->leaf_d);
  ylm_free(t->proxies_f);
  ylm_free(t->proxies_d);
  ylm_free(t);
}

size_t ylm__lights_tree_bytes(const ylm_lights *lights) {
  const ylm_light_tree *t = lights->tree;
  if (!t) return 0;
  return sizeof *t + t->groups * sizeof *t->group +
         t->leaves * (sizeof *t->leaf_f + sizeof *t->leaf_d) +
         t->blocks * (sizeof *t->proxies_f + sizeof *t->proxies_d);
}
