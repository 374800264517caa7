/*
** tree_build.c - cuts virtual lights into nodes, and has these filled from below.
**
** A set is halved across the longest of its extents, at the middle of it: that of its places, of
** its radii, or of its normals. An extent of normals counts times that of the places. Nodes are
** compact, and their lights look alike. Lights of positive and of negative luminance are parted
** first. (csrc/light/tree/build.c halves by places and radii alone, in double, into groups of nodes.)
*/
#include <float.h>
#include <string.h>

#include "tree.h"
#include "ylm_image.h"
#include "ylm_list.h"

/* Deeper than this, sets are halved by count. */
#define DEEP 40
enum { AXES = 7 }; /* place, radius, normal */

typedef struct builder {
  ylm__virtual_tree *t;
  float (*key)[AXES]; /* [lights] */
  size_t room;        /* nodes */
  uint8_t *depth;     /* [room] */
} builder;

/* -- cuts ----------------------------------------------------------------------------------- */

/* Whether hardly any of the lights have the middle third of an axis, as where two walls meet. */
static bool has_gap(const builder *b, uint32_t begin, uint32_t end, int axis, float lo, float hi) {
  const float third = (hi - lo) / 3;
  uint32_t n = 0;
  for (uint32_t i = begin; i < end; i++) {
    const float x = b->key[b->t->order[i]][axis];
    n += x > lo + third && x < hi - third;
  }
  return (double)n <= VIRTUAL_GAP * (double)(end - begin);
}

/* The axis of the longest extent of lights begin .. end-1, and its middle; -1: all are alike. */
static int longest(const builder *b, uint32_t begin, uint32_t end, float *middle) {
  float lo[AXES], hi[AXES], most = 0, size = 0;
  int axis = -1;
  for (int a = 0; a < AXES; a++) lo[a] = INFINITY, hi[a] = -INFINITY;
  for (uint32_t i = begin; i < end; i++) {
    const float *x = b->key[b->t->order[i]];
    for (int a = 0; a < AXES; a++) lo[a] = fminf(lo[a], x[a]), hi[a] = fmaxf(hi[a], x[a]);
  }
  for (int a = 0; a < 3; a++) size = fmaxf(size, hi[a] - lo[a]);
  for (int a = 0; a < AXES; a++) {
    float extent = hi[a] - lo[a];
    if (a > 3 && extent > VIRTUAL_APART && has_gap(b, begin, end, a, lo[a], hi[a]))
      extent *= 1 / (float)VIRTUAL_APART;
    if (a > 3) extent *= (float)VIRTUAL_NORMALS * fmaxf(size, FLT_MIN);
    if (extent > most) most = extent, axis = a, *middle = lo[a] + (hi[a] - lo[a]) / 2;
  }
  return axis;
}

/* Halves a set; where its second half begins. */
static uint32_t halve(builder *b, uint32_t begin, uint32_t end, bool deep) {
  float middle = 0;
  uint32_t i = begin, *order = b->t->order;
  int axis = deep ? -1 : longest(b, begin, end, &middle);
  for (uint32_t k = begin; axis >= 0 && k < end; k++) {
    uint32_t light = order[k];
    if (b->key[light][axis] > middle) continue;
    order[k] = order[i], order[i++] = light;
  }
  return i == begin || i == end ? begin + (end - begin) / 2 : i;
}

static ylm_status grow(builder *b) {
  ylm__virtual_tree *t = b->t;
  size_t n = t->nodes, room = ylm_list_room(b->room, n + 2);
  if (room == b->room) return YLM_OK;
  if (!ylm_list_resize(&t->node, n, room, sizeof *t->node) ||
      !ylm_list_resize(&b->depth, n, room, sizeof *b->depth))
    return YLM_ENOMEM;
  b->room = room;
  return YLM_OK;
}

/* A new node of lights begin .. end-1; there is room. */
static uint32_t add_node(builder *b, uint32_t begin, uint32_t end, int depth) {
  uint32_t at = b->t->nodes++;
  b->t->node[at] = (ylm__virtual_node){.begin = begin, .lights = end - begin};
  b->depth[at] = (uint8_t)depth;
  if (depth > b->t->depth) b->t->depth = depth;
  return at;
}

