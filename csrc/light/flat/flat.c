/* flat.c - flat lights as data and as a light field. */
#include <math.h>
#include <string.h>

#include "../finite.h"
#include "kernel.h"
#include "merged.h"
#include "ylm_sh.h"
#include "ylm_vector.h"

void ylm_polygons_free(ylm_polygons *p) {
  if (!p) return;
  ylm_free(p->sides);
  ylm_free(p->first);
  ylm_free(p->vertices);
  ylm_free(p->radiance);
  ylm_free(p->normal);
  ylm_free(p->centroid);
  ylm_free(p->radius);
  ylm_free(p->reach);
  ylm_free(p->edge);
  ylm_free(p);
}

/* One of unit radiance by the reference. */
static ylm_status one_light(const ylm__contour *k, const ylm_polygons *p, size_t i,
                            const double *x) {
  const double *from = p->vertices + 3 * p->first[i], *up = p->clipped ? p->horizon : NULL;
  double v[YLM_POLYGON_VERTICES][3];
  int sides = p->sides[i];
  memcpy(v, from, ylm__polygon_rows(sides) * sizeof v[0]);
  for (int r = 0; r < (sides ? sides : 1); r++)
    for (int a = 0; a < 3; a++) v[r][a] -= x[a];
  const double(*rows)[3] = (const double(*)[3])v;
  return sides ? ylm__contour_polygon(k, sides, rows, p->normal + 3 * i, up)
               : ylm__contour_ellipse(k, rows, p->normal + 3 * i, up);
}

ylm_status ylm__polygon_add(const ylm_polygons *p, const ylm__contour *k, size_t light,
                            const double *x, double *sum, uint8_t *inside) {
  size_t wide = (k->hessian ? 10 : k->gradient ? 4 : 1) * k->count;
  ylm_status s = one_light(k, p, light, x);
  if (s == YLM_EDOMAIN) *inside = 1, s = YLM_OK;
  for (size_t c = 0; c < 3; c++)
    for (size_t t = 0; t < wide; t++) sum[c * wide + t] += p->radiance[3 * light + c] * k->value[t];
  return s;
}

ylm_status ylm__polygon_exactly(const ylm_polygons *p, const ylm__flat_plan *plan,
                                const ylm_field_query *q, size_t n, const double (*x)[3],
                                double *sum, uint8_t *inside) {
  size_t count = ylm_sh_count(q->lmax), wide = ylm__flat_wide(q);
  bool h = wide == 10 * count, g = wide > count;
  ylm__flat_range *kernel = plan ? plan->range : NULL;
  ylm__contour k;
  double *one = ylm_alloc_zero(wide, sizeof *one);
  ylm_status s = ylm__contour_make(&k, q->lmax);
  if (!one) s = YLM_ENOMEM;
  k.value = one;
  k.gradient = g && one ? one + count : NULL;
  k.hessian = h && one ? one + 4 * count : NULL;
  if (s == YLM_OK && kernel) s = kernel(plan, &k, n, x, sum, inside);
  for (size_t i = 0; i < n && s == YLM_OK && !kernel; i++)
    for (size_t l = 0; l < p->n && s == YLM_OK; l++)
      s = ylm__polygon_add(p, &k, l, x[i], sum + 3 * i * wide, inside + i);
  ylm_free(k.y);
  ylm_free(one);
  return s;
}

/* -- the field ------------------------------------------------------------------------------ */

typedef struct job {
  const ylm_polygons *p;
  const ylm__flat_plan *plan; /* NULL: by the reference */
  ylm__merged merged;         /* of lights that are approximated */
  const ylm_field_query *q;
  const void *points;
  ylm_field_result *r;
} job;

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  const ylm_field_query *q = j->q;
  size_t wide = j->p->exact ? ylm__flat_wide(q) : 10 * ylm_sh_count(q->lmax), n = end - begin;
  double *sum = ylm_alloc_zero(n * 3 * wide, sizeof *sum), x[YLM__POLYGON_BLOCK][3];
  uint8_t inside[YLM__POLYGON_BLOCK] = {0};
  if (!sum) return YLM_ENOMEM;
  for (size_t i = 0; i < 3 * n; i++) {
    x[i / 3][i % 3] = ylm_get(q->dtype, j->points, 3 * begin + i);
    if (q->origin) x[i / 3][i % 3] += q->origin[i % 3];
  }
  const double(*at)[3] = (const double(*)[3])x;
  ylm_status s = j->p->exact        ? ylm__polygon_exactly(j->p, j->plan, q, n, at, sum, inside)
                 : j->merged.kernel ? ylm__polygon_merged(j->p, &j->merged, q, n, at, sum, inside)
                                    : ylm__polygon_spheres(j->p, q, n, at, sum, inside);
  for (size_t i = 0; i < n && s == YLM_OK; i++) {
    ylm__field_write(q, begin + i, 3, sum + 3 * i * wide, wide, j->r);
    if (j->r->inside) j->r->inside[begin + i] = inside[i];
  }
  ylm_free(sum);
  return s;
}

