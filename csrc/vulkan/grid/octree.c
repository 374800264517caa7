/* octree.c - grids refined on a device: the back end of a bake that keeps cells and points. */
#include "octree.h"

#include <math.h>

/* -- progress and counts ------------------------------------------------------------------- */

/* Progress of some work as progress of the present stage: at its first word, then at intervals. */
static bool forward(void *user, uint64_t done, uint64_t total, const char *stage) {
  octree *t = user;
  double now = ylm_seconds();
  if (now - t->told < 0.1) return true;
  t->told = now;
  uint64_t here = total ? (uint64_t)((double)t->now * (double)done / (double)total) : 0;
  return ylm_report(t->outer, t->done + here, t->of, stage) == YLM_OK;
}

ylm_status ylm__octree_report(octree *t) {
  return forward(t, 0, 0, NULL) ? YLM_OK : YLM_ECANCELLED;
}

void ylm__octree_restart(octree *t) {
  t->done = t->now = 0;
  t->of = 1;
  t->told = -1;
}

ylm_status ylm__octree_counts(octree *t, uint32_t count[YLM_GPU_COUNTS]) {
  return ylm__steps_counts(&t->q, t->counts, YLM_GPU_COUNTS, count);
}

/* -- beginning ----------------------------------------------------------------------------- */

/* Where the lattice's planes are, so that all positions are the host's to the bit. */
static ylm_status upload_exact(octree *t) {
  size_t n = (size_t)t->resolution + 1;
  if (!ylm_gpu_about(t->g)->float64) return YLM_OK;
  double *d = ylm_alloc(3 * n, sizeof *d);
  if (!d) return ylm_no_memory(t->e);
  for (uint32_t i = 0; i < n; i++) {
    double at[3];
    ylm_grid_position(t->grid, (uint32_t[]){i, i, i}, at);
    for (size_t a = 0; a < 3; a++) d[a * n + i] = at[a];
  }
  ylm_status s = ylm_gpu_buffer_from(t->g, 3 * n * sizeof *d, d, &t->exact, t->e);
  ylm_free(d);
  return s;
}

/* The root is the only voxel of level 0, and a surface may cross it. */
static ylm_status begin_root(octree *t) {
  static const uint32_t voxel[4] = {0, 0, 0, 0}, state = YLM_GPU_ASKED, first = 0;
  octree_level *root = &t->level[0];
  root->voxels = 1;
  t->levels = 1;
  t->asks = 1;
  ylm_status s = ylm_gpu_buffer_from(t->g, sizeof voxel, voxel, &root->voxel, t->e);
  if (s == YLM_OK) s = ylm_gpu_buffer_from(t->g, 4, &state, &root->state, t->e);
  if (s == YLM_OK) s = ylm_gpu_buffer_from(t->g, 4, &first, &t->asked, t->e);
  return s;
}

static ylm_status begin(octree *t, const ylm_grid_making *m) {
  const ylm_grid_source *source = m->source;
  const ylm_grid_contents *v = ylm_grid_look(m->grid);
  t->g = t->l->gpu;
  t->source = source;
  t->grid = m->grid;
  t->form = v->form;
  t->stats = m->stats;
  t->e = m->e;
  t->uniform = t->form.kind == YLM_GRID_UNIFORM;
  if (t->uniform) t->form.depth = 0; /* edges of voxels are those of the lattice */
  t->resolution = v->resolution[0];
  t->all = !source->occupied && !source->meshes;
  t->outer = m->progress;
  t->progress = (ylm_progress){forward, t};
  t->q = (step_queue){
      .g = t->g, .times = &t->l->times, .progress = t->outer ? &t->progress : NULL, .e = t->e};
  ylm_status s = ylm_gpu_state(t->g, t->e);
  if (s == YLM_OK) s = ylm__points_begin(&t->p, t->l, t->grid, t->e);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(t->g, YLM_GPU_COUNTS * 4, &t->counts, t->e);
  if (s == YLM_OK && !t->uniform) s = upload_exact(t);
  if (s == YLM_OK && !t->uniform) s = begin_root(t);
  t->occupied = (occupied_voxels){.l = t->l,
                                  .grid = t->grid,
                                  .source = source,
                                  .there = t->occupied.there,
                                  .q = &t->q,
                                  .counts = t->counts,
                                  .e = t->e};
  ylm__octree_restart(t);
  t->q.stage = "occupancy";
  if (s == YLM_OK) ylm__steps_fill(&t->q, t->counts, 0);
  return s;
}

bool ylm__octree_takes(const ylm_gpu *g, const ylm_grid_form *form, const ylm_grid_source *source) {
  const ylm_gpu_info *about = ylm_gpu_about(g);
  if (form->kind == YLM_GRID_ADAPTIVE)
    return !(form->tolerance > 0) && about->binds >= OCTREE_BINDS;
  uint64_t n = 1, most = 1u << 27; /* corners of voxels are numbered by 30 bits */
  for (int a = 0; a < 3; a++) {
    if (form->cells[a] < 1 || form->cells[a] > 1u << 16) return false;
    n *= form->cells[a];
    if (n > YLM_GRID_MAX_CELLS) return false;
  }
  uint64_t marked = source->occupied && source->occupied < n ? source->occupied : n;
  if (about->bind_bytes / 32 < most) most = about->bind_bytes / 32;
  return about->binds >= OCTREE_BINDS && marked < most && n / 8 < about->bind_bytes;
}

