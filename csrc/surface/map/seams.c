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
  double side[2] = {hypot(q[0] - p[0], q[1] - p[1]), hypot(s[0] - r[0], s[1] - r[1])};
  double length = fmax(side[0], side[1]);
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
      for (int a = 0; a < 2; a++) seam.at[k][a] = (float)at[k][a];
      seam.finer[k] = length > 0 ? (float)log2(fmax(side[k] / length, 1e-6)) : 0;
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

/* A picture of the means of two by two texels of one. */
static void halve(size_t width, size_t height, const float *from, float *to) {
  for (size_t y = 0; y < height; y++)
    for (size_t x = 0; x < width; x++)
      for (size_t c = 0; c < 3; c++) {
        const float *a = from + 12 * y * width + 6 * x + c, *b = a + 6 * width;
        to[3 * (y * width + x) + c] = 0.25f * (a[0] + a[3] + b[0] + b[3]);
      }
}

/* Adds a part of the light at coordinates of a whole level. */
static void add_level(const map_bake *b, const float *picture, int level, const float from[2],
                      double part, double out[3]) {
  map_tap tap;
  double at[2] = {ldexp((double)from[0], -level), ldexp((double)from[1], -level)};
  ylm__map_tap_of(b->width >> level, b->height >> level, at, &tap);
  for (int j = 0; j < 4; j++)
    for (size_t c = 0; c < 3; c++)
      out[c] += part * (double)tap.weight[j] * (double)picture[3 * (size_t)tap.texel[j] + c];
}

/* The largest jump where the denser sides are looked up at a level, and the others at that where their texels are as large. */
static double find_jump(const map_bake *b, int level, float *const picture[]) {
  double most = 0;
  for (size_t i = 0; i < b->seams; i++) {
    double side[2][3] = {{0, 0, 0}, {0, 0, 0}};
    const map_seam *s = &b->seam[i];
    for (int k = 0; k < 2; k++) {
      double own = fmax(0, level + (double)s->finer[k]), part = own - floor(own);
      int first = (int)own;
      add_level(b, picture[first], first, s->at[k], 1 - part, side[k]);
      if (part > 0) add_level(b, picture[first + 1], first + 1, s->at[k], part, side[k]);
    }
    for (size_t c = 0; c < 3; c++) {
      double m = fmax(0.5 * (side[0][c] + side[1][c]), b->mean[c]);
      if (m > 0) most = fmax(most, fabs(side[0][c] - side[1][c]) / m);
    }
  }
  return most;
}

ylm_status ylm__map_jumps(const map_bake *b, double jump[YLM_SURFACE_MAP_LEVELS]) {
  float *picture[YLM_SURFACE_MAP_LEVELS] = {b->m->picture};
  ylm_status s = YLM_OK;
  for (int level = 0; s == YLM_OK && level < YLM_SURFACE_MAP_LEVELS; level++) {
    size_t width = b->width >> level, height = b->height >> level;
    if (level) picture[level] = ylm_alloc(width * height, 3 * sizeof **picture);
    if (!picture[level]) s = YLM_ENOMEM;
    if (level && s == YLM_OK) halve(width, height, picture[level - 1], picture[level]);
    if (s == YLM_OK) jump[level] = find_jump(b, level, picture);
  }
  for (int level = 1; level < YLM_SURFACE_MAP_LEVELS; level++) ylm_free(picture[level]);
  return s;
}
