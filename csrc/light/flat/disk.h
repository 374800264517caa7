/*
** disk.h - disks and ellipses for kernel.isa.c: sums along their rims, lanes are
** points.
**
** On a rim y = c + u cos phi + v sin phi the normal of the great circle turns. Its components times
** the moments of kernel.h are therefore summed, at equal steps of phi, in each lane as many as it
** needs.
*/
#ifndef YLM_LIGHT_FLAT_DISK_H
#define YLM_LIGHT_FLAT_DISK_H

#include "calibration.h"
#include "kernel.h"
#include "space.h"

/* Directions, and components of m with the node's weight over rho to the power 0, 1, 2. */
typedef struct rim_nodes {
  v3 s[AT_ONCE];
  V w[3][3][AT_ONCE];
} rim_nodes;

/* Adds nodes to sums [3][width]: all harmonics up to plan->top, m by m. */
YLM_INLINE void add_rim(const ylm__flat_plan *plan, const int kinds, const rim_nodes *n, V *sum) {
  const int top = plan->top, stride = plan->lmax + 2;
  V re[AT_ONCE], im[AT_ONCE];
  for (int j = 0; j < AT_ONCE; j++) re[j] = set(1), im[j] = set(0);
  for (int m = 0; m <= top; m++) {
    V c[AT_ONCE], s[AT_ONCE], c_before[AT_ONCE], s_before[AT_ONCE];
    for (int j = 0; j < AT_ONCE; j++)
      c[j] = re[j], s[j] = im[j], c_before[j] = s_before[j] = set(0);
    for (int l = m; l <= top; l++) {
      size_t at = (size_t)(l * (l + 1)), up = at + (size_t)m, down = at - (size_t)m;
      for (int k = 0; k < 3; k++) {
        if (!(kinds & 1 << k) || l > plan->lmax - 1 + k) continue;
        for (size_t a = 0; a < 3; a++) {
          V *out = sum + a * plan->width + plan->offset[k], x = out[up], y = out[down];
          for (int j = 0; j < AT_ONCE; j++) x += c[j] * n->w[k][a][j], y += s[j] * n->w[k][a][j];
          out[down] = y, out[up] = x; /* one place where m is 0 */
        }
      }
      V factor = set(plan->monic[m * stride + l]);
      for (int j = 0; j < AT_ONCE; j++) {
        V next = n->s[j].z * c[j] - factor * c_before[j];
        V other = n->s[j].z * s[j] - factor * s_before[j];
        c_before[j] = c[j], c[j] = next, s_before[j] = s[j], s[j] = other;
      }
    }
    for (int j = 0; j < AT_ONCE; j++) {
      V t = re[j] * n->s[j].x - im[j] * n->s[j].y;
      im[j] = re[j] * n->s[j].y + im[j] * n->s[j].x;
      re[j] = t;
    }
  }
}

/* A disk seen from the lanes' points. */
typedef struct seen_disk {
  v3 c, u, v, facing;
  V steps, weight; /* weight of a node: the side that is seen, 0 for lanes without a part */
} seen_disk;

/* Which lanes are for the reference: on the light, edge-on, far away, or so near that the rim needs
   panels; the steps that the others need. */
YLM_INLINE VI difficult_disk(const ylm__flat_plan *plan, v3 c, V height, const double (*axes)[3],
                             double size, V *steps) {
  V distance2 = dot(c, c), distance = ylm_vd_sqrt(distance2);
  V cu = dot(c, spread(axes[0])), cv = dot(c, spread(axes[1]));
  V swing = 2 * ylm_vd_sqrt(cu * cu + cv * cv), across = distance2 + size * size;
  VI out = (VI) ~(absolute(height) > 1e-13 * (distance + size)) |
           (VI) ~((plan->lmax + 4) * size > plan->far * distance);
  *steps = set(AT_ONCE);
  for (int i = 0; i < LANES; i++) {
    int n = out[i] ? 0 : ylm__equal_steps(across[i], swing[i], plan->lmax, plan->digits);
    if (n)
      (*steps)[i] = n;
    else
      out[i] = -1;
  }
  return out;
}

/* Node j, at the middle of step i; what the solid angle gains. */
YLM_INLINE V add_node(const seen_disk *d, int i, rim_nodes *n, int j) {
  VI used = i < d->steps;
  turned t = turn(ylm_vd_select(used, YLM_PI * ((i + 0.5) / d->steps - 0.5), set(0)));
  /* of the whole angle from those of its half */
  V sine = 2 * t.sine * t.cosine, cosine = 2 * t.cosine * t.cosine - 1;
  node at = rim_node(d->c, d->u, d->v, d->facing, cosine, sine);
  V weight = ylm_vd_select(used, d->weight, set(0));
  v3 m = scale(at.m, weight);
  n->s[j] = at.s;
  n->w[0][0][j] = m.x, n->w[0][1][j] = m.y, n->w[0][2][j] = m.z;
  for (int a = 0; a < 3; a++) {
    n->w[1][a][j] = n->w[0][a][j] * at.inverse;
    n->w[2][a][j] = n->w[1][a][j] * at.inverse;
  }
  return weight * at.angle;
}

/* Adds a disk to sums [channels][3 width + 1] as add_polygon does. */
YLM_INLINE void add_disk(const ylm__flat_plan *plan, const int kinds, size_t light, v3 x, VI *out,
                         V *one, V *sum) {
  const ylm_polygons *p = plan->p;
  const double(*row)[3] = (const double(*)[3])(p->vertices + 3 * p->first[light]);
  const double *normal = p->normal + 3 * light,
               *e = plan->radiance + light * (size_t)plan->channels;
  size_t width = plan->width, rows = 3 * width + 1;
  double size = ylm__rim_speed(row[1], row[2]), most = 0;
  v3 centre = spread(row[0]), c = {centre.x - x.x, centre.y - x.y, centre.z - x.z};
  V height = dot(c, spread(normal)), steps;
  *out = difficult_disk(plan, c, height, row + 1, size, &steps);
  /* what these lanes compute is thrown away: from above the centre */
  c.x = ylm_vd_select(*out, set(size * normal[0]), c.x);
  c.y = ylm_vd_select(*out, set(size * normal[1]), c.y);
  c.z = ylm_vd_select(*out, set(size * normal[2]), c.z);
  V side = ylm_vd_select(dot(c, spread(normal)) < 0, set(-1), set(1)), solid = set(0);
  seen_disk d = {c, spread(row[1]), spread(row[2]), scale(spread(normal), side), steps, side};
  d.weight *= 2 * YLM_PI / steps;
  d.weight = ylm_vd_select(*out, set(0), d.weight);
  V *to = plan->channels == 1 ? sum : one;
  if (plan->channels == 1)
    d.weight *= e[0];
  else
    for (size_t k = 0; k < rows; k++) one[k] = set(0);
  for (int i = 0; i < LANES; i++) most = steps[i] > most ? steps[i] : most;
  for (int i = 0; i < most; i += AT_ONCE) {
    rim_nodes n;
    for (int j = 0; j < AT_ONCE; j++) solid += add_node(&d, i + j, &n, j);
    if (plan->top >= 0) add_rim(plan, kinds, &n, to);
  }
  to[3 * width] += plan->channels == 1 && e[0] < 0 ? -absolute(solid) : absolute(solid);
  for (size_t c3 = 0; c3 < 3 && plan->channels == 3; c3++)
    for (size_t k = 0; k < rows; k++) sum[c3 * rows + k] += e[c3] * one[k];
}

#endif
