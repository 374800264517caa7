/* seams.c - edges where two charts meet on a smooth surface: both sides are to read as one. */
#include "map.h"

/* The normal of the scene in the middle of an edge of a sheet's fine triangle. */
static void normal_of(const ylm_surface_map *m, const map_sheet *sheet, size_t fine, int edge,
                      float normal[3]) {
  double u = edge == 2 ? 0 : 0.5, v = edge == 0 ? 0 : 0.5;
  size_t triangle = ylm__map_whole(sheet, fine, &u, &v);
  ylm_scene_place p = {sheet->mesh, (uint32_t)triangle, (float)(sheet->back ? v : u),
                       (float)(sheet->back ? u : v), sheet->back};
  ylm_scene_surface at;
  ylm_scene_surfaces(m->scene, 1, &p, &at);
  memcpy(normal, at.normal, sizeof at.normal);
}

static void mix(const double a[2], const double b[2], double t, double out[2]) {
  for (int k = 0; k < 2; k++) out[k] = a[k] + t * (b[k] - a[k]);
}

/* Places of one edge: from p to q in the first chart, from r to s in the second. */
static ylm_status add_edge(map_bake *b, const uint32_t chart[2], double p[2], double q[2],
                           double r[2], double s[2]) {
  double length = hypot(q[0] - p[0], q[1] - p[1]);
  size_t n = 1 + (size_t)(MAP_SEAM_ALONG * length);
  for (size_t i = 0; i <= n; i++) {
    map_tap tap[2];
    map_seam seam;
    double at[2][2], t = (double)i / (double)n;
    mix(p, q, t, at[0]);
    mix(r, s, t, at[1]);
    bool read = true;
    for (int k = 0; k < 2; k++) {
      ylm__map_tap_at(b->m, at[k], &tap[k]);
      read = read && ylm__map_keep_in(b, chart[k], &tap[k]);
    }
    if (!read) continue;
    for (int k = 0; k < 8; k++) {
      seam.texel[k] = tap[k / 4].texel[k % 4];
      seam.weight[k] = (k < 4 ? 1 : -1) * tap[k / 4].weight[k % 4];
    }
    if (!ylm_list_reserve(&b->seam, b->seams, b->seams + 1, &b->seam_room, sizeof *b->seam))
      return YLM_ENOMEM;
    b->seam[b->seams++] = seam;
  }
  return YLM_OK;
}

/* Places of edge k of a triangle, where another chart begins there and the surface is smooth. */
static ylm_status add_seam(map_bake *b, size_t sheet, size_t triangle, int k) {
  const ylm_surface_map *m = b->m;
  size_t other;
  int across;
  if (!ylm_unwrap_across(m->charts, sheet, triangle, k, &other, &across) || other < triangle)
    return YLM_OK;
  uint32_t chart[2] = {ylm_unwrap_chart(m->charts, sheet, triangle),
                       ylm_unwrap_chart(m->charts, sheet, other)};
  float normal[2][3];
  if (chart[0] == chart[1]) return YLM_OK;
  normal_of(m, &m->sheet[sheet], triangle, k, normal[0]);
  normal_of(m, &m->sheet[sheet], other, across, normal[1]);
  if (ylm_dot3(normal[0], normal[1]) < (float)MAP_SMOOTH) return YLM_OK;
  double p[3][2], q[3][2];
  ylm_unwrap_corners(m->charts, sheet, triangle, p);
  ylm_unwrap_corners(m->charts, sheet, other, q);
  b->m->stats.seams++;
  return add_edge(b, chart, p[k], p[(k + 1) % 3], q[(across + 1) % 3], q[across]);
}

ylm_status ylm__map_seams(map_bake *b) {
  ylm_status s = YLM_OK;
  b->seams = b->m->stats.seams = 0;
  for (size_t i = 0; i < b->m->sheets; i++)
    for (size_t t = 0; t < b->m->sheet[i].fine; t++)
      for (int k = 0; s == YLM_OK && k < 3; k++) s = add_seam(b, i, t, k);
  return s;
}

double ylm__map_jump(const map_bake *b) {
  const float *picture = b->m->picture;
  double most = 0;
  for (size_t i = 0; i < b->seams; i++)
    for (size_t c = 0; c < 3; c++) {
      double side[2] = {0, 0};
      for (int k = 0; k < 8; k++)
        side[k / 4] += fabs((double)b->seam[i].weight[k]) *
                       (double)picture[3 * (size_t)b->seam[i].texel[k] + c];
      double m = fmax(0.5 * (side[0] + side[1]), b->mean[c]);
      if (m > 0) most = fmax(most, fabs(side[0] - side[1]) / m);
    }
  return most;
}
