/* fourier.c - tables for products by Fourier series (Xin et al. 2021), and the choice of kernel. */
#include "fourier.h"

#include <math.h>

static void fourier_free(void *plan) {
  ylm__fourier *f = plan;
  if (!f) return;
  for (int i = 0; f->fft && i <= f->factors; i++) {
    ylm_free(f->fft[i].twiddle_d);
    ylm_free(f->fft[i].twiddle_f);
  }
  ylm_free(f->fft);
  ylm_free(f->series_d);
  ylm_free(f->series_f);
  ylm_free(f->back_d);
  ylm_free(f->back_f);
  ylm_free(f->series_at);
  ylm_free(f->back_at);
  ylm_free(f);
}

/* The least product of 2, 3 and 5 that is n or more, in steps of radix 4, 2, 3, 5. */
static bool plan(int n, ylm__fft *f) {
  for (;; n++) {
    int rest = n, steps = 0;
    while (rest % 4 == 0) f->radix[steps++] = 4, rest /= 4;
    while (rest % 2 == 0) f->radix[steps++] = 2, rest /= 2;
    while (rest % 3 == 0) f->radix[steps++] = 3, rest /= 3;
    while (rest % 5 == 0) f->radix[steps++] = 5, rest /= 5;
    f->steps = steps;
    if (rest == 1) break;
  }
  f->n = n;
  f->twiddle_d = ylm_alloc(2 * (size_t)n, sizeof(double));
  f->twiddle_f = ylm_alloc(2 * (size_t)n, sizeof(float));
  if (!f->twiddle_d || !f->twiddle_f) return false;
  for (int k = 0; k < n; k++) {
    f->twiddle_f[2 * k] = (float)(f->twiddle_d[2 * k] = cos(2 * YLM_PI * k / n));
    f->twiddle_f[2 * k + 1] = (float)(f->twiddle_d[2 * k + 1] = sin(2 * YLM_PI * k / n));
  }
  return true;
}

static float *floats(const double *x, size_t n) {
  float *f = x ? ylm_alloc(n, sizeof *f) : NULL;
  for (size_t i = 0; f && i < n; i++) f[i] = (float)x[i];
  return f;
}

/* Both tables, by a Gauss-Legendre rule exact for every integrand. */
static bool tables(ylm__fourier *f) {
  int L = f->lmax, d = f->factors * L, entries = (L + 1) * (L + 2) / 2, nodes = (d + L) / 2 + 2,
      cheb = L + 1;
  size_t ns = 0, nb = 0;
  f->series_at = ylm_alloc((size_t)entries, sizeof(size_t));
  f->back_at = ylm_alloc((size_t)entries, sizeof(size_t));
  double *x = ylm_alloc((size_t)(2 * nodes + (nodes + cheb) * entries), sizeof *x);
  if (!f->series_at || !f->back_at || !x) {
    ylm_free(x);
    return false;
  }
  for (int l = 0; l <= L; l++)
    for (int m = 0; m <= l; m++) {
      f->series_at[l * (l + 1) / 2 + m] = ns;
      f->back_at[l * (l + 1) / 2 + m] = nb;
      ns += (size_t)(l / 2 + 1);
      nb += (size_t)((d - (l & 1)) / 2 + 1);
    }
  f->series_d = ylm_alloc(ns + 1, sizeof(double));
  f->back_d = ylm_alloc(nb + 1, sizeof(double));
  double *w = x + nodes, *p = w + nodes, *q = p + nodes * entries;
  ylm_sh_gauss_legendre(nodes, x, w);
  for (int h = 0; h < nodes; h++) ylm_sh_legendre(L, x[h], sqrt(1 - x[h] * x[h]), p + h * entries);
  for (int h = 0; h < cheb; h++) { /* angles (h + 1/2) pi/cheb */
    double angle = (h + 0.5) * YLM_PI / cheb;
    ylm_sh_legendre(L, cos(angle), sin(angle), q + h * entries);
  }
  for (int l = 0; f->series_d && f->back_d && l <= L; l++)
    for (int m = 0; m <= l; m++) {
      int entry = l * (l + 1) / 2 + m;
      double *series = f->series_d + f->series_at[entry], *back = f->back_d + f->back_at[entry];
      for (int s = l; s >= 0; s -= 2) {
        /* half the amplitude of cos or sin (s theta), for the two exponents; for g_t half again if
         * m > 0 */
        double sum = 0;
        for (int h = 0; h < cheb; h++) {
          double angle = (h + 0.5) * YLM_PI / cheb;
          sum += q[h * entries + entry] * (m & 1 ? sin(s * angle) : cos(s * angle));
        }
        *series++ = sum / cheb * (m ? 0.5 : 1);
      }
      for (int s = l & 1; s <= d; s += 2) {
        double sum = 0;
        for (int h = 0; h < nodes; h++) {
          double angle = acos(x[h]);
          sum += w[h] * p[h * entries + entry] * (m & 1 ? sin(s * angle) : cos(s * angle));
        }
        *back++ = 2 * YLM_PI * sum * (s ? 2 : 1);
      }
    }
  ylm_free(x);
  f->series_f = floats(f->series_d, ns);
  f->back_f = floats(f->back_d, nb);
  return f->series_f && f->back_f;
}

static ylm_status create(int lmax, int factors, void **out, ylm_error *e) {
  (void)e;
  *out = NULL;
  ylm__fourier *f = ylm_alloc_zero(1, sizeof *f);
  if (!f) return YLM_ENOMEM;
  f->lmax = lmax;
  f->factors = factors;
  f->fft = ylm_alloc_zero((size_t)factors + 1, sizeof *f->fft);
  bool ok = f->fft && tables(f);
  for (int k = 2; ok && k <= factors; k++) ok = plan(2 * k * lmax + 1, f->fft + k);
  if (!ok) {
    fourier_free(f);
    return YLM_ENOMEM;
  }
  *out = f;
  return YLM_OK;
}

static size_t scratch_of(const void *plan, ylm_dtype t) {
  const ylm__fourier *f = plan;
  (void)t;
  size_t n = fourier_grid(f->fft[f->factors].n);
  for (int k = 0; k < f->factors; k++) n += fourier_size((f->factors - k) * f->lmax);
  return n * sizeof(double);
}

static YLM_KERNEL_CHOICE(ylm__fourier_run_float, run_float, ylm__fourier_run_f,
                         ylm__fourier_run_f_reference);
static YLM_KERNEL_CHOICE(ylm__fourier_run_double, run_double, ylm__fourier_run_d,
                         ylm__fourier_run_d_reference);

static void apply(const void *plan, ylm_dtype t, const void *const *c, void *out, void *scratch,
                  double *stage) {
  if (t == YLM_DOUBLE)
    run_double()(plan, (const double *const *)c, out, scratch, stage);
  else
    run_float()(plan, (const float *const *)c, out, scratch, stage);
}

const ylm_sh_rival_product ylm__rival_fourier = {create, fourier_free, scratch_of, apply};
