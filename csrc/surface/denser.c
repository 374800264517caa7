/*
** denser.c - more sites where rectangles have too few to be halved.
**
** Sites are spread by area. Where light bends within a hand's breadth, beside a shelf or a window's jamb, rectangles run out of them
** before they are small enough. Such rectangles get more, spread evenly over them, in the planes of those that there are.
*/
#include "surface.h"

/* Leaves that want more sites, and those that they get. */
typedef struct densing {
  surface_bake *b;
  uint64_t round;
  const uint32_t *leaf;
  surface_site (*site)[DENSER];
  surface_entry (*entry)[DENSER];
  uint8_t *n; /* of each leaf */
} densing;

/* The place of a plane, through a surface's place, that lies at t, 0 .. 1, of a leaf's edges; false: it is seen from its edge. */
static bool find_place(const surface_bake *b, const surface_branch *n, const ylm_scene_surface *on,
                       const double t[2], float x[3]) {
  const surface_chart *c = &b->charts.chart[n->chart];
  double along = 0, up = (double)ylm_dot3(on->flat, c->axis[2]);
  if (!(fabs(up) > FLAT_LEAST)) return false;
  for (int a = 0; a < 3; a++) {
    double place = (double)c->origin[a];
    for (int k = 0; k < 2; k++)
      place += (n->lo[k] + t[k] * (n->hi[k] - n->lo[k])) / SURFACE_TOP * (double)c->size[k] *
               (double)c->axis[k][a];
    x[a] = (float)place;
    along += ((double)on->position[a] - place) * (double)on->flat[a];
  }
  for (int a = 0; a < 3; a++) x[a] = (float)((double)x[a] + along / up * (double)c->axis[2][a]);
  return true;
}

/* A place of a leaf in the plane of one of its sites: another site of the leaf, if the surface is there. */
static bool find_site(const surface_bake *b, uint32_t leaf, const ylm_scene_surface *of,
                      const double t[2], surface_site *s, surface_entry *e) {
  const surface_branch *n = &b->branch[b->leaf[leaf].branch];
  float x[3];
  *s = (surface_site){.light = SURFACE_NONE};
  if (!find_place(b, n, of, t, x) || !ylm_surface_place(b->scene, x, of->flat, &s->at))
    return false;
  ylm_scene_surface on;
  surface_spot spot[3];
  ylm_scene_surfaces(b->scene, 1, &s->at, &on);
  memcpy(s->position, on.position, sizeof s->position);
  memcpy(s->normal, on.normal, sizeof s->normal);
  int spots = ylm__surface_spots(&b->charts, &s->at, s->position, s->normal, spot);
  for (int k = 0; k < spots; k++) {
    if (spot[k].chart != n->chart || ylm__surface_descend(b, &spot[k], s->position) != leaf)
      continue;
    memcpy(e->at, spot[k].at, sizeof e->at);
    return true;
  }
  return false;
}

static ylm_status find_sites(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const densing *j = context;
  const surface_bake *b = j->b;
  for (size_t i = begin; i < end; i++) {
    const surface_leaf *l = &b->leaf[j->leaf[i]];
    ylm_scene_surface at;
    ylm_rng rng;
    ylm_rng_seed(&rng, b->form->light.seed ^ ylm_mix64(j->leaf[i]), 0xde7500 + j->round);
    j->n[i] = 0;
    for (size_t k = 0; k < DENSER; k++) {
      double t[2];
      ylm_scene_surfaces(b->scene, 1, &b->site[b->entry[l->first + k % l->n].site].at, &at);
      for (int a = 0; a < 2; a++) t[a] = ylm_rng_double(&rng);
      uint8_t n = j->n[i];
      j->n[i] += find_site(b, j->leaf[i], &at, t, &j->site[i][n], &j->entry[i][n]);
    }
  }
  return YLM_OK;
}

/* Leaves whose error is too large and whose sites are too few; how many. */
static size_t list_leaves(const surface_bake *b, uint32_t *leaf) {
  size_t n = 0;
  for (uint32_t i = 0; i < b->leaves; i++) {
    const surface_leaf *l = &b->leaf[i];
    const surface_branch *at = &b->branch[l->branch];
    bool few = l->sampled && l->n < PLACES_LEAST && !l->stuck;
    if (!few || !(l->square > DENSER_ERROR * b->aim * b->aim)) continue;
    if (ylm__surface_may(b, at, 0) || ylm__surface_may(b, at, 1)) leaf[n++] = i;
  }
  return n;
}

/* Sites and entries join those that there are: entries at the end of their leaves. */
static ylm_status take(const densing *j, size_t n) {
  surface_bake *b = j->b;
  size_t more = 0, to = 0, listed = 0;
  for (size_t i = 0; i < n; i++) more += j->n[i];
  surface_entry *entry = ylm_alloc(b->entries + more, sizeof *entry);
  if (!entry ||
      !ylm_list_reserve(&b->site, b->sites, b->sites + more, &b->site_room, sizeof *b->site)) {
    ylm_free(entry);
    return YLM_ENOMEM;
  }
  for (uint32_t k = 0; k < b->leaves; k++) {
    surface_leaf *l = &b->leaf[k];
    ylm_copy(entry + to, b->entry + l->first, l->n * sizeof *entry);
    l->first = to;
    to += l->n;
    if (listed == n || j->leaf[listed] != k) continue;
    for (uint8_t i = 0; i < j->n[listed]; i++) {
      entry[to] = j->entry[listed][i];
      entry[to++].site = (uint32_t)b->sites;
      b->site[b->sites++] = j->site[listed][i];
    }
    l->n += j->n[listed++];
  }
  ylm_free(b->entry);
  b->entry = entry;
  b->entries = to;
  return YLM_OK;
}

ylm_status ylm__surface_denser(surface_bake *b, uint64_t round) {
  uint32_t *leaf = ylm_alloc(b->leaves ? b->leaves : 1, sizeof *leaf);
  size_t n = leaf ? list_leaves(b, leaf) : 0, room = n ? n : 1;
  densing j = {b,
               round,
               leaf,
               ylm_alloc(room, sizeof *j.site),
               ylm_alloc(room, sizeof *j.entry),
               ylm_alloc(room, 1)};
  ylm_status s = leaf && j.site && j.entry && j.n ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK && n > 0)
    s = ylm_parallel(n, 16, b->form->light.threads, find_sites, &j, NULL, NULL);
  if (s == YLM_OK && n > 0) s = take(&j, n);
  ylm_free(leaf);
  ylm_free(j.site);
  ylm_free(j.entry);
  ylm_free(j.n);
  return s;
}
