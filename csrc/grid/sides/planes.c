/*
** planes.c - planes between the parts of a leaf, for look-ups that trace no ray.
**
** Pieces are coarse: a wall within one has both of its sides there. The ways between neighbouring pieces that a surface blocks tell
** where surfaces are, and ways beside them how these lean. Samples are the places just before the surface, whose part is that of the
** piece that the way comes from.
*/
#include "planes.h"
#include "sides.h"
#include "ylm_vector.h"

#include <math.h>
#include <string.h>

/* -- choosing -------------------------------------------------------------------------------------- */

/* The samples of a leaf. */
typedef struct choice {
  size_t n;
  const side_sample *sample;
  uint8_t parts;
  uint8_t *side; /* [n] the sides of the planes so far */
} choice;

/* The weight of samples in the wrong part where each side has that of the most, with one plane more (NULL: none). `part`, where
   not NULL, becomes the parts of sides. */
static double wrong(const choice *c, int planes, const side_plane *more, uint8_t *part) {
  double weight[PLANES_SIDES][YLM_GRID_PARTS] = {{0}}, all[YLM_GRID_PARTS] = {0}, sum = 0;
  int sides = 1 << (planes + (more != NULL));
  for (size_t i = 0; i < c->n; i++) {
    const side_sample *s = &c->sample[i];
    size_t side = c->side[i];
    if (more) side |= (size_t)(plane_height(more, s->at) >= 0) << planes;
    weight[side][s->part] += (double)s->weight;
    all[s->part] += (double)s->weight;
  }
  uint8_t most = 0;
  for (uint8_t k = 1; k < c->parts; k++)
    if (all[k] > all[most]) most = k;
  for (int side = 0; side < sides; side++) {
    uint8_t best = most;
    double total = 0;
    for (uint8_t k = 0; k < c->parts; k++) {
      total += weight[side][k];
      if (weight[side][k] > weight[side][best]) best = k;
    }
    sum += total - weight[side][best];
    if (part) part[side] = best;
  }
  return sum;
}

/* How far the nearest sample is from a plane. */
static double margin(const choice *c, const side_plane *p) {
  double least = 1;
  for (size_t i = 0; i < c->n; i++) least = fmin(least, fabs(plane_height(p, c->sample[i].at)));
  return least;
}

size_t ylm__planes_choose(size_t n, const side_sample *sample, uint8_t parts, size_t planes,
                          const side_plane *plane, double gain, uint8_t *side,
                          size_t chosen[PLANES_MOST], uint8_t part[PLANES_SIDES], double *left) {
  choice c = {n, sample, parts, side};
  double total = 0;
  int taken = 0;
  for (size_t i = 0; i < n; i++) total += (double)sample[i].weight;
  *left = wrong(&c, 0, NULL, part);
  while (taken<PLANES_MOST && * left> 0) {
    const side_plane *best = NULL;
    double least = *left - gain * total, far = 0;
    for (size_t i = 0; i < planes; i++) {
      double stays = wrong(&c, taken, &plane[i], NULL);
      if (stays > least + 1e-9) continue;
      double m = margin(&c, &plane[i]);
      if (stays > least - 1e-9 && m <= far) continue;
      best = &plane[i];
      least = stays;
      far = m;
    }
    if (!best) break;
    *left = wrong(&c, taken, best, part);
    for (size_t i = 0; i < n; i++)
      side[i] |= (uint8_t)((plane_height(best, sample[i].at) >= 0) << taken);
    chosen[taken++] = (size_t)(best - plane);
  }
  return (size_t)taken;
}

/* -- finding --------------------------------------------------------------------------------------- */

enum {
  WAYS = (MORE - 1) * MORE * MORE, /* between neighbouring pieces along an axis */
  SAMPLES = 6 * WAYS + YLM_GRID_PIECES,
  PLANES_ALL = PLANES_TRIED + YLM_GRID_PARTS * (YLM_GRID_PARTS - 1) / 2
};
static const size_t step_of[3] = {1, MORE, MORE *MORE};

