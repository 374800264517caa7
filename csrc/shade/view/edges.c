/* edges.c - rays for points whose direct light is not that of points around: at edges of shadows, where a filter finds few points
   alike. */
#include <math.h>

#include "denoise.h"

/* The largest point of each pixel, and luminous irradiance there. */
typedef struct edge_pixel {
  uint32_t point; /* YLM_SHADE_NOWHERE: none */
  float light, all;
} edge_pixel;

typedef struct edge_job {
  const ylm_shade_view *v;
  const float *light, *all;
  edge_pixel *pixel; /* [height][width] */
  float *out;        /* [points] contrast, then rays */
  double unit, most, usual;
} edge_job;

static ylm_status fill(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const edge_job *j = context;
  const ylm_shade_view *v = j->v;
  for (size_t p = begin; p < end; p++) {
    edge_pixel *e = j->pixel + p;
    *e = (edge_pixel){.point = YLM_SHADE_NOWHERE};
    for (size_t i = v->pixel[p].first; i < v->pixel[p + 1].first; i++)
      if (e->point == YLM_SHADE_NOWHERE || v->entry[i].weight > v->entry[e->point].weight)
        e->point = (uint32_t)i;
    if (e->point == YLM_SHADE_NOWHERE) continue;
    e->light = ylm__denoise_irradiance(v, e->point, j->light);
    e->all = ylm__denoise_irradiance(v, e->point, j->all);
  }
  return YLM_OK;
}

static bool alike(const ylm_shade_view *v, size_t i, size_t k) {
  return v->mesh[i] == v->mesh[k] &&
         ylm_dot3(v->normal[i], v->normal[k]) > (float)SHADE_SAME_NORMAL;
}

/* The standard deviation of light around point i of pixel (x, y), on its surface, over the mean of all light there. */
static float contrast(const edge_job *j, int x, int y, size_t i) {
  const ylm_shade_options *o = &j->v->o;
  double n = 0, sum = 0, square = 0, all = 0;
  for (int b = y - EDGE_REACH; b <= y + EDGE_REACH; b++)
    for (int a = x - EDGE_REACH; a <= x + EDGE_REACH; a++) {
      if (a < 0 || b < 0 || a >= o->width || b >= o->height) continue;
      const edge_pixel *e = j->pixel + (size_t)b * (size_t)o->width + (size_t)a;
      if (e->point == YLM_SHADE_NOWHERE || !alike(j->v, i, e->point)) continue;
      double light = (double)e->light;
      n++, sum += light, square += light * light, all += (double)e->all;
    }
  return all > 0 ? (float)(n * sqrt(fmax(0, square / n - sum * sum / (n * n))) / all) : 0;
}

static ylm_status look(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const edge_job *j = context;
  size_t width = (size_t)j->v->o.width;
  for (size_t y = begin; y < end; y++)
    for (size_t x = 0, p = y * width; x < width; x++, p++)
      for (size_t i = j->v->pixel[p].first; i < j->v->pixel[p + 1].first; i++)
        j->out[i] = contrast(j, (int)x, (int)y, i);
  return YLM_OK;
}

static ylm_status count(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const edge_job *j = context;
  for (size_t i = begin; i < end; i++) {
    double over = (double)j->out[i] / (EDGE_CONTRAST * j->usual),
           rays = j->unit * (over * over - 1);
    j->out[i] = rays >= j->unit ? (float)floor(fmin(rays, j->most)) : 0;
  }
  return YLM_OK;
}

ylm_status ylm_shade_edge_rays(const ylm_shade_view *v, const ylm_shade_edges *o, int threads,
                               float *rays, double *mean) {
  if (v->corner || v->number) return YLM_EINVAL;
  size_t pixels = (size_t)v->o.width * (size_t)v->o.height;
  edge_job j = {
      .v = v, .light = o->light, .all = o->all, .out = rays, .unit = o->unit, .most = o->most};
  double sum = 0, lit = 0;
  j.pixel = ylm_alloc(pixels, sizeof *j.pixel);
  ylm_status s =
      j.pixel ? ylm_parallel(pixels, SHADE_GRAIN, threads, fill, &j, NULL, NULL) : YLM_ENOMEM;
  if (s == YLM_OK) s = ylm_parallel((size_t)v->o.height, 1, threads, look, &j, NULL, NULL);
  ylm_free(j.pixel);
  if (s != YLM_OK) return s;
  for (size_t i = 0; i < v->points; i++) sum += (double)rays[i], lit += rays[i] > 0;
  j.usual = fmax(EDGE_LEAST, sum / fmax(1, lit));
  s = ylm_parallel(v->points, SHADE_GRAIN, threads, count, &j, NULL, NULL);
  *mean = 0;
  for (size_t i = 0; i < v->points; i++) *mean += (double)rays[i] / (double)v->points;
  return s;
}
