/* plan.c - the jobs of a bake in bricks, one after the other, and the bricks there are. */
#include "brick.h"
#include "ylm_list.h"

#include <stdlib.h>
#include <string.h>

/* -- order ------------------------------------------------------------------------------------- */

bool ylm__brick_before(const brick *a, const brick *b) {
  return b && (!a || strcmp(a->code, b->code) < 0);
}

static int by_code(const void *a, const void *b) {
  return strcmp(((const brick *)a)->code, ((const brick *)b)->code);
}

/* The largest error first: it takes longest. */
static int by_error(const void *a, const void *b) {
  const brick *x = a, *y = b;
  return x->error > y->error ? -1 : x->error < y->error ? 1 : by_code(a, b);
}

/* -- checks ------------------------------------------------------------------------------------ */

static ylm_status check_how(const ylm_grid_form *f, const ylm_grid_source *s,
                            const ylm_grid_bricks *how, ylm_error *e) {
  if (f->kind != YLM_GRID_ADAPTIVE)
    return ylm_fail(e, YLM_EINVAL, "bricks: an adaptive grid is baked in bricks, not a lattice");
  if (f->dynamic)
    return ylm_fail(e, YLM_EINVAL, "bricks: a grid that follows lights is not baked in bricks");
  if (ylm_quantity_jumps(s->field->quantity) || f->sides || f->measure != YLM_GRID_COEFFICIENTS ||
      s->normals)
    return ylm_fail(e, YLM_EINVAL, "bricks: light that has sides is not baked in bricks");
  if (s->like) return ylm_fail(e, YLM_EINVAL, "bricks: like is of grids that are baked whole");
  if (s->backend) return ylm_fail(e, YLM_EINVAL, "bricks: devices do not bake bricks");
  if (how->level < 0 || how->level > f->depth - 2)
    return ylm_fail(e, YLM_ERANGE, "bricks: a level from 1 to %d (depth less 2), got %d",
                    f->depth - 2, how->level);
  if (!how->folder || !*how->folder || strlen(how->folder) > FOLDER_PATH - 64)
    return ylm_fail(e, YLM_EINVAL, "bricks: the folder's name is empty or too long");
  return YLM_OK;
}

/* -- beginning and end ----------------------------------------------------------------------- */

/* The top, and the first bricks. */
static ylm_status begin(plan *p, ylm_error *e) {
  ylm__baker_begin(&p->top, ylm__grid_new(&p->form), p->source, e);
  if (!p->top.g) return YLM_ENOMEM;
  if (p->source->field->tells_validity) {
    p->top.g->validity = ylm_alloc(1, sizeof *p->top.g->validity);
    if (!p->top.g->validity) return YLM_ENOMEM;
  }
  return ylm__top_bake(p, e);
}

/* Evaluated points of a brick at most, by what is asked for and by the light of the top. */
static size_t most_points(const plan *p) {
  const ylm_grid_bricks *how = &p->how;
  const ylm_grid *g = p->top.g;
  size_t most = how->points ? how->points : BRICK_POINTS;
  double seconds = how->brick_seconds > 0 ? how->brick_seconds : how->points ? 0 : BRICK_SECONDS;
  if (!g || !g->evaluated || !(seconds > 0)) return most;
  double point = (double)g->stats.pairs / (double)g->evaluated * g->contents.count * BRICK_PAIR;
  if (!(point * (double)most > seconds)) return most;
  size_t few = (size_t)(seconds / point);
  return few > BRICK_LEAST ? few : most < BRICK_LEAST ? most : BRICK_LEAST;
}

static void order_wanted(plan *p) {
  if (p->wanteds) qsort(p->wanted, p->wanteds, sizeof *p->wanted, by_error);
}

/* The first job: none where the folder is finished. */
static ylm_status begin_jobs(plan *p, ylm_error *e) {
  char path[FOLDER_PATH];
  ylm__folder_file(p->how.folder, "index", path);
  if (ylm__folder_has(path)) {
    p->job = PLAN_FINISH;
    return ylm__plan_advance(p, e);
  }
  return p->wanteds ? YLM_OK : ylm__plan_advance(p, e);
}

