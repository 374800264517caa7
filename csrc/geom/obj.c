/* obj.c - Wavefront OBJ. */
#include "groups.h"

#include <math.h>
#include <string.h>

/* The largest index of a kind that a face used, and where: it may stand before what it names. */
typedef struct extent {
  uint64_t largest; /* one-based; 0: none */
  size_t line;
} extent;

typedef struct parser {
  ylm_lines at;
  const char *name;
  ylm_error *e;
  ylm_growing place, uv, normal; /* double[3], float[2], float[3] */
  ylm_growing position;          /* float[3], of the places, relative to the origin */
  double origin[3];
  ylm_growing polygon, triangle; /* ylm_corner */
  extent most[3];                /* v, vt, vn */
  ylm_grouping *groups;          /* NULL: not wanted */
  ylm_growing smooth;            /* uint32_t, the smoothing group of each triangle */
  uint32_t smoothing;            /* of the next one */
  double crease;
  bool bare_normal; /* some corner has none */
} parser;

/* n numbers of a v, vt or vn statement; `least` of them must be there, the others are 0. */
static ylm_status read_numbers(parser *s, ylm_growing *to, const char *what, int n, int least) {
  void *out = ylm__grow(to, 1);
  ylm_dtype t = to == &s->place ? YLM_DOUBLE : YLM_FLOAT;
  if (!out) return ylm_no_memory_for(s->e, s->name);
  for (int i = 0; i < n; i++) {
    double x = 0;
    ylm__skip_blanks(&s->at);
    if (!ylm_decimal_read(&s->at.p, s->at.end, &x) && i < least)
      return ylm_fail(s->e, YLM_EFORMAT, "%s:%zu: '%s' wants %d numbers, number %d is none",
                      s->name, s->at.line, what, n, i + 1);
    ylm_put(t, out, (size_t)i, x);
    if (!isfinite((float)x))
      return ylm_fail(s->e, YLM_EFORMAT, "%s:%zu: number %d of '%s' is too large", s->name,
                      s->at.line, i + 1, what);
  }
  if (++to->count > YLM_MESH_MAX)
    return ylm_fail(s->e, YLM_ELIMIT, "%s:%zu: more than %zu of '%s'", s->name, s->at.line,
                    YLM_MESH_MAX, what);
  ylm__skip_line(&s->at);
  return YLM_OK;
}

/* One index of a face corner (kind 0 v, 1 vt, 2 vn) as a zero-based one. */
static ylm_status read_index(parser *s, int kind, uint32_t *out) {
  static const char *const names[] = {"vertex", "texture coordinate", "normal"};
  bool negative = s->at.p < s->at.end && *s->at.p == '-';
  if (negative) s->at.p++;
  uint64_t k = 0;
  if (s->at.p == s->at.end || *s->at.p < '0' || *s->at.p > '9')
    return ylm_fail(s->e, YLM_EFORMAT, "%s:%zu: a %s index expected in a face", s->name, s->at.line,
                    names[kind]);
  for (; s->at.p < s->at.end && *s->at.p >= '0' && *s->at.p <= '9'; s->at.p++)
    if (k < 1u << 31) k = 10 * k + (uint64_t)(*s->at.p - '0');
  const ylm_growing *pool = kind == 0 ? &s->place : kind == 1 ? &s->uv : &s->normal;
  if (negative) {
    if (k == 0 || k > pool->count)
      return ylm_fail(s->e, YLM_EFORMAT, "%s:%zu: a face refers to %s -%llu, %zu are there so far",
                      s->name, s->at.line, names[kind], (unsigned long long)k, pool->count);
    k = pool->count - k + 1;
  }
  if (k == 0 || k > YLM_MESH_MAX)
    return ylm_fail(s->e, YLM_EFORMAT, "%s:%zu: a face refers to %s %llu", s->name, s->at.line,
                    names[kind], (unsigned long long)k);
  if (k > s->most[kind].largest) s->most[kind] = (extent){k, s->at.line};
  *out = (uint32_t)(k - 1);
  return YLM_OK;
}

