/*
** merge.c - landings of the same neighbourhood, whose normals point alike, become one light.
**
** A neighbourhood is a cell of a grid in the scene's axes whose place never changes, and whose edge is a power of
** 2^(1/4): lights stay in place while lamps move.
*/
#include <stdlib.h>

#include "emit.h"
#include "ylm_keys.h"
#include "ylm_light_virtual.h"
#include "ylm_sh.h"

#define STEPS 4          /* edges of cells between 1 and 2 */
#define GRAIN 16         /* lights */
#define LEAST_FACING 0.2 /* of normals whose tangent planes count, the cosine to the mean */
/* Edges between facets are above tangent planes, in parts of the depth of all landings. */
#define FACETS 0.25
#define ALIKE 0.99999 /* the cosine between normals that count as one */
/* Directions of a fit, rings of a product of Gauss and even steps; the ridge over the mean of the diagonal. */
#define RINGS 7
#define TURNS 14
#define RIDGE 1e-4
#define MOST 81
#define LEAST_FLUX 0.05 /* of a fit over that of its parts, if it is to be scaled to it */

/* A place, and the side of a cube that its normal points to. */
typedef struct spot {
  float at[3];
  uint32_t side;
} spot;

typedef struct cell {
  int32_t at[3];
  uint32_t side;
} cell;

typedef struct merging {
  const emit_landings *from;
  const ylm_emit_lights *parts; /* their emission; NULL: all are matte */
  spot *spot;                   /* [n] */
  size_t most;                  /* cells, at most */
  ylm_keys cells;               /* cell */
  uint32_t *of;                 /* [landings] their cells */
  size_t *begin;                /* [cells + 1] of the cells' members */
  uint32_t *member;             /* [landings] in the order of particles */
  emit_landing *landing;        /* [cells] merged */
  ylm_emit_lights *lights;
} merging;

/* -- cells ------------------------------------------------------------------------ */

/* The side of a cube, turned so that no wall is along one of its edges. */
static uint32_t side_of(const float n[3]) {
  static const float turn[3][3] = {
      {0.8363f, -0.3847f, 0.3908f}, {0.5174f, 0.7658f, -0.3820f}, {-0.1811f, 0.5154f, 0.8376f}};
  float most = -1;
  uint32_t side = 0;
  for (uint32_t a = 0; a < 3; a++) {
    float x = ylm_dot3(turn[a], n), size = fabsf(x);
    if (size > most) most = size, side = 2 * a + (x < 0);
  }
  return side;
}

/* Which cell of edge h a place is in. Cells begin beside 0, where walls of scenes like to be. */
static cell cell_of(const spot *s, double inverse) {
  static const double beside[3] = {0.377, 0.613, 0.251};
  cell c = {.side = s->side};
  for (int a = 0; a < 3; a++) {
    double x = (double)s->at[a] * inverse + beside[a];
    c.at[a] = (int32_t)fmax(-0x1p30, fmin(0x1p30, floor(x)));
  }
  return c;
}

/* Finds the cells of edge h that hold landings; false: there are more than `most`. */
static bool find_cells(merging *m, double h) {
  double inverse = 1 / h;
  ylm_keys_clear(&m->cells);
  for (size_t i = 0; i < m->from->n; i++) {
    cell c = cell_of(&m->spot[i], inverse);
    if (ylm_keys_put(&m->cells, &c, sizeof c, &m->of[i]) != YLM_OK || m->cells.n > m->most)
      return false;
  }
  return true;
}

static double edge_of(int step) { return exp2((double)step / STEPS); }

