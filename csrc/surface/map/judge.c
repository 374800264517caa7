/*
** judge.c - fresh places that say how far a picture is from the light that it was fitted to, and why places miss the aim.
**
** Places near the aim, or beyond it, are asked again, as long as the picture may be enough: their own noise would fail it.
*/
#include <stdlib.h>

#include "map.h"
#include "ylm_grid.h"

typedef struct judges {
  size_t n;
  ylm_scene_place *place;
  surface_light *light;
  bool *open;
  float (*told)[3];
  double *error; /* relative, in the worst channel; < 0: in a body */
} judges;

static void free_judges(judges *j) {
  ylm_free(j->place), ylm_free(j->light), ylm_free(j->open), ylm_free(j->told), ylm_free(j->error);
}

static ylm_status draw(const map_bake *b, uint64_t round, judges *j) {
  j->place = ylm_alloc(MAP_JUDGES, sizeof *j->place);
  j->light = ylm_alloc(MAP_JUDGES, sizeof *j->light);
  j->open = ylm_alloc(MAP_JUDGES, sizeof *j->open);
  j->told = ylm_alloc(MAP_JUDGES, sizeof *j->told);
  j->error = ylm_alloc(MAP_JUDGES, sizeof *j->error);
  if (!j->place || !j->light || !j->open || !j->told || !j->error) return YLM_ENOMEM;
  return ylm_surface_map_draw(b->m, b->r, MAP_JUDGES, b->form->light.seed + 7919 * (round + 1),
                              j->place, &j->n);
}

/* The larger of a place's light and the mean, of a channel. */
static double scale_of(const map_bake *b, const surface_light *light, int c) {
  double E[3];
  ylm__surface_mid(light, E);
  return fmax(E[c], b->mean[c]);
}

/* Errors of all places; how many miss the aim. */
static size_t find_errors(const map_bake *b, judges *j) {
  size_t failed = 0;
  for (size_t i = 0; i < j->n; i++) {
    double E[3], worst = 0;
    ylm__surface_mid(&j->light[i], E);
    for (int c = 0; c < 3; c++) {
      double m = scale_of(b, &j->light[i], c);
      if (m > 0) worst = fmax(worst, fabs((double)j->told[i][c] - E[c]) / m);
    }
    j->error[i] = j->open[i] ? worst : -1;
    failed += j->open[i] && worst > b->aim;
  }
  return failed;
}

/* Asks the places that are near the aim, or beyond it, with more rays; `before`: how many times as many they had. */
static ylm_status ask_again(map_bake *b, judges *j, double before) {
  static const int more[2] = {MAP_JUDGE_MORE * MAP_JUDGE_RAYS, MAP_JUDGE_MORE * MAP_JUDGE_RAYS};
  size_t n = 0, *of = ylm_alloc(j->n, sizeof *of);
  ylm_scene_place *place = ylm_alloc(j->n, sizeof *place);
  surface_light *light = ylm_alloc(j->n, sizeof *light);
  bool *open = ylm_alloc(j->n, sizeof *open);
  ylm_status s = of && place && light && open ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < j->n; i++)
    if (j->error[i] > MAP_NEAR * b->aim) place[n] = j->place[i], of[n++] = i;
  if (s == YLM_OK && n) s = ylm__map_ask(b, n, place, more, light, open, NULL);
  float part = (float)(MAP_JUDGE_MORE / (before + MAP_JUDGE_MORE));
  for (size_t i = 0; s == YLM_OK && i < n; i++) {
    surface_light *own = &j->light[of[i]];
    for (int c = 0; c < 3; c++) {
      own->a[c] += part * (light[i].a[c] - own->a[c]);
      own->b[c] += part * (light[i].b[c] - own->b[c]);
    }
  }
  ylm_free(of), ylm_free(place), ylm_free(light), ylm_free(open);
  return s;
}

/* -- causes ------------------------------------------------------------------------------------------ */

