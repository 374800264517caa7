/*
** lattice.c - directions in cells: a cube whose faces are cut into n x n cells by tan(u pi/4), u from -1 to 1.
**
** Cells are within a factor of 1.4 of each other in size, and borders are parts of great circles. Face
** 2a is that of the positive axis a, 2a + 1 that of the negative one; u runs along axis a + 1, v along
** a + 2, in the direction of the axis: so neighbours across an edge of the cube count alike along it.
*/
#include "gather.h"

static int axis_of(int face) { return face / 2; }
static float sign_of(int face) { return face % 2 ? -1 : 1; }

/* Scales v to length 1. */
static void unit(float v[3]) {
  float scale = 1 / sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  for (int a = 0; a < 3; a++) v[a] *= scale;
}

void ylm__gather_direction(const gather_lattice *l, int face, size_t u, size_t v, float out[3]) {
  int a = axis_of(face);
  out[a] = sign_of(face);
  out[(a + 1) % 3] = l->tangent[u];
  out[(a + 2) % 3] = l->tangent[v];
  unit(out);
}

void ylm__gather_children_of(const gather_lattice *l, gather_place p, float (*out)[4]) {
  size_t half = (size_t)1 << 2 * (l->levels - p.level - 1); /* of a child's edge */
  const float *u = l->tangent + half * (8 * (size_t)p.i + 1),
              *v = l->tangent + half * (8 * (size_t)p.j + 1);
  float edge = (float)(YLM_PI / 2) * (float)half / (float)l->fine, inverse[16], angle[16], x[4],
        y[4];
  for (size_t k = 0; k < 4; k++) x[k] = u[2 * half * k], y[k] = v[2 * half * k];
  for (size_t j = 0; j < 4; j++)
    for (size_t k = 0; k < 4; k++) {
      float r = 1 / sqrtf(1 + x[k] * x[k] + y[j] * y[j]);
      inverse[4 * j + k] = r;
      angle[4 * j + k] = edge * edge * (1 + x[k] * x[k]) * (1 + y[j] * y[j]) * (r * r * r);
    }
  int a = axis_of(p.face), b = (a + 1) % 3, c = (a + 2) % 3;
  float sign = sign_of(p.face);
  for (size_t k = 0; k < 16; k++) {
    out[k][a] = sign * inverse[k];
    out[k][b] = x[k % 4] * inverse[k];
    out[k][c] = y[k / 4] * inverse[k];
    out[k][3] = angle[k];
  }
}

/* The solid angle of a cell exactly, by its corners. */
static float exact_angle(const gather_lattice *l, size_t i, size_t j) {
  size_t step = 2 * l->fine / (size_t)l->base;
  double sum = 0;
  for (size_t k = 0; k < 4; k++) {
    double x = (double)l->tangent[(i + k % 2) * step], y = (double)l->tangent[(j + k / 2) * step];
    sum += (k % 2 == k / 2 ? 1 : -1) * atan2(x * y, sqrt(1 + x * x + y * y));
  }
  return (float)sum;
}

/* Middle of length 1 of an arc between two directions of length 1; its length; half of the way between them. */
static float bisect(float end[2][3], float middle[3], float way[3]) {
  float chord2 = 0;
  for (int k = 0; k < 3; k++) {
    middle[k] = end[0][k] + end[1][k];
    way[k] = end[1][k] - end[0][k];
    chord2 += way[k] * way[k];
  }
  unit(middle);
  return sqrtf(chord2) * (1 + chord2 * (1.0f / 24 + chord2 * (3.0f / 640)));
}

/* The normal of a border's great circle, to `high`. */
static void turn_across(const gather_lattice *l, const gather_border *b, float out[3]) {
  int a = axis_of(b->face);
  float t = l->tangent[2 * (size_t)b->line], cosine = 1 / sqrtf(1 + t * t);
  out[a] = -t * cosine * sign_of(b->face);
  out[(a + 1 + b->across) % 3] = cosine;
  out[(a + 2 - b->across) % 3] = 0;
}

