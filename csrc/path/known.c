/*
** known.c - what a pilot of paths learnt about reflected light: irradiance of clusters of places, and where it comes from.
**
** The pilot's paths, as cosines choose directions, are samples of form factors: irradiance of n reflections is a mean over
** paths of that of n - 1 where they arrive, times the albedo there, as radiosity is.
**
** Source   Mueller et al. 2017, "Practical Path Guiding for Efficient Light-Transport Simulation"; Vorba & Krivanek 2016,
**          "Adjoint-Driven Russian Roulette and Splitting in Light Transport Simulation"
*/
#include <math.h>
#include <stdatomic.h>

#include "calibration.h"
#include "path.h"

/* Random numbers of rays to lamps. */
#define KNOWN_SEED 0x6b6e6f776eu
/* Cells of directions: of the square around the disk that directions above a surface cast on its plane. */
#define CELLS (KNOWN_SIDE * KNOWN_SIDE)

/* The directions of a cluster's light. */
typedef struct directions {
  float frame[3][3]; /* the third is the normal */
  float unused[7];   /* what follows begins lines of the cache */
  float row[KNOWN_SIDE];
  float below[CELLS]; /* the chance of the cells before each; row: that of the first of each row */
} directions;

struct path_known {
  ylm_scene_clusters *of;
  float (*sum)[KNOWN_ORDERS + 1][3]; /* [clusters] irradiance of at most so many reflections */
  directions *from;                  /* [clusters] */
};

/* Knowledge as it is learnt. */
typedef struct learning {
  const path_job *job;
  const path_places *places;
  path_known *known;
  size_t clusters;
  uint32_t *cluster;   /* [places] */
  float (*direct)[3];  /* [places] irradiance straight from lamps, by one ray */
  float (*mean)[3];    /* [clusters] of it */
  float *brightness;   /* [places] luminance that arrives from there, relative */
  float inside[CELLS]; /* parts of cells that are in the disk */
  atomic_uint_fast64_t rays;
} learning;

void ylm__path_known_free(path_known *k) {
  if (!k) return;
  ylm_scene_clusters_free(k->of);
  ylm_free(k->sum);
  ylm_free(k->from);
  ylm_free(k);
}

uint32_t ylm__path_cluster(const path_known *k, const float x[3], const float normal[3]) {
  return k ? (uint32_t)ylm_scene_cluster_at(k->of, x, normal) : (uint32_t)PATH_UNKNOWN;
}

void ylm__path_clusters_at(const path_known *k, size_t n, const float (*x)[3],
                           const float (*normal)[3], uint32_t *cluster) {
  ylm_scene_clusters_at(k->of, n, x, normal, cluster);
  for (size_t i = 0; i < n; i++) {
    __builtin_prefetch(k->sum[cluster[i]][0]);
    __builtin_prefetch(k->sum[cluster[i]][KNOWN_ORDERS]);
  }
}

size_t ylm__path_clusters(const path_known *k) { return ylm_scene_clusters_count(k->of); }

static int at_most(int n) { return n < 0 ? 0 : n > KNOWN_ORDERS ? KNOWN_ORDERS : n; }

void ylm__path_expected(const path_job *j, uint32_t cluster, int order, float irradiance[3]) {
  const ylm_path_options *o = j->o;
  int last = o->last < 0 ? KNOWN_ORDERS : at_most(o->last - order);
  int first = at_most(o->first - order - 1);
  const float(*sum)[3] = (const float(*)[3])j->known->sum[cluster];
  for (int c = 0; c < 3; c++) irradiance[c] = fmaxf(0, sum[last][c] - sum[first][c]);
}

/* -- directions ------------------------------------------------------------------------------------ */

/* The cell of a direction, and its cosine; false: it is below the surface. */
static bool cell_of(const directions *d, const float w[3], size_t *cell, float *cosine) {
  float x = ylm_dot3(w, d->frame[0]), y = ylm_dot3(w, d->frame[1]);
  *cosine = ylm_dot3(w, d->frame[2]);
  if (!(*cosine > 0)) return false;
  int a = (int)((x + 1) * (0.5f * KNOWN_SIDE)), b = (int)((y + 1) * (0.5f * KNOWN_SIDE));
  a = a < 0 ? 0 : a < KNOWN_SIDE ? a : KNOWN_SIDE - 1;
  b = b < 0 ? 0 : b < KNOWN_SIDE ? b : KNOWN_SIDE - 1;
  *cell = (size_t)(b * KNOWN_SIDE + a);
  return true;
}

/* The chance of a cell. */
static float chance(const directions *d, size_t cell) {
  return (cell + 1 < CELLS ? d->below[cell + 1] : 1) - d->below[cell];
}

