/* map.h - what the files of csrc/surface/map share. Private. */
#ifndef YLM_SURFACE_MAP_PRIVATE_H
#define YLM_SURFACE_MAP_PRIVATE_H

#include "../surface.h"
#include "ylm_surface_map.h"

#define MAP_NONE UINT32_MAX

/* -- calibration -------------------------------------------------------------------------------- */

/* Places of a texel along an axis. */
#define MAP_ALONG 2
/* The part of the texels that a pilot has, of which densities are learnt; and their limits, over the mean. */
#define MAP_PILOT 0.25
#define MAP_SPARSEST 0.1
#define MAP_DENSEST 16
/* The slope of the square error over the density, at least and at most. */
#define MAP_SLOPE_LEAST 0.7
#define MAP_SLOPE_MOST 4
/* Fine triangles: about so many squares of two cover all surfaces, at most so many lie along an edge. */
#define MAP_FINE 8192
#define MAP_FINE_MOST 48
/* A chart whose fine triangles make more charts than these is not cut: its triangles overlap. */
#define MAP_FINE_CHARTS 4
/* Charts are divided where that saves so many times the texels of the new borders; with this slope, so often at most, by so
   many lines an axis. */
#define MAP_DIVIDE_GAIN 1
#define MAP_DIVIDE_SLOPE 2.5
#define MAP_DIVIDE_DEPTH 10
#define MAP_DIVIDE_LINES 48
/* Texels of the first picture that is made for a tolerance, and by how much a next one has more. */
#define MAP_FIRST 16384
#define MAP_GROW_LEAST 1.5
#define MAP_GROW_MOST 4
#define MAP_ROUNDS 8
/* Weights of bends that are tried, over that of a place; half of the best is right for both halves. */
#define MAP_WEIGHTS 5
static const double map_weight[MAP_WEIGHTS] = {0.01, 0.3, 10, 300, 10000};
/* The one where none is chosen, and that of differences, which holds texels that nothing else does. */
#define MAP_WEIGHT 0.1
#define MAP_LEVEL 1e-4
/* Errors of a weight are summed over so many texels around one. */
#define MAP_AROUND 3
/* Weight of a seam's place, over that of a place of light; how many of a texel's length. */
#define MAP_SEAM 64
#define MAP_SEAM_ALONG 2
/* Its weight in the last fits, and what its sides may differ by there, over the larger of the light and the mean. */
#define MAP_PRESS 256
#define MAP_SLACK 0.01
/* Sides of an edge whose normals have at least this cosine are one smooth surface. */
#define MAP_SMOOTH 0.999
#define MAP_STEPS 250
#define MAP_SMALL 1e-10
/* Last fits, before which texels below 0 become dark, and seams are asked for what they miss. */
#define MAP_LIFTS 16
/* Places whose light a file gets at once. */
#define MAP_KEEP 65536
/* Places that judge, and their rays over those of other places. */
#define MAP_JUDGES 2048
#define MAP_JUDGE_RAYS 16
/* Of places whose errors are more than this part of the aim, so many times as many more, and how often, where no more than this
   part of the places misses the aim. */
#define MAP_NEAR 0.5
#define MAP_JUDGE_MORE 4
#define MAP_JUDGE_ROUNDS 3
#define MAP_CLOSE 0.05
/* Places around which less than this part is open are under bodies. */
#define MAP_FREE 0.97
/* The power by which misses fall with the number of texels; no further picture is made where the last left more than this part of
   the misses before it, and chance does not tell it. */
#define MAP_FALL 0.67
#define MAP_PAYS 0.8
/* Square errors count no more than that of this many aims. */
#define MAP_BOUND 2.2
/* Places around which light has more noise than this part of the aim are asked again, with so many times as many links where
   lamps shine, and shadow rays, or links where none do. */
#define MAP_NOISY 2
#define MAP_AGAIN 2
static const int map_again[MAP_AGAIN][2] = {{1, 4}, {4, 16}};
/* The part of them that may fail where another judge follows, and else. */
#define MAP_ENOUGH 0.004
#define MAP_ENOUGH_SURE 0.003

/* -- the map ------------------------------------------------------------------------------------ */

/* A side of a mesh that has light. Its triangles are cut into fine ones, alike along each edge. */
typedef struct map_sheet {
  uint32_t mesh;
  bool back;
  size_t triangles, fine;
  uint8_t *parts;  /* [triangles] of an edge: n cuts a triangle into n^2 */
  uint32_t *first; /* [triangles + 1] fine triangles before those of one */
  uint32_t *of;    /* [fine] the triangle that one is of */
} map_sheet;

struct ylm_surface_map {
  const ylm_scene *scene;
  surface_charts plane; /* of judges */
  map_sheet *sheet;
  size_t sheets;
  uint32_t *of; /* [meshes][2] the sheet of a front and a back, or MAP_NONE */
  ylm_unwrap *charts;
  double *error;  /* [charts] */
  float *picture; /* [height][width][3] */
  float *flow;    /* [3 axes][height][width][3] or NULL */
  ylm_surface_map_stats stats;
};

