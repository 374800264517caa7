/*
** levels.c - irradiance by many virtual lights at points with normals.
**
** Lights have a near part, to 1.6 R, which is summed light by light (near.c), and a far part. The
** far part is that of the core 2^L R, and the parts between 2^j R and 2^(j+1) R. Each of these is
** smooth on the scale of 2^j R, and its lights are merged in cells that are as much larger. Level j
** has a lattice whose cells grow alike: corners hold what they interpolate from level j+1, and what
** the part of level j adds. A cell has children where that part reaches it. A corner therefore asks
** a number of lights that depends on neither their number nor the room.
*/
#include "levels.h"
#include "near.h"
#include "ylm_keys.h"
#include "ylm_list.h"
#include "ylm_sets.h"
#include "ylm_sh.h"

enum { LEVELS = 24, TOP_POINTS = 2048, CHUNK = 2048, EXTENT = 1 << 28 };
/* Pairs of the top level that are worth another one below; how many lights a merging may leave of 16 to be worth it. */
#define TOP_PAIRS 4e6
#define WORTH 13
#define ALIKE 1e-6f /* of normals that count as one: the most that their numbers differ */
#define INSET 1e-3  /* of an edge */
#define NONE UINT32_MAX

/* A place on a lattice. */
typedef struct level_key {
  int32_t of[3];
} level_key;

static const level_key *key_at(const ylm_keys *t, size_t number) {
  return ylm_keys_at(t, number, sizeof(level_key));
}

/* Cells of a lattice, and their corners. */
typedef struct level {
  double edge[3], core;
  ylm_keys cells, corners;
  uint32_t (*corner)[8]; /* [cells] */
  uint32_t *above;       /* [corners] a cell of the level above that has the corner */
  float *rows;           /* [corners][4][stride] */
  size_t room, corner_room;
} level;

typedef struct levels {
  const ylm_light_virtual *lights;
  const ylm_light_virtual_levels *o;
  size_t n; /* points */
  const float *points, *normals;
  int top;             /* the highest level */
  level level[LEVELS]; /* [top+1] */
  double origin[3];
  int32_t cells[3]; /* of the lowest level along an axis, at most */
  size_t count, stride;
  ylm_keys finest;         /* cells of the lowest level that have points */
  uint32_t *at;            /* [points] of these */
  uint32_t *leaf;          /* [finest] a cell */
  uint8_t *depth;          /* [finest] of this level */
  uint32_t *first, *order; /* [finest+1], [points] by cells */
  ylm__level_mix_fn *mix;
  ylm__level_shine_fn *shine;
  float *out;
  int of; /* the level that is at work */
} levels;

/* -- cells ---------------------------------------------------------------------------------- */

/* Numbers the cells of the lowest level that have points. */
static ylm_status find_cells(levels *s) {
  level_key before = {{0}};
  uint32_t number = NONE;
  double inverse[3];
  for (int a = 0; a < 3; a++) inverse[a] = 1 / s->level[0].edge[a];
  s->at = ylm_alloc(s->n, sizeof *s->at);
  if (!s->at) return YLM_ENOMEM;
  for (size_t i = 0; i < s->n; i++) {
    level_key k = {{0}};
    for (size_t a = 0; a < 3; a++) {
      int32_t at = (int32_t)(((double)s->points[3 * i + a] - s->origin[a]) * inverse[a]);
      k.of[a] = at < 0 ? 0 : at < s->cells[a] ? at : s->cells[a] - 1;
    }
    if (number == NONE || memcmp(&k, &before, sizeof k) != 0) {
      ylm_status status = ylm_keys_put(&s->finest, &k, sizeof k, &number);
      if (status != YLM_OK) return status;
      before = k;
    }
    s->at[i] = number;
  }
  return YLM_OK;
}

/* Sorts points by their cells, in the order of their numbers. */
static ylm_status sort_points(levels *s) {
  s->first = ylm_alloc_zero(s->finest.n + 2, sizeof *s->first);
  s->order = ylm_alloc(s->n, sizeof *s->order);
  s->leaf = ylm_alloc(s->finest.n, sizeof *s->leaf);
  s->depth = ylm_alloc_zero(s->finest.n, sizeof *s->depth);
  if (!s->first || !s->order || !s->leaf || !s->depth) return YLM_ENOMEM;
  for (size_t i = 0; i < s->n; i++) s->first[s->at[i] + 2]++;
  for (size_t k = 2; k < s->finest.n + 2; k++) s->first[k] += s->first[k - 1];
  for (size_t i = 0; i < s->n; i++) s->order[s->first[s->at[i] + 1]++] = (uint32_t)i;
  return YLM_OK;
}

