/*
** ylm_transfer.h - light from surface to surface.
**
**   ylm_transfer   the surfaces of a scene in elements, and links: the elements that each of them sees
**   ylm_radiosity  light on these elements: direct light, and all its bounces
**   ylm_gather     a light field: what the elements send to points in space
**
** A ray of an element, of a shading point or of a probe is traced once. The number of the element that it hit is kept. Rays
** have the density of the cosine, so all links of a place weigh alike, and what arrives there is a mean over rows:
**
**   E_i = E0_i + 1/K sum over links j of i of rho_j E_j
**
** E irradiance, E0 that of direct light, rho the albedo. Surfaces reflect as matte ones of their
** mean albedo.
**
** Elements    numbered from 0; behind the last stands a row of zeros: links that hit nothing lead there.
** Ownership   a transfer must not outlive its scene, a radiosity its transfer, a gather its radiosity.
** Threads     transfers are read-only after creation. Results do not depend on the number of threads.
** Source      Goral et al. 1984, "Modeling the Interaction of Light Between Diffuse Surfaces"; Green
**             2003, "Spherical Harmonic Lighting: The Gritty Details"; docs/bouncing.md
*/
#ifndef YLM_TRANSFER_H
#define YLM_TRANSFER_H

#include "ylm_base.h"
#include "ylm_grid.h"
#include "ylm_scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/* -- elements and links ------------------------------------------------------- */

typedef struct ylm_transfer ylm_transfer;

/* Numbers of elements, in two bytes each or in four: one of the two is NULL. */
typedef struct ylm_links {
  uint16_t *two;
  uint32_t *four;
} ylm_links;

/* Link k. */
static inline uint32_t ylm_links_at(ylm_links l, size_t k) { return l.two ? l.two[k] : l.four[k]; }
/* Links from k on. */
static inline ylm_links ylm_links_from(ylm_links l, size_t k) {
  ylm_links from = {l.two ? l.two + k : NULL, l.four ? l.four + k : NULL};
  return from;
}
/* The bytes of a link. */
static inline size_t ylm_links_bytes(ylm_links l) { return l.two ? 2 : 4; }
/* Whether there is none: memory ran out. */
static inline bool ylm_links_are_none(ylm_links l) { return !l.two && !l.four; }

#define YLM_TRANSFER_LINKS 4096                      /* the most links of a place */
#define YLM_TRANSFER_LMAX 20                         /* the highest degree of transfer vectors */
#define YLM_TRANSFER_ELEMENTS ((size_t)1 << 20)      /* at most, where the caller says nothing */
#define YLM_TRANSFER_ELEMENTS_MOST ((size_t)1 << 30) /* at most, whatever the caller says */
#define YLM_TRANSFER_BOUNCES 1000000 /* the most bounces that are asked for by number */

/* Which sides of a mesh reflect. AUTO: of a closed mesh the outer one, or the inner one where it is
   a room; of an open mesh both. A room holds a lamp or one of the `inside` places. */
typedef enum ylm_transfer_sides {
  YLM_TRANSFER_AUTO,
  YLM_TRANSFER_BOTH,
  YLM_TRANSFER_FRONT,
  YLM_TRANSFER_BACK
} ylm_transfer_sides;

typedef struct ylm_transfer_form {
  double spacing; /* the longest edge of an element, scene units; 0: a hundredth of the diagonal
                     of what stands on grounds (ylm_scene_core, of `inside`), and on grounds of all's,
                     raised until there are at most max_elements                                */
  size_t max_elements; /* YLM_ELIMIT beyond; 0: YLM_TRANSFER_ELEMENTS                       */
  int links;           /* of an element, 4 .. YLM_TRANSFER_LINKS, a multiple of 4           */
  int lmax; /* of the transfer vectors of direct light, 0 .. YLM_TRANSFER_LMAX; -1: none */
  ylm_transfer_sides sides;
  const uint8_t *mesh_sides; /* [meshes] ylm_transfer_sides each, or NULL: `sides` for all      */
  size_t places;
  const float (*inside)[3]; /* [places] points in space from which rooms are seen: the camera  */
  uint64_t seed;
  int threads;
  const ylm_progress *progress; /* stages "elements", "links" */
} ylm_transfer_form;

