/* occupancy.c - the occupancy octree, built bottom-up from shading points or marked voxels. */
#include "../grid.h"
#include "calibration.h"

#include <string.h>

/* Point i of the source in double. */
static void source_point(const ylm_grid_source *s, size_t i, double p[3]) {
  for (int a = 0; a < 3; a++)
    p[a] = ylm_get(s->occupied_dtype, s->occupied_points, 3 * i + (size_t)a);
}

/* The finest lattice cell of point i. */
static bool source_cell(const ylm_grid *g, const ylm_grid_source *s, size_t i, uint32_t cell[3]) {
  double p[3], at[3];
  source_point(s, i, p);
  bool inside = ylm__grid_coordinates(g, p, at);
  for (int a = 0; a < 3; a++) {
    uint32_t last = g->contents.resolution[a] - 1, c = (uint32_t)at[a];
    cell[a] = c > last ? last : c;
  }
  return inside;
}

/* -- codes of the finest nodes, sorted ------------------------------------------------------- */

/* A block of points is a list of its own while codes are collected. Radix sort counts and moves block
   by block, so that threads do not meet and the order is always the same. */
#define DIGITS (1u << SORT_BITS)

typedef struct code_job {
  const ylm_grid *g;
  const ylm_grid_source *source;
  occupancy *o;
  uint64_t *from, *to;
  size_t n, *length; /* codes; of each block, while the blocks have gaps between them: else NULL */
  uint32_t (*place)[DIGITS]; /* [blocks]: counts, then places, of digits */
  int shift;
  _Atomic uint64_t outside;
} code_job;

static void set_bit(uint8_t *bits, uint64_t i) {
  uint8_t bit = (uint8_t)(1u << (i & 7));
  if (!(__atomic_load_n(&bits[i >> 3], __ATOMIC_RELAXED) & bit))
    __atomic_fetch_or(&bits[i >> 3], bit, __ATOMIC_RELAXED);
}

/* Codes of a block of points: into the bits, or listed without those that repeat the one before. */
static ylm_status find_codes(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  code_job *j = context;
  uint64_t outside = 0, *list = j->from ? j->from + begin : NULL;
  size_t n = 0;
  for (size_t i = begin; i < end; i++) {
    uint32_t c[3];
    outside += !source_cell(j->g, j->source, i, c);
    uint64_t code = ylm_morton(c[0], c[1], c[2]);
    if (!list)
      set_bit(j->o->bits[j->o->dense], code);
    else if (!n || list[n - 1] != code)
      list[n++] = code;
  }
  if (list) j->length[begin / SORT_BLOCK] = n;
  j->outside += outside;
  return YLM_OK;
}

static size_t block_end(const code_job *j, size_t begin, size_t end) {
  return j->length ? begin + j->length[begin / SORT_BLOCK] : end;
}

static ylm_status count_digits(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  code_job *j = context;
  uint32_t *count = j->place[begin / SORT_BLOCK];
  memset(count, 0, sizeof *j->place);
  end = block_end(j, begin, end);
  for (size_t i = begin; i < end; i++) count[j->from[i] >> j->shift & (DIGITS - 1)]++;
  return YLM_OK;
}

static ylm_status move_codes(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  code_job *j = context;
  uint32_t *next = j->place[begin / SORT_BLOCK];
  end = block_end(j, begin, end);
  for (size_t i = begin; i < end; i++)
    j->to[next[j->from[i] >> j->shift & (DIGITS - 1)]++] = j->from[i];
  return YLM_OK;
}

/* One pass of radix sort, least significant digits first. */
static void sort_by_digit(code_job *j, int threads) {
  size_t blocks = (j->n + SORT_BLOCK - 1) / SORT_BLOCK;
  uint32_t sum = 0;
  ylm_parallel(j->n, SORT_BLOCK, threads, count_digits, j, NULL, NULL);
  for (uint32_t d = 0; d < DIGITS; d++)
    for (size_t b = 0; b < blocks; b++) {
      uint32_t count = j->place[b][d];
      j->place[b][d] = sum;
      sum += count;
    }
  ylm_parallel(j->n, SORT_BLOCK, threads, move_codes, j, NULL, NULL);
  uint64_t *swap = j->from;
  j->from = j->to;
  j->to = swap;
  j->n = sum;
  j->length = NULL;
}

