/* directed.c - lamps near by whose radiance depends on the direction: disks with spread, openings of photometric lamps. */
#include <math.h>
#include <stdlib.h>

#include "scene.h"

/* A lamp's weight is multiplied by its part, but by LEAST at least: other places of the lamp may send more. */
#define LEAST 0.05f

static int compare(const void *a, const void *b) {
  const scene_directed *x = a, *y = b;
  return x->lamp < y->lamp ? -1 : x->lamp > y->lamp;
}

ylm_status ylm__scene_copy_directed(ylm_scene *s, const ylm_scene_lamps *l) {
  const double way[3] = {-s->origin[0], -s->origin[1], -s->origin[2]};
  const size_t first[] = {[YLM_LIGHT_DIRECTED_SPHERE] = 0,
                          [YLM_LIGHT_DIRECTED_TRIANGLE] = s->lamps,
                          [YLM_LIGHT_DIRECTED_DISK] = s->lamps + s->triangles};
  s->directed = ylm_alloc(l->directions, sizeof *s->directed);
  if (!s->directed) return YLM_ENOMEM;
  for (; s->directions < l->directions; s->directions++) {
    const ylm_light_directed *from = &l->directed[s->directions];
    scene_directed *to = &s->directed[s->directions];
    *to = (scene_directed){first[from->shape] + from->i, from->emitter};
    ylm_light_emitter_keep(&to->emitter);
    ylm_light_emitter_move(&to->emitter, way);
  }
  qsort(s->directed, s->directions, sizeof *s->directed, compare);
  return YLM_OK;
}

void ylm__scene_free_directed(ylm_scene *s) {
  for (size_t i = 0; i < s->directions; i++) ylm_light_emitter_drop(&s->directed[i].emitter);
  ylm_free(s->directed);
}

/* The first directed lamp that is not before a number. */
static size_t find(const ylm_scene *s, size_t lamp) {
  size_t lo = 0, hi = s->directions;
  while (lo < hi) {
    size_t mid = (lo + hi) / 2;
    if (s->directed[mid].lamp < lamp)
      lo = mid + 1;
    else
      hi = mid;
  }
  return lo;
}

const ylm_light_emitter *ylm__scene_directed(const ylm_scene *s, size_t lamp) {
  if (s->directions == 0) return NULL;
  size_t i = find(s, lamp);
  return i < s->directions && s->directed[i].lamp == lamp ? &s->directed[i].emitter : NULL;
}

bool ylm__scene_directed_radiance(const ylm_scene *s, size_t lamp, const float d[3],
                                  float radiance[3]) {
  const ylm_light_emitter *e = ylm__scene_directed(s, lamp);
  if (!e) return false;
  double rgb[3], way[3];
  for (int a = 0; a < 3; a++) way[a] = -(double)d[a];
  ylm_light_emitter_radiance(e, way, rgb);
  for (int c = 0; c < 3; c++) radiance[c] = (float)rgb[c];
  return true;
}

void ylm__scene_weigh_directed(const ylm_scene *s, size_t first, size_t n, const float x[3],
                               float *weight, float *sum) {
  const double from[3] = {(double)x[0], (double)x[1], (double)x[2]};
  size_t i = find(s, first), end = find(s, first + n);
  for (size_t k = i; k < end; k++) {
    size_t at = s->directed[k].lamp - first;
    float part = (float)ylm_light_emitter_part(&s->directed[k].emitter, from);
    weight[at] *= fmaxf(part, LEAST);
  }
  for (size_t b = 0; i < end && b * YLM_LAMP_CHUNK < n; b++) {
    double total = 0;
    for (size_t k = b * YLM_LAMP_CHUNK; k < n && k < (b + 1) * YLM_LAMP_CHUNK; k++)
      total += (double)weight[k];
    sum[b] = (float)total;
  }
}
