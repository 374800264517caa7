/*
** many_gloss.c - receivers of virtual lights that gloss: slices of their materials for the eye, or zonal lobes.
**
** Harmonics are asked in the frame of the view, in which slices stand: directions are turned, not slices. A light's
** harmonics are weighed by the row at once, which is the product of its coefficients with the row, summed in another
** order.
*/
#include "many_gloss.h"

#include <math.h>
#include <string.h>

#include "../gloss/slices.h"
#include "ylm_sh.h"

/* How far below the horizon of a normal of vertices the eye may be. */
#define LEAST_COSINE 1e-4f
/* Directions among which the least f of a material is taken as its matte base: angles of eye and light from the
   normal, and azimuths between them. */
#define EYES 6
#define ANGLES 8
#define AZIMUTHS 8

typedef struct material {
  const ylm_material *m;
  const ylm_material_table *table; /* of harmonics and zonal lobes */
  ylm_material_table_facts facts;
  float base[3];
} material;

struct many_gloss {
  const ylm_shade_gather_options *o;
  int lmax; /* of tables: of lobes of VSGL power and mean direction alone */
  bool zonal;
  size_t n;
  uint32_t *slot; /* [meshes]; YLM_SHADE_MATTE */
  material *material;
  uint32_t *vertex;   /* of a view per vertex with anisotropic materials */
  bool turned;        /* there are such */
  double *hemisphere; /* [lmax+1] coefficients of m = 0 of all directions above the surface */
  ylm_many_series series;
};

/* -- recurrences -------------------------------------------------------------------- */

ylm_status ylm__many_series(int lmax, ylm_many_series *s) {
  size_t entries = (size_t)(lmax + 1) * (size_t)(lmax + 2) / 2, k = 0;
  double *p = ylm_alloc(entries, sizeof *p);
  *s = (ylm_many_series){lmax, entries, ylm_alloc((size_t)lmax + 1, sizeof(float)),
                         ylm_alloc(entries, sizeof(float)), ylm_alloc(entries, sizeof(float))};
  bool ok = p && s->first && s->a && s->b;
  if (ok) ylm_sh_legendre(lmax, 0, 1, p);
  for (int m = 0; ok && m <= lmax; m++) {
    s->first[m] = (float)p[m * (m + 1) / 2 + m];
    for (int l = m; l <= lmax; l++, k++) { /* to degree l + 1 */
      double n = l + 1, d = n * n - (double)m * m;
      s->a[k] = (float)sqrt((4 * n * n - 1) / d);
      s->b[k] =
          l == m ? 0
                 : (float)sqrt(((double)l * l - (double)m * m) * (2 * n + 1) / (d * (2 * n - 3)));
    }
  }
  ylm_free(p);
  return ok ? YLM_OK : YLM_ENOMEM;
}

void ylm__many_series_free(ylm_many_series *s) {
  ylm_free(s->first);
  ylm_free(s->a);
  ylm_free(s->b);
}

/* -- materials ---------------------------------------------------------------------- */

/* Whether receivers are known by tables; others ask the material itself. */
static bool has_tables(const ylm_shade_gather_options *o) {
  return o->method == YLM_SHADE_HVL || o->method == YLM_SHADE_VSGL;
}

static void toward(double angle, double azimuth, float w[3]) {
  w[0] = (float)(sin(angle) * cos(azimuth));
  w[1] = (float)(sin(angle) * sin(azimuth));
  w[2] = (float)cos(angle);
}

/* The matte base of a material: the least f of some directions, sr^-1. */
static void find_base(material *m) {
  enum { N = ANGLES * AZIMUTHS };
  float wi[N][3], wo[N][3], f[N][3];
  for (int c = 0; c < 3; c++) m->base[c] = INFINITY;
  for (int e = 0; e < EYES; e++) {
    for (int i = 0; i < N; i++) {
      toward((e + 0.5) / EYES * 0.45 * YLM_PI, 0.4, wo[i]);
      toward((i / AZIMUTHS + 0.5) / ANGLES * 0.45 * YLM_PI,
             2 * YLM_PI * (i % AZIMUTHS) / AZIMUTHS + 0.4, wi[i]);
    }
    ylm_material_eval(m->m, N, (const float(*)[3])wi, (const float(*)[3])wo, f);
    for (int i = 0; i < N; i++)
      for (int c = 0; c < 3; c++) m->base[c] = fminf(m->base[c], fmaxf(0, f[i][c]));
  }
}

