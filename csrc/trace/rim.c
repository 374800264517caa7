/*
** rim.c - the rim of what is hit, seen from a point.
**
** Directions of a lattice are traced. Between neighbours of which one hits and one misses, the rim is found by halving;
** through the places found it goes from edge to edge of each cell (Lorensen & Cline 1987, in two dimensions).
*/
#include <math.h>
#include <string.h>

#include "occlusion.h"
#include "ylm_list.h"

#define QUARTER 0.78539816339744830962 /* of pi */

/* A place on an edge of the lattice: between a direction that hits and one that misses. */
typedef struct rim_found {
  double in[2], out[2]; /* of the map */
  rim_point point;
} rim_found;

void ylm__rim_free(rim_room *r) {
  ylm_free(r->at);
  ylm_free(r->hit);
  ylm_free(r->edge);
  ylm_free(r->ray);
  ylm_free(r->meet);
  ylm_free(r->found);
  ylm_free(r->arc);
  memset(r, 0, sizeof *r);
}

/* Room for a map of so many cells. */
static ylm_status reserve(rim_room *r, size_t side) {
  if (r->nodes >= side * side) return YLM_OK;
  ylm__rim_free(r);
  r->at = ylm_alloc(side, sizeof *r->at);
  r->hit = ylm_alloc(side * side, 1);
  r->edge = ylm_alloc(2 * side * side, sizeof *r->edge);
  /* each line of the lattice crosses the rim at most once a cell */
  size_t most = 2 * side * side;
  r->ray = ylm_alloc(most, sizeof *r->ray);
  r->meet = ylm_alloc(most, sizeof *r->meet);
  r->found = ylm_alloc(most, sizeof *r->found);
  if (!r->at || !r->hit || !r->edge || !r->ray || !r->meet || !r->found) {
    ylm__rim_free(r);
    return YLM_ENOMEM;
  }
  r->nodes = side * side;
  return YLM_OK;
}

static void direction(const rim_map *m, double x, double y, double w[3]) {
  double square = 0;
  for (int a = 0; a < 3; a++) {
    w[a] = m->middle[a] + x * m->across[a] + y * m->up[a];
    square += w[a] * w[a];
  }
  double over = 1 / sqrt(square);
  for (int a = 0; a < 3; a++) w[a] *= over;
}

static ylm_trace_ray ray_along(const double p[3], const double w[3]) {
  ylm_trace_ray r = {.near = 0, .far = INFINITY};
  for (int a = 0; a < 3; a++) r.org[a] = (float)p[a], r.dir[a] = (float)w[a];
  return r;
}

/* Traces the nodes of the map, row by row. */
static void trace_nodes(const ylm_trace *t, const double p[3], const rim_map *m, rim_room *r,
                        double *hit) {
  size_t side = (size_t)m->cells + 1;
  double step = 2.0 / m->cells;
  double wide =
      sqrt(m->across[0] * m->across[0] + m->across[1] * m->across[1] + m->across[2] * m->across[2]);
  uint32_t *node = r->edge; /* not in use yet */
  for (size_t j = 0; j < side; j++) {
    size_t n = 0;
    for (size_t i = 0; i < side; i++) {
      double w[3], cosine = 0;
      direction(m, r->at[i], r->at[j], w);
      for (int a = 0; a < 3; a++) cosine += w[a] * m->middle[a];
      r->hit[j * side + i] = 0;
      if (cosine < m->cosine) continue;
      node[n] = (uint32_t)i;
      r->ray[n++] = ray_along(p, w);
    }
    ylm_trace_occluded(t, n, r->ray);
    for (size_t k = 0; k < n; k++) {
      if (!(r->ray[k].far < 0)) continue;
      double x = wide * r->at[node[k]], y = wide * r->at[j], square = 1 + x * x + y * y;
      r->hit[j * side + node[k]] = 1;
      /* of one face of a cube: places are tangents of even angles */
      double dx = wide * step * (m->cosine < -1 ? (1 + x * x) * QUARTER : 1);
      double dy = wide * step * (m->cosine < -1 ? (1 + y * y) * QUARTER : 1);
      *hit += dx * dy / (square * sqrt(square));
    }
  }
}

/* -- places on edges ----------------------------------------------------------------------------- */

static void add_edge(rim_room *r, size_t node, size_t other, size_t side, uint32_t *to) {
  size_t in = r->hit[node] ? node : other, out = r->hit[node] ? other : node;
  rim_found *f = &r->found[r->founds];
  *to = UINT32_MAX;
  if (r->hit[node] == r->hit[other]) return;
  f->in[0] = r->at[in % side];
  f->in[1] = r->at[in / side];
  f->out[0] = r->at[out % side];
  f->out[1] = r->at[out / side];
  *to = (uint32_t)r->founds++;
}

static void list_edges(const rim_map *m, rim_room *r) {
  size_t side = (size_t)m->cells + 1;
  r->founds = 0;
  for (size_t j = 0; j < side; j++)
    for (size_t i = 0; i < side; i++) {
      size_t k = j * side + i;
      if (i + 1 < side) add_edge(r, k, k + 1, side, &r->edge[k]);
      if (j + 1 < side) add_edge(r, k, k + side, side, &r->edge[side * side + k]);
    }
}

