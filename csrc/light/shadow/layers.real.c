/* layers.real.c - casters before a light, in layers that do not overlap. */
#include "block.h"

/* Do their cones meet? The cosine of the sum of half angles, by their sines and cosines. */
static bool overlap(const shadow_seen *a, const shadow_seen *b) {
  double cosine = a->w[0] * b->w[0] + a->w[1] * b->w[1] + a->w[2] * b->w[2];
  return a->sine >= 1 || b->sine >= 1 || cosine > a->cosine * b->cosine - a->sine * b->sine;
}

/* The first layer of a term where nothing overlaps caster k of it. */
static int layer_of(const block *b, const shadow_term *t, size_t k) {
  const shadow_before *x = b->before + t->first;
  if (!b->w->s->form.layers) return (int)t->layers;
  for (int layer = 0;; layer++) {
    bool free = true;
    for (size_t j = 0; j < k && free; j++)
      free = x[j].layer != layer || !overlap(&b->seen[x[j].seen], &b->seen[x[k].seen]);
    if (free) return layer;
  }
}

void SHADOW(layer)(block *b) {
  for (size_t i = 0; i < b->terms; i++) {
    shadow_term *t = &b->term[i];
    t->layers = 0;
    for (size_t k = 0; k < t->n; k++) {
      shadow_before *x = &b->before[t->first + k];
      bool sphere = b->w->exponential || !b->w->s->caster[b->seen[x->seen].caster].form.hides;
      x->layer = sphere ? -1 : layer_of(b, t, k);
      if (x->layer >= (int)t->layers) t->layers = (size_t)x->layer + 1;
    }
  }
}

void SHADOW(count)(const block *b) {
  size_t factors = 0;
  for (size_t i = 0; i < b->terms; i++) {
    const shadow_term *t = &b->term[i];
    factors += t->layers;
    for (size_t k = 0; k < t->n; k++) factors += b->before[t->first + k].layer < 0;
  }
  atomic_fetch_add(&b->w->casters, b->seens);
  atomic_fetch_add(&b->w->products, b->terms);
  atomic_fetch_add(&b->w->factors, factors);
}
