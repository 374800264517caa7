/* query.c - whether a query about lights is sound. */
#include "light.h"

ylm_status ylm__query_check(const ylm_field_query *q, const ylm_field_result *r, int most,
                            ylm_error *e) {
  if (q->lmax < 0 || q->lmax > most)
    return ylm_fail(e, YLM_ERANGE, "lmax must be 0 .. %d for these lights, got %d", most, q->lmax);
  if (q->channels != 1 && q->channels != 3)
    return ylm_fail(e, YLM_EINVAL, "channels must be 1 or 3, got %d", q->channels);
  if ((q->want & YLM_WANT_METRIC) && q->metric_channels != 1 && q->metric_channels != 3)
    return ylm_fail(e, YLM_EINVAL, "metric_channels must be 1 or 3, got %d", q->metric_channels);
  if (((q->want & YLM_WANT_VALUE) && !r->value) ||
      ((q->want & YLM_WANT_GRADIENT) && !r->gradient) ||
      ((q->want & YLM_WANT_HESSIAN) && !r->hessian))
    return ylm_fail(e, YLM_EINVAL, "a result is wanted but has no place to go");
  return YLM_OK;
}

ylm_status ylm__field_check(const ylm_field_query *q, size_t n, const void *points,
                            const ylm_field_result *r, int most, ylm_error *e) {
  size_t where;
  ylm_status s = ylm__query_check(q, r, most, e);
  if (s != YLM_OK) return s;
  if (!ylm_all_finite(q->dtype, points, 3 * n, &where))
    return ylm_fail(e, YLM_EDOMAIN, "point %zu is not finite", where / 3 + 1);
  return YLM_OK;
}