static ylm_status make_material(const many_gloss *g, material *m, ylm_error *e) {
  if (!has_tables(g->o)) return YLM_OK;
  ylm_status s = ylm_material_table_kept_as(
      m->m, g->zonal ? YLM_MATERIAL_TABLE_BARE : YLM_MATERIAL_TABLE_COSINE, g->lmax, g->o->threads,
      g->o->progress, &m->table, e);
  if (s != YLM_OK) return s;
  ylm_material_table_look(m->table, &m->facts);
  if (g->zonal) find_base(m);
  return YLM_OK;
}

static ylm_status list_materials(const ylm_shade_view *v, many_gloss *g, ylm_error *e) {
  for (size_t i = 0; i < v->points; i++) {
    const ylm_material *m = ylm__shade_material(v, i);
    size_t k = 0;
    if ((i > 0 && v->mesh[i] == v->mesh[i - 1]) || !ylm_material_glosses(m)) continue;
    while (k < g->n && g->material[k].m != m) k++;
    g->slot[v->mesh[i]] = (uint32_t)k;
    if (k < g->n) continue;
    g->material[g->n++].m = m;
    if (!ylm_material_isotropic(m)) g->turned = true;
    ylm_status s = make_material(g, &g->material[k], e);
    if (s != YLM_OK) return s;
  }
  return YLM_OK;
}

/* Coefficients of what is 1 above the surface. */
static bool make_hemisphere(many_gloss *g) {
  int lmax = g->lmax;
  double P0 = 1, P1 = 0; /* at 0 */
  double *h = g->hemisphere = ylm_alloc((size_t)lmax + 2, sizeof *h);
  if (!h) return false;
  /* int_0^1 P_l = (P_(l-1)(0) - P_(l+1)(0))/(2l+1) */
  h[0] = 1;
  for (int l = 1; l <= lmax; l++) {
    double P2 = -l * P0 / (l + 1);
    h[l] = (P0 - P2) / (2 * l + 1);
    P0 = P1, P1 = P2;
  }
  for (int l = 0; l <= lmax; l++) h[l] *= 2 * YLM_PI * sqrt((2 * l + 1) / (4 * YLM_PI));
  return true;
}

ylm_status ylm__many_gloss(const ylm_shade_view *v, const ylm_shade_gather_options *o,
                           many_gloss **out, ylm_error *e) {
  size_t meshes = ylm_scene_meshes(v->scene), glossy = 0;
  *out = NULL;
  for (size_t i = 0; i < meshes; i++)
    glossy += ylm_material_glosses(ylm__shade_mesh_material(v, i));
  if (glossy == 0 || o->matte || v->points == 0) return YLM_OK;
  if (o->method == YLM_SHADE_HVL && o->lmax > YLM_MATERIAL_TABLE_LMAX)
    return ylm_fail(e, YLM_ERANGE,
                    "surfaces that gloss are shaded by tables of degree 0 to %d, lmax is %d: lower "
                    "it, or prepare the view with gloss = 'matte'",
                    YLM_MATERIAL_TABLE_LMAX, o->lmax);
  many_gloss *g = *out = ylm_alloc_zero(1, sizeof *g);
  if (!g) return YLM_ENOMEM;
  g->o = o;
  g->zonal = o->zonal || o->method == YLM_SHADE_VSGL;
  g->lmax = o->method == YLM_SHADE_VSGL ? 1 : o->lmax;
  g->slot = ylm_alloc(meshes, sizeof *g->slot);
  g->material = ylm_alloc_zero(glossy, sizeof *g->material);
  if (!g->slot || !g->material) return YLM_ENOMEM;
  for (size_t i = 0; i < meshes; i++) g->slot[i] = YLM_SHADE_MATTE;
  ylm_status s = list_materials(v, g, e);
  if (s == YLM_OK && g->turned && v->corner && !(g->vertex = ylm__shade_point_vertices(v)))
    return YLM_ENOMEM;
  if (s != YLM_OK || !has_tables(o)) return s;
  if (g->zonal) return make_hemisphere(g) ? YLM_OK : YLM_ENOMEM;
  return ylm__many_series(o->lmax, &g->series);
}

