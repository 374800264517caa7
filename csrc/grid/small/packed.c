/* packed.c - rows of points in words of one size, for devices: what they are rounded to, and what that costs. */
#include <math.h>
#include <string.h>

#include "small.h"

#define PLACES 16384 /* that rounding is looked at */
#define KINDS 4      /* of numbers of a coefficient: its value, three slopes */

static const int bits_of[KINDS] = {YLM_PACKED_VALUE, YLM_PACKED_SLOPE, YLM_PACKED_SLOPE,
                                   YLM_PACKED_SLOPE};

static int most_of(int kind) { return (1 << (bits_of[kind] - 1)) - 1; }

/* The largest of n numbers without their signs; NaN and infinities come through. */
static float largest(const float *x, size_t n, float so_far) {
  for (size_t i = 0; i < n; i++)
    if (!(fabsf(x[i]) <= so_far)) so_far = isfinite(x[i]) ? fabsf(x[i]) : INFINITY;
  return so_far;
}

/* Packs a row [rows][stride] of width numbers into word [width + 2], and what it is then into `to`; false: a number is not
   finite. */
static bool pack_row(const ylm_grid *g, const float *row, uint32_t *word, float *to) {
  size_t width = g->width, stride = g->contents.stride;
  float scale[2] = {largest(row, width, 0), 0};
  for (int a = 1; a < KINDS; a++) scale[1] = largest(row + (size_t)a * stride, width, scale[1]);
  if (!isfinite(scale[0]) || !isfinite(scale[1])) return false;
  for (size_t j = 0; j < width; j++) {
    word[j] = 0;
    for (int a = 0, shift = 0; a < KINDS; shift += bits_of[a++]) {
      float unit = scale[a > 0] / (float)most_of(a);
      long q = unit > 0 ? lrintf(row[(size_t)a * stride + j] / unit) : 0;
      q = q > most_of(a) ? most_of(a) : q < -most_of(a) ? -most_of(a) : q;
      word[j] |= ((uint32_t)q & ((1u << bits_of[a]) - 1)) << shift;
      to[(size_t)a * stride + j] = (float)q * unit;
    }
  }
  for (int k = 0; k < 2; k++) {
    float unit = scale[k] / (float)most_of(k);
    memcpy(&word[width + (size_t)k], &unit, sizeof unit);
  }
  return true;
}

/* Errors of light that is read from rounded rows, against the grid's own. */
static ylm_status measure_packing(const ylm_grid *g, float *rounded, int threads,
                                  ylm_grid_packing *report, ylm_error *e) {
  ylm_grid other = *g; /* sampling reads a grid alone */
  other.data = rounded;
  other.contents.data = rounded;
  double *error = ylm_alloc(PLACES, sizeof *error);
  if (!error) return ylm_no_memory(e);
  ylm_status s = ylm__small_errors(g, &other, threads, PLACES, error, e);
  if (s == YLM_OK) {
    double rounding = ylm__small_quantile(error, PLACES, 0.99);
    *report = (ylm_grid_packing){.error = g->stats.error + rounding,
                                 .rounding = rounding,
                                 .largest = ylm__small_quantile(error, PLACES, 1),
                                 .places = PLACES};
  }
  ylm_free(error);
  return s;
}

ylm_status ylm_grid_pack(const ylm_grid *g, int threads, uint32_t *word, ylm_grid_packing *report,
                         ylm_error *e) {
  const ylm_grid_contents *v = ylm_grid_look(g);
  size_t width = g->width, row = KINDS * v->stride;
  if (v->form.sides)
    return ylm_fail(e, YLM_EINVAL,
                    "packed: points beside walls have no slopes: a grid with sides is not packed");
  float *rounded = ylm_alloc(v->points * row + KINDS * v->stride, sizeof *rounded);
  if (!rounded) return ylm_no_memory(e);
  memset(rounded, 0, (v->points * row + KINDS * v->stride) * sizeof *rounded);
  bool finite = true;
  for (size_t i = 0; finite && i < v->points; i++)
    finite = pack_row(g, v->data + i * row, word + i * (width + 2), rounded + i * row);
  ylm_status s =
      finite ? YLM_OK : ylm_fail(e, YLM_EDOMAIN, "packed: the grid's light is not finite");
  if (s == YLM_OK) s = measure_packing(g, rounded, threads, report, e);
  ylm_free(rounded);
  return s;
}
