/*
** ylm_scene.h - surfaces with materials, and lamps, ready to be traced.
**
**   ylm_scene          meshes, materials and lamps; what a ray hits is asked of its ylm_trace
**   ylm_scene_place    a place on one of its triangles; ylm_scene_surfaces says what is there
**   ylm_scene_chooser  aims rays from a place at the lamps
**   ylm_camera         where pictures are taken from
**
** A scene knows no picture and no spherical harmonics: what a camera sees of it is ylm_shade.h's.
** A mesh that does not occlude is only seen: it keeps no light from anything.
**
** Positions are relative to the scene's origin wherever a scene takes them or gives them, here and in the folders behind
** that have scenes. The origin is 0, but where the meshes are far from 0: there a float keeps too few
** digits of a position in the world.
**
** Ownership   ylm_scene_create copies what it is given.
** Threads     scenes are read-only after creation; a chooser is for one caller at a time.
*/
#ifndef YLM_SCENE_H
#define YLM_SCENE_H

#include "ylm_base.h"
#include "ylm_image.h"
#include "ylm_material.h"
#include "ylm_trace.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ylm_light_image ylm_light_image; /* ylm_light_emitter.h */
typedef struct ylm_light_directed ylm_light_directed;
typedef struct ylm_light_emitter ylm_light_emitter;
typedef struct ylm_light_set ylm_light_set; /* ylm_light.h */

/* -- scenes ------------------------------------------------------------------ */

typedef struct ylm_scene ylm_scene;

/* Spheres that are weighed one by one; flat lamps count eightfold. */
enum { YLM_SCENE_ONE_BY_ONE = 256 };

typedef struct ylm_scene_mesh {
  const float *positions; /* [vertices][3]  scene units, relative to `origin`        */
  const float *normals;   /* [vertices][3]  any length; NULL: those of the triangles */
  const float *uvs;       /* [vertices][2]  texture coordinates; NULL: none          */
  size_t vertices;
  const uint32_t *triangles; /* [count][3]     < vertices                               */
  size_t count;
  const ylm_material *material; /* kept: reference counted */
  bool occludes;                /* false: seen, but never in the way of light */
  const float *colours;         /* [vertices][3]  0 .. 1, linear; NULL: none: they, and          */
  const ylm_texture *texture;   /* at the uvs (kept: reference counted; NULL: none), multiply what
                                   the material reflects */
  const double *origin;         /* [3] NULL: 0 */
} ylm_scene_mesh;

/* Lamps, spheres and flat ones that emit to both sides: drawn as emitters, sampled by choosers;
   they never occlude. The last triangles are those of images, one after the other: their radiance
   is the image's where they are hit, what stands in `radiance` says how often rays are aimed at
   them (0: never). */
typedef struct ylm_scene_lamps {
  ylm_trace_lamps shape; /* relative to the scene's origin */
  const float *radiance; /* [spheres + triangles + disks][3]  W sr^-1 m^-2, linear Rec. 709 */
  const float *horizon;  /* [triangles + disks][3] or NULL: what of a lamp is below the plane across
                            it through a shading point brings no light there; 0: all does */
  size_t images;
  const ylm_light_image *image; /* in the world, as emitters are */
  size_t directions;
  const ylm_light_directed *directed; /* lamps whose radiance depends on the direction */
  const ylm_light_set
      *sky; /* distant lights, which the scene shares with the set, and emitters without a size,
                               which it copies; or NULL */
  bool sky_is_seen;  /* by camera rays that hit nothing */
  size_t one_by_one; /* up to so many lamps choosers weigh one by one for each point, more of
                               them through a tree; 0: YLM_SCENE_ONE_BY_ONE */
} ylm_scene_lamps;

/* The origin of a scene of these meshes: ylm_origin of the box around them. */
YLM_API void ylm_scene_origin_of(size_t meshes, const ylm_scene_mesh *mesh, double origin[3]);
/* YLM_OK; YLM_EINVAL, YLM_EDOMAIN, YLM_EOVERFLOW, YLM_ENOMEM, YLM_EDEVICE as ylm_trace_create
   says. */
YLM_API ylm_status ylm_scene_create(size_t meshes, const ylm_scene_mesh *mesh,
                                    const ylm_scene_lamps *lamps, ylm_scene **scene, ylm_error *e);
