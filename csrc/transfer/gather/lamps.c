/*
** lamps.c - the lamps of a scene in a tree, and groups of them as a point sees them.
**
** A group is a node of the tree. The one that matters most for its size is opened until there are as many
** groups as have rays; few lamps are a group each.
*/
#include <stdlib.h>

#include "calibration.h"
#include "direct.h"
#include "ylm_light.h"

static double luminance_of(const double *rgb) {
  return fabs(YLM_LUMINANCE_R * rgb[0] + YLM_LUMINANCE_G * rgb[1] + YLM_LUMINANCE_B * rgb[2]);
}

/* Power, place and size of a lamp by its record; a sun's power is its irradiance. */
static void measure(gather_lamp *l) {
  const double *x = l->record;
  if (!strcmp(l->kind, "sphere")) {
    memcpy(l->at, x + 3, sizeof l->at);
    l->reach = x[6];
    l->power = luminance_of(x) * YLM_PI * x[6] * x[6];
  } else if (!strcmp(l->kind, "sun")) {
    l->distant = true;
    l->power = luminance_of(x);
  } else {
    const double *p = x + 7;
    double u[3], v[3], n[3], area = 0;
    for (int a = 0; a < 3; a++) {
      l->at[a] = x[6] > 0 ? (p[a] + p[3 + a] + p[6 + a]) / 3 : p[a];
      u[a] = x[6] > 0 ? p[3 + a] - p[a] : p[3 + a];
      v[a] = x[6] > 0 ? p[6 + a] - p[a] : p[6 + a];
    }
    for (int a = 0; a < 3; a++) {
      n[a] = u[(a + 1) % 3] * v[(a + 2) % 3] - u[(a + 2) % 3] * v[(a + 1) % 3];
      area += n[a] * n[a];
    }
    area = sqrt(area) * (x[6] > 0 ? 0.5 : YLM_PI);
    for (int k = 0; k < 3; k++) {
      double d2 = 0;
      for (int a = 0; a < 3; a++)
        d2 += x[6] > 0 ? (p[3 * k + a] - l->at[a]) * (p[3 * k + a] - l->at[a])
                       : (k ? p[3 * k + a] * p[3 * k + a] : 0);
      l->reach = fmax(l->reach, sqrt(d2));
    }
    l->power = luminance_of(x) * area;
  }
}

/* -- the tree ---------------------------------------------------------------------------------- */

static int by_x(const void *a, const void *b) {
  double x = ((const gather_lamp *)a)->at[0], y = ((const gather_lamp *)b)->at[0];
  return (x > y) - (x < y);
}
static int by_y(const void *a, const void *b) {
  double x = ((const gather_lamp *)a)->at[1], y = ((const gather_lamp *)b)->at[1];
  return (x > y) - (x < y);
}
static int by_z(const void *a, const void *b) {
  double x = ((const gather_lamp *)a)->at[2], y = ((const gather_lamp *)b)->at[2];
  return (x > y) - (x < y);
}

static uint32_t build(gather_lamps *l, size_t first, size_t n) {
  static int (*const by[3])(const void *, const void *) = {by_x, by_y, by_z};
  uint32_t at = l->nodes++;
  gather_node *node = &l->node[at];
  double lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY};
  *node = (gather_node){.first = (uint32_t)first, .n = (uint32_t)n};
  for (size_t i = first; i < first + n; i++) {
    node->power += l->lamp[i].power;
    for (int a = 0; a < 3; a++) {
      lo[a] = fmin(lo[a], l->lamp[i].at[a]);
      hi[a] = fmax(hi[a], l->lamp[i].at[a]);
    }
  }
  int longest = 0;
  for (int a = 0; a < 3; a++) {
    node->at[a] = (lo[a] + hi[a]) / 2;
    if (hi[a] - lo[a] > hi[longest] - lo[longest]) longest = a;
  }
  for (size_t i = first; i < first + n; i++) {
    double d2 = 0;
    for (int a = 0; a < 3; a++)
      d2 += (l->lamp[i].at[a] - node->at[a]) * (l->lamp[i].at[a] - node->at[a]);
    node->reach = fmax(node->reach, sqrt(d2) + l->lamp[i].reach);
  }
  if (n == 1) return at;
  qsort(l->lamp + first, n, sizeof *l->lamp, by[longest]);
  uint32_t left = build(l, first, n / 2), right = build(l, first + n / 2, n - n / 2);
  l->node[at].child[0] = left;
  l->node[at].child[1] = right;
  return at;
}

