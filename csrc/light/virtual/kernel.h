/* kernel.h - sums over virtual lights for the unit's element type: lanes are points. plan.h says what is summed. Files named
   x.real.isa.c are compiled once per element type and instruction set. Private to the folder.

   Lights go into a tile (add_light), tiles into sums (flush: by products, or straight), sums to results. */
#ifndef YLM_LIGHT_VIRTUAL_KERNEL_H
#define YLM_LIGHT_VIRTUAL_KERNEL_H

#include "distance.h"
#include "emission.h"

#include "../moments/gen/compensation.h"
#include "../moments/gen/recurrences.h"

#ifdef YLM_REAL_IS_FLOAT
#define COEF coef_f
#define ROWS_OF(p) ((p)->lights->seen)
#else
#define COEF coef
#define ROWS_OF(p) ((p)->seen)
#endif

/* eps^2 of a smooth light over sg^2. */
#define SOFT ((real)(YLM__GAUSS_SOFT * YLM__GAUSS_SOFT))

/* Bytes of a tile that stay in the first cache beside the sums, and of sums that do; fewest lights of a tile; lights of
   a tile of products. Measured on 48 KiB of cache with 512-bit vectors. */
enum { STRAIGHT_BYTES = 12288, SUM_BYTES = 40960, STRAIGHT_LEAST = 4, PRODUCT_TILE = 8 };
enum { ARRAYS = 8, TILE = YLM__VIRTUAL_TILE, TOP = YLM_LIGHT_LMAX + 2 };

/* VIRTUAL(name): the name of a function that other files of the type and set call. */
#define VIRTUAL(name) YLM_REAL_KERNEL(ylm__virtual_##name)

/* Weights of rows, by the degree of their harmonic; block 2 beyond 0 and 1. */
typedef struct weights {
  vreal value[TOP + 1], up[TOP + 1], down[TOP + 1], upup[TOP + 1], same[TOP + 1], downdown[TOP + 1];
} weights;

/* A light of the tile at the points: w, the squared distance, 1/d, 1/D, n.u, e^(-sg^2/d^2), and the cosine, 0 where it
   sends nothing. */
typedef struct sight {
  vreal w[3], d2, inv, inverse, along, heat, cosine;
} sight;

typedef struct work {
  vreal *S, *E, *B;         /* [TILE][width], [TILE][numbers], [TILE][4 (lmax+1)] */
  vreal *sum, *part, *lost; /* [sums] */
  vreal *mixed, *out;       /* [sums of three channels], [6 count] */
  double beta[(YLM_LIGHT_VIRTUAL_DEGREE + 1) * (YLM_LIGHT_VIRTUAL_DEGREE + 1)];
  weights weights;
  sight sight[TILE];
  const real *lamp[TILE];
  const ylm__virtual_plan *of; /* of the lights in the tile */
  int tile, held;              /* lights that a tile takes, and has */
} work;

/* -- tile.real.isa.c ------------------------------------------------------------------------ */

/* Vectors that the arrays of a work take. */
size_t VIRTUAL(room_of)(const ylm__virtual_plan *p);
/* A work whose arrays are at x, of room_of vectors. */
void VIRTUAL(work_place)(work *k, const ylm__virtual_plan *p, vreal *x);
/* Adds the tile's lights to the sums. */
void VIRTUAL(flush)(const ylm__virtual_plan *q, work *k);
/* factors.real.isa.c, products.real.isa.c */
void VIRTUAL(sum_straight)(const ylm__virtual_plan *p, work *k);
void VIRTUAL(sum_products)(const ylm__virtual_plan *p, work *k);

/* -- stages.real.isa.c ---------------------------------------------------------------------- */

/* Weights [lmax+1][4] of a light. */
typedef void weigh_fn(const ylm__virtual_plan *p, const real *lamp, const sight *s, vreal *B);
typedef void send_fn(const seen *s, int degree, const double *beta, const real *lamp, vreal *E);

/* [order][profile]; [three channels, luminance][order] */
extern weigh_fn *const VIRTUAL(weighers)[3][5];
extern send_fn *const VIRTUAL(senders)[2][3];

/* Derivatives of distances, and of emissions. */
YLM_INLINE int order_of(int kinds) { return kinds & 12 ? 2 : kinds & 2 ? 1 : 0; }
YLM_INLINE int jet_of(int kinds) { return kinds & 4 ? 2 : kinds & 2 ? 1 : 0; }