/* A leaf for which planes are sought. */
typedef struct seeking {
  const ylm_grid *g;
  const ylm_grid_walls *walls;
  const ylm_grid_side *side;
  size_t n, planes;
  side_sample sample[SAMPLES];
  side_plane plane[PLANES_ALL];
  uint32_t hits[PLANES_ALL]; /* that lie on it */
  size_t missed; /* places before surfaces that the pieces in front of them have in another part */
} seeking;

/* Adds a place of a piece's part. */
static void add_sample(seeking *k, size_t piece, const double at[3], float weight) {
  uint8_t part = ylm_grid_side_part(k->side, piece);
  if (part == YLM_GRID_PARTS) return;
  side_sample *s = &k->sample[k->n++];
  *s = (side_sample){.weight = weight, .part = part};
  for (int a = 0; a < 3; a++) s->at[a] = (float)at[a];
}

/* A plane, as the grid keeps it, joins those that are known; a new one takes the place of that with the fewest hits. */
static void add_plane(seeking *k, size_t most, const double normal[3], const double through[3]) {
  double length = sqrt(ylm_dot3d(normal, normal));
  side_plane p = {.offset = 0};
  if (!(length > 1e-9)) return;
  for (int a = 0; a < 3; a++) {
    p.normal[a] = round(normal[a] / length * GRID_PLANE_NORMAL) / GRID_PLANE_NORMAL;
    p.offset += p.normal[a] * through[a];
  }
  p.offset = round(p.offset * GRID_PLANE_OFFSET) / GRID_PLANE_OFFSET;
  if (!(fabs(p.offset) * GRID_PLANE_OFFSET < INT16_MAX)) return;
  size_t fewest = 0;
  for (size_t i = 0; i < k->planes; i++) {
    const side_plane *q = &k->plane[i];
    double sign = ylm_dot3d(p.normal, q->normal) < 0 ? -1 : 1;
    double apart = fabs(p.offset - sign * q->offset);
    for (int a = 0; a < 3; a++) apart = fmax(apart, fabs(p.normal[a] - sign * q->normal[a]));
    if (k->hits[i] < k->hits[fewest]) fewest = i;
    if (apart > PLANES_ALIKE) continue;
    k->hits[i]++;
    return;
  }
  if (k->planes < most) fewest = k->planes++;
  k->plane[fewest] = p;
  k->hits[fewest] = 1;
}

/* The ways from pieces to the next ones along an axis, moved by `more` edges along another one; shares of them before surfaces. */
static void look_along(const seeking *k, int axis, int sign, int aside, double more, size_t n,
                       const uint8_t *piece, float *share) {
  const ylm_grid_cell *leaf = &k->g->cell[k->side->cell];
  float a[WAYS][3], b[WAYS][3];
  for (size_t i = 0; i < n; i++) {
    size_t next = sign > 0 ? piece[i] + step_of[axis] : piece[i] - step_of[axis];
    ylm__side_place(k->g, leaf, piece[i], k->walls->origin, a[i]);
    ylm__side_place(k->g, leaf, next, k->walls->origin, b[i]);
    a[i][aside] += (float)(more * ylm__grid_edge(k->g, leaf) / k->g->scale[aside]);
    b[i][aside] += (float)(more * ylm__grid_edge(k->g, leaf) / k->g->scale[aside]);
  }
  k->walls->share(k->walls->self, n, (const float(*)[3])a, (const float(*)[3])b, share);
}

/* How far surfaces are from blocked ways, of two that are moved aside: the slope of the first one that a surface blocks too, in
   edges; NAN where none does. */
