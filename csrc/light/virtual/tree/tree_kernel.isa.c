/*
** tree_kernel.isa.c - the sum over a tree of virtual lights at packets of points, in float: lanes are points.
**
** The points of a packet walk down together. A node that is far from each of them is summed as its
** proxies. A node that is behind the horizon of all its lights is dropped, any other is opened. A
** first walk, the pilot's, finds the scales that errors refer to.
*/
#define YLM_REAL_IS_FLOAT
#include "../kernel.h"
#include "tree.h"

#include <string.h>

#define VECTORS (YLM__PACKET > LANES ? YLM__PACKET / LANES : 1)

/* Lights and proxies that are to be summed; rows that are made for that. */
typedef struct lamp_list {
  size_t n;
  const ylm__virtual_plan *of[VIRTUAL_LIST + YLM__MOST_PROXIES];
  const real *row[VIRTUAL_LIST + YLM__MOST_PROXIES];
  real made[VIRTUAL_LIST + YLM__MOST_PROXIES][YLM__VIRTUAL_WIDE];
} lamp_list;

/* Scratch of one worker. */
typedef struct tree_work {
  uint64_t pairs; /* first: the caller reads it */
  const ylm__virtual_tree_plan *p;
  bool pilot;
  size_t n, to[YLM__PACKET]; /* the packet's points */
  int vectors;
  vreal xyz[VECTORS][3], at[VECTORS][3]; /* in the scene, in the tree's units */
  vreal tail[VECTORS][YLM__TAILS],
      skip[VECTORS]; /* sums of strength u^4 beyond distances; one of these */
  vreal allowed[VECTORS][3], part[VECTORS][3],
      c[VECTORS][YLM__STRENGTHS][3]; /* sums of strength u^(2+k) */
  work main, scales;
  vreal *sums, *dim_sums, *pilot_sums; /* [vectors][sums] */
  float *value, *gradient, *hessian;   /* of LANES points */
  uint32_t *stack;
  lamp_list list, dim;
} tree_work;

static ylm_status tree_work_create(const ylm__virtual_tree_plan *p, void **scratch,
                                   tree_work **out) {
  tree_work *k = *out = scratch[0];
  if (k) return YLM_OK;
  const size_t count = p->lights.rows[0], main = VIRTUAL(room_of)(&p->lights),
               scales = VIRTUAL(room_of)(&p->pilot[0]);
  const size_t sums = VECTORS * p->lights.sums, pilot_sums = VECTORS * p->pilot[0].sums;
  const size_t dim_sums = VECTORS * p->dim[0].sums;
  const size_t results = LANES * 3 * 10 * count, stack = (size_t)p->tree->depth + 4;
  k = ylm_alloc_zero(1, sizeof *k + (main + scales + sums + dim_sums + pilot_sums) * sizeof(vreal) +
                            results * sizeof(float) + stack * sizeof(uint32_t));
  if (!k) return YLM_ENOMEM;
  scratch[0] = *out = k;
  vreal *at = (vreal *)(k + 1);
  k->p = p;
  VIRTUAL(work_place)(&k->main, &p->lights, at), at += main;
  VIRTUAL(work_place)(&k->scales, &p->pilot[0], at), at += scales;
  k->sums = at, at += sums;
  k->dim_sums = at, at += dim_sums;
  k->pilot_sums = at, at += pilot_sums;
  k->value = (float *)at;
  k->gradient = k->value + LANES * 3 * count;
  k->hessian = k->gradient + LANES * 9 * count;
  k->stack = (uint32_t *)(k->hessian + LANES * 18 * count);
  return YLM_OK;
}

/* -- lists ---------------------------------------------------------------------------------- */

