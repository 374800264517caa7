/*
** tree_body.h - the sum over a tree of lights for one element type, included by sum.isa.c after
** sum_body.h. Here lanes are lights: each point has its own list of lights and proxies, so that its
** result depends on nothing else. The moment kernels, which take one light for many points, see
** many lights from one: u = (y - x)/r, all of radius 1; weights of kind k are off by r^k.
*/

/* Groups on the stack that are taken several at a time. */
#define BROAD 1024

/* Lights to sum over: a whole number of tiles, and room for one more leaf. */
#define LIST (YLM__TILE * LANES > 64 ? YLM__TILE * LANES : 64)

typedef struct NAME(light_list) {
  size_t n;
  REAL field[YLM__FIELDS][LIST + YLM_VECTOR_BYTES] __attribute__((aligned(64)));
} NAME(light_list);

/* Scratch of one worker beside what sums and scales need. */
typedef struct NAME(tree_work) {
  uint64_t pairs; /* first: the caller reads it */
  NAME(light_list) near, far;
  V inverse[YLM__TILE], emission[4][YLM__TILE]; /* 1/r, and r, g, b, luminance of a tile */
  V c[YLM__STRENGTHS][3];                       /* sums of strength u^(2+k) */
  V *sums, *far_sums, *scaled;                  /* as lum and rgb of NAME(work), lanes are lights */
  uint32_t *stack;
  NAME(work) main, pilot;
} NAME(tree_work);

static ylm_status NAME(tree_work_create)(const ylm__tree_plan *p, void **scratch,
                                         NAME(tree_work) * *out) {
  NAME(tree_work) *k = scratch[0];
  const ylm__plan *sums = p->sums, *pilot = p->pilot;
  int lmax = sums->q->lmax;
  if (!k) {
    size_t n = (size_t)(sums->n_lum + 3 * sums->n_rgb), m = (size_t)pilot->n_lum;
    size_t W = (size_t)ylm__weight_slots(lmax) * YLM__TILE;
    size_t stack = BROAD + (size_t)(p->tree->depth + 2) * YLM__GROUP;
    k = ylm_alloc_zero(1, sizeof *k + (2 * n + m + W) * sizeof(V) + stack * sizeof(uint32_t));
    if (!k) return YLM_ENOMEM;
    scratch[0] = k;
    k->sums = (V *)(k + 1);
    k->far_sums = k->sums + (n > m ? n : m);
    k->scaled = k->far_sums + n;
    k->stack = (uint32_t *)(k->scaled + W);
  }
  if (NAME(work_create)(&k->main, sums, &scratch[1]) != YLM_OK) return YLM_ENOMEM;
  if (NAME(work_create)(&k->pilot, pilot, &scratch[2]) != YLM_OK) return YLM_ENOMEM;
  *out = k;
  return YLM_OK;
}

/* -- sums over a list --------------------------------------------------------------------- */

YLM_INLINE V NAME(keep_lanes)(VI mask, V a) { return (V)((VI)a & mask); }