YLM_API void ylm_scene_free(ylm_scene *scene);

/*
** ylm_scene_relight - the same meshes with other lamps, for lamps that move.
**
** The two share meshes, materials and the structure that rays are traced through, and tables of a sky
** that both have; each may be freed before the other.
**
** Returns  as ylm_scene_create
** Cost     as if the scene had no meshes: 2,516 spheres take 0.6 ms
*/
YLM_API ylm_status ylm_scene_relight(const ylm_scene *scene, const ylm_scene_lamps *lamps,
                                     ylm_scene **out, ylm_error *e);
/* The origin [3] of positions, as long as the scene lives; NULL: 0. */
YLM_API const double *ylm_scene_origin(const ylm_scene *scene);
/* A place in the world, relative to the scene's origin; and back. */
YLM_API void ylm_scene_enter(const ylm_scene *scene, const double world[3], float x[3]);
YLM_API void ylm_scene_leave(const ylm_scene *scene, const float x[3], double world[3]);
/* Box around all meshes (not the lamps); zeros where there are none. */
YLM_API void ylm_scene_bounds(const ylm_scene *scene, double lo[3], double hi[3]);
/*
** ylm_scene_core - the box of a scene without its grounds: connected triangles that lie flat and are much wider than what stands
** on them.
**
**   place   in   [places][3]  from which the scene is seen, relative to its origin: half of them are in the box; none: anywhere
**   lo, hi  out               relative to the origin; those of ylm_scene_bounds where there is no ground
**   ground  out  [triangles of all meshes]  1: of a ground; NULL: not wanted
**
** Returns YLM_OK or YLM_ENOMEM.
*/
YLM_API ylm_status ylm_scene_core(const ylm_scene *scene, size_t places, const float (*place)[3],
                                  double lo[3], double hi[3], uint8_t *ground);
/* The structure that rays are traced through; lives as long as the scene. */
YLM_API const ylm_trace *ylm_scene_trace(const ylm_scene *scene);

/* Mesh m alone, where it occludes: rays for it meet nothing else. The caller frees it. As ylm_trace_create. */
YLM_API ylm_status ylm_scene_trace_mesh(const ylm_scene *scene, size_t m, ylm_trace **out,
                                        ylm_error *e);

/* The number of meshes; what mesh m is made of; the corners of its triangle `element`, as vertices
   of the mesh [3]. */
YLM_API size_t ylm_scene_meshes(const ylm_scene *scene);
YLM_API const ylm_material *ylm_scene_material(const ylm_scene *scene, size_t m);
YLM_API const uint32_t *ylm_scene_triangle(const ylm_scene *scene, size_t m, size_t element);
/* How many triangles mesh m has, and whether it occludes. */
YLM_API size_t ylm_scene_triangles(const ylm_scene *scene, size_t m);
YLM_API bool ylm_scene_occludes(const ylm_scene *scene, size_t m);
/* Whether some mesh has a texture or colours: tints of all surfaces are 1 otherwise. */
YLM_API bool ylm_scene_is_tinted(const ylm_scene *scene);

/* All vertices of all meshes, one after the other: their number; out [n][3], NULL: not wanted. */
YLM_API size_t ylm_scene_vertices(const ylm_scene *scene, float *out);
/* How many of them are before those of mesh m; of the mesh behind the last: all. */
YLM_API size_t ylm_scene_first_vertex(const ylm_scene *scene, size_t m);

/* Fingerprints of what light in the scene depends on, the same wherever these numbers are the same: meshes; materials,
   textures and colours; lamps and skies. */
typedef struct ylm_scene_prints {
  uint64_t geometry, materials, lights;
} ylm_scene_prints;
YLM_API void ylm_scene_print(const ylm_scene *scene, ylm_scene_prints *out);
/* That of lamps and skies alone, whether or not a picture shows the sky. */
YLM_API uint64_t ylm_scene_print_lights(const ylm_scene *scene);

/* -- what is at a place ------------------------------------------------------ */

/* A place on a triangle, by the weights of its second and third corner. */
typedef struct ylm_scene_place {
  uint32_t mesh, element;
  float u, v;
  bool back; /* seen against the triangle's winding */
} ylm_scene_place;

