/* importance.c - links backwards: what light on each element is worth. */
#include "../calibration.h"
#include "adjoint.h"

struct ylm_transpose {
  const ylm_transfer *t;
  size_t *row;    /* [elements + 1] where the sources of an element begin */
  uint32_t *from; /* the elements whose links lead to it, in order, each as often as they do */
};

ylm_status ylm_transpose_create(const ylm_transfer *t, ylm_transpose **out) {
  size_t n = t->elements, links = (size_t)t->form.links, all = n * links;
  ylm_transpose *x = ylm_alloc_zero(1, sizeof *x);
  *out = NULL;
  if (!x) return YLM_ENOMEM;
  x->t = t;
  x->row = ylm_alloc_zero(n + 2, sizeof *x->row);
  if (x->row) {
    for (size_t k = 0; k < all; k++)
      if (ylm_links_at(t->link, k) < n) x->row[ylm_links_at(t->link, k) + 2]++;
    for (size_t i = 2; i < n + 2; i++) x->row[i] += x->row[i - 1];
    x->from = ylm_alloc(x->row[n + 1], sizeof *x->from);
  }
  if (!x->from) {
    ylm_transpose_free(x);
    return YLM_ENOMEM;
  }
  for (size_t k = 0; k < all; k++)
    if (ylm_links_at(t->link, k) < n)
      x->from[x->row[ylm_links_at(t->link, k) + 1]++] = (uint32_t)(k / links);
  *out = x;
  return YLM_OK;
}

void ylm_transpose_free(ylm_transpose *x) {
  if (!x) return;
  ylm_free(x->row);
  ylm_free(x->from);
  ylm_free(x);
}

typedef struct job {
  const ylm_transpose *x;
  const double (*in)[3];
  double (*out)[3];
} job;

/* M^T in, on elements begin .. end-1. */
static ylm_status apply(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  const ylm_transpose *x = j->x;
  double each = 1.0 / x->t->form.links;
  for (size_t i = begin; i < end; i++) {
    double sum[3] = {0, 0, 0};
    for (size_t k = x->row[i]; k < x->row[i + 1]; k++)
      for (int c = 0; c < 3; c++) sum[c] += j->in[x->from[k]][c];
    for (int c = 0; c < 3; c++) j->out[i][c] = each * sum[c];
  }
  return YLM_OK;
}

static ylm_status backwards(const ylm_transpose *x, const double (*in)[3], int threads,
                            double (*out)[3]) {
  job j = {x, in, out};
  if (x->t->elements * (size_t)x->t->form.links < BOUNCE_FEW) threads = 1;
  return ylm_parallel(x->t->elements, BOUNCE_GRAIN, threads, apply, &j, NULL, NULL);
}

static ylm_status check(const ylm_transpose *x, const ylm_radiosity *lit, ylm_error *e) {
  if (lit->t == x->t) return YLM_OK;
  return ylm_fail(e, YLM_EINVAL, "the radiosity is of other links");
}

ylm_status ylm_transpose_importance(const ylm_transpose *x, const ylm_radiosity *lit,
                                    const double (*leaving)[3], const double (*falling)[3],
                                    int threads, double (*out)[3], ylm_error *e) {
  const ylm_transfer *t = x->t;
  size_t n = t->elements;
  ylm_status s = check(x, lit, e);
  double(*term)[3] = ylm_alloc(n, sizeof *term), (*next)[3] = ylm_alloc(n, sizeof *next);
  if (s == YLM_OK && !(term && next)) s = YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < n; i++)
    for (int c = 0; c < 3; c++)
      out[i][c] = term[i][c] =
          (double)t->albedo[i][c] * leaving[i][c] + (falling ? falling[i][c] : 0);
  for (int k = 0; s == YLM_OK && k < lit->stats.bounces; k++) {
    bool last = k + 1 == lit->stats.bounces && lit->stats.closed;
    s = backwards(x, (const double(*)[3])term, threads, next);
    for (size_t i = 0; s == YLM_OK && i < n; i++)
      for (int c = 0; c < 3; c++) {
        double q = last && lit->q[c] < 1 ? lit->q[c] / (1 - lit->q[c]) : 0;
        term[i][c] = (double)t->albedo[i][c] * next[i][c];
        out[i][c] += term[i][c] * (1 + q);
      }
  }
  ylm_free(term);
  ylm_free(next);
  return s;
}

ylm_status ylm_transpose_albedo(const ylm_transpose *x, const ylm_radiosity *lit,
                                const double (*leaving)[3], const double (*importance)[3],
                                int threads, double (*out)[3], ylm_error *e) {
  ylm_status s = check(x, lit, e);
  if (s == YLM_OK) s = backwards(x, importance, threads, out);
  for (size_t i = 0; s == YLM_OK && i < x->t->elements; i++)
    for (size_t c = 0; c < 3; c++)
      out[i][c] = (out[i][c] + leaving[i][c]) * (double)lit->E[4 * i + c];
  return s;
}
