/* weld.c - vertices at one place, and whether triangles close around something. */
#include <stdlib.h>

#include "ylm_geom.h"

/* -- places ------------------------------------------------------------------------------------ */

typedef struct place {
  float at[3];
  uint32_t vertex;
} place;

static int by_place(const void *a, const void *b) {
  const place *p = a, *q = b;
  for (int k = 0; k < 3; k++)
    if (p->at[k] != q->at[k]) return p->at[k] < q->at[k] ? -1 : 1;
  return 0;
}

ylm_status ylm_mesh_weld(size_t vertices, const float *position, uint32_t *name, size_t *places) {
  place *p = ylm_alloc(vertices, sizeof *p);
  *places = 0;
  if (!p) return YLM_ENOMEM;
  for (size_t i = 0; i < vertices; i++) {
    for (size_t a = 0; a < 3; a++) p[i].at[a] = position[3 * i + a] + 0.0f; /* no -0 */
    p[i].vertex = (uint32_t)i;
  }
  qsort(p, vertices, sizeof *p, by_place);
  for (size_t i = 0; i < vertices; i++) {
    if (!i || by_place(&p[i - 1], &p[i])) ++*places;
    name[p[i].vertex] = (uint32_t)*places - 1;
  }
  ylm_free(p);
  return YLM_OK;
}

/* -- edges ------------------------------------------------------------------------------------- */

typedef struct edge {
  uint32_t low, high;
  int way; /* 1: from low to high */
} edge;

static int by_ends(const void *a, const void *b) {
  const edge *p = a, *q = b;
  if (p->low != q->low) return p->low < q->low ? -1 : 1;
  return p->high < q->high ? -1 : p->high > q->high;
}

ylm_status ylm_mesh_open_edges(size_t triangles, const uint32_t *index, const uint32_t *name,
                               size_t *open) {
  edge *list = ylm_alloc(triangles, 3 * sizeof *list);
  size_t n = 0;
  *open = 0;
  if (!list) return YLM_ENOMEM;
  for (size_t i = 0; i < 3 * triangles; i++) {
    uint32_t a = name[index[i]], b = name[index[i % 3 == 2 ? i - 2 : i + 1]];
    if (a != b) list[n++] = a < b ? (edge){a, b, 1} : (edge){b, a, -1};
  }
  qsort(list, n, sizeof *list, by_ends);
  for (size_t i = 0; i < n;) {
    size_t end = i;
    int ways = 0;
    for (; end < n && !by_ends(&list[i], &list[end]); end++) ways += list[end].way;
    *open += ways != 0;
    i = end;
  }
  ylm_free(list);
  return YLM_OK;
}
