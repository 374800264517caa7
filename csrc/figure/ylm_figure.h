/*
** ylm_figure.h - the geometry of pictures, and pictures as pixels.
**
** Shapes      triangles or segments with a colour per vertex: SH lobes, octree edges, arrows,
**             tubes, spheres. Many things go into one shape, so that they are drawn in one call.
** Volumes     numbers on a regular lattice: what slices, isosurfaces, clouds and streamlines
**             are made of.
** Canvases    8-bit RGB pixels that pictures, bars and texts are laid out on.
** Files       .vtu, .vtp, .vti as ParaView reads them.
**
** Nothing here draws: csrc/vtk does. Colours are display values (sRGB encoded), 0 .. 1 in
** arguments, bytes in shapes and canvases.
*/
#ifndef YLM_FIGURE_H
#define YLM_FIGURE_H

#include "ylm_base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* -- shapes ---------------------------------------------------------------- */

typedef struct ylm_figure_shape {
  int corners; /* of a cell: 3 triangles, 2 segments */
  size_t points, cells, point_room, cell_room;
  float *position; /* [points][3] */
  float *normal;   /* [points][3] of triangles; NULL for segments */
  uint8_t *colour; /* [points][4] red, green, blue, alpha */
  uint32_t *index; /* [cells][corners] */
} ylm_figure_shape;

/* An empty shape of triangles (3) or segments (2). Free what it holds with _clear. */
YLM_API void ylm_figure_shape_init(ylm_figure_shape *s, int corners);
YLM_API void ylm_figure_shape_clear(ylm_figure_shape *s);
/* Smallest box around its points; false if it has none. */
YLM_API bool ylm_figure_shape_bounds(const ylm_figure_shape *s, double bounds[6]);
/* out[k]: the largest product of a point of the shape and direction[k], [n][3]; -infinity where it
   has no points. */
YLM_API void ylm_figure_shape_reach(const ylm_figure_shape *s, size_t n, const double *direction,
                                    double *out);

/*
** ylm_figure_add_mesh - triangles as they are.
**
**   n, position   [n][3]
**   normal        [n][3], or NULL: made from the triangles, weighted by area
**   colour        [n][3], or [1][3] where `one_colour`
**   m, triangle   [m][3], indices below n (checked: YLM_ERANGE)
*/
YLM_API ylm_status ylm_figure_add_mesh(ylm_figure_shape *s, size_t n, const double *position,
                                       const double *normal, const double *colour, bool one_colour,
                                       size_t m, const uint32_t *triangle, double opacity);

/* n spheres: centre [n][3], radius [n], colour [n][3]; detail 0 .. 4 splits an octahedron. */
YLM_API ylm_status ylm_figure_add_spheres(ylm_figure_shape *s, size_t n, const double *centre,
                                          const double *radius, const double *colour, int detail);

/* n arrows from their tails: at [n][3], along [n][3] (with its length), colour [n][3]. */
YLM_API ylm_status ylm_figure_add_arrows(ylm_figure_shape *s, size_t n, const double *at,
                                         const double *along, const double *colour);

/* A tube of `radius` around n points [n][3] with colours [n][3]. */
YLM_API ylm_status ylm_figure_add_tube(ylm_figure_shape *s, size_t n, const double *point,
                                       const double *colour, double radius);

/* n segments, from [n][3] to [n][3], in one colour {r, g, b, a}. */
YLM_API ylm_status ylm_figure_add_segments(ylm_figure_shape *s, size_t n, const double *from,
                                           const double *to, const double colour[4]);

/*
** ylm_figure_add_lobes - n SH vectors as surfaces r(w) = scale * |f(w)| around their centres.
**
**   basis        [points of the sphere][count]: Y at ylm_figure_sphere(detail)
**   coefficient  [n][count]
**   centre       [n][3]
**   scale        [n]; with `fit`, the largest radius of each instead
**   positive, negative   colours of the parts where f is above and below 0
**
** Cost  O(n count 4^detail)
*/
YLM_API ylm_status ylm_figure_add_lobes(ylm_figure_shape *s, size_t n, int count, int detail,
                                        const double *basis, const double *coefficient,
                                        const double *centre, const double *scale, bool fit,
                                        const double positive[3], const double negative[3]);

/* The unit directions [points][3] and triangles [triangles][3] of a subdivided octahedron,
   4^(detail+1) + 2 points; both allocated, freed by the caller. */
YLM_API ylm_status ylm_figure_sphere(int detail, size_t *points, double **direction,
                                     size_t *triangles, uint32_t **index);

/* -- cells ------------------------------------------------------------------ */

