/*
** power.c - the power that virtual lights send.
**
** By Funk and Hecke, the integral of max(0, s + n.u) Y_lm(u) over all u is lambda_l Y_lm(n) with
**
**   lambda_l = 2 pi integral over t = -s .. 1 of (s + t) P_l(t)
**
** and, by parts, lambda_l = 2 pi (I_(l-1) - I_(l+1))/(2l+1) from l = 1 on, I_l being the integral of
** P_l from -s to 1: (P_(l-1)(-s) - P_(l+1)(-s))/(2l+1).
*/
#include <string.h>

#include "virtual.h"
#include "ylm_sh.h"

enum { DEGREE = YLM_LIGHT_VIRTUAL_DEGREE };

/* Integrals of P_0 .. P_(DEGREE+1) from -s to 1. */
static void integrals(double s, double I[DEGREE + 2]) {
  double P[DEGREE + 3] = {1, -s};
  for (int l = 2; l < DEGREE + 3; l++)
    P[l] = ((2 * l - 1) * -s * P[l - 1] - (l - 1) * P[l - 2]) / l;
  I[0] = 1 + s;
  for (int l = 1; l < DEGREE + 2; l++) I[l] = (P[l - 1] - P[l + 1]) / (2 * l + 1);
}

static void cosine_factors(double s, double lambda[DEGREE + 1]) {
  double I[DEGREE + 2];
  integrals(s, I);
  lambda[0] = YLM_PI * (1 + s) * (1 + s);
  for (int l = 1; l <= DEGREE; l++) lambda[l] = 2 * YLM_PI * (I[l - 1] - I[l + 1]) / (2 * l + 1);
}

void ylm_light_virtual_flux(const double *normal, double shift, int degree, const double *emission,
                            double power[3]) {
  size_t wide = YLM_LIGHT_VIRTUAL_NUMBERS(degree);
  double Y[(DEGREE + 1) * (DEGREE + 1)], lambda[DEGREE + 1];
  memset(power, 0, 3 * sizeof *power);
  if (!normal || (normal[0] == 0 && normal[1] == 0 && normal[2] == 0)) {
    for (size_t c = 0; c < 3; c++) power[c] = sqrt(4 * YLM_PI) * emission[c * wide];
    return;
  }
  cosine_factors(shift, lambda);
  ylm_sh_how how = {.isa = YLM_ISA_reference, .threads = 1};
  if (ylm_sh_eval_how(&how, degree, YLM_DOUBLE, 1, normal, Y, NULL, NULL, NULL) != YLM_OK) return;
  for (size_t c = 0; c < 3; c++)
    for (int l = 0, q = 0; l <= degree; l++)
      for (int m = -l; m <= l; m++, q++)
        power[c] += lambda[l] * emission[c * wide + (size_t)q] * Y[q];
}

void ylm_light_virtual_power_one(const ylm_light_virtual *v, size_t i, double power[3]) {
  ylm_light_virtual_flux(v->normal + 3 * i, v->shift[i], v->degree,
                         v->emission + 3 * i * YLM_LIGHT_VIRTUAL_NUMBERS(v->degree), power);
}

void ylm_light_virtual_power(const ylm_light_virtual *v, double power[3]) {
  memset(power, 0, 3 * sizeof *power);
  if (v->profile == YLM_LIGHT_VIRTUAL_NEAR) return; /* ends at 1.6 cores */
  for (size_t i = 0; i < v->n; i++) {
    double one[3];
    ylm_light_virtual_power_one(v, i, one);
    for (int c = 0; c < 3; c++) power[c] += one[c];
  }
}
