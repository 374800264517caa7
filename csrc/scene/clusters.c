/*
** clusters.c - places that lie close together and face the same way: leaves of a tree that halves places by their normals, then
** by their positions.
*/
#include <math.h>

#include "calibration.h"
#include "scene.h"
#include "ylm_list.h"

enum { STACK = 64 };

/* Places below `at` along an axis, of normals or of positions, are in the first branch, which the other one follows. A leaf leads to
   itself: every place is below it along LEAF. */
enum { LEAF = 7, AXES = 8, AXIS_BITS = 3 };
typedef struct cluster_node {
  float at;
  uint32_t way; /* its first branch; in the low bits its axis */
} cluster_node;

/* A part of the list of places. */
typedef struct cluster_part {
  size_t first, n;
} cluster_part;

struct ylm_scene_clusters {
  size_t nodes, clusters;
  cluster_node *node; /* [nodes] the first is the root */
  uint32_t *cluster;  /* [nodes] of leaves */
  /* until they are forgotten: */
  uint32_t *list;     /* places, in an order in which those of a node follow one another */
  cluster_part *part; /* [nodes] */
  uint32_t *up;       /* [nodes] the node that was split; of the root itself */
  uint32_t *leaf;     /* [clusters] its node */
};

/* The tree as it grows. */
typedef struct growing {
  const ylm_scene_places *places;
  ylm_scene_clusters *c;
  size_t most; /* places of a cluster */
} growing;

void ylm_scene_clusters_forget(ylm_scene_clusters *c) {
  ylm_free(c->list);
  ylm_free(c->part);
  ylm_free(c->up);
  ylm_free(c->leaf);
  c->list = c->up = c->leaf = NULL;
  c->part = NULL;
}

void ylm_scene_clusters_free(ylm_scene_clusters *c) {
  if (!c) return;
  ylm_scene_clusters_forget(c);
  ylm_free(c->node);
  ylm_free(c->cluster);
  ylm_free(c);
}

size_t ylm_scene_clusters_count(const ylm_scene_clusters *c) { return c->clusters; }

const uint32_t *ylm_scene_cluster_places(const ylm_scene_clusters *c, size_t cluster, size_t least,
                                         size_t *n) {
  uint32_t node = c->leaf[cluster];
  while (c->part[node].n < least && c->up[node] != node) node = c->up[node];
  *n = c->part[node].n;
  return c->list + c->part[node].first;
}

static float along(int axis, const float x[3], const float normal[3]) {
  return axis < 3 ? normal[axis] : x[axis - 3];
}

static void set_out(const float x[3], const float normal[3], float v[AXES]) {
  for (int k = 0; k < AXES; k++) v[k] = k < 3 ? normal[k] : k < 6 ? x[k - 3] : 0;
}

/* One step down from a node. */
static inline uint32_t step(cluster_node n, const float v[AXES]) {
  return (n.way >> AXIS_BITS) + !(v[n.way & LEAF] < n.at);
}

size_t ylm_scene_cluster_at(const ylm_scene_clusters *c, const float x[3], const float normal[3]) {
  float v[AXES];
  uint32_t at = 0;
  set_out(x, normal, v);
  while ((c->node[at].way & LEAF) != LEAF) at = step(c->node[at], v);
  return c->cluster[at];
}

/* Walks go down together, so that none waits for another's nodes. */
void ylm_scene_clusters_at(const ylm_scene_clusters *c, size_t n, const float (*x)[3],
                           const float (*normal)[3], uint32_t *cluster) {
  enum { WALKS = 8 };
  for (size_t i = 0; i < n; i += WALKS) {
    size_t walks = n - i < WALKS ? n - i : WALKS;
    float v[WALKS][AXES];
    uint32_t at[WALKS] = {0}, on;
    for (size_t k = 0; k < WALKS; k++)
      set_out(x[k < walks ? i + k : i], normal[k < walks ? i + k : i], v[k]);
    do {
      on = 0;
      for (size_t k = 0; k < WALKS; k++) {
        cluster_node node = c->node[at[k]];
        on |= ~node.way & LEAF;
        at[k] = step(node, v[k]);
      }
    } while (on);
    for (size_t k = 0; k < walks; k++) cluster[i + k] = c->cluster[at[k]];
  }
}

static float coordinate(const growing *g, int axis, size_t i) {
  uint32_t place = g->c->list[i];
  return along(axis, g->places->lit[place], g->places->normal[place]);
}

