/* tree.c - rectangles of charts while they are halved. */
#include <math.h>

#include "surface.h"

uint32_t ylm__surface_descend(const surface_bake *b, const surface_spot *s,
                              const float position[3]) {
  uint32_t k = b->root[s->chart];
  while (k != SURFACE_NONE && b->branch[k].kind != NODE_RECTANGLE) {
    const surface_branch *n = &b->branch[k], *child = &b->branch[n->child];
    bool second = n->kind == NODE_PLANE ? ylm__surface_is_beyond(n->a, position)
                                        : s->at[n->kind] >= child->hi[n->kind];
    k = n->child + second;
  }
  return k == SURFACE_NONE ? k : b->branch[k].leaf;
}

static ylm_status add_leaf(surface_bake *b, uint32_t branch, size_t first, size_t n) {
  if (!ylm_list_reserve(&b->leaf, b->leaves, b->leaves + 1, &b->leaf_room, sizeof *b->leaf))
    return YLM_ENOMEM;
  b->branch[branch].leaf = (uint32_t)b->leaves;
  b->leaf[b->leaves++] =
      (surface_leaf){.branch = branch, .first = first, .n = n, .weight = (double)n};
  return YLM_OK;
}

static ylm_status room(surface_bake *b, size_t n) {
  return ylm_list_reserve(&b->branch, b->branches, b->branches + n, &b->branch_room,
                          sizeof *b->branch)
             ? YLM_OK
             : YLM_ENOMEM;
}

ylm_status ylm__surface_plant(surface_bake *b, uint32_t chart, size_t first, size_t n) {
  ylm_status s = room(b, 1);
  if (s != YLM_OK) return s;
  uint32_t k = (uint32_t)b->branches++;
  b->branch[k] = (surface_branch){.chart = chart, .kind = NODE_RECTANGLE};
  for (int a = 0; a < 3; a++) b->branch[k].hi[a] = SURFACE_TOP;
  b->root[chart] = k;
  return add_leaf(b, k, first, n);
}

bool ylm__surface_may(const surface_bake *b, const surface_branch *n, int axis) {
  return n->hi[axis] - n->lo[axis] >= 2 &&
         (double)ylm__surface_extent(b, n, axis) > 2 * NARROWEST * b->charts.unit;
}

/* Values at the corners of a part of a leaf. */
static void inherit(const surface_branch *whole, const float value[4][3],
                    const surface_branch *part, float out[4][3]) {
  for (int c = 0; c < 4; c++) {
    const float at[2] = {c & 1 ? part->hi[0] : part->lo[0], c & 2 ? part->hi[1] : part->lo[1]};
    float w[4];
    ylm__surface_weights(whole->lo, whole->hi, at, w);
    for (int k = 0; k < 3; k++) {
      out[c][k] = 0;
      for (int i = 0; i < 4; i++) out[c][k] += w[i] * value[i][k];
    }
  }
}

static bool is_second(const surface_bake *b, const surface_branch *n, const surface_entry *e) {
  if (n->kind == NODE_PLANE) return ylm__surface_is_beyond(n->a, b->site[e->site].position);
  return e->at[n->kind] >= b->branch[n->child].hi[n->kind];
}

/* Sorts the entries of a leaf by halves, each in its order; how many the first has, of all and of those sampled. */
static ylm_status part(surface_bake *b, const surface_branch *n, const surface_leaf *l,
                       size_t *first, size_t *sampled) {
  surface_entry *e = b->entry + l->first, *rest = ylm_alloc(l->n, sizeof *rest);
  size_t k = 0, others = 0;
  if (!rest) return YLM_ENOMEM;
  *sampled = 0;
  for (size_t i = 0; i < l->n; i++)
    if (is_second(b, n, &e[i]))
      rest[others++] = e[i];
    else {
      *sampled += i < l->sampled;
      e[k++] = e[i];
    }
  ylm_copy(e + k, rest, others * sizeof *rest);
  *first = k;
  ylm_free(rest);
  return YLM_OK;
}