/* Codes of the finest nodes, sorted and unique, into o->code. */
static ylm_status collect_codes(code_job *j, int threads) {
  occupancy *o = j->o;
  size_t n = j->n = j->source->occupied, blocks = (n + SORT_BLOCK - 1) / SORT_BLOCK;
  size_t *length = j->length = ylm_alloc(blocks, sizeof *length);
  j->place = ylm_alloc(blocks, sizeof *j->place);
  j->from = ylm_alloc(n, sizeof *j->from);
  j->to = ylm_alloc(n, sizeof *j->to);
  bool ok = j->length && j->place && j->from && j->to && n < UINT32_MAX;
  if (ok) {
    ylm_parallel(n, SORT_BLOCK, threads, find_codes, j, NULL, NULL);
    for (j->shift = 0; j->shift < 3 * o->depth; j->shift += SORT_BITS) sort_by_digit(j, threads);
    for (size_t i = 0; i < j->n; i++)
      if (!o->codes || j->from[o->codes - 1] != j->from[i]) j->from[o->codes++] = j->from[i];
    o->code = ylm_realloc(j->from, o->codes * sizeof *o->code, o->codes, sizeof *o->code);
    if (o->code) j->from = NULL;
  }
  ylm_free(length);
  ylm_free(j->place);
  ylm_free(j->from);
  ylm_free(j->to);
  return o->code ? YLM_OK : YLM_ENOMEM;
}

/* -- the octree ------------------------------------------------------------------------------ */

/* A node is occupied where one of its eight children, a byte of the level below, is. */
static void mark_parents(occupancy *o) {
  for (int level = o->dense; level > 0; level--)
    for (uint64_t i = 0, n = (uint64_t)1 << 3 * (level - 1); i < n; i++) {
      uint64_t eight = 0; /* the children of eight nodes: mostly none */
      if (i % 8 == 0 && n - i >= 8) memcpy(&eight, o->bits[level] + i, 8);
      if (i % 8 == 0 && n - i >= 8 && !eight)
        i += 7;
      else if (o->bits[level][i])
        set_bit(o->bits[level - 1], i);
    }
}

void ylm__occupancy_mark(occupancy *o, int level, uint64_t code) { set_bit(o->bits[level], code); }

void ylm__occupancy_mark_parents(occupancy *o) { mark_parents(o); }

static ylm_status begin(occupancy *o, const ylm_grid *g) {
  *o = (occupancy){.depth = g->contents.form.depth};
  o->dense = o->depth < OCCUPIED_DENSE ? o->depth : OCCUPIED_DENSE;
  for (int level = 0; level <= o->dense; level++) {
    o->bits[level] = ylm_alloc_zero((((size_t)1 << 3 * level) + 7) / 8, 1);
    if (!o->bits[level]) return YLM_ENOMEM;
  }
  return YLM_OK;
}

/* Levels 0 .. dense from codes. */
static void mark_codes(occupancy *o, const uint64_t *code, size_t n) {
  for (size_t i = 0; i < n; i++) set_bit(o->bits[o->dense], code[i] >> 3 * (o->depth - o->dense));
}

ylm_status ylm__occupancy_build(occupancy *o, const ylm_grid *g, const ylm_grid_source *s,
                                uint64_t *outside) {
  *o = (occupancy){.depth = g->contents.form.depth, .all = !s->occupied_points};
  if (o->all) return YLM_OK;
  ylm_status status = begin(o, g);
  code_job j = {.g = g, .source = s, .o = o};
  if (status == YLM_OK && o->depth > o->dense) {
    status = collect_codes(&j, s->threads);
    mark_codes(o, o->code, o->codes);
  } else if (status == YLM_OK)
    ylm_parallel(s->occupied, SORT_BLOCK, s->threads, find_codes, &j, NULL, NULL);
  if (status != YLM_OK) return status;
  *outside += j.outside;
  mark_parents(o);
  return YLM_OK;
}

