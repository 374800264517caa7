/* gloss.h - surfaces that gloss, shaded by tables of their materials. Private. */
#ifndef YLM_SHADE_GLOSS_GLOSS_H
#define YLM_SHADE_GLOSS_GLOSS_H

#include "../view.h"
#include "ylm_material_rival.h"
#include "ylm_sh.h"

#define YLM_SHADE_MATTE UINT32_MAX

/* The tables of all materials in sight that gloss, of one degree. */
typedef struct shade_tables {
  struct shade_tables *next;
  int lmax;
  const ylm_material_table **table; /* [materials], theirs; NULL: not in sight */
  const ylm_sh_rotator *rotator;    /* of a plan */
  const ylm_sh_product *product;
  ylm_material_rival_fn *nearest; /* NULL: rows are interpolated */
  size_t materials;               /* of the tables, which are then its own */
  size_t bytes;
  double seconds;
} shade_tables;

/* Slices of all points that gloss, made once: of one list of tables, with shadows or without. */
struct shade_kept {
  struct shade_kept *next;
  const shade_tables *tables;
  bool shadows;
  float *slice; /* of one point behind the other [functions][count] */
  size_t *at;   /* [points] where they begin; of others 0 */
  size_t bytes;
};

/* Stages of shading (ylm_shade_stages). */
typedef enum shade_stage {
  SHADE_ROWS,
  SHADE_ROTATION,
  SHADE_PRODUCT,
  SHADE_LIGHT,
  SHADE_DOT,
  SHADE_STAGES
} shade_stage;
/* Adds the seconds since `start` to a stage, where the view has points that gloss; returns the time. */
double ylm__shade_clock(const ylm_shade_view *v, shade_stage stage, double start);

/* gloss.c: *out NULL where no surface of the view's scene glosses; to be freed on failure too. `before`: of
   the view that this one is made of, or NULL. YLM_EINVAL: what has become of a material is refused. */
ylm_status ylm__shade_gloss_create(const ylm_shade_view *v, const shade_gloss *before,
                                   shade_gloss **out, ylm_error *e);
/* Room for that many points; g may be NULL. Then what is known of each point. */
ylm_status ylm__shade_gloss_room(shade_gloss *g, size_t points);
void ylm__shade_gloss_point(shade_gloss *g, size_t i, uint32_t mesh, const ylm_scene_surface *s);
void ylm__shade_gloss_free(shade_gloss *g);
/* The gloss of n points of a view alone, without tables; NULL without memory. Dropped, not
   freed. */
shade_gloss *ylm__shade_gloss_pick(const shade_gloss *g, size_t n, const size_t *point);
void ylm__shade_gloss_drop(shade_gloss *g);

/*
** ylm__shade_gloss_shares - the part of points' radiance that is by rays, by options.gloss.
**
**   lmax    in   of the light
**   t       in   tables of that degree or a higher one; not of RAYS
**   share   out  [n], of points from `first` on
**   missed  out  [n]: the part of the slice's norm that degree lmax misses, 0 of RAYS; or NULL
*/
void ylm__shade_gloss_shares(const ylm_shade_view *v, const shade_tables *t, int lmax, size_t first,
                             size_t n, float *share, float *missed);

/* The number of a mesh's material, or YLM_SHADE_MATTE. */
uint32_t ylm__shade_gloss_slot(const shade_gloss *g, uint32_t mesh);
/* [points]; NULL: all materials are isotropic. */
const float (*ylm__shade_gloss_tangents(const shade_gloss *g))[3];
/* Adds to the statistics of a view. */
void ylm__shade_gloss_stats(const ylm_shade_view *v, ylm_shade_stats *stats);

/*
** ylm__shade_gloss_tables - the tables of a degree, listed at the first call; materials keep them.
**
** Returns  YLM_OK, and *out NULL where no point glosses; YLM_ERANGE (lmax), YLM_ENOMEM, YLM_ECANCELLED
** Threads  any number at once
*/
ylm_status ylm__shade_gloss_tables(const ylm_shade_view *v, int lmax, int threads,
                                   const ylm_progress *progress, const shade_tables **out,
                                   ylm_error *e);

/* gloss.c: the slices that a view keeps (options.keep), made by `make` at the first call. */
typedef ylm_status shade_make_fn(const ylm_shade_view *v, shade_kept *kept, int threads,
                                 const ylm_progress *progress);
ylm_status ylm__shade_gloss_kept(const ylm_shade_view *v, const shade_tables *tables, bool shadows,
                                 shade_make_fn *make, int threads, const ylm_progress *progress,
                                 const shade_kept **out);
/* glossy.c */
shade_make_fn ylm__shade_keep;

#endif
