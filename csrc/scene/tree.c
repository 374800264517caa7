/* tree.c - the tree of lamps is made: slots in order, and sums over the lamps of nodes. */
#include "tree.h"
#include "calibration.h"

#include <math.h>
#include <string.h>

#include "scene.h"

/* Of the largest, so that each lamp has a chance. */
#define LEAST_POWER 1e-30
/* Its square is a number. */
#define LEAST_RADIUS 1e-15f
/* Radii are rounded up. */
#define ROUND_UP 1.00001

/* A lane in double. */
typedef struct lane {
  double x[3], power, spread, radius, facing[6];
} lane;

static void put(scene_node *node, size_t i, const lane *l) {
  for (int a = 0; a < 3; a++) node->x[a][i] = (float)l->x[a];
  node->power[i] = (float)l->power;
  node->spread[i] = (float)l->spread;
  node->radius[i] = fmaxf((float)(l->radius * ROUND_UP), LEAST_RADIUS);
  for (int k = 0; k < 6; k++) node->facing[k][i] = (float)l->facing[k];
}

static lane get(const scene_node *node, size_t i) {
  lane l = {.power = (double)node->power[i],
            .spread = (double)node->spread[i],
            .radius = (double)node->radius[i]};
  for (int a = 0; a < 3; a++) l.x[a] = (double)node->x[a][i];
  for (int k = 0; k < 6; k++) l.facing[k] = (double)node->facing[k][i];
  return l;
}

static double distance2(const double *a, const double *b) {
  double d2 = 0;
  for (int k = 0; k < 3; k++) d2 += (a[k] - b[k]) * (a[k] - b[k]);
  return d2;
}

/* -- lamps ---------------------------------------------------------------------------------- */

/* A flat lamp's squared cosine, with a least one. */
static void face(const double normal[3], lane *l) {
  for (int k = 0; k < 6; k++) {
    int a = k < 3 ? k : k < 5 ? 0 : 1, b = k < 3 ? k : k == 3 ? 1 : 2;
    l->facing[k] = normal[a] * normal[b] + (k < 3 ? LEAST_FACING : 0);
  }
}

static void triangle_lane(const ylm_scene *s, size_t i, lane *l) {
  const scene_far *f = &s->far[i];
  double normal[3], reach2 = 0;
  for (int a = 0; a < 3; a++) {
    l->x[a] = f->centre[a];
    normal[a] = f->area > 0 ? f->across[a] / f->area : 0;
  }
  for (int c = 0; c < 3; c++) {
    const float *t = s->triangle + 9 * i + 3 * c;
    double corner[3] = {(double)t[0], (double)t[1], (double)t[2]};
    reach2 = fmax(reach2, distance2(corner, l->x));
  }
  l->radius = sqrt(reach2);
  l->power = f->area / YLM_PI * (double)s->patch_luminance[i];
  face(normal, l);
}

static void disk_lane(const ylm_scene *s, size_t i, lane *l) {
  const float *d = s->disk + 7 * (i - s->triangles);
  double normal[3];
  for (int a = 0; a < 3; a++) l->x[a] = (double)d[a], normal[a] = (double)d[4 + a];
  l->radius = (double)d[3];
  l->power = l->radius * l->radius * (double)s->patch_luminance[i];
  face(normal, l);
}

static lane lane_of(const ylm_scene *s, size_t i) {
  lane l = {0};
  if (i >= s->lamps + s->triangles) {
    disk_lane(s, i - s->lamps, &l);
  } else if (i >= s->lamps) {
    triangle_lane(s, i - s->lamps, &l);
  } else {
    for (int a = 0; a < 3; a++) l.x[a] = (double)s->lamp[a][i];
    l.radius = (double)s->lamp[3][i];
    l.power = l.radius * l.radius * (double)s->lamp_luminance[i];
    for (int k = 0; k < 3; k++) l.facing[k] = 1;
  }
  return l;
}

/* -- sums ----------------------------------------------------------------------------------- */

/* Everything below a node as one lane of the node above. */
static lane sum_of(const scene_node *node) {
  lane all = {0}, l[SCENE_WIDTH];
  size_t n = 0;
  for (size_t i = 0; i < SCENE_WIDTH; i++) {
    if (!(node->power[i] > 0)) continue;
    l[n] = get(node, i);
    all.power += l[n++].power;
  }
  if (n == 0) return all;
  for (size_t i = 0; i < n; i++) {
    double part = l[i].power / all.power;
    for (int a = 0; a < 3; a++) all.x[a] += part * l[i].x[a];
    for (int k = 0; k < 6; k++) all.facing[k] += part * l[i].facing[k];
  }
  for (int a = 0; a < 3; a++) all.x[a] = (double)(float)all.x[a];
  for (size_t i = 0; i < n; i++) {
    double d2 = distance2(l[i].x, all.x);
    all.spread += l[i].power / all.power * (l[i].spread + d2);
    all.radius = fmax(all.radius, sqrt(d2) + l[i].radius);
  }
  return all;
}

