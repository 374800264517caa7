/* encode.c - points of a grid, rounded and coded by one step. */
#include <math.h>
#include <string.h>

#include "small.h"

#define DEAD 0.35f           /* numbers round down up to 1 - DEAD above a whole one: most are 0 */
#define LEAST_OF_MEDIAN 1e-4 /* norms below this part of the median count as it */
#define IRRADIANCE_LEAST 0.0625f /* of the mean: the least norm where irradiance is what counts */
#define IRRADIANCE_MOST                                                                            \
  2.0 /* of the mean: the largest: beside a lamp that grazes a floor irradiance is far below the norm */
#define DEGREE_LEAST (1 / 24.0f) /* weight of degrees that irradiance does not see */
#define SLOPES 5.0f
#define LOOK_EVERY 4000 /* points between two looks at who waits */
#define ENOUGH 26       /* points for each coefficient that a turn of its own pays for */

struct small_encoder {
  const ylm_grid *from;
  small_common common;
  int threads;
  small_layout layout;
  bit_coder tree;
  small_frame frame;
  small_packed packed;
  int16_t *exponent; /* [met] */
  int32_t *number;   /* [met][rows * width], rounded */
  uint8_t (*class)[SMALL_KINDS];
  float learnt; /* the step that bases were learnt at; 0: none */
  bool continued;
};

/* -- making ----------------------------------------------------------------------------------------- */

/* Half an octave of a size. */
static size_t bin_of(double size) {
  int e;
  double m = frexp(size, &e);
  int bin = SMALL_NORM_BINS / 2 + 2 * e + (m >= 0.70710678118654752);
  if (!(size > 0) || bin < 0) return 0;
  return bin < SMALL_NORM_BINS ? (size_t)bin : SMALL_NORM_BINS - 1;
}

void ylm__small_count_norms(const ylm_grid *g, small_norms *n) {
  size_t count = (size_t)g->contents.count;
  for (size_t p = 0; p < g->evaluated; p++) {
    const float *row = ylm__grid_row(g, (uint32_t)p, 0);
    double sum = 0, flat = 0;
    for (size_t i = 0; i < g->width; i++) sum += (double)row[i] * (double)row[i];
    for (size_t c = 0; c < g->width; c += count) flat += (double)row[c] * (double)row[c];
    n->bin[bin_of(sqrt(sum))]++;
    n->means += sqrt(flat);
  }
  n->points += g->evaluated;
}

/* The median of what points are as large as. */
static double median_of(const small_norms *n) {
  uint64_t before = n->bin[0];
  size_t bin = 0;
  while (before <= n->points / 2 && bin + 1 < SMALL_NORM_BINS) before += n->bin[++bin];
  return bin ? ldexp(bin & 1 ? 0.84 : 0.6, ((int)bin - SMALL_NORM_BINS / 2 - (int)(bin & 1)) / 2)
             : 0;
}

small_common ylm__small_common_of(const small_norms *n, const ylm_grid_form *form) {
  double mean = n->points ? n->means / (double)n->points : 0;
  bool irradiance = form->measure == YLM_GRID_IRRADIANCE;
  double least = fmax(median_of(n), 1e-3 * mean) * LEAST_OF_MEDIAN;
  if (irradiance) least = mean * (double)IRRADIANCE_LEAST;
  return (small_common){
      .least = (float)fmax(least, 1e-30),
      .most = irradiance ? (float)fmax(IRRADIANCE_MOST * mean, 1e-30) : 1e30f,
  };
}

static small_turn turn_of(const ylm_grid *g, size_t points) {
  size_t count = (size_t)g->contents.count;
  if (points < ENOUGH * (size_t)g->contents.form.lmax) return SMALL_AS_THEY_ARE;
  if (count <= SMALL_COLUMNS && points >= ENOUGH * count) return SMALL_ALL;
  return g->contents.form.lmax <= SMALL_TURN_LMAX ? SMALL_BY_DEGREE : SMALL_AS_THEY_ARE;
}

