/* crease.c - normals of meshes that come without: smooth, but for edges where triangles meet sharply. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ylm_geom.h"
#include "ylm_list.h"
#include "ylm_vector.h"

/* Normals with a cosine of this or more are those of one plane, rounded: 0.26 degrees. */
#define EVEN 0.99999

/* Triangles at an edge, all of whose pairs are compared. */
#define FEW 8

/* A side of a triangle: from corner `at` (3 * triangle + k) to the next one. */
typedef struct side {
  uint32_t to, at;
} side;

typedef struct creases {
  const ylm_mesh *mesh;
  const uint32_t *group; /* NULL: angles alone decide */
  double cosine;         /* smooth where normals' cosine is at least this */
  double *normal;        /* [triangles][3] unit, or zero */
  size_t *first;    /* [vertices + 1]: of the sides that begin or end there, by the lower end */
  side *side;       /* [3 * triangles] */
  uint32_t *parent; /* [3 * triangles] corners that share a normal: union-find */
} creases;

/* Corners a and b share a normal from now on; the first of them all stands for them. */
static void join(creases *c, uint32_t a, uint32_t b) {
  a = ylm_list_root(c->parent, a), b = ylm_list_root(c->parent, b);
  c->parent[a > b ? a : b] = a < b ? a : b;
}

static uint32_t next_corner(uint32_t i) { return i % 3 == 2 ? i - 2 : i + 1; }

/* The lower end of the side that begins at corner i. */
static uint32_t lower_end(const ylm_mesh *m, uint32_t i) {
  uint32_t a = m->index[i], b = m->index[next_corner(i)];
  return a < b ? a : b;
}

/* Whether triangles s and t share normals at the edge where they meet. */
static bool is_smooth(const creases *c, uint32_t s, uint32_t t) {
  const double *p = c->normal + 3 * (size_t)s, *q = c->normal + 3 * (size_t)t;
  uint32_t group = c->group ? c->group[s] : YLM_MESH_BY_ANGLE;
  if (c->group && c->group[t] != group) return false;
  if (group != YLM_MESH_BY_ANGLE && group != YLM_MESH_FLAT) return true;
  if (ylm_dot3d(p, p) == 0 || ylm_dot3d(q, q) == 0) return true; /* no normal of its own */
  return ylm_dot3d(p, q) >= (group == YLM_MESH_FLAT ? EVEN : c->cosine);
}

static int by_other_end(const void *a, const void *b) {
  const side *p = a, *q = b;
  if (p->to != q->to) return p->to < q->to ? -1 : 1;
  return p->at < q->at ? -1 : p->at > q->at;
}

/* Lists the sides by their lower ends. */
static void list_sides(creases *c) {
  const ylm_mesh *m = c->mesh;
  uint32_t n = (uint32_t)(3 * m->triangles);
  for (uint32_t i = 0; i < n; i++) c->first[lower_end(m, i) + 1]++;
  for (size_t v = 0; v < m->vertices; v++) c->first[v + 1] += c->first[v];
  for (uint32_t i = n; i-- > 0;) {
    uint32_t low = lower_end(m, i), a = m->index[i], b = m->index[next_corner(i)];
    c->side[--c->first[low + 1]] = (side){a < b ? b : a, i};
  }
  /* each entry now holds where its vertex begins, one place late */
  memmove(c->first, c->first + 1, m->vertices * sizeof *c->first);
  c->first[m->vertices] = n;
}

/* Joins the corners at both ends of an edge that two triangles share. */
static void join_edge(creases *c, uint32_t a, uint32_t b) {
  const uint32_t *index = c->mesh->index;
  bool same_way = index[a] == index[b];
  if (!is_smooth(c, a / 3, b / 3)) return;
  join(c, a, same_way ? b : next_corner(b));
  join(c, next_corner(a), same_way ? next_corner(b) : b);
}

/* Joins what n triangles have at one edge: every pair of few, neighbours in the list of many. */
static void join_pairs(creases *c, const side *s, size_t n) {
  for (size_t i = 0; i < n; i++)
    for (size_t j = i + 1; j < n && (n <= FEW || j == i + 1); j++) join_edge(c, s[i].at, s[j].at);
}

