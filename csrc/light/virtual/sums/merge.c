/*
** merge.c - virtual lights of one cell of a lattice, whose normals point alike, as one light.
**
** Power and the middle of places are kept, and of matte lights the mean of directions: the error of a sum over many
** cells is of second order in a cell's edge over the distance on which what lights bring varies. Lights that are not matte
** are merged where normals and shifts are one, which is exact but for places. (csrc/emit/merge.c makes lights to be looked at
** from near by, out of particles: they are lifted above surfaces, and fitted.)
*/
#include "levels.h"
#include "ylm_keys.h"

enum {
  FACES = 3, /* parts of a cube's edge that normals are told apart by */
  FINE = 8192
};
#define LARGEST 0.99 /* of a core: radii of merged lights */

/* A light's class beside its place: its normal's. */
static void class_of(const ylm_light_virtual *v, size_t i, int32_t to[3]) {
  static const double turn[3][3] = {
      {0.8363, -0.3847, 0.3908}, {0.5174, 0.7658, -0.3820}, {-0.1811, 0.5154, 0.8376}};
  const double *n = v->normal + 3 * i;
  to[0] = -1, to[1] = to[2] = 0;
  if (n[0] == 0 && n[1] == 0 && n[2] == 0) return;
  if (v->degree > 0) {
    uint32_t shift = (uint32_t)lrint(v->shift[i] * FINE);
    for (int a = 0; a < 3; a++) to[a] = (int32_t)lrint((n[a] + 1) * FINE);
    to[0] ^= (int32_t)(shift << 15);
    return;
  }
  double u[3], most = 0;
  int axis = 0;
  for (int a = 0; a < 3; a++) {
    u[a] = turn[a][0] * n[0] + turn[a][1] * n[1] + turn[a][2] * n[2];
    if (fabs(u[a]) > most) most = fabs(u[a]), axis = a;
  }
  to[0] = 2 * axis + (u[axis] < 0);
  for (int k = 1; k < 3; k++)
    to[k] = (int32_t)fmin(FACES - 1, (u[(axis + k) % 3] / most + 1) * (0.5 * FACES));
}

typedef struct group {
  double weight, at[3], normal[3], second, radius2, scale;
} group;

/* How much a light counts where places are averaged. */
static double weight_of(const ylm_light_virtual *v, size_t i) {
  const size_t n = YLM_LIGHT_VIRTUAL_NUMBERS(v->degree);
  double sum = 1e-30;
  for (size_t c = 0; c < 3; c++) sum += fabs(v->emission[(3 * i + c) * n]);
  return sum * (1 + v->shift[i]) * (1 + v->shift[i]);
}

static ylm_status number_lights(const ylm_light_virtual *v, double cell, ylm_keys *keys,
                                uint32_t *of) {
  ylm_status s = YLM_OK;
  for (size_t i = 0; i < v->n && s == YLM_OK; i++) {
    int32_t k[6]; /* a cell, a class */
    for (int a = 0; a < 3; a++)
      k[a] = (int32_t)fmax(-0x1p30, fmin(0x1p30, floor(v->at[3 * i + a] / cell)));
    class_of(v, i, k + 3);
    s = ylm_keys_put(keys, k, sizeof k, of + i);
  }
  return s;
}

static void add_light(const ylm_light_virtual *v, size_t i, group *g) {
  const double w = weight_of(v, i), *at = v->at + 3 * i, toward = w * (1 - 0.5 * v->shift[i]);
  g->weight += w;
  for (int a = 0; a < 3; a++) {
    g->at[a] += w * at[a];
    g->normal[a] += toward * v->normal[3 * i + a];
  }
  g->radius2 += w * v->radius[i] * v->radius[i];
}

/* Means of sums, where a light's normal and shift are those of its members. */
static void settle(const group *g, double core, size_t i, ylm_light_virtual *m) {
  double length = 0;
  for (size_t a = 0; a < 3; a++) {
    m->at[3 * i + a] = g->at[a] / g->weight;
    length += g->normal[a] * g->normal[a];
  }
  length = sqrt(length);
  for (size_t a = 0; a < 3; a++) m->normal[3 * i + a] = length > 0 ? g->normal[a] / length : 0;
  m->shift[i] = length > 0 ? fmax(0, fmin(1, 2 * (1 - length / g->weight))) : 0;
  if (m->shift[i] < 1e-6) m->shift[i] = 0;
  m->radius[i] = fmin(LARGEST * core, sqrt((g->radius2 + 2 * g->second) / g->weight));
}

static ylm_status make(const ylm_light_virtual *v, const uint32_t *of, size_t n, double core,
                       ylm_light_virtual *m) {
  const size_t wide = 3 * YLM_LIGHT_VIRTUAL_NUMBERS(v->degree);
  group *g = ylm_alloc_zero(n, sizeof *g);
  double *x = ylm_alloc_zero(n, (8 + wide) * sizeof *x);
  *m = (ylm_light_virtual){.users = 1, .n = n, .degree = v->degree, .profile = v->profile};
  m->at = x;
  if (!g || !x) {
    ylm_free(g);
    return YLM_ENOMEM;
  }
  m->normal = x + 3 * n, m->radius = x + 6 * n, m->shift = x + 7 * n, m->emission = x + 8 * n;
  for (size_t i = 0; i < v->n; i++) add_light(v, i, &g[of[i]]);
  for (size_t i = 0; i < v->n; i++) {
    group *own = &g[of[i]];
    double w = weight_of(v, i);
    for (int a = 0; a < 3; a++) {
      double d = v->at[3 * i + a] - own->at[a] / own->weight;
      own->second += w * d * d;
    }
  }
  for (size_t i = 0; i < n; i++) settle(&g[i], core, i, m);
  for (size_t i = 0; i < v->n; i++) {
    const double own = 1 + v->shift[i], all = 1 + m->shift[of[i]];
    const double part = own * own / (all * all);
    for (size_t k = 0; k < wide; k++)
      m->emission[wide * of[i] + k] += part * v->emission[wide * i + k];
  }
  ylm_free(g);
  return ylm__virtual_settle(m);
}

ylm_status ylm__virtual_merge(const ylm_light_virtual *v, double cell, double core,
                              ylm_light_virtual *m) {
  ylm_keys keys = {0};
  uint32_t *of = ylm_alloc(v->n, sizeof *of);
  *m = (ylm_light_virtual){0};
  ylm_status s = of ? number_lights(v, cell, &keys, of) : YLM_ENOMEM;
  if (s == YLM_OK) s = make(v, of, keys.n, core, m);
  if (s != YLM_OK) ylm__virtual_merged_free(m);
  ylm_keys_free(&keys);
  ylm_free(of);
  return s;
}

void ylm__virtual_merged_free(ylm_light_virtual *m) {
  if (m->local != m->at) ylm_free(m->local);
  ylm_free(m->at);
  ylm_free(m->seen);
  *m = (ylm_light_virtual){0};
}
