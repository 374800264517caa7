/* ambient.c - openness of shading points by rays, and pictures that are darkened by it. */
#include "ambient.h"
#include "ylm_shade_over.h"

#include <math.h>

#define GRAIN 64
#define RAYS 128
#define STREAMS 0x616d6269656e74u /* random numbers that no other estimate of the view uses */

typedef struct job {
  const ylm_shade_view *view;
  float radius, *out;
} job;

/* The part of RAYS, dense as the cosine, that meets nothing within the radius. */
static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  const ylm_shade_view *v = j->view;
  for (size_t i = begin; i < end; i++) {
    ylm_trace_ray ray[RAYS];
    ylm_rng rng;
    ylm_rng_seed(&rng, v->o.seed ^ STREAMS, ylm__shade_stream(v, i));
    double shift = ylm_rng_double(&rng), turn = ylm_rng_double(&rng);
    float a[3], b[3];
    ylm_scene_basis(v->normal[i], a, b);
    for (int k = 0; k < RAYS; k++) {
      double h = fmod((double)k / RAYS + shift, 1);
      double angle = 2 * YLM_PI * (ylm_scene_radical((uint32_t)k) + turn);
      float x = (float)(sqrt(h) * cos(angle)), y = (float)(sqrt(h) * sin(angle)),
            z = (float)sqrt(1 - h);
      for (int q = 0; q < 3; q++) {
        ray[k].org[q] = v->origin[i][q];
        ray[k].dir[q] = x * a[q] + y * b[q] + z * v->normal[i][q];
      }
      ray[k].near = 0;
      ray[k].far = j->radius;
    }
    ylm_trace_occluded(ylm_scene_trace(v->scene), RAYS, ray);
    int free = 0;
    for (int k = 0; k < RAYS; k++) free += !(ray[k].far < 0);
    j->out[i] = (float)free / RAYS;
  }
  return YLM_OK;
}

ylm_status ylm_shade_ambient(const ylm_shade_view *v, ylm_shade_ambience method, double radius,
                             int threads, const ylm_progress *progress, float *out) {
  if (v->corner) return YLM_EINVAL;
  if (!(radius > 0)) return YLM_ERANGE;
  if (method == YLM_SHADE_SCREEN) return ylm__shade_ssao(v, radius, threads, out);
  job j = {v, (float)fmin(radius, 3e38), out};
  return ylm_parallel(v->points, GRAIN, threads, run, &j, progress, "ambient");
}
