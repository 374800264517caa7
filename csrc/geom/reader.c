/* reader.c - blocks that grow, polygons, lines. */
#include "reader.h"
#include "ylm_list.h"

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