/* Adds a list to the sums of each vector of points, and empties it. */
static void sum_list(tree_work *k, lamp_list *l) {
  const ylm__virtual_plan *plan = k->pilot       ? &k->p->pilot[0]
                                  : l == &k->dim ? &k->p->dim[0]
                                                 : &k->p->lights;
  work *w = k->pilot ? &k->scales : &k->main;
  vreal *sums = k->pilot ? k->pilot_sums : l == &k->dim ? k->dim_sums : k->sums;
  for (int v = 0; v < k->vectors && l->n; v++, sums += plan->sums) {
    memset(w->part, 0, plan->sums * sizeof *w->part);
    for (size_t i = 0; i < l->n; i++) {
      add_light(l->of[i], w, l->row[i], k->xyz[v], 0);
      if (w->held == TILE) VIRTUAL(flush)(plan, w);
    }
    VIRTUAL(flush)(plan, w);
    for (size_t s = 0; s < plan->sums; s++) sums[s] += w->part[s];
  }
  k->pairs += k->n * l->n;
  l->n = 0;
}

/* The row of a node's proxies but for place and emission. */
static void begin_row(const ylm__virtual_node *x, real *row) {
  for (int a = 0; a < 3; a++) row[YLM__VIRTUAL_NORMAL + a] = x->normal[a];
  row[YLM__VIRTUAL_SHIFT] = x->shift;
  row[YLM__VIRTUAL_RADIUS] = x->radius;
}

/* The pilot's: an emission [n][3] in one colour, whose luminance is the norm over colours, or luminance, and
   positive. */
static void find_norm(const ylm__virtual_tree_plan *p, real *e, size_t n) {
  real w[3] = {(real)YLM_LUMINANCE_R, (real)YLM_LUMINANCE_G, (real)YLM_LUMINANCE_B};
  if (p->at[0] == YLM__STRENGTH_RGB) {
    real norm = vreal_sqrt(vreal_set(e[0] * e[0] + e[1] * e[1] + e[2] * e[2]))[0];
    for (int c = 0; c < 3 && norm > 0; c++) w[c] = e[c] / norm;
  }
  if (w[0] * e[0] + w[1] * e[1] + w[2] * e[2] < 0)
    for (int c = 0; c < 3; c++) w[c] = -w[c];
  for (size_t i = 0; i < n; i++) {
    real one = w[0] * e[3 * i] + w[1] * e[3 * i + 1] + w[2] * e[3 * i + 2];
    for (int c = 0; c < 3; c++) e[3 * i + (size_t)c] = one;
  }
}

/* How much of a strength counts under a cosine. */
YLM_INLINE vreal seen_part(const ylm__virtual_tree_plan *p, vreal cosine) {
  return smaller(larger(cosine, vreal_set(0)) + p->graze, vreal_set(1));
}

/* The pilot's sums of strength u^(2+k), at squared distances d2, of lights in front. */
YLM_INLINE void add_strength(tree_work *k, int v, vreal d2, const float *strength, vreal part) {
  vreal u = inverse_root(larger(d2, vreal_set(TINY)));
  const ylm__virtual_tree_plan *p = k->p;
  for (int s = 0; s < YLM__STRENGTHS; s++) {
    vreal e = part * u * u * strength[s];
    for (int j = 0; p->dims && s == p->at[2] && j < YLM__TAILS; j++)
      k->tail[v][j] += keep_lanes(u * (p->skip[j] / (1 + p->pilot_widest)) < 1, e * u * u);
    for (int j = 0; j < 3; j++) k->c[v][s][j] += e, e *= u;
  }
}

