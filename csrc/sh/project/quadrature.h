/* quadrature.h - Gauss-Legendre rules and Legendre tables. Private to csrc/sh. */
#ifndef YLM_SH_QUADRATURE_H
#define YLM_SH_QUADRATURE_H

/* n nodes in (-1, 1), rising, and their weights; exact to degree 2n-1. Newton's method in long
 * double. */
void ylm__gauss_legendre(int n, double *x, double *w);

/* p[l*(l+1)/2+m] = sqrt(m ? 2 : 1) K_lm P_lm(x) with the Condon-Shortley phase, 0 <= m <= l <=
   lmax: the part of Y_lm that depends on z = x. `sine` is sqrt(1-x^2). */
void ylm__legendre(int lmax, double x, double sine, double *p);

#endif
