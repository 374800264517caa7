/*
** octree_points.c - the corners of a level's voxels on a device: found in a table, numbered, and
** evaluated where they are new.
*/
#include "octree.h"

#define MOST_VOXELS (1u << 27) /* of a level: candidates are numbered by 30 bits */

/* -- the table ----------------------------------------------------------------------------- */

/* A table at most half full with `more` points beside those there are. */
static ylm_status reserve_table(octree *t, uint64_t more) {
  uint64_t slots = t->slots ? t->slots : 1024;
  while (slots < 2 * (t->p.points + more)) slots *= 2;
  if (slots == t->slots) return YLM_OK;
  if (slots > (uint64_t)1 << 31)
    return ylm_fail(t->e, YLM_ELIMIT, "more than 2^30 points on a device");
  ylm_gpu_buffer_free(t->slot);
  t->slot = NULL;
  t->slots = (uint32_t)slots;
  ylm_status s = ylm_gpu_buffer_create(t->g, 4 * slots, &t->slot, t->e);
  if (s != YLM_OK) return s;
  ylm__steps_fill(&t->q, t->slot, UINT32_MAX);
  step_kernel k = {"octree_insert", 1, {1, 0}, 0};
  uint32_t push[] = {t->p.points, 0, t->slots - 1};
  ylm_gpu_buffer *bind[] = {t->slot, t->p.key, t->level[0].voxel};
  if (t->p.points) ylm__steps_dispatch(&t->q, &k, t->p.points, 3, push, 3, bind);
  return YLM_OK;
}

/* Room for `more` points, if there may be so many. */
static ylm_status reserve_points(octree *t, uint32_t more) {
  size_t most = t->source->max_points;
  if (most && (uint64_t)t->p.points + more > most)
    return ylm_fail(t->e, YLM_ELIMIT, "the grid needs more than %zu points", most);
  ylm_status s = ylm__steps_run(&t->q);
  return s == YLM_OK ? ylm__points_reserve(&t->p, more) : s;
}

/* -- a level's corners --------------------------------------------------------------------- */

/* No more points than so many are new: all corners, those of cells that were split, a lattice's. */
static uint64_t most_fresh(const octree *t, int level) {
  uint64_t corners = 8 * (uint64_t)t->level[level].voxels;
  uint64_t inner = level ? 19 * (uint64_t)t->level[level - 1].splits : 8;
  const uint32_t *r = ylm_grid_look(t->grid)->resolution;
  if (t->uniform) inner = (r[0] + 1) * (uint64_t)(r[1] + 1) * (r[2] + 1);
  return corners < inner ? corners : inner;
}

/* Corners as entries of the table; *fresh of them are new. */
static ylm_status find_corners(octree *t, int level, uint32_t *fresh) {
  octree_level *v = &t->level[level];
  uint32_t n = 8 * v->voxels, edge = octree_edge(t, level), count[YLM_GPU_COUNTS];
  ylm_status s = reserve_table(t, most_fresh(t, level));
  if (s == YLM_OK && !t->p.key) s = reserve_points(t, 8);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(t->g, 4 * (uint64_t)n, &v->corner, t->e);
  if (s == YLM_OK) s = ylm__steps_reserve(t->g, &t->before[0], 4 * (uint64_t)n, t->e);
  if (s != YLM_OK) return s;
  step_kernel insert = {"octree_insert", 1, {0, 0}, 0}, find = {"octree_find", 0, {0, 0}, 0};
  uint32_t push[] = {n, edge, t->slots - 1};
  ylm_gpu_buffer *bind[] = {t->slot, t->p.key, v->voxel, v->corner};
  ylm__steps_dispatch(&t->q, &insert, n, 3, push, 3, bind);
  ylm__steps_dispatch(&t->q, &find, n, 3, push, 4, bind);
  ylm__steps_scan(&t->q, SCAN_OWN, 0, v->corner, n, t->before[0], t->counts, YLM_GPU_COUNT_FRESH);
  s = ylm__octree_counts(t, count);
  *fresh = count[YLM_GPU_COUNT_FRESH];
  return s;
}

/* Gives new points their numbers. */
static void number_corners(octree *t, int level) {
  octree_level *v = &t->level[level];
  uint32_t n = 8 * v->voxels, push[] = {n, octree_edge(t, level), t->p.points};
  step_kernel number = {"octree_number", 0, {0, 0}, 0}, settle = {"octree_settle", 0, {0, 0}, 0};
  ylm_gpu_buffer *bind[] = {v->corner, t->before[0], t->p.key, v->voxel};
  ylm__steps_dispatch(&t->q, &number, n, 3, push, 4, bind);
  uint32_t slots[] = {t->slots, t->p.points};
  ylm_gpu_buffer *table[] = {t->slot, t->before[0]};
  ylm__steps_dispatch(&t->q, &settle, t->slots, 2, slots, 2, table);
}

ylm_status ylm__octree_corners(octree *t, int level, uint32_t *fresh) {
  if (t->level[level].voxels >= MOST_VOXELS)
    return ylm_fail(t->e, YLM_ELIMIT, "more than 2^27 voxels in a level on a device");
  t->q.stage = "points";
  ylm_status s = find_corners(t, level, fresh);
  if (s == YLM_OK) s = reserve_points(t, *fresh);
  if (s == YLM_OK) number_corners(t, level);
  return s == YLM_OK ? ylm__steps_run(&t->q) : s;
}

/* -- evaluating ---------------------------------------------------------------------------- */

/* Rows of all points so far to the host. */
static ylm_status flush(octree *t) {
  ylm_grid_parts parts;
  ylm_status s = ylm_grid_room(t->grid, 0, t->p.points, &parts, t->e);
  if (s == YLM_OK) s = ylm__points_download(&t->p, parts.data);
  if (s == YLM_OK) s = ylm__octree_report(t);
  ylm__points_forget(&t->p);
  return s;
}

ylm_status ylm__octree_evaluate(octree *t, uint32_t n) {
  uint32_t end = t->p.points + n;
  double start = ylm_seconds();
  ylm_status s = YLM_OK;
  t->of = n;
  while (s == YLM_OK && t->p.points < end) {
    bool full;
    t->now = end - t->p.points;
    t->done = n - t->now;
    s = ylm__points_evaluate(&t->p, (uint32_t)t->now, t->q.progress, &full);
    if (full && t->p.points > t->p.first) s = flush(t);
  }
  t->done = n;
  t->now = 0;
  t->stats->pairs += n * ylm__lights_pairs(t->l);
  t->stats->field_seconds += ylm_seconds() - start;
  return s;
}
