/* eval.c - ylm_sh_eval: arguments checked, a kernel chosen, points shared among threads. */
#include "../calibration.h"
#include "sh_eval.h"

#include <float.h>
#include <math.h>

const char *ylm_sh_method_name(ylm_sh_method m) {
  static const char *const names[] = {
#define X(name) #name,
      YLM_SH_METHOD_LIST(X)
#undef X
  };
  return (int)m >= 0 && m < YLM_SH_METHOD_COUNT ? names[m] : "?";
}

/* The least and largest that a point's largest coordinate may be for all results to be
   representable, with room for a factor of (lmax+1)^2. */
static void limits(const ylm_sh_how *how, int lmax, ylm_dtype t, double *least, double *most) {
  double exponent = (t == YLM_DOUBLE ? DBL_MAX_EXP : FLT_MAX_EXP) - 3 - 2 * log2(lmax + 1.0);
  *least = how->solid ? 0 : t == YLM_DOUBLE ? DBL_TRUE_MIN : FLT_TRUE_MIN;
  *most = t == YLM_DOUBLE ? DBL_MAX : FLT_MAX;
  if (how->solid && lmax > 0) *most = fmin(*most, exp2(exponent / lmax) / sqrt(3));
  if (!how->solid && how->derivatives > 0)
    *least = fmax(*least, exp2(-exponent / how->derivatives));
}

/* Whether all points lie between the limits, by the kernel of `isa`. */
static bool all_between(ylm_isa isa, ylm_dtype t, size_t n, const void *p, double least,
                        double most) {
  switch (isa) {
#define X(name)                                                                                    \
  case YLM_ISA_##name:                                                                             \
    return t == YLM_DOUBLE ? ylm__sh_all_between_double_##name(p, n, least, most)                  \
                           : ylm__sh_all_between_float_##name(p, n, least, most);
    YLM_SETS(X)
#undef X
  default: return false;
  }
}

/* The error of point i, if it has one. */
static ylm_status check_point(ylm_dtype t, const void *p, size_t i, int lmax, double least,
                              double most, ylm_error *e) {
  double x = ylm_get(t, p, 3 * i), y = ylm_get(t, p, 3 * i + 1), z = ylm_get(t, p, 3 * i + 2);
  double largest = fmax(fmax(fabs(x), fabs(y)), fabs(z));
  if (!isfinite(x) || !isfinite(y) || !isfinite(z))
    return ylm_fail(e, YLM_EDOMAIN, "point %zu is not finite", i + 1);
  if (largest == 0 && least > 0)
    return ylm_fail(e, YLM_EDOMAIN, "point %zu is zero: it has no direction", i + 1);
  if (largest > most)
    return ylm_fail(e, YLM_ERANGE, "point %zu is too long: |v|^%d overflows", i + 1, lmax);
  if (largest < least)
    return ylm_fail(e, YLM_ERANGE, "point %zu is too short: derivatives overflow", i + 1);
  return YLM_OK;
}

ylm_status ylm__sh_check_points(const ylm_sh_how *how, int lmax, ylm_dtype t, size_t n,
                                const void *p, bool *tame, ylm_error *e) {
  double least, most;
  ylm_isa isa = how->isa < 0 ? ylm_isa_current() : (ylm_isa)how->isa;
  limits(how, lmax, t, &least, &most);
  *tame = all_between(isa, t, n, p, fmax(least, t == YLM_DOUBLE ? 1e-140 : 1e-14),
                      fmin(most, t == YLM_DOUBLE ? 1e140 : 1e14));
  for (size_t i = 0; !*tame && i < n; i++) {
    ylm_status s = check_point(t, p, i, lmax, least, most, e);
    if (s != YLM_OK) return s;
  }
  return YLM_OK;
}

ylm_status ylm_sh_check_points(const ylm_sh_how *how, int lmax, ylm_dtype t, size_t n,
                               const void *p, ylm_error *e) {
  bool tame;
  return ylm__sh_check_points(how, lmax, t, n, p, &tame, e);
}

void ylm_sh_coefficients(int l, int q, double k[7]) {
  double n = 2.0 * l + 1, rho = sqrt(n / (n - 2)), d = (double)(l - q) * (l + q);
  if (q == l) {
    k[0] = l == 1 ? -sqrt(3) : -sqrt(n / (n - 1));
    k[1] = k[2] = k[5] = k[6] = 0;
  } else {
    k[0] = sqrt(n * (n - 2) / d);
    k[1] = l == q + 1 ? 0 : sqrt(n * (l - 1 - q) * (l - 1 + q) / ((n - 4) * d));
    k[2] = rho * sqrt(d);
    k[6] = rho * sqrt((double)(l + q) / (l - q));
    k[5] = k[0] - k[6];
  }
  k[3] = -0.5 * rho * sqrt((double)(l + q - 1) * (l + q) * (q == 1 ? 2 : 1));
  k[4] = 0.5 * rho * sqrt((double)(l - q - 1) * (l - q) * (q == 0 ? 2 : 1));
}