ylm_status ylm__plan_agree(plan_team *team, ylm_status s, ylm_error *e) {
  ylm_team *t = team->team;
  if (t->size == 1 || team->agreed) return s;
  if (s != YLM_OK && !(e && e->status == s)) ylm_fail_plain(e, s);
  s = t->agree(t->self, s, e);
  team->agreed = s != YLM_OK;
  return s;
}

/* The folder: its owner makes it while the others wait. */
static ylm_status open_folder(plan *p, ylm_status s, ylm_error *e) {
  char path[FOLDER_PATH];
  if (!p->owner) s = ylm__plan_agree(p->team, s, e);
  ylm__folder_file(p->how.folder, "form", path);
  if (s == YLM_OK && !p->owner && !ylm__folder_awaits(p, path))
    s = ylm_fail(
        e, YLM_EIO,
        "%s: the files of the process that began it do not arrive here: all processes have to "
        "see one folder",
        p->how.folder);
  if (s == YLM_OK) s = ylm__folder_open(p, e);
  return p->owner ? ylm__plan_agree(p->team, s, e) : s;
}

ylm_status ylm__plan_open(const ylm_grid_form *form, const ylm_grid_source *source,
                          const ylm_grid_bricks *how, plan_team *team, plan **out, ylm_error *e) {
  *out = NULL;
  ylm_status s = ylm__grid_check_form(form, e);
  if (s == YLM_OK) s = ylm__grid_check_source(source, form->dynamic, e);
  if (s == YLM_OK) s = check_how(form, source, how, e);
  if (s != YLM_OK) return s;
  plan *p = ylm_alloc_zero(1, sizeof *p);
  if (!p) return ylm__grid_no_room(YLM_ENOMEM, source, e);
  p->form = *form;
  p->form.quantity = source->field->quantity;
  p->source = source;
  p->how = *how;
  p->team = team;
  p->owner = team->team->rank == 0;
  p->lock = -1;
  if (!p->how.level) p->how.level = form->depth - 2 < BRICK_LEVEL ? form->depth - 2 : BRICK_LEVEL;
  s = begin(p, e);
  p->how.points = most_points(p);
  if (s == YLM_ENOMEM || (s == YLM_ELIMIT && !p->top.told)) ylm__grid_no_room(s, source, e);
  s = open_folder(p, s, e);
  order_wanted(p);
  p->top.e = p->top.making.e = NULL;
  if (s == YLM_OK) s = begin_jobs(p, e);
  if (s == YLM_OK)
    *out = p;
  else
    ylm__plan_close(p);
  return s;
}

void ylm__plan_close(plan *p) {
  if (!p) return;
  ylm__folder_close(p);
  ylm_grid_free(p->top.g);
  ylm__occupancy_free(&p->top.learnt.occupied);
  ylm__baker_free(&p->top);
  ylm_free(p->brick);
  ylm_free(p->wanted);
  ylm_free(p);
}

/* -- jobs --------------------------------------------------------------------------------------- */

size_t ylm__plan_tasks(const plan *p) {
  switch (p->job) {
  case PLAN_REFINE:
  case PLAN_LIGHTS: return p->wanteds;
  case PLAN_JOIN: return p->bricks + 1;
  case PLAN_FILL:
  case PLAN_FINISH: return 1;
  default: return 0;
  }
}

const char *ylm__plan_stage(const plan *p) {
  static const char *const names[] = {
      "bricks", "points in lights", "points in lights", "joining", "index", "done"};
  return names[p->job];
}

ylm_status ylm__plan_task(plan *p, size_t task, int threads, const ylm_progress *progress,
                          ylm_error *e) {
  switch (p->job) {
  case PLAN_REFINE: return ylm__brick_refine(p, &p->wanted[task], threads, progress, e);
  case PLAN_LIGHTS: return ylm__brick_lights(p, &p->wanted[task], threads, e);
  case PLAN_FILL: return ylm__brick_fill(p, e);
  case PLAN_JOIN: return ylm__brick_join(p, task < p->bricks ? &p->brick[task] : NULL, threads, e);
  case PLAN_FINISH: return ylm__brick_finish(p, e);
  default: return YLM_OK;
  }
}