/* The surface there, turned to the side that is seen. Vectors have length 1. */
typedef struct ylm_scene_surface {
  float position[3], normal[3];
  float lit[3];     /* where light arrives: on the surface that the normals describe */
  float origin[3];  /* where rays start: off the triangle by no more than rays' rounding */
  float flat[3];    /* the normal of the triangle, or of the vertex */
  float tangent[3]; /* at right angles to `normal`: where u grows, else ylm_scene_basis's first */
  const ylm_material *material;
  float tint[3]; /* what the material reflects is multiplied by it: texture and colours, else 1 */
} ylm_scene_surface;

/*
** ylm_scene_surfaces - the surfaces at n places.
**
** Normals are those of the vertices, interpolated, where the mesh has them. `lit` and origins leave the
** flat triangle for the surface that these normals describe. Origins are off it by ylm_trace_lift, and
** as far from its edges as that takes beside a wall; they are rounded away from it.
**
**   p    in   [n]
**   out  out  [n]
**
** Source  Hanika 2021, "Hacking the Shadow Terminator" (lit); Pharr, Jakob & Humphreys 2023,
**         "Physically Based Rendering", 6.8 (rounding)
*/
YLM_API void ylm_scene_surfaces(const ylm_scene *scene, size_t n, const ylm_scene_place *p,
                                ylm_scene_surface *out);
/* The place of p's triangle, on the side that p is seen from, that a ray passes through; false: it passes by. */
YLM_API bool ylm_scene_cross(const ylm_scene *scene, const ylm_scene_place *p,
                             const ylm_trace_ray *ray, ylm_scene_place *out);
/* The surface at a vertex of mesh m, seen from its front or back. */
YLM_API void ylm_scene_vertex(const ylm_scene *scene, size_t m, size_t vertex, bool back,
                              ylm_scene_surface *out);
/* Where rays from x, on a surface with this normal whose triangle is not known, start: as the origin
   there; x, where no surface is. */
YLM_API void ylm_scene_ray_origin(const ylm_scene *scene, const float x[3], const float normal[3],
                                  float origin[3]);

/* -- lamps ------------------------------------------------------------------- */

/* The radiance [3] of the lamp that a ray hit, at the place where it did, towards the ray's origin. */
YLM_API void ylm_scene_lamp_radiance(const ylm_scene *scene, const ylm_trace_ray *ray,
                                     const ylm_trace_hit *hit, float radiance[3]);

/* Whether a ray that hits nothing sees distant lights, and then the radiance [3] of those. */
YLM_API bool ylm_scene_sky_radiance(const ylm_scene *scene, const ylm_trace_ray *ray,
                                    double radiance[3]);

/* The most rays that a place is asked to aim at the lamps; more are refused by the folders behind. */
#define YLM_SCENE_SAMPLES 65536

/* State for choosing rays to the lamps of a scene. */
typedef struct ylm_scene_chooser ylm_scene_chooser;
/* NULL without memory. */
YLM_API ylm_scene_chooser *ylm_scene_chooser_create(const ylm_scene *scene);
YLM_API void ylm_scene_chooser_free(ylm_scene_chooser *c);

/*
** ylm_scene_aim - rays to the lamps as x sees them, on a surface with normal n.
**
** Each of `light_samples` strata chooses a lamp about in proportion to its unshadowed luminous
** irradiance (ylm_scene_choose), then a direction. The direction is uniform in the solid angle that
** the lamp fills; of disks, and triangles that fill little, it is that of a place uniform in area.
** Of a sky of one radiance it goes as the cosine. Other skies choose pixels as their luminance
** times solid angle, in tiles that are chosen like lamps.
**
**   origin  in  [3]                where rays start, beside x; NULL: at x
**   ray    out  [light_samples]     each to a place of a lamp, or to infinity
**   value  out  [light_samples][3]  the irradiance that the ray brings if nothing is in its way
**
** Returns  how many rays there are: at most `light_samples`
** Cost     of few lamps O(lamps + light_samples), of many O(light_samples log lamps); of the sky
**          O(tiles); no allocation. The samples of a point walk down the tree together.
** Source   Shirley, Wang, Zimmerman 1996, "Monte Carlo Techniques for Direct Lighting
**          Calculations"; Arvo 1995, "Stratified Sampling of Spherical Triangles";
**          Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences" (R2)
*/
YLM_API size_t ylm_scene_aim(ylm_scene_chooser *c, const float x[3], const float n[3],
                             const float *origin, int light_samples, ylm_rng *rng,
                             ylm_trace_ray *ray, float (*value)[3]);
