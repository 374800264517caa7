/*
** shadow.h - what the files of csrc/light/shadow share. Private to the room.
**
** A query goes block by block (block.real.c): which casters hide something from each point, what each of them hides there,
** which lamps they stand before, the products at nodes.
*/
#ifndef YLM_LIGHT_SHADOW_PRIVATE_H
#define YLM_LIGHT_SHADOW_PRIVATE_H

#include <math.h>
#include <stdatomic.h>

#include "../kind.h"
#include "ylm_light_shadow.h"
#include "ylm_sh.h"
#include "ylm_sh_exponential.h"

#define LIGHT_ONE 3.54490770181103205459 /* sqrt(4 pi): the function 1 */

/* -- solids ---------------------------------------------------------------------------------- */

/* A closed convex mesh. */
typedef struct ylm__solid {
  double centre[3], radius, area; /* a sphere around it; its surface */
  double middle[3];               /* of its corners: inside of it */
  size_t planes, numbers;
  double *plane;  /* [planes][4] unit normal outwards, offset */
  double *record; /* [numbers] its faces as records of polygons of radiance 1/2 */
} ylm__solid;

/* Arguments and results as ylm_light_occluder_solid; plane and record are the caller's to free. solid.c */
ylm_status ylm__solid_create(size_t vertices, const float *position, size_t triangles,
                             const uint32_t *index, ylm__solid *s, ylm_error *e);

/* Whether a field is the visibility of a sphere, and which. occluder.c */
bool ylm__occluder_ball(const ylm_field *f, double at[3], double *radius);

/* -- shadowed light -------------------------------------------------------------------------- */

/* Lights of a pack that are taken apart at most; a larger pack is one light, behind all casters. */
#define SHADOW_LAMPS 4096
/* Points of a block. */
#define SHADOW_BLOCK 256
#define SHADOW_BLOCK_GRADIENTS 64
/* Viewers of a caster whose rows are turned and summed at a time: those of a tile of rotations. */
#define SHADOW_PLACED 32
/* The width of the step at the rim of a sphere that is evaluated at nodes, in distances of nodes: in a body of several, and of
   a lone one. Of 1, errors of irradiance are twice as large. */
#define SHADOW_STEP 2
#define SHADOW_STEP_LONE 2.5
#define SHADOW_EVEN SIZE_MAX
/* Beyond this share of the distance that a caster's field is asked within, it blends into a disk. */
#define SHADOW_BLEND 0.9

/* A lamp that casters may stand before or behind. */
typedef struct shadow_lamp {
  double at[3], radius, rgb[3];
  ylm_light_set *grey; /* of radiance 1 */
} shadow_lamp;

typedef struct shadow_caster {
  ylm_light_caster form;
  double centre[3], radius; /* of the sphere around it, where it stands */
  bool turned;              /* its rotation is not the identity */
  bool lone;                /* the only sphere of its body */
  ylm_light_occluder *disk; /* what stands for it far away, about `centre` of its frame */
} shadow_caster;

/* The directions of a rule, ring by ring around z, each ring in the order of azimuths and padded. */
typedef struct shadow_rings {
  size_t n, padded, around; /* around: directions of a ring but the equator */
  double *z;                /* [n] */
  size_t *first;            /* [n][2] the first direction, how many */
  uint32_t *node;           /* [padded] their places among the nodes of the rule */
  double *at;               /* [3][padded] */
  float *at_f;
} shadow_rings;

/* Tables of one lmax. */
typedef struct shadow_tables {
  ylm_sh_nodes *nodes;
  shadow_rings rings;
  ylm_sh_rotator *rotator;
  ylm_sh_exponential *exponential; /* of product exp */
} shadow_tables;

struct ylm_light_shadowed {
  ylm_field field;
  ylm_light_shadow_form form;
  size_t n;
  bool spheres; /* some are evaluated at directions */
  shadow_caster *caster;
  const ylm_field *local; /* the sum of the lamps; NULL: there are none */
  const ylm_field *rest;  /* light behind all casters; NULL: there is none */
  bool even;              /* that light is the same at all points */
  ylm_field_sum *local_sum, *rest_sum;
  size_t lamps;
  shadow_lamp *lamp;
  _Atomic(shadow_tables *) tables[YLM_SH_PRODUCT_LMAX + 1];
  _Atomic(uint64_t) points, casters, products, factors, nanoseconds; /* so far */
};

/* -- one query -------------------------------------------------------------------------------- */

/* out[i] = a[i] b[i] + c[i] d[i]; out may be any of them. sums.c, sums.isa.c */
typedef void shadow_sums_fn(size_t n, float *out, const float *a, const float *b, const float *c,
                            const float *d);
shadow_sums_fn *ylm__shadow_sums(void);
/* to[i] += from[i]. sums.c, sums.isa.c */
typedef void shadow_add_fn(size_t n, float *to, const float *from);
shadow_add_fn *ylm__shadow_add(void);

/* The step at the rims of spheres. */
typedef struct shadow_blur {
  double step, half_cosine, half_sine; /* width; of half of it */
  double mean;                         /* of the cosine over the step's slope */
} shadow_blur;

/* A sphere as directions see it. */
typedef struct shadow_cap {
  double w[3], cosine, sine; /* the middle; of half its angle */
  double limit, low, high;   /* cosine of the angle where it ends; z from and to there */
  double step, deep;         /* of its rim; how much it hides in its middle */
  double azimuth, reach; /* of the middle; sine of the largest azimuth from there, or more than 1 */
  double over, turn, fade[3]; /* 1/distance; derivatives of the angle and of `deep` */
} shadow_cap;

