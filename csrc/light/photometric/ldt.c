/* ldt.c - EULUMDAT files: one field a line, numbers with a point or a comma. */
#include "file.h"

#include <math.h>
#include <string.h>

#include "ylm_decimal.h"

#define MOST_SETS 20
#define MOST_ANGLES 721
#define BRIGHTEST 1e20

typedef ylm__photometric_text text;
typedef ylm__photometric_line line;

/* -- fields ---------------------------------------------------------------------------------------- */

/* The next line, of a field that `what` names. */
static ylm_status field(text *t, const char *what, line *l) {
  if (ylm__photometric_next(t, l)) return YLM_OK;
  return ylm__photometric_fail(t, t->line, "the file ends where %s is due", what);
}

/* The number of a whole line; false: it is none. */
static bool number_of(const line *l, double *x) {
  unsigned char word[64];
  const unsigned char *p = word;
  if (l->n == 0 || l->n >= sizeof word) return false;
  for (size_t i = 0; i < l->n; i++) word[i] = l->p[i] == ',' ? '.' : l->p[i];
  return ylm_decimal_read(&p, word + l->n, x) && p == word + l->n && fabs(*x) <= BRIGHTEST;
}

/* An empty line is 0. */
static ylm_status number(text *t, const char *what, double *x) {
  line l;
  ylm_status s = field(t, what, &l);
  *x = 0;
  if (s != YLM_OK || l.n == 0 || number_of(&l, x)) return s;
  return ylm__photometric_fail(t, l.line, "%s: a number expected, got \"%.*s\"", what,
                               l.n < 30 ? (int)l.n : 30, (const char *)l.p);
}

static ylm_status integer(text *t, const char *what, double least, double most, int *n) {
  double x;
  ylm_status s = number(t, what, &x);
  if (s != YLM_OK) return s;
  if (!(x >= least && x <= most) || x != floor(x))
    return ylm__photometric_fail(t, t->line - 1, "%s must be an integer from %g to %g, got %g",
                                 what, least, most, x);
  *n = (int)x;
  return YLM_OK;
}

/* n numbers into x, of which `least` of a plane increase where `rise`. */
static ylm_status numbers(text *t, const char *what, size_t n, bool rise, double *x) {
  for (size_t i = 0; i < n; i++) {
    line l;
    if (!ylm__photometric_next(t, &l))
      return ylm__photometric_fail(t, t->line, "the file ends: %zu %s wanted, %zu there", n, what,
                                   i);
    if (!number_of(&l, x + i))
      return ylm__photometric_fail(t, l.line, "%s: a number expected, got \"%.*s\"", what,
                                   l.n < 30 ? (int)l.n : 30, (const char *)l.p);
    if (rise && i > 0 && !(x[i] > x[i - 1]))
      return ylm__photometric_fail(t, l.line, "%s must increase: %g follows %g", what, x[i],
                                   x[i - 1]);
  }
  return YLM_OK;
}

static ylm_status word(text *t, const char *what, ylm_light_photometry_file *f) {
  line l;
  ylm_status s = field(t, what, &l);
  return s == YLM_OK && l.n ? ylm__photometric_add(f, what, l.p, l.n) : s;
}

/* -- the lamp -------------------------------------------------------------------------------------- */

/* Fields up to the lamp sets. */
typedef struct head {
  int type, symmetry, planes, angles, sets;
  double between_planes, between_angles, size[5], heights[4], downward, ratio, factor, tilt;
} head;

static ylm_status read_words(text *t, ylm_light_photometry_file *f) {
  static const char *const names[5] = {"report", "luminaire", "number", "file", "date"};
  ylm_status s = YLM_OK;
  for (int i = 0; i < 5 && s == YLM_OK; i++) s = word(t, names[i], f);
  return s;
}

static ylm_status read_head(text *t, head *h, ylm_light_photometry_file *f) {
  static const char *const sizes[5] = {"the length of the luminaire", "its width", "its height",
                                       "the length of the luminous area", "its width"};
  ylm_status s = word(t, "company", f);
  if (s == YLM_OK) s = integer(t, "the type of source (line 2)", 0, 3, &h->type);
  if (s == YLM_OK) s = integer(t, "the symmetry (line 3)", 0, 4, &h->symmetry);
  if (s == YLM_OK) s = integer(t, "the number of C planes (line 4)", 1, MOST_ANGLES, &h->planes);
  if (s == YLM_OK) s = number(t, "the distance of C planes (line 5)", &h->between_planes);
  if (s == YLM_OK) s = integer(t, "the number of angles (line 6)", 2, MOST_ANGLES, &h->angles);
  if (s == YLM_OK) s = number(t, "the distance of angles (line 7)", &h->between_angles);
  if (s == YLM_OK) s = read_words(t, f);
  for (int i = 0; s == YLM_OK && i < 5; i++) s = number(t, sizes[i], &h->size[i]);
  for (int i = 0; s == YLM_OK && i < 4; i++)
    s = number(t, "a height of the luminous area", &h->heights[i]);
  if (s == YLM_OK) s = number(t, "the downward flux", &h->downward);
  if (s == YLM_OK) s = number(t, "the light output ratio", &h->ratio);
  if (s == YLM_OK) s = number(t, "the conversion factor (line 24)", &h->factor);
  if (s == YLM_OK) s = number(t, "the tilt (line 25)", &h->tilt);
  if (s == YLM_OK) s = integer(t, "the number of lamp sets (line 26)", 1, MOST_SETS, &h->sets);
  if (s == YLM_OK && h->factor == 0) h->factor = 1;
  if (s == YLM_OK && !(h->factor > 0))
    s = ylm__photometric_fail(t, 24, "the conversion factor must be above 0, got %g", h->factor);
  return s;
}

