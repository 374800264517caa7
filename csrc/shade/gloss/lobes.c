/*
** lobes.c - what points that gloss see of the elements of a scene, by rays that their materials choose.
**
** Directions have about the density of f cos, so that a sharp lobe has all of its rays. Source: Heitz 2018,
** "Sampling the GGX Distribution of Visible Normals".
*/
#include "lobes.h"

#include <math.h>

#include "../calibration.h"

/* Rays that are traced in one go, unless one point has more. */
#define BATCH 1024
/* How far below the horizon of a normal of vertices the eye may be. */
#define LEAST_COSINE 1e-4f
#define BELOW_ONE 0x1.fffffep-1f
#define WEIGHTS 65535
/* No element; a ray that a material chose. */
#define AIMED_NOWHERE UINT32_MAX
#define AIMED_CHOSEN (UINT32_MAX - 1)

typedef struct job {
  const ylm_shade_view *v;
  const ylm_transfer *t;
  const ylm_transfer_targets *targets; /* or NULL */
  const uint32_t *point;
  const uint64_t *stream;
  size_t most; /* links of a point */
  uint64_t seed;
  uint32_t
      *vertex; /* [points of the view] 2 * vertex of the scene + back; NULL: points are entries */
  float (*albedo)[3]; /* [elements]; NULL: nothing is tinted */
  const shade_lobes *out;
} job;

/* The memory of one thread. */
typedef struct scratch {
  float (*u)[3], (*wo)[3], (*wi)[3], *pdf; /* [most] */
  float (*f)[3];                           /* [most] */
  float (*weight)[3];                      /* [room] */
  ylm_trace_ray *ray;
  ylm_trace_hit *hit;
  uint32_t *target, *good; /* [room], [most] */
  double *own;     /* [room] density of rays that the material chooses; < 0: it chose all of them */
  uint32_t *aimed; /* [room] the element that a ray is aimed at, or AIMED_NOWHERE */
  size_t *cluster; /* [room] */
  size_t room, rays; /* rays: of points so far */
} scratch;

/* -- directions ------------------------------------------------------------------- */

void ylm__shade_surface(const ylm_shade_view *v, const uint32_t *vertex, size_t i,
                        ylm_scene_surface *s) {
  if (!vertex) {
    ylm_scene_surfaces(v->scene, 1, &v->entry[i].at, s);
    return;
  }
  size_t of_mesh = vertex[i] / 2 - ylm_scene_first_vertex(v->scene, v->mesh[i]);
  ylm_scene_vertex(v->scene, v->mesh[i], of_mesh, vertex[i] & 1, s);
}

/* The direction to the camera in the frame x, y, normal of a surface. */
static void toward_eye(const ylm_shade_view *v, const ylm_scene_surface *s, const float y[3],
                       float wo[3]) {
  double d[3], length = 0;
  float to[3];
  for (int a = 0; a < 3; a++) d[a] = v->frame.from[a] - (double)s->position[a];
  for (int a = 0; a < 3; a++) length += d[a] * d[a];
  for (int a = 0; a < 3; a++) to[a] = length > 0 ? (float)(d[a] / sqrt(length)) : s->normal[a];
  wo[0] = ylm_dot3(to, s->tangent), wo[1] = ylm_dot3(to, y), wo[2] = ylm_dot3(to, s->normal);
  if (wo[2] < LEAST_COSINE) wo[2] = LEAST_COSINE;
  float each = 1 / sqrtf(ylm_dot3(wo, wo));
  for (int a = 0; a < 3; a++) wo[a] *= each;
}

void ylm__shade_frame(const ylm_shade_view *v, const uint32_t *vertex, size_t i,
                      ylm_scene_surface *s, float y[3], float wo[3]) {
  ylm__shade_surface(v, vertex, i, s);
  for (int a = 0; a < 3; a++) {
    int b = (a + 1) % 3, c = (a + 2) % 3;
    y[a] = s->normal[b] * s->tangent[c] - s->normal[c] * s->tangent[b];
  }
  toward_eye(v, s, y, wo);
}

