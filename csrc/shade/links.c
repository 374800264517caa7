/* links.c - what shading points see of the elements of a scene, and the light that these send. */
#include <math.h>

#include "view.h"

/* Points that are gathered at once: their sums stay in the first-level cache. */
#define BLOCK 256

struct ylm_shade_links {
  const ylm_shade_view *view;
  const ylm_transfer *transfer;
  int links;
  uint32_t *link; /* [points][links] */
  double seconds;
};

/* Random numbers of successive streams lie on a lattice, which the points of a pixel would share. */
static uint64_t mix(uint64_t x) {
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
  x = (x ^ x >> 27) * 0x94d049bb133111ebu;
  return x ^ x >> 31;
}

ylm_status ylm_shade_links_create(const ylm_shade_view *v, const ylm_transfer *t, int links,
                                  uint64_t seed, int threads, const ylm_progress *progress,
                                  ylm_shade_links **out, ylm_error *e) {
  *out = NULL;
  if (links < 4 || links > YLM_TRANSFER_LINKS || links % 4)
    return ylm_fail(e, YLM_ERANGE, "links must be a multiple of 4 from 4 to %d, got %d",
                    YLM_TRANSFER_LINKS, links);
  double start = ylm_seconds();
  ylm_shade_links *l = ylm_alloc_zero(1, sizeof *l);
  uint64_t *stream = l ? ylm__shade_streams(v) : NULL;
  for (size_t i = 0; stream && i < v->points; i++) stream[i] = mix(stream[i]);
  if (l) *l = (ylm_shade_links){.view = v, .transfer = t, .links = links};
  if (l) l->link = ylm_alloc(v->points, (size_t)links * sizeof *l->link);
  ylm_status s = stream && l->link ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK)
    s = ylm_transfer_find(t, v->points, (const float(*)[3])v->origin, (const float(*)[3])v->normal,
                          stream, links, seed, threads, progress, l->link, 0, NULL, e);
  ylm_free(stream);
  if (s != YLM_OK) {
    ylm_shade_links_free(l);
    return s;
  }
  l->seconds = ylm_seconds() - start;
  *out = l;
  return YLM_OK;
}

void ylm_shade_links_free(ylm_shade_links *l) {
  if (!l) return;
  ylm_free(l->link);
  ylm_free(l);
}

void ylm_shade_links_look(const ylm_shade_links *l, ylm_shade_links_stats *stats) {
  size_t n = l->view->points * (size_t)l->links;
  *stats = (ylm_shade_links_stats){l->links, n, sizeof *l + n * sizeof *l->link, l->seconds};
}

const ylm_transfer *ylm_shade_links_transfer(const ylm_shade_links *l) { return l->transfer; }

/* -- noise ------------------------------------------------------------------------ */

#define LOOKED_AT 4096 /* points */

double ylm_shade_gather_noise(const ylm_shade_links *l, const float *leaving) {
  size_t points = l->view->points, n = points < LOOKED_AT ? points : LOOKED_AT;
  double square = 0, mean = 0;
  for (size_t k = 0; k < n; k++) {
    const uint32_t *link = l->link + k * points / n * (size_t)l->links;
    double sum[2] = {0};
    for (int i = 0; i < l->links; i++) {
      const float *r = leaving + 4 * (size_t)link[i];
      sum[i & 1] += YLM_LUMINANCE_R * (double)r[0] + YLM_LUMINANCE_G * (double)r[1] +
                    YLM_LUMINANCE_B * (double)r[2];
    }
    double apart =
        (sum[0] - sum[1]) / l->links; /* half of the difference of means over half of them */
    square += apart * apart;
    mean += (sum[0] + sum[1]) / l->links;
  }
  return mean > 0 ? sqrt(square * (double)n) / mean : 0;
}

/* -- gathering ------------------------------------------------------------------- */

typedef struct gather_job {
  const ylm_shade_links *l;
  const float *leaving, *start;
  float *out;
} gather_job;

/* Reflected at n points: the mean radiance that arrives along their links, [n][4], and `start`. */
static void reflect(const ylm_shade_view *v, size_t first, size_t n, const float *mean,
                    const float *start, float *out) {
  float radiance[3 * BLOCK];
  for (size_t i = 0; i < n; i++)
    for (size_t c = 0; c < 3; c++) radiance[3 * i + c] = (float)M_PI * mean[4 * i + c];
  ylm__shade_reflect(v, first, n, radiance);
  for (size_t k = 0; k < 3 * n; k++) out[k] = (start ? start[k] : 0) + radiance[k];
}

static ylm_status run_gather(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const gather_job *j = context;
  const ylm_shade_links *l = j->l;
  size_t n = end - begin;
  float mean[4 * BLOCK] __attribute__((aligned(64)));
  ylm_transfer_sum(n, l->links, l->link + begin * (size_t)l->links, 4, j->leaving, NULL, mean, 1);
  reflect(l->view, begin, n, mean, j->start ? j->start + 3 * begin : NULL, j->out + 3 * begin);
  return YLM_OK;
}

ylm_status ylm_shade_gather(const ylm_shade_links *l, const float *leaving, const float *start,
                            int threads, const ylm_progress *progress, float *out) {
  gather_job j = {l, leaving, start, out};
  return ylm_parallel(l->view->points, BLOCK, threads, run_gather, &j, progress, "gathering");
}
