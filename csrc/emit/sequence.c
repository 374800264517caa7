/* sequence.c - the numbers that particles set out with: Roberts' sequence R_d, which fills five
   dimensions evenly from its first elements on. */
#include "emit.h"

/* The root above 1 of x^(d+1) = x + 1. */
static double root(int d) {
  double x = 1.5;
  for (int k = 0; k < 64; k++) x = pow(1 + x, 1.0 / (d + 1));
  return x;
}

void ylm__emit_sequence(uint64_t seed, emit_sequence *s) {
  double x = root(EMIT_NUMBERS), step = 1;
  ylm_rng rng;
  ylm_rng_seed(&rng, seed, ~(uint64_t)0);
  for (int k = 0; k < EMIT_NUMBERS; k++) {
    step /= x;
    s->step[k] = (uint64_t)ldexp(step, 64);
    s->start[k] = (uint64_t)ylm_rng_u32(&rng) << 32;
    s->start[k] |= ylm_rng_u32(&rng);
  }
}

void ylm__emit_numbers(const emit_sequence *s, uint64_t i, double u[EMIT_NUMBERS]) {
  for (int k = 0; k < EMIT_NUMBERS; k++)
    u[k] = (double)((s->start[k] + i * s->step[k]) >> 11) * 0x1p-53;
}
