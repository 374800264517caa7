/* mtl.c - Wavefront MTL: the materials of an OBJ file. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "reader.h"

#define MOST_EXPONENT 1e5

typedef struct parser {
  ylm_lines at;
  const char *name;
  ylm_error *e;
  ylm_growing material; /* ylm_mesh_material */
  ylm_mesh_library *library;
} parser;

/* Numbers of a statement: n, or one for all n; each from 0 to `largest`. */
static ylm_status read_numbers(parser *s, const char *what, int n, double largest, float *out) {
  int read = 0;
  size_t line = s->at.line;
  for (; read < n; read++) {
    double x;
    ylm__skip_blanks(&s->at);
    if (!ylm_decimal_read(&s->at.p, s->at.end, &x)) break;
    out[read] = (float)x;
    if (!(x >= 0 && x <= largest))
      return ylm_fail(s->e, YLM_EFORMAT, "%s:%zu: number %d of %s must be from 0 to %g, got %g",
                      s->name, line, read + 1, what, largest, x);
  }
  if (read == 1)
    for (; read < n; read++) out[read] = out[0];
  bool ends = ylm__at_line_end(&s->at) || *s->at.p == ' ' || *s->at.p == '\t' || *s->at.p == '\\' ||
              *s->at.p == '#';
  if (read != n || !ends)
    return ylm_fail(s->e, YLM_EFORMAT,
                    n == 1 ? "%s:%zu: %s wants a number"
                           : "%s:%zu: %s wants three numbers, or one for all",
                    s->name, line, what);
  ylm__skip_line(&s->at);
  return YLM_OK;
}

/* Takes the rest of the line as a name. */
static ylm_status read_text(parser *s, const char *what, ylm_mesh_text *out) {
  char *text;
  size_t line = s->at.line;
  ylm_status st = ylm__rest_of_line(&s->at, &text);
  if (st == YLM_ENOMEM) return ylm_no_memory_for(s->e, s->name);
  if (st != YLM_OK)
    return ylm_fail(s->e, st, "%s:%zu: the name after %s has a zero byte", s->name, line, what);
  if (*text == 0) {
    ylm_free(text);
    return ylm_fail(s->e, YLM_EFORMAT, "%s:%zu: %s wants a name", s->name, line, what);
  }
  ylm_free(out->text);
  *out = (ylm_mesh_text){text, line};
  return YLM_OK;
}

/* Counts what is not read, and keeps the first names of it, each once. */
static void skip(parser *s, const unsigned char *word, size_t n) {
  ylm_mesh_library *l = s->library;
  size_t used = strlen(l->words);
  char name[32];
  l->skipped++;
  if (n >= sizeof name || memchr(word, 0, n)) return;
  memcpy(name, word, n);
  name[n] = 0;
  for (const char *p = l->words; (p = strstr(p, name)); p++) {
    bool begins = p == l->words || p[-1] == ' ', ends = p[n] == 0 || p[n] == ',';
    if (begins && ends) return;
  }
  if (used + n + 3 <= sizeof l->words)
    snprintf(l->words + used, sizeof l->words - used, "%s%s", used ? ", " : "", name);
}

/* How many words an option of map_Kd takes; -1: it is none. Of -o, -s and -t numbers follow. */
static int option_words(const unsigned char *word, size_t n) {
  static const struct {
    const char *name;
    int words;
  } options[] = {{"-blendu", 1}, {"-blendv", 1},  {"-boost", 1},  {"-bm", 1},   {"-cc", 1},
                 {"-clamp", 1},  {"-imfchan", 1}, {"-texres", 1}, {"-type", 1}, {"-mm", 2},
                 {"-o", 0},      {"-s", 0},       {"-t", 0}};
  for (size_t i = 0; i < sizeof options / sizeof *options; i++)
    if (ylm__is_word(word, n, options[i].name)) return options[i].words;
  return -1;
}

/* Passes over one option; false, where it stands, if there is none. */
static bool skip_option(parser *s) {
  ylm_lines before = s->at;
  const unsigned char *word = s->at.p;
  size_t n = ylm__skip_word(&s->at);
  int words = option_words(word, n);
  if (words < 0) {
    s->at = before;
    return false;
  }
  skip(s, word, n);
  for (int i = 0; i < words; i++) {
    ylm__skip_blanks(&s->at);
    ylm__skip_word(&s->at);
  }
  for (int i = 0; words == 0 && i < 3; i++) {
    double x;
    ylm_lines number = s->at;
    ylm__skip_blanks(&s->at);
    if (ylm_decimal_read(&s->at.p, s->at.end, &x) && !ylm__at_line_end(&s->at) &&
        (*s->at.p == ' ' || *s->at.p == '\t'))
      continue;
    s->at = number;
    break;
  }
  ylm__skip_blanks(&s->at);
  return true;
}

