/*
** small.h - grids in few bytes: predicted, turned, rounded, counted. docs/grids.md has the format.
**
** A small file has a grid's octree as bits and its points as rounded differences from predictions by points before them.
** Encoder and reader make the same grid by the same walk (layout.c) and the same arithmetic (row.c), so that the encoder holds
** what any reader will decode, to the bit, and can measure it.
*/
#ifndef YLM_GRID_SMALL_H
#define YLM_GRID_SMALL_H

#include "../grid.h"
#include "coder.h"
#include "rans.h"

#define SMALL_VERSION 1u
#define SMALL_BLOCK 64u  /* points that share a basis of colour */
#define SMALL_CLASSES 32 /* sizes of a point's numbers */
#define SMALL_PARENTS 4
#define SMALL_COLUMNS 81   /* of a matrix that turns coefficients, at most */
#define SMALL_TURN_LMAX 40 /* up to which a degree has no more of them */
#define SMALL_KINDS 6      /* of classes: values and slopes, of each channel */

#define SMALL_LOOSE 0xff    /* level of points that no cell has brought */
#define SMALL_TURN_MOST 511 /* of 10 bits with a sign */
#define SMALL_RISE 0.08f    /* numbers are read as larger by it */

#define SMALL_ASKED_BITS 16 /* of a ghost's place, along an axis */
#define SMALL_NEAR_BITS 3   /* of the pieces from which a ghost's place may be seen */
#define SMALL_WAY_BITS 8    /* of the way from there */

/* Constants that other decoders need, by their names there. */
#define SMALL_CONSTANTS(X)                                                                         \
  X(NONE, YLM_GRID_NONE)                                                                           \
  X(LEAF, YLM_GRID_LEAF)                                                                           \
  X(OCCUPIED, YLM_GRID_OCCUPIED)                                                                   \
  X(BAKED, YLM_GRID_BAKED)                                                                         \
  X(CROSSED, YLM_GRID_CROSSED)                                                                     \
  X(BRICK, YLM_GRID_BRICK)                                                                         \
  X(SIDED, YLM_GRID_SIDED)                                                                         \
  X(GHOST, YLM_GRID_POINT_GHOST)                                                                   \
  X(PIECES, YLM_GRID_PIECES)                                                                       \
  X(ACROSS, YLM_GRID_PIECES_ALL)                                                                   \
  X(ASKED_BITS, SMALL_ASKED_BITS)                                                                  \
  X(NEAR_BITS, SMALL_NEAR_BITS)                                                                    \
  X(WAY_BITS, SMALL_WAY_BITS)                                                                      \
  X(LOOSE, SMALL_LOOSE)                                                                            \
  X(BLOCK, SMALL_BLOCK)                                                                            \
  X(PARENTS, SMALL_PARENTS)                                                                        \
  X(CLASSES, SMALL_CLASSES)                                                                        \
  X(TURN_MOST, SMALL_TURN_MOST)                                                                    \
  X(RISE, SMALL_RISE)                                                                              \
  X(EVEN, CODER_EVEN)                                                                              \
  X(QUICK, CODER_QUICK)                                                                            \
  X(SLOW, CODER_SLOW)                                                                              \
  X(LEAST, CODER_LEAST)                                                                            \
  X(TOP, CODER_TOP)                                                                                \
  X(TABLES, RANS_TABLES)                                                                           \
  X(SYMBOLS, RANS_SYMBOLS)                                                                         \
  X(MOST, RANS_MOST)                                                                               \
  X(LONG, RANS_LONG)                                                                               \
  X(LONG_BITS, RANS_LONG_BITS)                                                                     \
  X(BITS, RANS_BITS)                                                                               \
  X(STATES, RANS_STATES)

/* How coefficients are turned. */
typedef enum small_turn { SMALL_AS_THEY_ARE = 0, SMALL_BY_DEGREE = 1, SMALL_ALL = 2 } small_turn;