typedef struct ylm_transfer_stats {
  size_t elements;      /* sides counted */
  size_t degenerate;    /* triangles without area: no element */
  size_t closed, rooms; /* closed meshes; of these, those whose inner side is used */
  size_t dead;          /* elements whose rays all begin inside of a body: E = 0 */
  uint64_t rays, escaped, buried,
      lost; /* links: to nothing; begun inside of a body and replaced; to a side
                                           that has no element */
  double seconds;
  size_t bytes;
} ylm_transfer_stats;

/*
** ylm_transfer_create - cut the surfaces of a scene into elements, and find what each of them sees.
**
** A triangle whose longest edge is longer than `spacing` is cut into k^2 equal ones; a long one, where that takes half as many
** elements at most, into strips across its longest edge, whose elements have no edge beyond 1.3 times the spacing. Each element sends
** `links` rays, their origins stratified over it, their directions distributed as the cosine about the
** normal. A ray whose first hit is a side that is not used begins inside of a body: it is replaced
** by one of the element's other rays. Meshes that do not occlude have no elements.
**
** Returns  YLM_OK; YLM_ERANGE (a field of the form), YLM_ELIMIT, YLM_ENOMEM, YLM_ECANCELLED
** Cost     elements * links rays; 2 bytes a link where there are at most 65,535 elements, else 4
*/
YLM_API ylm_status ylm_transfer_create(const ylm_scene *scene, const ylm_transfer_form *form,
                                       ylm_transfer **t, ylm_error *e);
YLM_API void ylm_transfer_free(ylm_transfer *t);
YLM_API void ylm_transfer_look(const ylm_transfer *t, ylm_transfer_stats *stats);
/* The form that it was made with; `mesh_sides`, `inside` and `progress` are NULL, `spacing` is that in use. */
YLM_API const ylm_transfer_form *ylm_transfer_made(const ylm_transfer *t);
YLM_API const ylm_scene *ylm_transfer_scene(const ylm_transfer *t);

/* The number of elements n. */
YLM_API size_t ylm_transfer_count(const ylm_transfer *t);
/* The part of a triangle's area that counts where places are drawn by area: less than 1 on grounds (ylm_scene_core), which count
   together as the largest face of the box of what stands on them. */
YLM_API double ylm_transfer_ground_share(const ylm_transfer *t, size_t mesh, size_t triangle);
/* centre, normal [n][3], area [n] of the part that is not inside of a body, albedo [n][3] tinted, mesh [n]; any
   may be NULL. */
YLM_API void ylm_transfer_elements(const ylm_transfer *t, float *centre, float *normal, float *area,
                                   float *albedo, uint32_t *mesh);
/* The element at a place, or n where that side has none. */
YLM_API uint32_t ylm_transfer_element(const ylm_transfer *t, const ylm_scene_place *p);
/* The elements that n rays hit first (n hits of ylm_trace_nearest for them): out [n]; n of the transfer
   where nothing is hit, n + 1 (YLM_TRANSFER_BURIED) where a side is that is not used. */
#define YLM_TRANSFER_BURIED(t) ((uint32_t)ylm_transfer_count(t) + 1)
YLM_API void ylm_transfer_hits(const ylm_transfer *t, size_t n, const ylm_trace_ray *ray,
                               const ylm_trace_hit *hit, uint32_t *out);
/* The element that a ray hit first, whose other side may be another's and which a wall may part; n of the transfer: none. */
YLM_API uint32_t ylm_transfer_hit(const ylm_transfer *t, const ylm_trace_ray *ray,
                                  const ylm_trace_hit *hit);
/* The links, [elements][links], in the order of their targets. */
YLM_API ylm_links ylm_transfer_links(const ylm_transfer *t);
/* Room for `n` links of this transfer, to be freed by ylm_links_free: two bytes each where the numbers of its elements fit. */
YLM_API ylm_links ylm_transfer_room(const ylm_transfer *t, size_t n);
YLM_API void ylm_links_free(ylm_links l);
/* Transfer vectors of direct light, [elements][(lmax+1)^2], the SH of cosine times escape; NULL: none. */
YLM_API const float *ylm_transfer_escape(const ylm_transfer *t);

