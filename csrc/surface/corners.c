/*
** corners.c - which corners of rectangles are one.
**
** Corners at one place of a chart join where the surface places nearest to them join. A corner that lies on the edge of a
** longer rectangle, and joins that too, hangs on it: it has that edge's value, so nothing steps there.
*/
#include <math.h>
#include <stdlib.h>

#include "surface.h"
#include "ylm_keys.h"

/* A corner as a key: all its bytes count. */
typedef struct corner_key {
  uint32_t chart;
  uint16_t at[2];
} corner_key;

/* The place of a leaf that is nearest to a corner. */
typedef struct nearest {
  uint32_t leaf, site;
  uint16_t at[2];
} nearest;

/* A leaf on whose edge the corner of a key lies. */
typedef struct hanging {
  uint32_t key, near;
} hanging;

typedef struct joiner {
  surface_bake *b;
  ylm_keys key;
  uint32_t *of;             /* [4 leaves] the key of a corner, or SURFACE_NONE */
  uint32_t *first, *corner; /* [keys + 1], and corners by key: numbers of 4 leaf + c */
  nearest *near;            /* [4 leaves], then those of `hang` */
  size_t n, room;
  hanging *hang;
  size_t hangs, hang_room;
  uint32_t *root;      /* [4 leaves] of joined corners */
  uint32_t (*pair)[2]; /* of corners, or of a corner and a hanging one */
  uint32_t (*sites)[2];
  bool *joined;
  size_t pairs, pair_room, site_room;
} joiner;

static void corner_of(const surface_branch *n, int c, uint16_t at[2]) {
  at[0] = c & 1 ? n->hi[0] : n->lo[0];
  at[1] = c & 2 ? n->hi[1] : n->lo[1];
}

/* Corners of all leaves by key. */
static ylm_status sort_corners(joiner *j) {
  surface_bake *b = j->b;
  for (uint32_t i = 0; i < 4 * b->leaves; i++) {
    const surface_leaf *l = &b->leaf[i / 4];
    const surface_branch *n = &b->branch[l->branch];
    corner_key key = {.chart = n->chart};
    j->root[i] = i;
    j->of[i] = SURFACE_NONE;
    j->near[i] = (nearest){.leaf = i / 4, .site = SURFACE_NONE};
    corner_of(n, (int)(i % 4), key.at);
    memcpy(j->near[i].at, key.at, sizeof key.at);
    if (l->sampled && ylm_keys_put(&j->key, &key, sizeof key, &j->of[i]) != YLM_OK)
      return YLM_ENOMEM;
  }
  j->first = ylm_alloc_zero(j->key.n + 2, sizeof *j->first);
  if (!j->first) return YLM_ENOMEM;
  for (size_t i = 0; i < 4 * b->leaves; i++)
    if (j->of[i] != SURFACE_NONE) j->first[j->of[i] + 2]++;
  for (size_t k = 0; k < j->key.n; k++) j->first[k + 2] += j->first[k + 1];
  for (uint32_t i = 0; i < 4 * b->leaves; i++)
    if (j->of[i] != SURFACE_NONE) j->corner[j->first[j->of[i] + 1]++] = i;
  return YLM_OK;
}

/* Lists the leaves below branch k on whose edges, not corners, the place of a key lies. */
static ylm_status find_around(joiner *j, uint32_t key, const corner_key *at, uint32_t k) {
  const surface_branch *n = &j->b->branch[k];
  bool edge[2];
  for (int a = 0; a < 2; a++) {
    if (at->at[a] < n->lo[a] || at->at[a] > n->hi[a]) return YLM_OK;
    edge[a] = at->at[a] == n->lo[a] || at->at[a] == n->hi[a];
  }
  if (n->kind != NODE_RECTANGLE) {
    uint32_t child = n->child;
    ylm_status s = find_around(j, key, at, child);
    return s == YLM_OK ? find_around(j, key, at, child + 1) : s;
  }
  if (edge[0] == edge[1] || !j->b->leaf[n->leaf].sampled) return YLM_OK;
  if (!ylm_list_reserve(&j->near, j->n, j->n + 1, &j->room, sizeof *j->near) ||
      !ylm_list_reserve(&j->hang, j->hangs, j->hangs + 1, &j->hang_room, sizeof *j->hang))
    return YLM_ENOMEM;
  j->hang[j->hangs++] = (hanging){key, (uint32_t)j->n};
  j->near[j->n] = (nearest){.leaf = n->leaf, .site = SURFACE_NONE};
  memcpy(j->near[j->n++].at, at->at, sizeof at->at);
  return YLM_OK;
}

