/* eval.c - ylm_sh_eval: arguments checked, a kernel chosen, points shared among threads. */
#include "sh_eval.h"

#include <float.h>
#include <math.h>

/* Points to a block of work. */
#define GRAIN 512

const char *ylm_sh_method_name(ylm_sh_method m) {
  static const char *const names[] = {
#define X(name) #name,
      YLM_SH_METHOD_LIST(X)
#undef X
  };
  return (int)m >= 0 && m < YLM_SH_METHOD_COUNT ? names[m] : "?";
}

static double number(ylm_dtype t, const void *p, size_t i) {
  return t == YLM_DOUBLE ? ((const double *)p)[i] : (double)((const float *)p)[i];
}

/* The shortest and longest largest-coordinates that points may have, for all results to be
   representable with room for a factor of (lmax+1)^2. */
static void limits(const ylm_sh_how *how, int lmax, ylm_dtype t, double *shortest, double *longest) {
  double max_exponent = (t == YLM_DOUBLE ? DBL_MAX_EXP : FLT_MAX_EXP) - 3 - 2 * log2(lmax + 1.0);
  *shortest = 0, *longest = t == YLM_DOUBLE ? DBL_MAX : FLT_MAX;
  if (how->solid) {
    if (lmax > 0) *longest = fmin(*longest, exp2(max_exponent / lmax) / sqrt(3));
  } else if (how->derivatives > 0) *shortest = exp2(-max_exponent / how->derivatives);
}

/* Every point finite, in range, and not zero unless solid. */
ylm_status ylm__sh_check_points(const ylm_sh_how *how, int lmax, ylm_dtype t, size_t n,
                               const void *p, ylm_error *e) {
  double shortest, longest;
  limits(how, lmax, t, &shortest, &longest);
  for (size_t i = 0; i < n; i++) {
    double x = number(t, p, 3 * i), y = number(t, p, 3 * i + 1), z = number(t, p, 3 * i + 2);
    double largest = fmax(fmax(fabs(x), fabs(y)), fabs(z));
    if (!isfinite(x) || !isfinite(y) || !isfinite(z))
      return ylm_fail(e, YLM_EDOMAIN, "point %zu is not finite", i + 1);
    if (largest == 0 && !how->solid)
      return ylm_fail(e, YLM_EDOMAIN, "point %zu is zero: it has no direction", i + 1);
    if (largest > longest)
      return ylm_fail(e, YLM_ERANGE, "point %zu is too long: |v|^%d overflows", i + 1, lmax);
    if (largest < shortest)
      return ylm_fail(e, YLM_ERANGE, "point %zu is too short: derivatives overflow", i + 1);
  }
  return YLM_OK;
}

void ylm__sh_coefficients(int l, int q, double k[5]) {
  double n = 2.0 * l + 1, rho = sqrt(n / (n - 2)), d = (double)(l - q) * (l + q);
  if (q == l) {
    k[0] = l == 1 ? -sqrt(3) : -sqrt(n / (n - 1));
    k[1] = k[2] = 0;
  } else {
    k[0] = sqrt(n * (n - 2) / d);
    k[1] = l == q + 1 ? 0 : sqrt(n * (l - 1 - q) * (l - 1 + q) / ((n - 4) * d));
    k[2] = rho * sqrt(d);
  }
  k[3] = -0.5 * rho * sqrt((double)(l + q - 1) * (l + q) * (q == 1 ? 2 : 1));
  k[4] = 0.5 * rho * sqrt((double)(l - q - 1) * (l - q) * (q == 0 ? 2 : 1));
}

/* The coefficients of all degrees 1 .. lmax; NULL if memory runs out. */
static void *make_table(int lmax, ylm_dtype t) {
  size_t n = ylm_sh_count(lmax) / 2 + (size_t)lmax + 1;
  void *table = ylm_alloc(5 * n, ylm_dtype_size(t));
  float *f = table;
  double *d = table, k[5];
  for (int l = 1; table && l <= lmax; l++) {
    for (int q = 0; q <= l; q++, f += 5, d += 5) {
      ylm__sh_coefficients(l, q, k);
      for (int i = 0; i < 5; i++) {
        if (t == YLM_DOUBLE) d[i] = k[i];
        else f[i] = (float)k[i];
      }
    }
  }
  return table;
}