static void make_head(small_encoder *k, small_head *h) {
  bool irradiance = k->from->contents.form.measure == YLM_GRID_IRRADIANCE;
  size_t points = k->common.points ? k->common.points : k->layout.met;
  *h = (small_head){.version = SMALL_VERSION,
                    .turn = (uint32_t)(k->common.entry ? k->common.turn : turn_of(k->from, points)),
                    .slopes = SLOPES,
                    .least = k->common.least,
                    .most = k->common.most,
                    .finest = k->common.finest,
                    .degree = irradiance ? DEGREE_LEAST : 1,
                    .loose = (uint32_t)k->layout.loose,
                    .sides = k->layout.g->sides.n,
                    .parts = k->layout.g->sides.parts,
                    .flags = (k->from->contents.form.sides ? SMALL_HAS_SIDES : 0) |
                             (k->from->validity ? SMALL_HAS_VALIDITY : 0)};
  for (size_t i = 0; i < k->layout.g->evaluated; i++)
    h->ghosts += (k->layout.g->flags[i] & YLM_GRID_POINT_GHOST) != 0;
}

static ylm_status lay_out(small_encoder *k) {
  small_layout *l = &k->layout;
  ylm__coder_encode(&k->tree);
  *l = (small_layout){.from = k->from,
                      .c = &k->tree,
                      .g = ylm__grid_new(&k->from->contents.form),
                      .finest = k->common.finest};
  l->most_cells = k->from->contents.octree_cells;
  if (!l->g) return YLM_ENOMEM;
  l->g->stats = k->from->stats;
  if (k->from->contents.root_level)
    ylm__grid_set_root(l->g, k->from->contents.root_level, k->from->contents.root);
  ylm_status s = ylm__small_lay_out(l);
  if (s == YLM_OK) s = ylm__small_loose(l);
  if (s == YLM_OK) s = ylm__coder_end(&k->tree);
  if (s == YLM_OK && !k->layout.met) return YLM_EDOMAIN;
  return s == YLM_OK ? ylm__small_finish(l) : s;
}

/* The rows of the grid itself: bases are learnt from them. */
static void copy_rows(small_encoder *k) {
  size_t row = ylm__grid_record(k->from);
  for (size_t i = 0; i < k->layout.met; i++)
    memcpy(k->layout.g->data + k->layout.place[i] * row, k->from->data + k->layout.old[i] * row,
           row * sizeof *k->from->data);
}

/* Flags, validity and norms of points: all but their rows. */
static ylm_status copy_points(small_encoder *k) {
  ylm_grid *g = k->layout.g;
  const ylm_grid *from = k->from;
  if (from->validity) {
    g->validity = ylm_alloc(g->point_room, sizeof *g->validity);
    if (!g->validity) return YLM_ENOMEM;
  }
  for (size_t i = 0; i < k->layout.met; i++) {
    size_t to = k->layout.place[i], was = k->layout.old[i];
    g->flags[to] |= from->flags[was] & YLM_GRID_POINT_INVALID;
    if (from->validity) g->validity[to] = floorf(from->validity[was] * 255 + 0.5f) / 255;
    k->exponent[i] = (int16_t)ylm__small_exponent(&k->frame, ylm__grid_row(from, (uint32_t)was, 0));
  }
  return YLM_OK;
}

/* Facts that parts of a set share, of a grid of its own. */
static ylm_status common_of(const ylm_grid *g, small_common *c) {
  small_norms *n = ylm_alloc_zero(1, sizeof *n);
  if (!n) return YLM_ENOMEM;
  ylm__small_count_norms(g, n);
  *c = ylm__small_common_of(n, &g->contents.form);
  ylm_free(n);
  return YLM_OK;
}

ylm_status ylm__small_encoder(const ylm_grid *from, const small_common *common, int threads,
                              small_encoder **out) {
  small_encoder *k = *out = ylm_alloc_zero(1, sizeof *k);
  small_head head;
  ylm_status s = YLM_OK;
  if (!k) return YLM_ENOMEM;
  k->from = from;
  k->threads = threads;
  if (common)
    k->common = *common;
  else
    s = common_of(from, &k->common);
  if (s == YLM_OK) s = lay_out(k);
  if (s != YLM_OK) return s;
  make_head(k, &head);
  size_t n = k->layout.met, all = from->rows * from->width;
  s = ylm__small_frame(&k->frame, &k->layout, &head);
  k->exponent = ylm_alloc(n, sizeof *k->exponent);
  k->number = ylm_alloc(n, all * sizeof *k->number);
  k->class = ylm_alloc(n, sizeof *k->class);
  if (s == YLM_OK && !(k->exponent && k->number && k->class)) s = YLM_ENOMEM;
  return s == YLM_OK ? copy_points(k) : s;
}