/*
** ylm_transfer_find - links of n other places.
**
**   origin   in   [n][3]  where rays start
**   normal   in   [n][3]  unit: directions are distributed as the cosine about it; NULL: evenly over
**                         the sphere
**   links    in   of a place, 4 .. YLM_TRANSFER_LINKS, a multiple of 4
**   stream   in   [n] or NULL: the number of each place's random numbers; NULL: its place in the list
**   out      out  [n][links]: ylm_transfer_room, or four bytes each
**   escape   out  [n][(lmax+1)^2] or NULL: SH of cosine times escape (of the sphere: of escape), by the
**                 same rays
**
** Returns  YLM_OK; YLM_ERANGE, YLM_EDOMAIN (an origin or a normal), YLM_ENOMEM, YLM_ECANCELLED (stage "links")
*/
YLM_API ylm_status ylm_transfer_find(const ylm_transfer *t, size_t n, const float (*origin)[3],
                                     const float (*normal)[3], const uint64_t *stream, int links,
                                     uint64_t seed, int threads, const ylm_progress *progress,
                                     ylm_links out, int lmax, float *escape, ylm_error *e);
/*
** ylm_transfer_sum - means of rows over links.
**
**   out[i] = start[i] + 1/links sum over j < links of in[link[i][j]]
**
**   link   in   [n][links], all at most `elements`
**   width  in   numbers in a row, a multiple of 4
**   in     in   [elements + 1][width], the last row zero; 16-byte aligned
**   start  in   [n][width] or NULL: zeros
**   out    out  [n][width]
**
** Cost     memory: 2 or 4 bytes a link, and rows at random. No allocation
*/
YLM_API void ylm_transfer_sum(size_t n, int links, ylm_links link, int width, const float *in,
                              const float *start, float *out, int threads);

/* Writes to a file, beside it first; reads one, which must be of this scene (YLM_EINVAL). */
YLM_API ylm_status ylm_transfer_write(const ylm_transfer *t, const char *path, ylm_error *e);
YLM_API ylm_status ylm_transfer_read(const ylm_scene *scene, const unsigned char *bytes,
                                     size_t size, const char *name, ylm_transfer **t, ylm_error *e);

/* -- bounces ------------------------------------------------------------------ */

typedef struct ylm_radiosity
    ylm_radiosity; /* E0, E and what leaves; written by one thread at a time */

typedef struct ylm_radiosity_stats {
  int bounces; /* that were summed */
  bool closed; /* the rest was added as a geometric series */
  double
      residual; /* change by the last bounce, relative to the light that bounced, by area and L1; with closure, about
                      that which one more would bring */
  double shrink; /* q, that change over the one before */
  double emitted[3], absorbed[3],
      escaped[3];      /* W: direct light that lands on elements; what they keep; what
                                                 leaves the scene. emitted = absorbed + escaped but for
                                                 the noise of links and the residual */
  double balance;      /* |emitted - absorbed - escaped| / emitted, the largest of the channels */
  uint64_t rays;       /* of direct light */
  size_t guides;       /* clusters of elements by which these were guided; 0: by none */
  uint64_t guide_rays; /* of the guides' pilot, beside `rays` */
  double
      close; /* the part of direct light that rays to lamps bring from nearer than twice the spacing */
  double direct_seconds, solve_seconds;
} ylm_radiosity_stats;

YLM_API ylm_status ylm_radiosity_create(const ylm_transfer *t, ylm_radiosity **r);
YLM_API void ylm_radiosity_free(ylm_radiosity *r);
YLM_API const ylm_transfer *ylm_radiosity_transfer(const ylm_radiosity *r);

