/* volume.c - lattices of numbers: filled from cells, smoothed, sampled, followed. */
#include "ylm_figure.h"

#include <math.h>
#include <string.h>

#include "ylm_grid.h"
#include "ylm_vector.h"

ylm_status ylm_figure_volume_init(ylm_figure_volume *v, const double b[6], const size_t size[3],
                                  int components) {
  memset(v, 0, sizeof *v);
  size_t shape[4] = {size[0], size[1], size[2], (size_t)components}, count;
  if (!size[0] || !size[1] || !size[2] || components < 1) return YLM_ERANGE;
  if (!ylm_shape_count(4, shape, &count)) return YLM_EOVERFLOW;
  for (int a = 0; a < 3; a++) {
    double extent = b[3 + a] - b[a];
    v->size[a] = size[a];
    v->spacing[a] = extent > 0 ? extent / (double)size[a] : 1;
    v->origin[a] = size[a] == 1 ? (b[a] + b[3 + a]) / 2 : b[a] + v->spacing[a] / 2;
  }
  v->components = components;
  v->value = ylm_alloc(count, sizeof(float));
  if (!v->value) return YLM_ENOMEM;
  for (size_t i = 0; i < count; i++) v->value[i] = NAN;
  return YLM_OK;
}

void ylm_figure_volume_clear(ylm_figure_volume *v) {
  ylm_free(v->value);
  memset(v, 0, sizeof *v);
}

/* Voxels first .. last-1 along an axis whose centres lie in [lo, hi). The last plane of voxels
   that a flat volume has may lie on the upper face of the last cell. */
static void span(const ylm_figure_volume *v, int axis, double lo, double hi, size_t *first,
                 size_t *last) {
  double a = ceil((lo - v->origin[axis]) / v->spacing[axis] - 1e-9);
  double b = ceil((hi - v->origin[axis]) / v->spacing[axis] - 1e-9);
  if (v->size[axis] == 1) {
    bool in = v->origin[axis] >= lo && v->origin[axis] <= hi;
    a = 0, b = in;
  }
  double n = (double)v->size[axis];
  *first = a > 0 ? (size_t)fmin(a, n) : 0;
  *last = b > 0 ? (size_t)fmin(b, n) : 0;
}

/* Everything about one cell while its voxels are filled. */
typedef struct cell {
  const double *origin, *size, *corner[8];
  double constant;
} cell;

/* The corners' values; false where one of them has none. */
static bool corners(const ylm_figure_cells *cells, size_t i, const double *value, size_t points,
                    int components, cell *c) {
  for (size_t k = 0; k < 8; k++) {
    double row = cells->corner[8 * i + k];
    if (!(row >= 1 && row <= (double)points)) return false;
    c->corner[k] = value + ((size_t)row - 1) * (size_t)components;
    for (int j = 0; j < components; j++)
      if (!isfinite(c->corner[k][j])) return false;
  }
  return true;
}

/* The trilinear weights of a cell's corners at p. */
static void weights(const cell *c, const double p[3], double w[8]) {
  double t[3];
  for (int a = 0; a < 3; a++) t[a] = fmin(1, fmax(0, (p[a] - c->origin[a]) / c->size[a]));
  for (int k = 0; k < 8; k++)
    w[k] = (k & 1 ? t[0] : 1 - t[0]) * (k & 2 ? t[1] : 1 - t[1]) * (k & 4 ? t[2] : 1 - t[2]);
}

static void fill_cell(ylm_figure_volume *v, const cell *c, bool pointwise) {
  size_t lo[3], hi[3];
  for (int a = 0; a < 3; a++) span(v, a, c->origin[a], c->origin[a] + c->size[a], &lo[a], &hi[a]);
  for (size_t z = lo[2]; z < hi[2]; z++)
    for (size_t y = lo[1]; y < hi[1]; y++)
      for (size_t x = lo[0]; x < hi[0]; x++) {
        size_t n = (size_t)v->components;
        float *out = v->value + ((z * v->size[1] + y) * v->size[0] + x) * n;
        if (!pointwise) {
          out[0] = (float)c->constant;
          continue;
        }
        double p[3] = {v->origin[0] + v->spacing[0] * (double)x,
                       v->origin[1] + v->spacing[1] * (double)y,
                       v->origin[2] + v->spacing[2] * (double)z},
               w[8];
        weights(c, p, w);
        for (size_t j = 0; j < n; j++) {
          double sum = 0;
          for (int k = 0; k < 8; k++) sum += w[k] * c->corner[k][j];
          out[j] = (float)sum;
        }
      }
}