void ylm__small_packed_free(small_packed *p) {
  ylm_free(p->tree);
  ylm_free(p->bases);
  ylm_free(p->tables);
  ylm_free(p->points);
  ylm_free(p->data);
  ylm_free(p->raw);
  *p = (small_packed){0};
}

void ylm__small_encoder_free(small_encoder *k) {
  if (!k) return;
  k->packed.tree = NULL; /* that of the coder */
  ylm__small_packed_free(&k->packed);
  ylm_free(k->tree.out);
  ylm__small_frame_free(&k->frame);
  ylm_grid_free(k->layout.g);
  ylm__small_layout_free(&k->layout);
  ylm_free(k->exponent);
  ylm_free(k->number);
  ylm_free(k->class);
  ylm_free(k);
}

small_packed *ylm__small_packed_of(small_encoder *k) { return &k->packed; }
ylm_grid *ylm__small_grid_of(small_encoder *k) { return k->layout.g; }

ylm_status ylm__small_learn_common(const ylm_grid *from, float step, small_common *c) {
  small_encoder *k = NULL;
  ylm_status s = ylm__small_encoder(from, c, 1, &k);
  if (s == YLM_OK) {
    small_frame *f = &k->frame;
    copy_rows(k);
    f->head.step = step;
    s = ylm__small_learn(f, k->exponent, NULL);
    c->turn = f->basis.turn;
    c->entry = ylm_alloc_copy(f->basis.entry, f->basis.kinds * f->basis.size + 1, 1);
    if (s == YLM_OK && !c->entry) s = YLM_ENOMEM;
  }
  ylm__small_encoder_free(k);
  return s;
}

/* -- rounding ----------------------------------------------------------------------------------------- */

typedef struct rounding {
  small_encoder *k;
  bit_coder code;
  small_points points;
  float *number, *room; /* [rows * width], [width] */
  double *mean;         /* [SMALL_CLASSES][rows * width] sums of sizes */
  uint64_t *times;      /* of numbers in these */
  uint64_t (*count)[RANS_SYMBOLS];
  small_look *look;
  void *self;
} rounding;

static int32_t rounded(float x) {
  float size = floorf(fabsf(x) + DEAD);
  if (!(size <= (float)RANS_LARGEST)) size = (float)RANS_LARGEST;
  return x < 0 ? -(int32_t)size : (int32_t)size;
}

/* The prediction that the point is nearer to, of two. */
static int choose_way(const rounding *r, size_t met, int ways, float *row) {
  const small_frame *f = &r->k->frame;
  const float *exact = ylm__grid_row(r->k->from, r->k->layout.old[met], 0);
  if (ways != 3) return ways;
  double best = INFINITY;
  int way = 1;
  for (int w = 1; w <= 2; w++) {
    double sum = 0;
    ylm__small_predict(f, met, w, row);
    for (size_t i = 0; i < f->width; i++) {
      double x = (double)row[i] - (double)exact[i];
      sum += x * x;
    }
    if (sum < best) best = sum, way = w;
  }
  return way;
}

/* Rounds the numbers of a point, and counts its classes. */
static void round_numbers(rounding *r, size_t met, uint8_t used[4], small_point *p) {
  const small_frame *f = &r->k->frame;
  size_t all = f->rows * f->width, count = (size_t)f->count;
  int32_t *q = r->k->number + met * all;
  uint64_t sum[SMALL_KINDS] = {0};
  for (size_t row = 0, i = 0; row < f->rows; row++) {
    used[row] = 0;
    for (size_t c = 0; c < (size_t)f->channels; c++)
      for (size_t k = 0; k < count; k++, i++) {
        q[i] = rounded(r->number[i]);
        r->number[i] = small_read_as(q[i]);
        used[row] |= q[i] != 0;
        sum[c + (row ? (size_t)f->channels : 0)] += (uint64_t)(q[i] < 0 ? -(int64_t)q[i] : q[i]);
      }
  }
  for (int k = 0; k < SMALL_KINDS; k++) p->class[k] = (uint8_t)small_class(sum[k]);
  memcpy(r->k->class[met], p -> class, sizeof p->class);
}