/* The least edge of which there are at most `most` cells. */
static double choose_edge(merging *m) {
  float low = INFINITY, high = -INFINITY;
  for (size_t i = 0; i < m->from->n; i++)
    for (int a = 0; a < 3; a++) {
      low = fminf(low, m->spot[i].at[a]);
      high = fmaxf(high, m->spot[i].at[a]);
    }
  double wide = fmax((double)high - (double)low, 1e-30);
  int few = (int)ceil(STEPS * log2(wide)) + 10 * STEPS, many = few - 34 * STEPS;
  while (!find_cells(m, edge_of(few))) few += STEPS; /* until one holds all */
  while (few - many > 1) {                           /* `few` is wide enough */
    int middle = (few + many) / 2;
    if (find_cells(m, edge_of(middle)))
      few = middle;
    else
      many = middle;
  }
  find_cells(m, edge_of(few));
  return edge_of(few);
}

typedef struct ranked {
  cell c;
  uint32_t of;
} ranked;

static int by_place(const void *a, const void *b) {
  const ranked *x = a, *y = b;
  for (int k = 0; k < 3; k++)
    if (x->c.at[k] != y->c.at[k]) return x->c.at[k] < y->c.at[k] ? -1 : 1;
  return (x->c.side > y->c.side) - (x->c.side < y->c.side);
}

/* Numbers cells by their places, and lists their members. */
static ylm_status list(merging *m) {
  ranked *r = ylm_alloc(m->cells.n, sizeof *r);
  uint32_t *number = ylm_alloc(m->cells.n, sizeof *number);
  m->begin = ylm_alloc_zero(m->cells.n + 2, sizeof *m->begin);
  m->member = ylm_alloc(m->from->n, sizeof *m->member);
  bool ok = r && number && m->begin && m->member;
  for (size_t k = 0; ok && k < m->cells.n; k++)
    r[k] = (ranked){((const cell *)m->cells.key)[k], (uint32_t)k};
  if (ok) qsort(r, m->cells.n, sizeof *r, by_place);
  for (size_t k = 0; ok && k < m->cells.n; k++) number[r[k].of] = (uint32_t)k;
  for (size_t i = 0; ok && i < m->from->n; i++) {
    m->of[i] = number[m->of[i]];
    m->begin[m->of[i] + 2]++;
  }
  for (size_t k = 0; ok && k < m->cells.n; k++) m->begin[k + 2] += m->begin[k + 1];
  for (size_t i = 0; ok && i < m->from->n; i++) m->member[m->begin[m->of[i] + 1]++] = (uint32_t)i;
  ylm_free(r);
  ylm_free(number);
  return ok ? YLM_OK : YLM_ENOMEM;
}

/* -- one light -------------------------------------------------------------------- */

/* Sums and means of the members of a cell. */
typedef struct group {
  size_t n;
  const uint32_t *member;
  double weight, power[3], at[3], normal[3], way;
  double spread; /* mean of the squares of distances from `at` */
  double facing; /* the mean of normals' length */
  double widest; /* the least cosine between `normal` and one of them */
} group;

/* Of landings by their luminous power. */
static void gather(const emit_landings *from, group *g) {
  double top = -INFINITY, bottom = INFINITY, tangent = INFINITY;
  for (size_t k = 0; k < g->n; k++) {
    const emit_landing *l = &from->landing[g->member[k]];
    double w = ylm__emit_luminous(l);
    g->weight += w;
    g->way += w * (double)l->way;
    for (int a = 0; a < 3; a++) {
      g->power[a] += (double)l->power[a];
      g->at[a] += w * (double)l->at[a];
      g->normal[a] += w * (double)l->normal[a];
    }
  }
  g->way /= g->weight;
  for (int a = 0; a < 3; a++) g->at[a] /= g->weight, g->facing += g->normal[a] * g->normal[a];
  g->facing = fmin(1, sqrt(g->facing) / g->weight);
  ylm_unit3(g->normal);
  g->widest = 1;
  for (size_t k = 0; k < g->n; k++) {
    const emit_landing *l = &from->landing[g->member[k]];
    double d2 = 0, up = 0, own = 0, facing = 0;
    for (int a = 0; a < 3; a++) {
      double v = (double)l->at[a] - g->at[a];
      d2 += v * v;
      up += v * g->normal[a];
      own += v * (double)l->normal[a];
      facing += (double)l->normal[a] * g->normal[a];
    }
    g->spread += ylm__emit_luminous(l) * d2 / g->weight;
    top = fmax(top, up);
    bottom = fmin(bottom, up);
    if (facing > LEAST_FACING) tangent = fmin(tangent, own / facing);
    g->widest = fmin(g->widest, facing);
  }
  /* out of the surface: a hollow is below the highest landing, a bulge below the tangent planes of all */
  double lift = fmax(top, isfinite(tangent) ? tangent : top);
  if (g->widest < ALIKE) lift += FACETS * (top - bottom);
  for (int a = 0; a < 3; a++) g->at[a] += lift * g->normal[a];
}

