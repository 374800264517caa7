/* page.c - grids and meshes as the bytes of a page. */
#include <math.h>
#include <string.h>

#include "ylm_figure.h"
#include "ylm_grid.h"
#include "ylm_numbers.h"

#define HALF_MOST 65504.0f

/* A number as a half; beyond its range the largest. */
static uint16_t half_of(float x) {
  uint16_t h = 0;
  if (x > HALF_MOST) x = HALF_MOST;
  ylm_numbers_convert(YLM_FLOAT, YLM_FLOAT16, 1, &x, &h, NULL);
  return h;
}

/* A cell as a shader walks it: `first` is its child, or its record; `corner` those of the cell or of a part. */
static void put_cell(const ylm_grid_cell *c, uint32_t first, const uint32_t corner[8],
                     uint32_t words[YLM_FIGURE_PAGE_WORDS]) {
  bool whole = true;
  for (int k = 0; k < 8; k++) {
    words[4 + k] = corner[k];
    whole &= corner[k] != YLM_GRID_NONE;
  }
  words[0] = first;
  words[1] = c->level | (whole ? 1u << 8 : 0) | (uint32_t)c->flags << 16;
  words[2] = c->origin[0] | c->origin[1] << 16;
  words[3] = c->origin[2] | (uint32_t)half_of(c->error) << 16;
}

void ylm_figure_page_cells(const ylm_grid *g, uint32_t *cell) {
  const ylm_grid_contents *v = ylm_grid_look(g);
  uint32_t(*words)[YLM_FIGURE_PAGE_WORDS] = (uint32_t(*)[YLM_FIGURE_PAGE_WORDS])cell;
  for (size_t i = 0; i < v->cells; i++)
    put_cell(&v->cell[i], v->cell[i].child, v->cell[i].corner, words[i]);
  for (size_t i = 0; i < v->sides; i++) {
    const ylm_grid_side *s = &v->side[i];
    words[s->cell][0] = (uint32_t)(i * YLM_FIGURE_PAGE_SIDE);
    for (uint32_t p = s->first; p < s->first + s->parts; p++)
      put_cell(&v->cell[s->cell], 0, v->node[p], words[v->cells + p]);
  }
}

/* The error of cell `was` to cell i, and from its children to the other's. */
static void take_errors(const ylm_grid_contents *v, uint32_t i, const ylm_grid_contents *from,
                        uint32_t was, uint32_t *cell) {
  uint32_t *word = &cell[(size_t)i * YLM_FIGURE_PAGE_WORDS + 3];
  *word = (*word & 0xffff) | (uint32_t)half_of(from->cell[was].error) << 16;
  if (v->cell[i].flags & YLM_GRID_LEAF || from->cell[was].flags & YLM_GRID_LEAF) return;
  for (uint32_t k = 0; k < 8; k++)
    take_errors(v, v->cell[i].child + k, from, from->cell[was].child + k, cell);
}

void ylm_figure_page_errors(const ylm_grid *g, const ylm_grid *from, uint32_t *cell) {
  const ylm_grid_contents *v = ylm_grid_look(g), *w = ylm_grid_look(from);
  bool lattice = v->form.kind == YLM_GRID_UNIFORM;
  size_t tops = lattice ? v->octree_cells : 1;
  for (size_t i = 0; i < tops && i < w->octree_cells; i++)
    take_errors(v, (uint32_t)i, w, (uint32_t)i, cell);
}

void ylm_figure_page_rest(const ylm_grid *g, uint32_t *cell) {
  const ylm_grid_contents *v = ylm_grid_look(g);
  for (size_t i = 0; i < v->cells + v->parts; i++, cell += YLM_FIGURE_PAGE_WORDS) {
    if (i >= v->octree_cells && i < v->cells) continue; /* a cell that continuity adds */
    if (i < v->octree_cells &&
        (!(v->cell[i].flags & YLM_GRID_LEAF) || v->cell[i].flags & YLM_GRID_SIDED))
      cell[0] = 0;
    cell[1] = cell[2] = 0;
    cell[3] &= 0xffff0000u;
    memset(cell + 4, 0, 8 * sizeof *cell);
  }
}

void ylm_figure_page_sides(const ylm_grid *g, uint32_t *record) {
  const ylm_grid_contents *v = ylm_grid_look(g);
  for (size_t i = 0; i < v->sides; i++, record += YLM_FIGURE_PAGE_SIDE) {
    const ylm_grid_side *s = &v->side[i];
    record[0] = (uint32_t)v->cells + s->first;
    record[1] = s->parts;
    for (size_t k = 0; k < YLM_GRID_PIECES / 8; k++) {
      const uint8_t *four = s->part + 4 * k;
      record[2 + k] =
          four[0] | (uint32_t)four[1] << 8 | (uint32_t)four[2] << 16 | (uint32_t)four[3] << 24;
    }
  }
}

void ylm_figure_page_table(const ylm_grid *g, uint32_t *cell) {
  const ylm_grid_contents *v = ylm_grid_look(g);
  const uint32_t *n = v->resolution;
  const double *b = v->form.bounds;
  for (uint32_t z = 0; z < n[2]; z++)
    for (uint32_t y = 0; y < n[1]; y++)
      for (uint32_t x = 0; x < n[0]; x++) {
        double p[3], at[3] = {x + 0.5, y + 0.5, z + 0.5};
        for (int a = 0; a < 3; a++) p[a] = b[a] + (b[3 + a] - b[a]) * at[a] / n[a];
        *cell++ = ylm_grid_locate(g, p, true, NULL);
      }
}