static void list_lights(tree_work *k, const ylm__virtual_node *x, lamp_list *l) {
  const ylm__virtual_tree *t = k->p->tree;
  const ylm_light_virtual *lights = t->lights;
  for (uint32_t i = 0; i < x->lights; i++) {
    const real *row = lights->seen + t->order[x->begin + i] * lights->stride;
    l->of[l->n] = k->pilot ? &k->p->pilot[0] : l == &k->dim ? &k->p->dim[0] : &k->p->lights;
    if (k->pilot) {
      vreal d2[VECTORS];
      const real scale = (real)(1 / t->size), r = row[YLM__VIRTUAL_RADIUS] * scale;
      float one[YLM__STRENGTHS];
      real *made = l->made[l->n];
      if (lights->degree <= 2) {
        memcpy(made, row, lights->stride * sizeof *row);
        find_norm(k->p, made + YLM__VIRTUAL_EMISSION, YLM_LIGHT_VIRTUAL_NUMBERS(lights->degree));
        row = made;
      }
      for (int s = 0; s < YLM__STRENGTHS; s++) one[s] = x->strength[s] / (float)x->lights;
      for (int v = 0; v < k->vectors; v++) {
        d2[v] = vreal_set(0);
        vreal c = vreal_set(0);
        for (int a = 0; a < 3; a++) {
          vreal y = (k->xyz[v][a] - row[a]) * scale;
          d2[v] += y * y, c += y * row[YLM__VIRTUAL_NORMAL + a];
        }
        vreal cosine = c * inverse_root(larger(d2[v], vreal_set(TINY))) + row[YLM__VIRTUAL_SHIFT];
        if (row[3] == 0 && row[4] == 0 && row[5] == 0) cosine = vreal_set(1);
        add_strength(k, v, larger(d2[v], vreal_set(r * r * 0.125f)), one,
                     keep_lanes(cosine > 0, seen_part(k->p, cosine)));
      }
    }
    l->row[l->n++] = row;
  }
}

static void list_proxies(tree_work *k, const ylm__virtual_node *x, lamp_list *l) {
  const ylm__virtual_tree *t = k->p->tree;
  const ylm__virtual_plan *plans[2] = {&k->p->matte, &k->p->rich};
  const size_t n = x->degree ? 3 * YLM__VIRTUAL_RICH : 3;
  const float *p = t->proxies + x->proxies;
  if (l == &k->dim) plans[0] = &k->p->dim[1], plans[1] = &k->p->dim[2];
  for (int j = 0; j < x->many; j++, p += YLM__VIRTUAL_PLACE + n) {
    real *row = l->made[l->n];
    begin_row(x, row);
    for (int a = 0; a < 3; a++) row[a] = p[a];
    memcpy(row + YLM__VIRTUAL_EMISSION, p + YLM__VIRTUAL_PLACE, n * sizeof *p);
    l->of[l->n] = plans[x->degree ? 1 : 0];
    l->row[l->n++] = row;
  }
}

/* The pilot's: one light for a node. */
static void list_whole(tree_work *k, const ylm__virtual_node *x) {
  const ylm__virtual_tree *t = k->p->tree;
  const size_t n = x->degree ? 3 * YLM__VIRTUAL_RICH : 3;
  const float *p = t->proxies + x->proxies;
  lamp_list *l = &k->list;
  real *row = l->made[l->n], *sum = row + YLM__VIRTUAL_EMISSION;
  memset(sum, 0, n * sizeof *sum);
  begin_row(x, row);
  for (int j = 0; j < x->many; j++, p += YLM__VIRTUAL_PLACE + n)
    for (size_t i = 0; i < n; i++) sum[i] += p[YLM__VIRTUAL_PLACE + i];
  for (int a = 0; a < 3; a++) row[a] = (real)(t->centre[a] + t->size * (double)x->at[a]);
  find_norm(k->p, sum, n / 3);
  l->of[l->n] = &k->p->pilot[x->degree ? 2 : 1];
  l->row[l->n++] = row;
}

/* -- the walk ------------------------------------------------------------------------------- */

enum { OPEN, FAR_AWAY, BEHIND };

