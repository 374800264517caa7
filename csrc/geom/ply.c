/* ply.c - PLY: ascii and binary of both byte orders. */
#include "reader.h"
#include "ylm_image.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAX_ELEMENTS 64
#define MAX_PROPERTIES 256

typedef enum type { INT8, UINT8, INT16, UINT16, INT32, UINT32, FLOAT32, FLOAT64, NO_TYPE } type;

static const size_t type_size[] = {1, 1, 2, 2, 4, 4, 4, 8};

/* Targets of a property: a slot of a vertex (x y z nx ny nz u v red green blue), a face's list,
   nothing. */
enum { COLOUR = 8, SLOTS = 11, FACE_LIST = 11, NOTHING = 12 };

typedef struct property {
  type value, count; /* count is NO_TYPE where it is no list */
  int target;
} property;

typedef struct element {
  bool vertex, face;
  uint64_t count;
  int first, properties; /* in the list of all */
} element;

typedef enum encoding { ASCII, LITTLE, BIG } encoding;

typedef struct parser {
  const unsigned char *start, *p, *end;
  size_t line;
  const char *name;
  double crease;
  ylm_error *e;
  encoding encoding;
  int elements, properties;
  element element[MAX_ELEMENTS];
  property property[MAX_PROPERTIES];
  unsigned slots; /* bits of the slots that vertices have */
  ylm_growing polygon, triangle;
  uint64_t largest, vertices; /* largest index that a face used, how many there are */
  size_t largest_line;
  uint64_t largest_face;
  double *place;
  float *out[4]; /* nothing, normal, uv, colour */
} parser;

/* An error with its line (text) or its byte (binary data). */
static ylm_status fail(parser *s, const char *format, ...) __attribute__((format(printf, 2, 3)));
static ylm_status fail(parser *s, const char *format, ...) {
  char text[200];
  va_list args;
  va_start(args, format);
  vsnprintf(text, sizeof text, format, args);
  va_end(args);
  if (s->encoding == ASCII)
    return ylm_fail(s->e, YLM_EFORMAT, "%s:%zu: %s", s->name, s->line, text);
  return ylm_fail(s->e, YLM_EFORMAT, "%s: byte %zu: %s", s->name, (size_t)(s->p - s->start), text);
}

/* -- header ----------------------------------------------------------------------- */

/* The next header line, split into at most 5 words; false at the end of the file. */
static bool next_line(parser *s, char word[5][40], int *words) {
  *words = 0;
  if (s->p == s->end) return false;
  const unsigned char *p = s->p;
  while (p < s->end && *p != '\n' && *p != '\r') {
    if (*p == ' ' || *p == '\t') {
      p++;
      continue;
    }
    size_t n = 0;
    for (; p<s->end && * p> ' '; p++)
      if (*words < 5 && n < 39) word[*words][n++] = (char)*p;
    if (*words < 5) word[(*words)++][n] = 0;
    if (p < s->end && *p < ' ' && *p != '\n' && *p != '\r' && *p != '\t') return false;
  }
  if (p < s->end && *p == '\r') p++;
  if (p < s->end && *p == '\n') p++;
  s->p = p;
  return true;
}

static type find_type(const char *word) {
  static const char *const names[2][8] = {
      {"char", "uchar", "short", "ushort", "int", "uint", "float", "double"},
      {"int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"}};
  for (int i = 0; i < 8; i++)
    if (strcmp(word, names[0][i]) == 0 || strcmp(word, names[1][i]) == 0) return (type)i;
  return NO_TYPE;
}

static int find_slot(const char *word) {
  static const struct {
    const char *name;
    int slot;
  } names[] = {{"x", 0},
               {"y", 1},
               {"z", 2},
               {"nx", 3},
               {"ny", 4},
               {"nz", 5},
               {"u", 6},
               {"v", 7},
               {"s", 6},
               {"t", 7},
               {"red", 8},
               {"green", 9},
               {"texture_u", 6},
               {"texture_v", 7},
               {"blue", 10},
               {"diffuse_red", 8},
               {"diffuse_green", 9},
               {"diffuse_blue", 10}};
  for (size_t i = 0; i < sizeof names / sizeof *names; i++)
    if (strcmp(word, names[i].name) == 0) return names[i].slot;
  return NOTHING;
}

