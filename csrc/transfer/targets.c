/* targets.c - which elements send light to which places, and gathering by rays that are aimed at them. */
#include <math.h>

#include "calibration.h"
#include "transfer.h"

struct ylm_transfer_targets {
  const ylm_transfer *t;
  ylm_scene_clusters *of; /* clusters of places */
  float *below;           /* [clusters][groups + 1] the chance of the groups before each */
  uint32_t *group;        /* [elements] */
  uint32_t *list, *first; /* [elements] in the order of groups; [groups + 1] of each in the list */
  float *before;   /* [elements + groups] the chance of those before each in its group, and 1 */
  uint32_t *guess; /* [elements] where a search in `before` begins, and */
  uint32_t *guess_below; /* [clusters][groups] in `below` */
  float *dense;          /* [elements] the chance of each in its group, over its area */
  float (*corner)[3][3]; /* [elements] of the list: the first, and from it to the others */
  ylm_transfer_targets_stats stats;
};

void ylm_transfer_targets_free(ylm_transfer_targets *a) {
  if (!a) return;
  ylm_scene_clusters_free(a->of);
  ylm_free(a->below);
  ylm_free(a->group);
  ylm_free(a->list);
  ylm_free(a->first);
  ylm_free(a->before);
  ylm_free(a->guess);
  ylm_free(a->guess_below);
  ylm_free(a->dense);
  ylm_free(a->corner);
  ylm_free(a);
}

void ylm_transfer_targets_look(const ylm_transfer_targets *a, ylm_transfer_targets_stats *stats) {
  *stats = a->stats;
}

/* -- what a pilot meets ---------------------------------------------------------------- */

/* Some places of each cluster, and the elements that their links hit. */
typedef struct pilot {
  size_t n;                         /* TARGETS_PLACES of each cluster */
  float (*origin)[3], (*normal)[3]; /* [n] */
  uint64_t *stream;                 /* [n] */
  uint32_t *link;                   /* [n][TARGETS_LINKS] */
  float *light;                     /* [elements + 1] luminance that leaves */
} pilot;

static void pilot_free(pilot *p) {
  ylm_free(p->origin);
  ylm_free(p->normal);
  ylm_free(p->stream);
  ylm_free(p->link);
  ylm_free(p->light);
}

static ylm_status pilot_create(const ylm_transfer_targets *a, const ylm_scene_places *places,
                               const float *leaving, pilot *p) {
  size_t clusters = a->stats.clusters, elements = a->t->elements;
  p->n = clusters * TARGETS_PLACES;
  p->origin = ylm_alloc(p->n, sizeof *p->origin);
  p->normal = ylm_alloc(p->n, sizeof *p->normal);
  p->stream = ylm_alloc(p->n, sizeof *p->stream);
  p->link = ylm_alloc(p->n * TARGETS_LINKS, sizeof *p->link);
  p->light = ylm_alloc(elements + 1, sizeof *p->light);
  if (!p->origin || !p->normal || !p->stream || !p->link || !p->light) return YLM_ENOMEM;
  for (size_t i = 0; i < p->n; i++) {
    size_t k = i % TARGETS_PLACES, m;
    const uint32_t *place = ylm_scene_cluster_places(a->of, i / TARGETS_PLACES, TARGETS_LEAST, &m);
    uint32_t at = place[k * m / TARGETS_PLACES];
    memcpy(p->origin[i], places->origin[at], 12);
    memcpy(p->normal[i], places->normal[at], 12);
    p->stream[i] = i;
  }
  ylm__transfer_luminances(elements + 1, leaving, p->light);
  return YLM_OK;
}

/* The variance of a link's light over the square of its mean, on average over clusters. */
static double variance_of(const ylm_transfer_targets *a, const pilot *p) {
  size_t each = TARGETS_PLACES * TARGETS_LINKS;
  double all = 0, lit = 0;
  for (size_t c = 0; c < a->stats.clusters; c++) {
    double sum = 0, square = 0;
    for (size_t k = c * each; k < (c + 1) * each; k++) {
      double light = (double)p->light[p->link[k]];
      sum += light, square += light * light;
    }
    if (!(sum > 0)) continue;
    all += square * (double)each / (sum * sum) - 1;
    lit++;
  }
  return lit > 0 ? all / lit : 0;
}

/* -- groups of elements ---------------------------------------------------------------- */

