/*
** alone.h - sums over lists of lights and proxies from one point, for the unit's element
** type. Here lanes are lights. The moment kernels, which take one light for many
** points, see many lights from one: u = (y - x)/r, all of radius 1; weights of kind k are off by
** r^k.
*/
#ifndef YLM_LIGHT_TREE_ALONE_H
#define YLM_LIGHT_TREE_ALONE_H

#include "../moments/sum_kernel.h"
#include "walk.h"

/* Lights to sum over: a whole number of tiles, and room for one more leaf. */
#define LIST (YLM__TILE * LANES > 64 ? YLM__TILE * LANES : 64)

/* A field of leaves and of proxies, for the element type; and how much smaller than its distance a
   light's radius may be, beside 1/TINY. */
#ifdef YLM_REAL_IS_FLOAT
#define LEAVES leaf_f
#define PROXIES proxies_f
#define SMALL 1e-4f
#else
#define LEAVES leaf_d
#define PROXIES proxies_d
#define SMALL 1e-8
#endif

typedef struct light_list {
  size_t n;
  real field[YLM__FIELDS][LIST + YLM_VECTOR_BYTES] __attribute__((aligned(64)));
} light_list;

/* State of one point. */
typedef struct lone_point {
  light_list near, dim;
  vreal seen[YLM__TILE][3];    /* -u of a tile's lights */
  vmask has_radius[YLM__TILE]; /* masks: a light has a radius */
  vreal inverse[YLM__TILE], luminance[YLM__TILE], rgb[3 * YLM__TILE]; /* of a tile; 1/r */
  vreal c[YLM__STRENGTHS][3];                                         /* sums of strength u^(2+k) */
  vreal tail[YLM__TAILS];                                             /* of u^4 beyond distances */
  vreal *sums, *dim_sums, *scaled; /* as those of points, lanes are lights */
} lone_point;

/* Adds e to the sums over lights beyond distances that the one at d, which stands for others within
   pilot_widest d, may be beyond. */
YLM_INLINE void add_tail(const ylm__tree_plan *p, vreal d, vreal e, vreal *tail) {
  real far = (real)(p->tree->size / (1 + (double)p->pilot_widest));
  for (int j = 0; j < YLM__TAILS; j++) tail[j] += keep_lanes(d > far * (real)p->skip[j], e);
}

/* -- sums over a list --------------------------------------------------------------------- */

/* Up to LANES lights seen from a point, the j-th vector of a tile; the pilot's sums too. */
YLM_INLINE void see_lights(const ylm__tree_plan *p, lone_point *k, const light_list *l, size_t i,
                           int j, const real *x, bool pilot) {
  const vreal *f[YLM__FIELDS];
  for (int c = 0; c < YLM__FIELDS; c++) f[c] = (const vreal *)(l->field[c] + i);
  vreal v[3], r = *f[YLM__R], d2 = {0};
  for (int a = 0; a < 3; a++) v[a] = *f[YLM__X + a] - x[a], d2 += v[a] * v[a];
  vreal d = vreal_sqrt(d2);
  /* A far light may be larger and dimmer: quotients stay representable, results the same. */
  vreal size = larger(larger(r, (real)SMALL * d), (vreal){0} + TINY), inverse = 1 / size;
  vreal part = r * inverse;
  part *= part;
  for (int a = 0; a < 3; a++) k->seen[j][a] = v[a] * -inverse;
  k->has_radius[j] = r > 0;
  k->inverse[j] = inverse;
  for (int c = 0; c < 3; c++) k->rgb[3 * j + c] = *f[YLM__E + c] * part;
  k->luminance[j] = *f[YLM__LUM] * part;
  if (!pilot) return;
  vreal u = keep_lanes(d > r, 1 / larger(d, (vreal){0} + TINY)), e2 = {0};
  for (int c = 0; c < 3; c++) e2 += k->rgb[3 * j + c] * k->rgb[3 * j + c];
  vreal strength[YLM__STRENGTHS] = {vreal_sqrt(e2), magnitude(k->luminance[j])};
  k->luminance[j] = strength[p->at[0]];
  for (int s = 0; s < YLM__STRENGTHS; s++) {
    vreal e = strength[s] * size * size * u * u;
    if (p->want[2] && s == p->at[2]) add_tail(p, d, e * u * u, k->tail);
    for (int n = 0; n < 3; n++) k->c[s][n] += e, e *= u;
  }
}

