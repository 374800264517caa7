/*
** sh_eval.h - what the files that evaluate the basis share. Private to csrc/sh.
**
** A kernel evaluates points begin .. end-1 of a job whose points have been
** checked: finite, and not zero unless solid.
*/
#ifndef YLM_SH_EVAL_H
#define YLM_SH_EVAL_H

#include "ylm_sets.h"
#include "ylm_sh_rival.h"

typedef struct ylm__sh_job ylm__sh_job;
typedef void ylm__sh_kernel(const ylm__sh_job *job, size_t begin, size_t end, void *scratch);

struct ylm__sh_job {
  int lmax, derivatives;
  bool solid;
  bool tame;                      /* the largest coordinates of all points can be squared safely */
  const void *p;                  /* [n][3] */
  void *y, *dy, *ddy;             /* each may be NULL: not wanted */
  const void *table;              /* coefficients of the recurrences, for kernels that want them */
  ylm__sh_kernel *inner;          /* of a kernel that converts and calls another */
  const ylm_sh_rival_eval *rival; /* a method of another library; NULL: ours */
};

/* True only if the largest coordinate of every point [n][3] is finite and from `least` to `most`,
   whose squares must be ordinary numbers; may be false for points close to the limits. */
typedef bool ylm__sh_check(const void *p, size_t n, double least, double most);

/* v = d * w with |w| = 1, without overflow or underflow; for v = 0, d = 0 and w = +z. */
void ylm__sh_unit(const double v[3], double w[3], double *d);

/* YLM_OK if every point is finite, not zero unless solid, and leads to representable results;
 *tame as in ylm__sh_job. */
ylm_status ylm__sh_check_points(const ylm_sh_how *how, int lmax, ylm_dtype t, size_t n,
                                const void *p, bool *tame, ylm_error *e);

/* The rival of a method; YLM_EMISSING while its library is not there. */
ylm_status ylm__sh_rival(ylm_sh_method m, const ylm_sh_rival_eval **out, ylm_error *e);

/* From a solid harmonic with derivatives at the unit vector w to the same at v = d w, or to Y. */
void ylm__sh_scale_solid(int l, double d, double s[10]);
void ylm__sh_surface(int l, double d, const double w[3], double s[10]);

/* The scalar kernel that judges the others, computing in double. Scratch: (lmax+2) * 5 doubles. */
ylm__sh_kernel ylm__sh_reference_float, ylm__sh_reference_double;

/* Vector kernels for any lmax (sh_kernel.h) and the scratch that each worker needs; for low
   degrees without scratch (low_kernel.h), NULL where there is none; a check of points. */
#define X(isa)                                                                                     \
  ylm__sh_kernel *ylm__sh_low_float_##isa(int lmax, int derivatives);                              \
  ylm__sh_kernel *ylm__sh_low_double_##isa(int lmax, int derivatives);                             \
  ylm__sh_check ylm__sh_all_between_float_##isa, ylm__sh_all_between_double_##isa;                 \
  ylm__sh_kernel ylm__sh_recurrence_float_##isa, ylm__sh_recurrence_double_##isa;                  \
  size_t ylm__sh_scratch_float_##isa(int lmax), ylm__sh_scratch_double_##isa(int lmax);
YLM_SETS(X)
#undef X

#endif
