/* image.c - pictures: paths that begin at a camera. */
#include "path.h"

/* The ray through the path's place in its pixel. */
static void camera_ray(const path_job *j, uint64_t pixel, const path_state *p, ylm_trace_ray *ray) {
  const ylm_camera_frame *f = &j->frame;
  double x = (double)(pixel % (uint64_t)j->width) + p->pixel[0];
  double y = (double)(pixel / (uint64_t)j->width) + p->pixel[1];
  double sx = 2 * x / j->width - 1, sy = 1 - 2 * y / j->height;
  for (int a = 0; a < 3; a++) {
    ray->org[a] = (float)f->from[a];
    ray->dir[a] = (float)(f->forward[a] + sx * f->right[a] + sy * f->up[a]);
  }
  ray->near = 0;
  ray->far = INFINITY;
}

/* Light that a ray of the camera sees without any reflection. */
static void see(path_tile *t, size_t i, float radiance[3]) {
  const path_job *j = t->job;
  const ylm_trace_hit *h = &t->rays.hit[i];
  double sky[3];
  if (h->mesh == YLM_TRACE_LAMP) ylm_scene_lamp_radiance(j->scene, &t->rays.ray[i], h, radiance);
  if (h->mesh != YLM_TRACE_NOTHING) return;
  if (ylm_scene_sky_radiance(j->scene, &t->rays.ray[i], sky))
    for (int c = 0; c < 3; c++) radiance[c] = (float)sky[c];
  else
    memcpy(radiance, j->background, 12);
}

static void begin(path_tile *t) {
  size_t n = t->rays.n = t->pairs * YLM_PATH_BATCH;
  for (size_t i = 0; i < n; i++) {
    path_state *p = &t->path[i];
    camera_ray(t->job, t->item[i / YLM_PATH_BATCH], p, &t->rays.ray[i]);
    t->rays.of[i] = (uint32_t)i;
    for (int c = 0; c < 3; c++) p->throughput[c] = 1, p->radiance[c] = 0;
  }
  ylm_trace_intersect(t->job->trace, n, t->rays.ray, true, t->rays.hit);
  t->counts.nearest_rays += n;
  if (t->job->o->first > 0) return;
  for (size_t i = 0; i < n; i++) see(t, i, t->path[i].radiance);
}

ylm_status ylm_path_image(const ylm_scene *scene, const ylm_camera *camera, int width, int height,
                          const float background[3], const ylm_path_options *o, ylm_path_sum *sum,
                          ylm_path_stats *stats, ylm_error *e) {
  static const path_kind kind = {"paths", begin, ylm__path_mean};
  path_job j = {.kind = &kind,
                .scene = scene,
                .o = o,
                .values = 3,
                .batches_per_tile = 1,
                .width = width,
                .height = height,
                .background = background};
  if (width < 1 || height < 1 || width > YLM_IMAGE_MAX_SIDE || height > YLM_IMAGE_MAX_SIDE)
    return ylm_fail(e, YLM_ERANGE, "an image has 1 to %d pixels each way", YLM_IMAGE_MAX_SIDE);
  if (!ylm_all_finite(YLM_FLOAT, background, 3, NULL))
    return ylm_fail(e, YLM_ERANGE, "the background must be finite");
  j.items = (size_t)width * (size_t)height;
  ylm_status s = ylm_scene_frame(scene, camera, width, height, &j.frame, e);
  return s == YLM_OK ? ylm__path_run(&j, sum, stats, e) : s;
}