/* The middles of elements that were hit, by the light that they brought: of the sum of all, as many as there are steps in it. */
static size_t draw_hits(const ylm_transfer_targets *a, const pilot *p, float (*x)[3],
                        float (*normal)[3]) {
  double all = 0, at = 0;
  size_t n = 0;
  for (size_t k = 0; k < p->n * TARGETS_LINKS; k++) all += (double)p->light[p->link[k]];
  for (size_t k = 0; all > 0 && k < p->n * TARGETS_LINKS; k++) {
    uint32_t e = p->link[k];
    for (at += (double)p->light[e] / all * TARGETS_HITS; n < TARGETS_HITS && at >= (double)n + 0.5;
         n++) {
      memcpy(x[n], a->t->centre[e], 12);
      memcpy(normal[n], a->t->normal[e], 12);
    }
  }
  return n;
}

/* Where searches in before [n] begin: guess[j] is that of all from j / n on. */
static void guess_steps(const float *before, size_t n, uint32_t *guess) {
  for (size_t j = 0, k = 0; j < n; j++) {
    double u = (double)j / (double)n * (1 - 1e-9);
    while (k + 1 < n && (double)before[k + 1] <= u) k++;
    guess[j] = (uint32_t)k;
  }
}

/* The last k < n with before[k] <= u, u from 0 to below 1 (Chen & Asau 1974). */
static size_t find(const float *before, const uint32_t *guess, size_t n, double u) {
  size_t j = (size_t)(u * (double)n), k = guess[j < n ? j : n - 1];
  while (k + 1 < n && (double)before[k + 1] <= u) k++;
  return k;
}

/* The chances of elements in a group. */
static void tell_within(ylm_transfer_targets *a, size_t g, const float *light) {
  const float *area = a->t->area;
  const uint32_t *list = a->list + a->first[g];
  float *before = a->before + a->first[g] + g;
  size_t all = a->first[g + 1] - a->first[g];
  double sum = 0, at = 0;
  for (size_t k = 0; k < all; k++) sum += (double)(light[list[k]] * area[list[k]]);
  for (size_t k = 0; k < all; k++) {
    before[k] = sum > 0 ? (float)fmin(1, at / sum) : 0;
    at += (double)(light[list[k]] * area[list[k]]);
  }
  before[all] = sum > 0;
  guess_steps(before, all, a->guess + a->first[g]);
  for (size_t k = 0; k < all; k++) a->dense[list[k]] = (before[k + 1] - before[k]) / area[list[k]];
}

/* Gives each element its group, all of them in the order of groups, and chances in these. */
static ylm_status list_elements(ylm_transfer_targets *a, const ylm_scene_clusters *groups,
                                const float *light) {
  const ylm_transfer *t = a->t;
  size_t n = t->elements, count = a->stats.groups;
  a->group = ylm_alloc(n, sizeof *a->group);
  a->list = ylm_alloc(n, sizeof *a->list);
  a->first = ylm_alloc_zero(count + 2, sizeof *a->first);
  a->before = ylm_alloc(n + count, sizeof *a->before);
  a->guess = ylm_alloc(n, sizeof *a->guess);
  a->dense = ylm_alloc(n, sizeof *a->dense);
  a->corner = ylm_alloc(n, sizeof *a->corner);
  if (!a->group || !a->list || !a->first || !a->before || !a->guess || !a->dense || !a->corner)
    return YLM_ENOMEM;
  for (size_t e = 0; e < n; e++) {
    a->group[e] = (uint32_t)ylm_scene_cluster_at(groups, t->centre[e], t->normal[e]);
    a->first[a->group[e] + 2]++;
  }
  for (size_t g = 2; g <= count; g++) a->first[g] += a->first[g - 1];
  for (size_t e = 0; e < n; e++) a->list[a->first[a->group[e] + 1]++] = (uint32_t)e;
  for (size_t g = 0; g < count; g++) tell_within(a, g, light);
  return YLM_OK;
}

