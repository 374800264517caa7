/*
** denoise.c - light of shading points without most of its noise: that of points around, of which two halves of the rays tell
** how alike they are.
*/
#include <math.h>
#include <string.h>

#include "denoise.h"

/* One picture that is filtered, all its points. */
typedef struct denoise_job {
  const ylm_shade_view *v;
  denoise_kernels kernel;
  denoise_grid fine, coarse; /* of pixels, and of 2 x 2 */
  float **half;
  const float *all;
  double noise; /* that is wanted, of this light: a part of all light */
  bool bounced;
  uint32_t *largest;    /* [pixels] the point that is in the grid; NOWHERE: none */
  float (*rare)[2][3];  /* [points] irradiance that was left out of it */
  float (*value)[2][3]; /* [points] irradiance of halves */
  float *class;         /* [points] the channels that are reflected; -1: not filtered */
  float (*guide)[2], *spread, *variance, *reach; /* [points] variance is that of a half */
} denoise_job;

static double luminance(const float *rgb) {
  return ylm_luminance((double[]){(double)rgb[0], (double)rgb[1], (double)rgb[2]});
}

/* The number of a pixel's cell in a grid. */
static size_t at(const denoise_grid *g, size_t x, size_t y) {
  return (y / g->cell + DENOISE_REACH) * g->stride + DENOISE_REACH + x / g->cell;
}

/* -- points ---------------------------------------------------------------------------------------- */

/* Irradiance of point i, in both halves, and the class of channels that its surface reflects. */
static void demodulate(denoise_job *j, size_t i) {
  float albedo[3];
  int class = 0;
  ylm__shade_albedo(j->v, i, albedo);
  for (int c = 0; c < 3; c++) {
    bool lit = albedo[c] > DENOISE_ALBEDO;
    class |= lit << c;
    for (int h = 0; h < 2; h++) j->value[i][h][c] = lit ? j->half[h][3 * i + c] / albedo[c] : 0;
  }
  const ylm_material *m = ylm__shade_material(j->v, i);
  if (ylm_material_glosses(m)) class |= 8 + (int)(ylm_material_print(m) % DENOISE_MATERIALS) * 16;
  bool narrow = ylm_material_excess(m, DENOISE_EYE) > DENOISE_NARROW;
  j->class[i] = (class & 7) == 0 || narrow ? -1 : (float)class;
}

float ylm__denoise_irradiance(const ylm_shade_view *v, size_t i, const float *radiance) {
  float albedo[3], E[3];
  ylm__shade_albedo(v, i, albedo);
  for (int c = 0; c < 3; c++)
    E[c] = albedo[c] > DENOISE_ALBEDO ? radiance[3 * i + (size_t)c] / albedo[c] : 0;
  return (float)luminance(E);
}

/* Puts point i into the fine grid. */
static void place(denoise_job *j, size_t i, size_t k) {
  float *const *to = j->fine.number;
  for (int a = 0; a < 3; a++) {
    to[TAP_X + a][k] = j->v->position[i][a];
    to[TAP_NORMAL + a][k] = j->v->normal[i][a];
    to[TAP_VALUE + a][k] = j->value[i][0][a];
    to[TAP_VALUE + 3 + a][k] = j->value[i][1][a];
  }
  to[TAP_SHARE][k] = j->v->entry[i].weight;
  to[TAP_CLASS][k] = j->class[i];
  to[TAP_GUIDE][k] = (float)luminance(j->value[i][0]);
  to[TAP_GUIDE + 1][k] = (float)luminance(j->value[i][1]);
  to[TAP_APART][k] = powf(to[TAP_GUIDE][k] - to[TAP_GUIDE + 1][k], 2);
  to[TAP_ALL][k] = ylm__denoise_irradiance(j->v, i, j->all);
}

/* All points of rows of pixels; the largest of a pixel that is filtered is in the grid. */
static ylm_status fill(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  denoise_job *j = context;
  const ylm_shade_view *v = j->v;
  for (size_t y = begin; y < end; y++)
    for (size_t x = 0, p = y * j->fine.width; x < j->fine.width; x++, p++) {
      uint32_t best = YLM_SHADE_NOWHERE;
      for (size_t i = v->pixel[p].first; i < v->pixel[p + 1].first; i++) {
        demodulate(j, i);
        if (j->class[i] < 0) continue;
        if (best == YLM_SHADE_NOWHERE || v->entry[i].weight > v->entry[best].weight)
          best = (uint32_t)i;
      }
      j->largest[p] = best;
      if (best != YLM_SHADE_NOWHERE) place(j, best, at(&j->fine, x, y));
    }
  return YLM_OK;
}

