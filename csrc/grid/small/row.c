/*
** row.c - predictions, steps and turns of points' rows: the arithmetic that encoder and reader share.
**
** The file is compiled without contraction of products and sums (Makefile), and has one form for all processors: a
** prediction that differed in its last bit would differ from level to level more.
*/
#include "small.h"

#include <math.h>
#include <string.h>

#include "ylm_sets.h"
#include "ylm_sh.h"

#define F float
#include "../gen/interpolation.h"

#define PLACES 27 /* of a cell's half-edge lattice */
#define OUT 4     /* a value and three slopes */

_Static_assert(SMALL_TERMS == SMALL_PARENTS * ROWS, "rows of all parents");

/* The terms of one output of a prediction: rows of corners, as ROWS counts them, and their weights. */
typedef struct small_terms {
  uint8_t n, row[ROWS];
  float weight[ROWS];
} small_terms;

struct small_weights {
  small_terms at[PLACES][OUT];
};

/* Red, green and blue of shared points: the mean, red against blue, green against both. */
static const float opponent[9] = {0.57735027f,  0.57735027f,  0.57735027f, 0.70710678f, 0,
                                  -0.70710678f, -0.40824829f, 0.81649658f, -0.40824829f};

static const uint32_t *place_of(const small_frame *f, size_t met) {
  return f->g->lattice + 3 * (size_t)f->k->place[met];
}

static bool is_shared(const small_frame *f, size_t met) {
  return small_is_shared(f->g, f->head.finest, place_of(f, met));
}

/* The turn of a point's colours; NULL: there is one channel. */
static const float *colours_of(const small_frame *f, size_t met) {
  if (!f->colour) return NULL;
  return is_shared(f, met) ? opponent : f->colour + f->k->before[met] / SMALL_BLOCK * 9;
}

/* -- weights ------------------------------------------------------------------------------------ */

static void keep_terms(small_terms *t, const float *w, int rows) {
  t->n = 0;
  for (int r = 0; r < rows; r++) {
    if (w[r] == 0) continue;
    t->row[t->n] = (uint8_t)r;
    t->weight[t->n++] = w[r];
  }
}

static void weights_of_place(const small_frame *f, const float edge[3], uint32_t place,
                             small_terms out[OUT]) {
  axis_functions v[3], d[3];
  float w[ROWS];
  bool slopes = f->rows > 1;
  ylm_grid_interpolation how = slopes ? YLM_GRID_HERMITE : YLM_GRID_LINEAR;
  for (int a = 0; a < 3; a++, place /= 3) {
    float t = 0.5f * (float)(place % 3);
    axis_values(&v[a], t, edge[a], how);
    axis_slopes(&d[a], t, edge[a], how);
  }
  weights(&v[0], &v[1], &v[2], w, 1);
  keep_terms(&out[0], w, slopes ? ROWS : 8);
  for (int a = 0; slopes && a < 3; a++) {
    weights(a == 0 ? &d[0] : &v[0], a == 1 ? &d[1] : &v[1], a == 2 ? &d[2] : &v[2], w, 1);
    keep_terms(&out[a + 1], w, ROWS);
  }
}

/* The level of cells of one edge of the lattice. */
static int depth_of(const ylm_grid *g) {
  return g->contents.form.kind == YLM_GRID_UNIFORM ? 0 : g->contents.form.depth;
}

static ylm_status make_weights(small_frame *f) {
  int levels = f->g->contents.form.kind == YLM_GRID_UNIFORM ? 0 : f->g->contents.form.depth + 1;
  f->weights = ylm_alloc((size_t)levels + 1, sizeof *f->weights);
  if (!f->weights) return YLM_ENOMEM;
  for (int l = 0; l < levels; l++) {
    float edge[3];
    for (int a = 0; a < 3; a++) edge[a] = (float)(f->voxel[a] * (1u << (levels - 1 - l)));
    for (uint32_t place = 0; place < PLACES; place++)
      weights_of_place(f, edge, place, f->weights[l].at[place]);
  }
  return YLM_OK;
}

/* -- frames ---------------------------------------------------------------------------------------- */

