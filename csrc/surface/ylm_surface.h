/*
** ylm_surface.h - irradiance on the surfaces of a scene, as values at the corners of rectangles.
**
** Triangles lie on charts: the planes of a mesh, or six maps along the axes where a mesh is round, which blend by the
** normal. Each chart is cut into rectangles by a binary tree. A rectangle is bilinear between four corners. Corners at one
** place are one where the surfaces beside them see each other, so light is continuous on a surface and jumps at a wall.
** A look-up traces no ray. It answers on the scene's own surfaces, for their own normals.
*/
#ifndef YLM_SURFACE_H
#define YLM_SURFACE_H

#include "ylm_transfer.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ylm_surface_grid ylm_surface_grid;

typedef struct ylm_surface_form {
  /* The promise: of irradiance at 99 % of the surface, over the larger of the place's and the mean. */
  double tolerance;
  double aim;     /* the part of it that is refined for, where another judge follows; 0: all */
  size_t corners; /* at most about so many; 0: as the tolerance asks */
  ylm_quantity quantity; /* what the light is, for who reads it */
  /* Whose rectangles take the light, a grid of the same meshes: none is halved; NULL: they are found. */
  const ylm_surface_grid *like;
  const ylm_scene *lit; /* whose materials and lamps have its prints; NULL: the radiosity's scene */
  /* As ylm_radiosity_places takes it; `links` of a place, twice. Seed, threads and progress are those of all work here
     (stage "surfaces"). */
  ylm_radiosity_map light;
} ylm_surface_form;

typedef struct ylm_surface_stats {
  size_t charts;         /* those that have rectangles */
  size_t rectangles;     /* of all charts */
  size_t corners, rows;  /* numbers that were fitted, a channel; with those that hang on others */
  size_t places, rounds; /* whose light was asked for; fits */
  uint64_t rays;         /* of light and of sight */
  size_t verified, failed;
  double
      error; /* that 99 % of the surface keep, with 99 % confidence; infinite: too few were verified */
  double rms;   /* over the mean, without the places' noise */
  bool met;     /* by the radiosity that was asked, or by the judge after it */
  bool spent;   /* it is not, and no more corners were allowed */
  size_t bytes; /* in memory */
  double seconds;
  double tolerance; /* that is promised */
  ylm_quantity quantity;
  ylm_scene_prints prints;
} ylm_surface_stats;

/*
** ylm_surface_bake - the irradiance of a radiosity on its scene's surfaces.
**
** Rectangles are fitted by least squares to places spread over them, and halved where their error by area is largest. The
** noise of places is taken out by two halves of their rays. Refinement ends where fresh places keep the tolerance.
**
** Returns  YLM_OK; YLM_ERANGE, YLM_EINVAL, YLM_ELIMIT (triangles), YLM_ENOMEM, YLM_ECANCELLED
** Cost     some 12000 places of 2 links rays, and 2048 that judge, at least
*/
YLM_API ylm_status ylm_surface_bake(const ylm_radiosity *r, const ylm_surface_form *form,
                                    ylm_surface_grid **out, ylm_error *e);
YLM_API void ylm_surface_free(ylm_surface_grid *g);
YLM_API void ylm_surface_look(const ylm_surface_grid *g, ylm_surface_stats *stats);
/* The verdict of another judge, at places of ylm_surface_draw, takes the place of the bake's. */
YLM_API void ylm_surface_verdict(ylm_surface_grid *g, size_t verified, size_t failed, double error,
                                 double rms);
YLM_API const ylm_scene *ylm_surface_scene(const ylm_surface_grid *g);

/* Irradiance at n places of the scene: out [n][3], W m^-2, at least 0; 0 on sides without light. `rectangle` [n] or NULL:
   the number of the one that a place lies on, UINT32_MAX: none. */
YLM_API void ylm_surface_irradiance(const ylm_surface_grid *g, size_t n,
                                    const ylm_scene_place *place, float (*out)[3],
                                    uint32_t *rectangle, int threads);
/* The place of a scene that a point lies on, as the scene has points (ylm_scene_enter), with a normal of its side.
   False: it lies on none. */
YLM_API bool ylm_surface_place(const ylm_scene *scene, const float point[3], const float normal[3],
                               ylm_scene_place *place);

/* At most n places by area, which a promise is about: on sides of which the radiosity has light, not in bodies, not
   covered by other surfaces; how many are drawn. YLM_ENOMEM. */
YLM_API ylm_status ylm_surface_draw(const ylm_surface_grid *g, const ylm_radiosity *r, size_t n,
                                    uint64_t seed, ylm_scene_place *place, size_t *drawn);

/* Rectangle i < rectangles: its corners in the scene, and their values; of a round mesh those of the nearest chart. */
YLM_API void ylm_surface_rectangle(const ylm_surface_grid *g, size_t i, float corner[4][3],
                                   float value[4][3]);

/* Writes to a file, beside it first; reads one, which must be of this scene (YLM_EINVAL). */
YLM_API ylm_status ylm_surface_write(const ylm_surface_grid *g, const char *path, ylm_error *e);
/* The header of a file, without its scene: all stats but `bytes` in memory. */
YLM_API ylm_status ylm_surface_inspect(const unsigned char *bytes, size_t size, const char *name,
                                       ylm_surface_stats *stats, ylm_error *e);
YLM_API ylm_status ylm_surface_read(const ylm_scene *scene, const unsigned char *bytes, size_t size,
                                    const char *name, ylm_surface_grid **g, ylm_error *e);

#ifdef __cplusplus
}
#endif
#endif