/* Whether tap i of a grid is of a surface like that of tap k. */
static bool is_like(const denoise_grid *g, size_t k, size_t i) {
  float cosine = 0;
  for (size_t c = TAP_NORMAL; c < TAP_NORMAL + 3; c++) cosine += g->number[c][i] * g->number[c][k];
  return i != k && g->number[TAP_SHARE][i] > 0 &&
         g->number[TAP_CLASS][i] == g->number[TAP_CLASS][k] && cosine > DENOISE_COSINE;
}

/* The mean light of halves at taps of the fine grid around tap k, of surfaces like its; INFINITY: fewer than `least` are. */
static float around(const denoise_grid *g, size_t k, int least) {
  float sum = 0;
  int n = 0;
  for (int v = -DENOISE_CALM; v <= DENOISE_CALM; v++)
    for (int u = -DENOISE_CALM; u <= DENOISE_CALM; u++) {
      size_t i = (size_t)((ptrdiff_t)k + v * (ptrdiff_t)g->stride + u);
      if (!is_like(g, k, i)) continue;
      sum += g->number[TAP_GUIDE][i] + g->number[TAP_GUIDE + 1][i];
      n++;
    }
  return n >= least ? sum / (2 * (float)n) : INFINITY;
}

/* Light that rare rays brought is left out of a tap: taps around have not its like, nor has the other half, or it is light that
   bounces, of which no pixel amid a surface has much alone. */
static ylm_status calm(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const denoise_job *j = context;
  float *const *n = j->fine.number;
  const int all = (2 * DENOISE_CALM + 1) * (2 * DENOISE_CALM + 1) - 1;
  for (size_t y = begin; y < end; y++)
    for (size_t x = 0, p = y * j->fine.width; x < j->fine.width; x++, p++) {
      size_t k = at(&j->fine, x, y), i = j->largest[p];
      float light[2] = {n[TAP_GUIDE][k], n[TAP_GUIDE + 1][k]};
      float own = j->bounced ? 0 : fminf(light[0], light[1]);
      if (!(fmaxf(light[0], light[1]) > DENOISE_RARE * own)) continue;
      float rare = j->bounced ? DENOISE_RARE_BOUNCED : DENOISE_RARE;
      float rest = own + around(&j->fine, k, j->bounced ? all : DENOISE_CALM);
      for (size_t h = 0; h < 2; h++)
        for (size_t c = 0; light[h] > rare * rest && c < 3; c++) {
          float *value = &n[TAP_VALUE + 3 * h + c][k], left = *value * rest / light[h];
          j->rare[i][h][c] = *value - left;
          j->value[i][h][c] = *value = left;
        }
    }
  return YLM_OK;
}

/* A point of pixel (x, y) as a centre in a grid; reach in pixels. */
static denoise_centre centre_of(const denoise_job *j, const denoise_grid *g, size_t x, size_t y,
                                size_t i, float reach) {
  const ylm_shade_view *v = j->v;
  float cells = reach / (float)g->cell, side = (float)g->cell;
  denoise_centre c = {.at = at(g, x, y), .rows = (int)(cells + 0.5f), .class = j->class[i]};
  double pixel = v->frame.pixel * (double)v->entry[i].depth;
  c.off[0] = ((float)(x % g->cell) + 0.5f) / side - 0.5f;
  c.off[1] = ((float)(y % g->cell) + 0.5f) / side - 0.5f;
  memcpy(c.x, v->position[i], sizeof c.x);
  memcpy(c.normal, v->normal[i], sizeof c.normal);
  c.plane = (float)(1 / fmax(DENOISE_PLANE * pixel, 1e-30));
  c.falloff = 1 / (cells * cells);
  c.around = (float)(1 / fmax(pow(DENOISE_AROUND * (double)reach * pixel, 2), 1e-30));
  memcpy(c.guide, j->guide[i], sizeof c.guide);
  c.spread = j->spread[i];
  return c;
}

/* Calls f(job, x, y, point) for the points of rows of pixels that are filtered. */
static void each_point(denoise_job *j, size_t begin, size_t end,
                       void (*f)(denoise_job *j, size_t x, size_t y, size_t i)) {
  for (size_t y = begin; y < end; y++)
    for (size_t x = 0, p = y * j->fine.width; x < j->fine.width; x++, p++)
      for (size_t i = j->v->pixel[p].first; i < j->v->pixel[p + 1].first; i++)
        if (j->class[i] >= 0) f(j, x, y, i);
}

