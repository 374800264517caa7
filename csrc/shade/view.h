/* view.h - what the files of csrc/shade share. Private. */
#ifndef YLM_SHADE_VIEW_H
#define YLM_SHADE_VIEW_H

#include "ylm_shade.h"
#include "ylm_vector.h"

typedef struct ylm_light_virtual ylm_light_virtual; /* ylm_light_virtual.h */
typedef struct ylm_shade_links ylm_shade_links;     /* ylm_shade_bounce.h */

/* One shaded part of a pixel: a place on a triangle, and its share of the pixel's samples. */
typedef struct shade_entry {
  ylm_scene_place at;
  float weight, depth;
  uint32_t samples; /* a bit for each of SHADE_PLACES samples of the pixel: it hit this triangle */
} shade_entry;

/* The part of a pixel beside surfaces. */
typedef struct shade_pixel {
  size_t first; /* of its entries */
  float lamps[3], coverage, emitter;
} shade_pixel;

/* gloss.h */
typedef struct shade_gloss shade_gloss;
typedef struct shade_tables shade_tables;
typedef struct shade_kept shade_kept;

/* The coefficient of degree 0 of visibility where nothing occludes: sqrt(4 pi). */
#define YLM_SHADE_OPEN 3.5449077018110318f

struct ylm_shade_view {
  const ylm_scene *scene;
  const double *world; /* [3] positions are relative to it: ylm_scene_origin; NULL: to 0 */
  ylm_shade_options o;
  ylm_camera_frame frame;
  ylm_shade_stats stats;
  size_t entries, points;
  shade_entry *entry;    /* [entries] in the order of pixels        */
  shade_pixel *pixel;    /* [width*height + 1]                      */
  uint32_t *number;      /* [pixels]: these of the image alone; NULL: all */
  int image[2];          /* width and height of the image that they are of */
  uint32_t (*corner)[3]; /* [entries]: points at the triangle's corners; NULL: entry i is point i */
  uint32_t *mesh;        /* [points]                                */
  float (*position)[3], (*normal)[3], (*origin)[3]; /* [points]    */
  float (*lit)[3]; /* [points] where light arrives: ylm_scene_surface */
  float
      *transfer; /* [points][count]; of points that gloss their visibility. NULL: a view by rays */
  size_t idle;   /* points without a row there: rays alone shade them */
  shade_gloss *gloss; /* NULL: no surface glosses, or such are shaded as matte ones */
  float (*seen)[3];   /* [entries]: the mean tint of the samples; NULL: the scene has no tints */
  float (*tint)[3];   /* [points]; NULL as `seen`, else often the same                         */
  ylm_trace *
      *own; /* [meshes] options.self: each mesh alone, while transfer vectors are made; else NULL */
  uint32_t
      *vertex; /* [2 vertices of the scene] their points, YLM_SHADE_NOWHERE: none; all_vertices */
  const ylm_shade_view *base;    /* whose points these are (relight.c); NULL: its own */
  const ylm_material **material; /* [meshes] instead of the scene's; NULL: those  */
  bool
      looks_again; /* made of another view, but for another camera: entries and pixels are its own */
};

#define YLM_SHADE_NOWHERE UINT32_MAX

/* Virtual lights relative to the origin of a view; NULL in *own where they are so already. near.c */
ylm_status ylm__shade_enter(const ylm_shade_view *v, const ylm_light_virtual *lights,
                            ylm_light_virtual **own, ylm_error *e);

/* The material of a mesh, as the view has it. */
static inline const ylm_material *ylm__shade_mesh_material(const ylm_shade_view *v, size_t mesh) {
  return v->material ? v->material[mesh] : ylm_scene_material(v->scene, mesh);
}

/* The material at point i. */
static inline const ylm_material *ylm__shade_material(const ylm_shade_view *v, size_t i) {
  return ylm__shade_mesh_material(v, v->mesh[i]);
}

/* tint.c: in place, the radiance of n points from `first` on, and one point's albedo, by tints. */
void ylm__shade_tint(const ylm_shade_view *v, size_t first, size_t n, float *radiance);
void ylm__shade_albedo(const ylm_shade_view *v, size_t point, float albedo[3]);
/* tint.c: room for the tints of all points; frees all tints. */
ylm_status ylm__shade_make_tints(ylm_shade_view *v);
void ylm__shade_free_tints(ylm_shade_view *v);
/* tint.c: the albedo in sight of entry i. */
void ylm__shade_seen_albedo(const ylm_shade_view *v, size_t i, float albedo[3]);

/* view.c: the number of point i's random numbers. The number is the pixel's and the point's place
   in it, so that what is seen elsewhere changes nothing here. */
