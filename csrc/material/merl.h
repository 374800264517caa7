/*
** merl.h - isotropic reflectance in MERL's bins (Matusik et al. 2003). Private to csrc/material.
**
** Bins belong to the half vector's angle from the normal, theta_h, and to the angles of the light's
** direction about it, theta_d and phi_d (Rusinkiewicz 1998). In 90 x 90 x 180 of them phi_d goes half
** around, since exchanged directions have phi_d + pi: such tables are reciprocal.
*/
#ifndef YLM_MATERIAL_MERL_H
#define YLM_MATERIAL_MERL_H

#include "calibration.h"
#include "kernels.h"
#include "lobe.h"
#include "ylm_material.h"

/* The fuzzer mutates a whole file, so its files have few bins. */
#ifdef FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION
#define MERL_THETA_H 3
#define MERL_THETA_D 3
#define MERL_PHI_D 4
#else
#define MERL_THETA_H YLM_MERL_THETA_H
#define MERL_THETA_D YLM_MERL_THETA_D
#define MERL_PHI_D YLM_MERL_PHI_D
#endif

/* A bin: f in sr^-1, and 1; or f of the nearest measured bin of smaller theta_d, and 0: missing. */
typedef float merl_bin[4];

typedef struct merl_table {
  int phis;      /* MERL_PHI_D, or twice as many: all around */
  bool linear;   /* between the centres of bins */
  lobe lobe;     /* to sample by */
  merl_bin *bin; /* [MERL_THETA_H][MERL_THETA_D][phis], aligned as vectors are */
} merl_table;

/* Places among the bins, in bins from the border of the first. */
typedef struct merl_places {
  float theta_h[MERL_BLOCK], theta_d[MERL_BLOCK], phi_d[MERL_BLOCK];
} merl_places;

/* Places of n pairs of directions, n at most MERL_BLOCK, among `phis` bins around. */
typedef void merl_places_fn(int phis, size_t n, const float (*wi)[3], const float (*wo)[3],
                            merl_places *out);
merl_places_fn *ylm__merl_places(void);

/* eval, sample and pdf, asked with a merl_table. */
const material_kernels *ylm__merl_kernels(void);

/* A table without any bin filled; *held: its bytes. NULL where memory runs out; ylm_free frees it. */
merl_table *ylm__merl_new(int phis, size_t *held);

/* Completes a table whose bins are filled: the missing ones, and the lobe. */
void ylm__merl_complete(merl_table *t);

/* Bytes of a file before its numbers; sr^-1 of a number 1 in each plane. */
#define MERL_HEADER 12
extern const double ylm__merl_scale[3];

/* The table of a file's bytes. YLM_OK; YLM_EFORMAT naming what is wrong with the file, YLM_ENOMEM. */
ylm_status ylm__merl_read(const unsigned char *bytes, size_t size, const char *name, merl_table **t,
                          size_t *held, ylm_error *e);

/* As kind.h has them, of materials with such a table. */
void ylm__merl_facts(const ylm_material *m, ylm_material_fact *fact, void *to);
bool ylm__merl_isotropic(const ylm_material *m);

#endif
