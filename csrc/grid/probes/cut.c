/*
** cut.c - planes between the bricks of a leaf.
**
** Samples are places in front of surfaces, whose bricks rays tell, and the middles of pieces, which count little; beside the grid's
** bounds those of pieces outside too, where places in front of a wall on the bounds are. Planes are those of the surfaces, of the
** pieces' borders, and those that halve the way between two bricks. The plane is taken that leaves the least weight of samples in the
** wrong brick, then the next, until none gains.
*/
#include "probes.h"
#include "ylm_list.h"

#include <string.h>

#define SLIGHT 0.05 /* the weight of a piece, beside 1 of a place */
#define GAIN 0.002  /* of the weight of all samples: a plane that gains less is not taken */
#define NEAR 0.3    /* of a place close to its surface */
#define CLOSE 0.02  /* so close, in parts of how far look-ups go in front */
#define PLANES_TRIED 96
#define BORDERS (3 * (PROBES_SUB + 1))
/* Planes that may cut a leaf: of surfaces, of the borders of pieces, between two bricks. */
#define PLANES_ALL (PLANES_TRIED + BORDERS + PROBES_PARTS * (PROBES_PARTS - 1) / 2)

typedef struct cut_sample {
  uint32_t row;
  uint8_t brick;
  bool surface;
  float at[3],
      normal[3]; /* in edges of the leaf; of a surface: where it is, and its normal there */
  float on[3];
  float weight;
} cut_sample;

typedef struct cut_plane {
  int8_t normal[3];
  int16_t offset;
} cut_plane;

/* Rounds a plane through a place of a leaf, as files have it. False: it is none. */
static bool round_plane(const double normal[3], const double through[3], cut_plane *p) {
  double length = 0, offset = 0;
  for (int a = 0; a < 3; a++) length += normal[a] * normal[a];
  length = sqrt(length);
  if (!(length > 1e-9)) return false;
  for (int a = 0; a < 3; a++) {
    p->normal[a] = (int8_t)lround(normal[a] / length * PROBES_NORMAL);
    offset += p->normal[a] / PROBES_NORMAL * through[a];
  }
  offset = round(offset * PROBES_OFFSET);
  if (!(fabs(offset) < 32768)) return false;
  p->offset = (int16_t)offset;
  return true;
}

static double height(const cut_plane *p, const float at[3]) {
  double h = -p->offset / PROBES_OFFSET;
  for (int a = 0; a < 3; a++) h += p->normal[a] / PROBES_NORMAL * (double)at[a];
  return h;
}

/* The samples of a leaf. */
typedef struct cut_leaf {
  const cut_sample *sample;
  size_t n;
  uint8_t parts;
  uint8_t *side; /* [n] the sides of the planes so far */
} cut_leaf;

/* The weight of samples in the wrong brick where each side has that of the most, with one plane more (NULL: none). `part`, where
   not NULL, becomes the bricks of sides. */
static double wrong(const cut_leaf *l, int planes, const cut_plane *more, uint8_t *part) {
  double weight[1 << PROBES_PLANES][PROBES_PARTS] = {{0}}, all[PROBES_PARTS] = {0}, sum = 0;
  int sides = 1 << (planes + (more != NULL));
  for (size_t i = 0; i < l->n; i++) {
    const cut_sample *s = &l->sample[i];
    size_t side = l->side[i];
    if (more) side |= (size_t)(height(more, s->at) >= 0) << planes;
    weight[side][s->brick] += (double)s->weight;
    all[s->brick] += (double)s->weight;
  }
  uint8_t most = 0;
  for (uint8_t k = 1; k < l->parts; k++)
    if (all[k] > all[most]) most = k;
  for (int side = 0; side < sides; side++) {
    uint8_t best = most;
    double total = 0;
    for (uint8_t k = 0; k < l->parts; k++) {
      total += weight[side][k];
      if (weight[side][k] > weight[side][best]) best = k;
    }
    sum += total - weight[side][best];
    if (part) part[side] = best;
  }
  return sum;
}

/* How far the nearest sample is from a plane. */
static double margin(const cut_leaf *l, const cut_plane *p) {
  double least = 1;
  for (size_t i = 0; i < l->n; i++) least = fmin(least, fabs(height(p, l->sample[i].at)));
  return least;
}