static ylm_status add_element(parser *s, const char *name, const char *count) {
  char *end;
  if (s->elements == MAX_ELEMENTS) return fail(s, "more than %d elements", MAX_ELEMENTS);
  if (count[0] < '0' || count[0] > '9' || strlen(count) > 15)
    return fail(s, "bad count '%s'", count);
  uint64_t n = strtoull(count, &end, 10);
  if (*end) return fail(s, "bad count '%s'", count);
  element *el = &s->element[s->elements++];
  *el = (element){strcmp(name, "vertex") == 0, strcmp(name, "face") == 0, n, s->properties, 0};
  for (element *o = s->element; o < el; o++)
    if ((o->vertex && el->vertex) || (o->face && el->face))
      return fail(s, "a second element '%s'", name);
  if (el->vertex) s->vertices = n;
  if ((el->vertex || el->face) && n > YLM_MESH_MAX)
    return ylm_fail(s->e, YLM_ELIMIT, "%s:%zu: %s elements, at most %zu", s->name, s->line, count,
                    YLM_MESH_MAX);
  return YLM_OK;
}

/* Whether numbers of a type can be colours: 0 .. 255, 0 .. 65535 or 0 .. 1. */
static bool holds_colour(type t) {
  return t == UINT8 || t == UINT16 || t == FLOAT32 || t == FLOAT64;
}

static ylm_status add_property(parser *s, char word[5][40], int words) {
  if (s->elements == 0) return fail(s, "a property before any element");
  if (s->properties == MAX_PROPERTIES) return fail(s, "more than %d properties", MAX_PROPERTIES);
  element *el = &s->element[s->elements - 1];
  property *p = &s->property[s->properties];
  bool list = words == 5 && strcmp(word[1], "list") == 0;
  if (!list && words != 3) return fail(s, "bad property");
  *p = (property){find_type(word[list ? 3 : 1]), list ? find_type(word[2]) : NO_TYPE, NOTHING};
  const char *name = word[words - 1];
  if (p->value == NO_TYPE || (list && p->count >= FLOAT32))
    return fail(s, "property '%s': unknown type", name);
  if (el->vertex && !list) p->target = find_slot(name);
  if (el->face && list &&
      (strcmp(name, "vertex_indices") == 0 || strcmp(name, "vertex_index") == 0)) {
    if (p->value >= FLOAT32) return fail(s, "vertex indices must be integers");
    p->target = FACE_LIST;
  }
  if (p->target >= COLOUR && p->target < SLOTS && !holds_colour(p->value)) p->target = NOTHING;
  if (p->target < SLOTS) s->slots |= 1u << p->target;
  s->properties++;
  el->properties++;
  return YLM_OK;
}

static ylm_status read_format(parser *s, const char *word) {
  static const char *const names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
  for (int i = 0; i < 3; i++)
    if (strcmp(word, names[i]) == 0) {
      s->encoding = (encoding)(i + 16); /* until the header ends errors name lines */
      return YLM_OK;
    }
  return fail(s, "unknown format '%s'", word);
}

static ylm_status read_header(parser *s) {
  char word[5][40];
  int words;
  encoding found = ASCII;
  bool format = false;
  for (s->line = 1; next_line(s, word, &words); s->line++) {
    ylm_status st = YLM_OK;
    if (words == 0 || strcmp(word[0], "comment") == 0 || strcmp(word[0], "obj_info") == 0) continue;
    if (s->line == 1) {
      if (strcmp(word[0], "ply") != 0) return fail(s, "not a PLY file");
    } else if (strcmp(word[0], "end_header") == 0) {
      s->line++;
      if (!format) return fail(s, "no format");
      s->encoding = found;
      return YLM_OK;
    } else if (strcmp(word[0], "format") == 0 && words == 3) {
      st = read_format(s, word[1]);
      found = (encoding)(s->encoding - 16);
      s->encoding = ASCII;
      format = true;
    } else if (strcmp(word[0], "element") == 0 && words == 3) {
      st = add_element(s, word[1], word[2]);
    } else if (strcmp(word[0], "property") == 0) {
      st = add_property(s, word, words);
    } else {
      st = fail(s, "'%s' does not belong into the header", word[0]);
    }
    if (st != YLM_OK) return st;
  }
  return fail(s, "the header has no end");
}

