/* file.c - photometric files: which format, lines and notes; symmetries undone. */
#include "file.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ylm_list.h"

#define MOST_TEXTS 1000
#define LONGEST 10000 /* of a text */

/* -- lines ----------------------------------------------------------------------------------------- */

bool ylm__photometric_next(ylm__photometric_text *t, ylm__photometric_line *line) {
  if (t->p >= t->end) return false;
  const unsigned char *from = t->p, *to;
  while (t->p < t->end && *t->p != '\n' && *t->p != '\r') t->p++;
  to = t->p;
  if (t->p < t->end) t->p += t->end - t->p > 1 && t->p[0] == '\r' && t->p[1] == '\n' ? 2 : 1;
  while (from < to && (*from == ' ' || *from == '\t')) from++;
  while (to > from && (to[-1] == ' ' || to[-1] == '\t')) to--;
  *line = (ylm__photometric_line){from, (size_t)(to - from), t->line++};
  return true;
}

static int upper(int c) { return c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c; }

bool ylm__photometric_begins(const ylm__photometric_line *line, const char *word) {
  size_t n = strlen(word);
  if (line->n < n) return false;
  for (size_t i = 0; i < n; i++)
    if (upper(line->p[i]) != upper((unsigned char)word[i])) return false;
  return true;
}

ylm_status ylm__photometric_fail(const ylm__photometric_text *t, size_t line, const char *format,
                                 ...) {
  char text[300];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return ylm_fail(t->e, YLM_EFORMAT, "%s:%zu: %s", t->name, line, text);
}

/* -- texts and notes ------------------------------------------------------------------------------- */

static char *copy(const void *from, size_t n) {
  char *to = ylm_alloc(n + 1, 1);
  if (!to) return NULL;
  ylm_copy(to, from, n);
  to[n] = 0;
  return to;
}

ylm_status ylm__photometric_add(ylm_light_photometry_file *f, const char *name,
                                const unsigned char *text, size_t n) {
  if (f->texts >= MOST_TEXTS) return YLM_OK;
  if (!ylm_list_resize(&f->text, f->texts, f->texts + 1, sizeof *f->text)) return YLM_ENOMEM;
  ylm_light_photometry_text *to = &f->text[f->texts];
  to->name = copy(name, strlen(name));
  to->text = copy(text, n < LONGEST ? n : LONGEST);
  f->texts++;
  return to->name && to->text ? YLM_OK : YLM_ENOMEM;
}

ylm_status ylm__photometric_note(ylm_light_photometry_file *f, const char *format, ...) {
  char text[300];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  if (!ylm_list_resize(&f->note, f->notes, f->notes + 1, sizeof *f->note)) return YLM_ENOMEM;
  f->note[f->notes] = copy(text, strlen(text));
  return f->note[f->notes++] ? YLM_OK : YLM_ENOMEM;
}

void ylm_light_photometry_file_free(ylm_light_photometry_file *f) {
  for (size_t i = 0; i < f->texts; i++) ylm_free(f->text[i].name), ylm_free(f->text[i].text);
  for (size_t i = 0; i < f->notes; i++) ylm_free(f->note[i]);
  ylm_free(f->text);
  ylm_free(f->note);
  ylm_free(f->angle);
  ylm_free(f->plane);
  ylm_free(f->candela);
  ylm_free(f->tilt_file);
  *f = (ylm_light_photometry_file){0};
}

/* -- symmetries ------------------------------------------------------------------------------------ */

/* A plane around the axis, and the row that it shows. */
typedef struct turned {
  double angle;
  size_t row, order;
} turned;

static int compare(const void *a, const void *b) {
  const turned *x = a, *y = b;
  if (x->angle != y->angle) return x->angle < y->angle ? -1 : 1;
  return x->order < y->order ? -1 : x->order > y->order;
}

static double within_turn(double angle) {
  double a = fmod(angle, 360);
  a = a < 0 ? a + 360 : a;
  return a >= 360 - 1e-9 ? 0 : a;
}

