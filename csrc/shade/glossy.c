/* glossy.c - radiance of points that gloss: table rows, turned to the world, times visibility, times
   light. */
#include <math.h>
#include <string.h>

#include "gloss.h"

/* Points of one material that are turned and multiplied together. */
#define BLOCK 256

/* Points of one material, and their slices in the world. */
typedef struct batch {
  const ylm_shade_view *v;
  const shade_tables *t;
  const ylm_material_table *table;
  size_t functions, width, count; /* of the table; count = (lmax+1)^2 */
  bool halves, shadows;
  size_t n, first;           /* points, of which number[] counts from `first` */
  size_t number[BLOCK];      /* increasing */
  float wo[BLOCK][3];        /* in the surface's frame */
  float frame[BLOCK][3][3];  /* of the view, columns x, y, normal */
  float *row, *slice;        /* [BLOCK][functions][width], and [count] */
  float *a, *b, *ab;         /* [BLOCK][count]: factors and products */
  size_t shadowed[BLOCK], m; /* of the points, those that something occludes */
} batch;

static void batch_free(batch *x) {
  if (!x) return;
  ylm_free(x->row);
  ylm_free(x->slice);
  ylm_free(x->a);
  ylm_free(x->b);
  ylm_free(x->ab);
  ylm_free(x);
}

