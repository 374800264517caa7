/*
** rotate.isa.c - rotation kernels: one vector by z-turns between quarter turns, batches by blocks.
*/
#include "ylm_sh.h"

#include "rotate.h"
#include "ylm_simd.h"

/* Rows of J at a time: two sums each and some registers to spare. */
#if YLM_VECTOR_BYTES == 64
#define ROTATE_PANEL 8
#else
#define ROTATE_PANEL 4
#endif

#define T float
#define V ylm_vf
#define LANES YLM_VF
#define FULL 16
#define FN(name) name##_f
#define PACKED packed_f
#define PANELS panels_f
#define SET ylm_vf_set
#define LOAD ylm_vf_load
#define STORE ylm_vf_store
#include "rotate_kernel.h"

#include "rotate_batch.h"

#undef T
#undef V
#undef LANES
#undef FULL
#undef FN
#undef PACKED
#undef PANELS
#undef SET
#undef LOAD
#undef STORE
#define T double
#define V ylm_vd
#define LANES YLM_VD
#define FULL 8
#define FN(name) name##_d
#define PACKED packed_d
#define PANELS panels_d
#define SET ylm_vd_set
#define LOAD ylm_vd_load
#define STORE ylm_vd_store
#include "rotate_kernel.h"

#include "rotate_batch.h"

const ylm__rotate_kernels YLM_KERNEL(ylm__rotate_kernels) = {one_f, one_d, apply_f, apply_d,
                                                             ROTATE_PANEL};
