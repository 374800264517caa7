/* ies.c - IES LM-63 files, 1986 to 2019: words, TILT, ten numbers of the lamp, three of its ballast, angles, intensities. */
#include "file.h"

#include <math.h>
#include <string.h>

#include "ylm_decimal.h"
#include "ylm_math.h"

#define HEAD_LINES 200
#define BRIGHTEST 1e20
#define FOOT 0.3048
#define LINE_WIDTH 0.01 /* m: of lines of light */

typedef ylm__photometric_text text;
typedef ylm__photometric_line line;

/* -- numbers --------------------------------------------------------------------------------------- */

static bool is_gap(int c) { return c == ' ' || c == '\t' || c == ',' || c == '\n' || c == '\r'; }

/* Passes over blanks, commas and line ends. */
static void skip_gap(text *t) {
  while (t->p < t->end && is_gap(*t->p)) {
    if (*t->p == '\n' || (*t->p == '\r' && (t->p + 1 == t->end || t->p[1] != '\n'))) t->line++;
    t->p++;
  }
}

/* A number that `what` names, `i` of n (n 0: the only one). */
static ylm_status number(text *t, const char *what, size_t i, size_t n, double *x) {
  skip_gap(t);
  if (t->p == t->end) {
    if (n > 0)
      return ylm__photometric_fail(t, t->line, "the file ends: %zu %s wanted, %zu there", n, what,
                                   i);
    return ylm__photometric_fail(t, t->line, "the file ends where %s is due", what);
  }
  const unsigned char *from = t->p;
  int shown = 0;
  if (ylm_decimal_read(&t->p, t->end, x) && (t->p == t->end || is_gap(*t->p)) &&
      fabs(*x) <= BRIGHTEST)
    return YLM_OK;
  while (from + shown < t->end && !is_gap(from[shown]) && shown < 30) shown++;
  return ylm__photometric_fail(t, t->line, "%s: a number expected, got \"%.*s\"", what, shown,
                               (const char *)from);
}

static ylm_status count(text *t, const char *what, double least, double most, size_t *n) {
  double x;
  ylm_status s = number(t, what, 0, 0, &x);
  if (s != YLM_OK) return s;
  if (!(x >= least && x <= most) || x != floor(x))
    return ylm__photometric_fail(t, t->line, "%s must be an integer from %g to %g, got %g", what,
                                 least, most, x);
  *n = (size_t)x;
  return YLM_OK;
}

/* n numbers, which increase where `rise`. The caller frees *out. */
static ylm_status numbers(text *t, const char *what, size_t n, bool rise, double **out) {
  double *x = *out = ylm_alloc(n, sizeof *x);
  if (!x) return YLM_ENOMEM;
  for (size_t i = 0; i < n; i++) {
    ylm_status s = number(t, what, i, n, x + i);
    if (s != YLM_OK) return s;
    if (rise && i > 0 && !(x[i] > x[i - 1]))
      return ylm__photometric_fail(t, t->line, "%s must increase: %g follows %g", what, x[i],
                                   x[i - 1]);
  }
  return YLM_OK;
}

/* -- head ------------------------------------------------------------------------------------------ */

static const char *version_of(const line *l) {
  static const char *const known[][2] = {{"IES:LM-63-2019", "IES LM-63-2019"},
                                         {"IESNA:LM-63-2002", "IES LM-63-2002"},
                                         {"IESNA:LM-63-1995", "IES LM-63-1995"},
                                         {"IESNA91", "IES LM-63-1991"}};
  for (size_t i = 0; i < sizeof known / sizeof *known; i++)
    if (ylm__photometric_begins(l, known[i][0])) return known[i][1];
  return ylm__photometric_begins(l, "IES") ? "IES LM-63, of another year" : "IES LM-63-1986";
}

/* A word "[NAME] text"; [MORE] goes on with the last one. Lines without a name are labels. */
static ylm_status add_word(ylm_light_photometry_file *f, const line *l) {
  const unsigned char *close = l->n && l->p[0] == '[' ? memchr(l->p, ']', l->n) : NULL;
  char name[64] = "LABEL";
  const unsigned char *from = l->p, *end = l->p + l->n;
  if (close) {
    size_t n = (size_t)(close - l->p) - 1;
    n = n < sizeof name - 1 ? n : sizeof name - 1;
    memcpy(name, l->p + 1, n);
    name[n] = 0;
    from = close + 1;
    while (from < end && *from == ' ') from++;
  }
  if (!l->n) return YLM_OK;
  return ylm__photometric_add(f, name, from, (size_t)(end - from));
}

