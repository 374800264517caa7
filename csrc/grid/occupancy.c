/* occupancy.c - the occupancy octree, built bottom-up from shading points. */
#include "grid.h"

#include <string.h>

#define DENSE 8 /* finest level that has one bit per node: 2 MiB */

/* Point i of the source in double. */
static void source_point(const ylm_grid_source *s, size_t i, double p[3]) {
  for (int a = 0; a < 3; a++)
    p[a] = s->occupied_dtype == YLM_DOUBLE ? ((const double *)s->occupied_points)[3 * i + (size_t)a]
                                           : ((const float *)s->occupied_points)[3 * i + (size_t)a];
}

/* The finest lattice cell of point i. */
static bool source_cell(const ylm_grid *g, const ylm_grid_source *s, size_t i, uint32_t cell[3]) {
  double p[3], at[3];
  source_point(s, i, p);
  bool inside = ylm__grid_coordinates(g, p, at);
  for (int a = 0; a < 3; a++) {
    uint32_t last = g->view.resolution[a] - 1, c = (uint32_t)at[a];
    cell[a] = c > last ? last : c;
  }
  return inside;
}

/* Sorts codes of `bits` bits by their bytes, least significant first. */
static ylm_status sort_codes(uint64_t **codes, size_t n, int bits) {
  uint64_t *code = *codes;
  uint64_t *other = ylm_alloc(n, sizeof *other), *from = code, *to = other;
  if (!other) return YLM_ENOMEM;
  for (int shift = 0; shift < bits; shift += 8) {
    size_t count[257] = {0};
    for (size_t i = 0; i < n; i++) count[(from[i] >> shift & 255) + 1]++;
    for (int k = 0; k < 256; k++) count[k + 1] += count[k];
    for (size_t i = 0; i < n; i++) to[count[from[i] >> shift & 255]++] = from[i];
    uint64_t *swap = from;
    from = to;
    to = swap;
  }
  ylm_free(to);
  *codes = from;
  return YLM_OK;
}

static void set_bit(uint8_t *bits, uint64_t i) { bits[i >> 3] |= (uint8_t)(1u << (i & 7)); }

/* A node is occupied where one of its eight children, a byte of the level below, is. */
static void mark_parents(occupancy *o) {
  for (int level = o->dense; level > 0; level--)
    for (uint64_t i = 0, n = (uint64_t)1 << 3 * (level - 1); i < n; i++)
      if (o->bits[level][i]) set_bit(o->bits[level - 1], i);
}

/* Codes of the finest nodes, sorted and unique, into o->code. */
static ylm_status collect_codes(occupancy *o, const ylm_grid *g, const ylm_grid_source *s,
                                uint64_t *outside) {
  size_t room = 1024;
  o->code = ylm_alloc(room, sizeof *o->code);
  if (!o->code) return YLM_ENOMEM;
  for (size_t i = 0; i < s->occupied; i++) {
    uint32_t c[3];
    if (!source_cell(g, s, i, c)) ++*outside;
    uint64_t code = ylm__morton(c[0], c[1], c[2]);
    if (o->codes && o->code[o->codes - 1] == code) continue;
    if (o->codes == room) {
      uint64_t *more = ylm_realloc(o->code, room * sizeof *more, room * 2, sizeof *more);
      if (!more) return YLM_ENOMEM;
      o->code = more;
      room *= 2;
    }
    o->code[o->codes++] = code;
  }
  if (sort_codes(&o->code, o->codes, 3 * o->depth) != YLM_OK) return YLM_ENOMEM;
  size_t unique = 0;
  for (size_t i = 0; i < o->codes; i++)
    if (!unique || o->code[unique - 1] != o->code[i]) o->code[unique++] = o->code[i];
  o->codes = unique;
  return YLM_OK;
}

ylm_status occupancy_build(occupancy *o, const ylm_grid *g, const ylm_grid_source *s,
                           uint64_t *outside) {
  *o = (occupancy){.depth = g->view.form.depth, .all = !s->occupied_points};
  if (o->all) return YLM_OK;
  o->dense = o->depth < DENSE ? o->depth : DENSE;
  for (int level = 0; level <= o->dense; level++) {
    o->bits[level] = ylm_alloc_zero((((size_t)1 << 3 * level) + 7) / 8, 1);
    if (!o->bits[level]) return YLM_ENOMEM;
  }
  if (o->depth > o->dense) {
    ylm_status status = collect_codes(o, g, s, outside);
    if (status != YLM_OK) return status;
    for (size_t i = 0; i < o->codes; i++)
      set_bit(o->bits[o->dense], o->code[i] >> 3 * (o->depth - o->dense));
  } else {
    for (size_t i = 0; i < s->occupied; i++) {
      uint32_t c[3];
      if (!source_cell(g, s, i, c)) ++*outside;
      set_bit(o->bits[o->dense], ylm__morton(c[0], c[1], c[2]));
    }
  }
  mark_parents(o);
  return YLM_OK;
}

ylm_status occupancy_mark_uniform(const ylm_grid *g, const ylm_grid_source *s, uint8_t *mark,
                                  uint64_t *outside) {
  const uint32_t *r = g->view.resolution;
  for (size_t i = 0; i < s->occupied; i++) {
    uint32_t c[3];
    if (!source_cell(g, s, i, c)) ++*outside;
    mark[((size_t)c[2] * r[1] + c[1]) * r[0] + c[0]] = 1;
  }
  return YLM_OK;
}

/* True if a sorted code lies in first .. last. */
static bool any_code(const occupancy *o, uint64_t first, uint64_t last) {
  size_t lo = 0, hi = o->codes;
  while (lo < hi) {
    size_t mid = lo + (hi - lo) / 2;
    if (o->code[mid] < first)
      lo = mid + 1;
    else
      hi = mid;
  }
  return lo < o->codes && o->code[lo] <= last;
}

bool occupancy_test(const occupancy *o, int level, const uint32_t node[3]) {
  if (o->all) return true;
  uint64_t code = ylm__morton(node[0], node[1], node[2]);
  if (level <= o->dense) return o->bits[level][code >> 3] >> (code & 7) & 1;
  int shift = 3 * (o->depth - level);
  return any_code(o, code << shift, ((code + 1) << shift) - 1);
}

void occupancy_free(occupancy *o) {
  for (int level = 0; level <= DENSE; level++) ylm_free(o->bits[level]);
  ylm_free(o->code);
  *o = (occupancy){0};
}
