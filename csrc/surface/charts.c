/* charts.c - maps of surfaces: the planes of a mesh, and six along the axes where it is round. */
#include <math.h>

#include "surface.h"
#include "ylm_keys.h"

/* A plane of a mesh, rounded. */
typedef struct plane_key {
  int32_t mesh, normal[3], distance;
} plane_key;

typedef struct planes {
  ylm_keys key;
  double *area; /* [key.n] */
  size_t room;
  uint32_t *of; /* [triangles] the number of its plane; ROUND; SURFACE_NONE: no area */
} planes;

enum { ROUND = 0x7fffffff };

double ylm__surface_triangle(const float *positions, const uint32_t *t, const float *p[3],
                             double n[3]) {
  double u[3], v[3];
  for (int k = 0; k < 3; k++) p[k] = positions + 3 * (size_t)t[k];
  for (int a = 0; a < 3; a++)
    u[a] = (double)p[1][a] - (double)p[0][a], v[a] = (double)p[2][a] - (double)p[0][a];
  ylm_cross3d(u, v, n);
  double area = 0.5 * sqrt(ylm_dot3d(n, n));
  return ylm_unit3(n) && isfinite(area) ? area : 0;
}

/* Whether normals turn within a triangle. */
static bool turns(const ylm_scene *scene, uint32_t mesh, uint32_t element) {
  static const float corner[3][2] = {{0, 0}, {1, 0}, {0, 1}};
  ylm_scene_place place[3];
  ylm_scene_surface at[3];
  for (int k = 0; k < 3; k++)
    place[k] = (ylm_scene_place){mesh, element, corner[k][0], corner[k][1], false};
  ylm_scene_surfaces(scene, 3, place, at);
  for (int k = 0; k < 3; k++)
    if (ylm_dot3(at[k].normal, at[k].flat) < 0.99999f) return true;
  return false;
}

/* The plane of a triangle. */
static ylm_status sort(planes *p, uint32_t mesh, const double n[3], const float *x, double area,
                       double unit, uint32_t *number) {
  plane_key key = {.mesh = (int32_t)mesh};
  double d = 0;
  for (int a = 0; a < 3; a++) {
    key.normal[a] = (int32_t)floor(n[a] / PLANE_NORMAL + 0.37);
    d += n[a] * (double)x[a];
  }
  key.distance = (int32_t)fmax(-2e9, fmin(2e9, floor(d / (PLANE_DISTANCE * unit) + 0.37)));
  size_t before = p->key.n;
  ylm_status s = ylm_keys_put(&p->key, &key, sizeof key, number);
  if (s != YLM_OK) return s;
  if (!ylm_list_reserve(&p->area, before, p->key.n, &p->room, sizeof *p->area)) return YLM_ENOMEM;
  if (p->key.n > before) p->area[before] = 0;
  p->area[*number] += area;
  return YLM_OK;
}

static ylm_status find_planes(surface_charts *c, const float *positions, planes *p) {
  ylm_status s = YLM_OK;
  double n[3];
  const float *x[3];
  size_t meshes = ylm_scene_meshes(c->scene);
  for (int pass = 0; pass < 2; pass++) {
    if (pass == 1) c->unit = sqrt(c->area);
    for (uint32_t m = 0; s == YLM_OK && m < meshes; m++) {
      size_t first = ylm_scene_first_vertex(c->scene, m);
      for (uint32_t i = 0; s == YLM_OK && i < ylm_scene_triangles(c->scene, m); i++) {
        double area =
            ylm__surface_triangle(positions + 3 * first, ylm_scene_triangle(c->scene, m, i), x, n);
        uint32_t *of = &p->of[c->first[m] + i];
        if (pass == 0)
          c->area += area;
        else if (!(area > 0))
          *of = SURFACE_NONE;
        else if (turns(c->scene, m, i))
          *of = ROUND;
        else
          s = sort(p, m, n, x[0], area, c->unit, of);
      }
    }
  }
  return s;
}

/* -- frames -------------------------------------------------------------------------------- */

/* The longest edge of a triangle, those at a right angle to another first; its length so weighed. */
static double longest(const float *const p[3], double edge[3]) {
  double best = 0;
  for (int k = 0; k < 3; k++) {
    double d[3], o[2][3], length, score;
    for (int a = 0; a < 3; a++) {
      d[a] = (double)p[(k + 1) % 3][a] - (double)p[k][a];
      o[0][a] = (double)p[(k + 2) % 3][a] - (double)p[k][a];
      o[1][a] = (double)p[(k + 2) % 3][a] - (double)p[(k + 1) % 3][a];
    }
    score = length = sqrt(ylm_dot3d(d, d));
    ylm_unit3(d);
    for (int i = 0; i < 2; i++)
      if (ylm_unit3(o[i]) && fabs(ylm_dot3d(d, o[i])) < 1e-3) score = 10 * length;
    if (score <= best) continue;
    best = score;
    memcpy(edge, d, sizeof d);
  }
  return best;
}