/* -- data -------------------------------------------------------------------------- */

/* The next number of the given type; false where the data end or are none. */
static bool read_value(parser *s, type t, double *x) {
  if (s->encoding == ASCII) {
    while (s->p < s->end && (*s->p == ' ' || *s->p == '\t' || *s->p == '\n' || *s->p == '\r')) {
      s->line += *s->p == '\n';
      s->p++;
    }
    return ylm_decimal_read(&s->p, s->end, x) && (s->p == s->end || *s->p <= ' ');
  }
  size_t n = type_size[t];
  if ((size_t)(s->end - s->p) < n) return false;
  uint64_t u = 0;
  for (size_t i = 0; i < n; i++)
    u |= (uint64_t)s->p[s->encoding == LITTLE ? i : n - 1 - i] << 8 * i;
  s->p += n;
  switch (t) {
  case INT8: *x = (int8_t)u; break;
  case INT16: *x = (int16_t)u; break;
  case INT32: *x = (int32_t)u; break;
  case FLOAT32: {
    uint32_t v = (uint32_t)u;
    float f;
    memcpy(&f, &v, sizeof f);
    *x = (double)f;
    break;
  }
  case FLOAT64: memcpy(x, &u, sizeof *x); break;
  default: *x = (double)u; break;
  }
  return true;
}

/* A channel of vertex i's colour as linear light. */
static ylm_status read_colour(parser *s, const property *q, double x, uint64_t i) {
  static const char *const names[] = {"red", "green", "blue"};
  int c = q->target - COLOUR;
  double largest = q->value == UINT8 ? 255 : q->value == UINT16 ? 65535 : 1;
  if (!(x >= 0 && x <= largest))
    return fail(s, "vertex %llu: %s must be from 0 to %g, got %g", (unsigned long long)i + 1,
                names[c], largest, x);
  if (s->out[3])
    s->out[3][3 * i + (uint64_t)c] =
        largest > 1 ? ylm_tone_decode_srgb((float)(x / largest)) : (float)x;
  return YLM_OK;
}

static ylm_status read_scalar(parser *s, const property *q, uint64_t i) {
  double x;
  if (!read_value(s, q->value, &x)) return fail(s, "the data end or are no number");
  if (q->target >= SLOTS) return YLM_OK;
  float f = (float)x;
  if (!isfinite(f)) return fail(s, "vertex %llu is not finite", (unsigned long long)i + 1);
  if (q->target >= COLOUR) return read_colour(s, q, x, i);
  if (q->target < 3)
    s->place[3 * i + (uint64_t)q->target] = x;
  else if (q->target < 6) {
    if (s->out[1]) s->out[1][3 * i + (uint64_t)q->target - 3] = f;
  } else if (s->out[2])
    s->out[2][2 * i + (uint64_t)q->target - 6] = f;
  return YLM_OK;
}

static ylm_status read_list(parser *s, const property *q, uint64_t i) {
  double n, x;
  if (!read_value(s, q->count, &n)) return fail(s, "the data end or are no number");
  size_t each = s->encoding == ASCII ? 2 : type_size[q->value];
  /* the last number of a text needs no space behind it */
  if (!(n >= 0 && n <= 4294967295.0) || n != floor(n) ||
      n > (double)((size_t)(s->end - s->p) + 1) / (double)each)
    return fail(s, "a list of %.15g numbers is longer than the file", n);
  bool face = q->target == FACE_LIST;
  if (face && n < 3)
    return fail(s, "face %llu has %g corners, 3 at least are wanted", (unsigned long long)i + 1, n);
  s->polygon.count = 0;
  ylm_corner *c = face ? ylm__grow(&s->polygon, (size_t)n) : NULL;
  if (face && !c) return ylm_no_memory_for(s->e, s->name);
  for (size_t k = 0; k < (size_t)n; k++) {
    if (!read_value(s, q->value, &x)) return fail(s, "the data end or are no number");
    if (!face) continue;
    if (!(x >= 0 && x < (double)YLM_MESH_MAX) || x != floor(x))
      return fail(s, "face %llu refers to vertex %.15g (from 0)", (unsigned long long)i + 1, x);
    c[k] = (ylm_corner){(uint32_t)x, YLM_NO_INDEX, YLM_NO_INDEX};
    if ((uint64_t)x + 1 > s->largest)
      s->largest = (uint64_t)x + 1, s->largest_line = s->line, s->largest_face = i + 1;
  }
  if (face && !ylm__add_polygon(&s->triangle, c, (size_t)n))
    return ylm_no_memory_for(s->e, s->name);
  if (s->triangle.count / 3 > YLM_MESH_MAX)
    return ylm_fail(s->e, YLM_ELIMIT, "%s: more than %zu triangles", s->name, YLM_MESH_MAX);
  return YLM_OK;
}

