/* lamp.h - a sphere light as a row of numbers, for kernels that read light by light (ylm_light.h, ylm_light).
   Private to csrc/light. */
#ifndef YLM_LIGHT_LAMP_H
#define YLM_LIGHT_LAMP_H

typedef struct ylm__lamp_f {
  float at[3], radius, luminance, rgb[3];
} ylm__lamp_f;
typedef struct ylm__lamp_d {
  double at[3], radius, luminance, rgb[3];
} ylm__lamp_d;

#endif