/* Where a row's plane is seen: up to four angles. */
static size_t mirrors(double a, ylm__photometric_symmetry s, double out[4]) {
  size_t n = 0;
  out[n++] = a;
  if (s == YLM__PHOTOMETRIC_HALVES || s == YLM__PHOTOMETRIC_QUARTERS) out[n++] = -a;
  if (s == YLM__PHOTOMETRIC_SIDES || s == YLM__PHOTOMETRIC_QUARTERS) out[n++] = 180 - a;
  if (s == YLM__PHOTOMETRIC_QUARTERS) out[n++] = 180 + a;
  return n;
}

/* All planes in order, each once; returns how many there are. */
static size_t turn_all(size_t rows, const double *plane, ylm__photometric_symmetry s, turned *to) {
  size_t n = 0, kept = 0;
  if (s == YLM__PHOTOMETRIC_ROUND) {
    to[0] = (turned){0, 0, 0};
    return 1;
  }
  for (size_t i = 0; i < rows; i++) {
    double at[4];
    size_t many = mirrors(plane[i], s, at);
    for (size_t k = 0; k < many; k++, n++) to[n] = (turned){within_turn(at[k]), i, n};
  }
  qsort(to, n, sizeof *to, compare);
  for (size_t i = 0; i < n; i++)
    if (kept == 0 || to[i].angle - to[kept - 1].angle > 1e-9) to[kept++] = to[i];
  return kept;
}

/* Negative numbers are 0. */
static ylm_status clip(ylm_light_photometry_file *f, const ylm__photometric_text *t) {
  size_t n = f->planes * f->angles, negative = 0, above = 0;
  double least = 0;
  for (size_t i = 0; i < n; i++) {
    negative += f->candela[i] < 0;
    above += f->candela[i] > 0;
    least = fmin(least, f->candela[i]);
    f->candela[i] = fmax(0, f->candela[i]);
  }
  if (negative && !above) return ylm__photometric_fail(t, t->line, "no intensity is above 0");
  if (!above) return ylm__photometric_note(f, "all intensities are 0: the lamp is dark");
  return negative ? ylm__photometric_note(f, "negative intensities, to %g cd, are taken as 0: %zu",
                                          least, negative)
                  : YLM_OK;
}

/* All planes share their value at an end of the angles that is a pole. */
static ylm_status join(ylm_light_photometry_file *f, size_t at, double pole) {
  double sum = 0, least = INFINITY, most = 0, peak = 0;
  if (f->angle[at] != pole || f->planes < 2) return YLM_OK;
  for (size_t i = 0; i < f->planes * f->angles; i++) peak = fmax(peak, f->candela[i]);
  for (size_t k = 0; k < f->planes; k++) {
    double x = f->candela[k * f->angles + at];
    sum += x;
    least = fmin(least, x), most = fmax(most, x);
  }
  for (size_t k = 0; k < f->planes && most > least; k++)
    f->candela[k * f->angles + at] = sum / (double)f->planes;
  return most - least > 0.01 * peak
             ? ylm__photometric_note(
                   f, "planes differ at %g degrees, %g to %g cd: their mean is taken", pole, least,
                   most)
             : YLM_OK;
}

ylm_status ylm__photometric_unfold(ylm_light_photometry_file *f, size_t rows, const double *plane,
                                   const double *candela, ylm__photometric_symmetry symmetry,
                                   const ylm__photometric_text *t) {
  turned *all = ylm_alloc(4 * rows, sizeof *all);
  if (!all) return YLM_ENOMEM;
  size_t n = turn_all(rows, plane, symmetry, all);
  if (n > YLM_LIGHT_PHOTOMETRY_ANGLES || n * f->angles > YLM_LIGHT_PHOTOMETRY_NUMBERS) {
    ylm_free(all);
    return ylm_fail(t->e, YLM_ELIMIT,
                    "%s: %zu planes of %zu angles; a table has at most %d planes and %zu numbers",
                    t->name, n, f->angles, YLM_LIGHT_PHOTOMETRY_ANGLES,
                    YLM_LIGHT_PHOTOMETRY_NUMBERS);
  }
  f->planes = n;
  f->plane = ylm_alloc(n, sizeof *f->plane);
  f->candela = ylm_alloc(n * f->angles, sizeof *f->candela);
  bool ok = f->plane && f->candela;
  for (size_t i = 0; i < n && ok; i++) {
    f->plane[i] = all[i].angle;
    memcpy(f->candela + i * f->angles, candela + all[i].row * f->angles,
           f->angles * sizeof *candela);
  }
  ylm_free(all);
  if (!ok) return YLM_ENOMEM;
  ylm_status s = clip(f, t);
  if (s == YLM_OK) s = join(f, 0, 0);
  return s == YLM_OK ? join(f, f->angles - 1, 180) : s;
}

