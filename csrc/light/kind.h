/*
** kind.h - a kind of light: one row of a table, and one file. Private to csrc/light.
**
** Outside of a kind's own file nothing knows it by name: sets, dynamic grids, ray casting and
** devices ask its row. kind.c lists the rows.
**
** A light is given as a record, a row of numbers: its radiance [3], then `common` numbers that all
** lights of one pack share, then what the kind wants. The lights of a pack are summed as one field.
*/
#ifndef YLM_LIGHT_KIND_H
#define YLM_LIGHT_KIND_H

#include <math.h>

#include "calibration.h"
#include "light.h"
#include "ylm_light_device.h"
#include "ylm_light_emitter.h"

typedef struct ylm__light_kind ylm__light_kind;

/* Numbers of a light beside those of ylm_light: the kind's `common` numbers first. */
struct ylm_light_shape {
  const ylm__light_kind *kind;
  size_t numbers;
  bool marked; /* by ylm_light_mark */
  double x[];
};

/* Lights of one kind that are summed together, shared by the sets that hold them. */
typedef struct ylm__light_pack {
  const ylm__light_kind *kind;
  void *of;               /* what the kind's file makes of records */
  const ylm_field *field; /* of them all */
  size_t n, users;
} ylm__light_pack;

/* How bounds of a kind are measured (bound.c): lights of radiance 1 about the origin are seen from
   these distances, under these cosines to the z axis. */
typedef struct ylm__light_probes {
  double radius;
  const double *record;
  size_t distances, cosines;
  const double *distance, *cosine;
} ylm__light_probes;

/* The half of a kind that rays and particles need: ylm_light_emitter.h has each question. x are the numbers of one
   emitter. NULL: the question is not asked of the kind. */
typedef struct ylm__light_emits {
  /* Of a pack. Light i, if it is neither a surface nor distant: how many numbers. */
  size_t (*numbers)(const void *of, size_t i, double x[YLM_LIGHT_EMITTER_NUMBERS]);
  /* Where distant light i comes from, if that is a cone. NULL: they fill the sky. */
  void (*cone)(const void *of, size_t i, ylm_light_cone *out);
  /* Lights that fill the sky: what `out` says of their radiance but the pack. */
  void (*dome)(const void *of, ylm_light_dome *out);

  void (*move)(double *x, const double way[3]);
  double (*power)(const double *x);
  bool (*place)(const double *x, ylm_light_place *out);
  bool (*toward)(const double *x, const double from[3], ylm_light_way *out);
  double (*weight)(const double *x, const double from[3], const float *normal);
  void (*intensity)(const double *x, const double way[3], double rgb[3]);
  void (*radiance)(const double *x, const double way[3], double rgb[3]);
  double (*part)(const double *x, const double from[3]);
  /* Keeps, or lets go of, what stands behind the numbers. NULL: nothing does. */
  void (*hold)(const double *x, bool on);
  bool (*leave)(const double *x, const double u[4], ylm_light_leaving *out);
  /* Why the kind has no light field, a sentence; NULL: it has one, and x is its record. */
  const char *fieldless;
} ylm__light_emits;

struct ylm__light_kind {
  const char *name;
  size_t common; /* numbers of a record behind its radiance */

  /* -- records: NULL for kinds that are made otherwise -- */

  /* How many numbers the record at x has, of which `left` are there; 0: that is none. */
  size_t (*length)(const double *x, size_t left);
  /* Checks n records and fills p->of, p->field. Errors count lights from 1. */
  ylm_status (*create)(size_t n, const double *const *record, ylm__light_pack *p, ylm_error *e);

  const ylm__light_emits *emits; /* NULL: rays ask for nothing but surfaces */

  /* -- a pack -- */

  void (*free)(void *of);
  /* Lights that are the surface of a solid are summed by its outline, where they can be. YLM_ENOMEM; NULL: they
     cannot. */
  ylm_status (*join)(void *of);
  /* The field's `evaluate` by the kernels of an instruction set; NULL: there is one way only. */
  ylm_status (*evaluate)(const void *of, ylm_isa isa, const ylm_field_query *q, size_t n,
                         const void *points, ylm_field_result *r, ylm_error *e);
  /* The field of many lights to a tolerance, which refers to the pack; what it keeps in the pack takes bytes.
     NULL: there is none. The last is the field's `evaluate` by the kernels of an instruction set. */
  ylm_status (*within)(void *of, double tolerance, int threads, ylm_field **field, ylm_error *e);
  void (*within_free)(ylm_field *field);
  size_t (*within_bytes)(const void *of);
  ylm_status (*within_evaluate)(const void *within, ylm_isa isa, const ylm_field_query *q, size_t n,
                                const void *points, ylm_field_result *r, ylm_error *e);
  /* How many numbers the shape of light i has. Where `shape` has room for them, the light; `out` is
     then complete. 0 numbers: one shape serves all lights of the kind, `out` is written. NULL:
     these lights cannot be told apart, so nothing follows them. */
  size_t (*get)(const void *of, size_t i, ylm_light *out, ylm_light_shape *shape);
  /* Keeps, or lets go of, what a shape refers to; NULL: nothing. */
  void (*hold)(const ylm_light_shape *shape, bool on);
  /* Adds what rays see of light i; NULL: nothing. `images`: that is an image on triangles, which a
     pack adds as a whole: i is 0. */
  ylm_status (*surfaces)(const void *of, size_t i, ylm_light_surfaces *out);
  bool images;
  /* Distant lights: adds the radiance that comes from direction d, of length 1. NULL: none does. */
  void (*radiance)(const void *of, const double d[3], double rgb[3]);
  /* The part of a device's sums that the pack is; NULL: no device sums it. */
  void (*device)(const void *of, ylm_light_part *out);