static void round_point(rounding *r, size_t met) {
  small_encoder *k = r->k;
  const small_frame *f = &k->frame;
  ylm_grid *g = k->layout.g;
  size_t to = k->layout.place[met];
  float step[4], *row = g->data + to * ylm__grid_record(g);
  uint8_t used[4];
  int ways = ylm__small_ways(f, met);
  small_point p = {.way = choose_way(r, met, ways, row), .exponent = k->exponent[met]};
  p.way = ylm__small_way_code(&r->points, ways, p.way);
  p.invalid = (g->flags[to] & YLM_GRID_POINT_INVALID) != 0;
  if (g->validity) p.validity = (uint8_t)(g->validity[to] * 255 + 0.5f);
  ylm__small_predict(f, met, p.way, row);
  int expected = ylm__small_exponent(f, row);
  ylm__small_steps(f, met, p.exponent, step);
  ylm__small_difference(f, met, step, ylm__grid_row(k->from, k->layout.old[met], 0), row, r->number,
                        r->room);
  round_numbers(r, met, used, &p);
  ylm__small_point_code(&r->points, f, ways, expected, &p);
  ylm__small_add(f, met, step, r->number, used, row, r->room);
  g->norm[to] = ylm__small_norm_of(g, row);
}

/* -- tables --------------------------------------------------------------------------------------------- */

/* Calls for each number of a point that is not in the class of zeros. */
#define EACH_NUMBER(f, class_, i, c)                                                               \
  for (size_t row_ = 0, i = 0, c; row_ < (f)->rows; row_++)                                        \
    for (size_t channel_ = 0; channel_ < (size_t)(f)->channels; channel_++)                        \
      if (c = (class_)[channel_ + (row_ ? (size_t)(f)->channels : 0)], !c)                         \
        i += (size_t)(f)->count;                                                                   \
      else                                                                                         \
        for (size_t k_ = 0; k_ < (size_t)(f)->count; k_++, i++)

/* The table for numbers of a mean size: by thirds of an octave. */
static uint8_t table_of(double sum, uint64_t times) {
  if (!times || sum <= 0) return 0;
  double at = floor(3 * (log2(sum / (double)times) + 13));
  return (uint8_t)(at < 1 ? 1 : at > RANS_TABLES - 1 ? RANS_TABLES - 1 : at);
}

static void choose_tables(rounding *r, small_tables *t) {
  const small_frame *f = &r->k->frame;
  size_t all = f->rows * f->width;
  for (size_t met = 0; met < r->k->layout.met; met++) {
    const int32_t *q = r->k->number + met * all;
    EACH_NUMBER(f, r->k->class[met], i, c) {
      r->mean[c * all + i] += fabs((double)q[i]);
      r->times[c * all + i]++;
    }
  }
  for (size_t i = 0; i < SMALL_CLASSES * all; i++) t->table[i] = table_of(r->mean[i], r->times[i]);
}

static void count_numbers(rounding *r, small_tables *t) {
  const small_frame *f = &r->k->frame;
  size_t all = f->rows * f->width;
  for (size_t met = 0; met < r->k->layout.met; met++) {
    const int32_t *q = r->k->number + met * all;
    EACH_NUMBER(f, r->k->class[met], i, c) {
      int more;
      uint32_t bits;
      r->count[t->table[c * all + i]][rans_symbol(q[i], &more, &bits)]++;
    }
  }
  for (int i = 1; i < RANS_TABLES; i++) ylm__rans_count(r->count[i], t->frequency[i]);
}

static ylm_status code_numbers(rounding *r, small_tables *t, small_packed *p) {
  const small_frame *f = &r->k->frame;
  size_t all = f->rows * f->width;
  rans_writer w = {0};
  for (size_t met = 0; met < r->k->layout.met && !w.failed; met++) {
    const int32_t *q = r->k->number + met * all;
    EACH_NUMBER(f, r->k->class[met], i, c) {
      uint8_t table = t->table[c * all + i];
      if (table) ylm__rans_put(&w, table, q[i]);
    }
  }
  ylm_status s = ylm__rans_end(&w, t->frequency, &p->data, &p->data_size);
  p->raw = w.raw;
  p->raw_size = (size_t)((w.raw_bits + 7) / 8);
  w.raw = NULL;
  ylm__rans_free(&w);
  return s;
}

