/* random.c - PCG32 (O'Neill 2014, "PCG: A Family of Simple Fast Space-Efficient
   Statistically Good Algorithms for Random Number Generation"). */
#include "ylm_random.h"

void ylm_rng_seed(ylm_rng *r, uint64_t seed, uint64_t stream) { ylm_draw_seed(r, seed, stream); }
uint32_t ylm_rng_u32(ylm_rng *r) { return ylm_draw_u32(r); }
double ylm_rng_double(ylm_rng *r) { return ylm_draw_double(r); }