/* Solves the n x n system by Cholesky's method, a and the three columns of b [3][MOST] in place; false: it has no
   solution. */
static bool solve(size_t n, double (*a)[MOST], double (*b)[MOST]) {
  for (size_t j = 0; j < n; j++) {
    for (size_t k = 0; k < j; k++) a[j][j] -= a[j][k] * a[j][k];
    if (!(a[j][j] > 0)) return false;
    a[j][j] = sqrt(a[j][j]);
    for (size_t i = j + 1; i < n; i++) {
      for (size_t k = 0; k < j; k++) a[i][j] -= a[i][k] * a[j][k];
      a[i][j] /= a[j][j];
    }
  }
  for (int c = 0; c < 3; c++) {
    for (size_t i = 0; i < n; i++) {
      for (size_t k = 0; k < i; k++) b[c][i] -= a[i][k] * b[c][k];
      b[c][i] /= a[i][i];
    }
    for (size_t i = n; i-- > 0;) {
      for (size_t k = i + 1; k < n; k++) b[c][i] -= a[k][i] * b[c][k];
      b[c][i] /= a[i][i];
    }
  }
  return true;
}

/* Directions all over where max(0, s + n.u) is not 0, and their solid angles. */
static void directions(const double n[3], double s, double (*u)[3], double *solid) {
  double z[RINGS], part[RINGS];
  float axis[3] = {(float)n[0], (float)n[1], (float)n[2]}, a[3], b[3];
  ylm_scene_basis(axis, a, b);
  ylm_sh_gauss_legendre(RINGS, z, part);
  for (int i = 0, k = 0; i < RINGS; i++)
    for (int j = 0; j < TURNS; j++, k++) {
      double up = (1 - s) / 2 + (1 + s) / 2 * z[i], across = sqrt(fmax(0, 1 - up * up));
      double turn = 2 * YLM_PI * (j + 0.5 * (i % 2)) / TURNS;
      for (int x = 0; x < 3; x++)
        u[k][x] = up * n[x] + across * (cos(turn) * (double)a[x] + sin(turn) * (double)b[x]);
      solid[k] = (1 + s) / 2 * part[i] * 2 * YLM_PI / TURNS;
    }
}

/* Light of the members in direction u, per colour; Y are the harmonics there. */
static void sent(const merging *m, const group *g, size_t count, const double u[3], const double *Y,
                 double out[3]) {
  memset(out, 0, 3 * sizeof *out);
  for (size_t k = 0; k < g->n; k++) {
    const emit_landing *l = &m->from->landing[g->member[k]];
    double facing = 0;
    for (int a = 0; a < 3; a++) facing += (double)l->normal[a] * u[a];
    if (facing <= 0) continue;
    for (size_t c = 0; c < 3; c++) {
      const double *b = m->parts->emission + (3 * (size_t)g->member[k] + c) * count;
      double sum = 0;
      for (size_t q = 0; q < count; q++) sum += b[q] * Y[q];
      out[c] += facing * sum;
    }
  }
}

