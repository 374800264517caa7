/* decimal.c - decimal numbers in texts. */
#include "ylm_decimal.h"

#include <stdlib.h>
#include <string.h>

static bool is_digit(const unsigned char *p, const unsigned char *end) {
  return p < end && *p >= '0' && *p <= '9';
}

/* The slow way, for numbers that the fast one cannot round correctly. */
static bool convert(const unsigned char *from, const unsigned char *to, double *x) {
  char word[512];
  size_t n = (size_t)(to - from);
  if (n >= sizeof word) return false;
  memcpy(word, from, n);
  word[n] = 0;
  *x = strtod(word, NULL);
  return true;
}

bool ylm_decimal_read(const unsigned char **at, const unsigned char *end, double *x) {
  static const double power[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                 1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
  const unsigned char *p = *at, *start = p;
  bool negative = p < end && *p == '-';
  if (p < end && (*p == '-' || *p == '+')) p++;
  uint64_t mantissa = 0;
  int digits = 0, exponent = 0;
  const unsigned char *first = p;
  for (; is_digit(p, end); p++) {
    if (digits < 19)
      mantissa = 10 * mantissa + (uint64_t)(*p - '0'), digits += mantissa > 0;
    else
      digits = 99;
  }
  size_t seen = (size_t)(p - first);
  if (p < end && *p == '.') {
    for (p++; is_digit(p, end); p++, seen++) {
      if (digits < 19)
        mantissa = 10 * mantissa + (uint64_t)(*p - '0'), digits += mantissa > 0, exponent--;
      else if (*p != '0')
        digits = 99;
    }
  }
  if (seen == 0) return false;
  if (p < end && (*p == 'e' || *p == 'E')) {
    const unsigned char *q = p + 1;
    bool down = q < end && *q == '-';
    if (q < end && (*q == '-' || *q == '+')) q++;
    if (is_digit(q, end)) {
      int k = 0;
      for (; is_digit(q, end); q++)
        if (k < 100000) k = 10 * k + (*q - '0');
      exponent += down ? -k : k;
      p = q;
    }
  }
  if (digits <= 19 && mantissa <= (uint64_t)1 << 53 && exponent >= -22 && exponent <= 22) {
    double m = (double)mantissa; /* exact, and so is the power: one rounding */
    m = exponent < 0 ? m / power[-exponent] : m * power[exponent];
    *x = negative ? -m : m;
  } else if (!convert(start, p, x)) {
    return false;
  }
  *at = p;
  return true;
}