/* Line k of 6 of set i: sets stand one behind the other, or line by line. */
static size_t line_of(const head *h, bool by_line, int i, int k) {
  return (size_t)(by_line ? k * h->sets + i : 6 * i + k);
}

/* Lumens and watts of the wanted set. */
static ylm_status read_sets(text *t, const head *h, int wanted, ylm_light_photometry_file *f,
                            double *flux) {
  static const char *const names[6] = {"lamps",       "lamp",      "flux",
                                       "temperature", "rendering", "watts"};
  line all[6 * MOST_SETS];
  double x, lamps = 0;
  if (wanted < 1 || wanted > h->sets)
    return ylm_fail(t->e, YLM_EFORMAT, "%s: lamp set %d is not there: the file has %d", t->name,
                    wanted, h->sets);
  for (int i = 0; i < 6 * h->sets; i++) {
    ylm_status s = field(t, "a lamp set", &all[i]);
    if (s != YLM_OK) return s;
  }
  bool by_line = h->sets > 1 && number_of(&all[1], &x) && !number_of(&all[h->sets], &x);
  for (int k = 0; k < 6; k++) {
    const line *l = &all[line_of(h, by_line, wanted - 1, k)];
    ylm_status s = ylm__photometric_add(f, names[k], l->p, l->n);
    if (s != YLM_OK) return s;
    bool is_number = number_of(l, &x);
    if ((k == 0 || k == 2) && !is_number)
      return ylm__photometric_fail(t, l->line, "%s of a lamp set: a number expected, got \"%.*s\"",
                                   names[k], l->n < 30 ? (int)l->n : 30, (const char *)l->p);
    if (k == 0) lamps = x;
    if (k == 2) *flux = x;
    if (k == 5) f->watts = is_number && x > 0 ? x : 0;
    if (k == 2 && !(x >= 0))
      return ylm__photometric_fail(t, l->line, "the flux must be 0 or more, got %g", x);
  }
  f->lumens = lamps < 0 ? 0 : *flux;
  if (h->sets > 1) return ylm__photometric_note(f, "lamp set %d of %d is taken", wanted, h->sets);
  return *flux == 0 ? ylm__photometric_note(f, "the flux of the lamps is 0: it is dark") : YLM_OK;
}

/* The luminous area, in metres: its length lies along C90, its width along C0. */
static ylm_status set_opening(const head *h, ylm_light_photometry_file *f) {
  const double *size = h->size[3] > 0 ? h->size + 3 : h->size;
  double length = size[0] / 1000, width = size[1] / 1000, high = 0;
  for (int i = 0; i < 4; i++) high = fmax(high, h->heights[i] / 1000);
  f->size[2] = high;
  if (!(length > 0)) {
    f->opening = YLM_LIGHT_OPENING_point;
    return YLM_OK;
  }
  f->opening = width > 0 ? YLM_LIGHT_OPENING_rectangle : YLM_LIGHT_OPENING_disk;
  f->size[0] = width > 0 ? width : length;
  f->size[1] = length;
  ylm_status s = YLM_OK;
  if (!(h->size[3] > 0))
    s = ylm__photometric_note(f, "no luminous area: that of the luminaire is taken");
  if (s == YLM_OK && high > 0)
    s = ylm__photometric_note(f, "luminous sides, %g m high, are taken into the opening", high);
  return s;
}

/* -- intensities ----------------------------------------------------------------------------------- */

/* The first plane that is stored, and how many are. */
static void stored(const head *h, int *first, int *n, ylm__photometric_symmetry *symmetry) {
  static const ylm__photometric_symmetry of[5] = {YLM__PHOTOMETRIC_FULL, YLM__PHOTOMETRIC_ROUND,
                                                  YLM__PHOTOMETRIC_HALVES, YLM__PHOTOMETRIC_SIDES,
                                                  YLM__PHOTOMETRIC_QUARTERS};
  int planes = h->planes;
  *symmetry = of[h->symmetry];
  *first = h->symmetry == 3 ? 3 * planes / 4 : 0;
  *n = h->symmetry == 0   ? planes
       : h->symmetry == 1 ? 1
       : h->symmetry == 4 ? planes / 4 + 1
                          : planes / 2 + 1;
}

