/* look.c - irradiance of a finished grid: charts, nodes, four corners. */
#include <math.h>

#include "surface.h"

void ylm_surface_free(ylm_surface_grid *g) {
  if (!g) return;
  ylm__surface_charts_free(&g->charts);
  ylm_free(g->root);
  ylm_free(g->node);
  ylm_free(g->plane);
  ylm_free(g->rectangle);
  ylm_free(g->row);
  ylm_free(g);
}

void ylm_surface_look(const ylm_surface_grid *g, ylm_surface_stats *stats) { *stats = g->stats; }

void ylm_surface_verdict(ylm_surface_grid *g, size_t verified, size_t failed, double error,
                         double rms) {
  ylm_surface_stats *s = &g->stats;
  s->verified = verified, s->failed = failed, s->error = error, s->rms = rms;
  s->met = error <= s->tolerance;
}

const ylm_scene *ylm_surface_scene(const ylm_surface_grid *g) { return g->charts.scene; }

void ylm__surface_weigh(ylm_surface_grid *g) {
  size_t triangles = g->charts.first[ylm_scene_meshes(g->charts.scene)];
  g->stats.bytes = sizeof *g + triangles * sizeof *g->charts.of +
                   g->charts.charts * (sizeof *g->charts.chart + sizeof *g->root) +
                   g->nodes * sizeof *g->node + g->planes * sizeof *g->plane +
                   g->stats.rectangles * sizeof *g->rectangle + g->stats.rows * sizeof *g->row;
}

/* The rectangle that a spot lies on. Edges of nodes are the middles of those above. */
static uint32_t descend(const ylm_surface_grid *g, const surface_spot *s, const float x[3]) {
  uint32_t k = g->root[s->chart];
  uint32_t lo[3] = {0, 0, 0}, hi[3] = {SURFACE_TOP, SURFACE_TOP, SURFACE_TOP};
  if (k == SURFACE_NONE) return k;
  for (;;) {
    uint32_t kind = g->node[k] & ((1u << NODE_BITS) - 1), value = g->node[k] >> NODE_BITS;
    if (kind == NODE_RECTANGLE) return value;
    if (kind == NODE_PLANE) {
      const surface_plane *p = &g->plane[value];
      k = p->child + ylm__surface_is_beyond(p->a, x);
      continue;
    }
    uint32_t middle = (lo[kind] + hi[kind]) / 2;
    bool second = s->at[kind] >= (float)middle;
    *(second ? &lo[kind] : &hi[kind]) = middle;
    k = value + second;
  }
}

static void add(const ylm_surface_grid *g, const surface_rectangle *r, const surface_spot *s,
                float E[3]) {
  float w[4];
  ylm__surface_weights(r->lo, r->hi, s->at, w);
  for (int c = 0; c < 4; c++)
    for (int k = 0; k < 3; k++) E[k] += s->weight * w[c] * g->row[r->corner[c]][k];
}

typedef struct job {
  const ylm_surface_grid *g;
  const ylm_scene_place *place;
  float (*out)[3];
  uint32_t *rectangle;
} job;

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  for (size_t i = begin; i < end; i++) {
    ylm_scene_surface at;
    surface_spot spot[3];
    float have = 0, most = 0, *E = j->out[i];
    ylm_scene_surfaces(j->g->charts.scene, 1, &j->place[i], &at);
    int n = ylm__surface_spots(&j->g->charts, &j->place[i], at.position, at.normal, spot);
    E[0] = E[1] = E[2] = 0;
    if (j->rectangle) j->rectangle[i] = SURFACE_NONE;
    for (int k = 0; k < n; k++) {
      uint32_t r = descend(j->g, &spot[k], at.position);
      if (r == SURFACE_NONE) continue;
      add(j->g, &j->g->rectangle[r], &spot[k], E);
      have += spot[k].weight;
      if (j->rectangle && spot[k].weight > most) j->rectangle[i] = r, most = spot[k].weight;
    }
    for (int k = 0; have > 0 && k < 3; k++) E[k] /= have;
  }
  return YLM_OK;
}

void ylm_surface_irradiance(const ylm_surface_grid *g, size_t n, const ylm_scene_place *place,
                            float (*out)[3], uint32_t *rectangle, int threads) {
  job j = {g, place, out, rectangle};
  ylm_parallel(n, SURFACE_GRAIN, threads, run, &j, NULL, NULL);
}

bool ylm_surface_place(const ylm_scene *scene, const float point[3], const float normal[3],
                       ylm_scene_place *place) {
  ylm_trace_hit hit;
  if (!ylm_trace_touch(ylm_scene_trace(scene), point, normal, &hit)) return false;
  *place = (ylm_scene_place){(uint32_t)hit.mesh, hit.element, hit.u, hit.v,
                             ylm_dot3(hit.normal, normal) < 0};
  return true;
}

void ylm_surface_rectangle(const ylm_surface_grid *g, size_t i, float corner[4][3],
                           float value[4][3]) {
  const surface_rectangle *r = &g->rectangle[i];
  const surface_chart *c = &g->charts.chart[r->chart];
  for (int k = 0; k < 4; k++) {
    float t[2] = {(float)(k & 1 ? r->hi[0] : r->lo[0]) / SURFACE_TOP,
                  (float)(k & 2 ? r->hi[1] : r->lo[1]) / SURFACE_TOP};
    for (int a = 0; a < 3; a++)
      corner[k][a] = c->origin[a] + t[0] * c->size[0] * c->axis[0][a] +
                     t[1] * c->size[1] * c->axis[1][a] + 0.5f * c->size[2] * c->axis[2][a];
    memcpy(value[k], g->row[r->corner[k]], sizeof value[k]);
  }
}
