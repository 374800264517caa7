/*
** ylm_light_virtual.h - virtual lights: small lights that send different light in different
** directions, as surfaces do that reflect.
**
** A virtual light has a place y, a normal n or none, a radius r, and an emission b: coefficients of
** its intensity without the cosine, in world axes. From point x, with v = y - x, d = |v|, w = v/d
** and the direction u = -v/sqrt(d^2 + eps^2) in which its light leaves:
**
**   E(x)    = max(0, s + n.u) sum_q b_q S_q(u)      (S_q: solid harmonics; factor 1 without a normal)
**   L_lm(x) = E(x) G_l(d) Y_lm(w)
**
** | profile | G_l(d), sg = r/2                                      | eps  |
** | gauss   | (1 - e^(-2 d^2/sg^2))/d^2 e^(-l(l+1) sg^2/(2 d^2))    | sg/4 |
** | cap     | a sphere light's of radiance 1/(pi r^2), inside d = r's      | 0    |
** | point   | 1/d^2; 0 at the light itself                          | 0    |
** | far     | (1 - e^(-(d/R)^4))/d^2 e^(-l(l+1) sg^2/(2 d^2))       | sg/4 |
** | near    | gauss - far: nearly nothing is left beyond 1.6 R      | sg/4 |
**
** Lights that are made from surfaces are matte where degree is 0. A surface that receives the power
** P and reflects the share rho of it sends rho P in all; b_00 = sqrt(4 pi) rho P/pi. Virtual lights
** have no body: rays do not see them, and they shine through walls.
**
**     ylm_light_virtual *lights;
**     ylm_light_virtual_form form = {.n = n, .at = at, .normal = normal, .radius = radius,
**                                    .emission = emission}; // degree 0, profile gauss
**     if (ylm_light_virtual_create(&form, &lights, &error) == YLM_OK) {
**       const ylm_field *field = ylm_light_virtual_field(lights);
**       ...
**       ylm_light_virtual_free(lights);
**     }
**
** Source  Mezieres & Paulin 2022, Secs. 3 and 5 (cap); docs/virtual.md
*/
#ifndef YLM_LIGHT_VIRTUAL_H
#define YLM_LIGHT_VIRTUAL_H

#include "ylm_base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ylm_light_set ylm_light_set; /* ylm_light.h */

#define YLM_LIGHT_VIRTUAL_PROFILES(X)                                                              \
  X(GAUSS, "gauss") X(CAP, "cap") X(POINT, "point") X(FAR, "far") X(NEAR, "near")

typedef enum ylm_light_virtual_profile {
#define X(name, text) YLM_LIGHT_VIRTUAL_##name,
  YLM_LIGHT_VIRTUAL_PROFILES(X)
#undef X
      YLM_LIGHT_VIRTUAL_PROFILE_COUNT
} ylm_light_virtual_profile;

/* A bit of a query's `want`, beside the metric's: lambda leaves out how the light that virtual lights send bends with the
   direction. Such a lambda costs a fifth, and guides refinement as well. Other fields know nothing
   of the bit. */
enum { YLM_WANT_ROUGH = 16 };

#define YLM_LIGHT_VIRTUAL_DEGREE 8         /* the highest degree of an emission */
#define YLM_LIGHT_VIRTUAL_MOST (1ul << 27) /* lights */

/* Numbers of an emission per colour. */
#define YLM_LIGHT_VIRTUAL_NUMBERS(degree) (((size_t)(degree) + 1) * ((size_t)(degree) + 1))

/* n lights of one profile and one degree of emission. */
typedef struct ylm_light_virtual_form {
  size_t n;
  const double *at;       /* [n][3]  scene units */
  const double *normal;   /* [n][3]  of length 1, or 0: emits all around; NULL: all of them do */
  const double *radius;   /* [n]     scene units; `point` has none */
  const double *shift;    /* [n]     0 .. 1; NULL: 0 */
  int degree;             /* 0 .. YLM_LIGHT_VIRTUAL_DEGREE */
  const double *emission; /* [n][3][(degree+1)^2]  W sr^-1, may be negative */
  ylm_light_virtual_profile profile;
  double core; /* R of far and near, scene units, above the largest radius */
} ylm_light_virtual_form;

/* Immutable once created; shared by the sets that hold it. */
typedef struct ylm_light_virtual ylm_light_virtual;

