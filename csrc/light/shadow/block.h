/*
** block.h - light behind casters at the points of a block, for the element type `real`: what its stages share. Files named
** x.real.c are compiled once per element type. Private to the room.
**
** The stages of a block: casters as points see them (see), what these hide (hide), lights and the casters before them
** (before), which casters overlap (layers), products at nodes (products, spheres, logarithms), results (write).
**
** Rows of coefficients: [rows][count], the value and, with gradients, its derivatives to x, y, z.
*/
#ifndef YLM_LIGHT_SHADOW_BLOCK_H
#define YLM_LIGHT_SHADOW_BLOCK_H

#include <float.h>

#include "shadow.h"

/* SHADOW(name): the name of a function that other files of the type call. */
#ifdef YLM_REAL_IS_FLOAT
typedef float real;
#define DTYPE YLM_FLOAT
#define REAL_EPSILON FLT_EPSILON
#define SHADOW(name) ylm__shadow_##name##_f
#else
typedef double real;
#define DTYPE YLM_DOUBLE
#define REAL_EPSILON DBL_EPSILON
#define SHADOW(name) ylm__shadow_##name##_d
#endif

typedef struct request {
  size_t point, light;
} request;

typedef struct block {
  shadow_query *w;
  size_t begin, m;
  double point[SHADOW_BLOCK][3];
  uint8_t inside[SHADOW_BLOCK], any[SHADOW_BLOCK]; /* in a caster; on a light */
  size_t *by_caster_first, *by_caster;             /* [casters + 1] of the list of [seens] */
  size_t seen_first[SHADOW_BLOCK + 1], seens, seen_room, befores, before_room, parts, part_room,
      terms, term_room, lights, light_room, requests, by_room, blur_room, filled_room;
  shadow_seen *seen;
  uint32_t *look; /* [casters] in the order in which a point looks for them */
  shadow_before *before;
  shadow_part *part;
  shadow_term *term;
  request request[SHADOW_BLOCK];
  real *hidden;    /* [seens][rows][count] visibilities where the casters stand */
  bool layered;    /* of one caster at a time, which are summed by layers: see hide.real.c */
  real *layers;    /* [layers of all terms][rows][count] */
  real *light;     /* [lights][channels][rows][count] */
  real *out;       /* [m][channels][rows][count]; NULL: results stand where they are wanted */
  double *blur;    /* [seens] lambda of visibilities, where it is wanted */
  uint8_t *filled; /* [layers of all terms] its row has something */
  struct viewers *viewers; /* of hide.real.c */
  double lambda[SHADOW_BLOCK];
  ylm_error *e;
  int worker;
} block;

/* Room for one more of `n` things. */
static inline bool grow(void **list, size_t n, size_t *room, size_t size) {
  return n < *room || ylm__shadow_grow(list, n, room, size);
}

/* Memory of at least so many numbers, which the thread's next block uses again; NULL without any. */
static inline real *room(const block *b, int which, size_t numbers) {
  return ylm__shadow_room(b->w, b->worker, which, numbers * sizeof(real));
}

/* Rows of even light: [channels][rows][count], of which gradients are 0; its values at nodes: [channels][nodes]. */
static inline const real *even_row(const shadow_query *w, size_t c) {
  return (const real *)w->even + c * w->rows * w->count;
}

static inline size_t tile_values(const shadow_query *w) {
  return ylm_sh_nodes_lanes(w->nodes, DTYPE) * ylm_sh_nodes_count(w->nodes);
}

/* Up to the next 16, with which rows begin. */
static inline size_t sixteens(size_t n) { return (n + 15) / 16 * 16; }

/* Numbers of even light before the values at nodes of channel c; c of all channels: its numbers. */
static inline size_t even_before(const shadow_query *w, size_t c) {
  return sixteens(w->channels * w->rows * w->count) + c * sixteens(ylm_sh_nodes_count(w->nodes));
}