static const float table_float[] = {
#include "../gen/sh_table.h"
};
static const double table_double[] = {
#include "../gen/sh_table.h"
};

/* The coefficients of degrees 1 .. lmax for lmax > SH_TABLE_LMAX; NULL if memory runs out. */
static void *make_table(int lmax, ylm_dtype t) {
  size_t n = ylm_sh_count(lmax) / 2 + (size_t)lmax + 1;
  void *table = ylm_alloc(7 * n, ylm_dtype_size(t));
  float *f = table;
  double *d = table, k[7];
  for (int l = 1; table && l <= lmax; l++) {
    for (int q = 0; q <= l; q++, f += 7, d += 7) {
      ylm_sh_coefficients(l, q, k);
      for (int i = 0; i < 7; i++) {
        if (t == YLM_DOUBLE)
          d[i] = k[i];
        else
          f[i] = (float)k[i];
      }
    }
  }
  return table;
}

/* Points of a job of another library's method. */
static void rival(const ylm__sh_job *job, ylm_dtype t, size_t begin, size_t end, void *scratch) {
  ylm_sh_job asked = {.lmax = job->lmax,
                      .derivatives = job->derivatives,
                      .solid = job->solid,
                      .dtype = t,
                      .p = job->p,
                      .y = job->y,
                      .dy = job->dy,
                      .ddy = job->ddy};
  job->rival->points(&asked, begin, end, scratch);
}

static void rival_float(const ylm__sh_job *job, size_t begin, size_t end, void *scratch) {
  rival(job, YLM_FLOAT, begin, end, scratch);
}

static void rival_double(const ylm__sh_job *job, size_t begin, size_t end, void *scratch) {
  rival(job, YLM_DOUBLE, begin, end, scratch);
}

/* An evaluator: a kernel, its scratch, and whether it needs the table. */
typedef struct choice {
  ylm__sh_kernel *kernel;
  size_t scratch;
  bool table;
} choice;