enum { SMALL_HAS_SIDES = 1, SMALL_HAS_VALIDITY = 2 };

/* Section "small". */
typedef struct small_head {
  uint32_t version, turn;
  float step;        /* of values, relative to the light's norm at the point */
  float slopes;      /* steps of slopes, in those of values an edge */
  float least, most; /* norms below and above count as these */
  float degree;      /* the least weight of a degree of irradiance; 1: all are alike */
  uint32_t loose;    /* points that are corners of no cell */
  uint64_t sides, parts, ghosts;
  uint32_t flags; /* SMALL_HAS_* */
  /* The finest level of cells of the top of the set that the grid is a part of; 0: it is a grid of its own. */
  uint32_t finest;
} small_head;

/*
** Parts of a set are read alone, and their neighbours' points on shared borders have to be the same bits. Points of the top,
** and those on the border of a brick, are therefore coded first, by what all parts that have them know: their place in the
** lattice, and each other.
*/
static inline bool small_on_border(const ylm_grid *g, const uint32_t at[3]) {
  bool border = false;
  for (int a = 0; a < 3; a++) border |= at[a] == g->contents.root[a] || at[a] > g->last[a];
  return border;
}
static inline bool small_is_shared(const ylm_grid *g, uint32_t finest, const uint32_t at[3]) {
  return finest && (!g->contents.root_level || small_on_border(g, at));
}
/* The level of cells of the lattice that a place is first a corner of. */
static inline int small_lattice_level(const ylm_grid *g, const uint32_t at[3]) {
  uint32_t all = at[0] | at[1] | at[2];
  int depth = g->contents.form.depth, zeros = all ? __builtin_ctz(all) : depth;
  return zeros < depth ? depth - zeros : 0;
}

/* -- layout.c: cells, points and what predicts them ----------------------------------------------- */

/* Points that a point is predicted from; all are before it. */
typedef struct small_source {
  uint32_t parent
      [SMALL_PARENTS]; /* cells of the level above that have it at a half of their edges; YLM_GRID_NONE: no more */
  uint32_t
      kin; /* the cell, or where `of_part` the part, that has it as corner; YLM_GRID_NONE: none */
  uint8_t corner, of_part;
} small_source;

/* A grid in the making. Points are met in an order, and numbered by it, but that ghosts stand last. */
typedef struct small_layout {
  ylm_grid *g;
  const ylm_grid *from; /* encoder: the grid that is encoded */
  bit_coder *c;
  uint32_t *was; /* [cells] encoder: the cell of `from` */
  size_t was_room;
  uint32_t *old; /* [met] encoder: the point of `from` */
  size_t old_room;
  lattice_hash known;   /* encoder: points of `from` that are no ghosts */
  small_source *source; /* [met] */
  size_t source_room, met;
  uint32_t *place,
      *rank; /* [met] the number of a point that was met, and back: from ylm__small_finish on */
  uint8_t *level; /* [met] of the cells that it was met at; LOOSE */
  size_t level_room;
  uint32_t *
      before; /* [met] the ghost before it at the same corner; from ylm__small_finish on the number that it was met with */
  size_t before_room;
  lattice_hash ghost; /* the last ghost at a corner */
  size_t loose;
  uint32_t finest; /* as of small_head */
  struct layout_chances *chance;
  const char *bad; /* the error of a damaged stream */
  size_t most_cells, most_points;
} small_layout;

/* Makes cells, sides and points (without data), from `from` or from the stream. */
ylm_status ylm__small_lay_out(small_layout *k);
/* Points on the border of a brick that its cells do not ask for, of `from` or of the stream. */
ylm_status ylm__small_loose(small_layout *k);
/* Numbers of points, corners that cells share. Points can have their rows then. */
ylm_status ylm__small_finish(small_layout *k);
/* Continuity and interpolated points, whose rows are made from those of evaluated ones: the grid can be sampled. */
ylm_status ylm__small_continue(small_layout *k, int threads);
void ylm__small_layout_free(small_layout *k);