/*
** ylm_light_virtual_create - take n virtual lights.
**
** Numbers are copied; normals whose length is 1 +- 1e-3 come to have length 1. n may be 0: darkness.
**
** Returns  YLM_OK; YLM_EDOMAIN (not finite; radius below 0, or 0 for any profile but point; a normal
**          that is neither 0 nor of length 1; a shift outside of 0 .. 1; core), YLM_ERANGE (n, degree,
**          a coordinate beyond YLM_LIGHT_EXTENT): `e` names the light, counted from 1; YLM_ENOMEM
** Cost     O(n)
*/
YLM_API ylm_status ylm_light_virtual_create(const ylm_light_virtual_form *form,
                                            ylm_light_virtual **lights, ylm_error *e);
/* Gives up one use of it; sets that hold it keep it alive. NULL is fine. */
YLM_API void ylm_light_virtual_free(ylm_light_virtual *lights);
YLM_API size_t ylm_light_virtual_count(const ylm_light_virtual *lights);
/* Their form as it was given, normals and shifts always there; alive as long as the lights are. */
YLM_API void ylm_light_virtual_get(const ylm_light_virtual *lights, ylm_light_virtual_form *form);
/* Bytes of memory that the lights take. */
YLM_API size_t ylm_light_virtual_bytes(const ylm_light_virtual *lights);
/* The name of a profile; the profile of a name, YLM_LIGHT_VIRTUAL_PROFILE_COUNT: there is none. */
YLM_API const char *ylm_light_virtual_profile_name(ylm_light_virtual_profile profile);
YLM_API ylm_light_virtual_profile ylm_light_virtual_profile_of(const char *name);

/* The power that light i of them sends, W; of all of them, which is 0 of profile near: it ends at 1.6 R, where far
   has all. Exact for the coefficients that are given. */
YLM_API void ylm_light_virtual_power_one(const ylm_light_virtual *lights, size_t i,
                                         double power[3]);
YLM_API void ylm_light_virtual_power(const ylm_light_virtual *lights, double power[3]);
/* As that, of a light that is not in a set: the integral of max(0, s + n.u) B(u) over all directions
   u; normal NULL or 0: of B(u). emission: [3][(degree+1)^2]. */
YLM_API void ylm_light_virtual_flux(const double *normal, double shift, int degree,
                                    const double *emission, double power[3]);

/*
** Their light field (ylm_base.h), which lives as long as they do: lmax <= YLM_LIGHT_LMAX. Nothing is
** inside of a virtual light. The field jumps, or bends sharply, at lights of `cap` and `point` alone.
** Accuracy relative to the sum of the norms of what lights give: 1e-12 (double), 4e-6 (float).
*/
YLM_API const ylm_field *ylm_light_virtual_field(const ylm_light_virtual *lights);
/* The field's `evaluate` by the kernels of an instruction set; YLM_ISA_reference is plain code in
   double, and judges the others. YLM_EINVAL too: isa is not available. */
YLM_API ylm_status ylm_light_virtual_evaluate(const ylm_light_virtual *lights, ylm_isa isa,
                                              const ylm_field_query *q, size_t n,
                                              const void *points, ylm_field_result *r,
                                              ylm_error *e);

/* A set of lights that are these; it shares them. YLM_ENOMEM. */
YLM_API ylm_status ylm_light_set_virtual(ylm_light_virtual *lights, ylm_light_set **set,
                                         ylm_error *e);
/* The virtual lights of a set that holds nothing else; NULL for any other. */
YLM_API ylm_light_virtual *ylm_light_set_virtuals(const ylm_light_set *set);
/* Whether a set holds virtual lights, which rays do not see. */
YLM_API bool ylm_light_set_has_virtual(const ylm_light_set *set);

/*
** ylm_light_virtual_split - far and near parts of lights of profile gauss, whose sum they are.
**
**   core  in   R, above the largest radius; lights fade within their radius, so that below two radii far is hardly
**              smoother than the whole
**
** The far part is smooth on the scale of R, and is baked; the near part ends at 1.6 R, and is
** gathered where it is needed.
**
** Returns  YLM_OK; YLM_EDOMAIN (core); YLM_EINVAL (another profile); YLM_ENOMEM
** Source   docs/virtual.md
*/
YLM_API ylm_status ylm_light_virtual_split(const ylm_light_virtual *lights, double core,
                                           ylm_light_virtual **far, ylm_light_virtual **near,
                                           ylm_error *e);

