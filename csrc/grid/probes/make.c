/* make.c - the bricks of a grid. */
#include "probes.h"
#include "ylm_list.h"

#include <string.h>

/* A cell in the making, on a lattice that is `fine` times finer than the grid's. */
typedef struct making_cell {
  uint32_t cell; /* of the grid */
  uint32_t at[3], edge;
  uint32_t kept; /* edges below this are not cut */
} making_cell;

typedef struct making {
  const ylm_grid *g;
  ylm_grid_probes *p;
  uint32_t fine;
  making_cell *queue; /* [cells] */
  uint32_t *number;   /* [points of the grid] of the probes; YLM_GRID_NONE */
  lattice_hash hash;  /* of points that are sampled */
  double (*asked)[3]; /* [sampled] where */
  uint32_t *sampled;  /* [sampled] points */
  size_t samples, sample_room, asked_room;
  size_t cell_room, brick_room, point_room, piece_room, queue_room, part_room, row_room, ghost_room,
      source_room, cut_room, number_room;
} making;

void ylm_grid_probes_free(ylm_grid_probes *p) {
  if (!p) return;
  ylm_free(p->parts);
  ylm_free(p->first);
  ylm_free(p->row);
  ylm_free(p->cut);
  ylm_free(p->source);
  ylm_free(p->piece);
  ylm_free(p->brick_of);
  ylm_free(p->corner);
  ylm_free(p->value);
  ylm_free(p->ghost);
  ylm_free(p->tie);
  ylm_free(p);
}

static void *copy_of(const void *from, size_t n, size_t size, bool *ok) {
  void *to = from ? ylm_alloc_copy(from, n, size) : NULL;
  *ok &= to || !from;
  return to;
}

ylm_status ylm_grid_probes_copy(const ylm_grid_probes *p, ylm_grid_probes **out) {
  ylm_grid_probes *q = *out = ylm_alloc(1, sizeof *q);
  bool ok = true;
  if (!q) return YLM_ENOMEM;
  *q = *p;
  q->parts = copy_of(p->parts, p->cells, sizeof *p->parts, &ok);
  q->first = copy_of(p->first, p->cells, sizeof *p->first, &ok);
  q->row = copy_of(p->row, p->cells, sizeof *p->row, &ok);
  q->source = copy_of(p->source, p->cells, sizeof *p->source, &ok);
  q->cut = copy_of(p->cut, p->several, sizeof *p->cut, &ok);
  q->piece = copy_of(p->piece, p->several, sizeof *p->piece, &ok);
  q->brick_of = copy_of(p->brick_of, p->several, sizeof *p->brick_of, &ok);
  q->corner = copy_of(p->corner, p->bricks, sizeof *p->corner, &ok);
  q->value = copy_of(p->value, p->points, 3 * (size_t)p->count * sizeof *p->value, &ok);
  q->tie = copy_of(p->tie, p->points, sizeof *p->tie, &ok);
  q->ghost = copy_of(p->ghost, p->points, sizeof *p->ghost, &ok);
  if (ok) return YLM_OK;
  ylm_grid_probes_free(q);
  *out = NULL;
  return YLM_ENOMEM;
}

ylm_grid_probes_size ylm_grid_probes_look(const ylm_grid_probes *p) {
  ylm_grid_probes_size s = {.cells = p->cells,
                            .leaves_of_several = p->several,
                            .bricks = p->bricks,
                            .points = ylm__probes_free_points(p),
                            .lmax = p->lmax,
                            .quantity = (ylm_quantity)p->quantity};
  memcpy(s.bounds, p->bounds, sizeof s.bounds);
  memcpy(s.roots, p->roots, sizeof s.roots);
  return s;
}

/* -- cells ----------------------------------------------------------------------------------------- */

static ylm_status add_cell(making *m, const making_cell *c) {
  ylm_grid_probes *p = m->p;
  size_t n = p->cells;
  if (n + 1 >= YLM_GRID_NONE) return YLM_ELIMIT;
  if (!ylm_list_reserve(&m->queue, n, n + 1, &m->queue_room, sizeof *m->queue) ||
      !ylm_list_reserve(&p->parts, n, n + 1, &m->part_room, sizeof *p->parts) ||
      !ylm_list_reserve(&p->first, n, n + 1, &m->cell_room, sizeof *p->first) ||
      !ylm_list_reserve(&p->row, n, n + 1, &m->row_room, sizeof *p->row) ||
      !ylm_list_reserve(&p->source, n, n + 1, &m->source_room, sizeof *p->source))
    return YLM_ENOMEM;
  m->queue[n] = *c;
  p->parts[n] = 0;
  p->first[n] = 0;
  p->row[n] = p->source[n] = YLM_GRID_NONE;
  p->cells++;
  return YLM_OK;
}

