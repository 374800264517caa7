/* sphere.c - image positions and directions. */
#include "ylm_image.h"

#include <math.h>

/* From forward, left, up to scene axes and back: z up looks along +x, y up along -z. */
static void to_scene(ylm_up up, double f, double l, double u, double d[3]) {
  if (up == YLM_UP_Z)
    d[0] = f, d[1] = l, d[2] = u;
  else
    d[0] = -l, d[1] = u, d[2] = -f;
}

static void from_scene(ylm_up up, const double d[3], double *f, double *l, double *u) {
  if (up == YLM_UP_Z)
    *f = d[0], *l = d[1], *u = d[2];
  else
    *f = -d[2], *l = -d[0], *u = d[1];
}

/* OpenGL 4.6, Table 8.19: the axes of s, t and the face's own, with signs. */
static const struct {
  int axis, sign, s, s_sign, t, t_sign;
} faces[6] = {
    {0, 1, 2, -1, 1, -1}, {0, -1, 2, 1, 1, -1}, {1, 1, 0, 1, 2, 1},
    {1, -1, 0, 1, 2, -1}, {2, 1, 0, 1, 1, -1},  {2, -1, 0, -1, 1, -1},
};

bool ylm_mapping_direction(ylm_mapping m, ylm_up up, int width, int height, double x, double y,
                           double d[3]) {
  double u = x / width, v = y / height;
  d[0] = d[1] = d[2] = 0;
  if (!isfinite(u) || !isfinite(v)) return false;
  if (m == YLM_MAPPING_LATLONG) {
    double phi = YLM_PI * (1 - 2 * u), theta = YLM_PI * v;
    to_scene(up, sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta), d);
    return true;
  }
  if (m == YLM_MAPPING_ANGULAR) {
    double right = 2 * u - 1, top = 1 - 2 * v, r = hypot(right, top);
    if (r > 1) return false;
    double k = r > 0 ? sin(YLM_PI * r) / r : YLM_PI;
    to_scene(up, cos(YLM_PI * r), -right * k, top * k, d);
    return true;
  }
  int face = (int)floor(6 * v);
  if (face < 0 || face > 5) return false;
  double s = 2 * u - 1, t = 2 * (6 * v - face) - 1;
  d[faces[face].axis] = faces[face].sign;
  d[faces[face].s] = s * faces[face].s_sign;
  d[faces[face].t] = t * faces[face].t_sign;
  double length = sqrt(1 + s * s + t * t);
  for (int a = 0; a < 3; a++) d[a] /= length;
  return true;
}

bool ylm_mapping_position(ylm_mapping m, ylm_up up, int width, int height, const double d[3],
                          double *x, double *y) {
  double scale = fmax(fabs(d[0]), fmax(fabs(d[1]), fabs(d[2])));
  *x = *y = 0;
  if (!(scale > 0) || !isfinite(scale) || isnan(d[0] + d[1] + d[2])) return false;
  double n[3] = {d[0] / scale, d[1] / scale, d[2] / scale}, f, l, u;
  from_scene(up, n, &f, &l, &u);
  if (m == YLM_MAPPING_LATLONG) {
    *x = f == 0 && l == 0 ? 0.5 * width : width * (0.5 - atan2(l, f) / (2 * YLM_PI));
    *y = height * atan2(hypot(f, l), u) / YLM_PI;
  } else if (m == YLM_MAPPING_ANGULAR) {
    double side = hypot(l, u), r = atan2(side, f) / YLM_PI;
    double right = side > 0 ? -l / side * r : r, top = side > 0 ? u / side * r : 0;
    *x = width * (right + 1) / 2;
    *y = height * (1 - top) / 2;
  } else {
    int axis = fabs(n[0]) == 1 ? 0 : fabs(n[1]) == 1 ? 1 : 2, face = 2 * axis + (n[axis] < 0);
    double s = n[faces[face].s] * faces[face].s_sign, t = n[faces[face].t] * faces[face].t_sign;
    *x = width * (s + 1) / 2;
    *y = height * (face + (t + 1) / 2) / 6;
  }
  return true;
}

/* Solid angle of the rectangle (0,0) .. (s,t) of a cube face, signed. */
static double corner_angle(double s, double t) { return atan2(s * t, sqrt(s * s + t * t + 1)); }