/* Has a brick been refined or given up? By another process of the team it has been, but a network file system may show it late. */
static ylm_status await_brick(const plan *p, const brick *k) {
  double begin = ylm_seconds();
  ylm_status s;
  while (!ylm__brick_given_up(p, k) && (s = ylm__brick_look(p, k)) != YLM_OK) {
    if (!plan_is_shared(p) || ylm_seconds() - begin > LATE_SECONDS) return s;
    ylm__folder_rest();
  }
  return YLM_OK;
}

/* The refined bricks of the round join the list; *more are those that were given up, at its end. */
static ylm_status take_round(plan *p, size_t *given_up, ylm_error *e) {
  if (!ylm_list_resize(&p->brick, p->bricks, p->bricks + p->wanteds, sizeof *p->brick))
    return ylm_no_memory(e);
  size_t n = 0;
  for (size_t i = 0; i < p->wanteds; i++) {
    const brick k = p->wanted[i];
    ylm_status s = await_brick(p, &k);
    if (ylm__brick_given_up(p, &k))
      p->wanted[n++] = k;
    else if (s == YLM_OK)
      p->brick[p->bricks++] = k;
    else if (s == YLM_ENOMEM)
      return ylm_fail(e, s, "memory ran out");
    else
      return ylm_fail(e, YLM_EIO, "%s: brick %s is not there, though it was baked", p->how.folder,
                      k.code);
  }
  *given_up = n;
  return YLM_OK;
}

/* Has the border of a brick points in lights; adds its own points to *sum. */
static ylm_status look_at(const plan *p, const brick *k, bool *invalid, uint64_t *sum,
                          ylm_error *e) {
  char path[FOLDER_PATH];
  border_head h;
  ylm__folder_brick(p->how.folder, k->code, "b", path);
  ylm_status s = ylm__border_head(path, &h, e);
  if (s != YLM_OK) return s;
  *sum += h.evaluated;
  *invalid = h.invalid > 0;
  return YLM_OK;
}

/* True if a brick, or one that it touches, has points in lights on its boundary. */
static ylm_status is_near_lights(const plan *p, size_t i, const bool *invalid, bool *near,
                                 ylm_error *e) {
  uint32_t box[6], *list;
  size_t n;
  brick_box(p, p->brick[i].origin, p->brick[i].level, box);
  ylm_status s = ylm__plan_touching(p, box, &list, &n);
  if (s != YLM_OK) return ylm_fail(e, s, "memory ran out");
  *near = invalid[i];
  for (size_t k = 0; k < n; k++) *near |= invalid[list[k]];
  ylm_free(list);
  return YLM_OK;
}

/* After the last round: which bricks have to look at points in lights; none where no boundary has any. */
static ylm_status look_for_lights(plan *p, ylm_error *e) {
  bool *invalid = ylm_alloc_zero(p->bricks, sizeof *invalid), any = false;
  uint64_t points = p->top.g->evaluated;
  ylm_free(p->wanted);
  p->wanted = ylm_alloc(p->bricks, sizeof *p->wanted);
  p->wanteds = 0;
  ylm_status s = invalid && p->wanted ? YLM_OK : ylm_no_memory(e);
  for (size_t i = 0; i < p->bricks && s == YLM_OK; i++)
    s = look_at(p, &p->brick[i], &invalid[i], &points, e);
  if (s == YLM_OK && p->source->max_points && points > p->source->max_points)
    s = ylm__grid_no_room(YLM_ELIMIT, p->source, e);
  for (size_t i = 0; i < p->top.g->evaluated; i++)
    any |= (p->top.g->flags[i] & YLM_GRID_POINT_INVALID) != 0;
  for (size_t i = 0; i < p->bricks && s == YLM_OK; i++) {
    bool near = false;
    s = is_near_lights(p, i, invalid, &near, e);
    any |= near;
    if (near) p->wanted[p->wanteds++] = p->brick[i];
  }
  ylm_free(invalid);
  p->filled = any;
  p->job = any ? p->wanteds ? PLAN_LIGHTS : PLAN_FILL : PLAN_JOIN;
  return s;
}

