/* phong.h - Phong's lobe about the mirror direction, as its kernels want it. Private to
   csrc/material. */
#ifndef YLM_MATERIAL_PHONG_H
#define YLM_MATERIAL_PHONG_H

typedef struct phong {
  float exponent;
  float lobe[3]; /* specular (n + 2) / (2 pi) */
  float base[3]; /* base / pi                 */
  float density; /* (n + 1) / (2 pi)          */
  float share;   /* of samples in the lobe    */
} phong;

#endif