uint64_t ylm__shade_stream(const ylm_shade_view *v, size_t i);
/* The numbers of random streams, one point after the other. */
typedef struct shade_stream {
  size_t point, pixel;
} shade_stream;
shade_stream ylm__shade_stream_at(const ylm_shade_view *v, size_t i);
uint64_t ylm__shade_stream_next(const ylm_shade_view *v, shade_stream *at);
/* view.c: those of all points; NULL without memory. To be freed. */
uint64_t *ylm__shade_streams(const ylm_shade_view *v);

/* view.c: weights of an entry's triangle's corners. */
void ylm__shade_corner_weights(const shade_entry *e, float w[3]);

/* primary.c: fills entry, pixel, entries and the statistics of primary rays. */
ylm_status ylm__shade_primary(ylm_shade_view *v, const ylm_camera_frame *f);

/* places.c: origins of rays from n places of point i of pixel p, which samples of the pixel hit, spread over these. The
   number of origins: 0 where only the point is known. */
size_t ylm__shade_places(const ylm_shade_view *v, size_t p, size_t i, size_t n, ylm_rng *rng,
                         float (*origin)[3]);

/* primary.c: ray i of the samples of pixel p of the view, whose set is shifted by `shift`. */
void ylm__shade_pixel_shift(const ylm_shade_view *v, size_t p, int at[2], double shift[2]);
void ylm__shade_pixel_ray(const ylm_shade_view *v, const int at[2], const double shift[2], int i,
                          ylm_trace_ray *ray);

/* Distinct vertices (per side) of the triangles that entries lie on, or all (all_vertices). vertices.c */
typedef struct shade_vertices {
  size_t count;
  uint32_t *mesh, *vertex; /* [count] */
  bool *back;
  uint32_t (*corner)[3]; /* [entries]: indices of the entry's triangle's vertices here */
  uint32_t *place;       /* [2 vertices of the scene]: indices here; YLM_SHADE_NOWHERE: not here */
} shade_vertices;
ylm_status ylm__shade_vertices(const ylm_shade_view *v, shade_vertices *out);
void ylm__shade_vertices_free(shade_vertices *x);
/* vertices.c: the corners of the view's entries in v->vertex; YLM_EINVAL: one is not there. */
ylm_status ylm__shade_corners(ylm_shade_view *v, ylm_error *e);

/* transfer.c: the zonal coefficients of all kinds of materials, [kinds][lmax+1]; NULL without memory. */
double *ylm__shade_zonal(int lmax);
/* transfer.c: SH coefficients of what the materials of n points weigh light with, out
   [n][(lmax+1)^2]; zonal of ylm__shade_zonal(lmax). */
ylm_status ylm__shade_cosines(const ylm_shade_view *v, int lmax, const double *zonal, size_t n,
                              const uint32_t *mesh, const float (*normal)[3], float *out);

/* transfer.c: transfer vectors at n points of the given meshes; `rays` is added to. share [n] or NULL: zeros
   where this is 1. */
ylm_status ylm__shade_transfer(const ylm_shade_view *v, bool shadows, size_t n,
                               const uint32_t *mesh, const float (*normal)[3],
                               const float (*origin)[3], const float *share, float *transfer,
                               uint64_t *rays);

/* noise.c: raises o.transfer_samples as o.light, o.noise, o.most_samples say; wants the points, and of those
   that gloss their tables and the shares of rays. */
ylm_status ylm__shade_choose_samples(ylm_shade_view *v, const shade_tables *tables,
                                     const float *share, ylm_error *e);

/* Rays to lamps, and as many that the material chooses. */
typedef struct shade_cast {
  const ylm_scene *lit; /* whose lamps; NULL: the view's */
  int light_samples;    /* noise > 0: the least of a pixel and mesh; out: the mean */
  double
      noise; /* that they may leave in each mesh, root mean square over that of its radiance; out:
                   what they leave in the mesh that has most of it */
  int most;  /* of a pixel and mesh */
  const float *
      own; /* [n] rays of each point, of its pixel and mesh together; noise 0. NULL: light_samples */
  const float *share; /* [n] how much of each point's radiance they are, noise > 0; NULL: all */
  bool shadows;
  uint64_t seed;
  int threads;
  const ylm_progress *progress;
} shade_cast;

/* primary.c: n rays through stratified places of pixel p of the view. */
void ylm__shade_pixel_rays(const ylm_shade_view *v, size_t p, int n, uint64_t seed,
                           ylm_trace_ray *ray);

/* cast.c: radiance of n points of a view by these, out [n][3]; `rays` is added to. Points of one pixel and mesh
   share their rays, and have the mean of their radiance (options.share 0: each its own); with noise > 0 that of all that
   the pixel sees of the mesh. `point` increases. YLM_EINVAL: a view per vertex; as ylm_path_places. */