/* -- voxels --------------------------------------------------------------------------------- */

static uint32_t lattice_voxels(const octree *t) {
  const uint32_t *r = ylm_grid_look(t->grid)->resolution;
  return r[0] * r[1] * r[2];
}

/* The voxels of a uniform grid, the only level there is: shaders/lattice_voxel.comp. */
static ylm_status list_voxels(octree *t, uint32_t voxels) {
  const uint32_t *r = ylm_grid_look(t->grid)->resolution;
  const occupied_level *o = &t->occupied.level[0];
  octree_level *v = &t->level[0];
  v->voxels = voxels;
  t->levels = 1;
  ylm_status s = ylm_gpu_buffer_create(t->g, 16 * (uint64_t)voxels, &v->voxel, t->e);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(t->g, 4 * (uint64_t)voxels, &v->state, t->e);
  if (s != YLM_OK) return s;
  step_kernel k = {"lattice_voxel", 0, {0}, 0};
  uint32_t push[] = {lattice_voxels(t), r[0], r[1], t->all};
  ylm_gpu_buffer *bind[] = {o->bits, o->before, v->voxel};
  ylm__steps_fill(&t->q, v->state, 0);
  ylm__steps_dispatch(&t->q, &k, push[0], 4, push, 3, bind);
  return ylm__steps_run(&t->q);
}

/* Which voxels are occupied; of a uniform grid they are then listed. */
static ylm_status occupy(octree *t) {
  occupied_level *o = &t->occupied.level[0];
  uint32_t count[YLM_GPU_COUNTS] = {[YLM_GPU_COUNT_VOXELS] = t->all ? lattice_voxels(t) : 0};
  ylm_status s = YLM_OK;
  if (t->source->meshes)
    s = ylm__occupied_surfaces(&t->occupied, count);
  else if (!t->all)
    s = ylm__occupied_mark(&t->occupied, count);
  else { /* bound, not read */
    s = ylm_gpu_buffer_create(t->g, 4, &o->bits, t->e);
    if (s == YLM_OK) s = ylm_gpu_buffer_create(t->g, 4, &o->before, t->e);
  }
  t->stats->outside = count[YLM_GPU_COUNT_OUTSIDE];
  return s == YLM_OK && t->uniform ? list_voxels(t, count[YLM_GPU_COUNT_VOXELS]) : s;
}

/* -- the back end --------------------------------------------------------------------------- */

static ylm_status occupied(void *self, const ylm_grid_making *m, uint64_t **code, size_t *n) {
  octree *t = self;
  ylm_status s = begin(t, m);
  if (s != YLM_OK) return s;
  t->l->busy = true; /* until the bake ends */
  s = occupy(t);
  *code = NULL;
  *n = t->level[0].voxels;
  return s;
}

static ylm_status corners(void *self, const ylm_grid_making *m, int level, size_t *fresh) {
  uint32_t n = 0;
  (void)m;
  ylm__octree_restart(self);
  ylm_status s = ylm__octree_corners(self, level, &n);
  *fresh = n;
  return s;
}

static ylm_status evaluate(void *self, const ylm_grid_making *m, size_t n) {
  (void)m;
  return ylm__octree_evaluate(self, (uint32_t)n);
}

static ylm_status metric(void *self, const ylm_grid_making *m, int level, size_t *next) {
  octree *t = self;
  (void)m;
  if (t->uniform) return ylm__octree_errors(t);
  ylm_status s = ylm__octree_split(t, level);
  *next = t->levels > level + 1 ? t->level[level + 1].voxels : 0;
  return s;
}

static ylm_status rows(void *self, const ylm_grid_making *m, ylm_grid_rows which, size_t n,
                       const uint32_t *point, float *row) {
  (void)m, (void)which, (void)n, (void)point, (void)row;
  return ylm__octree_gather(self);
}

ylm_grid_backend ylm__octree_backend(octree *t) {
  return (ylm_grid_backend){.self = t,
                            .occupied = occupied,
                            .corners = corners,
                            .evaluate = evaluate,
                            .metric = metric,
                            .rows = rows};
}

void ylm__octree_end(octree *t) {
  for (int k = 0; k < OCTREE_LEVELS; k++) {
    octree_level *v = &t->level[k];
    ylm_gpu_buffer *gone[] = {v->voxel, v->state, v->error, v->corner};
    for (int i = 0; i < 4; i++) ylm_gpu_buffer_free(gone[i]);
  }
  ylm_gpu_buffer *gone[] = {t->counts,    t->exact, t->asked,     t->sphere[0],
                            t->sphere[1], t->slot,  t->before[0], t->before[1]};
  for (int i = 0; i < 8; i++) ylm_gpu_buffer_free(gone[i]);
  ylm__occupied_free(&t->occupied);
  ylm__points_end(&t->p);
  ylm__steps_free(&t->q);
}