/* Boxes of a grid; plain arrays that the caller owns. */
typedef struct ylm_figure_cells {
  size_t n;
  const double *origin; /* [n][3] lower corner */
  const double *size;   /* [n][3] */
  const double *level;  /* [n]; NULL: all 0 */
  const double *drawn;  /* [n]; 0 leaves the cell out; NULL: all are in */
  const double *corner; /* [n][8] one-based rows of point values, x fastest; 0: none; or NULL */
} ylm_figure_cells;

/*
** ylm_figure_add_edges - the edges of boxes, each once.
**
** An edge that lies on one of a coarser level is left out, so translucent lines do not add up.
** colours [levels][4] by level; cells of a deeper level take the last one.
*/
YLM_API ylm_status ylm_figure_add_edges(ylm_figure_shape *s, const ylm_figure_cells *cells,
                                        size_t levels, const double *colours);

/* The faces of boxes shrunk by `shrink` (0 .. 1) about their middles, colour [n][3]. */
YLM_API ylm_status ylm_figure_add_boxes(ylm_figure_shape *s, const ylm_figure_cells *cells,
                                        const double *colour, double shrink, double opacity);

/* -- volumes ----------------------------------------------------------------- */

typedef struct ylm_figure_volume {
  size_t size[3];   /* voxels along x, y, z */
  double origin[3]; /* of the first voxel's centre */
  double spacing[3];
  int components; /* numbers per voxel */
  float *value;   /* [nz][ny][nx][components]; NaN where there is no data */
} ylm_figure_volume;

/* Voxels all NaN that fill bounds {x0 y0 z0 x1 y1 z1}; a flat axis has one voxel, in its middle. */
YLM_API ylm_status ylm_figure_volume_init(ylm_figure_volume *v, const double bounds[6],
                                          const size_t size[3], int components);
YLM_API void ylm_figure_volume_clear(ylm_figure_volume *v);

/*
** ylm_figure_fill - resamples cells to a volume.
**
**   value    [cells->n]: constant in each cell; or, where `pointwise`, [points][components]:
**            trilinear between the corners of each cell (corners that are 0 or NaN leave it empty)
**
** A voxel takes the value of the cell that holds its centre; of several, the last one's.
*/
YLM_API ylm_status ylm_figure_fill(ylm_figure_volume *v, const ylm_figure_cells *cells,
                                   const double *value, size_t points, bool pointwise);

typedef struct ylm_grid ylm_grid; /* ylm_grid.h */

/*
** ylm_figure_fill_parts - the leaves of a grid with sides, piece by piece, to a volume; the rest stays.
**
**   value  [points][components]: trilinear between the corners of a piece's part; NULL: the part's
**          number in its leaf, from 1. NaN where a piece has no part
*/
YLM_API void ylm_figure_fill_parts(ylm_figure_volume *v, const ylm_grid *g, const double *value);

/* The volume at p, trilinear; false (out untouched) outside, and where a neighbour is NaN. */
YLM_API bool ylm_figure_volume_at(const ylm_figure_volume *v, const double p[3], double *out);

/* Fills `to` with what `from` (as many components, at most 8) is at its voxels; NaN where it is
 * nothing. */
YLM_API void ylm_figure_resample(ylm_figure_volume *to, const ylm_figure_volume *from);

/* Least and largest finite value of the first component, and the least above 0;
   false if there is none. */
YLM_API bool ylm_figure_volume_range(const ylm_figure_volume *v, double *least, double *largest,
                                     double *least_positive);

/* Averages each voxel with its neighbours within one, `times` times; NaN stays NaN. */
YLM_API ylm_status ylm_figure_volume_smooth(ylm_figure_volume *v, int times);

/*
** ylm_figure_streamline - follows the direction of a volume of 3 components, `forward` or against
** it. The method is 4th-order Runge-Kutta in arc length. The line ends where it leaves the volume,
** where the direction vanishes, or at `room` points.
** Returns the number of points written to out [room][3].
*/
YLM_API size_t ylm_figure_streamline(const ylm_figure_volume *v, const double seed[3], double step,
                                     bool forward, size_t room, double *out);

/* -- colours ------------------------------------------------------------------ */

/* How numbers become colours. */
typedef struct ylm_figure_scale {
  const char *map; /* a colour map of csrc/image: viridis, magma, coolwarm, grey */
  double least, largest;
  bool logarithmic;
} ylm_figure_scale;

/* Where x lies in the scale's range: 0 .. 1 clamped, NaN for NaN and for logs of x <= 0. */
YLM_API double ylm_figure_place(const ylm_figure_scale *s, double x);
/* Colours [n][3] of n numbers; `none` where there is no place. */
YLM_API ylm_status ylm_figure_colours(const ylm_figure_scale *s, size_t n, const double *x,
                                      const double none[3], double *rgb);