/* Whether a node is dropped, summed or opened, for all points of the packet. */
static int test_node(tree_work *k, const ylm__virtual_node *x, bool *dim) {
  const ylm__virtual_tree_plan *p = k->p;
  const real widest = k->pilot ? p->pilot_widest : p->widest;
  bool far = true, behind = x->open < 2;
  vreal d2[VECTORS], d[VECTORS] = {vreal_set(0)}, up[VECTORS];
  for (int v = 0; v < k->vectors; v++) {
    vreal y[3];
    for (int a = 0; a < 3; a++) y[a] = k->at[v][a] - x->at[a];
    d2[v] = y[0] * y[0] + y[1] * y[1] + y[2] * y[2];
    d[v] = vreal_sqrt(d2[v]);
    up[v] = y[0] * x->axis[0] + y[1] * x->axis[1] + y[2] * x->axis[2] + x->back +
            x->open * (d[v] + x->reach);
    if (x->open >= 2) up[v] = d[v];
    behind = behind && !any(up[v] > 0);
  }
  if (behind) return BEHIND;
  *dim = p->dims && !k->pilot;
  for (int v = 0; v < k->vectors && *dim; v++) *dim = !any(d[v] - x->reach <= k->skip[v]);
  for (int v = 0; v < k->vectors && far; v++) {
    vmask good = (x->reach <= widest * d[v]) & (d[v] - x->reach >= p->nearest);
    if (!any(good)) return OPEN;
    for (int j = 0; j < 3 && !k->pilot; j++) {
      if (!p->want[j] || (j == 2 && *dim)) continue;
      const int s = p->at[j];
      const float *c = p->c[j];
      vreal u = 1 / d[v], power = u * u * u;
      vreal missed = (p->flat[j] * x->flat[s] * d[v] + c[0] * x->first[s]) * d[v] +
                     c[1] * x->second[s] +
                     u * (c[2] * x->third[s] + u * (c[3] * x->fourth * x->strength[s]));
      missed *= power;
      missed *= missed * seen_part(p, up[v] * u);
      for (int i = 0; i < j; i++) missed *= u;
      good &= missed <= k->allowed[v][j] * x->strength[s];
      good &= k->part[v][j] * x->strength[s] >= p->even * x->flat[s];
      if (j == 2 && x->flat[s] > 0) {
        vreal aside = magnitude(up[v] - x->open * (d[v] + x->reach));
        good &= (aside > x->open * (d[v] + x->reach) + 2 * x->back) | (k->part[v][2] >= p->kink);
      }
    }
    far = !any(~good);
  }
  if (!far) return OPEN;
  for (int v = 0; k->pilot && x->many && v < k->vectors; v++)
    add_strength(k, v, d2[v], x->strength, keep_lanes(up[v] > 0, seen_part(p, up[v] / d[v])));
  return FAR_AWAY;
}

static void walk(tree_work *k) {
  const ylm__virtual_tree *t = k->p->tree;
  size_t top = 0;
  k->stack[top++] = 0;
  while (top) {
    const ylm__virtual_node *x = &t->node[k->stack[--top]];
    bool dim;
    const int how = test_node(k, x, &dim);
    lamp_list *l = dim ? &k->dim : &k->list;
    if (how == BEHIND) continue;
    if (how == FAR_AWAY && x->many) {
      if (k->pilot)
        list_whole(k, x);
      else
        list_proxies(k, x, l);
    } else if (!x->child) {
      list_lights(k, x, l);
    } else {
      k->stack[top++] = x->child + 1;
      k->stack[top++] = x->child;
    }
    if (l->n >= VIRTUAL_LIST) sum_list(k, l);
  }
  sum_list(k, &k->list);
  if (!k->pilot && k->p->dims) sum_list(k, &k->dim);
}

/* Adds sums without Hessians to those with, part by part of the blocks (plan.h). */
static void add_dim(const ylm__virtual_tree_plan *p, const vreal *from, vreal *to) {
  for (size_t j = 0; p->dim[0].straight && j < p->dim[0].sums; j++) to[j] += from[j];
  for (int i = 0; i < 2 && !p->dim[0].straight; i++)
    for (int part = 0; part < 5; part++) { /* value, three of the gradient, block 1 */
      const ylm__virtual_sums *a = &p->dim[0].of[i], *b = &p->lights.of[i];
      const int block = part == 4, kind = part ? 2 : 1, at = part == 4 ? 0 : part;
      if (!(a->kinds & kind)) continue;
      const size_t n = (size_t)a->channels * p->lights.rows[block];
      for (size_t j = 0; j < n; j++) to[b->at[block][at] + j] += from[a->at[block][at] + j];
    }
}