/* Counts why places miss the aim: texels under bodies, noise, or what is left, edges of light. */
static ylm_status find_causes(map_bake *b, const judges *j) {
  float *all = ylm_alloc_zero(2 * b->texels, sizeof *all);
  ylm_surface_map_stats *s = &b->m->stats;
  s->bodies = s->noisy = s->edges = 0;
  if (!all) return YLM_ENOMEM;
  float *open = all + b->texels;
  for (size_t i = 0; i < b->sites; i++)
    for (int k = 0; b->site[i].read && k < 4; k++) {
      all[b->site[i].tap.texel[k]] += b->site[i].tap.weight[k];
      open[b->site[i].tap.texel[k]] += b->site[i].open ? b->site[i].tap.weight[k] : 0;
    }
  for (size_t i = 0; i < j->n; i++) {
    map_site site = {.place = j->place[i]};
    if (j->error[i] <= b->aim || !ylm__map_tap(b->m, &site.place, &site.tap)) continue;
    double had = 0, free = 0, noise = 0;
    for (int k = 0; k < 4; k++) had += (double)all[site.tap.texel[k]];
    for (int k = 0; k < 4; k++) free += (double)open[site.tap.texel[k]];
    for (int c = 0; c < 3; c++) {
      double m = scale_of(b, &j->light[i], c), told = 0;
      for (int half = 0; half < 2; half++)
        told += (half ? -0.5 : 0.5) * map_value(b, b->value, half, &site, c);
      double own = 0.5 * ((double)j->light[i].a[c] - (double)j->light[i].b[c]);
      if (m > 0) noise = fmax(noise, hypot(told, own) / m);
    }
    if (free < MAP_FREE * had)
      s->bodies++;
    else if (2 * noise > j->error[i])
      s->noisy++;
    else
      s->edges++;
  }
  ylm_free(all);
  return YLM_OK;
}

/* -- the verdict ------------------------------------------------------------------------------------- */

static int upwards(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return x < y ? -1 : x > y;
}

static void rule(map_bake *b, judges *j) {
  double square = 0, mean = 0;
  size_t kept = 0;
  ylm_surface_map_stats *s = &b->m->stats;
  s->failed = 0;
  for (size_t i = 0; i < j->n; i++) {
    const surface_light *light = &j->light[i];
    double told = (double)j->told[i][1], error = j->error[i];
    if (!j->open[i]) continue;
    s->failed += error > b->aim;
    square += (told - (double)light->a[1]) * (told - (double)light->b[1]);
    mean += 0.5 * ((double)light->a[1] + (double)light->b[1]);
    j->error[kept++] = error;
  }
  qsort(j->error, kept, sizeof *j->error, upwards);
  int most = ylm_grid_allowed(kept);
  s->verified = kept;
  s->error = most < 0 ? INFINITY : j->error[kept - 1 - (size_t)most];
  s->rms = mean > 0 ? sqrt(fmax(0, square / (double)kept)) / (mean / (double)kept) : 0;
  s->met = s->error <= b->aim;
}

ylm_status ylm__map_judge(map_bake *b, uint64_t round) {
  static const int more[2] = {MAP_JUDGE_RAYS, MAP_JUDGE_RAYS};
  double start = ylm_seconds();
  judges j = {0};
  ylm_status s = draw(b, round, &j);
  if (s == YLM_OK) s = ylm__map_ask(b, j.n, j.place, more, j.light, j.open, NULL);
  if (s == YLM_OK) {
    ylm_surface_map_irradiance(b->m, j.n, j.place, j.told, NULL);
    size_t failed = find_errors(b, &j);
    for (int k = 0; s == YLM_OK && b->aim > 0 && failed && k < MAP_JUDGE_ROUNDS; k++) {
      if ((double)failed > MAP_CLOSE * (double)j.n) break;
      s = ask_again(b, &j, 1 + MAP_JUDGE_MORE * k);
      failed = find_errors(b, &j);
    }
  }
  if (s == YLM_OK) s = find_causes(b, &j);
  if (s == YLM_OK) rule(b, &j);
  free_judges(&j);
  b->m->stats.judge_seconds += ylm_seconds() - start;
  return s;
}

/* The part of the places that may fail. */
static double allowed(const map_bake *b) {
  return b->aim < b->form->tolerance ? MAP_ENOUGH : MAP_ENOUGH_SURE;
}

bool ylm__map_is_enough(const map_bake *b) {
  const ylm_surface_map_stats *s = &b->m->stats;
  bool few = (double)s->failed <= allowed(b) * (double)s->verified;
  return b->aim < b->form->tolerance ? few : s->verified == 0 || (s->met && few);
}

double ylm__map_growth(const map_bake *b) {
  double few = fmax(1, allowed(b) * (double)b->m->stats.verified);
  double more = pow(fmax(1, (double)b->m->stats.failed) / few, 1 / MAP_FALL);
  return fmin(fmax(more, MAP_GROW_LEAST), MAP_GROW_MOST);
}