/* The level of the largest leaf that a point is a corner of: of the first cell that has it, where it is a corner of none. */
static ylm_status find_edges(small_frame *f) {
  const ylm_grid *g = f->g;
  const small_layout *k = f->k;
  f->edge = ylm_alloc(k->met, 1);
  if (!f->edge) return YLM_ENOMEM;
  memset(f->edge, 0xff, k->met);
  for (size_t i = 0; i < g->contents.octree_cells; i++) {
    const ylm_grid_cell *c = &g->cell[i];
    for (int corner = 0; c->flags & YLM_GRID_LEAF && corner < 8; corner++) {
      uint32_t p = c->corner[corner];
      if (p >= g->evaluated) continue;
      uint8_t *edge = &f->edge[k->rank[p]];
      if (c->level < *edge) *edge = c->level;
    }
  }
  int depth = depth_of(g);
  for (size_t i = 0; i < k->met; i++) {
    if (f->edge[i] == 0xff) f->edge[i] = k->level[i];
    if (f->edge[i] > depth) f->edge[i] = (uint8_t)depth;
    const uint32_t *at = g->lattice + 3 * (size_t)k->place[i];
    if (small_is_shared(g, f->head.finest, at)) f->edge[i] = (uint8_t)small_lattice_level(g, at);
  }
  return YLM_OK;
}

/* Weights of coefficients: those of their degree in irradiance, where that is what counts. */
static void weigh_degrees(small_frame *f) {
  for (int l = 0; l <= f->g->contents.form.lmax; l++) {
    float w = fabsf((float)(ylm_sh_cosine_factor(l) / YLM_PI));
    for (size_t k = ylm_sh_index(l, -l); k <= ylm_sh_index(l, l); k++)
      f->weight[k] = fmaxf(w, f->head.degree), f->unweight[k] = 1 / f->weight[k];
  }
}

ylm_status ylm__small_frame(small_frame *f, const small_layout *k, const small_head *head) {
  const ylm_grid *g = k->g;
  *f = (small_frame){.sums = ylm__small_kernels(),
                     .g = g,
                     .k = k,
                     .head = *head,
                     .rows = g->rows,
                     .width = g->width,
                     .channels = g->contents.form.channels,
                     .count = g->contents.count};
  for (int a = 0; a < 3; a++)
    f->voxel[a] =
        (g->contents.form.bounds[a + 3] - g->contents.form.bounds[a]) / g->contents.resolution[a];
  f->weight = ylm_alloc((size_t)f->count, sizeof *f->weight);
  f->unweight = ylm_alloc((size_t)f->count, sizeof *f->unweight);
  if (!f->weight || !f->unweight) return YLM_ENOMEM;
  weigh_degrees(f);
  ylm_status s = find_edges(f);
  if (s == YLM_OK) s = make_weights(f);
  return s == YLM_OK ? ylm__small_bases(f) : s;
}

void ylm__small_frame_free(small_frame *f) {
  ylm_free(f->weight);
  ylm_free(f->unweight);
  ylm_free(f->weights);
  ylm_free(f->edge);
  ylm_free(f->basis.entry);
  ylm_free(f->basis.column);
  ylm_free(f->colour);
  ylm_free(f->turns);
}

/* -- bases --------------------------------------------------------------------------------------------- */

size_t ylm__small_basis_size(small_turn turn, int lmax) {
  size_t size = 0, count = ylm_sh_count(lmax);
  if (turn == SMALL_ALL) return count * count;
  for (size_t l = 0; turn == SMALL_BY_DEGREE && l <= (size_t)lmax; l++)
    size += (2 * l + 1) * (2 * l + 1);
  return size;
}

ylm_status ylm__small_bases(small_frame *f) {
  small_basis *b = &f->basis;
  size_t blocks = small_blocks(f);
  b->turn = (small_turn)f->head.turn;
  b->lmax = f->g->contents.form.lmax;
  b->count = f->count;
  b->kinds = f->rows;
  b->size = ylm__small_basis_size(b->turn, b->lmax);
  b->entry = ylm_alloc(b->kinds * b->size + 1, 1);
  b->column = ylm_alloc(b->kinds * b->size + 1, sizeof *b->column);
  if (!b->entry || !b->column) return YLM_ENOMEM;
  if (!blocks) return YLM_OK;
  f->colour = ylm_alloc(blocks, 9 * sizeof *f->colour);
  f->turns = ylm_alloc(blocks, sizeof *f->turns);
  if (!f->colour || !f->turns) return YLM_ENOMEM;
  for (size_t i = 0; i < blocks; i++) {
    f->turns[i] = SMALL_NO_TURN;
    ylm__small_turn(f->turns[i], f->colour + 9 * i);
  }
  return YLM_OK;
}

