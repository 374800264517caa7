/*
** tensor.c - the header of tensor files (Dupuy & Jakob 2018), checked before anything is read:
**
**     "tensor_file\0", version u8 1, u8 0, fields u32
**     per field: length of its name u16, name, axes u16, type u8, offset u64, extents u64 [axes]
**
** Numbers are little-endian, the header has no gaps, offsets count from the file's first byte.
*/
#include "tensor.h"

#include <math.h>
#include <string.h>

static const char magic[12] = "tensor_file";

/* Bytes and name of each type of element, by its number in the file. */
static const struct {
  unsigned char bytes;
  const char *name;
} types[] = {{0, "no type"}, {1, "u8"},  {1, "i8"},  {2, "u16"}, {2, "i16"}, {4, "u32"},
             {4, "i32"},     {8, "u64"}, {8, "i64"}, {2, "f16"}, {4, "f32"}, {8, "f64"}};

static const int known_types = sizeof types / sizeof *types;

/* The little-endian number of n bytes at p. */
static uint64_t number(const unsigned char *p, int n) {
  uint64_t x = 0;
  for (int i = n - 1; i >= 0; i--) x = x << 8 | p[i];
  return x;
}

/* The bytes of a header that are still to be read. */
typedef struct reader {
  const tensor *t;
  size_t at;
  bool short_of; /* the file ended */
} reader;

/* The next n bytes; NULL where the file ends before. */
static const unsigned char *take(reader *r, size_t n) {
  if (r->short_of || r->t->size - r->at < n) {
    r->short_of = true;
    return NULL;
  }
  r->at += n;
  return r->t->bytes + r->at - n;
}

static uint64_t take_number(reader *r, int n) {
  const unsigned char *p = take(r, (size_t)n);
  return p ? number(p, n) : 0;
}

/* The field's extents; *count: their product, SIZE_MAX where it cannot be that of a file. */
static void take_shape(reader *r, tensor_field *f) {
  f->count = 1;
  bool large = false;
  for (int a = 0; a < f->axes; a++) {
    uint64_t extent = take_number(r, 8);
    size_t product;
    large |= extent > SIZE_MAX || __builtin_mul_overflow(f->count, (size_t)extent, &product);
    if (large) continue;
    f->shape[a] = (size_t)extent;
    f->count = product;
  }
  if (large) f->count = SIZE_MAX;
}

#define NAMED(f) (int)((f)->length < 40 ? (f)->length : 40), (f)->name

/* Whether the name can be shown: ASCII without control characters. */
static bool is_text(const tensor_field *f) {
  for (size_t i = 0; i < f->length; i++)
    if (f->name[i] < ' ' || f->name[i] > '~') return false;
  return true;
}

static ylm_status truncated(const tensor *t, ylm_error *e) {
  return ylm_fail(e, YLM_EFORMAT, "%s: the file ends within its header", t->name);
}

/* The next field of a header; *offset: of its data. */
static ylm_status take_field(reader *r, tensor_field *f, uint64_t *offset, ylm_error *e) {
  const tensor *t = r->t;
  f->length = (size_t)take_number(r, 2);
  f->name = (const char *)take(r, f->length);
  uint64_t axes = take_number(r, 2);
  f->type = (int)take_number(r, 1);
  *offset = take_number(r, 8);
  if (r->short_of) return truncated(t, e);
  if (!is_text(f))
    return ylm_fail(e, YLM_EFORMAT, "%s: a field's name has characters that are no ASCII text",
                    t->name);
  if (axes > TENSOR_AXES)
    return ylm_fail(e, YLM_EFORMAT, "%s: field '%.*s' has %d axes, at most %d are known", t->name,
                    NAMED(f), (int)axes, TENSOR_AXES);
  f->axes = (int)axes;
  if (f->type < 1 || f->type >= known_types)
    return ylm_fail(e, YLM_EFORMAT, "%s: field '%.*s' has elements of type %d, which is not known",
                    t->name, NAMED(f), f->type);
  take_shape(r, f);
  return r->short_of ? truncated(t, e) : YLM_OK;
}

