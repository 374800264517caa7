/*
** ylm_geom_unwrap.h - texture coordinates for meshes that have none: charts, flattened and packed into one picture.
**
**   ylm_unwrap_create   cuts meshes into charts, and flattens each with little stretch
**   ylm_unwrap_pack     lays the charts out on a grid of texels, each in its own density
**   ylm_unwrap_split    a mesh with these coordinates, its vertices split where charts end
**
** A chart grows over triangles that join at edges and face about the same way. Charts that are not nearly flat are
** flattened as rigidly as possible. A chart that overlaps itself or stretches too much is cut in two. Charts touch no texel
** that a bilinear look-up in another chart reads.
*/
#ifndef YLM_GEOM_UNWRAP_H
#define YLM_GEOM_UNWRAP_H

#include "ylm_geom.h"

#ifdef __cplusplus
extern "C" {
#endif

#define YLM_UNWRAP_SIDE 16384      /* the most texels along a side of a picture */
#define YLM_UNWRAP_NONE UINT32_MAX /* no chart: a triangle without area */

typedef struct ylm_unwrap ylm_unwrap;

/* One mesh: positions in scene units, corners below `vertices`. */
typedef struct ylm_unwrap_mesh {
  size_t vertices, triangles;
  const float *position; /* [vertices][3] */
  const uint32_t *index; /* [triangles][3] */
} ylm_unwrap_mesh;

typedef struct ylm_unwrap_form {
  double
      angle; /* degrees, 1 .. 80: how far a triangle's normal is from the mean of its chart's, at most */
  double stretch; /* 1.001 .. 10: the most stretch of a chart, root mean square */
  const uint32_t *
      label; /* [triangles of all meshes]: triangles of two labels share no chart; NULL: all have one */
  int threads;
  const ylm_progress *progress; /* stage "unwrap" */
} ylm_unwrap_form;

typedef struct ylm_unwrap_stats {
  size_t triangles, charts, curved; /* curved: charts that are not nearly flat */
  size_t degenerate;                /* triangles without area, in no chart */
  size_t crowded;        /* edges of more than two triangles, or of two that face opposite ways */
  double stretch, worst; /* root mean square over the area, 1: none; of the chart with the most */
  size_t width, height;  /* of the picture; 0: not packed */
  double density;        /* texels a scene unit, root mean square over the area */
  double share;          /* of all texels, those that charts are looked up from */
} ylm_unwrap_stats;

/*
** ylm_unwrap_create - charts of meshes, in scene units. Triangles of different meshes share no chart.
**
** Returns  YLM_OK; YLM_ERANGE (the form), YLM_EDOMAIN (a vertex that is not finite, no triangle has an area), YLM_ENOMEM,
**          YLM_ECANCELLED
** Cost     O(triangles log triangles) where charts are nearly flat; some 500 passes over the triangles of curved ones
** Source   Liu et al. 2008 (flattening); Sander et al. 2001 (stretch); docs/lightmaps.md
*/
YLM_API ylm_status ylm_unwrap_create(size_t meshes, const ylm_unwrap_mesh *mesh,
                                     const ylm_unwrap_form *form, ylm_unwrap **out, ylm_error *e);
YLM_API void ylm_unwrap_free(ylm_unwrap *u);
YLM_API void ylm_unwrap_look(const ylm_unwrap *u, ylm_unwrap_stats *stats);

/* The chart of a triangle, or YLM_UNWRAP_NONE; the area of a chart on its surface. */
YLM_API uint32_t ylm_unwrap_chart(const ylm_unwrap *u, size_t mesh, size_t triangle);
YLM_API double ylm_unwrap_area(const ylm_unwrap *u, size_t chart);
/* Texels a scene unit of a packed chart, the geometric mean of both axes. */
YLM_API double ylm_unwrap_density(const ylm_unwrap *u, size_t chart);
/* The triangle of the mesh beyond edge 0 .. 2 of another, which begins at the corner of its number, and that edge there;
   false: none joins. */
YLM_API bool ylm_unwrap_across(const ylm_unwrap *u, size_t mesh, size_t triangle, int edge,
                               size_t *triangle_across, int *edge_across);

/*
** ylm_unwrap_pack - lays all charts out. Each is turned to its smallest rectangle, and scaled to whole texels along both
** sides, at least one.
**
**   density  in  [charts] texels a scene unit, > 0
**   gutter   in  0 .. 64 texels between the texels of two charts, at least
**
** Returns  YLM_OK; YLM_ERANGE, YLM_ELIMIT (more than YLM_UNWRAP_SIDE texels along a side), YLM_ENOMEM; what was packed
**          before then stays
*/
YLM_API ylm_status ylm_unwrap_pack(ylm_unwrap *u, const double *density, int gutter, ylm_error *e);
/*
** ylm_unwrap_fit - ylm_unwrap_pack, with all densities times the factor at which the picture has at most `texels`, and
** nearly so many where charts allow it.
**
**   factor  out  NULL: not wanted
**
** Returns  as ylm_unwrap_pack; YLM_ELIMIT (the charts do not fit into so few)
*/
YLM_API ylm_status ylm_unwrap_fit(ylm_unwrap *u, const double *density, int gutter, size_t texels,
                                  double *factor, ylm_error *e);

/* Corners of a packed triangle, in texels from the upper left corner of the picture. A triangle without area lies on a
   point. */
YLM_API void ylm_unwrap_corners(const ylm_unwrap *u, size_t mesh, size_t triangle, double at[3][2]);
/* [height][width]: the chart that each texel is looked up for, or YLM_UNWRAP_NONE. YLM_ENOMEM. */
YLM_API ylm_status ylm_unwrap_texels(const ylm_unwrap *u, uint32_t *chart);

/*
** ylm_unwrap_split - a mesh with one vertex for each vertex and chart that go together.
**
**   from   out  [*vertices] which vertex of the mesh each was; the caller's to free, as are the others
**   uv     out  [*vertices][2] u to the right, v upwards, 0 .. 1
**   index  out  [triangles][3] of the new vertices, triangles in their old order
**
** Returns  YLM_OK; YLM_EINVAL (not packed), YLM_ENOMEM
*/
YLM_API ylm_status ylm_unwrap_split(const ylm_unwrap *u, size_t mesh, size_t *vertices,
                                    uint32_t **from, float **uv, uint32_t **index, ylm_error *e);

#ifdef __cplusplus
}
#endif
#endif
