/* fourier_kernel.h - products by Fourier series for one element type; included twice by
   fourier.isa.c and by fourier.c. */

/* One radix step of the transform of n = r m rows of w numbers, s of them together (Stockham). */
static void FN(step)(int r, int m, int s, int w, const T *tw, int stride, const T *restrict xr,
                     const T *restrict xi, T *restrict yr, T *restrict yi) {
  const T c3 = (T)0.86602540378443864676, c51 = (T)0.30901699437494742410,
          c52 = (T)-0.80901699437494742410;
  const T s51 = (T)0.95105651629515357212, s52 = (T)0.58778525229247312917;
  size_t width = (size_t)s * (size_t)w, apart = (size_t)m * width;
  for (int p = 0; p < m; p++) {
    const T *ar = xr + (size_t)p * width, *ai = xi + (size_t)p * width;
    T *br = yr + (size_t)p * (size_t)r * width, *bi = yi + (size_t)p * (size_t)r * width;
    T wr[5], wi[5];
    for (int k = 1; k < r; k++) wr[k] = tw[2 * p * k * stride], wi[k] = tw[2 * p * k * stride + 1];
#define PUT(k, re, im)                                                                             \
  do {                                                                                             \
    T re_ = (re), im_ = (im);                                                                      \
    br[(k)*width + q] = re_ * wr[k] - im_ * wi[k];                                                 \
    bi[(k)*width + q] = re_ * wi[k] + im_ * wr[k];                                                 \
  } while (0)
    switch (r) {
    case 2:
      for (size_t q = 0; q < width; q++) {
        T r0 = ar[q], r1 = ar[apart + q], i0 = ai[q], i1 = ai[apart + q];
        br[q] = r0 + r1, bi[q] = i0 + i1;
        PUT(1, r0 - r1, i0 - i1);
      }
      break;
    case 3:
      for (size_t q = 0; q < width; q++) {
        T r0 = ar[q], r1 = ar[apart + q], r2 = ar[2 * apart + q], i0 = ai[q], i1 = ai[apart + q],
          i2 = ai[2 * apart + q];
        T tr = r1 + r2, ti = i1 + i2, ur = r0 - tr / 2, ui = i0 - ti / 2, vr = c3 * (r1 - r2),
          vi = c3 * (i1 - i2);
        br[q] = r0 + tr, bi[q] = i0 + ti;
        PUT(1, ur - vi, ui + vr);
        PUT(2, ur + vi, ui - vr);
      }
      break;
    case 4:
      for (size_t q = 0; q < width; q++) {
        T r0 = ar[q], r1 = ar[apart + q], r2 = ar[2 * apart + q], r3 = ar[3 * apart + q];
        T i0 = ai[q], i1 = ai[apart + q], i2 = ai[2 * apart + q], i3 = ai[3 * apart + q];
        T a = r0 + r2, b = r0 - r2, c = r1 + r3, d = r1 - r3, e = i0 + i2, f = i0 - i2, g = i1 + i3,
          h = i1 - i3;
        br[q] = a + c, bi[q] = e + g;
        PUT(1, b - h, f + d);
        PUT(2, a - c, e - g);
        PUT(3, b + h, f - d);
      }
      break;
    default:
      for (size_t q = 0; q < width; q++) {
        T r0 = ar[q], i0 = ai[q], ra = ar[apart + q] + ar[4 * apart + q],
          rb = ar[apart + q] - ar[4 * apart + q];
        T ia = ai[apart + q] + ai[4 * apart + q], ib = ai[apart + q] - ai[4 * apart + q];
        T rc = ar[2 * apart + q] + ar[3 * apart + q], rd = ar[2 * apart + q] - ar[3 * apart + q];
        T ic = ai[2 * apart + q] + ai[3 * apart + q], id = ai[2 * apart + q] - ai[3 * apart + q];
        T ur = r0 + c51 * ra + c52 * rc, ui = i0 + c51 * ia + c52 * ic;
        T vr = r0 + c52 * ra + c51 * rc, vi = i0 + c52 * ia + c51 * ic;
        T pr = s51 * rb + s52 * rd, pi = s51 * ib + s52 * id, qr = s52 * rb - s51 * rd,
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
static bool FN(transform)(const ylm__fft *f, int w, T *xr, T *xi, T *yr, T *yi) {
  int n = f->n, s = 1;
  bool swapped = false;
  for (int i = 0; i < f->steps; i++) {
    int r = f->radix[i], m = n / r;
    FN(step)
    (r, m, s, w, f->TWIDDLE, f->n / n, swapped ? yr : xr, swapped ? yi : xi, swapped ? xr : yr,
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
static int FN(values)(const ylm__fft *f, int d, const T *in, T *const *g) {
  int n = f->n, w = d + 1, half = (n + 1) / 2;
  const T *re = in, *im = in + (2 * d + 1) * w;
  memset(g[0], 0, (size_t)(n * w) * sizeof(T));
  memset(g[1], 0, (size_t)(n * w) * sizeof(T));
  for (int s = -d; s <= d; s++) {
    memcpy(g[0] + ((s + n) % n) * w, re + (s + d) * w, (size_t)w * sizeof(T));
    memcpy(g[1] + ((s + n) % n) * w, im + (s + d) * w, (size_t)w * sizeof(T));
  }
  int at = FN(transform)(f, w, g[0], g[1], g[2], g[3]) ? 2 : 0, to = 2 - at;
  /* rows p and p + half become one complex row: z_t = a_t + i b_t, z_-t = conj a_t + i conj b_t */
  memset(g[to], 0, (size_t)(n * half) * sizeof(T));
  memset(g[to + 1], 0, (size_t)(n * half) * sizeof(T));
  for (int p = 0; p < half; p++) {
    const T *ar = g[at] + p * w, *ai = g[at + 1] + p * w;
    const T *br = p + half < n ? ar + half * w : NULL, *bi = p + half < n ? ai + half * w : NULL;
    for (int t = 0; t <= d; t++) {
      T b0 = br ? br[t] : 0, b1 = bi ? bi[t] : 0;
      g[to][t * half + p] = ar[t] - b1;
      g[to + 1][t * half + p] = ai[t] + b0;
      if (t == 0) continue;
      g[to][(n - t) * half + p] = ar[t] + b1;
      g[to + 1][(n - t) * half + p] = b0 - ai[t];
    }
  }
  return FN(transform)(f, half, g[to], g[to + 1], g[at], g[at + 1]) ? at : to;
}

/* out (degree da + db) = a * b, a and b of degrees da and db; out may be either. */
static void FN(convolve)(const ylm__fft *f, int da, const T *a, int db, const T *b, T *out,
                         T *scratch) {
  int n = f->n, half = (n + 1) / 2, d = da + db, w = d + 1;
  size_t grid = (size_t)n * (size_t)n;
  T *g[8];
  for (int i = 0; i < 8; i++) g[i] = scratch + (size_t)i * grid;
  T *const *h = g + 4;
  int at = FN(values)(f, da, a, g), bt = FN(values)(f, db, b, h);
  T *re = g[at], *im = g[at + 1];
  for (int i = 0; i < n * half; i++) {
    re[i] *= h[bt][i];
    im[i] *= h[bt + 1][i];
  }
  T scale = (T)(1.0 / ((double)n * n));
  /* back along phi: exponents with the other sign */
  int to = 2 - at;
  int z = FN(transform)(f, half, im, re, g[to + 1], g[to]) ? to : at, y = 2 - z;
  /* z_t = a_t + i b_t again: the rows of theta apart, [theta][t] */
  for (int p = 0; p < half; p++)
    for (int t = 0; t <= d; t++) {
      int o = t ? n - t : 0;
      T zr = g[z][t * half + p], zi = g[z + 1][t * half + p], cr = g[z][o * half + p],
        ci = g[z + 1][o * half + p];
      g[y][p * w + t] = (zr + cr) / 2;
      g[y + 1][p * w + t] = (zi - ci) / 2;
      if (p + half < n) {
        g[y][(p + half) * w + t] = (zi + ci) / 2;
        g[y + 1][(p + half) * w + t] = (cr - zr) / 2;
      }
    }
  z = FN(transform)(f, w, g[y + 1], g[y], g[z + 1], g[z]) ? z : y;
  T *outi = out + (2 * d + 1) * w;
  for (int s = -d; s <= d; s++)
    for (int t = 0; t <= d; t++) {
      out[(s + d) * w + t] = scale * g[z][((s + n) % n) * w + t];
      outi[(s + d) * w + t] = scale * g[z + 1][((s + n) % n) * w + t];
    }
}

/* The series of a coefficient vector. */
static void FN(to_series)(const ylm__fourier *f, const T *c, T *out) {
  int d = f->lmax, w = d + 1;
  T *re = out, *im = out + (2 * d + 1) * w;
  memset(out, 0, fourier_size(d) * sizeof(T));
  for (int m = 0; m <= d; m++)
    for (int l = m; l <= d; l++) {
      const T *a = f->SERIES + f->series_at[l * (l + 1) / 2 + m];
      T x = c[l * (l + 1) + m], y = m ? -c[l * (l + 1) - m] : 0;
      for (int s = l; s >= 0; s -= 2) {
        T v = *a++;
        T *rs = re + (d + s) * w + m, *is = im + (d + s) * w + m;
        if (m & 1)
          *rs += v * y, *is -= v * x; /* -i A */
        else
          *rs += v * x, *is += v * y;
      }
    }
  for (int m = 0; m <= d; m++)
    for (int s = 1; s <= d; s++) {
      T sign = m & 1 ? -1 : 1;
      re[(d - s) * w + m] = sign * re[(d + s) * w + m];
      im[(d - s) * w + m] = sign * im[(d + s) * w + m];
    }
}

/* The coefficients up to lmax of a series of degree d. */
static void FN(from_series)(const ylm__fourier *f, int d, const T *in, T *c) {
  int w = d + 1;
  const T *re = in + d * w, *im = in + (2 * d + 1) * w + d * w;
  for (int m = 0; m <= f->lmax; m++)
    for (int l = m; l <= f->lmax; l++) {
      const T *a = f->BACK + f->back_at[l * (l + 1) / 2 + m];
      T x = 0, y = 0;
      for (int s = l & 1; s <= d; s += 2) {
        T v = *a++, r = re[s * w + m], i = im[s * w + m];
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
static void FN(multiply)(const ylm__fourier *f, int first, int last, T *const *series, T *scratch) {
  if (last - first < 2) return;
  int middle = (first + last) / 2, da = (middle - first) * f->lmax, db = (last - middle) * f->lmax;
  FN(multiply)(f, first, middle, series, scratch);
  FN(multiply)(f, middle, last, series, scratch);
  FN(convolve)
  (f->fft + (last - first), da, series[first], db, series[middle], series[first], scratch);
}

static void FN(run)(const ylm__fourier *f, const T *const *c, T *out, T *scratch, double *stage) {
  T *series[YLM_SH_PRODUCT_FACTORS];
  for (int k = 0; k < f->factors; k++) {
    series[k] = scratch;
    scratch +=
        fourier_size((f->factors - k) * f->lmax); /* room for the product of it and all after it */
  }
  double t0 = stage ? ylm_seconds() : 0;
  for (int k = 0; k < f->factors; k++) FN(to_series)(f, c[k], series[k]);
  double t1 = stage ? ylm_seconds() : 0;
  FN(multiply)(f, 0, f->factors, series, scratch);
  double t2 = stage ? ylm_seconds() : 0;
  FN(from_series)(f, f->factors * f->lmax, series[0], out);
  if (stage) {
    stage[0] += t1 - t0;
    stage[1] += t2 - t1;
    stage[2] += ylm_seconds() - t2;
  }
}