/* The axis along which places are widest, of three, and their middle there. */
static int widest(const growing *g, const cluster_part *p, int axis, float *extent, float *middle) {
  int found = axis;
  *extent = -1;
  for (int k = axis; k < axis + 3; k++) {
    float lo = INFINITY, hi = -INFINITY;
    for (size_t i = p->first; i < p->first + p->n; i++) {
      lo = fminf(lo, coordinate(g, k, i));
      hi = fmaxf(hi, coordinate(g, k, i));
    }
    if (hi - lo > *extent) found = k, *extent = hi - lo, *middle = (lo + hi) / 2;
  }
  return found;
}

/* Puts places below `at` before the others; returns their number. */
static size_t part(growing *g, const cluster_part *p, int axis, float at) {
  uint32_t *list = g->c->list;
  size_t below = p->first;
  for (size_t i = p->first; i < p->first + p->n; i++) {
    if (!(coordinate(g, axis, i) < at)) continue;
    uint32_t other = list[below];
    list[below++] = list[i];
    list[i] = other;
  }
  return below - p->first;
}

/* A split of places; false: they are a cluster. */
static bool split(growing *g, const cluster_part *p, int *axis, float *at, size_t *below) {
  float extent;
  if (p->n < 2) return false;
  *axis = widest(g, p, 0, &extent, at);
  if (!(extent > GUIDE_NORMALS)) {
    if (p->n <= g->most) return false;
    *axis = widest(g, p, 3, &extent, at);
  }
  *below = part(g, p, *axis, *at);
  return *below > 0 && *below < p->n;
}

/* Makes the two nodes that a node was split into. */
static void branch(ylm_scene_clusters *c, uint32_t node, size_t below) {
  cluster_part p = c->part[node];
  for (uint32_t k = 0; k < 2; k++) {
    uint32_t at = (uint32_t)c->nodes++;
    c->up[at] = node;
    c->part[at] =
        k == 0 ? (cluster_part){p.first, below} : (cluster_part){p.first + below, p.n - below};
  }
}

/* Fills nodes and clusters; there is room for a node of each place, twice. */
static void grow(growing *g) {
  ylm_scene_clusters *c = g->c;
  uint32_t open[2 * STACK] = {0};
  size_t n = 1, below;
  c->nodes = 1;
  c->part[0] = (cluster_part){0, g->places->n};
  c->up[0] = 0;
  while (n > 0) {
    uint32_t at = open[--n];
    int axis;
    float middle;
    if (n + 2 > 2 * STACK || !split(g, &c->part[at], &axis, &middle, &below)) {
      c->node[at] = (cluster_node){INFINITY, at << AXIS_BITS | LEAF};
      c->cluster[at] = (uint32_t)c->clusters;
      c->leaf[c->clusters++] = at;
      continue;
    }
    c->node[at] = (cluster_node){middle, (uint32_t)c->nodes << AXIS_BITS | (uint32_t)axis};
    for (uint32_t k = 0; k < 2; k++) open[n++] = (uint32_t)c->nodes + k;
    branch(c, at, below);
  }
  /* as large as before, if that fails */
  ylm_list_resize(&c->node, c->nodes, c->nodes, sizeof *c->node);
  ylm_list_resize(&c->cluster, c->nodes, c->nodes, sizeof *c->cluster);
}

ylm_status ylm_scene_clusters_create(const ylm_scene_places *places, size_t most,
                                     ylm_scene_clusters **out) {
  size_t n = places->n;
  ylm_scene_clusters *c = *out = ylm_alloc_zero(1, sizeof *c);
  if (!c) return YLM_ENOMEM;
  c->list = ylm_alloc(n, sizeof *c->list);
  c->leaf = ylm_alloc(n, sizeof *c->leaf);
  c->part = ylm_alloc(2 * n, sizeof *c->part);
  c->up = ylm_alloc(2 * n, sizeof *c->up);
  c->node = ylm_alloc_zero(2 * n, sizeof *c->node);
  c->cluster = ylm_alloc_zero(2 * n, sizeof *c->cluster);
  if (!c->list || !c->leaf || !c->part || !c->up || !c->node || !c->cluster) {
    ylm_scene_clusters_free(c);
    *out = NULL;
    return YLM_ENOMEM;
  }
  for (size_t i = 0; i < n; i++) c->list[i] = (uint32_t)i;
  grow(&(growing){places, c, most});
  return YLM_OK;
}
