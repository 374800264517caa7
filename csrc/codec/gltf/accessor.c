/* accessor.c - buffers, views into them, accessors: every offset checked before a byte is read. */
#include "gltf.h"

static uint16_t u16(const unsigned char *p) { return (uint16_t)(p[0] | p[1] << 8); }
static uint32_t u32(const unsigned char *p) { return u16(p) | (uint32_t)u16(p + 2) << 16; }

size_t ylm__gltf_component_size(int component) {
  switch (component) {
  case 5120:
  case 5121: return 1;
  case 5122:
  case 5123: return 2;
  case 5125:
  case 5126: return 4;
  default: return 0;
  }
}

enum { ZEROS = 1 << 20 }; /* elements of an accessor without bytes */

/* -- buffers and views ----------------------------------------------------------------- */

static void read_buffer(gltf *g, const place *at, const json_t *o, size_t i, gltf_bytes *b) {
  uint64_t said = ylm__gltf_integer(g, at, o, "byteLength", 0);
  const char *uri = ylm__gltf_string(g, at, o, "uri");
  if (g->status != YLM_OK) return;
  place p = {at, "uri", 0};
  if (uri)
    ylm__gltf_fetch(g, &p, uri, b);
  else if (i == 0)
    *b = g->binary;
  if (g->status == YLM_OK && said > b->size)
    ylm__gltf_fail(g, YLM_EFORMAT, at, "buffer %zu has %zu bytes, %llu are said", i, b->size,
                   (unsigned long long)said);
  if (said < b->size) b->size = (size_t)said;
}

static void read_view(gltf *g, const place *at, const json_t *o, gltf_view *v) {
  int64_t buffer = ylm__gltf_reference(g, at, o, "buffer", "buffer", g->buffers);
  uint64_t offset = ylm__gltf_integer(g, at, o, "byteOffset", 0);
  uint64_t length = ylm__gltf_integer(g, at, o, "byteLength", 0);
  uint64_t stride = ylm__gltf_integer(g, at, o, "byteStride", 0), end;
  if (g->status != YLM_OK) return;
  if (buffer < 0) {
    ylm__gltf_fail(g, YLM_EFORMAT, at, "a buffer is missing");
    return;
  }
  const gltf_bytes *b = &g->buffer[buffer];
  if (__builtin_add_overflow(offset, length, &end) || end > b->size)
    ylm__gltf_fail(g, YLM_EFORMAT, at, "bytes %llu to %llu of a buffer of %zu",
                   (unsigned long long)offset, (unsigned long long)end, b->size);
  else if (stride != 0 && (stride < 4 || stride > 252 || stride % 4 != 0))
    ylm__gltf_fail(g, YLM_EFORMAT, at,
                   "byteStride from 4 to 252, a multiple of 4, expected, not %llu",
                   (unsigned long long)stride);
  else
    *v = (gltf_view){b->data ? b->data + offset : NULL, (size_t)length, (size_t)stride};
}

/* -- accessors ------------------------------------------------------------------------- */

static int numbers_of(const char *type) {
  static const struct {
    const char *name;
    int numbers;
  } types[] = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4},
               {"MAT2", 4},   {"MAT3", 9}, {"MAT4", 16}};
  for (size_t i = 0; type && i < sizeof types / sizeof *types; i++)
    if (strcmp(type, types[i].name) == 0) return types[i].numbers;
  return 0;
}

/* Finds `count` elements of `size` bytes, `stride` apart, in a view; NULL and a failure where they
   are not all in it. */
static const unsigned char *locate(gltf *g, const place *at, const gltf_view *v, uint64_t offset,
                                   size_t stride, uint64_t count, size_t size, size_t align) {
  uint64_t end;
  bool over = __builtin_mul_overflow((uint64_t)stride, count - 1, &end);
  over = __builtin_add_overflow(end, size, &end) || over;
  over = __builtin_add_overflow(end, offset, &end) || over;
  if (over || end > v->size) {
    ylm__gltf_fail(g, YLM_EFORMAT, at,
                   "%llu elements from byte %llu on do not fit a view of %zu bytes",
                   (unsigned long long)count, (unsigned long long)offset, v->size);
    return NULL;
  }
  if (offset % align != 0)
    ylm__gltf_fail(g, YLM_EFORMAT, at, "byteOffset %llu is no multiple of %zu",
                   (unsigned long long)offset, align);
  return v->data + offset;
}