/* Lets a ray start beside its origin, and end where it ended. */
static inline void ylm_scene_start(ylm_trace_ray *ray, const float origin[3]) {
  float over = ray->far > 0 ? 1 / ray->far : 0;
  for (int a = 0; a < 3; a++) {
    ray->dir[a] += (ray->org[a] - origin[a]) * over;
    ray->org[a] = origin[a];
  }
}

/*
** Guides: which lamps, and which tiles of the sky, are seen from where.
**
** Places that lie close together and face the same way are a cluster. Some rays of each, a pilot, say how
** much of a lamp's or tile's unshadowed light arrives, and how much that varies. Weights by which lamps and
** tiles are chosen are then multiplied by a factor of the cluster: the root of the mean square of what arrives.
** A ray of ylm_scene_aim to a tile is one of several, chosen by such factors of 4 x 4 cells of tiles. Rays of clusters
** beside one count for its tiles and cells, too.
** Lamps that are worth a ray get one for certain, and more of them as what they bring varies. All factors are
** above 0, so that every direction with light keeps its chance, and values are divided by the chance that they
** had: estimates stay unbiased, as the pilot has random numbers of its own. Lamps of a tree (more than YLM_SCENE_ONE_BY_ONE) have
** no factors: scenes with a tree are not guided.
**
**   Source  Mueller et al. 2017, "Practical Path Guiding for Efficient Light-Transport Simulation"
**           (learning from pilots); Neyman 1934 (counts by standard deviations); Talbot, Cline & Egbert 2005,
**           "Importance Resampling for Global Illumination" (cells)
*/
typedef struct ylm_scene_guide ylm_scene_guide;

/* Places that guides are learnt from. */
typedef struct ylm_scene_places {
  size_t n;
  const float (*lit)[3], (*normal)[3], (*origin)[3]; /* [n] as ylm_scene_surface has them */
} ylm_scene_places;

/* Clusters of places: those that lie close together and face the same way. Every other place is in one of them, too. */
typedef struct ylm_scene_clusters ylm_scene_clusters;
/* Of one place at least, so that no cluster has more than `most`, as far as they are apart. YLM_OK or YLM_ENOMEM. */
YLM_API ylm_status ylm_scene_clusters_create(const ylm_scene_places *places, size_t most,
                                             ylm_scene_clusters **out);
YLM_API void ylm_scene_clusters_free(ylm_scene_clusters *c);
YLM_API size_t ylm_scene_clusters_count(const ylm_scene_clusters *c);
/* The cluster of a place. */
YLM_API size_t ylm_scene_cluster_at(const ylm_scene_clusters *c, const float x[3],
                                    const float normal[3]);
/* The clusters of n places, in less time each. */
YLM_API void ylm_scene_clusters_at(const ylm_scene_clusters *c, size_t n, const float (*x)[3],
                                   const float (*normal)[3], uint32_t *cluster);
/* The places of a cluster, as numbers [n]; where these are fewer than `least`, with those of clusters around it. Until they are
   forgotten, which frees most of the memory. */
YLM_API const uint32_t *ylm_scene_cluster_places(const ylm_scene_clusters *c, size_t cluster,
                                                 size_t least, size_t *n);
YLM_API void ylm_scene_clusters_forget(ylm_scene_clusters *c);

/* The cost of a guide. */
typedef struct ylm_scene_guide_stats {
  size_t clusters;
  uint64_t rays;
  double seconds;
} ylm_scene_guide_stats;

/*
** ylm_scene_guide_create - learns a guide for rays from places as these.
**
**   light_samples  in   rays of a place that are to be guided: the pilot has about a quarter of these
**   out            out  NULL where nothing is to be guided: no place, one lamp, or a tree of lamps
**
** Returns  YLM_OK; YLM_ENOMEM, YLM_ECANCELLED (progress stage "guides"). Results do not depend on the number of threads.
*/
YLM_API ylm_status ylm_scene_guide_create(const ylm_scene *scene, const ylm_scene_places *places,
                                          int light_samples, uint64_t seed, int threads,
                                          const ylm_progress *progress, ylm_scene_guide **out);