/* The corners of elements of the list that send light. */
static ylm_status find_corners(ylm_transfer_targets *a, const float *light) {
  const ylm_transfer *t = a->t;
  float(*vertex)[3] = ylm_alloc(ylm_scene_vertices(t->scene, NULL), sizeof *vertex);
  if (!vertex) return YLM_ENOMEM;
  ylm_scene_vertices(t->scene, vertex[0]);
  for (size_t k = 0; k < t->elements; k++) {
    ylm_scene_place place;
    float at[3][2], (*out)[3] = a->corner[k];
    if (!(light[a->list[k]] > 0)) continue;
    ylm__transfer_corners(t, a->list[k], &place, at);
    const uint32_t *of = ylm_scene_triangle(t->scene, place.mesh, place.element);
    size_t first = ylm_scene_first_vertex(t->scene, place.mesh);
    const float *x = vertex[first + of[0]], *y = vertex[first + of[1]], *z = vertex[first + of[2]];
    for (int q = 0; q < 3; q++) {
      for (int c = 0; c < 3; c++)
        out[c][q] = x[q] + at[c][0] * (y[q] - x[q]) + at[c][1] * (z[q] - x[q]);
      out[1][q] -= out[0][q];
      out[2][q] -= out[0][q];
    }
  }
  ylm_free(vertex);
  return YLM_OK;
}

/* Groups of elements that are the finer where more light comes from. */
static ylm_status group_elements(ylm_transfer_targets *a, const pilot *p) {
  float(*x)[3] = ylm_alloc(2 * TARGETS_HITS, sizeof *x);
  ylm_scene_clusters *groups = NULL;
  if (!x) return YLM_ENOMEM;
  size_t n = draw_hits(a, p, x, x + TARGETS_HITS);
  ylm_scene_places hits = {n, (const float(*)[3])x, (const float(*)[3])(x + TARGETS_HITS),
                           (const float(*)[3])x};
  ylm_status s = n > 0 ? ylm_scene_clusters_create(&hits, TARGETS_GROUP, &groups) : YLM_OK;
  if (s == YLM_OK && n > 0) {
    a->stats.groups = ylm_scene_clusters_count(groups);
    s = list_elements(a, groups, p->light);
    if (s == YLM_OK) s = find_corners(a, p->light);
  }
  ylm_scene_clusters_free(groups);
  ylm_free(x);
  return s;
}

/* Lengths whose square is below `width` do not make a look bring more. */
typedef struct chances {
  ylm_transfer_targets *a;
  const pilot *p;
  double *flux;  /* [groups] sum of luminance times area */
  double *width; /* [groups] sum of area over pi */
  uint64_t seed;
} chances;

/* The memory of one thread. */
typedef struct looks {
  double *part;       /* [groups] of the light of a cluster */
  size_t n;           /* rays to groups */
  ylm_trace_ray *ray; /* [TARGETS_LOOKS of each group] */
  float *value;       /* what they bring if nothing is in their way */
  uint32_t *of;       /* their groups */
} looks;

/* A ray of cluster c to group g, and the mean radiance that it would bring as all of the group if nothing were in its way. */
static float look(const chances *x, size_t c, size_t g, ylm_rng *rng, ylm_trace_ray *ray,
                  double *floor) {
  const ylm_transfer_targets *a = x->a;
  const ylm_transfer *t = a->t;
  size_t n = a->first[g + 1] - a->first[g];
  const float *before = a->before + a->first[g] + g;
  size_t i = c * TARGETS_PLACES + (size_t)(ylm_rng_double(rng) * TARGETS_PLACES);
  double u = ylm_rng_double(rng);
  ray->near = 0, ray->far = -1;
  memcpy(ray->org, x->p->origin[i], 12);
  memcpy(ray->dir, x->p->normal[i], 12);
  if (n == 0 || !(before[n] > 0)) return 0;
  uint32_t e = a->list[a->first[g] + find(before, a->guess + a->first[g], n, u)];
  float to[3];
  for (int k = 0; k < 3; k++) to[k] = t->centre[e][k] - ray->org[k];
  double square = (double)ylm_dot3(to, to), here = (double)ylm_dot3(to, x->p->normal[i]),
         there = -(double)ylm_dot3(to, t->normal[e]);
  *floor += TARGETS_FAR / TARGETS_LOOKS * x->flux[g] / (YLM_PI * fmax(square, x->width[g]));
  if (!(here > 0) || !(there > 0)) return 0;
  memcpy(ray->dir, to, 12);
  ray->far = 0.999f;
  return (float)(x->flux[g] * here * there / (YLM_PI * square * fmax(square, x->width[g])));
}

