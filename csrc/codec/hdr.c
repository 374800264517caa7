/* hdr.c - Radiance .hdr: RGBE with run lengths (Ward 1991, Real Pixels; both old and new runs). */
#include "codec.h"

#include <math.h>
#include <string.h>

/* -- reading -------------------------------------------------------------------------- */

typedef struct parser {
  const unsigned char *bytes;
  size_t size, at;
} parser;

/* The next line without its end; false at the end of the file or beyond 4096 bytes. */
static bool next_line(parser *s, char *line, size_t room) {
  size_t n = 0;
  while (s->at < s->size && s->bytes[s->at] != '\n') {
    if (n + 1 >= room) return false;
    line[n++] = (char)s->bytes[s->at++];
  }
  if (s->at == s->size) return false;
  s->at++;
  if (n && line[n - 1] == '\r') n--;
  line[n] = 0;
  return true;
}

/* "-Y 480 +X 640" and its seven relatives: height, width, and how the rows lie. */
typedef struct layout {
  uint64_t rows, columns;
  bool transposed, flip_rows, flip_columns; /* rows run along X; from the bottom; from the right */
} layout;

static bool read_axis(const char **p, char *axis, bool *negative, uint64_t *n) {
  while (**p == ' ') ++*p;
  if (**p != '-' && **p != '+') return false;
  *negative = *(*p)++ == '-';
  *axis = *(*p)++;
  if (*axis != 'X' && *axis != 'Y') return false;
  while (**p == ' ') ++*p;
  if (**p < '0' || **p > '9') return false;
  for (*n = 0; **p >= '0' && **p <= '9'; ++*p)
    if (*n < 1u << 20) *n = 10 * *n + (uint64_t)(**p - '0');
  return true;
}

static bool read_layout(const char *line, layout *l) {
  char first, second;
  bool down, left;
  if (!read_axis(&line, &first, &down, &l->rows) || !read_axis(&line, &second, &left, &l->columns))
    return false;
  while (*line == ' ') line++;
  if (*line || first == second) return false;
  l->transposed = first == 'X';
  /* rows: -Y is from the top down, +X from the left; columns alike */
  l->flip_rows = l->transposed ? down : !down;
  l->flip_columns = l->transposed ? !left : left;
  return true;
}

/* One row of RGBE in planes-with-runs (new) form. */
static bool read_new_row(parser *s, unsigned char *row, size_t n) {
  for (int k = 0; k < 4; k++)
    for (size_t i = 0; i < n;) {
      if (s->size - s->at < 2) return false;
      size_t count = s->bytes[s->at++];
      if (count > 128) {
        count -= 128;
        if (count > n - i) return false;
        unsigned char value = s->bytes[s->at++];
        for (; count > 0; count--) row[4 * i++ + (size_t)k] = value;
      } else {
        if (count == 0 || count > n - i || count > s->size - s->at) return false;
        for (; count > 0; count--) row[4 * i++ + (size_t)k] = s->bytes[s->at++];
      }
    }
  return true;
}

/* One row of pixels, 1 1 1 n repeating the one before (old form). */
static bool read_old_row(parser *s, unsigned char *row, size_t n) {
  int shift = 0;
  for (size_t i = 0; i < n;) {
    if (s->size - s->at < 4) return false;
    const unsigned char *p = s->bytes + s->at;
    s->at += 4;
    if (p[0] == 1 && p[1] == 1 && p[2] == 1) {
      size_t count = shift < 24 ? (size_t)p[3] << shift : n + 1;
      if (i == 0 || count > n - i) return false;
      for (; count > 0; count--, i++) memcpy(row + 4 * i, row + 4 * (i - 1), 4);
      shift += 8;
    } else {
      memcpy(row + 4 * i++, p, 4);
      shift = 0;
    }
  }
  return true;
}

