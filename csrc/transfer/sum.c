/* sum.c - means of rows over links: the plain form, which judges the others, and their choice. */
#include "calibration.h"
#include "transfer.h"
#include "ylm_sets.h"

static void plain(size_t n, int links, ylm_links link, int width, const float *in,
                  const float *start, float *out) {
  size_t row = (size_t)width;
  for (size_t i = 0; i < n; i++)
    for (size_t k = 0; k < row; k++) {
      double s = 0;
      for (int j = 0; j < links; j++)
        s += (double)in[ylm_links_at(link, i * (size_t)links + (size_t)j) * row + k];
      out[i * row + k] = (float)(s / links) + (start ? start[i * row + k] : 0);
    }
}

YLM_KERNEL_CHOICE(ylm_transfer_sum_fn, ylm__transfer_sum, ylm_k_transfer_sum, plain);

typedef struct job {
  ylm_transfer_sum_fn *sum;
  int links, width;
  ylm_links link;
  const float *in, *start;
  float *out;
} job;

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  size_t row = begin * (size_t)j->width;
  j->sum(end - begin, j->links, ylm_links_from(j->link, begin * (size_t)j->links), j->width, j->in,
         j->start ? j->start + row : NULL, j->out + row);
  return YLM_OK;
}

void ylm_transfer_sum(size_t n, int links, ylm_links link, int width, const float *in,
                      const float *start, float *out, int threads) {
  job j = {ylm__transfer_sum(), links, width, link, in, start, out};
  ylm_parallel(n, BOUNCE_GRAIN, threads, run, &j, NULL, NULL);
}
