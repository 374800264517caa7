/*
** looks.c - rays that meet few lamps, which balls enclose, and these lamps among so many that none does, for specs.
**
** Prints for each scene, at 0 and ever farther from it, how many rays meet lamps, and how many answers differ. A third of the
** rays grazes a sphere, a third a corner or an edge of a triangle, the others go anywhere; some end before they arrive.
*/
#include <math.h>
#include <stdio.h>
#include <string.h>

#include <ylm/ylm_trace.h>

enum { RAYS = 90000, FEW = 2, MORE = 17 };

static double draw(ylm_rng *r) { return 2 * ylm_rng_double(r) - 1; }

static void aim(ylm_rng *r, int i, double shift, const float *sphere, const float *triangle,
                ylm_trace_ray *ray) {
  double to[3], aside[3], length = 0, u = ylm_rng_double(r);
  for (int a = 0; a < 3; a++) {
    ray->org[a] = (float)(3 * draw(r) + shift);
    aside[a] = draw(r), length += aside[a] * aside[a];
  }
  for (int a = 0; a < 3; a++) {
    double corner = triangle[a], next = triangle[3 + a];
    if (i % 3 == 0) to[a] = sphere[a] + aside[a] / sqrt(length) * sphere[3] * (1 + 1e-5 * u);
    if (i % 3 == 1) to[a] = corner + (i % 2 ? u * (next - corner) : 0) + 1e-6 * aside[a];
    if (i % 3 == 2) to[a] = sphere[a] + 1.2 * aside[a];
    ray->dir[a] = (float)((to[a] - ray->org[a]) * (i % 5 ? 1 : 7));
  }
  ray->near = 0;
  ray->far = i % 4 ? INFINITY : (float)(ylm_rng_double(r) * 1.5 / (i % 5 ? 1 : 7));
}

static int look(double shift) {
  static ylm_trace_ray ray[2][RAYS];
  float sphere[FEW + MORE][4], triangle[2][9], disk[7] = {-.5f, .8f, -.4f, .3f, 0, .6f, .8f};
  ylm_trace *t[2];
  ylm_rng r;
  int met = 0, differ = 0;
  ylm_rng_seed(&r, 1, 1);
  for (int i = 0; i < FEW + MORE; i++)
    for (int a = 0; a < 4; a++)
      sphere[i][a] = (float)(a == 3 ? i < FEW ? .3 + .2 * i : 1e-3
                                    : draw(&r) + shift + (i < FEW ? 0 : 1e6 + i));
  for (int i = 0; i < 18; i++) triangle[i / 9][i % 9] = (float)(draw(&r) + shift);
  for (int a = 0; a < 3; a++) disk[a] += (float)shift;
  for (int k = 0; k < 2; k++) {
    ylm_trace_lamps lamps = {FEW + (k ? MORE : 0), 2, 1, sphere[0], triangle[0], disk};
    if (ylm_trace_create(0, NULL, &lamps, &t[k], NULL) != YLM_OK) return 1;
  }
  for (int i = 0; i < RAYS; i++) aim(&r, i, shift, sphere[0], triangle[0], &ray[0][i]);
  memcpy(ray[1], ray[0], sizeof ray[0]);
  for (int k = 0; k < 2; k++) ylm_trace_meets_lamps(t[k], RAYS, ray[k]);
  for (int i = 0; i < RAYS; i++) {
    met += ray[1][i].far < 0;
    differ += (ray[0][i].far < 0) != (ray[1][i].far < 0);
  }
  printf("%d rays, %d meet lamps, %d differ\n", RAYS, met, differ);
  for (int k = 0; k < 2; k++) ylm_trace_free(t[k]);
  return 0;
}

int main(void) { return look(0) || look(30) || look(4000); }