static ylm_status add_point(making *m, bool ghost, uint32_t *number) {
  ylm_grid_probes *p = m->p;
  size_t n = p->points;
  if (n + 1 >= YLM_GRID_NONE) return YLM_ELIMIT;
  if (!ylm_list_reserve(&p->value, n, n + 1, &m->point_room,
                        3 * (size_t)p->count * sizeof *p->value) ||
      !ylm_list_reserve(&p->ghost, n, n + 1, &m->ghost_room, sizeof *p->ghost))
    return YLM_ENOMEM;
  p->ghost[n] = ghost;
  *number = (uint32_t)p->points++;
  return YLM_OK;
}

static ylm_status add_brick(making *m, const uint32_t corner[8]) {
  ylm_grid_probes *p = m->p;
  if (!ylm_list_reserve(&p->corner, p->bricks, p->bricks + 1, &m->brick_room, sizeof *p->corner))
    return YLM_ENOMEM;
  memcpy(p->corner[p->bricks++], corner, sizeof *p->corner);
  return YLM_OK;
}

/* -- points ---------------------------------------------------------------------------------------- */

/* Coefficients of radiance [count] as polynomials of irradiance. */
static void put_value(const making *m, uint32_t point, const float *c) {
  /* cosine factors times the constants of the basis */
  static const double factor[9] = {0.886226925452758, -1.02332670794649,  1.02332670794649,
                                   -1.02332670794649, 0.858085530809941,  -0.858085530809941,
                                   0.247707956100334, -0.858085530809941, 0.429042765404971};
  const ylm_grid *g = m->g;
  ylm_grid_probes *p = m->p;
  size_t channels = (size_t)g->contents.form.channels, own = (size_t)g->contents.count,
         count = (size_t)p->count;
  for (size_t k = 0; k < 3; k++)
    for (size_t j = 0; j < count; j++) {
      const float *from = c + (channels == 3 ? k : 0) * own;
      p->value[(point * 3 + k) * count + j] = j < own ? (float)(factor[j] * (double)from[j]) : 0;
    }
}

/* The point of the probes that is a point of the grid. */
static ylm_status take_point(making *m, uint32_t point, uint32_t *number) {
  if (m->number[point] == YLM_GRID_NONE) {
    bool ghost = m->g->flags[point] & YLM_GRID_POINT_GHOST;
    ylm_status s = add_point(m, ghost, &m->number[point]);
    if (s != YLM_OK) return s;
    put_value(m, m->number[point], ylm__grid_row(m->g, point, 0));
  }
  *number = m->number[point];
  return YLM_OK;
}

/* The point at a place of the finer lattice, which will be sampled. */
static ylm_status sample_point(making *m, const uint32_t at[3], uint32_t *number) {
  ylm_status s = ylm__lattice_hash_reserve(&m->hash, m->samples + 1);
  if (s != YLM_OK) return s;
  uint32_t *known = ylm__lattice_hash_at(&m->hash, lattice_key(at));
  if (*known == YLM_GRID_NONE) {
    if (!ylm_list_reserve(&m->asked, m->samples, m->samples + 1, &m->asked_room,
                          sizeof *m->asked) ||
        !ylm_list_reserve(&m->sampled, m->samples, m->samples + 1, &m->sample_room,
                          sizeof *m->sampled))
      return YLM_ENOMEM;
    s = add_point(m, false, known);
    if (s != YLM_OK) return s;
    const double *b = m->g->contents.form.bounds;
    for (int a = 0; a < 3; a++) {
      double part = (double)at[a] / ((double)m->g->contents.resolution[a] * m->fine);
      m->asked[m->samples][a] = b[a] + part * (b[a + 3] - b[a]);
    }
    m->sampled[m->samples++] = *known;
  }
  *number = *known;
  return YLM_OK;
}

