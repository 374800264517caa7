/* base.c - harmonics integrated over the cells of the base. */
#include "gather.h"

/* Two Gauss points each way. */
float *ylm__gather_base(const gather_lattice *l, int lmax) {
  size_t count = ylm_sh_count(lmax), n = l->cells, face = (size_t)l->base * (size_t)l->base;
  float *out = ylm_alloc_zero(n * count + GATHER_SPARE, sizeof *out);
  float *y = ylm_alloc(4 * count, sizeof *y);
  for (size_t c = 0; out && y && c < n; c++) {
    int i = (int)(c % (size_t)l->base), j = (int)(c % face / (size_t)l->base), f = (int)(c / face);
    float at[4][3], weight[4], all = 0;
    for (int k = 0; k < 4; k++) {
      double x[2] = {i + 0.5 + (k % 2 ? 1 : -1) * 0.28867513459481287,
                     j + 0.5 + (k / 2 ? 1 : -1) * 0.28867513459481287};
      for (int a = 0; a < 2; a++) x[a] = tan((2 * x[a] / l->base - 1) * (YLM_PI / 4));
      double r2 = 1 + x[0] * x[0] + x[1] * x[1];
      at[k][f / 2] = f % 2 ? -1 : 1;
      at[k][(f / 2 + 1) % 3] = (float)x[0];
      at[k][(f / 2 + 2) % 3] = (float)x[1];
      weight[k] = (float)((1 + x[0] * x[0]) * (1 + x[1] * x[1]) / (r2 * sqrt(r2)));
      all += weight[k];
    }
    ylm_sh_eval(lmax, 0, false, YLM_FLOAT, 4, at, y, NULL, NULL, 1, NULL);
    for (int k = 0; k < 4; k++)
      for (size_t q = 0; q < count; q++)
        out[c * count + q] += weight[k] / all * l->angle[c] * y[(size_t)k * count + q];
  }
  if (!y) ylm_free(out);
  ylm_free(y);
  return y ? out : NULL;
}