static ylm_status read_element(parser *s, const element *el) {
  for (uint64_t i = 0; el->properties && i < el->count; i++)
    for (int k = 0; k < el->properties; k++) {
      const property *q = &s->property[el->first + k];
      ylm_status st = q->count == NO_TYPE ? read_scalar(s, q, i) : read_list(s, q, i);
      if (st != YLM_OK) return st;
    }
  return YLM_OK;
}

/* Refuses, before anything is allocated, counts that the file is too short for. */
static ylm_status check_lengths(parser *s) {
  uint64_t need = 0, rest = (uint64_t)(s->end - s->p);
  for (int i = 0; i < s->elements; i++) {
    uint64_t each = 0;
    for (int k = 0; k < s->element[i].properties; k++) {
      const property *q = &s->property[s->element[i].first + k];
      each += s->encoding == ASCII ? 2 : type_size[q->count == NO_TYPE ? q->value : q->count];
    }
    uint64_t bytes; /* a count has at most 15 digits, each at most 2048 */
    if (__builtin_mul_overflow(s->element[i].count, each, &bytes) || bytes > rest + 1 ||
        (need += bytes) > rest + 1)
      return fail(s, "truncated: the header promises more than the %llu bytes that follow",
                  (unsigned long long)rest);
  }
  return YLM_OK;
}

static ylm_status read_data(parser *s, ylm_mesh **m) {
  if ((s->slots & 7) != 7) return fail(s, "vertices need x, y and z");
  ylm_status st = check_lengths(s);
  if (st != YLM_OK) return st;
  bool normals = (s->slots >> 3 & 7) == 7, uvs = (s->slots >> 6 & 3) == 3;
  ylm_mesh *v = NULL;
  st = ylm_mesh_create((size_t)s->vertices, 0, normals, uvs, &v, s->e);
  if (st != YLM_OK) return st;
  if ((s->slots >> COLOUR & 7) == 7) v->colour = ylm_alloc_zero(v->vertices * 3, sizeof(float));
  if ((s->slots >> COLOUR & 7) == 7 && !v->colour) {
    ylm_mesh_free(v);
    return ylm_no_memory_for(s->e, s->name);
  }
  if (!(s->place = ylm_alloc_zero(v->vertices * 3, sizeof(double)))) {
    ylm_mesh_free(v);
    return ylm_no_memory_for(s->e, s->name);
  }
  s->out[1] = v->normal, s->out[2] = v->uv, s->out[3] = v->colour;
  for (int i = 0; st == YLM_OK && i < s->elements; i++) st = read_element(s, &s->element[i]);
  if (st == YLM_OK && s->largest > s->vertices) {
    s->line = s->largest_line;
    st = fail(s, "face %llu refers to vertex %llu (from 0), there are %llu",
              (unsigned long long)s->largest_face, (unsigned long long)s->largest - 1,
              (unsigned long long)s->vertices);
  }
  if (st == YLM_OK && s->triangle.count == 0) st = fail(s, "no faces");
  if (st == YLM_OK) ylm_mesh_set_places(v, s->place);
  uint32_t *index = st == YLM_OK ? ylm_alloc(s->triangle.count, sizeof *index) : NULL;
  if (index) {
    const ylm_corner *c = s->triangle.data;
    for (size_t i = 0; i < s->triangle.count; i++) index[i] = c[i].v;
    ylm_free(v->index);
    v->index = index;
    v->triangles = s->triangle.count / 3;
    if (!normals) st = ylm_mesh_make_creased_normals(v, s->crease, NULL);
  } else if (st == YLM_OK) {
    st = YLM_ENOMEM;
  }
  if (st == YLM_ENOMEM) ylm_no_memory_for(s->e, s->name);
  if (st == YLM_OK)
    *m = v;
  else
    ylm_mesh_free(v);
  return st;
}