bool ylm__shade_is_soft(const ylm_shade_view *v, size_t i) {
  const ylm_material *m = ylm__shade_material(v, i);
  double along = 0, square = 0;
  if (!ylm_material_glosses(m)) return true;
  if (v->corner) return false;
  for (int a = 0; a < 3; a++) {
    double d = v->frame.from[a] - (double)v->position[i][a];
    along += d * (double)v->normal[i][a];
    square += d * d;
  }
  float cosine = square > 0 ? (float)(along / sqrt(square)) : 1;
  return ylm_material_excess(m, cosine) < SHADE_SOFT;
}

/* The digits of i to the base 3, reversed behind the point. */
static double radical_of_three(uint32_t i) {
  double x = 0, digit = 1;
  for (; i > 0; i /= 3) x += (double)(i % 3) * (digit /= 3);
  return x;
}

static float shifted(double x, float by) {
  float y = (float)x + by;
  return fminf(y >= 1 ? y - 1 : y, BELOW_ONE);
}

/* Random numbers of a point: Hammersley's set, shifted. */
static void draw(const job *j, size_t point, size_t links, float (*u)[3]) {
  ylm_rng rng;
  float by[3];
  ylm_rng_seed(&rng, j->seed, j->stream[point]);
  for (int a = 0; a < 3; a++) by[a] = (float)ylm_rng_double(&rng);
  for (size_t k = 0; k < links; k++) {
    u[k][0] = shifted((double)k / (double)links, by[0]);
    u[k][1] = shifted(ylm_scene_radical((uint32_t)k), by[1]);
    u[k][2] = shifted(radical_of_three((uint32_t)k), by[2]);
  }
}

/* Aims a ray from a surface at what u chooses for a cluster; wi [3]: its direction in the surface's frame; the element that it is
   aimed at, or AIMED_NOWHERE. */
static uint32_t aim_at(const job *j, const ylm_scene_surface *s, const float y[3], size_t cluster,
                       const float u[3], ylm_trace_ray *ray, float wi[3]) {
  uint32_t element;
  float to[3], square;
  ray->near = 0;
  ray->far = -1;
  memcpy(ray->org, s->origin, 12);
  memcpy(ray->dir, s->normal, 12);
  memset(wi, 0, 12);
  if (!ylm_transfer_target(j->targets, cluster,
                           (double[]){(double)u[0], (double)u[1], (double)u[2]}, &element, to))
    return AIMED_NOWHERE;
  for (int a = 0; a < 3; a++) to[a] -= s->origin[a];
  square = ylm_dot3(to, to);
  if (!(ylm_dot3(to, s->flat) > 0)) return AIMED_NOWHERE;
  for (int a = 0; a < 3; a++) ray->dir[a] = to[a] / sqrtf(square);
  wi[0] = ylm_dot3(ray->dir, s->tangent);
  wi[1] = ylm_dot3(ray->dir, y);
  wi[2] = ylm_dot3(ray->dir, s->normal);
  if (wi[2] > 0) ray->far = INFINITY;
  return element;
}

/* Aims rays first .. links-1 of a point, of random numbers x->u; weights of these and of those that its material chose are f cos. */
static void aim_at_light(const job *j, scratch *x, const ylm_scene_surface *s, const float y[3],
                         size_t point, size_t first, size_t links) {
  const ylm_material *m = ylm__shade_material(j->v, point);
  ylm_trace_ray *ray = x->ray + x->rays;
  size_t cluster = ylm_transfer_targets_at(j->targets, s->origin, s->normal), n = links - first;
  for (size_t k = first; k < links; k++)
    x->aimed[x->rays + k] = aim_at(j, s, y, cluster, x->u[k], &ray[k], x->wi[k]);
  const float(*wi)[3] = (const float(*)[3])x->wi + first, (*wo)[3] = (const float(*)[3])x->wo;
  ylm_material_eval(m, n, wi, wo, x->f + first);
  ylm_material_pdf(m, n, wi, wo, x->pdf + first);
  for (size_t k = 0; k < links; k++) {
    float *weight = x->weight[x->rays + k];
    x->cluster[x->rays + k] = cluster;
    x->own[x->rays + k] = (double)x->pdf[k];
    for (int c = 0; c < 3; c++) {
      if (k < first)
        weight[c] *= x->pdf[k];
      else
        weight[c] = ray[k].far > 0 ? x->f[k][c] * x->wi[k][2] : 0;
    }
  }
}