/* n columns of n entries become orthonormal, one after the other; one that vanishes becomes an axis. */
static void make_orthonormal(const int8_t *entry, float *column, size_t n) {
  for (size_t k = 0; k < n; k++) {
    double x[SMALL_COLUMNS];
    for (size_t i = 0; i < n; i++) x[i] = entry[k * n + i] / 127.0;
    for (size_t axis = 0;; axis++) {
      double sum = 0;
      for (size_t m = 0; m < k; m++) {
        double dot = 0;
        for (size_t i = 0; i < n; i++) dot += x[i] * (double)column[m * n + i];
        for (size_t i = 0; i < n; i++) x[i] -= dot * (double)column[m * n + i];
      }
      for (size_t i = 0; i < n; i++) sum += x[i] * x[i];
      if (sum > 1e-4) {
        double inverse = 1 / sqrt(sum);
        for (size_t i = 0; i < n; i++) column[k * n + i] = (float)(x[i] * inverse);
        break;
      }
      for (size_t i = 0; i < n; i++) x[i] = i == (k + axis) % n;
      if (axis > 2 * n) { /* cannot be: some axis is outside of k < n columns */
        for (size_t i = 0; i < n; i++) column[k * n + i] = (float)x[i];
        break;
      }
    }
  }
}

void ylm__small_settle(small_basis *b) {
  for (size_t r = 0; r < b->kinds; r++) {
    const int8_t *entry = b->entry + r * b->size;
    float *column = b->column + r * b->size;
    if (b->turn == SMALL_ALL) make_orthonormal(entry, column, (size_t)b->count);
    for (size_t l = 0, at = 0; b->turn == SMALL_BY_DEGREE && l <= (size_t)b->lmax; l++) {
      make_orthonormal(entry + at, column + at, 2 * l + 1);
      at += (2 * l + 1) * (2 * l + 1);
    }
  }
}

/* A turn of colours: a unit quaternion by its three smaller numbers, of 10 bits each, and which is the largest. */
void ylm__small_turn(uint32_t turn, float column[9]) {
  double q[4], sum = 0;
  uint32_t largest = turn >> 30;
  for (uint32_t i = 0, bits = turn; i < 4; i++) {
    if (i == largest) continue;
    double n = (double)(bits & 1023) - SMALL_TURN_MOST;
    q[i] = n / SMALL_TURN_MOST * 0.70710678118654752;
    sum += q[i] * q[i];
    bits >>= 10;
  }
  q[largest] = sum < 1 ? sqrt(1 - sum) : 0;
  double scale = sum < 1 ? 1 : 1 / sqrt(sum), w = q[0] * scale, x = q[1] * scale, y = q[2] * scale,
         z = q[3] * scale;
  double m[9] = {1 - 2 * (y * y + z * z), 2 * (x * y + w * z),     2 * (x * z - w * y),
                 2 * (x * y - w * z),     1 - 2 * (x * x + z * z), 2 * (y * z + w * x),
                 2 * (x * z + w * y),     2 * (y * z - w * x),     1 - 2 * (x * x + y * y)};
  for (int i = 0; i < 9; i++) column[i] = (float)m[i];
}

/* -- predictions ------------------------------------------------------------------------------------------ */

static const uint32_t *kin_of(const small_frame *f, const small_source *s) {
  return s->of_part ? f->g->sides.node[s->kin] : f->g->cell[s->kin].corner;
}

/* Was a corner met before? */
static bool is_before(const small_frame *f, uint32_t point, size_t met) {
  return point < f->g->evaluated && f->k->rank[point] < met;
}

/* Points before and behind a point along an axis, at a half of its parent's edges. */
typedef struct small_pair {
  uint32_t low, high;
  bool known;
} small_pair;