/* Normals of the file to unit length. */
static void normalise(ylm_mesh *m) {
  for (size_t i = 0; i < m->vertices; i++) {
    float *n = m->normal + 3 * i;
    double length = sqrt((double)n[0] * n[0] + (double)n[1] * n[1] + (double)n[2] * n[2]);
    for (int a = 0; a < 3; a++) n[a] = length > 0 ? (float)(n[a] / length) : a == 2;
  }
}

ylm_status ylm_mesh_parse_ply(const unsigned char *bytes, size_t size, const char *name,
                              double crease, ylm_mesh **m, ylm_error *e) {
  *m = NULL;
  parser *s = ylm_alloc_zero(1, sizeof *s);
  if (!s) return ylm_no_memory_for(e, name);
  s->start = s->p = bytes;
  s->end = bytes + size;
  s->name = name;
  s->crease = crease;
  s->e = e;
  s->polygon.size = s->triangle.size = sizeof(ylm_corner);
  ylm_status st = read_header(s);
  if (st == YLM_OK) st = read_data(s, m);
  if (st == YLM_OK) normalise(*m);
  ylm_free(s->polygon.data);
  ylm_free(s->triangle.data);
  ylm_free(s->place);
  ylm_free(s);
  return st;
}

/* -- writing ------------------------------------------------------------------------ */

static unsigned char *put(unsigned char *p, const void *word) {
  uint32_t u;
  memcpy(&u, word, 4);
  for (int i = 0; i < 4; i++) *p++ = (unsigned char)(u >> 8 * i);
  return p;
}

static unsigned char *put_double(unsigned char *p, double x) {
  uint64_t u;
  memcpy(&u, &x, 8);
  for (int i = 0; i < 8; i++) *p++ = (unsigned char)(u >> 8 * i);
  return p;
}

/* A vertex's place: floats, or doubles where the mesh has an origin. */
static unsigned char *put_place(unsigned char *p, const ylm_mesh *m, size_t i, bool far) {
  double place[3];
  ylm_mesh_place(m, i, place);
  for (int a = 0; a < 3; a++)
    p = far ? put_double(p, place[a]) : put(p, m->position + 3 * i + (size_t)a);
  return p;
}

ylm_status ylm_mesh_write_ply(const ylm_mesh *m, const char *path, ylm_error *e) {
  ylm_file *f;
  ylm_status s = ylm_file_create(path, &f, e);
  if (s != YLM_OK) return s;
  char head[500];
  bool far = ylm_mesh_is_far(m);
  const char *kind = far ? "double" : "float";
  int n = snprintf(
      head, sizeof head,
      "ply\nformat binary_little_endian 1.0\ncomment ylm " YLM_VERSION "\nelement vertex %zu\n"
      "property %s x\nproperty %s y\nproperty %s z\n%s%s%selement face %zu\n"
      "property list uchar int vertex_indices\nend_header\n",
      m->vertices, kind, kind, kind,
      m->normal ? "property float nx\nproperty float ny\nproperty float nz\n" : "",
      m->uv ? "property float u\nproperty float v\n" : "",
      m->colour ? "property float red\nproperty float green\nproperty float blue\n" : "",
      m->triangles);
  ylm_file_write(f, head, (size_t)n);
  unsigned char row[56];
  for (size_t i = 0; i < m->vertices; i++) {
    unsigned char *p = row;
    p = put_place(p, m, i, far);
    for (int a = 0; m->normal && a < 3; a++) p = put(p, m->normal + 3 * i + (size_t)a);
    for (int a = 0; m->uv && a < 2; a++) p = put(p, m->uv + 2 * i + (size_t)a);
    for (int a = 0; m->colour && a < 3; a++) p = put(p, m->colour + 3 * i + (size_t)a);
    ylm_file_write(f, row, (size_t)(p - row));
  }
  for (size_t t = 0; t < m->triangles; t++) {
    unsigned char *p = row;
    *p++ = 3;
    for (int a = 0; a < 3; a++) p = put(p, m->index + 3 * t + (size_t)a);
    ylm_file_write(f, row, (size_t)(p - row));
  }
  return ylm_file_commit(f, e);
}