static inline real *even_nodes(const shadow_query *w, size_t c) {
  return (real *)w->even + even_before(w, c);
}

/* The place of a point of the block among the query's. */
static inline size_t place_of(const block *b, size_t i) {
  return b->w->place ? b->w->place[b->begin + i] : b->begin + i;
}

/* Rows of a point's result. */
static inline real *out_row(const block *b, size_t i) {
  const shadow_query *w = b->w;
  size_t wide = w->channels * w->rows * w->count;
  return b->out ? b->out + i * wide : (real *)w->r->value + place_of(b, i) * wide;
}

/* Row c of a light. */
static inline const real *light_row(const block *b, size_t light, size_t c) {
  const shadow_query *w = b->w;
  return light == SHADOW_EVEN ? even_row(w, c)
                              : b->light + (light * w->channels + c) * w->rows * w->count;
}

/* A field's answer at n points, as rows. */
typedef struct answer {
  real *value, *gradient, lambda[SHADOW_BLOCK]; /* lambda where it is wanted */
  uint8_t inside[SHADOW_BLOCK];
} answer;

/* Values at nodes: [count][lanes] each. */
typedef struct tile {
  block *b;
  size_t lanes, n, values; /* terms in lanes, numbers of one function */
  const shadow_term *term[16];
  real *f, *g[3], *one, *two;
  real *row, *unit, *zero, *result; /* [lanes][rows][count]; [count] each; [lanes][count] */
  real *profile;                    /* [1 + lanes][rows][rings->padded] */
  void *scratch;
} tile;

/* -- ask.real.c -------------------------------------------------------------------------------- */

/* SHADOW_BLOCK points at most are relative to `origin`; NULL: to 0. `into`: where values go, or NULL. */
ylm_status SHADOW(ask)(block *b, const ylm_field *f, int lmax, size_t channels, size_t n,
                       const real *points, const double *origin, real *into, answer *a);
/* Row i of an answer of `own` coefficients to a row of the query's, whose other coefficients are 0. */
void SHADOW(unfold)(const shadow_query *w, const answer *a, size_t i, size_t own, real *to);

/* -- stages ------------------------------------------------------------------------------------- */

/* A body of that radius as the point sees it; false where it hides too little to count. see.real.c */
bool SHADOW(look)(const double p[3], const double at[3], double radius, double least,
                  shadow_seen *to);
/* Lists the casters that points see, the nearest first. */
ylm_status SHADOW(see)(block *b);
/* hide.real.c: rows of visibility of all that points see. */
ylm_status SHADOW(hide)(block *b);

/* Even light at the points of the block. before.real.c */
ylm_status SHADOW(add_even)(block *b);
/* Light that all lamps send, and light behind all casters, at the points of the block. */
ylm_status SHADOW(sum_lights)(block *b, const ylm_field *f, bool behind);
/* Casters before a lamp at each point. Terms from `from` on may have the same. */
ylm_status SHADOW(before_lamp)(block *b, const shadow_lamp *l, size_t from);

/* Puts the casters of each term into layers that do not overlap. layers.real.c */
void SHADOW(layer)(block *b);
/* Notes how much there is to multiply. */
void SHADOW(count)(const block *b);

/* All terms, those with the most layers first, so that the lanes of a tile have about as many. products.real.c */
ylm_status SHADOW(multiply)(block *b);
/* Value or derivative d of a layer to nodes. */
void SHADOW(to_nodes)(const tile *t, const real *const *row, size_t d, bool multiply, real *to);
/* The largest value of a lane at nodes. */
double SHADOW(largest)(const real *light, size_t values, size_t lanes, size_t lane);
/* Multiplies the lanes by their spheres. spheres.real.c */
void SHADOW(multiply_spheres)(const tile *t);
/* The visibility of casters in each lane, at nodes. logarithms.real.c */
ylm_status SHADOW(exponentials)(const tile *t);

/* Results of the block's points. write.real.c */
void SHADOW(write)(const block *b);

#endif