float ylm__path_guided_density(const path_known *k, uint32_t cluster, const float direction[3]) {
  const directions *d = &k->from[cluster];
  size_t cell;
  float cosine;
  if (!cell_of(d, direction, &cell, &cosine)) return 0;
  return chance(d, cell) * cosine * (0.25f * CELLS);
}

void ylm__path_density_ahead(const path_known *k, uint32_t cluster, const float direction[3]) {
  const directions *d = &k->from[cluster];
  size_t cell;
  float cosine;
  if (cell_of(d, direction, &cell, &cosine)) __builtin_prefetch(&d->below[cell]);
}

void ylm__path_guide_ahead(const path_known *k, uint32_t cluster) {
  __builtin_prefetch(k->from[cluster].frame);
  __builtin_prefetch(k->from[cluster].row);
}

/* The last of these, which do not fall, that is no more than u; the first is 0, but of light that overflows no number. */
static size_t last_of(const float from[KNOWN_SIDE], float u) {
  int n = 0;
  for (int i = 0; i < KNOWN_SIDE; i++) n += from[i] <= u;
  return n > 1 ? (size_t)n - 1 : 0;
}

void ylm__path_guided_ahead(const path_known *k, uint32_t cluster, const float u[2]) {
  const directions *d = &k->from[cluster];
  __builtin_prefetch(&d->below[last_of(d->row, u[0]) * KNOWN_SIDE]);
}

bool ylm__path_guided(const path_known *k, uint32_t cluster, const float u[2], float direction[3]) {
  const directions *d = &k->from[cluster];
  size_t cell = last_of(d->row, u[0]) * KNOWN_SIDE;
  cell += last_of(&d->below[cell], u[0]);
  float within = (u[0] - d->below[cell]) / chance(d, cell);
  float x = ((float)(cell % KNOWN_SIDE) + within) * (2.0f / KNOWN_SIDE) - 1;
  float y = ((float)(cell / KNOWN_SIDE) + u[1]) * (2.0f / KNOWN_SIDE) - 1;
  float square = 1 - x * x - y * y;
  if (!(square > 0)) return false;
  for (int a = 0; a < 3; a++)
    direction[a] = x * d->frame[0][a] + y * d->frame[1][a] + sqrtf(square) * d->frame[2][a];
  return true;
}

/* The parts of cells that are in the disk. */
static void measure_disk(float inside[CELLS]) {
  enum { FINE = 16 };
  for (int cell = 0; cell < CELLS; cell++) {
    int n = 0;
    for (int k = 0; k < FINE * FINE; k++) {
      double x = (cell % KNOWN_SIDE + (k % FINE + 0.5) / FINE) * 2.0 / KNOWN_SIDE - 1;
      double y = (cell / KNOWN_SIDE + (k / FINE + 0.5) / FINE) * 2.0 / KNOWN_SIDE - 1;
      n += x * x + y * y < 1;
    }
    inside[cell] = (float)n / (FINE * FINE);
  }
}

/* Squared radiance in cells, and how many paths found it. */
typedef struct tally {
  float square[CELLS], paths[CELLS];
  double squares, all;
} tally;

/* The luminance that arrives from each place that a path of the pilot reached, times a power of 2, so that its squares are numbers. */
static void brighten(const learning *l) {
  const ylm_path_options *o = l->job->o;
  int last = o->last < 0 ? KNOWN_ORDERS : at_most(o->last - 2), exponent = 0;
  float most = 0;
  for (size_t i = 0; i < l->places->n; i++) {
    uint32_t cluster = l->cluster[i];
    float sum[3];
    for (int c = 0; c < 3; c++)
      sum[c] = l->places->albedo[i][c] *
               (0.5f * (l->direct[i][c] + l->mean[cluster][c]) + l->known->sum[cluster][last][c]);
    l->brightness[i] = ylm__path_luminance(sum);
    if (l->brightness[i] > most) most = l->brightness[i];
  }
  if (isfinite(most)) (void)frexpf(most, &exponent);
  for (size_t i = 0; i < l->places->n; i++) l->brightness[i] = ldexpf(l->brightness[i], -exponent);
}

/* Adds what the pilot's path from a place found, as it is seen from x. */
static void see(const learning *l, const directions *d, uint32_t from, const float x[3], tally *t) {
  const path_places *p = l->places;
  uint32_t to = p->next[from];
  float w[3], light = 0, cosine;
  size_t cell;
  if (to == PATH_UNKNOWN) return;
  memcpy(w, p->direction[from], sizeof w);
  if (to != PATH_NOWHERE) {
    for (int a = 0; a < 3; a++) w[a] = p->x[to][a] - x[a];
    float length = sqrtf(ylm_dot3(w, w));
    if (!(length > 0) || ylm_dot3(w, p->normal[to]) > 0) return;
    for (int a = 0; a < 3; a++) w[a] /= length;
    light = l->brightness[to];
  }
  if (!cell_of(d, w, &cell, &cosine)) return;
  t->square[cell] += light * light;
  t->paths[cell]++;
  t->squares += (double)(light * light);
  t->all++;
}

