/*
** ylm_shade_rival.h - virtual lights as kernels want them, and ways to ask them that exist to be compared with.
**
** ylm_shade_gather_virtual itself knows harmonics (HVL), of all lights or of a few by chance. Points, spheres, groups as
** Gaussians and interleaved lights stand in libylm_rival.so (csrc/rival/many), whose table ylm_shade_rival_set takes.
** Until then the answer for these is YLM_EMISSING. That library is linked with libylm.so alone: it calls libylm_scene.so
** by an ylm_many_host.
*/
#ifndef YLM_SHADE_RIVAL_H
#define YLM_SHADE_RIVAL_H

#include "ylm_light_virtual.h"
#include "ylm_material_table.h"
#include "ylm_shade_bounce.h"

#ifdef __cplusplus
extern "C" {
#endif

/* -- lights and points ------------------------------------------------------------------- */

/* Lights that are looked at in one go; arrays of them are padded to a multiple of it. */
#define YLM_MANY_CHUNK 512

/* Recurrences of harmonics by order, then degree: p_mm = first[m], p_(l+1)m = a z p_lm - b r^2 p_(l-1)m, and
   Y_lm = p_lm times the real (m >= 0) or imaginary part of (x + i y)^|m|. */
typedef struct ylm_many_series {
  int lmax;
  size_t entries;       /* (lmax+1)(lmax+2)/2 */
  float *first, *a, *b; /* [lmax+1], [entries] */
} ylm_many_series;

/* The place of (l, m), m >= 0, in this order. */
static inline size_t ylm_many_entry(int lmax, int l, int m) {
  return (size_t)(m * (lmax + 1) - m * (m - 1) / 2 + l - m);
}

/* Lights as kernels want them: arrays of one number each. Padding lies at 0 and sends nothing. */
typedef struct ylm_many_lights {
  size_t n, padded; /* with groups n is `padded` */
  ylm_light_virtual_form form;
  size_t groups; /* that points ask one of: of a tile's pixels; else 1 */
  size_t *begin; /* [groups + 1] multiples of YLM_MANY_LOBES; NULL: one */
  float *bright; /* [padded] bounds of the luminance of intensities; NULL: not asked for */
  float *at[3], *normal[3], *shift; /* [padded]; without a normal the shift is 1 */
  float *radius;                    /* [padded] */
  float *intensity[3];              /* [padded] degree 0; else lobes */
  float *memory;
  /* of a degree: emission of YLM_MANY_LOBES lights beside each other, in the order of ylm_many_series:
     [padded/YLM_MANY_LOBES][entries][3][2: m >= 0, m < 0][YLM_MANY_LOBES], and the highest degree in it that counts */
  float *lobe;
  uint8_t *top;
  const ylm_many_series *series; /* of their degree */
} ylm_many_lights;

/* Lights whose emission stands together. */
#define YLM_MANY_LOBES 16

/* The question to a light. */
typedef struct ylm_many_ask {
  const struct ylm_many_host *host; /* of rivals alone */
  const ylm_shade_gather_options *o;
  float zonal[YLM_SHADE_GATHER_LMAX + 1]; /* a_l (2l+1)/(4 pi) window_l */
  float up[YLM_SHADE_GATHER_LMAX + 1],
      down[YLM_SHADE_GATHER_LMAX + 1]; /* P_(l+1) = up_l c P_l - down_l P_(l-1) */
  float core;                          /* 1/R^4 of far and near */
  double alpha;                        /* stochastic: light above which a light is always kept */
  float reflectance;                   /* of the receiver: luminance of its albedo over pi */
} ylm_many_ask;

/* A point that glosses. */
typedef struct ylm_many_receiver {
  const ylm_material *material; /* NULL: the point is matte */
  float wo[3];                  /* to the eye, in the surface's frame */
  float turn[2];                /* cosine and sine from the view's frame to that */
  float axis[3][3];             /* of the view: x in the plane of normal and eye, y, normal */
  /* harmonics: slices, windowed, whose mixtures the channels are */
  const ylm_many_series *series;
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
} ylm_many_receiver;

/* -- kernels ----------------------------------------------------------------------------- */

/* w[k]: irradiance at x, normal N, by light first + k for an intensity of 1, k < n. In all of these n <= YLM_MANY_CHUNK is a
   multiple of YLM_MANY_LOBES. */
typedef void ylm_many_weights_fn(const ylm_many_lights *l, const ylm_many_ask *a, size_t first,
                                 size_t n, const float x[3], const float N[3], float *w);
/* sum[c] += w[k] I[c][k], k < n. */
typedef void ylm_many_collect_fn(size_t n, const float *w, const float *const I[3], double sum[3]);

/* As collect, with weights for each channel: w [3][YLM_MANY_CHUNK]. */
typedef void ylm_many_collect_each_fn(size_t n, const float (*w)[YLM_MANY_CHUNK],
                                      const float *const I[3], double sum[3]);
/* I[c][k]: intensity of light first + k, whose emission has a degree, towards x; k < n. `soft`: profiles
   whose direction is. */
typedef void ylm_many_send_fn(const ylm_many_lights *l, bool soft, size_t first, size_t n,
                              const float x[3], float (*I)[YLM_MANY_CHUNK]);
/* As weights, of a receiver that glosses: w [functions][YLM_MANY_CHUNK], radiance by functions of its slices; of zonal
   lobes [3], of VSGL without the base. */
typedef void ylm_many_gloss_fn(const ylm_many_lights *l, const ylm_many_ask *a,
                               const ylm_many_receiver *r, size_t first, size_t n, const float x[3],
                               float (*w)[YLM_MANY_CHUNK]);

/* As weights, of lights as spheres; seed: of the point; keep [n]: factors, 0 leaves a light out; NULL: 1. */
typedef void ylm_many_spheres_fn(const ylm_many_lights *l, const ylm_many_ask *a, size_t first,
                                 size_t n, const float x[3], const float N[3],
                                 const uint32_t seed[2], const float *keep, float *w);
/* As that, of a receiver that glosses: radiance for an intensity of 1, w [3][YLM_MANY_CHUNK]. */
typedef void ylm_many_spheres_gloss_fn(const ylm_many_lights *l, const ylm_many_ask *a,
                                       const ylm_many_receiver *r, size_t first, size_t n,
                                       const float x[3], const uint32_t seed[2], const float *keep,
                                       float (*w)[YLM_MANY_CHUNK]);

typedef struct ylm_many_kernels {
  ylm_many_weights_fn *weights;
  ylm_many_collect_fn *collect;
  ylm_many_collect_each_fn *collect_each;
  ylm_many_send_fn *send;
  ylm_many_gloss_fn *gloss;
  ylm_many_spheres_fn *spheres; /* NULL, but of VSL */
  ylm_many_spheres_gloss_fn *spheres_gloss;
} ylm_many_kernels;

/* -- rivals ------------------------------------------------------------------------------ */

struct many_gloss;

/* The points of a view, and the functions of libylm_scene.so that rivals call. */
typedef struct ylm_many_host {
  const ylm_shade_view *view;
  const struct many_gloss *gloss; /* of points that gloss; NULL: none does */
  const ylm_scene *scene;
  size_t points;
  size_t size[2];           /* of the image, pixels */
  const double *eye;        /* [3] */
  const float (*origin)[3]; /* [points] where rays start */
  const float (*normal)[3]; /* [points] */
  const uint32_t *mesh;     /* [points] */
  /* the first point of a pixel; of the number of pixels: how many points there are */
  size_t (*first)(const ylm_shade_view *view, size_t pixel);
  uint64_t (*stream)(const ylm_shade_view *view, size_t point); /* its random numbers */
  void (*albedo)(const ylm_shade_view *view, size_t point, float albedo[3]);
  void (*tint)(const ylm_shade_view *view, size_t first, size_t n, float *radiance);
  /* whether a point glosses; the receiver there (room NULL: without tables, never fails); its f, sr^-1, of light from n <=
     YLM_MANY_CHUNK directions w of the world */
  bool (*glosses)(const struct many_gloss *gloss, const ylm_shade_view *view, size_t point);
  ylm_status (*receive)(const struct many_gloss *gloss, const ylm_shade_view *view, size_t point,
                        float *room, ylm_many_receiver *r);
  void (*eval)(const ylm_many_receiver *r, size_t n, const float (*w)[3], float (*f)[3]);
  void (*basis)(const float n[3], float a[3], float b[3]); /* ylm_scene_basis */
  const ylm_trace *trace;
  void (*nearest)(const ylm_trace *trace, size_t n, const ylm_trace_ray *rays, bool coherent,
                  ylm_trace_hit *hits); /* ylm_trace_nearest */
  void (*surfaces)(const ylm_scene *scene, size_t n, const ylm_scene_place *p,
                   ylm_scene_surface *out); /* ylm_scene_surfaces */
  /* ylm_path_places, seen from the eye, with shadows */
  ylm_status (*places)(const ylm_scene *scene, size_t n, const ylm_scene_place *places,
                       const size_t *first, const float *weight, const double eye[3], bool shadows,
                       const ylm_path_options *o, ylm_path_sum *sum, ylm_path_stats *stats,
                       ylm_error *e);
} ylm_many_host;

/*
** The methods of libylm_rival.so.
**   kernels     puts those of a method, of the instruction set in use, in place of those of HVL
**   parts       VSGL: groups of lights, parted where they are widest in place and direction. Light i of `out` is group i:
**               at its mean place, normal the axis of its lobe, radius the deviation of its places, shift its sharpness,
**               intensity its power over A (sharpness). *count: how many there are, at most `groups`; YLM_ENOMEM
**   compensate  VPL: adds to irradiances [points][3], of points that gloss radiances, what the bound took; YLM_ENOMEM
**   filter      INTERLEAVED: in place, irradiances [points][3] of points that ask one light of tile^2 become means over a
**               tile of pixels. A mean takes points on the same mesh whose normals are within 20 degrees. Points that gloss
**               stay as they are; YLM_ENOMEM
*/
typedef struct ylm_shade_rival {
  void (*kernels)(ylm_shade_gather_method method, ylm_many_kernels *k);
  ylm_status (*parts)(const ylm_light_virtual *lights, size_t groups, size_t *count,
                      const ylm_many_lights *out);
  ylm_status (*compensate)(const ylm_many_ask *a, float *out, uint64_t *rays, ylm_error *e);
  ylm_status (*filter)(const ylm_many_host *host, int tile, int threads, float *out);
} ylm_shade_rival;

#ifdef __cplusplus
}
#endif
#endif