static level_key ancestor(const levels *s, uint32_t finest, int j) {
  level_key k = *key_at(&s->finest, finest);
  for (int a = 0; a < 3; a++) k.of[a] >>= j;
  return k;
}

/* Room for a cell more, and its corners. */
static ylm_status reserve(level *l) {
  if (!ylm_list_reserve(&l->corner, l->cells.n, l->cells.n + 1, &l->room, sizeof *l->corner) ||
      !ylm_list_reserve(&l->above, l->corners.n, l->corners.n + 8, &l->corner_room,
                        sizeof *l->above))
    return YLM_ENOMEM;
  return YLM_OK;
}

/* The cell of level j with that key, whose parent is `above`: made where it is not there. */
static ylm_status put_cell(level *l, const level_key *k, uint32_t above, uint32_t *number) {
  ylm_status status = reserve(l);
  size_t before = l->cells.n;
  if (status == YLM_OK) status = ylm_keys_put(&l->cells, k, sizeof *k, number);
  if (status != YLM_OK || l->cells.n == before) return status;
  for (int c = 0; c < 8 && status == YLM_OK; c++) {
    level_key at = *k;
    uint32_t corner = 0;
    for (int a = 0; a < 3; a++) at.of[a] += c >> a & 1;
    size_t corners = l->corners.n;
    status = ylm_keys_put(&l->corners, &at, sizeof at, &corner);
    if (l->corners.n > corners) l->above[corner] = above;
    l->corner[*number][c] = corner;
  }
  return status;
}

static void place_of(const levels *s, int j, const level_key *k, double beside, float out[3]) {
  for (int a = 0; a < 3; a++)
    out[a] = (float)(s->origin[a] + ((double)k->of[a] + beside) * s->level[j].edge[a]);
}

static ylm__near_lattice lattice_of(const levels *s, int j) {
  ylm__near_lattice l;
  for (int a = 0; a < 3; a++) l.origin[a] = s->origin[a], l.edge[a] = s->level[j].edge[a];
  return l;
}

/* The cells of the top level: all that have points. */
static ylm_status top_cells(levels *s) {
  ylm_status status = YLM_OK;
  for (uint32_t i = 0; i < s->finest.n && status == YLM_OK; i++) {
    level_key k = ancestor(s, i, s->top);
    status = put_cell(&s->level[s->top], &k, NONE, &s->leaf[i]);
    s->depth[i] = (uint8_t)s->top;
  }
  return status;
}

/* The cells of level j: those that `ring` reaches, of parents that have children. */
static ylm_status cells_of(levels *s, int j, const ylm_light_virtual *ring) {
  const ylm__near_lattice lattice = lattice_of(s, j);
  ylm_keys wanted = {0};
  uint32_t *which = ylm_alloc(s->finest.n, sizeof *which);
  ylm_status status = which ? YLM_OK : YLM_ENOMEM;
  for (uint32_t i = 0; i < s->finest.n && status == YLM_OK; i++) {
    if (s->depth[i] != j + 1) continue;
    level_key k = ancestor(s, i, j);
    status = ylm_keys_put(&wanted, &k, sizeof k, &which[i]);
  }
  float *at = ylm_alloc(wanted.n, 3 * sizeof *at);
  uint8_t *touched = ylm_alloc(wanted.n, 1);
  if (!at || !touched) status = YLM_ENOMEM;
  for (size_t i = 0; i < wanted.n && status == YLM_OK; i++)
    place_of(s, j, key_at(&wanted, i), 0.5, at + 3 * i);
  if (status == YLM_OK)
    status = ylm__near_touch(ring, &lattice, wanted.n, at, s->o->threads, s->o->progress, touched);
  for (uint32_t i = 0; i < s->finest.n && status == YLM_OK; i++) {
    if (s->depth[i] != j + 1 || !touched[which[i]]) continue;
    level_key k = *key_at(&wanted, which[i]);
    status = put_cell(&s->level[j], &k, s->leaf[i], &s->leaf[i]);
    s->depth[i] = (uint8_t)j;
  }
  ylm_keys_free(&wanted);
  ylm_free(which);
  ylm_free(at);
  ylm_free(touched);
  return status;
}

/* -- corners -------------------------------------------------------------------------------- */

