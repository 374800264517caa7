/* transfer.h - what the files of csrc/transfer share. Private. */
#ifndef YLM_TRANSFER_PRIVATE_H
#define YLM_TRANSFER_PRIVATE_H

#include "cuts.h"
#include "ylm_sh.h"
#include "ylm_transfer_targets.h"
#include "ylm_vector.h"

/* Bits of the sides of a mesh that reflect. */
enum { TRANSFER_FRONT = 1, TRANSFER_BACK = 2 };

/* The first element of a triangle's side that has none. */
#define TRANSFER_NONE UINT32_MAX

/* How finely a triangle is cut at best. */
#define TRANSFER_CUT 65535

struct ylm_transfer {
  const ylm_scene *scene;
  ylm_transfer_form form;
  ylm_transfer_stats stats;
  size_t meshes, triangles;
  size_t *first;        /* [meshes + 1] of its triangles */
  uint8_t *side;        /* [meshes] bits; 0: the mesh does not occlude */
  uint8_t *ground;      /* [triangles] 1: of a ground; NULL: there is none */
  double ground_share;  /* the part of its area that counts */
  transfer_cut *cut;    /* [triangles] of a side */
  float *foot;          /* [triangles] transfer_shape */
  uint32_t (*start)[2]; /* [triangles] the first element of front and back, or TRANSFER_NONE */
  size_t elements;
  float (*centre)[3], (*normal)[3], *area, (*albedo)[3]; /* [elements] */
  uint32_t *mesh, *triangle;                             /* [elements] the latter in its mesh */
  float *share;     /* [elements] the part of it that is not inside of a body; 0: dead */
  uint8_t *crossed; /* [elements] a wall parts it: its light is that of its middle's side */
  ylm_links link;   /* [elements][links] */
  float *escape;    /* [elements][(lmax+1)^2] or NULL */
};

/* -- places.c ------------------------------------------------------------------- */

/* The places of elements that have light. */
typedef struct transfer_places {
  ylm_scene_places of;
  uint32_t *element; /* [of.n] */
  float (*room)[3];
} transfer_places;

/* In a scene of the same meshes; to be freed in any case. */
ylm_status ylm__transfer_places(const ylm_transfer *t, const ylm_scene *scene, transfer_places *p);
void ylm__transfer_places_free(transfer_places *p);

/* -- smooth.c ------------------------------------------------------------------- */

/* Groups of elements that see each other. To be freed in any case. */
typedef struct transfer_neighbours transfer_neighbours;
ylm_status ylm__transfer_neighbours_create(const ylm_transfer *t, const transfer_places *p,
                                           int threads, transfer_neighbours **out);
void ylm__transfer_neighbours_free(transfer_neighbours *g);
/* Averages the noise of E0 [elements][4] over neighbours, and `apart` [elements][4] or NULL, a sample of it, as that; `variance`
   [elements]: of its luminance. */
ylm_status ylm__transfer_smooth(const ylm_transfer *t, const transfer_neighbours *of,
                                const float *variance, float *E0, float *apart, int threads);

/* Whether there are any. */
bool ylm__transfer_has_groups(const transfer_neighbours *g);
/* E [elements][4] becomes the irradiance of a solution with the noise of links averaged over its neighbours. */
ylm_status ylm__transfer_average(const ylm_radiosity *r, int threads, float *E);

/* Luminances of n radiances [n][4], 0 at least. */
static inline void ylm__transfer_luminances(size_t n, const float *L, float *out) {
  for (size_t e = 0; e < n; e++, L += 4)
    out[e] = fmaxf(0, (float)ylm_luminance((double[]){(double)L[0], (double)L[1], (double)L[2]}));
}

/* -- closed.c ------------------------------------------------------------------- */

/*
** Whether every edge of a mesh is passed as often in one direction as in the other; ends are the same
** where their positions are, bit for bit. `volume`: what it encloses, negative where its front is inside.
*/
ylm_status ylm__transfer_closed(const ylm_scene *scene, size_t mesh, const float *positions,
                                bool *closed, double *volume);

/* -- sides.c -------------------------------------------------------------------- */

/* Fills t->side and the statistics of closed meshes. `positions`: those of all vertices. */
ylm_status ylm__transfer_sides(ylm_transfer *t, const ylm_transfer_form *form,
                               const float *positions);

/* -- elements.c ----------------------------------------------------------------- */

/* Cuts the surfaces: everything but links. */
ylm_status ylm__transfer_cut(ylm_transfer *t, const ylm_transfer_form *form, ylm_error *e);
/* As ylm__transfer_cut where t->side, t->cut, t->share and the statistics are known; YLM_EFORMAT, and nothing made,
   unless these cuts are the spacing's and there are so many elements then. */