/* The light that the pilot's links brought to cluster c. */
static void add_links(const chances *x, size_t c, double *part) {
  size_t each = TARGETS_PLACES * TARGETS_LINKS;
  const uint32_t *link = x->p->link + c * each;
  for (size_t k = 0; k < each; k++) {
    float light = x->p->light[link[k]];
    if (light > 0) part[x->a->group[link[k]]] += (double)light / (double)each;
  }
}

/* Rays from cluster c to all groups, and a part of what they bring if nothing is in their way; small ones are left out. */
static void aim_looks(const chances *x, size_t c, looks *l) {
  double open = 0;
  size_t n = 0;
  ylm_rng rng;
  ylm_rng_seed(&rng, x->seed, c);
  for (size_t k = 0; k < TARGETS_LOOKS * x->a->stats.groups; k++) {
    size_t g = k / TARGETS_LOOKS;
    l->value[n] = look(x, c, g, &rng, &l->ray[n], &l->part[g]);
    if (!(l->value[n] > 0)) continue;
    open += (double)l->value[n];
    l->of[n++] = (uint32_t)g;
  }
  l->n = 0;
  for (size_t k = 0; k < n; k++) {
    l->part[l->of[k]] += TARGETS_FLOOR * (double)l->value[k] / TARGETS_LOOKS;
    if ((double)l->value[k] < open * TARGETS_SMALL) continue;
    l->ray[l->n] = l->ray[k], l->value[l->n] = l->value[k], l->of[l->n++] = l->of[k];
  }
}

/* The chances of groups for a cluster, from parts of its light. */
static void settle(size_t groups, const double *part, float *below) {
  double sum = 0, at = 0;
  for (size_t g = 0; g < groups; g++) sum += part[g];
  for (size_t g = 0; g < groups; g++) {
    below[g] = sum > 0 ? (float)fmin(1, at / sum) : 0;
    at += part[g];
  }
  below[groups] = sum > 0;
}

static ylm_status tell(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const chances *x = context;
  ylm_transfer_targets *a = x->a;
  size_t groups = a->stats.groups, most = TARGETS_LOOKS * groups;
  looks l = {.part = ylm_alloc(groups, sizeof *l.part),
             .ray = ylm_alloc(most, sizeof *l.ray),
             .value = ylm_alloc(most, sizeof *l.value),
             .of = ylm_alloc(most, sizeof *l.of)};
  ylm_status s = l.part && l.ray && l.value && l.of ? YLM_OK : YLM_ENOMEM;
  for (size_t c = begin; s == YLM_OK && c < end; c++) {
    memset(l.part, 0, groups * sizeof *l.part);
    add_links(x, c, l.part);
    aim_looks(x, c, &l);
    ylm_trace_occluded(ylm_scene_trace(a->t->scene), l.n, l.ray);
    for (size_t k = 0; k < l.n; k++)
      if (!(l.ray[k].far < 0)) l.part[l.of[k]] += (double)l.value[k] / TARGETS_LOOKS;
    settle(groups, l.part, a->below + c * (groups + 1));
    guess_steps(a->below + c * (groups + 1), groups, a->guess_below + c * groups);
  }
  ylm_free(l.part);
  ylm_free(l.ray);
  ylm_free(l.value);
  ylm_free(l.of);
  return s;
}

/* The part of each group in the light that clusters meet. */
static ylm_status tell_chances(ylm_transfer_targets *a, const pilot *p, uint64_t seed, int threads,
                               const ylm_progress *progress) {
  size_t groups = a->stats.groups;
  chances x = {.a = a, .p = p, .seed = seed};
  x.flux = ylm_alloc_zero(groups, sizeof *x.flux);
  x.width = ylm_alloc_zero(groups, sizeof *x.width);
  a->below = ylm_alloc(a->stats.clusters * (groups + 1), sizeof *a->below);
  a->guess_below = ylm_alloc(a->stats.clusters * groups, sizeof *a->guess_below);
  ylm_status s = x.flux && x.width && a->below && a->guess_below ? YLM_OK : YLM_ENOMEM;
  for (size_t e = 0; s == YLM_OK && e < a->t->elements; e++)
    if (p->light[e] > 0) {
      x.flux[a->group[e]] += (double)(p->light[e] * a->t->area[e]);
      x.width[a->group[e]] += (double)a->t->area[e] / YLM_PI;
    }
  if (s == YLM_OK) s = ylm_parallel(a->stats.clusters, 1, threads, tell, &x, progress, "links");
  ylm_free(x.flux);
  ylm_free(x.width);
  return s;
}