static ylm__level_cell rows_of(const levels *s, int j, uint32_t cell) {
  const level *l = &s->level[j];
  ylm__level_cell c = {.stride = s->stride};
  for (int a = 0; a < 3; a++) c.edge[a] = (float)l->edge[a];
  for (int k = 0; k < 8; k++) c.row[k] = l->rows + (size_t)l->corner[cell][k] * 4 * s->stride;
  return c;
}

static ylm_status interpolate(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const levels *s = context;
  const int j = s->of;
  const level *l = &s->level[j];
  for (size_t i = begin; i < end; i++) {
    const uint32_t above = l->above[i];
    const level_key *own = key_at(&l->corners, i), *cell = key_at(&s->level[j + 1].cells, above);
    const ylm__level_cell c = rows_of(s, j + 1, above);
    float t[3];
    for (int a = 0; a < 3; a++) t[a] = 0.5f * (float)(own->of[a] - 2 * cell->of[a]);
    s->mix(&c, t, l->rows + i * 4 * s->stride);
  }
  return YLM_OK;
}

static ylm_status room_for_rows(const levels *s, level *l) {
  size_t numbers = 4 * s->stride;
  l->rows = ylm_alloc(l->corners.n * numbers + YLM__LEVEL_PAD, sizeof *l->rows);
  if (!l->rows) return YLM_ENOMEM;
  memset(l->rows + l->corners.n * numbers, 0, YLM__LEVEL_PAD * sizeof *l->rows);
  return YLM_OK;
}

static float *places(const levels *s, int j) {
  const level *l = &s->level[j];
  float *at = ylm_alloc(l->corners.n, 3 * sizeof *at);
  for (size_t i = 0; at && i < l->corners.n; i++)
    place_of(s, j, key_at(&l->corners, i), 0, at + 3 * i);
  return at;
}

/* Rows of level j: what is above it, and what the ring adds. */
static ylm_status rows_between(levels *s, int j, const ylm_light_virtual *ring,
                               ylm_light_virtual_levels_report *r) {
  level *l = &s->level[j];
  const ylm__near_lattice lattice = lattice_of(s, j);
  float *at = places(s, j);
  s->of = j;
  ylm_status status = at ? room_for_rows(s, l) : YLM_ENOMEM;
  if (status == YLM_OK)
    status = ylm_parallel(l->corners.n, 64, s->o->threads, interpolate, s, NULL, NULL);
  if (status == YLM_OK)
    status = ylm__near_rows(ring, &lattice, s->o->lmax, l->corners.n, at, s->o->threads,
                            s->o->progress, l->rows, s->stride, &r->far_pairs);
  ylm_free(at);
  return status;
}

/* Rows of the top level: all lights at all corners. */
static ylm_status rows_above(levels *s, const ylm_light_virtual *far,
                             ylm_light_virtual_levels_report *r, ylm_error *e) {
  level *l = &s->level[s->top];
  const size_t wide = 3 * s->count, most = l->corners.n < TOP_POINTS ? l->corners.n : TOP_POINTS;
  float *at = places(s, s->top), *value = ylm_alloc(most, 4 * wide * sizeof *value);
  ylm_status status = at && value ? room_for_rows(s, l) : YLM_ENOMEM;
  ylm_field_query q = {.lmax = s->o->lmax,
                       .channels = 3,
                       .want = YLM_WANT_VALUE | YLM_WANT_GRADIENT,
                       .metric_channels = 3,
                       .dtype = YLM_FLOAT,
                       .threads = s->o->threads,
                       .progress = s->o->progress};
  for (size_t first = 0; first < l->corners.n && status == YLM_OK; first += most) {
    size_t n = l->corners.n - first < most ? l->corners.n - first : most;
    ylm_field_result x = {.value = value, .gradient = value + most * wide};
    status = ylm_light_virtual_evaluate(far, ylm_isa_current(), &q, n, at + 3 * first, &x, e);
    r->far_pairs += x.pairs;
    for (size_t i = 0; i < n && status == YLM_OK; i++) {
      float *row = l->rows + (first + i) * 4 * s->stride;
      const float *slope = value + most * wide + i * 3 * wide;
      memset(row, 0, 4 * s->stride * sizeof *row);
      ylm_copy(row, value + i * wide, wide * sizeof *row);
      for (size_t k = 0; k < wide; k++)
        for (size_t a = 0; a < 3; a++) row[(a + 1) * s->stride + k] = slope[3 * k + a];
    }
  }
  ylm_free(at);
  ylm_free(value);
  return status;
}

