/* container.c - bytes: chunks of .glb files, base64, files beside the JSON. */
#include <ctype.h>
#include <limits.h>
#include <stdlib.h>
#include <sys/stat.h>

#include "gltf.h"

static uint32_t u32(const unsigned char *p) {
  return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

enum { JSON_CHUNK = 0x4e4f534a, BIN_CHUNK = 0x004e4942 };

bool ylm_gltf_is_binary(const unsigned char *data, size_t size) {
  return size >= 4 && memcmp(data, "glTF", 4) == 0;
}

void ylm__gltf_unwrap(gltf *g, const unsigned char *data, size_t size, gltf_bytes *json) {
  *json = (gltf_bytes){data, size, NULL};
  if (!ylm_gltf_is_binary(data, size)) return;
  *json = (gltf_bytes){0};
  if (size < 20) {
    ylm__gltf_fail(g, YLM_EFORMAT, NULL,
                   "truncated: a .glb file has 20 bytes at least, this one %zu", size);
    return;
  }
  if (u32(data + 4) != 2) {
    ylm__gltf_fail(g, YLM_EVERSION, NULL, "version %u of the container, 2 is known", u32(data + 4));
    return;
  }
  size_t length = u32(data + 8);
  if (length > size) {
    ylm__gltf_fail(g, YLM_EFORMAT, NULL, "truncated: %zu bytes are said, %zu are there", length,
                   size);
    return;
  }
  for (size_t at = 12, chunk = 0; length >= 8 && at <= length - 8; chunk++) {
    size_t n = u32(data + at);
    uint32_t type = u32(data + at + 4);
    if (n > length - at - 8) {
      ylm__gltf_fail(g, YLM_EFORMAT, NULL, "chunk %zu has %zu bytes, %zu are said", chunk,
                     length - at - 8, n);
      return;
    }
    gltf_bytes b = {data + at + 8, n, NULL};
    if (chunk == 0 && type == JSON_CHUNK) *json = b;
    if (chunk == 1 && type == BIN_CHUNK) g->binary = b;
    at += 8 + n + (4 - n % 4) % 4;
  }
  if (!json->data) ylm__gltf_fail(g, YLM_EFORMAT, NULL, "the first chunk is not JSON");
}

/* -- URIs ------------------------------------------------------------------------------ */

static int digit64(unsigned char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' || c == '-' ? 62 : c == '/' || c == '_' ? 63 : -1;
}

/* Strict: groups of four, padded. */
static void decode64(gltf *g, const place *at, const char *s, gltf_bytes *b) {
  size_t n = strlen(s), pad = 0;
  while (pad < 2 && n > pad && s[n - 1 - pad] == '=') pad++;
  if (n % 4 != 0) {
    ylm__gltf_fail(g, YLM_EFORMAT, at, "base64 of %zu characters, no multiple of 4", n);
    return;
  }
  unsigned char *out = ylm__gltf_alloc(g, n / 4 * 3, 1);
  b->own = out;
  for (size_t i = 0; out && i < n; i += 4) {
    uint32_t word = 0;
    for (size_t k = 0; k < 4; k++) {
      int d = i + k >= n - pad ? 0 : digit64((unsigned char)s[i + k]);
      if (d < 0) {
        ylm__gltf_fail(g, YLM_EFORMAT, at, "character %zu is not base64", i + k + 1);
        return;
      }
      word = word << 6 | (uint32_t)d;
    }
    for (size_t k = 0; k < 3; k++) out[i / 4 * 3 + k] = (unsigned char)(word >> (16 - 8 * k));
  }
  b->data = out;
  b->size = n / 4 * 3 - pad;
}

static int digit16(char c) {
  return c >= '0' && c <= '9'   ? c - '0'
         : c >= 'a' && c <= 'f' ? c - 'a' + 10
         : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                : -1;
}

/* Decodes percent signs once; false where one is wrong, or a character 0 comes out. */
static bool decode_percent(const char *s, char *out) {
  for (; *s; s++) {
    if (*s == '%') {
      int hi = digit16(s[1]), lo = hi < 0 ? -1 : digit16(s[2]);
      if (lo < 0 || (hi == 0 && lo == 0)) return false;
      *out++ = (char)(16 * hi + lo);
      s += 2;
    } else {
      *out++ = *s;
    }
  }
  *out = 0;
  return true;
}

/* Relative, without a scheme, without empty parts and "..". */
static bool stays_below(const char *path) {
  if (*path == 0 || *path == '/' || strpbrk(path, ":\\")) return false;
  for (const char *part = path; part; part = strchr(part, '/')) {
    if (*part == '/') part++;
    size_t n = strcspn(part, "/");
    if (n == 0 || (n == 2 && part[0] == '.' && part[1] == '.')) return false;
  }
  return true;
}

void ylm__gltf_fetch(gltf *g, const place *at, const char *uri, gltf_bytes *b) {
  *b = (gltf_bytes){0};
  if (strncmp(uri, "data:", 5) == 0) {
    const char *comma = strchr(uri, ',');
    if (!comma || comma - uri < 7 || memcmp(comma - 7, ";base64", 7) != 0)
      ylm__gltf_fail(g, YLM_EFORMAT, at, "of data URIs base64 alone is read");
    else
      decode64(g, at, comma + 1, b);
    return;
  }
  size_t n = strlen(uri);
  char *path = ylm__gltf_alloc(g, n + 1, 1);
  if (!path) return;
  if (n > 1000 || !decode_percent(uri, path) || !stays_below(path))
    ylm__gltf_fail(g, YLM_EFORMAT, at,
                   "a file in the folder of this one expected: relative, without '..'");
  else if (!g->o->open)
    ylm__gltf_fail(g, YLM_EFORMAT, at, "other files are not read here");
  else {
    ylm_error e = {0};
    ylm_status s = g->o->open(g->o->user, path, &b->own, &b->size, &e);
    b->data = b->own;
    if (s != YLM_OK) ylm__gltf_fail(g, s, at, "%.200s", e.text);
  }
  ylm_free(path);
}

/* -- files ---------------------------------------------------------------------------- */

typedef struct folder {
  char path[PATH_MAX];
  size_t limit;
} folder;

/* ylm_gltf_open for a folder: symbolic links followed, the file lies in it. */
static ylm_status open_in(void *user, const char *path, unsigned char **data, size_t *size,
                          ylm_error *e) {
  const folder *f = user;
  char name[2 * PATH_MAX], real[PATH_MAX];
  snprintf(name, sizeof name, "%s/%s", f->path, path);
  if (!realpath(name, real)) return ylm_fail(e, YLM_EIO, "%s: no such file", path);
  size_t n = strlen(f->path);
  if (n == 1) n = 0; /* the folder is "/" */
  if (strncmp(f->path, real, n) != 0 || real[n] != '/')
    return ylm_fail(e, YLM_EIO, "%s: a link that leads out of the folder", path);
  return ylm_file_read(real, f->limit, data, size, e);
}

ylm_status ylm_gltf_read(const char *path, size_t limit, const ylm_gltf_options *o, ylm_gltf **out,
                         ylm_error *e) {
  *out = NULL;
  unsigned char *data;
  size_t size;
  ylm_status s = ylm_file_read(path, limit, &data, &size, e);
  if (s != YLM_OK) return s;
  folder f = {.limit = limit};
  ylm_gltf_options mine = o ? *o : (ylm_gltf_options){0};
  const char *slash = strrchr(path, '/');
  char *name = ylm_alloc_copy(path, strlen(path) + 1, 1);
  if (name && slash) name[slash == path ? 1 : slash - path] = 0;
  if (!name) {
    s = ylm_no_memory_for(e, path);
  } else if (!realpath(slash ? name : ".", f.path)) {
    s = ylm_fail(e, YLM_EIO, "%s: its folder is gone", path);
  } else {
    if (!mine.open) {
      mine.open = open_in;
      mine.user = &f;
    }
    s = ylm_gltf_decode(data, size, path, &mine, out, e);
  }
  ylm_free(name);
  ylm_free(data);
  return s;
}
