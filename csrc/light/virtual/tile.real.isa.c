/* tile.real.isa.c - the room of tiles of lights, and tiles to sums. */
#include "kernel.h"

/* Of the recurrences of emissions. */
static void find_beta(double *beta) {
  for (int l = 1; l <= YLM_LIGHT_VIRTUAL_DEGREE; l++)
    for (int m = 0; m <= l; m++) beta[l * (YLM_LIGHT_VIRTUAL_DEGREE + 1) + m] = YLM__BETA(l, m);
}

/* Sizes of a work's arrays. */
static void sizes_of(const ylm__virtual_plan *p, size_t sizes[ARRAYS]) {
  sizes[0] = TILE * p->width, sizes[1] = TILE * (size_t)p->numbers;
  for (int i = 2; i < 6; i++) sizes[i] = p->sums;
  sizes[6] = 6 * (size_t)(p->lmax + 1) * (size_t)(p->lmax + 1);
  sizes[7] = 4 * (size_t)(p->lmax + 1);
}

size_t VIRTUAL(room_of)(const ylm__virtual_plan *p) {
  size_t sizes[ARRAYS], all = 0;
  sizes_of(p, sizes);
  for (int i = 0; i < ARRAYS; i++) all += sizes[i];
  return all;
}

static int tile_of(const ylm__virtual_plan *p) {
  const size_t width = p->slopes ? p->factors + 6 * ((size_t)p->lmax + 1) : p->width;
  const size_t fit = STRAIGHT_BYTES / (width * sizeof(vreal));
  if (!p->straight) return PRODUCT_TILE;
  if (p->sums * sizeof(vreal) > SUM_BYTES) return TILE;
  return fit < STRAIGHT_LEAST ? STRAIGHT_LEAST : fit < TILE ? (int)fit : TILE;
}

/* A work whose arrays are at x, of room_of vectors. */
void VIRTUAL(work_place)(work *k, const ylm__virtual_plan *p, vreal *x) {
  size_t sizes[ARRAYS];
  vreal **slots[] = {&k->S, &k->E, &k->sum, &k->part, &k->lost, &k->mixed, &k->out, &k->B};
  sizes_of(p, sizes);
  for (int i = 0; i < ARRAYS; i++) *slots[i] = x, x += sizes[i];
  find_beta(k->beta);
  k->tile = tile_of(p);
  k->held = 0;
  k->of = p;
}

void VIRTUAL(flush)(const ylm__virtual_plan *q, work *k) {
  const ylm__virtual_plan *p = k->of;
  (void)q;
  if (!k->held) return;
  if (p->straight)
    VIRTUAL(sum_straight)(p, k);
  else
    VIRTUAL(sum_products)(p, k);
  k->held = 0;
}