/*
** ylm_radiosity_rays - direct light on the elements of a scene by rays to its lamps and sky, light_samples from
** each element. `scene` is the transfer's, or another of the same meshes with other lamps. `guides`: a pilot learns which lamps
** and tiles of the sky elements see (ylm_scene_guide); rays of ylm_radiosity_lightmap and ylm_radiosity_places follow it too,
** where their lamps are as many. Noise is averaged over neighbours that see each other, where an element has places of its rays to
** tell it (light_samples from 16 on); shadows keep their edges.
**
** ylm_radiosity_field - direct light from coefficients of degree <= lmax. Of a field of lights E0 = T0 . L with L at the
** elements' centres and T0 of ylm_transfer_escape, lmax at most that of T0: it knows no shadow of what is nearer than a
** light and takes what is behind one for an occluder. Of a field that holds shadows E0 = A . L, A
** the cosine. L is that half a spacing off the surface.
**
** ylm_radiosity_set - direct light that is given, irradiance E0 [elements][3], W m^-2.
**
** Returns  YLM_OK; YLM_ERANGE, YLM_EINVAL (no transfer vectors; another geometry), YLM_ENOMEM, YLM_ECANCELLED (stage
**          "direct"), what the field returns. The radiosity then is as it was
*/
YLM_API ylm_status ylm_radiosity_rays(ylm_radiosity *r, const ylm_scene *scene, int light_samples,
                                      bool guides, uint64_t seed, int threads,
                                      const ylm_progress *progress, ylm_error *e);
YLM_API ylm_status ylm_radiosity_field(ylm_radiosity *r, const ylm_field *field, int lmax,
                                       int threads, const ylm_progress *progress, ylm_error *e);
YLM_API void ylm_radiosity_set(ylm_radiosity *r, const float *E0);

/*
** ylm_radiosity_solve - all bounces of the direct light.
**
**   bounces   in  reflections after direct light; negative: until the residual is reached,
**                 which is not looked for below 1e-6
**   residual  in  the change at which the series ends, relative to the light that bounced, > 0
**   closure   in  of negative bounces: the rest, the geometric series of the last change, is added
**
** Returns  YLM_OK; YLM_EDOMAIN (all bounces do not converge: the albedo is 1 and nothing escapes), YLM_ENOMEM,
**          YLM_ECANCELLED (stage "bounces")
*/
YLM_API ylm_status ylm_radiosity_solve(ylm_radiosity *r, int bounces, double residual, bool closure,
                                       int threads, const ylm_progress *progress,
                                       ylm_radiosity_stats *stats, ylm_error *e);
/*
** ylm_radiosity_coarse - how far elements are from fine enough: the last solution again, its radiance constant on groups of
** up to four elements, which are those of twice the spacing. No ray is traced. The error of elements falls about in
** proportion to the spacing; what the groups change is then the error that the elements leave. Triangles that are not cut
** stay whole.
**
**   bounces, residual, closure  in   those of ylm_radiosity_solve
**   into    out  the coarse solution, a radiosity of the same transfer, or NULL
**   change  out  root mean square over elements, in luminance, over the mean of the light that bounces
**
** Returns  YLM_OK; YLM_EINVAL (`into` of another transfer), YLM_ERANGE, YLM_EDOMAIN, YLM_ENOMEM
** Cost     that of the solution
*/
YLM_API ylm_status ylm_radiosity_coarse(const ylm_radiosity *r, int bounces, double residual,
                                        bool closure, int threads, ylm_radiosity *into,
                                        double *change, ylm_error *e);

/*
** ylm_radiosity_averaged - ylm_radiosity_leaving with the noise of links averaged over neighbours, for places that see elements from
** near: of others, means over many elements are the same. After ylm_radiosity_rays with more than one place of each; else as it is.
**
**   leaving  out  [elements + 1][4], until the next solution
**
** Returns  YLM_OK, YLM_ENOMEM. Bits are the same for any number of threads
*/
YLM_API ylm_status ylm_radiosity_averaged(ylm_radiosity *r, int threads, const float **leaving);

/*
** ylm_radiosity_noise - a sample of the noise that rays of direct light leave in ylm_radiosity_leaving.
**
** It is the difference of places of an element, averaged over neighbours as light is, and what bounces of that: of mean 0 and the variance
** of the light. Its rays are those of ylm_radiosity_rays.
**
**   leaving  out  [elements + 1][4] valid until light is found anew; NULL: light was not found by rays, or from one place each
**
** Returns  YLM_OK, YLM_ENOMEM
*/
YLM_API ylm_status ylm_radiosity_noise(ylm_radiosity *r, int threads, const float **leaving);

/* Of the last solution; valid until the next. [elements + 1][4], the fourth number of a row and the last row are
   zero: direct irradiance, irradiance W m^-2, and radiance that leaves, W sr^-1 m^-2: rho E / pi. */
