/* tile.c - the memory of one thread, random numbers of its paths, and places that rays hit. */
#include "path.h"

/* Streams of random numbers: of batches, and of what paths ask for behind them. */
#define BATCHES 0x62617463686573u
#define PATHS 0x7061746873u
/* A pair's number: its batch in the low bits. */
#define BATCH_BITS 24
/* Vertices whose surfaces are looked at in one go. */
#define VERTICES 64
/* How far below the horizon of a normal of vertices the eye may be. */
#define LEAST_COSINE 1e-4f

/* Makes room for n elements at `p`. */
#define ROOM(p, n) ((p) = ylm_alloc((n), sizeof *(p)), (p) != NULL)

static bool room(path_tile *t) {
  size_t n = PATH_TILE;
  size_t count = (size_t)(t->job->lmax + 1) * (size_t)(t->job->lmax + 1);
  path_rays *r = &t->rays;
  path_lights *l = &t->lights;
  return ROOM(t->item, PATH_PAIRS) && ROOM(t->batch, PATH_PAIRS) && ROOM(t->path, n) &&
         ROOM(t->vertex, n) && ROOM(t->behind, t->job->materials) && ROOM(t->wo, n) &&
         ROOM(t->u, n) && ROOM(t->wi, n) && ROOM(t->weight, n) && ROOM(t->pdf, n) &&
         ROOM(r->ray, n) && ROOM(r->way, n) && ROOM(r->hit, n) && ROOM(r->of, n) &&
         ROOM(r->lit, n) && ROOM(l->ray, n) && ROOM(l->radiance, n) && ROOM(l->density, n) &&
         ROOM(l->wi, n) && ROOM(l->wo, n) && ROOM(l->f, n) && ROOM(l->pdf, n) && ROOM(l->of, n) &&
         ROOM(l->toward, n) && ROOM(t->way, n) && ROOM(t->f, n) && ROOM(t->own, n) &&
         ROOM(t->cluster, n) && ROOM(t->chance, n) && ROOM(t->ends, n) &&
         (!t->job->points || (ROOM(t->toward, n) && ROOM(t->straight, n) && ROOM(t->first, n) &&
                              ROOM(t->basis, 2 * YLM_PATH_BATCH * count)));
}

path_tile *ylm__path_tile_create(const path_job *j) {
  path_tile *t = ylm_alloc_zero(1, sizeof *t);
  if (!t) return NULL;
  t->job = j;
  t->lamps = ylm_scene_chooser_create(j->scene);
  if (t->lamps && ylm_scene_chooser_follow(t->lamps, j->guide) && room(t)) return t;
  ylm__path_tile_free(t);
  return NULL;
}

void ylm__path_tile_free(path_tile *t) {
  if (!t) return;
  void *all[] = {t->item,
                 t->batch,
                 t->path,
                 t->vertex,
                 t->behind,
                 t->wo,
                 t->u,
                 t->wi,
                 t->weight,
                 t->pdf,
                 t->rays.ray,
                 t->rays.way,
                 t->rays.hit,
                 t->rays.of,
                 t->rays.lit,
                 t->lights.ray,
                 t->lights.radiance,
                 t->lights.density,
                 t->lights.wi,
                 t->lights.wo,
                 t->lights.f,
                 t->lights.pdf,
                 t->lights.of,
                 t->toward,
                 t->straight,
                 t->first,
                 t->basis,
                 t->lights.toward,
                 t->way,
                 t->f,
                 t->own,
                 t->cluster,
                 t->chance,
                 t->ends};
  for (size_t i = 0; i < sizeof all / sizeof *all; i++) ylm_free(all[i]);
  ylm_scene_chooser_free(t->lamps);
  ylm_free(t);
}

/* -- random numbers ---------------------------------------------------------------- */

static void seed(ylm_rng *r, uint64_t seed_of_all, uint64_t kind, uint64_t number) {
  ylm_rng_seed(r, ylm_mix64(seed_of_all ^ ylm_mix64(number + kind)), number);
}

static double wrap(double x) { return x - floor(x); }

/* A random order of the batch's samples. */
static void shuffle(ylm_rng *r, int order[YLM_PATH_BATCH]) {
  for (int i = 0; i < YLM_PATH_BATCH; i++) order[i] = i;
  for (int i = YLM_PATH_BATCH - 1; i > 0; i--) {
    int k = (int)(((uint64_t)ylm_draw_u32(r) * (uint64_t)(i + 1)) >> 32), swapped = order[i];
    order[i] = order[k];
    order[k] = swapped;
  }
}

