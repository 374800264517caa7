/* again.c - shading by a dynamic grid, again and again: only what an update changed is sampled. */
#include <stdatomic.h>
#include <string.h>

#include "view.h"

#define BLOCK 1024

struct ylm_shade_memory {
  size_t points;
  ylm_grid_interpolation how;
  uint64_t *sign;  /* [points]; 0: not shaded yet */
  float *radiance; /* [points][3] */
};

ylm_status ylm_shade_memory_create(const ylm_shade_view *v, ylm_shade_memory **memory) {
  ylm_shade_memory *m = *memory = ylm_alloc_zero(1, sizeof *m);
  if (!m) return YLM_ENOMEM;
  m->points = v->points;
  m->sign = ylm_alloc_zero(v->points, sizeof *m->sign);
  m->radiance = ylm_alloc(v->points, 3 * sizeof *m->radiance);
  if (m->sign && m->radiance) return YLM_OK;
  ylm_shade_memory_free(m);
  *memory = NULL;
  return YLM_ENOMEM;
}

void ylm_shade_memory_free(ylm_shade_memory *m) {
  if (!m) return;
  ylm_free(m->sign);
  ylm_free(m->radiance);
  ylm_free(m);
}

typedef struct again_job {
  const ylm_shade_view *view;
  const ylm_grid *grid;
  ylm_shade_memory *memory;
  ylm_grid_query query;
  ylm_shade_dot_fn *dot;
  float *out;
  atomic_uint_fast64_t outside, unbaked, fresh;
} again_job;

/* Samples and shades the n points `index` of the block at `begin`. */
static ylm_status shade_few(const again_job *j, size_t begin, size_t n, const uint16_t *index) {
  const ylm_grid_view *look = ylm_grid_look(j->grid);
  const ylm_shade_view *v = j->view;
  size_t row = (size_t)look->form.channels * (size_t)look->count;
  float *L = ylm_alloc(n * row, sizeof *L), x[BLOCK][3];
  if (!L) return YLM_ENOMEM;
  for (size_t i = 0; i < n; i++) memcpy(x[i], v->position[begin + index[i]], sizeof x[i]);
  ylm_status s = ylm_grid_sample(j->grid, &j->query, n, x, L, NULL, NULL, NULL);
  for (size_t i = 0; s == YLM_OK && i < n;) {
    size_t run = 1; /* neighbours that follow one another are shaded together */
    while (i + run < n && index[i + run] == index[i] + run) run++;
    size_t p = begin + index[i];
    ylm__shade_points(v, j->dot, p, run,
                      &(shade_light){look->form.channels, look->form.lmax, YLM_FLOAT, L + i * row},
                      j->memory->radiance + 3 * p);
    i += run;
  }
  ylm_free(L);
  return s;
}

static ylm_status run_again(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  again_job *j = context;
  ylm_shade_memory *m = j->memory;
  uint64_t sign[BLOCK];
  uint16_t index[BLOCK];
  size_t n = 0;
  ylm_grid_report r = {0};
  ylm_grid_sign(j->grid, end - begin, j->view->position[begin], sign, &r);
  for (size_t i = 0; i < end - begin; i++)
    if (sign[i] == 0 || sign[i] != m->sign[begin + i]) index[n++] = (uint16_t)i;
  ylm_status s = n ? shade_few(j, begin, n, index) : YLM_OK;
  if (s != YLM_OK) return s;
  for (size_t i = 0; i < n; i++) m->sign[begin + index[i]] = sign[index[i]];
  memcpy(j->out + 3 * begin, m->radiance + 3 * begin, 3 * (end - begin) * sizeof *j->out);
  atomic_fetch_add_explicit(&j->outside, r.outside, memory_order_relaxed);
  atomic_fetch_add_explicit(&j->unbaked, r.unbaked, memory_order_relaxed);
  atomic_fetch_add_explicit(&j->fresh, n, memory_order_relaxed);
  return YLM_OK;
}

ylm_status ylm_shade_grid_again(const ylm_shade_view *v, ylm_shade_memory *m, const ylm_grid *grid,
                                ylm_grid_interpolation how, int threads,
                                const ylm_progress *progress, float *out, ylm_grid_report *report,
                                uint64_t *fresh, ylm_error *e) {
  double start = ylm_seconds();
  ylm_grid_report none = {0};
  if (m->points != v->points) return YLM_ESHAPE;
  *fresh = v->points;
  if (!ylm_grid_sign(grid, 0, NULL, NULL, &none))
    return ylm_shade_grid(v, grid, how, threads, progress, out, report, e);
  if (m->how != how) memset(m->sign, 0, m->points * sizeof *m->sign);
  m->how = how;
  again_job j = {
      .view = v,
      .grid = grid,
      .memory = m,
      .out = out,
      .dot = ylm__shade_kernels().dot,
      .query = {.interpolation = how, .point_dtype = YLM_FLOAT, .dtype = YLM_FLOAT, .threads = 1}};
  ylm_status s = ylm_parallel(v->points, BLOCK, threads, run_again, &j, progress, "shading");
  if (report) *report = (ylm_grid_report){j.outside, j.unbaked, ylm_seconds() - start};
  *fresh = j.fresh;
  return s;
}
