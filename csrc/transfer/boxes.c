/* boxes.c - which boxes meet triangles that occlude: where leaves of grids are crossed. */
#include <stdlib.h>

#include "calibration.h"
#include "transfer.h"
#include "ylm_vector.h"

typedef struct corner3 {
  float p[3][3];
} corner3;

/* Triangles first .. first+n-1 of a node, or n = 0 and two children one after the other. */
typedef struct meets_node {
  float lo[3], hi[3];
  uint32_t first, n;
} meets_node;

struct transfer_boxes {
  corner3 *triangle;
  meets_node *node;
  size_t triangles, nodes;
};

static float middle_of(const corner3 *t, int a) { return t->p[0][a] + t->p[1][a] + t->p[2][a]; }

static int compare(const void *x, const void *y, int a) {
  float p = middle_of(x, a), q = middle_of(y, a);
  return (p > q) - (p < q);
}
static int by_x(const void *x, const void *y) { return compare(x, y, 0); }
static int by_y(const void *x, const void *y) { return compare(x, y, 1); }
static int by_z(const void *x, const void *y) { return compare(x, y, 2); }

static void build(struct transfer_boxes *m, size_t at, size_t first, size_t n) {
  static int (*const by[3])(const void *, const void *) = {by_x, by_y, by_z};
  meets_node *node = &m->node[at];
  for (int a = 0; a < 3; a++) node->lo[a] = INFINITY, node->hi[a] = -INFINITY;
  for (size_t i = first; i < first + n; i++)
    for (int k = 0; k < 3; k++)
      for (int a = 0; a < 3; a++) {
        node->lo[a] = fminf(node->lo[a], m->triangle[i].p[k][a]);
        node->hi[a] = fmaxf(node->hi[a], m->triangle[i].p[k][a]);
      }
  node->first = (uint32_t)first;
  node->n = n > MEETS_LEAF ? 0 : (uint32_t)n;
  if (n <= MEETS_LEAF) return;
  int longest = 0;
  for (int a = 1; a < 3; a++)
    if (node->hi[a] - node->lo[a] > node->hi[longest] - node->lo[longest]) longest = a;
  qsort(m->triangle + first, n, sizeof *m->triangle, by[longest]);
  size_t child = m->nodes;
  m->nodes += 2;
  node->first = (uint32_t)child;
  build(m, child, first, n / 2);
  build(m, child + 1, first + n / 2, n - n / 2);
}

static void fill(struct transfer_boxes *m, const ylm_scene *s, const float *vertex) {
  for (size_t i = 0; i < ylm_scene_meshes(s); i++)
    for (size_t k = 0; ylm_scene_occludes(s, i) && k < ylm_scene_triangles(s, i); k++) {
      const uint32_t *corner = ylm_scene_triangle(s, i, k);
      for (int c = 0; c < 3; c++)
        memcpy(m->triangle[m->triangles].p[c],
               vertex + 3 * (ylm_scene_first_vertex(s, i) + corner[c]), 12);
      m->triangles++;
    }
}

ylm_status ylm__boxes_create(const ylm_scene *s, struct transfer_boxes **out) {
  size_t n = 0;
  for (size_t i = 0; i < ylm_scene_meshes(s); i++) n += ylm_scene_triangles(s, i);
  struct transfer_boxes *m = *out = ylm_alloc_zero(1, sizeof *m);
  float *vertex = ylm_alloc(ylm_scene_vertices(s, NULL), 12);
  if (m) m->triangle = ylm_alloc(n, sizeof *m->triangle);
  if (m) m->node = ylm_alloc(2 * n + 1, sizeof *m->node);
  bool good = m && vertex && m->triangle && m->node;
  if (good) {
    ylm_scene_vertices(s, vertex);
    fill(m, s, vertex);
    m->nodes = 1;
    build(m, 0, 0, m->triangles);
  }
  ylm_free(vertex);
  return good ? YLM_OK : YLM_ENOMEM;
}

void ylm__boxes_free(struct transfer_boxes *m) {
  if (!m) return;
  ylm_free(m->triangle);
  ylm_free(m->node);
  ylm_free(m);
}

/* Whether a direction parts a triangle from the box of half edges h about the origin. */
static bool parts(const double d[3], double p[3][3], const double h[3]) {
  double lo = INFINITY, hi = -INFINITY, r = 0;
  for (int k = 0; k < 3; k++) {
    double x = d[0] * p[k][0] + d[1] * p[k][1] + d[2] * p[k][2];
    lo = fmin(lo, x);
    hi = fmax(hi, x);
  }
  for (int a = 0; a < 3; a++) r += fabs(d[a]) * h[a];
  return lo > r || hi < -r;
}

/* Separating axes: of the box, across the triangle, and across pairs of edges. */
static bool meets(const corner3 *t, const double box[6]) {
  static const double axis[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  double p[3][3], h[3], edge[3][3], d[3];
  for (int a = 0; a < 3; a++) {
    h[a] = (box[3 + a] - box[a]) / 2;
    for (int k = 0; k < 3; k++) p[k][a] = (double)t->p[k][a] - (box[a] + box[3 + a]) / 2;
  }
  for (int k = 0; k < 3; k++)
    for (int a = 0; a < 3; a++) edge[k][a] = p[(k + 1) % 3][a] - p[k][a];
  for (int a = 0; a < 3; a++)
    if (parts(axis[a], p, h)) return false;
  ylm_cross3d(edge[0], edge[1], d);
  if (parts(d, p, h)) return false;
  for (int k = 0; k < 3; k++)
    for (int a = 0; a < 3; a++) {
      ylm_cross3d(edge[k], axis[a], d);
      if (parts(d, p, h)) return false;
    }
  return true;
}

bool ylm__boxes_meet(const struct transfer_boxes *m, const double box[6]) {
  uint32_t stack[128];
  size_t top = 0;
  stack[top++] = 0;
  while (top) {
    const meets_node *node = &m->node[stack[--top]];
    bool apart = false;
    for (int a = 0; a < 3; a++)
      apart = apart || (double)node->lo[a] > box[3 + a] || (double)node->hi[a] < box[a];
    if (apart) continue;
    for (uint32_t i = 0; i < node->n; i++)
      if (meets(&m->triangle[node->first + i], box)) return true;
    if (node->n == 0 && node->lo[0] <= node->hi[0])
      for (uint32_t k = 0; k < 2; k++) stack[top++] = node->first + k;
  }
  return false;
}
