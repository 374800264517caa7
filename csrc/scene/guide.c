/*
** guide.c - which lamps and tiles of the sky are seen from where: clusters of places, each with a pilot of rays.
*/
#include <math.h>
#include <string.h>

#include "scene.h"
#include "ylm_random.h"

struct ylm_scene_guide {
  size_t width, cells; /* lamps, and cells of the sky */
  ylm_scene_clusters *of;
  float *row; /* [clusters][2 width + cells] factors of weights, spreads, factors of cells */
  ylm_scene_guide_stats stats;
};

void ylm_scene_guide_free(ylm_scene_guide *g) {
  if (!g) return;
  ylm_scene_clusters_free(g->of);
  ylm_free(g->row);
  ylm_free(g);
}

void ylm_scene_guide_look(const ylm_scene_guide *g, ylm_scene_guide_stats *stats) {
  *stats = g->stats;
}

bool ylm_scene_chooser_follow(ylm_scene_chooser *c, const ylm_scene_guide *g) {
  bool fits =
      !g || (g->width == c->chunks * YLM_LAMP_CHUNK && g->cells == ylm__scene_sky_cells(c->scene));
  c->guide = fits ? g : NULL;
  return fits;
}

static size_t row_of(const ylm_scene_guide *g, size_t cluster) {
  return cluster * (2 * g->width + g->cells);
}

/* Weights of n lamps of a chunk, times these factors; their sum. Weights behind them are 0. */
static double weigh_chunk(size_t n, float *weight, const float *factor) {
  enum { LANES = 8 };
  double lane[LANES] = {0}, sum = 0;
  for (size_t i = 0; i < n; i += LANES)
    for (size_t k = 0; k < LANES; k++) {
      weight[i + k] *= factor[i + k];
      lane[k] += (double)weight[i + k];
    }
  for (size_t k = 0; k < LANES; k++) sum += lane[k];
  return sum;
}

/* Weighs all lamps by a row. */
static const float *weigh(ylm_scene_chooser *c, const float *factor) {
  c->total = 0;
  for (int k = 0; k < SCENE_STORAGES; k++) {
    size_t left = ylm__scene_storage[k]->count(c->scene);
    for (size_t b = c->chunk[k]; b < c->chunk[k + 1]; b++) {
      size_t first = b * YLM_LAMP_CHUNK, n = left < YLM_LAMP_CHUNK ? left : YLM_LAMP_CHUNK;
      c->sum[b] = (float)weigh_chunk(n, c->weight + first, factor + first);
      c->total += (double)c->sum[b];
      left -= n;
    }
  }
  return factor;
}

const float *ylm__scene_guide_weights(ylm_scene_chooser *c) {
  const ylm_scene_guide *g = c->guide;
  return weigh(c, g->row + row_of(g, ylm_scene_cluster_at(g->of, c->x, c->normal)));
}

void ylm__scene_guide_ahead(ylm_scene_chooser *c, size_t n, const float (*x)[3],
                            const float (*normal)[3]) {
  const ylm_scene_guide *g = c->guide;
  uint32_t cluster[YLM_SCENE_AHEAD];
  ylm_scene_clusters_at(g->of, n, x, normal, cluster);
  for (size_t k = 0; k < n; k++) {
    c->row[k] = g->row + row_of(g, cluster[k]);
    for (int s = 0; s < SCENE_STORAGES; s++)
      if (c->chunk[s + 1] > c->chunk[s])
        __builtin_prefetch(c->row[k] + c->chunk[s] * YLM_LAMP_CHUNK);
  }
}

void ylm__scene_guide_weights_ahead(ylm_scene_chooser *c, size_t k) { weigh(c, c->row[k]); }

/* A guide that is made. */
typedef struct building {
  const ylm_scene *scene;
  const ylm_scene_places *places;
  ylm_scene_guide *g;
  float *tally; /* [clusters][3 width + 2 cells] */
  size_t tiles; /* the place of the first tile of the sky in the list of lamps */
  uint64_t seed;
  atomic_uint_fast64_t rays;
} building;