static choice choose(ylm_isa isa, ylm_dtype t, const ylm__sh_job *job) {
  ylm__sh_kernel *low = NULL;
  int lmax = job->lmax, order = job->derivatives;
  if (job->rival)
    return (choice){t == YLM_DOUBLE ? rival_double : rival_float, job->rival->scratch(lmax), false};
  switch (isa) {
#define X(name)                                                                                    \
  case YLM_ISA_##name:                                                                             \
    if (!job->solid)                                                                               \
      low = t == YLM_DOUBLE ? ylm__sh_low_double_##name(lmax, order)                               \
                            : ylm__sh_low_float_##name(lmax, order);                               \
    if (low) return (choice){low, 0, false};                                                       \
    if (t == YLM_DOUBLE)                                                                           \
      return (choice){ylm__sh_recurrence_double_##name, ylm__sh_scratch_double_##name(lmax),       \
                      true};                                                                       \
    return (choice){ylm__sh_recurrence_float_##name, ylm__sh_scratch_float_##name(lmax), true};
    YLM_SETS(X)
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

/* Points evaluated at a time where float is computed in double. */
static size_t chunk(int lmax) { return lmax <= 256 ? 8 : 1; }

static size_t chunk_numbers(int lmax) { return chunk(lmax) * (3 + 10 * ylm_sh_count(lmax)); }

static void round_to_float(float *out, const double *x, size_t n) {
  for (size_t i = 0; out && i < n; i++) out[i] = (float)x[i];
}

/* A kernel for float whose job's `inner` is one for double; its scratch comes after the numbers. */
static void by_double(const ylm__sh_job *job, size_t begin, size_t end, void *scratch) {
  size_t most = chunk(job->lmax), count = ylm_sh_count(job->lmax);
  double *p = scratch, *y = p + 3 * most, *dy = y + most * count, *ddy = dy + 3 * most * count;
  void *rest = p + (chunk_numbers(job->lmax) + 7) / 8 * 8;
  ylm__sh_job in = *job;
  in.p = p, in.y = y, in.dy = job->dy ? dy : NULL, in.ddy = job->ddy ? ddy : NULL;
  in.tame = true; /* every float, squared, is an ordinary double */
  for (size_t i = begin; i < end; i += most) {
    size_t n = end - i < most ? end - i : most;
    for (size_t k = 0; k < 3 * n; k++) p[k] = (double)((const float *)job->p)[3 * i + k];
    job->inner(&in, 0, n, rest);
    if (job->y) round_to_float((float *)job->y + i * count, y, n * count);
    if (job->dy) round_to_float((float *)job->dy + 3 * i * count, dy, 3 * n * count);
    if (job->ddy) round_to_float((float *)job->ddy + 6 * i * count, ddy, 6 * n * count);
  }
}

/* The kernel for a job, and the type it computes in. */
static choice choose_type(ylm_isa isa, ylm_dtype *t, ylm__sh_job *job) {
  if (*t == YLM_DOUBLE || job->lmax <= SH_FLOAT_LMAX || job->rival) return choose(isa, *t, job);
  *t = YLM_DOUBLE;
  choice how = choose(isa, *t, job);
  job->inner = how.kernel;
  how.kernel = by_double;
  how.scratch += (chunk_numbers(job->lmax) + 8) * sizeof(double);
  return how;
}

/* Finds the method, *out: NULL for ours; and refuses what it cannot do. */
static ylm_status find_method(const ylm_sh_how *how, int lmax, const ylm_sh_rival_eval **out,
                              ylm_error *e) {
  const char *name = ylm_sh_method_name(how->method);
  *out = NULL;
  if ((int)how->method < 0 || how->method >= YLM_SH_METHOD_COUNT)
    return ylm_fail(e, YLM_EINVAL, "no such method");
  if (how->method == YLM_SH_solid) return YLM_OK;
  ylm_status s = ylm__sh_rival(how->method, out, e);
  if (s != YLM_OK) return s;
  if (lmax > (*out)->lmax)
    return ylm_fail(e, YLM_ERANGE, "method '%s' goes to lmax %d", name, (*out)->lmax);
  if (how->solid && !(*out)->solid)
    return ylm_fail(e, YLM_EINVAL, "method '%s' has no solid harmonics", name);
  if (how->derivatives > (*out)->derivatives)
    return ylm_fail(e, YLM_ERANGE, "method '%s' has no second derivatives", name);
  return YLM_OK;
}

static ylm_status check_how(const ylm_sh_how *how, int lmax, const ylm_sh_rival_eval **method,
                            ylm_error *e) {
  if (lmax < 0 || lmax > YLM_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax must be from 0 to %d, got %d", YLM_LMAX, lmax);
  if (how->derivatives < 0 || how->derivatives > 2)
    return ylm_fail(e, YLM_ERANGE, "derivatives must be 0, 1 or 2, got %d", how->derivatives);
  if (how->isa >= 0 && !ylm_isa_available((ylm_isa)how->isa))
    return ylm_fail(e, YLM_EINVAL, "kernels '%s' do not run here", ylm_isa_name((ylm_isa)how->isa));
  return find_method(how, lmax, method, e);
}

/* Runs a job with the scratch and the table (of type t) that its kernel wants. */
static ylm_status run_job(ylm__sh_job *job, choice how, ylm_dtype t, size_t n, int threads,
                          const ylm_progress *progress, ylm_error *e) {
  void *table = how.table && job->lmax > SH_TABLE_LMAX ? make_table(job->lmax, t) : NULL;
  job->table = table ? table : t == YLM_DOUBLE ? (const void *)table_double : table_float;
  threads = n <= SH_EVAL_GRAIN ? 1 : ylm_threads(threads);
  how.scratch = (how.scratch + YLM_ALIGN - 1) / YLM_ALIGN * YLM_ALIGN;
  task k = {job, how, how.scratch ? ylm_alloc((size_t)threads, how.scratch) : NULL};
  ylm_status s = YLM_ENOMEM;
  if ((k.scratch || !how.scratch) && (table || !how.table || job->lmax <= SH_TABLE_LMAX))
    s = ylm_parallel(n, SH_EVAL_GRAIN, threads, run, &k, progress, "spherical harmonics");
  ylm_free(k.scratch);
  ylm_free(table);
  return s == YLM_ENOMEM ? ylm_fail(e, s, "no memory for degree %d", job->lmax) : s;
}

ylm_status ylm_sh_eval_how(const ylm_sh_how *how, int lmax, ylm_dtype t, size_t n, const void *p,
                           void *y, void *dy, void *ddy, ylm_error *e) {
  ylm__sh_job job = {
      .lmax = lmax, .derivatives = how->derivatives, .solid = how->solid, .p = p, .y = y};
  ylm_status s = check_how(how, lmax, &job.rival, e);
  if (s == YLM_OK) s = ylm__sh_check_points(how, lmax, t, n, p, &job.tame, e);
  if (s != YLM_OK || n == 0) return s;
  ylm_isa isa = how->isa < 0 ? ylm_isa_current() : (ylm_isa)how->isa;
  if (how->derivatives > 0) job.dy = dy;
  if (how->derivatives > 1) job.ddy = ddy;
  choice kernel = choose_type(isa, &t, &job);
  return run_job(&job, kernel, t, n, how->threads, how->progress, e);
}

ylm_status ylm_sh_eval(int lmax, int derivatives, bool solid, ylm_dtype t, size_t n, const void *p,
                       void *y, void *dy, void *ddy, int threads, ylm_error *e) {
  ylm_sh_how how = {.derivatives = derivatives, .solid = solid, .isa = -1, .threads = threads};
  return ylm_sh_eval_how(&how, lmax, t, n, p, y, dy, ddy, e);
}
