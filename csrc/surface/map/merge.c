/*
** merge.c - fine triangles of one chart become few: convex pieces of the lattice, whose borders keep the corners of all others.
**
** Rows of fine triangles of one chart are runs; runs that lie over each other become one piece as long as it is convex. A place
** of an edge of the mesh that a piece begins or ends at is a corner of the triangles on both sides, so that no gap opens there.
*/
#include <stdlib.h>

#include "map.h"

#define ROWS (MAP_FINE_MOST + 1)
#define BORDER (4 * ROWS)
/* How far a vertex may be from where the chart's plane has it, in texels. */
#define PLANE_NEAR 0.02

/* Part of a triangle's lattice from row `low` to `high`: left and right ends at each. */
typedef struct piece {
  uint32_t chart;
  int low, high, left[ROWS], right[ROWS];
} piece;

/* A place of an edge between two vertices of the mesh, num/den of the way from the lower one. */
typedef struct knot {
  uint32_t low, high, num, den;
} knot;

typedef struct merger {
  const ylm_surface_map *m;
  size_t sheet;
  const map_sheet *s;
  map_split *split;
  const uint32_t *name; /* [vertices of the mesh] one for all at a place */
  uint32_t *old;        /* [fine][3] split->index as it was */
  size_t *first;        /* [triangles] where its lattice's marks begin */
  uint8_t *mark;        /* 1: a corner of a piece */
  knot *knot;
  size_t knots, knot_room, index_room, vertex_room;
} merger;

static int row_of(int n, int j) { return j * (n + 1) - j * (j - 1) / 2; }
static size_t fine_of(const map_sheet *s, size_t t, int j, int k) {
  int n = s->parts[t];
  return s->first[t] + (size_t)(n * n - (n - j) * (n - j) + k);
}

/* The places of the lattice at the corners of the k-th triangle of row j, in its order. */
static void corners_of(int j, int k, int at[3][2]) {
  int i = k / 2, turned = k % 2;
  const int own[2][3][2] = {{{i, j}, {i + 1, j}, {i, j + 1}},
                            {{i + 1, j + 1}, {i, j + 1}, {i + 1, j}}};
  memcpy(at, own[turned], sizeof own[turned]);
}

/* -- pieces ------------------------------------------------------------------------------------------- */

/* Whether the fine triangles of each chart lie on one plane of the texture, as they do where charts are flat. */
static bool is_plain(const merger *g, size_t t) {
  const map_sheet *s = g->s;
  const ylm_unwrap *u = g->m->charts;
  int n = s->parts[t];
  uint32_t known = YLM_UNWRAP_NONE;
  double zero[2] = {0, 0}, step[2][2] = {{0, 0}, {0, 0}};
  for (int j = 0; j < n; j++)
    for (int k = 0; k < 2 * (n - j) - 1; k++) {
      double c[3][2];
      int at[3][2];
      size_t f = fine_of(s, t, j, k);
      uint32_t chart = ylm_unwrap_chart(u, g->sheet, f);
      if (chart == YLM_UNWRAP_NONE) return false;
      ylm_unwrap_corners(u, g->sheet, f, c);
      corners_of(j, k, at);
      double sign = k % 2 ? -1 : 1;
      for (int a = 0; chart != known && a < 2; a++) {
        for (int axis = 0; axis < 2; axis++) step[axis][a] = sign * (c[axis + 1][a] - c[0][a]);
        zero[a] = c[0][a] - at[0][0] * step[0][a] - at[0][1] * step[1][a];
      }
      known = chart;
      for (int v = 0; v < 3; v++)
        for (int a = 0; a < 2; a++)
          if (fabs(zero[a] + at[v][0] * step[0][a] + at[v][1] * step[1][a] - c[v][a]) > PLANE_NEAR)
            return false;
    }
  return true;
}

