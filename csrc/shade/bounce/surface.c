/* surface.c - irradiance that a surface grid holds at the shading points of a view. */
#include "../calibration.h"
#include "../view.h"
#include "ylm_shade_bounce.h"

ylm_status ylm_shade_surfaces(const ylm_shade_view *v, const ylm_surface_grid *g, int threads,
                              float (*irradiance)[3], uint32_t *rectangle, ylm_error *e) {
  if (v->corner)
    return ylm_fail(e, YLM_EINVAL,
                    "the view's points are vertices: light on surfaces is for pixels");
  ylm_scene_place *place = ylm_alloc(v->points, sizeof *place);
  if (!place) return YLM_ENOMEM;
  for (size_t i = 0; i < v->points; i++) place[i] = v->entry[i].at;
  ylm_surface_irradiance(g, v->points, place, irradiance, rectangle, threads);
  ylm_free(place);
  return YLM_OK;
}
