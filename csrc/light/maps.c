/* maps.c - how results follow from sums over lights, for kernels elsewhere. */
#include "moments.h"

#include <math.h>

/*
** Rows for sums of the product rule: by order m, side, degree l, then value, x y z, xx .. zz as far
** as there are derivatives. Sums are by the light's position and lack 2 pi and the normalisation.
*/
static ylm_status product_rows(ylm__rows *r, int lmax, int derivatives, int part, int width) {
  static const int parts[3] = {1, 4, 10};
  size_t n = (size_t)(lmax + 1) * (size_t)(lmax + 1);
  if (ylm__rows_create(r, (size_t)width * n, (size_t)width * n) != YLM_OK) return YLM_ENOMEM;
  double sign = part == 1 ? -2 * M_PI : 2 * M_PI;
  for (int l = 0; l <= lmax; l++)
    for (int m = -l; m <= l; m++) {
      int q = m < 0 ? -m : m;
      /* coefficients of orders below q, and of the cosines of q where this is a sine */
      int before = 0;
      for (int j = 0; j < q; j++) before += (j ? 2 : 1) * (lmax + 1 - j);
      if (m < 0) before += lmax + 1 - q;
      for (int i = 0; i < width; i++) {
        ylm__rows_term(r, (size_t)((before + l - q) * parts[derivatives] + part + i),
                       sign * ylm__harmonic_scale(l, q, 1));
        ylm__rows_end(r);
      }
    }
  return YLM_OK;
}

ylm_status ylm_light_maps_create(int lmax, int need, int kinds, ylm_light_maps *maps) {
  ylm__map map = {0};
  *maps = (ylm_light_maps){.sums = (size_t)ylm__sum_count(lmax, kinds)};
  ylm_status s = ylm__map_create(&map, lmax, need, kinds, 1);
  maps->value = map.value;
  maps->gradient = map.gradient;
  maps->bend = map.bend;
  if (s == YLM_OK && need & YLM__M2) s = ylm__map_hessian(&maps->hessian, lmax);
  return s;
}

ylm_status ylm_light_product_maps_create(int lmax, int derivatives, ylm_light_maps *maps) {
  static const size_t parts[3] = {1, 4, 10};
  *maps = (ylm_light_maps){.sums = (size_t)(lmax + 1) * (size_t)(lmax + 1) * parts[derivatives]};
  ylm_status s = product_rows(&maps->value, lmax, derivatives, 0, 1);
  if (s == YLM_OK && derivatives > 0) s = product_rows(&maps->gradient, lmax, derivatives, 1, 3);
  if (s == YLM_OK && derivatives > 1) s = product_rows(&maps->hessian, lmax, derivatives, 4, 6);
  return s;
}

void ylm_light_maps_free(ylm_light_maps *maps) {
  ylm__rows_free(&maps->value);
  ylm__rows_free(&maps->gradient);
  ylm__rows_free(&maps->bend);
  ylm__rows_free(&maps->hessian);
}

void ylm_light_kinds(const ylm_field_query *q, int *lum, int *rgb) {
  *lum = ylm__kinds_of(q, 1);
  *rgb = ylm__kinds_of(q, 3);
}