/* How far in cores lights of profile near are summed by the two functions below: R times this. */
#define YLM_LIGHT_VIRTUAL_REACH 1.6
/*
** ylm_light_virtual_near_irradiance - add the irradiance by lights near to points with normals.
**
**   lights   in      of profile near
**   lmax     in      of the clamped cosine, 0 .. YLM_LIGHT_LMAX
**   points   in      [n][3]
**   normals  in      [n][3] of length 1
**   out      in out  [n][3]  W m^-2
**   pairs    out     of lights and points that were looked at; may be NULL
**
** Lights farther than 1.6 R count as nothing; a point's result depends on the point and the lights alone,
** and is rounded as a field's in float. Each light adds E sum_l a_l (2l+1)/(4 pi) G_l P_l(w.N), a_l
** being pi, 2 pi/3, pi/4, ..: what coefficients to lmax give.
**
** Returns  YLM_OK; YLM_EINVAL (another profile), YLM_ERANGE (lmax), YLM_EDOMAIN (a point or normal that
**          is not finite), YLM_ENOMEM
*/
YLM_API ylm_status ylm_light_virtual_near_irradiance(const ylm_light_virtual *lights, int lmax,
                                                     size_t n, const float *points,
                                                     const float *normals, int threads,
                                                     const ylm_progress *progress, float *out,
                                                     uint64_t *pairs, ylm_error *e);
/* As that, of coefficients: out [n][3][(lmax+1)^2], added to. */
YLM_API ylm_status ylm_light_virtual_near_value(const ylm_light_virtual *lights, int lmax, size_t n,
                                                const float *points, int threads,
                                                const ylm_progress *progress, float *out,
                                                uint64_t *pairs, ylm_error *e);

/* The highest degree of the function below. */
#define YLM_LIGHT_VIRTUAL_LEVELS_LMAX 8

typedef struct ylm_light_virtual_levels {
  double core;  /* R, scene units, above the largest radius: how far lights are near */
  double voxel; /* edge of the finest voxels, over R */
  double
      merge; /* edge of the cells in which lights are merged, over R, 2 R, 4 R, ..; 0: none are */
  int lmax;  /* of the clamped cosine, 0 .. YLM_LIGHT_VIRTUAL_LEVELS_LMAX */
  bool near, far; /* the parts that are added */
  int threads;
  const ylm_progress *progress; /* stages "near lights", "lights", "far lights" */
} ylm_light_virtual_levels;

typedef struct ylm_light_virtual_levels_report {
  int levels;
  size_t corners, cells, bytes; /* of voxels of all levels; what corners keep */
  size_t merged;                /* lights of the highest level */
  double cell;                  /* edge of the lowest level's cells in which lights are merged */
  uint64_t pairs, far_pairs;    /* of points and near lights; of corners and lights */
  double seconds[5]; /* sorting of points, merging, rows of corners, interpolation, near parts */
} ylm_light_virtual_levels_report;

/*
** ylm_light_virtual_irradiance - add the irradiance by many lights at points with normals.
**
**   lights   in      of profile gauss
**   points   in      [n][3]
**   normals  in      [n][3] of length 1
**   out      in out  [n][3]  W m^-2
**   report   out     may be NULL
**
** Near parts, to 1.6 R, are summed at the points. Far parts are baked in levels of voxels about the
** points: level j has voxels of 2^j voxel R and corners with gradients. The level's lights are
** merged in cells of 2^j merge R; their part between the cores 2^j R and 2^(j+1) R counts. The
** highest level has all that is beyond. A voxel is divided where lights are in reach. The error is
** that of interpolation and of merging. Interpolation adds some percent of the mean at voxel 1,
** falling with its square; merging adds less than a percent at merge 1/4. Results do not depend on
** the number of threads.
**
** Returns  YLM_OK; YLM_EINVAL (another profile), YLM_ERANGE (lmax; points that are too far apart for the voxels; no
**          kernels are available), YLM_EDOMAIN (an option; a point or normal that is not finite), YLM_ENOMEM, YLM_ECANCELLED
** Cost     O(n + lights): a corner sees some 500 lights of its level, a point those within 1.6 R
*/
YLM_API ylm_status ylm_light_virtual_irradiance(const ylm_light_virtual *lights,
                                                const ylm_light_virtual_levels *o, size_t n,
                                                const float *points, const float *normals,
                                                float *out, ylm_light_virtual_levels_report *report,
                                                ylm_error *e);

#ifdef __cplusplus
}
#endif
#endif
