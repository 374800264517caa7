/* ply.c - virtual lights as points of a PLY file. */
#include <stdio.h>

#include "emit.h"

#define ROW 43 /* bytes: ten floats, three of a colour */

static void put_floats(unsigned char *to, const double *x, size_t n) {
  for (size_t i = 0; i < n; i++) {
    float f = (float)x[i];
    uint32_t bits;
    memcpy(&bits, &f, 4);
    for (int k = 0; k < 4; k++) to[4 * i + (size_t)k] = (unsigned char)(bits >> (8 * k));
  }
}

/* sRGB of a linear value. */
static unsigned char grey(double x) {
  x = x <= 0.0031308 ? 12.92 * fmax(0, x) : 1.055 * pow(fmin(1, x), 1 / 2.4) - 0.055;
  return (unsigned char)(255 * x + 0.5);
}

ylm_status ylm_emit_write_ply(const ylm_emit_lights *l, const char *path, ylm_error *e) {
  char head[800];
  unsigned char row[ROW];
  double most = 0;
  ylm_file *f;
  for (size_t i = 0; i < 3 * l->n; i++) most = fmax(most, l->intensity[i]);
  ylm_status s = ylm_file_create(path, &f, e);
  if (s != YLM_OK) return s;
  int length = snprintf(
      head, sizeof head,
      "ply\nformat binary_little_endian 1.0\ncomment ylm " YLM_VERSION
      ": virtual lights; intensity along the normal in W sr^-1; colours are sRGB of intensity "
      "times %.9g\nelement vertex %zu\n"
      "property float x\nproperty float y\nproperty float z\n"
      "property float nx\nproperty float ny\nproperty float nz\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\n"
      "property float radius\nproperty float intensity_red\nproperty float intensity_green\n"
      "property float intensity_blue\nend_header\n",
      most > 0 ? 1 / most : 1, l->n);
  ylm_file_write(f, head, (size_t)length); /* errors stick */
  for (size_t i = 0; i < l->n; i++) {
    put_floats(row, l->at + 3 * i, 3);
    put_floats(row + 12, l->normal + 3 * i, 3);
    for (size_t c = 0; c < 3; c++)
      row[24 + c] = grey(most > 0 ? l->intensity[3 * i + c] / most : 0);
    put_floats(row + 27, l->radius + i, 1);
    put_floats(row + 31, l->intensity + 3 * i, 3);
    ylm_file_write(f, row, sizeof row);
  }
  return ylm_file_commit(f, e);
}