/* Whether the field's numbers lie behind the header and in the file. */
static ylm_status check_place(const tensor *t, const tensor_field *f, uint64_t offset,
                              ylm_error *e) {
  if (f->count > t->size / types[f->type].bytes || offset > t->size ||
      f->count * types[f->type].bytes > t->size - offset)
    return ylm_fail(e, YLM_EFORMAT, "%s: field '%.*s' lies outside of the file", t->name, NAMED(f));
  if (offset < t->end && f->count)
    return ylm_fail(e, YLM_EFORMAT, "%s: field '%.*s' lies within the header", t->name, NAMED(f));
  return YLM_OK;
}

/* Where the first field stands in the header. */
static const size_t first_field = sizeof magic + 2 + 4;

ylm_status ylm__tensor_open(const unsigned char *bytes, size_t size, const char *name, tensor *t,
                            ylm_error *e) {
  *t = (tensor){bytes, size, name, 0, 0};
  if (size < sizeof magic || memcmp(bytes, magic, sizeof magic) != 0)
    return ylm_fail(e, YLM_EFORMAT, "%s: not a tensor file: it does not begin with 'tensor_file'",
                    name);
  if (size < first_field) return truncated(t, e);
  const unsigned char *version = bytes + sizeof magic;
  if (version[0] != 1 || version[1] != 0)
    return ylm_fail(e, YLM_EVERSION, "%s: a tensor file of version %d.%d, only 1.0 is known", name,
                    version[0], version[1]);
  t->fields = (size_t)number(version + 2, 4);
  tensor_field f;
  uint64_t offset;
  reader r = {t, first_field, false};
  for (size_t i = 0; i < t->fields; i++) {
    ylm_status s = take_field(&r, &f, &offset, e);
    if (s != YLM_OK) return s;
  }
  t->end = r.at;
  r.at = first_field;
  for (size_t i = 0; i < t->fields; i++) {
    take_field(&r, &f, &offset, e);
    ylm_status s = check_place(t, &f, offset, e);
    if (s != YLM_OK) return s;
  }
  return YLM_OK;
}

bool ylm__tensor_find(const tensor *t, const char *name, tensor_field *f) {
  reader r = {t, first_field, false};
  uint64_t offset;
  for (size_t i = 0; i < t->fields; i++) {
    take_field(&r, f, &offset, NULL);
    f->data = t->bytes + offset;
    if (f->length == strlen(name) && memcmp(f->name, name, f->length) == 0) return true;
  }
  return false;
}

ylm_status ylm__tensor_field(const tensor *t, const char *name, tensor_type type, int axes,
                             tensor_field *f, ylm_error *e) {
  if (!ylm__tensor_find(t, name, f))
    return ylm_fail(e, YLM_EFORMAT, "%s: field '%s' is missing", t->name, name);
  if (f->type != (int)type)
    return ylm_fail(e, YLM_EFORMAT, "%s: field '%s' has elements of type %s, %s expected", t->name,
                    name, types[f->type].name, types[type].name);
  if (f->axes != axes)
    return ylm_fail(e, YLM_EFORMAT, "%s: field '%s' has %d axes, %d expected", t->name, name,
                    f->axes, axes);
  return YLM_OK;
}

float ylm__tensor_float(const tensor_field *f, size_t i) {
  uint32_t bits = (uint32_t)number(f->data + 4 * i, 4);
  float x;
  memcpy(&x, &bits, sizeof x);
  return x;
}

ylm_status ylm__tensor_floats(const tensor *t, const tensor_field *f, float *out, ylm_error *e) {
  for (size_t i = 0; i < f->count; i++) {
    out[i] = ylm__tensor_float(f, i);
    if (!isfinite(out[i]))
      return ylm_fail(e, YLM_EFORMAT, "%s: number %zu of field '%.*s' is not finite", t->name,
                      i + 1, NAMED(f));
  }
  return YLM_OK;
}
