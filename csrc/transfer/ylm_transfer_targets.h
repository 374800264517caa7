/*
** ylm_transfer_targets.h - which elements send light to which places, for rays that are aimed at them.
*/
#ifndef YLM_TRANSFER_TARGETS_H
#define YLM_TRANSFER_TARGETS_H

#include "ylm_transfer.h"

#ifdef __cplusplus
extern "C" {
#endif

/*
** Places that lie close together and face the same way are a cluster; elements, where they send light, are groups. Rays of some
** places of each cluster, a pilot, say how much light each group sends there. Rays are then aimed at a group as often as it does,
** and at an element of it by the light that leaves that. They count beside rays that go as the cosine, or as a material chooses,
** by the balance heuristic: each has the density of both, so that means stay those of the links, whatever the pilot met.
**
**   Source  Veach & Guibas 1995, "Optimally Combining Sampling Techniques for Monte Carlo Rendering"; Mueller et al. 2017,
**           "Practical Path Guiding for Efficient Light-Transport Simulation" (learning from pilots)
*/
typedef struct ylm_transfer_targets ylm_transfer_targets;

typedef struct ylm_transfer_targets_stats {
  size_t clusters, groups;
  uint64_t rays; /* of the pilot */
  double seconds;
} ylm_transfer_targets_stats;

/*
** ylm_transfer_targets_create - learns what sends light to places as these.
**
**   leaving  in   [elements + 1][4] radiance, as ylm_radiosity_leaving
**   out      out  must not outlive the transfer; NULL where no light was found
**
** Returns  YLM_OK; YLM_ENOMEM, YLM_ECANCELLED (progress stage "targets"). Bits are the same for any number of threads
*/
YLM_API ylm_status ylm_transfer_targets_create(const ylm_transfer *t, const float *leaving,
                                               const ylm_scene_places *places, uint64_t seed,
                                               int threads, const ylm_progress *progress,
                                               ylm_transfer_targets **out);
YLM_API void ylm_transfer_targets_free(ylm_transfer_targets *a);
YLM_API void ylm_transfer_targets_look(const ylm_transfer_targets *a,
                                       ylm_transfer_targets_stats *stats);

/* The cluster of a place. */
YLM_API size_t ylm_transfer_targets_at(const ylm_transfer_targets *a, const float x[3],
                                       const float normal[3]);
/* The element [1] and the point of it [3] that u [3], from 0 below 1, chooses for places of a cluster: false: no element sends
   light there. */
YLM_API bool ylm_transfer_target(const ylm_transfer_targets *a, size_t cluster, const double u[3],
                                 uint32_t *element, float point[3]);
/* How often the direction of a ray, of length 1, is chosen for places of a cluster, where it hits element e: sr^-1. */
YLM_API double ylm_transfer_target_density(const ylm_transfer_targets *a, size_t cluster,
                                           uint32_t e, const ylm_trace_ray *ray,
                                           const ylm_trace_hit *hit);

/*
** ylm_transfer_gather_targets - the mean radiance of links that go as the cosine, half of which are aimed.
**
**   links  in   of a place, an even number
**   mean   out  [n][4]: pi times it is the irradiance that elements send
**
** Returns  YLM_OK; YLM_ERANGE (links), YLM_ENOMEM, YLM_ECANCELLED
*/
YLM_API ylm_status ylm_transfer_gather_targets(const ylm_transfer_targets *a, const float *leaving,
                                               size_t n, const float (*origin)[3],
                                               const float (*normal)[3], const uint64_t *stream,
                                               int links, uint64_t seed, int threads,
                                               const ylm_progress *progress, float (*mean)[4]);

/*
** ylm_radiosity_aim - lets ylm_radiosity_places and lightmaps of a solution aim half of their links, by what its elements learn, and
** gather ylm_radiosity_averaged.
**
** Until the next solution; a second call does nothing. Nothing changes where rays of the direct light had no guides
** (ylm_radiosity_rays), nor where links that go as the cosine have little noise.
**
** Returns  as ylm_transfer_targets_create
*/
YLM_API ylm_status ylm_radiosity_aim(ylm_radiosity *r, int threads, const ylm_progress *progress);

#ifdef __cplusplus
}
#endif
#endif