/* v, v/vt, v//vn or v/vt/vn. */
static ylm_status read_corner(parser *s, ylm_corner *c) {
  *c = (ylm_corner){YLM_NO_INDEX, YLM_NO_INDEX, YLM_NO_INDEX};
  ylm_status st = read_index(s, 0, &c->v);
  if (st == YLM_OK && s->at.p < s->at.end && *s->at.p == '/') {
    s->at.p++;
    if (s->at.p < s->at.end && *s->at.p != '/') st = read_index(s, 1, &c->t);
    if (st == YLM_OK && s->at.p < s->at.end && *s->at.p == '/') {
      s->at.p++;
      st = read_index(s, 2, &c->n);
    }
  }
  if (st == YLM_OK && !ylm__at_line_end(&s->at) && *s->at.p != ' ' && *s->at.p != '\t' &&
      *s->at.p != '\\')
    st = ylm_fail(s->e, YLM_EFORMAT, "%s:%zu: a face has corners v, v/vt, v//vn or v/vt/vn",
                  s->name, s->at.line);
  s->bare_normal |= c->n == YLM_NO_INDEX;
  return st;
}

/* n further triangles of the current smoothing group; false: no memory. */
static bool add_smoothing(parser *s, size_t n) {
  uint32_t *group = ylm__grow(&s->smooth, n);
  for (size_t i = 0; group && i < n; i++) group[i] = s->smoothing;
  if (group) s->smooth.count += n;
  return group != NULL;
}

/* The rest of a line of s: "off", or the number of a group, of which 0 is none. */
static void read_smoothing(parser *s) {
  ylm__skip_blanks(&s->at);
  const unsigned char *word = s->at.p;
  size_t n = ylm__skip_word(&s->at);
  uint64_t k = 0;
  for (size_t i = 0; i < n && k < YLM_MESH_BY_ANGLE; i++)
    k = word[i] >= '0' && word[i] <= '9' ? 10 * k + (uint64_t)(word[i] - '0') : YLM_MESH_BY_ANGLE;
  bool known = n > 0 && k < YLM_MESH_BY_ANGLE;
  s->smoothing = ylm__is_word(word, n, "off") ? YLM_MESH_FLAT
                 : known                      ? (uint32_t)k
                                              : YLM_MESH_BY_ANGLE;
  ylm__skip_line(&s->at);
}

static ylm_status read_face(parser *s) {
  s->polygon.count = 0;
  for (ylm__skip_blanks(&s->at); !ylm__at_line_end(&s->at) && *s->at.p != '#';
       ylm__skip_blanks(&s->at)) {
    ylm_corner *c = ylm__grow(&s->polygon, 1);
    if (!c) return ylm_no_memory_for(s->e, s->name);
    ylm_status st = read_corner(s, c);
    if (st != YLM_OK) return st;
    s->polygon.count++;
    if (!ylm__at_line_end(&s->at) && *s->at.p == '\\' &&
        (s->at.end - s->at.p < 2 || (s->at.p[1] != '\n' && s->at.p[1] != '\r')))
      return ylm_fail(s->e, YLM_EFORMAT, "%s:%zu: unexpected '\\' in a face", s->name, s->at.line);
    const unsigned char *before = s->at.p;
    ylm__skip_blanks(&s->at);
    if (s->at.p == before && !ylm__at_line_end(&s->at) && *s->at.p != '#')
      return ylm_fail(s->e, YLM_EFORMAT, "%s:%zu: unexpected text in a face", s->name, s->at.line);
  }
  if (s->polygon.count < 3)
    return ylm_fail(s->e, YLM_EFORMAT, "%s:%zu: a face has %zu corners, 3 at least are wanted",
                    s->name, s->at.line, s->polygon.count);
  if (!ylm__add_polygon(&s->triangle, s->polygon.data, s->polygon.count) ||
      !add_smoothing(s, s->polygon.count - 2) ||
      (s->groups && !ylm__groups_faces(s->groups, s->polygon.count - 2)))
    return ylm_no_memory_for(s->e, s->name);
  if (s->triangle.count / 3 > YLM_MESH_MAX)
    return ylm_fail(s->e, YLM_ELIMIT, "%s:%zu: more than %zu triangles", s->name, s->at.line,
                    YLM_MESH_MAX);
  ylm__skip_line(&s->at);
  return YLM_OK;
}

