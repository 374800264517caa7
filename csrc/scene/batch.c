/* batch.c - rays of several places to the lamps, traced in one go. */
#include "scene.h"

ylm_status ylm_scene_batch_create(const ylm_scene *scene, size_t light_samples,
                                  ylm_scene_batch *b) {
  size_t room = light_samples > YLM_SCENE_BATCH ? light_samples : YLM_SCENE_BATCH;
  *b = (ylm_scene_batch){.lamps = ylm_scene_chooser_create(scene),
                         .ray = ylm_alloc(room, sizeof *b->ray),
                         .value = ylm_alloc(room, sizeof *b->value),
                         .room = room};
  return b->lamps && b->ray && b->value ? YLM_OK : YLM_ENOMEM;
}

void ylm_scene_batch_free(ylm_scene_batch *b) {
  ylm_scene_chooser_free(b->lamps);
  ylm_free(b->ray);
  ylm_free(b->value);
}

void ylm_scene_batch_aim(ylm_scene_batch *b, const float x[3], const float n[3],
                         const float origin[3], int light_samples, ylm_rng *rng) {
  b->rays += ylm_scene_aim(b->lamps, x, n, origin, light_samples, rng, b->ray + b->rays,
                           b->value + b->rays);
}

void ylm_scene_batch_trace(ylm_scene_batch *b) {
  ylm_trace_occluded(ylm_scene_trace(b->lamps->scene), b->rays, b->ray);
  b->traced += b->rays;
}
