/*
** panorama.c - environments of which rays see more than coefficients, as a kind of light.
**
** The light field is that of the coefficients (environment.c); rays see an image of the whole
** sphere, or a sky of the CIE. The kind has no records: ylm_light_set_panorama makes a set of one.
** One by one, its lights are environments.
**
** Source  docs/math.md "Distant light"
*/
#include "../set.h"
#include "cie.h"
#include "environment.h"

typedef struct panorama {
  ylm__distant lights;
  ylm_light_panorama seen; /* whose texels are its own */
  double cie_scale;        /* of a sky without texels */
  float *texel;
} panorama;

static void release(void *of) {
  panorama *p = of;
  if (!p) return;
  ylm__distant_release(&p->lights);
  ylm_free(p->texel);
  ylm_free(p);
}

static ylm_status evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                           const void *points, ylm_field_result *r, ylm_error *e) {
  return ylm__environment_evaluate(f->self, true, q, n, points, r, e);
}

static void radiance(const void *of, const double d[3], double rgb[3]) {
  const ylm_light_panorama *p = &((const panorama *)of)->seen;
  if (!p->texel) {
    double scale = ((const panorama *)of)->cie_scale;
    double luminance = p->scale * ylm__light_cie_scaled(&p->cie, scale, d);
    for (int c = 0; c < 3; c++) rgb[c] += luminance;
    return;
  }
  size_t i;
  if (!ylm_mapping_pixel(p->mapping, p->up, p->width, p->height, d, &i)) return;
  for (int c = 0; c < 3; c++) rgb[c] += p->scale * (double)p->texel[3 * i + (size_t)c];
}

static void dome(const void *of, ylm_light_dome *out) {
  out->panorama = &((const panorama *)of)->seen;
}

static const ylm__light_emits emits = {.dome = dome};

const ylm__light_kind ylm__panorama_kind = {.name = "panorama",
                                            .free = release,
                                            .get = ylm__distant_get,
                                            .radiance = radiance,
                                            .emits = &emits};

ylm_status ylm_light_panorama_check(const ylm_light_panorama *p, ylm_error *e) {
  if (!p->texel) return YLM_OK;
  if (!ylm_mapping_fits(p->mapping, p->width, p->height))
    return ylm_fail(e, YLM_ESHAPE, "an image of %d x %d is not of its mapping's shape", p->width,
                    p->height);
  size_t w = (size_t)p->width, n = 3 * w * (size_t)p->height;
  for (size_t i = 0; i < n; i++) {
    if (p->texel[i] >= 0 && isfinite(p->texel[i])) continue;
    return ylm_fail(e, YLM_EDOMAIN, "pixel (%zu, %zu) is %s", i / 3 % w + 1, i / 3 / w + 1,
                    isfinite(p->texel[i]) ? "negative" : "not finite");
  }
  return YLM_OK;
}

static ylm_status fill(panorama *to, const ylm_light_panorama *p, size_t n,
                       const double *const *record, ylm_error *e) {
  to->seen = *p;
  to->cie_scale = p->texel ? 0 : ylm__light_cie_scale(&p->cie);
  if (p->texel) {
    to->seen.texel = to->texel =
        ylm_alloc_copy(p->texel, 3 * (size_t)p->width * (size_t)p->height, sizeof *to->texel);
    if (!to->texel) return YLM_ENOMEM;
  }
  ylm_status s = ylm__environment_copy(&to->lights, n, record, e);
  to->lights.field.evaluate = evaluate;
  return s;
}

ylm_status ylm_light_set_panorama(const ylm_light_panorama *p, size_t n,
                                  const double *const *record, ylm_light_set **set, ylm_error *e) {
  *set = NULL;
  ylm_status s = ylm_light_panorama_check(p, e);
  if (s != YLM_OK) return s;
  panorama *to = ylm_alloc_zero(1, sizeof *to);
  s = to ? fill(to, p, n, record, e) : YLM_ENOMEM;
  if (s == YLM_OK) {
    ylm__light_pack made = {&ylm__panorama_kind, to, &to->lights.field, n, 0};
    return ylm__light_set_of_pack(&made, set, e);
  }
  release(to);
  return s == YLM_ENOMEM ? ylm_no_memory(e) : s;
}
