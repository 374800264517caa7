/*
** ylm_geom.h - triangle meshes: procedural shapes, transforms, OBJ with MTL, PLY. No ray tracing.
**
** Triangles are counter-clockwise seen from outside. Positions are in scene units.
*/
#ifndef YLM_GEOM_H
#define YLM_GEOM_H

#include "ylm_base.h"

#ifdef __cplusplus
extern "C" {
#endif

#define YLM_MESH_MAX ((size_t)1 << 28) /* vertices, and triangles, that a reader or shape makes */

typedef struct ylm_mesh {
  size_t vertices, triangles;
  float *position;  /* [vertices][3]                                 */
  float *normal;    /* [vertices][3] unit; NULL: none                */
  float *uv;        /* [vertices][2]; NULL: none                     */
  uint32_t *index;  /* [triangles][3], each below `vertices`         */
  float *colour;    /* [vertices][3] 0 .. 1, linear; NULL: none      */
  double origin[3]; /* positions are relative to it; 0 but far from 0: ylm_origin */
} ylm_mesh;

/* A mesh of zeros. YLM_EOVERFLOW (more than YLM_MESH_MAX), YLM_ENOMEM. */
YLM_API ylm_status ylm_mesh_create(size_t vertices, size_t triangles, bool normals, bool uvs,
                                   ylm_mesh **mesh, ylm_error *e);
YLM_API void ylm_mesh_free(ylm_mesh *mesh);
/* Sets the origin, and positions [vertices][3] relative to it, from places in the world. */
YLM_API void ylm_mesh_set_places(ylm_mesh *mesh, const double *place);
/* Whether positions are relative to another place than 0. */
static inline bool ylm_mesh_is_far(const ylm_mesh *mesh) {
  return mesh->origin[0] != 0 || mesh->origin[1] != 0 || mesh->origin[2] != 0;
}
/* The place of a vertex in the world. */
static inline void ylm_mesh_place(const ylm_mesh *mesh, size_t vertex, double out[3]) {
  for (size_t a = 0; a < 3; a++) out[a] = mesh->origin[a] + mesh->position[3 * vertex + a];
}
/* Smallest and largest coordinates in the world; zeros for a mesh without vertices. */
YLM_API void ylm_mesh_bounds(const ylm_mesh *mesh, double lo[3], double hi[3]);
/* Sum of the areas of all triangles. */
YLM_API double ylm_mesh_area(const ylm_mesh *mesh);
/* Makes normals: area-weighted means of the triangles around each vertex, in an order that does
   not depend on anything; (0, 0, 1) where there is nothing to average. YLM_ENOMEM. */
YLM_API ylm_status ylm_mesh_make_normals(ylm_mesh *mesh);
/* Twice the area of a triangle times its unit normal. */
YLM_API void ylm_mesh_area_vector(const ylm_mesh *mesh, size_t triangle, double out[3]);

/*
** ylm_mesh_pick - a mesh whose vertices are vertices of another, with all that these have.
**
**   from    in  [n] vertices of the other
**   index   in  [triangles of the other][3] vertices of the new mesh, below n
**   turned  in  normals point to the other side; the index says how triangles run
**
** Returns  YLM_OK; YLM_EOVERFLOW, YLM_ENOMEM
*/
YLM_API ylm_status ylm_mesh_pick(const ylm_mesh *mesh, size_t n, const uint32_t *from,
                                 const uint32_t *index, bool turned, ylm_mesh **out, ylm_error *e);

/* A vertex between three others: the sum of part times vertex, over the sum of the parts. */
typedef struct ylm_mesh_mix {
  uint32_t of[3], part[3];
} ylm_mesh_mix;

/* ylm_mesh_pick of vertices between others: `triangles` of them. Positions are rounded alike wherever the same two vertices are
   mixed, so edges stay closed. */
YLM_API ylm_status ylm_mesh_blend(const ylm_mesh *mesh, size_t n, const ylm_mesh_mix *from,
                                  size_t triangles, const uint32_t *index, bool turned,
                                  ylm_mesh **out, ylm_error *e);

#define YLM_MESH_CREASE 40.0         /* degrees: the crease angle where nobody names one */
#define YLM_MESH_FLAT 0u             /* smoothing groups that are none: a flat triangle,  */
#define YLM_MESH_BY_ANGLE UINT32_MAX /* and one whose edges are creases by their angle    */
/*
** ylm_mesh_make_creased_normals - ylm_mesh_make_normals, but for creases: vertices at sharp edges are split.
**
** An edge is smooth between triangles whose normals differ by `degrees` or less. The first
** normal of a vertex keeps the vertex and its number; copies of the vertex for other normals follow the last one.
**
**   degrees  in   0 (flat but within planes) .. 180 (smooth everywhere)
**   group    in   [triangles] YLM_MESH_FLAT, YLM_MESH_BY_ANGLE or a smoothing group, whatever the angle; NULL: by angle
**
** Returns  YLM_OK; YLM_ENOMEM (the mesh may be split in part, and must be freed)
** Cost     O(vertices + triangles)
*/
YLM_API ylm_status ylm_mesh_make_creased_normals(ylm_mesh *mesh, double degrees,
                                                 const uint32_t *group);
/*
** ylm_mesh_weld - one name for all vertices at a place.
**
**   position  in   [vertices][3] finite
**   name      out  [vertices] 0 .. *places - 1, rising with the place: by x, then y, then z
**
** Returns  YLM_OK; YLM_ENOMEM
*/
YLM_API ylm_status ylm_mesh_weld(size_t vertices, const float *position, uint32_t *name,
                                 size_t *places);
/*
** ylm_mesh_open_edges - edges that triangles do not pass as often one way as the other.
**
**   index     in   [triangles][3] vertices
**   name      in   of each vertex, as ylm_mesh_weld has it
**   open      out  0: the triangles close around something
**
** Returns  YLM_OK; YLM_ENOMEM
*/
YLM_API ylm_status ylm_mesh_open_edges(size_t triangles, const uint32_t *index,
                                       const uint32_t *name, size_t *open);

/* -- procedural shapes: all have normals and texture coordinates ---------------- */

/* corner + s*u + t*v for s, t in 0 .. 1, in nu x nv quads of two triangles; faces along u x v. */
YLM_API ylm_status ylm_mesh_quad(const double corner[3], const double u[3], const double v[3],
                                 int nu, int nv, ylm_mesh **mesh, ylm_error *e);
/* Radius r about the origin, pole +z, `around` segments (>= 3) and `rings` from pole to pole (>=
 * 2). */
YLM_API ylm_status ylm_mesh_sphere(double r, int around, int rings, ylm_mesh **mesh, ylm_error *e);
/* The box of these corners; each face divided into n x n quads. */
YLM_API ylm_status ylm_mesh_box(const double lo[3], const double hi[3], int n, ylm_mesh **mesh,
                                ylm_error *e);
/* Axis +z; `radius` to the middle of the tube of radius `tube`. */
YLM_API ylm_status ylm_mesh_torus(double radius, double tube, int around, int across,
                                  ylm_mesh **mesh, ylm_error *e);
/*
** ylm_mesh_knot - a tube along the (p, q) torus knot.
**
**   c(t) = ((R + r cos qt) cos pt, (R + r cos qt) sin pt, r sin qt),  0 <= t < 2 pi
**
**   p, q           in  1 .. 64; p times around the axis +z, q times around the tube of the torus;
**                      with a common divisor it is a closed curve run through several times:
**                      refused
**   radius, minor  in  R, r > 0
**   tube           in  > 0
**   along, across  in  segments, >= 3; 2*along*across triangles
**
** Frames: c' and the torus' outward direction made perpendicular to it: they close without a twist.
** Returns  YLM_OK; YLM_EINVAL, YLM_ERANGE, YLM_EOVERFLOW, YLM_ENOMEM
*/
YLM_API ylm_status ylm_mesh_knot(int p, int q, double radius, double minor, double tube, int along,
                                 int across, ylm_mesh **mesh, ylm_error *e);

/* -- transforms: 3 x 4, row-major, y = A x + b ------------------------------------ */

YLM_API void ylm_transform_identity(double m[12]);
/* Rotation by `radians` about an axis of any length but 0, right-handed. */
YLM_API void ylm_transform_rotate(double m[12], const double axis[3], double radians);
/* out = a after b; out may be a or b. */
YLM_API void ylm_transform_compose(double out[12], const double a[12], const double b[12]);
/* Moves a mesh; normals by the inverse transpose; a mirror image turns its triangles around.
   YLM_EDOMAIN if the matrix is singular or not finite, or a vertex overflows (the mesh is then
   untouched). */
YLM_API ylm_status ylm_mesh_transform(ylm_mesh *mesh, const double m[12], ylm_error *e);

/* -- spheres in place of a body: csrc/geom/sphere_set.c ---------------------------- */

#define YLM_SPHERE_SET 4096

/* Volumes, in cubes of scene units, by the points of a lattice. */
typedef struct ylm_sphere_set {
  size_t count; /* of spheres */
  double volume, outside,
      uncovered; /* of the body; of spheres outside of it; of it outside of spheres */
  double step;   /* of the lattice */
} ylm_sphere_set;

/*
** ylm_mesh_sphere_set - spheres, whose union comes near to a closed mesh.
**
**   count    in   1 .. YLM_SPHERE_SET; fewer are made where they cover all points of the lattice
**   at       out  [count][3], of which set->count are written
**   radius   out  [count]
**
** Returns  YLM_OK; YLM_ERANGE (count), YLM_EDOMAIN (no triangles, not finite, open, no volume, too thin for the
**          lattice): `e` says what; YLM_ENOMEM, YLM_ECANCELLED
** Cost     grows with count and with the points of the lattice, 20,000 inside of the body or 60 a sphere
*/
YLM_API ylm_status ylm_mesh_sphere_set(const ylm_mesh *m, size_t count, double *at, double *radius,
                                       ylm_sphere_set *set, const ylm_progress *progress,
                                       ylm_error *e);

/* -- files ---------------------------------------------------------------------- */

/*
** ylm_mesh_parse_obj - a mesh from the text of a Wavefront OBJ file.
**
** Read: v, vn, vt, s, f (v, v/vt, v//vn, v/vt/vn, negative indices, polygons as fans). Other
** statements are skipped. A vertex is made for each distinct combination of indices; without
** texture coordinates and normals positions stay as they are and unused ones are kept.
** Normals are computed (ylm_mesh_make_creased_normals) where some face has none.
**
**   text    in   [size] bytes
**   name    in   what errors call it: "name:line: ..."
**   crease  in   degrees, of faces without a word of s
**
** Returns  YLM_OK; YLM_EFORMAT with the line, YLM_ELIMIT (more than YLM_MESH_MAX), YLM_ENOMEM
** Cost     O(size)
*/
YLM_API ylm_status ylm_mesh_parse_obj(const unsigned char *text, size_t size, const char *name,
                                      double crease, ylm_mesh **mesh, ylm_error *e);
/*
** ylm_mesh_parse_ply - a mesh from the bytes of a PLY file: ascii, binary_little_endian,
** binary_big_endian, 1.0; vertex x y z [nx ny nz] [s t | u v | texture_u texture_v] [red green blue],
** face vertex_indices or vertex_index as lists; other elements and properties are skipped.
** Colours of 8 and 16 bits are sRGB-encoded and become linear; float and double are linear, from 0 to 1.
*/
YLM_API ylm_status ylm_mesh_parse_ply(const unsigned char *bytes, size_t size, const char *name,
                                      double crease, ylm_mesh **mesh, ylm_error *e);
/* By content: PLY if it begins with "ply", else OBJ. Errors of ylm_file_read too. */
YLM_API ylm_status ylm_mesh_read(const char *path, double crease, ylm_mesh **mesh, ylm_error *e);
/* Whether ylm_mesh_read takes these bytes for PLY. */
YLM_API bool ylm_mesh_is_ply(const unsigned char *bytes, size_t size);
/* Writes binary little-endian PLY. YLM_EIO. */
YLM_API ylm_status ylm_mesh_write_ply(const ylm_mesh *mesh, const char *path, ylm_error *e);

/* -- materials of OBJ files -------------------------------------------------------- */

/* A name or file name as a file gives it, up to the end of the line. */
typedef struct ylm_mesh_text {
  char *text;
  size_t line;
} ylm_mesh_text;

/* The materials that an OBJ file names. */
typedef struct ylm_mesh_groups {
  size_t libraries, names;
  ylm_mesh_text *library; /* [libraries] of mtllib                                              */
  ylm_mesh_text *name;    /* [names] of usemtl, each once, in the order of their first mention  */
  size_t triangles;
  uint32_t *group; /* [triangles]: 1 + the name's place, 0 before the first usemtl       */
} ylm_mesh_groups;

/* ylm_mesh_parse_obj, and what it says about materials; groups are the caller's to free. */
YLM_API ylm_status ylm_mesh_parse_obj_groups(const unsigned char *text, size_t size,
                                             const char *name, double crease, ylm_mesh **mesh,
                                             ylm_mesh_groups **groups, ylm_error *e);
YLM_API void ylm_mesh_groups_free(ylm_mesh_groups *groups);
/*
** ylm_mesh_split - a mesh for each group of triangles, with the vertices that these use.
**
**   part  out  [names + 1], NULL where a group has no triangle; the caller's to free
**
** Returns  YLM_OK; YLM_ENOMEM (all parts are then NULL)
** Cost     O(vertices + triangles)
*/
YLM_API ylm_status ylm_mesh_split(const ylm_mesh *mesh, const ylm_mesh_groups *groups,
                                  ylm_mesh **part, ylm_error *e);

/* A material of an MTL file: what it says, else `has` is false and the numbers are 0. */
typedef struct ylm_mesh_material {
  ylm_mesh_text name;
  float kd[3], ks[3], ke[3]; /* diffuse, specular 0 .. 1; emitted radiance >= 0        */
  float ns;                  /* exponent, 0 .. 1e5                                     */
  bool has_kd, has_ks, has_ke, has_ns;
  ylm_mesh_text map_kd; /* the file's name; text NULL: none                       */
} ylm_mesh_material;

/* All materials of an MTL file. */
typedef struct ylm_mesh_library {
  size_t count;
  ylm_mesh_material *material; /* [count] */
  size_t skipped;              /* statements and options that were not read */
  char words[100];             /* the first of their names */
} ylm_mesh_library;

/*
** ylm_mesh_parse_mtl - the materials of a Wavefront MTL file.
**
** Read: newmtl, Kd, Ks, Ke (r g b, or r for all three), Ns, map_Kd (without its options), in upper or
** lower case. Other statements are skipped and counted. Names go to the end of the line.
**
**   text  in  [size] bytes
**   name  in  what errors call it: "name:line: ..."
**
** Returns  YLM_OK; YLM_EFORMAT with the line, YLM_ENOMEM
** Cost     O(size)
*/
YLM_API ylm_status ylm_mesh_parse_mtl(const unsigned char *text, size_t size, const char *name,
                                      ylm_mesh_library **library, ylm_error *e);
YLM_API void ylm_mesh_library_free(ylm_mesh_library *library);

#ifdef __cplusplus
}
#endif
#endif
