/* edges.c - edges that the polygons of a closed surface share. */
#include "flat.h"

#include <stdlib.h>
#include <string.h>

/* A vertex by its place. */
typedef struct corner {
  const double *at;
  uint32_t row, name;
} corner;

/* An edge of a polygon, by the names of its ends. */
typedef struct side {
  uint32_t low, high; /* names */
  bool turned;        /* it runs from high to low */
  ylm__flat_edge edge;
} side;

static int by_place(const void *a, const void *b) {
  const double *p = ((const corner *)a)->at, *q = ((const corner *)b)->at;
  for (int i = 0; i < 3; i++)
    if (p[i] != q[i]) return p[i] < q[i] ? -1 : 1;
  return 0;
}

static int by_row(const void *a, const void *b) {
  uint32_t p = ((const corner *)a)->row, q = ((const corner *)b)->row;
  return p < q ? -1 : p > q;
}

static int by_ends(const void *a, const void *b) {
  const side *p = a, *q = b;
  if (p->low != q->low) return p->low < q->low ? -1 : 1;
  if (p->high != q->high) return p->high < q->high ? -1 : 1;
  return p->edge.left < q->edge.left ? -1 : p->edge.left > q->edge.left;
}

/* Names vertices, in the order of rows: vertices at one place have one name. */
static void name(const ylm_polygons *p, size_t rows, corner *c) {
  uint32_t last = 0;
  for (size_t i = 0; i < rows; i++) c[i] = (corner){.at = p->vertices + 3 * i, .row = (uint32_t)i};
  qsort(c, rows, sizeof *c, by_place);
  for (size_t i = 0; i < rows; i++) {
    if (i && by_place(&c[i - 1], &c[i]) != 0) last++;
    c[i].name = last;
  }
  qsort(c, rows, sizeof *c, by_row);
}

static void list_sides(const ylm_polygons *p, const corner *c, side *s) {
  for (size_t f = 0; f < p->n; f++)
    for (int i = 0; i < p->sides[f]; i++, s++) {
      uint32_t from = (uint32_t)p->first[f] + (uint32_t)i,
               to = (uint32_t)p->first[f] + (uint32_t)((i + 1) % p->sides[f]);
      uint32_t a = c[from].name, b = c[to].name;
      *s = (side){a < b ? a : b, a < b ? b : a, b < a, {from, to, (uint32_t)f, 0}};
    }
}

/* Do edges come in pairs of opposite directions? */
static bool pair(size_t n, const side *s, ylm__flat_edge *edge) {
  for (size_t i = 0; i < n; i += 2) {
    bool same = i + 1 < n && s[i].low == s[i + 1].low && s[i].high == s[i + 1].high;
    bool more = i + 2 < n && s[i].low == s[i + 2].low && s[i].high == s[i + 2].high;
    if (!same || more || s[i].low == s[i].high || s[i].turned == s[i + 1].turned) return false;
    edge[i / 2] = s[i].edge;
    edge[i / 2].right = s[i + 1].edge.left;
  }
  return true;
}

/* Edges that are summed: of lights that are the same to all points. */
static size_t count_rows(const ylm_polygons *p) {
  size_t rows = 0;
  if (!p->exact || p->clipped) return 0;
  for (size_t i = 0; i < p->n; i++) {
    bool same = memcmp(p->radiance, p->radiance + 3 * i, 3 * sizeof *p->radiance) == 0;
    if (!p->sides[i] || !same) return 0;
    rows += (size_t)p->sides[i];
  }
  return rows <= UINT32_MAX / 2 ? rows : 0;
}

ylm_status ylm_polygons_join(ylm_polygons *p) {
  size_t rows = count_rows(p);
  if (!rows || p->edges) return YLM_OK;
  corner *c = ylm_alloc(rows, sizeof *c);
  side *s = ylm_alloc(rows, sizeof *s);
  ylm__flat_edge *edge = ylm_alloc(rows / 2 + 1, sizeof *edge);
  bool ok = c && s && edge;
  if (ok) {
    name(p, rows, c);
    list_sides(p, c, s);
    qsort(s, rows, sizeof *s, by_ends);
    if (pair(rows, s, edge)) {
      p->edge = edge;
      p->edges = rows / 2;
      edge = NULL;
    }
  }
  ylm_free(c);
  ylm_free(s);
  ylm_free(edge);
  return ok ? YLM_OK : YLM_ENOMEM;
}