/* -- points --------------------------------------------------------------------------------- */

/* Points of one cell that are looked up together. */
typedef struct chunk {
  float normal[CHUNK][3], t[3][CHUNK + YLM__LEVEL_PAD];
  uint32_t which[CHUNK], run[CHUNK], own[CHUNK]; /* own: where runs begin */
  float *cosine, *Y;                             /* [CHUNK][wide], [CHUNK][count] */
  size_t wide;
} chunk;

/* Coefficients of the clamped cosine, once for each run of points that share a normal. */
static ylm_status find_cosines(const levels *s, chunk *c, size_t n) {
  uint32_t *own = c->own;
  size_t runs = 0;
  for (size_t i = 0; i < n; i++) {
    const float *a = c->normal[i], *b = c->normal[i ? i - 1 : 0];
    bool same =
        i && fabsf(a[0] - b[0]) < ALIKE && fabsf(a[1] - b[1]) < ALIKE && fabsf(a[2] - b[2]) < ALIKE;
    if (!same) own[runs++] = (uint32_t)i;
  }
  for (size_t k = 0; k < runs; k++) {
    size_t end = k + 1 < runs ? own[k + 1] : n;
    for (size_t i = own[k]; i < end; i++) c->run[i] = (uint32_t)(end - i);
    memmove(c->normal[k], c->normal[own[k]], sizeof *c->normal);
  }
  ylm_status status =
      ylm_sh_eval(s->o->lmax, 0, false, YLM_FLOAT, runs, c->normal[0], c->Y, NULL, NULL, 1, NULL);
  for (size_t k = 0; k < runs && status == YLM_OK; k++) {
    float *to = c->cosine + own[k] * c->wide;
    memset(to, 0, c->wide * sizeof *to);
    for (int l = 0, q = 0; l <= s->o->lmax; l++) {
      const float factor = (float)ylm_sh_cosine_factor(l);
      for (int m = -l; m <= l; m++, q++) to[q] = factor * c->Y[k * s->count + (size_t)q];
    }
    size_t end = k + 1 < runs ? own[k + 1] : n;
    for (size_t i = own[k] + 1; i < end && end - own[k] < 8; i++)
      ylm_copy(c->cosine + i * c->wide, to, c->wide * sizeof *to);
  }
  return status;
}

/* Adds the far part at n points of a cell, numbers order[..]. */
static ylm_status shine_cell(const levels *s, chunk *c, uint32_t cell, const uint32_t *order,
                             size_t n) {
  const int j = s->depth[cell];
  const ylm__level_cell rows = rows_of(s, j, s->leaf[cell]);
  const level_key *k = key_at(&s->level[j].cells, s->leaf[cell]);
  double inverse[3];
  for (int a = 0; a < 3; a++) inverse[a] = 1 / s->level[j].edge[a];
  for (size_t i = 0; i < n; i++) {
    c->which[i] = order[i];
    memcpy(c->normal[i], s->normals + 3 * (size_t)order[i], sizeof *c->normal);
    for (size_t a = 0; a < 3; a++)
      c->t[a][i] =
          (float)(((double)s->points[3 * (size_t)order[i] + a] - s->origin[a]) * inverse[a] -
                  k->of[a]);
  }
  ylm_status status = find_cosines(s, c, n);
  if (status != YLM_OK) return status;
  s->shine(&rows,
           &(ylm__level_points){.n = n,
                                .count = s->count,
                                .t = {c->t[0], c->t[1], c->t[2]},
                                .cosine = c->cosine,
                                .wide = c->wide,
                                .which = c->which,
                                .run = c->run},
           s->out);
  return YLM_OK;
}

static ylm_status shine_cells(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const levels *s = context;
  chunk *c = ylm_alloc_zero(1, sizeof *c);
  ylm_status status = c ? YLM_OK : YLM_ENOMEM;
  if (c) {
    c->wide = (s->count + 15) / 16 * 16;
    c->cosine = ylm_alloc_zero(CHUNK, c->wide * sizeof *c->cosine);
    c->Y = ylm_alloc(CHUNK, s->count * sizeof *c->Y);
    if (!c->cosine || !c->Y) status = YLM_ENOMEM;
  }
  for (size_t cell = begin; cell < end && status == YLM_OK; cell++)
    for (size_t i = s->first[cell]; i < s->first[cell + 1] && status == YLM_OK; i += CHUNK) {
      size_t left = s->first[cell + 1] - i;
      status = shine_cell(s, c, (uint32_t)cell, s->order + i, left < CHUNK ? left : CHUNK);
    }
  if (c) {
    ylm_free(c->cosine);
    ylm_free(c->Y);
  }
  ylm_free(c);
  return status;
}

