/*
** far.c - how well the field of far lights is found by interpolation, and how many nodes that
** takes.
**
** One axis is looked at, of half extent 1. A small light is at the distance D across its middle,
** where convergence is slowest. K(x,y) is the inner product of the k-th derivatives of its
** coefficients at x and at y, summed over coefficients and components:
**
**   K(x,y) = sum over l of W_k(l) P_l(cos) / (d_x d_y)^(2+k)
**
** ylm__tree_norms sums the weights W_k of degrees. Interpolation in n of Chebyshev's nodes loses
** what polynomials of degree n and higher make of it, and as much by aliasing: with K = sum c_ij
** T_i(x) T_j(y) the norm of the error is at most 2 sqrt(sum over i, j >= n of |c_ij|). Half of that
** is within some percent of the largest error of interpolated lights (lmax 1 to 15, any place), and
** taken.
**
** Source  docs/math.md "Many lights", Blocks
*/
#include "tree.h"

#include <math.h>
#include <string.h>

#define SAMPLES (YLM__FAR_NODES + 8) /* Chebyshev coefficients that are looked at */
#define NEAREST 0.5                  /* distances of the table: this times sqrt(2)^i */
#define MOST 16.0                    /* and the largest that is of use */

/* W_k(l): how often each degree is among the k-th derivatives of all d^-2 Y_lm, l <= lmax. */
static void find_weights(int lmax, int k, double *W) {
  double next[YLM_LIGHT_LMAX + 4];
  memset(W, 0, sizeof next);
  for (int l = 0; l <= lmax; l++) W[l] = 2 * l + 1;
  for (int j = 0; j < k; j++) {
    int a = -2 - j;
    memset(next, 0, sizeof next);
    for (int l = 0; l <= lmax + j; l++) {
      double each = W[l] / (2 * l + 1);
      next[l + 1] += each * (l + 1) * (a - l) * (a - l);
      if (l > 0) next[l - 1] += each * l * (a + l + 1) * (a + l + 1);
    }
    memcpy(W, next, sizeof next);
  }
}

/* K(x,y) for a light at the distance `d` across the middle, of weights W up to `top`. */
static double product(const double *W, int top, int k, double d, double x, double y) {
  double d2 = (x * x + d * d) * (y * y + d * d), z = (x * y + d * d) / sqrt(d2);
  double before = 1, now = z, sum = W[0] + W[1] * z;
  for (int l = 1; l < top; l++) {
    double next = ((2 * l + 1) * z * now - l * before) / (l + 1);
    before = now, now = next;
    sum += W[l + 1] * next;
  }
  return sum / pow(d2, 0.5 * (2 + k));
}

/* Chebyshev's coefficients of K along x, then along y: [SAMPLES][SAMPLES] in place. */
static void expand(double *K) {
  double cosine[SAMPLES][SAMPLES], turned[SAMPLES * SAMPLES];
  for (int i = 0; i < SAMPLES; i++)
    for (int j = 0; j < SAMPLES; j++)
      cosine[i][j] = (i ? 2.0 : 1.0) / SAMPLES * cos(i * (j + 0.5) * YLM_PI / SAMPLES);
  for (int turn = 0; turn < 2; turn++) {
    for (int i = 0; i < SAMPLES; i++)
      for (int j = 0; j < SAMPLES; j++) {
        double s = 0;
        for (int a = 0; a < SAMPLES; a++) s += cosine[i][a] * K[j * SAMPLES + a];
        turned[i * SAMPLES + j] = s;
      }
    memcpy(K, turned, sizeof turned);
  }
}

static void find_errors(int lmax, int k, double d, float error[YLM__FAR_NODES + 1]) {
  double W[YLM_LIGHT_LMAX + 4], K[SAMPLES * SAMPLES], x[SAMPLES], unit = 0, tail = 0;
  find_weights(lmax, k, W);
  for (int l = 0; l <= lmax + k; l++) unit += W[l];
  for (int i = 0; i < SAMPLES; i++) x[i] = cos((i + 0.5) * YLM_PI / SAMPLES);
  for (int i = 0; i < SAMPLES; i++)
    for (int j = 0; j <= i; j++)
      K[i * SAMPLES + j] = K[j * SAMPLES + i] = product(W, lmax + k, k, d, x[i], x[j]);
  expand(K);
  for (int n = SAMPLES - 1; n >= 0; n--) {
    tail += fabs(K[n * SAMPLES + n]);
    for (int j = n + 1; j < SAMPLES; j++)
      tail += fabs(K[n * SAMPLES + j]) + fabs(K[j * SAMPLES + n]);
    if (n <= YLM__FAR_NODES) error[n] = (float)log2(sqrt(tail / unit) * pow(d, 2 + k));
  }
}

void ylm__far_create(int lmax, const bool want[3], ylm__far *f) {
  for (int k = 0; k < 3; k++)
    for (int i = 0; want[k] && i < YLM__FAR_STEPS; i++)
      find_errors(lmax, k, NEAREST * pow(2, 0.5 * i), f->error[k][i]);
}

/* log2 of the error of n nodes at `d` half extents: between the table's distances, and beyond by
   the power of the distance. */
static double error_at(const float table[YLM__FAR_STEPS][YLM__FAR_NODES + 1], int n, double d) {
  double at = 2 * log2(d / NEAREST);
  if (!(at > 0)) return table[0][n];
  double over = at - (YLM__FAR_STEPS - 1);
  if (over >= 0) return table[YLM__FAR_STEPS - 1][n] - 0.5 * n * over;
  int i = (int)at;
  return table[i][n] + (at - i) * (table[i + 1][n] - table[i][n]);
}

/* The number of nodes at the distance `d` half extents that keeps all errors below `most`. */
static int nodes_for(const ylm__far *f, const bool want[3], double d, const double most[3]) {
  int n = 1;
  for (int k = 0; k < 3; k++)
    while (want[k] && n <= YLM__FAR_NODES && !(error_at(f->error[k], n, d) <= most[k])) n++;
  return n;
}

double ylm__far_nodes(const ylm__far *f, const bool want[3], const float half[3],
                      const float part[3], int n[3]) {
  double most[3], extent = 0, at = 0, step = 2;
  int axes = 0, along = n[0];
  for (int a = 0; a < 3; a++) extent = fmax(extent, (double)half[a]), axes += half[a] > 0;
  for (int k = 0; k < 3; k++) most[k] = log2((double)part[k] / axes);
  if (!(nodes_for(f, want, MOST, most) <= along)) return 0;
  for (double d = MOST; step > 1.01; step = sqrt(step)) {
    while (d / step >= NEAREST && nodes_for(f, want, d / step, most) <= along) d /= step;
    at = d;
  }
  for (int a = 0; a < 3; a++) {
    n[a] = half[a] > 0 ? nodes_for(f, want, at * extent / (double)half[a], most) : 1;
    if (n[a] > along) n[a] = along;
  }
  return at * extent;
}