/* Guides and their variance, from points to the fine grid. */
static ylm_status take(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const denoise_job *j = context;
  for (size_t y = begin; y < end; y++)
    for (size_t x = 0; x < j->fine.width; x++) {
      uint32_t i = j->largest[y * j->fine.width + x];
      if (i == YLM_SHADE_NOWHERE) continue;
      size_t k = at(&j->fine, x, y);
      j->fine.number[TAP_GUIDE][k] = j->guide[i][0];
      j->fine.number[TAP_GUIDE + 1][k] = j->guide[i][1];
      j->fine.number[TAP_SPREAD][k] = j->spread[i];
    }
  return YLM_OK;
}

/* Whether taps a and b of a grid are of one surface: their light may be one tap of a coarser grid. */
static bool alike(const denoise_job *j, size_t a, size_t b, double plane) {
  float *const *n = j->fine.number;
  double up = 0, cosine = 0;
  for (int k = 0; k < 3; k++) {
    up += ((double)n[TAP_X + k][b] - (double)n[TAP_X + k][a]) * (double)n[TAP_NORMAL + k][a];
    cosine += (double)n[TAP_NORMAL + k][a] * (double)n[TAP_NORMAL + k][b];
  }
  return n[TAP_CLASS][a] == n[TAP_CLASS][b] && n[TAP_SHARE][b] > 0 &&
         cosine > (double)SHADE_SAME_NORMAL && fabs(up) < plane;
}

/* The mean of the taps of four pixels that are like the first of them. */
static void merge(denoise_job *j, size_t x, size_t y) {
  const denoise_grid *g = &j->fine;
  size_t to = at(&j->coarse, x, y), from[4], n = 0;
  double plane = 0, weight = 0, sum[TAP_NUMBERS] = {0};
  for (size_t v = y; v < y + 2 && v < g->height; v++)
    for (size_t u = x; u < x + 2 && u < g->width; u++) {
      uint32_t i = j->largest[v * g->width + u];
      if (i == YLM_SHADE_NOWHERE) continue;
      if (n == 0) plane = j->v->frame.pixel * (double)j->v->entry[i].depth;
      from[n++] = at(g, u, v);
    }
  for (size_t m = 0; m < n; m++) {
    if (!alike(j, from[0], from[m], plane)) continue;
    double w = (double)g->number[TAP_SHARE][from[m]];
    weight += w;
    for (int k = 0; k < TAP_NUMBERS; k++) sum[k] += w * (double)g->number[k][from[m]];
  }
  if (!(weight > 0)) return;
  for (int k = 0; k < TAP_NUMBERS; k++) j->coarse.number[k][to] = (float)(sum[k] / weight);
  j->coarse.number[TAP_SHARE][to] = (float)weight;
}

static ylm_status coarsen(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  denoise_job *j = context;
  for (size_t y = begin; y < end; y++)
    for (size_t x = 0; x < j->coarse.width; x++) merge(j, 2 * x, 2 * y);
  return YLM_OK;
}

/* -- passes ---------------------------------------------------------------------------------------- */

/* How far taps of a point reach, in pixels: as far as leaves the noise that is wanted. The weights 1 - d^2/r^2 of a disk
   count as 3/4 pi r^2 taps. */
static float reach_of(const denoise_job *j, float variance, float all) {
  double wanted = j->noise * (double)all,
         taps = (double)variance / 2 / fmax(wanted * wanted, 1e-300);
  return (float)fmin(sqrt(taps / (0.75 * YLM_PI)), 2 * DENOISE_REACH);
}

/* The guide of a point by sums, and its variance. */
static void guide_of(denoise_job *j, size_t i, const denoise_sums *s) {
  double spread = 0;
  for (int h = 0; h < 2; h++) {
    if (!(s->weight[h] > 0)) return;
    double w = (double)s->weight[h];
    j->guide[i][h] = (float)(luminance(s->value[h]) / w);
    spread += (double)j->variance[i] * (double)s->square[h] / (w * w) / 2;
  }
  j->spread[i] = (float)fmax(spread, DENOISE_LEAST);
}

/* Adds a point that is no tap to sums of denoise_vary_fn. */
static void add_own(const denoise_job *j, size_t i, float sums[3]) {
  float weight = j->v->entry[i].weight;
  sums[0] += weight;
  sums[1] += weight * powf(j->guide[i][0] - j->guide[i][1], 2);
  sums[2] += weight * ylm__denoise_irradiance(j->v, i, j->all);
}

