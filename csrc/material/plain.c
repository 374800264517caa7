/* plain.c - pairs of directions one by one, in double. */
#include "plain.h"

#include <math.h>

#include "ylm_math.h"

void ylm__plain_eval(plain_both_fn *both, const void *p, size_t n, const float (*wi)[3],
                     const float (*wo)[3], float (*f)[3]) {
  for (size_t i = 0; i < n; i++) {
    double a[3] = {wi[i][0], wi[i][1], wi[i][2]}, b[3] = {wo[i][0], wo[i][1], wo[i][2]}, x[3] = {0};
    if (a[2] > 0 && b[2] > 0) both(p, a, b, x);
    for (int c = 0; c < 3; c++) f[i][c] = (float)x[c];
  }
}

void ylm__plain_pdf(plain_both_fn *both, const void *p, size_t n, const float (*wi)[3],
                    const float (*wo)[3], float *pdf) {
  for (size_t i = 0; i < n; i++) {
    double a[3] = {wi[i][0], wi[i][1], wi[i][2]}, b[3] = {wo[i][0], wo[i][1], wo[i][2]}, f[3];
    pdf[i] = a[2] > 0 && b[2] > 0 ? (float)both(p, a, b, f) : 0;
  }
}

void ylm__plain_sample(plain_both_fn *both, plain_choose_fn *choose, const void *p, size_t n,
                       const float (*wo)[3], const float (*u)[3], float (*wi)[3],
                       float (*weight)[3], float *pdf) {
  for (size_t i = 0; i < n; i++) {
    double b[3] = {wo[i][0], wo[i][1], wo[i][2]}, a[3], f[3] = {0}, density = 0;
    choose(p, b, u[i], a);
    if (a[2] > 0 && b[2] > 0) density = both(p, a, b, f);
    pdf[i] = (float)density;
    for (int c = 0; c < 3; c++) {
      wi[i][c] = (float)a[c];
      weight[i][c] = density > 0 ? (float)(f[c] * a[2] / density) : 0;
    }
  }
}

void ylm__plain_mirrored(double ax, double ay, const double wo[3], const float u[3], double wi[3]) {
  double v[3] = {wo[0] * ax, wo[1] * ay, wo[2]};
  double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]), turn = 2 * YLM_PI * (double)u[0];
  for (int a = 0; a < 3; a++) v[a] /= length;
  double h = (1 - (double)u[1]) * (1 + v[2]), z = h - v[2], r = sqrt(fmax(0, 1 - z * z));
  double m[3] = {(r * cos(turn) + v[0]) * ax, (r * sin(turn) + v[1]) * ay, h};
  double d =
      2 * (m[0] * wo[0] + m[1] * wo[1] + m[2] * wo[2]) / (m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
  for (int a = 0; a < 3; a++) wi[a] = d * m[a] - wo[a];
  wi[2] = fabs(wi[2]);
}

void ylm__plain_cosine(const float u[3], double wi[3]) {
  double turn = 2 * YLM_PI * (double)u[0], r = sqrt((double)u[1]);
  wi[0] = r * cos(turn), wi[1] = r * sin(turn), wi[2] = sqrt(1 - (double)u[1]);
}