/*
** ylm_figure_pixels - a volume's first component as RGBA, [size 0 * size 1 * size 2][4].
** Transparent where there is no place on the scale, else `opacity` (0 .. 1).
*/
YLM_API ylm_status ylm_figure_pixels(const ylm_figure_volume *v, const ylm_figure_scale *s,
                                     double opacity, uint8_t *rgba);
/* The places of a volume's first component, as a volume that the caller clears. */
YLM_API ylm_status ylm_figure_places(const ylm_figure_volume *v, const ylm_figure_scale *s,
                                     ylm_figure_volume *place);

/*
** ylm_figure_add_streamlines - tubes both ways from n seeds [n][3] through a volume of 3
** components, coloured by its length on the scale. Lines of fewer than `fewest` points are left
** out.
*/
YLM_API ylm_status ylm_figure_add_streamlines(ylm_figure_shape *shape, const ylm_figure_volume *v,
                                              size_t n, const double *seed, double step,
                                              size_t room, size_t fewest, double radius,
                                              const ylm_figure_scale *s);

/* -- canvases ------------------------------------------------------------------ */

typedef struct ylm_figure_canvas {
  int width, height;
  uint8_t *pixel; /* [height][width][3], top row first */
} ylm_figure_canvas;

/* 1 .. 32768 pixels along each axis, filled with one colour. */
YLM_API ylm_status ylm_figure_canvas_init(ylm_figure_canvas *c, int width, int height,
                                          const double rgb[3]);
YLM_API void ylm_figure_canvas_clear(ylm_figure_canvas *c);

/* A rectangle of pixels of one colour and opacity; parts outside are cut off. */
YLM_API void ylm_figure_canvas_rectangle(ylm_figure_canvas *c, double x, double y, double width,
                                         double height, const double rgba[4]);
/* A line `width` pixels thick, anti-aliased. */
YLM_API void ylm_figure_canvas_line(ylm_figure_canvas *c, double x0, double y0, double x1,
                                    double y1, double width, const double rgba[4]);
/* RGBA pixels [h][w][4], not premultiplied, with their upper left corner at x, y. */
YLM_API void ylm_figure_canvas_blend(ylm_figure_canvas *c, int x, int y, int w, int h,
                                     const uint8_t *rgba);
/*
** ylm_figure_canvas_copy - part (sx, sy, sw, sh) of another canvas into (x, y, w, h) of this one.
** Enlarges by repeating pixels where `sharp`, else by interpolation; shrinks by area averages.
*/
YLM_API void ylm_figure_canvas_copy(ylm_figure_canvas *c, int x, int y, int w, int h,
                                    const ylm_figure_canvas *from, double sx, double sy, double sw,
                                    double sh, bool sharp);

/* -- files ------------------------------------------------------------------- */

typedef enum ylm_figure_type {
  YLM_FIGURE_F32,
  YLM_FIGURE_F64,
  YLM_FIGURE_U8,
  YLM_FIGURE_I32,
  YLM_FIGURE_I64
} ylm_figure_type;

/* One named array of a file. */
typedef struct ylm_figure_data {
  const char *name;
  ylm_figure_type type;
  int components;
  size_t n;
  const void *data; /* [n][components] */
} ylm_figure_data;

/* Hexahedra with numbers at their points and of their own. */
typedef struct ylm_figure_hexahedra {
  size_t points, cells;
  const double *point;   /* [points][3] */
  const int64_t *corner; /* [cells][8] zero-based rows of point, x fastest */
  int point_arrays, cell_arrays;
  const ylm_figure_data *point_data, *cell_data;
} ylm_figure_hexahedra;

/*
** ylm_figure_save_cells - an unstructured grid of hexahedra (.vtu).
**   Raw appended data, 64-bit sizes; the file is replaced whole or not at all.
*/
YLM_API ylm_status ylm_figure_save_cells(const char *path, const ylm_figure_hexahedra *h,
                                         ylm_error *e);

/*
** A .vtu file of several pieces, of which one at a time is in memory. It is made beside its target,
** which ylm_figure_pieces_end replaces.
**
**   pieces  in  their number: so many are added
**
** Returns  YLM_EIO, YLM_ENOMEM; YLM_ERANGE for a corner that is none of the points; YLM_EINVAL for
** another number of pieces, or one whose arrays are not those of the first. After a failure nothing
** is left but to free it.
*/
typedef struct ylm_figure_pieces ylm_figure_pieces;
YLM_API ylm_status ylm_figure_pieces_begin(const char *path, size_t pieces, ylm_figure_pieces **p,
                                           ylm_error *e);