/* The text behind TILT=, without blanks around it. */
static line tilt_of(const line *l) {
  const unsigned char *p = l->p + 4, *end = l->p + l->n;
  while (p < end && (*p == ' ' || *p == '\t' || *p == '=')) p++;
  return (line){p, (size_t)(end - p), l->line};
}

static bool is_word(const line *l, const char *word) {
  return l->n == strlen(word) && ylm__photometric_begins(l, word);
}

/* Words up to the line TILT=, which comes back. */
static ylm_status read_head(text *t, ylm_light_photometry_file *f, line *tilt) {
  line l;
  size_t blocks = 0;
  for (bool first = true; ylm__photometric_next(t, &l) && l.line <= HEAD_LINES; first = false) {
    if (first) {
      f->format = version_of(&l);
      if (ylm__photometric_begins(&l, "IES")) continue;
    }
    if (ylm__photometric_begins(&l, "TILT")) {
      *tilt = tilt_of(&l);
      return YLM_OK;
    }
    if (ylm__photometric_begins(&l, "[BLOCK]") && ++blocks > 1) break;
    ylm_status s = add_word(f, &l);
    if (s != YLM_OK) return s;
  }
  return ylm__photometric_fail(t, t->line, "no TILT= in the first %d lines: not an IES file",
                               HEAD_LINES);
}

/* -- tilt ------------------------------------------------------------------------------------------ */

/* The factor at an angle, linear between those of a table. */
static double factor_at(size_t n, const double *angle, const double *factor, double at) {
  size_t i = 0;
  if (at <= angle[0]) return factor[0];
  while (i + 2 < n && angle[i + 1] < at) i++;
  if (n < 2 || at >= angle[i + 1]) return factor[n - 1];
  double u = (at - angle[i]) / (angle[i + 1] - angle[i]);
  return factor[i] + u * (factor[i + 1] - factor[i]);
}

/* Lamp geometry, angles, factors. */
static ylm_status read_factors(text *t, double tilt, double *factor) {
  size_t geometry, n = 0;
  double *angle = NULL, *part = NULL;
  ylm_status s = count(t, "the lamp's geometry (TILT)", 1, 3, &geometry);
  if (s == YLM_OK) s = count(t, "the number of tilt angles", 1, 1000, &n);
  if (s == YLM_OK) s = numbers(t, "tilt angles", n, true, &angle);
  if (s == YLM_OK) s = numbers(t, "tilt factors", n, false, &part);
  for (size_t i = 0; s == YLM_OK && i < n; i++)
    if (!(part[i] >= 0))
      s = ylm__photometric_fail(t, t->line, "tilt factor %zu must be 0 or more, got %g", i + 1,
                                part[i]);
  if (s == YLM_OK && !isnan(tilt)) *factor = factor_at(n, angle, part, fabs(tilt));
  ylm_free(angle);
  ylm_free(part);
  return s;
}

/* The factor that the lamp's tilt multiplies by: 1 without a table, or without a tilt. */
static ylm_status read_tilt(text *t, const line *tilt, const ylm_light_photometry_form *form,
                            ylm_light_photometry_file *f, double *factor) {
  *factor = 1;
  if (is_word(tilt, "NONE")) return YLM_OK;
  if (is_word(tilt, "INCLUDE")) return read_factors(t, form->tilt, factor);
  if (!tilt->n)
    return ylm__photometric_fail(t, tilt->line, "TILT= NONE, INCLUDE or a file's name expected");
  if (form->factors) {
    text other = {form->factors, form->factors + form->factors_size, 1, "the file of TILT=", t->e};
    return read_factors(&other, form->tilt, factor);
  }
  f->tilt_file = ylm_alloc(tilt->n + 1, 1);
  if (!f->tilt_file) return YLM_ENOMEM;
  memcpy(f->tilt_file, tilt->p, tilt->n);
  f->tilt_file[tilt->n] = 0;
  return YLM_OK;
}

/* -- the opening ----------------------------------------------------------------------------------- */