static void join_edges(creases *c) {
  for (size_t v = 0; v < c->mesh->vertices; v++) {
    side *s = c->side + c->first[v], *end = c->side + c->first[v + 1];
    if (end - s > 1) qsort(s, (size_t)(end - s), sizeof *s, by_other_end);
    for (side *stop; s < end; s = stop) {
      for (stop = s; stop < end && stop->to == s->to;) stop++;
      if (s->to != v) join_pairs(c, s, (size_t)(stop - s));
    }
  }
}

/* Unit normals of the triangles; zero where there is none. */
static void find_normals(creases *c) {
  const ylm_mesh *m = c->mesh;
  for (size_t t = 0; t < m->triangles; t++) {
    double *n = c->normal + 3 * t;
    ylm_mesh_area_vector(m, t, n);
    if (!ylm_unit3(n)) n[0] = n[1] = n[2] = 0;
  }
}

/* Names a vertex for each normal: the first of a place keeps its number, others follow the last vertex.
   from[k] is the vertex that vertex k of `index` is a copy of; returns how many there are. */
static size_t number(creases *c, uint32_t *from, uint32_t *index) {
  const ylm_mesh *m = c->mesh;
  size_t n = 3 * m->triangles, count = m->vertices;
  for (size_t v = 0; v < m->vertices; v++) from[v] = UINT32_MAX;
  for (uint32_t i = 0; i < n; i++) {
    uint32_t v = m->index[i];
    if (ylm_list_root(c->parent, i) != i)
      index[i] = index[ylm_list_root(c->parent, i)];
    else if (from[v] == UINT32_MAX)
      index[i] = from[v] = v;
    else
      from[count] = v, index[i] = (uint32_t)count++;
  }
  for (size_t v = 0; v < m->vertices; v++) from[v] = (uint32_t)v;
  return count;
}

/* rows[k] = old[from[k]]; NULL stays NULL. */
static bool copy_rows(float **rows, size_t width, size_t count, const uint32_t *from) {
  if (!*rows) return true;
  float *out = ylm_alloc(count * width, sizeof *out);
  if (!out) return false;
  for (size_t k = 0; k < count; k++)
    memcpy(out + k * width, *rows + from[k] * width, width * sizeof *out);
  ylm_free(*rows);
  *rows = out;
  return true;
}

/* Gives each normal a vertex of its own. */
static ylm_status split(creases *c, ylm_mesh *m) {
  size_t n = 3 * m->triangles;
  uint32_t *from = ylm_alloc(m->vertices + n, sizeof *from), *index = ylm_alloc(n, sizeof *index);
  bool made = from && index;
  if (made) {
    size_t count = number(c, from, index);
    made = count == m->vertices ||
           (copy_rows(&m->position, 3, count, from) && copy_rows(&m->uv, 2, count, from) &&
            copy_rows(&m->colour, 3, count, from) && copy_rows(&m->normal, 3, count, from));
    if (made) {
      memcpy(m->index, index, n * sizeof *index);
      m->vertices = count;
    }
  }
  ylm_free(from);
  ylm_free(index);
  return made ? YLM_OK : YLM_ENOMEM;
}

ylm_status ylm_mesh_make_creased_normals(ylm_mesh *m, double degrees, const uint32_t *group) {
  size_t n = 3 * m->triangles;
  if (degrees >= 180 && !group) return ylm_mesh_make_normals(m);
  creases c = {.mesh = m,
               .group = group,
               .cosine = degrees < 180 ? fmin(EVEN, cos(degrees * (YLM_PI / 180))) : -2,
               .normal = ylm_alloc(n, sizeof(double)),
               .first = ylm_alloc_zero(m->vertices + 1, sizeof(size_t)),
               .side = ylm_alloc(n, sizeof(side)),
               .parent = ylm_alloc(n, sizeof(uint32_t))};
  ylm_status s = c.normal && c.first && c.side && c.parent ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) {
    for (uint32_t i = 0; i < n; i++) c.parent[i] = i;
    find_normals(&c);
    list_sides(&c);
    join_edges(&c);
    s = split(&c, m);
  }
  ylm_free(c.normal);
  ylm_free(c.first);
  ylm_free(c.side);
  ylm_free(c.parent);
  return s == YLM_OK ? ylm_mesh_make_normals(m) : s;
}
