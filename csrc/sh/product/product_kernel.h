/*
** product_kernel.h - kernels of products, for the unit's element type: quadrature for one and for
** batches, straight-line sums of low degree, matrices of products.
*/
#include "product_batch.h"
#include "product_nodes.h"
#include "transfer_kernel.h"

#ifdef YLM_REAL_IS_FLOAT
typedef ylm__product_kernels_float product_kernels;
#else
typedef ylm__product_kernels_double product_kernels;
#endif

const product_kernels YLM_REAL_KERNEL(ylm__product_kernels) = {
    dense, separable, batch, gaunt_low, synthesise, analyse, transfer, LANES};
