/*
** ground.c - the grounds of a scene: parts that lie flat and are much wider than what stands on them.
**
** Parts are triangles of a mesh that are connected at places of their corners. The widest parts are grounds if they lie flat
** together, and if the box of the others is small beside that of all and holds places from which the scene is seen.
*/
#include <stdlib.h>
#include <string.h>

#include "scene.h"
#include "ylm_geom.h"
#include "ylm_list.h"

typedef struct ground_part {
  double lo[3], hi[3];
  double wide;    /* the diagonal of the box */
  uint32_t first; /* triangle */
} ground_part;

typedef struct grounds {
  const ylm_scene *scene;
  size_t triangles, parts;
  uint32_t *to; /* [triangles] one before it of the same part; the first one itself */
  ground_part *part;
} grounds;

static const ground_part EMPTY = {
    {INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}, 0, 0};

static void widen(ground_part *box, const double lo[3], const double hi[3]) {
  double square = 0;
  for (int a = 0; a < 3; a++) {
    box->lo[a] = fmin(box->lo[a], lo[a]);
    box->hi[a] = fmax(box->hi[a], hi[a]);
    square += (box->hi[a] - box->lo[a]) * (box->hi[a] - box->lo[a]);
  }
  box->wide = sqrt(square);
}

/* -- parts ----------------------------------------------------------------------------------------- */

/* Connects the triangles of a mesh, before which there are `before`. */
static ylm_status connect(grounds *g, const scene_mesh *m, size_t before) {
  size_t places = 0;
  uint32_t *name = ylm_alloc(m->vertices ? m->vertices : 1, sizeof *name);
  uint32_t *at = ylm_alloc(m->vertices ? m->vertices : 1, sizeof *at);
  ylm_status s = name && at ? ylm_mesh_weld(m->vertices, m->position, name, &places) : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < places; i++) at[i] = UINT32_MAX;
  for (size_t i = 0; s == YLM_OK && i < 3 * m->count; i++) {
    uint32_t *known = &at[name[m->triangle[i]]], here = (uint32_t)(before + i / 3);
    if (*known == UINT32_MAX) *known = here;
    uint32_t a = ylm_list_root(g->to, *known), b = ylm_list_root(g->to, here);
    g->to[a < b ? b : a] = a < b ? a : b;
  }
  ylm_free(name);
  ylm_free(at);
  return s;
}

static int by_width(const void *a, const void *b) {
  const ground_part *p = a, *q = b;
  if (p->wide != q->wide) return p->wide > q->wide ? -1 : 1;
  return p->first < q->first ? -1 : 1;
}

/* The parts, the widest first. */
static ylm_status find_parts(grounds *g) {
  const ylm_scene *scene = g->scene;
  uint32_t *of = ylm_alloc(g->triangles, sizeof *of);
  ylm_status s = of ? YLM_OK : YLM_ENOMEM;
  for (size_t m = 0, i = 0; s == YLM_OK && m < scene->meshes; i += scene->mesh[m++].count)
    s = connect(g, &scene->mesh[m], i);
  for (size_t i = 0; s == YLM_OK && i < g->triangles; i++)
    if (g->to[i] == i) of[i] = (uint32_t)g->parts++;
  if (s == YLM_OK && !(g->part = ylm_alloc(g->parts, sizeof *g->part))) s = YLM_ENOMEM;
  for (size_t m = 0, i = 0; s == YLM_OK && m < scene->meshes; m++)
    for (size_t t = 0; t < scene->mesh[m].count; t++, i++) {
      uint32_t first = ylm_list_root(g->to, (uint32_t)i);
      ground_part *p = &g->part[of[first]];
      if (first == i) *p = EMPTY, p->first = first;
      for (size_t k = 0; k < 3; k++) {
        const float *x = scene->mesh[m].position + 3 * scene->mesh[m].triangle[3 * t + k];
        const double at[3] = {(double)x[0], (double)x[1], (double)x[2]};
        widen(p, at, at);
      }
    }
  ylm_free(of);
  if (s == YLM_OK) qsort(g->part, g->parts, sizeof *g->part, by_width);
  return s;
}

/* -- grounds --------------------------------------------------------------------------------------- */

static bool is_flat(const ground_part *b) {
  double least = INFINITY, most = 0;
  for (int a = 0; a < 3; a++) {
    least = fmin(least, b->hi[a] - b->lo[a]);
    most = fmax(most, b->hi[a] - b->lo[a]);
  }
  return least <= GROUND_FLAT * most;
}

/* Whether half of the places are in a box, which then is so of boxes around it. */
static bool is_seen(const ground_part *b, size_t places, const float (*place)[3]) {
  size_t in = 0;
  if (!places) return true;
  for (size_t i = 0; i < places; i++) {
    bool all = true;
    for (int a = 0; a < 3; a++)
      all &= (double)place[i][a] >= b->lo[a] && (double)place[i][a] <= b->hi[a];
    in += all;
  }
  return 2 * in >= places;
}

/* How many of the widest parts are grounds, and the box of the rest. */
static ylm_status find_grounds(const grounds *g, size_t places, const float (*place)[3],
                               size_t *found, ground_part *core) {
  size_t most = g->parts - 1 < GROUND_PARTS ? g->parts - 1 : GROUND_PARTS;
  ground_part *rest = ylm_alloc(most + 1, sizeof *rest), before = EMPTY, behind = EMPTY;
  if (!rest) return YLM_ENOMEM;
  for (size_t i = g->parts; i-- > 0;) {
    widen(&behind, g->part[i].lo, g->part[i].hi);
    if (i <= most) rest[i] = behind;
  }
  *core = rest[0];
  *found = 0;
  for (size_t i = 1; i <= most && !*found; i++) {
    widen(&before, g->part[i - 1].lo, g->part[i - 1].hi);
    if (!is_flat(&before)) break;
    if (rest[i].wide > rest[0].wide / GROUND_WIDER || is_flat(&rest[i]) ||
        !is_seen(&rest[i], places, place))
      continue;
    *core = rest[i];
    *found = i;
  }
  ylm_free(rest);
  return YLM_OK;
}

ylm_status ylm_scene_core(const ylm_scene *scene, size_t places, const float (*place)[3],
                          double lo[3], double hi[3], uint8_t *ground) {
  grounds g = {.scene = scene};
  size_t found = 0;
  ground_part core;
  for (size_t m = 0; m < scene->meshes; m++) g.triangles += scene->mesh[m].count;
  ylm_scene_bounds(scene, lo, hi);
  if (ground) memset(ground, 0, g.triangles);
  if (!g.triangles || g.triangles >= UINT32_MAX) return YLM_OK;
  g.to = ylm_alloc(g.triangles, sizeof *g.to);
  ylm_status s = g.to ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < g.triangles; i++) g.to[i] = (uint32_t)i;
  if (s == YLM_OK) s = find_parts(&g);
  if (s == YLM_OK) s = find_grounds(&g, places, place, &found, &core);
  for (int a = 0; s == YLM_OK && found && a < 3; a++) lo[a] = core.lo[a], hi[a] = core.hi[a];
  for (size_t k = 0; s == YLM_OK && ground && k < found; k++)
    for (size_t i = g.part[k].first; i < g.triangles; i++)
      ground[i] |= ylm_list_root(g.to, (uint32_t)i) == g.part[k].first;
  ylm_free(g.to);
  ylm_free(g.part);
  return s;
}
