/* guide.c - which lamps and tiles of the sky paths see from where: a pilot of paths without light, and the guide that is
   learnt from the places at which they are reflected. */
#include <stdatomic.h>

#include "path.h"

/* Random numbers of the pilot. */
#define PILOT_SEED 0x70696c6f74u

static void places_free(path_places *p) {
  void *all[] = {p->x, p->normal, p->origin, p->albedo, p->direction, p->next, p->cosine};
  for (size_t i = 0; i < sizeof all / sizeof *all; i++) ylm_free(all[i]);
}

static bool places_create(path_places *p, size_t room) {
  p->room = room;
  p->x = ylm_alloc(room, sizeof *p->x);
  p->normal = ylm_alloc(room, sizeof *p->normal);
  p->origin = ylm_alloc(room, sizeof *p->origin);
  p->albedo = ylm_alloc(room, sizeof *p->albedo);
  p->direction = ylm_alloc(room, sizeof *p->direction);
  p->next = ylm_alloc(room, sizeof *p->next);
  p->cosine = ylm_alloc(room, sizeof *p->cosine);
  return p->x && p->normal && p->origin && p->albedo && p->direction && p->next && p->cosine;
}

/* A pilot of paths from a part of the items. */
typedef struct pilot {
  const path_job *job;
  size_t pairs, items; /* the former are spread evenly over the latter */
  path_places *noted;  /* [tiles] */
  atomic_uint_fast64_t rays;
} pilot;

/* Lets the paths of tiles note their places. */
static ylm_status walk(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  pilot *p = context;
  path_tile *t = ylm__path_tile_create(p->job);
  if (!t) return YLM_ENOMEM;
  ylm_status s = YLM_OK;
  for (size_t i = begin; s == YLM_OK && i < end; i++) {
    t->noted = &p->noted[i];
    for (t->pairs = 0; t->pairs < PATH_PAIRS && i * PATH_PAIRS + t->pairs < p->pairs; t->pairs++) {
      double part = (double)(i * PATH_PAIRS + t->pairs) / (double)p->pairs;
      t->item[t->pairs] = (uint64_t)(part * (double)p->items);
      t->batch[t->pairs] = i * PATH_PAIRS + t->pairs;
    }
    if (!places_create(t->noted, t->pairs * YLM_PATH_BATCH * PILOT_PLACES)) s = YLM_ENOMEM;
    if (s == YLM_OK) ylm__path_walk(t, NULL);
  }
  atomic_fetch_add_explicit(&p->rays,
                            t->counts.nearest_rays + t->counts.lamp_rays + t->counts.shadow_rays,
                            memory_order_relaxed);
  ylm__path_tile_free(t);
  return s;
}

/* The places of all tiles as one list. */
static bool join(const pilot *p, size_t tiles, path_places *all) {
  size_t n = 0;
  for (size_t i = 0; i < tiles; i++) n += p->noted[i].n;
  if (!places_create(all, n)) return false;
  for (size_t i = 0; i < tiles; i++) {
    const path_places *from = &p->noted[i];
    memcpy(all->x + all->n, from->x, from->n * sizeof *all->x);
    memcpy(all->normal + all->n, from->normal, from->n * sizeof *all->normal);
    memcpy(all->origin + all->n, from->origin, from->n * sizeof *all->origin);
    memcpy(all->albedo + all->n, from->albedo, from->n * sizeof *all->albedo);
    memcpy(all->direction + all->n, from->direction, from->n * sizeof *all->direction);
    memcpy(all->cosine + all->n, from->cosine, from->n * sizeof *all->cosine);
    for (size_t k = 0; k < from->n; k++) {
      bool place = from->next[k] < PATH_UNKNOWN;
      all->next[all->n + k] = from->next[k] + (place ? (uint32_t)all->n : 0);
    }
    all->n += from->n;
  }
  return true;
}

/* All places of a pilot. */
static ylm_status explore(const path_job *j, size_t pairs, path_places *all,
                          ylm_path_stats *stats) {
  size_t tiles = (pairs + PATH_PAIRS - 1) / PATH_PAIRS;
  pilot p = {.job = j, .pairs = pairs, .items = j->items};
  p.noted = ylm_alloc_zero(tiles, sizeof *p.noted);
  if (!p.noted) return YLM_ENOMEM;
  ylm_status s = ylm_parallel(tiles, 1, j->o->threads, walk, &p, j->o->progress, "guides");
  if (s == YLM_OK && !join(&p, tiles, all)) s = YLM_ENOMEM;
  for (size_t i = 0; i < tiles; i++) places_free(&p.noted[i]);
  ylm_free(p.noted);
  stats->guide_rays += p.rays;
  return s;
}

