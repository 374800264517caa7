/* contour.h - integrals of spherical harmonics over what a flat light fills of the sphere, as
   integrals along its rim. Private to csrc/light.

   y(t) is the rim seen from the shading point x; rho = |y|, s = y/rho. m dt = (y x y')/rho^2 dt is
   the rim's element on the sphere times the normal of its great circle:

     L_lm      = 1/(l(l+1)) integral m . grad Y_lm(s),  l > 0
     grad L_lm = integral m Y_lm(s)/rho
     H_ab L_lm = - integral sym_ab m_a (grad Y_lm(s) - 3 s Y_lm(s))_b / rho^2

   where the rim belongs to the light; along a horizon through x only L has a share. Where the
   horizon cuts the rim at y, H gains +- sym_ab (y x y')_a up_b/(y'.up) Y_lm(s)/rho^3.

   Source  docs/math.md "Polygons and disks" */
#ifndef YLM_LIGHT_CONTOUR_H
#define YLM_LIGHT_CONTOUR_H

#include "../light.h"
#include "calibration.h"
#include "ylm_vector.h"

/* Gauss-Legendre rules, shortest first: gen/gauss.c. */
#define YLM__RULES 21
#define YLM__MOST_NODES 96
typedef struct ylm__rule {
  int n;
  double fine, rough; /* degree times half angle that it integrates to 1e-16, to 1e-10 */
  double x[YLM__MOST_NODES], w[YLM__MOST_NODES]; /* zeros behind the n-th */
} ylm__rule;
extern const ylm__rule ylm__rule_table[YLM__RULES];
/* The rule for an arc of an angle, polynomials of degree l on it; of `least` nodes or more. */
static inline const ylm__rule *ylm__rule_for(int l, double angle, int least) {
  const ylm__rule *r = ylm__rule_table;
  double need = 0.5 * l * angle;
  for (int i = 1; i < YLM__RULES && (r->fine < need || r->n < least); i++) r++;
  return r;
}

/* Where sums go, and scratch for the basis at YLM__BATCH nodes. */
typedef struct ylm__contour {
  int lmax;
  size_t count;
  double *y, *dy, *ddy; /* [YLM__BATCH][count], ..[3], ..[6] */
  double *value, *gradient,
      *hessian; /* [count], [count][3], [count][6]; the last two may be NULL */
} ylm__contour;
/* YLM_ENOMEM; to be freed with ylm_free(k->y). */
ylm_status ylm__contour_make(ylm__contour *k, int lmax);
/* Zeros to start from. */
void ylm__contour_clear(const ylm__contour *k);

/* Adds nodes of a rim: directions s, m with its weight, 1/rho; `moves`: the rim is the light's. */
ylm_status ylm__contour_nodes(const ylm__contour *k, int n, const double (*s)[3],
                              const double (*m)[3], const double *inverse, bool moves);
/* Adds the great arc that the segment from v to w fills; false where it has no plane with x. */
bool ylm__contour_arc(const ylm__contour *k, const double *v, const double *w, double sign,
                      bool moves, ylm_status *status);
/* Adds what the Hessian owes to a horizon that cuts the rim at y, where the rim runs along dy. */
ylm_status ylm__contour_cut(const ylm__contour *k, const double *y, const double *dy,
                            const double *up, double sign);
/* Adds a flat light as n points y with weights (areas), seen from far. */
ylm_status ylm__contour_points(const ylm__contour *k, int n, const double (*y)[3], const double *w,
                               const double *normal);

/*
** One flat light of unit radiance; sums are cleared first. `normal` is a unit vector.
**
**   v        in  [n][3] relative to the shading point; a convex polygon
**   ellipse  in  [3][3] centre, and two half axes
**
** Returns  YLM_OK; YLM_EDOMAIN where the shading point lies on it: sums are half a sphere's
*/
ylm_status ylm__contour_polygon(const ylm__contour *k, int n, const double (*v)[3],
                                const double *normal, const double *horizon);
ylm_status ylm__contour_ellipse(const ylm__contour *k, const double (*ellipse)[3],
                                const double *normal, const double *horizon);
/* Equal steps around a whole rim that keeps its distance converge geometrically: how many leave
   exp(-digits); 0 if they are more than YLM__STEPS. With the centre c and half axes u, v: across = c.c +
   size^2, swing = 2 |(c.u, c.v)|. contour_ellipse.c */
int ylm__equal_steps(double across, double swing, int lmax, double digits);
/* An upper bound of |y'| along a rim of half axes u, v. */
double ylm__rim_speed(const double *u, const double *v);
/* Half a sphere's sums: YLM_EDOMAIN. */
ylm_status ylm__contour_touched(const ylm__contour *k);

#endif