/* Whether there is something to guide: two lamps, and no tree of them. */
YLM_API bool ylm_scene_guides(const ylm_scene *scene);
YLM_API void ylm_scene_guide_free(ylm_scene_guide *g);
YLM_API void ylm_scene_guide_look(const ylm_scene_guide *g, ylm_scene_guide_stats *stats);
/* Lets a chooser aim by a guide, which must outlive it; NULL: by none. False: it was learnt from other lamps. */
YLM_API bool ylm_scene_chooser_follow(ylm_scene_chooser *c, const ylm_scene_guide *g);

/* Rays of several places to the lamps, which are traced in one go. For one caller at a time. */
typedef struct ylm_scene_batch {
  ylm_scene_chooser *lamps;
  ylm_trace_ray *ray; /* [room] */
  float (*value)[3];  /* [room]: irradiance that a ray brings if nothing is in its way */
  size_t rays, room;
  uint64_t traced; /* in all */
} ylm_scene_batch;

/* With room for YLM_SCENE_BATCH rays, or for the `light_samples` of one place if these are more. YLM_ENOMEM; to
   be freed in any case. */
#define YLM_SCENE_BATCH 512
YLM_API ylm_status ylm_scene_batch_create(const ylm_scene *scene, size_t light_samples,
                                          ylm_scene_batch *b);
YLM_API void ylm_scene_batch_free(ylm_scene_batch *b);
/* Appends the rays that ylm_scene_aim makes for a place. */
YLM_API void ylm_scene_batch_aim(ylm_scene_batch *b, const float x[3], const float n[3],
                                 const float origin[3], int light_samples, ylm_rng *rng);
/* Traces them all: ray[k].far < 0 where something is in the way of ray k. */
YLM_API void ylm_scene_batch_trace(ylm_scene_batch *b);

/* Lamps are counted as ylm_trace.h counts those that are hit; distant lights follow them, then points: lamps without a
   size. */

/* The number of all lamps. */
YLM_API size_t ylm_scene_lamps_all(const ylm_scene *scene);
/* The number of points, and these, as long as the scene lives. Rays are aimed at them, and never meet them. */
YLM_API size_t ylm_scene_points(const ylm_scene *scene, const ylm_light_emitter **point);
/* The light that a lamp is, relative to the scene's origin; of an image the mean of a part. False: a part of
   light that fills the sky. */
YLM_API bool ylm_scene_emitter(const ylm_scene *scene, size_t lamp, ylm_light_emitter *out);
YLM_API bool ylm_scene_is_distant(const ylm_scene *scene, size_t lamp);
/* The number of lamps that rays can meet, which are the first; of distant ones. */
YLM_API size_t ylm_scene_near(const ylm_scene *scene);
YLM_API size_t ylm_scene_distant(const ylm_scene *scene);
/* A ray from x to the place u [2] of a lamp, from 0 below 1, uniform in the solid angle or the area;
   false: nothing of it is seen there. */
YLM_API bool ylm_scene_lamp_ray(const ylm_scene *scene, size_t lamp, const float x[3],
                                const double u[2], ylm_trace_ray *ray);
/* The direction [3], of length 1, to the place u [2] of distant light i, from 0 below 1, and the radiance
   [3] from there; 1 over the density of these directions, sr; 0: there is none. */
YLM_API double ylm_scene_distant_ray(const ylm_scene *scene, size_t i, const double u[2],
                                     float direction[3], float radiance[3]);
/* The integral of the luminance of distant light i over directions: W m^-2. */
YLM_API double ylm_scene_distant_power(const ylm_scene *scene, size_t i);
/* The distant lights of a scene; NULL: there are none. */
YLM_API const ylm_light_set *ylm_scene_sky(const ylm_scene *scene);
/* The radiance [3] that a lamp, met at distance t of a ray of length 1, sends to the ray's origin;
   false: it is below the lamp's horizon, and sends none. */
YLM_API bool ylm_scene_near_radiance(const ylm_scene *scene, const ylm_trace_ray *ray,
                                     uint32_t lamp, float t, float radiance[3]);
/* How far a ray that leaves off at distance t sees lamp `lamp`, which may lie on what is there. */
YLM_API float ylm_scene_reach(const ylm_scene *scene, uint32_t lamp, const ylm_trace_ray *ray,
                              float t);