/* The weight of a link, f cos, over the density of its ray by both ways. */
static void balance(const job *j, const scratch *x, size_t k) {
  float *weight = x->weight[k];
  uint32_t raw = x->target[k] < ylm_transfer_count(j->t)
                     ? ylm_transfer_hit(j->t, &x->ray[k], &x->hit[k])
                     : AIMED_NOWHERE;
  bool aimed = x->aimed[k] != AIMED_CHOSEN;
  double other = 0;
  if (raw != AIMED_NOWHERE)
    other = ylm_transfer_target_density(j->targets, x->cluster[k], raw, &x->ray[k], &x->hit[k]);
  double all = (x->own[k] + other) / 2;
  for (int c = 0; c < 3; c++)
    weight[c] = all > 0 && !(aimed && raw != x->aimed[k]) ? (float)((double)weight[c] / all) : 0;
}

/* Rays of a point and their weights. Rays that a normal of vertices would send below the triangle are absorbed. */
static void aim(const job *j, scratch *x, size_t point, size_t links) {
  ylm_scene_surface s;
  float y[3], (*weight)[3] = x->weight + x->rays;
  ylm_trace_ray *ray = x->ray + x->rays;
  bool both = j->targets && links % 2 == 0 && ylm__shade_is_soft(j->v, point);
  size_t chosen = both ? links / 2 : links;
  ylm__shade_frame(j->v, j->vertex, point, &s, y, x->wo[0]);
  for (size_t k = 1; k < links; k++) memcpy(x->wo[k], x->wo[0], 12);
  draw(j, point, chosen, x->u);
  if (both) memcpy(x->u + chosen, x->u, chosen * sizeof *x->u);
  ylm_material_sample(ylm__shade_material(j->v, point), chosen, (const float(*)[3])x->wo,
                      (const float(*)[3])x->u, x->wi, weight, x->pdf);
  for (size_t k = 0; k < chosen; k++) {
    x->own[x->rays + k] = -1;
    x->aimed[x->rays + k] = AIMED_CHOSEN;
    for (int a = 0; a < 3; a++)
      ray[k].dir[a] = x->wi[k][0] * s.tangent[a] + x->wi[k][1] * y[a] + x->wi[k][2] * s.normal[a];
    bool goes = x->pdf[k] > 0 && ylm_dot3(ray[k].dir, s.flat) > 0;
    memcpy(ray[k].org, s.origin, 12);
    ray[k].near = 0;
    ray[k].far = goes ? INFINITY : -1;
    for (int c = 0; c < 3; c++)
      if (!goes || !(weight[k][c] > 0) || !isfinite(weight[k][c])) weight[k][c] = 0;
  }
  if (both) aim_at_light(j, x, &s, y, point, chosen, links);
  x->rays += links;
}

/* -- what they hit ------------------------------------------------------------------- */

/* A place that is hit may have another tint than its element in the mean. */
static void tint(const job *j, const ylm_trace_ray *ray, const ylm_trace_hit *hit, uint32_t element,
                 float weight[3]) {
  ylm_scene_surface s;
  float albedo[3];
  bool back = ylm_dot3(hit->normal, ray->dir) > 0;
  ylm_scene_place at = {(uint32_t)hit->mesh, hit->element, hit->u, hit->v, back};
  ylm_scene_surfaces(j->v->scene, 1, &at, &s);
  ylm_material_albedo(s.material, albedo);
  for (int c = 0; c < 3; c++) {
    float mean = j->albedo[element][c];
    weight[c] *= mean > 0 ? albedo[c] * s.tint[c] / mean : 0;
  }
}