ylm_status ylm__shade_cast(const ylm_shade_view *v, shade_cast *c, size_t n, const size_t *point,
                           float *out, uint64_t *rays);

/* relight.c: frees a view that is made of another. */
void ylm__shade_change_free(ylm_shade_view *v);

/* lobes.c: the vertices that the points of a view per vertex are, 2 * vertex of the scene + back; NULL without memory.
   The surface at point i, with these; NULL: points are entries. */
uint32_t *ylm__shade_point_vertices(const ylm_shade_view *v);
void ylm__shade_surface(const ylm_shade_view *v, const uint32_t *vertex, size_t i,
                        ylm_scene_surface *s);

/* -- kernels -------------------------------------------------------------------- */

/* out[p][c] = sum over k < count of T[p][k] L[i][c][k] for i < n, p = index[i] (index NULL: p = i),
   c < channels (1: the other two are the first again). T has rows of t_row floats, L begins a
   channel every l_row floats, a point every l_point; out is [..][3]. */
typedef void ylm_shade_dot_fn(size_t count, size_t n, int channels, const uint32_t *index,
                              size_t t_row, const float *T, size_t l_row, size_t l_point,
                              const float *L, float *out);
/* all[k] += sum of Y[i][k] over i < n; seen[k] the same over i where visible[i] */
typedef void ylm_shade_sums_fn(size_t count, size_t n, const float *Y, const uint8_t *visible,
                               float *seen, float *all);
/* out[i][c] = sum over f < functions, k < count of mix[c][f] T[i][f][k] L[i][c][k] for i < n; rows of T and L
   are t_row and l_row floats, L has 1 channel or 3 */
typedef void ylm_shade_mix_fn(size_t count, size_t n, int functions, int channels, size_t t_row,
                              const float *T, size_t l_row, const float *L, const float (*mix)[3],
                              float *out);

typedef struct shade_kernels {
  ylm_shade_dot_fn *dot;
  ylm_shade_sums_fn *sums;
  ylm_shade_mix_fn *mix;
} shade_kernels;

/* The kernels of the instruction set in use. kernels.c */
shade_kernels ylm__shade_kernels(void);

/* links.c: whose points they are of. */
const ylm_shade_view *ylm__shade_links_view(const ylm_shade_links *l);

/* Coefficients as they come: of n points, [n][channels][(lmax+1)^2]. */
typedef struct shade_light {
  int channels, lmax;
  ylm_dtype type;
  const void *L;
} shade_light;

/* In place: from irradiance at n points from `first` on to the radiance that they reflect. light.c */
void ylm__shade_reflect(const ylm_shade_view *v, size_t first, size_t n, float *out);
/* Radiance of the n points `point`, whose coefficients, float, begin every l_point floats; out is
   [points][3]. light.c */
void ylm__shade_some(const ylm_shade_view *v, ylm_shade_dot_fn *dot, size_t n,
                     const uint32_t *point, const shade_light *x, size_t l_point, float *out);
/* The rows that the light of a view's points is multiplied by: transfer vectors, or cosines. */
typedef struct shade_rows {
  ylm_shade_weight weight;
  int lmax;                   /* of the light */
  double *zonal;              /* COSINE       */
  const shade_tables *tables; /* of points that gloss; NULL: there is none */
  const shade_kept *kept;     /* products of these; NULL: they are made anew */
} shade_rows;

/* light.c: YLM_EINVAL where the view has no transfer vectors; ylm_free(zonal) afterwards. */
ylm_status ylm__shade_rows(const ylm_shade_view *v, ylm_shade_weight weight, int lmax, int threads,
                           const ylm_progress *progress, shade_rows *rows, ylm_error *e);
/* light.c: out[i][c] = sum over k < count of T[i][k] L[i][c][k], in the type of the light. */
void ylm__shade_dots(ylm_shade_dot_fn *dot, size_t count, size_t n, size_t t_row, const float *T,
                     const shade_light *x, float *out);
/* glossy.c: radiance of those of n points from `first` on that gloss; x and out begin at the first of
   them. Their visibility counts with `shadows`. YLM_ENOMEM. */
ylm_status ylm__shade_glossy(const ylm_shade_view *v, ylm_shade_dot_fn *dot, const shade_rows *rows,
                             bool shadows, size_t first, size_t n, const shade_light *x,
                             float *out);
/* light.c: whether rows hold shadows that slices are multiplied by. */
bool ylm__shade_shadows(const ylm_shade_view *v, ylm_shade_weight weight);
/* Radiance of n points from `first` on; x and out begin at the first of them. YLM_ENOMEM. */
ylm_status ylm__shade_points(const ylm_shade_view *v, ylm_shade_dot_fn *dot, const shade_rows *rows,
                             size_t first, size_t n, const shade_light *x, float *out);

#endif
