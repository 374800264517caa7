/*
** lights.h - sums over lights on a device: what the files of this room share. Private.
**
** Sums lie in the device's memory as [sum][stride]: neighbouring invocations read neighbouring numbers. The stride is the
** points of a pass rounded up to whole groups.
*/
#ifndef YLM_GPU_LIGHTS_H
#define YLM_GPU_LIGHTS_H

#include "../calibration.h"
#include "ylm_light_device.h"
#include "ylm_vulkan.h"

#define GROUP 64u /* points of a group */
#define MAX_PASSES 32
/* The highest lmax of the kernels with unrolled formulas: shaders/gen/moments.glsl. */
#define YLM__UNROLLED 10

/* A sparse matrix in the device's memory. */
typedef struct device_rows {
  uint32_t n, terms;
  ylm_gpu_buffer *start, *index, *coef;
} device_rows;

/* From sums to results; without it Hessians follow from the sums themselves. */
typedef struct device_maps {
  device_rows value, gradient, to_u, hessian;
} device_maps;

/*
** Sums in some channels, by passes over ranges of orders m. Merged moments of flat lights have
** parts: three times `part` sums from `parts` on for derivatives of the cosine, six times for
** second derivatives, which passes with `second` sum.
*/
typedef struct sum_set {
  uint32_t channel_first, channels; /* 0 3: rgb; 3 1: luminance; channels 0: none */
  uint32_t kinds, sums;             /* of each channel */
  int passes;
  struct sum_pass {
    uint32_t m_first, m_last, sums, parts, part;
    bool second, rims, loops;
    /* moments_any.real.comp and rims.real.comp: */
    uint32_t kinds, block, items;
    ylm_gpu_buffer *item;
  } pass[MAX_PASSES];
} sum_set;

/* The work of a query: made once, then found again. */
typedef struct sum_plan {
  struct sum_plan *next;
  int lmax, need_lum, need_rgb; /* kinds of results in each */
  ylm_dtype dtype;
  sum_set lum, rgb;
  int mixed; /* kinds that luminance takes from the rgb sums */
  device_maps from_lum, from_rgb, from_mixed;
  device_rows mix;           /* luminance of rgb sums */
  ylm_gpu_buffer *constants; /* of the recurrences, where lmax > YLM__UNROLLED: [m][k][4] */
  uint32_t grow;             /* what z is multiplied by there */
  ylm_gpu_buffer *betas;     /* of the recurrences of rims.real.comp, in double: [m][l] */
} sum_plan;

enum {
  BUFFER_POINTS,
  BUFFER_PARTIAL,
  BUFFER_TOTAL, /* luminance, then red, green, blue */
  BUFFER_LOST,
  BUFFER_MIXED,
  BUFFER_U,
  BUFFER_METRIC_VALUE,
  BUFFER_METRIC_HESSIAN,
  BUFFER_VALUE,
  BUFFER_GRADIENT,
  BUFFER_HESSIAN,
  BUFFER_LAMBDA,
  BUFFER_NORM,
  BUFFER_INSIDE,
  BUFFERS
};

/* Exact flat lights, in double. */
typedef struct rim_set {
  size_t objects;
  ylm_light_rims *of;           /* [objects] */
  uint32_t lights, arcs, chunk; /* arcs of lights, and arcs of a chunk */
  bool cut;                     /* some lights have horizons */
  ylm_gpu_buffer *row, *arc, *rule;
} rim_set;

struct ylm_gpu_lights {
  ylm_field field;
  ylm_gpu *gpu;
  const ylm_light_set *set;
  ylm_light_part spheres; /* kind NULL: none */
  ylm_light_part cosines; /* flat lights approximated by spheres times a cosine; kind NULL: none */
  rim_set rims;
  ylm_gpu_method method;
  uint32_t active, chunk;   /* spheres that emit; those whose sum is begun at zero */
  ylm_gpu_buffer *lamps[2]; /* by dtype; NULL: not there yet */
  sum_plan *plans;
  ylm_gpu_buffer *scratch[BUFFERS];
  ylm_gpu_times times;
  bool busy; /* a call that uses them has not returned: its progress function runs */
};

/* -- any.c ---------------------------------------------------------------------- */