/* The first distant light from i on that shines from a direction of length 1, and its radiance [3]
   there; ylm_scene_distant: none does. The sky is in tiles, of which a direction meets one: this
   finds it at once. */
YLM_API size_t ylm_scene_distant_next(const ylm_scene *scene, size_t i, const float direction[3],
                                      float radiance[3]);
/*
** ylm_scene_choose - turn a chooser to the point x.
**
** Lamps are then chosen by (a bound of) the luminous irradiance that they bring there. Many of them
** are chosen through a tree, in which that of a group is estimated: its power over the squared
** distance, times the cosines there and at the lamps. Groups whose estimate may be far off for the
** whole are replaced by what is in them. Every lamp that may bring light has a chance.
**
**   normal  in  [3] of the surface there; NULL: a point in space, lit from all sides
**
** Returns  false where no lamp can bring light
** Cost     of few lamps O(lamps), of many O(log lamps); of the sky O(tiles); no allocation
** Source   Conty Estevez & Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree
**          Splitting"; Walter et al. 2005, "Lightcuts: A Scalable Approach to Illumination"
*/
YLM_API bool ylm_scene_choose(ylm_scene_chooser *c, const float x[3], const float *normal);
/* Tells a chooser of n <= YLM_SCENE_AHEAD places on surfaces. Until it is told of others, ylm_scene_choose_ahead at place k, whose x and
   normal are given again, is ylm_scene_choose there, with the same bits, in less time where lamps are few or a guide is followed. */
#define YLM_SCENE_AHEAD 16
YLM_API void ylm_scene_look_ahead(ylm_scene_chooser *c, size_t n, const float (*x)[3],
                                  const float (*normal)[3]);
YLM_API bool ylm_scene_choose_ahead(ylm_scene_chooser *c, size_t k, const float x[3],
                                    const float normal[3]);

/*
** ylm_scene_sample - a ray from the chooser's point to a lamp.
**
**   u         in   [3], from 0 below 1: the lamp, and the place on it
**   ray       out  ends at the lamp, or at infinity
**   radiance  out  [3] that it brings if nothing is in its way
**   lamp      out  which one, as above
**
** Returns  the density of its direction for this lamp, sr^-1, the choice of the lamp included;
**          0: nothing is to be had there
*/
YLM_API double ylm_scene_sample(const ylm_scene_chooser *c, const double u[3], ylm_trace_ray *ray,
                                float radiance[3], uint32_t *lamp);
/* The density for a direction of length 1 that meets the lamp. */
YLM_API double ylm_scene_density(const ylm_scene_chooser *c, uint32_t lamp,
                                 const float direction[3]);

/* How often a chooser that has been turned to a point chooses a lamp there: 0 .. 1, of all lamps
   together 1. O(log lamps) where they are many. */
YLM_API double ylm_scene_share(const ylm_scene_chooser *c, uint32_t lamp);

/* -- cameras ----------------------------------------------------------------- */

/* A pinhole camera. */
typedef struct ylm_camera {
  double from[3], at[3]; /* scene units, in the world, different          */
  double up[3];          /* not along at - from                           */
  double fov;            /* of the image's height, degrees, 0 < fov < 180 */
} ylm_camera;

/* Right, up and forward of a camera: dir = forward + x*right + y*up, x and y from -1 to 1 over
   the image; dir has length 1 along the view axis. */
typedef struct ylm_camera_frame {
  double from[3], right[3], up[3], forward[3];
  double pixel; /* height of a pixel at distance 1 */
} ylm_camera_frame;

/* YLM_OK; YLM_EINVAL naming what of the camera is wrong. `from` is relative to the scene's origin. */
YLM_API ylm_status ylm_scene_frame(const ylm_scene *scene, const ylm_camera *c, int width,
                                   int height, ylm_camera_frame *f, ylm_error *e);

/* -- sampling ---------------------------------------------------------------- */

/* Two vectors that make a right-handed orthonormal frame with the unit vector n.
   Source: Duff et al. 2017, "Building an Orthonormal Basis, Revisited". */
YLM_API void ylm_scene_basis(const float n[3], float a[3], float b[3]);
/* The bits of i reversed behind the binary point: van der Corput's sequence. */
YLM_API double ylm_scene_radical(uint32_t i);

#ifdef __cplusplus
}
#endif
#endif
