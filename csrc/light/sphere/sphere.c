/* sphere.c - the set of sphere lights: made from arrays, checked, read back, asked as a
 * field. */
#include "../light.h"

#include <math.h>
#include <string.h>

/* YLM_OK if all lights may be; else which one may not and why. */
static ylm_status validate(size_t n, const double *at, const double *radius, const double *radiance,
                           ylm_error *e) {
  for (size_t i = 0; i < n; i++) {
    for (int a = 0; a < 3; a++) {
      double x = at[3 * i + a], c = radiance[3 * i + a];
      if (!isfinite(x))
        return ylm_fail(e, YLM_EDOMAIN, "light %zu: its centre is not finite", i + 1);
      if (fabs(x) > YLM_LIGHT_EXTENT)
        return ylm_fail(e, YLM_ERANGE, "light %zu: its centre is beyond %g", i + 1,
                        YLM_LIGHT_EXTENT);
      if (!isfinite(c))
        return ylm_fail(e, YLM_EDOMAIN, "light %zu: its radiance is not finite", i + 1);
    }
    if (!isfinite(radius[i]) || radius[i] < 0)
      return ylm_fail(e, YLM_EDOMAIN, "light %zu: its radius must be finite and >= 0, got %g",
                      i + 1, radius[i]);
    if (radius[i] > YLM_LIGHT_EXTENT)
      return ylm_fail(e, YLM_ERANGE, "light %zu: its radius is beyond %g", i + 1, YLM_LIGHT_EXTENT);
  }
  return YLM_OK;
}

/* Fills the kernels' copies with the lights that emit. */
static void pack(ylm_lights *l) {
  size_t k = 0;
  for (size_t i = 0; i < l->n; i++) {
    if (l->radius[i] == 0) continue;
    ylm__lamp_d *d = &l->lamp_d[k];
    ylm__lamp_f *f = &l->lamp_f[k++];
    for (int a = 0; a < 3; a++) {
      d->at[a] = l->at[3 * i + a];
      d->rgb[a] = l->radiance[3 * i + a];
      f->at[a] = (float)d->at[a];
      f->rgb[a] = (float)d->rgb[a];
    }
    d->radius = l->radius[i];
    d->luminance = ylm__emission(d->rgb, 1, 0);
    f->radius = (float)d->radius;
    f->luminance = (float)d->luminance;
  }
}

static ylm_status evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                           const void *points, ylm_field_result *r, ylm_error *e) {
  return ylm_lights_evaluate(f->self, ylm_isa_current(), q, n, points, r, e);
}

ylm_status ylm_lights_create(size_t n, const double *at, const double *radius,
                             const double *radiance, ylm_lights **lights, ylm_error *e) {
  *lights = NULL;
  ylm_status s = validate(n, at, radius, radiance, e);
  if (s != YLM_OK) return s;
  ylm_lights *l = ylm_alloc_zero(1, sizeof *l);
  if (!l) return ylm_fail(e, YLM_ENOMEM, "no memory for %zu lights", n);
  l->n = n;
  for (size_t i = 0; i < n; i++) l->active += radius[i] > 0;
  l->at = ylm_alloc_copy(at, n, 3 * sizeof(double));
  l->radius = ylm_alloc_copy(radius, n, sizeof(double));
  l->radiance = ylm_alloc_copy(radiance, n, 3 * sizeof(double));
  l->lamp_f = ylm_alloc(l->active, sizeof *l->lamp_f);
  l->lamp_d = ylm_alloc(l->active, sizeof *l->lamp_d);
  if (!l->at || !l->radius || !l->radiance || !l->lamp_f || !l->lamp_d) {
    ylm_lights_free(l);
    return ylm_fail(e, YLM_ENOMEM, "no memory for %zu lights", n);
  }
  pack(l);
  l->field = (ylm_field){.self = l, .evaluate = evaluate, .crosses = ylm__crosses};
  *lights = l;
  return YLM_OK;
}

void ylm_lights_free(ylm_lights *l) {
  if (!l) return;
  ylm_free(l->at);
  ylm_free(l->radius);
  ylm_free(l->radiance);
  ylm_free(l->lamp_f);
  ylm_free(l->lamp_d);
  ylm__tree_free(l->tree);
  ylm_free(l);
}

size_t ylm_lights_count(const ylm_lights *l) { return l->n; }

void ylm_lights_arrays(const ylm_lights *l, const double **at, const double **radius,
                       const double **radiance) {
  if (at) *at = l->at;
  if (radius) *radius = l->radius;
  if (radiance) *radiance = l->radiance;
}

const ylm_field *ylm_lights_field(const ylm_lights *l) { return &l->field; }
