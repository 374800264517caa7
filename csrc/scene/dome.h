/* dome.h - light that fills the sky, as tiles that rays are aimed at. Private to csrc/scene. */
#ifndef YLM_SCENE_DOME_H
#define YLM_SCENE_DOME_H

#include <stdatomic.h>

#include "ylm_light_emitter.h"

/* The numbers behind weights of lights of the sky: luminous power over pi, its mean direction times that,
   and the largest distance of a direction from that mean, times power too. */
typedef struct scene_sky_bound {
  double power, mean[3], spread;
} scene_sky_bound;

/* The pixels of a panorama, or of a table of what has none, in tiles: each is a light. Uniform domes
   have no pixels and are one light. */
typedef struct scene_dome {
  atomic_uint *references; /* to its arrays, which scenes share that differ in other lamps */
  ylm_light_dome light;
  ylm_mapping mapping;
  ylm_up up;
  int width, height;
  size_t across, down, lights; /* tiles; lights = across*down, or 1 */
  size_t cells[2];             /* parts of tiles, across and down, of which guides know; 0: none */
  scene_sky_bound *bound;      /* [lights] */
  float *share;                /* [height][width] of the luminous power of a pixel's tile */
  float *keep;                 /* [height][width] the alias table of each tile: how often its own */
  uint32_t *other;             /* pixel is meant, and which one else, counted in the tile */
  uint32_t *holder[2];         /* [width], [height] of columns and rows of pixels those of cells */
} scene_dome;

/* To be freed in any case; YLM_ENOMEM. */
ylm_status ylm__scene_dome_create(scene_dome *d, const ylm_light_dome *light);
void ylm__scene_dome_free(scene_dome *d);
/* One more owner of a dome, for another scene; to be freed too. */
void ylm__scene_dome_share(const scene_dome *from, scene_dome *d);
/* A pixel of a tile that is not dark, for u of 0 .. 1; *rest: what u is within it. */
size_t ylm__scene_dome_pixel(const scene_dome *d, size_t tile, double u, double *rest);
/* The tile of a pixel, and its cell. */
size_t ylm__scene_dome_tile(const scene_dome *d, size_t pixel);
size_t ylm__scene_dome_cell(const scene_dome *d, size_t pixel);
/* DOME_LOOKS pixels of a tile that are not dark, for u of 0 .. 1, each as ylm__scene_dome_pixel would find it; and their cells. */
void ylm__scene_dome_looks(const scene_dome *d, size_t tile, double u, size_t *pixel, double *rest,
                           size_t *cell);
/* The radiance from direction d of length 1, which falls into that pixel. */
void ylm__scene_dome_radiance(const scene_dome *d, size_t pixel, const double direction[3],
                              double rgb[3]);

#endif
