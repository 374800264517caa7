/* lattice.h - the inside of a closed mesh at the points of a lattice. Private to the room. */
#ifndef YLM_GEOM_LATTICE_H
#define YLM_GEOM_LATTICE_H

#include "ylm_geom.h"

#define LATTICE_MOST ((size_t)1 << 23) /* points */

/* Points of a lattice around a mesh: point (i, j, k) is low + step (i, j, k). */
typedef struct ylm__lattice {
  double low[3], step, volume; /* volume: of the mesh, by its triangles */
  size_t n[3], points, inside; /* inside: points in the mesh */
  uint8_t *in;                 /* [n[2]][n[1]][n[0]] 1 inside */
} ylm__lattice;

static inline size_t lattice_at(const ylm__lattice *l, size_t i, size_t j, size_t k) {
  return (k * l->n[1] + j) * l->n[0] + i;
}

/*
** ylm__lattice_create - about `inside` points in a closed mesh, fewer where it is thin.
**
** Returns  YLM_OK; YLM_EDOMAIN (empty, not finite, open, flat): `e` says what; YLM_ENOMEM. `in` is the caller's to free
*/
ylm_status ylm__lattice_create(const ylm_mesh *m, size_t inside, ylm__lattice *l, ylm_error *e);

/* The distance of each point inside from the nearest one outside, else 0: [points], the caller's to free; NULL: no memory. */
float *ylm__lattice_depth(const ylm__lattice *l);

#endif