static void find_slopes(const seeking *k, int axis, int sign, int aside, size_t n,
                        const uint8_t *piece, const float *share, double *slope) {
  float beside[2][WAYS];
  for (int i = 0; i < 2; i++)
    look_along(k, axis, sign, aside, i ? -PLANES_ASIDE : PLANES_ASIDE, n, piece, beside[i]);
  for (size_t i = 0; i < n; i++) {
    int turn = beside[0][i] < 1 ? 0 : 1;
    double more = turn ? -PLANES_ASIDE : PLANES_ASIDE;
    slope[i] =
        beside[turn][i] < 1 ? (double)(beside[turn][i] - share[i]) / SUB / more : (double)NAN;
  }
}

/* Has the piece in front of a hit another part than that which the way comes from? `normal` is in edges, away from it. */
static bool is_missed(const seeking *k, size_t piece, const double hit[3], const double normal[3]) {
  double away[3], units = ylm__grid_edge(k->g, &k->g->cell[k->side->cell]);
  float front[3];
  for (int a = 0; a < 3; a++) away[a] = -normal[a] * k->g->scale[a] / units;
  if (!ylm_unit3(away)) return false;
  for (int a = 0; a < 3; a++) front[a] = (float)away[a];
  return ylm__side_piece_before(k->g, k->side, hit, front) != ylm_grid_side_part(k->side, piece);
}

/* Places before the surfaces that block ways along an axis, and the planes of these surfaces, by ways beside them. */
static void find_hits(seeking *k, int axis, int sign) {
  uint8_t piece[WAYS];
  float share[WAYS];
  double slope[3][WAYS];
  size_t n = 0, blocked = 0;
  for (size_t i = 0; i < YLM_GRID_PIECES; i++)
    if (piece_at(i, axis) != (sign > 0 ? MORE - 2 : -1) &&
        ylm_grid_side_part(k->side, i) != YLM_GRID_PARTS)
      piece[n++] = (uint8_t)i;
  look_along(k, axis, sign, axis, 0, n, piece, share);
  for (size_t i = 0; i < n; i++)
    if (share[i] < 1) {
      piece[blocked] = piece[i];
      share[blocked++] = share[i];
    }
  for (int a = 0; a < 3; a++)
    if (a != axis) find_slopes(k, axis, sign, a, blocked, piece, share, slope[a]);
  for (size_t i = 0; i < blocked; i++) {
    double at[3], hit[3], normal[3], way = (double)share[i] / SUB;
    for (int a = 0; a < 3; a++) {
      hit[a] = at[a] = piece_middle(piece[i], a);
      normal[a] = a == axis ? sign : -slope[a][i];
    }
    hit[axis] += sign * way;
    at[axis] += sign * fmax(0.5 * way, way - PLANES_BEFORE);
    add_sample(k, piece[i], at, 1);
    add_plane(k, PLANES_TRIED, normal, hit);
    k->missed += is_missed(k, piece[i], hit, normal);
  }
}

/* Planes that halve the ways between the middles of two parts. */
static void halve(seeking *k) {
  double middle[YLM_GRID_PARTS][3] = {{0}}, weight[YLM_GRID_PARTS] = {0};
  for (size_t i = 0; i < k->n; i++) {
    const side_sample *s = &k->sample[i];
    weight[s->part] += (double)s->weight;
    for (int a = 0; a < 3; a++) middle[s->part][a] += (double)s->weight * (double)s->at[a];
  }
  for (uint32_t i = 0; i < k->side->parts; i++)
    for (uint32_t j = 0; j < i; j++) {
      double normal[3], on[3];
      if (!(weight[i] > 0 && weight[j] > 0)) continue;
      for (int a = 0; a < 3; a++) {
        double x = middle[i][a] / weight[i], y = middle[j][a] / weight[j];
        normal[a] = x - y;
        on[a] = (x + y) / 2;
      }
      add_plane(k, PLANES_ALL, normal, on);
    }
}

