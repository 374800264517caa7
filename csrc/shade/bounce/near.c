/* near.c - radiance of shading points under the near parts of virtual lights. */
#include <string.h>

#include "../calibration.h"
#include "../gloss/gloss.h"
#include "ylm_light_virtual.h"
#include "ylm_sh.h"
#include "ylm_shade_bounce.h"

#define SLAB 32768 /* points whose coefficients are held */

typedef struct near_job {
  const ylm_shade_view *view;
  ylm_shade_dot_fn *dot;
  shade_rows rows;
  size_t first;
  const float *L;
  float *out; /* of the slab */
} near_job;

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const near_job *j = context;
  const float *L = j->L + begin * 3 * ylm_sh_count(j->rows.lmax);
  return ylm__shade_points(j->view, j->dot, &j->rows, j->first + begin, end - begin,
                           &(shade_light){3, j->rows.lmax, YLM_FLOAT, L}, j->out + 3 * begin);
}

/* Adds radiance by coefficients, which transfer vectors and tables want. */
static ylm_status by_coefficients(const ylm_shade_view *v, const ylm_light_virtual *near,
                                  near_job *j, int threads, const ylm_progress *progress,
                                  float *radiance, uint64_t *pairs, ylm_error *e) {
  size_t wide = 3 * ylm_sh_count(j->rows.lmax), most = v->points < SLAB ? v->points : SLAB;
  float *L = ylm_alloc(most, wide * sizeof *L), *out = ylm_alloc(most, 3 * sizeof *out);
  ylm_status s = L && out ? YLM_OK : YLM_ENOMEM;
  j->L = L, j->out = out;
  for (size_t first = 0; s == YLM_OK && first < v->points; first += SLAB) {
    size_t n = v->points - first < SLAB ? v->points - first : SLAB;
    uint64_t some = 0;
    ylm_progress_part part;
    j->first = first;
    memset(L, 0, n * wide * sizeof *L);
    s = ylm_light_virtual_near_value(
        near, j->rows.lmax, n, v->position[first], threads,
        ylm_progress_part_of(&part, progress, "near lights", first, n, v->points), L, &some, e);
    if (s == YLM_OK) s = ylm_parallel(n, SHADE_LAYER_GRAIN, threads, run, j, NULL, NULL);
    for (size_t i = 0; s == YLM_OK && i < 3 * n; i++) radiance[3 * first + i] += out[i];
    *pairs += some;
  }
  ylm_free(L);
  ylm_free(out);
  return s;
}

/* Adds radiance by irradiance, of matte points. */
static ylm_status by_irradiance(const ylm_shade_view *v, const ylm_light_virtual *near, int lmax,
                                int threads, const ylm_progress *progress, float *radiance,
                                uint64_t *pairs, ylm_error *e) {
  float *out = ylm_alloc_zero(v->points, 3 * sizeof *out);
  ylm_status s = out ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK && v->points)
    s = ylm_light_virtual_near_irradiance(near, lmax, v->points, v->position[0], v->normal[0],
                                          threads, progress, out, pairs, e);
  if (s == YLM_OK) ylm__shade_reflect(v, 0, v->points, out);
  for (size_t i = 0; s == YLM_OK && i < 3 * v->points; i++) radiance[i] += out[i];
  ylm_free(out);
  return s;
}

ylm_status ylm__shade_enter(const ylm_shade_view *v, const ylm_light_virtual *lights,
                            ylm_light_virtual **own, ylm_error *e) {
  ylm_light_virtual_form form;
  *own = NULL;
  if (!v->world) return YLM_OK;
  ylm_light_virtual_get(lights, &form);
  double *at = ylm_alloc_copy(form.at, 3 * form.n, sizeof *at);
  if (!at) return YLM_ENOMEM;
  for (size_t i = 0; i < 3 * form.n; i++) at[i] -= v->world[i % 3];
  form.at = at;
  ylm_status s = ylm_light_virtual_create(&form, own, e);
  ylm_free(at);
  return s;
}

ylm_status ylm_shade_near(const ylm_shade_view *v, const ylm_light_virtual *near,
                          ylm_shade_weight weight, int lmax, int threads,
                          const ylm_progress *progress, float *radiance,
                          ylm_shade_near_report *report, ylm_error *e) {
  double begun = ylm_seconds();
  near_job j = {.view = v, .dot = ylm__shade_kernels().dot};
  uint64_t pairs = 0;
  ylm_light_virtual *own;
  ylm_status s = ylm__shade_enter(v, near, &own, e);
  if (own) near = own;
  if (s == YLM_OK) s = ylm__shade_rows(v, weight, lmax, threads, NULL, &j.rows, e);
  if (s == YLM_OK && weight == YLM_SHADE_COSINE && !j.rows.tables)
    s = by_irradiance(v, near, lmax, threads, progress, radiance, &pairs, e);
  else if (s == YLM_OK)
    s = by_coefficients(v, near, &j, threads, progress, radiance, &pairs, e);
  ylm_free(j.rows.zonal);
  ylm_light_virtual_free(own);
  if (report) *report = (ylm_shade_near_report){pairs, ylm_seconds() - begun};
  return s;
}

void ylm_shade_reflect(const ylm_shade_view *v, float *irradiance) {
  ylm__shade_reflect(v, 0, v->points, irradiance);
}