/* A statement about materials, by the function that reads its rest. */
static ylm_status read_grouping(parser *s, const char *what,
                                ylm_status (*read)(ylm_grouping *, ylm_lines *)) {
  size_t line = s->at.line;
  ylm_status st = read(s->groups, &s->at);
  if (st == YLM_ENOMEM) return ylm_no_memory_for(s->e, s->name);
  if (st != YLM_OK)
    return ylm_fail(s->e, st, "%s:%zu: the name after %s has a zero byte", s->name, line, what);
  return YLM_OK;
}

/* One line, from its first word on. */
static ylm_status read_statement(parser *s) {
  const unsigned char *word = s->at.p;
  size_t n = ylm__skip_word(&s->at);
  if (n == 1 && word[0] == 'v') return read_numbers(s, &s->place, "v", 3, 3);
  if (n == 2 && memcmp(word, "vt", 2) == 0) return read_numbers(s, &s->uv, "vt", 2, 1);
  if (n == 2 && memcmp(word, "vn", 2) == 0) return read_numbers(s, &s->normal, "vn", 3, 3);
  if (n == 1 && word[0] == 'f') return read_face(s);
  if (n == 1 && word[0] == 's') {
    read_smoothing(s);
    return YLM_OK;
  }
  if (s->groups && ylm__is_word(word, n, "mtllib"))
    return read_grouping(s, "mtllib", ylm__groups_library);
  if (s->groups && ylm__is_word(word, n, "usemtl"))
    return read_grouping(s, "usemtl", ylm__groups_use);
  if (n > 0 && !ylm__is_statement(word, n))
    return ylm_fail(s->e, YLM_EFORMAT, "%s:%zu: not a statement of an OBJ file", s->name,
                    s->at.line);
  s->at.p = word;
  ylm__skip_line(&s->at);
  return YLM_OK;
}

static ylm_status read_lines(parser *s) {
  while (s->at.p < s->at.end) {
    ylm__skip_blanks(&s->at);
    ylm_status st = ylm__at_line_end(&s->at) ? YLM_OK : read_statement(s);
    if (st != YLM_OK) return st;
    ylm__next_line(&s->at);
  }
  static const char *const names[] = {"vertex", "texture coordinate", "normal"};
  const ylm_growing *pool[] = {&s->place, &s->uv, &s->normal};
  for (int k = 0; k < 3; k++)
    if (s->most[k].largest > pool[k]->count)
      return ylm_fail(s->e, YLM_EFORMAT, "%s:%zu: a face refers to %s %llu, the file has %zu",
                      s->name, s->most[k].line, names[k], (unsigned long long)s->most[k].largest,
                      pool[k]->count);
  if (s->triangle.count == 0)
    return ylm_fail(s->e, YLM_EFORMAT, "%s: not an OBJ file with faces (%zu vertices)", s->name,
                    s->place.count);
  return YLM_OK;
}

/* Places become positions relative to an origin. */
static ylm_status take_places(parser *s) {
  ylm_mesh plain = {.vertices = s->place.count,
                    .position = ylm_alloc(s->place.count, 3 * sizeof(float))};
  if (!plain.position) return ylm_no_memory_for(s->e, s->name);
  ylm_mesh_set_places(&plain, s->place.data);
  memcpy(s->origin, plain.origin, sizeof s->origin);
  s->position = (ylm_growing){plain.position, plain.vertices, plain.vertices, 3 * sizeof(float)};
  return YLM_OK;
}

