/* project.c - from samples on the sphere to coefficients. */
#include "../calibration.h"
#include "ylm_sh.h"

#include <math.h>
#include <string.h>

ylm_status ylm_sh_sphere_rule(int nodes, int azimuths, double lo, double hi, double *direction,
                              double *weight) {
  if (nodes < 1 || nodes > 100000 || azimuths < 1 || azimuths > 100000 ||
      !(lo >= -1 && lo < hi && hi <= 1))
    return YLM_ERANGE;
  double *x = ylm_alloc(2 * (size_t)nodes, sizeof *x), *w = x + nodes;
  if (!x) return YLM_ENOMEM;
  ylm_sh_gauss_legendre(nodes, x, w);
  for (int h = 0; h < nodes; h++) {
    double z = 0.5 * (lo + hi) + 0.5 * (hi - lo) * x[h], s = sqrt((1 - z) * (1 + z));
    for (int j = 0; j < azimuths; j++) {
      double phi = 2 * YLM_PI * (j + 0.5) / azimuths;
      double *d = direction + 3 * ((size_t)h * (size_t)azimuths + (size_t)j);
      d[0] = s * cos(phi);
      d[1] = s * sin(phi);
      d[2] = z;
      weight[(size_t)h * (size_t)azimuths + (size_t)j] =
          0.5 * (hi - lo) * w[h] * 2 * YLM_PI / azimuths;
    }
  }
  ylm_free(x);
  return YLM_OK;
}

void ylm_sh_sphere_samples(int side, uint64_t seed, uint64_t stream, double *direction) {
  ylm_rng r;
  ylm_rng_seed(&r, seed, stream);
  for (int a = 0; a < side; a++)
    for (int b = 0; b < side; b++, direction += 3) {
      double x = (a + ylm_rng_double(&r)) / side, y = (b + ylm_rng_double(&r)) / side;
      double z = 1 - 2 * x, s = sqrt(4 * x * (1 - x)), phi = 2 * YLM_PI * y;
      direction[0] = s * cos(phi);
      direction[1] = s * sin(phi);
      direction[2] = z;
    }
}

typedef struct job {
  int lmax, channels;
  size_t n;
  const double *direction, *weight, *value;
  bool squares;    /* as many numbers again behind */
  double *partial; /* [blocks of PROJECT_GRAIN][1 or 2][channels][count] */
} job;

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  size_t count = ylm_sh_count(j->lmax), channels = (size_t)j->channels;
  size_t size = channels * count;
  double *out = j->partial + begin / PROJECT_GRAIN * size * (j->squares ? 2 : 1),
         p[PROJECT_BLOCK][3], wf[PROJECT_BLOCK];
  double *y = ylm_alloc(PROJECT_BLOCK * count, sizeof *y);
  if (!y) return YLM_ENOMEM;
  ylm_status s = YLM_OK;
  for (size_t i = begin; i < end && s == YLM_OK; i += PROJECT_BLOCK) {
    size_t n = end - i < PROJECT_BLOCK ? end - i : PROJECT_BLOCK;
    for (size_t k = 0; k < n; k++) {
      memcpy(p[k], j->direction + 3 * (i + k), sizeof p[k]);
      if (p[k][0] == 0 && p[k][1] == 0 && p[k][2] == 0 && j->weight && j->weight[i + k] == 0)
        p[k][2] = 1;
    }
    s = ylm_sh_eval(j->lmax, 0, false, YLM_DOUBLE, n, p, y, NULL, NULL, 1, NULL);
    for (size_t c = 0; c < channels && s == YLM_OK; c++) {
      for (size_t k = 0; k < n; k++)
        wf[k] = (j->weight ? j->weight[i + k] : 4 * YLM_PI / (double)j->n) *
                j->value[(i + k) * channels + c];
      for (size_t k = 0; k < n; k++)
        for (size_t q = 0; q < count; q++) out[c * count + q] += wf[k] * y[k * count + q];
      for (size_t k = 0; k < n && j->squares; k++)
        for (size_t q = 0; q < count; q++) {
          double term = wf[k] * y[k * count + q];
          out[size + c * count + q] += term * term;
        }
    }
  }
  ylm_free(y);
  return s;
}

ylm_status ylm_sh_project_samples(int lmax, size_t n, const double *direction, const double *weight,
                                  int channels, const double *value, double *out, double *square,
                                  int threads, const ylm_progress *progress, ylm_error *e) {
  if (lmax < 0 || lmax > YLM_LMAX || channels < 1)
    return ylm_fail(e, YLM_ERANGE, "lmax must be from 0 to %d, got %d", YLM_LMAX, lmax);
  for (size_t i = 0; i < n; i++) {
    const double *d = direction + 3 * i;
    bool finite = isfinite(d[0]) && isfinite(d[1]) && isfinite(d[2]);
    bool zero = d[0] == 0 && d[1] == 0 && d[2] == 0;
    if (!finite || (zero && !(weight && weight[i] == 0)))
      return ylm_fail(e, YLM_EDOMAIN, "direction %zu is %s", i + 1, zero ? "zero" : "not finite");
  }
  size_t size = (size_t)channels * ylm_sh_count(lmax),
         blocks = n / PROJECT_GRAIN + (n % PROJECT_GRAIN != 0);
  size_t width = square ? 2 * size : size;
  memset(out, 0, size * sizeof *out);
  if (square) memset(square, 0, size * sizeof *square);
  job j = {lmax,
           channels,
           n,
           direction,
           weight,
           value,
           square != NULL,
           ylm_alloc_zero(blocks, width * sizeof(double))};
  if (!j.partial) return YLM_ENOMEM;
  ylm_status s = ylm_parallel(n, PROJECT_GRAIN, threads, run, &j, progress, "project");
  for (size_t b = 0; b < blocks && s == YLM_OK; b++)
    for (size_t k = 0; k < size; k++) {
      out[k] += j.partial[b * width + k];
      if (square) square[k] += j.partial[b * width + size + k];
    }
  ylm_free(j.partial);
  return s;
}

size_t ylm_sh_halved(int width, int height, int faces) {
  return (size_t)((width + 1) / 2) * (size_t)((height / faces + 1) / 2) * (size_t)faces;
}

void ylm_sh_halve_pixels(int width, int height, int faces, int channels, const double *direction,
                         const double *weight, const double *value, double *coarse_direction,
                         double *coarse_weight, double *coarse_value) {
  int rows = height / faces;
  for (int face = 0; face < faces; face++)
    for (int y = 0; y < rows; y += 2)
      for (int x = 0; x < width; x += 2, coarse_direction += 3, coarse_value += channels) {
        double d[3] = {0, 0, 0}, sum = 0;
        for (int c = 0; c < channels; c++) coarse_value[c] = 0;
        for (int v = y; v < y + 2 && v < rows; v++)
          for (int u = x; u < x + 2 && u < width; u++) {
            size_t i = (size_t)(face * rows + v) * (size_t)width + (size_t)u;
            sum += weight[i];
            for (int k = 0; k < 3; k++) d[k] += weight[i] * direction[3 * i + (size_t)k];
            for (int c = 0; c < channels; c++)
              coarse_value[c] += weight[i] * value[i * (size_t)channels + (size_t)c];
          }
        double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        if (!(length > 0)) sum = 0; /* outside of an angular map, or opposite directions */
        *coarse_weight++ = sum;
        for (int k = 0; k < 3; k++) coarse_direction[k] = sum > 0 ? d[k] / length : 0;
        for (int c = 0; c < channels; c++) coarse_value[c] = sum > 0 ? coarse_value[c] / sum : 0;
      }
}