/* -- scales --------------------------------------------------------------------------------- */

/* Norms of value, gradient and Hessian by the pilot's sums, in parts of the sums of the lights' own norms,
   1/`down`. */
static void find_norms(const ylm__virtual_tree_plan *p, work *w, const vreal down[3],
                       vreal norm[3]) {
  static const real times[6] = {1, 2, 2, 1, 2, 1};
  const ylm__virtual_plan *q = &p->pilot[0];
  const size_t count = q->rows[0];
  for (int j = 0; j < 3; j++) norm[j] = vreal_set(0);
  if (p->want[0]) VIRTUAL(value_of)(q, w, 1, 0, w->out);
  for (size_t i = 0; p->want[0] && i < count; i++) {
    vreal x = w->out[i] * down[0];
    norm[0] += x * x;
  }
  if (p->want[1]) VIRTUAL(gradient_of)(q, w, 1, 0, w->out);
  for (size_t i = 0; p->want[1] && i < 3 * count; i++) {
    vreal x = w->out[i] * down[1];
    norm[1] += x * x;
  }
  if (p->want[2]) VIRTUAL(hessian_of)(q, w, 1, 0, w->out);
  for (size_t i = 0; p->want[2] && i < 6 * count; i++) {
    vreal x = w->out[i] * down[2];
    norm[2] += times[i % 6] * x * x;
  }
  for (int j = 0; j < 3; j++) norm[j] = vreal_sqrt(norm[j]);
}

/* The errors that each point of a packet allows. */
static void find_scales(tree_work *k) {
  const ylm__virtual_tree_plan *p = k->p;
  const ylm__virtual_tree *t = p->tree;
  const size_t sums = p->pilot[0].sums;
  memset(k->pilot_sums, 0, (size_t)k->vectors * sums * sizeof *k->pilot_sums);
  memset(k->c, 0, sizeof k->c);
  memset(k->tail, 0, sizeof k->tail);
  k->pilot = true;
  walk(k);
  k->pilot = false;
  for (int v = 0; v < k->vectors; v++) {
    vreal down[3], norm[3];
    double unit = t->size * t->size / t->total;
    for (int j = 0; j < 3; j++, unit *= t->size) {
      vreal sum = (real)p->norm[j] * k->c[v][p->at[j]][j];
      down[j] = keep_lanes(sum > 0, (real)unit / larger(sum, vreal_set(TINY)));
    }
    memcpy(k->scales.sum, k->pilot_sums + (size_t)v * sums, sums * sizeof *k->scales.sum);
    find_norms(p, &k->scales, down, norm);
    for (int j = 0; j < 3; j++) {
      vreal part = (real)p->tolerance * larger(norm[j] - p->margin, vreal_set(1 / p->cancelled));
      vreal share =
          (real)p->share[j] * part * (1 - p->one_sign * smaller(norm[j] * norm[j], vreal_set(1)));
      k->part[v][j] = part;
      k->allowed[v][j] = share * share * k->c[v][p->at[j]][j];
    }
    vreal small = (real)YLM__SKIP * k->part[v][2] * k->c[v][p->at[2]][2];
    vmask more = small >= 0;
    k->skip[v] = vreal_set(INFINITY);
    for (int j = 0; p->dims && j < YLM__TAILS; j++) {
      more &= k->tail[v][j] <= small;
      k->skip[v] = choose(more, vreal_set(p->skip[j]), k->skip[v]);
    }
  }
}

/* -- packets -------------------------------------------------------------------------------- */

