/* raycast.c - light from the lamps themselves, by sampling their solid angles. */
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "view.h"

#define PI 3.14159265358979323846
#define GRAIN 32

typedef struct job {
  const ylm_shade_view *view;
  int samples;
  bool shadows;
  uint64_t seed;
  size_t chunks, spheres; /* chunks of all lamps; of these, of spheres */
  ylm_shade_weights_fn *weights;
  float *out;
  atomic_uint_fast64_t rays;
} job;

typedef struct scratch {
  float *weight, *sum; /* [chunks*YLM_LAMP_CHUNK], [chunks]: spheres, then patches */
  ylm_trace_ray *ray;  /* [samples] */
  float (*value)[3];   /* [samples]: irradiance that the ray brings if nothing is hit */
} scratch;

/* A place in the list of lamps as strata walk along the sum of weights. */
typedef struct walk {
  size_t chunk, lamp;
  double passed; /* weight of all lamps before `lamp` */
} walk;

/* Moves on to the lamp that holds `target`; targets increase. */
static void walk_to(walk *w, const scratch *s, size_t chunks, double target) {
  while (w->lamp % YLM_LAMP_CHUNK == 0 && w->chunk + 1 < chunks &&
         w->passed + s->sum[w->chunk] <= target) {
    w->passed += s->sum[w->chunk++];
    w->lamp = w->chunk * YLM_LAMP_CHUNK;
  }
  while (w->passed + s->weight[w->lamp] <= target && w->lamp + 1 < chunks * YLM_LAMP_CHUNK) {
    w->passed += s->weight[w->lamp++];
    w->chunk = w->lamp / YLM_LAMP_CHUNK;
    while (w->lamp % YLM_LAMP_CHUNK == 0 && w->chunk + 1 < chunks &&
           w->passed + s->sum[w->chunk] <= target) {
      w->passed += s->sum[w->chunk++];
      w->lamp = w->chunk * YLM_LAMP_CHUNK;
    }
  }
}

/* A direction about the axis: cosine z, azimuth u. */
static void turn(const float axis[3], double z, double u, float out[3]) {
  float a[3], b[3];
  double r = sqrt(fmax(0, 1 - z * z)), c = r * cos(2 * PI * u), s = r * sin(2 * PI * u);
  ylm__shade_basis(axis, a, b);
  for (int k = 0; k < 3; k++) out[k] = (float)(c * a[k] + s * b[k] + z * axis[k]);
}

/* A ray from x to a random place of lamp i and the irradiance it brings, for radiance 1. */
static double sample_lamp(const ylm_shade_scene *s, size_t i, const float x[3], const float n[3],
                          double u0, double u1, ylm_trace_ray *ray) {
  double v[3], d2 = 0, r = s->lamp[3][i];
  for (int a = 0; a < 3; a++) {
    v[a] = (double)s->lamp[a][i] - (double)x[a];
    d2 += v[a] * v[a];
    ray->org[a] = x[a];
  }
  ray->near = 0;
  if (d2 <= r * r) { /* light from everywhere: directions as the cosine, to the lamp's far side */
    turn(n, sqrt(1 - u0), u1, ray->dir);
    double along = 0;
    for (int a = 0; a < 3; a++) along += v[a] * (double)ray->dir[a];
    ray->far = (float)(along + sqrt(fmax(0, along * along + r * r - d2)));
    return PI;
  }
  float axis[3];
  double d = sqrt(d2), s2 = r * r / d2, cap = s2 / (1 + sqrt(1 - s2));
  for (int a = 0; a < 3; a++) axis[a] = (float)(v[a] / d);
  double z = 1 - u0 * cap, side2 = d2 * fmax(0, 1 - z * z);
  turn(axis, z, u1, ray->dir);
  ray->far = (float)(d * z - sqrt(fmax(0, r * r - side2)));
  return fmax(0, (double)ylm__dot3(ray->dir, n)) * 2 * PI * cap;
}

static double wrap(double x) { return x - floor(x); }

/* Irradiance of one point. Places on lamps follow Roberts' sequence R2, shifted at random, so that
   successive rays, most of them to one lamp, spread over it; returns the number of rays that were
   traced. */
