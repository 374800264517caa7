/* numbers.c - element types: names, conversion. */
#include "numbers.h"

const char *ylm_numbers_type_name(ylm_dtype t) {
  static const char *const names[YLM_NUMBERS_TYPES] = {"float", "double", "int32", "float16"};
  return (unsigned)t < YLM_NUMBERS_TYPES ? names[t] : "?";
}

#define GET_float(x) (x)
#define GET_double(x) (x)
#define GET_int32(x) (x)
#define GET_float16(x) ylm__half_get(x)
#define TYPE_float float
#define TYPE_double double
#define TYPE_int32 int32_t
#define TYPE_float16 uint16_t

/* To types that hold everything, or all but what is beyond the range of float. */
#define TO_WIDE(from, to)                                                                          \
  static size_t from##_to_##to(size_t n, const TYPE_##from *in, to *out) {                         \
    for (size_t i = 0; i < n; i++) out[i] = (to)GET_##from(in[i]);                                 \
    return n;                                                                                      \
  }
TO_WIDE(float, double)
TO_WIDE(double, float)
TO_WIDE(int32, float)
TO_WIDE(int32, double)
TO_WIDE(float16, float)
TO_WIDE(float16, double)

/* To int32: the index of the first number that is not whole or too large; n where there is none. */
#define TO_INT32(from)                                                                             \
  static size_t from##_to_int32(size_t n, const TYPE_##from *in, int32_t *out) {                   \
    for (size_t i = 0; i < n; i++) {                                                               \
      double x = (double)GET_##from(in[i]);                                                        \
      if (!(x >= -2147483648.0 && x <= 2147483647.0)) return i;                                    \
      out[i] = (int32_t)x;                                                                         \
      if ((double)out[i] != x) return i;                                                           \
    }                                                                                              \
    return n;                                                                                      \
  }
TO_INT32(float)
TO_INT32(double)
TO_INT32(float16)

/* To float16: the index of the first finite number that would become infinite. */
#define TO_HALF(from)                                                                              \
  static size_t from##_to_float16(size_t n, const TYPE_##from *in, uint16_t *out) {                \
    for (size_t i = 0; i < n; i++) {                                                               \
      double x = (double)in[i];                                                                    \
      if (__builtin_fabs(x) >= 65520 && __builtin_fabs(x) <= 0x1.fffffffffffffp1023) return i;     \
      out[i] = ylm__half_put(ylm__half_sticky(x));                                                 \
    }                                                                                              \
    return n;                                                                                      \
  }
TO_HALF(float)
TO_HALF(double)
TO_HALF(int32)

ylm_status ylm_numbers_convert(ylm_dtype from, ylm_dtype to, size_t n, const void *in, void *out,
                               size_t *where) {
  if (from == to) {
    ylm_copy(out, in, n * ylm_numbers_size(from));
    return YLM_OK;
  }
  size_t good = n;
  switch (from * YLM_NUMBERS_TYPES + to) {
#define CASE(FROM, from, TO, to)                                                                   \
  case YLM_##FROM *YLM_NUMBERS_TYPES + YLM_##TO: good = from##_to_##to(n, in, out); break;
    CASE(FLOAT, float, DOUBLE, double)
    CASE(FLOAT, float, INT32, int32)
    CASE(FLOAT, float, FLOAT16, float16)
    CASE(DOUBLE, double, FLOAT, float)
    CASE(DOUBLE, double, INT32, int32)
    CASE(DOUBLE, double, FLOAT16, float16)
    CASE(INT32, int32, FLOAT, float)
    CASE(INT32, int32, DOUBLE, double)
    CASE(INT32, int32, FLOAT16, float16)
    CASE(FLOAT16, float16, FLOAT, float)
    CASE(FLOAT16, float16, DOUBLE, double)
    CASE(FLOAT16, float16, INT32, int32)
#undef CASE
  default: return YLM_ETYPE;
  }
  if (good == n) return YLM_OK;
  if (where) *where = good;
  return YLM_ERANGE;
}
