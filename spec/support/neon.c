/*
** neon.c - compares the NEON kernels with the reference kernel; built by spec/neon_spec.lua for
** aarch64 and run under qemu-user. Prints the largest error of each type and "ok", or what differs.
*/
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "ylm_sh.h"

#define POINTS 37

static double at(ylm_dtype t, const void *x, size_t i) {
  return t == YLM_DOUBLE ? ((const double *)x)[i] : (double)((const float *)x)[i];
}

/* Largest difference of a degree at a point relative to the largest number there. */
static double error(int lmax, ylm_dtype t, size_t width, const void *a, const void *b) {
  size_t count = ylm_sh_count(lmax) * width;
  double worst = 0;
  for (size_t i = 0; i < POINTS; i++)
    for (int l = 0; l <= lmax; l++) {
      double largest = 1e-300, difference = 0;
      for (size_t k = ylm_sh_index(l, -l) * width; k < (ylm_sh_index(l, l) + 1) * width; k++) {
        double d = fabs(at(t, a, i * count + k) - at(t, b, i * count + k));
        if (!(d <= difference)) difference = d;
        largest = fmax(largest, fabs(at(t, b, i * count + k)));
      }
      if (!(difference / largest <= worst)) worst = difference / largest;
    }
  return worst;
}

int main(void) {
  static const int degrees[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 13, 20};
  if (!ylm_isa_available(YLM_ISA_neon)) return puts("no NEON"), 1;
  size_t most = POINTS * ylm_sh_count(20) * 10 * sizeof(double);
  double pd[3 * POINTS];
  float pf[3 * POINTS];
  char *a = malloc(most), *b = malloc(most);
  ylm_rng r;
  ylm_rng_seed(&r, 7, 7);
  for (int i = 0; i < 3 * POINTS; i++)
    pf[i] = (float)(2 * ylm_rng_double(&r) - 1), pd[i] = (double)pf[i];
  for (int t = 0; t < 2; t++) {
    double worst = 0;
    for (size_t k = 0; k < sizeof degrees / sizeof *degrees; k++)
      for (int solid = 0; solid < 2; solid++) {
        int lmax = degrees[k];
        size_t n = POINTS * ylm_sh_count(lmax) * ylm_dtype_size((ylm_dtype)t);
        ylm_sh_how how = {.derivatives = 2, .solid = solid, .threads = 1, .isa = YLM_ISA_neon};
        const void *p = t ? (const void *)pd : pf;
        ylm_error e = {YLM_OK, ""};
        ylm_status s =
            ylm_sh_eval_how(&how, lmax, (ylm_dtype)t, POINTS, p, a, a + n, a + 4 * n, &e);
        how.isa = YLM_ISA_reference;
        if (s == YLM_OK)
          s = ylm_sh_eval_how(&how, lmax, (ylm_dtype)t, POINTS, p, b, b + n, b + 4 * n, &e);
        if (s != YLM_OK) return printf("%s\n", e.text), 1;
        worst = fmax(worst, error(lmax, (ylm_dtype)t, 1, a, b));
        worst = fmax(worst, error(lmax, (ylm_dtype)t, 3, a + n, b + n));
        worst = fmax(worst, error(lmax, (ylm_dtype)t, 6, a + 4 * n, b + 4 * n));
      }
    printf("%s %.3g\n", t ? "double" : "float", worst);
    if (!(worst < (t ? 1e-12 : 1e-5))) return puts("too far off"), 1;
  }
  return puts("ok"), 0;
}
