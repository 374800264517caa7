/*
** cuts.c - triangles cut into elements: into k^2 equal ones, or long ones into strips across their longest edge.
**
** The foot of the height on the longest edge parts a long triangle in two. Rows of a part run from its far corner F to the height,
** columns are lines through F. In coordinates that are affine on the part, r of a place is its distance from F along the longest edge,
** in parts of the whole, and y is its height above that edge in parts of the triangle's: a row is between r = j/rows and (j+1)/rows,
** a column between y/r = i/columns and (i+1)/columns. The row at F has a triangle of each column, other cells have two triangles.
*/
#include "cuts.h"

#include <math.h>

#include "calibration.h"

/* -- how many ---------------------------------------------------------------------- */

transfer_shape ylm__cut_shape(double p[3][3]) {
  double edge[3], dot[3] = {0, 0, 0};
  int apex = 0;
  for (int c = 0; c < 3; c++) { /* opposite to corner c */
    const double *from = p[(c + 1) % 3], *to = p[(c + 2) % 3];
    edge[c] = 0;
    for (int k = 0; k < 3; k++) {
      edge[c] += (to[k] - from[k]) * (to[k] - from[k]);
      dot[c] += (to[k] - from[k]) * (p[c][k] - from[k]);
    }
    if (edge[c] > edge[apex]) apex = c;
  }
  const double *from = p[(apex + 1) % 3];
  double foot = edge[apex] > 0 ? dot[apex] / edge[apex] : 0, square = 0;
  for (int k = 0; k < 3; k++) {
    double along = foot * (p[(apex + 2) % 3][k] - from[k]);
    square += (p[apex][k] - from[k] - along) * (p[apex][k] - from[k] - along);
  }
  double longest = sqrt(edge[apex]), height = sqrt(square), across = height;
  double before = sqrt(edge[(apex + 2) % 3]), behind = sqrt(edge[(apex + 1) % 3]);
  bool flat = !(longest * height / 2 > 1e-12 * longest * longest);
  if (!(foot * longest > CUT_FOOT * height)) /* a part that is steep is no part: rows lean */
    foot = 0, across = before, behind = longest, before = 0;
  else if (!((1 - foot) * longest > CUT_FOOT * height))
    foot = 1, across = behind, before = longest, behind = 0;
  return (transfer_shape){.edge = flat ? -1 : (float)longest,
                          .height = (float)across,
                          .foot = (float)foot,
                          .along = {(float)before, (float)behind},
                          .apex = (uint8_t)apex};
}

void ylm__cut_scale(transfer_shape *s, float by) {
  s->edge *= by, s->height *= by;
  for (int h = 0; h < 2; h++) s->along[h] *= by;
}

double ylm__cut_pieces(const transfer_shape *s, double spacing) {
  return s->edge < 0 ? 0 : fmax(1, ceil((double)s->edge / spacing));
}

/* Columns of cells that are no higher than the spacing over the root of 2. */
static double find_columns(const transfer_shape *s, double spacing) {
  return fmax(1, ceil((double)s->height / (spacing * sqrt(0.5))));
}

/* Rows of both parts, rows [2]: cells that do not lean have no edge beyond the spacing. */
static void find_rows(const transfer_shape *s, double spacing, double columns, double rows[2]) {
  double up = (double)s->height / columns;
  double along = sqrt(fmax(spacing * spacing - up * up, spacing * spacing / 2));
  for (int h = 0; h < 2; h++)
    rows[h] = s->along[h] > 0 ? fmax(1, ceil((double)s->along[h] / along)) : 0;
}

static double count_strips(double columns, const double rows[2]) {
  return columns * (fmax(0, 2 * rows[0] - 1) + fmax(0, 2 * rows[1] - 1));
}

/* Whether strips have far fewer elements than k^2, and numbers that fit; how many. */
static bool is_long(const transfer_shape *s, double spacing, double *columns, double rows[2],
                    double *number) {
  double k = ylm__cut_pieces(s, spacing);
  *number = k * k;
  if (k < 2) return false;
  *columns = find_columns(s, spacing);
  find_rows(s, spacing, *columns, rows);
  double strips = count_strips(*columns, rows);
  if (!(strips < CUT_STRIPS * k * k) || fmax(*columns, fmax(rows[0], rows[1])) > UINT16_MAX)
    return false;
  *number = strips;
  return true;
}

double ylm__cut_number(const transfer_shape *s, double spacing) {
  double columns, rows[2], number;
  is_long(s, spacing, &columns, rows, &number);
  return number;
}

transfer_cut ylm__cut_of(const transfer_shape *s, double spacing) {
  double columns, rows[2], number;
  if (is_long(s, spacing, &columns, rows, &number))
    return (transfer_cut){s->apex, (uint16_t)columns, {(uint16_t)rows[0], (uint16_t)rows[1]}};
  return (transfer_cut){(uint16_t)ylm__cut_pieces(s, spacing), 0, {0, 0}};
}

bool ylm__cut_can_be(const transfer_shape *s, double spacing, const transfer_cut *c) {
  double k = ylm__cut_pieces(s, spacing), rows[2];
  if (!c->columns)
    return c->rows[0] + c->rows[1] == 0 && (c->k == 0) == (k == 0) && fabs(c->k - k) <= 1;
  if (k < 2 || c->k != s->apex || fabs(c->columns - find_columns(s, spacing)) > 1) return false;
  find_rows(s, spacing, c->columns, rows);
  for (int h = 0; h < 2; h++)
    if ((c->rows[h] == 0) != (rows[h] == 0) || fabs(c->rows[h] - rows[h]) > 1) return false;
  return true;
}

