/*
** calibration.h - the tuned constants of kernels on a device. Private to csrc/vulkan.
**
** `make bench-vulkan` prints the times of sums (spec/bench/vulkan_lights.lua), of bakes (vulkan_adaptive.lua) and of
** pictures (vulkan_image.lua) by stage. Numbers that a shader has too are in gen/layout.h, or beside its dispatch.
*/
#ifndef YLM_VULKAN_CALIBRATION_H
#define YLM_VULKAN_CALIBRATION_H

/* -- slices of work: device/run.c, device/memory.c, device/peak.c -------------------------------- */

/* Seconds that a submission should take: less than YLM_GPU_SLICE by what a rate may be wrong. */
#define GPU_SUBMISSION 0.005
/* Bytes that are taken from the driver at a time. */
#define GPU_BLOCK_BYTES ((VkDeviceSize)16 << 20)
/* The best of several runs counts, until these seconds have passed without a better one: other
   users of the device make a run slower, never faster. */
#define GPU_PEAK_SECONDS 0.25

/* -- sums over lights: light/ -------------------------------------------------------------------- */

/* Bytes of the device's memory for a pass of points, and those of partial sums. */
#define LIGHTS_PASS_BYTES ((uint64_t)96 << 20)
#define LIGHTS_PARTIAL_BYTES ((uint64_t)48 << 20)
/* Sums that an invocation keeps in registers: 255 of them hold these and what a light needs. */
#define SUM_BUDGET 144
/* Plans that are kept. */
#define PLANS_KEPT 8

/* -- grids: grid/ -------------------------------------------------------------------------------- */

/* Shading points of one dispatch. */
#define OCCUPIED_POINTS ((size_t)1 << 20)
/* Points whose keys are unpacked at a time, and packed at a time. */
#define OCTREE_KEYS ((size_t)1 << 16)
#define REMOTE_KEYS ((size_t)1 << 16)
/* Probes of a dispatch. */
#define POINTS_PROBES ((size_t)1 << 16)
/* Bytes of rows that are gathered or scattered at a time. */
#define POINTS_PACKED_BYTES ((uint64_t)32 << 20)
/* Bytes of the device's memory for a pass of points that are sampled or shaded. */
#define SAMPLE_PASS_BYTES ((uint64_t)64 << 20)

/* -- spherical harmonics, pictures: sh.c, picture/ ----------------------------------------------- */

/* Bytes of the device's memory for a pass of directions. */
#define SH_PASS_BYTES ((uint64_t)64 << 20)
/* Strips of an image whose samples are sorted on their own. */
#define PICTURE_STRIPS 16

#endif