/* -- nearest places -------------------------------------------------------------------------- */

/* The entry of a leaf nearest to a corner, of those not known to be buried; `sampled`: of those that have light. */
static uint32_t find_nearest(const surface_bake *b, const nearest *x, bool sampled) {
  const surface_leaf *l = &b->leaf[x->leaf];
  const float *size = b->charts.chart[b->branch[l->branch].chart].size;
  size_t n = sampled ? l->sampled : l->sampled + CORNER_PLACES;
  uint32_t best = SURFACE_NONE;
  double least = INFINITY;
  for (size_t i = l->first; i < l->first + (n < l->n ? n : l->n); i++) {
    const surface_entry *e = &b->entry[i];
    if (b->site[e->site].known == SITE_BURIED) continue;
    double u = (double)((e->at[0] - x->at[0]) * size[0]),
           v = (double)((e->at[1] - x->at[1]) * size[1]);
    if (best == SURFACE_NONE || u * u + v * v < least) least = u * u + v * v, best = e->site;
  }
  return best;
}

static int by_number(const void *a, const void *b) {
  uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
  return x < y ? -1 : x > y;
}

/* Finds out which of the nearest places are buried; *all: none of them is. */
static ylm_status know_nearest(joiner *j, bool *all) {
  uint32_t *list = ylm_alloc(j->n, sizeof *list);
  size_t n = 0, distinct = 0;
  if (!list) return YLM_ENOMEM;
  for (size_t i = 0; i < j->n; i++)
    if (j->near[i].site != SURFACE_NONE && j->b->site[j->near[i].site].known == SITE_UNKNOWN)
      list[n++] = j->near[i].site;
  qsort(list, n, sizeof *list, by_number);
  for (size_t i = 0; i < n; i++)
    if (i == 0 || list[i] != list[i - 1]) list[distinct++] = list[i];
  ylm_status s = ylm__surface_know(j->b, distinct, list, NULL);
  *all = true;
  for (size_t i = 0; i < distinct; i++) *all &= j->b->site[list[i]].known != SITE_BURIED;
  ylm_free(list);
  return s;
}

static ylm_status find_all_nearest(joiner *j) {
  ylm_status s = YLM_OK;
  bool all = false;
  for (int pass = 0; s == YLM_OK && !all; pass++) {
    for (size_t i = 0; i < j->n; i++) {
      nearest *x = &j->near[i];
      if (i < 4 * j->b->leaves && j->of[i] == SURFACE_NONE) continue;
      if (x->site != SURFACE_NONE && j->b->site[x->site].known != SITE_BURIED) continue;
      x->site = find_nearest(j->b, x, pass >= NEAREST_PASSES);
    }
    s = know_nearest(j, &all);
  }
  return s;
}

/* -- joining --------------------------------------------------------------------------------- */

static ylm_status add_pair(joiner *j, uint32_t a, uint32_t b) {
  if (j->near[a].site == SURFACE_NONE || j->near[b].site == SURFACE_NONE) return YLM_OK;
  if (!ylm_list_reserve(&j->pair, j->pairs, j->pairs + 1, &j->pair_room, sizeof *j->pair) ||
      !ylm_list_reserve(&j->sites, j->pairs, j->pairs + 1, &j->site_room, sizeof *j->sites))
    return YLM_ENOMEM;
  j->pair[j->pairs][0] = a, j->pair[j->pairs][1] = b;
  j->sites[j->pairs][0] = j->near[a].site, j->sites[j->pairs][1] = j->near[b].site;
  j->pairs++;
  return YLM_OK;
}

/* Looks whether the places of all pairs join. */
static ylm_status ask(joiner *j) {
  ylm_free(j->joined);
  j->joined = ylm_alloc(j->pairs, sizeof *j->joined);
  if (!j->joined) return YLM_ENOMEM;
  return ylm__surface_join(j->b, j->pairs, (const uint32_t(*)[2])j->sites, j->joined);
}