YLM_API const float *ylm_radiosity_direct(const ylm_radiosity *r);
YLM_API const float *ylm_radiosity_irradiance(const ylm_radiosity *r);
YLM_API const float *ylm_radiosity_leaving(const ylm_radiosity *r);
YLM_API void ylm_radiosity_look(const ylm_radiosity *r, ylm_radiosity_stats *stats);

/* Writes the elements as triangles of a PLY file, each with its irradiance and that of direct light. */
YLM_API ylm_status ylm_radiosity_write_ply(const ylm_radiosity *r, const char *path, ylm_error *e);

/* A picture of the irradiance of one mesh, by its texture coordinates. */
typedef struct ylm_radiosity_map {
  size_t mesh;
  bool back;                /* of its back */
  const float *uvs;         /* [vertices of the mesh][2]: u to the right, v upwards, 0 .. 1 */
  int width, height;        /* 1 .. 16384 */
  bool indirect;            /* with the light that elements send */
  const ylm_scene *scene;   /* direct light by rays to the lamps of this scene, or NULL */
  const ylm_field *field;   /* direct light by coefficients of degree <= lmax, or NULL */
  int lmax;                 /* of it, as ylm_radiosity_field takes both */
  int links, light_samples; /* of a texel */
  /* Of ylm_radiosity_places, out [n][3 axes][3 channels]: radiance times direction, over directions above the surface, so
     that its product with the normal is the irradiance; W m^-2. Not of `field`. NULL: not wanted. */
  float (*flow)[3][3];
  int gutter; /* 0 .. 64: how many texels beside the mesh take the mean of their neighbours */
  uint64_t seed;
  int threads;
  const ylm_progress *progress; /* stage "lightmap" */
} ylm_radiosity_map;

/*
** ylm_radiosity_lightmap - irradiance at the middles of texels: light that links bring, and direct light.
**
**   out       in/out  [height][width][3]  W m^-2, row 0 is the top; texels that are not on the mesh stay
**   coverage  out     [height][width]     1 where the middle of the texel is on the mesh, and not inside of a body
**   overlaps  out     how many texels more than one triangle has
**
** Returns  YLM_OK; YLM_ERANGE, YLM_EINVAL, YLM_ENOMEM, YLM_ECANCELLED, what the field returns
*/
YLM_API ylm_status ylm_radiosity_lightmap(const ylm_radiosity *r, const ylm_radiosity_map *m,
                                          float *out, float *coverage, size_t *overlaps,
                                          ylm_error *e);

/*
** ylm_radiosity_places - irradiance at n places of surfaces, as ylm_radiosity_lightmap finds it at texels. Of `m` the mesh,
** its side, texture coordinates, size and gutter are not looked at.
**
**   stream  in   [n]     the number of each place's random numbers
**   out     out  [n][3]  W m^-2
**   share   out  [n]     the part of a place's rays that does not begin inside of a body
**
** Returns  YLM_OK; YLM_ERANGE, YLM_EINVAL, YLM_ENOMEM, YLM_ECANCELLED (stage "lightmap"), what the field returns
*/
YLM_API ylm_status ylm_radiosity_places(const ylm_radiosity *r, const ylm_radiosity_map *m,
                                        size_t n, const ylm_scene_place *place,
                                        const uint64_t *stream, float (*out)[3], float *share,
                                        ylm_error *e);

/* -- the gathered field --------------------------------------------------------- */

/* Cells along an edge of the cube of directions. */
#define YLM_GATHER_LEAST 4
#define YLM_GATHER_MOST 64

typedef enum ylm_gather_parts {
  YLM_GATHER_INDIRECT = 1, /* what surfaces send back          */
  YLM_GATHER_DIRECT = 2,   /* lamps and sky, with shadows      */
  YLM_GATHER_ALL = 3
} ylm_gather_parts;

typedef enum ylm_gather_derivatives {
  YLM_GATHER_CELLS, /* borders of cells move with the nearer surface: gradient and Hessian */
  YLM_GATHER_POINTS /* hit points move, less the mean radiance: gradient; Hessian by cells  */
} ylm_gather_derivatives;

