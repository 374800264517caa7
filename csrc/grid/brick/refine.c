/* refine.c - the first task of a brick: its cells and evaluated points, without regard to its neighbours. */
#include "../bake/surface.h"
#include "../promise/tolerance.h"
#include "brick.h"
#include "ylm_list.h"

#include <string.h>

/* A brick so deep is never given up: its children would hardly have any of their own. */
static bool may_be_given_up(const plan *p, const brick *k) { return k->level < p->form.depth - 2; }

bool ylm__brick_given_up(const plan *p, const brick *k) {
  char path[FOLDER_PATH];
  ylm__folder_brick(p->how.folder, k->code, "s", path);
  return ylm__folder_has(path);
}

ylm_status ylm__brick_look(const plan *p, const brick *k) {
  char path[FOLDER_PATH];
  border_head h;
  ylm_grid_file_info info;
  ylm__folder_brick(p->how.folder, k->code, "b", path);
  ylm_status s = ylm__folder_has(path) ? ylm__border_head(path, &h, NULL) : YLM_EIO;
  ylm__folder_brick(p->how.folder, k->code, "a", path);
  if (s == YLM_OK) s = ylm__folder_has(path) ? ylm_grid_file_look(path, &info, NULL) : YLM_EIO;
  if (s != YLM_OK) return s;
  if (info.stats.points != h.evaluated) s = YLM_EFORMAT;
  ylm_grid_file_forget(&info);
  return s;
}

/* The mark that a brick is given up. */
static ylm_status give_up(const plan *p, const brick *k, ylm_error *e) {
  char path[FOLDER_PATH];
  ylm__folder_brick(p->how.folder, k->code, "s", path);
  ylm_status s = ylm_file_save(path, k->code, strlen(k->code), e);
  if (s == YLM_OK) ylm__folder_sync(path);
  return s;
}

/* The boundary first: where the cells are, it is there too. */
static ylm_status save(const plan *p, const brick *k, ylm_grid *g, ylm_error *e) {
  char path[FOLDER_PATH];
  g->contents.octree_cells = g->cells;
  ylm__folder_brick(p->how.folder, k->code, "b", path);
  ylm_status s = ylm__border_write(g, path, e);
  ylm__folder_brick(p->how.folder, k->code, "a", path);
  if (s == YLM_OK) s = ylm_grid_write(g, path, e);
  if (s == YLM_OK) ylm__folder_sync(path);
  return s;
}

/* -- by a tolerance --------------------------------------------------------------------------------- */

/* Is a shading point in a brick? */
static bool is_in(const plan *p, const brick *k, const double x[3]) {
  uint32_t voxel[3], shift = (uint32_t)(p->form.depth - k->level);
  ylm_grid_voxel(p->top.g, x, voxel);
  bool in = true;
  for (int a = 0; a < 3; a++) in &= voxel[a] >> shift == k->origin[a] >> shift;
  return in;
}

/* The shading points of a brick take the place of all; the caller frees *points. */
static ylm_status choose_points(const plan *p, const brick *k, ylm_grid_source *s, char **points) {
  size_t row = 3 * ylm_dtype_size(s->occupied_dtype), room = 0, n = 0;
  *points = NULL;
  for (size_t i = 0; i < s->occupied; i++) {
    double x[3];
    for (size_t a = 0; a < 3; a++) x[a] = ylm_get(s->occupied_dtype, s->occupied_points, 3 * i + a);
    if (!is_in(p, k, x)) continue;
    if (!ylm_list_reserve(points, n, n + 1, &room, row)) return YLM_ENOMEM;
    memcpy(*points + n++ * row, (const char *)s->occupied_points + i * row, row);
  }
  s->occupied_points = *points;
  s->occupied = n;
  return YLM_OK;
}

/* The surface within a brick; NULL where no triangle is. */
static ylm_status choose_surface(const baker *b, ylm_grid_surface **surface) {
  double box[6];
  ylm_grid_box(b->g, 0, box);
  ylm_status s = ylm_grid_surface_create(b->source->meshes, b->source->mesh, box,
                                         b->source->threads, surface, NULL);
  return s == YLM_EDOMAIN ? YLM_OK : s;
}

/* Rounds of refinement until few held-out points fail; without points, one. */
static ylm_status refine_rounds(refiner *r, bool held) {
  bool limited = false;
  ylm_status s = ylm__tolerance_begin(r);
  if (s == YLM_OK) s = ylm__tolerance_refine(r);
  for (uint64_t round = 1; held && s == YLM_OK; round++) {
    r->b->g->stats.rounds = round;
    s = ylm__verify(r, round);
    if (s != YLM_OK || ylm__verify_satisfied(r, &limited) || round == MAX_ROUNDS) break;
    s = ylm__tolerance_again(r);
  }
  r->b->g->stats.limited = limited;
  ylm__tolerance_end(r);
  return s;
}

static ylm_status refine_by_tolerance(const plan *p, baker *b, const brick *k) {
  const ylm_grid_source *whole = b->source;
  ylm_grid_source source = *whole;
  char *points = NULL;
  ylm_grid_surface *surface = NULL;
  ylm_status s = YLM_OK;
  source.seed += ylm_morton(k->origin[0], k->origin[1], k->origin[2]) << 8;
  if (source.meshes)
    s = choose_surface(b, &surface);
  else if (source.occupied_points)
    s = choose_points(p, k, &source, &points);
  b->source = b->making.source = &source;
  b->surface = surface;
  refiner r = {.b = b, .tolerance = p->form.tolerance, .tight = FIRST_TIGHT, .most = BRICK_HELD};
  bool held = source.meshes ? surface != NULL : whole->occupied_points ? source.occupied > 0 : true;
  if (source.meshes && !surface) source.meshes = 0;
  if (s == YLM_OK) s = refine_rounds(&r, held);
  b->source = b->making.source = whole;
  ylm_free(points);
  ylm_grid_surface_free(surface);
  return s;
}

/* -- the task ------------------------------------------------------------------------------------------ */

/* Cells and points of a brick whose grid is empty. */
static ylm_status make(const plan *p, baker *b, const brick *k) {
  ylm__grid_set_root(b->g, k->level, k->origin);
  b->learnt.occupied = p->top.learnt.occupied;
  if (p->source->field->tells_validity) {
    b->g->validity = ylm_alloc(1, sizeof *b->g->validity);
    if (!b->g->validity) return YLM_ENOMEM;
  }
  ylm_status s = ylm__cells_root(b);
  if (s != YLM_OK) return s;
  return p->form.tolerance > 0 ? refine_by_tolerance(p, b, k) : ylm__refine(b, 1);
}

ylm_status ylm__brick_refine(const plan *p, const brick *k, int threads,
                             const ylm_progress *progress, ylm_error *e) {
  if (ylm__brick_given_up(p, k) || ylm__brick_look(p, k) == YLM_OK) return YLM_OK;
  ylm_grid_source source = *p->source;
  source.threads = threads;
  source.progress = progress;
  source.team = NULL;
  source.max_points = may_be_given_up(p, k) ? p->how.points : 0;
  baker b;
  ylm__baker_begin(&b, ylm__grid_new(&p->form), &source, e);
  ylm_status s = b.g ? make(p, &b, k) : YLM_ENOMEM;
  if (s == YLM_ELIMIT && source.max_points && b.g->points >= source.max_points)
    s = give_up(p, k, e);
  else if (s == YLM_OK)
    s = save(p, k, b.g, e);
  else if (!b.told)
    ylm__grid_no_room(s, &source, e);
  ylm__baker_free(&b);
  ylm_grid_free(b.g);
  return s;
}
