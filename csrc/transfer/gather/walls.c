/*
** walls.c - sides of the box around a scene that are walls: points on them see the scene from within.
**
** Bounds of grids are that box, or a little larger: probes at them would stand behind walls, in the dark.
*/
#include "gather.h"

/* Surfaces in one side of the box, by where they look: inwards, outwards. */
typedef struct face {
  double area[2], light[2]; /* light: luminance of irradiance times area */
} face;

void ylm__gather_step_in(const ylm_gather *g, float at[3]) {
  if (!(g->margin > 0)) return;
  for (int a = 0; a < 3; a++) {
    double x = (double)at[a], touch = g->margin / 100;
    if (g->wall[0][a] && x >= g->lo[a] - g->margin && x <= g->lo[a] + touch)
      at[a] = (float)(g->lo[a] + g->margin);
    if (g->wall[1][a] && x <= g->hi[a] + g->margin && x >= g->hi[a] - touch)
      at[a] = (float)(g->hi[a] - g->margin);
  }
}

/* Adds an element to the side of the box that it lies in, if any. */
static void add(const ylm_gather *g, const float *centre, const float *normal, double area,
                const float *E, face (*faces)[3]) {
  double light = YLM_LUMINANCE_R * (double)E[0] + YLM_LUMINANCE_G * (double)E[1] +
                 YLM_LUMINANCE_B * (double)E[2];
  for (int a = 0; a < 3; a++) {
    double x = (double)centre[a], n = (double)normal[a];
    if (fabs(n) < 1 - GATHER_WALL_TILT) continue;
    for (int high = 0; high < 2; high++) {
      if (fabs(x - (high ? g->hi[a] : g->lo[a])) > g->margin / 10) continue;
      int outwards = high ? n > 0 : n < 0;
      faces[high][a].area[outwards] += area;
      faces[high][a].light[outwards] += area * light;
    }
  }
}

/* Decides by the elements of the transfer and their light in the last solution. */
static ylm_status by_light(ylm_gather *g) {
  size_t n = g->elements;
  float *centre = ylm_alloc(n + 1, 3 * sizeof *centre), *area = ylm_alloc(n + 1, sizeof *area);
  float *normal = ylm_alloc(n + 1, 3 * sizeof *normal);
  face faces[2][3] = {0};
  bool there = centre && normal && area;
  const float *E = ylm_radiosity_irradiance(g->radiosity);
  if (there) ylm_transfer_elements(g->transfer, centre, normal, area, NULL, NULL);
  for (size_t i = 0; there && i < n; i++)
    add(g, centre + 3 * i, normal + 3 * i, (double)area[i], E + 4 * i, faces);
  for (int a = 0; there && a < 3; a++) {
    int b = (a + 1) % 3, c = (a + 2) % 3;
    double most = (g->hi[b] - g->lo[b]) * (g->hi[c] - g->lo[c]);
    for (int high = 0; high < 2; high++) {
      const face *f = &faces[high][a];
      g->wall[high][a] = f->area[0] > GATHER_WALL_AREA * most && f->light[0] >= f->light[1];
    }
  }
  ylm_free(centre);
  ylm_free(normal);
  ylm_free(area);
  return there ? YLM_OK : YLM_ENOMEM;
}

ylm_status ylm__gather_walls(ylm_gather *g) {
  double diagonal2 = 0;
  ylm_scene_bounds(g->scene, g->lo, g->hi);
  for (int a = 0; a < 3; a++) diagonal2 += (g->hi[a] - g->lo[a]) * (g->hi[a] - g->lo[a]);
  g->margin = sqrt(diagonal2) / 1000;
  for (int a = 0; a < 3; a++) /* what is flat has no inside */
    if (g->hi[a] - g->lo[a] <= 4 * g->margin) g->margin = 0;
  for (int a = 0; a < 3; a++) g->wall[0][a] = g->wall[1][a] = g->form.within;
  return g->form.within || !(g->margin > 0) ? YLM_OK : by_light(g);
}
