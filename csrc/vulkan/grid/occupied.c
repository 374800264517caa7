/*
** occupied.c - which voxels hold shading points, on a device: shaders/octree_voxel.comp; of an
** octree octree_mark.comp, of a uniform grid lattice_mark.comp.
*/
#include "occupied.h"
#include "../calibration.h"

#include <string.h>

/* -- where voxels begin -------------------------------------------------------------------- */

/* Numbers of a type in their order, as integers: octree_voxel.comp. */
static double number_of(ylm_dtype t, uint64_t order) {
  uint32_t high = (uint32_t)(t == YLM_DOUBLE ? order >> 32 : order), bits = bits_of_high(high);
  if (t == YLM_DOUBLE) {
    uint64_t both = (uint64_t)bits << 32 | bits_of_low(high, (uint32_t)order);
    double x;
    memcpy(&x, &both, sizeof x);
    return x;
  }
  float x;
  memcpy(&x, &bits, sizeof x);
  return (double)x;
}

/* The orders of minus and plus infinity. */
static void ends_of(ylm_dtype t, uint64_t *lo, uint64_t *hi) {
  const uint64_t infinity = t == YLM_DOUBLE ? 0x7ff0000000000000u : 0x7f800000u;
  const uint64_t sign = t == YLM_DOUBLE ? (uint64_t)1 << 63 : (uint64_t)1 << 31;
  *lo = sign - 1 - infinity;
  *hi = sign | infinity;
}

/* Questions about a number x of an axis: is it in voxel k or beyond; is it at least, beyond, x0? */
typedef struct question {
  const ylm_grid *grid;
  size_t axis;
  uint32_t voxel;
  int kind; /* 0: voxel; 1: at least x0; 2: beyond x0 */
  double x0;
} question;

static bool holds(const question *q, double x) {
  uint32_t voxel[3];
  double p[3] = {x, x, x};
  if (q->kind) return q->kind == 1 ? x >= q->x0 : x > q->x0;
  ylm_grid_voxel(q->grid, p, voxel);
  return voxel[q->axis] >= q->voxel;
}

/* The order of the first number for which it holds (infinity's if for none). */
static uint64_t first_of(ylm_dtype t, const question *q, uint64_t lo, uint64_t hi) {
  while (lo < hi) {
    uint64_t middle = lo + (hi - lo) / 2;
    if (holds(q, number_of(t, middle)))
      hi = middle;
    else
      lo = middle + 1;
  }
  return lo;
}

/* Two words, the high one first; a float's one word is the high one. */
static void put(uint32_t to[2], ylm_dtype t, uint64_t order) {
  to[0] = t == YLM_DOUBLE ? (uint32_t)(order >> 32) : (uint32_t)order;
  to[1] = t == YLM_DOUBLE ? (uint32_t)order : 0;
}

static ylm_status upload_fences(const occupied_voxels *o, ylm_gpu_buffer **fences) {
  ylm_dtype type = o->source->occupied_dtype;
  const ylm_grid_contents *v = ylm_grid_look(o->grid);
  const uint32_t *r = v->resolution;
  size_t inner = (size_t)r[0] + r[1] + r[2] - 3, n = inner + 6, at = 0;
  uint32_t(*fence)[2] = ylm_alloc(n, sizeof *fence);
  uint64_t lo, hi;
  if (!fence) return ylm_no_memory(o->e);
  ends_of(type, &lo, &hi);
  for (size_t a = 0; a < 3; a++) {
    question begin = {o->grid, a, 0, 1, v->form.bounds[a]},
             end = {o->grid, a, 0, 2, v->form.bounds[a + 3]};
    uint64_t from = first_of(type, &begin, lo, hi), to = first_of(type, &end, from, hi);
    put(fence[inner + 2 * a], type, from);
    put(fence[inner + 2 * a + 1], type, to - 1);
    for (uint32_t k = 1; k < r[a]; k++, at++) {
      question q = {o->grid, a, k, 0, 0};
      from = first_of(type, &q, from, to);
      put(fence[at], type, from);
    }
  }
  ylm_status s = ylm_gpu_buffer_from(o->l->gpu, n * sizeof *fence, fence, fences, o->e);
  ylm_free(fence);
  return s;
}