/* Geometry and weights of up to LANES lights, the j-th vector of a tile; the pilot's sums too. */
static void NAME(prepare_lights)(const ylm__tree_plan *p, NAME(tree_work) * k,
                                 const NAME(light_list) * l, size_t i, int j, int kinds,
                                 const REAL *x, bool pilot, VI *inside) {
  static const LAMP unit = {{0, 0, 0}, 1, 1, {1, 1, 1}};
  const NAME(work) *w = pilot ? &k->pilot : &k->main;
  int lmax = p->sums->q->lmax;
  const V *f[YLM__FIELDS];
  for (int c = 0; c < YLM__FIELDS; c++) f[c] = (const V *)(l->field[c] + i);
  V v[3], r = *f[YLM__R], d2 = {0};
  for (int a = 0; a < 3; a++) v[a] = *f[YLM__X + a] - x[a], d2 += v[a] * v[a];
  V d = NAME(root)(d2);
  /* A far light may be larger and dimmer: quotients stay representable, results the same. */
  V size = NAME(larger)(NAME(larger)(r, (REAL)SMALL * d), (V){0} + TINY), inverse = 1 / size;
  V part = r * inverse;
  part *= part;
  for (int a = 0; a < 3; a++) v[a] *= -inverse;
  VI in = {0};
  p->sums->kernel->prepare(lmax, kinds, 1, &unit, false, v,
                           w->geometry + j * ylm__geometry_slots(lmax),
                           w->weights + j * ylm__weight_slots(lmax), &in);
  *inside |= in & (r > 0);
  k->inverse[j] = inverse;
  for (int c = 0; c < 4; c++) k->emission[c][j] = *f[YLM__E + c] * part;
  if (!pilot) return;
  V u = NAME(keep_lanes)(d > r, 1 / NAME(larger)(d, (V){0} + TINY)), e2 = {0};
  for (int c = 0; c < 3; c++) e2 += k->emission[c][j] * k->emission[c][j];
  V strength[YLM__STRENGTHS] = {NAME(root)(e2), NAME(size)(k->emission[3][j])};
  k->emission[3][j] = strength[p->at[0]];
  for (int s = 0; s < YLM__STRENGTHS; s++) {
    V e = strength[s] * size * size * u * u;
    for (int n = 0; n < 3; n++) k->c[s][n] += e, e *= u;
  }
}

/* The weights of `kinds` times the emission in channel c. */
static void NAME(scale_lights)(const NAME(tree_work) * k, int lmax, int kinds, int n, int c,
                               const V *w, V *out) {
  int W = ylm__weight_slots(lmax);
  int edges[4] = {0, ylm__weight_at(lmax, 1, 0), ylm__weight_at(lmax, 2, 0), W};
  for (int j = 0; j < n; j++) {
    V e = k->emission[c][j];
    for (int kind = 0; kind < 3; kind++) {
      for (int i = edges[kind]; kinds & (1 << kind) && i < edges[kind + 1]; i++)
        out[j * W + i] = e * w[j * W + i];
      e *= k->inverse[j];
    }
  }
}

/* Adds a list to sums of kinds_lum, then thrice of kinds_rgb, and empties it. */
static void NAME(sum_list)(const ylm__tree_plan *p, NAME(tree_work) * k, NAME(light_list) * l,
                           const REAL *x, bool pilot, int kinds_lum, int kinds_rgb, V *sums,
                           VI *inside) {
  const ylm__moment_kernel *kernel = p->sums->kernel;
  const NAME(work) *w = pilot ? &k->pilot : &k->main;
  int lmax = p->sums->q->lmax, all = kinds_lum | kinds_rgb;
  int n_lum = ylm__sum_count(lmax, kinds_lum), n_rgb = ylm__sum_count(lmax, kinds_rgb);
  if (all == (YLM__M1 | YLM__M2)) all = 7;
  for (size_t i = l->n; i % LANES; i++)
    for (int f = 0; f < YLM__FIELDS; f++) l->field[f][i] = f <= YLM__Z ? x[f] : 0;
  for (size_t i = 0; all && i < l->n; i += YLM__TILE * LANES) {
    size_t left = (l->n - i + LANES - 1) / LANES;
    int n = left < YLM__TILE ? (int)left : YLM__TILE;
    for (int j = 0; j < n; j++)
      NAME(prepare_lights)(p, k, l, i + (size_t)(j * LANES), j, all, x, pilot, inside);
    for (int c = 0; kinds_rgb && c < 3; c++) {
      NAME(scale_lights)(k, lmax, kinds_rgb, n, c, w->weights, k->scaled);
      kernel->sum(lmax, kinds_rgb, n, w->geometry, k->scaled, w->state, sums + n_lum + c * n_rgb);
    }
    if (kinds_lum) {
      NAME(scale_lights)(k, lmax, kinds_lum, n, 3, w->weights, k->scaled);
      kernel->sum(lmax, kinds_lum, n, w->geometry, k->scaled, w->state, sums);
    }
  }
  k->pairs += l->n;
  l->n = 0;
}