/* Numbers of charts by plane and by mesh: the first. */
typedef struct numbers {
  uint32_t *plane, *round; /* [planes], [meshes] */
  double *edge;            /* [planes] the longest so far */
} numbers;

static void set_axis(surface_chart *c, int a, const double x[3]) {
  for (int k = 0; k < 3; k++) c->axis[a][k] = (float)x[k];
}

/* A plane's axes along an edge of it. */
static void turn_to(surface_chart *c, const double edge[3], const double n[3]) {
  double across[3];
  ylm_cross3d(n, edge, across);
  set_axis(c, 0, edge);
  set_axis(c, 1, across);
  set_axis(c, 2, n);
}

/* Bounds of a chart grow by a triangle: origin and size hold least and most meanwhile. */
static void stretch(surface_chart *c, const float *const p[3]) {
  for (int k = 0; k < 3; k++)
    for (int a = 0; a < 3; a++) {
      float x = ylm_dot3(p[k], c->axis[a]);
      c->origin[a] = fminf(c->origin[a], x);
      c->size[a] = fmaxf(c->size[a], x);
    }
}

static void settle(surface_chart *c) {
  float lo[3], origin[3] = {0, 0, 0};
  for (int a = 0; a < 3; a++) {
    float most = fmaxf(fabsf(c->origin[a]), fabsf(c->size[a])), rounding = 1e-6f * most;
    lo[a] = c->origin[a] - rounding;
    c->size[a] = c->size[a] + rounding - lo[a];
  }
  for (int a = 0; a < 3; a++)
    for (int k = 0; k < 3; k++) origin[k] += lo[a] * c->axis[a][k];
  memcpy(c->origin, origin, sizeof origin);
}

static void begin(surface_chart *c, size_t n) {
  for (size_t i = 0; i < n; i++)
    for (int a = 0; a < 3; a++) c[i].origin[a] = INFINITY, c[i].size[a] = -INFINITY;
}

/* The axes of all charts, which then are known by number. */
static void find_axes(surface_charts *c, const float *positions, const planes *p, numbers *x) {
  const float *q[3];
  double n[3], edge[3] = {1, 0, 0};
  for (uint32_t m = 0; m < ylm_scene_meshes(c->scene); m++) {
    size_t first = ylm_scene_first_vertex(c->scene, m);
    for (uint32_t i = 0; i < ylm_scene_triangles(c->scene, m); i++) {
      uint32_t of = p->of[c->first[m] + i];
      if (of == SURFACE_NONE || of == ROUND || x->plane[of] == SURFACE_NONE) continue;
      ylm__surface_triangle(positions + 3 * first, ylm_scene_triangle(c->scene, m, i), q, n);
      double length = longest(q, edge);
      if (length <= x->edge[of]) continue;
      x->edge[of] = length;
      for (int side = 0; side < 2; side++) turn_to(&c->chart[x->plane[of] + side], edge, n);
    }
    if (x->round[m] == SURFACE_NONE) continue;
    for (int k = 0; k < 6; k++)
      for (int a = 0; a < 3; a++) {
        double e[3] = {0, 0, 0};
        e[(k / 2 + 1 + a) % 3] = 1;
        set_axis(&c->chart[x->round[m] + (uint32_t)k], a, e);
      }
  }
}

static void find_bounds(surface_charts *c, const float *positions, size_t count, const numbers *x) {
  const float *q[3];
  double n[3];
  for (uint32_t m = 0; m < ylm_scene_meshes(c->scene); m++) {
    size_t first = ylm_scene_first_vertex(c->scene, m);
    for (uint32_t i = 0; i < ylm_scene_triangles(c->scene, m); i++) {
      uint32_t of = c->of[c->first[m] + i];
      if (of == SURFACE_NONE) continue;
      ylm__surface_triangle(positions + 3 * first, ylm_scene_triangle(c->scene, m, i), q, n);
      for (uint32_t k = 0; k < (of & 1 ? 6u : 2u); k++) stretch(&c->chart[of / 2 + k], q);
    }
  }
  for (size_t i = 0; i < c->charts; i++) settle(&c->chart[i]);
  for (size_t i = 0; i < count; i++)
    for (int side = 0; x->plane[i] != SURFACE_NONE && side < 2; side++)
      c->chart[x->plane[i] + side].size[2] = 0;
}