ylm_status ylm_polygons_evaluate(const ylm_polygons *p, ylm_isa isa, const ylm_field_query *q,
                                 size_t n, const void *points, ylm_field_result *r, ylm_error *e) {
  if (!ylm_isa_available(isa))
    return ylm_fail(e, YLM_EINVAL, "no kernels for '%s' here", ylm_isa_name(isa));
  ylm_status s = ylm_field_check(q, n, points, r, p->exact ? YLM_LIGHT_RIM_LMAX : YLM_LIGHT_LMAX,
                                 "these lights", e);
  if (s != YLM_OK) return s;
  ylm__flat_plan plan = {0};
  job j = {.p = p, .q = q, .points = points, .r = r};
  if (p->exact && !p->clipped && ylm__flat_kernel(isa)) {
    s = ylm__flat_plan_make(&plan, p, q, isa);
    j.plan = &plan;
  }
  if (!p->exact) s = ylm__merged_make(&j.merged, p, q, isa);
  size_t grain = n < 512 ? 8 : q->lmax <= 10 ? YLM__POLYGON_BLOCK : 64;
  if (s == YLM_OK) s = ylm_parallel(n, grain, q->threads, run, &j, q->progress, "polygons");
  ylm__flat_plan_free(&plan);
  ylm__merged_free(&j.merged);
  if (s != YLM_OK) return ylm_fail_plain(e, s);
  r->pairs += (uint64_t)n * p->n;
  return ylm_light_finite(q, n, points, r, e);
}

static ylm_status evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                           const void *points, ylm_field_result *r, ylm_error *e) {
  return ylm_polygons_evaluate(f->self, ylm_isa_current(), q, n, points, r, e);
}

/* -- making them ---------------------------------------------------------------------------- */

static ylm_status allocate(ylm_polygons *p, size_t n, size_t rows) {
  p->n = n;
  p->sides = ylm_alloc(n, sizeof *p->sides);
  p->first = ylm_alloc(n, sizeof *p->first);
  p->vertices = ylm_alloc(rows, 3 * sizeof(double));
  p->radiance = ylm_alloc(n, 3 * sizeof(double));
  p->normal = ylm_alloc(n, 3 * sizeof(double));
  p->centroid = ylm_alloc(n, 3 * sizeof(double));
  p->radius = ylm_alloc(n, sizeof(double));
  p->reach = ylm_alloc(n, sizeof(double));
  return p->sides && p->first && p->vertices && p->radiance && p->normal && p->centroid &&
                 p->radius && p->reach
             ? YLM_OK
             : YLM_ENOMEM;
}

static ylm_status set_horizon(ylm_polygons *p, const double *horizon, ylm_error *e) {
  if (!horizon || (horizon[0] == 0 && horizon[1] == 0 && horizon[2] == 0)) return YLM_OK;
  memcpy(p->horizon, horizon, sizeof p->horizon);
  if (!ylm_unit3(p->horizon))
    return ylm_fail(e, YLM_EDOMAIN, "the horizon's direction is not finite");
  if (!p->exact) return ylm_fail(e, YLM_EINVAL, "only exact polygons are cut at a horizon");
  p->clipped = true;
  return YLM_OK;
}

/* Polygon i from its rows, which begin at `at`. */
static ylm_status set_light(ylm_polygons *p, size_t i, size_t at, int sides, const double *rows,
                            const double *radiance, ylm_error *e) {
  p->sides[i] = sides;
  p->first[i] = at;
  memcpy(p->vertices + 3 * at, rows, ylm__polygon_rows(sides) * 3 * sizeof(double));
  ylm_status s = ylm__polygon_describe(i, sides, rows, p->normal + 3 * i, p->centroid + 3 * i,
                                       p->radius + i, p->reach + i, e);
  for (size_t c = 0; c < 3 && s == YLM_OK; c++) {
    p->radiance[3 * i + c] = radiance[c];
    if (!isfinite(radiance[c]))
      s = ylm_fail(e, YLM_EDOMAIN, "polygon %zu: its radiance is not finite", i + 1);
  }
  return s;
}

ylm_status ylm_polygons_create(size_t n, const int *sides, const double *vertices,
                               const double *radiance, bool exact, const double *horizon,
                               ylm_polygons **polygons, ylm_error *e) {
  *polygons = NULL;
  size_t total = 0, at = 0;
  for (size_t i = 0; i < n; i++) {
    if (sides[i] && (sides[i] < 3 || sides[i] > YLM_POLYGON_VERTICES))
      return ylm_fail(e, YLM_ERANGE, "polygon %zu: 3 to %d vertices expected, got %d", i + 1,
                      YLM_POLYGON_VERTICES, sides[i]);
    total += ylm__polygon_rows(sides[i]);
  }
  ylm_polygons *p = ylm_alloc_zero(1, sizeof *p);
  if (!p) return YLM_ENOMEM;
  p->field = (ylm_field){.self = p,
                         .evaluate = evaluate,
                         .crosses = ylm__polygon_crosses,
                         .pointwise = true,
                         .relative = true};
  p->exact = exact;
  ylm_status s = allocate(p, n, total);
  if (s == YLM_OK) s = set_horizon(p, horizon, e);
  for (size_t i = 0; i < n && s == YLM_OK; i++) {
    s = set_light(p, i, at, sides[i], vertices + 3 * at, radiance + 3 * i, e);
    at += ylm__polygon_rows(sides[i]);
  }
  if (s != YLM_OK) {
    ylm_polygons_free(p);
    return s;
  }
  *polygons = p;
  return YLM_OK;
}
