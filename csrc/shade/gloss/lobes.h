/* lobes.h - links of points that gloss: by rays that their materials choose. Private. */
#ifndef YLM_SHADE_LOBES_H
#define YLM_SHADE_LOBES_H

#include "../view.h"
#include "ylm_transfer_targets.h"

/* Whether the material at point i glosses. */
static inline bool ylm__shade_glosses(const ylm_shade_view *v, size_t i) {
  return ylm_material_glosses(ylm__shade_material(v, i));
}

/* Whether rays to lamps find the light that point i reflects to the eye: matte, or a lobe that is not narrow; no vertex. */
bool ylm__shade_is_soft(const ylm_shade_view *v, size_t i);
/* The surface at point i, its second tangent y, and the direction wo to the eye in the frame of these; `vertex` as
   ylm__shade_surface has it. */
void ylm__shade_frame(const ylm_shade_view *v, const uint32_t *vertex, size_t i,
                      ylm_scene_surface *s, float y[3], float wo[3]);

/* Links with weights, f cos over the density of their rays, of n points: out[i] is the mean over links k from start[i]
   on, start[i+1] - start[i] of them, of weight times the radiance that leaves the element of k. */
typedef struct shade_lobes {
  size_t *start;    /* [n+1] */
  uint32_t *link;   /* [start[n]] */
  uint16_t *weight; /* [3][links] of each point, from 3 start[i] on, in parts of `most` / 65535 */
  float *most;      /* [n]: the largest weight */
} shade_lobes;

/* Fills the lobes of points, whose starts are known; stream [points of the view]: the number of each one's random
   numbers; most: the largest number of links of a point; targets: what half of the links of points that are soft are aimed
   by, or NULL. YLM_ENOMEM, YLM_ECANCELLED. lobes.c */
ylm_status ylm__shade_lobes(const ylm_shade_view *v, const ylm_transfer *t,
                            const ylm_transfer_targets *targets, size_t n, const uint32_t *point,
                            const uint64_t *stream, size_t most, uint64_t seed, int threads,
                            const ylm_progress *progress, const shade_lobes *out);
/* out [3] is the sum of weight times radiance over links of point i, divided by the number of all
   of its links. `parity` picks the links whose numbers have an even (0) or odd (1) sum of bits, or
   all (-1). */
void ylm__shade_lobe(const shade_lobes *x, size_t i, const float *leaving, int parity,
                     double out[3]);

#endif