ylm_status ylm_figure_fill(ylm_figure_volume *v, const ylm_figure_cells *cells, const double *value,
                           size_t points, bool pointwise) {
  if (pointwise ? !cells->corner : v->components != 1) return YLM_EINVAL;
  for (size_t i = 0; i < cells->n; i++) {
    if (cells->drawn && cells->drawn[i] == 0) continue;
    cell c = {.origin = cells->origin + 3 * i, .size = cells->size + 3 * i};
    if (!pointwise)
      c.constant = value[i];
    else if (!corners(cells, i, value, points, v->components, &c))
      continue;
    fill_cell(v, &c, pointwise);
  }
  return YLM_OK;
}

/* A voxel at p of a leaf with sides: the number of its piece's part, or what is there of the values. */
static void fill_piece(const ylm_grid *g, const ylm_grid_side *s, const cell *c,
                       const double *value, const double p[3], size_t n, float *out) {
  double w[8], place[3];
  for (int a = 0; a < 3; a++) place[a] = fmin(fmax((p[a] - c->origin[a]) / c->size[a], 0), 0.999);
  uint32_t part = ylm_grid_side_part_at(s, place);
  weights(c, p, w);
  for (size_t j = 0; j < n; j++) {
    double sum = value ? 0 : part + 1.0;
    for (int k = 0; value && part != YLM_GRID_PARTS && k < 8; k++)
      sum += w[k] * value[n * ylm_grid_look(g)->node[s->first + part][k] + j];
    out[j] = part == YLM_GRID_PARTS ? NAN : (float)sum;
  }
}

void ylm_figure_fill_parts(ylm_figure_volume *v, const ylm_grid *g, const double *value) {
  const ylm_grid_contents *look = ylm_grid_look(g);
  for (size_t i = 0; i < look->sides; i++) {
    const ylm_grid_side *s = &look->side[i];
    size_t lo[3], hi[3], n = (size_t)v->components;
    double box[6], size[3], p[3];
    ylm_grid_box(g, s->cell, box);
    for (int a = 0; a < 3; a++) {
      size[a] = box[a + 3] - box[a];
      span(v, a, box[a], box[a + 3], &lo[a], &hi[a]);
    }
    cell c = {.origin = box, .size = size};
    for (size_t z = lo[2]; z < hi[2]; z++)
      for (size_t y = lo[1]; y < hi[1]; y++)
        for (size_t x = lo[0]; x < hi[0]; x++) {
          size_t at[3] = {x, y, z};
          for (int a = 0; a < 3; a++) p[a] = v->origin[a] + v->spacing[a] * (double)at[a];
          fill_piece(g, s, &c, value, p, n, v->value + ((z * v->size[1] + y) * v->size[0] + x) * n);
        }
  }
}

bool ylm_figure_volume_at(const ylm_figure_volume *v, const double p[3], double *out) {
  size_t at[3];
  double t[3], sum[8] = {0};
  size_t n = (size_t)v->components;
  for (int a = 0; a < 3; a++) {
    double x = (p[a] - v->origin[a]) / v->spacing[a];
    if (!(x >= -0.5 && x <= (double)v->size[a] - 0.5)) return false;
    x = fmin(fmax(x, 0), (double)v->size[a] - 1);
    at[a] = (size_t)fmin(floor(x), v->size[a] > 1 ? (double)v->size[a] - 2 : 0);
    t[a] = x - (double)at[a];
  }
  for (size_t k = 0; k < 8; k++) {
    double w = 1;
    size_t i[3];
    for (int a = 0; a < 3; a++) {
      size_t bit = k >> a & 1;
      w *= bit ? t[a] : 1 - t[a];
      i[a] = at[a] + (at[a] + bit < v->size[a] ? bit : 0);
    }
    if (w == 0) continue;
    const float *x = v->value + ((i[2] * v->size[1] + i[1]) * v->size[0] + i[0]) * n;
    for (size_t j = 0; j < n && j < 8; j++) sum[j] += w * x[j];
  }
  for (size_t j = 0; j < n && j < 8; j++)
    if (isnan(sum[j])) return false;
  for (size_t j = 0; j < n && j < 8; j++) out[j] = sum[j];
  return true;
}