/* Geometry and weights of the lights of a tile, n vectors of them. All are seen before any is
   prepared, so that no quotient is waited for. */
static void prepare_lights(const ylm__tree_plan *p, lone_point *k, const work *w,
                           const light_list *l, size_t i, int n, int kinds, const real *x,
                           bool pilot, vmask *inside) {
  static const real_lamp unit = {{0, 0, 0}, 1, 1, {1, 1, 1}};
  int lmax = p->sums->q->lmax, G = ylm__geometry_slots(lmax), W = ylm__weight_slots(lmax);
  for (int j = 0; j < n; j++) see_lights(p, k, l, i + (size_t)(j * LANES), j, x, pilot);
  for (int j = 0; j < n; j++) {
    vmask in = {0};
    p->sums->kernel->prepare(lmax, kinds, 1, &unit, false, k->seen[j], w->geometry + j * G,
                             w->weights + j * W, &in);
    *inside |= in & k->has_radius[j];
  }
}

/* The weights of `kinds` times `emission`, and in the scene's unit of length. */
static void scale_lights(const lone_point *k, int lmax, int kinds, int n, const vreal *emission,
                         const vreal *w, vreal *out) {
  int W = ylm__weight_slots(lmax);
  int edges[4] = {0, ylm__weight_at(lmax, 1, 0), ylm__weight_at(lmax, 2, 0), W};
  for (int j = 0; j < n; j++) {
    vreal e = emission[j];
    for (int kind = 0; kind < 3; kind++) {
      for (int i = edges[kind]; kinds & (1 << kind) && i < edges[kind + 1]; i++)
        out[j * W + i] = e * w[j * W + i];
      e *= k->inverse[j];
    }
  }
}

/* Adds a list to the sums of a plan, luminance and then rgb, and empties it; how many they were. */
static size_t sum_list(const ylm__tree_plan *p, const ylm__plan *s, lone_point *k, const work *w,
                       light_list *l, const real *x, vreal *sums, vmask *inside) {
  const ylm__moment_kernel *kernel = s->kernel;
  int lmax = s->q->lmax, all = s->kinds_lum | s->kinds_rgb;
  size_t count = l->n;
  vreal one[YLM__TILE];
  for (int j = 0; j < YLM__TILE; j++) one[j] = (vreal){0} + 1;
  if (all == (YLM__M1 | YLM__M2)) all = 7;
  for (size_t i = l->n; i % LANES; i++)
    for (int f = 0; f < YLM__FIELDS; f++) l->field[f][i] = f <= YLM__R ? l->field[f][0] : 0;
  for (size_t i = 0; all && i < l->n; i += YLM__TILE * LANES) {
    size_t left = (l->n - i + LANES - 1) / LANES;
    int n = left < YLM__TILE ? (int)left : YLM__TILE;
    prepare_lights(p, k, w, l, i, n, all, x, s == p->pilot, inside);
    if (s->kinds_lum) {
      scale_lights(k, lmax, s->kinds_lum, n, k->luminance, w->weights, k->scaled);
      kernel->sum(lmax, s->kinds_lum, n, w->geometry, k->scaled, w->state, sums);
    }
    if (s->kinds_rgb) {
      scale_lights(k, lmax, s->kinds_rgb & ~YLM__M0, n, one, w->weights, w->weights);
      kernel->sum_rgb(lmax, s->kinds_rgb, n, w->geometry, w->weights, k->rgb, w->state,
                      sums + s->n_lum, s->n_rgb);
    }
  }
  l->n = 0;
  return count;
}

/* Sums over the lights of a vector, to lane `lane` of each. */
static void add_lanes(const vreal *sums, size_t n, int lane, vreal *to) {
  for (size_t i = 0; i < n; i++) {
    real part[LANES];
    memcpy(part, &sums[i], sizeof part);
    for (int half = LANES / 2; half > 0; half /= 2)
      for (int j = 0; j < half; j++) part[j] += part[j + half];
    ((real *)&to[i])[lane] += part[0];
  }
}

/* -- lists ----------------------------------------------------------------------------------- */

