/* radius.c - how wide lights are: by the lights around them, by the way of their particle, or as told. */
#include "emit.h"
#include "ylm_light_spot.h"

#define MOST_MEDIANS 4

/* The radius of a disk that has the n-th part of the surface of the box around all lights. */
static double even(const ylm_emit_lights *l, double scale) {
  double size[3], area;
  for (size_t a = 0; a < 3; a++) {
    double least = INFINITY, most = -INFINITY;
    for (size_t i = 0; i < l->n; i++) {
      least = fmin(least, l->at[3 * i + a]);
      most = fmax(most, l->at[3 * i + a]);
    }
    size[a] = most - least;
  }
  area = 2 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]);
  return area > 0 ? scale * sqrt(area / YLM_PI / (double)l->n) : scale;
}

/* The number of n that has so many below it. Source: Hoare 1961, "Algorithm 65: Find". */
static double find(double *x, size_t n, size_t rank) {
  ptrdiff_t low = 0, high = (ptrdiff_t)n - 1, at = (ptrdiff_t)rank;
  while (low < high) {
    double pivot = x[low + (high - low) / 2];
    ptrdiff_t i = low, k = high;
    while (i <= k) {
      while (x[i] < pivot) i++;
      while (x[k] > pivot) k--;
      if (i > k) break;
      double swapped = x[i];
      x[i++] = x[k];
      x[k--] = swapped;
    }
    if (at <= k)
      high = k;
    else if (at >= i)
      low = i;
    else
      break;
  }
  return x[rank];
}

/* Cuts radii at some medians, and fills those that are not known; tells least, median and largest. */
static ylm_status settle(const ylm_emit_options *o, ylm_emit_lights *l, ylm_emit_report *report) {
  size_t n = 0;
  double least = INFINITY, *known = ylm_alloc(l->n, sizeof *known);
  if (!known) return YLM_ENOMEM;
  for (size_t i = 0; i < l->n; i++)
    if (l->radius[i] > 0) {
      least = fmin(least, l->radius[i]);
      known[n++] = l->radius[i];
    }
  double median = n > 0 ? find(known, n, n / 2) : even(l, o->scale), most = MOST_MEDIANS * median;
  report->radius[0] = n > 0 ? least : median;
  report->radius[1] = report->radius[2] = median;
  for (size_t i = 0; i < l->n; i++) {
    double *r = &l->radius[i];
    if (!(*r > 0)) *r = median;
    if (*r > most) {
      *r = most;
      report->cut++;
    }
    report->radius[2] = fmax(report->radius[2], *r);
  }
  ylm_free(known);
  return YLM_OK;
}

/* The paper's r2, of a grid: d tan(sqrt(2) times the angle of a texel). */
static void by_texel(const ylm_scene *scene, const emit_landing *landing, const ylm_emit_options *o,
                     ylm_emit_lights *l) {
  const ylm_light_spot *spot;
  size_t each = (size_t)o->grid * (size_t)o->grid;
  (void)ylm_scene_spots(scene, &spot);
  for (size_t i = 0; i < l->n; i++) {
    double opening = 2 * fmin(acos(spot[landing[i].particle / each].outer), EMIT_WIDEST);
    double angle = fmin(sqrt(2) * opening / o->grid, YLM_PI / 4);
    l->radius[i] = o->scale * (double)landing[i].way * tan(angle);
  }
}

/* The paper's r1: the mean distance to the lights of the eight texels around, weighed by 1/(difference of their ways +
   a thousandth of the way). */
static double by_texels(const emit_landing *landing, const uint32_t *light, int side, size_t i) {
  const emit_landing *of = &landing[i];
  size_t wide = (size_t)side, in = of->particle % (wide * wide), first = of->particle - in;
  int x = (int)(in % wide), y = (int)(in / wide);
  double sum = 0, all = 0;
  for (int k = 0; k < 9; k++) {
    int u = x + k % 3 - 1, v = y + k / 3 - 1;
    if (k == 4 || u < 0 || v < 0 || u >= side || v >= side) continue;
    uint32_t j = light[first + (size_t)v * wide + (size_t)u];
    if (j == UINT32_MAX) continue;
    double d2 = 0,
           weight = 1 / (fabs((double)of->way - (double)landing[j].way) + 1e-3 * (double)of->way);
    for (int a = 0; a < 3; a++) {
      double d = (double)of->at[a] - (double)landing[j].at[a];
      d2 += d * d;
    }
    sum += weight * sqrt(d2);
    all += weight;
  }
  return all > 0 ? sum / all : 0;
}

static ylm_status by_neighbours(const emit_landing *landing, const ylm_emit_options *o,
                                ylm_emit_lights *l) {
  uint32_t *light = ylm_alloc(o->particles, sizeof *light);
  if (!light) return YLM_ENOMEM;
  for (size_t i = 0; i < o->particles; i++) light[i] = UINT32_MAX;
  for (size_t i = 0; i < l->n; i++) light[landing[i].particle] = (uint32_t)i;
  for (size_t i = 0; i < l->n; i++) l->radius[i] = o->scale * by_texels(landing, light, o->grid, i);
  ylm_free(light);
  return YLM_OK;
}

/* The paper's: by the ways of particles. */
static void by_angle(const emit_landing *landing, const ylm_emit_options *o, ylm_emit_lights *l) {
  double lights = (double)(o->lights ? o->lights : o->particles);
  double wide = tan(fmin(acos(fmax(0, 1 - 2 / lights)), YLM_PI / 4));
  for (size_t i = 0; i < l->n; i++) l->radius[i] = o->scale * (double)landing[i].way * wide;
}

static double by_area(const emit_landing *l, const ylm_emit_options *o) {
  return o->scale * sqrt((double)l->area / YLM_PI);
}

ylm_status ylm__emit_radii(const ylm_scene *scene, const emit_landing *landing,
                           const ylm_emit_options *o, ylm_emit_lights *l, ylm_emit_report *report) {
  ylm_status s = YLM_OK;
  if (l->n == 0) return YLM_OK;
  switch (o->radius) {
  case YLM_EMIT_DENSITY:
    s = ylm__emit_density(l->n, landing, o, l->radius);
    for (size_t i = 0; s == YLM_OK && i < l->n; i++) /* merged ones alone have an area */
      l->radius[i] = fmax(l->radius[i], by_area(&landing[i], o));
    break;
  case YLM_EMIT_FOOTPRINT:
    for (size_t i = 0; i < l->n; i++) l->radius[i] = by_area(&landing[i], o);
    break;
  case YLM_EMIT_ANGLE:
    if (o->grid)
      by_texel(scene, landing, o, l);
    else
      by_angle(landing, o, l);
    break;
  case YLM_EMIT_NEIGHBOURS: s = by_neighbours(landing, o, l); break;
  default: /* nothing is left to settle */
    for (size_t i = 0; i < l->n; i++) l->radius[i] = o->fixed;
    for (int k = 0; k < 3; k++) report->radius[k] = o->fixed;
    return YLM_OK;
  }
  return s == YLM_OK ? settle(o, l, report) : s;
}
