/* aim.c - rays from a point to the lamps: lamps and places on them stratified, samples of the tree of
   lamps together. */
#include <math.h>
#include <string.h>

#include "scene.h"
#include "ylm_random.h"

/* x >= 0 without its whole part. */
static double wrap(double x) { return x - (double)(int64_t)x; }

/* Samples whose lamps are chosen: those of spheres become rays together. */
typedef struct chosen {
  size_t n;
  int k[SCENE_GROUP];
  uint32_t lamp[SCENE_GROUP];
  double rarity[SCENE_GROUP]; /* 1 over the chance of the lamp */
} chosen;

/* Rays on their way out of ylm_scene_aim. */
typedef struct aiming {
  ylm_scene_chooser *c;
  int light_samples;
  double s0, s1;     /* where the sequence of places on lamps begins */
  const float *seen; /* a guide's factors of cells of the sky; NULL: there is none */
  size_t rays;
  ylm_trace_ray *ray;
  float (*value)[3];
  chosen waiting;
} aiming;

/* Where on its lamp ray k goes. */
static void place_of(const aiming *a, int k, double u[2]) {
  u[0] = wrap(a->s0 + k * 0.75487766624669276);
  u[1] = wrap(a->s1 + k * 0.56984029099805327);
}

/* The ray of sample i alone. */
static void add_one(aiming *a, size_t i) {
  const ylm_scene *s = a->c->scene;
  size_t lamp = a->waiting.lamp[i];
  int of = ylm__scene_storage_of(s, &lamp);
  scene_aim to = {.x = a->c->x,
                  .normal = a->c->normal,
                  .solid = ylm__scene_solid(a->c, of, lamp),
                  .one = s->tree != NULL,
                  .seen = a->seen};
  float radiance[3];
  place_of(a, a->waiting.k[i], to.u);
  double e = ylm__scene_storage[of]->sample(s, lamp, &to, &a->ray[a->rays], radiance);
  if (!(e > 0)) return;
  e *= a->waiting.rarity[i] / a->light_samples;
  for (int c = 0; c < 3; c++) a->value[a->rays][c] = (float)e * radiance[c];
  a->rays++;
}

/* Lanes of the samples that go to spheres; returns how many there are. */
static size_t list_spheres(aiming *a) {
  const ylm_scene *s = a->c->scene;
  scene_spheres *to = &a->c->spheres;
  size_t lanes = 0;
  for (size_t i = 0; i < a->waiting.n; i++) {
    uint32_t lamp = a->waiting.lamp[i];
    double u[2];
    if (lamp >= s->lamps) continue;
    place_of(a, a->waiting.k[i], u);
    for (int c = 0; c < 3; c++) to->v[c][lanes] = s->lamp[c][lamp] - a->c->x[c];
    to->radius[lanes] = s->lamp[3][lamp];
    to->u[0][lanes] = (float)u[0];
    to->u[1][lanes++] = (float)u[1];
  }
  return lanes;
}

/* The ray of a lane, which is sample i. */
static void add_lane(aiming *a, size_t lane, size_t i) {
  const scene_spheres *from = &a->c->spheres;
  ylm_trace_ray *ray = &a->ray[a->rays];
  uint32_t lamp = a->waiting.lamp[i];
  float e = from->value[lane] * (float)(a->waiting.rarity[i] / a->light_samples);
  if (!(e > 0)) return;
  float radiance[3];
  memcpy(radiance, a->c->scene->lamp_radiance + 3 * (size_t)lamp, sizeof radiance);
  for (int c = 0; c < 3; c++) {
    ray->org[c] = a->c->x[c];
    ray->dir[c] = from->dir[c][lane];
  }
  if (a->c->scene->directions) ylm__scene_directed_radiance(a->c->scene, lamp, ray->dir, radiance);
  for (int c = 0; c < 3; c++) a->value[a->rays][c] = e * radiance[c];
  ray->near = 0;
  ray->far = from->far[lane];
  a->rays++;
}

/* Rays of all samples that wait. */
static void add_all(aiming *a) {
  scene_spheres *spheres = &a->c->spheres;
  size_t lanes = list_spheres(a), lane = 0;
  if (lanes > 0) a->c->aim_at_spheres(lanes, a->c->normal, spheres);
  for (size_t i = 0; i < a->waiting.n; i++) {
    bool sphere = a->waiting.lamp[i] < a->c->scene->lamps;
    if (sphere && !(spheres->value[lane] < 0))
      add_lane(a, lane, i);
    else
      add_one(a, i);
    lane += sphere;
  }
  a->waiting.n = 0;
}

