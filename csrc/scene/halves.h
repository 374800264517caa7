/* halves.h - floats of half a vector as doubles of a whole one; for kernels (*.isa.c). */
#ifndef YLM_SCENE_HALVES_H
#define YLM_SCENE_HALVES_H

#include "ylm_simd.h"

typedef float half __attribute__((vector_size(YLM_VECTOR_BYTES / 2)));

YLM_INLINE ylm_vd widen(const float *p) {
  half h;
  memcpy(&h, p, sizeof h);
  return __builtin_convertvector(h, ylm_vd);
}

#endif