/* The mean of the squares in a cell and those around it, and a bit of that of all. */
static float around(const tally *t, int cell) {
  int x = cell % KNOWN_SIDE, y = cell / KNOWN_SIDE;
  float square = KNOWN_DOUBT * (float)(t->squares / t->all), paths = KNOWN_DOUBT;
  for (int v = y > 0 ? y - 1 : 0; v <= y + 1 && v < KNOWN_SIDE; v++)
    for (int u = x > 0 ? x - 1 : 0; u <= x + 1 && u < KNOWN_SIDE; u++) {
      square += t->square[v * KNOWN_SIDE + u];
      paths += t->paths[v * KNOWN_SIDE + u];
    }
  return square / paths;
}

/* Chances of cells: as the root of the mean square of what arrives there. */
static void settle(const learning *l, const tally *t, directions *d) {
  double sum = 0;
  float part[CELLS];
  for (int i = 0; i < CELLS; i++) {
    part[i] = l->inside[i];
    if (t->squares > 0) part[i] *= sqrtf((t->square[i] + around(t, i)) / (t->paths[i] + 1));
    sum += (double)part[i];
  }
  double below = 0;
  for (int i = 0; i < CELLS; i++) {
    d->below[i] = (float)(below / sum);
    below += (double)part[i];
  }
  for (int i = 0; i < KNOWN_SIDE; i++) d->row[i] = d->below[i * KNOWN_SIDE];
}

/* The frame of the cluster's mean normal. */
static void turn(const learning *l, const uint32_t *place, size_t n, directions *d) {
  double mean[3] = {0};
  for (size_t k = 0; k < n; k++)
    for (int a = 0; a < 3; a++) mean[a] += (double)l->places->normal[place[k]][a];
  ylm_unit3(mean);
  for (int a = 0; a < 3; a++) d->frame[2][a] = (float)mean[a];
  ylm_scene_basis(d->frame[2], d->frame[0], d->frame[1]);
}

static ylm_status learn_directions(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  learning *l = context;
  for (size_t i = begin; i < end; i++) {
    size_t n, wide;
    const uint32_t *own = ylm_scene_cluster_places(l->known->of, i, 0, &n);
    const uint32_t *near = ylm_scene_cluster_places(l->known->of, i, KNOWN_PATHS, &wide);
    tally t = {{0}, {0}, 0, 0};
    turn(l, own, n, &l->known->from[i]);
    for (size_t k = 0; k < wide; k++)
      see(l, &l->known->from[i], near[k], l->places->x[own[k % n]], &t);
    settle(l, &t, &l->known->from[i]);
  }
  return YLM_OK;
}

/* -- irradiance ------------------------------------------------------------------------------------ */

/* One ray of each place to a lamp. */
static ylm_status light(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  learning *l = context;
  const path_places *p = l->places;
  uint32_t of[YLM_SCENE_BATCH];
  ylm_scene_batch b;
  ylm_status s = ylm_scene_batch_create(l->job->scene, YLM_SCENE_BATCH, &b);
  if (s == YLM_OK && !ylm_scene_chooser_follow(b.lamps, l->job->guide)) s = YLM_EINVAL;
  for (size_t i = begin; s == YLM_OK && i < end; i++) {
    ylm_rng rng;
    size_t had = b.rays;
    ylm_rng_seed(&rng, ylm_mix64(l->job->o->seed ^ KNOWN_SEED), i);
    ylm_scene_batch_aim(&b, p->x[i], p->normal[i], p->origin[i], 1, &rng);
    for (size_t k = had; k < b.rays; k++) of[k] = (uint32_t)i;
    if (b.rays < YLM_SCENE_BATCH && i + 1 < end) continue;
    ylm_scene_batch_trace(&b);
    for (size_t k = 0; k < b.rays; k++)
      for (int c = 0; c < 3 && !(b.ray[k].far < 0); c++) l->direct[of[k]][c] += b.value[k][c];
    b.rays = 0;
  }
  atomic_fetch_add_explicit(&l->rays, b.traced, memory_order_relaxed);
  ylm_scene_batch_free(&b);
  return s;
}

