/* path.c - paths from their first hits on: reflected, lit, reflected again. */
#include "path.h"
#include "calibration.h"

/* The largest number below 1. */
#define BELOW_ONE 0x1.fffffep-1f

/* The directions that materials choose at all vertices. */
static void choose(path_tile *t, bool first) {
  const path_job *j = t->job;
  for (size_t v = 0; v < t->n; v++) {
    path_state *p = &t->path[t->vertex[v].path];
    for (int a = 0; a < 3; a++)
      t->u[v][a] = fminf(BELOW_ONE, (float)(first ? p->chosen[a] : ylm__path_random(&p->rng)));
  }
  for (size_t m = 0, v = 0; m < j->materials; v = t->behind[m++]) {
    size_t n = t->behind[m] - v;
    if (n)
      ylm_material_sample(j->material[m], n, (const float(*)[3])(t->wo + v),
                          (const float(*)[3])(t->u + v), t->wi + v, t->weight + v, t->pdf + v);
  }
}

/* Follows these directions to the surfaces that they meet. */
static void follow(path_tile *t) {
  path_rays *r = &t->rays;
  r->n = 0;
  for (uint32_t v = 0; v < t->n; v++) {
    if (!(t->pdf[v] > 0)) continue;
    ylm_trace_ray *ray = &r->ray[r->n];
    memcpy(ray->org, t->vertex[v].at.origin, 12);
    memcpy(r->lit[r->n], t->vertex[v].at.lit, 12);
    ylm__path_outward(&t->vertex[v], t->wi[v], ray->dir);
    ray->near = 0;
    ray->far = INFINITY;
    r->of[r->n++] = v;
  }
  if (t->job->open) {
    for (size_t i = 0; i < r->n; i++) r->hit[i].mesh = YLM_TRACE_NOTHING;
    return;
  }
  ylm_trace_nearest(t->job->trace, r->n, r->ray, false, r->hit);
  t->counts.nearest_rays += r->n;
}

static float luminance(const float *c) {
  return (float)YLM_LUMINANCE_R * c[0] + (float)YLM_LUMINANCE_G * c[1] +
         (float)YLM_LUMINANCE_B * c[2];
}

/* Whether a path goes on: at random by its throughput, which is then raised. */
static bool survives(path_state *p) {
  float chance = fminf(MOST_CHANCE, fmaxf(LEAST_CHANCE, luminance(p->throughput)));
  if (ylm__path_random(&p->rng) >= (double)chance) return false;
  for (int c = 0; c < 3; c++) p->throughput[c] /= chance;
  return true;
}

/* Keeps the rays of paths that go on behind reflection `order`; they are then counted by paths. */
static void go_on(path_tile *t, int order) {
  path_rays *r = &t->rays;
  size_t n = 0;
  for (size_t i = 0; i < r->n; i++) {
    uint32_t v = r->of[i];
    const path_vertex *at = &t->vertex[v];
    path_state *p = &t->path[at->path];
    if (ylm_dot3(r->ray[i].dir, at->at.flat) <= 0) {
      t->counts.absorbed++;
      continue;
    }
    if (r->hit[i].mesh < 0) continue;
    for (int c = 0; c < 3; c++) p->throughput[c] *= t->weight[v][c];
    if (!(p->throughput[0] > 0 || p->throughput[1] > 0 || p->throughput[2] > 0)) continue;
    if (order >= ROULETTE && !survives(p)) continue;
    r->ray[n] = r->ray[i];
    r->hit[n] = r->hit[i];
    r->of[n++] = at->path;
  }
  r->n = n;
}

void ylm__path_mean(path_tile *t, size_t k, double *values) {
  const path_state *p = &t->path[k * YLM_PATH_BATCH];
  for (int c = 0; c < 3; c++) {
    values[c] = 0;
    for (int i = 0; i < YLM_PATH_BATCH; i++) values[c] += (double)p[i].radiance[c] / YLM_PATH_BATCH;
  }
}

/* Notes where paths are, as far as there is room. */
static void note(path_tile *t) {
  path_places *p = t->noted;
  for (size_t v = 0; v < t->n && p->n < p->room; v++, p->n++) {
    memcpy(p->x[p->n], t->vertex[v].at.lit, 12);
    memcpy(p->normal[p->n], t->vertex[v].at.normal, 12);
    memcpy(p->origin[p->n], t->vertex[v].at.origin, 12);
  }
}

void ylm__path_walk(path_tile *t, double *values) {
  const ylm_path_options *o = t->job->o;
  bool camera = !t->job->points;
  ylm__path_tile_seed(t);
  t->job->kind->begin(t);
  t->counts.paths += t->pairs * YLM_PATH_BATCH;
  for (int order = 1; t->rays.n > 0 && (o->last < 0 || order <= o->last); order++) {
    bool first = camera && order == 1, ends = order == o->last;
    ylm__path_tile_vertices(t);
    t->rays.n = 0;
    if (!ends || o->strategy != YLM_PATH_LIGHTS) {
      choose(t, first);
      follow(t);
    }
    if (t->noted)
      note(t);
    else if (order >= o->first)
      ylm__path_direct(t, first);
    go_on(t, order);
  }
  for (size_t k = 0; k < t->pairs && !t->noted; k++)
    t->job->kind->finish(t, k, values + k * t->job->values);
}
