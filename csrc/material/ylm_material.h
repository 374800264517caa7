/*
** ylm_material.h - how surfaces reflect: kinds of materials, and what each does with light.
**
** A material is of a kind and is described by the kind's numbers. The kinds, each a file of its
** name:
**
** | kind  | numbers | unit | range  |                                                       |
** | ----- | ------- | ---- | ------ | ----------------------------------------------------- |
** | matte | [3]     | 1    | 0 .. 1 | reflected over incident flux, linear Rec. 709; the    |
** |       |         |      |        | same radiance in every direction (Lambertian)         |
** | ggx   | [2]     | 1    | 1e-3.. | alpha, roughness along the tangent and across it      |
** |       | [3]     | 1    | 0 .. 1 | f0, reflected along the normal                        |
** |       | [3]     | 1    | 0 .. 1 | base, the albedo below                                |
** |       | [1]     |      | 0, 1   | whether what is lost between microfacets comes back   |
** | phong | [1]     | 1    | 0..1e5 | exponent                                              |
** |       | [3] [3] | 1    | 0 .. 1 | specular, base; their sum at most 1                   |
** | abc   | [3] [3] | 1    | >= 0   | kd, a                                                 |
** |       | [4]     | 1    | >= 0   | b, c, ior (at least 1), scale                         |
** | merl  | [1]     |      | 0, 1   | interpolation: nearest, linear; besides: a MERL file  |
** | rgl   | [1]     | deg  | finite | turn about the normal; besides: an RGL file           |
**
** A tabulated material has no numbers but a table, f in MERL's bins ("files" below).
** A material knows nothing of scenes, meshes or rays.
**
** Ownership   materials are reference counted
** Threads     materials do not change: any number of threads may ask at once
*/
#ifndef YLM_MATERIAL_H
#define YLM_MATERIAL_H

#include "ylm_base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* -- kinds ------------------------------------------------------------------- */

/* How many kinds there are, counted from 0; their names, "?" of none; the kind of a name, -1: none. */
YLM_API int ylm_material_kinds(void);
YLM_API const char *ylm_material_kind_name(int kind);
YLM_API int ylm_material_kind_find(const char *name);

/* The highest degree of ylm_material_transfer. */
#define YLM_MATERIAL_LMAX 1000

/*
** ylm_material_transfer - what transfer vectors weigh light with, on surfaces of a kind.
**
** The vector has zonal coefficients a[l] about the normal n: A = sum over l, m of a[l] Y_lm(n)
** Y_lm(s). Light L from directions s, where it is not occluded, counts as the integral of A L. Of
** matte surfaces A is max(0, n.s), and the sum of a[l] L_lm Y_lm(n) their irradiance.
**
**   lmax  in   0 .. YLM_MATERIAL_LMAX
**   a     out  [lmax+1]   sr
**
** Returns  YLM_OK; YLM_ERANGE (lmax), YLM_EINVAL (no such kind)
** Accuracy 4e-16 relative (matte, lmax 20)
** Cost     O(lmax), no allocation, thread-safe
** Source   Ramamoorthi & Hanrahan 2001, "An Efficient Representation for Irradiance Environment
**          Maps", Eq. 7
*/
YLM_API ylm_status ylm_material_transfer(int kind, int lmax, double *a);
/* The clamped cosine's, for light whose directions are weighed by it alone. */
YLM_API ylm_status ylm_material_cosine(int lmax, double *a);

/* -- materials --------------------------------------------------------------- */

typedef struct ylm_material ylm_material;

/* The most numbers that describe a material. */
#define YLM_MATERIAL_NUMBERS 16

/* Whether n numbers describe a material of a kind. YLM_OK; YLM_EINVAL (no such kind, or another
   number of them), YLM_EDOMAIN naming what is out of range. O(n). */
YLM_API ylm_status ylm_material_check(int kind, size_t n, const float *numbers, ylm_error *e);
/* A material of a kind from the n numbers that describe it. YLM_OK; as ylm_material_check, or
   YLM_ENOMEM. Materials that gloss take a millisecond: their mean albedo is found. */
YLM_API ylm_status ylm_material_create(int kind, size_t n, const float *numbers, ylm_material **m,
                                       ylm_error *e);
/* A material of a kind that a file describes, from its bytes [size], not kept; `name` stands
   for the file in messages. As ylm_material_create, or YLM_EFORMAT naming what is wrong with it. */
YLM_API ylm_status ylm_material_load(int kind, size_t n, const float *numbers, const void *bytes,
                                     size_t size, const char *name, ylm_material **m, ylm_error *e);
/* Another hold of the material, to be freed once more. */
YLM_API const ylm_material *ylm_material_keep(const ylm_material *m);
YLM_API void ylm_material_free(const ylm_material *m);
YLM_API int ylm_material_kind(const ylm_material *m);
/* Whether its light differs from eye to eye: transfer vectors alone do not say what it reflects. */
YLM_API bool ylm_material_glosses(const ylm_material *m);
/* By how much more noise than of a matte surface rays that are dense as the cosine find what an eye sees of it under light from
   everywhere: the variance of pi f over its squared mean, channels added. 0: matte; above 1, lobes are so narrow that they should
   choose rays. cosine: of the eye's angle to the normal; the azimuth does not count. Within 10 % where it is below 10. */
YLM_API float ylm_material_excess(const ylm_material *m, float cosine);
/* A fingerprint of its kind, its numbers and the bytes of its file. */
YLM_API uint64_t ylm_material_print(const ylm_material *m);
/* The memory that it takes. */
YLM_API size_t ylm_material_bytes(const ylm_material *m);

