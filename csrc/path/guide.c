/* guide.c - which lamps and tiles of the sky paths see from where: a pilot of paths without light, and the guide that is
   learnt from the places at which they are reflected. */
#include "path.h"

/* Random numbers of the pilot. */
#define PILOT_SEED 0x70696c6f74u

static void places_free(path_places *p) {
  ylm_free(p->x);
  ylm_free(p->normal);
  ylm_free(p->origin);
}

static bool places_create(path_places *p, size_t pairs) {
  p->room = pairs * YLM_PATH_BATCH * PILOT_PLACES;
  p->x = ylm_alloc(p->room, sizeof *p->x);
  p->normal = ylm_alloc(p->room, sizeof *p->normal);
  p->origin = ylm_alloc(p->room, sizeof *p->origin);
  return p->x && p->normal && p->origin;
}

/* Lets the paths of one batch of `pairs` items, evenly many, note their places. */
static ylm_status walk(const path_job *j, size_t pairs, path_places *noted, ylm_path_stats *stats) {
  path_tile *t = ylm__path_tile_create(j);
  if (!t) return YLM_ENOMEM;
  t->noted = noted;
  for (size_t first = 0; first < pairs; first += t->pairs) {
    for (t->pairs = 0; t->pairs < PATH_PAIRS && first + t->pairs < pairs; t->pairs++) {
      t->item[t->pairs] = (uint64_t)((double)(first + t->pairs) / (double)pairs * (double)j->items);
      t->batch[t->pairs] = 0;
    }
    ylm__path_walk(t, NULL);
  }
  stats->guide_rays += t->counts.nearest_rays + t->counts.lamp_rays + t->counts.shadow_rays;
  ylm__path_tile_free(t);
  return YLM_OK;
}

/* Notes places of surfaces that irradiance is asked for at, evenly many of the items. */
static void note_starts(const path_job *j, size_t pairs, path_places *p) {
  for (size_t k = 0; j->normals && k < pairs && p->n < p->room; k++, p->n++) {
    size_t item = (size_t)((double)k / (double)pairs * (double)j->items);
    double n[3];
    for (int a = 0; a < 3; a++) n[a] = (double)j->normals[item][a];
    ylm_unit3(n);
    for (int a = 0; a < 3; a++) p->normal[p->n][a] = (float)n[a];
    memcpy(p->x[p->n], j->points[item], sizeof p->x[p->n]);
    memcpy(p->origin[p->n], (j->origin ? j->origin : j->points)[item], sizeof p->origin[p->n]);
  }
}

/* Learns from these places by a part of as many rays as an item lets the pilot have. */
static ylm_status learn(path_job *j, const path_places *p, ylm_path_stats *stats) {
  ylm_scene_places places = {p->n, (const float(*)[3])p->x, (const float(*)[3])p->normal,
                             (const float(*)[3])p->origin};
  double rays = fmin(PILOT_RAYS, (double)PILOT_EACH * (double)j->items);
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

ylm_status ylm__path_learn(path_job *j, ylm_path_stats *stats) {
  size_t pairs = j->items / PILOT_ITEMS;
  ylm_path_options o = *j->o;
  path_job pilot = *j;
  path_places places = {0};
  if (pairs == 0 || o.strategy == YLM_PATH_MATERIAL || !ylm_scene_guides(j->scene)) return YLM_OK;
  if (pairs > PILOT_PAIRS) pairs = PILOT_PAIRS;
  o.seed = ylm_mix64(o.seed ^ PILOT_SEED);
  o.first = 1; /* no light at the start */
  pilot.o = &o;
  bool room = places_create(&places, pairs);
  if (room) note_starts(j, pairs, &places);
  ylm_status s = room ? walk(&pilot, pairs, &places, stats) : YLM_ENOMEM;
  if (s == YLM_OK) s = learn(j, &places, stats);
  places_free(&places);
  return s;
}
