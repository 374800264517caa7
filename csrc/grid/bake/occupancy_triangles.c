/*
** occupancy_triangles.c - the finest voxels that triangles meet.
**
** A triangle's box of voxels is halved along its longest side, the halves that the triangle does
** not meet are dropped, down to single voxels: those are marked, each by a bit. Bits to level 8
** are all there; below, two levels at a time, one word stands for the 64 voxels of each voxel
** that was marked before. Memory follows what is occupied, and no order of threads shows.
*/
#include "surface.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

typedef struct marking {
  const ylm_grid_source *source;
  const double *bounds;
  triangle_list list;
  bool uniform;
  double origin[3];           /* of rounding */
  double scale[3], margin[3]; /* lattice units of this pass */
  uint32_t resolution[3];
  uint64_t *word; /* of 64 voxels that follow one another, or that are in each of `above` */
  size_t words;
  uint64_t *above; /* [words] codes of voxels that were marked before; NULL: there are none */
  int shift;       /* from codes to those above */
  int parts;       /* of the lattice along each axis */
  bool counting;   /* triangles that are not within the bounds: in one pass */
  _Atomic uint64_t outside;
  _Atomic size_t marked; /* voxels so far; more than OCCUPIED_MOST: no use to go on */
} marking;

/* A triangle under way, and the voxels that it was the first to mark. */
typedef struct marker {
  marking *m;
  const triangle *t;
  size_t fresh;
} marker;

/* -- marks ----------------------------------------------------------------------------------- */

/* The word that has a voxel's bit; NULL where what is above was not marked: rounding alone saw
   it. */
static uint64_t *word_of(const marking *m, uint64_t code) {
  size_t lo = 0, hi = m->words;
  if (!m->above) return &m->word[code >> m->shift];
  while (hi - lo > 1) {
    size_t mid = lo + (hi - lo) / 2;
    if (m->above[mid] <= code >> m->shift)
      lo = mid;
    else
      hi = mid;
  }
  return m->above[lo] == code >> m->shift ? &m->word[lo] : NULL;
}

static void mark(marker *k, const uint32_t at[3]) {
  marking *m = k->m;
  const uint32_t *r = m->resolution;
  uint64_t code = m->uniform ? ((uint64_t)at[2] * r[1] + at[1]) * r[0] + at[0]
                             : ylm_morton(at[0], at[1], at[2]);
  uint64_t *word = word_of(m, code), bit = (uint64_t)1 << (code & (((uint64_t)1 << m->shift) - 1));
  if (!word || __atomic_load_n(word, __ATOMIC_RELAXED) & bit) return;
  k->fresh += !(__atomic_fetch_or(word, bit, __ATOMIC_RELAXED) & bit);
  if (k->fresh < OCCUPIED_TOLD) return;
  m->marked += k->fresh;
  k->fresh = 0;
}

/* Marks those of the voxels first .. last that a triangle meets. */
static void mark_box(marker *k, const uint32_t first[3], const uint32_t last[3]) {
  int longest = 0;
  if (!ylm__triangle_meets(k->t, first, last) || k->m->marked > OCCUPIED_MOST) return;
  for (int a = 1; a < 3; a++)
    if (last[a] - first[a] > last[longest] - first[longest]) longest = a;
  if (last[longest] == first[longest]) {
    mark(k, first);
    return;
  }
  uint32_t middle[3], next[3];
  memcpy(middle, last, sizeof middle);
  memcpy(next, first, sizeof next);
  middle[longest] = first[longest] + (last[longest] - first[longest]) / 2;
  next[longest] = middle[longest] + 1;
  mark_box(k, first, middle);
  mark_box(k, next, last);
}

/* A triangle in lattice units; false where it is not wholly within the bounds. */
static bool set_triangle(const marking *m, size_t i, triangle *t) {
  double p[3][3];
  bool within = true;
  ylm__triangle_list_get(&m->list, i, p);
  for (int c = 0; c < 3; c++)
    for (int a = 0; a < 3; a++) {
      within &= p[c][a] >= m->bounds[a] && p[c][a] <= m->bounds[a + 3];
      p[c][a] = (p[c][a] - m->bounds[a]) * m->scale[a];
    }
  ylm__triangle_set(t, (const double(*)[3])p, m->margin);
  return within;
}

/* The voxels of part `part` of the lattice that the triangle's box meets; false: none. */
static bool range_of(const marking *m, const triangle *t, size_t part, uint32_t first[3],
                     uint32_t last[3]) {
  for (int a = 0; a < 3; a++) {
    uint64_t r = m->resolution[a], parts = (uint64_t)m->parts, k = part % parts;
    uint64_t lo = r * k / parts, end = r * (k + 1) / parts;
    part /= parts;
    if (lo == end || !ylm__triangle_range(t, a, (uint32_t)r, &first[a], &last[a])) return false;
    if (first[a] < lo) first[a] = (uint32_t)lo;
    if (last[a] >= end) last[a] = (uint32_t)(end - 1);
    if (first[a] > last[a]) return false;
  }
  return true;
}

/* Triangles of the list, once for each part of the lattice. */
static ylm_status mark_triangles(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  marking *m = context;
  uint64_t outside = 0;
  for (size_t i = begin; i < end; i++) {
    triangle t;
    uint32_t first[3], last[3];
    size_t part = i / m->list.triangles;
    outside += !set_triangle(m, i % m->list.triangles, &t) && m->counting && part == 0;
    if (!range_of(m, &t, part, first, last)) continue;
    marker k = {m, &t, 0};
    mark_box(&k, first, last);
    m->marked += k.fresh;
  }
  m->outside += outside;
  return YLM_OK;
}