ylm_status ylm__transfer_cut_again(ylm_transfer *t, size_t elements);
/* Where element i lies: its triangle's place, and the weights (u, v) of its three corners. */
void ylm__transfer_corners(const ylm_transfer *t, size_t i, ylm_scene_place *place,
                           float corner[3][2]);
/* Gives `place` the point of these corners that (x, y) of the unit square is folded to. */
static inline void ylm__transfer_inside(float corner[3][2], double x, double y,
                                        ylm_scene_place *place) {
  float u = (float)(x + y > 1 ? 1 - x : x), v = (float)(x + y > 1 ? 1 - y : y);
  place->u = corner[0][0] + u * (corner[1][0] - corner[0][0]) + v * (corner[2][0] - corner[0][0]);
  place->v = corner[0][1] + u * (corner[1][1] - corner[0][1]) + v * (corner[2][1] - corner[0][1]);
}
static inline bool ylm__transfer_is_back(const ylm_transfer *t, size_t i) {
  const uint32_t *start = t->start[t->first[t->mesh[i]] + t->triangle[i]];
  return start[1] != TRANSFER_NONE && i >= start[1];
}

/* -- crossed.c ------------------------------------------------------------------ */

/* How far above an element places see each other past what ends closely above it. */
float ylm__transfer_lift(const ylm_transfer *t, size_t e);
/* Fills t->crossed, of elements that are known. */
ylm_status ylm__transfer_cross(ylm_transfer *t, const ylm_progress *progress);
/* Brings a place of element e to the side of its middle. */
void ylm__transfer_hold(const ylm_transfer *t, size_t e, ylm_scene_place *place);
/* The element whose light a place of the crossed element e has; t->elements: none. */
uint32_t ylm__transfer_own(const ylm_transfer *t, uint32_t e, const ylm_scene_place *place);

/* -- links.c -------------------------------------------------------------------- */

/* Fills t->link, t->escape, t->share, and what the statistics say of rays. */
ylm_status ylm__transfer_link(ylm_transfer *t, const ylm_progress *progress, ylm_error *e);

/* Whether links take two bytes where there are so many elements, whose number is that of nothing. */
static inline bool ylm__links_are_short(size_t elements) { return elements <= UINT16_MAX; }
/* Writes n links from number k on. */
void ylm__links_put(ylm_links l, size_t k, size_t n, const uint32_t *from);

/* Directions of a place, which all places share but for a turn and a shift: Hammersley's set. */
typedef struct transfer_fan {
  int rays;
  float (*disk)[2], *height; /* [rays] cos and sin of the azimuth; k / rays */
} transfer_fan;

/* To be freed in any case. */
ylm_status ylm__transfer_fan_create(int rays, transfer_fan *f);
void ylm__transfer_fan_free(transfer_fan *f);
/* Rays [rays] to infinity without origins: dense as the cosine about n, or even over the sphere (NULL). */
void ylm__transfer_fan_aim(const transfer_fan *f, const float *n, ylm_rng *rng, ylm_trace_ray *ray);

/* The light of links along the axes, as ylm_radiosity_map has it. */
typedef struct transfer_flow {
  const float *leaving; /* [elements + 1][4] radiance */
  float (*out)[3][3];   /* [n] */
} transfer_flow;

/* As ylm_transfer_find, of arguments that are good; share [n]: the part of each place's rays that does not begin
   inside of a body; flow: of places with normals, or NULL. */
ylm_status ylm__transfer_find_shares(const ylm_transfer *t, size_t n, const float (*origin)[3],
                                     const float (*normal)[3], const uint64_t *stream, int links,
                                     uint64_t seed, int threads, const ylm_progress *progress,
                                     ylm_links out, int lmax, float *escape, float *share,
                                     const transfer_flow *flow);
/* YLM_ERANGE unless there can be so many links. */
ylm_status ylm__transfer_check_links(int links, ylm_error *e);
/* YLM_EDOMAIN, YLM_ERANGE unless rays can start there; normals, or NULL, are 1 long at most. */
ylm_status ylm__transfer_check_places(size_t n, const char *what, const float (*place)[3],
                                      const float (*normal)[3], ylm_error *e);

/* -- targets.c ------------------------------------------------------------------ */

/* As ylm_transfer_gather_targets; share [n], flow: as ylm__transfer_find_shares has them, or NULL. */
ylm_status ylm__transfer_gather(const ylm_transfer_targets *a, const float *leaving, size_t n,
                                const float (*origin)[3], const float (*normal)[3],
                                const uint64_t *stream, int links, uint64_t seed, int threads,
                                const ylm_progress *progress, float (*mean)[4], float *share,
                                const transfer_flow *flow);