/* v [rows][padded] becomes the smaller of itself and a cap's profile, or their product; rows 1, or 4 with derivatives. */
typedef void shadow_profile_fn(const shadow_rings *r, const shadow_cap *c, bool times, size_t rows,
                               float *v);

/* Memory that the blocks of a thread use one after the other. */
enum {
  ROOM_HIDDEN,
  ROOM_LAYERS,
  ROOM_VALUE,
  ROOM_GRADIENT,
  ROOM_OUT,
  ROOM_TILE,
  ROOM_SCRATCH,
  ROOMS
};
typedef struct shadow_room {
  void *at;
  size_t bytes;
} shadow_room;

/* The query, as all blocks share it. */
typedef struct shadow_query {
  const ylm_light_shadowed *s;
  size_t skip, skips; /* casters that are left out: the first, how many */
  const ylm_field_query *q;
  const void *points;
  const uint32_t *place; /* of a point among those of the query, NULL: its own; see order.c */
  ylm_field_result *r;
  const ylm_sh_nodes *nodes;
  const shadow_rings *rings;
  shadow_blur blur[2];                   /* of bodies of several spheres, of lone ones */
  shadow_profile_fn *profile;            /* NULL: the plain form */
  const ylm_sh_exponential *exponential; /* NULL: visibilities are multiplied */
  ylm_sh_rotation **turn;                /* [n] NULL where a caster is not turned */
  const size_t
      *order; /* [n] casters by their places, in which sums do not depend on how they are listed */
  size_t count, rows, channels; /* coefficients; 1, or 4 with gradients; of the light */
  void *even;          /* light that is the same at all points, see block.h; NULL: there is none */
  double even_most[3]; /* the largest of its values at nodes, of each channel */
  bool metric;
  shadow_room *room; /* [threads][ROOMS] */
  void **block;      /* [threads] of block.h */
  _Atomic(uint64_t) pairs, casters, products, factors;
  shadow_sums_fn *sums;
  shadow_add_fn *add;
} shadow_query;

/* A caster as a point sees it. */
typedef struct shadow_seen {
  double w[3], distance, sine,
      cosine; /* direction and distance of its centre; of half the angle of its cone, 1, -1 in it */
  size_t row; /* of the block: its visibility; where casters are summed by layers, its layer */
  uint32_t caster, point;
} shadow_seen;

/* Half the angle of the cone of a caster; pi in it. */
static inline double shadow_angle(const shadow_seen *s) {
  return s->sine < 1 ? asin(s->sine) : YLM_PI;
}

/* A lamp, or all light behind casters, at a point, with the casters before it. */
typedef struct shadow_term {
  size_t point, first, n; /* casters first .. first+n-1 of the block's list `before` */
  size_t light;           /* row of the light; SHADOW_EVEN: the one that is the same everywhere */
  bool again;             /* the light has been summed without casters: it is taken away */
  size_t layers;          /* factors at nodes */
  size_t row;             /* of its first layer, where layers have rows */
} shadow_term;

/* How much of a caster counts before a light: a part where its cone just misses that of the lamp. */
typedef struct shadow_part {
  double weight, slope[3];
} shadow_part;

/* One caster before a light. */
typedef struct shadow_before {
  size_t seen;   /* of the block's list */
  int layer;     /* from 0 on; -1: a sphere, evaluated at nodes or by its logarithm */
  uint32_t part; /* of the block's list, whose first is all of a caster */
} shadow_before;

/* Spheres at directions: profile.c, spheres.real.c, profile.isa.c. YLM_ENOMEM; what was made is freed with the rings */
ylm_status ylm__shadow_rings_create(const ylm_sh_nodes *nodes, shadow_rings *r);
void ylm__shadow_rings_free(shadow_rings *r);
shadow_profile_fn *ylm__shadow_profile(void);
shadow_blur ylm__shadow_blur(int degree, bool lone);
void ylm__shadow_cap_of(const shadow_blur *b, const shadow_seen *s, const shadow_part *x, bool lone,
                        shadow_cap *c);

/* room.c: room for one more of `n` things, of which there is none; room for n things, whatever they were; memory of a thread,
   which its next block uses again, NULL without any. */
bool ylm__shadow_grow(void **list, size_t n, size_t *room, size_t size);
bool ylm__shadow_have(void **list, size_t n, size_t *room, size_t size);
void *ylm__shadow_room(const shadow_query *w, int worker, int which, size_t bytes);

/* The order in which n points are taken, and the points in it; the caller's to free, without memory too, which is false.
   order.c */
bool ylm__shadow_order(ylm_dtype t, size_t n, const void *points, uint32_t **order, void **moved);

/* Points begin .. end-1 of a query, SHADOW_BLOCK at most. block.real.c */
ylm_status ylm__shadow_block_f(shadow_query *w, size_t begin, size_t end, int worker, ylm_error *e);
ylm_status ylm__shadow_block_d(shadow_query *w, size_t begin, size_t end, int worker, ylm_error *e);
/* Asks light that is the same everywhere, once for all blocks of a query; w->even is the caller's to free. block.real.c */
ylm_status ylm__shadow_even_f(shadow_query *w, ylm_error *e);
ylm_status ylm__shadow_even_d(shadow_query *w, ylm_error *e);
/* Frees what a thread's blocks have kept; NULL: nothing. */
void ylm__shadow_block_free_f(void *kept);
void ylm__shadow_block_free_d(void *kept);

#endif
