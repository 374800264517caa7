/* compact.c - the finished grid: nodes in numbers, rectangles, and a row for each class of corners. */
#include <math.h>

#include "surface.h"

/* How far a rectangle lies from another, of one chart. */
static double apart(const surface_branch *a, const surface_branch *b) {
  double d = 0;
  for (int k = 0; k < 3; k++) {
    double gap = fmax(0, fmax((double)b->lo[k] - a->hi[k], (double)a->lo[k] - b->hi[k]));
    d += gap * gap;
  }
  return d;
}

/* The first leaf of each chart's list, and the next one of a leaf's: the lists of leaves that have light. */
typedef struct lists {
  uint32_t *first, *next;
  size_t charts;
} lists;

static void sort_by_charts(const surface_bake *b, const lists *l) {
  for (size_t c = 0; c < l->charts; c++) l->first[c] = SURFACE_NONE;
  for (uint32_t i = (uint32_t)b->leaves; i-- > 0;) {
    uint32_t chart = b->branch[b->leaf[i].branch].chart;
    if (!b->leaf[i].sampled) continue;
    l->next[i] = l->first[chart];
    l->first[chart] = i;
  }
}

/* Rectangles by leaves. A leaf without light has its nearest neighbour's; SURFACE_NONE: its chart has none. */
static void number(const surface_bake *b, const lists *l, uint32_t *of) {
  uint32_t n = 0;
  for (size_t i = 0; i < b->leaves; i++) of[i] = b->leaf[i].sampled ? n++ : SURFACE_NONE;
  sort_by_charts(b, l);
  for (size_t i = 0; i < b->leaves; i++) {
    const surface_branch *x = &b->branch[b->leaf[i].branch];
    double least = INFINITY;
    if (b->leaf[i].sampled) continue;
    for (uint32_t k = l->first[x->chart]; k != SURFACE_NONE; k = l->next[k]) {
      double d = apart(x, &b->branch[b->leaf[k].branch]);
      if (d < least) least = d, of[i] = of[k];
    }
  }
}

/* Nodes have the branches' order: children follow each other there too. */
static void fill_nodes(const surface_bake *b, const uint32_t *of, ylm_surface_grid *g) {
  uint32_t planes = 0;
  for (size_t i = 0; i < b->branches; i++) {
    const surface_branch *n = &b->branch[i];
    uint32_t value = n->child;
    if (n->kind == NODE_RECTANGLE) value = of[n->leaf] == SURFACE_NONE ? 0 : of[n->leaf];
    if (n->kind == NODE_PLANE) {
      g->plane[planes] = (surface_plane){.child = n->child};
      memcpy(g->plane[planes].a, n->a, sizeof n->a);
      value = planes++;
    }
    g->node[i] = value << NODE_BITS | n->kind;
  }
  for (size_t c = 0; c < g->charts.charts; c++) g->root[c] = SURFACE_NONE;
  for (size_t i = 0; i < b->leaves; i++) {
    uint32_t chart = b->branch[b->leaf[i].branch].chart;
    if (b->leaf[i].sampled && g->root[chart] == SURFACE_NONE) {
      g->root[chart] = b->root[chart];
      g->stats.charts++;
    }
  }
}

static void fill_rectangles(const surface_bake *b, ylm_surface_grid *g) {
  size_t to = 0;
  for (size_t i = 0; i < b->leaves; i++) {
    const surface_leaf *l = &b->leaf[i];
    if (!l->sampled) continue;
    const surface_branch *n = &b->branch[l->branch];
    surface_rectangle *r = &g->rectangle[to++];
    r->chart = n->chart;
    memcpy(r->corner, l->corner, sizeof r->corner);
    for (int a = 0; a < 2; a++) r->lo[a] = n->lo[a], r->hi[a] = n->hi[a];
  }
  for (size_t k = 0; k < b->classes; k++) memcpy(g->row[k], b->class[k].value, sizeof g->row[k]);
}

ylm_status ylm__surface_compact(surface_bake *b, ylm_surface_grid **out) {
  ylm_surface_grid *g = ylm_alloc_zero(1, sizeof *g);
  uint32_t *of = ylm_alloc(b->leaves, sizeof *of);
  lists l = {ylm_alloc(b->charts.charts, sizeof *l.first), ylm_alloc(b->leaves, sizeof *l.next),
             b->charts.charts};
  size_t planes = 0, rectangles = 0;
  for (size_t i = 0; i < b->branches; i++) planes += b->branch[i].kind == NODE_PLANE;
  for (size_t i = 0; i < b->leaves; i++) rectangles += b->leaf[i].sampled > 0;
  if (g) {
    g->charts = b->charts;
    b->charts = (surface_charts){.scene = NULL};
    g->stats = b->stats;
    g->nodes = b->branches;
    g->planes = planes;
    g->root = ylm_alloc(g->charts.charts, sizeof *g->root);
    g->node = ylm_alloc(b->branches, sizeof *g->node);
    g->plane = ylm_alloc(planes, sizeof *g->plane);
    g->rectangle = ylm_alloc(rectangles, sizeof *g->rectangle);
    g->row = ylm_alloc(b->classes, sizeof *g->row);
  }
  ylm_status s =
      g && of && l.first && l.next && g->root && g->node && g->plane && g->rectangle && g->row
          ? YLM_OK
          : YLM_ENOMEM;
  if (s == YLM_OK) {
    g->stats.rectangles = rectangles;
    g->stats.corners = b->unknowns;
    g->stats.rows = b->classes;
    number(b, &l, of);
    fill_nodes(b, of, g);
    fill_rectangles(b, g);
    ylm__surface_weigh(g);
  }
  ylm_free(of);
  ylm_free(l.first);
  ylm_free(l.next);
  if (s != YLM_OK) ylm_surface_free(g);
  *out = s == YLM_OK ? g : NULL;
  return s;
}