/* -- voxels of points ------------------------------------------------------------------------ */

/* Shading points on the device: chunks of their voxels and ranks. */
typedef struct shading {
  ylm_gpu_buffer **place;
  size_t chunks;
} shading;

static size_t chunk_size(const occupied_voxels *o, size_t i) {
  size_t left = o->source->occupied - i * OCCUPIED_POINTS;
  return left < OCCUPIED_POINTS ? left : OCCUPIED_POINTS;
}

/* Queues finding the voxels of chunk i, whose points are in a buffer, or are all there. */
static void find_chunk(occupied_voxels *o, const shading *p, size_t i, ylm_gpu_buffer *points,
                       ylm_gpu_buffer *fences) {
  const uint32_t *r = ylm_grid_look(o->grid)->resolution;
  size_t n = chunk_size(o, i), row = 3 * ylm_dtype_size(o->source->occupied_dtype);
  uint32_t words = (uint32_t)row / 12, one = 1;
  uint8_t low;
  memcpy(&low, &one, 1); /* the high word of a double comes last where low bytes come first */
  step_kernel k = {"octree_voxel", 1, {words, 0}, 0};
  uint32_t push[] = {(uint32_t)n, (uint32_t)(i * OCCUPIED_POINTS), low, r[0], r[1], r[2]};
  ylm_gpu_buffer *bind[] = {points, fences, p->place[i], o->counts};
  ylm__steps_dispatch(o->q, &k, n, 6, push, 4, bind);
  if (o->there) ylm__steps_part(o->q, 0, i * OCCUPIED_POINTS * row, n * row);
}

/* Chunk after chunk, uploaded where they are not there; the device keeps their voxels. */
static ylm_status find_voxels(occupied_voxels *o, shading *p) {
  const ylm_grid_source *source = o->source;
  size_t row = 3 * ylm_dtype_size(source->occupied_dtype);
  ylm_gpu *g = o->l->gpu;
  ylm_gpu_buffer *fences = NULL, *points = NULL;
  double start = ylm_seconds();
  ylm_status s = upload_fences(o, &fences);
  if (s == YLM_OK && !o->there) s = ylm_gpu_buffer_create(g, chunk_size(o, 0) * row, &points, o->e);
  ylm__lights_copied(o->l, "upload", start);
  for (size_t i = 0; s == YLM_OK && i < p->chunks; i++) {
    size_t n = chunk_size(o, i);
    start = ylm_seconds();
    if (!o->there)
      s = ylm_gpu_upload(points, 0, n * row,
                         (const char *)source->occupied_points + i * OCCUPIED_POINTS * row, o->e);
    if (!o->there) ylm__lights_copied(o->l, "upload", start);
    if (s == YLM_OK) s = ylm_gpu_buffer_create(g, n * 12, &p->place[i], o->e);
    if (s != YLM_OK) break;
    find_chunk(o, p, i, o->there ? o->there : points, fences);
    s = ylm__steps_run(o->q);
  }
  ylm_gpu_buffer_free(fences);
  ylm_gpu_buffer_free(points);
  return s;
}

/* -- levels -------------------------------------------------------------------------------- */

static ylm_status reserve_level(occupied_voxels *o, occupied_level *v, uint64_t words) {
  v->words = (uint32_t)words;
  ylm_status s = ylm_gpu_buffer_create(o->l->gpu, 4 * words, &v->bits, o->e);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(o->l->gpu, 4 * words, &v->before, o->e);
  if (s == YLM_OK) ylm__steps_fill(o->q, v->bits, 0);
  return s;
}