static ylm_status sample_points(making *m, ylm_error *e) {
  const ylm_grid *g = m->g;
  float *value = ylm_alloc(m->samples ? m->samples : 1, g->width * sizeof *value);
  if (!value) return YLM_ENOMEM;
  ylm_grid_query q = {.point_dtype = YLM_DOUBLE, .dtype = YLM_FLOAT};
  ylm_status s = ylm_grid_sample(g, &q, m->samples, m->asked, value, NULL, NULL, e);
  for (size_t i = 0; s == YLM_OK && i < m->samples; i++)
    put_value(m, m->sampled[i], value + i * g->width);
  ylm_free(value);
  return s;
}

/* -- leaves ---------------------------------------------------------------------------------------- */

/* A brick whose points are sampled at the corners of a cell. */
static ylm_status make_sampled(making *m, const making_cell *c) {
  uint32_t corner[8];
  for (int k = 0; k < 8; k++) {
    uint32_t at[3];
    for (int a = 0; a < 3; a++) at[a] = c->at[a] + (k >> a & 1 ? c->edge : 0);
    ylm_status s = sample_point(m, at, &corner[k]);
    if (s != YLM_OK) return s;
  }
  return add_brick(m, corner);
}

static ylm_status make_from(making *m, const uint32_t point[8]) {
  uint32_t corner[8];
  for (int k = 0; k < 8; k++) {
    ylm_status s = take_point(m, point[k], &corner[k]);
    if (s != YLM_OK) return s;
  }
  return add_brick(m, corner);
}

/* A leaf of several bricks: those of its pieces, and of the grid's parts. */
static ylm_status add_several(making *m, size_t cell, const uint8_t piece[PROBES_PIECES],
                              const uint8_t number[YLM_GRID_PARTS]) {
  ylm_grid_probes *p = m->p;
  size_t n = p->several;
  if (!ylm_list_reserve(&p->piece, n, n + 1, &m->piece_room, sizeof *p->piece) ||
      !ylm_list_reserve(&p->cut, n, n + 1, &m->cut_room, sizeof *p->cut) ||
      !ylm_list_reserve(&p->brick_of, n, n + 1, &m->number_room, sizeof *p->brick_of))
    return YLM_ENOMEM;
  memcpy(p->piece[n], piece, sizeof *p->piece);
  memcpy(p->brick_of[n], number, sizeof *p->brick_of);
  p->row[cell] = (uint32_t)p->several++;
  return YLM_OK;
}

/* A brick for each part of a leaf. A piece without a part has that of the nearest. */
static ylm_status make_sided(making *m, size_t cell, const ylm_grid_side *side) {
  uint8_t number[YLM_GRID_PARTS], piece[PROBES_PIECES];
  memset(number, 255, sizeof number);
  for (uint32_t part = 0; part < side->parts; part++) {
    ylm_status s = make_from(m, m->g->sides.node[side->first + part]);
    if (s != YLM_OK) return s;
    number[part] = (uint8_t)part;
  }
  for (size_t i = 0; side->parts && i < PROBES_PIECES; i++) {
    size_t x = i % 4 + 1, y = i / 4 % 4 + 1, z = i / 16 + 1;
    size_t all = (z * YLM_GRID_PIECES_ALL + y) * YLM_GRID_PIECES_ALL + x;
    uint8_t part = ylm__side_part_near(m->g, side, all);
    piece[i] = part == YLM_GRID_PARTS ? 0 : part;
  }
  m->p->parts[cell] = (uint8_t)side->parts;
  return side->parts > 1 ? add_several(m, cell, piece, number) : YLM_OK;
}

static ylm_status make_leaf(making *m, size_t cell) {
  making_cell c = m->queue[cell];
  const ylm_grid *g = m->g;
  m->p->first[cell] = (uint32_t)m->p->bricks;
  m->p->source[cell] = c.cell;
  const ylm_grid_side *side =
      g->contents.form.sides && c.cell != YLM_GRID_NONE ? ylm__grid_side_of(g, c.cell) : NULL;
  if (side) return make_sided(m, cell, side);
  m->p->parts[cell] = 1;
  bool own = g->rows == 1 && c.cell != YLM_GRID_NONE && ylm__grid_is_complete(&g->cell[c.cell]);
  return own ? make_from(m, g->cell[c.cell].corner) : make_sampled(m, &c);
}

/* -- the tree -------------------------------------------------------------------------------------- */