YLM_INLINE falloff fall_of(const int profile, const int order, const ylm__virtual_plan *p,
                           const real *lamp, const sight *s) {
  return begin_fall(profile, order, lamp, (real)p->lights->core, (real)p->lights->outer, s->d2,
                    s->inv * s->inv, s->heat);
}

YLM_INLINE void seen_of(const sight *s, const real *lamp, seen *to) {
  const vmask front = s->cosine > 0;
  const vreal part = -s->d2 * s->inv * s->inverse;
  to->inverse = s->inverse;
  to->cosine = s->cosine;
  for (int a = 0; a < 3; a++) {
    to->u[a] = s->w[a] * part;
    to->normal[a] = keep_lanes(front, vreal_set(lamp[YLM__VIRTUAL_NORMAL + a]));
  }
}

/* -- results.real.isa.c --------------------------------------------------------------------- */

/* Luminance of sums of three channels, where the first channel's are. */
void VIRTUAL(mix)(const ylm__virtual_plan *p, work *k);
/* Coefficients of channel c of `channels` from sums: [count], gradients by x, [count][3], and second derivatives, [count][6]. */
void VIRTUAL(value_of)(const ylm__virtual_plan *p, const work *k, int channels, int c, vreal *out);
void VIRTUAL(gradient_of)(const ylm__virtual_plan *p, const work *k, int channels, int c,
                          vreal *out);
void VIRTUAL(hessian_of)(const ylm__virtual_plan *p, const work *k, int channels, int c,
                         vreal *out);
/* Writes what the query wants, but the metric, to points from `point` on; then the metric. */
void VIRTUAL(results)(const ylm__virtual_plan *p, work *k, size_t point, int lanes,
                      ylm_field_result *r);
void VIRTUAL(metric)(const ylm__virtual_plan *p, work *k, size_t point, int lanes,
                     ylm_field_result *r);

/* -- lights to tiles ------------------------------------------------------------------------ */

YLM_INLINE bool is_sharp(ylm_light_virtual_profile profile) {
  return profile == YLM_LIGHT_VIRTUAL_POINT || profile == YLM_LIGHT_VIRTUAL_CAP;
}

/* Without a normal. */
YLM_INLINE bool is_round(const real *lamp) {
  const real *n = lamp + YLM__VIRTUAL_NORMAL;
  return n[0] == 0 && n[1] == 0 && n[2] == 0;
}

/*
** Takes a light into the tile, unless it sends nothing to any lane; nor farther than the root of reach2, where that
** is above 0. The row must stay where it is until the tile is flushed, which happens where it is full. Plans of
** other lights may take turns, for one query.
*/
YLM_INLINE void add_light(const ylm__virtual_plan *p, work *k, const real *lamp, const vreal xyz[3],
                          const real reach2) {
  if (k->of != p &&
      (k->of->lights->degree != p->lights->degree || k->of->lights->profile != p->lights->profile))
    VIRTUAL(flush)(p, k);
  k->of = p;
  const bool sharp = is_sharp(p->lights->profile), round = is_round(lamp);
  const real *n = lamp + YLM__VIRTUAL_NORMAL, shift = lamp[YLM__VIRTUAL_SHIFT];
  const real width2 = width2_of(lamp);
  vreal v[3];
  for (int a = 0; a < 3; a++) v[a] = lamp[a] - xyz[a];
  vreal d2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2], D2 = d2;
  const vreal along = n[0] * v[0] + n[1] * v[1] + n[2] * v[2];
  vmask lit = along < 0;
  if (shift > 0 || round) lit = d2 >= 0;
  if (sharp) lit &= d2 > 0;
  if (reach2 > 0) lit &= d2 < reach2;
  if (!any(lit)) return;
  if (sharp)
    D2 = d2 = choose(d2 > 0, d2, vreal_set(1));
  else
    D2 += width2 * SOFT, d2 = larger(d2, vreal_set(NEAREST * width2));
  sight *s = &k->sight[k->held];
  s->d2 = d2;
  s->inverse = inverse_root(D2);
  const vreal inv = s->inv = inverse_root(d2);
  s->along = -along * s->inverse;
  const vreal c = round ? vreal_set(1) : shift + s->along;
  s->cosine = keep_lanes(lit & (c > 0), c);
  for (int a = 0; a < 3; a++) s->w[a] = v[a] * inv;
  if (!sharp) s->heat = decay(inv * inv * width2);
  k->lamp[k->held] = lamp;
  if (++k->held == k->tile) VIRTUAL(flush)(p, k);
}

#endif