static void find_pair(const small_frame *f, size_t met, const uint32_t at[3], int axis,
                      uint32_t half, small_pair *pair) {
  uint32_t place[3];
  memcpy(place, at, sizeof place);
  place[axis] -= half;
  pair->low = ylm__lattice_hash_find(&f->g->hash, lattice_key(place));
  place[axis] += 2 * half;
  pair->high = ylm__lattice_hash_find(&f->g->hash, lattice_key(place));
  pair->known = is_before(f, pair->low, met) && is_before(f, pair->high, met);
}

/* Points that predict a shared point: those on both sides along the axes by which it is in the middle of the lattice's cells,
   else, in the middle of a face, its corners. All parts that have the point have these. */
typedef struct small_lattice {
  int pairs, axis[2]; /* axes of the face */
  small_pair pair[3];
  uint32_t corner[4]; /* bit 0: behind along axis[0] */
  bool known;         /* corners */
  float h[3];         /* edges */
} small_lattice;

/* The corners of the face that a point is in the middle of. */
static void find_corners(const small_frame *f, size_t met, const uint32_t at[3], uint32_t half,
                         small_lattice *l) {
  l->known = true;
  for (int i = 0; i < 4; i++) {
    uint32_t place[3];
    memcpy(place, at, sizeof place);
    for (int k = 0; k < 2; k++) {
      int a = l->axis[k];
      place[a] = i >> k & 1 ? place[a] + half : place[a] - half;
    }
    l->corner[i] = ylm__lattice_hash_find(&f->g->hash, lattice_key(place));
    l->known &= is_before(f, l->corner[i], met);
  }
}

/* False: nothing predicts the point, as where cells are larger than those of the top. */
static bool find_lattice(const small_frame *f, size_t met, small_lattice *l) {
  const uint32_t *at = place_of(f, met);
  uint32_t all = at[0] | at[1] | at[2], half = all & -all;
  int middles = 0;
  *l = (small_lattice){.pairs = 0};
  if (small_lattice_level(f->g, at) <= (int)f->head.finest) return false;
  for (int a = 0; a < 3; a++) {
    l->h[a] = (float)(f->voxel[a] * (2 * half));
    if (!(at[a] & half)) continue;
    if (middles < 2) l->axis[middles] = a;
    middles++;
    find_pair(f, met, at, a, half, &l->pair[a]);
    l->pairs += l->pair[a].known;
  }
  if (!l->pairs && middles == 2) find_corners(f, met, at, half, l);
  return l->pairs || l->known;
}

int ylm__small_ways(const small_frame *f, size_t met) {
  small_lattice l;
  if (is_shared(f, met)) return find_lattice(f, met, &l);
  const small_source *s = &f->k->source[met];
  int ways = s->parent[0] != YLM_GRID_NONE;
  if ((ways && f->rows > 1) || s->kin == YLM_GRID_NONE) return ways;
  const uint32_t *corner = kin_of(f, s);
  for (int i = 0; i < 8; i++)
    if (is_before(f, corner[i], met)) return ways | 2;
  return ways;
}

static void add_row(float *restrict to, const float *restrict row, float weight, size_t n) {
  for (size_t i = 0; i < n; i++) to[i] += weight * row[i];
}

static void mix(const small_mix *m, float scale, float *restrict to, size_t n) {
  for (size_t i = 0; i < n; i++) {
    float sum = 0;
    for (int t = 0; t < m->n; t++) sum += m->weight[t] * m->row[t][i];
    to[i] = sum * scale;
  }
}

static void turn(const float *column, const float *number, float *to, size_t n) {
  memset(to, 0, n * sizeof *to);
  for (size_t k = 0; k < n; k++)
    if (number[k] != 0) add_row(to, column + k * n, number[k], n);
}

static void colour(const float v[9], const float *x, float step, const float *by, float *to,
                   size_t n) {
  for (size_t c = 0; c < 3; c++)
    for (size_t k = 0; k < n; k++) {
      float sum = v[c] * x[k] + v[3 + c] * x[n + k];
      sum += v[6 + c] * x[2 * n + k];
      to[c * n + k] += sum * step * by[k];
    }
}

