/* match.c - which lights changed between two arrays of them. */
#include "follow.h"

#include <stdlib.h>

static bool same(const ylm_light *a, const ylm_light *b) { return ylm_light_compare(a, b) == 0; }

/* A light that has no equal at its own place. */
typedef struct odd {
  const ylm_light *light;
  int64_t index;
} odd;

static int by_content(const void *a, const void *b) {
  const odd *x = a, *y = b;
  int c = ylm_light_compare(x->light, y->light);
  return c ? c : x->index < y->index ? -1 : x->index > y->index;
}

static int by_index(const void *a, const void *b) {
  const odd *x = a, *y = b;
  return x->index < y->index ? -1 : x->index > y->index;
}

/* Takes pairs of equal lights out of both lists; those of `b` learn where they come from. */
static void pair_equals(odd *a, size_t *na, odd *b, size_t *nb, int64_t *origin) {
  size_t i = 0, j = 0, left_a = 0, left_b = 0;
  qsort(a, *na, sizeof *a, by_content);
  qsort(b, *nb, sizeof *b, by_content);
  while (i < *na && j < *nb) {
    int c = ylm_light_compare(a[i].light, b[j].light);
    if (c == 0)
      origin[b[j++].index] = a[i++].index;
    else if (c < 0)
      a[left_a++] = a[i++];
    else
      b[left_b++] = b[j++];
  }
  while (i < *na) a[left_a++] = a[i++];
  while (j < *nb) b[left_b++] = b[j++];
  *na = left_a;
  *nb = left_b;
  qsort(a, *na, sizeof *a, by_index);
  qsort(b, *nb, sizeof *b, by_index);
}

ylm_status ylm__lights_match(const grid_dynamic *d, size_t n, const ylm_light *now, int64_t *origin,
                             light_change **changes, size_t *count) {
  size_t most = d->lights > n ? d->lights : n, na = 0, nb = 0;
  odd *a = ylm_alloc(d->lights, sizeof *a), *b = ylm_alloc(n, sizeof *b);
  ylm_status s = a && b ? YLM_OK : YLM_ENOMEM;
  *changes = NULL;
  *count = 0;
  for (size_t i = 0; s == YLM_OK && i < most; i++) {
    bool equal = i < d->lights && i < n && same(&d->light[i], &now[i]);
    if (i < n) origin[i] = equal ? (int64_t)i : -1;
    if (!equal && i < d->lights) a[na++] = (odd){&d->light[i], (int64_t)i};
    if (!equal && i < n) b[nb++] = (odd){&now[i], (int64_t)i};
  }
  if (s == YLM_OK) {
    pair_equals(a, &na, b, &nb, origin);
    *count = na > nb ? na : nb;
    *changes = ylm_alloc(*count, sizeof **changes);
    if (!*changes) s = YLM_ENOMEM;
  }
  for (size_t i = 0; s == YLM_OK && i < *count; i++)
    (*changes)[i] = (light_change){i < na ? a[i].index : -1, i < nb ? b[i].index : -1};
  ylm_free(a);
  ylm_free(b);
  return s;
}
