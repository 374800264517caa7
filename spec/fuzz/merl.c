/*
** merl.c - fuzzes the reader of MERL's files, with 3 x 3 x 4 or 8 bins (merl.h).
**
** Mutations get the size of a file; one in sixteen goes through as it is. Accepted tables must answer
** finite numbers, whatever the directions.
*/
#include <math.h>
#include <string.h>

#include "../../csrc/material/merl.h"
#include "ylm_sets.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t room);

/* The kernels are not what is fuzzed: every set puts the directions at the same place. */
static float everywhere[3];
static void places(int phis, size_t n, merl_places *out) {
  for (size_t k = 0; k < n; k++) {
    out->theta_h[k] = MERL_THETA_H * everywhere[0];
    out->theta_d[k] = MERL_THETA_D * everywhere[1];
    out->phi_d[k] = (float)phis * everywhere[2];
  }
}
#define KERNEL(isa)                                                                                \
  merl_places_fn ylm_k_merl_places_##isa;                                                          \
  void ylm_k_merl_places_##isa(int phis, size_t n, const float(*wi)[3], const float(*wo)[3],       \
                               merl_places *out) {                                                 \
    (void)wi, (void)wo;                                                                            \
    places(phis, n, out);                                                                          \
  }
YLM_SETS(KERNEL)

#define BYTES (MERL_HEADER + 24 * (size_t)MERL_THETA_H * MERL_THETA_D * MERL_PHI_D)

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed) {
  size = LLVMFuzzerMutate(data, size, room);
  bool around = size > MERL_HEADER && data[8] + 256 * data[9] == 2 * MERL_PHI_D;
  size_t wanted = around ? 2 * BYTES - MERL_HEADER : BYTES;
  if (seed % 16 == 0 || wanted > room) return size;
  if (size < wanted) memset(data + size, 0, wanted - size);
  return wanted;
}

/* Asks for f, samples and densities at one place, by both interpolations. */
static void ask(merl_table *t, const float wo[1][3]) {
  float f[1][3], wi[1][3], weight[1][3], pdf[1], u[1][3];
  for (int linear = 0; linear < 2; linear++) {
    t->linear = linear;
    ylm__merl_kernels()->eval(t, 1, wo, wo, f);
    for (int a = 0; a < 3; a++) u[0][a] = everywhere[a] * 0.999f;
    ylm__merl_kernels()->sample(t, 1, wo, (const float(*)[3])u, wi, weight, pdf);
    for (int c = 0; c < 3; c++)
      if (!(f[0][c] >= 0 && f[0][c] <= 1e12f && weight[0][c] >= 0 && pdf[0] >= 0)) __builtin_trap();
  }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  ylm_error e;
  merl_table *t;
  size_t held;
  if (ylm__merl_read(data, size, "fuzz", &t, &held, &e) != YLM_OK) return 0;
  static const float wo[2][1][3] = {{{0, 0, 1}}, {{0.6f, -0.79f, 0.1f}}};
  for (int i = 0; i < 27; i++) {
    for (int a = 0, k = i; a < 3; a++, k /= 3) everywhere[a] = (float)(k % 3) / 2;
    ask(t, wo[i % 2]);
  }
  ylm_free(t);
  return 0;
}