/* Learns from these places by a part of as many rays as an item lets the pilot have. */
static ylm_status learn(path_job *j, size_t pairs, const path_places *p, ylm_path_stats *stats) {
  ylm_scene_places places = {p->n, (const float(*)[3])p->x, (const float(*)[3])p->normal,
                             (const float(*)[3])p->origin};
  double rays = fmin(PILOT_RAYS, (double)PILOT_EACH * PILOT_ITEMS * (double)pairs);
  double each = 4 * rays / fmax(1, (double)p->n); /* a guide has one ray for four of the places' */
  ylm_status s = ylm_scene_guide_create(j->scene, &places, (int)fmax(1, fmin(64, each)), j->o->seed,
                                        j->o->threads, j->o->progress, &j->guide);
  if (s != YLM_OK || !j->guide) return s;
  ylm_scene_guide_stats of;
  ylm_scene_guide_look(j->guide, &of);
  stats->guide_rays += of.rays;
  stats->clusters = of.clusters;
  return YLM_OK;
}

/* How many batches of paths the pilot has. Pictures go on bit for bit: theirs do not depend on samples. */
static size_t size_of(const path_job *j) {
  size_t pairs = j->items / PILOT_ITEMS;
  if (j->points) {
    double part = (double)j->items * j->o->samples / (YLM_PATH_BATCH * PILOT_PART);
    if (part > (double)pairs) pairs = part < PILOT_PAIRS ? (size_t)part : PILOT_PAIRS;
  }
  return pairs < PILOT_PAIRS ? pairs : PILOT_PAIRS;
}

/* -- guides that are kept ------------------------------------------------------------------------ */

struct ylm_path_guides {
  const ylm_scene *scene; /* NULL: nothing was learnt */
  ylm_scene_guide *guide;
  path_known *known;
  size_t pairs, clusters; /* batches of the pilot */
};

ylm_path_guides *ylm_path_guides_create(void) { return ylm_alloc_zero(1, sizeof(ylm_path_guides)); }

void ylm_path_guides_free(ylm_path_guides *g) {
  if (!g) return;
  ylm_scene_guide_free(g->guide);
  ylm__path_known_free(g->known);
  ylm_free(g);
}

void ylm__path_forget(path_job *j) {
  const ylm_path_guides *kept = j->o->kept;
  if (kept && kept->guide == j->guide && kept->known == j->known) return;
  ylm_scene_guide_free(j->guide);
  ylm__path_known_free(j->known);
}

/* Guides by a pilot. */
static ylm_status ask_pilot(path_job *j, ylm_path_stats *stats) {
  size_t pairs = size_of(j);
  ylm_path_options o = *j->o;
  path_job scout = *j;
  path_places places = {0};
  bool bounces = o.last < 0 || o.last > (j->normals ? 0 : 1);
  if (pairs == 0 || o.strategy == YLM_PATH_MATERIAL || j->open) return YLM_OK;
  if (!bounces && !ylm_scene_guides(j->scene)) return YLM_OK;
  o.seed = ylm_mix64(o.seed ^ PILOT_SEED);
  o.first = 1; /* no light at the start */
  o.last = o.last < 0 || o.last > PILOT_PLACES - 1 ? PILOT_PLACES - 1 : o.last;
  scout.o = &o;
  ylm_status s = explore(&scout, pairs, &places, stats);
  if (s == YLM_OK) s = learn(j, pairs, &places, stats);
  if (s == YLM_OK && bounces) s = ylm__path_know(j, &places, stats);
  places_free(&places);
  if (stats->clusters == 0 && j->known) stats->clusters = ylm__path_clusters(j->known);
  return s;
}

ylm_status ylm__path_learn(path_job *j, ylm_path_stats *stats) {
  ylm_path_guides *kept = j->o->kept;
  size_t pairs = size_of(j);
  if (kept && kept->scene && kept->scene != j->scene) return YLM_EINVAL;
  if (kept && kept->scene && pairs <= PILOT_KEPT * kept->pairs) {
    j->guide = kept->guide;
    j->known = kept->known;
    stats->clusters = kept->clusters;
    return YLM_OK;
  }
  ylm_status s = ask_pilot(j, stats);
  if (s != YLM_OK || !kept) return s;
  ylm_scene_guide_free(kept->guide);
  ylm__path_known_free(kept->known);
  *kept = (ylm_path_guides){j->scene, j->guide, j->known, pairs, stats->clusters};
  return s;
}
