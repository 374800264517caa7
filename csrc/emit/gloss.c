/*
** gloss.c - what surfaces that gloss reflect of a particle, and how it leaves them: fitted slices of their materials.
**
** A light's emission is the slice of the particle's arrival, fitted over the hemisphere. The slice
** is turned from the frame of arrival and normal to the axes of the scene.
*/
#include "emit.h"
#include "ylm_material_table.h"
#include "ylm_sh.h"

/* Reflectances of a material: rows of the angle from the normal, columns of the azimuth. */
#define ROWS 65
#define TURNED_ROWS 17
#define COLUMNS 16
/* The part of its flux that a slice keeps at least if it is to be scaled to the whole. */
#define LEAST_FLUX 0.05
/* Lights whose slices are made at once. */
#define BATCH 256
/* Degrees that are tried, and the error of the slice at 45 degrees with which they are enough. A white metal of
   roughness 0.5 has 13 % at degree 2, one of 0.25 has 25 % at degree 4. */
static const struct {
  int degree;
  double error;
} tries[] = {{2, 0.14}, {4, 0.26}, {8, INFINITY}};
/* Directions about a normal, at which light below zero is looked for. */
#define RINGS 7
#define TURNS 14

typedef struct gloss_material {
  const ylm_material *m;
  int rows, columns;
  float (*reflectance)[3]; /* [columns][rows] */
} gloss_material;

struct emit_gloss {
  size_t n;
  uint32_t *slot; /* [meshes] its material; EMIT_MATTE */
  gloss_material *material;
};

/* -- reflectances ------------------------------------------------------------------- */

static void toward(double angle, double azimuth, float w[3]) {
  w[0] = (float)(sin(angle) * cos(azimuth));
  w[1] = (float)(sin(angle) * sin(azimuth));
  w[2] = (float)cos(angle);
}

static ylm_status measure(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  gloss_material *m = context;
  for (size_t i = begin; i < end; i++) {
    size_t rows = (size_t)m->rows;
    double angle = (double)(i % rows) / (double)(rows - 1) * YLM_PI / 2;
    float w[3];
    /* the last row is a little above the horizon */
    toward(fmin(angle, 0.4999 * YLM_PI), 2 * YLM_PI * (double)(i / rows) / m->columns, w);
    ylm_material_reflectance(m->m, 1, (const float(*)[3])w, m->reflectance + i);
  }
  return YLM_OK;
}

static ylm_status make_material(gloss_material *m, const ylm_emit_options *o) {
  bool turned = !ylm_material_isotropic(m->m);
  m->rows = turned ? TURNED_ROWS : ROWS;
  m->columns = turned ? COLUMNS : 1;
  size_t n = (size_t)m->rows * (size_t)m->columns;
  m->reflectance = ylm_alloc(n, sizeof *m->reflectance);
  if (!m->reflectance) return YLM_ENOMEM;
  return ylm_parallel(n, 4, o->threads, measure, m, o->progress, "particles");
}

void ylm__emit_gloss_free(emit_gloss *g) {
  if (!g) return;
  for (size_t k = 0; g->material && k < g->n; k++) ylm_free(g->material[k].reflectance);
  ylm_free(g->material);
  ylm_free(g->slot);
  ylm_free(g);
}

ylm_status ylm__emit_gloss(const ylm_scene *scene, const ylm_emit_options *o, emit_gloss **out) {
  size_t meshes = ylm_scene_meshes(scene), glossy = 0;
  *out = NULL;
  for (size_t i = 0; i < meshes; i++) glossy += ylm_material_glosses(ylm_scene_material(scene, i));
  if (glossy == 0 || o->degree == 0) return YLM_OK;
  emit_gloss *g = *out = ylm_alloc_zero(1, sizeof *g);
  if (!g) return YLM_ENOMEM;
  g->slot = ylm_alloc(meshes, sizeof *g->slot);
  g->material = ylm_alloc_zero(glossy, sizeof *g->material);
  ylm_status s = g->slot && g->material ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < meshes; i++) {
    const ylm_material *m = ylm_scene_material(scene, i);
    size_t k = 0;
    g->slot[i] = EMIT_MATTE;
    if (!ylm_material_glosses(m)) continue;
    while (k < g->n && g->material[k].m != m) k++;
    g->slot[i] = (uint32_t)k;
    if (k < g->n) continue;
    g->n++;
    g->material[k].m = m;
    s = make_material(&g->material[k], o);
  }
  return s;
}

uint32_t ylm__emit_slot(const emit_gloss *g, size_t mesh) { return g ? g->slot[mesh] : EMIT_MATTE; }

