/* coarse.c - elements in groups, which are those of a cut half as fine. */
#include "transfer.h"

/* The number of the group of element x of a triangle that is cut into k^2. */
static size_t group_of_equal(size_t x, size_t k) {
  size_t i = 0, half = (k + 1) / 2;
  while ((i + 1) * (2 * k - (i + 1)) <= x) i++;
  size_t rest = x - i * (2 * k - i), j = rest / 2, row = i / 2, place = j / 2;
  bool upper = i % 2 + j % 2 + rest % 2 >= 2 && row + place < half - 1;
  if (place > half - 1 - row) place = half - 1 - row;
  return row * (2 * half - row) + 2 * place + upper;
}

/* The number of the group of element x of a triangle, in its triangle: the element of a coarser cut that has its middle. */
static size_t group_in(const transfer_cut *c, float foot, const transfer_cut *coarse, size_t x) {
  float corner[3][2];
  if (!c->columns) return group_of_equal(x, c->k);
  ylm__cut_corners(c, foot, x, corner);
  return ylm__cut_at(coarse, foot, (corner[0][0] + corner[1][0] + corner[2][0]) / 3,
                     (corner[0][1] + corner[1][1] + corner[2][1]) / 3);
}

ylm_status ylm__transfer_group(const ylm_transfer *t, transfer_groups *g) {
  *g = (transfer_groups){.of = ylm_alloc(t->elements, sizeof *g->of)};
  if (!g->of) return YLM_ENOMEM;
  for (size_t i = 0; i < t->triangles; i++)
    for (int side = 0; side < 2; side++) {
      size_t first = t->start[i][side], size = ylm__cut_size(&t->cut[i]);
      transfer_cut coarse = ylm__cut_coarse(&t->cut[i]);
      if (first == TRANSFER_NONE) continue;
      for (size_t x = 0; x < size; x++)
        g->of[first + x] = (uint32_t)(g->count + group_in(&t->cut[i], t->foot[i], &coarse, x));
      g->count += ylm__cut_size(&coarse);
    }
  g->sum = ylm_alloc(g->count, sizeof *g->sum);
  return g->sum ? YLM_OK : YLM_ENOMEM;
}

void ylm__transfer_level(const ylm_transfer *t, const transfer_groups *g, float *B) {
  for (size_t k = 0; k < g->count; k++) memset(g->sum[k], 0, sizeof g->sum[k]);
  for (size_t i = 0; i < t->elements; i++) {
    double *sum = g->sum[g->of[i]], area = (double)t->area[i] * (double)t->share[i];
    for (size_t c = 0; c < 3; c++) sum[c] += area * (double)B[4 * i + c];
    sum[3] += area;
  }
  for (size_t i = 0; i < t->elements; i++) {
    const double *sum = g->sum[g->of[i]];
    for (size_t c = 0; c < 3 && sum[3] > 0; c++) B[4 * i + c] = (float)(sum[c] / sum[3]);
  }
}

void ylm__transfer_ungroup(transfer_groups *g) {
  ylm_free(g->of);
  ylm_free(g->sum);
}
