/* local.c - points of queries relative to the origin of lights that are far from 0. */
#include "light.h"

ylm_status ylm__local_begin(const ylm_field_query *q, const double origin[3], size_t n,
                            const void *points, ylm__local *out) {
  double shift[3];
  bool same = true;
  for (int a = 0; a < 3; a++) {
    shift[a] = (q->origin ? q->origin[a] : 0) - origin[a];
    same = same && shift[a] == 0;
  }
  *out = (ylm__local){.q = *q, .points = points};
  out->q.origin = NULL;
  if (same || n == 0) return YLM_OK;
  out->points = out->room = ylm_alloc(n, 3 * ylm_dtype_size(q->dtype));
  if (!out->room) return YLM_ENOMEM;
  for (size_t i = 0; i < 3 * n; i++)
    ylm_put(q->dtype, out->room, i, ylm_get(q->dtype, points, i) + shift[i % 3]);
  return YLM_OK;
}

void ylm__local_end(ylm__local *local) { ylm_free(local->room); }