  /* -- one light of it -- */

  /* Its record with another radiance, to `to` unless that is NULL: how many numbers these are. */
  size_t (*record)(const ylm_light *l, const double radiance[3], double *to);
  /* Whether b is a, moved and recoloured; both are of the kind. */
  bool (*slides)(const ylm_light *a, const ylm_light *b);
  /* The farthest that it reaches from its place. NULL: distant lights, which have no place. */
  double (*reach)(const ylm_light *l);
  /* The distance of p from a light that slides from a to b (a itself: from a). */
  double (*distance)(const ylm_light *a, const ylm_light *b, const double p[3]);
  /* Bounds hold at larger distances only, and on a way only where p is not passed by. */
  double (*near)(const ylm_light *l);
  bool (*passes)(const ylm_light *a, const ylm_light *b, const double p[3]);
  /* A horizon's terms in bounds of value, gradient, Hessian at distance d for radiance e. */
  void (*cut)(const ylm_light *l, int lmax, double e, double d, double bound[3]);
  const ylm__light_probes *probes;
  /* Distant lights: the norm of their coefficients for radiance 1. */
  double (*norm)(const ylm_light *l, int lmax);
};

/* The table. `foreign`: a light field of another origin, of which nothing else is known. */
#define YLM__LIGHT_KINDS(X)                                                                        \
  X(sphere)                                                                                        \
  X(polygon)                                                                                       \
  X(polygon_as_sphere)                                                                             \
  X(textured)                                                                                      \
  X(environment)                                                                                   \
  X(panorama)                                                                                      \
  X(sun) X(sampled) X(spot) X(lobe) X(virtual) X(photometric) X(photometric_point) X(foreign)
#define X(name) extern const ylm__light_kind ylm__##name##_kind;
YLM__LIGHT_KINDS(X)
#undef X
/* The kind of a name, NULL if there is none; the place of a kind in the table. kind.c */
const ylm__light_kind *ylm__light_kind_of(const char *name);
size_t ylm__light_kind_index(const ylm__light_kind *kind);

/* Adds to surfaces, of which there is room for a power of two; YLM_ENOMEM. surfaces.c */
ylm_status ylm__surfaces_sphere(ylm_light_surfaces *s, const ylm_light *sphere);
ylm_status ylm__surfaces_triangle(ylm_light_surfaces *s, const double *a, const double *b,
                                  const double *c, const double radiance[3], const double *horizon);
ylm_status ylm__surfaces_disk(ylm_light_surfaces *s, const double at[3], double radius,
                              const double normal[3], const double radiance[3],
                              const double *horizon);

/* Adds an image, whose triangles have been added; there is one for each textured light. */
ylm_status ylm__surfaces_image(ylm_light_surfaces *s, const ylm_light_image *image);

/* The last lamp of a shape sends radiance as an emitter says. */
ylm_status ylm__surfaces_direct(ylm_light_surfaces *s, ylm_light_directed_shape shape,
                                const ylm_light_emitter *emitter);

/* `evaluate` of fields of kinds that have none, which are packs of distant.h. emitter.c */
ylm_status ylm__fieldless(const ylm_field *f, const ylm_field_query *q, size_t n,
                          const void *points, ylm_field_result *r, ylm_error *e);

/* A pack of spheres from arrays. sphere/kind.c */
ylm_status ylm__sphere_pack(size_t n, const double *at, const double *radius,
                            const double *radiance, ylm__light_pack *p, ylm_error *e);

/* Probes of kinds that have no distance or direction of their own. bound.c */
#define YLM__PROBE_DISTANCES 7
#define YLM__PROBE_COSINES 8
extern const double ylm__probe_distance[YLM__PROBE_DISTANCES],
    ylm__probe_cosine[YLM__PROBE_COSINES];

static inline double ylm__distance(const double a[3], const double b[3]) {
  double s = 0;
  for (int k = 0; k < 3; k++) s += (a[k] - b[k]) * (a[k] - b[k]);
  return sqrt(s);
}

/* From p to the segment between a and b. */
static inline double ylm__segment_distance(const double p[3], const double a[3],
                                           const double b[3]) {
  double along = 0, length2 = 0, s = 0;
  for (int k = 0; k < 3; k++) {
    along += (p[k] - a[k]) * (b[k] - a[k]);
    length2 += (b[k] - a[k]) * (b[k] - a[k]);
  }
  double t = length2 > 0 ? along / length2 : 0;
  t = t < 0 ? 0 : t > 1 ? 1 : t;
  for (int k = 0; k < 3; k++) {
    double d = p[k] - (a[k] + t * (b[k] - a[k]));
    s += d * d;
  }
  return sqrt(s);
}

#endif