static ylm_status learn(ylm_transfer_targets *a, const float *leaving,
                        const ylm_scene_places *places, double worth, uint64_t seed, int threads,
                        const ylm_progress *progress) {
  pilot p = {0};
  size_t most = places->n / TARGETS_CLUSTERS;
  ylm_status s =
      ylm_scene_clusters_create(places, most > TARGETS_LEAST ? most : TARGETS_LEAST, &a->of);
  if (s != YLM_OK) return s;
  a->stats.clusters = ylm_scene_clusters_count(a->of);
  s = pilot_create(a, places, leaving, &p);
  if (s == YLM_OK)
    s = ylm__transfer_find_shares(
        a->t, p.n, (const float(*)[3])p.origin, (const float(*)[3])p.normal, p.stream,
        TARGETS_LINKS, seed, threads, progress, (ylm_links){.four = p.link}, 0, NULL, NULL, NULL);
  a->stats.rays = p.n * TARGETS_LINKS;
  if (s == YLM_OK && variance_of(a, &p) > worth) s = group_elements(a, &p);
  if (s == YLM_OK && a->stats.groups > 0)
    s = tell_chances(a, &p, ylm_mix64(seed), threads, progress);
  pilot_free(&p);
  ylm_scene_clusters_forget(a->of);
  return s;
}

/* As ylm_transfer_targets_create, where links vary by more than `worth`. */
static ylm_status create(const ylm_transfer *t, const float *leaving,
                         const ylm_scene_places *places, double worth, uint64_t seed, int threads,
                         const ylm_progress *progress, ylm_transfer_targets **out) {
  double begun = ylm_seconds();
  *out = NULL;
  if (places->n == 0 || t->elements == 0) return YLM_OK;
  ylm_transfer_targets *a = ylm_alloc_zero(1, sizeof *a);
  if (!a) return YLM_ENOMEM;
  a->t = t;
  ylm_status s = learn(a, leaving, places, worth, seed, threads, progress);
  a->stats.seconds = ylm_seconds() - begun;
  if (s == YLM_OK && a->stats.groups > 0)
    *out = a;
  else
    ylm_transfer_targets_free(a);
  return s;
}

ylm_status ylm_transfer_targets_create(const ylm_transfer *t, const float *leaving,
                                       const ylm_scene_places *places, uint64_t seed, int threads,
                                       const ylm_progress *progress, ylm_transfer_targets **out) {
  return create(t, leaving, places, TARGETS_WORTH, seed, threads, progress, out);
}

/* -- rays ------------------------------------------------------------------------------ */

size_t ylm_transfer_targets_at(const ylm_transfer_targets *a, const float x[3],
                               const float normal[3]) {
  return ylm_scene_cluster_at(a->of, x, normal);
}

/* The rest of u in the step from before[0] to before[1]. */
static double rest(const float *before, double u) {
  double step = (double)before[1] - (double)before[0];
  return step > 0 ? fmin((u - (double)before[0]) / step, 1 - 1e-12) : 0;
}

bool ylm_transfer_target(const ylm_transfer_targets *a, size_t cluster, const double u[3],
                         uint32_t *element, float point[3]) {
  size_t groups = a->stats.groups;
  const float *below = a->below + cluster * (groups + 1);
  if (!(below[groups] > 0)) return false;
  size_t g = find(below, a->guess_below + cluster * groups, groups, u[0]);
  size_t n = a->first[g + 1] - a->first[g];
  const float *before = a->before + a->first[g] + g;
  if (n == 0 || !(before[n] > 0)) return false;
  double v = rest(below + g, u[0]);
  size_t at = a->first[g] + find(before, a->guess + a->first[g], n, v);
  double x = u[1] + u[2] > 1 ? 1 - u[1] : u[1], y = u[1] + u[2] > 1 ? 1 - u[2] : u[2];
  *element = a->list[at];
  for (int q = 0; q < 3; q++)
    point[q] =
        a->corner[at][0][q] + (float)x * a->corner[at][1][q] + (float)y * a->corner[at][2][q];
  return true;
}

