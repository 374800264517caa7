/* random.c - PCG32 (O'Neill 2014, "PCG: A Family of Simple Fast Space-Efficient
   Statistically Good Algorithms for Random Number Generation"). */
#include "ylm_base.h"

void ylm_rng_seed(ylm_rng *r, uint64_t seed, uint64_t stream) {
  r->state = 0;
  r->stream = stream * 2 + 1;
  ylm_rng_u32(r);
  r->state += seed;
  ylm_rng_u32(r);
}

uint32_t ylm_rng_u32(ylm_rng *r) {
  uint64_t s = r->state;
  r->state = s * 6364136223846793005u + r->stream;
  uint32_t x = (uint32_t)(((s >> 18) ^ s) >> 27), turn = (uint32_t)(s >> 59);
  return x >> turn | x << (-turn & 31);
}

double ylm_rng_double(ylm_rng *r) {
  uint64_t hi = ylm_rng_u32(r), lo = ylm_rng_u32(r);
  return (double)((hi << 32 | lo) >> 11) * 0x1p-53;
}