static bool read_row(parser *s, unsigned char *row, size_t n) {
  const unsigned char *p = s->bytes + s->at;
  bool is_new = n >= 8 && n < 32768 && s->size - s->at >= 4 && p[0] == 2 && p[1] == 2 && p[2] < 128;
  if (!is_new) return read_old_row(s, row, n);
  if (((size_t)p[2] << 8 | p[3]) != n) return false;
  s->at += 4;
  return read_new_row(s, row, n);
}

/* Mantissas in the middle of their steps, as Radiance does. */
static void decode(const unsigned char *p, float *rgb) {
  float f = p[3] ? ldexpf(1.0f, (int)p[3] - (128 + 8)) : 0;
  for (int k = 0; k < 3; k++) rgb[k] = p[3] ? ((float)p[k] + 0.5f) * f : 0;
}

static ylm_status read_header(parser *s, const char *name, layout *l, ylm_error *e) {
  char line[4096];
  bool format = false;
  next_line(s, line, sizeof line); /* "#?..." */
  for (;;) {
    if (!next_line(s, line, sizeof line))
      return ylm_fail(e, YLM_EFORMAT, "%s: the Radiance header has no end", name);
    if (line[0] == 0) break;
    if (strcmp(line, "FORMAT=32-bit_rle_rgbe") == 0)
      format = true;
    else if (strncmp(line, "FORMAT=", 7) == 0)
      return ylm_fail(e, YLM_EFORMAT, "%s: Radiance format '%.40s' is not supported", name,
                      line + 7);
  }
  (void)format; /* old files leave it out */
  if (!next_line(s, line, sizeof line) || !read_layout(line, l))
    return ylm_fail(e, YLM_EFORMAT, "%s: no resolution like '-Y 480 +X 640'", name);
  return YLM_OK;
}

ylm_status ylm__hdr_parse(const unsigned char *bytes, size_t size, const char *name,
                          const ylm_codec_input *input, ylm_image **image, ylm_error *e) {
  parser s = {bytes, size, 0};
  layout l;
  *image = NULL;
  ylm_status st = read_header(&s, name, &l, e);
  if (st != YLM_OK) return st;
  uint64_t w = l.transposed ? l.rows : l.columns, h = l.transposed ? l.columns : l.rows;
  /* a run of 127 equal bytes takes two: 4*columns bytes take at least columns/16 */
  st = ylm__codec_start(name, input, w, h, 3, size, (size_t)(l.rows * (l.columns / 32)), image, e);
  if (st != YLM_OK) return st;
  unsigned char *row = ylm_alloc((size_t)l.columns, 4);
  if (!row) st = ylm_no_memory_for(e, name);
  for (size_t j = 0; st == YLM_OK && j < l.rows; j++) {
    if (!read_row(&s, row, (size_t)l.columns)) {
      st = ylm_fail(e, YLM_EFORMAT, "%s: damaged or truncated in row %zu of %llu", name, j + 1,
                    (unsigned long long)l.rows);
      break;
    }
    size_t jj = l.flip_rows ? (size_t)l.rows - 1 - j : j;
    for (size_t i = 0; i < l.columns; i++) {
      size_t ii = l.flip_columns ? (size_t)l.columns - 1 - i : i;
      size_t x = l.transposed ? jj : ii, y = l.transposed ? ii : jj;
      decode(row + 4 * i, (*image)->layer[0].data + 3 * (y * (size_t)w + x));
    }
  }
  ylm_free(row);
  if (st != YLM_OK) {
    ylm_image_free(*image);
    *image = NULL;
  }
  return st;
}

/* -- writing ------------------------------------------------------------------------------ */

