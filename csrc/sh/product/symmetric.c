/*
** symmetric.c - eigenvalues and eigenvectors of a symmetric matrix.
**
** Householder reflections make it tridiagonal, QL steps with implicit shifts then diagonal.
** Source  Golub & Van Loan 2013, 8.3; Martin, Reinsch & Wilkinson 1968
*/
#include "product.h"

#include <float.h>
#include <math.h>

/* a -> Q with Q' a Q tridiagonal: diagonal d, beside it e [n], e[0] = 0. */
static void reduce(int n, double *a, double *d, double *e, double *u) {
  for (int i = n - 1; i > 1; i--) {
    double *row = a + (size_t)i * (size_t)n, scale = 0, h = 0;
    for (int k = 0; k < i; k++) scale = fmax(scale, fabs(row[k]));
    d[i] = 0;
    e[i] = row[i - 1];
    if (scale == 0) continue;
    for (int k = 0; k < i; k++) {
      row[k] /= scale;
      h += row[k] * row[k];
    }
    double f = row[i - 1], g = f >= 0 ? -sqrt(h) : sqrt(h), s = 0;
    e[i] = scale * g;
    h -= f * g;
    row[i - 1] = f - g; /* the reflection's vector; h is half its square */
    d[i] = h;
    for (int j = 0; j < i; j++) {
      double p = 0;
      for (int k = 0; k <= j; k++) p += a[(size_t)j * (size_t)n + (size_t)k] * row[k];
      for (int k = j + 1; k < i; k++) p += a[(size_t)k * (size_t)n + (size_t)j] * row[k];
      u[j] = p / h;
      s += u[j] * row[j];
    }
    for (int j = 0; j < i; j++) u[j] -= s / (2 * h) * row[j];
    for (int j = 0; j < i; j++)
      for (int k = 0; k <= j; k++)
        a[(size_t)j * (size_t)n + (size_t)k] -= row[j] * u[k] + u[j] * row[k];
  }
  d[0] = d[1 < n ? 1 : 0] = 0;
  e[0] = 0;
  if (n > 1) e[1] = a[n];
  /* the product of the reflections; d[i] is h of row i, 0 where there is none */
  for (int i = 0; i < n; i++) {
    double *row = a + (size_t)i * (size_t)n, h = d[i];
    for (int j = 0; j < i && h != 0; j++) {
      double g = 0;
      for (int k = 0; k < i; k++) g += row[k] * a[(size_t)k * (size_t)n + (size_t)j];
      u[j] = g / h;
    }
    for (int k = 0; k < i && h != 0; k++)
      for (int j = 0; j < i; j++) a[(size_t)k * (size_t)n + (size_t)j] -= u[j] * row[k];
    d[i] = row[i];
    row[i] = 1;
    for (int k = 0; k < i; k++) row[k] = a[(size_t)k * (size_t)n + (size_t)i] = 0;
  }
}

/* Turns columns i and i+1 of z. */
static void turn(int n, double *z, int i, double c, double s) {
  for (int k = 0; k < n; k++) {
    double *at = z + (size_t)k * (size_t)n + (size_t)i, f = at[1];
    at[1] = s * at[0] + c * f;
    at[0] = c * at[0] - s * f;
  }
}

/* QL steps: d eigenvalues, the columns of z their vectors. */
static void diagonalise(int n, double *z, double *d, double *e) {
  for (int i = 1; i < n; i++) e[i - 1] = e[i];
  e[n - 1] = 0;
  for (int l = 0; l < n; l++)
    for (int pass = 0; pass < 60; pass++) {
      int m = l;
      while (m < n - 1 && fabs(e[m]) > DBL_EPSILON * (fabs(d[m]) + fabs(d[m + 1]))) m++;
      if (m == l) break;
      double g = (d[l + 1] - d[l]) / (2 * e[l]), r = hypot(g, 1), s = 1, c = 1, p = 0;
      g = d[m] - d[l] + e[l] / (g + copysign(r, g));
      int i = m - 1;
      for (; i >= l; i--) {
        double f = s * e[i], b = c * e[i];
        r = hypot(f, g);
        e[i + 1] = r;
        if (r == 0) {
          d[i + 1] -= p;
          e[m] = 0;
          break;
        }
        s = f / r;
        c = g / r;
        g = d[i + 1] - p;
        r = (d[i] - g) * s + 2 * c * b;
        p = s * r;
        d[i + 1] = g + p;
        g = c * r - b;
        turn(n, z, i, c, s);
      }
      if (r == 0 && i >= l) continue;
      d[l] -= p;
      e[l] = g;
      e[m] = 0;
    }
}

ylm_status ylm__sh_eigen(int n, double *a, double *w) {
  double *room = ylm_alloc(2 * (size_t)n, sizeof *room);
  if (!room) return YLM_ENOMEM;
  reduce(n, a, w, room, room + n);
  diagonalise(n, a, w, room);
  ylm_free(room);
  return YLM_OK;
}