/* Keeps the links of number i, of rays from `at` on: those that begin inside of a body give their slots to others that the
   material chose, evenly. */
static void keep(const job *j, scratch *x, size_t i, size_t at) {
  const uint32_t *target = x->target + at, *aimed = x->aimed + at;
  const float(*weight)[3] = (const float(*)[3])x->weight + at;
  const size_t *start = j->out->start + i;
  uint32_t none = (uint32_t)ylm_transfer_count(j->t), links = (uint32_t)(start[1] - start[0]);
  uint32_t *link = j->out->link + start[0], n = 0, b = 0, buried = 0;
  uint16_t *part = j->out->weight + 3 * start[0];
  float most = 0;
  for (uint32_t k = 0; k < links; k++) buried += target[k] > none;
  for (uint32_t k = 0; k < links; k++)
    if (target[k] <= none && aimed[k] == AIMED_CHOSEN) x->good[n++] = k;
  for (uint32_t k = 0; k < links; k++)
    for (int c = 0; target[k] <= none && c < 3; c++) most = fmaxf(most, weight[k][c]);
  for (uint32_t k = 0; k < links; k++) {
    uint32_t from = target[k] <= none || n == 0 ? k : x->good[(uint64_t)b++ * n / buried];
    link[k] = target[from] <= none ? target[from] : none;
    for (uint32_t c = 0; c < 3; c++)
      part[c * links + k] =
          link[k] < none && most > 0 ? (uint16_t)lrintf(weight[from][c] / most * WEIGHTS) : 0;
  }
  j->out->most[i] = most;
}

/* Traces the rays of points first .. end-1. */
static void follow(const job *j, scratch *x, size_t first, size_t end) {
  size_t none = ylm_transfer_count(j->t);
  const size_t *start = j->out->start;
  ylm_trace_nearest(ylm_scene_trace(j->v->scene), x->rays, x->ray, false, x->hit);
  ylm_transfer_hits(j->t, x->rays, x->ray, x->hit, x->target);
  for (size_t k = 0; k < x->rays; k++) {
    if (x->ray[k].far < 0) x->target[k] = (uint32_t)none;
    if (!(x->own[k] < 0)) balance(j, x, k);
    if (x->aimed[k] != AIMED_CHOSEN && x->target[k] > none) x->target[k] = (uint32_t)none;
    if (j->albedo && x->target[k] < none)
      tint(j, &x->ray[k], &x->hit[k], x->target[k], x->weight[k]);
  }
  for (size_t i = first; i < end; i++) keep(j, x, i, start[i] - start[first]);
  x->rays = 0;
}

/* -- all points ---------------------------------------------------------------------- */

static void scratch_free(scratch *x) {
  ylm_free(x->u);
  ylm_free(x->wo);
  ylm_free(x->wi);
  ylm_free(x->weight);
  ylm_free(x->pdf);
  ylm_free(x->ray);
  ylm_free(x->hit);
  ylm_free(x->target);
  ylm_free(x->good);
  ylm_free(x->f);
  ylm_free(x->own);
  ylm_free(x->aimed);
  ylm_free(x->cluster);
}

