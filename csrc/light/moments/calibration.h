/*
** calibration.h - the tuned constants of the sums over lights. Private to csrc/light.
**
** Sizes move the speed of sums: `make bench BENCH=light` prints nanoseconds for each pair of a light and a
** point, `make bench BENCH=many_lights` those of trees. Accuracies are columns of `make bench BENCH=accuracy`.
*/
#ifndef YLM_LIGHT_MOMENTS_CALIBRATION_H
#define YLM_LIGHT_MOMENTS_CALIBRATION_H

/* Lights whose geometry is kept at once, in the first-level cache. */
#define YLM__TILE 8
/* Above YLM__SPECIAL, for one kind of sums in one channel, and for three channels. Sums are loaded and stored once a
   tile. */
#define YLM__TILE_ONE 16
#define YLM__TILE_RGB 32
/* Lights after which a partial sum is added to the total; a multiple of each. Moved by: errors of float
   sums of 10^5 lights. */
#define YLM__BLOCK 256
/* The highest lmax with a kernel of its own, gen/moments_L.h: beyond, the registers hold a small part of the
   sums in any case. */
#define YLM__SPECIAL 10
/* Sums that fit into the vector registers beside the rest; lua/ylm/codegen/moments.lua (budgets) has the same
   for kernels of their own. */
#if defined(__AVX512F__) || defined(__aarch64__)
#define YLM__SUMS 24
#else
#define YLM__SUMS 12
#endif

/* Columns of orders below this are found by differences from the pole, in float. Moved by: errors, which stay
   below 0.9 of the bound (single ones 1.03; spec/bench/accuracy.c). */
#define YLM__FINE(lmax) ((lmax) < 5 ? 0 : (lmax) < 11 ? 1 : ((lmax)-4) / 3)

#endif
