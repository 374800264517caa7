/*
** fourier_kernel.h - products by Fourier series, for the unit's element type. Private to csrc/rival.
**
** A unit of an instruction set, and one of none, defines YLM_REAL_IS_FLOAT or does not, as those of ylm_real.h.
*/
#ifndef YLM_RIVAL_FOURIER_KERNEL_H
#define YLM_RIVAL_FOURIER_KERNEL_H

#include <string.h>

#include "fourier.h"
#ifdef YLM_ISA
#include "ylm_simd.h"
#else
#define YLM_KERNEL(name) name##_reference
#endif

#ifdef YLM_REAL_IS_FLOAT
typedef float real;
#define TWIDDLE twiddle_f
#define SERIES series_f
#define BACK back_f
#define RUN YLM_KERNEL(ylm__fourier_run_f)
#else
typedef double real;
#define TWIDDLE twiddle_d
#define SERIES series_d
#define BACK back_d
#define RUN YLM_KERNEL(ylm__fourier_run_d)
#endif

/* One radix step of the transform of n = r m rows of w numbers, s of them together (Stockham). */
static void step(int r, int m, int s, int w, const real *tw, int stride, const real *restrict xr,
                 const real *restrict xi, real *restrict yr, real *restrict yi) {
  const real c3 = (real)0.86602540378443864676, c51 = (real)0.30901699437494742410,
             c52 = (real)-0.80901699437494742410;
  const real s51 = (real)0.95105651629515357212, s52 = (real)0.58778525229247312917;
  size_t width = (size_t)s * (size_t)w, apart = (size_t)m * width;
  for (int p = 0; p < m; p++) {
    const real *ar = xr + (size_t)p * width, *ai = xi + (size_t)p * width;
    real *br = yr + (size_t)p * (size_t)r * width, *bi = yi + (size_t)p * (size_t)r * width;
    real wr[5], wi[5];
    for (int k = 1; k < r; k++) wr[k] = tw[2 * p * k * stride], wi[k] = tw[2 * p * k * stride + 1];
#define PUT(k, re, im)                                                                             \
  do {                                                                                             \
    real re_ = (re), im_ = (im);                                                                   \
    br[(k)*width + q] = re_ * wr[k] - im_ * wi[k];                                                 \
    bi[(k)*width + q] = re_ * wi[k] + im_ * wr[k];                                                 \
  } while (0)
    switch (r) {
    case 2:
      for (size_t q = 0; q < width; q++) {
        real r0 = ar[q], r1 = ar[apart + q], i0 = ai[q], i1 = ai[apart + q];
        br[q] = r0 + r1, bi[q] = i0 + i1;
        PUT(1, r0 - r1, i0 - i1);
      }
      break;
    case 3:
      for (size_t q = 0; q < width; q++) {
        real r0 = ar[q], r1 = ar[apart + q], r2 = ar[2 * apart + q], i0 = ai[q], i1 = ai[apart + q],
             i2 = ai[2 * apart + q];
        real tr = r1 + r2, ti = i1 + i2, ur = r0 - tr / 2, ui = i0 - ti / 2, vr = c3 * (r1 - r2),
             vi = c3 * (i1 - i2);
        br[q] = r0 + tr, bi[q] = i0 + ti;
        PUT(1, ur - vi, ui + vr);
        PUT(2, ur + vi, ui - vr);
      }
      break;
    case 4:
      for (size_t q = 0; q < width; q++) {
        real r0 = ar[q], r1 = ar[apart + q], r2 = ar[2 * apart + q], r3 = ar[3 * apart + q];
        real i0 = ai[q], i1 = ai[apart + q], i2 = ai[2 * apart + q], i3 = ai[3 * apart + q];
        real a = r0 + r2, b = r0 - r2, c = r1 + r3, d = r1 - r3, e = i0 + i2, f = i0 - i2,
             g = i1 + i3, h = i1 - i3;
        br[q] = a + c, bi[q] = e + g;
        PUT(1, b - h, f + d);
        PUT(2, a - c, e - g);
        PUT(3, b + h, f - d);
      }
      break;
    default:
      for (size_t q = 0; q < width; q++) {
        real r0 = ar[q], i0 = ai[q], ra = ar[apart + q] + ar[4 * apart + q],
             rb = ar[apart + q] - ar[4 * apart + q];
        real ia = ai[apart + q] + ai[4 * apart + q], ib = ai[apart + q] - ai[4 * apart + q];
        real rc = ar[2 * apart + q] + ar[3 * apart + q], rd = ar[2 * apart + q] - ar[3 * apart + q];
        real ic = ai[2 * apart + q] + ai[3 * apart + q], id = ai[2 * apart + q] - ai[3 * apart + q];
        real ur = r0 + c51 * ra + c52 * rc, ui = i0 + c51 * ia + c52 * ic;
        real vr = r0 + c52 * ra + c51 * rc, vi = i0 + c52 * ia + c51 * ic;
        real pr = s51 * rb + s52 * rd, pi = s51 * ib + s52 * id, qr = s52 * rb - s51 * rd,
             qi = s52 * ib - s51 * id;
        br[q] = r0 + ra + rc, bi[q] = i0 + ia + ic;
        PUT(1, ur - pi, ui + pr);
        PUT(2, vr - qi, vi + qr);
        PUT(3, vr + qi, vi - qr);
        PUT(4, ur + pi, ui - pr);
      }
    }
#undef PUT
  }
}

