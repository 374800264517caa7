/* octree_split.c - which voxels of a level are split, and the voxels of the next, on a device. */
#include <math.h>
#include <string.h>

#include "octree.h"

#define SPHERES 1024u /* that a group asks about */

/* -- surfaces of lights ----------------------------------------------------------------- */

/* Centres and radii of the spheres that emit (flat 0), or of those that stand for flat lights. */
static ylm_status upload_spheres(octree *t, int flat) {
  if (t->sphere[flat]) return YLM_OK;
  const ylm_light_part *p = flat ? &t->l->cosines : &t->l->spheres;
  double(*sphere)[4] = ylm_alloc(p->lamps, sizeof *sphere);
  if (!sphere) return ylm_no_memory(t->e);
  uint32_t kept = 0;
  for (size_t i = 0; i < p->lamps; i++) {
    ylm_light_lamp lamp;
    p->lamp(p->of, i, &lamp);
    if (lamp.radius == 0) continue;
    memcpy(sphere[kept], lamp.at, sizeof lamp.at);
    sphere[kept++][3] = lamp.radius;
  }
  double start = ylm_seconds();
  ylm_status s = ylm_gpu_buffer_from(t->g, kept * sizeof *sphere, sphere, &t->sphere[flat], t->e);
  t->spheres[flat] = kept;
  ylm__lights_copied(t->l, "upload", start);
  ylm_free(sphere);
  return s;
}

/* Marks those of the level's voxels that a sphere's surface crosses. */
static ylm_status cross_spheres(octree *t, int level, int flat) {
  ylm_status s = upload_spheres(t, flat);
  uint32_t n = t->spheres[flat], chunk = n < SPHERES ? n : SPHERES;
  if (s != YLM_OK || !n) return s;
  uint64_t chunks = (n + chunk - 1) / chunk, blocks = (t->asks + STEP_GROUP - 1) / STEP_GROUP;
  step_kernel k = {"octree_cross", 1, {(uint32_t)flat}, chunk};
  uint32_t push[] = {t->asks, octree_edge(t, level), t->resolution, n, chunk};
  ylm_gpu_buffer *bind[] = {t->sphere[flat], t->asked, t->level[level].voxel, t->exact,
                            t->level[level].state};
  t->q.stage = "crossing";
  ylm__steps_dispatch(&t->q, &k, blocks * chunks * STEP_GROUP, 5, push, 5, bind);
  return YLM_OK;
}

/* Arrays of the host, while the field is asked which voxels its surfaces cross. */
typedef struct crossing {
  uint32_t *asked, (*voxel)[4], *state;
  double (*box)[6];
  uint8_t *out;
} crossing;

static void box_of(const octree *t, const uint32_t key[2], uint32_t edge, double box[6]) {
  uint32_t at[3], far[3];
  points_unpack(key, at);
  for (int a = 0; a < 3; a++) far[a] = at[a] + edge;
  ylm_grid_position(t->grid, at, box);
  ylm_grid_position(t->grid, far, box + 3);
}

static ylm_status ask_field(octree *t, int level, const crossing *c) {
  const octree_level *v = &t->level[level];
  const ylm_field *f = ylm_gpu_lights_field(t->l);
  size_t n = t->asks, all = v->voxels;
  ylm_status s = ylm_gpu_download(t->asked, 0, n * sizeof *c->asked, c->asked, t->e);
  if (s == YLM_OK) s = ylm_gpu_download(v->voxel, 0, all * sizeof *c->voxel, c->voxel, t->e);
  if (s == YLM_OK) s = ylm_gpu_download(v->state, 0, all * sizeof *c->state, c->state, t->e);
  if (s != YLM_OK) return s;
  for (size_t i = 0; i < n; i++)
    box_of(t, c->voxel[c->asked[i] < all ? c->asked[i] : 0], octree_edge(t, level), c->box[i]);
  s = f->crosses(f, n, c->box[0], c->out);
  if (s != YLM_OK) return ylm_fail_plain(t->e, s);
  for (size_t i = 0; i < n; i++)
    if (c->out[i] && c->asked[i] < all) c->state[c->asked[i]] |= YLM_GPU_CROSSED;
  return ylm_gpu_upload(v->state, 0, all * sizeof *c->state, c->state, t->e);
}

/* Crossing by the host, for devices that do not compute in double. */
static ylm_status cross_any(octree *t, int level) {
  size_t n = t->asks, all = t->level[level].voxels;
  ylm_status s = ylm__steps_run(&t->q);
  if (s != YLM_OK) return s;
  crossing c = {ylm_alloc(n, sizeof *c.asked), ylm_alloc(all, sizeof *c.voxel),
                ylm_alloc(all, sizeof *c.state), ylm_alloc(n, sizeof *c.box), ylm_alloc(n, 1)};
  s = c.asked && c.voxel && c.state && c.box && c.out ? ask_field(t, level, &c)
                                                      : ylm_no_memory(t->e);
  ylm_free(c.asked);
  ylm_free(c.voxel);
  ylm_free(c.state);
  ylm_free(c.box);
  ylm_free(c.out);
  return s;
}