static ylm_status join(joiner *j) {
  ylm_status s = YLM_OK;
  j->pairs = 0;
  for (size_t k = 0; k < j->key.n; k++)
    for (size_t x = j->first[k]; x < j->first[k + 1]; x++)
      for (size_t y = x + 1; s == YLM_OK && y < j->first[k + 1]; y++)
        s = add_pair(j, j->corner[x], j->corner[y]);
  if (s == YLM_OK) s = ask(j);
  for (size_t i = 0; s == YLM_OK && i < j->pairs; i++)
    if (j->joined[i]) {
      uint32_t a = ylm_list_root(j->root, j->pair[i][0]), b = ylm_list_root(j->root, j->pair[i][1]);
      j->root[a > b ? a : b] = a < b ? a : b;
    }
  return s;
}

/* Classes of the joined corners. */
static ylm_status number(joiner *j) {
  surface_bake *b = j->b;
  b->classes = 0;
  for (uint32_t i = 0; i < 4 * b->leaves; i++) {
    if (j->of[i] == SURFACE_NONE || ylm_list_root(j->root, i) != i) continue;
    if (!ylm_list_reserve(&b->class, b->classes, b->classes + 1, &b->class_room, sizeof *b->class))
      return YLM_ENOMEM;
    b->leaf[i / 4].corner[i % 4] = (uint32_t)b->classes;
    b->class[b->classes] = (surface_class){.host = SURFACE_NONE, .free = SURFACE_NONE};
    memcpy(b->class[b->classes++].at, j->near[i].at, sizeof j->near[i].at);
  }
  for (uint32_t i = 0; i < 4 * b->leaves; i++) {
    if (j->of[i] == SURFACE_NONE) continue;
    uint32_t root = ylm_list_root(j->root, i);
    b->leaf[i / 4].corner[i % 4] = b->leaf[root / 4].corner[root % 4];
  }
  return YLM_OK;
}

/* The length of the edge of a leaf that a place lies on. */
static int edge(const surface_bake *b, uint32_t leaf, const uint16_t at[2]) {
  const surface_branch *n = &b->branch[b->leaf[leaf].branch];
  bool across = at[0] == n->lo[0] || at[0] == n->hi[0];
  return across ? n->hi[1] - n->lo[1] : n->hi[0] - n->lo[0];
}

/* Classes hang on the longest edge that they join. */
static ylm_status hang(joiner *j) {
  surface_bake *b = j->b;
  ylm_status s = YLM_OK;
  j->pairs = 0;
  for (size_t h = 0; h < j->hangs; h++)
    for (size_t x = j->first[j->hang[h].key]; s == YLM_OK && x < j->first[j->hang[h].key + 1]; x++)
      s = add_pair(j, j->corner[x], j->hang[h].near);
  if (s == YLM_OK) s = ask(j);
  for (size_t i = 0; s == YLM_OK && i < j->pairs; i++) {
    if (!j->joined[i]) continue;
    uint32_t corner = j->pair[i][0];
    const nearest *x = &j->near[j->pair[i][1]];
    surface_class *c = &b->class[b->leaf[corner / 4].corner[corner % 4]];
    if (c->host == SURFACE_NONE || edge(b, x->leaf, x->at) > edge(b, c->host, x->at))
      c->host = x->leaf;
  }
  return s;
}

ylm_status ylm__surface_corners(surface_bake *b) {
  size_t n = 4 * b->leaves;
  joiner j = {.b = b, .n = n};
  j.of = ylm_alloc(n, sizeof *j.of);
  j.corner = ylm_alloc(n, sizeof *j.corner);
  j.root = ylm_alloc(n, sizeof *j.root);
  ylm_status s =
      j.of && j.corner && j.root && ylm_list_reserve(&j.near, 0, n + 1, &j.room, sizeof *j.near)
          ? sort_corners(&j)
          : YLM_ENOMEM;
  for (uint32_t k = 0; s == YLM_OK && k < j.key.n; k++) {
    corner_key at;
    memcpy(&at, ylm_keys_at(&j.key, k, sizeof at), sizeof at);
    s = find_around(&j, k, &at, b->root[at.chart]);
  }
  if (s == YLM_OK) s = find_all_nearest(&j);
  if (s == YLM_OK) s = join(&j);
  if (s == YLM_OK) s = number(&j);
  if (s == YLM_OK) s = hang(&j);
  ylm_keys_free(&j.key);
  ylm_free(j.of);
  ylm_free(j.first);
  ylm_free(j.corner);
  ylm_free(j.near);
  ylm_free(j.hang);
  ylm_free(j.root);
  ylm_free(j.pair);
  ylm_free(j.sites);
  ylm_free(j.joined);
  return s;
}