/* -- pilots ---------------------------------------------------------------------------------------- */

/* Sums over the rays to each lamp: their number, what arrived of the lamp's weight, and its square; and to each cell. */
typedef struct tally {
  float *rays, *seen, *square;    /* [width] */
  float *cell_rays, *cell_square; /* [cells] */
} tally;

static size_t tally_size(const ylm_scene_guide *g) { return 3 * g->width + 2 * g->cells; }

static tally tally_in(const ylm_scene_guide *g, float *room) {
  float *cell = room + 3 * g->width;
  return (tally){room, room + g->width, room + 2 * g->width, cell, cell + g->cells};
}

static tally tally_of(const building *b, size_t cluster) {
  return tally_in(b->g, b->tally + cluster * tally_size(b->g));
}

#define PILOT_NO_CELL UINT32_MAX
/* The pilot's rays that wait to be traced. */
typedef struct pilot {
  ylm_scene_batch batch;
  uint32_t place[YLM_SCENE_BATCH], cell[YLM_SCENE_BATCH]; /* PILOT_NO_CELL: none */
  float part[YLM_SCENE_BATCH];
  tally tally;
  float *weight; /* [width] of lamps at the place, as they were before they were evened out */
} pilot;

static void pilot_free(pilot *p) {
  ylm_scene_batch_free(&p->batch);
  ylm_free(p->weight);
}

static ylm_status pilot_create(const ylm_scene *s, size_t width, pilot *p) {
  ylm_status status = ylm_scene_batch_create(s, YLM_SCENE_BATCH, &p->batch);
  p->weight = ylm_alloc(width, sizeof(float));
  return status == YLM_OK && !p->weight ? YLM_ENOMEM : status;
}

static void trace(pilot *p) {
  ylm_scene_batch *b = &p->batch;
  ylm_scene_batch_trace(b);
  for (size_t k = 0; k < b->rays; k++) {
    size_t i = p->place[k];
    if (b->ray[k].far < 0) continue;
    p->tally.seen[i] += p->part[k];
    p->tally.square[i] += p->part[k] * p->part[k];
    if (p->cell[k] != PILOT_NO_CELL) p->tally.cell_square[p->cell[k]] += p->part[k] * p->part[k];
  }
  b->rays = 0;
}

/* Half of the weight of each lamp as it is, half the same for all that may bring light. Their sum is 1. */
static void even_out(ylm_scene_chooser *c) {
  size_t active = 0;
  for (size_t i = 0; i < c->chunks * YLM_LAMP_CHUNK; i++) active += c->weight[i] > 0;
  float scale = (float)(0.5 / c->total), even = (float)(0.5 / (double)active);
  c->total = 0;
  for (size_t b = 0; b < c->chunks; b++) {
    double sum = 0;
    for (size_t i = b * YLM_LAMP_CHUNK; i < (b + 1) * YLM_LAMP_CHUNK; i++) {
      if (c->weight[i] > 0) c->weight[i] = scale * c->weight[i] + even;
      sum += (double)c->weight[i];
    }
    c->sum[b] = (float)sum;
    c->total += (double)c->sum[b];
  }
}

/* A ray from the chooser's point to the lamp at a place in the list. */
static void send(pilot *p, size_t place, const float origin[3], ylm_rng *rng) {
  const ylm_scene_chooser *c = p->batch.lamps;
  size_t k = p->batch.rays, i = ylm__scene_lamp_at(c, place), cell;
  ylm_trace_ray *ray = &p->batch.ray[k];
  int of = ylm__scene_storage_of(c->scene, &i);
  scene_aim to = {.x = c->x, .normal = c->normal, .solid = ylm__scene_solid(c, of, i)};
  float radiance[3];
  to.u[0] = ylm_draw_double(rng);
  to.u[1] = ylm_draw_double(rng);
  double e = ylm__scene_storage[of]->sample(c->scene, i, &to, ray, radiance);
  p->tally.rays[place]++;
  if (!(e > 0)) return;
  double rgb[3] = {(double)radiance[0], (double)radiance[1], (double)radiance[2]};
  p->place[k] = (uint32_t)place;
  p->cell[k] = PILOT_NO_CELL;
  if (of == SCENE_SKY && ylm__scene_sky_cell(c->scene, i, ray->dir, &cell)) {
    p->cell[k] = (uint32_t)cell;
    p->tally.cell_rays[cell]++;
  }
  p->part[k] = (float)fmin(4, e * ylm_luminance_size(rgb) / (YLM_PI * (double)p->weight[place]));
  ylm_scene_start(ray, origin);
  p->batch.rays++;
}