double ylm_transfer_target_density(const ylm_transfer_targets *a, size_t cluster, uint32_t e,
                                   const ylm_trace_ray *ray, const ylm_trace_hit *hit) {
  const float *below = a->below + cluster * (a->stats.groups + 1) + a->group[e];
  double n = sqrt((double)ylm_dot3(hit->normal, hit->normal));
  double cosine = fabs((double)ylm_dot3(hit->normal, ray->dir));
  double area = (double)(below[1] - below[0]) * (double)a->dense[e]; /* over area: m^-2 */
  return area * (cosine > 0 ? (double)hit->t * (double)hit->t * n / cosine : 0);
}

/* -- gathering ------------------------------------------------------------------------- */

typedef struct job {
  const ylm_transfer_targets *a;
  const float *leaving;
  const float (*origin)[3], (*normal)[3];
  const uint64_t *stream;
  transfer_fan fan;
  int links;
  uint64_t seed;
  float (*mean)[4], *share;  /* share: NULL: not wanted */
  const transfer_flow *flow; /* NULL: not wanted */
} job;

typedef struct scratch {
  ylm_trace_ray *ray; /* [TARGETS_GRAIN][links]: of the cosine, then those that are aimed */
  ylm_trace_hit *hit;
  uint32_t *target, *aimed;
  size_t cluster[TARGETS_GRAIN];
} scratch;

/* Rays of place i. */
static void aim(const job *j, scratch *x, size_t i, size_t at) {
  int fan = j->fan.rays;
  ylm_trace_ray *ray = x->ray + at * (size_t)j->links;
  uint32_t *aimed = x->aimed + at * (size_t)j->links;
  ylm_rng rng;
  ylm_rng_seed(&rng, j->seed, j->stream[i]);
  ylm__transfer_fan_aim(&j->fan, j->normal[i], &rng, ray);
  double by = ylm_rng_double(&rng), u = ylm_rng_double(&rng), v = ylm_rng_double(&rng);
  x->cluster[at] = ylm_transfer_targets_at(j->a, j->origin[i], j->normal[i]);
  for (int k = 0; k < j->links; k++) {
    float point[3], square;
    memcpy(ray[k].org, j->origin[i], 12);
    if (k < fan) continue;
    double draw[3] = {(k - fan + by) / (j->links - fan), u + (k - fan) * 0.7548776662466927,
                      v + (k - fan) * 0.5698402909980532};
    draw[1] -= floor(draw[1]), draw[2] -= floor(draw[2]);
    ray[k].near = 0;
    ray[k].far = -1;
    memcpy(ray[k].dir, j->normal[i], 12);
    if (!ylm_transfer_target(j->a, x->cluster[at], draw, &aimed[k], point)) continue;
    for (int q = 0; q < 3; q++) point[q] -= ray[k].org[q];
    square = ylm_dot3(point, point);
    if (!(ylm_dot3(point, j->normal[i]) > 0)) continue;
    for (int q = 0; q < 3; q++) ray[k].dir[q] = point[q] / sqrtf(square);
    ray[k].far = INFINITY;
  }
}