static ylm_status read_map(parser *s, ylm_mesh_material *m) {
  ylm__skip_blanks(&s->at);
  while (skip_option(s)) {
  }
  return read_text(s, "map_Kd", &m->map_kd);
}

static ylm_status begin_material(parser *s) {
  ylm_mesh_material *m = ylm__grow(&s->material, 1);
  if (!m) return ylm_no_memory_for(s->e, s->name);
  *m = (ylm_mesh_material){0};
  ylm_status st = read_text(s, "newmtl", &m->name);
  if (st == YLM_OK) s->material.count++;
  return st;
}

/* Whether a colour is given by other means than numbers. */
static bool is_other_colour(const parser *s) {
  ylm_lines at = s->at;
  ylm__skip_blanks(&at);
  const unsigned char *word = at.p;
  size_t n = ylm__skip_word(&at);
  return ylm__is_word(word, n, "spectral") || ylm__is_word(word, n, "xyz");
}

/* The statements that are read, of material m. */
static ylm_status read_property(parser *s, int which, ylm_mesh_material *m) {
  switch (which) {
  case 0: m->has_kd = true; return read_numbers(s, "Kd", 3, 1, m->kd);
  case 1: m->has_ks = true; return read_numbers(s, "Ks", 3, 1, m->ks);
  case 2: m->has_ke = true; return read_numbers(s, "Ke", 3, 1e30, m->ke);
  case 3: m->has_ns = true; return read_numbers(s, "Ns", 1, MOST_EXPONENT, &m->ns);
  default: return read_map(s, m);
  }
}

/* One line, from its first word on. */
static ylm_status read_statement(parser *s) {
  static const char *const names[] = {"Kd", "Ks", "Ke", "Ns", "map_Kd"};
  const unsigned char *word = s->at.p;
  size_t line = s->at.line, n = ylm__skip_word(&s->at);
  if (ylm__is_word(word, n, "newmtl")) return begin_material(s);
  if (!ylm__is_statement(word, n))
    return ylm_fail(s->e, YLM_EFORMAT, "%s:%zu: not a statement of an MTL file", s->name, line);
  for (int i = 0; i < 5; i++) {
    if (!ylm__is_word(word, n, names[i]) || (i < 3 && is_other_colour(s))) continue;
    if (s->material.count == 0)
      return ylm_fail(s->e, YLM_EFORMAT, "%s:%zu: %s before the first newmtl", s->name, line,
                      names[i]);
    return read_property(s, i, (ylm_mesh_material *)s->material.data + s->material.count - 1);
  }
  if (*word != '#') skip(s, word, n);
  ylm__skip_line(&s->at);
  return YLM_OK;
}

static void free_materials(ylm_mesh_material *m, size_t n) {
  for (size_t i = 0; i < n; i++) {
    ylm_free(m[i].name.text);
    ylm_free(m[i].map_kd.text);
  }
  ylm_free(m);
}

void ylm_mesh_library_free(ylm_mesh_library *l) {
  if (!l) return;
  free_materials(l->material, l->count);
  ylm_free(l);
}

ylm_status ylm_mesh_parse_mtl(const unsigned char *text, size_t size, const char *name,
                              ylm_mesh_library **library, ylm_error *e) {
  parser s = {.at = {text, text + size, 1}, .name = name, .e = e};
  s.material.size = sizeof(ylm_mesh_material);
  *library = NULL;
  s.library = ylm_alloc_zero(1, sizeof *s.library);
  ylm_status st = s.library ? YLM_OK : ylm_no_memory_for(e, name);
  if (size >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0) s.at.p += 3; /* a mark of UTF-8 */
  while (st == YLM_OK && s.at.p < s.at.end) {
    ylm__skip_blanks(&s.at);
    if (!ylm__at_line_end(&s.at)) st = read_statement(&s);
    if (st == YLM_OK) ylm__next_line(&s.at);
  }
  if (st == YLM_OK) {
    s.library->material = s.material.data;
    s.library->count = s.material.count;
    *library = s.library;
    return st;
  }
  free_materials(s.material.data, s.material.count);
  ylm_free(s.library);
  return st;
}