/* What evaluates: a kernel, its scratch, and whether it needs the table. */
typedef struct choice {
  ylm__sh_kernel *kernel;
  size_t scratch;
  bool table;
} choice;

static choice choose_recurrence(ylm_isa isa, ylm_dtype t, int lmax) {
  switch (isa) {
#define X(name)                                                                           \
  case YLM_ISA_##name:                                                                    \
    if (t == YLM_DOUBLE)                                                                  \
      return (choice){ylm__sh_recurrence_double_##name, ylm__sh_scratch_double_##name(lmax), true}; \
    return (choice){ylm__sh_recurrence_float_##name, ylm__sh_scratch_float_##name(lmax), true};
    YLM__SH_SETS(X)
#undef X
  default:
    return (choice){t == YLM_DOUBLE ? ylm__sh_reference_double : ylm__sh_reference_float,
                    ((size_t)lmax + 2) * 5 * sizeof(double), false};
  }
}

typedef struct task {
  const ylm__sh_job *job;
  choice how;
  char *scratch;
} task;

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  const task *k = context;
  k->how.kernel(k->job, begin, end, k->scratch + (size_t)worker * k->how.scratch);
  return YLM_OK;
}

static ylm_status check_how(const ylm_sh_how *how, int lmax, ylm_error *e) {
  if (lmax < 0 || lmax > YLM_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax must be from 0 to %d, got %d", YLM_LMAX, lmax);
  if (how->derivatives < 0 || how->derivatives > 2)
    return ylm_fail(e, YLM_ERANGE, "derivatives must be 0, 1 or 2, got %d", how->derivatives);
  if (how->isa >= 0 && !ylm_isa_available((ylm_isa)how->isa))
    return ylm_fail(e, YLM_EINVAL, "kernels '%s' do not run here", ylm_isa_name((ylm_isa)how->isa));
  return YLM_OK;
}

ylm_status ylm_sh_eval_how(const ylm_sh_how *how, int lmax, ylm_dtype t, size_t n, const void *p,
                           void *y, void *dy, void *ddy, ylm_error *e) {
  ylm_status s = check_how(how, lmax, e);
  if (s == YLM_OK) s = ylm__sh_check_points(how, lmax, t, n, p, e);
  if (s != YLM_OK || n == 0) return s;
  ylm_isa isa = how->isa < 0 ? ylm_isa_current() : (ylm_isa)how->isa;
  ylm__sh_job job = {.lmax = lmax, .derivatives = how->derivatives, .solid = how->solid, .p = p, .y = y};
  if (how->derivatives > 0) job.dy = dy;
  if (how->derivatives > 1) job.ddy = ddy;
  task k = {&job, choose_recurrence(isa, t, lmax), NULL};
  int threads = n <= GRAIN ? 1 : ylm_threads(how->threads);
  void *table = k.how.table ? make_table(lmax, t) : NULL;
  job.table = table;
  k.how.scratch = (k.how.scratch + YLM_ALIGN - 1) / YLM_ALIGN * YLM_ALIGN;
  k.scratch = ylm_alloc((size_t)threads, k.how.scratch);
  if (k.scratch && (table || !k.how.table))
    s = ylm_parallel(n, GRAIN, threads, run, &k, how->progress, "spherical harmonics");
  else s = ylm_fail(e, YLM_ENOMEM, "no memory for degree %d", lmax);
  ylm_free(k.scratch);
  ylm_free(table);
  return s;
}

ylm_status ylm_sh_eval(int lmax, int derivatives, bool solid, ylm_dtype t, size_t n, const void *p,
                       void *y, void *dy, void *ddy, int threads, ylm_error *e) {
  ylm_sh_how how = {.derivatives = derivatives, .solid = solid, .isa = -1, .threads = threads};
  return ylm_sh_eval_how(&how, lmax, t, n, p, y, dy, ddy, e);
}