static void gather(tree_work *k, const size_t *order, size_t n, const float *points) {
  const ylm__virtual_tree *t = k->p->tree;
  k->n = n;
  k->vectors = (int)((n + LANES - 1) / LANES);
  for (size_t i = 0; i < n; i++) k->to[i] = order[i];
  for (size_t i = 0; i < (size_t)k->vectors * LANES; i++)
    for (size_t a = 0; a < 3; a++) {
      const float x = points[3 * order[i < n ? i : 0] + a];
      k->xyz[i / LANES][a][i % LANES] = x;
      k->at[i / LANES][a][i % LANES] = (real)(((double)x - t->centre[a]) / t->size);
    }
}

/* Results of LANES points to where they belong. */
static void scatter(const tree_work *k, size_t first, int lanes, const ylm_field_result *own,
                    ylm_field_result *r) {
  const ylm_field_query *q = k->p->lights.q;
  const size_t width = (size_t)q->channels * k->p->lights.rows[0];
  const struct {
    const float *from;
    float *to;
    size_t width;
  } all[] = {{own->value, r->value, width},
             {own->gradient, r->gradient, 3 * width},
             {own->hessian, r->hessian, 6 * width},
             {own->lambda, r->lambda, 1},
             {own->norm, r->norm, 1}};
  for (size_t i = 0; i < sizeof all / sizeof *all; i++)
    for (size_t lane = 0; all[i].from && lane < (size_t)lanes; lane++)
      memcpy(all[i].to + k->to[first + lane] * all[i].width, all[i].from + lane * all[i].width,
             all[i].width * sizeof(float));
  for (size_t lane = 0; r->inside && lane < (size_t)lanes; lane++)
    r->inside[k->to[first + lane]] = 0;
}

static void sum_packet(tree_work *k, ylm_field_result *r) {
  const ylm__virtual_plan *p = &k->p->lights;
  const int want = p->q->want;
  float lambda[LANES], norm[LANES];
  ylm_field_result own = {.value = want & YLM_WANT_VALUE ? k->value : NULL,
                          .gradient = want & YLM_WANT_GRADIENT ? k->gradient : NULL,
                          .hessian = want & YLM_WANT_HESSIAN ? k->hessian : NULL};
  if (want & YLM_WANT_METRIC) {
    own.lambda = r->lambda ? lambda : NULL;
    own.norm = r->norm ? norm : NULL;
  }
  memset(k->sums, 0, (size_t)k->vectors * p->sums * sizeof *k->sums);
  memset(k->dim_sums, 0, (size_t)k->vectors * k->p->dim[0].sums * sizeof *k->sums);
  walk(k);
  for (int v = 0; v < k->vectors && k->p->dims; v++)
    add_dim(k->p, k->dim_sums + (size_t)v * k->p->dim[0].sums, k->sums + (size_t)v * p->sums);
  for (int v = 0; v < k->vectors; v++) {
    const size_t first = (size_t)v * LANES;
    const int lanes = k->n - first < LANES ? (int)(k->n - first) : LANES;
    memcpy(k->main.sum, k->sums + (size_t)v * p->sums, p->sums * sizeof *k->sums);
    VIRTUAL(mix)(p, &k->main);
    VIRTUAL(results)(p, &k->main, 0, lanes, &own);
    if (want & YLM_WANT_METRIC) VIRTUAL(metric)(p, &k->main, 0, lanes, &own);
    scatter(k, first, lanes, &own, r);
  }
}

ylm__virtual_tree_range YLM_KERNEL(ylm__virtual_tree);

ylm_status YLM_KERNEL(ylm__virtual_tree)(const ylm__virtual_tree_plan *p, void **scratch,
                                         size_t begin, size_t end, const float *points,
                                         ylm_field_result *r) {
  tree_work *k;
  if (tree_work_create(p, scratch, &k) != YLM_OK) return YLM_ENOMEM;
  const size_t *order = p->packing->order;
  for (size_t i = p->packing->block[begin]; i < p->packing->block[end]; i += YLM__PACKET) {
    const size_t left = p->packing->block[end] - i;
    gather(k, order + i, left < YLM__PACKET ? left : YLM__PACKET, points);
    find_scales(k);
    sum_packet(k, r);
  }
  return YLM_OK;
}
