/* spheres.c - rays to spheres, several at a time: the plain form, which judges the others, and their
   choice. */
#include <math.h>

#include "scene.h"
#include "ylm_sets.h"

static void spheres(size_t n, const float normal[3], scene_spheres *a) {
  for (size_t i = 0; i < n; i++) {
    double r = (double)a->radius[i], d2 = 0, toward = 0;
    for (int k = 0; k < 3; k++) d2 += (double)a->v[k][i] * (double)a->v[k][i];
    if (d2 <= r * r) {
      a->value[i] = -1;
      continue;
    }
    double d = sqrt(d2), s2 = r * r / d2, cap = s2 / (1 + sqrt(1 - s2));
    double q = (double)a->u[0][i] * cap, side2 = q * (2 - q), up, x[3], axis[3];
    double c = cos(2 * YLM_PI * (double)a->u[1][i]), s = sin(2 * YLM_PI * (double)a->u[1][i]);
    for (int k = 0; k < 3; k++) axis[k] = (double)a->v[k][i] / d;
    up = axis[2] < 0 ? -1 : 1;
    double p = -1 / (up + axis[2]), w = axis[0] * axis[1] * p, side = sqrt(fmax(0, side2));
    x[0] = c * (1 + up * axis[0] * axis[0] * p) + s * w;
    x[1] = c * (up * w) + s * (up + axis[1] * axis[1] * p);
    x[2] = -(c * up * axis[0]) - s * axis[1];
    for (int k = 0; k < 3; k++) {
      a->dir[k][i] = (float)(side * x[k] + (1 - q) * axis[k]);
      toward += (double)a->dir[k][i] * (double)normal[k];
    }
    a->far[i] = (float)(d * (1 - q) - sqrt(fmax(0, r * r - d2 * side2)));
    a->value[i] = (float)(fmax(0, toward) * 2 * YLM_PI * cap);
  }
}

YLM_KERNEL_CHOICE(ylm_scene_spheres_fn, ylm__scene_spheres, ylm_k_scene_spheres, spheres);