/* The variance of a point's light by that of points around, how far it reaches, and its first guide. */
static void look(denoise_job *j, size_t x, size_t y, size_t i) {
  float sums[3];
  denoise_sums s;
  for (int h = 0; h < 2; h++) j->guide[i][h] = (float)luminance(j->value[i][h]);
  j->spread[i] = INFINITY;
  const denoise_grid *g = &j->coarse;
  denoise_centre c = centre_of(j, g, x, y, i, DENOISE_VARIED);
  j->kernel.vary(g, &c, sums);
  if (!(sums[0] > 0)) { /* of a part of 2 x 2 pixels that is another surface */
    c = centre_of(j, g = &j->fine, x, y, i, DENOISE_VARIED);
    j->kernel.vary(g, &c, sums);
  }
  if (j->largest[y * j->fine.width + x] != i) add_own(j, i, sums);
  if (!(sums[0] > 0)) return;
  j->variance[i] = sums[1] / (2 * sums[0]);
  j->reach[i] = reach_of(j, j->variance[i], sums[2] / sums[0]);
  c = centre_of(j, &j->fine, x, y, i, DENOISE_FIRST);
  j->kernel.gather(&j->fine, &c, &s);
  guide_of(j, i, &s);
}

/* Whether a half has few taps that are like it. */
static bool is_few(const denoise_sums *s, int h) {
  return !(s->weight[h] * s->weight[h] > DENOISE_FEW * s->square[h]);
}

/* Whether few taps are like a point by chance: of a small part of the picture, a slit of sun, both halves say so and agree;
   else one of them has met a ray in thousands. */
static bool is_chance(const denoise_job *j, size_t i, const denoise_sums *s) {
  bool few[2] = {is_few(s, 0), is_few(s, 1)};
  float apart = j->guide[i][0] - j->guide[i][1];
  return few[0] != few[1] || (few[0] && apart * apart > 2 * DENOISE_RANGE * j->spread[i]);
}

/* Sums over all taps of the second guide, like or not. */
static void gather_all(const denoise_job *j, size_t x, size_t y, size_t i, denoise_sums *out) {
  denoise_centre c = centre_of(j, &j->fine, x, y, i, fminf(j->reach[i], DENOISE_GUIDED));
  c.spread = INFINITY;
  j->kernel.gather(&j->fine, &c, out);
}

/* The second guide of a point. */
static void guide(denoise_job *j, size_t x, size_t y, size_t i) {
  denoise_sums s;
  if (!(j->reach[i] >= 1)) return;
  denoise_centre c = centre_of(j, &j->fine, x, y, i, fminf(j->reach[i], DENOISE_GUIDED));
  j->kernel.gather(&j->fine, &c, &s);
  if (is_chance(j, i, &s)) gather_all(j, x, y, i, &s);
  guide_of(j, i, &s);
}

/* At the centre, the plane that fits the light of taps best; slopes are drawn to 0 by a part of a cell. */
static void fitted(const denoise_sums *s, int h, float out[3]) {
  double w = (double)s->weight[h], u = (double)s->u[h] / w, v = (double)s->v[h] / w;
  double uu = (double)s->uu[h] / w - u * u + DENOISE_RIDGE;
  double vv = (double)s->vv[h] / w - v * v + DENOISE_RIDGE, uv = (double)s->uv[h] / w - u * v;
  double scale = 1 / (uu * vv - uv * uv);
  for (int k = 0; k < 3; k++) {
    double mean = (double)s->value[h][k] / w;
    double du = (double)s->value_u[h][k] / w - u * mean;
    double dv = (double)s->value_v[h][k] / w - v * mean;
    double slope_u = (vv * du - uv * dv) * scale, slope_v = (uu * dv - uv * du) * scale;
    out[k] = (float)fmax(0, mean - slope_u * u - slope_v * v);
  }
}

/* Irradiance of point i before the filter becomes radiance, and its variance with it. */
static void modulate(denoise_job *j, size_t i, const float albedo[3]) {
  double y = luminance(albedo);
  j->variance[i] *= (float)(y * y);
  for (int h = 0; h < 2; h++)
    for (int k = 0; k < 3; k++) j->value[i][h][k] *= albedo[k];
}