void ylm__many_gloss_free(many_gloss *g) {
  if (!g) return;
  ylm__many_series_free(&g->series);
  ylm_free(g->hemisphere);
  ylm_free(g->vertex);
  ylm_free(g->material);
  ylm_free(g->slot);
  ylm_free(g);
}

bool ylm__many_glosses(const many_gloss *g, const ylm_shade_view *v, size_t p) {
  return g && g->slot[v->mesh[p]] != YLM_SHADE_MATTE;
}

/* -- points ------------------------------------------------------------------------- */

size_t ylm__many_gloss_room(const many_gloss *g) {
  size_t count = ylm_sh_count(g->lmax); /* a row as the table has it, then as kernels want it */
  return 3 * count + 3 * 2 * (g->series.entries ? g->series.entries : (size_t)g->lmax + 1) + count;
}

/* The number of (l, m) in a row of a function; -1: it holds m >= 0 alone. */
static int place(const material *m, int l, int q) {
  if (!m->facts.halves) return l * (l + 1) + q;
  return q < 0 ? -1 : l * (l + 1) / 2 + q;
}

static double window_of(const many_gloss *g, int l) {
  return g->o->window && g->o->method == YLM_SHADE_HVL ? g->o->window[l] : 1;
}

/* Rows in the order of kernels. */
static void order_rows(const many_gloss *g, const material *m, const float *from, float *to) {
  int lmax = g->lmax;
  for (int f = 0; f < m->facts.functions; f++, from += m->facts.width, to += 2 * g->series.entries)
    for (int q = 0; q <= lmax; q++)
      for (int l = q; l <= lmax; l++) {
        size_t k = ylm_many_entry(lmax, l, q);
        int minus = q > 0 ? place(m, l, -q) : -1;
        double by = window_of(g, l);
        to[k] = (float)(by * (double)from[place(m, l, q)]);
        to[g->series.entries + k] = minus < 0 ? 0 : (float)(by * (double)from[minus]);
      }
}

/* The lobe above the base, of channel c: coefficient (l, q). */
static double above_base(const many_gloss *g, const material *m, const float *row, int c, int l,
                         int q) {
  const float(*mix)[3] = ylm_material_table_mix(m->table);
  int k = place(m, l, q);
  double sum = q == 0 ? -(double)m->base[c] * g->hemisphere[l] : 0;
  for (int f = 0; k >= 0 && f < m->facts.functions; f++)
    sum += (double)mix[c][f] * (double)row[(size_t)f * m->facts.width + (size_t)k];
  return sum;
}

/* Lobes about the direction in which the light above the base lies, in the mean. */
static ylm_status make_lobes(const many_gloss *g, const material *m, const float *row, float *z,
                             float *Y, ylm_many_receiver *r) {
  int lmax = g->lmax;
  double d[3] = {0, 0, 0}, luminance[3] = {YLM_LUMINANCE_R, YLM_LUMINANCE_G, YLM_LUMINANCE_B};
  float axis[3];
  for (int c = 0; lmax > 0 && c < 3; c++) {
    d[0] -= luminance[c] * above_base(g, m, row, c, 1, 1);
    d[1] -= luminance[c] * above_base(g, m, row, c, 1, -1);
    d[2] += luminance[c] * above_base(g, m, row, c, 1, 0);
  }
  if (!ylm_unit3(d)) d[0] = d[1] = 0, d[2] = 1;
  for (int k = 0; k < 3; k++) axis[k] = (float)d[k];
  ylm_status s = ylm_sh_eval(lmax, 0, false, YLM_FLOAT, 1, axis, Y, NULL, NULL, 1, NULL);
  for (int k = 0; k < 3; k++)
    r->lobe[k] = axis[0] * r->axis[0][k] + axis[1] * r->axis[1][k] + axis[2] * r->axis[2][k];
  for (int c = 0; c < 3; c++)
    for (int l = 0; l <= lmax; l++) {
      double sum = 0;
      for (int q = -l; q <= l; q++)
        sum += above_base(g, m, row, c, l, q) * (double)Y[l * (l + 1) + q];
      z[c * (lmax + 1) + l] = (float)(window_of(g, l) * sum);
    }
  r->lobes = z;
  return s;
}

