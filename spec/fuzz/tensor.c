/* tensor.c - fuzzes the reader of tensor files, and what RGL's tables answer: no negative numbers. */
#include "../../csrc/material/kind.h"
#include "../../csrc/material/rgl.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Asks for f, samples and densities of a few directions. */
static void ask(const ylm_material *m) {
  static const float some[4][3] = {
      {0, 0, 1}, {0.6f, -0.79f, 0.1f}, {-0.8f, 0.1f, 0.6f}, {0.05f, 0.02f, 0.99f}};
  static const float u[4][3] = {
      {0, 0, 0}, {0.999f, 0.999f, 0.999f}, {0.3f, 0.7f, 0.5f}, {0.5f, 0.01f, 0.2f}};
  float f[4][3], wi[4][3], weight[4][3], pdf[4];
  for (int i = 0; i < 4; i++) {
    const float wo[4][3] = {{some[i][0], some[i][1], some[i][2]}, {0, 0, 1}, {0, 1, 0}, {0, 0, -1}};
    ylm__material_rgl.eval(m, 4, some, wo, f);
    ylm__material_rgl.pdf(m, 4, some, wo, pdf);
    ylm__material_rgl.sample(m, 4, some, u, wi, weight, pdf);
    for (int k = 0; k < 4; k++)
      for (int c = 0; c < 3; c++)
        if (!(f[k][c] >= 0 && weight[k][c] >= 0 && pdf[k] >= 0)) __builtin_trap();
  }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  ylm_error e;
  rgl_table *t;
  ylm_material m = {.x = {30}};
  if (ylm__rgl_read(data, size, "fuzz", m.x[0], &t, &m.bytes, &e) != YLM_OK) return 0;
  m.table = t;
  ask(&m);
  ylm_free(t);
  return 0;
}
