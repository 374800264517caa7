/* surface.h - triangles of a source, one after the other; what the files on surfaces share. */
#ifndef YLM_GRID_SURFACE_H
#define YLM_GRID_SURFACE_H

#include "../grid.h"
#include "calibration.h"

/* The triangles of all meshes as one list. */
typedef struct triangle_list {
  size_t meshes, triangles;
  const ylm_grid_mesh *mesh;
  size_t *first; /* [meshes + 1] number of each mesh's first triangle */
} triangle_list;
ylm_status ylm__triangle_list_make(triangle_list *l, size_t meshes, const ylm_grid_mesh *mesh);
void ylm__triangle_list_free(triangle_list *l);
/* The vertices of triangle i, scene units. */
void ylm__triangle_list_get(const triangle_list *l, size_t i, double p[3][3]);

/* Finite positions, indices in range, at least one triangle; the sentence names the mesh. */
ylm_status ylm__grid_check_meshes(size_t meshes, const ylm_grid_mesh *mesh, ylm_error *e);

/* Gives a surface a copy of its meshes, which it keeps. */
ylm_status ylm__surface_keep(ylm_grid_surface *s);
/* The meshes that a surface is made of. */
const ylm_grid_mesh *ylm__surface_meshes(const ylm_grid_surface *s);
/* Random point k of a seed, of any triangle with the same chance, whatever its area; false where
   none of the triangle is within the bounds. */
bool ylm__surface_draw_alike(const ylm_grid_surface *s, uint64_t seed, uint64_t k,
                             double position[3], double normal[3]);
/* Bytes of memory that it holds. */
size_t ylm__surface_bytes(const ylm_grid_surface *s);

/* -- triangle.c ------------------------------------------------------------------------ */

#define TRIANGLE_AXES 10 /* its normal, and its edges crossed with those of boxes */

/* A triangle in lattice units, ready to be compared with boxes of voxels. */
typedef struct triangle {
  double lo[3], hi[3]; /* its own box, margins included */
  double from[3];      /* a vertex, which the following is relative to */
  double axis[TRIANGLE_AXES][3], least[TRIANGLE_AXES], most[TRIANGLE_AXES];
} triangle;
/* The triangle p in lattice units; boxes are enlarged by `margin`. */
void ylm__triangle_set(triangle *t, const double p[3][3], const double margin[3]);
/* The voxels first .. last along an axis, of so many, that the triangle's box meets; false:
   none. */
bool ylm__triangle_range(const triangle *t, int axis, uint32_t voxels, uint32_t *first,
                         uint32_t *last);
/* True unless the triangle is certainly apart from the box of voxels first .. last, whose sides
   its own box meets. */
bool ylm__triangle_meets(const triangle *t, const uint32_t first[3], const uint32_t last[3]);

#endif