/* The mean over places of a cluster of what light of n - 1 reflections brings there by one more; n = 0: straight from lamps. */
static void average(const learning *l, size_t cluster, int n, float out[3]) {
  const path_places *p = l->places;
  size_t places, paths = 0;
  const uint32_t *place = ylm_scene_cluster_places(l->known->of, cluster, KNOWN_LEAST, &places);
  double sum[3] = {0};
  for (size_t k = 0; k < places; k++) {
    uint32_t i = place[k], to = p->next[i];
    if (n > 0 && (to == PATH_UNKNOWN || !p->cosine[i])) continue;
    paths++;
    if (n > 0 && to == PATH_NOWHERE) continue;
    const float(*of)[3] = l->known->sum[n > 1 ? l->cluster[to] : 0];
    for (int c = 0; c < 3; c++)
      sum[c] += n == 0   ? (double)l->direct[i][c]
                : n == 1 ? (double)(p->albedo[to][c] * l->direct[to][c])
                         : (double)(p->albedo[to][c] * (of[n - 1][c] - of[n - 2][c]));
  }
  for (int c = 0; c < 3; c++) out[c] = paths > 0 ? (float)(sum[c] / (double)paths) : 0;
}

/* The last sum has all that follow: as if each reflection brought the same part of the one before. */
#define REST_RATIO 0.9f
static void add_rest(float sum[KNOWN_ORDERS + 1][3]) {
  for (int c = 0; c < 3; c++) {
    float last = sum[KNOWN_ORDERS][c] - sum[KNOWN_ORDERS - 1][c];
    float before = sum[KNOWN_ORDERS - 1][c] - sum[KNOWN_ORDERS - 2][c];
    float ratio = before > 0 ? fminf(REST_RATIO, fmaxf(0, last / before)) : 0;
    sum[KNOWN_ORDERS][c] += last * ratio / (1 - ratio);
  }
}

static void solve(learning *l) {
  for (size_t i = 0; i < l->clusters; i++) {
    average(l, i, 0, l->mean[i]);
    memset(l->known->sum[i][0], 0, 12);
  }
  for (int n = 1; n <= KNOWN_ORDERS; n++)
    for (size_t i = 0; i < l->clusters; i++) {
      float more[3];
      average(l, i, n, more);
      for (int c = 0; c < 3; c++) l->known->sum[i][n][c] = l->known->sum[i][n - 1][c] + more[c];
    }
  for (size_t i = 0; i < l->clusters; i++) add_rest(l->known->sum[i]);
}

static ylm_status learn(learning *l) {
  const path_job *j = l->job;
  const ylm_path_options *o = j->o;
  size_t n = l->places->n;
  path_known *k = l->known;
  ylm_scene_places places = {n, (const float(*)[3])l->places->x,
                             (const float(*)[3])l->places->normal,
                             (const float(*)[3])l->places->origin};
  ylm_status s = ylm_scene_clusters_create(&places, KNOWN_PLACES, &k->of);
  if (s != YLM_OK) return s;
  l->clusters = ylm_scene_clusters_count(k->of);
  l->cluster = ylm_alloc(n, sizeof *l->cluster);
  l->direct = ylm_alloc_zero(n, sizeof *l->direct);
  l->brightness = ylm_alloc(n, sizeof *l->brightness);
  l->mean = ylm_alloc(l->clusters, sizeof *l->mean);
  k->sum = ylm_alloc(l->clusters, sizeof *k->sum);
  k->from = ylm_alloc(l->clusters, sizeof *k->from);
  if (!l->cluster || !l->direct || !l->brightness || !l->mean || !k->sum || !k->from)
    return YLM_ENOMEM;
  for (size_t i = 0; i < l->clusters; i++) {
    size_t own;
    const uint32_t *place = ylm_scene_cluster_places(k->of, i, 0, &own);
    for (size_t m = 0; m < own; m++) l->cluster[place[m]] = (uint32_t)i;
  }
  s = ylm_parallel(n, 8192, o->threads, light, l, o->progress, "guides");
  if (s != YLM_OK) return s;
  solve(l);
  brighten(l);
  measure_disk(l->inside);
  s = ylm_parallel(l->clusters, 16, o->threads, learn_directions, l, o->progress, "guides");
  ylm_scene_clusters_forget(k->of);
  return s;
}

ylm_status ylm__path_know(path_job *j, const path_places *places, ylm_path_stats *stats) {
  if (places->n == 0) return YLM_OK;
  learning l = {.job = j, .places = places, .known = ylm_alloc_zero(1, sizeof(path_known))};
  ylm_status s = l.known ? learn(&l) : YLM_ENOMEM;
  stats->guide_rays += l.rays;
  ylm_free(l.cluster);
  ylm_free(l.direct);
  ylm_free(l.brightness);
  ylm_free(l.mean);
  if (s == YLM_OK)
    j->known = l.known;
  else
    ylm__path_known_free(l.known);
  return s;
}
