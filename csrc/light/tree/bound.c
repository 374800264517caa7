/* bound.c - how far proxies are from what they stand for, and what that means for a query. */
#include "tree.h"

#include <math.h>

/*
** The mean over the sphere of |j-th derivatives of d^a Y_lm|^2 at d = 1, all 3^j of them. A
** gradient has the degrees l+1 and l-1 in the shares of vector spherical harmonics; n_0 = 1:
**
**   n_j(l,a) = (l+1)/(2l+1) (a-l)^2 n_(j-1)(l+1,a-1) + l/(2l+1) (a+l+1)^2 n_(j-1)(l-1,a-1)
**
** Times 1/4pi, summed over m, the square is the same in every direction.
*/
static double derivative_square(int j, int l, int a) {
  if (j == 0) return 1;
  double up = a - l, down = a + l + 1;
  double s = (l + 1.0) / (2 * l + 1) * up * up * derivative_square(j - 1, l + 1, a - 1);
  if (l > 0) s += l / (2.0 * l + 1) * down * down * derivative_square(j - 1, l - 1, a - 1);
  return s;
}

void ylm__tree_norms(int lmax, double G[YLM__NORMS]) {
  for (int j = 0; j < YLM__NORMS; j++) {
    double s = 0;
    for (int l = 0; l <= lmax; l++) s += (2 * l + 1) * derivative_square(j, l, -2);
    G[j] = sqrt(YLM_PI / 4 * s); /* a small light's coefficients are pi e r^2/d^2 Y_lm */
  }
}

/* Places of the sums of `few` kinds among those of `all`, in the kernels' order
   (moments/moments.h). */
static void find_places(int lmax, int all, int few, uint32_t *at) {
  uint32_t next = 0;
  int K = ylm__degree_of(lmax, all);
  for (int m = 0; m <= K; m++)
    for (int side = 0; side < (m ? 2 : 1); side++)
      for (int k = m; k <= K; k++)
        for (int kind = 0; kind < 3; kind++) {
          if (ylm__has(lmax, few, kind, k)) *at++ = next;
          next += ylm__has(lmax, all, kind, k);
        }
}

ylm_status ylm__tree_plan_create(ylm__tree_plan *p, const ylm_light_tree *t, double tolerance,
                                 const ylm__plan *sums, const ylm__plan *pilot) {
  const ylm_field_query *q = sums->q;
  bool metric = q->want & YLM_WANT_METRIC, rgb = q->channels == 3;
  int hessians = q->want & YLM_WANT_HESSIAN ? q->channels : 0;
  if (metric && q->metric_channels > hessians) hessians = q->metric_channels;
  *p = (ylm__tree_plan){.tree = t, .sums = sums, .pilot = pilot, .tolerance = tolerance};
  p->want[0] = metric || q->want & YLM_WANT_VALUE;
  p->want[1] = q->want & YLM_WANT_GRADIENT;
  p->want[2] = hessians;
  if (metric && q->metric_channels == 3) rgb = true;
  p->at[0] = p->at[1] = rgb ? YLM__STRENGTH_RGB : YLM__STRENGTH_LUM;
  p->at[2] = hessians == 3 ? YLM__STRENGTH_RGB : YLM__STRENGTH_LUM;
  double G[YLM__NORMS];
  ylm__tree_norms(q->lmax, G);
  for (int k = 0; k < 3; k++) {
    p->norm[k] = G[k];
    for (int j = 0; j < 3; j++) p->c[k][j] = (float)(G[2 + k + j] / G[k]);
  }
  p->share[0] = SHARE_VALUE;
  p->share[1] = SHARE_GRADIENT;
  p->share[2] = q->want & YLM_WANT_HESSIAN ? SHARE_HESSIAN : SHARE_METRIC;
  /* High degrees vary faster. */
  float high = fminf(1, sqrtf(5.0f / (float)(q->lmax + 1)));
  p->share[1] *= (double)high, p->share[2] *= (double)high;
  p->widest = WIDEST * high;
  p->pilot_widest = (p->want[1] || p->want[2] ? PILOT_WIDEST : PILOT_WIDEST_VALUE) * high;
  for (int j = 0; j < YLM__TAILS; j++) p->skip[j] = 2 * powf(0.5f, 0.5f * (float)j);
  p->dim = *sums;
  p->dim.kinds_lum &= ~YLM__M2, p->dim.kinds_rgb &= ~YLM__M2;
  p->dim.n_lum = ylm__sum_count(q->lmax, p->dim.kinds_lum);
  p->dim.n_rgb = ylm__sum_count(q->lmax, p->dim.kinds_rgb);
  p->dim_at = ylm_alloc((size_t)(p->dim.n_lum + p->dim.n_rgb), sizeof *p->dim_at);
  if (!p->dim_at) return YLM_ENOMEM;
  find_places(q->lmax, sums->kinds_lum, p->dim.kinds_lum, p->dim_at);
  find_places(q->lmax, sums->kinds_rgb, p->dim.kinds_rgb, p->dim_at + p->dim.n_lum);
  return YLM_OK;
}

void ylm__tree_plan_blocks(ylm__tree_plan *p, size_t n) {
  size_t most = YLM__BLOCK_MOST, sums = (size_t)(p->sums->n_lum + 3 * p->sums->n_rgb);
  while (most > n / (most > YLM__BLOCK_LEAST ? YLM__BLOCKS : YLM__BLOCKS / 2)) most /= 2;
  p->nodes = YLM__NODES_BYTES / (sums * ylm_dtype_size(p->sums->q->dtype));
  if (p->nodes > most / 2) p->nodes = most / 2;
  if (most < YLM__BLOCK_LEAST || p->nodes < YLM__BLOCK_LEAST / 16) p->nodes = 0;
  p->block = p->nodes ? most : 2 * YLM__PACKET;
  if (p->nodes) ylm__far_create(p->sums->q->lmax, p->want, &p->far);
}

void ylm__tree_plan_free(ylm__tree_plan *p) { ylm_free(p->dim_at); }

/* The number of uniform lights of which the exact sum takes about as long as the tree, wherever the
   points are. At lmax 4 these are 750 lights at a tolerance of 0.1, 2100 at 0.01 and 5700 at 0.001.
   Other lmax scale by the lights and proxies that are summed. */
bool ylm__tree_pays(const ylm_light_tree *t, int lmax, double tolerance) {
  double least = (YLM__FEW + 15.0 * lmax * lmax) * pow(0.1 / tolerance, 0.44);
  return t && (double)t->lights->active >= least;
}
