/* cuts.h - how a triangle is cut into elements, and which of them has a place. Private to csrc/transfer. */
#ifndef YLM_TRANSFER_CUTS_H
#define YLM_TRANSFER_CUTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* A triangle, as far as cuts depend on it. */
typedef struct transfer_shape {
  float
      edge; /* the longest; below 0: there is no area, a triangle that floats cannot tell from a line */
  float
      height; /* above that edge; where the foot is at a corner, the edge from there to the apex */
  float
      foot; /* of the height: how far along the edge from the corner behind `apex`; 0 and 1 near corners */
  float along
      [2]; /* the longest line of rows of the parts before the foot and behind it; 0: there is none */
  uint8_t apex; /* the corner opposite to that edge */
} transfer_shape;

/* The cut of a triangle, as files have it. */
typedef struct transfer_cut {
  uint16_t k;       /* k^2 equal elements, 0: no area; of strips: apex */
  uint16_t columns; /* of strips; 0: none are */
  uint16_t rows[2]; /* of strips before the foot and behind it */
} transfer_cut;

transfer_shape ylm__cut_shape(double p[3][3]);
/* The shape of a triangle so many times as large. */
void ylm__cut_scale(transfer_shape *s, float by);
/* Pieces of the longest edge. */
double ylm__cut_pieces(const transfer_shape *s, double spacing);
/* How many elements ylm__cut_of makes; whole. */
double ylm__cut_number(const transfer_shape *s, double spacing);
/* The cut whose elements have no edge beyond the spacing, of strips beyond 1.3 times that; its numbers must fit. */
transfer_cut ylm__cut_of(const transfer_shape *s, double spacing);
/* Whether a cut of a file can be that, but for rounding. */
bool ylm__cut_can_be(const transfer_shape *s, double spacing, const transfer_cut *c);
size_t ylm__cut_size(const transfer_cut *c);
/* The corners of element x of a triangle, as weights (u, v) of its second and third corner. */
void ylm__cut_corners(const transfer_cut *c, float foot, size_t x, float corner[3][2]);
/* The element that has a place (u, v). */
size_t ylm__cut_at(const transfer_cut *c, float foot, float u, float v);
/* A cut about half as fine. */
transfer_cut ylm__cut_coarse(const transfer_cut *c);

/* The part of a triangle that is between these corners; negative where they turn the other way. */
static inline double ylm__cut_share(float corner[3][2]) {
  double a = (double)corner[1][0] - (double)corner[0][0];
  double b = (double)corner[1][1] - (double)corner[0][1];
  double c = (double)corner[2][0] - (double)corner[0][0];
  double d = (double)corner[2][1] - (double)corner[0][1];
  return a * d - b * c;
}

#endif
