/*
** ylm_vector.h - vectors of three numbers whose squares need not be representable.
*/
#ifndef YLM_VECTOR_H
#define YLM_VECTOR_H

#include <math.h>
#include <stdbool.h>

/*
** Scales v to length 1, whatever its length: from the least denormal number to the largest. False,
** and v as it was, where it is zero or not finite. The scale is a power of two, so that vectors of
** ordinary lengths come out as if they were divided by their length alone.
*/
static inline bool ylm_unit3(double v[3]) {
  if (!isfinite(v[0]) || !isfinite(v[1]) || !isfinite(v[2])) return false;
  double largest = fmax(fabs(v[0]), fmax(fabs(v[1]), fabs(v[2]))), u[3];
  int exponent;
  if (largest == 0) return false;
  frexp(largest, &exponent);
  for (int a = 0; a < 3; a++) u[a] = ldexp(v[a], -exponent);
  double length = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
  for (int a = 0; a < 3; a++) v[a] = u[a] / length;
  return true;
}

static inline float ylm_dot3(const float a[3], const float b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline double ylm_dot3d(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* x as a float that lies no less far along n than x does. */
static inline float ylm_away(double x, float n) {
  return (float)(x + fabs(x) * 0x1p-24 * ((n > 0) - (n < 0)));
}

/* a x b; out is neither. */
static inline void ylm_cross3d(const double a[3], const double b[3], double out[3]) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

/* Direction i of n that are spread evenly over the sphere: along a spiral, by the golden angle. */
static inline void ylm_spiral(int i, int n, double out[3]) {
  double z = 1 - (2 * i + 1.0) / n, r = sqrt(1 - z * z), phi = 2.39996322972865332 * i;
  out[0] = r * cos(phi);
  out[1] = r * sin(phi);
  out[2] = z;
}

/* Cosine and sine of t turns, 0 <= t <= 1, to 2e-16, without branches: Taylor's series within an eighth of a
   turn about the nearest quarter. */
static inline void ylm_turn(double t, double *cosine, double *sine) {
  static const double sign[5][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 0}};
  int quarter = (int)(4 * t + 0.5);
  double x = 2 * 3.14159265358979323846 * (t - 0.25 * quarter), y = x * x;
  double s = y * (-1.0 / 1307674368000), c = y * (1.0 / 20922789888000);
  s = y * (s + 1.0 / 6227020800), c = y * (c - 1.0 / 87178291200);
  s = y * (s - 1.0 / 39916800), c = y * (c + 1.0 / 479001600);
  s = y * (s + 1.0 / 362880), c = y * (c - 1.0 / 3628800);
  s = y * (s - 1.0 / 5040), c = y * (c + 1.0 / 40320);
  s = y * (s + 1.0 / 120), c = y * (c - 1.0 / 720);
  s = y * (s - 1.0 / 6), c = y * (c + 1.0 / 24);
  s = x + x * s, c = 1 + y * (c - 0.5);
  const double *q = sign[quarter];
  *cosine = q[0] * c - q[1] * s;
  *sine = q[1] * c + q[0] * s;
}

#endif
