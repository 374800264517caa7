/* noise.c - how many occlusion rays a view needs: chosen by the noise that they leave. */
#include <math.h>
#include <string.h>

#include "../calibration.h"
#include "../gloss/gloss.h"
#include "ylm_image.h"

typedef struct trial {
  size_t n, count;
  size_t *point;       /* [n]        */
  shade_gloss *gloss;  /* of these   */
  float *part;         /* [n] of the radiance that is by rows of T */
  double *radiance[2]; /* [n] by T[0], T[1], to a factor of the material's */
  uint32_t *mesh;      /* [n]        */
  float (*position)[3], (*normal)[3], (*origin)[3]; /* [n]        */
  float *light;                                     /* [n][count] */
  float *T[2];                                      /* [n][count] */
} trial;

static void trial_free(trial *x) {
  ylm__shade_gloss_drop(x->gloss);
  ylm_free(x->point);
  ylm_free(x->part);
  ylm_free(x->radiance[0]);
  ylm_free(x->radiance[1]);
  ylm_free(x->mesh);
  ylm_free(x->position);
  ylm_free(x->normal);
  ylm_free(x->origin);
  ylm_free(x->light);
  ylm_free(x->T[0]);
  ylm_free(x->T[1]);
}

/* Points spread evenly over those of the view, and the luminance of the light there. */
static ylm_status trial_create(const ylm_shade_view *v, const float *share, trial *x,
                               ylm_error *e) {
  size_t n = v->points / NOISE_PART;
  if (n < NOISE_LEAST) n = NOISE_LEAST;
  if (n > NOISE_MOST) n = NOISE_MOST;
  if (n > v->points) n = v->points;
  x->n = n;
  x->count = ylm_sh_count(v->o.lmax);
  x->point = ylm_alloc(n, sizeof *x->point);
  x->part = ylm_alloc(n, sizeof *x->part);
  x->mesh = ylm_alloc(n, sizeof *x->mesh);
  x->position = ylm_alloc(n, sizeof *x->position);
  x->normal = ylm_alloc(n, sizeof *x->normal);
  x->origin = ylm_alloc(n, sizeof *x->origin);
  x->light = ylm_alloc(n, x->count * sizeof(float));
  bool made = x->point && x->part && x->mesh && x->position && x->normal && x->origin && x->light;
  for (int k = 0; k < 2; k++) {
    x->T[k] = ylm_alloc(n, x->count * sizeof(float));
    x->radiance[k] = ylm_alloc(n, sizeof(double));
    made = made && x->T[k] && x->radiance[k];
  }
  if (!made) return YLM_ENOMEM;
  for (size_t i = 0; i < n; i++) {
    size_t p = (size_t)(((double)i + 0.5) / (double)n * (double)v->points);
    x->point[i] = p;
    x->part[i] = share ? 1 - share[p] : 1;
    x->mesh[i] = v->mesh[p];
    memcpy(x->position[i], v->position[p], 12);
    memcpy(x->normal[i], v->normal[p], 12);
    memcpy(x->origin[i], v->origin[p], 12);
  }
  if (v->gloss && !(x->gloss = ylm__shade_gloss_pick(v->gloss, n, x->point))) return YLM_ENOMEM;
  ylm_field_query q = {.lmax = v->o.lmax,
                       .channels = 1,
                       .want = YLM_WANT_VALUE,
                       .metric_channels = 1,
                       .dtype = YLM_FLOAT,
                       .threads = v->o.threads,
                       .origin = v->world};
  ylm_field_result r = {.value = x->light};
  return ylm_field_evaluate(v->o.light, &q, n, x->position, &r, e);
}

static double dot(const float *a, const float *b, size_t n) {
  double s = 0;
  for (size_t k = 0; k < n; k++) s += (double)a[k] * (double)b[k];
  return s;
}

static bool is_glossy(const trial *x, size_t i) {
  return x->gloss && ylm__shade_gloss_slot(x->gloss, x->mesh[i]) != YLM_SHADE_MATTE;
}

