/* many_singular.c - lights without size that lie at shading points: 1/d^2 has no value there. */
#include <stdlib.h>

#include "many.h"

static int compare(const void *a, const void *b) {
  const float *x = a, *y = b;
  for (int k = 0; k < 3; k++)
    if (x[k] != y[k]) return x[k] < y[k] ? -1 : 1;
  return 0;
}

/* How many places of the sorted list come before x; `upto`: or are the same. */
static size_t before(const float (*list)[3], size_t n, const float x[3], bool upto) {
  size_t low = 0, high = n;
  while (low < high) {
    size_t middle = low + (high - low) / 2;
    int c = compare(list[middle], x);
    if (c < 0 || (c == 0 && upto))
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

ylm_status ylm__many_singular(const ylm_shade_view *v, const ylm_many_lights *l, uint64_t *pairs) {
  float(*list)[3] = ylm_alloc(l->n, sizeof *list);
  *pairs = 0;
  if (!list) return YLM_ENOMEM;
  for (size_t i = 0; i < l->n; i++)
    for (int k = 0; k < 3; k++) list[i][k] = l->at[k][i];
  qsort(list, l->n, sizeof *list, compare);
  for (size_t p = 0; p < v->points; p++)
    *pairs += before((const float(*)[3])list, l->n, v->position[p], true) -
              before((const float(*)[3])list, l->n, v->position[p], false);
  ylm_free(list);
  return YLM_OK;
}
