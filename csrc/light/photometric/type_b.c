/* type_b.c - intensities about a horizontal axis, type B, or an upright one, type A, on a grid of gamma and C.

   With H the angle of the rows of a file, V that of its columns, both 0 along the lamp's axis z, a direction is

     type B   sin H x + cos H sin V y + cos H cos V z      the polar axis is x, C0
     type A   cos V sin H x + sin V y + cos V cos H z      the polar axis is y, C90 */
#include "file.h"
#include "table.h"

#include <math.h>

/* Degrees between angles of the grid at least. Fuzzers need not wait for fine ones. */
#ifdef FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION
#define FINEST 10
#else
#define FINEST 0.5
#endif

/* A side of the table: angles from -90 or 0; those from 0 stand for both signs. */
typedef struct side {
  size_t n;
  const double *x;
  bool mirrored;
} side;

static side side_of(size_t n, const double *x) { return (side){n, x, n > 0 && x[0] > -1e-6}; }

/* The place of an angle on a side: *i and the part of the way to the next; false: it is beyond. */
static bool place(const side *s, double at, size_t *i, double *u) {
  if (s->mirrored) at = fabs(at);
  if (s->n == 1) {
    *i = 0, *u = 0;
    return true;
  }
  if (at < s->x[0] - 1e-9 || at > s->x[s->n - 1] + 1e-9) return false;
  *i = ylm__photometric_place(s->n - 1, s->x, at);
  *u = fmin(fmax((at - s->x[*i]) / (s->x[*i + 1] - s->x[*i]), 0), 1);
  return true;
}

/* Weights of the four nodes about a place, by the cubics through them (Lagrange); fewer at ends. */
static size_t cubic(const side *s, size_t i, double at, double w[4]) {
  size_t first = i > 0 ? i - 1 : 0, end = i + 3 < s->n ? i + 3 : s->n;
  if (s->n == 1) {
    w[0] = 1;
    return 0;
  }
  for (size_t k = 0; k < 4; k++) w[k] = 0;
  for (size_t k = first; k < end; k++) {
    double x = 1;
    for (size_t m = first; m < end; m++)
      if (m != k) x *= (at - s->x[m]) / (s->x[k] - s->x[m]);
    w[k - first] = x;
  }
  return first;
}

/* The intensity at angles H and V, degrees. */
static double look(const side *rows, const side *columns, const double *candela, double h,
                   double v) {
  size_t i, j;
  double u, a[4], b[4], sum = 0;
  if (!place(rows, h, &i, &u) || !place(columns, v, &j, &u)) return 0;
  size_t r = cubic(rows, i, rows->mirrored ? fabs(h) : h, a);
  size_t c = cubic(columns, j, columns->mirrored ? fabs(v) : v, b);
  for (size_t k = 0; k < 4 && r + k < rows->n; k++)
    for (size_t m = 0; m < 4 && c + m < columns->n; m++)
      sum += a[k] * b[m] * candela[(r + k) * columns->n + c + m];
  return fmax(0, sum);
}

/* The smallest step of a side, not finer than FINEST, that divides 90 degrees. */
static double step_of(size_t n, const double *x) {
  double least = 90;
  for (size_t i = 1; i < n; i++) least = fmin(least, x[i] - x[i - 1]);
  return 90 / fmax(1, floor(90 / fmax(least, FINEST) + 1e-6));
}

/* H and V, degrees, of the direction at angles of radians. */
static double turned(bool vertical, double gamma, double c, double *v) {
  double x = sin(gamma) * cos(c), y = sin(gamma) * sin(c), z = cos(gamma), degree = 180 / YLM_PI;
  *v = degree * (vertical ? asin(fmin(fmax(y, -1), 1)) : atan2(y, z));
  return degree * (vertical ? atan2(x, z) : asin(fmin(fmax(x, -1), 1)));
}

ylm_status ylm__photometric_resample(ylm_light_photometry_file *f, bool vertical, size_t rows,
                                     const double *plane, size_t columns, const double *angle,
                                     const double *candela, const ylm__photometric_text *t) {
  side h = side_of(rows, plane), v = side_of(columns, angle);
  double limit = vertical ? 180 : 90;
  if (plane[0] < -limit - 1e-6 || plane[rows - 1] > limit + 1e-6 || angle[0] < -180 - 1e-6 ||
      angle[columns - 1] > 180 + 1e-6)
    return ylm__photometric_fail(t, t->line, "angles of type %c are beyond %g and 180 degrees",
                                 vertical ? 'A' : 'B', limit);
  double step = fmin(step_of(rows, plane), step_of(columns, angle));
  double most = vertical ? fabs(plane[rows - 1]) : fabs(angle[columns - 1]);
  f->angles = (size_t)floor((most > 90 + 1e-6 ? 180 : 90) / step + 1.5);
  size_t planes = (size_t)floor(360 / step + 0.5);
  double *c = ylm_alloc(planes, sizeof *c), *out = ylm_alloc(planes * f->angles, sizeof *out);
  f->angle = ylm_alloc(f->angles, sizeof *f->angle);
  ylm_status s = c && out && f->angle ? YLM_OK : YLM_ENOMEM;
  for (size_t k = 0; s == YLM_OK && k < planes; k++) {
    c[k] = (double)k * 360 / (double)planes;
    for (size_t j = 0; j < f->angles; j++) {
      double at, by = f->angle[j] = (double)j * step;
      at = turned(vertical, by * (YLM_PI / 180), c[k] * (YLM_PI / 180), &by);
      out[k * f->angles + j] = look(&h, &v, candela, at, by);
    }
  }
  if (s == YLM_OK) s = ylm__photometric_unfold(f, planes, c, out, YLM__PHOTOMETRIC_FULL, t);
  if (s == YLM_OK)
    s = ylm__photometric_note(
        f, "photometric type %c, resampled at %g degrees; its polar axis is taken along C%d",
        vertical ? 'A' : 'B', step, vertical ? 90 : 0);
  ylm_free(c);
  ylm_free(out);
  return s;
}