/* The pilot's rays of a place. */
static void look_around(building *b, pilot *p, size_t at, ylm_rng *rng) {
  const ylm_scene_places *from = b->places;
  ylm_scene_chooser *c = p->batch.lamps;
  scene_walk w = {0};
  ylm__scene_turn_to(c, from->lit[at], from->normal[at]);
  if (!(ylm__scene_weigh(c, false, 1) > 0)) return;
  memcpy(p->weight, c->weight, b->g->width * sizeof *p->weight);
  even_out(c);
  if (p->batch.rays + GUIDE_RAYS > p->batch.room) trace(p);
  for (int k = 0; k < GUIDE_RAYS; k++) {
    ylm__scene_walk_to(&w, c, (k + ylm_draw_double(rng)) / GUIDE_RAYS * c->total);
    if (p->weight[w.lamp] > 0) send(p, w.lamp, from->origin[at], rng);
  }
}

static ylm_status learn(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  building *b = context;
  pilot p = {.batch = {0}};
  ylm_status s = pilot_create(b->scene, b->g->width, &p);
  for (size_t i = begin; s == YLM_OK && i < end; i++) {
    size_t n;
    const uint32_t *place = ylm_scene_cluster_places(b->g->of, i, 0, &n);
    ylm_rng rng;
    ylm_draw_seed(&rng, b->seed, i);
    p.tally = tally_of(b, i);
    for (size_t k = 0; k < n; k++) look_around(b, &p, place[k], &rng);
    trace(&p);
  }
  atomic_fetch_add_explicit(&b->rays, p.batch.traced, memory_order_relaxed);
  pilot_free(&p);
  return s;
}

/* -- clusters around ------------------------------------------------------------------------------- */

/* Clusters beside one, by what they see. */
typedef struct beside {
  size_t n;
  uint32_t cluster[GUIDE_BESIDE];
  float *room;
  tally sum; /* of theirs, in `room` */
} beside;

/* Half the extent of places along each axis, so that a place that is moved by it may lie in the cluster beside. */
static void reach_of(const building *b, const uint32_t *place, size_t n, float out[3]) {
  for (int k = 0; k < 3; k++) {
    float lo = INFINITY, hi = -INFINITY;
    for (size_t i = 0; i < n; i++) {
      lo = fminf(lo, b->places->lit[place[i]][k]);
      hi = fmaxf(hi, b->places->lit[place[i]][k]);
    }
    out[k] = (hi - lo) / 2;
  }
}

static void meet(beside *x, size_t own, size_t cluster) {
  if (cluster == own || x->n == GUIDE_BESIDE) return;
  for (size_t k = 0; k < x->n; k++)
    if (x->cluster[k] == cluster) return;
  x->cluster[x->n++] = (uint32_t)cluster;
}

/* The clusters beside one: those of some of its places that are moved along the axes. */
static void find_beside(const building *b, size_t own, beside *x) {
  size_t n;
  const uint32_t *place = ylm_scene_cluster_places(b->g->of, own, 0, &n);
  size_t step = n / GUIDE_BESIDE + 1;
  float reach[3];
  reach_of(b, place, n, reach);
  x->n = 0;
  for (size_t i = 0; i < n; i += step)
    for (int k = 0; k < 6; k++) {
      float at[3];
      memcpy(at, b->places->lit[place[i]], sizeof at);
      at[k / 2] += k % 2 ? reach[k / 2] : -reach[k / 2];
      meet(x, own, ylm_scene_cluster_at(b->g->of, at, b->places->normal[place[i]]));
    }
}