static size_t gather(const job *j, size_t i, const scratch *s, double E[3]) {
  const ylm_shade_scene *scene = j->view->scene;
  const float *x = j->view->origin[i], *n = j->view->normal[i];
  double total = 0;
  size_t rays = 0;
  ylm_rng rng;
  ylm_rng_seed(&rng, j->seed, i);
  E[0] = E[1] = E[2] = 0;
  size_t before = j->spheres * YLM_LAMP_CHUNK; /* places of spheres */
  j->weights(j->spheres, scene->lamp, scene->lamp_luminance, x, n, s->weight, s->sum);
  ylm__shade_patch_weights(scene, x, n, s->weight + before, s->sum + j->spheres);
  for (size_t b = 0; b < j->chunks; b++) total += s->sum[b];
  if (!(total > 0)) return 0;
  walk w = {0};
  double s0 = ylm_rng_double(&rng), s1 = ylm_rng_double(&rng);
  for (int k = 0; k < j->samples; k++) {
    double target = (k + ylm_rng_double(&rng)) / j->samples * total;
    double u0 = wrap(s0 + k * 0.75487766624669276), u1 = wrap(s1 + k * 0.56984029099805327);
    walk_to(&w, s, j->chunks, target);
    if (!(s->weight[w.lamp] > 0)) continue; /* padding has none */
    bool flat = w.lamp >= before;
    const float *radiance = scene->lamp_radiance + (flat ? 0 : 3 * w.lamp);
    double e = flat ? ylm__shade_patch_sample(scene, w.lamp - before, x, n, u0, u1, &s->ray[rays],
                                              &radiance)
                    : sample_lamp(scene, w.lamp, x, n, u0, u1, &s->ray[rays]);
    if (!(e > 0)) continue;
    e *= total / s->weight[w.lamp] / j->samples;
    for (int c = 0; c < 3; c++) s->value[rays][c] = (float)e * radiance[c];
    rays++;
  }
  if (j->shadows) ylm_trace_occluded(scene->trace, rays, s->ray);
  for (size_t k = 0; k < rays; k++)
    if (!j->shadows || !(s->ray[k].far < 0))
      for (int c = 0; c < 3; c++) E[c] += s->value[k][c];
  return j->shadows ? rays : 0;
}

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  job *j = context;
  size_t samples = (size_t)j->samples, rays = 0;
  scratch s = {ylm_alloc(j->chunks * YLM_LAMP_CHUNK, sizeof(float)),
               ylm_alloc(j->chunks, sizeof(float)), ylm_alloc(samples, sizeof(ylm_trace_ray)),
               ylm_alloc(samples, 12)};
  bool ok = s.weight && s.sum && s.ray && s.value;
  for (size_t i = begin; ok && i < end; i++) {
    const float *albedo = j->view->scene->mesh[j->view->mesh[i]].material.albedo;
    double E[3];
    rays += gather(j, i, &s, E);
    for (int c = 0; c < 3; c++) j->out[3 * i + (size_t)c] = (float)(E[c] / PI) * albedo[c];
  }
  ylm_free(s.weight);
  ylm_free(s.sum);
  ylm_free(s.ray);
  ylm_free(s.value);
  atomic_fetch_add_explicit(&j->rays, rays, memory_order_relaxed);
  return ok ? YLM_OK : YLM_ENOMEM;
}

ylm_status ylm_shade_raycast(const ylm_shade_view *v, int samples, bool shadows, uint64_t seed,
                             int threads, const ylm_progress *progress, float *out,
                             uint64_t *rays) {
  if (samples < 1 || samples > 65536) return YLM_ERANGE;
  size_t spheres = (v->scene->lamps + YLM_LAMP_CHUNK - 1) / YLM_LAMP_CHUNK;
  size_t patches = v->scene->triangles + v->scene->disks;
  job j = {.view = v,
           .samples = samples,
           .shadows = shadows,
           .seed = seed,
           .spheres = spheres,
           .chunks = spheres + (patches + YLM_LAMP_CHUNK - 1) / YLM_LAMP_CHUNK,
           .weights = ylm__shade_kernels().weights,
           .out = out};
  ylm_status s = ylm_parallel(v->points, GRAIN, threads, run, &j, progress, "raycast");
  if (rays) *rays = j.rays;
  return s;
}