/* -- all ------------------------------------------------------------------------------------ */

/* A set of lights of one level; `own`: it has memory of its own. */
typedef struct tier {
  ylm_light_virtual lights;
  bool own;
} tier;

/* Lights of each level from those below; how many levels are worth it goes to s->top. */
static ylm_status merge_all(levels *s, tier *tiers, ylm_light_virtual_levels_report *r) {
  const double core = s->o->core;
  ylm_status status = YLM_OK;
  size_t cells = s->finest.n;
  for (int j = 0; status == YLM_OK; j++) {
    const ylm_light_virtual *from = j ? &tiers[j - 1].lights : s->lights;
    const double own = ldexp(core, j);
    tiers[j].own = s->o->merge > 0;
    if (tiers[j].own) status = ylm__virtual_merge(from, own * s->o->merge, own, &tiers[j].lights);
    if (status == YLM_OK && tiers[j].own && 16 * tiers[j].lights.n > WORTH * from->n) {
      ylm__virtual_merged_free(&tiers[j].lights);
      tiers[j].own = false;
    }
    if (!tiers[j].own) tiers[j].lights = *from;
    tiers[j].lights.profile = YLM_LIGHT_VIRTUAL_FAR;
    tiers[j].lights.core = own;
    tiers[j].lights.outer = 2 * own;
    tiers[j].lights.tree = NULL;
    s->level[j].core = own;
    for (int a = 0; a < 3; a++) s->level[j].edge[a] = ldexp(s->level[0].edge[a], j);
    s->top = j;
    /* corners on surfaces are fewer by about 3.5 a level */
    double corners = 2 * (double)cells * pow(0.29, j);
    if (corners * (double)tiers[j].lights.n <= TOP_PAIRS || j + 1 == LEVELS || corners < 64) break;
  }
  tiers[s->top].lights.outer = 0;
  r->merged = tiers[s->top].lights.n;
  r->cell = core * s->o->merge;
  return status;
}

static ylm_status far_part(levels *s, ylm_light_virtual_levels_report *r, ylm_error *e) {
  tier *tiers = ylm_alloc_zero(LEVELS, sizeof *tiers);
  double t = ylm_seconds();
  ylm_status status = tiers ? find_cells(s) : YLM_ENOMEM;
  if (status == YLM_OK) status = sort_points(s);
  r->seconds[0] = ylm_seconds() - t, t = ylm_seconds();
  if (status == YLM_OK) status = merge_all(s, tiers, r);
  r->seconds[1] = ylm_seconds() - t, t = ylm_seconds();
  if (status == YLM_OK) status = top_cells(s);
  if (status == YLM_OK) status = rows_above(s, &tiers[s->top].lights, r, e);
  for (int j = s->top - 1; j >= 0 && status == YLM_OK; j--) {
    status = cells_of(s, j, &tiers[j].lights);
    if (status == YLM_OK && !s->level[j].cells.n) break;
    if (status == YLM_OK) status = rows_between(s, j, &tiers[j].lights, r);
  }
  r->seconds[2] = ylm_seconds() - t, t = ylm_seconds();
  if (status == YLM_OK)
    status =
        ylm_parallel(s->finest.n, 16, s->o->threads, shine_cells, s, s->o->progress, "far lights");
  r->seconds[3] = ylm_seconds() - t;
  r->levels = s->top + 1;
  for (int j = 0; j <= s->top; j++) {
    r->corners += s->level[j].corners.n;
    r->cells += s->level[j].cells.n;
    r->bytes += s->level[j].corners.n * 4 * s->stride * sizeof(float);
    ylm_keys_free(&s->level[j].cells);
    ylm_keys_free(&s->level[j].corners);
    ylm_free(s->level[j].corner);
    ylm_free(s->level[j].above);
    ylm_free(s->level[j].rows);
    if (tiers && tiers[j].own) ylm__virtual_merged_free(&tiers[j].lights);
  }
  ylm_free(tiers);
  ylm_keys_free(&s->finest);
  ylm_free(s->at);
  ylm_free(s->leaf);
  ylm_free(s->depth);
  ylm_free(s->first);
  ylm_free(s->order);
  return status;
}