/* Sums of what clusters beside one see. */
static void sum_beside(const building *b, size_t own, beside *x) {
  size_t size = tally_size(b->g);
  find_beside(b, own, x);
  memset(x->room, 0, size * sizeof *x->room);
  for (size_t k = 0; k < x->n; k++) {
    const float *from = b->tally + x->cluster[k] * size;
    for (size_t i = 0; i < size; i++) x->room[i] += from[i];
  }
}

/* -- factors --------------------------------------------------------------------------------------- */

/* Rays and squares of a map of the sky, which goes around. */
typedef struct sky_map {
  const float *rays, *square, *rays_beside, *square_beside;
  int across, down;
} sky_map;

/* The mean of what a place of a map and its neighbours see, here and from clusters beside, and a part of a ray that none of
   them has. */
static float around(const sky_map *m, size_t i) {
  int x = (int)i % m->across, y = (int)i / m->across;
  float rays = 1, square = GUIDE_DOUBT;
  for (int v = y > 0 ? y - 1 : 0; v <= y + 1 && v < m->down; v++)
    for (int u = x - 1; u <= x + 1; u++) {
      size_t k = (size_t)(v * m->across + (u + m->across) % m->across);
      rays += m->rays[k] + GUIDE_PART_BESIDE * m->rays_beside[k];
      square += m->square[k] + GUIDE_PART_BESIDE * m->square_beside[k];
    }
  return square / rays;
}

/* The mean square of what place i sees. */
static float mean_square(const sky_map *m, size_t i) {
  return (m->square[i] + around(m, i)) / (m->rays[i] + 1);
}

/* Of tiles: the root of the mean square. */
static void settle_tiles(const building *b, const tally *t, const beside *x, float *row) {
  size_t first = b->tiles;
  for (size_t k = 0; k < b->scene->domes; first += b->scene->dome[k++].lights) {
    const scene_dome *d = &b->scene->dome[k];
    sky_map m = {t->rays + first,       t->square + first, x->sum.rays + first,
                 x->sum.square + first, (int)d->across,    (int)d->down};
    for (size_t i = 0; i < d->lights; i++) row[first + i] = sqrtf(mean_square(&m, i));
  }
}

/* Of their cells: the same, with a least one. */
static void settle_cells(const building *b, const tally *t, const beside *x, float *row) {
  size_t first = 0;
  for (size_t k = 0; k < b->scene->domes; k++) {
    const size_t *n = b->scene->dome[k].cells;
    sky_map m = {t->cell_rays + first,
                 t->cell_square + first,
                 x->sum.cell_rays + first,
                 x->sum.cell_square + first,
                 (int)n[0],
                 (int)n[1]};
    for (size_t i = 0; i < n[0] * n[1]; i++)
      row[first + i] = sqrtf(mean_square(&m, i) + GUIDE_CELL_LEAST);
    first += n[0] * n[1];
  }
}

/* Of lamps: the same, and the standard deviation over it, which is never 0 for certain. */
static void settle_lamp(const tally *t, size_t width, size_t at, float *row) {
  float n = t->rays[at] + 1, mean = (t->seen[at] + GUIDE_LAMP_DOUBT) / n;
  float square = (t->square[at] + GUIDE_LAMP_DOUBT) / n;
  row[at] = sqrtf(square);
  row[width + at] = sqrtf(fmaxf(1 - mean * mean / square, GUIDE_LEAST));
}

static ylm_status settle(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const building *b = context;
  size_t width = b->g->width;
  beside x = {.room = ylm_alloc(tally_size(b->g), sizeof *x.room)};
  if (!x.room) return YLM_ENOMEM;
  x.sum = tally_in(b->g, x.room);
  for (size_t i = begin; i < end; i++) {
    tally t = tally_of(b, i);
    float *row = b->g->row + row_of(b->g, i);
    sum_beside(b, i, &x);
    for (size_t k = 0; k < width; k++) settle_lamp(&t, width, k, row);
    settle_tiles(b, &t, &x, row);
    settle_cells(b, &t, &x, row + 2 * width);
  }
  ylm_free(x.room);
  return YLM_OK;
}

