/*
** place.c - where the lights stand that stand for many.
**
** In units in which the covariance is the identity, proxies begin at the corners u of a cube or of
** a tetrahedron, of equal weights. A cube's have no third moments; to first order, and without a
** change of any other moment up to the third,
**
**   xyz  is changed by the weights 1 + s xyz,
**   xxx  by the weights 1 - s x/2,
**   xxy  by the squares x^2 -> x^2 (1 + s y).
**
** On a plane the tetrahedron's corners are a square's, where the rules hold too. Changes of lower
** moments are undone; the third moments that are then missed are added to s, a few times. Nodes of few lights have third
** moments by chance; these are met.
**
** Source  docs/math.md "Many lights"
*/
#include "proxy.h"

#include <math.h>
#include <string.h>

/* A cube's; the first four are a tetrahedron's. */
static const double corner[YLM__MOST_PROXIES][3] = {{1, 1, 1},   {1, -1, -1},  {-1, 1, -1},
                                                    {-1, -1, 1}, {-1, -1, -1}, {-1, 1, 1},
                                                    {1, -1, 1},  {1, 1, -1}};

void ylm__tree_axes(const double *cov, double grain, double A[3][3]) {
  double C[3][3] = {{cov[0], cov[1], cov[2]}, {cov[1], cov[3], cov[4]}, {cov[2], cov[4], cov[5]}};
  double least = fmax(1e-12 * (C[0][0] + C[1][1] + C[2][2]), grain);
  memset(A, 0, 9 * sizeof(double));
  for (int k = 0; k < 3; k++) {
    double pivot = C[k][k];
    for (int j = 0; j < k; j++) pivot -= A[k][j] * A[k][j];
    if (!(pivot > least)) continue;
    A[k][k] = sqrt(pivot);
    for (int i = k + 1; i < 3; i++) {
      double s = C[i][k];
      for (int j = 0; j < k; j++) s -= A[i][j] * A[k][j];
      A[i][k] = s / A[k][k];
    }
  }
}

void ylm__tree_solve(double A[3][3], const double *x, double *y) {
  for (int a = 0; a < 3; a++) {
    double s = x[a];
    for (int b = 0; b < a; b++) s -= A[a][b] * y[b];
    y[a] = A[a][a] > 0 ? s / A[a][a] : 0;
  }
}

/* Third moments in full. */
static void unpack_third(const double *m, double t[3][3][3]) {
  for (int a = 0; a < 3; a++)
    for (int b = a; b < 3; b++)
      for (int c = b; c < 3; c++, m++)
        t[a][b][c] = t[a][c][b] = t[b][a][c] = t[b][c][a] = t[c][a][b] = t[c][b][a] = *m;
}

/* Third moments of y, given those of x = A y: index after index, each of which goes last. */
static void whiten_third(double A[3][3], double t[3][3][3]) {
  for (int times = 0; times < 3; times++) {
    double next[3][3][3];
    for (int b = 0; b < 3; b++)
      for (int c = 0; c < 3; c++)
        ylm__tree_solve(A, (double[3]){t[0][b][c], t[1][b][c], t[2][b][c]}, next[b][c]);
    memcpy(t, next, sizeof next);
  }
}

/* The corners, changed by s of the head of this file. */
static void move_corners(const double s[3][3][3], const double *mirror, proxies *p) {
  for (int j = 0; j < p->n; j++) {
    double u[3], *x = p->x[j], w = 1;
    for (int a = 0; a < 3; a++) u[a] = mirror[a] * corner[j][a];
    for (int a = 0; a < 3; a++) {
      double square = 1;
      for (int b = 0; b < 3; b++) square += b == a ? 0 : s[a][a][b] * u[b];
      w -= s[a][a][a] * u[a] / 2;
      x[a] = u[a] * sqrt(fmax(square, LEAST));
    }
    p->weight[j] = fmax(w + s[0][1][2] * u[0] * u[1] * u[2], LEAST);
  }
}

/* Brings moments of degree 0, 1, 2 back to 1, 0, the identity; third moments are then t. */
static void normalise(proxies *p, double t[3][3][3]) {
  double m[MOMENTS] = {0}, L[3][3], cov[6], sum = 0;
  for (int j = 0; j < p->n; j++) sum += p->weight[j];
  for (int j = 0; j < p->n; j++) ylm__tree_add(m, p->weight[j] /= sum, p->x[j], 0);
  for (int a = 0, k = 0; a < 3; a++)
    for (int b = a; b < 3; b++, k++) cov[k] = m[M2 + k] - m[M1 + a] * m[M1 + b];
  ylm__tree_axes(cov, 0, L);
  double mean[3] = {m[M1], m[M1 + 1], m[M1 + 2]};
  memset(m, 0, sizeof m);
  for (int j = 0; j < p->n; j++) {
    double x[3];
    for (int a = 0; a < 3; a++) x[a] = p->x[j][a] - mean[a];
    ylm__tree_solve(L, x, p->x[j]);
    ylm__tree_add(m, p->weight[j], p->x[j], 0);
  }
  unpack_third(m + M3, t);
}

void ylm__tree_place(const cluster *q, double A[3][3], int n, double mirror, proxies *p) {
  double want[3][3][3], s[3][3][3] = {{{0}}}, sign[3], least = INFINITY;
  int axes = 0;
  for (int a = 0; a < 3; a++) axes += A[a][a] > 0, sign[a] = A[a][a] > 0 ? mirror : 0;
  unpack_third(q->shape + M3, want);
  whiten_third(A, want);
  bool fits = axes < 3 || n == YLM__MOST_PROXIES;
  for (int times = 0; times < (fits ? TIMES : 1); times++) {
    proxies next = {.n = n};
    double have[3][3][3], missing = 0;
    move_corners(s, sign, &next);
    normalise(&next, have);
    for (int i = 0; i < 27; i++) {
      double d = want[i / 9][i / 3 % 3][i % 3] - have[i / 9][i / 3 % 3][i % 3];
      s[i / 9][i / 3 % 3][i % 3] += d, missing += d * d;
    }
    if (missing < least) *p = next, least = missing;
  }
  for (int j = 0; j < n; j++) {
    double y[3];
    memcpy(y, p->x[j], sizeof y);
    for (int a = 0; a < 3; a++) p->x[j][a] = A[a][0] * y[0] + A[a][1] * y[1] + A[a][2] * y[2];
  }
}
