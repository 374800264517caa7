/* receivers.c - places in space or on surfaces that elements light. */
#include <math.h>

#include "../calibration.h"
#include "adjoint.h"

ylm_status ylm_receivers_create(const ylm_transfer *t, size_t n, const float (*point)[3],
                                const float (*normal)[3], int links, uint64_t seed, int threads,
                                const ylm_progress *progress, ylm_receivers **out, ylm_error *e) {
  *out = NULL;
  ylm_status s = ylm__transfer_check_links(links, e);
  ylm_receivers *r = s == YLM_OK ? ylm_alloc_zero(1, sizeof *r) : NULL;
  if (!r) return s == YLM_OK ? YLM_ENOMEM : s;
  *r = (ylm_receivers){.t = t, .n = n, .links = links};
  r->point = ylm_alloc_copy(point, n, sizeof *r->point);
  r->normal = ylm_alloc_copy(normal, n, sizeof *r->normal);
  r->link = ylm_transfer_room(t, n * (size_t)links);
  r->share = ylm_alloc(n, sizeof *r->share);
  s = r->point && r->normal && !ylm_links_are_none(r->link) && r->share ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) s = ylm__transfer_check_places(n, "receiver", point, normal, e);
  for (size_t i = 0; s == YLM_OK && i < n; i++)
    ylm_scene_ray_origin(t->scene, point[i], normal[i], r->point[i]);
  if (s == YLM_OK)
    s = ylm__transfer_find_shares(t, n, (const float(*)[3])r->point, (const float(*)[3])r->normal,
                                  NULL, links, seed, threads, progress, r->link, -1, NULL, r->share,
                                  NULL);
  if (s == YLM_OK)
    *out = r;
  else
    ylm_receivers_free(r);
  return s;
}

void ylm_receivers_free(ylm_receivers *r) {
  if (!r) return;
  ylm_free(r->point);
  ylm_free(r->normal);
  ylm_links_free(r->link);
  ylm_free(r->share);
  ylm_free(r);
}

const ylm_transfer *ylm_receivers_transfer(const ylm_receivers *r) { return r->t; }
size_t ylm_receivers_count(const ylm_receivers *r) { return r->n; }
int ylm_receivers_links(const ylm_receivers *r) { return r->links; }
const float *ylm_receivers_share(const ylm_receivers *r) { return r->share; }

ylm_status ylm_receivers_indirect(const ylm_receivers *r, const ylm_radiosity *lit, int threads,
                                  float (*out)[3], ylm_error *e) {
  if (lit->t != r->t)
    return ylm_fail(e, YLM_EINVAL, "the receivers and the radiosity are of different links");
  float(*sum)[4] = ylm_alloc(r->n, sizeof *sum);
  if (!sum) return YLM_ENOMEM;
  ylm_transfer_sum(r->n, r->links, r->link, 4, lit->leaving, NULL, sum[0], threads);
  for (size_t i = 0; i < r->n; i++)
    for (int c = 0; c < 3; c++) out[i][c] = (float)YLM_PI * sum[i][c];
  ylm_free(sum);
  return YLM_OK;
}

void ylm_receivers_scatter(const ylm_receivers *r, const double (*weight)[3], double (*out)[3]) {
  size_t links = (size_t)r->links, elements = r->t->elements;
  memset(out, 0, elements * sizeof *out);
  for (size_t i = 0; i < r->n; i++)
    for (size_t k = 0; k < links; k++) {
      size_t to = ylm_links_at(r->link, i * links + k);
      for (int c = 0; to < elements && c < 3; c++) out[to][c] += weight[i][c] / r->links;
    }
}

typedef struct job {
  const ylm_receivers *r;
  const ylm_scene *scene;
  int light_samples;
  uint64_t seed;
  float (*out)[3];
} job;

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  ylm_scene_batch b;
  ylm_status s = ylm_scene_batch_create(j->scene, (size_t)j->light_samples, &b);
  for (size_t i = begin; i < end && s == YLM_OK; i++) {
    ylm_rng rng;
    double E[3] = {0, 0, 0};
    const float *x = j->r->point[i];
    ylm_rng_seed(&rng, j->seed, i);
    ylm_scene_batch_aim(&b, x, j->r->normal[i], x, j->light_samples, &rng);
    ylm_scene_batch_trace(&b);
    for (size_t k = 0; k < b.rays; k++)
      for (int c = 0; c < 3; c++)
        if (!(b.ray[k].far < 0)) E[c] += (double)b.value[k][c];
    b.rays = 0;
    for (int c = 0; c < 3; c++) j->out[i][c] = (float)E[c];
  }
  ylm_scene_batch_free(&b);
  return s;
}

ylm_status ylm_receivers_rays(const ylm_receivers *r, const ylm_scene *scene, int light_samples,
                              uint64_t seed, int threads, const ylm_progress *progress,
                              float (*out)[3], ylm_error *e) {
  ylm_status s = ylm__transfer_check_rays(r->t, scene, light_samples, e);
  job j = {r, scene, light_samples, seed, out};
  return s == YLM_OK ? ylm_parallel(r->n, DIRECT_GRAIN, threads, run, &j, progress, "direct") : s;
}