void ylm__emit_frame(const ylm_scene_surface *s, float x[3], float y[3]) {
  float along = ylm_dot3(s->tangent, s->normal), length = 0;
  for (int k = 0; k < 3; k++) {
    x[k] = s->tangent[k] - along * s->normal[k];
    length += x[k] * x[k];
  }
  if (!(length > 1e-6f)) {
    ylm_scene_basis(s->normal, x, y);
    return;
  }
  for (int k = 0; k < 3; k++) x[k] /= sqrtf(length);
  for (int k = 0; k < 3; k++) {
    int a = (k + 1) % 3, b = (k + 2) % 3;
    y[k] = s->normal[a] * x[b] - s->normal[b] * x[a];
  }
}

void ylm__emit_reflectance(const emit_gloss *g, uint32_t slot, const float wo[3], float out[3]) {
  const gloss_material *m = &g->material[slot];
  double row = acos(fmin(1, fmax(0, (double)wo[2]))) / (YLM_PI / 2) * (m->rows - 1);
  double column = 0;
  if (m->columns > 1) {
    column = atan2((double)wo[1], (double)wo[0]) / (2 * YLM_PI) * m->columns;
    if (column < 0) column += m->columns;
  }
  int i = (int)fmin(row, m->rows - 2), j = (int)column;
  double by_row = row - i, by_column = column - j;
  for (int c = 0; c < 3; c++) {
    double sum = 0;
    for (int b = 0; b < 2; b++) {
      const float(*r)[3] =
          (const float(*)[3])m->reflectance + (size_t)((j + b) % m->columns) * (size_t)m->rows;
      sum += (b ? by_column : 1 - by_column) *
             ((1 - by_row) * (double)r[i][c] + by_row * (double)r[i + 1][c]);
    }
    out[c] = (float)sum;
  }
}

bool ylm__emit_sample(const emit_gloss *g, uint32_t slot, const float wo[3], const float u[3],
                      float wi[3], float weight[3]) {
  float pdf;
  ylm_material_sample(g->material[slot].m, 1, (const float(*)[3])wo, (const float(*)[3])u,
                      (float(*)[3])wi, (float(*)[3])weight, &pdf);
  return pdf > 0 && wi[2] > 0;
}

/* -- emission ----------------------------------------------------------------------- */

/* Lights of one material, and what is needed to make their emission. */
typedef struct making {
  const emit_gloss *g;
  const emit_landing *landing;
  const ylm_emit_options *o;
  ylm_emit_lights *l;
  ylm_emit_report *report;
  const ylm_material_table *table;
  ylm_material_table_facts facts;
  ylm_sh_rotator *rotator;
  size_t count;             /* of coefficients */
  double flux[9];           /* of the coefficients of m = 0 */
  float (*basis)[81];       /* [RINGS * TURNS] at directions about the normal */
  double part[RINGS];       /* their solid angle times the cosine */
  float *row, *turned;      /* [BATCH][functions][..] */
  double missed[2], weight; /* sum of squares, most; sum of what counts */
  double below, all;        /* light below zero; all */
} making;

static ylm_status fit_of(const emit_gloss *g, size_t k, int degree, const ylm_emit_options *o,
                         const ylm_material_table **table, ylm_error *e) {
  return ylm_material_table_kept_as(g->material[k].m, YLM_MATERIAL_TABLE_FIT, degree, o->threads,
                                    o->progress, table, e);
}

/* The degree that a material asks for. */
static ylm_status degree_of(const emit_gloss *g, size_t k, const ylm_emit_options *o, int *degree,
                            ylm_error *e) {
  const float half[1][3] = {{0.70710678f, 0, 0.70710678f}};
  for (size_t i = 0; i < sizeof tries / sizeof *tries; i++) {
    const ylm_material_table *table;
    float error;
    ylm_status s = fit_of(g, k, tries[i].degree, o, &table, e);
    if (s != YLM_OK) return s;
    ylm_material_table_missed(table, tries[i].degree, 1, half, &error);
    *degree = tries[i].degree;
    if ((double)error <= tries[i].error) break;
  }
  return YLM_OK;
}

/* The degree of all lights: the highest of their materials'. */
static ylm_status choose_degree(const emit_gloss *g, const emit_landing *landing, size_t n,
                                const ylm_emit_options *o, int *degree, ylm_error *e) {
  ylm_status s = YLM_OK;
  *degree = 0;
  for (size_t k = 0; g && s == YLM_OK && k < g->n; k++) {
    int own = 0;
    size_t i = 0;
    while (i < n && landing[i].slot != k) i++;
    if (i == n) continue;
    if (o->degree >= 0)
      own = o->degree;
    else
      s = degree_of(g, k, o, &own, e);
    if (own > *degree) *degree = own;
  }
  return s;
}

