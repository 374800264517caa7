/* matte.c - Lambertian reflectance and the clamped cosine it weighs light with. */
#include "ylm_material.h"

ylm_status ylm_material_check(const ylm_material *m, ylm_error *e) {
  static const char *const names[] = {"red", "green", "blue"};
  for (int c = 0; c < 3; c++)
    if (!(m->albedo[c] >= 0 && m->albedo[c] <= 1))
      return ylm_fail(e, YLM_EDOMAIN, "the albedo's %s must be from 0 to 1, got %g", names[c],
                      (double)m->albedo[c]);
  return YLM_OK;
}

ylm_status ylm_material_cosine(int lmax, double *a) {
  const double pi = 3.14159265358979323846;
  if (lmax < 0 || lmax > YLM_MATERIAL_LMAX) return YLM_ERANGE;
  for (int l = 0; l <= lmax; l++)
    a[l] = l == 0   ? pi
           : l == 1 ? 2 * pi / 3
           : l == 2 ? pi / 4
           : l % 2  ? 0
                    : -a[l - 2] * (l - 3) / (l + 2);
  return YLM_OK;
}
