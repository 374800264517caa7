/*
** occupied_surface.c - voxels that surfaces meet: the processor finds them, a device gets the bits.
*/
#include "occupied.h"

/* A level's bits to the device; takes them. */
static ylm_status upload_bits(occupied_voxels *o, occupied_level *v, uint32_t *bits, size_t words) {
  ylm_gpu *g = o->l->gpu;
  double start = ylm_seconds();
  v->words = (uint32_t)words;
  ylm_status s =
      bits ? ylm_gpu_buffer_from(g, 4 * words, bits, &v->bits, o->e) : ylm_no_memory(o->e);
  ylm__lights_copied(o->l, "upload", start);
  ylm_free(bits);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(g, 4 * words, &v->before, o->e);
  if (s != YLM_OK) return s;
  ylm__steps_scan(o->q, SCAN_BITS, UINT32_MAX, v->bits, v->words, v->before, o->counts,
                  SCAN_NO_SUM);
  return ylm__steps_run(o->q);
}

/* A byte for each node above that has codes, with a bit for each of its children that has. */
static ylm_status upload_level(occupied_voxels *o, int level, const uint64_t *code, size_t n) {
  int down = 3 * (ylm_grid_look(o->grid)->form.depth - level);
  size_t nodes = 1, at = 0;
  for (size_t i = 1; i < n; i++) nodes += code[i] >> down >> 3 != code[i - 1] >> down >> 3;
  size_t words = (nodes + 3) / 4;
  uint32_t *bits = ylm_alloc_zero(words, sizeof *bits);
  for (size_t i = 0; bits && i < n; i++) {
    at += i && code[i] >> down >> 3 != code[i - 1] >> down >> 3;
    bits[at / 4] |= 1u << (at % 4 * 8 + (code[i] >> down & 7));
  }
  return upload_bits(o, &o->level[level], bits, words);
}

static ylm_status upload_lattice(occupied_voxels *o, const uint64_t *place, size_t n) {
  const uint32_t *r = ylm_grid_look(o->grid)->resolution;
  size_t words = ((size_t)r[0] * r[1] * r[2] + 31) / 32;
  uint32_t *bits = ylm_alloc_zero(words, sizeof *bits);
  for (size_t i = 0; bits && i < n; i++) bits[place[i] / 32] |= 1u << place[i] % 32;
  return upload_bits(o, &o->level[0], bits, words);
}

ylm_status ylm__occupied_surfaces(occupied_voxels *o, uint32_t count[YLM_GPU_COUNTS]) {
  const ylm_grid_form *form = &ylm_grid_look(o->grid)->form;
  uint64_t *code, outside = 0;
  size_t n;
  ylm_status s = ylm_grid_surface_voxels(o->grid, o->source, &code, &n, &outside, o->e);
  if (s != YLM_OK) return s;
  if (form->kind == YLM_GRID_UNIFORM) s = upload_lattice(o, code, n);
  for (int level = 1; form->kind == YLM_GRID_ADAPTIVE && s == YLM_OK && level <= form->depth;
       level++)
    s = upload_level(o, level, code, n);
  ylm_free(code);
  count[YLM_GPU_COUNT_VOXELS] = (uint32_t)n;
  count[YLM_GPU_COUNT_OUTSIDE] = (uint32_t)outside;
  return s;
}
