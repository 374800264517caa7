/*
** bias.c - looking a grid up beside surfaces, where its light jumps at them.
**
** A voxel of edges h is h_x |n_x| + h_y |n_y| + h_z |n_z| thick along n. So far from a plane with
** normal n, a voxel lies on one side of it. The value is carried back to the surface by the
** interpolant's gradient.
*/
#include "../grid.h"

#include <math.h>
#include <string.h>

#define LOOKS 4 /* at larger and larger leaves */

typedef struct bias_job {
  const ylm_grid *g;
  double factor;
  const float (*points)[3], (*normals)[3];
  const float *limit;
  float *b;
} bias_job;

/* The thickness along n of the octree's leaf at p. */
static double thickness(const ylm_grid *g, const double p[3], const float n[3]) {
  bool uniform = g->contents.form.kind == YLM_GRID_UNIFORM;
  uint32_t edge = uniform ? 1 : ylm__grid_edge(g, &g->cell[ylm_grid_locate(g, p, false, NULL)]);
  double sum = 0;
  for (int a = 0; a < 3; a++) sum += (double)edge / g->scale[a] * fabs((double)n[a]);
  return sum;
}

double ylm__grid_bias_at(const ylm_grid *g, double factor, const float x[3], const float n[3]) {
  double p[3] = {x[0], x[1], x[2]}, q[3], b = factor * thickness(g, p, n);
  for (int look = 0; look < LOOKS; look++) {
    for (int a = 0; a < 3; a++) q[a] = p[a] + b * (double)n[a];
    double further = factor * thickness(g, q, n);
    if (!(further > b)) break;
    b = further;
  }
  return b;
}

static ylm_status find_distances(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const bias_job *j = context;
  for (size_t i = begin; i < end; i++) {
    j->b[i] = (float)ylm__grid_bias_at(j->g, j->factor, j->points[i], j->normals[i]);
    if (j->limit && j->limit[i] < j->b[i]) j->b[i] = j->limit[i];
  }
  return YLM_OK;
}

void ylm_grid_bias(const ylm_grid *g, double factor, size_t n, const float (*points)[3],
                   const float (*normals)[3], const float *limit, float *b, int threads) {
  bias_job j = {g, factor, points, normals, limit, b};
  if (factor > 0)
    ylm_parallel(n, 1024, threads, find_distances, &j, NULL, NULL);
  else
    ylm_zero(b, n * sizeof *b);
}

ylm_status ylm_grid_sample_biased(const ylm_grid *g, const ylm_grid_query *q, size_t n,
                                  const float (*points)[3], const float (*normals)[3],
                                  const float *b, float *value, ylm_grid_report *report,
                                  ylm_error *e) {
  size_t w = g->width;
  ylm_grid_query own = *q;
  float(*place)[3] = ylm_alloc(n, sizeof *place);
  float *gradient = ylm_alloc(n, 3 * w * sizeof *gradient);
  ylm_status s = place && gradient ? YLM_OK : YLM_ENOMEM;
  own.point_dtype = own.dtype = YLM_FLOAT;
  for (size_t i = 0; s == YLM_OK && i < n; i++)
    for (int a = 0; a < 3; a++) place[i][a] = points[i][a] + b[i] * normals[i][a];
  if (s == YLM_OK) s = ylm_grid_sample(g, &own, n, place, value, gradient, report, e);
  for (size_t i = 0; s == YLM_OK && i < n; i++) {
    float d[3];
    for (int a = 0; a < 3; a++) d[a] = points[i][a] - place[i][a];
    for (size_t k = 0; b[i] > 0 && k < w; k++)
      value[i * w + k] = carried(value[i * w + k], d, gradient + 3 * (i * w + k));
  }
  ylm_free(place);
  ylm_free(gradient);
  return s == YLM_ENOMEM ? ylm_fail(e, s, "no memory to sample %zu points", n) : s;
}
