/* reach.c - where a scene's surfaces are, as bakes and look-ups of grids with sides ask. */
#include <math.h>

#include "transfer.h"

struct ylm_walls {
  const ylm_scene *scene;
  const ylm_transfer *transfer; /* NULL: all sides are used */
  struct transfer_boxes *boxes;
  double origin[3];
};

/* Rays that are traced at once. */
#define WAYS 64

void ylm_walls_share(const void *scene, size_t n, const float (*a)[3], const float (*b)[3],
                     float *share) {
  ylm_trace_ray ray[WAYS];
  ylm_trace_hit hit[WAYS];
  for (size_t first = 0; first < n; first += WAYS) {
    size_t some = n - first < WAYS ? n - first : WAYS;
    for (size_t i = 0; i < some; i++) {
      ray[i].near = 0;
      ray[i].far = 1;
      for (int k = 0; k < 3; k++) {
        ray[i].org[k] = a[first + i][k];
        ray[i].dir[k] = b[first + i][k] - a[first + i][k];
      }
    }
    ylm_trace_nearest(ylm_scene_trace(scene), some, ray, false, hit);
    for (size_t i = 0; i < some; i++)
      share[first + i] = hit[i].mesh == YLM_TRACE_NOTHING ? 1 : fminf(hit[i].t, 0.99999994f);
  }
}

static void share(const void *self, size_t n, const float (*a)[3], const float (*b)[3],
                  float *out) {
  ylm_walls_share(((const ylm_walls *)self)->scene, n, a, b, out);
}

static bool meets(const void *self, const double box[6]) {
  return ylm__boxes_meet(((const ylm_walls *)self)->boxes, box);
}

/* Of rays from x in directions evenly spread: the part that ends at sides that are not used, of those that end at surfaces. */
static double buried(const void *self, const float x[3], double *open) {
  const ylm_walls *w = self;
  ylm_trace_ray ray[WAYS];
  ylm_trace_hit hit[WAYS];
  uint32_t element[WAYS];
  size_t found = 0, met = 0;
  for (int i = 0; i < WAYS; i++) {
    double d[3];
    ylm_spiral(i, WAYS, d);
    ray[i].near = 0;
    ray[i].far = INFINITY;
    for (int a = 0; a < 3; a++) {
      ray[i].org[a] = x[a];
      ray[i].dir[a] = (float)d[a];
    }
  }
  ylm_trace_nearest(ylm_scene_trace(w->scene), WAYS, ray, false, hit);
  ylm_transfer_hits(w->transfer, WAYS, ray, hit, element);
  for (int i = 0; i < WAYS; i++) {
    found += element[i] == YLM_TRANSFER_BURIED(w->transfer);
    met += hit[i].mesh != YLM_TRACE_NOTHING;
  }
  *open = 1 - (double)met / WAYS;
  return met ? (double)found / (double)met : 0;
}

ylm_status ylm_walls_create(const ylm_scene *scene, const ylm_transfer *transfer, ylm_walls **out) {
  ylm_walls *w = *out = ylm_alloc_zero(1, sizeof *w);
  if (!w) return YLM_ENOMEM;
  const double *origin = ylm_scene_origin(scene);
  for (int a = 0; origin && a < 3; a++) w->origin[a] = origin[a];
  w->scene = scene;
  w->transfer = transfer;
  ylm_status s = ylm__boxes_create(scene, &w->boxes);
  if (s == YLM_OK) return s;
  ylm_walls_free(w);
  *out = NULL;
  return s;
}

void ylm_walls_free(ylm_walls *w) {
  if (!w) return;
  ylm__boxes_free(w->boxes);
  ylm_free(w);
}

ylm_grid_walls ylm_walls_look(const ylm_walls *w) {
  return (ylm_grid_walls){.share = share,
                          .meets = meets,
                          .buried = w->transfer ? buried : NULL,
                          .self = w,
                          .origin = {w->origin[0], w->origin[1], w->origin[2]}};
}
