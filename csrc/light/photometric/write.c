/* write.c - photometric files: LM-63-2002, absolute, and EULUMDAT, symmetries found. */
#include "file.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "ylm_list.h"

#define ALIKE 1e-6   /* of the peak: planes that differ by less are one */
#define MOST_LDT 721 /* planes, and angles, of EULUMDAT */

/* Bytes that grow. */
typedef struct out {
  char *bytes;
  size_t size, room;
  bool failed;
} out;

static void put(out *o, const char *format, ...) __attribute__((format(printf, 2, 3)));

static void put(out *o, const char *format, ...) {
  char text[400];
  va_list arguments;
  va_start(arguments, format);
  int n = vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  size_t used = n < 0 ? 0 : (size_t)n < sizeof text ? (size_t)n : sizeof text - 1;
  if (o->failed || !ylm_list_reserve(&o->bytes, o->size, o->size + used + 1, &o->room, 1)) {
    o->failed = true;
    return;
  }
  memcpy(o->bytes + o->size, text, used + 1);
  o->size += used;
}

/* A number with a point in any locale. */
static void put_number(out *o, double x) {
  char text[40];
  snprintf(text, sizeof text, "%.9g", x);
  char *comma = strchr(text, ',');
  if (comma) *comma = '.';
  put(o, "%s", text);
}

/* -- symmetries ------------------------------------------------------------------------------------ */

/* The plane at an angle of whole numbers of a millionth of a degree; planes: there is none. */
static size_t plane_at(const ylm_light_photometry_file *f, double at) {
  at = fmod(at + 720, 360);
  for (size_t k = 0; k < f->planes; k++)
    if (fabs(f->plane[k] - at) < 1e-6 || fabs(f->plane[k] + 360 - at) < 1e-6) return k;
  return f->planes;
}

/* Whether every plane C is as the plane sign C + offset. */
static bool mirrors(const ylm_light_photometry_file *f, double sign, double offset) {
  double peak = 0;
  for (size_t i = 0; i < f->planes * f->angles; i++) peak = fmax(peak, f->candela[i]);
  for (size_t k = 0; k < f->planes; k++) {
    size_t m = plane_at(f, sign * f->plane[k] + offset);
    if (m == f->planes) return false;
    for (size_t j = 0; j < f->angles; j++)
      if (fabs(f->candela[k * f->angles + j] - f->candela[m * f->angles + j]) > ALIKE * peak)
        return false;
  }
  return true;
}

static bool is_round(const ylm_light_photometry_file *f) {
  double peak = 0;
  for (size_t i = 0; i < f->planes * f->angles; i++) peak = fmax(peak, f->candela[i]);
  for (size_t i = f->angles; i < f->planes * f->angles; i++)
    if (fabs(f->candela[i] - f->candela[i % f->angles]) > ALIKE * peak) return false;
  return true;
}

static ylm__photometric_symmetry symmetry_of(const ylm_light_photometry_file *f) {
  if (is_round(f)) return YLM__PHOTOMETRIC_ROUND;
  if (f->plane[0] > 0) return YLM__PHOTOMETRIC_FULL;
  bool halves = mirrors(f, -1, 0) && plane_at(f, 180) < f->planes;
  bool sides = mirrors(f, -1, 180) && plane_at(f, 90) < f->planes && plane_at(f, 270) < f->planes;
  return halves && sides ? YLM__PHOTOMETRIC_QUARTERS
         : halves        ? YLM__PHOTOMETRIC_HALVES
         : sides         ? YLM__PHOTOMETRIC_SIDES
                         : YLM__PHOTOMETRIC_FULL;
}

/* The angles that planes of a symmetry go from and to. */
static void range_of(ylm__photometric_symmetry s, double *from, double *to) {
  *from = s == YLM__PHOTOMETRIC_SIDES ? 90 : 0;
  *to = s == YLM__PHOTOMETRIC_ROUND      ? 0
        : s == YLM__PHOTOMETRIC_QUARTERS ? 90
        : s == YLM__PHOTOMETRIC_HALVES   ? 180
        : s == YLM__PHOTOMETRIC_SIDES    ? 270
                                         : 360;
}

/* -- LM-63 ----------------------------------------------------------------------------------------- */

/* A text of the file by name; "": there is none. */
static const char *text_of(const ylm_light_photometry_file *f, const char *a, const char *b) {
  for (size_t i = 0; i < f->texts; i++)
    if (strcmp(f->text[i].name, a) == 0 || strcmp(f->text[i].name, b) == 0) return f->text[i].text;
  return "";
}