static ylm_status check_planes(text *t, const head *h) {
  int by = h->symmetry < 2 ? 1 : h->symmetry == 2 ? 2 : 4;
  if (h->planes % by)
    return ylm__photometric_fail(t, 4, "symmetry %d wants a multiple of %d planes, got %d",
                                 h->symmetry, by, h->planes);
  return YLM_OK;
}

/* Room for what is read: angles of planes, angles, rows of intensities and their planes. */
typedef struct room {
  double *plane, *angle, *candela, *row;
} room;

static ylm_status read_rows(text *t, const head *h, double scale, const room *r,
                            ylm_light_photometry_file *f) {
  int first, n;
  ylm__photometric_symmetry symmetry;
  stored(h, &first, &n, &symmetry);
  size_t angles = (size_t)h->angles, count = (size_t)n * angles;
  ylm_status s = numbers(t, "C planes", (size_t)h->planes, true, r->plane);
  if (s == YLM_OK) s = numbers(t, "angles", angles, true, r->angle);
  if (s == YLM_OK && !(r->angle[0] >= 0 && r->angle[angles - 1] <= 180))
    s = ylm__photometric_fail(t, t->line - 1, "angles go from %g to %g; within 0 to 180 expected",
                              r->angle[0], r->angle[angles - 1]);
  if (s == YLM_OK && !(r->plane[0] >= 0 && r->plane[h->planes - 1] <= 360))
    s = ylm__photometric_fail(t, t->line - 1, "C planes go from %g to %g; within 0 to 360 expected",
                              r->plane[0], r->plane[h->planes - 1]);
  if (s == YLM_OK) s = numbers(t, "intensities", count, false, r->candela);
  if (s != YLM_OK) return s;
  for (size_t i = 0; i < count; i++) {
    r->candela[i] *= scale;
    if (!(fabs(r->candela[i]) <= BRIGHTEST))
      return ylm__photometric_fail(t, t->line, "intensity %zu is beyond %g cd", i + 1, BRIGHTEST);
  }
  for (int i = 0; i < n; i++) r->row[i] = r->plane[(first + i) % h->planes];
  if (symmetry == YLM__PHOTOMETRIC_HALVES && h->planes > 1) r->row[n - 1] = 180;
  f->angles = angles;
  f->angle = ylm_alloc_copy(r->angle, angles, sizeof *r->angle);
  return f->angle ? ylm__photometric_unfold(f, (size_t)n, r->row, r->candela, symmetry, t)
                  : YLM_ENOMEM;
}

static ylm_status read_table(text *t, const head *h, double flux, ylm_light_photometry_file *f) {
  size_t planes = (size_t)h->planes + 1, angles = (size_t)h->angles;
  room r = {ylm_alloc(planes, sizeof(double)), ylm_alloc(angles, sizeof(double)),
            ylm_alloc(planes * angles, sizeof(double)), ylm_alloc(planes, sizeof(double))};
  bool ok = r.plane && r.angle && r.candela && r.row;
  ylm_status s = ok ? read_rows(t, h, flux / 1000 * h->factor, &r, f) : YLM_ENOMEM;
  ylm_free(r.plane);
  ylm_free(r.angle);
  ylm_free(r.candela);
  ylm_free(r.row);
  return s;
}

static ylm_status look_behind(text *t, ylm_light_photometry_file *f) {
  size_t more = 0;
  line l;
  while (ylm__photometric_next(t, &l)) more += l.n > 0 && l.p[0] != 26; /* the end mark of DOS */
  return more ? ylm__photometric_note(f, "lines behind the intensities are left out: %zu", more)
              : YLM_OK;
}

ylm_status ylm__photometric_read_ldt(text *t, const ylm_light_photometry_form *form,
                                     ylm_light_photometry_file *f) {
  head h;
  double flux = 0, ratios[10];
  f->format = "EULUMDAT";
  ylm_status s = read_head(t, &h, f);
  if (s == YLM_OK) s = check_planes(t, &h);
  if (s == YLM_OK) s = read_sets(t, &h, form->lamps, f, &flux);
  for (int i = 0; s == YLM_OK && i < 10; i++) s = number(t, "a direct ratio", ratios + i);
  if (s == YLM_OK) s = read_table(t, &h, flux, f);
  if (s == YLM_OK) s = set_opening(&h, f);
  if (s == YLM_OK && !isnan(form->tilt))
    s = ylm__photometric_note(f, "EULUMDAT has no table of tilt factors");
  return s == YLM_OK ? look_behind(t, f) : s;
}
