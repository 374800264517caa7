/* light.h - what the files of csrc/light share. Private to the folder. */
#ifndef YLM_LIGHT_PRIVATE_H
#define YLM_LIGHT_PRIVATE_H

#include "lamp.h"
#include "sphere/sphere.h"
#include "ylm_light.h"

/* How many channels of each kind of sum a query needs: 0, 1 (luminance) or 3 (rgb). */
typedef struct ylm__channels {
  int value, gradient, hessian;
} ylm__channels;
ylm__channels ylm__channels_of(const ylm_field_query *q);

/* Channel c of `channels` of a light's radiance. */
static inline double ylm__emission(const double *rgb, int channels, int c) {
  return channels == 3
             ? rgb[c]
             : YLM_LUMINANCE_R * rgb[0] + YLM_LUMINANCE_G * rgb[1] + YLM_LUMINANCE_B * rgb[2];
}

/*
** X_a^k[p,m]: the integral of Y_kp w_a Y_(k+1)m over the sphere; axis a = 0, 1, 2 for x, y, z.
** The product is w_a Y_km = sum X_a^k[m,m'] Y_(k+1)m' + sum X_a^(k-1)[m',m] Y_(k-1)m'.
*/
double ylm__coupling(int a, int k, int p, int m);

/* The reference: product rule, double, points begin .. end-1. */
ylm_status ylm__reference_range(const ylm_lights *lights, const ylm_field_query *q, size_t begin,
                                size_t end, const void *points, ylm_field_result *r);

/* The tree of a set of lights, or NULL; YLM_ENOMEM. */
ylm_status ylm__tree_create(const ylm_lights *lights, int threads, struct ylm_light_tree **tree);
void ylm__tree_free(struct ylm_light_tree *tree);

/* A query about sphere lights is sound. */
ylm_status ylm__lights_check(const ylm_field_query *q, ylm_isa isa, size_t n, const void *points,
                             const ylm_field_result *r, ylm_error *e);

/* Whether lights' surfaces meet boxes. */
ylm_status ylm__crosses(const ylm_field *f, size_t n, const double *boxes, uint8_t *out);

/* A query as kernels see it: its points relative to the origin of the lights. */
typedef struct ylm__local {
  ylm_field_query q; /* without an origin */
  const void *points;
  void *room;
} ylm__local;
/* Points of the query stay where they are if the origins are the same; else they are moved in
   double, then rounded. To be ended in any case. YLM_ENOMEM. local.c */
ylm_status ylm__local_begin(const ylm_field_query *q, const double origin[3], size_t n,
                            const void *points, ylm__local *out);
void ylm__local_end(ylm__local *local);

/* Writes what q wants for a point from sums [channels][wide]: value [count], gradient [count][3],
   Hessian [count][6] in that order; channels 3, or 1 where luminance is all that is wanted. */
void ylm__field_write(const ylm_field_query *q, size_t point, int channels, const double *sum,
                      size_t wide, ylm_field_result *r);

#endif
