/* view.h - what the files of csrc/shade share. Private. */
#ifndef YLM_SHADE_VIEW_H
#define YLM_SHADE_VIEW_H

#include "ylm_shade.h"
#include "ylm_trace.h"

/* A mesh as copied: `smooth` where it came with normals; else they are means over triangles, for
   shading per vertex alone. */
typedef struct shade_mesh {
  float *position, *normal; /* [vertices][3] */
  uint32_t *triangle;       /* [count][3]    */
  size_t vertices, count, first_vertex;
  bool smooth;
  ylm_material material;
} shade_mesh;

/* A texture as copied. */
typedef struct shade_texture {
  double corner[3], across[3], up[3]; /* s = across.(p - corner) from 0 to 1, upwards by up */
  size_t width, height;
  float *texel;         /* [height][width][3], times the scale */
  size_t first, behind; /* its triangles: first .. behind-1 */
} shade_texture;

struct ylm_shade_scene {
  ylm_trace *trace;
  shade_mesh *mesh;
  size_t meshes, vertices;
  size_t lamps;
  float *lamp[4]; /* x, y, z, radius: each [lamps], padded to a multiple of YLM_LAMP_CHUNK */
  float *lamp_luminance;
  float *lamp_radiance;    /* [lamps + triangles + disks][3] */
  size_t triangles, disks; /* of flat lights: "patches", triangles first */
  float *triangle, *disk;  /* [triangles][9], [disks][7] */
  float *patch_luminance;  /* [triangles + disks] */
  float *horizon;          /* [triangles + disks][3] or NULL */
  size_t textures;
  shade_texture *texture; /* in the order of their triangles */
};

/* One shaded part of a pixel: a place on a triangle, and its share of the pixel's samples. */
typedef struct shade_entry {
  uint32_t mesh, element;
  float u, v, weight, depth;
  bool back; /* seen against the triangle's winding */
} shade_entry;

/* The surface there, its sides turned towards the camera. */
typedef struct shade_surface {
  float position[3], normal[3];
  float origin[3]; /* where rays start */
} shade_surface;

/* What a pixel shows beside surfaces. */
typedef struct shade_pixel {
  size_t first; /* of its entries */
  float lamps[3], coverage, emitter;
} shade_pixel;

/* Right, up and forward of a camera: dir = forward + x*right + y*up, x and y from -1 to 1 over
   the image; dir has length 1 along the view axis. camera.c */
typedef struct shade_frame {
  double from[3], right[3], up[3], forward[3];
  double pixel; /* height of a pixel at distance 1 */
} shade_frame;

struct ylm_shade_view {
  const ylm_shade_scene *scene;
  ylm_shade_options o;
  shade_frame frame;
  ylm_shade_stats stats;
  size_t entries, points;
  shade_entry *entry;    /* [entries] in the order of pixels        */
  shade_pixel *pixel;    /* [width*height + 1]                      */
  uint32_t (*corner)[3]; /* [entries]: points at the triangle's corners; NULL: entry i is point i */
  uint32_t *mesh;        /* [points]                                */
  float (*position)[3], (*normal)[3], (*origin)[3]; /* [points]    */
  float *transfer;                                  /* [points][count]                         */
};

/* scene.c: the surface at entry `e`. */
void ylm__shade_surface(const ylm_shade_scene *s, const shade_entry *e, shade_surface *out);
/* The point and normal of a vertex seen from its front or back. */
void ylm__shade_vertex(const ylm_shade_scene *s, uint32_t mesh, uint32_t vertex, bool back,
                       shade_surface *out);

/* view.c: weights of an entry's triangle's corners. */
void ylm__shade_corner_weights(const shade_entry *e, float w[3]);

ylm_status ylm__shade_frame(const ylm_camera *c, int width, int height, shade_frame *f,
                            ylm_error *e);

/* primary.c: fills entry, pixel, entries and the statistics of primary rays. */
ylm_status ylm__shade_primary(ylm_shade_view *v, const shade_frame *f);

/* Distinct vertices (per side) of the triangles that entries lie on. vertices.c */
typedef struct shade_vertices {
  size_t count;
  uint32_t *mesh, *vertex; /* [count] */
  bool *back;
  uint32_t (*corner)[3]; /* [entries]: indices of the entry's triangle's vertices here */
} shade_vertices;
ylm_status ylm__shade_vertices(const ylm_shade_view *v, shade_vertices *out);
void ylm__shade_vertices_free(shade_vertices *x);

/* transfer.c: transfer vectors at n points; `rays` is added to. */
ylm_status ylm__shade_transfer(const ylm_shade_view *v, bool shadows, size_t n,
                               const float (*normal)[3], const float (*origin)[3], float *transfer,
                               uint64_t *rays);

/* noise.c: raises o.transfer_samples as o.light, o.noise, o.most_samples say; wants the points. */
ylm_status ylm__shade_choose_samples(ylm_shade_view *v, ylm_error *e);

/* -- kernels -------------------------------------------------------------------- */

