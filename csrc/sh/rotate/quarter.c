/*
** quarter.c - the quarter turn about x in every degree, from whole numbers.
**
** |J_qm| = g 2^-l sqrt(C(N, x) / C(N, k)) |K_k(x)|, N = 2l, k = l-|q|, x = l-|m|, with Krawtchouk's
** polynomials sum_k K_k(x) z^k = (1 - z)^x (1 + z)^(N-x); g = 2, sqrt 2 where one of q, m is 0, 1
** where both are.
**
** K is made of sums and differences of whole numbers below 2^252. Zeros are zeros, rational entries exact, and the others
** within 0.51 units in the last place where long double has 64 bits or more; the recurrence of ylm_sh_rotation_reference
** loses a digit every eight degrees above 40.
**
** Source  Koornwinder 1982 (Krawtchouk polynomials as elements of SU(2)'s representations);
** docs/math.md "Rotation"
*/
#include "ylm_sh.h"

#include <math.h>
#include <string.h>

#include "rotate.h"

/* -- whole numbers of 256 bits ---------------------------------------------------------------- */

__extension__ typedef unsigned __int128 word;

/* hi 2^128 + lo, two's complement */
typedef struct wide {
  word lo, hi;
} wide;

static wide add(wide a, wide b) {
  word lo = a.lo + b.lo;
  return (wide){lo, a.hi + b.hi + (lo < a.lo)};
}

static wide subtract(wide a, wide b) { return (wide){a.lo - b.lo, a.hi - b.hi - (a.lo < b.lo)}; }

static long double value(wide a) {
  bool negative = a.hi >> 127;
  if (negative) a = subtract((wide){0, 0}, a);
  long double x = ldexpl((long double)a.hi, 128) + (long double)a.lo;
  return negative ? -x : x;
}

/* -- one degree ------------------------------------------------------------------------------- */

/* Row n+1 of Pascal's triangle from row n, entries 0 .. last. */
static void pascal(int last, wide *row) {
  for (int k = last; k > 0; k--) row[k] = add(row[k], row[k - 1]);
}

/* K_k(x) of all k from those of x-1: (1 + z) K(x) = (1 - z) K(x-1). */
static void next_column(int last, const wide *before, wide *now) {
  now[0] = before[0];
  for (int k = 1; k <= last; k++) now[k] = subtract(subtract(before[k], before[k - 1]), now[k - 1]);
}

/* The sign that J_qm has besides that of K. */
static int sign_of(int q, int m) {
  int aq = q < 0 ? -q : q, am = m < 0 ? -m : m;
  bool negative = (aq / 2 + am / 2) & 1;
  if (q < 0 && m < 0) negative = !negative;
  if ((q < 0) != (m < 0) && !(aq & 1)) negative = !negative;
  return negative ? -1 : 1;
}

/* Entries (+-k, +-x) of degree l: two of the four, where J links the classes. */
static void put_entries(int l, int q, int m, double size, double *block) {
  for (int a = 0; a < 2; a++)
    for (int b = 0; b < 2; b++) {
      int row = a ? -q : q, column = b ? -m : m;
      if ((a && q == 0) || (b && m == 0)) continue;
      if (class_partner(l, class_of(column)) != class_of(row)) continue;
      block[(row + l) * (2 * l + 1) + column + l] = size == 0 ? 0 : sign_of(row, column) * size;
    }
}

ylm_status ylm__sh_quarter_turns(int lmax, double *blocks) {
  size_t n = (size_t)lmax + 1;
  wide *memory = ylm_alloc_zero(3 * n, sizeof *memory);
  long double *root = ylm_alloc(n, sizeof *root);
  if (!memory || !root) {
    ylm_free(memory);
    ylm_free(root);
    return YLM_ENOMEM;
  }
  wide *binomial = memory, *now = memory + n, *next = now + n;
  binomial[0].lo = 1;
  for (int l = 0; l <= lmax; l++) {
    int w = 2 * l + 1;
    if (l > 0) pascal(lmax, binomial), pascal(lmax, binomial);
    for (int k = 0; k <= l; k++) root[k] = sqrtl(value(binomial[k]));
    memset(blocks, 0, (size_t)(w * w) * sizeof *blocks);
    memcpy(now, binomial, ((size_t)l + 1) * sizeof *now);
    for (int x = 0; x <= l; x++) {
      for (int k = 0; k <= l; k++) {
        long double g = k == l && x == l ? 1 : k == l || x == l ? sqrtl(2) : 2;
        put_entries(l, l - k, l - x, (double)ldexpl(g * root[x] / root[k] * value(now[k]), -l),
                    blocks);
      }
      next_column(l, now, next);
      wide *swap = now;
      now = next;
      next = swap;
    }
    blocks += w * w;
  }
  ylm_free(memory);
  ylm_free(root);
  return YLM_OK;
}
