/*
** merl_file.c - MERL's files, read:
**
**     int32 [3]: 90, 90, 180
**     float64 [3][90][90][180]: planes of red, green and blue over theta_h, theta_d, phi_d
**
** Numbers are little-endian; times 1/1500, 1.15/1500 and 1.66/1500 they are sr^-1. A negative number
** stands where nothing was measured.
*/
#include <math.h>
#include <string.h>

#include "merl.h"

const double ylm__merl_scale[3] = {1 / 1500., 1.15 / 1500, 1.66 / 1500};

/* A larger reflectance cannot be measured, and products of it could overflow. */
#define LARGEST 1e12

static uint64_t number(const unsigned char *p, int n) {
  uint64_t x = 0;
  for (int i = n - 1; i >= 0; i--) x = x << 8 | p[i];
  return x;
}

static double real(const unsigned char *p) {
  uint64_t bits = number(p, 8);
  double x;
  memcpy(&x, &bits, sizeof x);
  return x;
}

/* The header, and that the file's size is as it says. */
static ylm_status read_header(const unsigned char *bytes, size_t size, const char *name, int *phis,
                              ylm_error *e) {
  if (size < MERL_HEADER)
    return ylm_fail(e, YLM_EFORMAT, "%s: the file ends within its header of %d bytes", name,
                    MERL_HEADER);
  int32_t n[3];
  for (int a = 0; a < 3; a++) n[a] = (int32_t)(uint32_t)number(bytes + 4 * a, 4);
  if (n[0] == MERL_THETA_H << 24)
    return ylm_fail(e, YLM_EFORMAT, "%s: its numbers are big-endian, little-endian ones expected",
                    name);
  if (n[0] != MERL_THETA_H || n[1] != MERL_THETA_D ||
      (n[2] != MERL_PHI_D && n[2] != 2 * MERL_PHI_D))
    return ylm_fail(e, YLM_EFORMAT,
                    "%s: %d x %d x %d bins of theta_h, theta_d and phi_d, %d x %d x %d or %d "
                    "expected",
                    name, (int)n[0], (int)n[1], (int)n[2], MERL_THETA_H, MERL_THETA_D, MERL_PHI_D,
                    2 * MERL_PHI_D);
  size_t wanted = MERL_HEADER + 24 * (size_t)n[0] * (size_t)n[1] * (size_t)n[2];
  if (size != wanted)
    return ylm_fail(e, YLM_EFORMAT, "%s: %zu bytes, but %d x %d x %d bins take %zu", name, size,
                    (int)n[0], (int)n[1], (int)n[2], wanted);
  *phis = n[2];
  return YLM_OK;
}

static ylm_status wrong_number(const char *name, int colour, size_t i, int phis, double x,
                               ylm_error *e) {
  static const char *const names[] = {"red", "green", "blue"};
  return ylm_fail(e, YLM_EFORMAT, "%s: the %s number at theta_h %zu, theta_d %zu, phi_d %zu is %g",
                  name, names[colour], i / (size_t)phis / MERL_THETA_D + 1,
                  i / (size_t)phis % MERL_THETA_D + 1, i % (size_t)phis + 1, x);
}

/* Fills the bins; one with a negative number is missing. */
static ylm_status read_bins(const unsigned char *numbers, const char *name, merl_table *t,
                            ylm_error *e) {
  size_t bins = (size_t)MERL_THETA_H * MERL_THETA_D * (size_t)t->phis, measured = 0;
  for (size_t i = 0; i < bins; i++) {
    float *bin = t->bin[i];
    bin[3] = 1;
    for (int c = 0; c < 3; c++) {
      double x = real(numbers + 8 * ((size_t)c * bins + i)) * ylm__merl_scale[c];
      if (!(fabs(x) <= LARGEST))
        return wrong_number(name, c, i, t->phis, x / ylm__merl_scale[c], e);
      if (x < 0) bin[3] = 0;
      bin[c] = (float)x;
    }
    measured += bin[3] != 0;
  }
  if (!measured)
    return ylm_fail(e, YLM_EFORMAT, "%s: nothing is measured: every bin has a negative number",
                    name);
  return YLM_OK;
}

ylm_status ylm__merl_read(const unsigned char *bytes, size_t size, const char *name, merl_table **t,
                          size_t *held, ylm_error *e) {
  int phis = 0;
  ylm_status s = read_header(bytes, size, name, &phis, e);
  if (s != YLM_OK) return s;
  merl_table *new = ylm__merl_new(phis, held);
  if (!new) return YLM_ENOMEM;
  s = read_bins(bytes + MERL_HEADER, name, new, e);
  if (s != YLM_OK) {
    ylm_free(new);
    return s;
  }
  ylm__merl_complete(new);
  *t = new;
  return YLM_OK;
}
