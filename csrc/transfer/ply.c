/* ply.c - elements and the light on them as PLY, for viewers and other programs. */
#include <math.h>
#include <stdio.h>

#include "transfer.h"

#define VERTEX 27 /* bytes: position, normal, colour; 12 more where positions are double */
#define FACE 37   /* count, three corners, six numbers */

static void put_u32(unsigned char *to, uint32_t x) {
  for (int k = 0; k < 4; k++) to[k] = (unsigned char)(x >> (8 * k));
}

static void put_floats(unsigned char *to, const float *x, size_t n) {
  for (size_t i = 0; i < n; i++) {
    uint32_t bits;
    memcpy(&bits, &x[i], 4);
    put_u32(to + 4 * i, bits);
  }
}

/* A place of the world: doubles where there is an origin. */
static unsigned char *put_place(unsigned char *to, const ylm_scene *scene, const float x[3]) {
  double place[3];
  if (!ylm_scene_origin(scene)) {
    put_floats(to, x, 3);
    return to + 12;
  }
  ylm_scene_leave(scene, x, place);
  for (int a = 0; a < 3; a++) {
    uint64_t bits;
    memcpy(&bits, &place[a], sizeof bits);
    put_u32(to + 8 * a, (uint32_t)bits);
    put_u32(to + 8 * a + 4, (uint32_t)(bits >> 32));
  }
  return to + 24;
}

/* sRGB of a linear value. */
static unsigned char grey(double x) {
  x = x <= 0.0031308 ? 12.92 * fmax(0, x) : 1.055 * pow(fmin(1, x), 1 / 2.4) - 0.055;
  return (unsigned char)(255 * x + 0.5);
}

/* The three corners of element i, of colour E times `exposure`; their bytes. */
static size_t put_corners(const ylm_radiosity *r, size_t i, double exposure, unsigned char *to) {
  ylm_scene_place place[3];
  ylm_scene_surface at[3];
  float corner[3][2];
  unsigned char *begin = to;
  bool back = ylm__transfer_is_back(r->t, i);
  ylm__transfer_corners(r->t, i, place, corner);
  for (int k = 2; k >= 0; k--) {
    place[k] = place[0];
    place[k].u = corner[k][0], place[k].v = corner[k][1];
  }
  ylm_scene_surfaces(r->t->scene, 3, place, at);
  for (int k = 0; k < 3; k++) {
    const ylm_scene_surface *s = &at[back ? 2 - k : k]; /* seen from its side */
    to = put_place(to, r->t->scene, s->position);
    put_floats(to, s->normal, 3);
    to += 12;
    for (size_t c = 0; c < 3; c++) *to++ = grey(exposure * (double)r->E[4 * i + c]);
  }
  return (size_t)(to - begin);
}

static void put_face(const ylm_radiosity *r, size_t i, unsigned char *to) {
  to[0] = 3;
  for (uint32_t k = 0; k < 3; k++) put_u32(to + 1 + 4 * k, (uint32_t)(3 * i) + k);
  put_floats(to + 13, r->E + 4 * i, 3);
  put_floats(to + 25, r->direct + 4 * i, 3);
}

/* Twice the mean irradiance is white. */
static double exposure_of(const ylm_radiosity *r) {
  double area = 0, sum = 0;
  for (size_t i = 0; i < r->t->elements; i++) {
    const float *E = r->E + 4 * i;
    area += (double)r->t->area[i];
    sum +=
        (double)r->t->area[i] * (YLM_LUMINANCE_R * (double)E[0] + YLM_LUMINANCE_G * (double)E[1] +
                                 YLM_LUMINANCE_B * (double)E[2]);
  }
  return sum > 0 ? area / (2 * sum) : 1;
}

ylm_status ylm_radiosity_write_ply(const ylm_radiosity *r, const char *path, ylm_error *e) {
  size_t n = r->t->elements;
  double exposure = exposure_of(r);
  unsigned char row[3 * (VERTEX + 12)];
  char head[800];
  const char *kind = ylm_scene_origin(r->t->scene) ? "double" : "float";
  ylm_file *f;
  if (n > UINT32_MAX / 3) return ylm_fail(e, YLM_EOVERFLOW, "more than 2^32 corners");
  ylm_status s = ylm_file_create(path, &f, e);
  if (s != YLM_OK) return s;
  int length =
      snprintf(head, sizeof head,
               "ply\nformat binary_little_endian 1.0\ncomment ylm " YLM_VERSION
               ": elements; irradiance and that of direct light in W m^-2; colours are sRGB of "
               "irradiance times %.9g\nelement vertex %zu\n"
               "property %s x\nproperty %s y\nproperty %s z\n"
               "property float nx\nproperty float ny\nproperty float nz\n"
               "property uchar red\nproperty uchar green\nproperty uchar blue\n"
               "element face %zu\nproperty list uchar int vertex_indices\n"
               "property float irradiance_red\nproperty float irradiance_green\n"
               "property float irradiance_blue\nproperty float direct_red\n"
               "property float direct_green\nproperty float direct_blue\nend_header\n",
               exposure, 3 * n, kind, kind, kind, n);
  ylm_file_write(f, head, (size_t)length); /* errors stick */
  for (size_t i = 0; i < n; i++) {
    size_t bytes = put_corners(r, i, exposure, row);
    ylm_file_write(f, row, bytes);
  }
  for (size_t i = 0; i < n; i++) {
    put_face(r, i, row);
    ylm_file_write(f, row, FACE);
  }
  return ylm_file_commit(f, e);
}
