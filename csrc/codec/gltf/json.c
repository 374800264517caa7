/* json.c - JSON: counted before it is parsed; typed entries, whose errors name the place. */
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>

#include "gltf.h"
#include "ylm_list.h"

/* -- failures ----------------------------------------------------------------------- */

/* Writes a place as a JSON pointer. */
static size_t write_place(const place *at, char *out, size_t room) {
  if (!at) return 0;
  size_t n = write_place(at->up, out, room);
  if (n >= room) return room;
  int more = at->key ? snprintf(out + n, room - n, "/%s", at->key)
                     : snprintf(out + n, room - n, "/%zu", at->index);
  return n + (size_t)more < room ? n + (size_t)more : room;
}

void ylm__gltf_fail(gltf *g, ylm_status s, const place *at, const char *format, ...) {
  if (g->status != YLM_OK) return;
  char where[160] = "", text[240];
  write_place(at, where, sizeof where);
  va_list args;
  va_start(args, format);
  vsnprintf(text, sizeof text, format, args);
  va_end(args);
  g->status = ylm_fail(g->e, s, "%s: %s%s%s", g->name, where, *where ? ": " : "", text);
}

void *ylm__gltf_alloc(gltf *g, size_t count, size_t size) {
  if (g->status != YLM_OK) return NULL;
  void *p = ylm_alloc_zero(count ? count : 1, size);
  if (!p) ylm__gltf_fail(g, YLM_ENOMEM, NULL, "memory ran out");
  return p;
}

void ylm__gltf_note(gltf *g, const char *format, ...) {
  if (g->status != YLM_OK || g->out->notes >= 64) return;
  char text[300];
  va_list args;
  va_start(args, format);
  vsnprintf(text, sizeof text, format, args);
  va_end(args);
  bool more =
      ylm_list_resize(&g->out->note, g->out->notes, g->out->notes + 1, sizeof *g->out->note);
  char *copy = more ? ylm_alloc_copy(text, strlen(text) + 1, 1) : NULL;
  if (copy)
    g->out->note[g->out->notes++] = copy;
  else
    ylm__gltf_fail(g, YLM_ENOMEM, NULL, "memory ran out");
}

/* -- parsing ------------------------------------------------------------------------- */

enum { DEPTH = 64, MOST = 1 << 26 };

/* Bytes that jansson allocates at most for an object, an array, an entry. */
enum { OBJECT = 136, ARRAY = 112, ENTRY = 48 };

/* Counts brackets and commas outside of strings. */
static void count(gltf *g, const unsigned char *p, size_t size) {
  uint64_t memory = 0;
  int depth = 0;
  bool text = false;
  for (size_t i = 0; i < size; i++) {
    unsigned char c = p[i];
    if (text) {
      if (c == '\\') i++;
      text = c != '"';
      continue;
    }
    if (c == '"') text = true;
    if (c == ',') memory += ENTRY;
    if (c == '{' || c == '[') {
      memory += c == '{' ? OBJECT : ARRAY;
      if (++depth > DEPTH) {
        ylm__gltf_fail(g, YLM_ELIMIT, NULL, "the JSON nests more than %d deep", DEPTH);
        return;
      }
    }
    if ((c == '}' || c == ']') && depth > 0) depth--;
  }
  if (memory > (uint64_t)1 << 30)
    ylm__gltf_fail(g, YLM_ELIMIT, NULL,
                   "the JSON has too many entries: they would take more than 1 GiB");
}

void ylm__gltf_parse(gltf *g, const unsigned char *text, size_t size) {
  if (size > MOST) {
    ylm__gltf_fail(g, YLM_ELIMIT, NULL, "the JSON has %zu bytes, 64 MiB at most are read", size);
    return;
  }
  count(g, text, size);
  if (g->status != YLM_OK) return;
  json_error_t wrong;
  g->root = json_loadb((const char *)text, size, JSON_REJECT_DUPLICATES, &wrong);
  if (!g->root && json_error_code(&wrong) == json_error_out_of_memory)
    ylm__gltf_fail(g, YLM_ENOMEM, NULL, "memory ran out");
  else if (!g->root)
    ylm__gltf_fail(g, YLM_EFORMAT, NULL, "line %d, column %d: not JSON: %s", wrong.line,
                   wrong.column, wrong.text);
  else if (!json_is_object(g->root))
    ylm__gltf_fail(g, YLM_EFORMAT, NULL, "the JSON is no object");
}

/* -- entries ------------------------------------------------------------------------- */

static const char *const kinds[] = {"an object", "a list",        "a string",      "an integer",
                                    "a number",  "true or false", "true or false", "nothing"};

/* The entry `key`; NULL where there is none, and after a failure. */
static json_t *member(gltf *g, const place *at, const json_t *o, const char *key, json_type type) {
  json_t *v = g->status == YLM_OK ? json_object_get(o, key) : NULL;
  if (!v) return NULL;
  bool fits = json_typeof(v) == type || (type == JSON_REAL && json_is_number(v)) ||
              (type == JSON_TRUE && json_is_boolean(v));
  if (fits) return v;
  place p = {at, key, 0};
  ylm__gltf_fail(g, YLM_EFORMAT, &p, "%s expected, not %s", kinds[type], kinds[json_typeof(v)]);
  return NULL;
}