/* sum over rows j of x_j e^(2 pi i j k/n) for all k; x [n][w] re and im, y scratch of that size.
   Returns whether the result is in y. Exchanging re and im changes the sign of the exponent. */
static bool transform(const ylm__fft *f, int w, real *xr, real *xi, real *yr, real *yi) {
  int n = f->n, s = 1;
  bool swapped = false;
  for (int i = 0; i < f->steps; i++) {
    int r = f->radix[i], m = n / r;
    step(r, m, s, w, f->TWIDDLE, f->n / n, swapped ? yr : xr, swapped ? yi : xi, swapped ? xr : yr,
         swapped ? xi : yi);
    swapped = !swapped;
    n = m;
    s *= r;
  }
  return swapped;
}

/* Values at n x n angles: out [phi q][theta pair] complex, real and imaginary part two rows of
   theta. in: degree d. g: four arrays of n*n numbers of scratch; returns where the values are: 0
   or 2. */
static int values(const ylm__fft *f, int d, const real *in, real *const *g) {
  int n = f->n, w = d + 1, half = (n + 1) / 2;
  const real *re = in, *im = in + (2 * d + 1) * w;
  memset(g[0], 0, (size_t)(n * w) * sizeof(real));
  memset(g[1], 0, (size_t)(n * w) * sizeof(real));
  for (int s = -d; s <= d; s++) {
    memcpy(g[0] + ((s + n) % n) * w, re + (s + d) * w, (size_t)w * sizeof(real));
    memcpy(g[1] + ((s + n) % n) * w, im + (s + d) * w, (size_t)w * sizeof(real));
  }
  int at = transform(f, w, g[0], g[1], g[2], g[3]) ? 2 : 0, to = 2 - at;
  /* rows p and p + half become one complex row: z_t = a_t + i b_t, z_-t = conj a_t + i conj b_t */
  memset(g[to], 0, (size_t)(n * half) * sizeof(real));
  memset(g[to + 1], 0, (size_t)(n * half) * sizeof(real));
  for (int p = 0; p < half; p++) {
    const real *ar = g[at] + p * w, *ai = g[at + 1] + p * w;
    const real *br = p + half < n ? ar + half * w : NULL, *bi = p + half < n ? ai + half * w : NULL;
    for (int t = 0; t <= d; t++) {
      real b0 = br ? br[t] : 0, b1 = bi ? bi[t] : 0;
      g[to][t * half + p] = ar[t] - b1;
      g[to + 1][t * half + p] = ai[t] + b0;
      if (t == 0) continue;
      g[to][(n - t) * half + p] = ar[t] + b1;
      g[to + 1][(n - t) * half + p] = b0 - ai[t];
    }
  }
  return transform(f, half, g[to], g[to + 1], g[at], g[at + 1]) ? at : to;
}

