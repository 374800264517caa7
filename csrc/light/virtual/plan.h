/*
** plan.h - what a query about virtual lights sums, and how results follow.
**
** Private to the folder. Values and gradients of three channels, to degree YLM__VIRTUAL_STRAIGHT, are summed as they
** are, by straight.h: sums [row][3], or [row][value, 2 by x, 2 by y, by z][3]; then, where the metric may be rough,
** second derivatives of G_l Y_lm times the luminance of E, by degree k of the harmonic: [order][UU, UD, DD].
**
** All else is the product rule. With jets of E and of S_lm = G_l Y_lm by v, three blocks of rows are summed, each
** times numbers of E; the rows of a light are, for lmax 4:
**
**   block  rows                                                            times
**   0      G_l Y_lm                                            25          E, its gradient, its Hessian
**   1      U_l Y_(l+1)m, D_l Y_(l-1)m                          35 + 16     E, its gradient
**   2      UU_l Y_(l+2)m, UD_l Y_lm, DD_l Y_(l-2)m             45 + 25 + 9 E
**
** U = G' - l G/d, D = G' + (l+1) G/d, UU = U' - (l+1) U/d, and so on. Harmonics are unnormalised; the maps
** have the factors. Sums are [part][channel][row].
*/
#ifndef YLM_LIGHT_VIRTUAL_PLAN_H
#define YLM_LIGHT_VIRTUAL_PLAN_H

#include "../moments/plan.h"
#include "virtual.h"

enum {
  YLM__VIRTUAL_TILE = 16,    /* lights whose rows are kept together, at most */
  YLM__VIRTUAL_STRAIGHT = 8, /* the highest degree of lua/ylm/codegen/virtual.lua */
  YLM__VIRTUAL_BLOCK = 128,  /* lights that are summed without compensation */
  YLM__VIRTUAL_SPECIAL = 4,  /* degrees that code is written out for */
  YLM__VIRTUAL_FLOAT = 8,    /* the highest degree that is summed in float */
  YLM__VIRTUAL_PARTS = 10    /* 1, gradient, Hessian xx xy xz yy yz zz */
};

/* A product of rows and numbers of E: `channels` of these from `from` on. */
typedef struct ylm__virtual_product {
  int block, from, channels;
  size_t to; /* the first sum */
} ylm__virtual_product;

/* Sums of three channels, or of luminance: bits of `kinds`: 1 value, 2 gradient, 4 Hessian, 8 that of G_l Y_lm
   times E. */
typedef struct ylm__virtual_sums {
  int kinds, channels;
  int from;                                /* numbers of E begin here */
  size_t at[3][YLM__VIRTUAL_PARTS], first; /* sums of a part of a block; the first one of all */
} ylm__virtual_sums;

/* Adds n lights to sums; each has harmonics, then factors. straight.h */
typedef void ylm__virtual_sum(int lmax, int n, const void *lights, size_t width, size_t factors,
                              void *sums);
typedef struct ylm__virtual_straight {
  /* Of n directions, `step` apart: [(top+1)^2], `width` apart. */
  void (*harmonics)(int top, int n, const void *directions, size_t step, void *to, size_t width);
  ylm__virtual_sum *value, *one, *each, *bend;
} ylm__virtual_straight;

typedef struct ylm__virtual_plan {
  const ylm_light_virtual *lights;
  const ylm_field_query *q;
  int lmax, kinds; /* of both */
  bool straight, slopes, bends;
  size_t factors, bent, bend_sums; /* where factors and sums begin: straight.h */
  size_t rows[3], width;           /* of blocks, and of all */
  ylm__virtual_sums of[2];         /* three channels; luminance */
  int need;                        /* kinds that are wanted in luminance */
  int products, numbers;           /* of E */
  size_t sums;
  ylm__virtual_product product[12];
  ylm__rows value, once, twice; /* from rows to value, gradient [..][3], Hessian [..][6] */
  const double *scale;          /* [count]: coefficients over straight sums */
  const double *beta;           /* [lmax+3][lmax+3]: of the recurrences, by degree and order */
  const double *seen; /* [n][stride]: lights as kernels in double see them; NULL for float */
} ylm__virtual_plan;

ylm_status ylm__virtual_plan_create(ylm__virtual_plan *p, const ylm_light_virtual *v,
                                    const ylm_field_query *q);
void ylm__virtual_plan_free(ylm__virtual_plan *p);

/* Sums at points begin .. end-1. */
typedef ylm_status ylm__virtual_range(const ylm__virtual_plan *p, size_t begin, size_t end,
                                      const void *points, ylm_field_result *r);
/* The kernel of an instruction set for a query; NULL: there is none. */
ylm__virtual_range *ylm__virtual_kernel(ylm_isa isa, const ylm_field_query *q);

/*
** Lights of a list at `lanes` points, at most as many as a vector has. Adds to out
** [lanes][3][count] their coefficients by the plan's query, of three channels (kernel.h). Gradients
** by x, y, z, where the query has them, are added `row` numbers behind each other. near.isa.c adds
** to out [lanes][3] the irradiance at points with normals by zonal [lmax+1]. Lights farther than
** `reach` are nothing. scratch: as NULL at a worker's first call; freed by the caller.
*/
typedef struct ylm__virtual_near {
  const uint32_t *list;
  size_t n;
  int lanes;
  const float (*points)[3], (*normals)[3], *zonal;
  const float *rows; /* irradiance by degree 0: what numbers of the list are rows of (near.h) */
  float reach;
  size_t row;
  float *out[16];
} ylm__virtual_near;
typedef ylm_status ylm__virtual_near_fn(const ylm__virtual_plan *p, const ylm__virtual_near *near,
                                        void **scratch);
/* Numbers of a light as kernels see it, then of its emission [(degree+1)^2][3]: an intensity; to degree 2
   1, u, then xx xy xz yy yz of u' C u, whose trace is 0; beyond, coefficients of unnormalised harmonics. */
enum {
  YLM__VIRTUAL_AT,
  YLM__VIRTUAL_NORMAL = 3,
  YLM__VIRTUAL_SHIFT = 6,
  YLM__VIRTUAL_RADIUS,
  YLM__VIRTUAL_EMISSION
};

#endif
