/* cosine.c - SH coefficients of what materials weigh light with where nothing occludes (matte: the clamped
   cosine). */
#include "../view.h"
#include "ylm_sh.h"

double *ylm__shade_zonal(int lmax) {
  int kinds = ylm_material_kinds();
  size_t row = (size_t)lmax + 1;
  double *zonal = ylm_alloc((size_t)kinds * row, sizeof *zonal);
  for (int i = 0; zonal && i < kinds; i++) /* views have an lmax that materials have too */
    (void)ylm_material_transfer(i, lmax, zonal + (size_t)i * row);
  return zonal;
}

ylm_status ylm__shade_cosines(const ylm_shade_view *v, int lmax, const double *zonal, size_t n,
                              const uint32_t *mesh, const float (*normal)[3], float *out) {
  size_t count = ylm_sh_count(lmax);
  ylm_status s = ylm_sh_eval(lmax, 0, false, YLM_FLOAT, n, normal, out, NULL, NULL, 1, NULL);
  const double *a = NULL;
  for (size_t i = 0; s == YLM_OK && i < n; i++, out += count) {
    if (i == 0 || mesh[i] != mesh[i - 1])
      a = zonal +
          ((size_t)lmax + 1) * (size_t)ylm_material_kind(ylm__shade_mesh_material(v, mesh[i]));
    for (int l = 0; l <= lmax; l++)
      for (size_t k = ylm_sh_index(l, -l); k <= ylm_sh_index(l, l); k++) out[k] *= (float)a[l];
  }
  return s;
}