/* Planes that may cut a leaf; their number. */
static size_t find_planes(const cut_leaf *l, cut_plane plane[PLANES_ALL]) {
  size_t n = 0, surfaces = 0;
  for (size_t i = 0; i < l->n; i++) surfaces += l->sample[i].surface;
  size_t step = surfaces / PLANES_TRIED + 1, seen = 0;
  for (size_t i = 0; i < l->n; i++) {
    const cut_sample *s = &l->sample[i];
    if (!s->surface || seen++ % step) continue;
    double normal[3] = {(double)s->normal[0], (double)s->normal[1], (double)s->normal[2]},
           on[3] = {(double)s->on[0], (double)s->on[1], (double)s->on[2]};
    n += round_plane(normal, on, &plane[n]);
  }
  for (int a = 0; a < 3; a++)
    for (int k = 0; k <= PROBES_SUB; k++) {
      double normal[3] = {a == 0, a == 1, a == 2}, on[3] = {0, 0, 0};
      on[a] = (double)k / PROBES_SUB;
      n += round_plane(normal, on, &plane[n]);
    }
  double middle[PROBES_PARTS][3] = {{0}}, weight[PROBES_PARTS] = {0};
  for (size_t i = 0; i < l->n; i++) {
    const cut_sample *s = &l->sample[i];
    weight[s->brick] += (double)s->weight;
    for (int a = 0; a < 3; a++) middle[s->brick][a] += (double)s->weight * (double)s->at[a];
  }
  for (uint8_t i = 0; i < l->parts; i++)
    for (uint8_t k = 0; k < i; k++) {
      double normal[3], on[3];
      if (!(weight[i] > 0 && weight[k] > 0)) continue;
      for (int a = 0; a < 3; a++) {
        double x = middle[i][a] / weight[i], y = middle[k][a] / weight[k];
        normal[a] = x - y;
        on[a] = (x + y) / 2;
      }
      n += round_plane(normal, on, &plane[n]);
    }
  return n;
}

static void cut_leaf_apart(cut_leaf *l, probes_cut *c) {
  cut_plane plane[PLANES_ALL];
  size_t n = find_planes(l, plane);
  double total = 0, now = wrong(l, 0, NULL, c->part);
  for (size_t i = 0; i < l->n; i++) total += (double)l->sample[i].weight;
  c->planes = 0;
  while (c->planes < PROBES_PLANES && now > 0) {
    const cut_plane *best = NULL;
    double least = now - GAIN * total, far = 0;
    for (size_t i = 0; i < n; i++) {
      double left = wrong(l, c->planes, &plane[i], NULL);
      if (left > least + 1e-9) continue;
      double m = margin(l, &plane[i]);
      if (left > least - 1e-9 && m <= far) continue;
      best = &plane[i];
      least = left;
      far = m;
    }
    if (!best) break;
    now = wrong(l, c->planes, best, c->part);
    for (size_t i = 0; i < l->n; i++)
      l->side[i] |= (uint8_t)((height(best, l->sample[i].at) >= 0) << c->planes);
    memcpy(c->normal[c->planes], best->normal, sizeof best->normal);
    c->offset[c->planes++] = best->offset;
  }
}

/* -- samples --------------------------------------------------------------------------------------- */

/* Whether a look-up ends in a leaf at a piece of it, or of the layer around it, which is outside then. */
static bool piece_is_read(const ylm_grid *g, const ylm_grid_cell *leaf, const int at[3]) {
  uint32_t edge = ylm__grid_edge(g, leaf);
  for (int a = 0; a < 3; a++) {
    if (at[a] < 0 && leaf->origin[a] > 0) return false;
    if (at[a] >= PROBES_SUB && leaf->origin[a] + edge < g->contents.resolution[a]) return false;
  }
  return true;
}

