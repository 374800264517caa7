/* many_gloss.h - receivers of virtual lights that gloss. Private to csrc/shade. */
#ifndef YLM_SHADE_MANY_GLOSS_H
#define YLM_SHADE_MANY_GLOSS_H

#include "many.h"
#include "ylm_material_table.h"

/* Recurrences of harmonics by order, then degree: p_mm = first[m], p_(l+1)m = a z p_lm - b r^2 p_(l-1)m, and
   Y_lm = p_lm times the real (m >= 0) or imaginary part of (x + i y)^|m|. */
typedef struct gather_series {
  int lmax;
  size_t entries;       /* (lmax+1)(lmax+2)/2 */
  float *first, *a, *b; /* [lmax+1], [entries] */
} gather_series;

/* YLM_ENOMEM */
ylm_status ylm__gather_series(int lmax, gather_series *s);
void ylm__gather_series_free(gather_series *s);
/* The place of (l, m), m >= 0, in this order. */
static inline size_t ylm__gather_entry(int lmax, int l, int m) {
  return (size_t)(m * (lmax + 1) - m * (m - 1) / 2 + l - m);
}

/* A point that glosses. */
typedef struct gather_receiver {
  const ylm_material *material; /* NULL: the point is matte */
  float wo[3];                  /* to the eye, in the surface's frame */
  float turn[2];                /* cosine and sine from the view's frame to that */
  float axis[3][3];             /* of the view: x in the plane of normal and eye, y, normal */
  /* harmonics: slices, windowed, whose mixtures the channels are */
  const gather_series *series;
  int functions;         /* 0: no harmonics */
  bool halves;           /* m >= 0 alone counts */
  const float (*mix)[3]; /* NULL: functions are the channels */
  const float *row;      /* [functions][2][entries]: m >= 0, m < 0 */
  /* zonal lobes: about an axis, times the cosine at the light, above a matte base; of VSGL Gaussian ones */
  bool zonal;
  float lobe[3];      /* the axis, in the world */
  const float *lobes; /* [3][lmax+1] */
  float base[3];      /* sr^-1 */
  bool based;         /* one of them is above 0 */
  float sharp;        /* VSGL: the lobe's sharpness; lobes [3] are powers over A */
} gather_receiver;

/* The materials in sight that gloss. */
typedef struct gather_gloss gather_gloss;

/* *out NULL where none does or all count as matte; to be freed on failure too. */
ylm_status ylm__gather_gloss(const ylm_shade_view *v, const ylm_shade_gather_options *o,
                             gather_gloss **out, ylm_error *e);
void ylm__gather_gloss_free(gather_gloss *g);
/* Whether point p glosses. */
bool ylm__gather_glosses(const gather_gloss *g, const ylm_shade_view *v, size_t p);
/* Floats that one point's rows take. */
size_t ylm__gather_gloss_room(const gather_gloss *g);
/* The receiver at point p, which glosses; room [ylm__gather_gloss_room]. YLM_ENOMEM */
ylm_status ylm__gather_receive(const gather_gloss *g, const ylm_shade_view *v, size_t p,
                               float *room, gather_receiver *r);

/* f of the receiver, sr^-1, of light from n <= GATHER_CHUNK directions w of the world: f [n][3]. */
void ylm__gather_eval(const gather_receiver *r, size_t n, const float (*w)[3], float (*f)[3]);
/* As the kernels of many.h have it, of light i: out [functions]. The plain form. */
void ylm__gather_gloss_weight(const gather_lights *l, const gather_ask *a, const gather_receiver *r,
                              size_t i, const float x[3], double out[3]);
/* The paper's Eq. 22: the part of light i that is above the horizon of N at x. many_plain.c */
double ylm__gather_above(const gather_lights *l, size_t i, const float x[3], const float N[3]);

#endif