json_t *ylm__gltf_list(gltf *g, const place *at, const json_t *o, const char *key, size_t *n) {
  json_t *list = member(g, at, o, key, JSON_ARRAY);
  place p = {at, key, 0};
  *n = list ? json_array_size(list) : 0;
  if (*n <= GLTF_COUNT) return list;
  ylm__gltf_fail(g, YLM_ELIMIT, &p, "%zu entries, at most %zu are read", *n, GLTF_COUNT);
  *n = 0;
  return NULL;
}

json_t *ylm__gltf_object(gltf *g, const place *at, const json_t *o, const char *key) {
  return member(g, at, o, key, JSON_OBJECT);
}

json_t *ylm__gltf_entry(gltf *g, const place *at, json_t *list, size_t i) {
  json_t *v = json_array_get(list, i);
  if (json_is_object(v)) return v;
  place p = {at, NULL, i};
  ylm__gltf_fail(g, YLM_EFORMAT, &p, "an object expected");
  return NULL;
}

json_t *ylm__gltf_extension(gltf *g, const place *at, const json_t *o, const char *name) {
  json_t *all = member(g, at, o, "extensions", JSON_OBJECT);
  place p = {at, "extensions", 0};
  return member(g, &p, all, name, JSON_OBJECT);
}

const char *ylm__gltf_string(gltf *g, const place *at, const json_t *o, const char *key) {
  return json_string_value(member(g, at, o, key, JSON_STRING));
}

bool ylm__gltf_boolean(gltf *g, const place *at, const json_t *o, const char *key) {
  return json_is_true(member(g, at, o, key, JSON_TRUE));
}

double ylm__gltf_number(gltf *g, const place *at, const json_t *o, const char *key, double none,
                        double lo, double hi) {
  json_t *v = member(g, at, o, key, JSON_REAL);
  if (!v) return none;
  double x = json_number_value(v);
  if (x >= lo && x <= hi) return x;
  place p = {at, key, 0};
  ylm__gltf_fail(g, YLM_EFORMAT, &p, "a number from %g to %g expected, not %g", lo, hi, x);
  return none;
}

/* An integral number that is exact in a double; false else. */
static bool integral(const json_t *v, uint64_t *out) {
  double x = json_is_number(v) ? json_number_value(v) : -1;
  if (!(x >= 0 && x <= 9007199254740992.0) || x != floor(x)) return false;
  *out = (uint64_t)x;
  return true;
}

uint64_t ylm__gltf_integer(gltf *g, const place *at, const json_t *o, const char *key,
                           uint64_t none) {
  json_t *v = member(g, at, o, key, JSON_REAL);
  uint64_t x = none;
  if (!v || integral(v, &x)) return x;
  place p = {at, key, 0};
  ylm__gltf_fail(g, YLM_EFORMAT, &p, "an integer of 0 or more expected");
  return none;
}

int64_t ylm__gltf_reference(gltf *g, const place *at, const json_t *o, const char *key,
                            const char *what, size_t total) {
  if (!json_object_get(o, key)) return -1;
  uint64_t i = ylm__gltf_integer(g, at, o, key, 0);
  place p = {at, key, 0};
  if (g->status == YLM_OK && i >= total)
    ylm__gltf_fail(g, YLM_EFORMAT, &p, "%s %llu of %zu (they are counted from 0)", what,
                   (unsigned long long)i, total);
  return g->status == YLM_OK ? (int64_t)i : -1;
}

bool ylm__gltf_numbers(gltf *g, const place *at, const json_t *o, const char *key, int n,
                       double *out) {
  json_t *list = member(g, at, o, key, JSON_ARRAY);
  if (!list) return false;
  bool fits = json_array_size(list) == (size_t)n;
  for (int i = 0; fits && i < n; i++) {
    const json_t *v = json_array_get(list, (size_t)i);
    fits = json_is_number(v);
    out[i] = json_number_value(v);
  }
  place p = {at, key, 0};
  if (!fits) ylm__gltf_fail(g, YLM_EFORMAT, &p, "%d numbers expected", n);
  return fits;
}

void ylm__gltf_name(gltf *g, const place *at, const json_t *o, char *out) {
  const char *s = ylm__gltf_string(g, at, o, "name");
  size_t n = s ? strlen(s) : 0;
  if (n >= YLM_GLTF_NAME)
    for (n = YLM_GLTF_NAME - 1; n > 0 && ((unsigned char)s[n] & 0xc0) == 0x80;) n--;
  ylm_copy(out, s, n);
  for (size_t i = 0; i < n; i++)
    if ((unsigned char)out[i] < 32 || out[i] == 127) out[i] = '?';
  out[n] = 0;
}

char *ylm__gltf_extras(gltf *g, const json_t *o) {
  const json_t *extras = g->status == YLM_OK ? json_object_get(o, "extras") : NULL;
  const json_t *mine = json_is_object(extras) ? json_object_get(extras, "ylm") : NULL;
  if (!json_is_object(mine)) return NULL;
  char *text = json_dumps(mine, JSON_COMPACT | JSON_REAL_PRECISION(17));
  char *copy = text ? ylm_alloc_copy(text, strlen(text) + 1, 1) : NULL;
  free(text);
  if (!copy) ylm__gltf_fail(g, YLM_ENOMEM, NULL, "memory ran out");
  return copy;
}