/* Adds a run to the piece that it continues, or as a new one. */
static void add_run(piece *list, size_t *n, uint32_t chart, int j, int from, int to, bool plain) {
  int bottom[2] = {from / 2 + from % 2, (to - 1) / 2 + 1};
  int top[2] = {from / 2, (to - 1) / 2 + (to - 1) % 2};
  for (size_t i = 0; plain && i < *n; i++) {
    piece *p = &list[i];
    int h = p->high - p->low;
    if (p->chart != chart || p->high != j || p->left[h] != bottom[0] || p->right[h] != bottom[1] ||
        bottom[0] == bottom[1])
      continue;
    if (top[0] - bottom[0] < p->left[h] - p->left[h - 1] ||
        top[1] - bottom[1] > p->right[h] - p->right[h - 1])
      continue;
    p->high++;
    p->left[h + 1] = top[0];
    p->right[h + 1] = top[1];
    return;
  }
  list[(*n)++] = (piece){.chart = chart,
                         .low = j,
                         .high = j + 1,
                         .left = {bottom[0], top[0]},
                         .right = {bottom[1], top[1]}};
}

/* The pieces of a triangle; list: room for as many as it has fine ones. */
static size_t find_pieces(const merger *g, size_t t, piece *list) {
  int n = g->s->parts[t];
  size_t count = 0;
  bool plain = is_plain(g, t);
  for (int j = 0; j < n; j++) {
    int all = 2 * (n - j) - 1;
    for (int from = 0, to; from < all; from = to) {
      uint32_t chart = ylm_unwrap_chart(g->m->charts, g->sheet, fine_of(g->s, t, j, from));
      for (to = from + 1;
           plain && to < all &&
           ylm_unwrap_chart(g->m->charts, g->sheet, fine_of(g->s, t, j, to)) == chart;)
        to++;
      add_run(list, &count, chart, j, from, to, plain);
    }
  }
  return count;
}

/* The places of the lattice along the border of a piece, counter-clockwise; how many. */
static size_t walk(const piece *p, int at[BORDER][2]) {
  size_t n = 0;
  int rows = p->high - p->low;
  for (int x = p->left[0]; x <= p->right[0]; x++) at[n][0] = x, at[n++][1] = p->low;
  for (int y = 1; y < rows; y++) at[n][0] = p->right[y], at[n++][1] = p->low + y;
  for (int x = p->right[rows]; x >= p->left[rows]; x--) at[n][0] = x, at[n++][1] = p->high;
  for (int y = rows - 1; y > 0; y--) at[n][0] = p->left[y], at[n++][1] = p->low + y;
  return n;
}

/* Marks the corners of a triangle's pieces. */
static void mark_corners(const piece *p, int parts, uint8_t *mark) {
  int at[BORDER][2];
  size_t n = walk(p, at);
  for (size_t i = 0; i < n; i++) {
    const int *a = at[(i + n - 1) % n], *b = at[i], *c = at[(i + 1) % n];
    if ((b[0] - a[0]) * (c[1] - b[1]) != (b[1] - a[1]) * (c[0] - b[0]))
      mark[row_of(parts, b[1]) + b[0]] = 1;
  }
}

/* -- edges of the mesh ---------------------------------------------------------------------------------- */

/* The place k of n along edge e of a lattice. */
static int on_edge(int n, int e, int k) {
  return e == 0 ? k : e == 1 ? row_of(n, k) + n - k : row_of(n, n - k);
}

/* The names of an edge's ends in order; whether they are exchanged for that. */
static bool ends_of(const merger *g, size_t t, int e, knot *out) {
  const uint32_t *of = ylm_scene_triangle(g->m->scene, g->s->mesh, t);
  uint32_t a = g->name[of[map_corner(g->s->back, e)]],
           b = g->name[of[map_corner(g->s->back, (e + 1) % 3)]];
  out->low = a < b ? a : b;
  out->high = a < b ? b : a;
  return b < a;
}

static int by_place(const void *a, const void *b) {
  const knot *p = a, *q = b;
  if (p->low != q->low) return p->low < q->low ? -1 : 1;
  if (p->high != q->high) return p->high < q->high ? -1 : 1;
  uint64_t x = (uint64_t)p->num * q->den, y = (uint64_t)q->num * p->den;
  return x < y ? -1 : x > y;
}