/* The plain form, which judges the others. */
const small_kernels ylm__small_plain = {mix, turn, colour};
YLM_KERNEL_CHOICE(const small_kernels, ylm__small_kernels, ylm_k_small, &ylm__small_plain);

static void scale_rows(float *to, size_t n, float by) {
  for (size_t i = 0; i < n; i++) to[i] *= by;
}

/* The place of a point in a cell's half-edge lattice. */
static uint32_t place_in(const ylm_grid *g, const ylm_grid_cell *c, const uint32_t at[3]) {
  uint32_t half = ylm__grid_edge(g, c) / 2, place = 0;
  for (int a = 2; a >= 0; a--) place = 3 * place + (at[a] - c->origin[a]) / half;
  return place;
}

static void add_term(const small_frame *f, small_mix *m, uint32_t point, int row, float weight) {
  m->row[m->n] = ylm__grid_row(f->g, point, row);
  m->weight[m->n++] = weight;
}

/* One row, from pairs along axes: the value, or the slope along axis row - 1. The cubic between two points says their middle's
   value and its slope along the axis; other slopes are means. h: the distance of a pair along each axis. */
static void mix_pairs(const small_frame *f, const small_pair pair[3], const float h[3], size_t row,
                      float *to) {
  small_mix m = {.n = 0};
  int pairs = 0;
  bool own = row && pair[row - 1].known;
  for (int a = 0; a < 3; a++) {
    if (!pair[a].known || (own && a != (int)row - 1)) continue;
    pairs++;
    if (own) {
      add_term(f, &m, pair[a].high, 0, 1.5f / h[a]);
      add_term(f, &m, pair[a].low, 0, -(1.5f / h[a]));
      add_term(f, &m, pair[a].high, a + 1, -0.25f);
      add_term(f, &m, pair[a].low, a + 1, -0.25f);
      continue;
    }
    add_term(f, &m, pair[a].low, (int)row, 0.5f);
    add_term(f, &m, pair[a].high, (int)row, 0.5f);
    if (row || f->rows == 1) continue;
    add_term(f, &m, pair[a].low, a + 1, 0.125f * h[a]);
    add_term(f, &m, pair[a].high, a + 1, -(0.125f * h[a]));
  }
  f->sums->mix(&m, 1 / (float)pairs, to, f->g->stride);
}

/* By middles of edges and faces of its parent that are there; false: there are none on both sides of any axis. */
static bool predict_by_middles(const small_frame *f, size_t met, float *row) {
  const ylm_grid *g = f->g;
  const ylm_grid_cell *c = &g->cell[f->k->source[met].parent[0]];
  const uint32_t *at = place_of(f, met);
  uint32_t half = ylm__grid_edge(g, c) / 2;
  small_pair pair[3] = {{.known = false}};
  float h[3];
  int middles = 0, pairs = 0;
  for (int a = 0; a < 3; a++) middles += at[a] - c->origin[a] == half;
  if (middles < 2) return false;
  for (int a = 0; a < 3; a++) {
    h[a] = (float)(f->voxel[a] * (2 * half));
    if (at[a] - c->origin[a] == half) find_pair(f, met, at, a, half, &pair[a]);
    pairs += pair[a].known;
  }
  for (size_t r = 0; pairs && r < f->rows; r++) mix_pairs(f, pair, h, r, row + r * g->stride);
  return pairs > 0;
}

/* One row from the corners of a face, as if the middles of its edges were predicted by these first. */
static void mix_corners(const small_frame *f, const small_lattice *l, size_t row, float *to) {
  small_mix m = {.n = 0};
  for (int i = 0; i < 4; i++) {
    uint32_t p = l->corner[i];
    bool own = false;
    for (int k = 0; k < 2; k++) {
      int a = l->axis[k];
      bool behind = i >> k & 1;
      if ((int)row == a + 1) {
        float slope = 0.75f / l->h[a];
        own = true;
        add_term(f, &m, p, 0, behind ? slope : -slope);
        add_term(f, &m, p, a + 1, -0.125f);
      }
      if (!row && f->rows > 1)
        add_term(f, &m, p, a + 1, behind ? -(0.0625f * l->h[a]) : 0.0625f * l->h[a]);
    }
    if (!own) add_term(f, &m, p, (int)row, 0.25f);
  }
  f->sums->mix(&m, 1, to, f->g->stride);
}

