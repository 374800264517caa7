/* guide.c - which lamps and tiles of the sky elements see: the guide of direct light by rays, on them and at places between. */
#include "transfer.h"

/* The places of elements that have light. */
static size_t places_of(const ylm_transfer *t, const ylm_scene *scene, float (*x)[3],
                        float (*normal)[3], float (*origin)[3]) {
  size_t n = 0;
  for (size_t i = 0; i < t->elements; i++) {
    ylm_scene_place place;
    ylm_scene_surface at;
    float corner[3][2];
    if (!(t->share[i] > 0)) continue;
    ylm__transfer_corners(t, i, &place, corner);
    ylm__transfer_inside(corner, 1.0 / 3, 1.0 / 3, &place);
    ylm__transfer_hold(t, i, &place);
    ylm_scene_surfaces(scene, 1, &place, &at);
    memcpy(x[n], at.lit, sizeof at.lit);
    memcpy(normal[n], at.normal, sizeof at.normal);
    memcpy(origin[n++], at.origin, sizeof at.origin);
  }
  return n;
}

ylm_status ylm__transfer_learn(const ylm_transfer *t, const ylm_scene *scene, int light_samples,
                               uint64_t seed, int threads, const ylm_progress *progress,
                               ylm_scene_guide **out) {
  size_t all = t->elements;
  *out = NULL;
  if (!ylm_scene_guides(scene)) return YLM_OK;
  float(*room)[3] = ylm_alloc(3 * all, sizeof *room);
  if (!room) return YLM_ENOMEM;
  size_t n = places_of(t, scene, room, room + all, room + 2 * all);
  ylm_scene_places places = {n, (const float(*)[3])room, (const float(*)[3])(room + all),
                             (const float(*)[3])(room + 2 * all)};
  ylm_status s =
      ylm_scene_guide_create(scene, &places, light_samples, seed, threads, progress, out);
  ylm_free(room);
  return s;
}