static double solid_angle(ylm_mapping m, int width, int height, int x, int y) {
  if (m == YLM_MAPPING_LATLONG) /* cos a - cos b without cancellation */
    return 2 * YLM_PI / width * 2 * sin(YLM_PI * (y + 0.5) / height) * sin(YLM_PI / (2.0 * height));
  if (m == YLM_MAPPING_ANGULAR) {
    double r = hypot(2 * (x + 0.5) / width - 1, 1 - 2 * (y + 0.5) / height);
    return (r > 0 ? YLM_PI * sin(YLM_PI * r) / r : YLM_PI * YLM_PI) * 4.0 / width / height;
  }
  int row = y % width;
  double s0 = 2.0 * x / width - 1, s1 = 2.0 * (x + 1) / width - 1;
  double t0 = 2.0 * row / width - 1, t1 = 2.0 * (row + 1) / width - 1;
  return corner_angle(s1, t1) - corner_angle(s0, t1) - corner_angle(s1, t0) + corner_angle(s0, t0);
}

bool ylm_mapping_fits(ylm_mapping m, int width, int height) {
  if (width < 1 || height < 1) return false;
  if (m == YLM_MAPPING_LATLONG) return width == 2 * (int64_t)height;
  return height == (m == YLM_MAPPING_CUBE ? 6 : 1) * (int64_t)width;
}

/* Which of n pixels holds the position x. */
static size_t index_of(double x, int n) { return x > 0 ? x < n ? (size_t)x : (size_t)n - 1 : 0; }

bool ylm_mapping_pixel(ylm_mapping m, ylm_up up, int width, int height, const double d[3],
                       size_t *pixel) {
  double x, y;
  *pixel = 0;
  if (!ylm_mapping_position(m, up, width, height, d, &x, &y)) return false;
  *pixel = index_of(y, height) * (size_t)width + index_of(x, width);
  return true;
}

/* Even in solid angle: 1 - cos theta = 2 sin^2(theta/2) grows evenly, and differs by 2 sin(middle) sin(half a row) from one
   edge of a row to the other. */
static double within_latlong(ylm_up up, int width, int height, double x, size_t row, double v,
                             double d[3]) {
  double edge = sin(YLM_PI * (double)row / (2 * height)), half = sin(YLM_PI / (2.0 * height));
  double wide = sin(YLM_PI * ((double)row + 0.5) / height) * half;
  double s = fmin(1, edge * edge + v * wide), sine = 2 * sqrt(s * (1 - s));
  double phi = YLM_PI * (1 - 2 * x / width);
  to_scene(up, sine * cos(phi), sine * sin(phi), 1 - 2 * s, d);
  return 4 * YLM_PI / width * wide;
}

bool ylm_mapping_within(ylm_mapping m, ylm_up up, int width, int height, size_t pixel, double u,
                        double v, double d[3], double *spread) {
  double x = (double)(pixel % (size_t)width) + u, area;
  size_t row = pixel / (size_t)width;
  if (m == YLM_MAPPING_LATLONG) {
    area = within_latlong(up, width, height, x, row, v, d);
  } else {
    if (!ylm_mapping_direction(m, up, width, height, x, (double)row + v, d)) return false;
    area = spread ? ylm_mapping_spread(m, up, width, height, pixel, d) : 0;
  }
  if (spread) *spread = area;
  return true;
}

double ylm_mapping_spread(ylm_mapping m, ylm_up up, int width, int height, size_t pixel,
                          const double d[3]) {
  double x, y;
  if (m == YLM_MAPPING_LATLONG)
    return solid_angle(m, width, height, 0, (int)(pixel / (size_t)width));
  if (!ylm_mapping_position(m, up, width, height, d, &x, &y)) return 0;
  if (m == YLM_MAPPING_ANGULAR) {
    double r = hypot(2 * x / width - 1, 1 - 2 * y / height);
    return (r > 0 ? YLM_PI * fmax(0, sin(YLM_PI * r)) / r : YLM_PI * YLM_PI) * 4 / width / height;
  }
  double s = 2 * x / width - 1, t = 2 * (y / width - floor(fmin(5, y / width))) - 1;
  return 4 / ((double)width * width) / pow(1 + s * s + t * t, 1.5);
}

ylm_status ylm_mapping_pixels(ylm_mapping m, ylm_up up, int width, int height, double *direction,
                              double *angle) {
  if (width < 1 || height < 1) return YLM_ERANGE;
  if (m == YLM_MAPPING_CUBE && height != 6 * (int64_t)width) return YLM_ESHAPE;
  for (int y = 0; y < height; y++)
    for (int x = 0; x < width; x++) {
      size_t i = (size_t)y * (size_t)width + (size_t)x;
      bool in = ylm_mapping_direction(m, up, width, height, x + 0.5, y + 0.5, direction + 3 * i);
      if (angle) angle[i] = in ? solid_angle(m, width, height, x, y) : 0;
    }
  return YLM_OK;
}