static ylm_status after_round(plan *p, ylm_error *e) {
  size_t given_up = 0;
  ylm_status s = take_round(p, &given_up, e);
  p->wanteds = given_up;
  if (s == YLM_OK && given_up) {
    qsort(p->wanted, given_up, sizeof *p->wanted, by_code);
    brick *gone = p->wanted;
    p->wanted = NULL;
    p->wanteds = 0;
    s = ylm__top_split(p, given_up, gone, e);
    ylm_free(gone);
    order_wanted(p);
    if (s != YLM_OK || p->wanteds) return s;
  }
  if (s != YLM_OK) return s;
  if (p->bricks) qsort(p->brick, p->bricks, sizeof *p->brick, by_code);
  for (size_t i = 0; i < p->bricks; i++) {
    ylm_grid_cell *c = &p->top.g->cell[p->brick[i].cell];
    c->flags |= YLM_GRID_BRICK;
    c->source = (uint32_t)i; /* in the plan's own top: the number of the brick */
  }
  return look_for_lights(p, e);
}

/* Files that tasks of the job have written. */
static void await_files(const plan *p) {
  char path[FOLDER_PATH];
  if (!plan_is_shared(p)) return;
  for (size_t i = 0; p->job == PLAN_LIGHTS && i < p->wanteds; i++) {
    ylm__folder_brick(p->how.folder, p->wanted[i].code, "c", path);
    ylm__folder_awaits(p, path);
  }
  for (size_t i = 0; p->job == PLAN_JOIN && i < p->bricks; i++) {
    ylm__folder_brick(p->how.folder, p->brick[i].code, "ylm", path);
    ylm__folder_awaits(p, path);
  }
  const char *name = p->job == PLAN_FILL     ? "fill"
                     : p->job == PLAN_JOIN   ? "top.ylm"
                     : p->job == PLAN_FINISH ? "index"
                                             : NULL;
  ylm__folder_file(p->how.folder, name ? name : "form", path);
  ylm__folder_awaits(p, path);
}

ylm_status ylm__plan_advance(plan *p, ylm_error *e) {
  await_files(p);
  switch (p->job) {
  case PLAN_REFINE: return after_round(p, e);
  case PLAN_LIGHTS: p->job = PLAN_FILL; break;
  case PLAN_FILL: p->job = PLAN_JOIN; break;
  case PLAN_JOIN: p->job = PLAN_FINISH; break;
  case PLAN_FINISH:
    p->job = PLAN_DONE;
    if (p->owner) ylm__folder_clean(p);
    break;
  default: break;
  }
  return YLM_OK;
}

/* -- neighbours ---------------------------------------------------------------------------------- */

typedef struct touching {
  const plan *p;
  const uint32_t *box;
  cell_list found;
} touching;

static ylm_status descend(touching *t, uint32_t cell) {
  const ylm_grid_cell *c = &t->p->top.g->cell[cell];
  uint32_t box[6];
  ylm_status s = YLM_OK;
  brick_box(t->p, c->origin, c->level, box);
  if (!boxes_touch(box, t->box)) return s;
  if (c->flags & YLM_GRID_BRICK) return ylm__cell_list_push(&t->found, c->source);
  for (uint32_t k = 0; c->child && k < 8 && s == YLM_OK; k++) s = descend(t, c->child + k);
  return s;
}

static int by_number(const void *a, const void *b) {
  uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
  return x < y ? -1 : x > y;
}

ylm_status ylm__plan_touching(const plan *p, const uint32_t box[6], uint32_t **list, size_t *n) {
  touching t = {.p = p, .box = box};
  ylm_status s = descend(&t, 0);
  if (s == YLM_OK && t.found.n) qsort(t.found.cell, t.found.n, sizeof *t.found.cell, by_number);
  if (s != YLM_OK) ylm_free(t.found.cell);
  *list = s == YLM_OK ? t.found.cell : NULL;
  *n = s == YLM_OK ? t.found.n : 0;
  return s;
}
