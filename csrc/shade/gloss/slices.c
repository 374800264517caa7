/* slices.c - slices of points that gloss: table rows, turned to the world, times visibility. */
#include "slices.h"

#include <math.h>
#include <string.h>

shade_slices *ylm__shade_slices(const ylm_shade_view *v, const shade_tables *t) {
  shade_slices *x = ylm_alloc_zero(1, sizeof *x);
  size_t count = ylm_sh_count(t->lmax), most = 3 * YLM_SHADE_SLICES;
  if (!x) return NULL;
  *x = (shade_slices){.v = v, .t = t, .count = count};
  x->row = ylm_alloc(most * count, sizeof(float));
  x->slice = ylm_alloc(most * count, sizeof(float));
  if (x->row && x->slice) return x;
  ylm__shade_slices_free(x);
  return NULL;
}

void ylm__shade_slices_free(shade_slices *x) {
  if (!x) return;
  ylm_free(x->row);
  ylm_free(x->slice);
  ylm_free(x);
}

void ylm__shade_slices_of(shade_slices *x, uint32_t k) {
  ylm_material_table_facts f;
  x->table = x->t->table[k];
  ylm_material_table_look(x->table, &f);
  x->functions = (size_t)f.functions;
  x->halves = f.halves;
}

/* Makes x at right angles to n and a unit vector. */
static void square(const double n[3], double x[3]) {
  double z = ylm_dot3d(x, n);
  for (int a = 0; a < 3; a++) x[a] -= z * n[a];
  double scale = 1 / sqrt(ylm_dot3d(x, x));
  for (int a = 0; a < 3; a++) x[a] *= scale;
}

void ylm__shade_look(const ylm_shade_view *v, size_t i, float wo[3], float frame[3][3]) {
  const float(*tangent)[3] = ylm__shade_gloss_tangents(v->gloss);
  ylm__shade_look_along(v, i, tangent ? tangent[i] : NULL, wo, frame);
}

void ylm__shade_look_along(const ylm_shade_view *v, size_t i, const float *tangent, float wo[3],
                           float frame[3][3]) {
  double w[3], n[3], x[3], y[3], u[3];
  for (int a = 0; a < 3; a++) {
    w[a] = v->frame.from[a] - (double)v->position[i][a];
    n[a] = (double)v->normal[i][a];
  }
  double by_n = 1 / sqrt(ylm_dot3d(n, n)), ww = ylm_dot3d(w, w), by_w = 1 / sqrt(ww);
  for (int a = 0; a < 3; a++) {
    n[a] *= by_n;
    w[a] = ww > 0 ? w[a] * by_w : n[a];
  }
  double z = ylm_dot3d(w, n);
  for (int a = 0; a < 3; a++) x[a] = w[a] - z * n[a];
  double across = sqrt(ylm_dot3d(x, x));
  if (tangent)
    for (int a = 0; a < 3; a++) u[a] = (double)tangent[a];
  if (across < 1e-4) { /* any x will do: that of the surface */
    float t[3], other[3];
    ylm_scene_basis(v->normal[i], t, other);
    for (int a = 0; a < 3; a++) x[a] = tangent ? u[a] : (double)t[a];
  }
  square(n, x);
  ylm_cross3d(n, x, y);
  for (int a = 0; a < 3; a++) {
    frame[a][0] = (float)x[a];
    frame[a][1] = (float)y[a];
    frame[a][2] = (float)n[a];
  }
  wo[0] = (float)across, wo[1] = 0, wo[2] = (float)z;
  if (!tangent) return;
  double c = ylm_dot3d(u, x), s = -ylm_dot3d(u, y), r = sqrt(c * c + s * s);
  wo[0] = (float)(across * c / r);
  wo[1] = (float)(across * s / r);
}

/* Whether a row of visibility is that of a point that nothing occludes. */
static bool is_open(const float *V, size_t count) {
  if (V[0] != YLM_SHADE_OPEN) return false;
  for (size_t k = 1; k < count; k++)
    if (V[k] != 0) return false;
  return true;
}

/* Multiplies the degrees of n points' rows by the view's window; degrees are turned within themselves. */
static void soften(shade_slices *x, size_t n) {
  const float *window = x->v->o.window;
  float *at = x->row;
  for (size_t i = 0; window[0] > 0 && i < n * x->functions; i++)
    for (int l = 0; l <= x->t->lmax; l++)
      for (int m = x->halves ? 0 : -l; m <= l; m++) *at++ *= window[l];
}