ylm_status ylm_figure_page_exponent(const ylm_grid *g, int *exponent, ylm_error *e) {
  const ylm_grid_contents *v = ylm_grid_look(g);
  size_t width = (size_t)v->form.channels * (size_t)v->count;
  float most = 0;
  *exponent = 0;
  for (size_t r = 0; r < v->rows * v->evaluated; r++) {
    const float *row = v->data + r * v->stride;
    for (size_t i = 0; i < width; i++) {
      float x = fabsf(row[i]);
      if (!(x < INFINITY))
        return ylm_fail(e, YLM_EDOMAIN, "point %zu of the grid has a number that is not finite",
                        r / v->rows + 1);
      if (x > most) most = x;
    }
  }
  int power;
  frexpf(most, &power);
  if (most > 0) *exponent = 15 - power;
  return YLM_OK;
}

void ylm_figure_page_rows(const ylm_grid *g, int exponent, float *row) {
  const ylm_grid_contents *v = ylm_grid_look(g);
  size_t width = (size_t)v->form.channels * (size_t)v->count;
  for (size_t p = 0; p < v->evaluated; p++)
    for (size_t i = 0; i < width; i++)
      for (size_t r = 0; r < 4; r++)
        *row++ = r < v->rows ? ldexpf(v->data[(v->rows * p + r) * v->stride + i], exponent) : 0;
}

void ylm_figure_page_bytes(size_t n, size_t width, const float *row, float *value, float *scale,
                           int8_t *slope) {
  for (size_t p = 0; p < n; p++, row += 4 * width, scale += 3) {
    for (size_t a = 0; a < 3; a++) {
      float most = 0;
      for (size_t i = 0; i < width; i++) most = fmaxf(most, fabsf(row[4 * i + a + 1]));
      scale[a] = most / 127;
    }
    for (size_t i = 0; i < width; i++) {
      *value++ = row[4 * i];
      for (size_t a = 0; a < 3; a++)
        *slope++ = (int8_t)(scale[a] > 0 ? lrintf(row[4 * i + a + 1] / scale[a]) : 0);
    }
  }
}

void ylm_figure_page_positions(size_t n, const float *position, const double lo[3],
                               const double step[3], uint16_t *out) {
  for (size_t i = 0; i < 3 * n; i++) {
    double x = step[i % 3] > 0 ? ((double)position[i] - lo[i % 3]) / step[i % 3] : 0;
    out[i] = (uint16_t)(x < 0 ? 0 : x > 65535 ? 65535 : x + 0.5);
  }
}

void ylm_figure_page_normals(size_t n, const float *normal, int16_t *out) {
  for (size_t i = 0; i < n; i++, normal += 3) {
    double sum = 0, v[2];
    for (int a = 0; a < 3; a++) sum += fabs((double)normal[a]);
    for (int a = 0; a < 2; a++) v[a] = sum > 0 ? (double)normal[a] / sum : 0;
    if (normal[2] < 0) { /* the lower half is folded outwards */
      double x = v[0], y = v[1];
      v[0] = copysign(1 - fabs(y), x);
      v[1] = copysign(1 - fabs(x), y);
    }
    for (int a = 0; a < 2; a++) *out++ = (int16_t)lrint(32767 * v[a]);
  }
}

/* Number i of `in`, of 1, 2 or 4 bytes. */
static uint32_t number_at(const void *in, size_t bytes, size_t i) {
  uint16_t two;
  uint32_t four;
  switch (bytes) {
  case 1: return ((const uint8_t *)in)[i];
  case 2: memcpy(&two, (const char *)in + 2 * i, sizeof two); return two;
  default: memcpy(&four, (const char *)in + 4 * i, sizeof four); return four;
  }
}

void ylm_figure_planes(size_t n, size_t bytes, size_t columns, const void *in, unsigned char *out) {
  for (size_t i = 0; i < n; i++) {
    uint32_t x = number_at(in, bytes, i);
    if (columns && i >= columns) x -= number_at(in, bytes, i - columns);
    for (size_t b = 0; b < bytes; b++) out[b * n + i] = (unsigned char)(x >> 8 * b);
  }
}

void ylm_figure_base64(size_t n, const unsigned char *in, char *out) {
  static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (size_t i = 0; i < n; i += 3) {
    uint32_t x = (uint32_t)in[i] << 16 | (i + 1 < n ? (uint32_t)in[i + 1] << 8 : 0) |
                 (i + 2 < n ? in[i + 2] : 0);
    *out++ = digits[x >> 18];
    *out++ = digits[x >> 12 & 63];
    *out++ = i + 1 < n ? digits[x >> 6 & 63] : '=';
    *out++ = i + 2 < n ? digits[x & 63] : '=';
  }
}

bool ylm_figure_unbase64(size_t n, const char *in, unsigned char *out, size_t *size) {
  static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  uint32_t x = 0;
  size_t pad = n > 0 && in[n - 1] == '=' ? n > 1 && in[n - 2] == '=' ? 2 : 1 : 0;
  *size = 0;
  if (n % 4 != 0) return false;
  for (size_t i = 0; i < n; i++) {
    const char *d = in[i] ? strchr(digits, in[i]) : NULL;
    if (!d && i < n - pad) return false;
    x = x << 6 | (uint32_t)(d ? d - digits : 0);
    if (i % 4 != 3) continue;
    for (int k = 2; k >= 0; k--) out[(*size)++] = (unsigned char)(x >> 8 * k);
    x = 0;
  }
  *size -= pad;
  return true;
}