/* By the signs of width, length and height, in metres: width lies along C90, length along C0. */
static ylm_status set_opening(ylm_light_photometry_file *f, double width, double length,
                              double height) {
  double w = fabs(width), l = fabs(length), h = fabs(height);
  ylm_status s = YLM_OK;
  f->size[0] = l, f->size[1] = w, f->size[2] = h;
  if (w == 0 && l == 0) {
    f->opening = YLM_LIGHT_OPENING_point;
    return h > 0 ? ylm__photometric_note(f, "an opening of height alone is taken as a point") : s;
  }
  if (width < 0 && length == 0) l = f->size[0] = w; /* a diameter: 1991, 1995 */
  if (length < 0 && width == 0) w = f->size[1] = l;
  bool round = (width < 0 && length <= 0) || (length < 0 && width <= 0);
  if (round && fabs(w - l) <= 1e-6 * w) {
    bool ball = height < 0 && fabs(h - w) <= 1e-6 * w;
    f->opening = ball ? YLM_LIGHT_OPENING_sphere : YLM_LIGHT_OPENING_disk;
    return h > 0 && !ball
               ? ylm__photometric_note(f, "a luminous cylinder is taken as its disk of %g m", w)
               : s;
  }
  f->opening = YLM_LIGHT_OPENING_rectangle;
  if (round) {
    f->size[0] *= sqrt(YLM_PI / 4), f->size[1] *= sqrt(YLM_PI / 4);
    return ylm__photometric_note(f, "an elliptic opening is taken as a rectangle of its area");
  }
  for (int a = 0; a < 2; a++)
    if (f->size[a] == 0) {
      f->size[a] = LINE_WIDTH;
      s = ylm__photometric_note(f, "a line of light is taken as a rectangle %g m wide", LINE_WIDTH);
    }
  if (s == YLM_OK && (width < 0 || length < 0 || height < 0))
    s = ylm__photometric_note(
        f, "a lying cylinder or an upright disk is taken as the rectangle around it");
  if (s == YLM_OK && h > 0)
    s = ylm__photometric_note(f, "luminous sides, %g m high, are taken into the opening", h);
  return s;
}

/* -- intensities ----------------------------------------------------------------------------------- */

/* Numbers between TILT and the angles. */
typedef struct lamp {
  size_t lamps, angles, planes, type, units;
  double lumens, multiplier, size[3], ballast, other, watts;
} lamp;

static ylm_status read_lamp(text *t, lamp *l) {
  static const char *const names[3] = {"the width", "the length", "the height"};
  ylm_status s = count(t, "the number of lamps", 1, 1e6, &l->lamps);
  if (s == YLM_OK) s = number(t, "the lumens of a lamp", 0, 0, &l->lumens);
  if (s == YLM_OK) s = number(t, "the multiplier", 0, 0, &l->multiplier);
  if (s == YLM_OK)
    s = count(t, "the number of vertical angles", 2, YLM_LIGHT_PHOTOMETRY_ANGLES, &l->angles);
  if (s == YLM_OK)
    s = count(t, "the number of horizontal angles", 1, YLM_LIGHT_PHOTOMETRY_ANGLES, &l->planes);
  if (s == YLM_OK && l->angles * l->planes > YLM_LIGHT_PHOTOMETRY_NUMBERS)
    s = ylm__photometric_fail(t, t->line, "%zu x %zu angles are more than %zu intensities",
                              l->angles, l->planes, YLM_LIGHT_PHOTOMETRY_NUMBERS);
  if (s == YLM_OK) s = count(t, "the photometric type", 1, 3, &l->type);
  if (s == YLM_OK) s = count(t, "the unit of lengths", 1, 2, &l->units);
  for (int k = 0; s == YLM_OK && k < 3; k++) s = number(t, names[k], 0, 0, &l->size[k]);
  if (s == YLM_OK) s = number(t, "the ballast factor", 0, 0, &l->ballast);
  if (s == YLM_OK) s = number(t, "the ballast-lamp factor", 0, 0, &l->other);
  if (s == YLM_OK) s = number(t, "the input watts", 0, 0, &l->watts);
  if (s == YLM_OK && !(l->multiplier > 0))
    s = ylm__photometric_fail(t, t->line, "the multiplier must be above 0, got %g", l->multiplier);
  if (s == YLM_OK && (!(l->ballast >= 0) || !(l->other >= 0) || !(l->watts >= 0)))
    s = ylm__photometric_fail(t, t->line, "ballast factors and watts must be 0 or more");
  return s;
}

/* The factor of field 12: since 2019 a mark of how the file came to be, which differs from 1 by less than 1 %. */
static double other_factor(const lamp *l) { return fabs(l->other - 1) < 0.01 ? 1 : l->other; }

static bool near(double a, double b) { return fabs(a - b) < 1e-6; }

/* How planes from the first to the last angle repeat. */
static ylm_status symmetry_of(text *t, const lamp *l, const double *plane,
                              ylm_light_photometry_file *f, ylm__photometric_symmetry *out) {
  double first = plane[0], last = plane[l->planes - 1], step = 0;
  for (size_t i = 1; i < l->planes; i++) step = fmax(step, plane[i] - plane[i - 1]);
  *out = YLM__PHOTOMETRIC_FULL;
  if (l->planes == 1)
    *out = YLM__PHOTOMETRIC_ROUND;
  else if (near(first, 0) && near(last, 90))
    *out = YLM__PHOTOMETRIC_QUARTERS;
  else if (near(first, 0) && near(last, 180))
    *out = YLM__PHOTOMETRIC_HALVES;
  else if (near(first, 90) && near(last, 270))
    *out = YLM__PHOTOMETRIC_SIDES;
  else if (near(first, 0) && last > 180 && last < 360 && last + 1.01 * step >= 360)
    return ylm__photometric_note(f, "horizontal angles end at %g: the circle is closed", last);
  else if (!(near(first, 0) && near(last, 360)))
    return ylm__photometric_fail(
        t, t->line,
        "horizontal angles go from %g to %g; 0 to 0, 90, 180 or 360, or 90 "
        "to 270 expected",
        first, last);
  return YLM_OK;
}

