/* spheres.real.c - spheres before a light, evaluated at the nodes of a rule. */
#include "block.h"

#include <math.h>
#include <string.h>

/* The smaller of v [rows][padded] and a cap's profile, or their product; with gradients its derivatives. */
static void profile_plain(const shadow_rings *r, const shadow_cap *c, bool times, size_t rows,
                          real *v) {
  const double *at = r->at;
  for (size_t k = 0; k < r->n; k++) {
    if (r->z[k] < c->low || r->z[k] > c->high) continue;
    size_t end = r->first[2 * k] + r->first[2 * k + 1];
    for (size_t i = r->first[2 * k]; i < end; i++) {
      double n[3] = {at[i], at[r->padded + i], at[2 * r->padded + i]};
      double d = c->w[0] * n[0] + c->w[1] * n[1] + c->w[2] * n[2];
      if (!(d > c->limit)) continue;
      double across = sqrt(fmax(0, 1 - d * d));
      double y = across * c->cosine - d * c->sine, z = d * c->cosine + across * c->sine;
      double u = fmin(1, fmax(0, 0.5 + atan2(y, z) / c->step));
      double hidden = 1 - u * u * (3 - 2 * u), p = 1 - c->deep * hidden, was = (double)v[i];
      if (!times && !(p < was)) continue;
      v[i] = (real)(times ? was * p : p);
      double steep = 6 * c->deep / c->step * u * (1 - u) * c->over,
             away = across > 0 ? 1 / across : 0;
      for (size_t a = 0; a + 1 < rows; a++) {
        double slope =
            steep * ((n[a] - c->w[a] * d) * away - c->w[a] * c->turn) - c->fade[a] * hidden;
        real *to = v + (a + 1) * r->padded + i;
        *to = (real)(times ? (double)*to * p + was * slope : slope);
      }
    }
  }
}

#ifdef YLM_REAL_IS_FLOAT
#define PROFILE(w, cap, times, v)                                                                  \
  ((w)->profile ? (w)->profile : profile_plain)((w)->rings, cap, times, (w)->rows, v)
#else
#define PROFILE(w, cap, times, v) profile_plain((w)->rings, cap, times, (w)->rows, v)
#endif

/* 1 at all directions, without a slope. */
static void clear_profile(const shadow_query *w, real *v) {
  for (size_t i = 0; i < w->rings->padded; i++) v[i] = 1;
  memset(v + w->rings->padded, 0, (w->rows - 1) * w->rings->padded * sizeof *v);
}

/* Spheres of a body that has several, in a term, from its first one on: their smallest value multiplies v. */
static void multiply_body(const tile *t, const shadow_term *term, size_t k, real *least, real *v) {
  const block *b = t->b;
  const shadow_query *w = b->w;
  const shadow_before *x = b->before + term->first;
  uint32_t body = w->s->caster[b->seen[x[k].seen].caster].form.body;
  size_t wide = w->rings->padded;
  shadow_cap cap;
  clear_profile(w, least);
  for (; k < term->n; k++) {
    const shadow_caster *c = &w->s->caster[b->seen[x[k].seen].caster];
    if (x[k].layer >= 0 || c->form.body != body) continue;
    ylm__shadow_cap_of(&w->blur[0], &b->seen[x[k].seen], &b->part[x[k].part], false, &cap);
    PROFILE(w, &cap, false, least);
  }
  for (size_t d = 1; d < w->rows; d++)
    for (size_t i = 0; i < wide; i++)
      v[d * wide + i] = v[d * wide + i] * least[i] + v[i] * least[d * wide + i];
  for (size_t i = 0; i < wide; i++) v[i] *= least[i];
}

/* The visibility of the spheres of a term: v; false where there are none. */
static bool open_spheres(const tile *t, const shadow_term *term, real *least, real *v) {
  const block *b = t->b;
  const shadow_query *w = b->w;
  const shadow_before *x = b->before + term->first;
  size_t n = 0;
  clear_profile(w, v);
  for (size_t k = 0; k < term->n; k++) {
    if (x[k].layer >= 0) continue;
    const shadow_caster *c = &w->s->caster[b->seen[x[k].seen].caster];
    shadow_cap cap;
    n++;
    if (c->lone) {
      ylm__shadow_cap_of(&w->blur[1], &b->seen[x[k].seen], &b->part[x[k].part], true, &cap);
      PROFILE(w, &cap, true, v);
      continue;
    }
    bool first = true;
    for (size_t j = k; j-- > 0 && first;)
      first = x[j].layer >= 0 || w->s->caster[b->seen[x[j].seen].caster].form.body != c->form.body;
    if (first) multiply_body(t, term, k, least, v);
  }
  return n > 0;
}

void SHADOW(multiply_spheres)(const tile *t) {
  const shadow_query *w = t->b->w;
  const shadow_rings *r = w->rings;
  size_t wide = w->rows * r->padded, lanes = t->lanes;
  bool some = false;
  const real *v = t->profile + wide;
  if (!w->s->spheres) return;
  for (size_t lane = 0; lane < lanes; lane++) {
    real *to = t->profile + (lane + 1) * wide;
    if (lane < t->n)
      some |= open_spheres(t, t->term[lane], t->profile, to);
    else
      clear_profile(w, to);
  }
  for (size_t k = 0; k < r->n && some; k++)
    for (size_t i = r->first[2 * k]; i < r->first[2 * k] + r->first[2 * k + 1]; i++) {
      real *f = t->f + r->node[i] * lanes;
      for (size_t d = 0; d + 1 < w->rows; d++) {
        real *g = t->g[d] + r->node[i] * lanes;
        const real *slope = v + (d + 1) * r->padded + i;
        for (size_t lane = 0; lane < lanes; lane++)
          g[lane] = g[lane] * v[lane * wide + i] + f[lane] * slope[lane * wide];
      }
      for (size_t lane = 0; lane < lanes; lane++) f[lane] *= v[lane * wide + i];
    }
}
