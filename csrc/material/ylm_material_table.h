/*
** ylm_material_table.h - materials as tables of spherical harmonics: what surfaces that gloss are shaded by.
**
** The slice of an eye is f wi.z over directions wi. A table holds the coefficients of slices at rows of
** elevation, of anisotropic materials at columns of azimuth too, in the frame of the eye: z the normal,
** x in the plane of normal and eye. Slices of isotropic materials are symmetric there, and coefficients of
** m < 0 are zero.
**
** The three channels are mixtures of few functions: of one where a material is grey, of two where
** Fresnel's term alone is coloured. A table holds these functions, and how they are mixed.
**
** Threads     a table is immutable once made
*/
#ifndef YLM_MATERIAL_TABLE_H
#define YLM_MATERIAL_TABLE_H

#include "ylm_material.h"

#ifdef __cplusplus
extern "C" {
#endif

#define YLM_MATERIAL_TABLE_LMAX 60
#define YLM_MATERIAL_TABLE_FIT_LMAX 8 /* of fits */
#define YLM_MATERIAL_TABLE_ROWS 256   /* the most rows, and columns */

/* A slice is f wi.z; f alone; or a fit B of degree lmax. B makes the integral of (wi.z (B - f))^2
   over directions above the surface least, with a ridge of 1e-4 of each diagonal element. Below the
   surface B is arbitrary: it is worth something times the clamped cosine alone. */
typedef enum ylm_material_table_slice {
  YLM_MATERIAL_TABLE_COSINE,
  YLM_MATERIAL_TABLE_BARE,
  YLM_MATERIAL_TABLE_FIT
} ylm_material_table_slice;

typedef struct ylm_material_table_form {
  int lmax;    /* 0 .. YLM_MATERIAL_TABLE_LMAX */
  int rows;    /* from 0 to 89.5 degrees, 4 .. YLM_MATERIAL_TABLE_ROWS */
  int columns; /* of an anisotropic material, 4 .. YLM_MATERIAL_TABLE_ROWS; else there is one */
  double
      error; /* > 0: rows, then columns, are doubled until the error between them is at most this, or
                      there are as many as may be; 0: as many as are given */
  ylm_material_table_slice slice; /* FIT: lmax to YLM_MATERIAL_TABLE_FIT_LMAX */
  int threads;
  const ylm_progress *progress; /* stage "table" */
} ylm_material_table_form;

typedef struct ylm_material_table ylm_material_table;

typedef struct ylm_material_table_facts {
  int lmax, rows, columns;
  int functions; /* 1 .. 3 */
  size_t
      width; /* numbers in a row of a function: (lmax+1)(lmax+2)/2 of isotropic materials, else (lmax+1)^2 */
  bool halves; /* rows hold m >= 0 alone */
  double
      error; /* between rows and columns, relative to the slice, the largest: of eyes to 84 degrees, */
  double grazing; /* of the others */
  size_t bytes;
  double seconds;
} ylm_material_table_facts;

/*
** ylm_material_table_create - the table of a material.
**
** Slices are integrated about the mirror direction, by Gauss's rule from there to the horizon and evenly in
** azimuth; nodes are doubled until coefficients change by less than 1e-4 of the slice's norm, to at most
** 192 x 384. Of a material that is the same mirrored at x = 0 and at y = 0, as GGX is, a quarter of the columns is
** integrated.
**
** Returns  YLM_OK; YLM_ERANGE (a field of the form), YLM_ENOMEM, YLM_ECANCELLED
** Source   Kautz, Sloan, Snyder 2002, "Fast, Arbitrary BRDF Shading for Low-Frequency Lighting Using
**          Spherical Harmonics"; Catmull & Rom 1974 (between rows); docs/virtual.md "Gloss" (fits)
*/
YLM_API ylm_status ylm_material_table_create(const ylm_material *m,
                                             const ylm_material_table_form *form,
                                             ylm_material_table **table, ylm_error *e);
/* The table of a material and a degree, made at the first call and kept with the material. Its rows and columns, 32 and 64,
   are doubled to an error of 0.002: valid as long as it. Any number of threads at once. As ylm_material_table_create. */
YLM_API ylm_status ylm_material_table_kept(const ylm_material *m, int lmax, int threads,
                                           const ylm_progress *progress,
                                           const ylm_material_table **table, ylm_error *e);
/* As that, of any slices: FIT is what virtual lights send, BARE their receivers' zonal lobes. */
YLM_API ylm_status ylm_material_table_kept_as(const ylm_material *m, ylm_material_table_slice slice,
                                              int lmax, int threads, const ylm_progress *progress,
                                              const ylm_material_table **table, ylm_error *e);
/* The memory of the tables that are kept with a material. */
YLM_API size_t ylm_material_table_kept_bytes(const ylm_material *m);
YLM_API void ylm_material_table_free(ylm_material_table *table);
YLM_API void ylm_material_table_look(const ylm_material_table *table,
                                     ylm_material_table_facts *facts);

/*
** ylm_material_table_rows - slices of n eyes, cubic between rows and columns.
**
**   wo   in   [n][3]  of length 1, in the surface's frame; below the horizon: as at the last row
**   out  out  [n][functions][width], in the frame of each eye
*/
YLM_API void ylm_material_table_rows(const ylm_material_table *table, size_t n,
                                     const float (*wo)[3], float *out);
/* The slices of the three channels in the surface's frame: out [n][3][(lmax+1)^2]. YLM_ENOMEM */
YLM_API ylm_status ylm_material_table_slices(const ylm_material_table *table, size_t n,
                                             const float (*wo)[3], float *out);
/* How channels are made of functions: channel c = sum over k of mix[c][k] function k. */
YLM_API const float (*ylm_material_table_mix(const ylm_material_table *table))[3];
/* The part of the slice's norm that coefficients up to `lmax` miss, for n eyes; lmax at most the table's;
   error [n]. Of fits: the norm of wi.z (B - f) over that of f wi.z, whatever lmax is. */
YLM_API void ylm_material_table_missed(const ylm_material_table *table, int lmax, size_t n,
                                       const float (*wo)[3], float *error);

#ifdef __cplusplus
}
#endif
#endif