/* The emission b [3][count], by least squares, of a light with that normal and shift: what the members send. */
static bool fit(const merging *m, const group *g, double shift, int degree, double (*b)[MOST]) {
  double u[RINGS * TURNS][3], solid[RINGS * TURNS], Y[RINGS * TURNS * MOST], a[MOST][MOST],
      trace = 0;
  size_t count = ylm_sh_count(degree);
  directions(g->normal, shift, u, solid);
  if (ylm_sh_eval(degree, 0, true, YLM_DOUBLE, RINGS * TURNS, u[0], Y, NULL, NULL, 1, NULL) !=
      YLM_OK)
    return false;
  memset(a, 0, sizeof a);
  memset(b, 0, 3 * sizeof *b);
  for (size_t k = 0; k < RINGS * TURNS; k++) {
    const double *y = Y + k * count;
    double out[3], facing = shift;
    for (int x = 0; x < 3; x++) facing += g->normal[x] * u[k][x];
    sent(m, g, count, u[k], y, out);
    for (size_t i = 0; i < count; i++) {
      for (size_t j = 0; j <= i; j++) a[i][j] += solid[k] * facing * facing * y[i] * y[j];
      for (int c = 0; c < 3; c++) b[c][i] += solid[k] * facing * y[i] * out[c];
    }
  }
  for (size_t i = 0; i < count; i++) trace += a[i][i];
  for (size_t i = 0; i < count; i++) a[i][i] += RIDGE * trace / (double)count;
  return solve(count, a, b);
}

/* Emission of light i: sums where normals are one, else fitted and scaled to the power of the members. */
static void emission_of(const merging *m, const group *g, size_t i, double shift) {
  int degree = m->parts->degree;
  size_t count = ylm_sh_count(degree);
  double b[3][MOST], power[3], wanted[3] = {0, 0, 0}, *to = m->lights->emission + 3 * i * count;
  bool alike = g->widest >= ALIKE;
  ylm_zero(to, 3 * count * sizeof *to);
  for (size_t k = 0; k < g->n; k++) {
    const double *part = m->parts->emission + 3 * (size_t)g->member[k] * count;
    for (size_t q = 0; alike && q < 3 * count; q++) to[q] += part[q];
    if (alike) continue;
    ylm_light_virtual_flux(m->parts->normal + 3 * (size_t)g->member[k], 0, degree, part, power);
    for (int c = 0; c < 3; c++) wanted[c] += power[c];
  }
  if (alike) return;
  if (!fit(m, g, shift, degree, b)) memset(b, 0, sizeof b);
  for (size_t c = 0; c < 3; c++) memcpy(to + c * count, b[c], count * sizeof **b);
  ylm_light_virtual_flux(g->normal, shift, degree, to, power);
  for (size_t c = 0; c < 3; c++) {
    bool scaled = power[c] > LEAST_FLUX * wanted[c] && wanted[c] > 0;
    for (size_t q = 0; q < count; q++) to[c * count + q] *= scaled ? wanted[c] / power[c] : 0;
    if (!scaled) /* as a matte surface sends it */
      to[c * count] = sqrt(4 * YLM_PI) * wanted[c] / (YLM_PI * (1 + shift) * (1 + shift));
  }
}

/* The shift of a light that stands for normals whose mean has this length. One that sends I max(0, s + n.u) has
   the power pi I (1 + s)^2, and the mean of directions, by power, 2/3 (1 - s/2) n; that of Lambert's law is 2/3 of
   its normal. */
static double matte_shift(const group *g) {
  return g->widest >= ALIKE ? 0 : fmin(1, 2 * (1 - g->facing));
}

