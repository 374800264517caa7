/* see.real.c - casters as the points of a block see them. */
#include "block.h"

#include <math.h>
#include <stdlib.h>

/* Casters that are sorted one by one. */
#define FEW_SEEN 32

static int by_distance(const void *a, const void *b) {
  const shadow_seen *p = a, *q = b;
  if (p->distance != q->distance) return p->distance < q->distance ? -1 : 1;
  return p->caster < q->caster ? -1 : p->caster > q->caster;
}

bool SHADOW(look)(const double p[3], const double at[3], double radius, double least,
                  shadow_seen *to) {
  double d2 = 0;
  for (int a = 0; a < 3; a++) {
    to->w[a] = at[a] - p[a];
    d2 += to->w[a] * to->w[a];
  }
  to->distance = sqrt(d2);
  double over = d2 > 0 ? 1 / to->distance : 0;
  for (int a = 0; a < 3; a++) to->w[a] *= over;
  to->sine = to->distance > radius ? radius * over : 1;
  /* the part of all directions that its cone takes: (1 - sqrt(1 - s^2))/2 */
  double s2 = to->sine * to->sine, cosine = sqrt(1 - s2);
  to->cosine = to->sine < 1 ? cosine : -1;
  return s2 >= least * (2 * (1 + cosine));
}

/* The nearest first. Few come in about that order. */
static void sort_seen(shadow_seen *s, size_t n) {
  if (n > FEW_SEEN) {
    qsort(s, n, sizeof *s, by_distance);
    return;
  }
  for (size_t i = 1; i < n; i++) {
    shadow_seen x = s[i];
    size_t k = i;
    for (; k > 0 && by_distance(&x, &s[k - 1]) < 0; k--) s[k] = s[k - 1];
    s[k] = x;
  }
}

/* Casters in an order that the query's first point begins with. */
static bool begin_look(block *b) {
  size_t n = b->w->s->n;
  if (b->look) return true;
  b->look = ylm_alloc(n, sizeof *b->look);
  for (size_t k = 0; b->look && k < n; k++) b->look[k] = (uint32_t)k;
  return b->look != NULL;
}

ylm_status SHADOW(see)(block *b) {
  const ylm_light_shadowed *s = b->w->s;
  double least = s->n ? s->form.cull / (double)s->n / (double)(b->w->q->lmax + 1) : 0;
  if (!begin_look(b)) return YLM_ENOMEM;
  for (size_t i = 0; i < b->m; i++) {
    size_t first = b->seen_first[i] = b->seens, at[FEW_SEEN];
    for (size_t j = 0; j < s->n; j++) {
      uint32_t k = b->look[j];
      if (k >= b->w->skip && k - b->w->skip < b->w->skips) continue;
      if (!grow((void **)&b->seen, b->seens, &b->seen_room, sizeof *b->seen)) return YLM_ENOMEM;
      shadow_seen *to = &b->seen[b->seens];
      to->caster = k;
      to->point = (uint32_t)i;
      if (!SHADOW(look)(b->point[i], s->caster[k].centre, s->caster[k].radius, least, to)) continue;
      if (b->seens - first < FEW_SEEN) at[b->seens - first] = j;
      b->seens++;
    }
    size_t n = b->seens - first;
    sort_seen(b->seen + first, n);
    /* the next point, a neighbour, will have about this order */
    for (size_t j = 0; j < n && n <= FEW_SEEN; j++) b->look[at[j]] = b->seen[first + j].caster;
  }
  b->seen_first[b->m] = b->seens;
  return YLM_OK;
}