/* Radiance by T[k]: of matte points the sum that it is in proportion to. */
static ylm_status trial_shade(const ylm_shade_view *v, const shade_tables *tables, trial *x,
                              int k) {
  ylm_status s = YLM_OK;
  float(*rgb)[3] = tables ? ylm_alloc(x->n, sizeof *rgb) : NULL;
  if (tables && !rgb) return YLM_ENOMEM;
  if (tables) {
    ylm_shade_view those = *v;
    those.mesh = x->mesh, those.position = x->position, those.normal = x->normal;
    those.transfer = x->T[k], those.gloss = x->gloss, those.tint = NULL;
    shade_rows rows = {.weight = YLM_SHADE_TRANSFER, .lmax = v->o.lmax, .tables = tables};
    s = ylm__shade_glossy(&those, ylm__shade_kernels().dot, &rows, true, 0, x->n,
                          &(shade_light){1, v->o.lmax, YLM_FLOAT, x->light}, rgb[0]);
  }
  for (size_t i = 0; s == YLM_OK && i < x->n; i++)
    if (tables && is_glossy(x, i))
      x->radiance[k][i] = ylm_luminance((double[]){rgb[i][0], rgb[i][1], rgb[i][2]});
    else
      x->radiance[k][i] = dot(x->light + i * x->count, x->T[k] + i * x->count, x->count);
  ylm_free(rgb);
  return s;
}

/* The noise of two independent estimates: root mean square of the deviation of one of them,
   relative to the radiance plus NOISE_DARK of its mean, over points like it: matte ones, or others. */
static double trial_noise(const trial *x) {
  double mean[2] = {0}, sum = 0;
  size_t points[2] = {0}, counted = 0;
  for (size_t i = 0; i < x->n; i++)
    for (int k = 0; k < 2 && x->part[i] > 0; k++) mean[is_glossy(x, i)] += fabs(x->radiance[k][i]);
  for (size_t i = 0; i < x->n; i++) points[is_glossy(x, i)] += x->part[i] > 0;
  for (int k = 0; k < 2; k++) mean[k] /= 2 * (double)points[k];
  for (size_t i = 0; i < x->n; i++) {
    double a = x->radiance[0][i], b = x->radiance[1][i], dark = mean[is_glossy(x, i)];
    counted += x->part[i] > 0;
    if (!(x->part[i] > 0 && dark > 0)) continue;
    double relative = x->part[i] * (a - b) / (fabs(a + b) / 2 + NOISE_DARK * dark);
    sum += relative * relative / 2;
  }
  return counted ? sqrt(sum / (double)counted) : 0;
}

/* Transfer vectors of the trial's points by other random numbers than the view's, and radiance. */
static ylm_status trial_trace(const ylm_shade_view *v, const shade_tables *tables, trial *x,
                              int samples, uint64_t *rays) {
  ylm_status s = YLM_OK;
  for (int k = 0; s == YLM_OK && k < 2; k++) {
    ylm_shade_view other = *v;
    other.o.transfer_samples = samples;
    other.o.seed = ~v->o.seed - (uint64_t)k;
    other.o.progress = NULL;
    s = ylm__shade_transfer(&other, true, x->n, x->mesh, (const float(*)[3])x->normal,
                            (const float(*)[3])x->origin, NULL, x->T[k], rays);
    if (s == YLM_OK) s = trial_shade(v, tables, x, k);
  }
  return s;
}

ylm_status ylm__shade_choose_samples(ylm_shade_view *v, const shade_tables *tables,
                                     const float *share, ylm_error *e) {
  trial x = {0};
  v->stats.noise = -1;
  if (!v->o.light || v->points == 0 || v->o.visibility == YLM_SHADE_UNSHADOWED ||
      v->o.visibility == YLM_SHADE_RAYS)
    return YLM_OK;
  ylm_status s = trial_create(v, share, &x, e);
  int samples = v->o.transfer_samples;
  while (s == YLM_OK) {
    s = trial_trace(v, tables, &x, samples, &v->stats.occlusion_rays);
    v->stats.noise = trial_noise(&x);
    if (!(v->stats.noise > v->o.noise) || samples > v->o.most_samples / 2) break;
    samples *= 2;
  }
  v->o.transfer_samples = samples;
  trial_free(&x);
  return s;
}
