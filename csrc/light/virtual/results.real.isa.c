/* results.real.isa.c - from sums to results. */
#include "kernel.h"

YLM_INLINE vreal row_times(const ylm__rows *A, size_t i, const vreal *x) {
  vreal s = vreal_set(0);
  for (uint32_t t = A->start[i]; t < A->start[i + 1]; t++) s += A->COEF[t] * x[A->index[t]];
  return s;
}

/* Where sums of a kind for a channel of `channels` lie: x are those of its first channel. */
static const ylm__virtual_sums *sums_of(const ylm__virtual_plan *p, const work *k, int kind,
                                        int channels, int c, const vreal **x, int *own) {
  bool mixed = channels == 1 && !(p->of[1].kinds & kind);
  *x = mixed ? k->mixed : k->sum;
  *own = channels == 3 ? c : 0;
  return &p->of[channels == 3 || mixed ? 0 : 1];
}

/* Luminance of sums of three channels, where the first channel's are. */
void VIRTUAL(mix)(const ylm__virtual_plan *p, work *k) {
  const ylm__virtual_sums *of = &p->of[0];
  if (p->straight || !(p->need & of->kinds)) return;
  for (int block = 0; block < 3; block++)
    for (int part = 0; part < PARTS; part++) {
      static const int needs[3][PARTS] = {{1, 2, 2, 2, 4, 4, 4, 4, 4, 4},
                                          {2, 4, 4, 4},
                                          {12}}; /* a kind of sums that has the part */
      if (!(of->kinds & needs[block][part])) continue;
      const size_t n = p->rows[block], at = of->at[block][part];
      const vreal *x = k->sum + at;
      for (size_t i = 0; i < n; i++)
        k->mixed[at + i] = (real)YLM_LUMINANCE_R * x[i] + (real)YLM_LUMINANCE_G * x[n + i] +
                           (real)YLM_LUMINANCE_B * x[2 * n + i];
    }
}

static void straight_value(const ylm__virtual_plan *p, const work *k, int channels, int c,
                           vreal *out) {
  const size_t wide = p->slopes ? 12 : 3;
  for (size_t i = 0; i < p->rows[0]; i++) {
    const vreal *x = k->sum + wide * i;
    out[i] = (real)p->scale[i] *
             (channels == 3 ? x[c]
                            : (real)YLM_LUMINANCE_R * x[0] + (real)YLM_LUMINANCE_G * x[1] +
                                  (real)YLM_LUMINANCE_B * x[2]);
  }
}

void VIRTUAL(value_of)(const ylm__virtual_plan *p, const work *k, int channels, int c, vreal *out) {
  const vreal *x;
  int own;
  if (p->straight) {
    straight_value(p, k, channels, c, out);
    return;
  }
  const ylm__virtual_sums *s = sums_of(p, k, 1, channels, c, &x, &own);
  x += s->at[0][0] + (size_t)own * p->rows[0];
  for (size_t i = 0; i < p->rows[0]; i++) out[i] = p->value.COEF[i] * x[i];
}

/* By x: minus those by v. */
void VIRTUAL(gradient_of)(const ylm__virtual_plan *p, const work *k, int channels, int c,
                          vreal *out) {
  const vreal *x;
  int own;
  for (size_t i = 0; p->straight && i < p->rows[0]; i++)
    for (size_t a = 0; a < 3; a++)
      out[3 * i + a] =
          (real)(a < 2 ? -0.5 : -1) * (real)p->scale[i] * k->sum[12 * i + 3 + 3 * a + (size_t)c];
  if (p->straight) return;
  const ylm__virtual_sums *s = sums_of(p, k, 2, channels, c, &x, &own);
  const size_t n0 = p->rows[0], n1 = p->rows[1], at = (size_t)own;
  for (size_t i = 0; i < n0; i++)
    for (size_t a = 0; a < 3; a++)
      out[3 * i + a] = -row_times(&p->once, 3 * i + a, x + s->at[1][0] + at * n1) -
                       p->value.COEF[i] * x[s->at[0][1 + a] + at * n0 + i];
}

