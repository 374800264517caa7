/*
** octree_occupancy.c - which voxels hold shading points, on a device: shaders/octree_voxel.comp; of
** an octree octree_mark.comp, of a uniform grid lattice_mark.comp, lattice_voxel.comp.
*/
#include <string.h>

#include "octree.h"

#define CHUNK ((size_t)1 << 20) /* shading points of one dispatch */

/* -- where voxels begin -------------------------------------------------------------------- */

/* Numbers of a type in their order, as integers: octree_voxel.comp. */
static double number_of(ylm_dtype t, uint64_t order) {
  if (t == YLM_DOUBLE) {
    uint64_t bits = order >> 63 ? order & ~((uint64_t)1 << 63) : ~order;
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
  }
  uint32_t o = (uint32_t)order, bits = o >> 31 ? o & 0x7fffffffu : ~o;
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

/* What is asked of a number x of an axis: is it in voxel k or beyond; is it at least, beyond, x0?
 */
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

static ylm_status upload_fences(octree *t, ylm_gpu_buffer **fences) {
  ylm_dtype type = t->source->occupied_dtype;
  const uint32_t *r = ylm_grid_look(t->grid)->resolution;
  size_t inner = (size_t)r[0] + r[1] + r[2] - 3, n = inner + 6, at = 0;
  uint32_t(*fence)[2] = ylm_alloc(n, sizeof *fence);
  uint64_t lo, hi;
  if (!fence) return ylm_fail(t->e, YLM_ENOMEM, "%s", ylm_status_text(YLM_ENOMEM));
  ends_of(type, &lo, &hi);
  for (size_t a = 0; a < 3; a++) {
    question begin = {t->grid, a, 0, 1, t->form.bounds[a]},
             end = {t->grid, a, 0, 2, t->form.bounds[a + 3]};
    uint64_t from = first_of(type, &begin, lo, hi), to = first_of(type, &end, from, hi);
    put(fence[inner + 2 * a], type, from);
    put(fence[inner + 2 * a + 1], type, to - 1);
    for (uint32_t k = 1; k < r[a]; k++, at++) {
      question q = {t->grid, a, k, 0, 0};
      from = first_of(type, &q, from, to);
      put(fence[at], type, from);
    }
  }
  ylm_status s = ylm_gpu_buffer_from(t->g, n * sizeof *fence, fence, fences, t->e);
  ylm_free(fence);
  return s;
}

/* -- levels -------------------------------------------------------------------------------- */

/* Shading points on the device: chunks of their voxels and ranks. */
typedef struct shading {
  ylm_gpu_buffer **place;
  size_t chunks;
} shading;

static size_t chunk_size(const octree *t, size_t i) {
  size_t left = t->source->occupied - i * CHUNK;
  return left < CHUNK ? left : CHUNK;
}

/* Uploads chunk after chunk; the device keeps their voxels. */
static ylm_status find_voxels(octree *t, shading *p) {
  const ylm_grid_source *source = t->source;
  const uint32_t *r = ylm_grid_look(t->grid)->resolution;
  size_t row = 3 * ylm_dtype_size(source->occupied_dtype);
  uint32_t words = (uint32_t)row / 12, one = 1, high;
  ylm_gpu_buffer *fences = NULL, *points = NULL;
  uint8_t low;
  memcpy(&low, &one, 1);
  high = low; /* the high word of a double comes last where low bytes come first */
  double start = ylm_seconds();
  ylm_status s = upload_fences(t, &fences);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(t->g, chunk_size(t, 0) * row, &points, t->e);
  ylm__lights_copied(t->l, "upload", start);
  for (size_t i = 0; s == YLM_OK && i < p->chunks; i++) {
    size_t n = chunk_size(t, i);
    start = ylm_seconds();
    s = ylm_gpu_upload(points, 0, n * row, (const char *)source->occupied_points + i * CHUNK * row,
                       t->e);
    ylm__lights_copied(t->l, "upload", start);
    if (s == YLM_OK) s = ylm_gpu_buffer_create(t->g, n * 12, &p->place[i], t->e);
    step_kernel k = {"octree_voxel", 1, {words, 0}, 0};
    uint32_t push[] = {(uint32_t)n, high, r[0], r[1], r[2]};
    ylm_gpu_buffer *bind[] = {points, fences, p->place[i], t->counts};
    steps_dispatch(&t->q, &k, n, 5, push, 4, bind);
    if (s == YLM_OK) s = steps_run(&t->q);
  }
  ylm_gpu_buffer_free(fences);
  ylm_gpu_buffer_free(points);
  return s;
}

/* Queues a level; `nodes` bounds how many of the level above hold points. */
static ylm_status mark_level(octree *t, const shading *p, int level, uint64_t nodes) {
  octree_occupied *o = &t->occupied[level], *above = level > 1 ? o - 1 : o;
  o->words = (uint32_t)((nodes + 3) / 4);
  ylm_status s = ylm_gpu_buffer_create(t->g, 4 * (uint64_t)o->words, &o->bits, t->e);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(t->g, 4 * (uint64_t)o->words, &o->before, t->e);
  if (s != YLM_OK) return s;
  steps_fill(&t->q, o->bits, 0);
  for (size_t i = 0; i < p->chunks; i++) {
    step_kernel k = {"octree_mark", 0, {0, 0}, 0};
    uint32_t push[] = {(uint32_t)chunk_size(t, i), (uint32_t)level,
                       (uint32_t)(t->form.depth - level)};
    ylm_gpu_buffer *bind[] = {p->place[i], o->bits, above->bits, above->before};
    steps_dispatch(&t->q, &k, push[0], 3, push, 4, bind);
  }
  steps_scan(&t->q, SCAN_BITS, UINT32_MAX, o->bits, o->words, o->before, t->counts, SCAN_NO_SUM);
  return YLM_OK;
}

static ylm_status mark_octree(octree *t, const shading *p) {
  uint64_t nodes = 1, n = t->source->occupied; /* of a level: no more than there are, nor than n */
  ylm_status s = YLM_OK;
  for (int level = 1; s == YLM_OK && level <= t->form.depth; level++) {
    s = mark_level(t, p, level, nodes);
    nodes = 8 * nodes < n ? 8 * nodes : n;
  }
  return s;
}

/* -- uniform grids ---------------------------------------------------------------------------- */

static uint32_t lattice_voxels(const octree *t) {
  const uint32_t *r = ylm_grid_look(t->grid)->resolution;
  return r[0] * r[1] * r[2];
}

static ylm_status mark_lattice(octree *t, const shading *p) {
  const uint32_t *r = ylm_grid_look(t->grid)->resolution;
  octree_occupied *o = &t->occupied[0];
  o->words = (lattice_voxels(t) + 31) / 32;
  ylm_status s = ylm_gpu_buffer_create(t->g, 4 * (uint64_t)o->words, &o->bits, t->e);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(t->g, 4 * (uint64_t)o->words, &o->before, t->e);
  if (s != YLM_OK) return s;
  steps_fill(&t->q, o->bits, 0);
  for (size_t i = 0; i < p->chunks; i++) {
    step_kernel k = {"lattice_mark", 0, {0}, 0};
    uint32_t push[] = {(uint32_t)chunk_size(t, i), r[0], r[1]};
    ylm_gpu_buffer *bind[] = {p->place[i], o->bits};
    steps_dispatch(&t->q, &k, push[0], 3, push, 2, bind);
  }
  steps_scan(&t->q, SCAN_BITS, UINT32_MAX, o->bits, o->words, o->before, t->counts, COUNT_VOXELS);
  return YLM_OK;
}

/* The voxels of the only level there is. */
static ylm_status list_voxels(octree *t, uint32_t voxels) {
  const uint32_t *r = ylm_grid_look(t->grid)->resolution;
  const octree_occupied *o = &t->occupied[0];
  octree_level *v = &t->level[0];
  v->voxels = voxels;
  t->levels = 1;
  ylm_status s = ylm_gpu_buffer_create(t->g, 16 * (uint64_t)voxels, &v->voxel, t->e);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(t->g, 4 * (uint64_t)voxels, &v->state, t->e);
  if (s != YLM_OK) return s;
  step_kernel k = {"lattice_voxel", 0, {0}, 0};
  uint32_t push[] = {lattice_voxels(t), r[0], r[1], t->all};
  ylm_gpu_buffer *bind[] = {o->bits, o->before, v->voxel};
  steps_fill(&t->q, v->state, 0);
  steps_dispatch(&t->q, &k, push[0], 4, push, 3, bind);
  return steps_run(&t->q);
}

/* -- both -------------------------------------------------------------------------------------- */

/* Marks what holds shading points; how many voxels a uniform grid has. */
static ylm_status mark(octree *t, uint32_t *voxels) {
  size_t n = t->source->occupied;
  uint32_t count[COUNTS];
  if (n > UINT32_MAX / 8)
    return ylm_fail(t->e, YLM_ELIMIT, "more than 2^29 shading points on a device");
  shading p = {.chunks = (n + CHUNK - 1) / CHUNK};
  p.place = ylm_alloc_zero(p.chunks, sizeof *p.place);
  ylm_status s = p.place ? YLM_OK : ylm_fail(t->e, YLM_ENOMEM, "%s", ylm_status_text(YLM_ENOMEM));
  if (s == YLM_OK) s = find_voxels(t, &p);
  if (s == YLM_OK) s = (t->uniform ? mark_lattice : mark_octree)(t, &p);
  if (s == YLM_OK) s = octree_counts(t, count);
  if (s == YLM_OK) t->stats->outside = count[COUNT_OUTSIDE];
  if (s == YLM_OK) *voxels = count[COUNT_VOXELS];
  for (size_t i = 0; p.place && i < p.chunks; i++) ylm_gpu_buffer_free(p.place[i]);
  ylm_free(p.place);
  return s;
}

ylm_status octree_occupy(octree *t) {
  octree_occupied *o = &t->occupied[0];
  uint32_t voxels = t->all ? lattice_voxels(t) : 0;
  ylm_status s = YLM_OK;
  if (!t->all)
    s = mark(t, &voxels);
  else { /* bound, not read */
    s = ylm_gpu_buffer_create(t->g, 4, &o->bits, t->e);
    if (s == YLM_OK) s = ylm_gpu_buffer_create(t->g, 4, &o->before, t->e);
  }
  return s == YLM_OK && t->uniform ? list_voxels(t, voxels) : s;
}