ylm_status ylm__occupancy_take(occupancy *o, const ylm_grid *g, uint64_t *code, size_t n) {
  ylm_status status = begin(o, g);
  if (status == YLM_OK) mark_codes(o, code, n);
  if (status == YLM_OK) mark_parents(o);
  if (status == YLM_OK && o->depth > o->dense) {
    o->code = code;
    o->codes = n;
  } else
    ylm_free(code);
  return status;
}

ylm_status ylm__occupancy_from_surfaces(occupancy *o, const ylm_grid *g, const ylm_grid_source *s,
                                        uint64_t *outside, ylm_error *e) {
  uint64_t *code;
  size_t n;
  ylm_status status = ylm_grid_surface_voxels(g, s, &code, &n, outside, e);
  return status == YLM_OK ? ylm__occupancy_take(o, g, code, n) : status;
}

/* The place of the first code from `first` on, looked for behind `begin`. */
static size_t code_from(const occupancy *o, size_t begin, uint64_t first) {
  size_t step = 1, lo = begin, hi = begin;
  while (hi < o->codes && o->code[hi] < first) {
    lo = hi + 1;
    hi += step;
    step *= 2;
  }
  if (hi > o->codes) hi = o->codes;
  while (lo < hi) {
    size_t mid = lo + (hi - lo) / 2;
    if (o->code[mid] < first)
      lo = mid + 1;
    else
      hi = mid;
  }
  return lo;
}

uint8_t ylm__occupancy_children(const occupancy *o, int level, const uint32_t origin[3]) {
  if (o->all) return 0xff;
  int below = o->depth - level;
  uint64_t code = ylm_morton(origin[0] >> below, origin[1] >> below, origin[2] >> below);
  if (level < o->dense) return o->bits[level + 1][code];
  int shift = 3 * (below - 1); /* from codes to the children's */
  uint8_t children = 0;
  for (size_t i = code_from(o, 0, code << 3 << shift);
       i < o->codes && o->code[i] >> shift >> 3 == code;) {
    uint64_t child = o->code[i] >> shift;
    children |= (uint8_t)(1u << (child & 7));
    i = code_from(o, i, (child + 1) << shift);
  }
  return children;
}

/* -- uniform grids --------------------------------------------------------------------------- */

typedef struct mark_job {
  const ylm_grid *g;
  const ylm_grid_source *source;
  uint8_t *mark;
  _Atomic uint64_t outside;
} mark_job;

static ylm_status mark_voxels(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  mark_job *j = context;
  const uint32_t *r = j->g->contents.resolution;
  uint64_t outside = 0;
  for (size_t i = begin; i < end; i++) {
    uint32_t c[3];
    outside += !source_cell(j->g, j->source, i, c);
    __atomic_store_n(&j->mark[((size_t)c[2] * r[1] + c[1]) * r[0] + c[0]], 1, __ATOMIC_RELAXED);
  }
  j->outside += outside;
  return YLM_OK;
}

void ylm__occupancy_mark_uniform(const ylm_grid *g, const ylm_grid_source *s, uint8_t *mark,
                                 uint64_t *outside) {
  mark_job j = {.g = g, .source = s, .mark = mark};
  ylm_parallel(s->occupied, SORT_BLOCK, s->threads, mark_voxels, &j, NULL, NULL);
  *outside += j.outside;
}

void ylm__occupancy_free(occupancy *o) {
  for (int level = 0; level <= OCCUPIED_DENSE; level++) ylm_free(o->bits[level]);
  ylm_free(o->code);
  *o = (occupancy){0};
}
