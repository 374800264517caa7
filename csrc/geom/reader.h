/* reader.h - what the mesh readers share. Private to csrc/geom. */
#ifndef YLM_GEOM_READER_H
#define YLM_GEOM_READER_H

#include "ylm_geom.h"

/* A block that grows by doubling. */
typedef struct ylm_growing {
  void *data;
  size_t count, room, size; /* size of one item */
} ylm_growing;

/* Room for `more` further items; returns where they go (count is not raised), or NULL. */
void *ylm__grow(ylm_growing *g, size_t more);

/* A triangle corner: zero-based indices, UINT32_MAX where there is none. */
typedef struct ylm_corner {
  uint32_t v, t, n;
} ylm_corner;

#define YLM_NO_INDEX UINT32_MAX

/* Adds the fan of a polygon's corners to `triangles` (items are ylm_corner). False: no memory. */
bool ylm__add_polygon(ylm_growing *triangles, const ylm_corner *corner, size_t n);

/*
** A decimal number at *p, ended by `end`: sign, digits, point, exponent; correctly rounded.
** On success *p is behind it. False if there is none. "nan" and "inf" are none.
*/
bool ylm__read_number(const unsigned char **p, const unsigned char *end, double *x);

#endif
