/* noise.c - what a gathered field says of itself: which points are in bodies, and how exactly it knows the light. */
#include <stdlib.h>

#include "gather.h"

static ylm_status check_points(size_t n, const float (*point)[3], ylm_error *e) {
  size_t where;
  if (ylm_all_finite(YLM_FLOAT, point, 3 * n, &where)) return YLM_OK;
  return ylm_fail(e, YLM_EDOMAIN, "point %zu is not finite", where / 3 + 1);
}

/* -- validity ------------------------------------------------------------------------------------ */

typedef struct glance_job {
  const ylm_gather *g;
  const float (*point)[3];
  float *validity;
  gather_sight **sight;
} glance_job;

static ylm_status glance_range(void *context, size_t begin, size_t end, int worker) {
  const glance_job *j = context;
  gather_sight **v = &j->sight[worker];
  if (!*v) *v = ylm__gather_sight_create(j->g);
  if (!*v) return YLM_ENOMEM;
  for (size_t i = begin; i < end; i++) {
    float at[3] = {j->point[i][0], j->point[i][1], j->point[i][2]};
    ylm__gather_glance(*v, at);
    j->validity[i] = 1 - (*v)->buried;
  }
  return YLM_OK;
}

ylm_status ylm_gather_validity(const ylm_gather *g, size_t n, const float (*point)[3], int threads,
                               float *validity, ylm_error *e) {
  size_t workers = (size_t)ylm_threads(threads);
  ylm_status s = check_points(n, point, e);
  if (s != YLM_OK) return s;
  glance_job j = {g, point, validity, ylm_alloc_zero(workers, sizeof *j.sight)};
  if (!j.sight) return YLM_ENOMEM;
  s = ylm_parallel(n, 1, (int)workers, glance_range, &j, NULL, "gather");
  for (size_t i = 0; i < workers; i++) ylm__gather_sight_free(j.sight[i]);
  ylm_free(j.sight);
  return s;
}

size_t ylm_gather_directions(const ylm_gather *g, const float point[3], size_t room,
                             float (*direction)[3]) {
  gather_sight *v = ylm__gather_sight_create(g);
  size_t cells = 0;
  if (v && ylm__gather_look(v, point) == YLM_OK) cells = v->cells;
  for (size_t i = 0; i < cells && i < room; i++)
    memcpy(direction[i], i < g->lattice.cells ? g->lattice.direction[i] : v->toward[i], 12);
  ylm__gather_sight_free(v);
  return cells;
}

/* -- noise --------------------------------------------------------------------------------------- */

static int compare(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Values of a field and which points are in bodies. */
static ylm_status values(const ylm_gather *g, size_t n, const float (*point)[3], int lmax,
                         int threads, const ylm_progress *progress, float *value, uint8_t *inside,
                         ylm_error *e) {
  ylm_field_query q = {.lmax = lmax,
                       .channels = 3,
                       .want = YLM_WANT_VALUE,
                       .dtype = YLM_FLOAT,
                       .threads = threads,
                       .progress = progress,
                       .origin = ylm_scene_origin(g->scene)};
  ylm_field_result r = {.value = value, .inside = inside};
  return g->field.evaluate(&g->field, &q, n, point, &r, e);
}

/* The distance of two rows; of a row and zeros, where b is NULL. */
static double distance(size_t width, const float *a, const float *b) {
  double d = 0;
  for (size_t k = 0; k < width; k++) {
    double x = (double)a[k] - (b ? (double)b[k] : 0);
    d += x * x;
  }
  return sqrt(d);
}

/* The mean norm of the rows of points that are not in bodies. */
static double mean_norm(size_t n, size_t width, const float *row, const uint8_t *inside) {
  double sum = 0;
  size_t valid = 0;
  for (size_t i = 0; i < n; i++) {
    if (inside[i]) continue;
    sum += distance(width, row + i * width, NULL);
    valid++;
  }
  return valid ? sum / (double)valid : 0;
}

ylm_status ylm_gather_noise(const ylm_gather *g, size_t n, const float (*point)[3], int lmax,
                            int threads, const ylm_progress *progress, double *quantile,
                            ylm_error *e) {
  size_t width = 3 * ylm_sh_count(lmax), valid = 0;
  ylm_gather *finer = NULL;
  float *value = ylm_alloc(2 * n * width, sizeof *value);
  double *error = ylm_alloc(n, sizeof *error);
  uint8_t *inside = ylm_alloc_zero(n, 1);
  *quantile = 0;
  ylm_status s = value && error && inside ? check_points(n, point, e) : YLM_ENOMEM;
  if (s == YLM_OK) s = ylm__gather_finer(g, &finer);
  if (s == YLM_OK) s = values(g, n, point, lmax, threads, progress, value, inside, e);
  if (s == YLM_OK)
    s = values(finer, n, point, lmax, threads, progress, value + n * width, inside, e);
  double mean = s == YLM_OK ? mean_norm(n, width, value + n * width, inside) : 0;
  for (size_t i = 0; s == YLM_OK && i < n; i++) {
    const float *a = value + i * width, *b = value + (n + i) * width;
    double scale = fmax(distance(width, b, NULL), mean);
    if (!inside[i]) error[valid++] = scale > 0 ? distance(width, a, b) / scale : 0;
  }
  if (s == YLM_OK && valid) {
    qsort(error, valid, sizeof *error, compare);
    *quantile = error[(size_t)ceil(0.95 * (double)valid) - 1];
  }
  ylm_gather_free(finer);
  ylm_free(value);
  ylm_free(error);
  ylm_free(inside);
  return s;
}
