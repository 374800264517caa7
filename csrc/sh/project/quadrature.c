/* quadrature.c - Gauss-Legendre rules and Legendre tables. */
#include "ylm_sh.h"

#include <math.h>

void ylm_sh_gauss_legendre(int n, double *x, double *w) {
  const long double pi = 3.14159265358979323846264L;
  for (int i = 0; i < (n + 1) / 2; i++) {
    long double t = cosl(pi * (i + 0.75L) / (n + 0.5L)), derivative = 1;
    for (int pass = 0; pass < 100; pass++) {
      long double a = 1, b = 0;
      for (int k = 1; k <= n; k++) {
        long double c = ((2 * k - 1) * t * a - (k - 1) * b) / k;
        b = a;
        a = c;
      }
      derivative = n * (t * a - b) / (t * t - 1);
      long double step = a / derivative;
      t -= step;
      if (fabsl(step) < 1e-18L) break;
    }
    if (2 * i + 1 == n) t = 0;
    x[n - 1 - i] = (double)t;
    x[i] = (double)-t;
    w[i] = w[n - 1 - i] = (double)(2 / ((1 - t * t) * derivative * derivative));
  }
}

void ylm_sh_legendre(int lmax, double x, double sine, double *p) {
  const long double pi = 3.14159265358979323846264L;
  long double diagonal = sqrtl(1 / (4 * pi));
  for (int m = 0; m <= lmax; m++) {
    if (m > 0) diagonal *= -sqrtl((2 * m + 1) / (2.0L * m)) * sine;
    long double scale = m ? sqrtl(2) : 1, a = 0, b = diagonal;
    for (int l = m; l <= lmax; l++) {
      p[l * (l + 1) / 2 + m] = (double)(scale * b);
      /* l+1 from l and l-1 */
      long double q = (long double)(l + 1) * (l + 1) - (long double)m * m,
                  r = (long double)l * l - (long double)m * m;
      long double next = sqrtl((4.0L * (l + 1) * (l + 1) - 1) / q) *
                         (x * b - (l > m ? sqrtl(r / (4.0L * l * l - 1)) * a : 0));
      a = b;
      b = next;
    }
  }
}
