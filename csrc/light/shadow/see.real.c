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
  for (int a = 0; a < 3; a++) to->w[a] = d2 > 0 ? to->w[a] / to->distance : 0;
  to->sine = to->distance > radius ? radius / to->distance : 1;
  /* the part of all directions that its cone takes: (1 - sqrt(1 - s^2))/2 */
  double s2 = to->sine * to->sine;
  to->cosine = to->sine < 1 ? sqrt(1 - s2) : -1;
  return s2 / (2 * (1 + sqrt(1 - s2))) >= least;
}

/* The nearest first. Most points see few casters. */
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

ylm_status SHADOW(see)(block *b) {
  const ylm_light_shadowed *s = b->w->s;
  double least = s->n ? s->form.cull / (double)s->n / (double)(b->w->q->lmax + 1) : 0;
  for (size_t i = 0; i < b->m; i++) {
    size_t first = b->seen_first[i] = b->seens;
    for (size_t k = 0; k < s->n; k++) {
      if (k >= b->w->skip && k - b->w->skip < b->w->skips) continue;
      if (!grow((void **)&b->seen, b->seens, &b->seen_room, sizeof *b->seen)) return YLM_ENOMEM;
      shadow_seen *to = &b->seen[b->seens];
      to->caster = k;
      to->point = i;
      if (SHADOW(look)(b->point[i], s->caster[k].centre, s->caster[k].radius, least, to))
        b->seens++;
    }
    sort_seen(b->seen + first, b->seens - first);
  }
  b->seen_first[b->m] = b->seens;
  return YLM_OK;
}