/* out (degree da + db) = a * b, a and b of degrees da and db; out may be either. */
static void convolve(const ylm__fft *f, int da, const real *a, int db, const real *b, real *out,
                     real *scratch) {
  int n = f->n, half = (n + 1) / 2, d = da + db, w = d + 1;
  size_t grid = (size_t)n * (size_t)n;
  real *g[8];
  for (int i = 0; i < 8; i++) g[i] = scratch + (size_t)i * grid;
  real *const *h = g + 4;
  int at = values(f, da, a, g), bt = values(f, db, b, h);
  real *re = g[at], *im = g[at + 1];
  for (int i = 0; i < n * half; i++) {
    re[i] *= h[bt][i];
    im[i] *= h[bt + 1][i];
  }
  real scale = (real)(1.0 / ((double)n * n));
  /* back along phi: exponents with the other sign */
  int to = 2 - at;
  int z = transform(f, half, im, re, g[to + 1], g[to]) ? to : at, y = 2 - z;
  /* z_t = a_t + i b_t again: the rows of theta apart, [theta][t] */
  for (int p = 0; p < half; p++)
    for (int t = 0; t <= d; t++) {
      int o = t ? n - t : 0;
      real zr = g[z][t * half + p], zi = g[z + 1][t * half + p], cr = g[z][o * half + p],
           ci = g[z + 1][o * half + p];
      g[y][p * w + t] = (zr + cr) / 2;
      g[y + 1][p * w + t] = (zi - ci) / 2;
      if (p + half < n) {
        g[y][(p + half) * w + t] = (zi + ci) / 2;
        g[y + 1][(p + half) * w + t] = (cr - zr) / 2;
      }
    }
  z = transform(f, w, g[y + 1], g[y], g[z + 1], g[z]) ? z : y;
  real *outi = out + (2 * d + 1) * w;
  for (int s = -d; s <= d; s++)
    for (int t = 0; t <= d; t++) {
      out[(s + d) * w + t] = scale * g[z][((s + n) % n) * w + t];
      outi[(s + d) * w + t] = scale * g[z + 1][((s + n) % n) * w + t];
    }
}

/* The series of a coefficient vector. */
static void to_series(const ylm__fourier *f, const real *c, real *out) {
  int d = f->lmax, w = d + 1;
  real *re = out, *im = out + (2 * d + 1) * w;
  memset(out, 0, fourier_size(d) * sizeof(real));
  for (int m = 0; m <= d; m++)
    for (int l = m; l <= d; l++) {
      const real *a = f->SERIES + f->series_at[l * (l + 1) / 2 + m];
      real x = c[l * (l + 1) + m], y = m ? -c[l * (l + 1) - m] : 0;
      for (int s = l; s >= 0; s -= 2) {
        real v = *a++;
        real *rs = re + (d + s) * w + m, *is = im + (d + s) * w + m;
        if (m & 1)
          *rs += v * y, *is -= v * x; /* -i A */
        else
          *rs += v * x, *is += v * y;
      }
    }
  for (int m = 0; m <= d; m++)
    for (int s = 1; s <= d; s++) {
      real sign = m & 1 ? -1 : 1;
      re[(d - s) * w + m] = sign * re[(d + s) * w + m];
      im[(d - s) * w + m] = sign * im[(d + s) * w + m];
    }
}

/* The coefficients up to lmax of a series of degree d. */
static void from_series(const ylm__fourier *f, int d, const real *in, real *c) {
  int w = d + 1;
  const real *re = in + d * w, *im = in + (2 * d + 1) * w + d * w;
  for (int m = 0; m <= f->lmax; m++)
    for (int l = m; l <= f->lmax; l++) {
      const real *a = f->BACK + f->back_at[l * (l + 1) / 2 + m];
      real x = 0, y = 0;
      for (int s = l & 1; s <= d; s += 2) {
        real v = *a++, r = re[s * w + m], i = im[s * w + m];
        if (m & 1)
          x -= v * i, y += v * r;
        else
          x += v * r, y += v * i;
      }
      c[l * (l + 1) + m] = x;
      if (m) c[l * (l + 1) - m] = -y;
    }
}

/* The series of factors first .. last-1 multiplied, in `out`; divide and conquer. */
static void multiply(const ylm__fourier *f, int first, int last, real *const *series,
                     real *scratch) {
  if (last - first < 2) return;
  int middle = (first + last) / 2, da = (middle - first) * f->lmax, db = (last - middle) * f->lmax;
  multiply(f, first, middle, series, scratch);
  multiply(f, middle, last, series, scratch);
  convolve(f->fft + (last - first), da, series[first], db, series[middle], series[first], scratch);
}

void RUN(const ylm__fourier *f, const real *const *c, real *out, real *scratch, double *stage) {
  real *series[YLM_SH_PRODUCT_FACTORS];
  for (int k = 0; k < f->factors; k++) {
    series[k] = scratch;
    scratch +=
        fourier_size((f->factors - k) * f->lmax); /* room for the product of it and all after it */
  }
  double t0 = stage ? ylm_seconds() : 0;
  for (int k = 0; k < f->factors; k++) to_series(f, c[k], series[k]);
  double t1 = stage ? ylm_seconds() : 0;
  multiply(f, 0, f->factors, series, scratch);
  double t2 = stage ? ylm_seconds() : 0;
  from_series(f, f->factors * f->lmax, series[0], out);
  if (stage) {
    stage[0] += t1 - t0;
    stage[1] += t2 - t1;
    stage[2] += ylm_seconds() - t2;
  }
}

#endif