/* Sums over the lights of a vector, to lane `lane` of each. */
static void NAME(add_lanes)(const V *sums, size_t n, int lane, V *to, const uint32_t *at) {
  for (size_t i = 0; i < n; i++) {
    REAL part[LANES];
    memcpy(part, &sums[i], sizeof part);
    for (int half = LANES / 2; half > 0; half /= 2)
      for (int j = 0; j < half; j++) part[j] += part[j + half];
    ((REAL *)&to[at ? at[i] : i])[lane] += part[0];
  }
}

/* -- walking down ----------------------------------------------------------------------------- */

/* The list of near lights, or of far ones whose Hessians are not wanted, is full: sum it. */
static void NAME(flush)(const ylm__tree_plan *p, NAME(tree_work) * k, const REAL *x, bool pilot,
                        NAME(light_list) * l, VI *inside) {
  if (pilot)
    NAME(sum_list)(p, k, l, x, true, p->pilot->kinds_lum, 0, k->sums, inside);
  else if (l == &k->near)
    NAME(sum_list)(p, k, l, x, false, p->sums->kinds_lum, p->sums->kinds_rgb, k->sums, inside);
  else
    NAME(sum_list)(p, k, l, x, false, p->far_lum, p->far_rgb, k->far_sums, inside);
}

/* Appends the first n lights of a block [FIELDS][width]. */
YLM_INLINE void NAME(append)(NAME(light_list) * l, const REAL *block, const size_t width,
                             size_t n) {
  for (int f = 0; f < YLM__FIELDS; f++)
    memcpy(l->field[f] + l->n, block + (size_t)f * width, width * sizeof *block);
  l->n += n;
}

/* Appends one light for a node, of its strengths. */
static void NAME(append_whole)(const ylm_light_tree *t, NAME(light_list) * l, const ylm__group *g,
                               int k, REAL radius) {
  size_t n = l->n++;
  double per_area = radius > 0 ? t->total / ((double)radius * (double)radius) : 0;
  for (int a = 0; a < 3; a++) {
    l->field[YLM__X + a][n] = (REAL)(t->centre[a] + t->size * (double)g->at[a][k]);
    l->field[YLM__E + a][n] =
        (REAL)(0.57735026918962576 * (double)g->strength[YLM__STRENGTH_RGB][k] * per_area);
  }
  l->field[YLM__R][n] = radius;
  l->field[YLM__LUM][n] = (REAL)((double)g->strength[YLM__STRENGTH_LUM][k] * per_area);
}

/* Sums over all lights as they are seen from a point. */
static void NAME(walk)(const ylm__tree_plan *p, NAME(tree_work) * k, const seen_from *from,
                       const REAL *x, VI *inside) {
  const ylm_light_tree *t = p->tree;
  size_t top = 0;
  k->near.n = k->far.n = 0;
  k->stack[top++] = 1;
  while (top) {
    const ylm__group *g[SIDE];
    uint32_t at[SIDE];
    int32_t closed[YLM_VF], dim[YLM_VF];
    int most = top > BROAD - YLM__GROUP * SIDE ? 1 : SIDE; /* one by one the stack stays short */
    for (int i = 0; i < SIDE; i++) {
      at[i] = i < most && top ? k->stack[--top] : 0;
      g[i] = &t->group[at[i]];
    }
    test_groups(p, g, from, closed, dim);
    for (int i = 0; i < YLM_VF; i++) {
      int place = i % YLM__GROUP;
      const ylm__group *h = g[i / YLM__GROUP];
      uint32_t child = h->child[place];
      size_t node = (size_t)at[i / YLM__GROUP] * YLM__GROUP + (size_t)place;
      uint32_t few = child & YLM__IS_LEAF ? child >> YLM__COUNT_AT & 15 : UINT32_MAX;
      if (few == 0) continue;
      if (!(child & YLM__IS_LEAF) && !closed[i]) {
        k->stack[top++] = child;
        continue;
      }
      NAME(light_list) *l = dim[i] && !from->pilot ? &k->far : &k->near;
      if (closed[i] && from->pilot && few > 1)
        NAME(append_whole)(t, l, h, place, t->PROXIES[node][YLM__R][0]);
      else if (closed[i] && few > YLM__PROXIES)
        NAME(append)(l, t->PROXIES[node][0], YLM__PROXIES, YLM__PROXIES);
      else
        NAME(append)(l, t->LEAVES[child & YLM__LEAF_MASK][0], YLM__LEAF, few);
      if (l->n >= LIST) NAME(flush)(p, k, x, from->pilot, l, inside);
    }
  }
  NAME(flush)(p, k, x, from->pilot, &k->near, inside);
  if (!from->pilot) NAME(flush)(p, k, x, false, &k->far, inside);
}

