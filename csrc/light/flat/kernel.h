/* kernel.h - polygons by vectors: lanes are points. Private to csrc/light.

   (Disks: disk.h.) Along an edge the normal N of its great circle is constant. Per edge three kinds
   of moments are summed over nodes. Per point three vectors of each kind are summed, N_a times a
   moment:

     kind  moment of Y_km along the edge      degrees k       feeds
     0     integral Y_km dt                   0 .. lmax-1     L: N.grad Y_lm has degree l-1 there
     1     integral Y_km / rho dt             0 .. lmax       gradients
     2     integral Y_km / rho^2 dt           0 .. lmax+1     Hessians

   With X of light.h, solid harmonics have d_a R_lm = (2l+1) sum X_a^(l-1)[m',m] R_(l-1)m'. On the
   unit sphere grad Y - 3 s Y = grad R - (l+3) s Y. Both are sparse maps, once per point. Harmonics
   are summed unnormalised, monic Legendre polynomials in z times Re, Im (x+iy)^m; their factors are
   in the maps. Source: docs/math.md "Polygons and disks" */
#ifndef YLM_LIGHT_POLYGON_KERNEL_H
#define YLM_LIGHT_POLYGON_KERNEL_H

#include "flat.h"
#include "ylm_sh.h"

enum { YLM__K0 = 1, YLM__K1 = 2, YLM__K2 = 4 };

/* result `row` gains factor * sums[axis][from]. */
typedef struct ylm__flat_entry {
  int axis;
  uint32_t from;
  double factor;
} ylm__flat_entry;
typedef struct ylm__flat_map {
  size_t *begin; /* [count+1] */
  ylm__flat_entry *entry;
} ylm__flat_map;

typedef struct ylm__flat_plan ylm__flat_plan;
/* Numbers of a channel of exact sums: coefficients, then gradients, then Hessians, as far as they are wanted. */
static inline size_t ylm__flat_wide(const ylm_field_query *q) {
  bool h = q->want & (YLM_WANT_HESSIAN | YLM_WANT_METRIC), g = q->want & YLM_WANT_GRADIENT;
  return (h ? 10 : g ? 4 : 1) * ylm_sh_count(q->lmax);
}

/* Adds all lights at n points: sum [n][3][wide]. Points on a light, edge-on, far, or too near
   to a disk's rim go to the reference, for which k is. */
typedef ylm_status ylm__flat_range(const ylm__flat_plan *plan, const ylm__contour *k, size_t n,
                                   const double (*x)[3], double *sum, uint8_t *inside);
/* The kernel of an instruction set; NULL: there is none. */
ylm__flat_range *ylm__flat_kernel(ylm_isa isa);

struct ylm__flat_plan {
  ylm__flat_range *range;
  const ylm_polygons *p;
  const double *radiance; /* [n][channels] */
  int lmax, top, kinds, channels;
  double degree;            /* of the integrands */
  double reach[YLM__RULES]; /* of the rules, for the element type */
  double far;               /* as YLM__FAR, for the element type */
  double digits;            /* of ylm__equal_steps, for the element type */
  size_t count, offset[3], width, wide;
  double *monic; /* [top+1][top+1]: c of p_(l+1) = z p_l - c p_(l-1), by m and l */
  double *norm;  /* [(lmax+2)^2] */
  ylm__flat_map value, hessian;
};

/* The plan of a query, or YLM_ENOMEM; to be freed in any case. */
ylm_status ylm__flat_plan_make(ylm__flat_plan *plan, const ylm_polygons *p,
                               const ylm_field_query *q, ylm_isa isa);
void ylm__flat_plan_free(ylm__flat_plan *plan);

/* Adds one light at one point by the reference: sum [3][wide]. flat.c */
ylm_status ylm__polygon_add(const ylm_polygons *p, const ylm__contour *k, size_t light,
                            const double *x, double *sum, uint8_t *inside);

/* The exact sums of all flat lights at n points, as ylm__polygon_spheres but for sum [n][3][wide]. plan NULL: by the
   reference. flat.c */
ylm_status ylm__polygon_exactly(const ylm_polygons *p, const ylm__flat_plan *plan,
                                const ylm_field_query *q, size_t n, const double (*x)[3],
                                double *sum, uint8_t *inside);

#endif
