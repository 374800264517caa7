/* noise.c - how many occlusion rays a view needs: chosen by the noise that they leave. */
#include <math.h>
#include <string.h>

#include "view.h"
#include "ylm_sh.h"

/* Points at which noise is measured: a NOISE_PART-th of all within these bounds. */
#define NOISE_LEAST 128
#define NOISE_MOST 512
#define NOISE_PART 32
/* The part of the mean radiance below which darkness excuses noise. */
#define NOISE_DARK 0.1

typedef struct trial {
  size_t n, count;
  uint32_t *mesh;                                   /* [n]        */
  float (*position)[3], (*normal)[3], (*origin)[3]; /* [n]        */
  float *light;                                     /* [n][count] */
  float *T[2];                                      /* [n][count] */
} trial;

static void trial_free(trial *x) {
  ylm_free(x->mesh);
  ylm_free(x->position);
  ylm_free(x->normal);
  ylm_free(x->origin);
  ylm_free(x->light);
  ylm_free(x->T[0]);
  ylm_free(x->T[1]);
}

/* Points spread evenly over those of the view, and the luminance of the light there. */
static ylm_status trial_create(const ylm_shade_view *v, trial *x, ylm_error *e) {
  size_t n = v->points / NOISE_PART;
  if (n < NOISE_LEAST) n = NOISE_LEAST;
  if (n > NOISE_MOST) n = NOISE_MOST;
  if (n > v->points) n = v->points;
  x->n = n;
  x->count = ylm_sh_count(v->o.lmax);
  x->mesh = ylm_alloc(n, sizeof *x->mesh);
  x->position = ylm_alloc(n, sizeof *x->position);
  x->normal = ylm_alloc(n, sizeof *x->normal);
  x->origin = ylm_alloc(n, sizeof *x->origin);
  x->light = ylm_alloc(n, x->count * sizeof(float));
  for (int k = 0; k < 2; k++) x->T[k] = ylm_alloc(n, x->count * sizeof(float));
  if (!x->mesh || !x->position || !x->normal || !x->origin || !x->light || !x->T[0] || !x->T[1])
    return YLM_ENOMEM;
  for (size_t i = 0; i < n; i++) {
    size_t p = (size_t)(((double)i + 0.5) / (double)n * (double)v->points);
    x->mesh[i] = v->mesh[p];
    memcpy(x->position[i], v->position[p], 12);
    memcpy(x->normal[i], v->normal[p], 12);
    memcpy(x->origin[i], v->origin[p], 12);
  }
  ylm_field_query q = {.lmax = v->o.lmax,
                       .channels = 1,
                       .want = YLM_WANT_VALUE,
                       .metric_channels = 1,
                       .dtype = YLM_FLOAT,
                       .threads = v->o.threads};
  ylm_field_result r = {.value = x->light};
  return v->o.light->evaluate(v->o.light, &q, n, x->position, &r, e);
}

static double dot(const float *a, const float *b, size_t n) {
  double s = 0;
  for (size_t k = 0; k < n; k++) s += (double)a[k] * (double)b[k];
  return s;
}

/* The noise of two independent estimates: root mean square of the deviation of one of them,
   relative to the radiance plus NOISE_DARK of its mean. */
static double trial_noise(const trial *x) {
  double mean = 0, sum = 0;
  for (size_t i = 0; i < x->n; i++)
    for (int k = 0; k < 2; k++)
      mean += fabs(dot(x->light + i * x->count, x->T[k] + i * x->count, x->count));
  mean /= 2 * (double)x->n;
  for (size_t i = 0; mean > 0 && i < x->n; i++) {
    double a = dot(x->light + i * x->count, x->T[0] + i * x->count, x->count);
    double b = dot(x->light + i * x->count, x->T[1] + i * x->count, x->count);
    double relative = (a - b) / (fabs(a + b) / 2 + NOISE_DARK * mean);
    sum += relative * relative / 2;
  }
  return x->n ? sqrt(sum / (double)x->n) : 0;
}

/* Transfer vectors of the trial's points by other random numbers than the view's. */
static ylm_status trial_trace(const ylm_shade_view *v, trial *x, int samples, uint64_t *rays) {
  ylm_status s = YLM_OK;
  for (int k = 0; s == YLM_OK && k < 2; k++) {
    ylm_shade_view other = *v;
    other.o.transfer_samples = samples;
    other.o.seed = ~v->o.seed - (uint64_t)k;
    other.o.progress = NULL;
    s = ylm__shade_transfer(&other, true, x->n, x->mesh, (const float(*)[3])x->normal,
                            (const float(*)[3])x->origin, x->T[k], rays);
  }
  return s;
}

ylm_status ylm__shade_choose_samples(ylm_shade_view *v, ylm_error *e) {
  trial x = {0};
  v->stats.noise = -1;
  if (!v->o.light || v->points == 0 || v->o.visibility == YLM_SHADE_UNSHADOWED ||
      v->o.visibility == YLM_SHADE_RAYS)
    return YLM_OK;
  ylm_status s = trial_create(v, &x, e);
  int samples = v->o.transfer_samples;
  while (s == YLM_OK) {
    s = trial_trace(v, &x, samples, &v->stats.occlusion_rays);
    v->stats.noise = trial_noise(&x);
    if (!(v->stats.noise > v->o.noise) || samples > v->o.most_samples / 2) break;
    samples *= 2;
  }
  v->o.transfer_samples = samples;
  trial_free(&x);
  return s;
}