/* -- formats --------------------------------------------------------------------------------------- */

static ylm__photometric_line first_line(const unsigned char *bytes, size_t size) {
  ylm__photometric_text t = {bytes, bytes + size, 1, NULL, NULL};
  ylm__photometric_line line = {bytes, 0, 1};
  ylm__photometric_next(&t, &line);
  return line;
}

/* Whether a line begins with TILT=, blanks within allowed. */
static bool has_tilt(const unsigned char *bytes, size_t size) {
  ylm__photometric_text t = {bytes, bytes + size, 1, NULL, NULL};
  ylm__photometric_line line;
  while (t.line <= 200 && ylm__photometric_next(&t, &line))
    if (ylm__photometric_begins(&line, "TILT")) return true;
  return false;
}

/* Lines 2 to 7 of EULUMDAT are small numbers. */
static bool has_counts(const unsigned char *bytes, size_t size) {
  ylm__photometric_text t = {bytes, bytes + size, 1, NULL, NULL};
  ylm__photometric_line line;
  for (int i = 1; i <= 7; i++) {
    if (!ylm__photometric_next(&t, &line)) return false;
    if (i == 1) continue;
    if (line.n == 0 || line.n > 12) return false;
    for (size_t k = 0; k < line.n; k++)
      if (!strchr("0123456789.,+-eE", line.p[k]) || !line.p[k]) return false;
  }
  return true;
}

int ylm_light_photometry_is(const unsigned char *bytes, size_t size) {
  ylm__photometric_line line = first_line(bytes, size);
  if (ylm__photometric_begins(&line, "IESNA") || ylm__photometric_begins(&line, "IES:") ||
      has_tilt(bytes, size))
    return 'i';
  return has_counts(bytes, size) ? 'l' : 0;
}

ylm_status ylm_light_photometry_read(const unsigned char *bytes, size_t size, const char *name,
                                     const ylm_light_photometry_form *form,
                                     ylm_light_photometry_file *out, ylm_error *e) {
  ylm__photometric_text t = {bytes, bytes + size, 1, name, e};
  ylm_status s;
  *out = (ylm_light_photometry_file){0};
  if (size >= 2 &&
      ((bytes[0] == 0xff && bytes[1] == 0xfe) || (bytes[0] == 0xfe && bytes[1] == 0xff)))
    return ylm_fail(e, YLM_EFORMAT, "%s: UTF-16; photometric files are of 8-bit characters", name);
  if (memchr(bytes, 0, size))
    return ylm_fail(e, YLM_EFORMAT, "%s: a zero byte: not a photometric file", name);
  if (size >= 3 && memcmp(bytes, "\xef\xbb\xbf", 3) == 0) t.p += 3;
  switch (ylm_light_photometry_is(t.p, (size_t)(t.end - t.p))) {
  case 'i': s = ylm__photometric_read_ies(&t, form, out); break;
  case 'l': s = ylm__photometric_read_ldt(&t, form, out); break;
  default:
    s = ylm_fail(e, YLM_EFORMAT,
                 "%s: neither IES LM-63 (no TILT= in the first 200 lines) nor EULUMDAT (lines 2 to "
                 "7 are no numbers)",
                 name);
  }
  if (s == YLM_OK) return s;
  ylm_light_photometry_file_free(out);
  return s == YLM_ENOMEM ? ylm_no_memory_for(e, name) : s;
}
