/* light.c - radiance of shading points: transfer vector times light. */
#include <stdatomic.h>

#include "../calibration.h"
#include "../gloss/gloss.h"
#include "ylm_sh.h"

/* Products in double, where light came in double. */
static void dot_double(size_t count, size_t n, int channels, size_t t_row, const float *T,
                       size_t l_row, const double *L, float *out) {
  for (size_t i = 0; i < n; i++, T += t_row)
    for (int c = 0; c < 3; c++) {
      double s = 0;
      if (c >= channels) {
        out[3 * i + (size_t)c] = out[3 * i];
        continue;
      }
      for (size_t k = 0; k < count; k++) s += (double)T[k] * L[k];
      L += l_row;
      out[3 * i + (size_t)c] = (float)s;
    }
}

void ylm__shade_reflect(const ylm_shade_view *v, size_t first, size_t n, float *out) {
  for (size_t i = 0, behind; i < n; i = behind) {
    for (behind = i + 1; behind < n && v->mesh[first + behind] == v->mesh[first + i];) behind++;
    ylm_material_radiance(ylm__shade_material(v, first + i), behind - i, out + 3 * i);
  }
  ylm__shade_tint(v, first, n, out);
}

bool ylm__shade_shadows(const ylm_shade_view *v, ylm_shade_weight weight) {
  return weight == YLM_SHADE_TRANSFER && v->transfer && v->o.visibility != YLM_SHADE_UNSHADOWED;
}

ylm_status ylm__shade_rows(const ylm_shade_view *v, ylm_shade_weight weight, int lmax, int threads,
                           const ylm_progress *progress, shade_rows *rows, ylm_error *e) {
  *rows = (shade_rows){.weight = weight, .lmax = weight == YLM_SHADE_TRANSFER ? v->o.lmax : lmax};
  if (weight == YLM_SHADE_TRANSFER && !v->transfer && v->points > 0)
    return ylm_fail(e, YLM_EINVAL, "the view has no transfer vectors: it was made by rays");
  ylm_status s = ylm__shade_gloss_tables(v, rows->lmax, threads, progress, &rows->tables, e);
  if (s == YLM_OK && rows->tables && v->o.keep)
    s = ylm__shade_gloss_kept(v, rows->tables, ylm__shade_shadows(v, weight), ylm__shade_keep,
                              threads, progress, &rows->kept);
  if (s != YLM_OK || weight == YLM_SHADE_TRANSFER) return s;
  rows->zonal = ylm__shade_zonal(lmax);
  return rows->zonal ? YLM_OK : YLM_ENOMEM;
}

void ylm__shade_dots(ylm_shade_dot_fn *dot, size_t count, size_t n, size_t t_row, const float *T,
                     const shade_light *x, float *out) {
  size_t given = ylm_sh_count(x->lmax);
  if (x->type == YLM_DOUBLE)
    dot_double(count, n, x->channels, t_row, T, given, x->L, out);
  else
    dot(count, n, x->channels, NULL, t_row, T, given, (size_t)x->channels * given, x->L, out);
}

/* Radiance of n points, as matte ones, from coefficients and rows T of degree lmax. */
static void multiply(const ylm_shade_view *v, ylm_shade_dot_fn *dot, int lmax, const float *T,
                     size_t first, size_t n, const shade_light *x, float *out) {
  size_t row = ylm_sh_count(lmax), given = ylm_sh_count(x->lmax);
  ylm__shade_dots(dot, row < given ? row : given, n, row, T, x, out);
  ylm__shade_reflect(v, first, n, out);
}

/* Radiance of n points from `first` on, as if all were matte. */
static ylm_status shade_matte(const ylm_shade_view *v, ylm_shade_dot_fn *dot,
                              const shade_rows *rows, size_t first, size_t n, const shade_light *x,
                              float *out) {
  if (rows->weight == YLM_SHADE_TRANSFER) {
    multiply(v, dot, v->o.lmax, v->transfer + first * ylm_sh_count(v->o.lmax), first, n, x, out);
    return YLM_OK;
  }
  float *T = ylm_alloc(n, ylm_sh_count(rows->lmax) * sizeof *T);
  ylm_status s = T ? ylm__shade_cosines(v, rows->lmax, rows->zonal, n, v->mesh + first,
                                        (const float(*)[3])v->normal + first, T)
                   : YLM_ENOMEM;
  if (s == YLM_OK) multiply(v, dot, rows->lmax, T, first, n, x, out);
  ylm_free(T);
  return s;
}

/* Whether n points from `first` on all gloss. */
static bool all_gloss(const ylm_shade_view *v, size_t first, size_t n) {
  for (size_t i = first; i < first + n; i++)
    if ((i == first || v->mesh[i] != v->mesh[i - 1]) &&
        ylm__shade_gloss_slot(v->gloss, v->mesh[i]) == YLM_SHADE_MATTE)
      return false;
  return true;
}

ylm_status ylm__shade_points(const ylm_shade_view *v, ylm_shade_dot_fn *dot, const shade_rows *rows,
                             size_t first, size_t n, const shade_light *x, float *out) {
  ylm_status s =
      rows->tables && all_gloss(v, first, n) ? YLM_OK : shade_matte(v, dot, rows, first, n, x, out);
  if (s != YLM_OK || !rows->tables) return s;
  return ylm__shade_glossy(v, dot, rows, ylm__shade_shadows(v, rows->weight), first, n, x, out);
}