typedef struct ylm_gather_form {
  int base;   /* cells along an edge of the cube of directions, YLM_GATHER_LEAST .. _MOST */
  int levels; /* of splitting 4 x 4, 0 .. 2                                            */
  double
      contrast; /* splits where radiance differs from a neighbour's by more than this part of the mean */
  double spacing; /* the least distance that counts in derivatives; 0: the elements' spacing */
  ylm_gather_parts parts;
  ylm_gather_derivatives derivatives;
  double
      tolerance; /* of shadow rays of direct light: groups are looked at closer until they matter less than an eighth of it */
  bool
      remember; /* keep each point's cells: the field asked again there, after another solution, traces shadow rays alone */
  uint64_t seed;
  const ylm_scene *lamps; /* whose lamps and sky give direct light; NULL: the transfer's scene */
} ylm_gather_form;

typedef struct ylm_gather_stats {
  uint64_t points, rays, shadow_rays;
  uint64_t invalid; /* points that see more of sides that are not used than of others */
  size_t bytes;     /* that are remembered */
} ylm_gather_stats;

typedef struct ylm_gather ylm_gather; /* a light field of a radiosity */

/* base 16, levels 2, contrast 0.2, indirect light, gradients by points. */
YLM_API ylm_gather_form ylm_gather_defaults(void);
/* YLM_OK; YLM_ERANGE, YLM_ENOMEM */
YLM_API ylm_status ylm_gather_create(const ylm_radiosity *r, const ylm_gather_form *form,
                                     ylm_gather **g, ylm_error *e);
YLM_API void ylm_gather_free(ylm_gather *g);
/* Direct light becomes that of another scene's lamps, of the same meshes. YLM_OK; YLM_ENOMEM: it
   then is as it was. */
YLM_API ylm_status ylm_gather_lamps(ylm_gather *g, const ylm_scene *lamps, ylm_error *e);
/* Lives as long as the gather; `inside` is 1 at points that are not valid. Up to degree YLM_TRANSFER_LMAX. */
YLM_API const ylm_field *ylm_gather_field(const ylm_gather *g);
/* validity [n]: 1 less the share of directions that see sides that are not used; below 0.5 the point is in a body. */
YLM_API ylm_status ylm_gather_validity(const ylm_gather *g, size_t n, const float (*point)[3],
                                       int threads, float *validity, ylm_error *e);
/*
** ylm_gather_noise - how exactly the field knows the light: its values with `base` cells against twice as many.
**
**   point     in   [n][3]
**   quantile  out  the 95 % quantile of the errors, each relative to the norm there, or
**                  to the mean norm over the points where that is more
*/
YLM_API ylm_status ylm_gather_noise(const ylm_gather *g, size_t n, const float (*point)[3],
                                    int lmax, int threads, const ylm_progress *progress,
                                    double *quantile, ylm_error *e);
/* Directions of length 1 of the rays that the field sends from a point: how many; direction [room][3] has the first. 0
   where memory runs out. */
YLM_API size_t ylm_gather_directions(const ylm_gather *g, const float point[3], size_t room,
                                     float (*direction)[3]);
YLM_API void ylm_gather_look(const ylm_gather *g, ylm_gather_stats *stats);

/* -- walls: reach.c ----------------------------------------------------------------- */

/* A scene's surfaces as bakes of grids with sides ask for them (ylm_grid_walls). */
typedef struct ylm_walls ylm_walls;
/* `transfer` knows which sides of surfaces are used; NULL: all are. Both must outlive the walls. YLM_OK; YLM_ENOMEM */
YLM_API ylm_status ylm_walls_create(const ylm_scene *scene, const ylm_transfer *transfer,
                                    ylm_walls **walls);
YLM_API void ylm_walls_free(ylm_walls *w);
YLM_API ylm_grid_walls ylm_walls_look(const ylm_walls *w);
/* ylm_grid_walls.share, whose self is a ylm_scene: all that look-ups need. */
YLM_API void ylm_walls_share(const void *scene, size_t n, const float (*a)[3], const float (*b)[3],
                             float *share);

/* -- distant light ---------------------------------------------------------------- */

/* Numbers in a row of transfer vectors: 3 (lmax+1)^2 rounded up to a multiple of 4. The transfer has vectors of
   direct light. */
YLM_API size_t ylm_transfer_width(const ylm_transfer *t);