static bool prepare(making *x) {
  int K = x->l->degree, k = 0;
  double a[9], z[RINGS], weight[RINGS];
  float at[RINGS * TURNS][3];
  x->basis = ylm_alloc_zero(RINGS * TURNS, sizeof *x->basis);
  float *basis = ylm_alloc(RINGS * TURNS, x->count * sizeof *basis);
  x->row = ylm_alloc(BATCH, 3 * x->count * sizeof *x->row);
  x->turned = ylm_alloc(BATCH, 3 * x->count * sizeof *x->turned);
  bool ok = x->basis && basis && x->row && x->turned && ylm_material_cosine(K, a) == YLM_OK &&
            ylm_sh_rotator_create(K, &x->rotator, NULL) == YLM_OK;
  for (int l = 0; l <= K; l++) x->flux[l] = a[l] * sqrt((2 * l + 1) / (4 * YLM_PI));
  ylm_sh_gauss_legendre(RINGS, z, weight);
  for (int i = 0; i < RINGS; i++) {
    double cosine = (z[i] + 1) / 2;
    x->part[i] = cosine * weight[i] / 2 * 2 * YLM_PI / TURNS;
    for (int j = 0; j < TURNS; j++, k++) toward(acos(cosine), 2 * YLM_PI * j / TURNS, at[k]);
  }
  ok = ok && ylm_sh_eval(K, 0, true, YLM_FLOAT, RINGS * TURNS, at[0], basis, NULL, NULL, 1, NULL) ==
                 YLM_OK;
  for (size_t i = 0; ok && i < RINGS * TURNS; i++)
    memcpy(x->basis[i], basis + i * x->count, x->count * sizeof *basis);
  ylm_free(basis);
  return ok;
}

/* The arrival's direction in the surface's frame, and the axes: columns x, y, normal, x on its side. */
static void look(const emit_landing *l, float wo[3], float frame[3][3]) {
  float x[3], y[3], z = ylm_dot3(l->from, l->normal), across = sqrtf(fmaxf(0, 1 - z * z));
  float length = 0;
  for (int k = 0; k < 3; k++) {
    x[k] = l->from[k] - z * l->normal[k];
    length += x[k] * x[k];
  }
  if (length > 1e-10f)
    for (int k = 0; k < 3; k++) x[k] /= sqrtf(length);
  else
    ylm_scene_basis(l->normal, x, y);
  for (int k = 0; k < 3; k++) {
    int a = (k + 1) % 3, b = (k + 2) % 3;
    frame[k][0] = x[k];
    frame[k][1] = l->normal[a] * x[b] - l->normal[b] * x[a];
    frame[k][2] = l->normal[k];
  }
  wo[0] = across * cosf(l->azimuth), wo[1] = across * sinf(l->azimuth), wo[2] = z;
}

/* The coefficient (l, m), m >= 0, of function f in a row. */
static float row_at(const making *x, const float *row, int f, int l, int m) {
  const float *from = row + (size_t)f * x->facts.width;
  return from[x->facts.halves ? l * (l + 1) / 2 + m : l * (l + 1) + m];
}

/* Counts the light that the emission of a light of power `weight` sends and that is below zero: of its first function. */
static void count_below(making *x, const float *row, double weight) {
  double plus = 0, minus = 0;
  float whole[81] = {0};
  for (int l = 0; l <= x->l->degree; l++)
    for (int m = x->facts.halves ? 0 : -l; m <= l; m++)
      whole[l * (l + 1) + m] = row[x->facts.halves ? l * (l + 1) / 2 + m : l * (l + 1) + m];
  for (int i = 0, k = 0; i < RINGS; i++)
    for (int j = 0; j < TURNS; j++, k++) {
      float sum = 0;
      for (size_t q = 0; q < x->count; q++) sum += whole[q] * x->basis[k][q];
      *(sum < 0 ? &minus : &plus) += fabs((double)sum) * x->part[i];
    }
  if (minus > plus) plus = minus, minus = 0; /* a function has no sign of its own */
  x->below += weight * minus / fmax(plus - minus, 1e-30);
  x->all += weight;
}

