/*
** fit.c - least squares over the hemisphere, of slices by harmonics.
**
** The integral of (z (B - f))^2 above the surface is least where A b = F. A has the integrals of
** z^2 Y_q Y_p, F those of z^2 f Y_q. Harmonics of different m do not meet in A, so that each m has
** a matrix of its own.
*/
#include "fit.h"

#include <math.h>
#include <string.h>

#include "calibration.h"
#include "ylm_sh.h"

#define WIDE (YLM_MATERIAL_TABLE_FIT_LMAX + 1)
#define NODES 16 /* exact for polynomials of degree 31: z^2 times two of degree 8 has 18 */

struct material_fit {
  int lmax;
  double gram[WIDE][WIDE][WIDE];     /* [m][l - m][l' - m] */
  double triangle[WIDE][WIDE][WIDE]; /* Cholesky's, of the gram with its ridge */
};

/* Adds node z to the matrices. */
static void add_node(material_fit *fit, double z, double weight) {
  double p[WIDE * (WIDE + 1) / 2];
  ylm_sh_legendre(fit->lmax, z, sqrt(1 - z * z), p);
  for (int m = 0; m <= fit->lmax; m++)
    for (int i = m; i <= fit->lmax; i++)
      for (int j = m; j <= fit->lmax; j++)
        fit->gram[m][i - m][j - m] += (m ? YLM_PI : 2 * YLM_PI) * weight * z * z *
                                      p[i * (i + 1) / 2 + m] * p[j * (j + 1) / 2 + m];
}

static void factorise(int n, const double gram[WIDE][WIDE], double L[WIDE][WIDE]) {
  for (int i = 0; i < n; i++)
    for (int j = 0; j <= i; j++) {
      double sum = gram[i][j] * (i == j ? 1 + FIT_RIDGE : 1);
      for (int k = 0; k < j; k++) sum -= L[i][k] * L[j][k];
      L[i][j] = i == j ? sqrt(sum) : sum / L[j][j];
    }
}

material_fit *ylm__fit_create(int lmax) {
  material_fit *fit = ylm_alloc_zero(1, sizeof *fit);
  double z[NODES], weight[NODES];
  if (!fit) return NULL;
  fit->lmax = lmax;
  ylm_sh_gauss_legendre(NODES, z, weight);
  for (int i = 0; i < NODES; i++) add_node(fit, (z[i] + 1) / 2, weight[i] / 2);
  for (int m = 0; m <= lmax; m++)
    factorise(lmax + 1 - m, (const double(*)[WIDE])fit->gram[m], fit->triangle[m]);
  return fit;
}

/* Solves for one m: x [n] in and out. */
static void solve(int n, const double L[WIDE][WIDE], double *x) {
  for (int i = 0; i < n; i++) {
    for (int k = 0; k < i; k++) x[i] -= L[i][k] * x[k];
    x[i] /= L[i][i];
  }
  for (int i = n - 1; i >= 0; i--) {
    for (int k = i + 1; k < n; k++) x[i] -= L[k][i] * x[k];
    x[i] /= L[i][i];
  }
}

double ylm__fit(const material_fit *fit, double *c) {
  double off = 0;
  for (int m = -fit->lmax; m <= fit->lmax; m++) {
    int a = m < 0 ? -m : m, n = fit->lmax + 1 - a;
    double b[WIDE], F[WIDE];
    for (int i = 0; i < n; i++) b[i] = F[i] = c[(a + i) * (a + i + 1) + m];
    solve(n, (const double(*)[WIDE])fit->triangle[a], b);
    for (int i = 0; i < n; i++) {
      off += 2 * b[i] * F[i];
      for (int j = 0; j < n; j++) off -= b[i] * fit->gram[a][i][j] * b[j];
      c[(a + i) * (a + i + 1) + m] = b[i];
    }
  }
  return off;
}