static uint32_t sparse_index(const gltf_accessor *a, size_t i) {
  const unsigned char *p = a->sparse_index + i * ylm__gltf_component_size(a->sparse_component);
  return a->sparse_component == 5121 ? p[0] : a->sparse_component == 5123 ? u16(p) : u32(p);
}

static void read_sparse(gltf *g, const place *at, const json_t *o, gltf_accessor *a) {
  place p = {at, "sparse", 0}, pi = {&p, "indices", 0}, pv = {&p, "values", 0};
  const json_t *indices = ylm__gltf_object(g, &p, o, "indices");
  const json_t *values = ylm__gltf_object(g, &p, o, "values");
  uint64_t count = ylm__gltf_integer(g, &p, o, "count", 0);
  int64_t vi = ylm__gltf_reference(g, &pi, indices, "bufferView", "view", g->views);
  int64_t vv = ylm__gltf_reference(g, &pv, values, "bufferView", "view", g->views);
  uint64_t oi = ylm__gltf_integer(g, &pi, indices, "byteOffset", 0);
  uint64_t ov = ylm__gltf_integer(g, &pv, values, "byteOffset", 0);
  a->sparse_component = (int)(ylm__gltf_integer(g, &pi, indices, "componentType", 0) & 0xffff);
  if (g->status != YLM_OK) return;
  size_t width = ylm__gltf_component_size(a->sparse_component);
  if (count < 1 || count > a->count || vi < 0 || vv < 0 ||
      (a->sparse_component != 5121 && a->sparse_component != 5123 && a->sparse_component != 5125)) {
    ylm__gltf_fail(g, YLM_EFORMAT, &p, "1 to %zu elements, indices and values expected", a->count);
    return;
  }
  size_t size = ylm__gltf_component_size(a->component) * (size_t)a->numbers;
  a->sparse_index = locate(g, &pi, &g->view[vi], oi, width, count, width, width);
  a->sparse_value =
      locate(g, &pv, &g->view[vv], ov, size, count, size, ylm__gltf_component_size(a->component));
  if (g->status != YLM_OK) return;
  for (size_t i = 0; i < count; i++) {
    uint32_t k = sparse_index(a, i);
    if (k >= a->count || (i > 0 && k <= sparse_index(a, i - 1))) {
      ylm__gltf_fail(g, YLM_EFORMAT, &pi, "index %zu is %u: rising ones below %zu expected", i, k,
                     a->count);
      return;
    }
  }
  a->sparse = (size_t)count;
}

static void read_accessor(gltf *g, const place *at, const json_t *o, gltf_accessor *a) {
  uint64_t count = ylm__gltf_integer(g, at, o, "count", 0);
  uint64_t offset = ylm__gltf_integer(g, at, o, "byteOffset", 0);
  int64_t view = ylm__gltf_reference(g, at, o, "bufferView", "view", g->views);
  const char *type = ylm__gltf_string(g, at, o, "type");
  const json_t *sparse = ylm__gltf_object(g, at, o, "sparse");
  a->component = (int)(ylm__gltf_integer(g, at, o, "componentType", 0) & 0xffff);
  a->normalized = ylm__gltf_boolean(g, at, o, "normalized");
  a->numbers = numbers_of(type);
  if (g->status != YLM_OK) return;
  size_t component = ylm__gltf_component_size(a->component);
  size_t size = component * (size_t)a->numbers;
  if (size == 0) {
    ylm__gltf_fail(g, YLM_EFORMAT, at, "type %.20s of componentType %d is not known",
                   type ? type : "(none)", a->component);
  } else if (count < 1 || count > UINT32_MAX) {
    ylm__gltf_fail(g, YLM_EFORMAT, at, "count must be 1 or more, and below 2^32");
  } else if (a->component == 5125 && a->normalized) {
    ylm__gltf_fail(g, YLM_EFORMAT, at, "integers of 32 bits cannot be normalised");
  } else if (view < 0 && count > ZEROS) {
    ylm__gltf_fail(g, YLM_ELIMIT, at, "%llu elements without a view, %d at most are read",
                   (unsigned long long)count, ZEROS);
  } else if (view >= 0) {
    const gltf_view *v = &g->view[view];
    a->stride = v->stride ? v->stride : size;
    a->data = locate(g, at, v, offset, a->stride, count, size, component);
  }
  a->count = (size_t)count;
  if (g->status == YLM_OK && sparse) read_sparse(g, at, sparse, a);
}

