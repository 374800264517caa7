/*
** ylm_surface_map.h - lightmaps: the irradiance on the surfaces of a scene as one picture, with texture coordinates of its own.
**
** Each side of a mesh that has light is a sheet. Sheets are cut into charts (ylm_geom_unwrap.h), which share a picture. The
** light of places spread over the charts is asked of a radiosity, and texels are fitted to it by least squares, as bilinear
** look-ups will read them. Texels are dense where light bends: charts take them by what they miss.
*/
#ifndef YLM_SURFACE_MAP_H
#define YLM_SURFACE_MAP_H

#include "ylm_geom_unwrap.h"
#include "ylm_surface.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ylm_surface_map ylm_surface_map;

/* Levels of mip maps at which seams are measured. */
#define YLM_SURFACE_MAP_LEVELS 3

typedef struct ylm_surface_map_form {
  /* Of irradiance at 99 % of the surface, over the larger of the place's and the mean; 0: as `texels` allow. */
  double tolerance;
  double aim;    /* the part of it that is refined for, where another judge follows; 0: all */
  size_t texels; /* of the picture, at most */
  bool even;     /* all charts have one density, for comparison */
  bool parts;    /* large charts are divided where parts of them want texels of their own density */
  bool smooth;   /* texels are averaged along the surface where light is smooth */
  bool directional; /* with the flow of light */
  int gutter;
  double angle, stretch; /* of charts, as ylm_unwrap_form has them */
  ylm_quantity quantity; /* what the light is, for who reads it */
  /* A file that gets light and texels as they are found, from which a bake that was interrupted goes on; NULL: none. It is of
     a bake that `words` describe, a line a fact, of at most 4,000 bytes. */
  const char *journal, *words;
  ylm_radiosity_map
      light; /* as ylm_surface_form has it: links and light_samples of a place, twice; stage "lightmap" */
} ylm_surface_map_form;

typedef struct ylm_surface_map_stats {
  ylm_unwrap_stats charts;
  size_t sheets;
  size_t places, rounds; /* whose light was asked for; pictures that were made */
  uint64_t rays;         /* of light */
  size_t seams;          /* edges between charts where the surface is smooth, which agree */
  /* The largest of their two sides' differences, over the larger of the light there and the mean: at the picture as it is, and
     at the next levels of its mip maps, which are means of two by two texels. */
  double jump[YLM_SURFACE_MAP_LEVELS];
  double noise; /* of the light of places, root mean square, as errors are told */
  size_t verified, failed;
  double
      error; /* that 99 % of the surface keep, with 99 % confidence; infinite: too few were verified */
  double rms;      /* over the mean, without the places' noise */
  bool met, spent; /* spent: it is not, and no more texels were allowed */
  bool stalled;    /* it is not, and more texels left most places that miss it as they were */
  /* Places of `failed` whose texels lie under bodies in part, those that noise explains, and the others: edges of light. */
  size_t bodies, noisy, edges;
  double tolerance; /* that is promised, 0: none */
  ylm_quantity quantity;
  double chart_seconds, pack_seconds, light_seconds, fit_seconds, judge_seconds;
} ylm_surface_map_stats;

/*
** ylm_surface_map_bake - the irradiance of a radiosity as a picture.
**
** Returns  YLM_OK; YLM_ERANGE, YLM_EINVAL, YLM_EDOMAIN (no triangle has an area), YLM_ELIMIT (the charts do not fit into the
**          texels), YLM_ENOMEM, YLM_ECANCELLED; of a journal
**          YLM_EIO, YLM_EBUSY (another bake writes it), YLM_EFORMAT (no journal), YLM_EINVAL (of another bake)
** Cost     four places a texel, of 2 links rays and 2 light_samples
*/
YLM_API ylm_status ylm_surface_map_bake(const ylm_radiosity *r, const ylm_surface_map_form *form,
                                        ylm_surface_map **out, ylm_error *e);
YLM_API void ylm_surface_map_free(ylm_surface_map *m);
YLM_API void ylm_surface_map_look(const ylm_surface_map *m, ylm_surface_map_stats *stats);
YLM_API void ylm_surface_map_verdict(ylm_surface_map *m, size_t verified, size_t failed,
                                     double error, double rms);
YLM_API const ylm_scene *ylm_surface_map_scene(const ylm_surface_map *m);

/* [height][width][3] W m^-2, row 0 is the top, numbers that half floats have; beyond charts those of the nearest. */
YLM_API const float *ylm_surface_map_picture(const ylm_surface_map *m);
/* [3 axes][height][width][3] the flow of light (ylm_radiosity_map), or NULL: at a normal n + d the irradiance is about the
   picture's plus the product of d and the flow. */
YLM_API const float *ylm_surface_map_flow(const ylm_surface_map *m);
/* The picture as numbers k/255: irradiance is range times the square of alpha times colour. Returns the range, the largest
   irradiance, or 1 where all is dark; out [height][width][4]. */
YLM_API double ylm_surface_map_rgbm(const ylm_surface_map *m, float *out);
/* [charts] what a chart misses, root mean square over the larger of the light around and the mean, as the last fit found it
   at its own places. */
YLM_API const double *ylm_surface_map_errors(const ylm_surface_map *m);
/* The texture coordinates: mesh `sheet` of ylm_unwrap_split is a sheet. */
YLM_API const ylm_unwrap *ylm_surface_map_charts(const ylm_surface_map *m);
/* The mesh of the scene that a sheet is of, and its side. Triangles of a back have their second and third corners
   exchanged. */
YLM_API size_t ylm_surface_map_sheet(const ylm_surface_map *m, size_t sheet, bool *back);

/* A sheet of its mesh as the charts have it, with its texture coordinates [vertices][2], the caller's to free. Triangles of large
   charts may be cut. YLM_OK, YLM_ENOMEM. */
YLM_API ylm_status ylm_surface_map_split(const ylm_surface_map *m, size_t sheet,
                                         const ylm_mesh *mesh, ylm_mesh **out, float **uv,
                                         ylm_error *e);

/* Irradiance at n places of the scene, as a bilinear look-up has it: out [n][3]; 0 on sides without light. `chart` [n]:
   the one that a place lies on, or YLM_UNWRAP_NONE; NULL: not wanted. */
YLM_API void ylm_surface_map_irradiance(const ylm_surface_map *m, size_t n,
                                        const ylm_scene_place *place, float (*out)[3],
                                        uint32_t *chart);
/* At most n places by area, as ylm_surface_draw has them; how many are drawn. YLM_ENOMEM. */
YLM_API ylm_status ylm_surface_map_draw(const ylm_surface_map *m, const ylm_radiosity *r, size_t n,
                                        uint64_t seed, ylm_scene_place *place, size_t *drawn);

#ifdef __cplusplus
}
#endif
#endif