/* Type C: angles are those of the table. */
static ylm_status set_type_c(text *t, const lamp *l, const double *angle, const double *plane,
                             const double *candela, ylm_light_photometry_file *f) {
  ylm__photometric_symmetry symmetry;
  double last = angle[l->angles - 1];
  if (!(angle[0] >= 0 && last <= 180))
    return ylm__photometric_fail(
        t, t->line, "vertical angles go from %g to %g; within 0 to 180 expected", angle[0], last);
  ylm_status s = symmetry_of(t, l, plane, f, &symmetry);
  if (s == YLM_OK &&
      !((near(angle[0], 0) || near(angle[0], 90)) && (near(last, 90) || near(last, 180))))
    s = ylm__photometric_note(f, "vertical angles go from %g to %g: it is dark beyond", angle[0],
                              last);
  f->angles = l->angles;
  f->angle = ylm_alloc_copy(angle, l->angles, sizeof *angle);
  if (!f->angle) return YLM_ENOMEM;
  return s == YLM_OK ? ylm__photometric_unfold(f, l->planes, plane, candela, symmetry, t) : s;
}

static ylm_status set_intensities(text *t, const lamp *l, double factor, const double *angle,
                                  const double *plane, double *candela,
                                  ylm_light_photometry_file *f) {
  double scale = factor * l->multiplier * l->ballast * other_factor(l);
  for (size_t i = 0; i < l->angles * l->planes; i++) {
    candela[i] *= scale;
    if (!(fabs(candela[i]) <= BRIGHTEST))
      return ylm__photometric_fail(t, t->line, "intensity %zu is beyond %g cd", i + 1, BRIGHTEST);
  }
  if (l->type == 1) return set_type_c(t, l, angle, plane, candela, f);
  return ylm__photometric_resample(f, l->type == 3, l->planes, plane, l->angles, angle, candela, t);
}

/* Lines behind the intensities are noted. */
static ylm_status look_behind(text *t, ylm_light_photometry_file *f) {
  size_t blocks = 0, more = 0;
  line l;
  skip_gap(t);
  for (; ylm__photometric_next(t, &l); more += l.n > 0)
    blocks += ylm__photometric_begins(&l, "[BLOCK]");
  if (blocks)
    return ylm__photometric_note(f, "further lamps in the file are left out: %zu", blocks);
  return more ? ylm__photometric_note(f, "lines behind the intensities are left out: %zu", more)
              : YLM_OK;
}

static ylm_status read_body(text *t, double factor, ylm_light_photometry_file *f) {
  lamp l;
  double *angle = NULL, *plane = NULL, *candela = NULL;
  ylm_status s = read_lamp(t, &l);
  if (s == YLM_OK) s = numbers(t, "vertical angles", l.angles, true, &angle);
  if (s == YLM_OK) s = numbers(t, "horizontal angles", l.planes, true, &plane);
  if (s == YLM_OK) s = numbers(t, "intensities", l.angles * l.planes, false, &candela);
  if (s == YLM_OK) s = set_intensities(t, &l, factor, angle, plane, candela, f);
  ylm_free(angle);
  ylm_free(plane);
  ylm_free(candela);
  if (s != YLM_OK) return s;
  double unit = l.units == 1 ? FOOT : 1;
  f->watts = l.watts;
  f->lumens = l.lumens > 0 ? l.lumens * (double)l.lamps : 0;
  if (l.lumens < 0 && l.lamps > 1)
    s = ylm__photometric_note(f, "absolute photometry of %zu lamps", l.lamps);
  if (s == YLM_OK) s = set_opening(f, unit * l.size[0], unit * l.size[1], unit * l.size[2]);
  return s == YLM_OK ? look_behind(t, f) : s;
}

ylm_status ylm__photometric_read_ies(text *t, const ylm_light_photometry_form *form,
                                     ylm_light_photometry_file *f) {
  line tilt;
  double factor;
  ylm_status s = read_head(t, f, &tilt);
  if (s == YLM_OK) s = read_tilt(t, &tilt, form, f, &factor);
  return s == YLM_OK ? read_body(t, factor, f) : s;
}