/* Normals of the positions, before these are split by texture coordinates: n of each corner is its vertex in a mesh
   that is split at creases alone, whose positions and normals take the place of the file's. */
static ylm_status make_normals(parser *s) {
  ylm_corner *c = s->triangle.data;
  ylm_mesh plain = {.vertices = s->position.count,
                    .triangles = s->triangle.count / 3,
                    .position = s->position.data,
                    .index = ylm_alloc(s->triangle.count, sizeof(uint32_t))};
  ylm_status st = plain.index ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; st == YLM_OK && i < s->triangle.count; i++) plain.index[i] = c[i].v;
  if (st == YLM_OK) st = ylm_mesh_make_creased_normals(&plain, s->crease, s->smooth.data);
  ylm_free(s->normal.data);
  s->position = (ylm_growing){plain.position, plain.vertices, plain.vertices, 3 * sizeof(float)};
  s->normal = (ylm_growing){plain.normal, plain.vertices, plain.vertices, 3 * sizeof(float)};
  for (size_t i = 0; st == YLM_OK && i < s->triangle.count; i++) c[i].n = plain.index[i];
  ylm_free(plain.index);
  return st == YLM_OK ? st : ylm_fail(s->e, st, "%s: memory ran out", s->name);
}

/* Numbers distinct corners in the order they come: vertex[i] of corner i, first[k] the corner that
   made vertex k. */
static bool number_corners(const ylm_corner *c, size_t n, uint32_t *vertex, uint32_t *first,
                           size_t *count) {
  ylm_keys corners = {0};
  bool ok = true;
  for (size_t i = 0; ok && i < n; i++) {
    size_t before = corners.n;
    ok = ylm_keys_put(&corners, &c[i], sizeof *c, &vertex[i]) == YLM_OK;
    if (corners.n > before) first[before] = (uint32_t)i;
  }
  *count = corners.n;
  ylm_keys_free(&corners);
  return ok;
}

/* Positions as make_normals left them: no texture coordinates. */
static ylm_status build_plain(parser *s, ylm_mesh **m) {
  ylm_status st = ylm_mesh_create(s->position.count, s->triangle.count / 3, true, false, m, s->e);
  if (st != YLM_OK) return st;
  const ylm_corner *c = s->triangle.data;
  memcpy((*m)->position, s->position.data, s->position.count * 3 * sizeof(float));
  memcpy((*m)->normal, s->normal.data, s->position.count * 3 * sizeof(float));
  for (size_t i = 0; i < s->triangle.count; i++) (*m)->index[i] = c[i].n;
  return YLM_OK;
}

/* A vertex for each distinct (v, vt, vn). */
static ylm_status build_split(parser *s, bool uvs, ylm_mesh **m) {
  size_t n = s->triangle.count, count = 0;
  const ylm_corner *c = s->triangle.data;
  uint32_t *vertex = ylm_alloc(n, sizeof *vertex), *first = ylm_alloc(n, sizeof *first);
  ylm_status st = YLM_ENOMEM;
  if (vertex && first && number_corners(c, n, vertex, first, &count))
    st = ylm_mesh_create(count, n / 3, true, uvs, m, s->e);
  else
    ylm_fail(s->e, st, "%s: memory ran out", s->name);
  if (st == YLM_OK) {
    const float *p = s->position.data, *t = s->uv.data, *q = s->normal.data;
    for (size_t k = 0; k < count; k++) {
      const ylm_corner *f = &c[first[k]];
      memcpy((*m)->position + 3 * k, p + 3 * (size_t)f->v, 3 * sizeof(float));
      memcpy((*m)->normal + 3 * k, q + 3 * (size_t)f->n, 3 * sizeof(float));
      if (uvs && f->t != YLM_NO_INDEX)
        memcpy((*m)->uv + 2 * k, t + 2 * (size_t)f->t, 2 * sizeof(float));
    }
    memcpy((*m)->index, vertex, n * sizeof *vertex);
  }
  ylm_free(vertex);
  ylm_free(first);
  return st;
}