/* -- row.c: the arithmetic that encoder and reader share --------------------------------------------- */

/* A turn of coefficients: columns of an orthonormal matrix, entries / 127 before they are made so. */
typedef struct small_basis {
  small_turn turn;
  int lmax, count;
  size_t kinds, size; /* rows of a point; entries of one kind's matrix */
  int8_t *entry;      /* [kinds][size], by blocks and columns */
  float *column;      /* [kinds][size] */
} small_basis;

/* Steps and predictions of a grid's rows. */
typedef struct small_frame {
  const struct small_kernels *sums;
  const ylm_grid *g;
  const small_layout *k;
  small_head head;
  size_t rows, width;
  int channels, count;
  float *weight, *unweight;      /* [count] of a coefficient's degree; their reciprocals */
  struct small_weights *weights; /* [levels] of predictions by parents */
  uint8_t *edge;                 /* [met] level of the largest leaf that the point is a corner of */
  double voxel[3];               /* the scene's extent of one cell of the lattice */
  small_basis basis;
  float *colour;   /* [blocks][9] columns; NULL: one channel */
  uint32_t *turns; /* [blocks] of these, as they are written */
} small_frame;

ylm_status ylm__small_frame(small_frame *f, const small_layout *k, const small_head *head);
void ylm__small_frame_free(small_frame *f);
/* Room for bases that stand for no turn. */
ylm_status ylm__small_bases(small_frame *f);
/* Columns from entries. */
void ylm__small_settle(small_basis *b);
/* Entries of one kind's matrix. */
size_t ylm__small_basis_size(small_turn turn, int lmax);
#define SMALL_NO_TURN (511u | 511u << 10 | 511u << 20)
/* The turn of a block's colours: columns. */
void ylm__small_turn(uint32_t turn, float column[9]);

/* Blocks of points that share a turn of colours; 0: there is one channel. */
static inline size_t small_blocks(const small_frame *f) {
  return f->channels == 1 ? 0 : (f->k->met + SMALL_BLOCK - 1) / SMALL_BLOCK;
}
/* Can a point be predicted by parents, by kin? Bits 1, 2. */
int ylm__small_ways(const small_frame *f, size_t met);
/* The prediction of a point: [rows][stride]. */
void ylm__small_predict(const small_frame *f, size_t met, int way, float *row);
/* Steps of the rows of a point whose norm's exponent is e: of values, and of slopes by axis. */
void ylm__small_steps(const small_frame *f, size_t met, int e, float step[4]);
/* Numbers [rows][width] to differences, which are added to the prediction. room: [2][width]. */
void ylm__small_add(const small_frame *f, size_t met, const float step[4], const float *number,
                    const uint8_t *used, float *row, float *room);
/* The encoder's: numbers [rows][width], not rounded yet, of a row and its prediction. room: [count]. */
void ylm__small_difference(const small_frame *f, size_t met, const float step[4], const float *row,
                           const float *predicted, float *number, float *room);
/* The norm that a row's steps are relative to, as an exponent. */
int ylm__small_exponent(const small_frame *f, const float *row);
/* The norm of an exponent: 2^(e/2). */
float ylm__small_norm(int e);
/* A number as it is read. */
static inline float small_read_as(int32_t q) {
  return q > 0 ? (float)q + SMALL_RISE : q < 0 ? (float)q - SMALL_RISE : 0.0f;
}
/* The class of a point's numbers, by the sum of their sizes. */
static inline uint32_t small_class(uint64_t sum) {
  uint32_t c = 0;
  static const uint32_t from[SMALL_CLASSES] = {
      0,  1,  2,  3,   4,   5,   6,   7,   9,   11,  14,  17,  21,  26,   32,   40,
      50, 63, 80, 101, 127, 160, 202, 254, 320, 404, 509, 641, 900, 1500, 3000, 8000};
  while (c + 1 < SMALL_CLASSES && sum >= from[c + 1]) c++;
  return c;
}

