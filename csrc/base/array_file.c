/* array_file.c - NumPy's .npy files of float32, float64, int32 and float16. */
#include "ylm_numbers.h"

#include <string.h>

static const unsigned char magic[6] = {0x93, 'N', 'U', 'M', 'P', 'Y'};

/* The header is the text of a Python dictionary; this reads the part of the language it uses. */
typedef struct parser {
  const char *p, *end;
  const char *name;
  ylm_error *e;
} parser;

static void skip_blanks(parser *s) {
  while (s->p < s->end && (*s->p == ' ' || *s->p == '\t' || *s->p == '\n' || *s->p == '\r')) s->p++;
}

/* True, and behind it, if the next sign is `c`. */
static bool accept(parser *s, char c) {
  skip_blanks(s);
  if (s->p == s->end || *s->p != c) return false;
  s->p++;
  return true;
}

/* A quoted word of at most 31 bytes. */
static bool read_word(parser *s, char word[32]) {
  skip_blanks(s);
  if (s->p == s->end || (*s->p != '\'' && *s->p != '"')) return false;
  char quote = *s->p++;
  size_t n = 0;
  while (s->p < s->end && *s->p != quote && n < 31) word[n++] = *s->p++;
  word[n] = 0;
  return accept(s, quote);
}

static ylm_status bad(parser *s, const char *what) {
  return ylm_fail(s->e, YLM_EFORMAT, "%s: damaged .npy header (%s)", s->name, what);
}

/* NumPy's codes of the element types. */
static const char *const codes[YLM_NUMBERS_TYPES] = {"f4", "f8", "i4", "f2"};

static ylm_status read_type(parser *s, ylm_array_file *a) {
  char word[32];
  if (!read_word(s, word)) return bad(s, "descr");
  int t = 0;
  while (t < YLM_NUMBERS_TYPES && strcmp(word + 1, codes[t]) != 0) t++;
  if ((word[0] != '<' && word[0] != '>') || t == YLM_NUMBERS_TYPES)
    return ylm_fail(s->e, YLM_EFORMAT,
                    "%s: elements are '%s'; only float32 ('f4'), float64 ('f8'), int32 ('i4') and "
                    "float16 ('f2') are supported",
                    s->name, word);
  a->dtype = (ylm_dtype)t;
  a->big_endian = word[0] == '>';
  return YLM_OK;
}

static ylm_status read_shape(parser *s, ylm_array_file *a) {
  if (!accept(s, '(')) return bad(s, "shape");
  a->axes = 0;
  while (!accept(s, ')')) {
    uint64_t n = 0;
    if (a->axes > 0 && !accept(s, ',')) return bad(s, "shape");
    if (a->axes > 0 && accept(s, ')')) break;
    skip_blanks(s);
    if (s->p == s->end || *s->p < '0' || *s->p > '9') return bad(s, "shape");
    for (; s->p < s->end && *s->p >= '0' && *s->p <= '9'; s->p++)
      if (n < (uint64_t)1 << 56) n = 10 * n + (uint64_t)(*s->p - '0');
    if (a->axes == YLM_MAX_AXES)
      return ylm_fail(s->e, YLM_ELIMIT, "%s: more than %d axes", s->name, YLM_MAX_AXES);
    a->shape[a->axes++] = (size_t)n;
  }
  if (a->axes == 0) a->shape[a->axes++] = 1; /* a single number */
  if (!ylm_shape_count(a->axes, a->shape, &a->count))
    return ylm_fail(s->e, YLM_ELIMIT, "%s: the array is too large", s->name);
  return YLM_OK;
}

static ylm_status read_order(parser *s) {
  skip_blanks(s);
  if (s->end - s->p >= 5 && memcmp(s->p, "False", 5) == 0) {
    s->p += 5;
    return YLM_OK;
  }
  if (s->end - s->p >= 4 && memcmp(s->p, "True", 4) == 0)
    return ylm_fail(s->e, YLM_EFORMAT,
                    "%s: Fortran order is not supported; save numpy.ascontiguousarray(a)", s->name);
  return bad(s, "fortran_order");
}

/* The comment behind the dictionary, with which ylm notes the convention of coefficients. */
static void read_comment(parser *s, ylm_array_file *a) {
  static const char note[] = "# ylm convention ";
  size_t n = sizeof note - 1;
  skip_blanks(s);
  if ((size_t)(s->end - s->p) <= n || memcmp(s->p, note, n) != 0) return;
  uint32_t x = 0;
  for (s->p += n; s->p < s->end && *s->p >= '0' && *s->p <= '9' && x < 100000000; s->p++)
    x = 10 * x + (uint32_t)(*s->p - '0');
  a->convention = x;
}