/* Whether there are lights beside exact flat ones. */
static inline bool ylm__sum_base(const ylm_gpu_lights *l) {
  return l->spheres.kind || l->cosines.kind;
}
/* Whether a set is summed by moments_any.real.comp. */
static inline bool ylm__sum_any(int lmax) { return lmax > YLM__UNROLLED; }
/* The passes of a set, and the plan's constants if it has none. */
ylm_status ylm__sum_any_cut(const ylm_gpu_lights *l, sum_plan *p, sum_set *set, ylm_error *e);

/* -- rims.c --------------------------------------------------------------------- */

/* Brings the exact flat lights l->rims.of to the device. YLM_EMISSING: it has no float64. */
ylm_status ylm__rims_create(ylm_gpu_lights *l, ylm_error *e);
void ylm__rims_free(rim_set *r);
/* Adds to a set the pass that sums along rims, behind the sums that are there. */
ylm_status ylm__rims_cut(const ylm_gpu_lights *l, sum_plan *p, sum_set *set, ylm_error *e);

/* -- ../rival/loops.c ----------------------------------------------------------- */

/* Whether lights are summed one by one, to compare with. */
static inline bool ylm__loops(const ylm_gpu_lights *l) { return l->method != YLM_GPU_MERGED; }
/* YLM_ERANGE: lmax is beyond what shaders/gen/product.glsl unrolls. */
ylm_status ylm__loops_check(const ylm_gpu_lights *l, const ylm_field_query *q, ylm_error *e);
/* The passes of a set. */
void ylm__loops_cut(const ylm_gpu_lights *l, int lmax, sum_set *set);

/* -- plan.c ------------------------------------------------------------------- */

/* Sums of all orders. */
uint32_t ylm__sum_count_of(int lmax, uint32_t kinds);
/* How many derivatives go with kinds. */
static inline int ylm__sum_derivatives(uint32_t kinds) { return kinds & 4 ? 2 : kinds & 2 ? 1 : 0; }
/* The plan of a query, which the object keeps. */
ylm_status ylm__sum_plan_get(ylm_gpu_lights *l, const ylm_field_query *q, const sum_plan **p,
                             ylm_error *e);
void ylm__sum_plans_free(sum_plan *p);

/* -- work.c ------------------------------------------------------------------- */

/* Bytes of the device's memory: of a point beside partial sums, of the widest of its arrays, and of
   the partial sums of one chunk. */
typedef struct sum_size {
  size_t all, widest, partial;
} sum_size;
sum_size ylm__sum_size(const sum_plan *p, const ylm_field_query *q);

/* Evaluates the n points in BUFFER_POINTS; results are left in the scratch buffers. */
ylm_status ylm__sum_run(ylm_gpu_lights *l, const sum_plan *p, const ylm_field_query *q, uint32_t n,
                        uint32_t chunks_at_once, const ylm_progress *progress, ylm_error *e);

/* -- lights.c ------------------------------------------------------------------- */

/* Pairs of a point with the lights that emit. */
static inline uint64_t ylm__lights_pairs(const ylm_gpu_lights *l) {
  return (uint64_t)l->active + l->rims.lights;
}
/* Chunks whose sums are added. */
static inline uint32_t ylm__lights_chunks(const ylm_gpu_lights *l) {
  uint32_t n = (l->active + l->chunk - 1) / l->chunk, arcs = 0;
  if (l->rims.arcs) arcs = (l->rims.arcs + l->rims.chunk - 1) / l->rims.chunk;
  return n > arcs ? n : arcs;
}
/* YLM_EBUSY while a call uses the lights. */
ylm_status ylm__lights_idle(const ylm_gpu_lights *l, ylm_error *e);
/* Scratch of at least so many bytes. */
ylm_status ylm__lights_scratch(ylm_gpu_lights *l, int which, uint64_t bytes, ylm_error *e);
/* Adds the wall time of a copy since `start` to a stage of the object's times. */
void ylm__lights_copied(ylm_gpu_lights *l, const char *name, double start);

/* How many points go into a pass, the same in whole groups, and how many chunks' sums at once. */
typedef struct sum_reach {
  size_t rows;
  uint64_t places;
  uint32_t at_once;
} sum_reach;
/* For n points, each of which takes `other` bytes in an array of the caller. YLM_ELIMIT. */
ylm_status ylm__lights_reach(const ylm_gpu_lights *l, const sum_plan *plan,
                             const ylm_field_query *q, size_t n, size_t other, sum_reach *r,
                             ylm_error *e);

#endif