/* -- mix.isa.c: sums that take most of the time; equal bits in all sets --------------------------------- */

#define SMALL_LANES 8 /* numbers that are summed side by side: strides are multiples of it */
#define SMALL_TERMS (SMALL_PARENTS * 32)

/* A prediction of one row of a point: rows of corners and their weights. */
typedef struct small_mix {
  int n;
  const float *row[SMALL_TERMS];
  float weight[SMALL_TERMS];
} small_mix;

typedef struct small_kernels {
  /* Sums in the order of their terms, scaled. n: a multiple of SMALL_LANES. */
  void (*mix)(const small_mix *m, float scale, float *to, size_t n);
  /* to[n] = the sum of number[k] times column k of [n][n]. */
  void (*turn)(const float *column, const float *number, float *to, size_t n);
  /* to[3][n] += the turned colours of x[3][n], times step and by[n]. */
  void (*colour)(const float v[9], const float *x, float step, const float *by, float *to,
                 size_t n);
} small_kernels;
const small_kernels *ylm__small_kernels(void);
extern const small_kernels ylm__small_plain;

/* -- stream.c: points as streams ---------------------------------------------------------------------- */

/* Tables and estimates of points' streams. */
typedef struct small_tables {
  uint8_t *table; /* [SMALL_CLASSES][rows * width] of RANS_TABLES */
  uint16_t *
      coded; /* reader: [SMALL_CLASSES][rows * width] of each row and channel the coefficients whose table is not 0 */
  uint16_t *codes; /* [SMALL_CLASSES][rows * channels] how many */
  uint16_t frequency[RANS_TABLES][RANS_SYMBOLS];
} small_tables;
/* Lists what is coded, for a reader. */
ylm_status ylm__small_tables_list(small_tables *t, size_t rows, size_t count);
ylm_status ylm__small_tables_room(small_tables *t, size_t components);
void ylm__small_tables_free(small_tables *t);
/* Codes tables; YLM_EFORMAT where these of a stream do not hold, YLM_ENOMEM. */
ylm_status ylm__small_tables_code(small_tables *t, size_t components, bit_coder *c);

/* Facts that stand beside a point's numbers. */
typedef struct small_point {
  int exponent, way;
  uint8_t invalid, validity;
  uint8_t class[SMALL_KINDS];
} small_point;
struct point_chances;
typedef struct small_points {
  bit_coder *c;
  struct point_chances *chance;
  small_point before;
} small_points;
ylm_status ylm__small_points_begin(small_points *s, bit_coder *c);
void ylm__small_points_free(small_points *s);
/* How a point is predicted, of the ways that there are. */
int ylm__small_way_code(small_points *s, int ways, int way);
/* `expected` is the exponent of the prediction's norm. */
void ylm__small_point_code(small_points *s, const small_frame *f, int ways, int expected,
                           small_point *p);

/* -- learn.c: bases ------------------------------------------------------------------------------------- */

/* Bases of the differences between a grid's own rows and predictions by the rows that the grid in the making has; exponents
   [met] of the light's norms. entry: the turn of coefficients that is known; NULL: it is learnt. */
ylm_status ylm__small_learn(small_frame *f, const int16_t *exponent, const int8_t *entry);

/* -- encode.c --------------------------------------------------------------------------------------------- */

/* Bytes of the sections of a small file. */
typedef struct small_packed {
  small_head head;
  ylm_grid_small_report report;
  unsigned char *tree, *bases, *tables, *points, *data, *raw;
  size_t tree_size, bases_size, tables_size, points_size, data_size, raw_size;
} small_packed;

void ylm__small_packed_free(small_packed *p);