/* From degrees 0 and 1 of three lobes z to powers over A of Gaussian ones, in place, and their sharpness. */
static void be_gaussian(float *z, ylm_many_receiver *r) {
  double power = 0, along = 0, luminance[3] = {YLM_LUMINANCE_R, YLM_LUMINANCE_G, YLM_LUMINANCE_B};
  for (int c = 0; c < 3; c++) {
    power += luminance[c] * 4 * YLM_PI * (double)z[2 * c];
    along += luminance[c] * 4 * YLM_PI / 3 * (double)z[2 * c + 1];
  }
  double R = power > 0 ? fmin(1 - 1e-6, fmax(0, along / power)) : 0;
  double sharp = R * (3 - R * R) / (1 - R * R);
  double area = sharp > 1e-6 ? 2 * YLM_PI * -expm1(-2 * sharp) / sharp : 4 * YLM_PI;
  for (int c = 0; c < 3; c++) z[c] = (float)(fmax(0, 4 * YLM_PI * (double)z[2 * c]) / area);
  r->sharp = (float)sharp;
}

/* The direction to the eye in the surface's frame, above it. */
static void raise(float wo[3]) {
  if (wo[2] >= LEAST_COSINE) return;
  wo[2] = LEAST_COSINE;
  float each = 1 / sqrtf(ylm_dot3(wo, wo));
  for (int k = 0; k < 3; k++) wo[k] *= each;
}

ylm_status ylm__many_receive(const many_gloss *g, const ylm_shade_view *v, size_t p, float *room,
                             ylm_many_receiver *r) {
  const material *m = &g->material[g->slot[v->mesh[p]]];
  ylm_scene_surface s;
  float frame[3][3];
  bool turned = !ylm_material_isotropic(m->m);
  if (turned) ylm__shade_surface(v, g->vertex, p, &s);
  *r = (ylm_many_receiver){.material = m->m, .turn = {1, 0}, .zonal = g->zonal};
  ylm__shade_look_along(v, p, turned ? s.tangent : NULL, r->wo, frame);
  for (int k = 0; k < 3; k++)
    for (int a = 0; a < 3; a++) r->axis[a][k] = frame[k][a];
  float across = sqrtf(r->wo[0] * r->wo[0] + r->wo[1] * r->wo[1]);
  if (turned && across > 0) r->turn[0] = r->wo[0] / across, r->turn[1] = r->wo[1] / across;
  if (!m->table) {
    raise(r->wo);
    return YLM_OK;
  }
  float *row = room, *made = room + 3 * ylm_sh_count(g->lmax);
  ylm_material_table_rows(m->table, 1, (const float(*)[3])r->wo, row);
  raise(r->wo);
  if (g->zonal) {
    memcpy(r->base, m->base, sizeof r->base);
    r->based = m->base[0] > 0 || m->base[1] > 0 || m->base[2] > 0;
    r->functions = 3;
    ylm_status made_of = make_lobes(g, m, row, made, made + 3 * ((size_t)g->lmax + 1), r);
    if (g->o->method == YLM_SHADE_VSGL) be_gaussian(made, r);
    return made_of;
  }
  order_rows(g, m, row, made);
  r->series = &g->series;
  r->functions = m->facts.functions;
  r->halves = m->facts.halves;
  r->mix = ylm_material_table_mix(m->table);
  r->row = made;
  return YLM_OK;
}

void ylm__many_eval(const ylm_many_receiver *r, size_t n, const float (*w)[3], float (*f)[3]) {
  float wi[YLM_MANY_CHUNK][3], wo[YLM_MANY_CHUNK][3];
  for (size_t i = 0; i < n; i++) {
    float x = ylm_dot3(w[i], r->axis[0]), y = ylm_dot3(w[i], r->axis[1]);
    wi[i][0] = r->turn[0] * x - r->turn[1] * y;
    wi[i][1] = r->turn[1] * x + r->turn[0] * y;
    wi[i][2] = ylm_dot3(w[i], r->axis[2]);
    memcpy(wo[i], r->wo, sizeof wo[i]);
  }
  ylm_material_eval(r->material, n, (const float(*)[3])wi, (const float(*)[3])wo, f);
}