/* The mean of the light that the rays of place i brought. */
static void add(const job *j, const scratch *x, size_t i, size_t at) {
  const ylm_transfer_targets *a = j->a;
  size_t links = (size_t)j->links, fan = (size_t)j->fan.rays, first = at * links, good = 0;
  double sum[3] = {0}, flow[9] = {0}, part = (double)fan / (double)links;
  for (size_t k = 0; k < fan; k++) good += x->target[first + k] != YLM_TRANSFER_BURIED(a->t);
  for (size_t k = 0; k < links; k++) {
    const ylm_trace_ray *ray = &x->ray[first + k];
    const ylm_trace_hit *hit = &x->hit[first + k];
    uint32_t e = x->target[first + k], raw;
    if (e >= a->t->elements || ray->far < 0) continue;
    raw = ylm_transfer_hit(a->t, ray, hit);
    if (k >= fan && raw != x->aimed[first + k]) continue;
    double own = (double)ylm_dot3(ray->dir, j->normal[i]) / YLM_PI;
    double other = ylm_transfer_target_density(a, x->cluster[at], raw, ray, hit);
    double each = own / (part * own + (1 - part) * other);
    if (k < fan) each *= (double)fan / (double)good;
    const float *L = j->leaving + 4 * (size_t)e;
    for (size_t c = 0; c < 3; c++) sum[c] += each * (double)L[c];
    double level = fmax((double)ylm_dot3(ray->dir, j->normal[i]), FLOW_LEVEL);
    for (size_t c = 0; j->flow && c < 9; c++)
      flow[c] += each * (double)L[c % 3] * (double)ray->dir[c / 3] / level;
  }
  if (j->share) j->share[i] = (float)good / (float)fan;
  for (size_t c = 0; j->flow && c < 9; c++)
    j->flow->out[i][c / 3][c % 3] = (float)(YLM_PI * flow[c] / (double)links);
  for (size_t c = 0; c < 3; c++) j->mean[i][c] = (float)(sum[c] / (double)links);
  j->mean[i][3] = 0;
}

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  size_t links = (size_t)j->links, all = (end - begin) * links;
  scratch x;
  x.ray = ylm_alloc(all, sizeof *x.ray);
  x.hit = ylm_alloc(all, sizeof *x.hit);
  x.target = ylm_alloc(all, sizeof *x.target);
  x.aimed = ylm_alloc(all, sizeof *x.aimed);
  ylm_status s = x.ray && x.hit && x.target && x.aimed ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) {
    for (size_t i = begin; i < end; i++) aim(j, &x, i, i - begin);
    ylm_trace_nearest(ylm_scene_trace(j->a->t->scene), all, x.ray, false, x.hit);
    ylm_transfer_hits(j->a->t, all, x.ray, x.hit, x.target);
    for (size_t i = begin; i < end; i++) add(j, &x, i, i - begin);
  }
  ylm_free(x.ray);
  ylm_free(x.hit);
  ylm_free(x.target);
  ylm_free(x.aimed);
  return s;
}

ylm_status ylm__transfer_gather(const ylm_transfer_targets *a, const float *leaving, size_t n,
                                const float (*origin)[3], const float (*normal)[3],
                                const uint64_t *stream, int links, uint64_t seed, int threads,
                                const ylm_progress *progress, float (*mean)[4], float *share,
                                const transfer_flow *flow) {
  job j = {.a = a,
           .leaving = leaving,
           .origin = origin,
           .normal = normal,
           .stream = stream,
           .links = links,
           .seed = seed,
           .mean = mean,
           .share = share,
           .flow = flow};
  if (links < 2 || links > YLM_TRANSFER_LINKS || links % 2) return YLM_ERANGE;
  ylm_status s = ylm__transfer_fan_create(links / 2, &j.fan);
  if (s == YLM_OK) s = ylm_parallel(n, TARGETS_GRAIN, threads, run, &j, progress, "links");
  ylm__transfer_fan_free(&j.fan);
  return s;
}

ylm_status ylm_transfer_gather_targets(const ylm_transfer_targets *a, const float *leaving,
                                       size_t n, const float (*origin)[3], const float (*normal)[3],
                                       const uint64_t *stream, int links, uint64_t seed,
                                       int threads, const ylm_progress *progress,
                                       float (*mean)[4]) {
  return ylm__transfer_gather(a, leaving, n, origin, normal, stream, links, seed, threads, progress,
                              mean, NULL, NULL);
}

/* -- of a radiosity ---------------------------------------------------------------------- */

ylm_status ylm_radiosity_aim(ylm_radiosity *r, int threads, const ylm_progress *progress) {
  const ylm_transfer *t = r->t;
  const float *averaged;
  ylm_status made = ylm_radiosity_averaged(r, threads, &averaged);
  if (made != YLM_OK || r->aimed || !r->guided) return made;
  size_t step = t->elements / TARGETS_ELEMENTS + 1, all = t->elements / step + 1, n = 0;
  float(*x)[3] = ylm_alloc(2 * all, sizeof *x);
  ylm_transfer_targets *a;
  if (!x) return YLM_ENOMEM;
  for (size_t i = 0; i < t->elements; i += step) {
    if (!(t->share[i] > 0)) continue;
    ylm_scene_ray_origin(t->scene, t->centre[i], t->normal[i], x[n]);
    memcpy(x[all + n++], t->normal[i], 12);
  }
  ylm_scene_places places = {n, (const float(*)[3])x, (const float(*)[3])(x + all),
                             (const float(*)[3])x};
  ylm_status s =
      create(t, r->leaving, &places, TARGETS_WORTH_ELEMENTS, t->form.seed, threads, progress, &a);
  ylm_free(x);
  r->targets = a;
  r->aimed = s == YLM_OK;
  return s;
}