/* Given normals to unit length; (0, 0, 1) for zero ones. */
static void normalise(float *n, size_t count) {
  for (size_t i = 0; i < count; i++, n += 3) {
    double length = sqrt((double)n[0] * n[0] + (double)n[1] * n[1] + (double)n[2] * n[2]);
    for (int a = 0; a < 3; a++) n[a] = length > 0 ? (float)(n[a] / length) : a == 2;
  }
}

/* ylm_mesh_parse_obj; groups NULL: not wanted. */
static ylm_status parse(const unsigned char *text, size_t size, const char *name, double crease,
                        ylm_grouping *groups, ylm_mesh **m, ylm_error *e) {
  parser s = {.at = {text, text + size, 1},
              .name = name,
              .e = e,
              .groups = groups,
              .smoothing = YLM_MESH_BY_ANGLE,
              .crease = crease};
  s.smooth.size = sizeof(uint32_t);
  s.place.size = 3 * sizeof(double);
  s.normal.size = 3 * sizeof(float);
  s.uv.size = 2 * sizeof(float);
  s.polygon.size = s.triangle.size = sizeof(ylm_corner);
  *m = NULL;
  ylm_status st = read_lines(&s);
  bool made = s.bare_normal, uvs = s.most[1].largest > 0;
  if (st == YLM_OK) st = take_places(&s);
  if (st == YLM_OK && made)
    st = make_normals(&s);
  else if (st == YLM_OK)
    normalise(s.normal.data, s.normal.count);
  if (st == YLM_OK) st = made && !uvs ? build_plain(&s, m) : build_split(&s, uvs, m);
  if (st == YLM_OK) memcpy((*m)->origin, s.origin, sizeof s.origin);
  ylm_free(s.place.data);
  ylm_free(s.position.data);
  ylm_free(s.uv.data);
  ylm_free(s.normal.data);
  ylm_free(s.polygon.data);
  ylm_free(s.triangle.data);
  ylm_free(s.smooth.data);
  return st;
}

ylm_status ylm_mesh_parse_obj(const unsigned char *text, size_t size, const char *name,
                              double crease, ylm_mesh **m, ylm_error *e) {
  return parse(text, size, name, crease, NULL, m, e);
}

ylm_status ylm_mesh_parse_obj_groups(const unsigned char *text, size_t size, const char *name,
                                     double crease, ylm_mesh **m, ylm_mesh_groups **groups,
                                     ylm_error *e) {
  ylm_grouping g;
  ylm__groups_begin(&g);
  *groups = NULL;
  ylm_status st = parse(text, size, name, crease, &g, m, e);
  if (st == YLM_OK && !(*groups = ylm__groups_finish(&g))) {
    ylm_mesh_free(*m);
    *m = NULL;
    st = ylm_no_memory_for(e, name);
  }
  ylm__groups_discard(&g);
  return st;
}

bool ylm_mesh_is_ply(const unsigned char *bytes, size_t size) {
  return size >= 4 && memcmp(bytes, "ply", 3) == 0 && (bytes[3] == '\n' || bytes[3] == '\r');
}

ylm_status ylm_mesh_read(const char *path, double crease, ylm_mesh **m, ylm_error *e) {
  unsigned char *bytes;
  size_t size;
  *m = NULL;
  ylm_status s = ylm_file_read(path, 0, &bytes, &size, e);
  if (s != YLM_OK) return s;
  s = ylm_mesh_is_ply(bytes, size) ? ylm_mesh_parse_ply(bytes, size, path, crease, m, e)
                                   : ylm_mesh_parse_obj(bytes, size, path, crease, m, e);
  ylm_free(bytes);
  return s;
}