/* Cuts a node until leaves are small; `first` lights are cut off first, unless that is 0. */
static ylm_status cut(builder *b, uint32_t at, uint32_t first) {
  ylm__virtual_tree *t = b->t;
  uint32_t begin = t->node[at].begin, end = begin + t->node[at].lights;
  int depth = b->depth[at];
  if (end - begin <= VIRTUAL_LEAF && !first) return YLM_OK;
  ylm_status s = grow(b);
  if (s != YLM_OK) return s;
  uint32_t middle = first ? begin + first : halve(b, begin, end, depth > DEEP);
  uint32_t child = add_node(b, begin, middle, depth + 1);
  add_node(b, middle, end, depth + 1);
  t->node[at].child = child;
  s = cut(b, child, 0);
  return s == YLM_OK ? cut(b, child + 1, 0) : s;
}

/* -- lights as spheres ---------------------------------------------------------------------- */

/* A light as a sphere whose e r^2 is the intensity, with the sign of its mean: root mean square over directions
   without the cosine, times 1 + shift. */
static void as_sphere(const ylm__virtual_tree *t, size_t i, ylm__lamp_d *l) {
  const ylm_light_virtual *v = t->lights;
  size_t wide = YLM_LIGHT_VIRTUAL_NUMBERS(v->degree);
  l->radius = v->radius[i] > 0 ? v->radius[i] : 1e-9 * t->size;
  for (size_t a = 0; a < 3; a++) l->at[a] = v->local[3 * i + a];
  for (size_t c = 0; c < 3; c++) {
    const double *b = v->emission + (3 * i + c) * wide;
    double s = 0;
    for (size_t q = 0; q < wide; q++) s += b[q] * b[q];
    s = (1 + v->shift[i]) * sqrt(s / (4 * YLM_PI)) / (l->radius * l->radius);
    l->rgb[c] = b[0] < 0 ? -s : s;
  }
  l->luminance = ylm__emission(l->rgb, 1, 0);
}

static double strength_of(const ylm__lamp_d *l) {
  return sqrt(l->rgb[0] * l->rgb[0] + l->rgb[1] * l->rgb[1] + l->rgb[2] * l->rgb[2]) * l->radius *
         l->radius;
}

static ylm__lamp_d *make_lamps(ylm__virtual_tree *t) {
  size_t n = t->lights->n;
  ylm__lamp_d *lamp = ylm_alloc(n, sizeof *lamp);
  t->total = 0;
  for (size_t i = 0; lamp && i < n; i++) {
    as_sphere(t, i, &lamp[i]);
    t->total += strength_of(&lamp[i]);
  }
  if (!(t->total > 0) || !isfinite(t->total)) t->total = 1;
  return lamp;
}

/* -- nodes ---------------------------------------------------------------------------------- */

typedef struct filler {
  const ylm__virtual_fit *fit;
  const uint32_t *node; /* [..] of a chunk */
  ylm__virtual_proxies *out;
} filler;

static ylm_status fill(void *context, size_t begin, size_t end, int worker) {
  const filler *f = context;
  (void)worker;
  for (size_t i = begin; i < end; i++)
    ylm__virtual_fit_node(f->fit, &f->fit->tree->node[f->node[i]], f->out[i]);
  return YLM_OK;
}

/* Appends the proxies of nodes to the tree's. */
static ylm_status write(ylm__virtual_tree *t, const uint32_t *node, size_t n,
                        const ylm__virtual_proxies *from, size_t *room) {
  for (size_t i = 0; i < n; i++) {
    ylm__virtual_node *x = &t->node[node[i]];
    size_t each = YLM__VIRTUAL_PLACE + 3 * (x->degree ? YLM__VIRTUAL_RICH : YLM__VIRTUAL_MATTE);
    size_t numbers = x->many * each;
    if (t->numbers + numbers > UINT32_MAX) return YLM_ENOMEM;
    if (!ylm_list_reserve(&t->proxies, t->numbers, t->numbers + numbers, room, sizeof *t->proxies))
      return YLM_ENOMEM;
    x->proxies = (uint32_t)t->numbers;
    ylm_copy(t->proxies + t->numbers, from[i], numbers * sizeof *t->proxies);
    t->numbers += numbers;
  }
  return YLM_OK;
}

