/* path.c - paths from their first hits on: reflected, lit, reflected again. */
#include <math.h>

#include "calibration.h"
#include "path.h"

/* The largest number below 1. */
#define BELOW_ONE 0x1.fffffep-1f

/* The light that a path may bring behind vertex v, as far as that is known: its mean. */
static void expect(const path_tile *t, size_t v, int order, float out[3]) {
  const path_job *j = t->job;
  const path_vertex *at = &t->vertex[v];
  const float *through = t->path[at->path].throughput, *albedo = j->albedo[at->material];
  ylm__path_expected(j, t->cluster[v], order, out);
  for (int c = 0; c < 3; c++) out[c] *= through[c] * albedo[c] * (float)(1 / YLM_PI);
}

/* Whether a path goes on from vertex v, where light is known roughly: the more probably, the more it may bring. A path that
   ends takes what is expected; one that goes on takes off so much that the mean is that of all paths. */
static void decide(path_tile *t, size_t v, int order, bool first) {
  const path_job *j = t->job;
  const path_vertex *at = &t->vertex[v];
  path_state *p = &t->path[at->path];
  float more[3];
  t->chance[v] = 1;
  t->ends[v] = false;
  if (!j->known || j->glosses[at->material]) {
    t->cluster[v] = PATH_UNKNOWN;
    return;
  }
  expect(t, v, order, more);
  float all = ylm__path_luminance(more);
  if (!(p->usual > 0)) p->usual = all;
  if (first || order == j->o->last || !(p->usual > 0)) return;
  float q = fminf(KNOWN_MOST_CHANCE, fmaxf(KNOWN_LEAST_CHANCE, KNOWN_CHANCE * all / p->usual));
  t->chance[v] = q;
  t->ends[v] = ylm__path_random(&p->rng) >= (double)q;
  for (int c = 0; c < 3; c++) more[c] *= t->ends[v] ? 1 : (q - 1) / q;
  ylm__path_add(t, p->radiance, more);
}

/* Decides at all vertices, whose clusters are found some at a time. */
static void decide_all(path_tile *t, int order, bool first) {
  for (size_t v = 0; t->job->known && v < t->n; v += YLM_SCENE_AHEAD) {
    float x[YLM_SCENE_AHEAD][3], normal[YLM_SCENE_AHEAD][3];
    size_t n = ylm__path_next(t, v, x, normal);
    ylm__path_clusters_at(t->job->known, n, (const float(*)[3])x, (const float(*)[3])normal,
                          t->cluster + v);
    for (size_t k = v; k < v + n; k++) decide(t, k, order, first);
  }
  for (size_t v = 0; !t->job->known && v < t->n; v++) decide(t, v, order, first);
}

/* Random numbers for the directions at all vertices. */
static void draw(path_tile *t, bool first) {
  for (size_t v = 0; v < t->n; v++) {
    path_state *p = &t->path[t->vertex[v].path];
    for (int a = 0; a < 3; a++) {
      float u = (float)(first ? p->chosen[a] : ylm__path_random(&p->rng));
      t->u[v][a] = u < BELOW_ONE ? u : BELOW_ONE;
    }
  }
}

/* Directions of a pilot, dense as the cosine, whatever the material. */
static void spread(path_tile *t, size_t begin, size_t end) {
  for (size_t v = begin; v < end; v++) {
    float r = sqrtf(t->u[v][0]);
    double turn = 2 * YLM_PI * (double)t->u[v][1];
    t->wi[v][0] = r * (float)cos(turn), t->wi[v][1] = r * (float)sin(turn);
    t->wi[v][2] = sqrtf(1 - t->u[v][0]);
    t->pdf[v] = t->wi[v][2] * (float)(1 / YLM_PI);
    t->weight[v][0] = t->weight[v][1] = t->weight[v][2] = 1;
    ylm__path_outward(&t->vertex[v], t->wi[v], t->way[v]);
  }
}

/* Which directions of a material's vertices guides choose: `own` of those is below 0. The rest of the third random number is the
   material's. */
static void part(path_tile *t, size_t begin, size_t end) {
  for (size_t v = begin; v < end; v++) {
    float u = t->u[v][2];
    t->own[v] = u < GUIDED_PART ? -1 : 0;
    u = u < GUIDED_PART ? u / GUIDED_PART : (u - GUIDED_PART) / (1 - GUIDED_PART);
    t->u[v][2] = fminf(BELOW_ONE, u);
  }
}

/* Fetches to the cache what guides are asked for vertices behind v. */
static void fetch(const path_tile *t, size_t v, size_t end) {
  const path_known *k = t->job->known;
  if (v + GUIDES_AHEAD < end) ylm__path_guide_ahead(k, t->cluster[v + GUIDES_AHEAD]);
  v += GUIDES_AHEAD / 2;
  if (v < end && t->own[v] < 0) ylm__path_guided_ahead(k, t->cluster[v], t->u[v]);
}

/* Lets guides choose these directions. */
static void guide(path_tile *t, size_t begin, size_t end) {
  static const float none[3] = {0, 0, -1};
  const path_known *k = t->job->known;
  for (size_t v = begin; v < end; v++) {
    const path_vertex *at = &t->vertex[v];
    fetch(t, v, end);
    if (!(t->own[v] < 0)) {
      ylm__path_outward(at, t->wi[v], t->way[v]);
      ylm__path_density_ahead(k, t->cluster[v], t->way[v]);
    } else if (ylm__path_guided(k, t->cluster[v], t->u[v], t->way[v]))
      ylm__path_inward(at, t->way[v], t->wi[v]);
    else
      memcpy(t->wi[v], none, 12);
  }
}