/* -- passes ---------------------------------------------------------------------------------- */

/* Codes of what is marked, ascending, in place of those above. */
static ylm_status collect(marking *m, size_t *n) {
  size_t count = 0, k = 0;
  for (size_t i = 0; i < m->words; i++) count += (size_t)__builtin_popcountll(m->word[i]);
  uint64_t *code = ylm_alloc(count, sizeof *code);
  if (!code) return YLM_ENOMEM;
  for (size_t i = 0; i < m->words; i++)
    for (uint64_t left = m->word[i]; left; left &= left - 1)
      code[k++] = (m->above ? m->above[i] : i) << m->shift | (uint64_t)__builtin_ctzll(left);
  ylm_free(m->above);
  m->above = code;
  *n = count;
  return YLM_OK;
}

/* The origin that surfaces far from 0 were rounded relative to: that of the box around them. */
static void rounded_at(const marking *m, const ylm_grid *g, double origin[3]) {
  double box[6], p[3][3];
  memcpy(origin, g->origin, 3 * sizeof *origin);
  if (origin[0] == 0 && origin[1] == 0 && origin[2] == 0) return;
  for (size_t i = 0; i < m->list.triangles; i++) {
    ylm__triangle_list_get(&m->list, i, p);
    for (int k = 0; k < 9; k++) {
      double x = p[k / 3][k % 3];
      bool first = i == 0 && k < 3;
      box[k % 3] = first ? x : fmin(box[k % 3], x);
      box[k % 3 + 3] = first ? x : fmax(box[k % 3 + 3], x);
    }
  }
  if (m->list.triangles) ylm_origin(box, origin);
}

/* Marks the voxels of a lattice of which this one has 1/coarser along each axis. */
static ylm_status pass(marking *m, const ylm_grid *g, uint32_t coarser, size_t *n) {
  for (int a = 0; a < 3; a++) {
    const double *b = m->bounds;
    m->resolution[a] = g->contents.resolution[a] / coarser;
    m->scale[a] = g->scale[a] / coarser;
    double ulps =
        0x1p-22 * fmax(fabs(b[a] - m->origin[a]), fabs(b[a + 3] - m->origin[a])) * m->scale[a];
    m->margin[a] = fmin(ulps, 0.25) + 1e-9;
  }
  size_t items = m->list.triangles * (size_t)m->parts * (size_t)m->parts * (size_t)m->parts;
  m->marked = 0;
  m->word = ylm_alloc_zero(m->words, sizeof *m->word);
  ylm_status s = m->word ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK)
    s = ylm_parallel(items, m->parts > 1 ? 1 : 64, m->source->threads, mark_triangles, m,
                     m->source->progress, "occupancy");
  if (s == YLM_OK && m->marked > OCCUPIED_MOST) s = YLM_ELIMIT;
  if (s == YLM_OK) s = collect(m, n);
  ylm_free(m->word);
  return s;
}

/* A uniform grid's lattice, or an octree's levels from OCCUPIED_DENSE on. */
static ylm_status mark_all(marking *m, const ylm_grid *g, size_t *n) {
  const uint32_t *r = g->contents.resolution;
  int depth = g->contents.form.depth, level = m->uniform               ? 0
                                              : depth < OCCUPIED_DENSE ? depth
                                                                       : OCCUPIED_DENSE;
  m->shift = 6;
  m->counting = true;
  m->words =
      m->uniform ? ((size_t)r[0] * r[1] * r[2] + 63) / 64 : (((size_t)1 << 3 * level) + 63) / 64;
  ylm_status s = pass(m, g, m->uniform ? 1 : (uint32_t)1 << (depth - level), n);
  m->counting = false;
  while (s == YLM_OK && !m->uniform && level < depth) {
    int down = depth - level < OCCUPIED_STEP ? depth - level : OCCUPIED_STEP;
    level += down;
    m->shift = 3 * down;
    m->words = *n;
    s = pass(m, g, (uint32_t)1 << (depth - level), n);
  }
  return s;
}

ylm_status ylm_grid_surface_voxels(const ylm_grid *g, const ylm_grid_source *source,
                                   uint64_t **code, size_t *n, uint64_t *outside, ylm_error *e) {
  marking m = {.source = source,
               .bounds = g->contents.form.bounds,
               .uniform = g->contents.form.kind == YLM_GRID_UNIFORM};
  ylm_status s = ylm__triangle_list_make(&m.list, source->meshes, source->mesh);
  m.parts = m.list.triangles < OCCUPIED_FEW ? OCCUPIED_PARTS : 1;
  *n = 0;
  if (s == YLM_OK) rounded_at(&m, g, m.origin);
  if (s == YLM_OK) s = mark_all(&m, g, n);
  ylm__triangle_list_free(&m.list);
  *outside += m.outside;
  *code = m.above;
  if (s == YLM_OK && *n) return YLM_OK;
  ylm_free(m.above);
  *code = NULL;
  if (s == YLM_OK) return ylm_fail(e, YLM_EDOMAIN, "surfaces: no triangle lies within the bounds");
  if (s == YLM_ELIMIT)
    return ylm_fail(e, s,
                    "surfaces: they meet more than %zu of the finest voxels: take a smaller "
                    "depth, or points instead of surfaces",
                    OCCUPIED_MOST);
  return ylm_fail_plain(e, s);
}
