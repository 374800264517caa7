/* reader.h - what the mesh readers share. Private to csrc/geom. */
#ifndef YLM_GEOM_READER_H
#define YLM_GEOM_READER_H

#include "ylm_decimal.h"
#include "ylm_geom.h"

/* A list whose items the reader knows: ylm_list.h. */
typedef struct ylm_growing {
  void *data;
  size_t count, room, size; /* size of one item */
} ylm_growing;

/* Room for `more` further items; returns where they go (count is not raised), or NULL. */
void *ylm__grow(ylm_growing *g, size_t more);

/* A triangle corner: zero-based indices, UINT32_MAX where there is none. */
typedef struct ylm_corner {
  uint32_t v, t, n;
} ylm_corner;

#define YLM_NO_INDEX UINT32_MAX

/* Adds the fan of a polygon's corners to `triangles` (items are ylm_corner). False: no memory. */
bool ylm__add_polygon(ylm_growing *triangles, const ylm_corner *corner, size_t n);

/* -- lines of OBJ and MTL files ------------------------------------------------- */

/* Where a reader is in a text. */
typedef struct ylm_lines {
  const unsigned char *p, *end;
  size_t line;
} ylm_lines;

bool ylm__at_line_end(const ylm_lines *s);
/* Skips blanks and continued line ends. */
void ylm__skip_blanks(ylm_lines *s);
/* Goes to the end of the line, continued ones included. */
void ylm__skip_line(ylm_lines *s);
/* Goes from a line's end to the next line. */
void ylm__next_line(ylm_lines *s);
/* The length of the word here, up to a blank, '\\' or the line's end, which is passed over. */
size_t ylm__skip_word(ylm_lines *s);
/* Whether the word of n bytes is `name`, in upper or lower case. */
bool ylm__is_word(const unsigned char *word, size_t n, const char *name);
/* Whether a word may begin a statement: by a letter, or by '#' for a comment. */
bool ylm__is_statement(const unsigned char *word, size_t n);
/* The rest of the line without blanks around it, a continued line end as one blank; goes to the line's
   end. YLM_EFORMAT (a zero byte), YLM_ENOMEM; the caller frees *out with ylm_free. */
ylm_status ylm__rest_of_line(ylm_lines *s, char **out);

#endif