static void ends_of(const gather_lattice *l, const gather_border *b, float end[2][3]) {
  size_t line = 2 * (size_t)b->line, from = 2 * (size_t)b->from, to = from + 2 * (size_t)b->size;
  ylm__gather_direction(l, b->face, b->across ? from : line, b->across ? line : from, end[0]);
  ylm__gather_direction(l, b->face, b->across ? to : line, b->across ? line : to, end[1]);
}

static void make_line(const gather_lattice *l, const gather_border *b, gather_line *out) {
  float end[2][3], way[3];
  ends_of(l, b, end);
  out->length = bisect(end, out->at, way);
  turn_across(l, b, out->across);
}

void ylm__gather_gauss(const gather_lattice *l, const gather_border *b, float at[2][3]) {
  float end[2][3], middle[3], way[3];
  ends_of(l, b, end);
  float part = bisect(end, middle, way) * 0.28867513f, sine = part * (1 - part * part / 6);
  float chord = sqrtf(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
  for (int k = 0; k < 3; k++) {
    at[0][k] = middle[k] * (1 - part * part / 2) - way[k] * sine / chord;
    at[1][k] = middle[k] * (1 - part * part / 2) + way[k] * sine / chord;
  }
}

void ylm__gather_line(const gather_lattice *l, const gather_border *b, gather_line *out) {
  if (b->size != l->part) {
    make_line(l, b, out);
    return;
  }
  int a = axis_of(b->face), across = (a + 1 + b->across) % 3, along = (a + 2 - b->across) % 3;
  const float *piece = l->piece[b->line * (l->fine / l->part) + b->from / l->part];
  out->at[a] = piece[0] * sign_of(b->face);
  out->at[across] = piece[1];
  out->at[along] = piece[2];
  out->length = piece[3];
  out->across[a] = -l->turn[b->line][1] * sign_of(b->face);
  out->across[across] = l->turn[b->line][0];
  out->across[along] = 0;
}

static void fill_pieces(gather_lattice *l) {
  size_t n = l->fine / l->part;
  for (size_t line = 0; line <= l->fine; line++) {
    float t = l->tangent[2 * line], cosine = 1 / sqrtf(1 + t * t);
    l->turn[line][0] = cosine;
    l->turn[line][1] = t * cosine;
    for (size_t k = 0; k < n; k++) {
      float end[2][3], way[3], *piece = l->piece[line * n + k];
      ylm__gather_direction(l, 4, 2 * line, 2 * k * l->part, end[0]);
      ylm__gather_direction(l, 4, 2 * line, 2 * (k + 1) * l->part, end[1]);
      float middle[3];
      piece[3] = bisect(end, middle, way);
      piece[0] = middle[2]; /* face 4 is that of +z: across x, along y */
      piece[1] = middle[0];
      piece[2] = middle[1];
    }
  }
}

static uint32_t cell_at(const gather_lattice *l, int face, size_t i, size_t j) {
  size_t n = (size_t)l->base;
  return (uint32_t)(((size_t)face * n + j) * n + i);
}

/* The cell of a face at `x` along axis `b` and `y` along axis `c`. */
static uint32_t cell_along(const gather_lattice *l, int face, int b, size_t x, size_t y) {
  bool is_u = b == (axis_of(face) + 1) % 3;
  return cell_at(l, face, is_u ? x : y, is_u ? y : x);
}

static void add(gather_lattice *l, gather_border b) {
  b.size = (uint16_t)(l->fine / (size_t)l->base);
  make_line(l, &b, &l->line[l->borders]);
  l->border[l->borders++] = b;
}

/* Borders within a face. */
static void add_inner(gather_lattice *l, int face) {
  size_t n = (size_t)l->base, size = l->fine / n;
  for (uint8_t across = 0; across < 2; across++)
    for (size_t k = 1; k < n; k++)
      for (size_t q = 0; q < n; q++)
        add(l,
            (gather_border){.low = across ? cell_at(l, face, q, k - 1) : cell_at(l, face, k - 1, q),
                            .high = across ? cell_at(l, face, q, k) : cell_at(l, face, k, q),
                            .line = (uint16_t)(k * size),
                            .from = (uint16_t)(q * size),
                            .face = (uint8_t)face,
                            .across = across,
                            .side_low = across ? MOST_V : MOST_U,
                            .side_high = across ? LEAST_V : LEAST_U});
}

/* Which edge of a face's cells looks along axis b, with its sign. */
static uint8_t edge_of(int face, int b, bool positive) {
  bool is_u = b == (axis_of(face) + 1) % 3;
  return (uint8_t)(is_u ? (positive ? MOST_U : LEAST_U) : (positive ? MOST_V : LEAST_V));
}

/* Borders of a face with those of higher numbers. */
static void add_outer(gather_lattice *l, int face) {
  size_t n = (size_t)l->base, size = l->fine / n;
  int a = axis_of(face);
  for (int other = face + 1; other < 6; other++) {
    int b = axis_of(other);
    bool up = other % 2 == 0, is_high = face % 2 == 0;
    if (b == a) continue;
    uint8_t own = edge_of(face, b, up), its = edge_of(other, a, is_high);
    for (size_t q = 0; q < n; q++) {
      uint32_t here = cell_along(l, face, b, up ? n - 1 : 0, q);
      uint32_t there = cell_along(l, other, a, is_high ? n - 1 : 0, q);
      add(l, (gather_border){.low = up ? here : there,
                             .high = up ? there : here,
                             .line = (uint16_t)(up ? l->fine : 0),
                             .from = (uint16_t)(q * size),
                             .face = (uint8_t)face,
                             .across = b != (a + 1) % 3,
                             .side_low = up ? own : its,
                             .side_high = up ? its : own});
    }
  }
}

static void fill(gather_lattice *l) {
  size_t n = (size_t)l->base;
  for (size_t k = 0; k <= 2 * l->fine; k++)
    l->tangent[k] = (float)tan(((double)k / (double)l->fine - 1) * (YLM_PI / 4));
  for (int face = 0; face < 6; face++)
    for (size_t j = 0; j < n; j++)
      for (size_t i = 0; i < n; i++) {
        uint32_t c = cell_at(l, face, i, j);
        size_t half = l->fine / n;
        ylm__gather_direction(l, face, half * (2 * i + 1), half * (2 * j + 1), l->direction[c]);
        l->angle[c] = exact_angle(l, i, j);
      }
  for (int face = 0; face < 6; face++) add_inner(l, face), add_outer(l, face);
}

static bool make_pieces(gather_lattice *l) {
  l->part = l->levels == 2 ? 4 : 1;
  l->turn = ylm_alloc(l->fine + 1, sizeof *l->turn);
  l->piece = ylm_alloc((l->fine + 1) * (l->fine / l->part), sizeof *l->piece);
  if (!l->turn || !l->piece) return false;
  fill_pieces(l);
  return true;
}

ylm_status ylm__gather_lattice_create(int base, int levels, bool lines, gather_lattice *l) {
  size_t n = (size_t)base;
  *l =
      (gather_lattice){.base = base, .levels = levels, .cells = 6 * n * n, .fine = n << 2 * levels};
  l->tangent = ylm_alloc(2 * l->fine + 1, sizeof *l->tangent);
  l->direction = ylm_alloc(l->cells, sizeof *l->direction);
  l->angle = ylm_alloc(l->cells, sizeof *l->angle);
  l->border = ylm_alloc(2 * l->cells, sizeof *l->border);
  l->line = ylm_alloc(2 * l->cells, sizeof *l->line);
  if (!l->tangent || !l->direction || !l->angle || !l->border || !l->line) return YLM_ENOMEM;
  fill(l);
  return !lines || levels == 0 || make_pieces(l) ? YLM_OK : YLM_ENOMEM;
}

void ylm__gather_lattice_free(gather_lattice *l) {
  ylm_free(l->tangent);
  ylm_free(l->direction);
  ylm_free(l->angle);
  ylm_free(l->border);
  ylm_free(l->line);
  ylm_free(l->turn);
  ylm_free(l->piece);
}
