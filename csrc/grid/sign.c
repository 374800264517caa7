/*
** sign.c - what a sample depends on, as one number, so that whoever keeps samples of a dynamic grid
** asks again only for those that an update has changed.
**
** The signature of a point is a hash of its data, that of a cell follows from its place and its
** corners. Equal signatures mean equal samples, whatever happened in between, but for one chance in
** 2^64.
*/
#include "dynamic.h"

#include <math.h>
#include <string.h>

/* The finaliser of SplitMix64 (Steele et al. 2014). */
static inline uint64_t mix(uint64_t x) {
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
  x = (x ^ x >> 27) * 0x94d049bb133111ebu;
  return x ^ x >> 31;
}

static uint64_t sign_data(const ylm_grid *g, size_t p) {
  uint64_t h[4] = {1, 2, 3, 4}, x;
  const char *row = (const char *)(g->data + p * 4 * g->stride);
  size_t words = 4 * g->stride * sizeof(float) / 8; /* the stride is a multiple of 8 */
  for (size_t i = 0; i < words; i += 4)
    for (size_t k = 0; k < 4; k++) {
      memcpy(&x, row + 8 * (i + k), 8);
      h[k] = (h[k] ^ x) * 0x9e3779b97f4a7c15u;
      h[k] ^= h[k] >> 29;
    }
  return mix(h[0] + 3 * mix(h[1] + 5 * mix(h[2] + 7 * mix(h[3]))));
}

void ylm__dynamic_sign(ylm_grid *g, uint32_t p) { g->dynamic->sign[p] = sign_data(g, p); }

typedef struct born_job {
  ylm_grid *g;
  const uint8_t *changed;
} born_job;

static ylm_status sign_born(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const born_job *j = context;
  for (size_t i = begin; i < end; i++) {
    size_t p = j->g->evaluated + i;
    if (!j->changed || j->changed[p]) j->g->dynamic->born_sign[i] = sign_data(j->g, p);
  }
  return YLM_OK;
}

static uint64_t corners(const ylm_grid *g, const ylm_grid_cell *c) {
  const grid_dynamic *d = g->dynamic;
  uint64_t h = 0;
  for (int k = 0; k < 8; k++) {
    uint32_t p = c->corner[k];
    h = (h ^ (p < g->evaluated ? d->sign[p] : d->born_sign[p - g->evaluated])) *
        0x9e3779b97f4a7c15u;
    h ^= h >> 32;
  }
  return mix(h);
}

static ylm_status sign_cells(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  ylm_grid *g = context;
  for (size_t i = begin; i < end; i++) {
    const ylm_grid_cell *c = &g->cell[i], *from = &g->cell[c->source];
    uint64_t place = lattice_key(from->origin) ^ (uint64_t)from->level << 58;
    /* A leaf without data that evaluated points touch has no corners of its own: 0, never equal. */
    uint64_t sign = corners(g, from) ^ mix(place ^ g->dynamic->form_sign);
    g->dynamic->cell_sign[i] = c->detail ? 0 : sign | 1;
  }
  return YLM_OK;
}

/* Of what all cells have in common. */
static uint64_t sign_form(const ylm_grid_form *f) {
  uint64_t h = (uint64_t)f->lmax << 8 ^ (uint64_t)f->channels ^ (uint64_t)f->depth << 16, x;
  for (int a = 0; a < 6; a++) {
    memcpy(&x, &f->bounds[a], sizeof x);
    h = mix(h ^ x);
  }
  for (int a = 0; a < 3; a++) h = mix(h ^ f->cells[a]);
  return h;
}

/* Room for `n` numbers at *p, which has room for *room. */
static bool room_for(uint64_t **p, size_t *room, size_t n) {
  if (n <= *room) return true;
  uint64_t *more = ylm_realloc(*p, *room * sizeof **p, n + n / 4, sizeof **p);
  if (!more) return false;
  *p = more;
  *room = n + n / 4;
  return true;
}

void ylm__dynamic_sign_all(ylm_grid *g, const uint8_t *changed, int threads) {
  grid_dynamic *d = g->dynamic;
  size_t born = g->points - g->evaluated;
  born_job j = {g, d->is_signed ? changed : NULL};
  d->is_signed = false;
  d->form_sign = sign_form(&g->view.form);
  if (!room_for(&d->born_sign, &d->born_room, born) ||
      !room_for(&d->cell_sign, &d->cell_room, g->cells))
    return; /* without signatures, everything is asked for again */
  for (uint32_t p = 0; p < g->evaluated; p++)
    if (g->flags[p] & YLM_GRID_POINT_INVALID) ylm__dynamic_sign(g, p); /* has been filled */
  ylm_parallel(born, 512, threads, sign_born, &j, NULL, NULL);
  d->is_signed = ylm_parallel(g->cells, 4096, threads, sign_cells, g, NULL, NULL) == YLM_OK;
}
