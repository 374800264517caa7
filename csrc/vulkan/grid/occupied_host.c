/* occupied_host.c - voxels that hold shading points, and some of these, brought to the host. */
#include "occupied.h"

/* -- voxels --------------------------------------------------------------------------------- */

/* Codes of a level's nodes from those of the level above, *n of them, whose bits say which of their
   children there are; frees those. */
static ylm_status descend(const occupied_level *v, uint64_t **code, size_t *n, ylm_error *e) {
  size_t words = (*n + 3) / 4, more = 0;
  uint32_t *bits = ylm_alloc(words, sizeof *bits);
  ylm_status s = bits ? YLM_OK : ylm_no_memory(e);
  if (s == YLM_OK) s = ylm_gpu_download(v->bits, 0, words * sizeof *bits, bits, e);
  for (size_t i = 0; s == YLM_OK && i < words; i++) more += (size_t)__builtin_popcount(bits[i]);
  uint64_t *next = s == YLM_OK ? ylm_alloc(more, sizeof *next) : NULL;
  if (s == YLM_OK && !next) s = ylm_no_memory(e);
  size_t k = 0;
  for (size_t i = 0; s == YLM_OK && i < *n; i++)
    for (uint32_t left = bits[i / 4] >> i % 4 * 8 & 0xff; left && k < more; left &= left - 1)
      next[k++] = (*code)[i] << 3 | (uint32_t)__builtin_ctz(left);
  ylm_free(bits);
  ylm_free(*code);
  *code = next;
  *n = k;
  return s;
}

ylm_status ylm__occupied_codes(const occupied_voxels *o, uint64_t **code, size_t *n) {
  int depth = ylm_grid_look(o->grid)->form.depth;
  double start = ylm_seconds();
  *n = 1;
  *code = ylm_alloc_zero(1, sizeof **code);
  ylm_status s = *code ? YLM_OK : ylm_no_memory(o->e);
  for (int level = 1; s == YLM_OK && level <= depth; level++)
    s = descend(&o->level[level], code, n, o->e);
  ylm__lights_copied(o->l, "download", start);
  if (s != YLM_OK) ylm_free(*code);
  return s;
}

/* -- points ----------------------------------------------------------------------------------- */

/* Copies rows of the points `index` to `rows`: as many dispatches as there are parts that a kernel
   sees of all points. */
static ylm_status gather(const occupied_voxels *o, size_t n, ylm_gpu_buffer *index,
                         ylm_gpu_buffer *rows) {
  size_t row = 3 * ylm_dtype_size(o->source->occupied_dtype), all = o->source->occupied;
  size_t most = ylm_gpu_rows(o->l->gpu, all, row, row, UINT64_MAX);
  if (!most) return ylm_fail_plain(o->e, YLM_ELIMIT);
  for (size_t at = 0, now; at < all; at += now) {
    now = all - at < most ? all - at : most;
    step_kernel k = {"shading_take", 1, {(uint32_t)row / 4}, 0};
    uint32_t push[] = {(uint32_t)n, (uint32_t)at, (uint32_t)(at + now)};
    ylm_gpu_buffer *bind[] = {o->there, index, rows};
    ylm__steps_dispatch(o->q, &k, n * (row / 4), 3, push, 3, bind);
    ylm__steps_part(o->q, 0, at * row, now * row);
  }
  return ylm__steps_run(o->q);
}

ylm_status ylm__occupied_points(const occupied_voxels *o, size_t n, const size_t *index,
                                float *out) {
  bool wide = o->source->occupied_dtype == YLM_DOUBLE;
  size_t row = wide ? 24 : 12;
  uint32_t *which = ylm_alloc(n, sizeof *which);
  double *rows = ylm_alloc(n, row);
  ylm_gpu_buffer *there = NULL, *taken = NULL;
  ylm_status s = which && rows ? YLM_OK : ylm_no_memory(o->e);
  for (size_t i = 0; s == YLM_OK && i < n; i++) which[i] = (uint32_t)index[i];
  if (s == YLM_OK) s = ylm_gpu_buffer_from(o->l->gpu, 4 * n, which, &there, o->e);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(o->l->gpu, n * row, &taken, o->e);
  if (s == YLM_OK) s = gather(o, n, there, taken);
  if (s == YLM_OK) s = ylm_gpu_download(taken, 0, n * row, wide ? (void *)rows : out, o->e);
  for (size_t i = 0; s == YLM_OK && wide && i < 3 * n; i++) out[i] = (float)rows[i];
  ylm_gpu_buffer_free(there);
  ylm_gpu_buffer_free(taken);
  ylm_free(which);
  ylm_free(rows);
  return s;
}

ylm_status ylm__occupied_fetch(const ylm_grid_source *source, const ylm_gpu_buffer *there,
                               void **points, ylm_error *e) {
  size_t row = 3 * ylm_dtype_size(source->occupied_dtype);
  *points = ylm_alloc(source->occupied, row);
  if (!*points) return ylm_no_memory(e);
  return ylm_gpu_download(there, 0, source->occupied * row, *points, e);
}
