/* vectors.c - transfer vectors with bounces, and transfer matrices, of a view's shading points; shading by vectors that are
   given. */
#include <stdatomic.h>

#include "../calibration.h"
#include "../view.h"
#include "ylm_sh.h"
#include "ylm_shade_bounce.h"

ylm_status ylm_shade_view_vectors(const ylm_shade_view *v, const ylm_transfer *t,
                                  const float *vectors, int links, uint64_t seed, int threads,
                                  const ylm_progress *progress, float *out, ylm_error *e) {
  uint64_t *stream = ylm__shade_streams(v);
  if (!stream) return YLM_ENOMEM;
  ylm_status s = ylm_transfer_vectors_at(t, vectors, v->points, (const float(*)[3])v->origin,
                                         (const float(*)[3])v->normal, stream, links, seed, threads,
                                         progress, out, e);
  ylm_free(stream);
  return s;
}

ylm_status ylm_shade_view_matrices(const ylm_shade_view *v, const ylm_transfer *t,
                                   const float *vectors, int rays, uint64_t seed, int lmax_in,
                                   int lmax_out, int threads, const ylm_progress *progress,
                                   float *out, ylm_error *e) {
  uint64_t *stream = ylm__shade_streams(v);
  if (!stream) return YLM_ENOMEM;
  ylm_status s = ylm_transfer_matrices(t, vectors, v->points, (const float(*)[3])v->origin,
                                       (const float(*)[3])v->normal, stream, rays, seed, lmax_in,
                                       lmax_out, threads, progress, out, e);
  ylm_free(stream);
  return s;
}

/* -- shading --------------------------------------------------------------------- */

typedef struct job {
  const ylm_shade_view *view;
  const float *T;
  int lmax, channels;
  const ylm_field *field;
  float *out;
  ylm_error *error;
  atomic_flag failed;
  atomic_uint_fast64_t pairs;
} job;

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  job *j = context;
  size_t n = end - begin, count = ylm_sh_count(j->lmax), row = (size_t)j->channels * count;
  float *L = ylm_alloc(n, 3 * count * sizeof *L), *E = j->out + 3 * begin;
  ylm_error e = {0};
  ylm_status s = L ? YLM_OK : YLM_ENOMEM;
  ylm_field_query q = {.lmax = j->lmax,
                       .channels = 3,
                       .want = YLM_WANT_VALUE,
                       .metric_channels = 1,
                       .dtype = YLM_FLOAT,
                       .threads = 1,
                       .origin = j->view->world};
  ylm_field_result r = {.value = L};
  if (s == YLM_OK) s = ylm_field_evaluate(j->field, &q, n, j->view->position[begin], &r, &e);
  if (s != YLM_OK && j->error && !atomic_flag_test_and_set(&j->failed)) *j->error = e;
  for (size_t i = 0; s == YLM_OK && i < n; i++)
    for (size_t c = 0; c < 3; c++) {
      const float *T = j->T + (begin + i) * row + (j->channels == 3 ? c * count : 0);
      double sum = 0;
      for (size_t k = 0; k < count; k++) sum += (double)T[k] * (double)L[(3 * i + c) * count + k];
      E[3 * i + c] = (float)sum;
    }
  if (s == YLM_OK) ylm__shade_reflect(j->view, begin, n, E);
  atomic_fetch_add_explicit(&j->pairs, r.pairs, memory_order_relaxed);
  ylm_free(L);
  return s;
}

ylm_status ylm_shade_by_vectors(const ylm_shade_view *v, int lmax, int channels, const float *T,
                                const ylm_field *field, int threads, const ylm_progress *progress,
                                float *out, uint64_t *pairs, ylm_error *e) {
  job j = {.view = v,
           .T = T,
           .lmax = lmax,
           .channels = channels,
           .field = field,
           .out = out,
           .error = e,
           .failed = ATOMIC_FLAG_INIT};
  ylm_status s =
      ylm_parallel(v->points, SHADE_VECTOR_POINTS, threads, run, &j, progress, "shading");
  if (pairs) *pairs = j.pairs;
  return s;
}