static void predict_by_lattice(const small_frame *f, size_t met, float *row) {
  small_lattice l;
  find_lattice(f, met, &l);
  for (size_t r = 0; r < f->rows; r++) {
    float *to = row + r * f->g->stride;
    if (l.pairs)
      mix_pairs(f, l.pair, l.h, r, to);
    else
      mix_corners(f, &l, r, to);
  }
}

static void predict_by_parents(const small_frame *f, size_t met, float *row) {
  if (predict_by_middles(f, met, row)) return;
  const ylm_grid *g = f->g;
  const small_source *s = &f->k->source[met];
  const uint32_t *at = place_of(f, met);
  const small_terms *terms[SMALL_PARENTS];
  const ylm_grid_cell *parent[SMALL_PARENTS];
  int parents = 0;
  for (; parents < SMALL_PARENTS && s->parent[parents] != YLM_GRID_NONE; parents++) {
    const ylm_grid_cell *c = parent[parents] = &g->cell[s->parent[parents]];
    terms[parents] = f->weights[c->level].at[place_in(g, c, at)];
  }
  for (size_t r = 0; r < f->rows; r++) {
    small_mix m = {.n = 0};
    for (int p = 0; p < parents; p++)
      for (int i = 0; i < terms[p][r].n; i++) {
        int which = terms[p][r].row[i];
        m.row[m.n] = ylm__grid_row(g, parent[p]->corner[which & 7], which >> 3);
        m.weight[m.n++] = terms[p][r].weight[i];
      }
    f->sums->mix(&m, 1 / (float)parents, row + r * g->stride, g->stride);
  }
}

/* The mean of what neighbours along the edges say, else of all corners that there are. */
static void predict_by_kin(const small_frame *f, size_t met, float *row) {
  const ylm_grid *g = f->g;
  const small_source *s = &f->k->source[met];
  const uint32_t *corner = kin_of(f, s);
  size_t cell = s->of_part ? g->sides.leaf[s->kin] : s->kin;
  double edge = ylm__grid_edge(g, &g->cell[cell]);
  int n = 0;
  for (int a = 0; a < 3; a++) {
    uint32_t p = corner[s->corner ^ 1 << a];
    if (!is_before(f, p, met)) continue;
    float way = (float)(s->corner >> a & 1 ? f->voxel[a] * edge : -(f->voxel[a] * edge));
    for (size_t r = 0; r < f->rows; r++)
      add_row(row + r * g->stride, ylm__grid_row(g, p, (int)r), 1, f->width);
    if (f->rows > 1) add_row(row, ylm__grid_row(g, p, a + 1), way, f->width);
    n++;
  }
  for (int i = 0; !n && i < 8; i++)
    if (is_before(f, corner[i], met)) {
      for (size_t r = 0; r < f->rows; r++)
        add_row(row + r * g->stride, ylm__grid_row(g, corner[i], (int)r), 1, f->width);
      return;
    }
  if (n > 1) scale_rows(row, f->rows * g->stride, 1 / (float)n);
}

void ylm__small_predict(const small_frame *f, size_t met, int way, float *row) {
  if (way != 1) memset(row, 0, f->rows * f->g->stride * sizeof *row);
  if (way == 1) (is_shared(f, met) ? predict_by_lattice : predict_by_parents)(f, met, row);
  if (way == 2) predict_by_kin(f, met, row);
}

/* -- numbers ------------------------------------------------------------------------------------------------- */

/* 2^e is nearest to the square of the norm, by its logarithm. */
int ylm__small_exponent(const small_frame *f, const float *row) {
  double sum = 0, least = (double)f->head.least * (double)f->head.least,
         most = (double)f->head.most * (double)f->head.most;
  size_t count = (size_t)f->count;
  for (size_t i = 0; i < f->width; i++) {
    double x = (double)row[i] * (double)f->weight[i % count];
    sum += x * x;
  }
  if (!(sum >= least)) sum = least;
  if (!(sum <= most)) sum = most;
  int e;
  return frexp(sum, &e) < 0.70710678118654752 ? e - 1 : e;
}

