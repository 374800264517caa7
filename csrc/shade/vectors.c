/* vectors.c - transfer vectors with bounces, and transfer matrices, of a view's shading points. */
#include "view.h"

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
