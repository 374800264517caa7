/* reader.c - numbers from text, blocks that grow, polygons. */
#include "reader.h"
#include "ylm_list.h"

#include <stdlib.h>
#include <string.h>

void *ylm__grow(ylm_growing *g, size_t more) {
  if (!ylm_list_reserve(&g->data, g->count, g->count + more, &g->room, g->size)) return NULL;
  return (char *)g->data + g->count * g->size;
}

bool ylm__add_polygon(ylm_growing *triangles, const ylm_corner *corner, size_t n) {
  if (n < 3) return true;
  ylm_corner *out = ylm__grow(triangles, 3 * (n - 2));
  if (!out) return false;
  for (size_t i = 2; i < n; i++) {
    *out++ = corner[0];
    *out++ = corner[i - 1];
    *out++ = corner[i];
  }
  triangles->count += 3 * (n - 2);
  return true;
}

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

bool ylm__read_number(const unsigned char **at, const unsigned char *end, double *x) {
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

/* -- lines ---------------------------------------------------------------------- */

bool ylm__at_line_end(const ylm_lines *s) {
  return s->p == s->end || *s->p == '\n' || *s->p == '\r';
}

void ylm__skip_blanks(ylm_lines *s) {
  for (;;) {
    if (s->p < s->end && (*s->p == ' ' || *s->p == '\t'))
      s->p++;
    else if (s->end - s->p >= 2 && s->p[0] == '\\' && s->p[1] == '\n')
      s->p += 2, s->line++;
    else if (s->end - s->p >= 3 && s->p[0] == '\\' && s->p[1] == '\r' && s->p[2] == '\n')
      s->p += 3, s->line++;
    else
      return;
  }
}

void ylm__skip_line(ylm_lines *s) {
  while (!ylm__at_line_end(s)) {
    if (*s->p == '\\') {
      const unsigned char *before = s->p;
      ylm__skip_blanks(s);
      if (s->p != before) continue;
    }
    s->p++;
  }
}

void ylm__next_line(ylm_lines *s) {
  if (s->p < s->end && *s->p == '\r') s->p++;
  if (s->p < s->end && *s->p == '\n') s->p++;
  s->line++;
}

size_t ylm__skip_word(ylm_lines *s) {
  const unsigned char *word = s->p;
  while (!ylm__at_line_end(s) && *s->p != ' ' && *s->p != '\t' && *s->p != '\\') s->p++;
  return (size_t)(s->p - word);
}

static int lower(int c) { return c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c; }

bool ylm__is_word(const unsigned char *word, size_t n, const char *name) {
  size_t i = 0;
  while (i < n && name[i] && lower(word[i]) == lower((unsigned char)name[i])) i++;
  return i == n && name[i] == 0;
}

bool ylm__is_statement(const unsigned char *word, size_t n) {
  return n > 0 && ((lower(word[0]) >= 'a' && lower(word[0]) <= 'z') || word[0] == '#');
}

ylm_status ylm__rest_of_line(ylm_lines *s, char **out) {
  ylm__skip_blanks(s);
  ylm_lines ahead = *s;
  ylm__skip_line(&ahead);
  char *text = *out = ylm_alloc((size_t)(ahead.p - s->p) + 1, 1);
  size_t n = 0;
  if (!text) return YLM_ENOMEM;
  while (s->p < ahead.p) {
    size_t line = s->line;
    const unsigned char *before = s->p;
    if (*s->p == '\\') ylm__skip_blanks(s);
    if (s->p == before)
      text[n++] = (char)*s->p++;
    else if (s->line > line)
      text[n++] = ' ';
  }
  while (n > 0 && (text[n - 1] == ' ' || text[n - 1] == '\t')) n--;
  text[n] = 0;
  if (strlen(text) == n) return YLM_OK;
  ylm_free(text);
  *out = NULL;
  return YLM_EFORMAT;
}
