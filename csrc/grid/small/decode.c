/* decode.c - a grid from the sections of a small file. */
#include "small.h"

#include <math.h>
#include <string.h>

#include "ylm_math.h"

/* Adaptive bits of a byte, at most: none costs less than a 177th of one. A cell has three at least, a point two and those of its
   classes. */
#define BITS_A_BYTE 1500
#define CELL_BITS 3
#define CLASS_BITS 5

/* Points that a byte of their stream can be. */
static size_t points_a_byte(const ylm_grid *g) {
  size_t kinds = (size_t)g->contents.form.channels * (g->rows > 1 ? 2 : 1);
  return BITS_A_BYTE / (2 + CLASS_BITS * kinds);
}

float ylm__small_norm_of(const ylm_grid *g, const float *row) {
  const ylm_grid_form *f = &g->contents.form;
  size_t count = (size_t)g->contents.count;
  double sum = 0;
  if (!f->metric_channels) return NAN;
  bool mix = f->channels == 3 && f->metric_channels == 1;
  for (size_t i = 0; i < (mix ? count : g->width); i++) {
    double x = (double)row[i];
    if (mix)
      x = ylm_luminance(
          (const double[]){(double)row[i], (double)row[count + i], (double)row[2 * count + i]});
    sum += x * x;
  }
  return (float)sqrt(sum);
}

static bool in_range(float x, float least, float most) { return x >= least && x <= most; }

static bool finest_holds(const small_head *h, const ylm_grid *g) {
  return !h->finest || (g->contents.form.kind == YLM_GRID_ADAPTIVE && !g->contents.form.sides &&
                        h->finest <= (uint32_t)g->contents.form.depth);
}

bool ylm__small_head_holds(const small_head *h, const ylm_grid *g) {
  return h->version == SMALL_VERSION && h->turn <= SMALL_ALL &&
         (h->turn != SMALL_ALL || g->contents.count <= SMALL_COLUMNS) &&
         (h->turn != SMALL_BY_DEGREE || g->contents.form.lmax <= SMALL_TURN_LMAX) &&
         in_range(h->step, 1e-9f, 10) && in_range(h->slopes, 1e-3f, 1e3f) &&
         in_range(h->least, 1e-37f, 1e37f) && in_range(h->most, h->least, 1e37f) &&
         in_range(h->degree, 1e-3f, 1) && h->flags <= 3 && finest_holds(h, g) &&
         (g->contents.form.sides || !(h->sides || h->parts || h->ghosts));
}

/* -- bases ------------------------------------------------------------------------------------------ */

static const char *take_bases(small_frame *f, const small_packed *p) {
  size_t blocks = small_blocks(f), entries = f->basis.kinds * f->basis.size;
  if (p->bases_size != entries + blocks * sizeof *f->turns) return "its bases";
  memcpy(f->basis.entry, p->bases, entries);
  ylm__small_settle(&f->basis);
  if (blocks) memcpy(f->turns, p->bases + entries, blocks * sizeof *f->turns);
  for (size_t i = 0; i < blocks; i++) ylm__small_turn(f->turns[i], f->colour + 9 * i);
  return NULL;
}

/* -- points ------------------------------------------------------------------------------------------- */

typedef struct taking {
  ylm_grid *g;
  small_frame *f;
  small_points points;
  bit_coder code;
  small_tables *tables;
  rans_reader rans;
  float *number, *room;
  float read_as[2 * RANS_MOST + 1]; /* of symbols */
} taking;

/* Have all tables that numbers are taken by frequencies? */
static bool tables_hold(const small_tables *t, size_t components) {
  bool has[RANS_TABLES] = {true};
  for (size_t k = 1; k < RANS_TABLES; k++)
    for (size_t i = 0; i < RANS_SYMBOLS; i++) has[k] |= t->frequency[k][i] != 0;
  for (size_t i = 0; i < SMALL_CLASSES * components; i++)
    if (!has[t->table[i]]) return false;
  return true;
}