/* Where four texels are read: numbers of the picture, and weights. */
typedef struct map_tap {
  uint32_t texel[4];
  float weight[4];
} map_tap;

/* sheets.c: the sheets of a scene, and their charts, of triangles that are not cut. */
ylm_status ylm__map_sheets(ylm_surface_map *m, const ylm_radiosity *r,
                           const ylm_surface_map_form *form, ylm_error *e);
/* sheets.c: new charts of the fine triangles; label: as ylm_unwrap_form has it. */
ylm_status ylm__map_unwrap(ylm_surface_map *m, const ylm_surface_map_form *form,
                           const uint32_t *label, ylm_error *e);
/* fine.c: counts the fine triangles of a sheet, by parts. YLM_ENOMEM. */
ylm_status ylm__map_count(map_sheet *s);
/* fine.c: the fine triangle of a place of a sheet's triangle, its u and v as the sheet has them; then those on the fine one. */
size_t ylm__map_fine(const map_sheet *s, size_t triangle, double *u, double *v);
/* fine.c: the triangle of a place of a fine one, and the place. */
size_t ylm__map_whole(const map_sheet *s, size_t fine, double *u, double *v);
/* fine.c: the vertices of the fine triangles beyond the mesh's: their number; triangle, and steps along both edges of each, or
   NULL; index [fine][3], or NULL. */
size_t ylm__map_lattice(const ylm_surface_map *m, const map_sheet *s, size_t vertices,
                        uint32_t (*at)[3], uint32_t *index);
/* A sheet as triangles with texture coordinates. */
typedef struct map_split {
  size_t vertices, triangles;
  uint32_t *index;   /* [triangles][3] */
  float *uv;         /* [vertices][2] */
  ylm_mesh_mix *mix; /* [vertices] of the mesh's */
} map_split;

/* merge.c: joins the fine triangles of a split that has all of them. YLM_ENOMEM. */
ylm_status ylm__map_merge(const ylm_surface_map *m, size_t sheet, const ylm_mesh *mesh,
                          map_split *split);
/* divide.c: cuts triangles of large charts into fine ones, so that charts can be divided. */
ylm_status ylm__map_refine(ylm_surface_map *m, const ylm_surface_map_form *form, ylm_error *e);
/* sheets.c: a corner of a scene's triangle as its sheet has it, and back. */
static inline int map_corner(bool back, int corner) { return back && corner ? 3 - corner : corner; }
/* sheets.c: where a place of a sheet is read. False: it has no chart. */
bool ylm__map_tap(const ylm_surface_map *m, const ylm_scene_place *p, map_tap *tap);
/* sheets.c: the chart of a place, or YLM_UNWRAP_NONE. */
uint32_t ylm__map_chart(const ylm_surface_map *m, const ylm_scene_place *p);
/* sheets.c: where coordinates in texels are read. */
void ylm__map_tap_at(const ylm_surface_map *m, const double at[2], map_tap *tap);
/* sheets.c: that of a picture of this size. */
void ylm__map_tap_of(size_t width, size_t height, const double at[2], map_tap *tap);

/* -- the bake ------------------------------------------------------------------------------------ */

typedef struct map_site {
  ylm_scene_place place;
  uint32_t chart;
  map_tap tap;
  surface_light light;
  bool open; /* in no body */
  bool read; /* from texels */
  /* One over the square of the light around, the mean of the channels. */
  float weight;
} map_site;

static inline bool map_counts(const map_site *s) { return s->open && s->read; }

/* A place of a seam: eight texels, those of its second side with negative weights. */
typedef struct map_seam {
  uint32_t texel[8];
  float weight[8];
  float at[2][2]; /* of both sides in texels */
  float finer[2]; /* how many levels of mip maps a side is finer than the denser one, at most 0 */
} map_seam;

/*
** The sum of squares of rows as a matrix of a picture: `pair` joins a texel to itself, the next, and the three below. `line` are
** the weights of bends along a row and a column at 1, 0 where a chart ends there.
*/
typedef struct map_matrix {
  float *pair;  /* [5][texels] */
  float *line;  /* [2][texels] */
  float *scale; /* [texels] mean weights of rows that read a texel */
} map_matrix;

/* A file that a bake goes on from. */
typedef struct map_journal {
  int file;
  bool open, reads; /* it may have more parts */
  uint64_t sum;     /* of all bytes before */
} map_journal;

/* Bytes that a bake has found. */
typedef struct map_part {
  void *data;
  size_t size;
} map_part;

typedef struct map_bake {
  ylm_surface_map *m;
  const ylm_radiosity *r;
  const ylm_surface_map_form *form;
  ylm_error *e;
  double aim;
  size_t charts;
  double *density, *square, *slope; /* [charts]; square errors, how they fall with the density */
  map_site *site;
  size_t sites, site_room;
  bool last;           /* the picture is one that is kept */
  float (*flow)[3][3]; /* [sites] or NULL */
  uint64_t asked;      /* random numbers used */
  map_journal journal;
  double mean[3];
  /* The picture. */
  size_t width, height, texels;
  uint32_t *chart; /* [texels] or YLM_UNWRAP_NONE */
  map_seam *seam;
  size_t seams, seam_room;
  map_matrix matrix;
  float *bend;  /* [texels] weights of bends */
  float *value; /* [2][3][texels] of the halves of all places' rays */
} map_bake;