/* Makes rows of n points in the axes of their views, which are frame; factors of the points: NULL where open. */
static void make_rows(shade_slices *x, size_t n, const size_t *point, const float *const *V,
                      float (*frame)[3][3], const void **factor) {
  float wo[YLM_SHADE_SLICES][3];
  double start = ylm_seconds();
  for (size_t i = 0; i < n; i++) ylm__shade_look(x->v, point[i], wo[i], frame[i]);
  if (x->t->nearest) {
    ylm_material_table_facts f;
    ylm_material_table_look(x->table, &f);
    x->t->nearest(&f, n, (const float(*)[3])wo, wo);
  }
  ylm_material_table_rows(x->table, n, (const float(*)[3])wo, x->row);
  soften(x, n);
  for (size_t i = 0; i < n; i++) factor[i] = V && !is_open(V[i], x->count) ? V[i] : NULL;
  ylm__shade_clock(x->v, SHADE_ROWS, start);
}

/* Counts seconds of rotation and product. */
static void clock_stages(const shade_slices *x, const double stage[2]) {
  ylm__shade_clock(x->v, SHADE_ROTATION, ylm_seconds() - stage[0]);
  ylm__shade_clock(x->v, SHADE_PRODUCT, ylm_seconds() - stage[1]);
}

ylm_status ylm__shade_slices_make(shade_slices *x, size_t n, const size_t *point,
                                  const float *const *V) {
  float frame[YLM_SHADE_SLICES][3][3];
  const void *factor[YLM_SHADE_SLICES];
  double stage[2] = {0, 0};
  make_rows(x, n, point, V, frame, factor);
  ylm_status s =
      ylm_sh_rotate_times(x->t->rotator, x->t->product, YLM_FLOAT, n, frame, (int)x->functions,
                          x->halves, x->row, factor, x->slice, stage, NULL);
  clock_stages(x, stage);
  return s;
}

bool ylm__shade_slices_shares(const shade_slices *x, const shade_light *l, size_t n,
                              const size_t *number) {
  size_t bytes = (size_t)l->channels * ylm_sh_count(l->lmax) * sizeof(float);
  const char *L = l->L, *first = L + number[0] * bytes;
  if (l->type != YLM_FLOAT || l->channels != 3 || l->lmax != x->t->lmax ||
      !ylm_sh_rotate_in_one(x->t->rotator, x->t->product))
    return false;
  for (size_t i = 1; i < n; i++)
    if (memcmp(first, L + number[i] * bytes, bytes) != 0) return false;
  return true;
}

ylm_status ylm__shade_slices_shine(shade_slices *x, size_t n, const size_t *point,
                                   const float *const *V, const float *L, float (*out)[3]) {
  float frame[YLM_SHADE_SLICES][3][3];
  const void *factor[YLM_SHADE_SLICES], *light[3] = {L, L + x->count, L + 2 * x->count};
  double stage[2] = {0, 0};
  make_rows(x, n, point, V, frame, factor);
  ylm_status s = ylm_sh_rotate_integrate(x->t->rotator, x->t->product, YLM_FLOAT, n, frame,
                                         (int)x->functions, x->halves, x->row, factor, light,
                                         ylm_material_table_mix(x->table), out, stage, NULL);
  clock_stages(x, stage);
  return s;
}

void ylm__shade_slices_light(const shade_slices *x, ylm_shade_dot_fn *dot, size_t from, size_t n,
                             const shade_light *l, float *out) {
  const float(*mix)[3] = ylm_material_table_mix(x->table);
  size_t given = ylm_sh_count(l->lmax), count = x->count < given ? x->count : given;
  float part[YLM_SHADE_SLICES][3];
  double start = ylm_seconds();
  if (l->type == YLM_FLOAT)
    ylm__shade_kernels().mix(count, n, (int)x->functions, l->channels, x->count,
                             x->slice + from * x->functions * x->count, given, l->L, mix, out);
  else
    memset(out, 0, n * 12);
  for (size_t k = 0; l->type == YLM_DOUBLE && k < x->functions; k++) {
    const float *T = x->slice + (from * x->functions + k) * x->count;
    ylm__shade_dots(dot, count, n, x->functions * x->count, T, l, part[0]);
    for (size_t i = 0; i < n; i++)
      for (size_t c = 0; c < 3; c++) out[3 * i + c] += mix[c][k] * part[i][c];
  }
  ylm__shade_clock(x->v, SHADE_DOT, start);
}