/* -- scales --------------------------------------------------------------------------------- */

/* Norms of value, gradient and Hessian by the pilot's sums, in parts of the sums of the lights' own
   norms, 1/`down`: numbers about 1 in any unit. */
static void NAME(norms)(const ylm__tree_plan *p, NAME(tree_work) * k, const V down[3], V norm[3]) {
  static const REAL times[6] = {1, 2, 2, 1, 2, 1};
  const ylm__plan *q = p->pilot;
  NAME(work) *w = &k->pilot;
  int lmax = q->q->lmax;
  size_t count = (size_t)(lmax + 1) * (size_t)(lmax + 1);
  for (int n = 0; n < 3; n++) norm[n] = (V){0};
  if (p->want[0]) NAME(apply)(&q->lum.value, 0, count, w->lum, w->out);
  for (size_t i = 0; p->want[0] && i < count; i++) {
    V x = w->out[i] * down[0];
    norm[0] += x * x;
  }
  if (p->want[1]) NAME(apply)(&q->lum.gradient, 0, 3 * count, w->lum, w->out);
  for (size_t i = 0; p->want[1] && i < 3 * count; i++) {
    V x = w->out[i] * down[1];
    norm[1] += x * x;
  }
  if (p->want[2]) NAME(apply)(&q->lum.bend, 0, q->lum.bend.n, w->lum, w->bend);
  if (p->want[2]) NAME(apply)(&q->hessian, 0, 6 * count, w->bend, w->out);
  for (size_t i = 0; p->want[2] && i < 6 * count; i++) {
    V x = w->out[i] * down[2];
    norm[2] += times[i % 6] * x * x;
  }
  for (int n = 0; n < 3; n++) norm[n] = NAME(root)(norm[n]);
}

/* What errors a point allows, from those norms and from sums of strength u^(2+k) in scene units. */
static void NAME(allow)(const ylm__tree_plan *p, const double norm[3], double c[YLM__STRENGTHS][3],
                        seen_from *from) {
  double unit = p->tree->size * p->tree->size / p->tree->total, sum[3], part[3];
  for (int k = 0; k < 3; k++, unit *= p->tree->size) {
    part[k] = p->tolerance * fmax(norm[k], 1.0 / YLM__CANCELLED);
    double share = p->share[k] * part[k];
    from->allowed[k] = (float)(share * share * unit * c[p->at[k]][k]);
    sum[k] = unit * c[p->at[2]][k];
  }
  double small = YLM__SKIP * part[2] * sum[2];
  from->skip = INFINITY;
  if (p->want[2] && small > 0) from->skip = (float)fmin(sqrt(sum[0] / small), sum[1] / small);
}

static REAL NAME(total)(V x) {
  REAL s = 0;
  for (int i = 0; i < LANES; i++) s += x[i];
  return s;
}

/* -- a vector of points -------------------------------------------------------------------------
 */