/* Lists the marks on the edges of a triangle. */
static ylm_status list_knots(merger *g, size_t t) {
  int n = g->s->parts[t];
  for (int e = 0; e < 3; e++) {
    knot own = {0, 0, 0, (uint32_t)n};
    bool back = ends_of(g, t, e, &own);
    for (int k = 1; k < n; k++) {
      if (!g->mark[g->first[t] + (size_t)on_edge(n, e, k)]) continue;
      if (!ylm_list_reserve(&g->knot, g->knots, g->knots + 1, &g->knot_room, sizeof *g->knot))
        return YLM_ENOMEM;
      own.num = (uint32_t)(back ? n - k : k);
      g->knot[g->knots++] = own;
    }
  }
  return YLM_OK;
}

/* The knots of an edge: the first, and how many. */
static size_t find_knots(const merger *g, const knot *edge, size_t *first) {
  size_t low = 0, high = g->knots, n = 0;
  while (low < high) {
    size_t mid = (low + high) / 2;
    const knot *k = &g->knot[mid];
    if (k->low < edge->low || (k->low == edge->low && k->high < edge->high))
      low = mid + 1;
    else
      high = mid;
  }
  *first = low;
  while (low + n < g->knots && g->knot[low + n].low == edge->low &&
         g->knot[low + n].high == edge->high)
    n++;
  return n;
}

/* Marks what the triangles beside one have marked on their edges. */
static void take_knots(merger *g, size_t t) {
  uint32_t n = g->s->parts[t];
  for (int e = 0; n > 1 && e < 3; e++) {
    knot own = {0, 0, 0, 0};
    size_t first;
    bool back = ends_of(g, t, e, &own);
    size_t count = find_knots(g, &own, &first);
    for (size_t i = first; i < first + count; i++) {
      uint32_t k = g->knot[i].num * n;
      if (k % g->knot[i].den) continue;
      k /= g->knot[i].den;
      g->mark[g->first[t] + (size_t)on_edge((int)n, e, (int)(back ? n - k : k))] = 1;
    }
  }
}

/* -- triangles ------------------------------------------------------------------------------------------ */

/* A corner of a convex border: where it is on the triangle, and its vertex. */
typedef struct corner {
  double u, v;
  uint32_t vertex;
} corner;

static double area_of(const corner *a, const corner *b, const corner *c) {
  return (b->u - a->u) * (c->v - a->v) - (b->v - a->v) * (c->u - a->u);
}

static ylm_status add_triangle(merger *g, uint32_t a, uint32_t b, uint32_t c) {
  map_split *s = g->split;
  if (!ylm_list_reserve(&s->index, 3 * s->triangles, 3 * s->triangles + 3, &g->index_room,
                        sizeof *s->index))
    return YLM_ENOMEM;
  uint32_t *to = s->index + 3 * s->triangles++;
  to[0] = a, to[1] = b, to[2] = c;
  return YLM_OK;
}

/* Triangles of a convex border: the smallest ear first, so that no line is left. */
static ylm_status add_ears(merger *g, corner *c, size_t n) {
  ylm_status s = YLM_OK;
  while (s == YLM_OK && n > 3) {
    size_t ear = n;
    double least = INFINITY;
    for (size_t i = 0; i < n; i++) {
      double area = area_of(&c[(i + n - 1) % n], &c[i], &c[(i + 1) % n]);
      if (area > 1e-9 && area < least) least = area, ear = i;
    }
    if (ear == n) return YLM_OK; /* a line */
    s = add_triangle(g, c[(ear + n - 1) % n].vertex, c[ear].vertex, c[(ear + 1) % n].vertex);
    memmove(c + ear, c + ear + 1, (n - ear - 1) * sizeof *c);
    n--;
  }
  return s == YLM_OK ? add_triangle(g, c[0].vertex, c[1].vertex, c[2].vertex) : s;
}