#define YLM_LAMP_CHUNK 64

/* out[p][c] = sum over k < count of T[p][k] L[i][c][k] for i < n, p = index[i] (index NULL: p = i),
   c < channels (1: the other two are the first again). T has rows of t_row floats, L begins a
   channel every l_row floats, a point every l_point; out is [..][3]. */
typedef void ylm_shade_dot_fn(size_t count, size_t n, int channels, const uint32_t *index,
                              size_t t_row, const float *T, size_t l_row, size_t l_point,
                              const float *L, float *out);
/* all[k] += sum of Y[i][k] over i < n; seen[k] the same over i where visible[i] */
typedef void ylm_shade_sums_fn(size_t count, size_t n, const float *Y, const uint8_t *visible,
                               float *seen, float *all);
/* w[j]: bound of the unshadowed luminous irradiance, over pi, at x with normal n from lamp j;
   sum[b]: over chunk b of YLM_LAMP_CHUNK lamps. Arrays are padded with lamps of luminance 0. */
typedef void ylm_shade_weights_fn(size_t chunks, float *const lamp[4], const float *luminance,
                                  const float x[3], const float n[3], float *w, float *sum);

typedef struct shade_kernels {
  ylm_shade_dot_fn *dot;
  ylm_shade_sums_fn *sums;
  ylm_shade_weights_fn *weights;
} shade_kernels;

/* The kernels of the instruction set in use. kernels.c */
shade_kernels ylm__shade_kernels(void);

/* Coefficients as they come: of n points, [n][channels][(lmax+1)^2]. */
typedef struct shade_light {
  int channels, lmax;
  ylm_dtype type;
  const void *L;
} shade_light;

/* Radiance of the n points `point`, whose coefficients, float, begin every l_point floats; out is
   [points][3]. light.c */
void ylm__shade_some(const ylm_shade_view *v, ylm_shade_dot_fn *dot, size_t n,
                     const uint32_t *point, const shade_light *x, size_t l_point, float *out);
/* Radiance of n points from `first` on; x and out begin at the first of them. */
void ylm__shade_points(const ylm_shade_view *v, ylm_shade_dot_fn *dot, size_t first, size_t n,
                       const shade_light *x, float *out);

/* -- aim.c -------------------------------------------------------------------- */

/* What choosing rays to the lamps of a scene takes; one caller at a time. */
typedef struct shade_aim {
  const ylm_shade_scene *scene;
  size_t chunks, spheres; /* chunks of all lamps; of these, of spheres */
  ylm_shade_weights_fn *weights;
  float *weight, *sum; /* [chunks*YLM_LAMP_CHUNK], [chunks]: spheres, then patches */
} shade_aim;

/* YLM_OK, YLM_ENOMEM; to be freed either way. */
ylm_status ylm__shade_aim_create(shade_aim *a, const ylm_shade_scene *s);
void ylm__shade_aim_free(shade_aim *a);
/* Aims up to `samples` rays from x, on a surface with normal n, at the lamps, in proportion to what
   they may bring: ray [samples], value [samples][3], the irradiance that each brings if nothing is
   in its way; returns their number. */
size_t ylm__shade_aim(const shade_aim *a, const float x[3], const float n[3], int samples,
                      ylm_rng *rng, ylm_trace_ray *ray, float (*value)[3]);

/* -- patch.c ------------------------------------------------------------------ */

/* For each patch the luminance times a bound of about its unshadowed irradiance over pi, above 0
   wherever it brings light; `weight` is padded to chunks, `sum` over them. */
void ylm__shade_patch_weights(const ylm_shade_scene *s, const float x[3], const float n[3],
                              float *weight, float *sum);
/* A ray from x to a random place on patch i, the radiance there and the irradiance that it brings
   for radiance 1: uniform in the solid angle of triangles that fill much of it (Arvo 1995), else by
   area. */
double ylm__shade_patch_sample(const ylm_shade_scene *s, size_t i, const float x[3],
                               const float n[3], double u0, double u1, ylm_trace_ray *ray,
                               const float **radiance);

/* texture.c: copies textures; their triangles are the last of s->triangles. */
ylm_status ylm__shade_copy_textures(ylm_shade_scene *s, const ylm_shade_lamps *l, ylm_error *e);
void ylm__shade_free_textures(ylm_shade_scene *s);
/* The radiance of patch i at the place p on it, [3]. */
const float *ylm__shade_patch_radiance(const ylm_shade_scene *s, size_t i, const double p[3]);

/* -- sampling.c ---------------------------------------------------------------- */

/* Two vectors that make a right-handed orthonormal frame with the unit vector n.
   Source: Duff et al. 2017, "Building an Orthonormal Basis, Revisited". */
void ylm__shade_basis(const float n[3], float a[3], float b[3]);
/* The bits of i reversed behind the binary point: van der Corput's sequence. */
double ylm__shade_radical(uint32_t i);

static inline float ylm__dot3(const float a[3], const float b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

#endif
