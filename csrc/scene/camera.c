/* camera.c - the frame of a pinhole camera. */
#include <math.h>

#include "scene.h"

ylm_status ylm_scene_frame(const ylm_scene *s, const ylm_camera *c, int width, int height,
                           ylm_camera_frame *f, ylm_error *e) {
  double up[3];
  if (!(c->fov > 0 && c->fov < 180))
    return ylm_fail(e, YLM_EINVAL, "the camera's fov must be between 0 and 180, got %g", c->fov);
  if (width < 1 || height < 1)
    return ylm_fail(e, YLM_EINVAL, "a picture has at least one pixel, got %d x %d", width, height);
  for (int a = 0; a < 3; a++) {
    if (!(fabs(c->from[a] - s->origin[a]) <= YLM_TRACE_EXTENT))
      return ylm_fail(e, YLM_EINVAL, "the camera's from must be within %g of the scene, got %g",
                      YLM_TRACE_EXTENT, c->from[a]);
    f->from[a] = c->from[a] - s->origin[a];
    f->forward[a] = c->at[a] - c->from[a];
    up[a] = c->up[a];
  }
  if (!ylm_unit3(f->forward))
    return ylm_fail(e, YLM_EINVAL, "the camera's from and at must be different points");
  if (!ylm_unit3(up)) return ylm_fail(e, YLM_EINVAL, "the camera's up must not be zero");
  ylm_cross3d(f->forward, up, f->right);
  double sine =
      sqrt(f->right[0] * f->right[0] + f->right[1] * f->right[1] + f->right[2] * f->right[2]);
  if (!(sine > 1e-9) || !ylm_unit3(f->right))
    return ylm_fail(e, YLM_EINVAL, "the camera's up must not point along its view");
  ylm_cross3d(f->right, f->forward, f->up);
  double half = tan(c->fov * (YLM_PI / 360));
  for (int a = 0; a < 3; a++) {
    f->right[a] *= half * width / height;
    f->up[a] *= half;
  }
  f->pixel = 2 * half / height;
  return YLM_OK;
}
