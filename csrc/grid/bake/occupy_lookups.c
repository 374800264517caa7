/*
** occupy_lookups.c - voxels that are looked up beside surfaces (sample/bias.c): they are occupied too.
**
** A point whose leaf is of a level is looked up as far off as a voxel of that level is thick. Each level then needs another
** voxel of those beside a surface, and none of its children.
*/
#include "baker.h"
#include "surface.h"
#include "ylm_list.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Finest voxels that are too deep for bits. */
typedef struct code_list {
  uint64_t *code;
  size_t n, room;
} code_list;

static ylm_status push(code_list *l, uint64_t code) {
  if (!ylm_list_reserve(&l->code, l->n, l->n + 1, &l->room, sizeof *l->code)) return YLM_ENOMEM;
  l->code[l->n++] = code;
  return YLM_OK;
}

/* Marks a voxel of a level. */
static ylm_status mark(occupancy *o, code_list *deep, int level, uint64_t code) {
  if (level > o->dense) return push(deep, code << 3 * (o->depth - level));
  ylm__occupancy_mark(o, level, code);
  return YLM_OK;
}

static int by_code(const void *a, const void *b) {
  uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
  return x < y ? -1 : x > y;
}

/* Codes join those of the finest voxels, sorted, each once. */
static ylm_status join(occupancy *o, const code_list *deep) {
  if (!deep->n) return YLM_OK;
  size_t n = o->codes + deep->n, kept = 0;
  uint64_t *all = ylm_alloc(n, sizeof *all);
  if (!all) return YLM_ENOMEM;
  ylm_copy(all, o->code, o->codes * sizeof *all);
  memcpy(all + o->codes, deep->code, deep->n * sizeof *all);
  qsort(all, n, sizeof *all, by_code);
  for (size_t i = 0; i < n; i++)
    if (!kept || all[kept - 1] != all[i]) all[kept++] = all[i];
  for (size_t i = 0; i < deep->n; i++)
    ylm__occupancy_mark(o, o->dense, deep->code[i] >> 3 * (o->depth - o->dense));
  ylm_free(o->code);
  o->code = all;
  o->codes = kept;
  return YLM_OK;
}

/* How far off a surface with normal n a leaf with an edge of `edge` lattice units is looked up. */
static double distance(const ylm_grid *g, uint32_t edge, const double n[3]) {
  double b = 0;
  for (int a = 0; a < 3; a++) b += fabs(n[a]) * (double)edge / g->scale[a];
  return g->contents.form.bias * b;
}

/* The lattice cell beside point i of the source, which lies in a leaf of that edge. */
static void cell_beside(const ylm_grid *g, const ylm_grid_source *s, size_t i, uint32_t edge,
                        uint32_t cell[3]) {
  double p[3], n[3];
  for (size_t a = 0; a < 3; a++) {
    p[a] = ylm_get(s->occupied_dtype, s->occupied_points, 3 * i + a);
    n[a] = ylm_get(s->occupied_dtype, s->normals, 3 * i + a);
  }
  double b = distance(g, edge, n);
  if (s->limits) b = fmin(b, (double)s->limits[i]);
  for (int a = 0; a < 3; a++) p[a] += b * n[a];
  ylm_grid_voxel(g, p, cell);
}

static ylm_status mark_points(occupancy *o, code_list *deep, const ylm_grid *g,
                              const ylm_grid_source *s) {
  ylm_status status = YLM_OK;
  for (int level = 1; level <= o->depth; level++) {
    int below = o->depth - level;
    for (size_t i = 0; status == YLM_OK && i < s->occupied; i++) {
      uint32_t c[3];
      cell_beside(g, s, i, 1u << below, c);
      status = mark(o, deep, level, ylm__morton(c[0] >> below, c[1] >> below, c[2] >> below));
    }
  }
  return status;
}

/* -- surfaces ---------------------------------------------------------------------------------- */

/* The normal of a triangle; false where it has none. */
static bool normal_of(const double p[3][3], double n[3]) {
  double u[3], v[3], sum = 0;
  for (int a = 0; a < 3; a++) {
    u[a] = p[1][a] - p[0][a];
    v[a] = p[2][a] - p[0][a];
  }
  for (int a = 0; a < 3; a++) {
    n[a] = u[(a + 1) % 3] * v[(a + 2) % 3] - u[(a + 2) % 3] * v[(a + 1) % 3];
    sum += n[a] * n[a];
  }
  for (int a = 0; a < 3; a++) n[a] /= sqrt(sum);
  return sum > 0;
}

