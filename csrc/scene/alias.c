/* alias.c - choosing by given shares in a time that does not grow with their number. */
#include "alias.h"

void ylm__alias_fill(size_t n, double *height, uint32_t *list, float *stay, uint32_t *other) {
  size_t low = 0, high = n; /* low ones from the front of the list, high ones behind */
  for (size_t i = 0; i < n; i++) {
    stay[i] = 1;
    other[i] = (uint32_t)i;
    list[height[i] < 1 ? low++ : --high] = (uint32_t)i;
  }
  while (low > 0 && high < n) {
    uint32_t from = list[--low], to = list[high];
    stay[from] = (float)height[from];
    other[from] = to;
    height[to] -= 1 - height[from];
    if (height[to] < 1) list[low++] = list[high++];
  }
}