/* The vertex that a piece has at a place of the lattice. */
static uint32_t vertex_at(const merger *g, size_t t, const piece *p, const int place[2]) {
  int n = g->s->parts[t];
  for (int j = place[1] - 1; j <= place[1]; j++)
    for (int k = 2 * place[0] - 2; k <= 2 * place[0] + 1; k++) {
      int at[3][2];
      if (j < p->low || j >= p->high || k < 0 || k >= 2 * (n - j) - 1) continue;
      size_t f = fine_of(g->s, t, j, k);
      if (ylm_unwrap_chart(g->m->charts, g->sheet, f) != p->chart) continue;
      corners_of(j, k, at);
      for (int c = 0; c < 3; c++)
        if (at[c][0] == place[0] && at[c][1] == place[1]) return g->old[3 * f + (size_t)c];
    }
  return 0;
}

static ylm_status add_piece(merger *g, size_t t, const piece *p) {
  int n = g->s->parts[t], at[BORDER][2];
  corner c[BORDER];
  size_t all = walk(p, at), count = 0;
  for (size_t i = 0; i < all; i++)
    if (g->mark[g->first[t] + (size_t)(row_of(n, at[i][1]) + at[i][0])])
      c[count++] = (corner){at[i][0], at[i][1], vertex_at(g, t, p, at[i])};
  return add_ears(g, c, count);
}

/* A vertex at num/den of edge e of a triangle that is not cut. */
static ylm_status add_vertex(merger *g, size_t t, int e, uint32_t num, uint32_t den, corner *out) {
  map_split *s = g->split;
  const uint32_t *own = g->old + 3 * (size_t)g->s->first[t],
                 *of = ylm_scene_triangle(g->m->scene, g->s->mesh, t);
  size_t room = g->vertex_room;
  if (!ylm_list_reserve(&s->uv, s->vertices, s->vertices + 1, &room, 2 * sizeof *s->uv) ||
      !ylm_list_reserve(&s->mix, s->vertices, s->vertices + 1, &g->vertex_room, sizeof *s->mix))
    return YLM_ENOMEM;
  uint32_t a = own[e], b = own[(e + 1) % 3], v = (uint32_t)s->vertices++;
  double part = (double)num / den, at[3] = {0, 0, 0};
  for (size_t k = 0; k < 2; k++)
    s->uv[2 * v + k] =
        (float)((1 - part) * (double)s->uv[2 * a + k] + part * (double)s->uv[2 * b + k]);
  ylm_mesh_mix mix = {{0, 0, 0}, {0, 0, 0}};
  for (int k = 0; k < 3; k++) mix.of[k] = of[map_corner(g->s->back, k)];
  mix.part[e] = den - num;
  mix.part[(e + 1) % 3] = num;
  s->mix[v] = mix;
  at[e] = 1 - part, at[(e + 1) % 3] = part;
  *out = (corner){at[1], at[2], v};
  return YLM_OK;
}

/* A triangle that is not cut, with the knots of its edges. */
static ylm_status add_whole(merger *g, size_t t) {
  const uint32_t *own = g->old + 3 * (size_t)g->s->first[t];
  size_t first[3], count[3], n = 0;
  bool back[3];
  for (int e = 0; e < 3; e++) {
    knot edge = {0, 0, 0, 0};
    back[e] = ends_of(g, t, e, &edge);
    count[e] = find_knots(g, &edge, &first[e]);
  }
  if (count[0] + count[1] + count[2] == 0 ||
      ylm_unwrap_chart(g->m->charts, g->sheet, g->s->first[t]) == YLM_UNWRAP_NONE)
    return add_triangle(g, own[0], own[1], own[2]);
  corner *c = ylm_alloc(3 + count[0] + count[1] + count[2], sizeof *c);
  ylm_status s = c ? YLM_OK : YLM_ENOMEM;
  for (int e = 0; s == YLM_OK && e < 3; e++) {
    c[n++] = (corner){e == 1, e == 2, own[e]};
    for (size_t i = 0; s == YLM_OK && i < count[e]; i++) {
      const knot *k = &g->knot[back[e] ? first[e] + count[e] - 1 - i : first[e] + i];
      s = add_vertex(g, t, e, back[e] ? k->den - k->num : k->num, k->den, &c[n++]);
    }
  }
  if (s == YLM_OK) s = add_ears(g, c, n);
  ylm_free(c);
  return s;
}