/* -- all of it ------------------------------------------------------------------------------------- */

static ylm_status build(building *b, int threads, const ylm_progress *progress) {
  ylm_scene_guide *g = b->g;
  double most = fmax(GUIDE_PLACES, GUIDE_ROOT * sqrt((double)b->places->n));
  ylm_status s = ylm_scene_clusters_create(b->places, (size_t)most, &g->of);
  if (s != YLM_OK) return s;
  size_t clusters = ylm_scene_clusters_count(g->of);
  g->row = ylm_alloc(row_of(g, clusters), sizeof *g->row);
  b->tally = ylm_alloc_zero(clusters, tally_size(g) * sizeof *b->tally);
  if (!g->row || !b->tally) s = YLM_ENOMEM;
  if (s == YLM_OK) s = ylm_parallel(clusters, 1, threads, learn, b, progress, "guides");
  if (s == YLM_OK) s = ylm_parallel(clusters, 1, threads, settle, b, NULL, NULL);
  ylm_free(b->tally);
  ylm_scene_clusters_forget(g->of);
  return s;
}

/* Of all places as many as the pilot has rays for. */
static ylm_status thin(const ylm_scene_places *all, int light_samples, ylm_scene_places *out,
                       float (**room)[3]) {
  size_t step = (size_t)(GUIDE_RAYS * GUIDE_PART / light_samples);
  if (step < 1) step = 1;
  size_t n = (all->n + step - 1) / step;
  float(*x)[3] = *room = ylm_alloc(3 * n, sizeof **room);
  if (!x) return YLM_ENOMEM;
  for (size_t i = 0; i < n; i++) {
    memcpy(x[i], all->lit[i * step], 12);
    memcpy(x[n + i], all->normal[i * step], 12);
    memcpy(x[2 * n + i], all->origin[i * step], 12);
  }
  *out = (ylm_scene_places){n, (const float(*)[3])x, (const float(*)[3])(x + n),
                            (const float(*)[3])(x + 2 * n)};
  return YLM_OK;
}

bool ylm_scene_guides(const ylm_scene *s) { return !s->tree && ylm_scene_lamps_all(s) >= 2; }

ylm_status ylm_scene_guide_create(const ylm_scene *s, const ylm_scene_places *all,
                                  int light_samples, uint64_t seed, int threads,
                                  const ylm_progress *progress, ylm_scene_guide **out) {
  double start = ylm_seconds();
  *out = NULL;
  if (all->n == 0 || !ylm_scene_guides(s)) return YLM_OK;
  ylm_scene_places places;
  float(*room)[3] = NULL;
  building b = {.scene = s, .places = &places, .seed = ylm_mix64(seed ^ 0x6775696465u)};
  ylm_scene_chooser *c = ylm_scene_chooser_create(s);
  b.g = ylm_alloc_zero(1, sizeof *b.g);
  ylm_status status = c && b.g ? thin(all, light_samples, &places, &room) : YLM_ENOMEM;
  if (status == YLM_OK) {
    b.g->width = c->chunks * YLM_LAMP_CHUNK;
    b.g->cells = ylm__scene_sky_cells(s);
    b.tiles = c->chunk[SCENE_SKY] * YLM_LAMP_CHUNK;
    status = build(&b, threads, progress);
  }
  ylm_scene_chooser_free(c);
  ylm_free(room);
  if (status != YLM_OK) {
    ylm_scene_guide_free(b.g);
    return status;
  }
  b.g->stats =
      (ylm_scene_guide_stats){ylm_scene_clusters_count(b.g->of), b.rays, ylm_seconds() - start};
  *out = b.g;
  return YLM_OK;
}