/* The light of a point by that of points around. */
static void filter(denoise_job *j, size_t x, size_t y, size_t i) {
  denoise_sums s, all;
  float albedo[3], light[3];
  if (!(j->reach[i] >= 1)) return;
  const denoise_grid *g = j->reach[i] < DENOISE_COARSE ? &j->fine : &j->coarse;
  denoise_centre c = centre_of(j, g, x, y, i, j->reach[i]);
  j->kernel.fit(g, &c, &s);
  ylm__shade_albedo(j->v, i, albedo);
  for (int h = 0; h < 2; h++) {
    const denoise_sums *of = is_few(&s, h) && is_chance(j, i, &s) ? &all : &s;
    if (of == &all) gather_all(j, x, y, i, &all);
    if (!(of->weight[h] > 0)) continue;
    if (!is_few(&s, h)) fitted(&s, h, light);
    for (int k = 0; is_few(&s, h) && k < 3; k++) light[k] = of->value[h][k] / of->weight[h];
    for (int k = 0; k < 3; k++) j->half[h][3 * i + (size_t)k] = light[k] * albedo[k];
  }
  modulate(j, i, albedo);
}

static ylm_status run_look(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  each_point(context, begin, end, look);
  return YLM_OK;
}

static ylm_status run_guide(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  each_point(context, begin, end, guide);
  return YLM_OK;
}

static ylm_status run_filter(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  each_point(context, begin, end, filter);
  return YLM_OK;
}

/* -- all of it ------------------------------------------------------------------------------------- */

static void job_free(denoise_job *j) {
  ylm_free(j->fine.number[0]);
  ylm_free(j->coarse.number[0]);
  ylm_free(j->largest);
  ylm_free(j->rare);
  ylm_free(j->value);
  ylm_free(j->class);
  ylm_free(j->guide);
  ylm_free(j->spread);
  ylm_free(j->variance);
  ylm_free(j->reach);
}

static bool grid_create(denoise_grid *g, size_t cell, size_t width, size_t height) {
  *g = (denoise_grid){
      .cell = cell, .width = (width + cell - 1) / cell, .height = (height + cell - 1) / cell};
  g->stride = g->width + 2 * DENOISE_REACH + DENOISE_LANES;
  size_t room = g->stride * (g->height + 2 * DENOISE_REACH + 1);
  float *numbers = ylm_alloc_zero(room, TAP_NUMBERS * sizeof *numbers);
  for (size_t k = 0; numbers && k < TAP_NUMBERS; k++) g->number[k] = numbers + k * room;
  return numbers != NULL;
}

static ylm_status job_create(denoise_job *j, size_t width, size_t height) {
  size_t points = j->v->points;
  bool grids = grid_create(&j->fine, 1, width, height) && grid_create(&j->coarse, 2, width, height);
  j->largest = ylm_alloc(width * height, sizeof *j->largest);
  j->rare = ylm_alloc_zero(points, sizeof *j->rare);
  j->value = ylm_alloc(points, sizeof *j->value);
  j->class = ylm_alloc(points, sizeof *j->class);
  j->guide = ylm_alloc(points, sizeof *j->guide);
  j->spread = ylm_alloc(points, sizeof *j->spread);
  j->variance = ylm_alloc_zero(points, sizeof *j->variance);
  j->reach = ylm_alloc_zero(points, sizeof *j->reach);
  bool all = grids && j->largest && j->rare && j->value && j->class && j->guide && j->spread &&
             j->variance && j->reach;
  return all ? YLM_OK : YLM_ENOMEM;
}

ylm_status ylm_shade_denoise(const ylm_shade_view *v, float *half[2], const float *all,
                             bool bounced, double noise, int threads,
                             const ylm_progress *progress) {
  if (v->corner || v->number) return YLM_EINVAL;
  if (!(noise > 0)) return YLM_ERANGE;
  denoise_job j = {.v = v,
                   .kernel = ylm__denoise_kernels(),
                   .half = half,
                   .all = all,
                   .noise = noise,
                   .bounced = bounced};
  ylm_status s = job_create(&j, (size_t)v->o.width, (size_t)v->o.height);
  struct {
    ylm_range_fn *run;
    size_t rows;
    bool shown;
  } step[] = {{fill, j.fine.height, false},      {calm, j.fine.height, false},
              {coarsen, j.coarse.height, false}, {run_look, j.fine.height, true},
              {take, j.fine.height, false},      {run_guide, j.fine.height, true},
              {take, j.fine.height, false},      {coarsen, j.coarse.height, false},
              {run_filter, j.fine.height, true}};
  for (size_t k = 0; s == YLM_OK && k < sizeof step / sizeof *step; k++)
    s = ylm_parallel(step[k].rows, 1, threads, step[k].run, &j, step[k].shown ? progress : NULL,
                     "denoising");
  denoise_balance kept = {v, (const float(*)[2][3])j.value, j.variance, j.reach, half};
  if (s == YLM_OK) s = ylm__denoise_balance(&kept, threads);
  if (s == YLM_OK) s = ylm__denoise_share(&kept, (const float(*)[2][3])j.rare, threads);
  job_free(&j);
  return s;
}
