/* file.h - what the readers of photometric files share: lines, numbers, notes. Private to csrc/light. */
#ifndef YLM_LIGHT_PHOTOMETRIC_FILE_H
#define YLM_LIGHT_PHOTOMETRIC_FILE_H

#include "ylm_light_photometry.h"

/* A text, and where its reader is. */
typedef struct ylm__photometric_text {
  const unsigned char *p, *end;
  size_t line; /* from 1 */
  const char *name;
  ylm_error *e;
} ylm__photometric_text;

/* A line without the blanks at its ends. */
typedef struct ylm__photometric_line {
  const unsigned char *p;
  size_t n, line;
} ylm__photometric_line;

/* The next line, however it ends; false: there is none. */
bool ylm__photometric_next(ylm__photometric_text *t, ylm__photometric_line *line);
/* Whether a line begins with a word, in upper or lower case. */
bool ylm__photometric_begins(const ylm__photometric_line *line, const char *word);
/* YLM_EFORMAT with "name:line: " before the sentence. */
ylm_status ylm__photometric_fail(const ylm__photometric_text *t, size_t line, const char *format,
                                 ...) __attribute__((format(printf, 3, 4)));

/* Appends a text, or a note; YLM_ENOMEM. */
ylm_status ylm__photometric_add(ylm_light_photometry_file *f, const char *name,
                                const unsigned char *text, size_t n);
ylm_status ylm__photometric_note(ylm_light_photometry_file *f, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* How the planes of a file repeat around the axis. */
typedef enum ylm__photometric_symmetry {
  YLM__PHOTOMETRIC_FULL,
  YLM__PHOTOMETRIC_ROUND,
  YLM__PHOTOMETRIC_HALVES, /* about C0-C180 */
  YLM__PHOTOMETRIC_SIDES,  /* about C90-C270 */
  YLM__PHOTOMETRIC_QUARTERS
} ylm__photometric_symmetry;

/*
** Fills planes and candela of f, whose angles stand, from rows of a file: plane [rows] in degrees, candela [rows][angles].
** Where several angles name one direction, the first counts. Negative numbers become 0; poles get one value. Notes say
** what was changed. YLM_EFORMAT (all are negative); YLM_ENOMEM. file.c
*/
ylm_status ylm__photometric_unfold(ylm_light_photometry_file *f, size_t rows, const double *plane,
                                   const double *candela, ylm__photometric_symmetry symmetry,
                                   const ylm__photometric_text *t);

/* Intensities by angles of type B (A: `vertical`, the polar axis is upright): fills f. YLM_ENOMEM; as unfold. type_b.c */
ylm_status ylm__photometric_resample(ylm_light_photometry_file *f, bool vertical, size_t rows,
                                     const double *plane, size_t columns, const double *angle,
                                     const double *candela, const ylm__photometric_text *t);

ylm_status ylm__photometric_read_ies(ylm__photometric_text *t,
                                     const ylm_light_photometry_form *form,
                                     ylm_light_photometry_file *f);
ylm_status ylm__photometric_read_ldt(ylm__photometric_text *t,
                                     const ylm_light_photometry_form *form,
                                     ylm_light_photometry_file *f);

#endif