/* Halves the way between hits and misses, and asks for the distance of the last hit. */
static void halve(const ylm_trace *t, const double p[3], const rim_map *m, rim_room *r) {
  double w[3];
  for (int k = 0; k < RIM_HALVINGS; k++) {
    for (size_t i = 0; i < r->founds; i++) {
      const rim_found *f = &r->found[i];
      direction(m, (f->in[0] + f->out[0]) / 2, (f->in[1] + f->out[1]) / 2, w);
      r->ray[i] = ray_along(p, w);
    }
    ylm_trace_occluded(t, r->founds, r->ray);
    for (size_t i = 0; i < r->founds; i++) {
      rim_found *f = &r->found[i];
      double *to = r->ray[i].far < 0 ? f->in : f->out;
      double x = (f->in[0] + f->out[0]) / 2, y = (f->in[1] + f->out[1]) / 2;
      to[0] = x;
      to[1] = y;
    }
  }
  for (size_t i = 0; i < r->founds; i++) {
    direction(m, r->found[i].in[0], r->found[i].in[1], w);
    r->ray[i] = ray_along(p, w);
  }
  ylm_trace_nearest(t, r->founds, r->ray, false, r->meet);
  for (size_t i = 0; i < r->founds; i++) {
    rim_found *f = &r->found[i];
    direction(m, (f->in[0] + f->out[0]) / 2, (f->in[1] + f->out[1]) / 2, f->point.w);
    f->point.t = r->meet[i].mesh == YLM_TRACE_NOTHING ? INFINITY : (double)r->meet[i].t;
  }
}

/* -- arcs -------------------------------------------------------------------------------------------- */

static ylm_status add_arc(rim_room *r, uint32_t from, uint32_t to) {
  if (!ylm_list_reserve(&r->arc, r->arcs, r->arcs + 1, &r->arcs_room, sizeof *r->arc))
    return YLM_ENOMEM;
  r->arc[r->arcs++] = (rim_arc){r->found[from].point, r->found[to].point};
  return YLM_OK;
}

/* Does the direction in the middle of a cell hit? */
static bool middle_hits(const ylm_trace *t, const double p[3], const rim_map *m, const rim_room *r,
                        size_t i, size_t j) {
  double w[3];
  direction(m, (r->at[i] + r->at[i + 1]) / 2, (r->at[j] + r->at[j + 1]) / 2, w);
  ylm_trace_ray ray = ray_along(p, w);
  ylm_trace_occluded(t, 1, &ray);
  return ray.far < 0;
}

/* The arcs within a cell. Counter-clockwise around it, the rim leaves what is hit at some edges and enters it at others:
   the body is to the left of the way from where it is left to where it is entered. */
static ylm_status cross_cell(const ylm_trace *t, const double p[3], const rim_map *m, rim_room *r,
                             size_t i, size_t j) {
  size_t side = (size_t)m->cells + 1, k = j * side + i, up = side * side;
  const uint8_t *h = r->hit;
  const uint8_t corner[5] = {h[k], h[k + 1], h[k + side + 1], h[k + side], h[k]};
  const uint32_t edge[4] = {r->edge[k], r->edge[up + k + 1], r->edge[k + side], r->edge[up + k]};
  uint32_t leave[2], enter[2];
  size_t leaves = 0, enters = 0;
  int first = -1; /* of the ways out */
  for (int s = 0; s < 4; s++)
    if (corner[s] && !corner[s + 1] && first < 0) first = s;
  if (first < 0) return YLM_OK;
  for (int n = 0; n < 4; n++) {
    int s = (first + n) % 4;
    if (corner[s] == corner[s + 1]) continue;
    if (corner[s])
      leave[leaves++] = edge[s];
    else
      enter[enters++] = edge[s];
  }
  if (leaves == 1) return add_arc(r, leave[0], enter[0]);
  bool joined = middle_hits(t, p, m, r, i, j);
  ylm_status s = add_arc(r, leave[0], enter[joined ? 0 : 1]);
  return s == YLM_OK ? add_arc(r, leave[1], enter[joined ? 1 : 0]) : s;
}

ylm_status ylm__rim_find(const ylm_trace *t, const double p[3], const rim_map *m, rim_room *r,
                         double *hit) {
  size_t side = (size_t)m->cells + 1;
  ylm_status s = reserve(r, side);
  if (s != YLM_OK) return s;
  for (size_t i = 0; i < side; i++) {
    double x = (2.0 * (double)i - m->cells) / m->cells;
    bool end =
        i == 0 ||
        i + 1 == side; /* exactly -1 or 1: neighbouring maps have these directions in common */
    r->at[i] = m->cosine < -1 && !end ? tan(x * QUARTER) : x;
  }
  trace_nodes(t, p, m, r, hit);
  list_edges(m, r);
  halve(t, p, m, r);
  for (size_t j = 0; j + 1 < side && s == YLM_OK; j++)
    for (size_t i = 0; i + 1 < side && s == YLM_OK; i++) s = cross_cell(t, p, m, r, i, j);
  return s;
}