ylm_status ylm__gather_lamps_create(const ylm_scene *scene, gather_lamps *l) {
  size_t all = ylm_scene_near(scene) + ylm_scene_distant(scene), suns = 0;
  *l = (gather_lamps){.scene = scene};
  l->lamp = ylm_alloc_zero(all + 1, sizeof *l->lamp); /* one to look at */
  l->node = ylm_alloc(2 * all, sizeof *l->node);
  if (!l->lamp || !l->node) return YLM_ENOMEM;
  for (int distant = 0; distant < 2; distant++)
    for (size_t i = 0; i < all; i++) {
      gather_lamp *lamp = &l->lamp[l->n];
      lamp->numbers = (uint32_t)ylm_scene_lamp_record(scene, i, &lamp->kind, lamp->record);
      if (!lamp->numbers || !strcmp(lamp->kind, "sun") != (distant == 1)) continue;
      lamp->lamp = (uint32_t)i;
      measure(lamp);
      if (!(lamp->power > 0)) {
        *lamp = (gather_lamp){0};
        continue;
      }
      l->n++;
      suns += (size_t)distant;
    }
  if (l->n > suns) build(l, 0, l->n - suns);
  l->suns = suns;
  return YLM_OK;
}

void ylm__gather_lamps_free(gather_lamps *l) {
  ylm_free(l->lamp);
  ylm_free(l->node);
  ylm_free(l->sky);
  *l = (gather_lamps){0};
}

ylm_status ylm__gather_light(const ylm_gather *g, const ylm_scene *scene, gather_lamps **lamps) {
  *lamps = ylm_alloc_zero(1, sizeof **lamps);
  if (!*lamps) return YLM_ENOMEM;
  ylm_status s = ylm__gather_lamps_create(scene, *lamps);
  if (s == YLM_OK) s = ylm__gather_make_sky(&g->lattice, *lamps);
  if (s == YLM_OK) return s;
  ylm__gather_dark(*lamps);
  *lamps = NULL;
  return s;
}

void ylm__gather_dark(gather_lamps *lamps) {
  if (!lamps) return;
  ylm__gather_lamps_free(lamps);
  ylm_free(lamps);
}

const float *ylm__gather_sky_cell(const gather_lamps *l, size_t i) {
  return l && l->sky ? l->sky[i] : NULL;
}

/* -- groups ------------------------------------------------------------------------------------ */

/* About the scalar irradiance that lamps bring to x. */
static double light_of(const double at[3], double reach, double power, const float x[3],
                       double *angle) {
  double d2 = 0;
  for (int a = 0; a < 3; a++) d2 += (at[a] - (double)x[a]) * (at[a] - (double)x[a]);
  *angle = reach / sqrt(fmax(d2, 1e-300));
  return power / fmax(d2, reach * reach);
}

static gather_group group_of(const gather_lamps *l, uint32_t node, const float x[3]) {
  const gather_node *n = &l->node[node];
  gather_group g = {.node = node, .first = n->first, .n = n->n};
  g.light = light_of(n->at, n->reach, n->power, x, &g.angle);
  return g;
}

size_t ylm__gather_groups(const gather_lamps *l, const float x[3], gather_group *out) {
  size_t n = 0, room = GATHER_GROUPS > l->suns ? GATHER_GROUPS - l->suns : 1;
  double all = 0;
  if (l->n > l->suns) out[n++] = group_of(l, 0, x);
  while (n > 0 && n < room) {
    size_t best = n;
    double most = 0;
    all = 0;
    for (size_t i = 0; i < n; i++) all += out[i].light;
    for (size_t i = 0; i < n; i++) {
      double matters = out[i].light * fmin(out[i].angle, 1);
      if (out[i].n > 1 && matters > most) most = matters, best = i;
    }
    if (best == n) break;
    if (l->n > GATHER_GROUPS &&
        (out[best].light < SMALL_SHARE * all || out[best].angle < SMALL_ANGLE))
      break;
    const uint32_t *child = l->node[out[best].node].child;
    out[n++] = group_of(l, child[1], x);
    out[best] = group_of(l, child[0], x);
  }
  for (size_t i = l->n - l->suns; i < l->n && n < GATHER_GROUPS; i++)
    out[n++] = (gather_group){.first = (uint32_t)i, .n = 1, .light = l->lamp[i].power};
  return n;
}
