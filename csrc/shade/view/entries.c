/*
** entries.c - what pictures of a view are made of, as arrays: for those that make them elsewhere.
*/
#include <math.h>
#include <string.h>

#include "../view.h"

static void write_pixel(const shade_pixel *p, size_t i, const ylm_shade_entries *out) {
  if (out->first) out->first[i] = (double)p->first;
  if (!out->shown) return;
  memcpy(out->shown + 4 * i, p->lamps, sizeof p->lamps);
  out->shown[4 * i + 3] = fmaxf(0, 1 - p->coverage - p->emitter);
}

static void write_entry(const ylm_shade_view *v, size_t i, const ylm_shade_entries *out) {
  const shade_entry *e = &v->entry[i];
  if (out->weight) out->weight[i] = e->weight;
  if (out->depth) out->depth[i] = e->depth;
  for (int k = 0; out->point && k < 3; k++)
    out->point[3 * i + (size_t)k] = v->corner ? (double)v->corner[i][k] : (double)i;
  if (out->part) ylm__shade_corner_weights(e, out->part + 3 * i);
}

size_t ylm_shade_view_entries(const ylm_shade_view *v, const ylm_shade_entries *out) {
  if (!out) return v->entries;
  for (size_t i = 0; i < v->stats.pixels; i++) write_pixel(&v->pixel[i], i, out);
  if (out->first) out->first[v->stats.pixels] = (double)v->entries;
  for (size_t i = 0; i < v->entries; i++) write_entry(v, i, out);
  return v->entries;
}

void ylm_shade_view_camera(const ylm_shade_view *v, double out[10]) {
  memcpy(out, v->frame.right, sizeof v->frame.right);
  memcpy(out + 3, v->frame.up, sizeof v->frame.up);
  memcpy(out + 6, v->frame.forward, sizeof v->frame.forward);
  out[9] = v->frame.pixel;
}