/* Sums over lights at one point, to lane `lane` of the sums of main. */
static void NAME(add_point)(const ylm__tree_plan *p, NAME(tree_work) * k, seen_from *from,
                            const REAL *x, int lane, VI *inside) {
  const ylm__plan *s = p->sums;
  size_t n = (size_t)(s->n_lum + 3 * s->n_rgb), lmax = (size_t)s->q->lmax;
  size_t lum = (size_t)ylm__sum_count((int)lmax, p->far_lum);
  size_t rgb = (size_t)ylm__sum_count((int)lmax, p->far_rgb);
  memset(k->sums, 0, n * sizeof(V));
  memset(k->far_sums, 0, n * sizeof(V));
  VI in = {0};
  NAME(walk)(p, k, from, x, &in);
  NAME(add_lanes)(k->sums, n, lane, k->main.lum, NULL);
  NAME(add_lanes)(k->far_sums, lum, lane, k->main.lum, p->far_at);
  for (size_t c = 0; c < 3; c++) NAME(add_lanes)
  (k->far_sums + lum + c * rgb, rgb, lane, k->main.rgb + c * (size_t)s->n_rgb, p->far_at + lum);
  for (int i = 0; i < LANES; i++) (*inside)[lane] |= in[i];
}

ylm__tree_range TREE_RANGE;

ylm_status TREE_RANGE(const ylm__tree_plan *p, void **scratch, size_t begin, size_t end,
                      const void *points, ylm_field_result *r) {
  NAME(tree_work) * k;
  const REAL *all = points;
  const ylm_light_tree *t = p->tree;
  if (NAME(tree_work_create)(p, scratch, &k) != YLM_OK) return YLM_ENOMEM;
  size_t n = (size_t)(p->sums->n_lum + 3 * p->sums->n_rgb), m = (size_t)p->pilot->n_lum;
  for (size_t point = begin; point < end; point += LANES) {
    int lanes = end - point < LANES ? (int)(end - point) : LANES;
    seen_from from[LANES];
    double c[LANES][YLM__STRENGTHS][3];
    V down[3] = {{0}}, norm[3];
    VI inside = {0}, unused = {0};
    memset(k->pilot.lum, 0, m * sizeof(V));
    memset(k->main.lum, 0, n * sizeof(V));
    for (int i = 0; i < lanes; i++) {
      const REAL *x = all + 3 * (point + (size_t)i);
      from[i] = (seen_from){.pilot = true, .skip = INFINITY};
      for (int a = 0; a < 3; a++) from[i].x[a] = (float)(((double)x[a] - t->centre[a]) / t->size);
      memset(k->sums, 0, m * sizeof(V));
      memset(k->c, 0, sizeof k->c);
      NAME(walk)(p, k, &from[i], x, &unused);
      NAME(add_lanes)(k->sums, m, i, k->pilot.lum, NULL);
      for (int s = 0; s < YLM__STRENGTHS; s++)
        for (int j = 0; j < 3; j++) c[i][s][j] = (double)NAME(total)(k->c[s][j]);
      for (int j = 0; j < 3; j++) {
        double sum = p->norm[j] * c[i][p->at[0]][j];
        down[j][i] = sum > 0 ? (REAL)fmin(1 / sum, 1 / (double)TINY) : 0;
      }
    }
    NAME(norms)(p, k, down, norm);
    for (int i = 0; i < lanes; i++) {
      double at[3] = {(double)norm[0][i], (double)norm[1][i], (double)norm[2][i]};
      NAME(allow)(p, at, c[i], &from[i]);
      from[i].pilot = false;
      NAME(add_point)(p, k, &from[i], all + 3 * (point + (size_t)i), i, &inside);
    }
    NAME(mix)(p->sums, &k->main);
    NAME(results)(p->sums, &k->main, point, lanes, r);
    if (p->sums->q->want & YLM_WANT_METRIC) NAME(metric)(p->sums, &k->main, point, lanes, r);
    for (int i = 0; r->inside && i < lanes; i++) r->inside[point + (size_t)i] = inside[i] != 0;
  }
  return YLM_OK;
}
