/* octree_result.c - an octree from a device as a ylm_grid: data of points, points, cells. */
#include <math.h>
#include <string.h>

#include "../calibration.h"
#include "octree.h"

/* -- points -------------------------------------------------------------------------------- */

static ylm_status take_points(octree *t, const ylm_grid_parts *parts) {
  uint32_t(*key)[2] = ylm_alloc(OCTREE_KEYS, sizeof *key);
  ylm_status s = key ? YLM_OK : ylm_no_memory(t->e);
  for (size_t i = 0, now; s == YLM_OK && i < t->p.points; i += now) {
    now = t->p.points - i < OCTREE_KEYS ? t->p.points - i : OCTREE_KEYS;
    s = ylm_gpu_download(t->p.key, 8 * i, 8 * now, key, t->e);
    for (size_t k = 0; s == YLM_OK && k < now; k++)
      points_unpack(key[k], parts->lattice + 3 * (i + k));
  }
  ylm_free(key);
  if (s == YLM_OK) s = ylm__points_download(&t->p, parts->data);
  if (s != YLM_OK) return s;
  memset(parts->flags, 0, t->p.points);
  return ylm__points_extra(&t->p, 0, t->p.points, parts->lambda, parts->norm, parts->flags);
}

/* -- cells --------------------------------------------------------------------------------- */

/* A level's voxels on the host. */
typedef struct voxels {
  uint32_t (*voxel)[4], *state, (*corner)[8];
  float *error;
} voxels;

static void voxels_free(voxels *v) {
  ylm_free(v->voxel);
  ylm_free(v->state);
  ylm_free(v->corner);
  ylm_free(v->error);
}

static ylm_status voxels_take(const octree *t, const octree_level *l, voxels *v) {
  size_t n = l->voxels;
  *v = (voxels){ylm_alloc(n, sizeof *v->voxel), ylm_alloc(n, sizeof *v->state),
                ylm_alloc(n, sizeof *v->corner), ylm_alloc(n, sizeof *v->error)};
  if (!v->voxel || !v->state || !v->corner || !v->error) return ylm_no_memory(t->e);
  ylm_status s = ylm_gpu_download(l->voxel, 0, n * sizeof *v->voxel, v->voxel, t->e);
  if (s == YLM_OK) s = ylm_gpu_download(l->state, 0, n * sizeof *v->state, v->state, t->e);
  if (s == YLM_OK) s = ylm_gpu_download(l->corner, 0, n * sizeof *v->corner, v->corner, t->e);
  if (s == YLM_OK) s = ylm_gpu_download(l->error, 0, n * sizeof *v->error, v->error, t->e);
  return s;
}

/* Eight children of a cell, from number `first` on. */
static void add_children(const octree *t, ylm_grid_cell *cell, size_t parent, size_t first) {
  const ylm_grid_cell *p = &cell[parent];
  uint32_t half = octree_edge(t, p->level + 1);
  for (uint32_t k = 0; k < 8; k++) {
    ylm_grid_cell *c = &cell[first + k];
    *c = (ylm_grid_cell){.level = (uint8_t)(p->level + 1), .error = NAN, .flags = YLM_GRID_LEAF};
    for (int a = 0; a < 3; a++) c->origin[a] = p->origin[a] + (k >> a & 1 ? half : 0);
    for (int i = 0; i < 8; i++) c->corner[i] = YLM_GRID_NONE;
  }
  cell[parent].child = (uint32_t)first;
  cell[parent].flags &= (uint8_t)~YLM_GRID_LEAF;
}

/* Writes what is known of the cells `begin` .. `end` - 1 of a level, and their children from there
   on; *next is behind the last. False: the device's numbers do not fit together. */
static bool write_level(const octree *t, const octree_level *l, const voxels *v,
                        ylm_grid_cell *cell, size_t begin, size_t end, size_t *next) {
  *next = end;
  for (size_t i = 0; i < l->voxels; i++) {
    if (v->voxel[i][3] >= end - begin || *next - end > 8 * (size_t)l->splits) return false;
    ylm_grid_cell *c = &cell[begin + v->voxel[i][3]];
    c->flags |= YLM_GRID_OCCUPIED;
    if (v->state[i] & YLM_GPU_CROSSED) c->flags |= YLM_GRID_CROSSED;
    c->error = v->error[i];
    memcpy(c->corner, v->corner[i], sizeof c->corner);
    if (!(v->state[i] & YLM_GPU_SPLIT)) continue;
    if (*next - end == 8 * (size_t)l->splits) return false;
    add_children(t, cell, begin + v->voxel[i][3], *next);
    *next += 8;
  }
  return *next - end == 8 * (size_t)l->splits;
}

/* The voxels of a uniform grid. */
static void write_lattice(const octree *t, const voxels *v, ylm_grid_cell *cell) {
  for (size_t i = 0; i < t->level[0].voxels; i++) {
    cell[i] = (ylm_grid_cell){.error = t->form.metric_channels ? v->error[i] : NAN,
                              .flags = YLM_GRID_LEAF | YLM_GRID_OCCUPIED};
    points_unpack(v->voxel[i], cell[i].origin);
    memcpy(cell[i].corner, v->corner[i], sizeof cell[i].corner);
  }
}

ylm_status ylm__octree_fails(const octree *t) {
  return ylm_fail(t->e, YLM_EDEVICE, "'%s' made no octree", ylm_gpu_about(t->g)->name);
}

static ylm_status take_lattice(const octree *t, ylm_grid_cell *cell) {
  voxels v;
  ylm_status s = voxels_take(t, &t->level[0], &v);
  if (s == YLM_OK) write_lattice(t, &v, cell);
  voxels_free(&v);
  return s;
}

static ylm_status take_cells(octree *t, ylm_grid_cell *cell, size_t cells) {
  size_t begin = 0, end = 1, next = 1;
  ylm_status s = YLM_OK;
  if (t->uniform) return take_lattice(t, cell);
  cell[0] = (ylm_grid_cell){.error = NAN, .flags = YLM_GRID_LEAF};
  for (int k = 0; s == YLM_OK && k < t->levels; k++) {
    voxels v;
    s = voxels_take(t, &t->level[k], &v);
    bool fits = s != YLM_OK || write_level(t, &t->level[k], &v, cell, begin, end, &next);
    voxels_free(&v);
    if (!fits) s = ylm__octree_fails(t);
    begin = end;
    end = next;
  }
  return s == YLM_OK && end != cells ? ylm__octree_fails(t) : s;
}

ylm_status ylm__octree_gather(octree *t) {
  ylm_grid_parts parts;
  size_t cells = t->uniform ? t->level[0].voxels : 1;
  for (int k = 0; k < t->levels; k++) cells += 8 * (size_t)t->level[k].splits;
  ylm__octree_restart(t);
  ylm_status s = ylm__octree_report(t);
  if (s == YLM_OK) s = ylm_grid_room(t->grid, cells, t->p.points, &parts, t->e);
  if (s == YLM_OK) s = take_points(t, &parts);
  double start = ylm_seconds();
  if (s == YLM_OK) s = take_cells(t, parts.cell, cells);
  ylm__lights_copied(t->l, "download", start);
  t->gathered = s == YLM_OK;
  return s;
}