YLM_INLINE void bend(const ylm__virtual_plan *p, const ylm__virtual_sums *s, const vreal *x,
                     size_t own, size_t i, vreal out[6]) {
  static const size_t row[6] = {0, 0, 0, 1, 1, 2}, column[6] = {0, 1, 2, 1, 2, 2};
  const size_t n0 = p->rows[0], n1 = p->rows[1], n2 = p->rows[2];
  for (size_t q = 0; q < 6; q++)
    out[q] = row_times(&p->twice, 6 * i + q, x + s->at[2][0] + own * n2) +
             row_times(&p->once, 3 * i + row[q], x + s->at[1][1 + column[q]] + own * n1) +
             row_times(&p->once, 3 * i + column[q], x + s->at[1][1 + row[q]] + own * n1) +
             p->value.COEF[i] * x[s->at[0][4 + q] + own * n0 + i];
}

void VIRTUAL(hessian_of)(const ylm__virtual_plan *p, const work *k, int channels, int c,
                         vreal *out) {
  const vreal *x;
  int own;
  const ylm__virtual_sums *s = sums_of(p, k, 4, channels, c, &x, &own);
  for (size_t i = 0; i < p->rows[0]; i++) bend(p, s, x, (size_t)own, i, out + 6 * i);
}

/* Writes rows of LANES numbers to points from `point` on, which have `stride` numbers each. */
static void put(const ylm__virtual_plan *p, const vreal *rows, size_t n, size_t point, int lanes,
                void *out, size_t first, size_t stride) {
  const real *from = (const real *)rows;
  for (int lane = 0; lane < lanes; lane++) {
    size_t at = (point + (size_t)lane) * stride + first;
    if (p->q->dtype == YLM_FLOAT)
      for (size_t i = 0; i < n; i++) ((float *)out)[at + i] = (float)from[i * LANES + (size_t)lane];
    else
      for (size_t i = 0; i < n; i++)
        ((double *)out)[at + i] = (double)from[i * LANES + (size_t)lane];
  }
}

void VIRTUAL(results)(const ylm__virtual_plan *p, work *k, size_t point, int lanes,
                      ylm_field_result *r) {
  const ylm_field_query *q = p->q;
  size_t n = p->rows[0], C = (size_t)q->channels;
  for (int c = 0; c < q->channels; c++) {
    if (q->want & YLM_WANT_VALUE) {
      VIRTUAL(value_of)(p, k, q->channels, c, k->out);
      put(p, k->out, n, point, lanes, r->value, (size_t)c * n, C * n);
    }
    if (q->want & YLM_WANT_GRADIENT) {
      VIRTUAL(gradient_of)(p, k, q->channels, c, k->out);
      put(p, k->out, 3 * n, point, lanes, r->gradient, (size_t)c * 3 * n, C * 3 * n);
    }
    if (q->want & YLM_WANT_HESSIAN) {
      VIRTUAL(hessian_of)(p, k, q->channels, c, k->out);
      put(p, k->out, 6 * n, point, lanes, r->hessian, (size_t)c * 6 * n, C * 6 * n);
    }
  }
}

void VIRTUAL(metric)(const ylm__virtual_plan *p, work *k, size_t point, int lanes,
                     ylm_field_result *r) {
  const bool rough = p->q->want & YLM_WANT_ROUGH;
  int channels = p->q->metric_channels;
  vreal lambda = vreal_set(0), norm = lambda, h[6];
  for (int c = 0; c < channels; c++) {
    const vreal *x;
    int own;
    const ylm__virtual_sums *s = sums_of(p, k, rough ? 8 : 4, channels, c, &x, &own);
    const vreal *alike =
        p->straight ? k->sum + p->bend_sums : x + s->at[2][0] + (size_t)own * p->rows[2];
    for (size_t i = 0; i < p->rows[0]; i++) {
      if (rough)
        for (size_t j = 0; j < 6; j++) h[j] = row_times(&p->twice, 6 * i + j, alike);
      else
        bend(p, s, x, (size_t)own, i, h);
      vreal e = largest_eigenvalue(h);
      lambda += e * e;
    }
    VIRTUAL(value_of)(p, k, channels, c, k->out);
    for (size_t i = 0; i < p->rows[0]; i++) norm += k->out[i] * k->out[i];
  }
  lambda = vreal_sqrt(lambda);
  norm = vreal_sqrt(norm);
  if (r->lambda) put(p, &lambda, 1, point, lanes, r->lambda, 0, 1);
  if (r->norm) put(p, &norm, 1, point, lanes, r->norm, 0, 1);
}