static void put_words(out *o, const ylm_light_photometry_file *f) {
  static const char *const words[][2] = {{"TEST", "report"},    {"TESTLAB", "company"},
                                         {"ISSUEDATE", "date"}, {"MANUFAC", "company"},
                                         {"LUMCAT", "number"},  {"LUMINAIRE", "luminaire"},
                                         {"LAMP", "lamp"}};
  put(o, "IESNA:LM-63-2002\r\n");
  for (size_t i = 0; i < sizeof words / sizeof *words; i++)
    put(o, "[%s] %.240s\r\n", words[i][0], text_of(f, words[i][0], words[i][1]));
  put(o, "TILT=NONE\r\n");
}

/* The opening as signs of width, length and height; width lies along C90. */
static void put_opening(out *o, const ylm_light_photometry_file *f) {
  double w = f->size[1], l = f->size[0], h = f->size[2];
  double sign =
      f->opening == YLM_LIGHT_OPENING_disk || f->opening == YLM_LIGHT_OPENING_sphere ? -1 : 1;
  if (f->opening == YLM_LIGHT_OPENING_point) w = l = h = 0;
  if (f->opening == YLM_LIGHT_OPENING_sphere) h = w;
  const double x[3] = {sign * w, sign * l, sign * h};
  for (int k = 0; k < 3; k++) {
    put(o, " ");
    put_number(o, x[k] + 0.0);
  }
  put(o, "\r\n");
}

/* n numbers, ten a line. */
static void put_list(out *o, size_t n, const double *x) {
  for (size_t i = 0; i < n; i++) {
    put_number(o, x[i]);
    put(o, i + 1 < n && (i + 1) % 10 ? " " : "\r\n");
  }
}

static void write_ies(out *o, const ylm_light_photometry_file *f) {
  ylm__photometric_symmetry s = symmetry_of(f);
  double from, to;
  size_t planes = 0;
  range_of(s, &from, &to);
  for (size_t k = 0; k < f->planes; k++) planes += f->plane[k] >= from && f->plane[k] <= to;
  if (s == YLM__PHOTOMETRIC_FULL) planes++; /* the first once more, at 360 */
  if (s == YLM__PHOTOMETRIC_ROUND) planes = 1;
  put_words(o, f);
  put(o, "1 -1 1 %zu %zu 1 2", f->angles, planes);
  put_opening(o, f);
  put(o, "1 1 ");
  put_number(o, f->watts);
  put(o, "\r\n");
  put_list(o, f->angles, f->angle);
  for (size_t i = 0, k = 0; i < planes; k++) {
    double at = k < f->planes ? f->plane[k] : 360 + f->plane[0];
    if (s != YLM__PHOTOMETRIC_ROUND && at < from) continue;
    put_number(o, s == YLM__PHOTOMETRIC_ROUND ? 0 : at);
    put(o, ++i < planes && i % 10 ? " " : "\r\n");
  }
  for (size_t i = 0, k = 0; i < planes; k++) {
    if (s != YLM__PHOTOMETRIC_ROUND && k < f->planes && f->plane[k] < from) continue;
    put_list(o, f->angles, f->candela + k % f->planes * f->angles);
    i++;
  }
}

/* -- EULUMDAT -------------------------------------------------------------------------------------- */

static void put_line(out *o, double x) {
  put_number(o, x);
  put(o, "\r\n");
}

/* Sizes of the luminaire and of the luminous area, mm: length along C90, width along C0; a width of 0 is round. */
static void put_sizes(out *o, const ylm_light_photometry_file *f) {
  bool point = f->opening == YLM_LIGHT_OPENING_point,
       flat = f->opening == YLM_LIGHT_OPENING_rectangle;
  double length = point ? 0 : 1000 * f->size[1], width = flat ? 1000 * f->size[0] : 0;
  put_line(o, length), put_line(o, width), put_line(o, 1000 * f->size[2]);
  put_line(o, length), put_line(o, width);
  for (int i = 0; i < 4; i++) put_line(o, 1000 * f->size[2]);
}

/* One lamp set, the file's: absolute where the lamps' flux is not known. */
static void put_set(out *o, const ylm_light_photometry_file *f, double flux) {
  put(o, "1\r\n%d\r\n%.200s\r\n", f->lumens > 0 ? 1 : -1, text_of(f, "lamp", "LAMP"));
  put_line(o, flux);
  put(o, "%.100s\r\n%.100s\r\n", text_of(f, "temperature", "CCT"), text_of(f, "rendering", "CRI"));
  put_line(o, f->watts);
  for (int i = 0; i < 10; i++) put(o, "0\r\n");
}

