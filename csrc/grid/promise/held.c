/* held.c - held-out points: random shading points, and where in the grid they are. */
#include <math.h>
#include <string.h>

#include "../bake/surface.h"
#include "tolerance.h"

/* Shading point k in float, relative to the grid's origin. */
static void shading_point(const refiner *r, size_t k, float out[3]) {
  const ylm_grid_source *s = r->b->source;
  double p[3];
  for (size_t a = 0; a < 3; a++) p[a] = ylm_get(s->occupied_dtype, s->occupied_points, 3 * k + a);
  ylm__grid_inward(r->b->g, p, out);
}

/* The side of shading point k. */
static void shading_side(const ylm_grid_source *s, size_t k, float out[3]) {
  for (size_t a = 0; a < 3; a++) out[a] = (float)ylm_get(s->occupied_dtype, s->normals, 3 * k + a);
}

void ylm__held_surface_side(const ylm_grid_surface *surface, uint64_t seed, uint64_t k,
                            uint64_t strata, float out[3]) {
  double p[3], normal[3];
  ylm_grid_surface_draw(surface, seed, k, strata, p, normal);
  float side = k & 1 ? -1 : 1; /* triangles have two */
  for (int a = 0; a < 3; a++) out[a] = side * (float)normal[a];
}

void ylm__held_surface_point(const refiner *r, uint64_t seed, uint64_t k, uint64_t strata,
                             float out[3]) {
  double p[3], normal[3];
  ylm_grid_surface_draw(r->surface, seed, k, strata, p, normal);
  ylm__grid_inward(r->b->g, p, out);
}

void ylm__held_draw(const refiner *r, ylm_rng *rng, float out[3]) {
  const ylm_grid_source *s = r->b->source;
  const ylm_grid *g = r->b->g;
  double box[6];
  memcpy(box, g->contents.form.bounds, sizeof box);
  if (g->contents.root_level) ylm_grid_box(g, 0, box);
  if (r->surface) {
    uint64_t high = ylm_rng_u32(rng), low = ylm_rng_u32(rng);
    ylm__held_surface_point(r, high << 32 | low, 0, 1, out);
  } else if (s->occupied_points)
    shading_point(r, (size_t)(ylm_rng_double(rng) * (double)s->occupied), out);
  else {
    double p[3];
    for (size_t a = 0; a < 3; a++) p[a] = box[a] + (box[a + 3] - box[a]) * ylm_rng_double(rng);
    ylm__grid_inward(g, p, out);
  }
}

uint32_t ylm__held_leaf(const ylm_grid *g, const float x[3]) {
  double p[3];
  ylm__grid_outward(g, x, p);
  return ylm_grid_locate(g, p, false, NULL);
}

ylm_status ylm__held_points(refiner *r, ylm_rng *rng, bool all, size_t n) {
  const ylm_grid_source *s = r->b->source;
  bool here = s->occupied_points || !backend_has_shading(s);
  size_t index[HELD_OUT];
  for (size_t i = 0; i < n; i++) {
    if (r->side) {
      size_t k = all ? i : (size_t)(ylm_rng_double(rng) * (double)s->occupied);
      shading_point(r, k, r->points + 3 * i);
      shading_side(s, k, r->side + 3 * i);
    } else if (here && !all)
      ylm__held_draw(r, rng, r->points + 3 * i);
    else if (here)
      shading_point(r, i, r->points + 3 * i);
    else
      index[i] = all ? i : (size_t)(ylm_rng_double(rng) * (double)s->occupied);
  }
  return here ? YLM_OK : ylm__backend_shading(r->b, n, index, r->points);
}

void ylm__held_fractions(const ylm_grid *g, const ylm_grid_cell *c, const float x[3], float t[3]) {
  double at[3], p[3], inverse = 1 / (double)ylm__grid_edge(g, c);
  ylm__grid_outward(g, x, p);
  ylm__grid_coordinates(g, p, at);
  for (int a = 0; a < 3; a++) t[a] = (float)edge_fraction(at[a], c->origin[a], inverse);
}

ylm_grid_probe ylm__held_probe(const ylm_grid *g, const ylm_grid_cell *c, const float t[3],
                               uint32_t point) {
  ylm_grid_probe p = {.edge = ylm__grid_edge(g, c), .point = point, .t = {t[0], t[1], t[2]}};
  memcpy(p.corner, c->corner, sizeof p.corner);
  return p;
}