/* -- transfer.c ----------------------------------------------------------------- */

/* The memory that a transfer takes. */
size_t ylm__transfer_bytes(const ylm_transfer *t);

/* -- file.c --------------------------------------------------------------------- */

/* The positions, triangles and flags of all meshes, in 64 bits. */
ylm_status ylm__transfer_fingerprint(const ylm_scene *scene, uint64_t *print);
/* Whether two scenes have the same meshes. */
ylm_status ylm__transfer_same(const ylm_scene *a, const ylm_scene *b, bool *same);
/* Whether light_samples rays may go to the lamps of a scene: YLM_OK; YLM_ERANGE, YLM_EINVAL (other meshes), YLM_ENOMEM. direct.c */
ylm_status ylm__transfer_check_rays(const ylm_transfer *t, const ylm_scene *scene,
                                    int light_samples, ylm_error *e);

/* -- sum.c ---------------------------------------------------------------------- */

/* As ylm_transfer_sum, of n places. */
typedef void ylm_transfer_sum_fn(size_t n, int links, ylm_links link, int width, const float *in,
                                 const float *start, float *out);
/* The kernel of the instruction set in use. */
ylm_transfer_sum_fn *ylm__transfer_sum(void);

/* -- outer.c -------------------------------------------------------------------- */

/* m[o][k] += sum over i < n of left[i][o] right[i][k]: left [n][rows], right [n][width], m [rows][width], width a
   multiple of 4. */
typedef void ylm_transfer_outer_fn(size_t n, size_t rows, size_t width, const float *left,
                                   const float *right, float *m);
/* The kernel of the instruction set in use. */
ylm_transfer_outer_fn *ylm__transfer_outer(void);

/* -- vectors.c ------------------------------------------------------------------ */

/* [elements + 1][width] scale times albedo times the vectors; NULL without memory. To be freed. */
float *ylm__transfer_reflected(const ylm_transfer *t, const float *vectors, double scale);

/* -- direct.c ------------------------------------------------------------------- */

/* Where light that jumps at surfaces is asked for, for n places on them: half a spacing off them. */
void ylm__transfer_off(const ylm_transfer *t, size_t n, const float (*place)[3],
                       const float (*normal)[3], float (*out)[3]);

/* -- boxes.c: boxes and triangles ------------------------------------------------------------- */

struct transfer_boxes;
/* The triangles of a scene that occlude. To be freed in any case. */
ylm_status ylm__boxes_create(const ylm_scene *s, struct transfer_boxes **b);
void ylm__boxes_free(struct transfer_boxes *b);
/* Whether a box (min, max) meets any of them. */
bool ylm__boxes_meet(const struct transfer_boxes *b, const double box[6]);

/* -- coarse.c ------------------------------------------------------------------- */

/* Groups of the elements of a triangle's side, at most four in one: the elements of a cut half as fine. */
typedef struct transfer_groups {
  uint32_t *of; /* [elements] the number of the group */
  size_t count;
  double (*sum)[4]; /* [count] for ylm__transfer_level */
} transfer_groups;

ylm_status ylm__transfer_group(const ylm_transfer *t, transfer_groups *g);
/* Gives each row of B [elements][4] the mean of its group, by area. */
void ylm__transfer_level(const ylm_transfer *t, const transfer_groups *g, float *B);
void ylm__transfer_ungroup(transfer_groups *g);

/* -- solve.c -------------------------------------------------------------------- */

struct ylm_radiosity {
  const ylm_transfer *t;
  float *E0; /* of the next solution, [elements + 1][4] as all others */
  float *direct, *E, *leaving;
  float *
      averaged; /* `leaving` with the noise of links averaged over neighbours; NULL: not asked for */
  float *apart;  /* a sample of E0's noise; NULL: not known */
  float *noise;  /* as it leaves behind bounces; NULL: not known yet */
  uint64_t rays; /* of E0 */
  double close, seconds;
  ylm_scene_guide *guide;          /* of the rays of E0; NULL: they had none */
  transfer_neighbours *neighbours; /* over which its noise is averaged; NULL: not known yet */
  struct ylm_transfer_targets
      *targets;       /* of leaving, where it is to be gathered by rays that are aimed; or NULL */
  bool guided, aimed; /* E0 may have guides; targets were looked for */
  double q[3];        /* of the last solution, by channel: stats.shrink is the largest */
  ylm_radiosity_stats stats;
};

#endif
