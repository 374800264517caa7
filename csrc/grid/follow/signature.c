/*
** signature.c - what a sample depends on, as one number. A caller that keeps samples of a dynamic grid asks again only for
** those that an update has changed.
**
** The signature of a point is a hash of its data, that of a cell follows from its place and its
** corners. Equal signatures mean equal samples, whatever happened in between, but for one chance in
** 2^64.
*/
#include "follow.h"
#include "ylm_list.h"

#include <math.h>
#include <string.h>

__extension__ typedef unsigned __int128 product;

/* Both halves of a product: one multiplication mixes sixteen bytes. */
static inline uint64_t fold(uint64_t a, uint64_t b) {
  product p = (product)a * b;
  return (uint64_t)p ^ (uint64_t)(p >> 64);
}

/* Four chains of products, so that they do not wait for one another. */
static uint64_t sign_data(const ylm_grid *g, size_t p) {
  static const uint64_t salt[4] = {0x5692161d100b05e5u, 0xdbd238973a2b148au, 0x1e535eede31428f0u,
                                   0xb7a4712c74562914u}; /* ylm_mix64 of 1 .. 4 */
  uint64_t h[4] = {1, 2, 3, 4}, x[2];
  const char *row = (const char *)(g->data + p * 4 * g->stride);
  size_t bytes = 4 * g->stride * sizeof(float); /* the stride is a multiple of 8 */
  for (size_t i = 0; i < bytes; i += 4 * sizeof x)
    for (size_t k = 0; k < 4; k++) {
      memcpy(x, row + i + k * sizeof x, sizeof x);
      h[k] = fold(x[0] ^ salt[k], x[1] ^ h[k]);
    }
  return ylm_mix64(h[0] + 3 * ylm_mix64(h[1] + 5 * ylm_mix64(h[2] + 7 * ylm_mix64(h[3]))));
}

void ylm__dynamic_sign(ylm_grid *g, uint32_t p) { g->dynamic->sign[p] = sign_data(g, p); }

static uint64_t corners(const ylm_grid *g, const ylm_grid_cell *c) {
  const grid_dynamic *d = g->dynamic;
  uint64_t h = 0;
  for (int k = 0; k < 8; k++) {
    uint32_t p = c->corner[k];
    h = (h ^ (p < g->evaluated ? d->sign[p] : d->born_sign[p - g->evaluated])) *
        0x9e3779b97f4a7c15u;
    h ^= h >> 32;
  }
  return ylm_mix64(h);
}

/* An interpolated value in a cell follows from its corners, its size and the place. */
void ylm__dynamic_sign_births(ylm_grid *g, const ylm_grid_cell *c, size_t n,
                              const uint32_t *birth) {
  uint64_t of_cell = corners(g, c) + c->level;
  for (size_t i = 0; i < n; i++)
    g->dynamic->born_sign[birth[i]] =
        ylm_mix64(of_cell ^ (uint64_t)(g->birth[birth[i]].place + 1) << 48);
}

static ylm_status sign_cells(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  ylm_grid *g = context;
  for (size_t i = begin; i < end; i++) {
    const ylm_grid_cell *c = &g->cell[i], *from = &g->cell[c->source];
    uint64_t place = lattice_key(from->origin) ^ (uint64_t)from->level << 58;
    /* A leaf without data that evaluated points touch has no corners of its own: 0, never equal. */
    uint64_t sign = corners(g, from) ^ ylm_mix64(place ^ g->dynamic->form_sign);
    g->dynamic->cell_sign[i] = c->detail ? 0 : sign | 1;
  }
  return YLM_OK;
}

/* Of what all cells have in common. */
static uint64_t sign_form(const ylm_grid_form *f) {
  uint64_t h = (uint64_t)f->lmax << 8 ^ (uint64_t)f->channels ^ (uint64_t)f->depth << 16, x;
  for (int a = 0; a < 6; a++) {
    memcpy(&x, &f->bounds[a], sizeof x);
    h = ylm_mix64(h ^ x);
  }
  for (int a = 0; a < 3; a++) h = ylm_mix64(h ^ f->cells[a]);
  return h;
}

/* Room for `n` numbers at *p, which has room for *room. */
static bool room_for(uint64_t **p, size_t *room, size_t n) {
  if (n <= *room) return true;
  if (!ylm_list_resize(p, *room, n + n / 4, sizeof **p)) return false;
  *room = n + n / 4;
  return true;
}

bool ylm__dynamic_room_births(ylm_grid *g, bool *all) {
  grid_dynamic *d = g->dynamic;
  bool room = room_for(&d->born_sign, &d->born_room, g->points - g->evaluated);
  d->is_signed &= room;
  *all = !d->is_signed;
  return room;
}

void ylm__dynamic_sign_all(ylm_grid *g, int threads) {
  grid_dynamic *d = g->dynamic;
  d->is_signed = false;
  d->form_sign = sign_form(&g->contents.form);
  if (d->born_room < g->points - g->evaluated || !room_for(&d->cell_sign, &d->cell_room, g->cells))
    return; /* without signatures, everything is asked for again */
  d->is_signed = ylm_parallel(g->cells, SIGN_GRAIN, threads, sign_cells, g, NULL, NULL) == YLM_OK;
}