/* Gives planes and round meshes their charts. */
static ylm_status number(surface_charts *c, const planes *p, numbers *x, ylm_error *e) {
  size_t n = 0;
  for (size_t i = 0; i < p->key.n; i++) {
    bool alone = p->area[i] >= PLANE_LEAST * c->area;
    x->plane[i] = alone ? (uint32_t)n : SURFACE_NONE;
    n += alone ? 2 : 0;
  }
  for (uint32_t m = 0; m < ylm_scene_meshes(c->scene); m++) {
    bool round = false;
    for (size_t i = c->first[m]; i < c->first[m + 1]; i++)
      round |=
          p->of[i] != SURFACE_NONE && (p->of[i] == ROUND || x->plane[p->of[i]] == SURFACE_NONE);
    x->round[m] = round ? (uint32_t)n : SURFACE_NONE;
    n += round ? 6 : 0;
    for (size_t i = c->first[m]; i < c->first[m + 1]; i++) {
      uint32_t of = p->of[i];
      bool flat = of != SURFACE_NONE && of != ROUND && x->plane[of] != SURFACE_NONE;
      c->of[i] = of == SURFACE_NONE ? of : flat ? 2 * x->plane[of] : 2 * x->round[m] + 1;
    }
  }
  c->charts = n;
  if (n > ROUND / 2) return ylm_fail(e, YLM_ELIMIT, "there are too many surfaces (%zu)", n);
  return YLM_OK;
}

static ylm_status find_charts(surface_charts *c, const float *positions, const planes *p,
                              ylm_error *e) {
  size_t meshes = ylm_scene_meshes(c->scene);
  numbers x = {ylm_alloc(p->key.n, sizeof *x.plane), ylm_alloc(meshes, sizeof *x.round),
               ylm_alloc_zero(p->key.n, sizeof *x.edge)};
  ylm_status s = x.plane && x.round && x.edge ? number(c, p, &x, e) : YLM_ENOMEM;
  if (s == YLM_OK && !(c->chart = ylm_alloc_zero(c->charts, sizeof *c->chart))) s = YLM_ENOMEM;
  if (s == YLM_OK) {
    begin(c->chart, c->charts);
    find_axes(c, positions, p, &x);
    find_bounds(c, positions, p->key.n, &x);
  }
  ylm_free(x.plane);
  ylm_free(x.round);
  ylm_free(x.edge);
  return s;
}

ylm_status ylm__surface_charts(const ylm_scene *scene, surface_charts *c, ylm_error *e) {
  size_t meshes = ylm_scene_meshes(scene), triangles = 0,
         vertices = ylm_scene_vertices(scene, NULL);
  *c = (surface_charts){.scene = scene, .first = ylm_alloc(meshes + 1, sizeof *c->first)};
  for (size_t m = 0; c->first && m <= meshes; m++) {
    c->first[m] = triangles;
    if (m < meshes) triangles += ylm_scene_triangles(scene, m);
  }
  planes p = {.of = ylm_alloc(triangles, sizeof *p.of)};
  float *positions = ylm_alloc(vertices, 3 * sizeof *positions);
  c->of = ylm_alloc(triangles, sizeof *c->of);
  ylm_status s = c->first && p.of && positions && c->of ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) {
    ylm_scene_vertices(scene, positions);
    s = find_planes(c, positions, &p);
  }
  if (s == YLM_OK) s = find_charts(c, positions, &p, e);
  ylm_keys_free(&p.key);
  ylm_free(p.area);
  ylm_free(p.of);
  ylm_free(positions);
  if (s != YLM_OK) ylm__surface_charts_free(c);
  return s;
}

void ylm__surface_charts_free(surface_charts *c) {
  ylm_free(c->first);
  ylm_free(c->chart);
  ylm_free(c->of);
  *c = (surface_charts){.scene = NULL};
}

/* -- spots --------------------------------------------------------------------------------- */

static void put_on(const surface_charts *c, uint32_t chart, float weight, const float x[3],
                   surface_spot *s) {
  const surface_chart *k = &c->chart[chart];
  float d[3];
  for (int a = 0; a < 3; a++) d[a] = x[a] - k->origin[a];
  s->chart = chart;
  s->weight = weight;
  for (int a = 0; a < 3; a++) {
    float t = k->size[a] > 0 ? ylm_dot3(d, k->axis[a]) / k->size[a] : 0;
    s->at[a] = SURFACE_TOP * fminf(fmaxf(t, 0), 1);
  }
}

int ylm__surface_spots(const surface_charts *c, const ylm_scene_place *p, const float position[3],
                       const float normal[3], surface_spot spot[3]) {
  uint32_t of = c->of[c->first[p->mesh] + p->element];
  float sum = 0;
  int n = 0;
  if (of == SURFACE_NONE) return 0;
  if (!(of & 1)) {
    put_on(c, of / 2 + p->back, 1, position, &spot[0]);
    return 1;
  }
  for (uint32_t a = 0; a < 3; a++) {
    float w = fabsf(normal[a]) - (float)ROUND_LEAST;
    if (!(w > 0)) continue;
    put_on(c, of / 2 + 2 * a + (normal[a] < 0), w, position, &spot[n++]);
    sum += w;
  }
  for (int i = 0; i < n; i++) spot[i].weight /= sum;
  return n;
}