float ylm__small_norm(int e) {
  float whole = ldexpf(1.0f, (e - (e & 1)) / 2);
  return e & 1 ? whole * 1.41421356f : whole;
}

void ylm__small_steps(const small_frame *f, size_t met, int e, float step[4]) {
  step[0] = f->head.step * ylm__small_norm(e);
  int depth = depth_of(f->g);
  for (int a = 0; a < 3; a++) {
    double edge = f->voxel[a] * (double)(1u << (depth - f->edge[met]));
    step[a + 1] = (float)((double)(f->head.slopes * step[0]) / edge);
  }
}

/* Numbers of one channel and row, turned back: to [count]. */
static void turn_back(const small_frame *f, size_t kind, const float *number, float *restrict to) {
  const small_basis *b = &f->basis;
  size_t count = (size_t)b->count;
  const float *column = b->column + kind * b->size;
  if (b->turn == SMALL_AS_THEY_ARE) memcpy(to, number, count * sizeof *to);
  if (b->turn == SMALL_ALL) f->sums->turn(column, number, to, count);
  for (size_t l = 0, n = 1; b->turn == SMALL_BY_DEGREE && l <= (size_t)b->lmax; l++, n += 2) {
    f->sums->turn(column, number + l * l, to + l * l, n);
    column += n * n;
  }
}

void ylm__small_add(const small_frame *f, size_t met, const float step[4], const float *number,
                    const uint8_t *used, float *row, float *room) {
  size_t count = (size_t)f->count;
  const float *v = colours_of(f, met);
  for (size_t r = 0; r < f->rows; r++) {
    float *to = row + r * f->g->stride;
    if (!used[r]) continue;
    for (size_t c = 0; c < (size_t)f->channels; c++)
      turn_back(f, r, number + r * f->width + c * count, room + c * count);
    if (v) f->sums->colour(v, room, step[r], f->unweight, to, count);
    for (size_t k = 0; !v && k < count; k++) to[k] += room[k] * step[r] * f->unweight[k];
  }
}

/* The inverse of turn_back: numbers of one channel and row. */
static void turn_to(const small_frame *f, size_t kind, const float *x, float *to) {
  const small_basis *b = &f->basis;
  size_t count = (size_t)b->count;
  const float *column = b->column + kind * b->size;
  if (b->turn == SMALL_AS_THEY_ARE) {
    memcpy(to, x, count * sizeof *to);
    return;
  }
  size_t blocks = b->turn == SMALL_ALL ? 1 : (size_t)b->lmax + 1;
  for (size_t l = 0, at = 0; l < blocks; l++) {
    size_t first = b->turn == SMALL_ALL ? 0 : l * l, n = b->turn == SMALL_ALL ? count : 2 * l + 1;
    for (size_t k = 0; k < n; k++) {
      float sum = 0;
      for (size_t i = 0; i < n; i++) sum += x[first + i] * column[at + k * n + i];
      to[first + k] = sum;
    }
    at += n * n;
  }
}

void ylm__small_difference(const small_frame *f, size_t met, const float step[4], const float *row,
                           const float *predicted, float *number, float *room) {
  size_t count = (size_t)f->count;
  const float *v = colours_of(f, met);
  for (size_t r = 0; r < f->rows; r++) {
    float *to = number + r * f->width;
    const float *a = row + r * f->g->stride, *b = predicted + r * f->g->stride;
    for (size_t c = 0; c < (size_t)f->channels; c++)
      for (size_t k = 0; k < count; k++)
        to[c * count + k] = (a[c * count + k] - b[c * count + k]) * f->weight[k] / step[r];
    for (size_t k = 0; v && k < count; k++) {
      float x[3] = {to[k], to[count + k], to[2 * count + k]};
      for (size_t d = 0; d < 3; d++)
        to[d * count + k] = v[3 * d] * x[0] + v[3 * d + 1] * x[1] + v[3 * d + 2] * x[2];
    }
    for (size_t c = 0; c < (size_t)f->channels; c++) {
      memcpy(room, to + c * count, count * sizeof *room);
      turn_to(f, r, room, to + c * count);
    }
  }
}
