/* top.c - the levels above the bricks: baked by every process, since they are small. */
#include "brick.h"
#include "ylm_list.h"

#include <string.h>

/* The octants from the root to a cell. */
static void name_cell(const plan *p, const ylm_grid_cell *c, char code[BRICK_CODE]) {
  memset(code, 0, BRICK_CODE);
  for (int level = 1; level <= c->level; level++)
    code[level - 1] = (char)('0' + octant_of(c->origin[0], c->origin[1], c->origin[2],
                                             (uint32_t)(p->form.depth - level)));
}

static ylm_status want(plan *p, uint32_t cell, size_t *room) {
  if (!ylm_list_reserve(&p->wanted, p->wanteds, p->wanteds + 1, room, sizeof *p->wanted))
    return YLM_ENOMEM;
  const ylm_grid_cell *c = &p->top.g->cell[cell];
  brick k = {.cell = cell, .level = c->level, .error = c->error};
  memcpy(k.origin, c->origin, sizeof k.origin);
  name_cell(p, c, k.code);
  p->wanted[p->wanteds++] = k;
  return YLM_OK;
}

/* Would a cell be split? With a tolerance its brick finds out. */
static bool goes_on(const plan *p, const ylm_grid_cell *c) {
  if (c->level >= p->form.depth) return false;
  return p->form.tolerance > 0 ||
         cell_splits((double)c->error, p->form.threshold, c->flags & YLM_GRID_CROSSED);
}

/* Evaluates the wave's cells. Cells that go on are split above the level of bricks, and become bricks at it or below. */
static ylm_status make_level(plan *p, size_t *room) {
  baker *b = &p->top;
  snprintf(b->stage_text, sizeof b->stage_text, "top");
  ylm_status s = ylm__corners_find(b);
  if (s == YLM_OK) s = ylm__backend_evaluate(b, b->g->points - b->g->evaluated);
  if (s == YLM_OK) s = ylm__metric_find(b);
  for (size_t i = 0; i < b->wave.n && s == YLM_OK; i++) {
    uint32_t cell = b->wave.cell[i];
    const ylm_grid_cell *c = &b->g->cell[cell];
    if (!goes_on(p, c)) continue;
    s = c->level < p->how.level ? ylm__cells_split(b, cell) : want(p, cell, room);
  }
  ylm__cells_advance(b);
  return s;
}

ylm_status ylm__top_bake(plan *p, ylm_error *e) {
  baker *b = &p->top;
  size_t room = 0;
  b->e = b->making.e = e;
  ylm_status s = ylm__occupy_voxels(b, NULL, 0);
  while (s == YLM_OK && b->wave.n) s = make_level(p, &room);
  if (s == YLM_OK && b->g->evaluated > TOP_POINTS)
    s = ylm_fail(e, YLM_ELIMIT,
                 "bricks: %zu points above level %d are too many: choose a lower level",
                 b->g->evaluated, p->how.level);
  b->told |= s == YLM_ELIMIT;
  return s;
}

ylm_status ylm__top_split(plan *p, size_t n, const brick *given_up, ylm_error *e) {
  baker *b = &p->top;
  size_t room = 0;
  ylm_status s = YLM_OK;
  b->e = b->making.e = e;
  for (size_t i = 0; i < n && s == YLM_OK; i++) s = ylm__cells_split(b, given_up[i].cell);
  ylm__cells_advance(b);
  if (s == YLM_OK) s = make_level(p, &room);
  b->e = b->making.e = NULL;
  return s == YLM_ENOMEM ? ylm__grid_no_room(s, p->source, e) : s;
}

ylm_status ylm__top_copy(const plan *p, ylm_grid **out, ylm_error *e) {
  unsigned char *data;
  size_t size;
  ylm_grid *g = p->top.g;
  *out = NULL;
  g->contents.octree_cells = g->cells;
  ylm_status s = ylm_grid_encode(g, &data, &size, e);
  if (s != YLM_OK) return s;
  s = ylm_grid_decode(data, size, "the top", out, e);
  ylm_free(data);
  return s;
}

uint64_t ylm__top_light(const plan *p) {
  const ylm_grid *g = p->top.g;
  uint64_t crc = ylm_crc64(0, g->lambda, g->evaluated * sizeof *g->lambda);
  for (size_t i = 0; i < g->evaluated; i++)
    for (int r = 0; r < 4; r++)
      crc = ylm_crc64(crc, ylm__grid_row(g, (uint32_t)i, r), g->width * sizeof(float));
  return ylm_crc64(crc, g->flags, g->evaluated);
}

uint64_t ylm__top_occupied(const plan *p) {
  const occupancy *o = &p->top.learnt.occupied;
  uint64_t crc = ylm_crc64(0, &p->source->seed, sizeof p->source->seed);
  if (!o->all) crc = ylm_crc64(crc, o->bits[o->dense], (((size_t)1 << 3 * o->dense) + 7) / 8);
  return ylm_crc64(crc, o->code, o->codes * sizeof *o->code);
}
