/* means.c - means over held-out points of surfaces, which the errors of darker light are relative to. */
#include "tolerance.h"

#include <math.h>

/* Points for means, and their light. */
static ylm_status hold_for_means(refiner *r) {
  const ylm_grid_source *s = r->b->source;
  size_t n = s->occupied_points && s->occupied < HELD_OUT ? s->occupied : HELD_OUT;
  ylm_rng rng;
  ylm_rng_seed(&rng, s->seed, UINT32_MAX);
  ylm_status status = r->surface ? ylm__held_surface(r, UINT32_MAX, n)
                                 : ylm__held_points(r, &rng, n == s->occupied, n);
  r->held = n;
  return status == YLM_OK ? ylm__sides_ask(r) : status;
}

ylm_status ylm__sides_scale(refiner *r) {
  measure *m = &r->b->measure;
  size_t w = r->b->g->width, counted = 0;
  bool sides = r->b->g->contents.form.sides;
  ylm_status status = sides ? ylm__verify_draw(r, UINT32_MAX) : hold_for_means(r);
  for (size_t i = 0; status == YLM_OK && i < r->held; i++) {
    double E[3] = {0}, norm = 0;
    if (r->inside[i]) continue;
    ylm__measure_irradiance(m, r->exact + i * w, r->side + 3 * i, E);
    for (size_t k = 0; k < w; k++)
      norm += (double)r->exact[i * w + k] * (double)r->exact[i * w + k];
    for (int c = 0; c < m->channels; c++) m->mean[c] += fabs(E[c]);
    m->norm += sqrt(norm);
    counted++;
  }
  for (int c = 0; c < 3 && counted; c++) m->mean[c] /= (double)counted;
  if (counted) m->norm /= (double)counted;
  r->held = 0;
  return status;
}