/* The numbers of a point; false: the stream ends early. */
static bool take_numbers(taking *t, const small_point *p, uint8_t used[4]) {
  const small_frame *f = t->f;
  size_t count = (size_t)f->count, channels = (size_t)f->channels, lists = f->rows * channels;
  rans_reader rans = t->rans;
  memset(used, 0, 4);
  memset(t->number, 0, f->rows * f->width * sizeof *t->number);
  for (size_t i = 0; i < lists; i++) {
    size_t class = p->class[i < channels ? i : channels + i % channels];
    if (!class) continue;
    const uint8_t *table = t->tables->table + (class * lists + i) * count;
    const uint16_t *coded = t->tables->coded + (class * lists + i) * count;
    size_t n = t->tables->codes[class * lists + i];
    float *to = t->number + i * count;
    used[i / channels] = 1;
    for (size_t k = 0; k < n; k++) {
      uint32_t symbol = rans_take(&rans, rans.slot[table[coded[k]]]);
      to[coded[k]] =
          symbol <= 2 * RANS_MOST ? t->read_as[symbol] : small_read_as(rans_long(&rans, symbol));
    }
    if (rans_is_short(&rans)) return false;
  }
  t->rans = rans;
  return true;
}

static const char *take_point(taking *t, size_t met) {
  ylm_grid *g = t->g;
  const small_frame *f = t->f;
  size_t to = f->k->place[met];
  float step[4], *row = g->data + to * ylm__grid_record(g);
  uint8_t used[4];
  small_point p = {0};
  int ways = ylm__small_ways(f, met);
  p.way = ylm__small_way_code(&t->points, ways, 0);
  ylm__small_predict(f, met, p.way, row);
  ylm__small_point_code(&t->points, f, ways, ylm__small_exponent(f, row), &p);
  if (p.exponent < -256 || p.exponent > 256 || t->code.short_by) return "its points";
  if (!take_numbers(t, &p, used)) return "its numbers";
  ylm__small_steps(f, met, p.exponent, step);
  ylm__small_add(f, met, step, t->number, used, row, t->room);
  if (p.invalid) g->flags[to] |= YLM_GRID_POINT_INVALID;
  if (g->validity) g->validity[to] = (float)p.validity / 255;
  g->norm[to] = ylm__small_norm_of(g, row);
  return NULL;
}

static ylm_status take_points(taking *t, const small_packed *p, const char **bad) {
  size_t all = t->f->rows * t->f->width;
  bit_coder c;
  ylm__coder_decode(&c, p->tables, p->tables_size);
  ylm__coder_decode(&t->code, p->points, p->points_size);
  ylm_status s = ylm__small_points_begin(&t->points, &t->code);
  t->tables = ylm_alloc(1, sizeof *t->tables);
  if (t->tables) *t->tables = (small_tables){.table = NULL};
  t->rans.slot = ylm_alloc(RANS_TABLES, sizeof *t->rans.slot);
  t->number = ylm_alloc(all, sizeof *t->number);
  t->room = ylm_alloc(t->f->width, sizeof *t->room);
  if (s != YLM_OK || !t->tables || !t->rans.slot || !t->number || !t->room) return YLM_ENOMEM;
  s = ylm__small_tables_room(t->tables, all);
  if (s != YLM_OK) return s;
  s = ylm__small_tables_code(t->tables, all, &c);
  bool holds = s != YLM_EFORMAT;
  if (s == YLM_OK)
    s = ylm__small_tables_list(t->tables, t->f->rows * (size_t)t->f->channels, (size_t)t->f->count);
  if (s != YLM_OK && holds) return s;
  if (!holds || !tables_hold(t->tables, all) || !ylm__rans_tables(&t->rans, t->tables->frequency)) {
    *bad = "its tables";
    return YLM_EFORMAT;
  }
  for (int i = 0; i <= 2 * RANS_MOST; i++) t->read_as[i] = small_read_as(i - RANS_MOST);
  ylm__rans_begin(&t->rans, p->data, p->data_size, p->raw, p->raw_size);
  for (size_t met = 0; !*bad && met < t->f->k->met; met++) *bad = take_point(t, met);
  if (!*bad && !ylm__rans_is_done(&t->rans)) *bad = "the end of its numbers";
  return *bad ? YLM_EFORMAT : YLM_OK;
}

