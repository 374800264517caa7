/* lobes.h - links of points that gloss: by rays that their materials choose. Private. */
#ifndef YLM_SHADE_LOBES_H
#define YLM_SHADE_LOBES_H

#include "view.h"

/* Whether the material at point i is not matte; `matte` is that kind. */
static inline bool ylm__shade_glosses(const ylm_shade_view *v, int matte, size_t i) {
  return ylm_material_kind(ylm__shade_material(v, i)) != matte;
}

/* Links with weights, f cos over the density of their rays, of n points: out[i] = 1/links sum over k of weight times
   the radiance that leaves link k. */
typedef struct shade_lobes {
  uint32_t *link;   /* [n][links] */
  uint16_t *weight; /* [n][3][links], in parts of `most` / 65535 */
  float *most;      /* [n]: the largest weight */
} shade_lobes;

/* Fills the lobes of points `point`, in any order; stream [points of the view]: the number of each one's random numbers.
   YLM_ENOMEM, YLM_ECANCELLED. lobes.c */
ylm_status ylm__shade_lobes(const ylm_shade_view *v, const ylm_transfer *t, size_t n,
                            const uint32_t *point, const uint64_t *stream, int links, uint64_t seed,
                            int threads, const ylm_progress *progress, const shade_lobes *out);
/* The mean of weight times radiance over the links of number i of them that have the parity 0, 1, or both (-1): out
   [3], of all `links`. */
void ylm__shade_lobe(const shade_lobes *x, size_t i, int links, const float *leaving, int parity,
                     double out[3]);

#endif