/* Puts the emission of light i. */
static void put(making *x, size_t i, const float *row, const float *turned, const float rho[3]) {
  const float(*mix)[3] = ylm_material_table_mix(x->table);
  const emit_landing *from = &x->landing[i];
  double *to = x->l->emission + 3 * i * x->count;
  bool unscaled = false;
  for (size_t c = 0; c < 3; c++, to += x->count) {
    double flux = 0, scale = rho[c] > 0 ? 1 / (double)rho[c] : 0;
    for (int f = 0; f < x->facts.functions; f++)
      for (int l = 0; l <= x->l->degree; l++)
        flux += (double)mix[c][f] * x->flux[l] * (double)row_at(x, row, f, l, 0);
    if (x->o->conserve && flux > LEAST_FLUX * (double)rho[c])
      scale = 1 / flux;
    else if (x->o->conserve && from->power[c] > 0)
      unscaled = true;
    scale *= (double)from->power[c];
    for (size_t q = 0; q < x->count; q++) {
      double sum = 0;
      for (int f = 0; f < x->facts.functions; f++)
        sum += (double)mix[c][f] * (double)turned[(size_t)f * x->count + q];
      to[q] = scale * sum;
    }
  }
  x->report->unscaled += unscaled;
}

/* Emission of n <= BATCH lights of one material. */
static ylm_status do_batch(making *x, size_t n, const uint32_t *number) {
  float wo[BATCH][3], frame[BATCH][3][3], missed[BATCH];
  size_t functions = (size_t)x->facts.functions;
  for (size_t i = 0; i < n; i++) look(&x->landing[number[i]], wo[i], frame[i]);
  ylm_material_table_rows(x->table, n, (const float(*)[3])wo, x->row);
  ylm_material_table_missed(x->table, x->l->degree, n, (const float(*)[3])wo, missed);
  ylm_status s = ylm_sh_rotate_each(x->rotator, x->l->degree, YLM_FLOAT, n, frame, (int)functions,
                                    x->facts.halves, x->row, x->turned, 1, NULL, NULL);
  for (size_t i = 0; s == YLM_OK && i < n; i++) {
    const float *row = x->row + i * functions * x->facts.width;
    double weight = ylm__emit_luminous(&x->landing[number[i]]), error = (double)missed[i];
    float rho[3];
    ylm__emit_reflectance(x->g, x->landing[number[i]].slot, wo[i], rho);
    put(x, number[i], row, x->turned + i * functions * x->count, rho);
    count_below(x, row, weight);
    x->missed[0] += weight * error * error;
    x->missed[1] = fmax(x->missed[1], error);
    x->weight += weight;
  }
  return s;
}

static ylm_status do_material(making *x, size_t k, ylm_error *e) {
  uint32_t number[BATCH];
  size_t n = 0;
  ylm_status s = YLM_OK;
  x->table = NULL;
  for (size_t i = 0; s == YLM_OK && i < x->l->n; i++) {
    if (x->landing[i].slot != k) continue;
    if (!x->table) {
      s = fit_of(x->g, k, x->l->degree, x->o, &x->table, e);
      if (s == YLM_OK) ylm_material_table_look(x->table, &x->facts);
    }
    number[n++] = (uint32_t)i;
    if (s == YLM_OK && n == BATCH) s = do_batch(x, n, number), n = 0;
  }
  return s == YLM_OK && n > 0 ? do_batch(x, n, number) : s;
}

ylm_status ylm__emit_emission(const emit_gloss *g, const emit_landing *landing,
                              const ylm_emit_options *o, ylm_emit_lights *l,
                              ylm_emit_report *report, ylm_error *e) {
  making x = {.g = g, .landing = landing, .o = o, .l = l, .report = report};
  ylm_status s = choose_degree(g, landing, l->n, o, &l->degree, e);
  report->degree = l->degree;
  if (s != YLM_OK || l->degree == 0) return s;
  x.count = ylm_sh_count(l->degree);
  l->emission = ylm_alloc_zero(l->n, 3 * x.count * sizeof *l->emission);
  s = l->emission && prepare(&x) ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < l->n; i++)
    for (size_t c = 0; landing[i].slot == EMIT_MATTE && c < 3; c++)
      l->emission[(3 * i + c) * x.count] = sqrt(4 * YLM_PI) * l->intensity[3 * i + c];
  for (size_t k = 0; s == YLM_OK && k < g->n; k++) s = do_material(&x, k, e);
  report->missed[0] = x.weight > 0 ? sqrt(x.missed[0] / x.weight) : 0;
  report->missed[1] = x.missed[1];
  report->below = x.all > 0 ? x.below / x.all : 0;
  ylm_sh_rotator_free(x.rotator);
  ylm_free(x.basis);
  ylm_free(x.row);
  ylm_free(x.turned);
  return s;
}
