/* kind.h - what a kind of material is. Private to csrc/material. */
#ifndef YLM_MATERIAL_KIND_H
#define YLM_MATERIAL_KIND_H

#include <stdatomic.h>

#include "calibration.h"
#include "kernels.h"
#include "ylm_material.h"

struct ylm_material {
  atomic_size_t holders;
  int kind;
  float x[YLM_MATERIAL_NUMBERS];
  float albedo[3]; /* of light from everywhere alike                                         */
  float excess[MATERIAL_EYES]; /* ylm_material_excess at cosines (k + 1/2) / MATERIAL_EYES  */
  void *table;  /* what the kind makes of the numbers, or keeps of a file; NULL: nothing  */
  size_t bytes; /* its size, of which Lua's collector is told                             */
  uint64_t print;
  _Atomic(struct material_kept *) kept; /* table_kept.c */
};

/* table_kept.c */
void ylm__material_free_kept(ylm_material *m);

/* A kind's functions, which ylm_material.h describes; x: the numbers of a material. */
typedef struct material_kind {
  const char *name;
  size_t numbers; /* at most YLM_MATERIAL_NUMBERS */
  ylm_status (*check)(const float *x, ylm_error *e);

  /* Functions that make a table, once, of a material whose numbers are there; where one
     fails, `free` gets the table as it is left. `prepare`: of the numbers, NULL: nothing is made.
     `load`: of a file's bytes, which it does not keep; `name` stands in messages; NULL: the kind is
     of no file. `free` gives back a table, never NULL; NULL: ylm_free. */
  ylm_status (*prepare)(ylm_material *m, ylm_error *e);
  ylm_status (*load)(ylm_material *m, const unsigned char *bytes, size_t size, const char *name,
                     ylm_error *e);
  void (*free)(void *table);
  /* Of light from everywhere alike, the mean; NULL: by quadrature of `sample`. */
  void (*mean)(const ylm_material *m, float albedo[3]);
  /* The reflectance towards n directions; NULL: by quadrature of `sample`. */
  void (*reflectance)(const ylm_material *m, size_t n, const float (*wo)[3], float (*albedo)[3]);

  /* Of transfer vectors. All NULL: as a matte surface of the mean albedo, which shaders refuse. */
  ylm_status (*transfer)(int lmax, double *a);
  void (*radiance)(const float *x, size_t n, float *light);
  void (*reflect)(const float *x, const double irradiance[3], float radiance[3]);
  void (*row)(const float *x, float *row);

  /* Of a table: as ylm_material_facts. NULL: nothing. */
  void (*facts)(const ylm_material *m, ylm_material_fact *fact, void *to);

  bool (*isotropic)(const ylm_material *m);
  bool mirrored; /* f is the same of two directions as of both mirrored at x = 0, or at y = 0 */

  /* eval, sample, pdf: of kernels, of the table or else the numbers; NULL: as the next three have
     it. */
  const material_kernels *(*kernels)(void);
  void (*eval)(const ylm_material *m, size_t n, const float (*wi)[3], const float (*wo)[3],
               float (*f)[3]);
  void (*sample)(const ylm_material *m, size_t n, const float (*wo)[3], const float (*u)[3],
                 float (*wi)[3], float (*weight)[3], float *pdf);
  void (*pdf)(const ylm_material *m, size_t n, const float (*wi)[3], const float (*wo)[3],
              float *pdf);
} material_kind;

/* Each X(name) is a file name.c with ylm__material_name. */
#define MATERIAL_KINDS(X) X(matte) X(ggx) X(phong) X(abc) X(merl) X(rgl) X(tabulated)

#define X(name) extern const material_kind ylm__material_##name;
MATERIAL_KINDS(X)
#undef X

/* material.c */
bool ylm__material_mirrored(const ylm_material *m);

/* -- albedo.c: by quadrature of what a material samples -------------------------- */

/* The mean over directions; its error is about 5e-4. */
void ylm__material_mean(const ylm_material *m, float albedo[3]);
/* Fills m->excess, of a material that is complete otherwise. */
void ylm__material_fill_excess(ylm_material *m);
/* Towards n directions; the error is about 2e-4. */
void ylm__material_reflectance(const ylm_material *m, size_t n, const float (*wo)[3],
                               float (*albedo)[3]);

#endif