/* Planes of a side; whether no more places are in wrong parts than by pieces. */
static bool find(seeking *k, grid_side_planes *out) {
  uint8_t side[SAMPLES] = {0}, part[PLANES_SIDES];
  size_t chosen[PLANES_MOST];
  double left;
  size_t hits, wrong_hits = 0;
  k->n = k->planes = k->missed = 0;
  for (int axis = 0; axis < 3; axis++) {
    find_hits(k, axis, 1);
    find_hits(k, axis, -1);
  }
  hits = k->n;
  for (size_t i = 0; i < YLM_GRID_PIECES; i++) {
    double at[3] = {piece_middle(i, 0), piece_middle(i, 1), piece_middle(i, 2)};
    add_sample(k, i, at, PLANES_SLIGHT);
  }
  halve(k);
  size_t n = ylm__planes_choose(k->n, k->sample, (uint8_t)k->side->parts, k->planes, k->plane,
                                PLANES_GAIN, side, chosen, part, &left);
  memset(out, 0, sizeof *out);
  for (size_t i = 0; i < PLANES_MOST; i++) {
    const side_plane *p = i < n ? &k->plane[chosen[i]] : NULL;
    out->plane[i][3] = p ? (int16_t)lround(p->offset * GRID_PLANE_OFFSET) : INT16_MAX;
    for (int a = 0; p && a < 3; a++)
      out->plane[i][a] = (int16_t)lround(p->normal[a] * GRID_PLANE_NORMAL);
  }
  for (size_t i = 0; i < PLANES_SIDES; i++)
    out->part[i / 2] |= (uint8_t)(part[i & (((size_t)1 << n) - 1)] << 4 * (i & 1));
  for (size_t i = 0; i < hits; i++) wrong_hits += part[side[i]] != k->sample[i].part;
  return n > 0 && (wrong_hits <= k->missed || (double)wrong_hits <= PLANES_WRONG * (double)hits);
}

/* Sides whose planes are sought. */
typedef struct planes_job {
  const ylm_grid *g;
  const ylm_grid_walls *walls;
  seeking *seeking;      /* of each thread */
  grid_side_planes *out; /* [sides] side YLM_GRID_NONE: none are found */
} planes_job;

static ylm_status find_some(void *context, size_t begin, size_t end, int worker) {
  const planes_job *j = context;
  seeking *k = &j->seeking[worker];
  for (size_t i = begin; i < end; i++) {
    k->side = &j->g->sides.side[i];
    bool found = k->side->parts > 1 && find(k, &j->out[i]);
    j->out[i].side = found ? (uint32_t)i : YLM_GRID_NONE;
  }
  return YLM_OK;
}

ylm_status ylm__sides_find_planes(ylm_grid *g, const ylm_grid_walls *walls, int threads,
                                  const ylm_progress *progress) {
  grid_sides *s = &g->sides;
  int workers = ylm_threads(threads);
  planes_job j = {g, walls, ylm_alloc((size_t)workers, sizeof *j.seeking),
                  ylm_alloc(s->n ? s->n : 1, sizeof *j.out)};
  ylm_status status = j.seeking && j.out ? YLM_OK : YLM_ENOMEM;
  for (int i = 0; status == YLM_OK && i < workers; i++)
    j.seeking[i].g = g, j.seeking[i].walls = walls;
  if (status == YLM_OK)
    status = ylm_parallel(s->n, SIDES_GRAIN, threads, find_some, &j, progress, "sides");
  size_t n = 0;
  for (size_t i = 0; status == YLM_OK && i < s->n; i++) n += j.out[i].side != YLM_GRID_NONE;
  if (status == YLM_OK && n > 0) s->planes = ylm_alloc(n, sizeof *s->planes);
  if (n > 0 && !s->planes) status = YLM_ENOMEM;
  for (size_t i = 0; status == YLM_OK && i < s->n; i++)
    if (j.out[i].side != YLM_GRID_NONE) s->planes[s->cut++] = j.out[i];
  ylm_free(j.seeking);
  ylm_free(j.out);
  return status;
}