/* -- the whole ------------------------------------------------------------------------------------------- */

/* Leaves out vertices that no triangle has. */
static ylm_status drop_unused(map_split *s) {
  uint32_t *number = ylm_alloc(s->vertices, sizeof *number), n = 0;
  if (!number) return YLM_ENOMEM;
  memset(number, 0xff, s->vertices * sizeof *number);
  for (size_t i = 0; i < 3 * s->triangles; i++) number[s->index[i]] = 0;
  for (size_t i = 0; i < s->vertices; i++) {
    if (number[i]) continue;
    s->mix[n] = s->mix[i];
    memmove(s->uv + 2 * (size_t)n, s->uv + 2 * i, 2 * sizeof *s->uv);
    number[i] = n++;
  }
  for (size_t i = 0; i < 3 * s->triangles; i++) s->index[i] = number[s->index[i]];
  s->vertices = n;
  ylm_free(number);
  return YLM_OK;
}

/* The marks of all triangles, and the places of edges that are among them. */
static ylm_status mark_all(merger *g, piece *list) {
  const map_sheet *s = g->s;
  ylm_status status = YLM_OK;
  for (size_t t = 0; status == YLM_OK && t < s->triangles; t++) {
    if (s->parts[t] == 1) continue;
    size_t n = find_pieces(g, t, list);
    for (size_t i = 0; i < n; i++) mark_corners(&list[i], s->parts[t], g->mark + g->first[t]);
    status = list_knots(g, t);
  }
  if (status != YLM_OK || !g->knots) return status;
  qsort(g->knot, g->knots, sizeof *g->knot, by_place);
  size_t kept = 1;
  for (size_t i = 1; i < g->knots; i++)
    if (by_place(&g->knot[i], &g->knot[kept - 1])) g->knot[kept++] = g->knot[i];
  g->knots = kept;
  for (size_t t = 0; t < s->triangles; t++) take_knots(g, t);
  return YLM_OK;
}

static ylm_status merge_all(merger *g) {
  const map_sheet *s = g->s;
  size_t marks = 0, most = 1;
  g->first = ylm_alloc(s->triangles, sizeof *g->first);
  if (!g->first) return YLM_ENOMEM;
  for (size_t t = 0; t < s->triangles; t++) {
    size_t n = s->parts[t];
    g->first[t] = marks;
    marks += (n + 1) * (n + 2) / 2;
    if (n * n > most) most = n * n;
  }
  g->mark = ylm_alloc_zero(marks, 1);
  piece *list = ylm_alloc(most, sizeof *list);
  ylm_status status = g->mark && list ? mark_all(g, list) : YLM_ENOMEM;
  for (size_t t = 0; status == YLM_OK && t < s->triangles; t++) {
    if (s->parts[t] == 1) {
      status = add_whole(g, t);
      continue;
    }
    size_t n = find_pieces(g, t, list);
    for (size_t i = 0; status == YLM_OK && i < n; i++) status = add_piece(g, t, &list[i]);
  }
  ylm_free(list);
  return status == YLM_OK ? drop_unused(g->split) : status;
}

ylm_status ylm__map_merge(const ylm_surface_map *m, size_t sheet, const ylm_mesh *mesh,
                          map_split *split) {
  merger g = {.m = m, .sheet = sheet, .s = &m->sheet[sheet], .split = split};
  if (g.s->fine == g.s->triangles) return YLM_OK; /* none is cut */
  uint32_t *name = ylm_alloc(mesh->vertices, sizeof *name);
  size_t places;
  ylm_status s = name ? ylm_mesh_weld(mesh->vertices, mesh->position, name, &places) : YLM_ENOMEM;
  g.name = name;
  g.old = split->index;
  g.vertex_room = split->vertices;
  split->index = NULL;
  split->triangles = 0;
  if (s == YLM_OK) s = merge_all(&g);
  ylm_free(name), ylm_free(g.old), ylm_free(g.first), ylm_free(g.mark), ylm_free(g.knot);
  return s;
}
