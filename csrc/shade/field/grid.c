/* grid.c - radiance of shading points under a grid, and the grid's cells they lie in. */
#include <math.h>
#include <stdatomic.h>

#include "../calibration.h"
#include "../gloss/gloss.h"
#include "ylm_transfer.h"

typedef struct grid_job {
  const ylm_shade_view *view;
  const ylm_grid *grid;
  const ylm_grid_contents *look;
  ylm_grid_query query;
  shade_rows rows;
  ylm_shade_dot_fn *dot;
  float *out, *level, *error;
  const double *window; /* [lmax+1] */
  atomic_uint_fast64_t outside, unbaked;
} grid_job;

/* Multiplies degree l of n rows of coefficients by window[l]. */
static void damp(const double *window, int lmax, size_t n, float *L) {
  for (size_t i = 0; i < n; i++)
    for (int l = 0; l <= lmax; l++)
      for (int m = -l; m <= l; m++) *L++ *= (float)window[l];
}

/* Coefficients of points begin .. begin+n-1 to L; in a grid with sides by what the points see. */
static ylm_status sample(const grid_job *j, size_t begin, size_t n, float *L, ylm_grid_report *r) {
  const ylm_shade_view *v = j->view;
  ylm_grid_walls walls = {.share = ylm_walls_share, .self = v->scene};
  ylm_grid_query q = j->query;
  float(*flat)[3] = NULL;
  if (j->look->form.sides) {
    if (v->world) memcpy(walls.origin, v->world, sizeof walls.origin);
    flat = ylm_alloc(n, sizeof *flat);
    if (!flat) return YLM_ENOMEM;
    ylm_shade_view_flats(v, begin, n, flat);
    q.normals = (const float(*)[3])flat;
    q.walls = &walls;
  }
  ylm_status s = ylm_grid_sample(j->grid, &q, n, v->position[begin], L, NULL, r, NULL);
  ylm_free(flat);
  return s;
}

static ylm_status run_grid(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  grid_job *j = context;
  const ylm_grid_form *form = &j->look->form;
  size_t n = end - begin;
  ylm_grid_report r = {0};
  float *L = ylm_alloc(n * (size_t)form->channels * (size_t)j->look->count, sizeof *L);
  ylm_status s = L ? YLM_OK : YLM_ENOMEM;
  double start = ylm_seconds();
  if (s == YLM_OK) s = sample(j, begin, n, L, &r);
  if (s == YLM_OK && j->window) damp(j->window, form->lmax, n * (size_t)form->channels, L);
  ylm__shade_clock(j->view, SHADE_LIGHT, start);
  if (s == YLM_OK)
    s = ylm__shade_points(j->view, j->dot, &j->rows, begin, n,
                          &(shade_light){form->channels, form->lmax, YLM_FLOAT, L},
                          j->out + 3 * begin);
  atomic_fetch_add_explicit(&j->outside, r.outside, memory_order_relaxed);
  atomic_fetch_add_explicit(&j->unbaked, r.unbaked, memory_order_relaxed);
  ylm_free(L);
  return s;
}

ylm_status ylm_shade_grid(const ylm_shade_view *v, const ylm_grid *grid, ylm_shade_weight weight,
                          ylm_grid_interpolation interpolation, const double *window, int threads,
                          const ylm_progress *progress, float *out, ylm_grid_report *report,
                          ylm_error *e) {
  double start = ylm_seconds();
  grid_job j = {.view = v,
                .grid = grid,
                .window = window,
                .look = ylm_grid_look(grid),
                .out = out,
                .dot = ylm__shade_kernels().dot,
                .query = {.interpolation = interpolation,
                          .point_dtype = YLM_FLOAT,
                          .dtype = YLM_FLOAT,
                          .threads = 1,
                          .origin = v->world}};
  ylm_status s = ylm__shade_rows(v, weight, j.look->form.lmax, threads, progress, &j.rows, e);
  if (s == YLM_OK)
    s = ylm_parallel(v->points, SHADE_GRID_POINTS, threads, run_grid, &j, progress, "shading");
  ylm_free(j.rows.zonal);
  if (report) *report = (ylm_grid_report){j.outside, j.unbaked, ylm_seconds() - start};
  return s;
}

static ylm_status run_cells(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const grid_job *j = context;
  for (size_t i = begin; i < end; i++) {
    double x[3];
    ylm_scene_leave(j->view->scene, j->view->position[i], x);
    uint32_t k = ylm_grid_locate(j->grid, x, false, NULL);
    const ylm_grid_cell *c = k == YLM_GRID_NONE ? NULL : &j->look->cell[k];
    j->level[i] = c ? c->level : 0;
    j->error[i] = c ? c->error : NAN;
  }
  return YLM_OK;
}

ylm_status ylm_shade_grid_cells(const ylm_shade_view *v, const ylm_grid *grid, int threads,
                                float *level, float *error) {
  grid_job j = {
      .view = v, .grid = grid, .look = ylm_grid_look(grid), .level = level, .error = error};
  return ylm_parallel(v->points, SHADE_GRAIN, threads, run_cells, &j, NULL, NULL);
}