static batch *batch_create(const ylm_shade_view *v, const shade_tables *t, bool shadows) {
  batch *x = ylm_alloc_zero(1, sizeof *x);
  size_t most = 3 * BLOCK;
  if (!x) return NULL;
  x->v = v;
  x->t = t;
  x->count = ylm_sh_count(t->lmax);
  x->shadows = shadows;
  x->row = ylm_alloc(most * x->count, sizeof(float));
  x->slice = ylm_alloc(most * x->count, sizeof(float));
  bool ok = x->row && x->slice;
  if (ok && shadows) {
    x->a = ylm_alloc(BLOCK * x->count, sizeof(float));
    x->b = ylm_alloc(BLOCK * x->count, sizeof(float));
    x->ab = ylm_alloc(BLOCK * x->count, sizeof(float));
    ok = x->a && x->b && x->ab;
  }
  if (ok) return x;
  batch_free(x);
  return NULL;
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

/* Both of point i of the view. */
static void look_from(const ylm_shade_view *v, size_t i, float wo[3], float frame[3][3]) {
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
static ylm_status occlude(batch *x) {
  const ylm_shade_view *v = x->v;
  size_t bytes = x->count * sizeof(float);
  x->m = 0;
  for (size_t i = 0; i < x->n; i++) {
    const float *V = v->transfer + (x->first + x->number[i]) * x->count;
    if (is_open(V, x->count)) continue;
    memcpy(x->b + x->m * x->count, V, bytes);
    x->shadowed[x->m++] = i;
  }
  ylm_status s = YLM_OK;
  for (size_t k = 0; s == YLM_OK && x->m && k < x->functions; k++) {
    for (size_t i = 0; i < x->m; i++)
      memcpy(x->a + i * x->count, x->slice + (x->shadowed[i] * x->functions + k) * x->count, bytes);
    s = ylm_sh_product_apply(x->t->product, YLM_FLOAT, x->m, (const void *[]){x->a, x->b}, NULL,
                             x->ab, 1, NULL, NULL);
    for (size_t i = 0; i < x->m; i++)
      memcpy(x->slice + (x->shadowed[i] * x->functions + k) * x->count, x->ab + i * x->count,
             bytes);
  }
  return s;
}

/* Slices of the batch's points in the world, with their visibility. */
static ylm_status make_slices(batch *x) {
  for (size_t i = 0; i < x->n; i++) look_from(x->v, x->first + x->number[i], x->wo[i], x->frame[i]);
  ylm_material_table_rows(x->table, x->n, (const float(*)[3])x->wo, x->row);
  ylm_status s = ylm_sh_rotate_each(x->t->rotator, x->t->lmax, YLM_FLOAT, x->n, x->frame,
                                    (int)x->functions, x->halves, x->row, x->slice, 1, NULL, NULL);
  return s == YLM_OK && x->shadows ? occlude(x) : s;
}

/* Radiance of the n points of a batch from `from` on, which follow each other. */
static void dot_run(const batch *x, ylm_shade_dot_fn *dot, size_t from, size_t n,
                    const shade_light *l, float *out) {
  const float(*mix)[3] = ylm_material_table_mix(x->table);
  size_t given = ylm_sh_count(l->lmax), count = x->count < given ? x->count : given;
  size_t l_point = (size_t)l->channels * given, p = x->number[from];
  float part[BLOCK][3];
  shade_light at = *l;
  at.L = (const char *)l->L + p * l_point * ylm_dtype_size(l->type);
  memset(out + 3 * p, 0, n * 12);
  for (size_t k = 0; k < x->functions; k++) {
    const float *T = x->slice + (from * x->functions + k) * x->count;
    ylm__shade_dots(dot, count, n, x->functions * x->count, T, &at, part[0]);
    for (size_t i = 0; i < n; i++)
      for (size_t c = 0; c < 3; c++) out[3 * (p + i) + c] += mix[c][k] * part[i][c];
  }
  ylm__shade_tint(x->v, x->first + p, n, out + 3 * p);
}

static ylm_status shade_batch(batch *x, ylm_shade_dot_fn *dot, const shade_light *l, float *out) {
  ylm_status s = make_slices(x);
  for (size_t from = 0, behind; s == YLM_OK && from < x->n; from = behind) {
    for (behind = from + 1; behind < x->n && x->number[behind] == x->number[behind - 1] + 1;)
      behind++;
    dot_run(x, dot, from, behind - from, l, out);
  }
  x->n = 0;
  return s;
}

/* The batch's next material: that of table k. */
static void turn_to(batch *x, uint32_t k) {
  ylm_material_table_facts f;
  x->table = x->t->table[k];
  ylm_material_table_look(x->table, &f);
  x->functions = (size_t)f.functions;
  x->width = f.width;
  x->halves = f.halves;
  x->n = 0;
}

/* The least material above `last` among n points' meshes (-1: none is asked for yet); or none. */
static uint32_t next_material(const ylm_shade_view *v, int64_t last, const uint32_t *mesh,
                              size_t n) {
  uint32_t least = YLM_SHADE_MATTE;
  for (size_t i = 0; i < n; i++) {
    if (i > 0 && mesh[i] == mesh[i - 1]) continue;
    uint32_t k = ylm__shade_gloss_slot(v->gloss, mesh[i]);
    if ((int64_t)k > last && k < least) least = k;
  }
  return least;
}

ylm_status ylm__shade_glossy(const ylm_shade_view *v, ylm_shade_dot_fn *dot,
                             const shade_tables *tables, bool shadows, size_t first, size_t n,
                             const shade_light *l, float *out) {
  const uint32_t *mesh = v->mesh + first;
  uint32_t k = next_material(v, -1, mesh, n);
  if (k == YLM_SHADE_MATTE) return YLM_OK;
  batch *x = batch_create(v, tables, shadows);
  ylm_status s = x ? YLM_OK : YLM_ENOMEM;
  for (; s == YLM_OK && k != YLM_SHADE_MATTE; k = next_material(v, k, mesh, n)) {
    turn_to(x, k);
    x->first = first;
    for (size_t i = 0; s == YLM_OK && i < n; i++) {
      if (ylm__shade_gloss_slot(v->gloss, mesh[i]) != k) continue;
      x->number[x->n++] = i;
      if (x->n == BLOCK) s = shade_batch(x, dot, l, out);
    }
    if (s == YLM_OK && x->n) s = shade_batch(x, dot, l, out);
  }
  batch_free(x);
  return s;
}