static ylm_status code_tables(rounding *r, small_packed *p) {
  small_tables *t = ylm_alloc(1, sizeof *t);
  size_t all = r->k->frame.rows * r->k->frame.width;
  bit_coder c;
  if (!t) return YLM_ENOMEM;
  ylm__coder_encode(&c);
  ylm_status s = ylm__small_tables_room(t, all);
  if (s == YLM_OK) {
    choose_tables(r, t);
    count_numbers(r, t);
    s = ylm__small_tables_code(t, all, &c);
  }
  if (s == YLM_OK) s = ylm__coder_end(&c);
  p->tables = c.out;
  p->tables_size = c.n;
  if (s == YLM_OK) s = code_numbers(r, t, p);
  ylm__small_tables_free(t);
  ylm_free(t);
  return s;
}

/* -- all ---------------------------------------------------------------------------------------------------- */

static ylm_status keep_bases(const small_frame *f, small_packed *p) {
  size_t blocks = small_blocks(f), entries = f->basis.kinds * f->basis.size;
  p->bases_size = entries + blocks * sizeof *f->turns;
  p->bases = ylm_alloc(p->bases_size + 1, 1);
  if (!p->bases) return YLM_ENOMEM;
  memcpy(p->bases, f->basis.entry, entries);
  if (blocks) memcpy(p->bases + entries, f->turns, blocks * sizeof *f->turns);
  return YLM_OK;
}

static ylm_status round_all(rounding *r, small_packed *p) {
  small_encoder *k = r->k;
  const small_frame *f = &k->frame;
  size_t all = f->rows * f->width;
  ylm__coder_encode(&r->code);
  ylm_status s = ylm__small_points_begin(&r->points, &r->code);
  r->number = ylm_alloc(all, sizeof *r->number);
  r->room = ylm_alloc(f->width, sizeof *r->room);
  r->mean = ylm_alloc_zero(SMALL_CLASSES * all, sizeof *r->mean);
  r->times = ylm_alloc_zero(SMALL_CLASSES * all, sizeof *r->times);
  r->count = ylm_alloc_zero(RANS_TABLES, sizeof *r->count);
  if (s == YLM_OK && !(r->number && r->room && r->mean && r->times && r->count)) s = YLM_ENOMEM;
  for (size_t met = 0; s == YLM_OK && met < k->layout.met; met++) {
    if (r->look && met % LOOK_EVERY == 0) s = r->look(r->self, (double)met / (double)k->layout.met);
    if (s == YLM_OK) round_point(r, met);
  }
  if (s == YLM_OK) s = ylm__coder_end(&r->code);
  p->points = r->code.out;
  p->points_size = r->code.n;
  if (s == YLM_OK) s = code_tables(r, p);
  if (s == YLM_OK) s = keep_bases(f, p);
  return s;
}

/* Interpolated points follow evaluated ones. */
static ylm_status follow(small_encoder *k) {
  if (k->continued) return ylm__grid_interpolate_points(k->layout.g, NULL, k->threads, NULL);
  k->continued = true;
  return ylm__small_continue(&k->layout, k->threads);
}

ylm_status ylm__small_round(small_encoder *k, float step, small_look *look, void *self) {
  rounding r = {.k = k, .look = look, .self = self};
  ylm_status s = YLM_OK;
  float octave = exp2f(floorf(log2f(step) + 0.5f));
  if (k->learnt != octave) { /* of the octave alone: what was tried before makes no difference */
    copy_rows(k);
    k->frame.head.step = k->learnt = octave;
    s = ylm__small_learn(&k->frame, k->exponent, k->common.entry);
  }
  k->frame.head.step = step;
  k->packed.tree = NULL; /* that of the coder, which stays */
  ylm__small_packed_free(&k->packed);
  k->packed.tree = k->tree.out;
  k->packed.tree_size = k->tree.n;
  k->packed.head = k->frame.head;
  if (s == YLM_OK) s = round_all(&r, &k->packed);
  ylm__small_points_free(&r.points);
  ylm_free(r.number);
  ylm_free(r.room);
  ylm_free(r.mean);
  ylm_free(r.times);
  ylm_free(r.count);
  return s == YLM_OK ? follow(k) : s;
}