static ylm_status make(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const merging *m = context;
  ylm_emit_lights *l = m->lights;
  for (size_t i = begin; i < end; i++) {
    group g = {.n = m->begin[i + 1] - m->begin[i], .member = m->member + m->begin[i]};
    gather(m->from, &g);
    bool matte = true;
    for (size_t k = 0; k < g.n; k++)
      matte = matte && m->from->landing[g.member[k]].slot == EMIT_MATTE;
    double shift = matte_shift(&g), widest = fmax(0, g.widest);
    if (!matte && g.widest < ALIKE) shift = sqrt(1 - widest * widest);
    emit_landing *to = &m->landing[i];
    *to = (emit_landing){.way = (float)g.way,
                         .area = (float)(2 * YLM_PI * g.spread),
                         .particle = (uint32_t)i,
                         .slot = EMIT_MATTE};
    l->shift[i] = shift;
    for (size_t a = 0; a < 3; a++) {
      to->at[a] = (float)(l->at[3 * i + a] = g.at[a]);
      to->normal[a] = (float)(l->normal[3 * i + a] = g.normal[a]);
      to->power[a] = (float)g.power[a];
      l->intensity[3 * i + a] = g.power[a] / (YLM_PI * (1 + shift) * (1 + shift));
    }
    if (!m->parts) continue;
    if (!matte) {
      emission_of(m, &g, i, shift);
      continue;
    }
    size_t count = ylm_sh_count(m->parts->degree);
    for (size_t c = 0; c < 3; c++) {
      ylm_zero(l->emission + (3 * i + c) * count, count * sizeof *l->emission);
      l->emission[(3 * i + c) * count] = sqrt(4 * YLM_PI) * l->intensity[3 * i + c];
    }
  }
  return YLM_OK;
}

/* -- all -------------------------------------------------------------------------- */

static ylm_status make_room(merging *m, ylm_emit_lights *l) {
  size_t n = l->n = m->cells.n;
  m->landing = ylm_alloc(n, sizeof *m->landing);
  l->at = ylm_alloc(n, 3 * sizeof *l->at);
  l->normal = ylm_alloc(n, 3 * sizeof *l->normal);
  l->radius = ylm_alloc(n, sizeof *l->radius);
  l->shift = ylm_alloc(n, sizeof *l->shift);
  l->intensity = ylm_alloc(n, 3 * sizeof *l->intensity);
  bool ok = m->landing && l->at && l->normal && l->radius && l->shift && l->intensity;
  if (m->parts) {
    l->degree = m->parts->degree;
    l->emission = ylm_alloc(n, 3 * ylm_sh_count(l->degree) * sizeof *l->emission);
    ok = ok && l->emission;
  }
  return ok ? YLM_OK : YLM_ENOMEM;
}

static ylm_status begin(merging *m, const ylm_emit_options *o) {
  size_t n = m->from->n;
  m->most = o->cell > 0 || o->lights == 0 || o->lights > n ? n : o->lights;
  if (m->most < YLM_EMIT_LEAST_MERGED) m->most = YLM_EMIT_LEAST_MERGED;
  m->spot = ylm_alloc(n, sizeof *m->spot);
  m->of = ylm_alloc(n, sizeof *m->of);
  if (!m->spot || !m->of || !ylm_keys_reserve(&m->cells, m->most + 1, sizeof(cell)))
    return YLM_ENOMEM;
  for (size_t i = 0; i < n; i++) {
    memcpy(m->spot[i].at, m->from->landing[i].at, sizeof m->spot[i].at);
    m->spot[i].side = side_of(m->from->landing[i].normal);
  }
  return YLM_OK;
}

ylm_status ylm__emit_merge(const ylm_emit_options *o, const ylm_emit_lights *parts,
                           emit_landings *x, ylm_emit_lights *lights, double *edge) {
  merging m = {.from = x, .parts = parts && parts->degree > 0 ? parts : NULL, .lights = lights};
  ylm_status s = begin(&m, o);
  if (s == YLM_OK) {
    *edge = o->cell > 0 ? o->cell : choose_edge(&m);
    if (o->cell > 0) find_cells(&m, o->cell);
    s = list(&m);
  }
  if (s == YLM_OK) s = make_room(&m, lights);
  if (s == YLM_OK) s = ylm_parallel(m.cells.n, GRAIN, o->threads, make, &m, o->progress, "merge");
  if (s == YLM_OK) {
    ylm_free(x->landing);
    *x = (emit_landings){m.cells.n, m.landing};
    m.landing = NULL;
  }
  ylm_free(m.landing);
  ylm_free(m.spot);
  ylm_keys_free(&m.cells);
  ylm_free(m.of);
  ylm_free(m.begin);
  ylm_free(m.member);
  return s;
}
