/* sphere.c - sphere lights: made from arrays, checked, asked as a field. */
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

/* Light i in double, and in float as its double is rounded. */
static ylm__lamp_d lamp_of(const double *at, const double *radius, const double *radiance,
                           size_t i) {
  ylm__lamp_d d = {.radius = radius[i]};
  for (size_t a = 0; a < 3; a++) d.at[a] = at[3 * i + a], d.rgb[a] = radiance[3 * i + a];
  d.luminance = ylm__emission(d.rgb, 1, 0);
  return d;
}

static ylm__lamp_f rounded(const ylm__lamp_d *d) {
  ylm__lamp_f f = {.radius = (float)d->radius, .luminance = (float)d->luminance};
  for (int a = 0; a < 3; a++) f.at[a] = (float)d->at[a], f.rgb[a] = (float)d->rgb[a];
  return f;
}

/* The origin of the lights that emit. */
static void find_origin(ylm_lights *l, const double *at, const double *radius) {
  double box[6] = {INFINITY, INFINITY, INFINITY, -INFINITY, -INFINITY, -INFINITY};
  for (size_t i = 0; i < 3 * l->n; i++) {
    if (radius[i / 3] == 0) continue;
    box[i % 3] = fmin(box[i % 3], at[i] - radius[i / 3]);
    box[i % 3 + 3] = fmax(box[i % 3 + 3], at[i] + radius[i / 3]);
  }
  if (l->active) ylm_origin(box, l->origin);
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
  l->all = ylm_alloc(n, sizeof *l->all);
  find_origin(l, at, radius);
  bool moved = l->origin[0] != 0 || l->origin[1] != 0 || l->origin[2] != 0;
  l->lamp_d = l->active == n && !moved ? l->all : ylm_alloc(l->active, sizeof *l->lamp_d);
  l->lamp_f = ylm_alloc(l->active, sizeof *l->lamp_f);
  if (!l->all || !l->lamp_d || !l->lamp_f) {
    ylm_lights_free(l);
    return ylm_fail(e, YLM_ENOMEM, "no memory for %zu lights", n);
  }
  for (size_t i = 0, k = 0; i < n; i++) {
    l->all[i] = lamp_of(at, radius, radiance, i);
    if (radius[i] == 0) continue;
    l->lamp_d[k] = l->all[i];
    for (int a = 0; moved && a < 3; a++) l->lamp_d[k].at[a] -= l->origin[a];
    l->lamp_f[k] = rounded(&l->lamp_d[k]);
    k++;
  }
  l->field = (ylm_field){.self = l,
                         .evaluate = evaluate,
                         .crosses = ylm__crosses,
                         .pointwise = true,
                         .relative = true};
  *lights = l;
  return YLM_OK;
}

void ylm_lights_free(ylm_lights *l) {
  if (!l) return;
  if (l->lamp_d != l->all) ylm_free(l->lamp_d);
  ylm_free(l->all);
  ylm_free(l->lamp_f);
  ylm__tree_free(l->tree);
  ylm_free(l);
}