static bool scratch_create(scratch *x, size_t links) {
  size_t rays = x->room = links > BATCH ? links : BATCH;
  x->u = ylm_alloc(links, sizeof *x->u);
  x->wo = ylm_alloc(links, sizeof *x->wo);
  x->wi = ylm_alloc(links, sizeof *x->wi);
  x->weight = ylm_alloc(rays, sizeof *x->weight);
  x->pdf = ylm_alloc(links, sizeof *x->pdf);
  x->ray = ylm_alloc(rays, sizeof *x->ray);
  x->hit = ylm_alloc(rays, sizeof *x->hit);
  x->target = ylm_alloc(rays, sizeof *x->target);
  x->good = ylm_alloc(links, sizeof *x->good);
  x->f = ylm_alloc(links, sizeof *x->f);
  x->own = ylm_alloc(rays, sizeof *x->own);
  x->aimed = ylm_alloc(rays, sizeof *x->aimed);
  x->cluster = ylm_alloc(rays, sizeof *x->cluster);
  return x->u && x->wo && x->wi && x->weight && x->pdf && x->ray && x->hit && x->target &&
         x->good && x->f && x->own && x->aimed && x->cluster;
}

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  const size_t *start = j->out->start;
  scratch x = {0};
  ylm_status s = scratch_create(&x, j->most) ? YLM_OK : YLM_ENOMEM;
  for (size_t first = begin, i = begin; s == YLM_OK && i < end; i++) {
    aim(j, &x, j->point[i], start[i + 1] - start[i]);
    if (i + 1 < end && start[i + 2] - start[first] <= x.room) continue;
    follow(j, &x, first, i + 1);
    first = i + 1;
  }
  scratch_free(&x);
  return s;
}

uint32_t *ylm__shade_point_vertices(const ylm_shade_view *v) {
  uint32_t *vertex = ylm_alloc_zero(v->points, sizeof *vertex);
  size_t all = 2 * ylm_scene_vertices(v->scene, NULL);
  for (size_t i = 0; vertex && v->vertex && i < all; i++)
    if (v->vertex[i] != YLM_SHADE_NOWHERE) vertex[v->vertex[i]] = (uint32_t)i;
  for (size_t i = 0; vertex && !v->vertex && i < v->entries; i++) {
    const ylm_scene_place *at = &v->entry[i].at;
    const uint32_t *corner = ylm_scene_triangle(v->scene, at->mesh, at->element);
    size_t first = ylm_scene_first_vertex(v->scene, at->mesh);
    for (int k = 0; k < 3; k++)
      vertex[v->corner[i][k]] = (uint32_t)(2 * (first + corner[k]) + at->back);
  }
  return vertex;
}

/* Albedos where something is tinted; vertices where points are. */
static ylm_status share(job *j) {
  const ylm_shade_view *v = j->v;
  bool tinted = ylm_scene_is_tinted(v->scene);
  if (v->corner) j->vertex = ylm__shade_point_vertices(v);
  if (tinted) j->albedo = ylm_alloc(ylm_transfer_count(j->t), sizeof *j->albedo);
  if ((v->corner && !j->vertex) || (tinted && !j->albedo)) return YLM_ENOMEM;
  if (tinted) ylm_transfer_elements(j->t, NULL, NULL, NULL, j->albedo[0], NULL);
  return YLM_OK;
}

ylm_status ylm__shade_lobes(const ylm_shade_view *v, const ylm_transfer *t,
                            const ylm_transfer_targets *targets, size_t n, const uint32_t *point,
                            const uint64_t *stream, size_t most, uint64_t seed, int threads,
                            const ylm_progress *progress, const shade_lobes *out) {
  job j = {.v = v,
           .t = t,
           .targets = targets,
           .point = point,
           .stream = stream,
           .most = most,
           .seed = seed,
           .out = out};
  ylm_status s = share(&j);
  if (s == YLM_OK) s = ylm_parallel(n, SHADE_LOBE_GRAIN, threads, run, &j, progress, "links");
  ylm_free(j.vertex);
  ylm_free(j.albedo);
  return s;
}

void ylm__shade_lobe(const shade_lobes *x, size_t i, const float *leaving, int parity,
                     double out[3]) {
  size_t links = x->start[i + 1] - x->start[i];
  const uint32_t *link = x->link + x->start[i];
  double each = (double)x->most[i] / WEIGHTS / (double)links;
  for (size_t c = 0; c < 3; c++) {
    const uint16_t *weight = x->weight + 3 * x->start[i] + c * links;
    double sum = 0;
    for (size_t k = 0; k < links; k++)
      if (parity < 0 || __builtin_parityll(k) == parity)
        sum += weight[k] * (double)leaving[4 * (size_t)link[k] + c];
    out[c] = each * sum;
  }
}