/* Ray k of all goes to a lamp that was chosen with the chance 1/rarity. */
static void aim_at(aiming *a, int k, uint32_t lamp, double rarity) {
  chosen *to = &a->waiting;
  if (to->n == SCENE_GROUP) add_all(a);
  to->k[to->n] = k;
  to->lamp[to->n] = lamp;
  to->rarity[to->n++] = rarity;
}

/* Samples of the tree, from k on: where they are of all weights. */
static void aim_into_tree(aiming *a, int k, size_t n, scene_drawn *d) {
  double part = ylm__scene_tree_weight(a->c) / a->c->total;
  ylm__scene_draw(a->c, n, d);
  for (size_t i = 0; i < n; i++)
    if (d->share[i] > 0) aim_at(a, k + (int)i, d->lamp[i], 1 / (part * d->share[i]));
}

/* -- by guides ------------------------------------------------------------------------------------- */

/* Whether all lamps of a chunk are tiles of the sky, which have no whole rays. */
static bool is_of_tiles(const ylm_scene_chooser *c, size_t chunk) {
  size_t first = c->chunk[SCENE_SKY], tiles = c->scene->sky_lights - c->scene->cones;
  return chunk >= first && (chunk + 1 - first) * YLM_LAMP_CHUNK <= tiles;
}

/* The sums of weights that are left, after lamps of other chunks may have left; their total. */
static double sum_up(ylm_scene_chooser *c) {
  c->total = 0;
  for (size_t b = 0; b < c->chunks; b++) {
    if (!is_of_tiles(c, b)) {
      double sum = 0;
      const float *weight = c->weight + b * YLM_LAMP_CHUNK;
      for (size_t i = 0; i < YLM_LAMP_CHUNK; i++) sum += (double)weight[i];
      c->sum[b] = (float)sum;
    }
    c->total += (double)c->sum[b];
  }
  return c->total;
}

/* Whether the lamp at a place in the list may have whole rays: it is no tile of the sky, and worth one. */
static bool is_whole(const ylm_scene_chooser *c, size_t place, double ray) {
  size_t first = c->chunk[SCENE_SKY] * YLM_LAMP_CHUNK;
  size_t tiles = c->scene->sky_lights - c->scene->cones;
  return (double)c->weight[place] >= ray && (place < first || place >= first + tiles);
}

/* The first place from `i` on that is not in a chunk of tiles. */
static size_t skip_tiles(const ylm_scene_chooser *c, size_t i) {
  while (i % YLM_LAMP_CHUNK == 0 && i / YLM_LAMP_CHUNK < c->chunks &&
         is_of_tiles(c, i / YLM_LAMP_CHUNK))
    i += YLM_LAMP_CHUNK;
  return i;
}

/* Lamps that are worth whole rays. */
typedef struct whole {
  double ray;    /* the weight that is worth one */
  int lamps;     /* their number */
  double spread; /* their weights times spreads */
  double rest;   /* the weight of all others */
} whole;

static whole find_whole(const ylm_scene_chooser *c, const float *spread, double ray) {
  whole x = {.ray = ray};
  size_t all = c->chunks * YLM_LAMP_CHUNK;
  for (size_t b = 0; b < c->chunks; b++)
    if (is_of_tiles(c, b)) x.rest += (double)c->sum[b];
  for (size_t i = skip_tiles(c, 0); i < all; i = skip_tiles(c, i + 1)) {
    double weight = (double)c->weight[i];
    if (is_whole(c, i, ray))
      x.lamps++, x.spread += weight * (double)spread[i];
    else
      x.rest += weight;
  }
  return x;
}

/* Lamps that are worth a ray have one, and more as what they bring varies from ray to ray. They leave the list: their
   light then does not vary with the number of their rays. Returns the rays that were dealt, not all of them where lamps
   are left. */