/* The middles of a leaf's pieces; their number. */
static size_t sample_pieces(const ylm_grid *g, const ylm_grid_probes *p, size_t cell,
                            cut_sample *out) {
  const ylm_grid_side *side = ylm__grid_side_of(g, p->source[cell]);
  uint32_t row = p->row[cell];
  size_t n = 0;
  for (size_t i = 0; i < YLM_GRID_PIECES; i++) {
    const size_t wide = YLM_GRID_PIECES_ALL;
    const int at[3] = {(int)(i % wide) - 1, (int)(i / wide % wide) - 1, (int)(i / wide / wide) - 1};
    if (!piece_is_read(g, &g->cell[p->source[cell]], at)) continue;
    bool own = true;
    for (int a = 0; a < 3; a++) own = own && at[a] >= 0 && at[a] < PROBES_SUB;
    uint8_t part = ylm_grid_side_part(side, i), brick = 255;
    if (own)
      brick = p->piece[row][(at[2] * PROBES_SUB + at[1]) * PROBES_SUB + at[0]];
    else if (part != YLM_GRID_PARTS)
      brick = p->brick_of[row][part];
    if (brick == 255) continue;
    cut_sample s = {.row = row, .brick = brick, .weight = SLIGHT};
    for (int a = 0; a < 3; a++) s.at[a] = ((float)at[a] + 0.5f) / PROBES_SUB;
    out[n++] = s;
  }
  return n;
}

/* The sample of a place, in front of its surface by the part `way` of what look-ups take; false: its leaf has one brick, or rays find
   none. */
static bool sample_place(const ylm_grid *g, const ylm_grid_probes *p, const ylm_grid_walls *walls,
                         const double x[3], const float normal[3], double way, cut_sample *s) {
  float shorter[3];
  for (int a = 0; a < 3; a++) shorter[a] = normal[a] * (float)sqrt(way);
  probes_front f = ylm__probes_front(p, x, shorter);
  uint32_t row = p->row[f.cell];
  if (row == YLM_GRID_NONE) return false;
  const ylm_grid_side *side = ylm__grid_side_of(g, p->source[f.cell]);
  uint8_t brick = p->brick_of[row][ylm__side_look(g, side, x, normal, walls) - side->first];
  *s = (cut_sample){.row = row, .brick = brick, .surface = true, .weight = way < 1 ? NEAR : 1};
  double length = 0;
  for (int a = 0; a < 3; a++) {
    double extent = p->bounds[a + 3] - p->bounds[a];
    s->at[a] = (float)f.front[a];
    s->on[a] = (float)f.at[a];
    s->normal[a] = normal[a] * (float)extent / (float)p->roots[a]; /* in edges */
    length += (double)s->normal[a] * (double)s->normal[a];
  }
  return brick != 255 && length > 0;
}

ylm_status ylm__probes_cut(const ylm_grid *g, const ylm_grid_walls *walls,
                           const ylm_grid_probes_places *at, ylm_grid_probes *p) {
  size_t places = walls && at ? at->n : 0, most = 2 * places + YLM_GRID_PIECES * p->several, n = 0;
  cut_sample *all = ylm_alloc(most + 1, sizeof *all), *sorted = ylm_alloc(most + 1, sizeof *all);
  size_t *begin = ylm_alloc_zero(p->several + 2, sizeof *begin);
  uint8_t *side = ylm_alloc_zero(most + 1, 1);
  ylm_status s = all && sorted && begin && side ? YLM_OK : YLM_ENOMEM;
  for (size_t cell = 0; s == YLM_OK && cell < p->cells; cell++)
    if (p->row[cell] != YLM_GRID_NONE) n += sample_pieces(g, p, cell, all + n);
  for (size_t i = 0; s == YLM_OK && i < 2 * places; i++) {
    size_t k = i / 2;
    n += sample_place(g, p, walls, at->point[k], at->normal[k], i % 2 ? CLOSE : 1, &all[n]);
  }
  for (size_t i = 0; s == YLM_OK && i < n; i++) begin[all[i].row + 2]++;
  for (size_t row = 0; s == YLM_OK && row < p->several; row++) begin[row + 2] += begin[row + 1];
  for (size_t i = 0; s == YLM_OK && i < n; i++) sorted[begin[all[i].row + 1]++] = all[i];
  for (size_t cell = 0; s == YLM_OK && cell < p->cells; cell++) {
    uint32_t row = p->row[cell];
    if (row == YLM_GRID_NONE) continue;
    cut_leaf l = {.sample = sorted + begin[row],
                  .n = begin[row + 1] - begin[row],
                  .parts = p->parts[cell],
                  .side = side + begin[row]};
    cut_leaf_apart(&l, &p->cut[row]);
  }
  ylm_free(all);
  ylm_free(sorted);
  ylm_free(begin);
  ylm_free(side);
  return s;
}
