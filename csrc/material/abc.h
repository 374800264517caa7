/*
** abc.h - the ABC microfacet model, as its kernels want it. Private to csrc/material.
**
**   f = scale (kd / pi + F S G / (pi wi.z wo.z)),   S = a / (1 + b (1 - m.z))^c,
**   G = min(1, 2 m.z wi.z / (wi.m), 2 m.z wo.z / (wi.m)),   F of unpolarised light on a dielectric
**
** Sources  Loew, Kronander, Ynnerman & Unger 2012, "BRDF Models for Accurate and Efficient Rendering
**          of Glossy Surfaces"
*/
#ifndef YLM_MATERIAL_ABC_H
#define YLM_MATERIAL_ABC_H

typedef struct abc {
  float kd[3]; /* scale kd / pi */
  float a[3];  /* scale a / pi  */
  float b, c, ior;
  float alpha, share; /* samples: visible normals of GGX of that roughness, and their share */
} abc;

#endif