/* Sample i's stratum of the batch in one dimension, and in two: a Hammersley set, shifted. */
static double one(const int *order, int i, ylm_rng *r) {
  return (order[i] + ylm__path_random(r)) / YLM_PATH_BATCH;
}
static void two(const path_job *j, const int *order, int i, const double shift[2], double out[2]) {
  out[0] = wrap((double)order[i] / YLM_PATH_BATCH + shift[0]);
  out[1] = wrap(j->radical[order[i]] + shift[1]);
}

static void seed_batch(path_tile *t, size_t k) {
  uint64_t number = t->item[k] << BATCH_BITS | t->batch[k];
  int order[5][YLM_PATH_BATCH];
  double shift[3][2];
  ylm_rng rng;
  seed(&rng, t->job->o->seed, BATCHES, number);
  for (int s = 0; s < 5; s++) shuffle(&rng, order[s]);
  for (int s = 0; s < 3; s++)
    for (int a = 0; a < 2; a++) shift[s][a] = ylm__path_random(&rng);
  for (int i = 0; i < YLM_PATH_BATCH; i++) {
    path_state *p = &t->path[k * YLM_PATH_BATCH + (size_t)i];
    two(t->job, order[0], i, shift[0], p->pixel);
    p->light[0] = one(order[1], i, &rng);
    two(t->job, order[2], i, shift[1], p->light + 1);
    two(t->job, order[3], i, shift[2], p->chosen);
    p->chosen[2] = one(order[4], i, &rng);
    p->usual = 0;
    p->noted = PATH_UNKNOWN;
    seed(&p->rng, t->job->o->seed, PATHS, number * YLM_PATH_BATCH + (uint64_t)i);
  }
}

void ylm__path_tile_seed(path_tile *t) {
  for (size_t k = 0; k < t->pairs; k++) seed_batch(t, k);
}

/* -- places ---------------------------------------------------------------------------- */

/* Where light goes that follows ray d backwards, in the vertex's frame. Normals of vertices may turn
   away from the eye: what they describe is then seen along the horizon. */
static void toward_eye(const path_vertex *v, const float d[3], float wo[3]) {
  float back[3], length;
  for (int a = 0; a < 3; a++) back[a] = -d[a];
  ylm__path_inward(v, back, wo);
  length = sqrtf(ylm_dot3(wo, wo));
  for (int a = 0; a < 3; a++) wo[a] /= length;
  if (wo[2] >= LEAST_COSINE) return;
  wo[2] = LEAST_COSINE;
  length = sqrtf(ylm_dot3(wo, wo));
  for (int a = 0; a < 3; a++) wo[a] /= length;
}

/* Where ray i hit a surface. */
static ylm_scene_place place_of(const path_rays *r, size_t i) {
  const ylm_trace_hit *h = &r->hit[i];
  bool back = ylm_dot3(h->normal, r->ray[i].dir) > 0;
  return (ylm_scene_place){(uint32_t)h->mesh, h->element, h->u, h->v, back};
}

/* The vertex there. */
static void put_vertex(path_tile *t, size_t i, const ylm_scene_surface *at) {
  uint32_t material = t->job->material_of[t->rays.hit[i].mesh], k = t->behind[material]++;
  path_vertex *v = &t->vertex[k];
  const float *n = at->normal, *x = at->tangent;
  v->at = *at;
  v->path = t->rays.of[i];
  v->material = material;
  for (int c = 0; c < 3; c++) t->path[v->path].throughput[c] *= v->at.tint[c];
  for (int a = 0; a < 3; a++)
    v->other[a] = n[(a + 1) % 3] * x[(a + 2) % 3] - n[(a + 2) % 3] * x[(a + 1) % 3];
  toward_eye(v, t->rays.ray[i].dir, t->wo[k]);
}

void ylm__path_tile_vertices(path_tile *t) {
  const path_job *j = t->job;
  const path_rays *r = &t->rays;
  t->n = 0;
  memset(t->behind, 0, j->materials * sizeof *t->behind);
  for (size_t i = 0; i < r->n; i++)
    if (r->hit[i].mesh >= 0) t->behind[j->material_of[r->hit[i].mesh]]++;
  for (size_t m = 0; m < j->materials; m++) {
    uint32_t count = t->behind[m];
    t->behind[m] = (uint32_t)t->n;
    t->n += count;
  }
  for (size_t i = 0, n; i < r->n;) {
    uint32_t ray[VERTICES];
    ylm_scene_place place[VERTICES];
    ylm_scene_surface at[VERTICES];
    for (n = 0; n < VERTICES && i < r->n; i++) {
      if (r->hit[i].mesh < 0) continue;
      ray[n] = (uint32_t)i;
      place[n++] = place_of(r, i);
    }
    ylm_scene_surfaces(j->scene, n, place, at);
    for (size_t k = 0; k < n; k++) put_vertex(t, ray[k], &at[k]);
  }
}