/* Sizes of points' light. */
#define SMALL_NORM_BINS 1024 /* half octaves */
typedef struct small_norms {
  uint64_t points, bin[SMALL_NORM_BINS];
  double means; /* the sum of the sizes of their means */
} small_norms;
void ylm__small_count_norms(const ylm_grid *g, small_norms *n);
/* Facts that all parts of a set share. */
typedef struct small_common {
  float least, most; /* as of small_head */
  uint32_t finest;
  size_t points; /* of a part, in the mean: they choose the turn of coefficients; 0: not known */
  small_turn turn;
  int8_t *entry; /* of that turn (ylm_free); NULL: it is learnt */
} small_common;

/* An encoding under way: the grid in the making holds what readers will decode. */
typedef struct small_encoder small_encoder;
/* common: NULL for a grid of its own. */
ylm_status ylm__small_encoder(const ylm_grid *from, const small_common *common, int threads,
                              small_encoder **out);
small_common ylm__small_common_of(const small_norms *n, const ylm_grid_form *form);
void ylm__small_encoder_free(small_encoder *k);
/* Rounds and codes all points with a step relative to the light's norm; look, which may be NULL, is called now and then with the
   part that is done, and ends it by another status than YLM_OK. */
typedef ylm_status small_look(void *self, double done);
ylm_status ylm__small_round(small_encoder *k, float step, small_look *look, void *self);
/* The turn of coefficients that a grid learns at a step, for all parts of its set: c->turn and c->entry. */
ylm_status ylm__small_learn_common(const ylm_grid *from, float step, small_common *c);
small_packed *ylm__small_packed_of(small_encoder *k);
ylm_grid *ylm__small_grid_of(small_encoder *k);

/* -- decode.c --------------------------------------------------------------------------------------------- */

/* Makes cells and points of a grid that has its form, from sections; the error of damaged ones through *bad. */
ylm_status ylm__small_decode(ylm_grid *g, const small_packed *p, size_t cells, size_t evaluated,
                             int threads, const char **bad);
/* The norm of a point's rows: of luminance or of all channels, as the form says; NaN where it says none. */
float ylm__small_norm_of(const ylm_grid *g, const float *row);
/* Whether a header is of a kind that this reader knows. */
bool ylm__small_head_holds(const small_head *h, const ylm_grid *g);

/* -- hunt.c: the step of rounding that is asked for ------------------------------------------------------------ */

#define SMALL_TRIES 8
typedef struct small_hunt {
  const ylm_grid_small *how;
  double before; /* the error of the grid; NAN: not known */
  bool judged;   /* errors add as squares: those of the exact light are known */
  size_t width;  /* of rows */
  /* Rounds by a step: what this errs by in all, or the bytes that it takes. */
  ylm_status (*round)(void *self, double step, double *found);
  void *self;
  int tries; /* 0: SMALL_TRIES */
  double steep;
} small_hunt;
/* The step that asks for no more than what is asked for; the last that was rounded by. YLM_ELIMIT: there is none. */
ylm_status ylm__small_hunt(small_hunt *h, double *step);
/* The step that may do, after one by which `found` was found. */
double ylm__small_next_step(const small_hunt *h, double step, double found);

/* -- search.c ------------------------------------------------------------------------------------------------ */

/* Bytes of the file that a grid and its sections are. */
typedef uint64_t small_size_fn(const ylm_grid *g, const small_packed *small);
/* Searches the step that is asked for. */
ylm_status ylm__small_search(small_encoder *k, const ylm_grid *from, const ylm_grid_small *how,
                             small_size_fn *size, ylm_error *e);
/* Errors of rounding at n random places of a grid that is rounded, sorted: error [n]. */
ylm_status ylm__small_roundings(small_encoder *k, const ylm_grid *from, int threads, size_t n,
                                double *error, ylm_error *e);
/* As much of another grid with equal cells and points. */
ylm_status ylm__small_errors(const ylm_grid *from, const ylm_grid *to, int threads, size_t n,
                             double *error, ylm_error *e);
void ylm__small_sort(double *error, size_t n);
double ylm__small_quantile(const double *error, size_t n, double q);

#endif