/* Planes, whether or not they are stored, and the stored ones. */
static void put_rows(out *o, const ylm_light_photometry_file *f, int symmetry, double flux) {
  size_t n = f->planes;
  size_t first = symmetry == 3 ? 3 * n / 4 : 0;
  size_t stored = symmetry == 0 ? n : symmetry == 1 ? 1 : symmetry == 4 ? n / 4 + 1 : n / 2 + 1;
  for (size_t k = 0; k < n; k++) put_line(o, f->plane[k]);
  for (size_t j = 0; j < f->angles; j++) put_line(o, f->angle[j]);
  for (size_t i = 0; i < stored; i++)
    for (size_t j = 0; j < f->angles; j++)
      put_line(o, 1000 * f->candela[(first + i) % n * f->angles + j] / flux);
}

/* EULUMDAT's number of a symmetry; its planes stand at equal distances, or are all stored. */
static int number_of(const ylm_light_photometry_file *f, ylm__photometric_symmetry s) {
  static const int numbers[] = {[YLM__PHOTOMETRIC_FULL] = 0,
                                [YLM__PHOTOMETRIC_ROUND] = 1,
                                [YLM__PHOTOMETRIC_HALVES] = 2,
                                [YLM__PHOTOMETRIC_SIDES] = 3,
                                [YLM__PHOTOMETRIC_QUARTERS] = 4};
  if (s == YLM__PHOTOMETRIC_ROUND) return 1;
  for (size_t k = 0; k < f->planes; k++)
    if (fabs(f->plane[k] - 360 * (double)k / (double)f->planes) > 1e-6) return 0;
  size_t by = s == YLM__PHOTOMETRIC_HALVES ? 2 : 4;
  return f->planes % by ? 0 : numbers[s];
}

static double step_of(size_t n, const double *x) {
  double step = n > 1 ? x[1] - x[0] : 0;
  for (size_t i = 1; i < n; i++)
    if (fabs(x[i] - x[i - 1] - step) > 1e-6) return 0;
  return step;
}

static ylm_status write_ldt(out *o, const ylm_light_photometry_file *f, ylm_error *e) {
  if (f->planes > MOST_LDT || f->angles > MOST_LDT)
    return ylm_fail(e, YLM_EINVAL,
                    "EULUMDAT has at most %d planes and angles, the table has %zu and %zu",
                    MOST_LDT, f->planes, f->angles);
  int symmetry = number_of(f, symmetry_of(f));
  double flux = f->lumens > 0 ? f->lumens : 1000;
  put(o, "%.240s\r\n", text_of(f, "company", "MANUFAC"));
  put(o, "%d\r\n%d\r\n%zu\r\n",
      f->opening == YLM_LIGHT_OPENING_rectangle ? 2
      : symmetry == 1                           ? 1
                                                : 3,
      symmetry, f->planes);
  put_line(o, f->planes > 1 ? step_of(f->planes, f->plane) : 0);
  put(o, "%zu\r\n", f->angles);
  put_line(o, step_of(f->angles, f->angle));
  put(o, "%.200s\r\n%.200s\r\n%.200s\r\n\r\n%.200s\r\n", text_of(f, "report", "TEST"),
      text_of(f, "luminaire", "LUMINAIRE"), text_of(f, "number", "LUMCAT"),
      text_of(f, "date", "ISSUEDATE"));
  put_sizes(o, f);
  put(o, "100\r\n100\r\n1\r\n0\r\n");
  put_set(o, f, flux);
  put_rows(o, f, symmetry, flux);
  return YLM_OK;
}

ylm_status ylm_light_photometry_write(const ylm_light_photometry_file *f, bool ldt, char **bytes,
                                      size_t *size, ylm_error *e) {
  out o = {0};
  ylm_status s = YLM_OK;
  *bytes = NULL;
  *size = 0;
  if (ldt)
    s = write_ldt(&o, f, e);
  else
    write_ies(&o, f);
  if (s == YLM_OK && o.failed) s = ylm_no_memory(e);
  if (s == YLM_OK) {
    *bytes = o.bytes;
    *size = o.size;
  } else {
    ylm_free(o.bytes);
  }
  return s;
}