/* Only children of crossed voxels are asked about: a surface that meets a child meets its
   parent. */
static ylm_status cross(octree *t, int level) {
  if (!t->asks || !ylm__lights_pairs(t->l)) return YLM_OK;
  if (!ylm_gpu_about(t->g)->float64 || t->l->rims.objects) return cross_any(t, level);
  ylm_status s = cross_spheres(t, level, 0);
  return s == YLM_OK ? cross_spheres(t, level, 1) : s;
}

/* -- deciding ------------------------------------------------------------------------------ */

/* The largest float that is no larger: x > it is x > threshold for floats x. */
static float floor_float(double threshold) {
  float f = (float)threshold;
  return (double)f > threshold ? nextafterf(f, -INFINITY) : f;
}

static uint32_t bits_of(float x) {
  union {
    float f;
    uint32_t u;
  } both = {x};
  return both.u;
}

static void decide(octree *t, int level) {
  octree_level *v = &t->level[level];
  const occupied_level *o = &t->occupied.level[t->all || level == t->form.depth ? 0 : level + 1];
  const uint32_t *r = ylm_grid_look(t->grid)->resolution;
  double box = 0;
  for (int a = 0; a < 3; a++) {
    double edge = (t->form.bounds[a + 3] - t->form.bounds[a]) / r[a] * octree_edge(t, level);
    box += edge * edge;
  }
  uint32_t push[] = {v->voxels, level == t->form.depth, t->all, bits_of((float)sqrt(box)),
                     bits_of(floor_float(t->form.threshold))};
  step_kernel k = {"octree_decide", 0, {0, 0}, 0};
  ylm_gpu_buffer *bits = o->bits ? o->bits : t->counts;
  ylm_gpu_buffer *bind[] = {v->voxel, v->corner, t->p.ratio, bits, v->state, v->error, t->counts};
  t->q.stage = "subdivide";
  ylm__steps_dispatch(&t->q, &k, v->voxels, 5, push, 7, bind);
}

ylm_status ylm__octree_errors(octree *t) {
  octree_level *v = &t->level[0];
  ylm_status s = ylm__steps_run(&t->q);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(t->g, 4 * (uint64_t)v->voxels, &v->error, t->e);
  if (s != YLM_OK) return s;
  decide(t, 0); /* there is no finer level, so that nothing is split */
  return ylm__steps_run(&t->q);
}

/* The voxels of the next level, as many as `count` says. */
static ylm_status descend(octree *t, int level, const uint32_t count[YLM_GPU_COUNTS]) {
  octree_level *v = &t->level[level], *next = v + 1;
  const occupied_level *o = &t->occupied.level[t->all ? 0 : level + 1];
  next->voxels = count[YLM_GPU_COUNT_VOXELS];
  t->asks = count[YLM_GPU_COUNT_ASKED];
  t->levels = level + 2;
  ylm_status s = ylm_gpu_buffer_create(t->g, 16 * (uint64_t)next->voxels, &next->voxel, t->e);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(t->g, 4 * (uint64_t)next->voxels, &next->state, t->e);
  if (s == YLM_OK) s = ylm__steps_reserve(t->g, &t->asked, 4 * (uint64_t)t->asks, t->e);
  if (s != YLM_OK) return s;
  step_kernel k = {"octree_descend", 0, {0, 0}, 0};
  uint32_t push[] = {v->voxels, octree_edge(t, level + 1), t->all};
  ylm_gpu_buffer *bind[] = {v->voxel,     v->state,    o->bits,     o->before, t->before[0],
                            t->before[1], next->voxel, next->state, t->asked,  t->counts};
  ylm__steps_dispatch(&t->q, &k, v->voxels, 3, push, 10, bind);
  return ylm__steps_run(&t->q);
}

ylm_status ylm__octree_split(octree *t, int level) {
  octree_level *v = &t->level[level];
  uint32_t count[YLM_GPU_COUNTS];
  ylm_status s = ylm__steps_run(&t->q); /* the room for prefix sums may be replaced */
  if (s == YLM_OK) s = ylm_gpu_buffer_create(t->g, 4 * (uint64_t)v->voxels, &v->error, t->e);
  for (int i = 0; s == YLM_OK && i < 2; i++)
    s = ylm__steps_reserve(t->g, &t->before[i], 4 * (uint64_t)v->voxels, t->e);
  if (s == YLM_OK) s = cross(t, level);
  if (s != YLM_OK) return s;
  decide(t, level);
  ylm__steps_scan(&t->q, SCAN_BITS, YLM_GPU_SPLIT, v->state, v->voxels, t->before[0], t->counts,
                  YLM_GPU_COUNT_SPLITS);
  ylm__steps_scan(&t->q, SCAN_BITS, YLM_GPU_CHILDREN, v->state, v->voxels, t->before[1], t->counts,
                  YLM_GPU_COUNT_VOXELS);
  s = ylm__octree_counts(t, count);
  v->splits = count[YLM_GPU_COUNT_SPLITS];
  return s == YLM_OK && count[YLM_GPU_COUNT_VOXELS] ? descend(t, level, count) : s;
}