static ylm_status split(making *m, size_t cell) {
  making_cell c = m->queue[cell];
  const ylm_grid *g = m->g;
  uint32_t child = c.edge > c.kept ? g->cell[c.cell].child : 0;
  m->p->parts[cell] = PROBES_SPLIT;
  m->p->first[cell] = (uint32_t)m->p->cells;
  for (uint32_t k = 0; k < 8; k++) {
    making_cell d = c;
    d.edge /= 2;
    for (int a = 0; a < 3; a++) d.at[a] += k >> a & 1 ? d.edge : 0;
    if (child) {
      const ylm_grid_cell *own = &g->cell[child + k];
      d.cell = child + k;
      d.kept = own->flags & YLM_GRID_LEAF ? d.edge : 0;
    }
    ylm_status s = add_cell(m, &d);
    if (s != YLM_OK) return s;
  }
  return YLM_OK;
}

static ylm_status add_roots(making *m) {
  const ylm_grid *g = m->g;
  bool uniform = g->contents.form.kind == YLM_GRID_UNIFORM;
  for (int a = 0; a < 3; a++) m->p->roots[a] = uniform ? g->contents.resolution[a] : 1;
  uint32_t edge = uniform ? 1 : 1u << g->contents.form.depth;
  for (uint32_t z = 0; z < m->p->roots[2]; z++)
    for (uint32_t y = 0; y < m->p->roots[1]; y++)
      for (uint32_t x = 0; x < m->p->roots[0]; x++) {
        making_cell c = {.at = {x * edge, y * edge, z * edge}, .edge = edge * m->fine};
        double middle[3] = {x + 0.5, y + 0.5, z + 0.5};
        c.cell = uniform ? ylm__grid_leaf(g, middle) : 0;
        if (uniform && memcmp(g->cell[c.cell].origin, c.at, sizeof c.at) != 0)
          c.cell = YLM_GRID_NONE; /* it has no data */
        for (int a = 0; a < 3; a++) c.at[a] *= m->fine;
        c.kept = uniform || g->cell[0].flags & YLM_GRID_LEAF ? c.edge : 0;
        ylm_status s = add_cell(m, &c);
        if (s != YLM_OK) return s;
      }
  return YLM_OK;
}

static ylm_status make_cells(making *m, ylm_error *e) {
  ylm_status s = add_roots(m);
  for (size_t i = 0; s == YLM_OK && i < m->p->cells; i++) {
    const making_cell *c = &m->queue[i];
    /* a leaf is cut as often as `fine` says */
    bool leaf = c->kept && c->edge * m->fine == c->kept;
    s = leaf ? make_leaf(m, i) : split(m, i);
  }
  return s == YLM_OK ? sample_points(m, e) : s;
}

ylm_status ylm_grid_probes_make(const ylm_grid *g, int lmax, int cuts, const ylm_grid_walls *walls,
                                const ylm_grid_probes_places *at, ylm_grid_probes **out,
                                ylm_error *e) {
  *out = NULL;
  if (lmax < 1 || lmax > 2 || cuts < 0 || cuts > 3)
    return ylm_fail(e, YLM_ERANGE, "probes have lmax 1 or 2, and leaves 0 to 3 cuts; got %d and %d",
                    lmax, cuts);
  making m = {.g = g, .fine = 1u << (g->rows == 1 ? 0 : cuts)};
  m.p = ylm_alloc_zero(1, sizeof *m.p);
  m.number = ylm_alloc(g->points ? g->points : 1, sizeof *m.number);
  ylm_status s = m.p && m.number ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) {
    memcpy(m.p->bounds, g->contents.form.bounds, sizeof m.p->bounds);
    m.p->lmax = lmax;
    m.p->quantity = (int)g->contents.form.quantity;
    m.p->count = (lmax + 1) * (lmax + 1);
    for (size_t i = 0; i < g->points; i++) m.number[i] = YLM_GRID_NONE;
    s = make_cells(&m, e);
  }
  if (s == YLM_OK) s = ylm__probes_cut(g, walls, at, m.p);
  if (s == YLM_OK && at) s = ylm__probes_drop_unread(m.p, at);
  if (s == YLM_OK) s = ylm__probes_compact(m.p);
  ylm_free(m.queue);
  ylm_free(m.number);
  ylm_free(m.asked);
  ylm_free(m.sampled);
  ylm__lattice_hash_free(&m.hash);
  if (s == YLM_OK)
    *out = m.p;
  else
    ylm_grid_probes_free(m.p);
  return s == YLM_ENOMEM ? ylm_fail(e, s, "no memory for the grid's probes") : s;
}
