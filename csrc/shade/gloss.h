/* gloss.h - surfaces that gloss, shaded by tables of their materials. Private. */
#ifndef YLM_SHADE_GLOSS_H
#define YLM_SHADE_GLOSS_H

#include "view.h"
#include "ylm_material_table.h"
#include "ylm_sh.h"

#define YLM_SHADE_MATTE UINT32_MAX

/* The tables of all materials in sight that gloss, of one degree. */
typedef struct shade_tables {
  struct shade_tables *next;
  int lmax;
  const ylm_material_table **table; /* [materials], theirs; NULL: not in sight */
  ylm_sh_rotator *rotator;
  ylm_sh_product *product;
  size_t bytes;
  double seconds;
} shade_tables;

/* gloss.c: *out NULL where no surface of the scene glosses; to be freed on failure too. */
ylm_status ylm__shade_gloss_create(const ylm_scene *scene, shade_gloss **out);
/* Room for that many points; g may be NULL. Then what is known of each point. */
ylm_status ylm__shade_gloss_room(shade_gloss *g, size_t points);
void ylm__shade_gloss_point(shade_gloss *g, size_t i, uint32_t mesh, const ylm_scene_surface *s);
void ylm__shade_gloss_free(shade_gloss *g);

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

#endif