static ylm_status decode_points(ylm_grid *g, small_layout *k, const small_packed *p,
                                const char **bad) {
  small_frame f = {0};
  taking t = {.g = g, .f = &f};
  ylm_status s = ylm__small_frame(&f, k, &p->head);
  if (s == YLM_OK) *bad = take_bases(&f, p);
  if (*bad) s = YLM_EFORMAT;
  if (s == YLM_OK) s = take_points(&t, p, bad);
  ylm__small_frame_free(&f);
  ylm__small_points_free(&t.points);
  if (t.tables) ylm__small_tables_free(t.tables);
  ylm_free(t.tables);
  ylm_free(t.rans.slot);
  ylm_free(t.number);
  ylm_free(t.room);
  return s;
}

/* Has each piece of a side a part of it, or none? */
static bool pieces_hold(const ylm_grid *g) {
  for (size_t i = 0; i < g->sides.n; i++)
    for (size_t k = 0; k < YLM_GRID_PIECES; k++) {
      uint32_t part = ylm_grid_side_part(&g->sides.side[i], k);
      if (part != YLM_GRID_PARTS && part >= g->sides.side[i].parts) return false;
    }
  return true;
}

/* Are the places of ghosts, which stand last, finite? */
static bool ghosts_hold(const ylm_grid *g) {
  size_t n = 0;
  while (n < g->evaluated && g->flags[g->evaluated - 1 - n] & YLM_GRID_POINT_GHOST) n++;
  return !n || ylm_all_finite(YLM_FLOAT, g->sides.asked + g->evaluated - n, 3 * n, NULL);
}

/* Has each cell corners that sampling relies on: the root, and of a lattice or a grid with sides every leaf without parts? */
static bool corners_hold(const ylm_grid *g) {
  bool every = g->contents.form.sides || g->contents.form.kind == YLM_GRID_UNIFORM;
  for (size_t i = 0; i < (every ? g->cells : 1); i++) {
    const ylm_grid_cell *c = &g->cell[i];
    bool asked = !every || (c->flags & YLM_GRID_LEAF && !(c->flags & YLM_GRID_SIDED));
    if (asked && !ylm__grid_is_complete(c)) return false;
  }
  return true;
}

ylm_status ylm__small_decode(ylm_grid *g, const small_packed *p, size_t cells, size_t evaluated,
                             int threads, const char **bad) {
  bit_coder c;
  *bad = NULL;
  if (cells / (BITS_A_BYTE / CELL_BITS) > p->tree_size ||
      evaluated / points_a_byte(g) > p->points_size) {
    *bad = "its counts";
    return YLM_EFORMAT;
  }
  ylm__coder_decode(&c, p->tree, p->tree_size);
  small_layout k = {.g = g,
                    .c = &c,
                    .most_cells = cells,
                    .most_points = evaluated,
                    .loose = p->head.loose,
                    .finest = p->head.finest};
  ylm_status s = ylm__small_lay_out(&k);
  if (s == YLM_OK) s = ylm__small_loose(&k);
  if (s == YLM_OK && (g->cells != cells || k.met != evaluated || g->sides.n != p->head.sides ||
                      g->sides.parts != p->head.parts))
    k.bad = "its counts", s = YLM_EFORMAT;
  if (s == YLM_OK) s = ylm__small_finish(&k);
  if (s == YLM_OK && !corners_hold(g)) k.bad = "a cell's corners", s = YLM_EFORMAT;
  if (s == YLM_OK && !pieces_hold(g)) k.bad = "the part of a piece", s = YLM_EFORMAT;
  if (s == YLM_OK && !ghosts_hold(g)) k.bad = "its ghosts", s = YLM_EFORMAT;
  *bad = k.bad;
  if (s == YLM_OK && p->head.flags & SMALL_HAS_VALIDITY) {
    g->validity = ylm_alloc_zero(g->point_room, sizeof *g->validity);
    if (!g->validity) s = YLM_ENOMEM;
  }
  if (s == YLM_OK) s = decode_points(g, &k, p, bad);
  if (s == YLM_OK &&
      !ylm_all_finite(YLM_FLOAT, g->data, g->evaluated * ylm__grid_record(g), NULL)) {
    *bad = "coefficients";
    s = YLM_EFORMAT;
  }
  if (s == YLM_OK) s = ylm__small_continue(&k, threads);
  ylm__small_layout_free(&k);
  return s;
}