/*
** ylm_transfer_vectors - transfer vectors of the elements with bounces, of light that is the same everywhere.
**
**   T = T0 + 1/K sum over links of rho T,   in three channels: ylm_transfer_escape solved as light is
**
** The product of T and the coefficients of distant light is irradiance. Light from nearby lamps differs from place to
** place: an element is then lit by light that is not there. ylm_radiosity_solve is right for both.
**
**   bounces, residual, closure  in   as ylm_radiosity_solve
**   stats                       out  bounces, closed, residual, shrink, solve_seconds; or NULL
**   out                         out  [elements + 1][ylm_transfer_width], a row [3][(lmax+1)^2], the last zero
**
** Returns  YLM_OK; YLM_EINVAL (no vectors of direct light), YLM_ERANGE, YLM_EDOMAIN (as ylm_radiosity_solve), YLM_ENOMEM,
**          YLM_ECANCELLED (stage "bounces"). Cost  as ylm_transfer_sum, a third of it where no albedo is coloured
** Source   Sloan et al. 2002, "Precomputed Radiance Transfer"; Green 2003
*/
YLM_API ylm_status ylm_transfer_vectors(const ylm_transfer *t, int bounces, double residual,
                                        bool closure, int threads, const ylm_progress *progress,
                                        ylm_radiosity_stats *stats, float *out, ylm_error *e);

/*
** ylm_transfer_vectors_at - transfer vectors of n other places: T0 + 1/links sum over links of rho T.
**
** Rays of a place find T0 and links together, so what T0 does not see is seen by a link.
**
**   vectors                  in   of the elements, with one bounce less than the places get; NULL: T0 alone
**   origin, normal, stream,  in   as ylm_transfer_find
**   links, seed
**   out                      out  [n][3][(lmax+1)^2]
**
** Returns  YLM_OK; YLM_EINVAL, YLM_ERANGE, YLM_ENOMEM, YLM_ECANCELLED (stage "links")
*/
YLM_API ylm_status ylm_transfer_vectors_at(const ylm_transfer *t, const float *vectors, size_t n,
                                           const float (*origin)[3], const float (*normal)[3],
                                           const uint64_t *stream, int links, uint64_t seed,
                                           int threads, const ylm_progress *progress, float *out,
                                           ylm_error *e);

/*
** ylm_transfer_vectors_of - transfer vectors of the vertices of a mesh: means of those of the elements around them, by
** area, of the front where it has elements, else of the back. Nothing is traced.
**
**   vectors  in   of the elements
**   mesh     in   its place in the scene
**   out      out  [vertices][3][(lmax+1)^2]; zeros where no element is
**
** Returns  YLM_OK; YLM_ENOMEM
*/
YLM_API ylm_status ylm_transfer_vectors_of(const ylm_transfer *t, const float *vectors, size_t mesh,
                                           float *out);

/*
** ylm_transfer_matrices - matrices from distant light to the light that arrives at n places.
**
**   M_ij = integral over the hemisphere about the normal of Y_i(w) x (escape: Y_j(w); an element: rho/pi T_j)
**
** found by rays that are even over it. M L are coefficients of incident radiance, which is 0 below the horizon.
**
**   vectors  in   as ylm_transfer_vectors_at; NULL: light that comes straight
**   rays     in   of a place, 1 .. YLM_SCENE_SAMPLES
**   lmax_in  in   at most that of the transfer;   lmax_out  in  0 .. YLM_TRANSFER_LMAX
**   out      out  [n][3][(lmax_out+1)^2][(lmax_in+1)^2]
**
** Returns  YLM_OK; YLM_EINVAL, YLM_ERANGE, YLM_ENOMEM, YLM_ECANCELLED (stage "matrices")
** Cost     a place: rays, and rays (lmax_out+1)^2 (1 or 3) (lmax_in+1)^2 products
** Source   Sloan et al. 2002; Lehtinen & Kautz 2003, "Matrix Radiance Transfer"; Green 2003
*/
YLM_API ylm_status ylm_transfer_matrices(const ylm_transfer *t, const float *vectors, size_t n,
                                         const float (*origin)[3], const float (*normal)[3],
                                         const uint64_t *stream, int rays, uint64_t seed,
                                         int lmax_in, int lmax_out, int threads,
                                         const ylm_progress *progress, float *out, ylm_error *e);

#ifdef __cplusplus
}
#endif
#endif
