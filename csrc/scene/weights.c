/* weights.c - how much each lamp may bring to a point: the plain form, which judges the others, and
   their choice. */
#include <math.h>

#include "scene.h"
#include "ylm_sets.h"

double ylm__scene_weight(const double v[3], double r, const float n[3]) {
  double d2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
  if (!n) return d2 > r * r ? 2 * (r * r / d2) / (1 + sqrt(1 - r * r / d2)) : r > 0 ? 4 : 0;
  if (d2 <= r * r) return r > 0;
  double cosine = (v[0] * n[0] + v[1] * n[1] + v[2] * n[2]) / sqrt(d2), s = r * r / d2;
  if (cosine >= sqrt(s)) return s * cosine;
  if (cosine <= -sqrt(s)) return 0;
  return s * fmax(0, cosine * sqrt(1 - s) + sqrt((1 - cosine * cosine) * s));
}

static void weights(size_t lamps, float *const lamp[4], const float *luminance, const float x[3],
                    const float n[3], float *w, float *sum) {
  for (size_t j = 0; j < lamps; j++) {
    double v[3] = {(double)lamp[0][j] - x[0], (double)lamp[1][j] - x[1], (double)lamp[2][j] - x[2]};
    if (j % YLM_LAMP_CHUNK == 0) sum[j / YLM_LAMP_CHUNK] = 0;
    w[j] = (float)ylm__scene_weight(v, lamp[3][j], n) * luminance[j];
    sum[j / YLM_LAMP_CHUNK] += w[j];
  }
}

YLM_KERNEL_CHOICE(ylm_scene_weights_fn, ylm__scene_weights, ylm_k_scene_weights, weights);
