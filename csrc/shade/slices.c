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
  x->factor = ylm_alloc(3 * YLM_SHADE_SLICES * count, sizeof(float));
  if (x->row && x->slice && x->factor) return x;
  ylm__shade_slices_free(x);
  return NULL;
}

void ylm__shade_slices_free(shade_slices *x) {
  if (!x) return;
  ylm_free(x->row);
  ylm_free(x->slice);
  ylm_free(x->factor);
  ylm_free(x);
}

void ylm__shade_slices_of(shade_slices *x, uint32_t k) {
  ylm_material_table_facts f;
  x->table = x->t->table[k];
  ylm_material_table_look(x->table, &f);
  x->functions = (size_t)f.functions;
  x->halves = f.halves;
}

static double dot3(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The direction w to the camera in the surface's frame, whose x is u, and the frame of the view, in
   which x lies in the plane of normal and view. */
static void look(const double w[3], const double n[3], const double u[3], bool isotropic,
                 float wo[3], float frame[3][3]) {
  double z = dot3(w, n), x[3], y[3];
  for (int a = 0; a < 3; a++) x[a] = w[a] - z * n[a];
  double across = sqrt(dot3(x, x));
  if (across < 1e-4) /* any x will do: that of the surface */
    for (int a = 0; a < 3; a++) x[a] = u[a] - dot3(u, n) * n[a];
  double l = sqrt(dot3(x, x));
  for (int a = 0; a < 3; a++) x[a] /= l;
  for (int a = 0; a < 3; a++) {
    int b = (a + 1) % 3, c = (a + 2) % 3;
    y[a] = n[b] * x[c] - n[c] * x[b];
    frame[a][0] = (float)x[a];
    frame[a][1] = (float)y[a];
    frame[a][2] = (float)n[a];
  }
  double r = hypot(dot3(u, x), dot3(u, y));
  wo[0] = (float)(isotropic ? across : across * dot3(u, x) / r);
  wo[1] = (float)(isotropic ? 0 : across * -dot3(u, y) / r);
  wo[2] = (float)z;
}

void ylm__shade_look(const ylm_shade_view *v, size_t i, float wo[3], float frame[3][3]) {
  const float(*tangent)[3] = ylm__shade_gloss_tangents(v->gloss);
  float u[3], other[3];
  double w[3], n[3], x[3], nn = 0, ww = 0;
  ylm_scene_basis(v->normal[i], u, other);
  if (tangent) memcpy(u, tangent[i], 12);
  for (int a = 0; a < 3; a++) {
    w[a] = v->frame.from[a] - (double)v->position[i][a];
    n[a] = (double)v->normal[i][a];
    x[a] = (double)u[a];
    ww += w[a] * w[a];
    nn += n[a] * n[a];
  }
  for (int a = 0; a < 3; a++) {
    n[a] /= sqrt(nn);
    w[a] = ww > 0 ? w[a] / sqrt(ww) : n[a];
  }
  look(w, n, x, !tangent, wo, frame);
}

/* Whether a row of visibility is that of a point that nothing occludes. */
static bool is_open(const float *V, size_t count) {
  if (V[0] != YLM_SHADE_OPEN) return false;
  for (size_t k = 1; k < count; k++)
    if (V[k] != 0) return false;
  return true;
}

/* Multiplies the slices of points that something occludes by their visibility. */
static ylm_status occlude(shade_slices *x, size_t n, const float *const *V) {
  size_t bytes = x->count * sizeof(float), m = 0, shadowed[YLM_SHADE_SLICES];
  float *a = x->factor, *b = a + YLM_SHADE_SLICES * x->count, *ab = b + YLM_SHADE_SLICES * x->count;
  for (size_t i = 0; i < n; i++) {
    if (is_open(V[i], x->count)) continue;
    memcpy(b + m * x->count, V[i], bytes);
    shadowed[m++] = i;
  }
  ylm_status s = YLM_OK;
  for (size_t k = 0; s == YLM_OK && m && k < x->functions; k++) {
    for (size_t i = 0; i < m; i++)
      memcpy(a + i * x->count, x->slice + (shadowed[i] * x->functions + k) * x->count, bytes);
    s = ylm_sh_product_apply(x->t->product, YLM_FLOAT, m, (const void *[]){a, b}, NULL, ab, 1, NULL,
                             NULL);
    for (size_t i = 0; i < m; i++)
      memcpy(x->slice + (shadowed[i] * x->functions + k) * x->count, ab + i * x->count, bytes);
  }
  return s;
}

ylm_status ylm__shade_slices_make(shade_slices *x, size_t n, const size_t *point,
                                  const float *const *V) {
  float wo[YLM_SHADE_SLICES][3], frame[YLM_SHADE_SLICES][3][3];
  double start = ylm_seconds();
  for (size_t i = 0; i < n; i++) ylm__shade_look(x->v, point[i], wo[i], frame[i]);
  if (x->t->nearest) {
    ylm_material_table_facts f;
    ylm_material_table_look(x->table, &f);
    x->t->nearest(&f, n, (const float(*)[3])wo, wo);
  }
  ylm_material_table_rows(x->table, n, (const float(*)[3])wo, x->row);
  start = ylm__shade_clock(x->v, SHADE_ROWS, start);
  ylm_status s = ylm_sh_rotate_each(x->t->rotator, x->t->lmax, YLM_FLOAT, n, frame,
                                    (int)x->functions, x->halves, x->row, x->slice, 1, NULL, NULL);
  start = ylm__shade_clock(x->v, SHADE_ROTATION, start);
  if (s != YLM_OK || !V) return s;
  s = occlude(x, n, V);
  ylm__shade_clock(x->v, SHADE_PRODUCT, start);
  return s;
}

void ylm__shade_slices_light(const shade_slices *x, ylm_shade_dot_fn *dot, size_t from, size_t n,
                             const shade_light *l, float *out) {
  const float(*mix)[3] = ylm_material_table_mix(x->table);
  size_t given = ylm_sh_count(l->lmax), count = x->count < given ? x->count : given;
  float part[YLM_SHADE_SLICES][3];
  double start = ylm_seconds();
  memset(out, 0, n * 12);
  for (size_t k = 0; k < x->functions; k++) {
    const float *T = x->slice + (from * x->functions + k) * x->count;
    ylm__shade_dots(dot, count, n, x->functions * x->count, T, l, part[0]);
    for (size_t i = 0; i < n; i++)
      for (size_t c = 0; c < 3; c++) out[3 * i + c] += mix[c][k] * part[i][c];
  }
  ylm__shade_clock(x->v, SHADE_DOT, start);
}