/* The lattice: its outermost planes are a little within the outermost points, which are those of a room's walls. Light bends
   there, and corners behind a wall would know nothing of it. False: the points are too far apart. */
static bool find_lattice(levels *s, double edge) {
  for (size_t a = 0; a < 3; a++) {
    float low = s->points[a], high = low;
    for (size_t i = 1; i < s->n; i++) {
      low = fminf(low, s->points[3 * i + a]);
      high = fmaxf(high, s->points[3 * i + a]);
    }
    double length = (double)high - (double)low, cells = ceil(length / edge - 0.1);
    if (!(cells < EXTENT)) return false;
    if (cells < 1) cells = 1;
    double within = length > 1e-3 * edge ? INSET * edge : 0;
    s->cells[a] = (int32_t)cells;
    s->origin[a] = (double)low + within;
    s->level[0].edge[a] = length > 1e-3 * edge ? (length - 2 * within) / cells : edge;
  }
  return true;
}

static YLM_KERNEL_CHOICE(ylm__level_mix_fn, mix_now, ylm__level_mix, NULL);
static YLM_KERNEL_CHOICE(ylm__level_shine_fn, shine_now, ylm__level_shine, NULL);

ylm_status ylm_light_virtual_irradiance(const ylm_light_virtual *lights,
                                        const ylm_light_virtual_levels *o, size_t n,
                                        const float *points, const float *normals, float *out,
                                        ylm_light_virtual_levels_report *report, ylm_error *e) {
  ylm_light_virtual_levels_report own = {0}, *r = report ? report : &own;
  *r = (ylm_light_virtual_levels_report){0};
  levels s = {.lights = lights, .o = o, .n = n, .points = points, .normals = normals, .out = out};
  size_t where;
  if (lights->profile != YLM_LIGHT_VIRTUAL_GAUSS)
    return ylm_fail(e, YLM_EINVAL, "lights of profile 'gauss' are split, and these are '%s'",
                    ylm_light_virtual_profile_name(lights->profile));
  if (o->lmax < 0 || o->lmax > YLM_LIGHT_VIRTUAL_LEVELS_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax must be 0 .. %d, got %d", YLM_LIGHT_VIRTUAL_LEVELS_LMAX,
                    o->lmax);
  for (size_t i = 0; i < lights->n; i++)
    if (!(o->core > lights->radius[i]))
      return ylm_fail(e, YLM_EDOMAIN,
                      "light %zu: core must be above the radius: core %g, radius %g", i + 1,
                      o->core, lights->radius[i]);
  if (!(o->voxel > 0 && isfinite(o->voxel) && isfinite(o->core) && o->merge >= 0 && o->merge <= 1))
    return ylm_fail(e, YLM_EDOMAIN, "voxel must be above 0, merge 0 .. 1: got %g, %g", o->voxel,
                    o->merge);
  if (!ylm_all_finite(YLM_FLOAT, points, 3 * n, &where))
    return ylm_fail(e, YLM_EDOMAIN, "point %zu is not finite", where / 3 + 1);
  if (!n || !lights->n) return YLM_OK;
  s.count = ylm_sh_count(o->lmax);
  s.stride = (3 * s.count + 15) / 16 * 16;
  s.mix = mix_now(), s.shine = shine_now();
  const bool vectors = s.mix;
  ylm_light_virtual near = *lights;
  near.profile = YLM_LIGHT_VIRTUAL_NEAR;
  near.core = vectors ? o->core : INFINITY; /* without kernels lights are near everywhere */
  double t = ylm_seconds();
  ylm_status status = YLM_OK;
  if (o->near)
    status = ylm_light_virtual_near_irradiance(&near, o->lmax, n, points, normals, o->threads,
                                               o->progress, out, &r->pairs, e);
  r->seconds[4] = ylm_seconds() - t;
  if (status != YLM_OK || !o->far || !vectors) return status;
  if (!find_lattice(&s, o->core * o->voxel))
    return ylm_fail(e, YLM_ERANGE, "levels: points are too far apart for voxels of %g",
                    o->core * o->voxel);
  status = far_part(&s, r, e);
  if (status != YLM_OK) return ylm_fail_plain(e, status);
  if (!ylm_all_finite(YLM_FLOAT, out, 3 * n, &where))
    return ylm_fail(e, YLM_ERANGE, "the light at point %zu is beyond the range of float",
                    where / 3 + 1);
  return YLM_OK;
}