void ylm__shade_some(const ylm_shade_view *v, ylm_shade_dot_fn *dot, size_t n,
                     const uint32_t *point, const shade_light *x, size_t l_point, float *out) {
  size_t row = ylm_sh_count(v->o.lmax), given = ylm_sh_count(x->lmax);
  dot(row < given ? row : given, n, x->channels, point, row, v->transfer, given, l_point, x->L,
      out);
  for (size_t i = 0; i < n; i++) {
    ylm_material_radiance(ylm__shade_material(v, point[i]), 1, out + 3 * point[i]);
    ylm__shade_tint(v, point[i], 1, out + 3 * point[i]);
  }
}

/* -- any field ------------------------------------------------------------------ */

typedef struct field_job {
  const ylm_shade_view *view;
  const ylm_field *field;
  shade_rows rows;
  ylm_dtype type;
  ylm_shade_dot_fn *dot;
  float *out;
  atomic_uint_fast64_t pairs;
  ylm_error *error; /* written by the first that fails */
  atomic_flag failed;
} field_job;

/* Positions in double, where light is asked for in double. */
static void widen(const float *p, size_t n, double *out) {
  for (size_t i = 0; i < 3 * n; i++) out[i] = (double)p[i];
}

static ylm_status run_field(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  field_job *j = context;
  const ylm_shade_view *v = j->view;
  size_t n = end - begin, count = ylm_sh_count(v->o.lmax);
  void *L = ylm_alloc(n * 3 * count, ylm_dtype_size(j->type));
  double *wide = j->type == YLM_DOUBLE ? ylm_alloc(n, 24) : NULL;
  ylm_error e = {0};
  ylm_status s = L && (j->type == YLM_FLOAT || wide) ? YLM_OK : YLM_ENOMEM;
  const float *at = /* light that jumps at surfaces is asked for off them */
      ylm_quantity_jumps(j->field->quantity) ? v->origin[begin] : v->position[begin];
  if (wide) widen(at, n, wide);
  ylm_field_query q = {.lmax = v->o.lmax,
                       .channels = 3,
                       .want = YLM_WANT_VALUE,
                       .metric_channels = 1,
                       .dtype = j->type,
                       .threads = 1,
                       .origin = v->world};
  ylm_field_result r = {.value = L};
  double start = ylm_seconds();
  if (s == YLM_OK) s = ylm_field_evaluate(j->field, &q, n, wide ? (const void *)wide : at, &r, &e);
  ylm__shade_clock(v, SHADE_LIGHT, start);
  if (s == YLM_OK)
    s = ylm__shade_points(v, j->dot, &j->rows, begin, n, &(shade_light){3, v->o.lmax, j->type, L},
                          j->out + 3 * begin);
  else if (j->error && !atomic_flag_test_and_set(&j->failed))
    *j->error = e;
  atomic_fetch_add_explicit(&j->pairs, r.pairs, memory_order_relaxed);
  ylm_free(L);
  ylm_free(wide);
  return s;
}

ylm_status ylm_shade_field(const ylm_shade_view *v, const ylm_field *field, ylm_shade_weight weight,
                           ylm_dtype t, int threads, const ylm_progress *progress, float *out,
                           uint64_t *pairs, ylm_error *e) {
  field_job j = {.view = v,
                 .field = field,
                 .type = t,
                 .dot = ylm__shade_kernels().dot,
                 .out = out,
                 .error = e,
                 .failed = ATOMIC_FLAG_INIT};
  ylm_status s = ylm__shade_rows(v, weight, v->o.lmax, threads, progress, &j.rows, e);
  if (s == YLM_OK)
    s = ylm_parallel(v->points, SHADE_LIGHT_POINTS, threads, run_field, &j, progress, "shading");
  if (pairs) *pairs = j.pairs;
  ylm_free(j.rows.zonal);
  return s;
}

/* -- coefficients of the caller ------------------------------------------------- */

typedef struct given_job {
  const ylm_shade_view *view;
  ylm_shade_dot_fn *dot;
  shade_rows rows;
  size_t first;
  shade_light light;
  float *out;
} given_job;

static ylm_status run_given(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const given_job *j = context;
  shade_light x = j->light;
  size_t row = (size_t)x.channels * ylm_sh_count(x.lmax) * ylm_dtype_size(x.type);
  x.L = (const char *)x.L + begin * row;
  return ylm__shade_points(j->view, j->dot, &j->rows, j->first + begin, end - begin, &x,
                           j->out + 3 * begin);
}

ylm_status ylm_shade_coefficients(const ylm_shade_view *v, size_t first, size_t n, int channels,
                                  int lmax, ylm_dtype t, const void *L, int threads, float *out) {
  if (first > v->points || n > v->points - first) return YLM_ERANGE;
  if (channels != 1 && channels != 3) return YLM_ESHAPE;
  given_job j = {v, ylm__shade_kernels().dot, {.lmax = lmax}, first, {channels, lmax, t, L}, out};
  ylm_status s = ylm__shade_rows(v, YLM_SHADE_TRANSFER, lmax, threads, NULL, &j.rows, NULL);
  if (s != YLM_OK) return s;
  return ylm_parallel(n, SHADE_GRAIN, threads, run_given, &j, NULL, NULL);
}