/* -- strips ------------------------------------------------------------------------ */

/* The elements of one part. */
static size_t part_size(size_t columns, size_t rows) {
  return rows > 0 ? columns * (2 * rows - 1) : 0;
}

/* Coordinates of the corners of element x of a part. */
static void strip_corners(size_t columns, size_t rows, size_t x, double r[3], double y[3]) {
  size_t row = x < columns ? 0 : 1 + (x - columns) / (2 * columns);
  size_t rest = row == 0 ? 2 * x : (x - columns) % (2 * columns), i = rest / 2, upper = rest % 2;
  double low = (double)row / (double)rows, high = (double)(row + 1) / (double)rows;
  double below = (double)i / (double)columns, above = (double)(i + 1) / (double)columns;
  r[0] = low, y[0] = low * below;
  r[1] = high, y[1] = high * (upper ? above : below);
  r[2] = upper ? low : high, y[2] = r[2] * above;
}

/* The element of a part that has a place. */
static size_t strip_at(size_t columns, size_t rows, double r, double y) {
  size_t row = r > 0 ? (size_t)(r * (double)rows) : 0;
  if (row > rows - 1) row = rows - 1;
  double x = r > 0 ? y / r * (double)columns : 0;
  size_t i = x > 0 ? (size_t)fmin(x, (double)columns) : 0;
  if (i > columns - 1) i = columns - 1;
  if (row == 0) return i;
  double low = (double)row / (double)rows, high = (double)(row + 1) / (double)rows;
  double from = low * (double)i / (double)columns, to = high * (double)(i + 1) / (double)columns;
  bool upper = y > from + (r - low) / (high - low) * (to - from);
  return columns + 2 * columns * (row - 1) + 2 * i + upper;
}

/* The weights (u, v) of a place of part h. */
static void leave(const transfer_cut *c, float foot, int h, double r, double y, float out[2]) {
  double along = h == 0 ? r * (double)foot : 1 - r * (1 - (double)foot), w[3];
  w[c->k] = y;
  w[(c->k + 2) % 3] = along - y * (double)foot;
  w[(c->k + 1) % 3] = 1 - y - w[(c->k + 2) % 3];
  out[0] = (float)w[1], out[1] = (float)w[2];
}

/* The part that has a place, and the place there. */
static int enter(const transfer_cut *c, float foot, float u, float v, double *r, double *y) {
  double w[3] = {1 - (double)u - (double)v, (double)u, (double)v};
  *y = w[c->k];
  double along = w[(c->k + 2) % 3] + *y * (double)foot;
  int h = along < (double)foot || foot == 1 ? 0 : 1;
  *r = h == 0 ? along / (double)foot : (1 - along) / (1 - (double)foot);
  return h;
}

/* -- either ------------------------------------------------------------------------ */

size_t ylm__cut_size(const transfer_cut *c) {
  if (!c->columns) return (size_t)c->k * c->k;
  return part_size(c->columns, c->rows[0]) + part_size(c->columns, c->rows[1]);
}

void ylm__cut_corners(const transfer_cut *c, float foot, size_t x, float corner[3][2]) {
  if (c->columns) {
    double r[3], y[3];
    size_t first = part_size(c->columns, c->rows[0]);
    int h = x < first ? 0 : 1;
    strip_corners(c->columns, c->rows[h], h ? x - first : x, r, y);
    for (int k = 0; k < 3; k++) leave(c, foot, h, r[k], y[k], corner[k]);
    if (ylm__cut_share(corner) >= 0) return;
    float swap[2] = {corner[1][0], corner[1][1]}; /* so that they turn as the triangle's do */
    memcpy(corner[1], corner[2], sizeof swap);
    memcpy(corner[2], swap, sizeof swap);
    return;
  }
  size_t k = c->k, i = (size_t)((double)k - sqrt((double)(k * k - x)));
  while (i > 0 && i * (2 * k - i) > x) i--;
  while ((i + 1) * (2 * k - (i + 1)) <= x) i++;
  size_t rest = x - i * (2 * k - i), j = rest / 2, upper = rest % 2;
  const size_t at[3][2] = {
      {i + upper, j + upper}, {i + 1 - upper, j + upper}, {i + upper, j + 1 - upper}};
  for (int n = 0; n < 3; n++)
    for (int a = 0; a < 2; a++) corner[n][a] = (float)((double)at[n][a] / (double)k);
}

size_t ylm__cut_at(const transfer_cut *c, float foot, float u, float v) {
  if (c->columns) {
    double r, y;
    int h = enter(c, foot, u, v, &r, &y);
    return (h ? part_size(c->columns, c->rows[0]) : 0) + strip_at(c->columns, c->rows[h], r, y);
  }
  uint32_t k = c->k;
  u *= (float)k, v *= (float)k;
  uint32_t i = u > 0 ? (uint32_t)u : 0, j = v > 0 ? (uint32_t)v : 0;
  if (i > k - 1) i = k - 1;
  if (j > k - 1 - i) j = k - 1 - i;
  uint32_t upper = i + j < k - 1 && (u - (float)i) + (v - (float)j) > 1;
  return (size_t)i * (2 * k - i) + 2 * j + upper;
}

transfer_cut ylm__cut_coarse(const transfer_cut *c) {
  if (!c->columns) return (transfer_cut){(uint16_t)((c->k + 1) / 2), 0, {0, 0}};
  return (transfer_cut){c->k,
                        (uint16_t)((c->columns + 1) / 2),
                        {(uint16_t)((c->rows[0] + 1) / 2), (uint16_t)((c->rows[1] + 1) / 2)}};
}
