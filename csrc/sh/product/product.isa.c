/* product.isa.c - kernels of products: quadrature for one and for batches, straight-line sums of
 * low degree. */
#include "product.h"
#include "ylm_simd.h"

#define T float
#define V ylm_vf
#define LANES YLM_VF
#define FULL 16
#define FN(name) name##_f
#define TABLES f
#define SET ylm_vf_set
#define LOAD ylm_vf_load
#define STORE ylm_vf_store
#include "product_kernel.h"

#include "product_batch.h"
#include "transfer_kernel.h"

#undef T
#undef V
#undef LANES
#undef FULL
#undef FN
#undef TABLES
#undef SET
#undef LOAD
#undef STORE
#define T double
#define V ylm_vd
#define LANES YLM_VD
#define FULL 8
#define FN(name) name##_d
#define TABLES d
#define SET ylm_vd_set
#define LOAD ylm_vd_load
#define STORE ylm_vd_store
#include "product_kernel.h"

#include "product_batch.h"
#include "transfer_kernel.h"

const ylm__product_kernels YLM_KERNEL(ylm__product_kernels) = {
    dense_f,     dense_d,     separable_f, separable_d, batch_f, batch_d,
    gaunt_low_f, gaunt_low_d, transfer_f,  transfer_d,  YLM_VF,  YLM_VD};