static void encode(const float *rgb, unsigned char *p) {
  float r = rgb[0] > 0 ? rgb[0] : 0, g = rgb[1] > 0 ? rgb[1] : 0, b = rgb[2] > 0 ? rgb[2] : 0;
  float most = fmaxf(r, fmaxf(g, b));
  int exponent;
  memset(p, 0, 4);
  if (most < 1e-38f) return;
  float scale = frexpf(most, &exponent) * 256.0f / most;
  if (exponent > 127) exponent = 127, scale = ldexpf(1.0f, 8 - 127);
  if (exponent < -127) return;
  p[0] = (unsigned char)fminf(r * scale, 255.0f);
  p[1] = (unsigned char)fminf(g * scale, 255.0f);
  p[2] = (unsigned char)fminf(b * scale, 255.0f);
  p[3] = (unsigned char)(exponent + 128);
}

/* One plane of a row in runs; returns the bytes written, at most n + n/64 + 2. */
static size_t write_runs(const unsigned char *row, size_t n, int k, unsigned char *out) {
  size_t used = 0;
  for (size_t i = 0; i < n;) {
    size_t run = 1;
    while (run < 127 && i + run < n && row[4 * (i + run) + (size_t)k] == row[4 * i + (size_t)k])
      run++;
    if (run >= 4) {
      out[used++] = (unsigned char)(128 + run);
      out[used++] = row[4 * i + (size_t)k];
      i += run;
      continue;
    }
    size_t start = i, same = 1;
    for (i++; i < n && i - start < 128; i++) { /* up to where four equal bytes begin */
      same = row[4 * i + (size_t)k] == row[4 * (i - 1) + (size_t)k] ? same + 1 : 1;
      if (same == 4) {
        i -= 3;
        break;
      }
    }
    out[used++] = (unsigned char)(i - start);
    for (size_t j = start; j < i; j++) out[used++] = row[4 * j + (size_t)k];
  }
  return used;
}

static void write_row(ylm_file *f, const unsigned char *row, size_t n, unsigned char *out) {
  if (n < 8 || n >= 32768) {
    ylm_file_write(f, row, 4 * n);
    return;
  }
  unsigned char head[4] = {2, 2, (unsigned char)(n >> 8), (unsigned char)n};
  ylm_file_write(f, head, 4);
  for (int k = 0; k < 4; k++) ylm_file_write(f, out, write_runs(row, n, k, out));
}

ylm_status ylm__hdr_write(const ylm_image *image, const ylm_layer *layer, const char *path,
                          const ylm_codec_options *o, ylm_error *e) {
  (void)o;
  size_t n = (size_t)image->width, where;
  if (layer->channels != 1 && layer->channels != 3)
    return ylm_fail(e, YLM_ESHAPE, "%s: Radiance files hold 3 channels, layer '%s' has %d", path,
                    layer->name, layer->channels);
  if (!ylm_all_finite(YLM_FLOAT, layer->data, n * (size_t)image->height * (size_t)layer->channels,
                      &where)) {
    where /= (size_t)layer->channels;
    return ylm_fail(e, YLM_EDOMAIN,
                    "%s: pixel (%zu, %zu) is not finite, which the format cannot say", path,
                    where % n + 1, where / n + 1);
  }
  unsigned char *row = ylm_alloc(n, 4), *out = ylm_alloc(2 * n + 8, 1);
  ylm_file *f = NULL;
  ylm_status s = row && out ? ylm_file_create(path, &f, e) : ylm_no_memory_for(e, path);
  if (s == YLM_OK) {
    char head[128];
    int length = snprintf(head, sizeof head,
                          "#?RADIANCE\nSOFTWARE=ylm " YLM_VERSION
                          "\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n",
                          image->height, image->width);
    ylm_file_write(f, head, (size_t)length);
    for (int y = 0; y < image->height; y++) {
      for (size_t i = 0; i < n; i++) {
        const float *p = layer->data + ((size_t)y * n + i) * (size_t)layer->channels;
        float grey[3] = {p[0], p[0], p[0]};
        encode(layer->channels == 3 ? p : grey, row + 4 * i);
      }
      write_row(f, row, n, out);
    }
    s = ylm_file_commit(f, e);
  }
  ylm_free(row);
  ylm_free(out);
  return s;
}
