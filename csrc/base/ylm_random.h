/* ylm_random.h - the random numbers of ylm_rng without a call, for loops that draw a few at each place. Private. */
#ifndef YLM_RANDOM_H
#define YLM_RANDOM_H

#include "ylm_base.h"

/* As ylm_rng_u32. */
static inline uint32_t ylm_draw_u32(ylm_rng *r) {
  uint64_t s = r->state;
  r->state = s * 6364136223846793005u + r->stream;
  uint32_t x = (uint32_t)(((s >> 18) ^ s) >> 27), turn = (uint32_t)(s >> 59);
  return x >> turn | x << (-turn & 31);
}

/* As ylm_rng_double. */
static inline double ylm_draw_double(ylm_rng *r) {
  uint64_t high = ylm_draw_u32(r), low = ylm_draw_u32(r);
  return (double)((high << 32 | low) >> 11) * 0x1p-53;
}

/* As ylm_rng_seed. */
static inline void ylm_draw_seed(ylm_rng *r, uint64_t seed, uint64_t stream) {
  r->state = 0;
  r->stream = stream * 2 + 1;
  ylm_draw_u32(r);
  r->state += seed;
  ylm_draw_u32(r);
}

#endif
