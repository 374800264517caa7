/* power.c - many lamps, chosen by the power that they send out in a time that does not grow with
   their number. */
#include <math.h>

#include "alias.h"
#include "scene.h"

#define PI 3.14159265358979323846

static double triangle_area(const float *t) {
  double a[3], b[3], n[3];
  for (int k = 0; k < 3; k++) {
    a[k] = (double)t[3 + k] - (double)t[k];
    b[k] = (double)t[6 + k] - (double)t[k];
  }
  for (int k = 0; k < 3; k++)
    n[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
  return sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) / 2;
}

/* Luminous power over pi of lamp i; flat ones have two sides. */
static double power_of(const ylm_scene *s, size_t i) {
  if (i < s->lamps) {
    double r = (double)s->lamp[3][i];
    return 4 * PI * r * r * (double)s->lamp_luminance[i];
  }
  size_t k = i - s->lamps;
  double luminance = (double)s->patch_luminance[k];
  if (k < s->triangles) return 2 * triangle_area(s->triangle + 9 * k) * luminance;
  double r = (double)s->disk[7 * (k - s->triangles) + 3];
  return 2 * PI * r * r * luminance;
}

ylm_status ylm__scene_weigh_power(ylm_scene *s) {
  size_t n = s->lamps + s->triangles + s->disks;
  double total = 0;
  if (n <= YLM_SCENE_FEW) return YLM_OK;
  for (size_t i = 0; i < n; i++) total += power_of(s, i);
  if (!(total > 0) || !isfinite(total)) return YLM_OK;
  scene_power *p = s->power = ylm_alloc_zero(1, sizeof *p);
  if (!p) return YLM_ENOMEM;
  p->share = ylm_alloc(n, sizeof *p->share);
  p->stay = ylm_alloc(n, sizeof *p->stay);
  p->other = ylm_alloc(n, sizeof *p->other);
  double *height = ylm_alloc(n, sizeof *height);
  uint32_t *list = ylm_alloc(n, sizeof *list);
  bool ok = p->share && p->stay && p->other && height && list;
  for (size_t i = 0; ok && i < n; i++) {
    p->share[i] = power_of(s, i) / total;
    height[i] = p->share[i] * (double)n;
  }
  if (ok) ylm__alias_fill(n, height, list, p->stay, p->other);
  ylm_free(height);
  ylm_free(list);
  return ok ? YLM_OK : YLM_ENOMEM;
}

void ylm__scene_free_power(ylm_scene *s) {
  if (!s->power) return;
  ylm_free(s->power->share);
  ylm_free(s->power->stay);
  ylm_free(s->power->other);
  ylm_free(s->power);
}

size_t ylm__scene_by_power(const scene_power *p, size_t lamps, double u) {
  double at = u * (double)lamps;
  size_t i = at < (double)lamps ? (size_t)at : lamps - 1;
  return at - (double)i < (double)p->stay[i] ? i : p->other[i];
}