static int deal_whole(aiming *a, ylm_scene_chooser *c, const float *spread, double total) {
  whole x = find_whole(c, spread, total / a->light_samples);
  int most = a->light_samples - (x.rest > 0), dealt = 0, given = 0;
  double more = most > x.lamps ? most - x.lamps : 0, worth = 0;
  if (x.rest > 0) more = floor(more * x.spread / (x.spread + x.rest));
  size_t all = c->chunks * YLM_LAMP_CHUNK;
  for (size_t i = skip_tiles(c, 0); i < all && dealt < most; i = skip_tiles(c, i + 1)) {
    if (!is_whole(c, i, x.ray)) continue;
    worth += more * (double)c->weight[i] * (double)spread[i] / x.spread;
    int extra = (int)floor(worth + 0.5) - given,
        rays = extra < most - dealt ? 1 + extra : most - dealt;
    for (int k = 0; k < rays; k++)
      aim_at(a, dealt + k, ylm__scene_lamp_at(c, i), (double)a->light_samples / rays);
    given += extra;
    dealt += rays;
    c->weight[i] = 0;
  }
  return dealt;
}

/* The rays that are left, to what is left. */
static void deal_rest(aiming *a, ylm_scene_chooser *c, int dealt, ylm_rng *rng) {
  int left = a->light_samples - dealt;
  double share = (double)a->light_samples / left;
  scene_walk w = {0};
  for (int k = 0; k < left; k++) {
    ylm__scene_walk_to(&w, c, (k + ylm_draw_double(rng)) / left * c->total);
    double weight = (double)c->weight[w.lamp];
    if (weight > 0) aim_at(a, dealt + k, ylm__scene_lamp_at(c, w.lamp), share * c->total / weight);
  }
}

static void aim_by_guide(aiming *a, ylm_scene_chooser *c, ylm_rng *rng) {
  const float *spread = ylm__scene_guide_weights(c) + c->chunks * YLM_LAMP_CHUNK;
  a->seen = spread + c->chunks * YLM_LAMP_CHUNK;
  int dealt = c->total > 0 ? deal_whole(a, c, spread, c->total) : 0;
  if (sum_up(c) > 0 && dealt < a->light_samples) deal_rest(a, c, dealt, rng);
}

/* -- all rays of a place --------------------------------------------------------------------------- */

/* Makes the rays that are left, and lets all start at the origin. */
static size_t start_all(aiming *a, const float *origin) {
  add_all(a);
  for (size_t i = 0; origin && i < a->rays; i++) ylm_scene_start(&a->ray[i], origin);
  return a->rays;
}

/* Places on lamps follow Roberts' sequence R2, shifted at random, so that successive rays, most of
   them to one lamp, spread over it. */
size_t ylm_scene_aim(ylm_scene_chooser *c, const float x[3], const float n[3], const float *origin,
                     int light_samples, ylm_rng *rng, ylm_trace_ray *ray, float (*value)[3]) {
  const ylm_scene *s = c->scene;
  ylm__scene_turn_to(c, x, n);
  if (!(ylm__scene_weigh(c, false, light_samples) > 0)) return 0;
  scene_walk w = {0};
  scene_drawn d;
  size_t drawn = 0;
  double tree = s->tree ? ylm__scene_tree_weight(c) : 0;
  aiming a;
  a.c = c, a.light_samples = light_samples, a.ray = ray, a.value = value, a.seen = NULL;
  a.rays = a.waiting.n = 0; /* the lists of those that wait are large */
  a.s0 = ylm_draw_double(rng);
  a.s1 = ylm_draw_double(rng);
  if (c->guide && !s->tree) {
    aim_by_guide(&a, c, rng);
    return start_all(&a, origin);
  }
  for (int k = 0; k < light_samples; k++) {
    double target = (k + ylm_draw_double(rng)) / light_samples * c->total;
    bool in_tree = tree > 0 && (target < tree || c->chunks == 0);
    if (in_tree) d.at[drawn++] = fmin(target / tree, SCENE_BELOW_ONE);
    if (drawn > 0 && (!in_tree || drawn == SCENE_GROUP || k + 1 == light_samples)) {
      aim_into_tree(&a, k + in_tree - (int)drawn, drawn, &d);
      drawn = 0;
    }
    if (in_tree) continue;
    ylm__scene_walk_to(&w, c, target - tree);
    if (c->weight[w.lamp] > 0) /* padding has none */
      aim_at(&a, k, ylm__scene_lamp_at(c, w.lamp), c->total / (double)c->weight[w.lamp]);
  }
  return start_all(&a, origin);
}