YLM_API ylm_status ylm_figure_pieces_add(ylm_figure_pieces *p, const ylm_figure_hexahedra *h,
                                         ylm_error *e);
YLM_API ylm_status ylm_figure_pieces_end(ylm_figure_pieces *p, ylm_error *e); /* frees p */
YLM_API void ylm_figure_pieces_free(ylm_figure_pieces *p);
/* Triangles or segments with normals and colours (.vtp). */
YLM_API ylm_status ylm_figure_save_shape(const char *path, const ylm_figure_shape *s, ylm_error *e);
/* A volume's first component or all (.vti), under `name`. */
YLM_API ylm_status ylm_figure_save_volume(const char *path, const ylm_figure_volume *v,
                                          const char *name, ylm_error *e);

/* -- pages: lua/ylm/page ------------------------------------------------------ */

#define YLM_FIGURE_PAGE_WORDS 12 /* of a cell */
#define YLM_FIGURE_PAGE_SIDE 29  /* words of a leaf with sides: first part, parts, 27 of pieces */

/*
** ylm_figure_page_cells - a grid's cells as a shader walks them, then the parts of leaves with sides.
**
**   cell  out  [cells + parts][12]  child (0: none), of a leaf flagged YLM_GRID_SIDED the word in
**                                   which its record begins; level + 2^8 (it has eight corners) +
**                                   2^16 flags; origin x + 2^16 y; origin z + 2^16 (estimated error,
**                                   a half); corners
*/
YLM_API void ylm_figure_page_cells(const ylm_grid *g, uint32_t *cell);
/* Gives cells the estimated errors of another grid's, of the same octree or lattice. */
YLM_API void ylm_figure_page_errors(const ylm_grid *g, const ylm_grid *from, uint32_t *cell);
/* Zeroes all that the octree of a small file says of the grid's cells: errors stay, children that continuity needs, its cells. */
YLM_API void ylm_figure_page_rest(const ylm_grid *g, uint32_t *cell);
/* Records of leaves with sides, [sides][29]: the first part's row among cells, the number of parts, the parts of
   pieces, 8 a word, the lowest bits first. */
YLM_API void ylm_figure_page_sides(const ylm_grid *g, uint32_t *record);
/* The cell of each voxel of a uniform grid, [z][y][x]; YLM_GRID_NONE: no data. */
YLM_API void ylm_figure_page_table(const ylm_grid *g, uint32_t *cell);

/* The power of two by which the largest of a grid's numbers comes to 2^14 .. 2^15, so that halves
   hold the small ones. YLM_EDOMAIN: some number is not finite. */
YLM_API ylm_status ylm_figure_page_exponent(const ylm_grid *g, int *exponent, ylm_error *e);
/* Numbers of evaluated points times 2^exponent, [evaluated][channels * count][4]: value, d/dx, d/dy,
   d/dz; slopes are 0 in a grid with sides. */
YLM_API void ylm_figure_page_rows(const ylm_grid *g, int exponent, float *row);
/* Rows [n][width][4] with slopes in bytes: value [n][width]; scale [n][3], of each point's d/dx, d/dy,
   d/dz; slope [n][width][3], -127 .. 127 times the scale. */
YLM_API void ylm_figure_page_bytes(size_t n, size_t width, const float *row, float *value,
                                   float *scale, int8_t *slope);

/* Positions [n][3] as whole steps from the corner `lo` of a box, 0 .. 65535. */
YLM_API void ylm_figure_page_positions(size_t n, const float *position, const double lo[3],
                                       const double step[3], uint16_t *out);
/* Unit normals [n][3] on an octahedron that is unfolded to a square, [n][2], -32767 .. 32767. */
YLM_API void ylm_figure_page_normals(size_t n, const float *normal, int16_t *out);

/*
** ylm_figure_planes - the bytes of numbers, all lowest ones first, then the next.
**
**   n, bytes  in   numbers, and bytes of each: 1, 2 or 4
**   columns   in   of a row; where not 0, each number less that a row before is written (wrapping)
**   out       out  [bytes][n]
*/
YLM_API void ylm_figure_planes(size_t n, size_t bytes, size_t columns, const void *in,
                               unsigned char *out);
/* Bytes as base64, [(n + 2) / 3 * 4] characters without a final 0. */
YLM_API void ylm_figure_base64(size_t n, const unsigned char *in, char *out);
/* Base64 as bytes: out has room for n / 4 * 3, *size of which are written. False: it is none. */
YLM_API bool ylm_figure_unbase64(size_t n, const char *in, unsigned char *out, size_t *size);

#ifdef __cplusplus
}
#endif
#endif
