/* flats.c - normals of the triangles that shading points lie on. */
#include "../calibration.h"
#include "../view.h"

void ylm_shade_view_flats(const ylm_shade_view *v, size_t first, size_t n, float (*out)[3]) {
  ylm_scene_surface surface[SHADE_FLATS];
  ylm_scene_place place[SHADE_FLATS];
  if (v->corner) {
    memcpy(out, v->normal + first, n * sizeof *out);
    return;
  }
  for (size_t i = 0; i < n; i += SHADE_FLATS) {
    size_t some = n - i < SHADE_FLATS ? n - i : SHADE_FLATS;
    for (size_t k = 0; k < some; k++) place[k] = v->entry[first + i + k].at;
    ylm_scene_surfaces(v->scene, some, place, surface);
    for (size_t k = 0; k < some; k++) memcpy(out[i + k], surface[k].flat, sizeof *out);
  }
}
