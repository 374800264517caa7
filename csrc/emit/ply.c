/* ply.c - virtual lights as points of a PLY file. */
#include <stdio.h>

#include "emit.h"

#define ROW 55 /* bytes: ten numbers, three of them double far from 0, and three of a colour */

static unsigned char *put_floats(unsigned char *to, const double *x, size_t n) {
  for (size_t i = 0; i < n; i++) {
    float f = (float)x[i];
    uint32_t bits;
    memcpy(&bits, &f, 4);
    for (int k = 0; k < 4; k++) *to++ = (unsigned char)(bits >> (8 * k));
  }
  return to;
}

static unsigned char *put_doubles(unsigned char *to, const double *x, size_t n) {
  for (size_t i = 0; i < 8 * n; i++) {
    uint64_t bits;
    memcpy(&bits, &x[i / 8], sizeof bits);
    *to++ = (unsigned char)(bits >> (8 * (i % 8)));
  }
  return to;
}

/* Whether floats keep too few digits of the places. */
static bool is_far(const ylm_emit_lights *l) {
  double box[6] = {0}, origin[3];
  for (size_t i = 0; i < 3 * l->n; i++) {
    size_t a = i % 3;
    box[a] = i < 3 ? l->at[i] : fmin(box[a], l->at[i]);
    box[a + 3] = i < 3 ? l->at[i] : fmax(box[a + 3], l->at[i]);
  }
  ylm_origin(box, origin);
  return origin[0] != 0 || origin[1] != 0 || origin[2] != 0;
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
  bool far = is_far(l);
  const char *kind = far ? "double" : "float";
  ylm_file *f;
  for (size_t i = 0; i < 3 * l->n; i++) most = fmax(most, l->intensity[i]);
  ylm_status s = ylm_file_create(path, &f, e);
  if (s != YLM_OK) return s;
  int length = snprintf(
      head, sizeof head,
      "ply\nformat binary_little_endian 1.0\ncomment ylm " YLM_VERSION
      ": virtual lights; intensity along the normal in W sr^-1; colours are sRGB of intensity "
      "times %.9g\nelement vertex %zu\n"
      "property %s x\nproperty %s y\nproperty %s z\n"
      "property float nx\nproperty float ny\nproperty float nz\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\n"
      "property float radius\nproperty float intensity_red\nproperty float intensity_green\n"
      "property float intensity_blue\nend_header\n",
      most > 0 ? 1 / most : 1, l->n, kind, kind, kind);
  ylm_file_write(f, head, (size_t)length); /* errors stick */
  for (size_t i = 0; i < l->n; i++) {
    unsigned char *to = (far ? put_doubles : put_floats)(row, l->at + 3 * i, 3);
    to = put_floats(to, l->normal + 3 * i, 3);
    for (size_t c = 0; c < 3; c++) *to++ = grey(most > 0 ? l->intensity[3 * i + c] / most : 0);
    to = put_floats(to, l->radius + i, 1);
    to = put_floats(to, l->intensity + 3 * i, 3);
    ylm_file_write(f, row, (size_t)(to - row));
  }
  return ylm_file_commit(f, e);
}