static ylm_status read_dictionary(parser *s, ylm_array_file *a) {
  unsigned seen = 0;
  if (!accept(s, '{')) return bad(s, "no dictionary");
  while (!accept(s, '}')) {
    char key[32];
    if (!read_word(s, key) || !accept(s, ':')) return bad(s, "key");
    ylm_status st;
    unsigned bit = strcmp(key, "descr") == 0           ? 1
                   : strcmp(key, "fortran_order") == 0 ? 2
                   : strcmp(key, "shape") == 0         ? 4
                                                       : 0;
    if (bit == 0 || (seen & bit)) return bad(s, key);
    st = bit == 1 ? read_type(s, a) : bit == 2 ? read_order(s) : read_shape(s, a);
    if (st != YLM_OK) return st;
    seen |= bit;
    if (!accept(s, ',')) {
      if (!accept(s, '}')) return bad(s, "comma");
      break;
    }
  }
  if (seen != 7) return bad(s, "a key is missing");
  read_comment(s, a);
  return YLM_OK;
}

ylm_status ylm_array_file_parse(const unsigned char *bytes, size_t size, const char *name,
                                ylm_array_file *a, ylm_error *e) {
  memset(a, 0, sizeof *a);
  if (size < 10 || memcmp(bytes, magic, 6) != 0)
    return ylm_fail(e, YLM_EFORMAT, "%s: not an .npy file", name);
  if (bytes[6] < 1 || bytes[6] > 3)
    return ylm_fail(e, YLM_EVERSION, "%s: .npy version %d", name, bytes[6]);
  size_t begin = bytes[6] == 1 ? 10 : 12, length = (size_t)bytes[8] | (size_t)bytes[9] << 8;
  if (begin == 12) {
    if (size < 12) return ylm_fail(e, YLM_EFORMAT, "%s: truncated", name);
    length |= (size_t)bytes[10] << 16 | (size_t)bytes[11] << 24;
  }
  if (length > size - begin) return ylm_fail(e, YLM_EFORMAT, "%s: truncated", name);
  parser s = {(const char *)bytes + begin, (const char *)bytes + begin + length, name, e};
  ylm_status st = read_dictionary(&s, a);
  if (st != YLM_OK) return st;
  a->data = bytes + begin + length;
  size_t rest = size - begin - length, need = a->count * ylm_numbers_size(a->dtype);
  if (rest != need)
    return ylm_fail(e, YLM_EFORMAT, "%s: %s: %zu bytes of elements, the shape wants %zu", name,
                    rest < need ? "truncated" : "damaged", rest, need);
  return YLM_OK;
}

void ylm_array_file_copy(const ylm_array_file *a, void *out) {
  size_t n = ylm_numbers_size(a->dtype);
  const uint16_t one = 1;
  bool host_big = *(const unsigned char *)&one == 0;
  if (a->count == 0) return;
  if (a->big_endian == host_big) {
    memcpy(out, a->data, a->count * n);
    return;
  }
  unsigned char *to = out;
  for (size_t i = 0; i < a->count; i++)
    for (size_t k = 0; k < n; k++) to[i * n + k] = a->data[i * n + n - 1 - k];
}

ylm_status ylm_array_file_write(const char *path, ylm_dtype t, int axes, const size_t *shape,
                                uint32_t convention, const void *data, ylm_error *e) {
  size_t count;
  if (axes < 1 || axes > YLM_MAX_AXES || !ylm_shape_count(axes, shape, &count))
    return ylm_fail(e, YLM_ESHAPE, "%s: not a shape", path);
  if ((unsigned)t >= YLM_NUMBERS_TYPES)
    return ylm_fail(e, YLM_ETYPE, "%s: no element type has the number %d", path, (int)t);
  const uint16_t one = 1;
  char head[512], text[300];
  size_t n = 0;
  for (int i = 0; i < axes; i++)
    n += (size_t)snprintf(text + n, sizeof text - n, i ? ", %zu" : "%zu", shape[i]);
  n = (size_t)snprintf(
      head, sizeof head, "{'descr': '%c%s', 'fortran_order': False, 'shape': (%s%s), }",
      *(const unsigned char *)&one ? '<' : '>', codes[t], text, axes == 1 ? "," : "");
  if (convention)
    n += (size_t)snprintf(head + n, sizeof head - n, "  # ylm convention %u", convention);
  size_t whole = (10 + n + 1 + 63) / 64 * 64; /* elements begin at a multiple of 64 */
  memset(head + n, ' ', whole - 10 - n - 1);
  head[whole - 11] = '\n';
  unsigned char start[10] = {0};
  memcpy(start, magic, 6);
  start[6] = 1;
  start[8] = (unsigned char)(whole - 10);
  start[9] = (unsigned char)((whole - 10) >> 8);
  ylm_file *f;
  ylm_status s = ylm_file_create(path, &f, e);
  if (s != YLM_OK) return s;
  ylm_file_write(f, start, 10);
  ylm_file_write(f, head, whole - 10);
  ylm_file_write(f, data, count * ylm_numbers_size(t));
  return ylm_file_commit(f, e);
}