void ylm__gltf_accessors(gltf *g) {
  place pb = {NULL, "buffers", 0}, pv = {NULL, "bufferViews", 0}, pa = {NULL, "accessors", 0};
  json_t *buffers = ylm__gltf_list(g, NULL, g->root, "buffers", &g->buffers);
  json_t *views = ylm__gltf_list(g, NULL, g->root, "bufferViews", &g->views);
  json_t *accessors = ylm__gltf_list(g, NULL, g->root, "accessors", &g->accessors);
  g->buffer = ylm__gltf_alloc(g, g->buffers, sizeof *g->buffer);
  g->view = ylm__gltf_alloc(g, g->views, sizeof *g->view);
  g->accessor = ylm__gltf_alloc(g, g->accessors, sizeof *g->accessor);
  uint64_t bytes = 0, sparse = 0;
  for (size_t i = 0; g->status == YLM_OK && i < g->buffers; i++) {
    place p = {&pb, NULL, i};
    read_buffer(g, &p, ylm__gltf_entry(g, &pb, buffers, i), i, &g->buffer[i]);
    bytes += g->buffer[i].size;
  }
  for (size_t i = 0; g->status == YLM_OK && i < g->views; i++) {
    place p = {&pv, NULL, i};
    read_view(g, &p, ylm__gltf_entry(g, &pv, views, i), &g->view[i]);
  }
  for (size_t i = 0; g->status == YLM_OK && i < g->accessors; i++) {
    place p = {&pa, NULL, i};
    read_accessor(g, &p, ylm__gltf_entry(g, &pa, accessors, i), &g->accessor[i]);
    sparse += g->accessor[i].sparse;
    if (sparse > bytes)
      ylm__gltf_fail(g, YLM_ELIMIT, &p,
                     "sparse accessors share their indices: more of them than bytes");
  }
}

/* -- elements -------------------------------------------------------------------------- */

static float number(const unsigned char *p, int component, bool normalized) {
  switch (component) {
  case 5120: {
    float x = (float)(int8_t)p[0];
    return !normalized ? x : x < -127 ? -1 : x / 127;
  }
  case 5121: return normalized ? (float)p[0] / 255 : (float)p[0];
  case 5122: {
    float x = (float)(int16_t)u16(p);
    return !normalized ? x : x < -32767 ? -1 : x / 32767;
  }
  case 5123: return normalized ? (float)u16(p) / 65535 : (float)u16(p);
  case 5125: return (float)u32(p);
  default: {
    uint32_t bits = u32(p);
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
  }
  }
}

/* The bytes of element i; NULL: zeros. */
static const unsigned char *bytes_of(const gltf_accessor *a, size_t i) {
  size_t size = ylm__gltf_component_size(a->component) * (size_t)a->numbers;
  for (size_t lo = 0, hi = a->sparse; lo < hi;) {
    size_t mid = lo + (hi - lo) / 2;
    uint32_t k = sparse_index(a, mid);
    if (k == i) return a->sparse_value + mid * size;
    if (k < i)
      lo = mid + 1;
    else
      hi = mid;
  }
  return a->data ? a->data + i * a->stride : NULL;
}

void ylm__gltf_element(const gltf_accessor *a, size_t i, float *out) {
  const unsigned char *p = bytes_of(a, i);
  size_t size = ylm__gltf_component_size(a->component);
  for (int k = 0; k < a->numbers; k++)
    out[k] = p ? number(p + (size_t)k * size, a->component, a->normalized) : 0;
}

uint32_t ylm__gltf_index(const gltf_accessor *a, size_t i) {
  const unsigned char *p = bytes_of(a, i);
  return !p ? 0 : a->component == 5121 ? p[0] : a->component == 5123 ? u16(p) : u32(p);
}
