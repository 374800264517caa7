/*
** ylm_numbers.h - arrays of any element type: conversion, arithmetic, sums along axes, parts.
**
** Loops behind ylm.array of Lua. float and double are types to compute in, which all of ylm takes.
** int32 and float16 are types for storage: functions here and array files take them too.
*/
#ifndef YLM_NUMBERS_H
#define YLM_NUMBERS_H

#include "ylm_base.h"

#ifdef __cplusplus
extern "C" {
#endif

#define YLM_INT32 ((ylm_dtype)2)
#define YLM_FLOAT16 ((ylm_dtype)3) /* IEEE 754 binary16 */
#define YLM_NUMBERS_TYPES 4

/* Bytes of an element of any of the four types. */
static inline size_t ylm_numbers_size(ylm_dtype t) {
  return t == YLM_DOUBLE ? sizeof(double) : t == YLM_FLOAT16 ? sizeof(uint16_t) : sizeof(float);
}

/* "float", "double", "int32", "float16". */
YLM_API const char *ylm_numbers_type_name(ylm_dtype t);

/* The type in which numbers of type t are computed with: int32 in double, float16 in float. */
static inline ylm_dtype ylm_numbers_wide(ylm_dtype t) {
  return t == YLM_INT32 ? YLM_DOUBLE : t == YLM_FLOAT16 ? YLM_FLOAT : t;
}

/* An array of any element type that the caller owns. */
typedef struct ylm_numbers {
  ylm_dtype dtype;
  int axes;            /* 1 .. YLM_MAX_AXES */
  const size_t *shape; /* [axes] */
  const void *data;    /* dense, row-major */
} ylm_numbers;

/*
** ylm_numbers_convert - numbers of one element type to another, rounded to nearest, ties to even.
**
**   in     in   [n] of type from
**   out    out  [n] of type to
**   where  out  index of the first number that `to` does not hold; may be NULL
**
** Returns  YLM_OK; YLM_ERANGE: int32 holds whole numbers of 32 bits, float16 numbers up to 65504,
**          infinities and NaN. A double beyond the range of float becomes infinite.
*/
YLM_API ylm_status ylm_numbers_convert(ylm_dtype from, ylm_dtype to, size_t n, const void *in,
                                       void *out, size_t *where);

/* Two numbers to one. Comparisons give 1 or 0; with NaN, all but not_equal give 0. minimum and
   maximum give NaN where either is. */
#define YLM_NUMBERS_COMBINE_LIST(X)                                                                \
  X(add)                                                                                           \
  X(subtract)                                                                                      \
  X(multiply)                                                                                      \
  X(divide)                                                                                        \
  X(power)                                                                                         \
  X(minimum)                                                                                       \
  X(maximum)                                                                                       \
  X(less)                                                                                          \
  X(less_equal)                                                                                    \
  X(greater)                                                                                       \
  X(greater_equal)                                                                                 \
  X(equal)                                                                                         \
  X(not_equal)

typedef enum ylm_numbers_combine_op {
#define X(name) YLM_COMBINE_##name,
  YLM_NUMBERS_COMBINE_LIST(X)
#undef X
      YLM_COMBINE_COUNT
} ylm_numbers_combine_op;

/*
** ylm_numbers_broadcast - the shape of what two arrays are combined to (NumPy's rule): shapes are
** aligned at their last axes, and each pair of extents is equal or has a 1.
**
**   axes   out  of the result
**   shape  out  [YLM_MAX_AXES]
**
** Returns  YLM_OK; YLM_ESHAPE (extents that differ), YLM_EOVERFLOW
*/
YLM_API ylm_status ylm_numbers_broadcast(int axes_a, const size_t *shape_a, int axes_b,
                                         const size_t *shape_b, int *axes, size_t *shape);

/*
** ylm_numbers_combine - out[i] = op(a[i], b[i]), broadcast.
**
**   t        in   float or double: numbers are computed in this type
**   out      out  [shape of ylm_numbers_broadcast] of type t; of comparisons float. It may be a's or
**                 b's own memory where that has its type and the result's shape
**   threads  in   0: the default. Small arrays take one
**
** Returns  YLM_OK; YLM_ESHAPE, YLM_ENOMEM
*/
YLM_API ylm_status ylm_numbers_combine(ylm_numbers_combine_op op, const ylm_numbers *a,
                                       const ylm_numbers *b, ylm_dtype t, void *out, int threads);

/* One number to one: -x, |x|, the square root (NaN of negative numbers). */
#define YLM_NUMBERS_MAP_LIST(X) X(negate) X(absolute) X(root)

typedef enum ylm_numbers_map_op {
#define X(name) YLM_MAP_##name,
  YLM_NUMBERS_MAP_LIST(X)
#undef X
      YLM_MAP_COUNT
} ylm_numbers_map_op;

/* out[i] = op(in[i]); out has the type ylm_numbers_wide(t). */
YLM_API void ylm_numbers_map(ylm_numbers_map_op op, ylm_dtype t, size_t n, const void *in,
                             void *out);

/* Many numbers to one. min and max give NaN where one is there. */
#define YLM_NUMBERS_REDUCE_LIST(X) X(sum) X(mean) X(min) X(max)

typedef enum ylm_numbers_reduce_op {
#define X(name) YLM_REDUCE_##name,
  YLM_NUMBERS_REDUCE_LIST(X)
#undef X
      YLM_REDUCE_COUNT
} ylm_numbers_reduce_op;

/*
** ylm_numbers_reduce - the middle axis of [outer][n][inner] to one number.
**
**   in   in   [outer][n][inner] of type t
**   out  out  [outer][inner] doubles
**
** Sums are compensated: their error is a few roundings, whatever n.
** Returns  YLM_OK; YLM_EDOMAIN (n = 0, other than of a sum), YLM_ENOMEM (int32, float16)
** Source   Neumaier 1974; Ogita, Rump & Oishi 2005, "Sum2"
*/
YLM_API ylm_status ylm_numbers_reduce(ylm_numbers_reduce_op op, ylm_dtype t, size_t outer, size_t n,
                                      size_t inner, const void *in, double *out);

/* The part of one axis that a slice takes: elements first, first + step, ..; count of them. */
typedef struct ylm_slice {
  size_t first;
  ptrdiff_t step;
  size_t count;
} ylm_slice;

/*
** ylm_slices_run - true where the elements of slices lie together in memory, in order.
** ylm_slices_gather - copies them out of an array; ylm_slices_scatter - puts them in.
**
**   axes    in      1 .. YLM_MAX_AXES
**   shape   in      [axes] of the array
**   slice   in      [axes], within the shape
**   start   out     index of the first element
**   size    in      bytes an element: 2, 4 or 8
**   array   in/out  [shape]
**   dense   out/in  [slice[0].count] .. [slice[axes-1].count]
*/
YLM_API bool ylm_slices_run(int axes, const size_t *shape, const ylm_slice *slice, size_t *start);
YLM_API void ylm_slices_gather(int axes, const size_t *shape, const ylm_slice *slice, size_t size,
                               const void *array, void *dense);
YLM_API void ylm_slices_scatter(int axes, const size_t *shape, const ylm_slice *slice, size_t size,
                                void *array, const void *dense);

#ifdef __cplusplus
}
#endif
#endif