/* packing.c: lays charts out for at most so many texels, and finds the taps of sites. */
ylm_status ylm__map_pack(map_bake *b, size_t texels);
/* packing.c: finds where a site is read; one that rounding has brought to a texel beside its chart is read from within. */
void ylm__map_find_tap(const map_bake *b, map_site *s);
/* packing.c: taps of a chart alone; false: there are none. */
bool ylm__map_keep_in(const map_bake *b, uint32_t chart, map_tap *tap);
/* sites.c: places spread over the texels as they are packed, and their light. */
ylm_status ylm__map_sample(map_bake *b);
/* sites.c: the light of places, in two halves, and whether they are open; more: times the links and the shadow rays, as far as
   they may; flow [n] of all rays, or NULL. */
ylm_status ylm__map_ask(map_bake *b, size_t n, const ylm_scene_place *place, const int more[2],
                        surface_light *light, bool *open, float (*flow)[3][3]);
/* seams.c: places of edges between charts. */
ylm_status ylm__map_seams(map_bake *b);
/* seams.c: the largest jumps of the picture across them, at the first levels of mip maps. */
ylm_status ylm__map_jumps(const map_bake *b, double jump[YLM_SURFACE_MAP_LEVELS]);

/* matrix.c: the matrix of all sites and seams; matrix.c: frees it. */
ylm_status ylm__map_matrix(map_bake *b);
void ylm__map_matrix_free(map_matrix *a);
/* fit.c: texels of both halves, from those in `value` on. */
ylm_status ylm__map_fit(const map_bake *b, float *value);
/* fit.c: fits again: texels are dark where the mean of the halves was below 0, and seams agree. */
ylm_status ylm__map_lift(const map_bake *b, float *value);
/* picture.c: the fitted texels as halves, and those beside charts. */
ylm_status ylm__map_draw(map_bake *b);
/* smooth.c: weights of bends, texel by texel, by halves that judge each other. */
ylm_status ylm__map_smooth(map_bake *b);
/* smooth.c: x [texels] becomes its sums over the texels of its chart around each; room [texels]. */
void ylm__map_sum_around(const map_bake *b, float *x, float *room);

/* density.c: the products of what the halves miss at each site [sites]; square errors of charts from these, without noise;
   densities for a picture. */
void ylm__map_products(const map_bake *b, double *product);
ylm_status ylm__map_square(const map_bake *b, const double *product, double *square);
/* density.c: adds values [sites] and their weights to the texels that sites read, and the mean of such sums at a site; 0: it does
   not count. */
void ylm__map_sum(const map_bake *b, const double *values, float *sum, float *count);
double ylm__map_mean_at(const map_site *s, const float *sum, const float *count);
/* density.c: products become means around their sites, which count no more than some aims: a place that misses a tolerance is
   one, by however much it does. */
ylm_status ylm__map_bound(const map_bake *b, double *product);
void ylm__map_spread(map_bake *b);
/* density.c: how square errors fall with the density, from those at half of it. */
void ylm__map_slopes(map_bake *b, const double *coarse);

/* divide.c: divides charts where parts of them miss more than others, by products of sites as they were packed last but one, and
   last (coarse, or NULL), for a picture of so many texels; what charts have is found anew. */
ylm_status ylm__map_divide(map_bake *b, size_t texels, const double *product, const double *coarse);
/* journal.c: opens the file that the form names, if it names one. YLM_EIO, YLM_EBUSY, YLM_EFORMAT, YLM_EINVAL (of another bake). */
ylm_status ylm__map_journal_open(map_bake *b);
void ylm__map_journal_close(map_bake *b);
/* journal.c: the next parts, as an earlier bake has found them; *had: it has. */
ylm_status ylm__map_recall(map_bake *b, size_t n, const map_part *part, bool *had);
/* journal.c: keeps parts that were found. */
ylm_status ylm__map_remember(map_bake *b, size_t n, const map_part *part);
/* judge.c: compares the picture with the light of fresh places. */
ylm_status ylm__map_judge(map_bake *b, uint64_t round);
/* judge.c: whether so few of them fail that no further picture is made; else how many times the texels one would take. */
bool ylm__map_is_enough(const map_bake *b);
double ylm__map_growth(const map_bake *b);
/* bake.c: room for what charts have. */
ylm_status ylm__map_begin(map_bake *b);

/* The light of a half of a fit at a site. */
static inline double map_value(const map_bake *b, const float *value, int half, const map_site *s,
                               int c) {
  const float *of = value + (size_t)(3 * half + c) * b->texels;
  double sum = 0;
  for (int k = 0; k < 4; k++) sum += (double)(s->tap.weight[k] * of[s->tap.texel[k]]);
  return sum;
}

#endif