/* One light for a node, of its strengths. */
static real_lamp lamp_of_node(const ylm_light_tree *t, size_t node) {
  const ylm__group *g = &t->group[node / YLM__GROUP];
  int k = (int)(node % YLM__GROUP);
  real radius = (real)(t->size * (double)g->radius[k]);
  double per_area = radius > 0 ? t->total / ((double)radius * (double)radius) : 0;
  real_lamp l = {.radius = radius};
  for (int a = 0; a < 3; a++) {
    l.at[a] = (real)(t->centre[a] + t->size * (double)g->at[a][k]);
    l.rgb[a] = (real)(0.57735026918962576 * (double)g->strength[YLM__STRENGTH_RGB][k] * per_area);
  }
  l.luminance = (real)((double)g->strength[YLM__STRENGTH_LUM][k] * per_area);
  return l;
}

/* The block that a note of a kind is about: of lights or of proxies. */
YLM_INLINE const real *block_of(const ylm_light_tree *t, const int kind, uint32_t note) {
  return kind == OF_LEAF ? t->LEAVES[note & YLM__LEAF_MASK][0] : t->PROXIES[note][0];
}

/* Appends the first n lights of a block [FIELDS][width]. */
YLM_INLINE void append(light_list *l, const real *block, const size_t width, size_t n) {
  for (int f = 0; f < YLM__FIELDS; f++)
    memcpy(l->field[f] + l->n, block + (size_t)f * width, width * sizeof *block);
  l->n += n;
}

static void append_whole(light_list *l, real_lamp lamp) {
  size_t n = l->n++;
  for (int a = 0; a < 3; a++)
    l->field[YLM__X + a][n] = lamp.at[a], l->field[YLM__E + a][n] = lamp.rgb[a];
  l->field[YLM__R][n] = lamp.radius;
  l->field[YLM__LUM][n] = lamp.luminance;
}

/* Adds what a walk noted of a kind to a list, which is summed whenever it is full. */
YLM_INLINE size_t list_notes(const tree_walk *walk, lone_point *k, const work *w,
                             const ylm__plan *s, const int kind, bool dim, const real *x,
                             vmask *inside) {
  const ylm_light_tree *t = walk->plan->tree;
  const uint32_t *at = walk->notes.at[kind + (dim ? OF_DIM : 0)];
  const size_t n = walk->notes.n[kind + (dim ? OF_DIM : 0)];
  const size_t width = kind == OF_FEW ? YLM__PROXIES : YLM__MOST_PROXIES;
  light_list *l = dim ? &k->dim : &k->near;
  size_t pairs = 0;
  for (size_t i = 0; i < n; i++) {
    if (kind == OF_WHOLE) {
      append_whole(l, lamp_of_node(t, at[i]));
    } else {
      const char *ahead = (const char *)block_of(t, kind, at[i + AHEAD < n ? i + AHEAD : i]);
      for (size_t line = 0; line < YLM__FIELDS * sizeof(real) * width; line += 64)
        __builtin_prefetch(ahead + line);
      append(l, block_of(t, kind, at[i]), width,
             kind == OF_LEAF ? at[i] >> YLM__COUNT_AT & 15 : width);
    }
    if (l->n >= LIST)
      pairs += sum_list(walk->plan, s, k, w, l, x, dim ? k->dim_sums : k->sums, inside);
  }
  return pairs;
}

/* Sums over what a walk comes to, for one point; how many lights and proxies they were. */
static size_t walk_alone(tree_walk *walk, lone_point *k, const work *w, const seen_from *from,
                         const real *x, vmask *inside) {
  const ylm__tree_plan *p = walk->plan;
  const ylm__plan *sums = from->pilot ? p->pilot : p->sums;
  size_t pairs = 0;
  while (walk_on(walk, from, NULL) > 0)
    for (int dim = 0; dim < (from->pilot ? 1 : 2); dim++) {
      const ylm__plan *s = dim ? &p->dim : sums;
      pairs += list_notes(walk, k, w, s, OF_LEAF, dim, x, inside);
      pairs += list_notes(walk, k, w, s, OF_FEW, dim, x, inside);
      pairs += list_notes(walk, k, w, s, OF_MANY, dim, x, inside);
      if (from->pilot) pairs += list_notes(walk, k, w, s, OF_WHOLE, dim, x, inside);
    }
  pairs += sum_list(p, sums, k, w, &k->near, x, k->sums, inside);
  if (!from->pilot) pairs += sum_list(p, &p->dim, k, w, &k->dim, x, k->dim_sums, inside);
  return pairs;
}

#endif