/* Reflected over incident flux, where light comes from everywhere alike: the mean albedo. */
YLM_API void ylm_material_albedo(const ylm_material *m, float albedo[3]);

/* Transfer vectors know no direction to the eye: by the two functions that follow, surfaces that gloss
   are matte ones of their mean albedo. */

/* In place, products of n transfer vectors with light to the radiance that leaves: light [n][3]. */
YLM_API void ylm_material_radiance(const ylm_material *m, size_t n, float *light);

/* The radiance that leaves, from irradiance whose directions are not told apart. */
YLM_API void ylm_material_reflect(const ylm_material *m, const double irradiance[3],
                                  float radiance[3]);

/* -- light from a direction into a direction ---------------------------------- */

/* Directions have length 1 and stand in the surface's frame: x along its tangent, z its normal. wi
   points to where light comes from, wo to where it goes. None of these functions allocates. */

/* Whether a turn of both directions about the normal changes nothing. */
YLM_API bool ylm_material_isotropic(const ylm_material *m);

/* The bidirectional reflectance f, sr^-1, of n pairs of directions [n][3]; f out [n][3], 0 where
   one of the two is not above the surface. */
YLM_API void ylm_material_eval(const ylm_material *m, size_t n, const float (*wi)[3],
                               const float (*wo)[3], float (*f)[3]);

/*
** ylm_material_sample - directions that light may come from, by their share in what leaves.
**
**   wo      in   [n][3]
**   u       in   [n][3]  from 0, below 1
**   wi      out  [n][3]
**   weight  out  [n][3]  f wi.z over the density
**   pdf     out  [n]     the density, sr^-1; 0: light is absorbed, and the weight is 0
*/
YLM_API void ylm_material_sample(const ylm_material *m, size_t n, const float (*wo)[3],
                                 const float (*u)[3], float (*wi)[3], float (*weight)[3],
                                 float *pdf);

/* The directional-hemispherical reflectance towards n directions wo [n][3]: the integral of f wi.z
   over wi, which is what leaves towards wo where light comes from everywhere alike; albedo out
   [n][3], 0 where wo is not above the surface. */
YLM_API void ylm_material_reflectance(const ylm_material *m, size_t n, const float (*wo)[3],
                                      float (*albedo)[3]);

/* The density of ylm_material_sample, sr^-1, for n pairs of directions; pdf out [n]. Of matte, ggx,
   phong and abc it integrates to 1 over directions above the surface. */
YLM_API void ylm_material_pdf(const ylm_material *m, size_t n, const float (*wi)[3],
                              const float (*wo)[3], float *pdf);

/* The highest degree of ylm_material_degrees. */
#define YLM_MATERIAL_DEGREES 100

/*
** ylm_material_degrees - the degree of spherical harmonics that slices of a material need.
**
** The slice of an eye is f wi.z over directions wi; cut at a degree, it misses a part of its norm.
**
**   error   in   above 0, below 1: the part that may be missed
**   most    in   0 .. YLM_MATERIAL_DEGREES
**   angle   in   [n]  of eyes from the normal towards the tangent, radians, below pi/2
**   degree  out  [n]  the least that misses no more; most + 1: a higher one
**
** Returns  YLM_OK; YLM_ERANGE, YLM_ENOMEM
** Accuracy nodes are doubled until the norm is settled to error^2/10, or are 1,024 x 2,048
*/
YLM_API ylm_status ylm_material_degrees(const ylm_material *m, double error, int most, size_t n,
                                        const double *angle, int *degree);

/* -- files ------------------------------------------------------------------- */

/*
** ylm_material_write_merl - an isotropic material as one of MERL's files.
**
** The file has the material's f at the centres of the bins, and -1 where one of the directions is not
** above the surface; of a material that is such a table, its own numbers. The file has 34,992,012 bytes.
**
** Returns  YLM_OK; YLM_EDOMAIN (anisotropic), YLM_EIO, YLM_ENOMEM
** Source   Matusik et al. 2003, "A Data-Driven Reflectance Model"; Rusinkiewicz 1998
*/
YLM_API ylm_status ylm_material_write_merl(const ylm_material *m, const char *path, ylm_error *e);

/* The bins of such a file, and the numbers [..][3] that a tabulated material is loaded from: sr^-1,
   negative where nothing is known. */
#define YLM_MERL_THETA_H 90
#define YLM_MERL_THETA_D 90
#define YLM_MERL_PHI_D 180

/* The directions of the centre of a bin, whose half vector lies in the plane y = 0; false: one of them
   is not above the surface. */
YLM_API bool ylm_material_merl_centre(int theta_h, int theta_d, int phi_d, double wi[3],
                                      double wo[3]);

/* Calls fact(to, name, number) with each number that says what a material's tables hold. */
typedef void ylm_material_fact(void *to, const char *name, double x);
YLM_API void ylm_material_facts(const ylm_material *m, ylm_material_fact *fact, void *to);

/* -- for kernels elsewhere --------------------------------------------------- */

#define YLM_MATERIAL_ROW 3

/* The material as a row of numbers [YLM_MATERIAL_ROW], from which shaders (gen/material.glsl)
   make radiance of products as ylm_material_radiance does. YLM_OK; YLM_EMISSING: no shader has
   the kind. */
YLM_API ylm_status ylm_material_row(const ylm_material *m, float *row, ylm_error *e);
/* In place, the row of the material with its reflectance multiplied by a tint. */
YLM_API void ylm_material_row_tint(float *row, const float tint[3]);
/* As those shaders do: in place, the product of a transfer vector with light to radiance. */
YLM_API void ylm_material_row_radiance(const float *row, float light[3]);

#ifdef __cplusplus
}
#endif
#endif