/* All triangles, moved to where points on them are looked up, to both sides. */
static ylm_status move_triangles(const ylm_grid *g, const triangle_list *list, uint32_t edge,
                                 double (*position)[3], uint32_t *index, size_t *n) {
  *n = 0;
  for (size_t i = 0; i < 2 * list->triangles; i++) {
    double p[3][3], normal[3];
    ylm__triangle_list_get(list, i / 2, p);
    if (!normal_of((const double(*)[3])p, normal)) continue;
    double b = distance(g, edge, normal) * (i % 2 ? -1 : 1);
    for (int k = 0; k < 3; k++) {
      for (int a = 0; a < 3; a++) position[3 * *n + (size_t)k][a] = p[k][a] + b * normal[a];
      index[3 * *n + (size_t)k] = (uint32_t)(3 * *n + (size_t)k);
    }
    ++*n;
  }
  return YLM_OK;
}

/* Voxels of a grid of that form that the moved triangles meet; none where they are all outside. */
static ylm_status voxels_of(const ylm_grid_form *form, const ylm_grid_source *s, size_t n,
                            const double (*position)[3], const uint32_t *index, uint64_t **code,
                            size_t *codes) {
  ylm_grid_mesh mesh = {3 * n, n, YLM_DOUBLE, position, index};
  ylm_grid_source moved = {
      .meshes = 1, .mesh = &mesh, .threads = s->threads, .progress = s->progress};
  uint64_t outside = 0;
  ylm_error e = {0};
  *code = NULL;
  *codes = 0;
  ylm_grid *g = n ? ylm__grid_new(form) : NULL;
  if (n && !g) return YLM_ENOMEM;
  ylm_status status =
      n ? ylm_grid_surface_voxels(g, &moved, code, codes, &outside, &e) : YLM_EDOMAIN;
  ylm_grid_free(g);
  return status == YLM_EDOMAIN ? YLM_OK : status;
}

/* Receives the voxels beside surfaces at a level. */
typedef ylm_status take_voxels(void *to, int level, size_t n, const uint64_t *code);

/* Voxels beside surfaces, level by level. */
static ylm_status each_level(const ylm_grid *g, const ylm_grid_source *s, int first, int last,
                             take_voxels *take, void *to) {
  triangle_list list;
  ylm_status status = ylm__triangle_list_make(&list, s->meshes, s->mesh);
  if (status != YLM_OK) return status;
  double(*position)[3] = ylm_alloc(6 * list.triangles, sizeof *position);
  uint32_t *index = ylm_alloc(6 * list.triangles, sizeof *index);
  status = position && index ? YLM_OK : YLM_ENOMEM;
  for (int level = first; status == YLM_OK && level <= last; level++) {
    ylm_grid_form form = g->contents.form;
    uint64_t *code;
    size_t n, codes;
    uint32_t edge = 1u << (last - level);
    form.depth = level;
    form.dynamic = false;
    move_triangles(g, &list, edge, position, index, &n);
    status = voxels_of(&form, s, n, (const double(*)[3])position, index, &code, &codes);
    if (status == YLM_OK) status = take(to, level, codes, code);
    ylm_free(code);
  }
  ylm_free(position);
  ylm_free(index);
  ylm__triangle_list_free(&list);
  return status;
}

typedef struct octree_marks {
  occupancy *o;
  code_list *deep;
} octree_marks;

static ylm_status take_octree(void *to, int level, size_t n, const uint64_t *code) {
  const octree_marks *m = to;
  ylm_status s = YLM_OK;
  for (size_t i = 0; s == YLM_OK && i < n; i++) s = mark(m->o, m->deep, level, code[i]);
  return s;
}

/* -- both ---------------------------------------------------------------------------------------- */

bool ylm__beside_wanted(const ylm_grid *g, const ylm_grid_source *s) {
  return g->contents.form.bias > 0 && !s->backend &&
         ((s->occupied_points && s->normals) || s->meshes);
}

ylm_status ylm__beside_mark(occupancy *o, const ylm_grid *g, const ylm_grid_source *s) {
  code_list deep = {0};
  octree_marks marks = {o, &deep};
  ylm_status status =
      s->meshes ? each_level(g, s, 1, o->depth, take_octree, &marks) : mark_points(o, &deep, g, s);
  if (status == YLM_OK) status = join(o, &deep);
  if (status == YLM_OK) ylm__occupancy_mark_parents(o);
  ylm_free(deep.code);
  return status;
}

static ylm_status take_uniform(void *to, int level, size_t n, const uint64_t *voxel) {
  uint8_t *mark = to;
  (void)level;
  for (size_t i = 0; i < n; i++) mark[voxel[i]] = 1;
  return YLM_OK;
}

ylm_status ylm__beside_mark_uniform(const ylm_grid *g, const ylm_grid_source *s, uint8_t *mark) {
  const uint32_t *r = g->contents.resolution;
  if (s->meshes) return each_level(g, s, 0, 0, take_uniform, mark);
  for (size_t i = 0; i < s->occupied; i++) {
    uint32_t c[3];
    cell_beside(g, s, i, 1, c);
    mark[((size_t)c[2] * r[1] + c[1]) * r[0] + c[0]] = 1;
  }
  return YLM_OK;
}