/* Gives these directions the density of all ways to find them. */
static void mix(path_tile *t, const ylm_material *m, size_t begin, size_t end) {
  const float(*wi)[3] = (const float(*)[3])(t->wi + begin);
  const float(*wo)[3] = (const float(*)[3])(t->wo + begin);
  ylm_material_eval(m, end - begin, wi, wo, t->f + begin);
  ylm_material_pdf(m, end - begin, wi, wo, t->own + begin);
  for (size_t v = begin; v < end; v++) {
    bool goes = !t->ends[v] && t->wi[v][2] > 0;
    float pdf = goes ? ylm__path_density(t, v, t->own[v], t->way[v]) : 0;
    t->pdf[v] = pdf;
    for (int c = 0; c < 3; c++) t->weight[v][c] = pdf > 0 ? t->f[v][c] * t->wi[v][2] / pdf : 0;
  }
}

/* The directions at all vertices. */
static void choose(path_tile *t, bool first) {
  const path_job *j = t->job;
  draw(t, first);
  for (size_t m = 0, v = 0; m < j->materials; v = t->behind[m++]) {
    size_t n = t->behind[m] - v;
    if (n == 0) continue;
    if (t->noted && !j->glosses[m]) {
      spread(t, v, v + n);
      continue;
    }
    bool guided = j->known && !j->glosses[m];
    if (guided) part(t, v, v + n);
    ylm_material_sample(j->material[m], n, (const float(*)[3])(t->wo + v),
                        (const float(*)[3])(t->u + v), t->wi + v, t->weight + v, t->pdf + v);
    if (guided) {
      guide(t, v, v + n);
      mix(t, j->material[m], v, v + n);
    } else
      for (size_t k = v; k < v + n; k++) ylm__path_outward(&t->vertex[k], t->wi[k], t->way[k]);
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
    memcpy(ray->dir, t->way[v], 12);
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

/* Whether a path goes on: at random by its throughput, which is then raised. */
static bool survives(path_state *p) {
  float chance = fminf(MOST_CHANCE, fmaxf(LEAST_CHANCE, ylm__path_luminance(p->throughput)));
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
    if (t->noted) t->noted->next[p->noted] = PATH_NOWHERE;
    if (ylm_dot3(r->ray[i].dir, at->at.flat) <= 0) {
      t->counts.absorbed++;
      continue;
    }
    if (r->hit[i].mesh < 0) continue;
    if (t->noted) t->noted->next[p->noted] = PATH_UNKNOWN;
    for (int c = 0; c < 3; c++) p->throughput[c] *= t->weight[v][c];
    if (!(p->throughput[0] > 0 || p->throughput[1] > 0 || p->throughput[2] > 0)) continue;
    if (order >= ROULETTE && !t->noted && t->chance[v] == 1 && !survives(p)) continue;
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

/* Notes that a path comes to a place, and goes on from there. */
static void note(path_places *p, path_state *path, const float *x, const float *normal,
                 const float *origin, const float *direction) {
  uint32_t at = (uint32_t)p->n++;
  if (path->noted != PATH_UNKNOWN) p->next[path->noted] = at;
  path->noted = at;
  memcpy(p->x[at], x, 12);
  memcpy(p->normal[at], normal, 12);
  memcpy(p->origin[at], origin, 12);
  memcpy(p->direction[at], direction, 12);
  memset(p->albedo[at], 0, 12);
  p->next[at] = PATH_UNKNOWN;
  p->cosine[at] = true;
}

/* Notes that paths of a pilot start at points of surfaces and go along the first rays. */
static void note_starts(path_tile *t) {
  const path_job *j = t->job;
  for (size_t i = 0; j->normals && i < t->rays.n; i++) {
    uint64_t item = t->item[i / YLM_PATH_BATCH];
    double n[3];
    float normal[3];
    for (int a = 0; a < 3; a++) n[a] = (double)j->normals[item][a];
    ylm_unit3(n);
    for (int a = 0; a < 3; a++) normal[a] = (float)n[a];
    note(t->noted, &t->path[i], j->points[item], normal, t->rays.ray[i].org, t->rays.ray[i].dir);
    if (t->rays.hit[i].mesh < 0) t->noted->next[t->path[i].noted] = PATH_NOWHERE;
  }
}

/* Notes where paths are. */
static void note_vertices(path_tile *t) {
  path_places *p = t->noted;
  for (size_t m = 0, v = 0; m < t->job->materials; m++)
    for (; v < t->behind[m]; v++) {
      const path_vertex *at = &t->vertex[v];
      note(p, &t->path[at->path], at->at.lit, at->at.normal, at->at.origin, t->way[v]);
      for (int c = 0; c < 3; c++) p->albedo[p->n - 1][c] = t->job->albedo[m][c] * at->at.tint[c];
      p->cosine[p->n - 1] = !t->job->glosses[m];
    }
}

void ylm__path_walk(path_tile *t, double *values) {
  const ylm_path_options *o = t->job->o;
  bool camera = !t->job->points;
  ylm__path_tile_seed(t);
  t->job->kind->begin(t);
  t->counts.paths += t->pairs * YLM_PATH_BATCH;
  if (t->noted) note_starts(t);
  for (int order = 1; t->rays.n > 0 && (o->last < 0 || order <= o->last); order++) {
    bool first = camera && order == 1, ends = order == o->last;
    ylm__path_tile_vertices(t);
    t->rays.n = 0;
    decide_all(t, order, first);
    if (!ends || (o->strategy != YLM_PATH_LIGHTS && !t->noted)) {
      choose(t, first);
      follow(t);
    }
    if (t->noted)
      note_vertices(t);
    else if (order >= o->first)
      ylm__path_direct(t, first);
    go_on(t, order);
  }
  for (size_t k = 0; k < t->pairs && !t->noted; k++)
    t->job->kind->finish(t, k, values + k * t->job->values);
}