/* Queues a level; `nodes` bounds how many of the level above hold points. */
static ylm_status mark_level(occupied_voxels *o, const shading *p, int level, uint64_t nodes) {
  occupied_level *v = &o->level[level], *above = level > 1 ? v - 1 : v;
  int depth = ylm_grid_look(o->grid)->form.depth;
  ylm_status s = reserve_level(o, v, (nodes + 3) / 4);
  for (size_t i = 0; s == YLM_OK && i < p->chunks; i++) {
    step_kernel k = {"octree_mark", 0, {0, 0}, 0};
    uint32_t push[] = {(uint32_t)chunk_size(o, i), (uint32_t)level, (uint32_t)(depth - level)};
    ylm_gpu_buffer *bind[] = {p->place[i], v->bits, above->bits, above->before};
    ylm__steps_dispatch(o->q, &k, push[0], 3, push, 4, bind);
  }
  if (s == YLM_OK)
    ylm__steps_scan(o->q, SCAN_BITS, UINT32_MAX, v->bits, v->words, v->before, o->counts,
                    SCAN_NO_SUM);
  return s;
}

static ylm_status mark_octree(occupied_voxels *o, const shading *p) {
  uint64_t nodes = 1, n = o->source->occupied; /* of a level: no more than there are, nor than n */
  int depth = ylm_grid_look(o->grid)->form.depth;
  ylm_status s = YLM_OK;
  for (int level = 1; s == YLM_OK && level <= depth; level++) {
    s = mark_level(o, p, level, nodes);
    nodes = 8 * nodes < n ? 8 * nodes : n;
  }
  return s;
}

static ylm_status mark_lattice(occupied_voxels *o, const shading *p) {
  const uint32_t *r = ylm_grid_look(o->grid)->resolution;
  occupied_level *v = &o->level[0];
  ylm_status s = reserve_level(o, v, ((uint64_t)r[0] * r[1] * r[2] + 31) / 32);
  for (size_t i = 0; s == YLM_OK && i < p->chunks; i++) {
    step_kernel k = {"lattice_mark", 0, {0}, 0};
    uint32_t push[] = {(uint32_t)chunk_size(o, i), r[0], r[1]};
    ylm_gpu_buffer *bind[] = {p->place[i], v->bits};
    ylm__steps_dispatch(o->q, &k, push[0], 3, push, 2, bind);
  }
  if (s == YLM_OK)
    ylm__steps_scan(o->q, SCAN_BITS, UINT32_MAX, v->bits, v->words, v->before, o->counts,
                    YLM_GPU_COUNT_VOXELS);
  return s;
}

ylm_status ylm__occupied_mark(occupied_voxels *o, uint32_t count[YLM_GPU_COUNTS]) {
  size_t n = o->source->occupied;
  bool uniform = ylm_grid_look(o->grid)->form.kind == YLM_GRID_UNIFORM;
  if (n > UINT32_MAX / 8)
    return ylm_fail(o->e, YLM_ELIMIT, "more than 2^29 shading points on a device");
  shading p = {.chunks = (n + OCCUPIED_POINTS - 1) / OCCUPIED_POINTS};
  p.place = ylm_alloc_zero(p.chunks, sizeof *p.place);
  ylm_status s = p.place ? YLM_OK : ylm_no_memory(o->e);
  if (s == YLM_OK) s = find_voxels(o, &p);
  if (s == YLM_OK) s = (uniform ? mark_lattice : mark_octree)(o, &p);
  if (s == YLM_OK) s = ylm__steps_counts(o->q, o->counts, YLM_GPU_COUNTS, count);
  for (size_t i = 0; p.place && i < p.chunks; i++) ylm_gpu_buffer_free(p.place[i]);
  ylm_free(p.place);
  if (s != YLM_OK || !count[YLM_GPU_COUNT_BAD]) return s;
  return ylm_fail(o->e, YLM_EDOMAIN, "occupied: point %u is not finite",
                  ~count[YLM_GPU_COUNT_BAD] + 1);
}

void ylm__occupied_free(occupied_voxels *o) {
  for (int k = 0; k < OCTREE_LEVELS; k++) {
    ylm_gpu_buffer_free(o->level[k].bits);
    ylm_gpu_buffer_free(o->level[k].before);
  }
}
