/* denoise_plain.c - the plain form of the sums over points around one, which judges the others, and the choice. */
#include <math.h>

#include "denoise.h"
#include "ylm_sets.h"

static double number(const denoise_grid *g, int k, size_t i) { return (double)g->number[k][i]; }

/* The weight of tap i by surfaces and by the squared distance d2 in the picture. */
static double near(const denoise_grid *g, const denoise_centre *c, size_t i, double d2) {
  double up = 0, down = 0, cosine = 0, away = 0, share = number(g, TAP_SHARE, i);
  if (g->number[TAP_CLASS][i] != c->class) return 0;
  for (int a = 0; a < 3; a++) {
    double x = number(g, TAP_X + a, i) - (double)c->x[a], n = number(g, TAP_NORMAL + a, i);
    up += x * (double)c->normal[a];
    down += x * n;
    away += x * x;
    cosine += n * (double)c->normal[a];
  }
  double off = fmax(up * up, down * down) * (double)c->plane * (double)c->plane;
  double turned = (cosine - (double)DENOISE_COSINE) / (1 - (double)DENOISE_COSINE);
  double inside = 1 - fmax(d2 * (double)c->falloff, away * (double)c->around);
  return fmax(0, 1 - off) * fmax(0, turned) * fmax(0, inside) * share;
}

static size_t tap_at(const denoise_grid *g, const denoise_centre *c, int u, int v) {
  return (size_t)((ptrdiff_t)c->at + v * (ptrdiff_t)g->stride + u);
}

/* Adds a tap at (x, y) of the centre to a half. */
static void add(const denoise_grid *g, size_t i, int h, double w, double x, double y,
                double sum[2][17]) {
  double by[6] = {1, x, y, x * x, x * y, y * y}, *s = sum[h];
  for (int k = 0; k < 6; k++) s[k] += w * by[k];
  s[6] += w * w;
  for (int k = 0; k < 3; k++)
    for (int b = 0; b < 3; b++) s[7 + 3 * k + b] += w * by[b] * number(g, TAP_VALUE + 3 * h + k, i);
}

static void fit(const denoise_grid *g, const denoise_centre *c, denoise_sums *out) {
  double sum[2][17] = {{0}};
  for (int v = -c->rows; v <= c->rows; v++)
    for (int u = -c->rows - 1; u <= c->rows + 1; u++) {
      size_t i = tap_at(g, c, u, v);
      double x = u - (double)c->off[0], y = v - (double)c->off[1];
      double w = near(g, c, i, x * x + y * y);
      for (int h = 0; h < 2 && w > 0; h++) {
        double d = number(g, TAP_GUIDE + !h, i) - (double)c->guide[!h];
        double spread = number(g, TAP_SPREAD, i) + (double)c->spread;
        double like = fmax(0, 1 - d * d / ((double)DENOISE_RANGE * spread));
        add(g, i, h, w * like * like, x, y, sum);
      }
    }
  for (int h = 0; h < 2; h++) {
    const double *s = sum[h];
    out->weight[h] = (float)s[0], out->u[h] = (float)s[1], out->v[h] = (float)s[2];
    out->uu[h] = (float)s[3], out->uv[h] = (float)s[4], out->vv[h] = (float)s[5];
    out->square[h] = (float)s[6];
    for (int k = 0; k < 3; k++) {
      out->value[h][k] = (float)s[7 + 3 * k];
      out->value_u[h][k] = (float)s[8 + 3 * k];
      out->value_v[h][k] = (float)s[9 + 3 * k];
    }
  }
}

static void vary(const denoise_grid *g, const denoise_centre *c, float out[3]) {
  double weight = 0, square = 0, mean = 0;
  for (int v = -c->rows; v <= c->rows; v++)
    for (int u = -c->rows - 1; u <= c->rows + 1; u++) {
      size_t i = tap_at(g, c, u, v);
      double x = u - (double)c->off[0], y = v - (double)c->off[1];
      double w = near(g, c, i, x * x + y * y);
      weight += w;
      square += w * number(g, TAP_APART, i);
      mean += w * number(g, TAP_ALL, i);
    }
  out[0] = (float)weight;
  out[1] = (float)square;
  out[2] = (float)mean;
}

static YLM_KERNEL_CHOICE(denoise_gather_fn, gather_now, ylm_k_denoise_gather, fit);
static YLM_KERNEL_CHOICE(denoise_gather_fn, fit_now, ylm_k_denoise_fit, fit);
static YLM_KERNEL_CHOICE(denoise_vary_fn, vary_now, ylm_k_denoise_vary, vary);

denoise_kernels ylm__denoise_kernels(void) {
  return (denoise_kernels){gather_now(), fit_now(), vary_now()};
}
