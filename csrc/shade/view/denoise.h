/* denoise.h - what the files that take noise from light share. Private to csrc/shade. */
#ifndef YLM_SHADE_DENOISE_H
#define YLM_SHADE_DENOISE_H

#include "../calibration.h"
#include "../view.h"

/* Numbers of a tap of the grid: place, normal, share, class, then what a pass works on. */
enum {
  TAP_X,
  TAP_NORMAL = 3,
  TAP_SHARE = 6,
  TAP_CLASS,
  TAP_GUIDE,       /* luminance of two halves */
  TAP_SPREAD = 10, /* variance of these */
  TAP_APART,       /* squared difference of the halves' luminance, before any pass */
  TAP_ALL,         /* luminance of all irradiance */
  TAP_VALUE,       /* irradiance of two halves, [2][3] */
  TAP_NUMBERS = TAP_VALUE + 6
};

/* The largest point of each pixel, or the mean of those of 2 x 2 pixels: rows of each number, with room around that counts
   for nothing. */
typedef struct denoise_grid {
  size_t cell; /* pixels on a side of what a number is of: 1 or 2 */
  size_t width, height, stride;
  float *number[TAP_NUMBERS]; /* [height + 2 DENOISE_REACH][stride] */
} denoise_grid;

/* The point whose light is asked for; lengths in the picture are in cells. */
typedef struct denoise_centre {
  size_t at;     /* its cell in the grid */
  float off[2];  /* from the middle of that */
  int rows;      /* above and below it */
  float falloff; /* one over the squared distance in the picture that counts for nothing */
  float around;  /* one over the squared distance in space that counts for nothing */
  float plane;   /* one over the distance from its plane that counts for nothing */
  float x[3], normal[3], class;
  float guide[2], spread;
} denoise_centre;

/* Sums over taps, of two halves; with u and v, which a tap is right of and below the centre. */
typedef struct denoise_sums {
  float weight[2], square[2], value[2][3];
  float u[2], v[2], uu[2], uv[2], vv[2], value_u[2][3], value_v[2][3]; /* `fit` alone */
} denoise_sums;

/* Sums for a centre: a half's weights are by the guide of the other. */
typedef void denoise_gather_fn(const denoise_grid *g, const denoise_centre *c, denoise_sums *out);
/* Sums of weights without guides, and by them of TAP_APART and TAP_ALL. */
typedef void denoise_vary_fn(const denoise_grid *g, const denoise_centre *c, float out[3]);

typedef struct denoise_kernels {
  denoise_gather_fn *gather, *fit; /* gather: without u and v */
  denoise_vary_fn *vary;
} denoise_kernels;

/* The kernels of the instruction set in use. denoise_plain.c */
denoise_kernels ylm__denoise_kernels(void);

/* Light of points before a filter and after it. Points whose reach is below 1 are not filtered. */
typedef struct denoise_balance {
  const ylm_shade_view *view;
  const float (*before)[2][3];   /* [points] radiance by two halves */
  const float *variance, *reach; /* [points] of the luminance of a half */
  float **half;                  /* [2][points][3] after it */
} denoise_balance;

/* Gives cells of pixels the light that they had before, as far as that is known. balance.c */
ylm_status ylm__denoise_balance(const denoise_balance *b, int threads);

/* Shares irradiance that was left out of points, rare [points], with all of their cells. balance.c */
ylm_status ylm__denoise_share(const denoise_balance *b, const float (*rare)[2][3], int threads);
/* Luminous irradiance at point i, to a factor, by the radiance [points][3] that it reflects. denoise.c */
float ylm__denoise_irradiance(const ylm_shade_view *v, size_t i, const float *radiance);

#endif