void ylm_figure_resample(ylm_figure_volume *to, const ylm_figure_volume *from) {
  size_t n = (size_t)to->components, i = 0;
  for (size_t z = 0; z < to->size[2]; z++)
    for (size_t y = 0; y < to->size[1]; y++)
      for (size_t x = 0; x < to->size[0]; x++, i++) {
        double p[3] = {to->origin[0] + to->spacing[0] * (double)x,
                       to->origin[1] + to->spacing[1] * (double)y,
                       to->origin[2] + to->spacing[2] * (double)z},
               out[8];
        bool there = n <= 8 && ylm_figure_volume_at(from, p, out);
        for (size_t j = 0; j < n; j++) to->value[i * n + j] = there ? (float)out[j] : NAN;
      }
}

bool ylm_figure_volume_range(const ylm_figure_volume *v, double *least, double *largest,
                             double *least_positive) {
  size_t count = v->size[0] * v->size[1] * v->size[2], n = (size_t)v->components;
  *least = INFINITY, *largest = -INFINITY, *least_positive = INFINITY;
  for (size_t i = 0; i < count; i++) {
    double x = v->value[i * n];
    if (!isfinite(x)) continue;
    *least = fmin(*least, x);
    *largest = fmax(*largest, x);
    if (x > 0) *least_positive = fmin(*least_positive, x);
  }
  return *least <= *largest;
}

/* One pass along an axis: weights 1, 2, 1 over the neighbours that have data. */
static void smooth_axis(const ylm_figure_volume *v, int axis, const float *from, float *to) {
  size_t n = (size_t)v->components, stride = n;
  for (int a = 0; a < axis; a++) stride *= v->size[a];
  size_t count = v->size[0] * v->size[1] * v->size[2] * n, length = v->size[axis];
  for (size_t i = 0; i < count; i++) {
    size_t k = i / stride % length;
    float sum = 2 * from[i], weight = 2;
    if (k > 0 && !isnan(from[i - stride])) sum += from[i - stride], weight++;
    if (k + 1 < length && !isnan(from[i + stride])) sum += from[i + stride], weight++;
    to[i] = sum / weight;
  }
}

ylm_status ylm_figure_volume_smooth(ylm_figure_volume *v, int times) {
  size_t count = v->size[0] * v->size[1] * v->size[2] * (size_t)v->components;
  float *other = ylm_alloc(count, sizeof *other);
  if (!other) return YLM_ENOMEM;
  for (int i = 0; i < times; i++)
    for (int axis = 0; axis < 3; axis++) {
      smooth_axis(v, axis, v->value, other);
      float *swap = v->value;
      v->value = other;
      other = swap;
    }
  ylm_free(other);
  return YLM_OK;
}

/* The unit direction at p, or false where there is none. */
static bool direction(const ylm_figure_volume *v, const double p[3], bool forward, double d[3]) {
  if (!ylm_figure_volume_at(v, p, d)) return false;
  if (!ylm_unit3(d)) return false;
  for (int a = 0; a < 3; a++) d[a] *= forward ? 1 : -1;
  return true;
}

size_t ylm_figure_streamline(const ylm_figure_volume *v, const double seed[3], double step,
                             bool forward, size_t room, double *out) {
  double p[3] = {seed[0], seed[1], seed[2]};
  size_t n = 0;
  if (v->components != 3) return 0;
  while (n < room) {
    double k[4][3], q[3], length = 0;
    if (!direction(v, p, forward, k[0])) break;
    memcpy(out + 3 * n++, p, sizeof p);
    static const double part[4] = {0, 0.5, 0.5, 1};
    for (int i = 1; i < 4; i++) {
      for (int a = 0; a < 3; a++) q[a] = p[a] + part[i] * step * k[i - 1][a];
      if (!direction(v, q, forward, k[i])) return n;
    }
    for (int a = 0; a < 3; a++) {
      double d = (k[0][a] + 2 * k[1][a] + 2 * k[2][a] + k[3][a]) / 6;
      p[a] += step * d;
      length += d * d;
    }
    if (length < 0.25) break; /* turning on the spot: an extremum */
  }
  return n;
}
