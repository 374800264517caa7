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

typedef struct task {
  const ylm__sh_job *job;
  ylm__sh_kernel *kernel;
} task;

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  const task *k = context;
  k->kernel(k->job, begin, end, k->job->scratch + (size_t)worker * k->job->scratch_size);
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
  int threads = ylm_threads(how->threads);
  ylm__sh_job job = {.lmax = lmax, .derivatives = how->derivatives, .solid = how->solid, .p = p, .y = y};
  if (how->derivatives > 0) job.dy = dy;
  if (how->derivatives > 1) job.ddy = ddy;
  job.scratch_size = ((size_t)lmax + 2) * 5 * sizeof(double);
  job.scratch = ylm_alloc((size_t)threads, job.scratch_size);
  if (!job.scratch) return ylm_fail(e, YLM_ENOMEM, "no memory for degree %d", lmax);
  task k = {&job, t == YLM_DOUBLE ? ylm__sh_reference_double : ylm__sh_reference_float};
  s = ylm_parallel(n, GRAIN, threads, run, &k, how->progress, "spherical harmonics");
  ylm_free(job.scratch);
  return s;
}

ylm_status ylm_sh_eval(int lmax, int derivatives, bool solid, ylm_dtype t, size_t n, const void *p,
                       void *y, void *dy, void *ddy, int threads, ylm_error *e) {
  ylm_sh_how how = {.derivatives = derivatives, .solid = solid, .isa = -1, .threads = threads};
  return ylm_sh_eval_how(&how, lmax, t, n, p, y, dy, ddy, e);
}
