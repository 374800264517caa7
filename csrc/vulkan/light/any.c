/* any.c - what shaders/moments_any.real.comp sums, and in which passes. */
#include "lights.h"

/* As in the kernel. */
typedef struct item {
  uint32_t m, component, k, cosine, sine;
} item;

/* Highest degree that kinds need. */
static uint32_t top_of(uint32_t lmax, uint32_t kinds) {
  return kinds & 4 ? lmax + 2 : kinds & 2 ? lmax + 1 : lmax;
}

/* Degrees of an item: a column is cut evenly into as few as fit into registers. */
static uint32_t block_of(uint32_t lmax, uint32_t kinds) {
  uint32_t width = (kinds & 1) + (kinds >> 1 & 1) + (kinds >> 2 & 1), most = SUM_BUDGET / 2 / width;
  uint32_t degrees = top_of(lmax, kinds) + 1, items = (degrees + most - 1) / most;
  return (degrees + items - 1) / items;
}

/* The items of one component of the jet, whose sums begin at *next; returns how many. */
static uint32_t add_items(int lmax, const struct sum_pass *pass, uint32_t component, uint32_t *next,
                          item *to) {
  uint32_t n = 0, top = top_of((uint32_t)lmax, pass->kinds);
  for (uint32_t m = 0; m <= top; m++) {
    uint32_t before = 0, column = 0;
    for (uint32_t k = m; k <= top; k++)
      column += (uint32_t)ylm_light_sums_at(lmax, (int)pass->kinds, (int)k);
    for (uint32_t k = m; k <= top; k++) {
      if ((k - m) % pass->block == 0)
        to[n++] = (item){m, component, k, *next + before, *next + column + before};
      before += (uint32_t)ylm_light_sums_at(lmax, (int)pass->kinds, (int)k);
    }
    *next += m ? 2 * column : column;
  }
  return n;
}

/* A pass over sums of `kinds` times components first .. first+count-1 of the jet. */
static ylm_status add_pass(const ylm_gpu_lights *l, int lmax, uint32_t kinds, uint32_t first,
                           uint32_t count, sum_set *set, ylm_error *e) {
  struct sum_pass *pass = &set->pass[set->passes++];
  *pass = (struct sum_pass){.kinds = kinds, .block = block_of((uint32_t)lmax, kinds)};
  uint32_t top = top_of((uint32_t)lmax, kinds), each = top / pass->block + 1;
  item *items = ylm_alloc((size_t)count * (top + 1) * each, sizeof *items);
  if (!items) return ylm_no_memory(e);
  for (uint32_t i = 0; i < count; i++)
    pass->items += add_items(lmax, pass, first + i, &set->sums, items + pass->items);
  ylm_status s = ylm_gpu_buffer_from(l->gpu, pass->items * sizeof *items, items, &pass->item, e);
  ylm_free(items);
  return s;
}

/* The constants of the recurrences, as the kernel reads them. */
static ylm_status add_constants(const ylm_gpu_lights *l, sum_plan *p, ylm_error *e) {
  size_t wide = (size_t)p->lmax + 3, n = wide * wide, size = ylm_dtype_size(p->dtype);
  if (p->constants) return YLM_OK;
  void *all = ylm_alloc(4 * n, size);
  if (!all) return ylm_no_memory(e);
  for (size_t i = 0; i < n; i++) {
    double c[4];
    p->grow = (uint32_t)ylm_light_recurrence(p->lmax, (int)(i / wide), (int)(i % wide), c);
    for (size_t k = 0; k < 4; k++)
      if (p->dtype == YLM_DOUBLE)
        ((double *)all)[4 * i + k] = c[k];
      else
        ((float *)all)[4 * i + k] = (float)c[k];
  }
  ylm_status s = ylm_gpu_buffer_from(l->gpu, 4 * n * size, all, &p->constants, e);
  ylm_free(all);
  return s;
}

ylm_status ylm__sum_any_cut(const ylm_gpu_lights *l, sum_plan *p, sum_set *set, ylm_error *e) {
  if (!set->channels) return YLM_OK;
  ylm_status s = add_constants(l, p, e);
  if (s == YLM_OK) s = add_pass(l, p->lmax, set->kinds, 0, 1, set, e);
  if (!l->cosines.kind) return s;
  if (s == YLM_OK && set->kinds > 1) s = add_pass(l, p->lmax, set->kinds & 4 ? 3 : 1, 1, 3, set, e);
  if (s == YLM_OK && set->kinds & 4) s = add_pass(l, p->lmax, 1, 4, 6, set, e);
  return s;
}
