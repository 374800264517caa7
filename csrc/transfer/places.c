/* places.c - where elements have light: what guides of direct light are learnt from, and groups of neighbours. */
#include "transfer.h"

ylm_status ylm__transfer_places(const ylm_transfer *t, const ylm_scene *scene, transfer_places *p) {
  float(*room)[3] = ylm_alloc(3 * t->elements, sizeof *room);
  *p = (transfer_places){.room = room, .element = ylm_alloc(t->elements, sizeof *p->element)};
  if (!room || !p->element) return YLM_ENOMEM;
  float(*x)[3] = room, (*normal)[3] = room + t->elements, (*origin)[3] = normal + t->elements;
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
    memcpy(origin[n], at.origin, sizeof at.origin);
    p->element[n++] = (uint32_t)i;
  }
  p->of = (ylm_scene_places){n, (const float(*)[3])x, (const float(*)[3])normal,
                             (const float(*)[3])origin};
  return YLM_OK;
}

void ylm__transfer_places_free(transfer_places *p) {
  ylm_free(p->room);
  ylm_free(p->element);
}