typedef struct level {
  const ylm_scene *s;
  scene_tree *t;
  size_t number;
  double unit; /* powers are multiples of it */
} level;

/* Fills nodes begin .. end-1 of a level. */
static ylm_status fill(void *context, size_t begin, size_t end, int worker) {
  const level *v = context;
  scene_tree *t = v->t;
  size_t below = v->number == 0 ? t->lamps : t->first[v->number] - t->first[v->number - 1];
  (void)worker;
  for (size_t i = begin; i < end; i++) {
    scene_node *node = &t->node[t->first[v->number] + i];
    ylm_zero(node, sizeof *node);
    for (size_t k = 0; k < SCENE_WIDTH && i * SCENE_WIDTH + k < below; k++) {
      size_t child = i * SCENE_WIDTH + k;
      lane l = v->number == 0 ? lane_of(v->s, t->lamp[child])
                              : sum_of(&t->node[t->first[v->number - 1] + child]);
      if (v->number == 0) l.power = fmax(l.power / v->unit, LEAST_POWER);
      put(node, k, &l);
    }
  }
  return YLM_OK;
}

/* Counts nodes; returns how many there are on all levels. */
static size_t count_nodes(scene_tree *t) {
  size_t n = t->lamps, all = 0;
  do {
    n = (n + SCENE_WIDTH - 1) / SCENE_WIDTH;
    t->first[t->levels++] = all;
    all += n;
  } while (n > 1);
  t->first[t->levels] = all;
  return all;
}

static ylm_status fill_levels(const ylm_scene *s, scene_tree *t, double unit) {
  ylm_status status = YLM_OK;
  for (size_t i = 0; status == YLM_OK && i < t->levels; i++) {
    level v = {s, t, i, unit};
    size_t n = t->first[i + 1] - t->first[i];
    status = ylm_parallel(n, TREE_GRAIN, n > TREE_GRAIN ? 0 : 1, fill, &v, NULL, NULL);
  }
  return status;
}

/* Lamps that may bring light, in any order, and the largest power of one. */
static double list_lamps(const ylm_scene *s, scene_tree *t, scene_item *item) {
  size_t all = ylm_scene_near(s);
  double most = 0;
  for (size_t i = 0; i < all; i++) {
    double x[3], power;
    if (i < s->lamps) {
      for (int a = 0; a < 3; a++) x[a] = (double)s->lamp[a][i];
      power = (double)s->lamp[3][i] * (double)s->lamp[3][i] * (double)s->lamp_luminance[i];
    } else {
      lane l = lane_of(s, i);
      memcpy(x, l.x, sizeof x);
      power = l.power;
    }
    t->slot[i] = UINT32_MAX;
    if (!(power > 0) || !isfinite(power)) continue;
    most = power > most ? power : most;
    scene_item *to = &item[t->lamps++];
    to->lamp = (uint32_t)i;
    for (int a = 0; a < 3; a++) to->x[a] = (float)x[a];
  }
  return most;
}

static bool any_horizon(const ylm_scene *s) {
  for (size_t k = 0; s->horizon && k < 3 * (s->triangles + s->disks); k++)
    if (s->horizon[k] != 0) return true;
  return false;
}

static ylm_status grow(const ylm_scene *s, scene_tree *t, scene_item *item) {
  double unit = list_lamps(s, t, item);
  ylm_status status = ylm__scene_order(t->lamps, item);
  if (status != YLM_OK) return status;
  t->lamp = ylm_alloc(t->lamps, sizeof *t->lamp);
  t->node = ylm_alloc(count_nodes(t), sizeof *t->node);
  if (!t->lamp || !t->node) return YLM_ENOMEM;
  for (size_t i = 0; i < t->lamps; i++) {
    t->lamp[i] = item[i].lamp;
    t->slot[item[i].lamp] = (uint32_t)i;
  }
  t->flat = s->triangles + s->disks > 0;
  t->horizons = any_horizon(s);
  t->unit = unit;
  return fill_levels(s, t, unit);
}

ylm_status ylm__scene_plant(ylm_scene *s, size_t one_by_one) {
  size_t all = ylm_scene_near(s), most = one_by_one ? one_by_one : YLM_SCENE_ONE_BY_ONE;
  if (s->lamps + TREE_FLAT * (s->triangles + s->disks) <= most) return YLM_OK;
  scene_tree *t = s->tree = ylm_alloc_zero(1, sizeof *t);
  if (!t) return YLM_ENOMEM;
  t->slot = ylm_alloc(all, sizeof *t->slot);
  scene_item *item = ylm_alloc(all, sizeof *item);
  ylm_status status = t->slot && item ? grow(s, t, item) : YLM_ENOMEM;
  ylm_free(item);
  return status;
}

void ylm__scene_free_tree(ylm_scene *s) {
  if (!s->tree) return;
  ylm_free(s->tree->node);
  ylm_free(s->tree->lamp);
  ylm_free(s->tree->slot);
  ylm_free(s->tree);
}