ylm_status ylm__surface_halve(surface_bake *b, uint32_t leaf, uint32_t kind, const float a[4]) {
  ylm_status s = room(b, 2);
  if (s == YLM_OK) s = add_leaf(b, b->leaf[leaf].branch, 0, 0); /* room, before anything changes */
  if (s != YLM_OK) return s;
  uint32_t second = (uint32_t)--b->leaves;
  surface_leaf *l = &b->leaf[leaf], *m = &b->leaf[second];
  surface_branch *n = &b->branch[l->branch], *child = &b->branch[b->branches];
  n->kind = kind;
  n->child = (uint32_t)b->branches;
  for (int k = 0; k < 2; k++) {
    child[k] = *n;
    child[k].kind = NODE_RECTANGLE;
    child[k].leaf = k ? second : leaf;
  }
  if (kind == NODE_PLANE)
    memcpy(n->a, a, sizeof n->a);
  else
    child[0].hi[kind] = child[1].lo[kind] = (uint16_t)((n->lo[kind] + n->hi[kind]) / 2);
  surface_leaf whole = *l;
  size_t first, sampled;
  s = part(b, n, &whole, &first, &sampled);
  if (s != YLM_OK) {
    n->kind = NODE_RECTANGLE;
    n->leaf = leaf;
    return s;
  }
  *l = (surface_leaf){.branch = n->child, .first = whole.first, .n = first, .sampled = sampled};
  *m = (surface_leaf){.branch = n->child + 1,
                      .first = whole.first + first,
                      .n = whole.n - first,
                      .sampled = whole.sampled - sampled};
  if (whole.n) l->weight = whole.weight * (double)first / (double)whole.n;
  m->weight = whole.weight - l->weight;
  inherit(n, whole.value, &child[0], l->value);
  inherit(n, whole.value, &child[1], m->value);
  b->branches += 2;
  b->leaves++;
  return YLM_OK;
}

/* A node of another grid, and the leaf that becomes like it. */
typedef struct growing {
  uint32_t node, leaf;
} growing;

typedef struct growings {
  growing *list;
  size_t n, room;
} growings;

static ylm_status push(growings *g, uint32_t node, uint32_t leaf) {
  if (node == SURFACE_NONE) return YLM_OK;
  if (!ylm_list_reserve(&g->list, g->n, g->n + 1, &g->room, sizeof *g->list)) return YLM_ENOMEM;
  g->list[g->n++] = (growing){node, leaf};
  return YLM_OK;
}

/* Halves a leaf as a node is, and lists both halves. */
static ylm_status grow_leaf(surface_bake *b, const ylm_surface_grid *like, growing x, growings *g) {
  uint32_t kind = like->node[x.node] & ((1u << NODE_BITS) - 1),
           child = like->node[x.node] >> NODE_BITS;
  const surface_branch *n = &b->branch[b->leaf[x.leaf].branch];
  const float *plane = NULL;
  if (kind == NODE_RECTANGLE || (kind != NODE_PLANE && n->hi[kind] - n->lo[kind] < 2))
    return YLM_OK;
  if (kind == NODE_PLANE) {
    plane = like->plane[child].a;
    child = like->plane[child].child;
  }
  ylm_status s = ylm__surface_halve(b, x.leaf, kind, plane);
  if (s == YLM_OK) s = push(g, child + 1, (uint32_t)b->leaves - 1);
  return s == YLM_OK ? push(g, child, x.leaf) : s;
}

ylm_status ylm__surface_grow(surface_bake *b, const ylm_surface_grid *like) {
  growings g = {.list = NULL};
  ylm_status s = YLM_OK;
  size_t visited = 0;
  for (uint32_t i = (uint32_t)b->leaves; s == YLM_OK && i-- > 0;)
    s = push(&g, like->root[b->branch[b->leaf[i].branch].chart], i);
  while (s == YLM_OK && g.n > 0) {
    growing x = g.list[--g.n];
    s = ++visited > like->nodes ? YLM_EFORMAT : grow_leaf(b, like, x, &g);
  }
  ylm_free(g.list);
  return s;
}

void ylm__surface_value(const surface_bake *b, const surface_site *s, float E[3]) {
  surface_spot spot[3];
  float have = 0;
  int n = ylm__surface_spots(&b->charts, &s->at, s->position, s->normal, spot);
  E[0] = E[1] = E[2] = 0;
  for (int i = 0; i < n; i++) {
    uint32_t leaf = ylm__surface_descend(b, &spot[i], s->position);
    if (leaf == SURFACE_NONE || !b->leaf[leaf].sampled) continue;
    const surface_leaf *l = &b->leaf[leaf];
    float w[4];
    const surface_branch *r = &b->branch[l->branch];
    ylm__surface_weights(r->lo, r->hi, spot[i].at, w);
    have += spot[i].weight;
    for (int c = 0; c < 4; c++)
      for (int k = 0; k < 3; k++) E[k] += spot[i].weight * w[c] * l->value[c][k];
  }
  for (int k = 0; have > 0 && k < 3; k++) E[k] /= have;
}