/* Fills all nodes, the deepest first. */
static ylm_status fill_all(builder *b, const ylm__virtual_fit *fit, int threads) {
  ylm__virtual_tree *t = b->t;
  size_t room = 0;
  uint32_t *node = ylm_alloc(t->nodes, sizeof *node);
  ylm__virtual_proxies *out = ylm_alloc(VIRTUAL_CHUNK, sizeof *out);
  ylm_status s = node && out ? YLM_OK : YLM_ENOMEM;
  for (int depth = t->depth; depth > 0 && s == YLM_OK; depth--) {
    size_t n = 0;
    for (uint32_t i = 0; i < t->nodes; i++)
      if (b->depth[i] == depth) node[n++] = i;
    for (size_t i = 0; i < n && s == YLM_OK; i += VIRTUAL_CHUNK) {
      size_t m = n - i < VIRTUAL_CHUNK ? n - i : VIRTUAL_CHUNK;
      filler f = {fit, node + i, out};
      s = ylm_parallel(m, 8, threads, fill, &f, NULL, NULL);
      if (s == YLM_OK) s = write(t, node + i, m, out, &room);
    }
  }
  ylm_free(node);
  ylm_free(out);
  return s;
}

/* Proxies as lights: at their distance cores are constant, and far lights are Gaussian. */
static void be_lights(ylm__virtual_tree *t) {
  const ylm_light_virtual *v = t->lights;
  t->matte.profile = v->profile == YLM_LIGHT_VIRTUAL_FAR ? YLM_LIGHT_VIRTUAL_GAUSS : v->profile;
  t->rich = t->matte;
  t->rich.degree = 2;
  t->matte.stride = YLM__VIRTUAL_EMISSION + 3;
  t->rich.stride = YLM__VIRTUAL_WIDE;
}

static ylm_status make(builder *b, ylm__virtual_fit *fit, int threads) {
  ylm__virtual_tree *t = b->t;
  const size_t n = t->lights->n;
  t->size = ylm__tree_units(n, t->lights->local, 3, t->lights->radius, 1, t->centre);
  ylm__lamp_d *lamp = make_lamps(t);
  t->order = ylm_alloc(n, sizeof *t->order);
  b->key = ylm_alloc(n, sizeof *b->key);
  ylm_status s = lamp && t->order && b->key ? grow(b) : YLM_ENOMEM;
  if (s == YLM_OK) {
    for (size_t i = 0; i < n; i++) {
      for (size_t a = 0; a < 3; a++) {
        b->key[i][a] = (float)((t->lights->local[3 * i + a] - t->centre[a]) / t->size);
        b->key[i][4 + a] = (float)t->lights->normal[3 * i + a];
      }
      b->key[i][3] = (float)(t->lights->radius[i] / t->size);
    }
    uint32_t positive = ylm__tree_part_signs(lamp, (uint32_t)n, t->order);
    s = cut(b, add_node(b, 0, (uint32_t)n, 1), positive < n ? positive : 0);
  }
  ylm_free(b->key);
  fit->tree = t, fit->lamp = lamp;
  if (s == YLM_OK) s = ylm__virtual_fit_create(fit, t->lights->degree);
  if (s == YLM_OK) s = fill_all(b, fit, threads);
  ylm__virtual_fit_free(fit);
  ylm_free(lamp);
  return s;
}

ylm_status ylm__virtual_tree_create(const ylm_light_virtual *v, int threads,
                                    ylm__virtual_tree **tree) {
  *tree = NULL;
  if (v->n < VIRTUAL_FEW || v->profile == YLM_LIGHT_VIRTUAL_NEAR) return YLM_OK;
  ylm__virtual_tree *t = ylm_alloc_zero(1, sizeof *t);
  if (!t) return YLM_ENOMEM;
  t->lights = v;
  be_lights(t);
  builder b = {.t = t};
  ylm__virtual_fit fit = {.tree = t};
  ylm_status s = make(&b, &fit, threads);
  ylm_free(b.depth);
  if (s == YLM_OK)
    *tree = t;
  else
    ylm__virtual_tree_free(t);
  return s;
}

void ylm__virtual_tree_free(ylm__virtual_tree *t) {
  if (!t) return;
  ylm_free(t->node);
  ylm_free(t->order);
  ylm_free(t->proxies);
  ylm_free(t);
}

size_t ylm__virtual_tree_bytes(const ylm__virtual_tree *t) {
  if (!t) return 0;
  return sizeof *t + t->nodes * sizeof *t->node + t->lights->n * sizeof *t->order +
         t->numbers * sizeof *t->proxies;
}
