/*
** packet.h - the sum over a tree of lights at a packet of points, for the unit's element type. The
** packet walks down the tree together, and lights that are far from all of it are summed with lanes
** that are points (crowd.h). From nodes that are smaller than the packet and too near, each point
** walks on alone, with lanes that are lights (alone.h). A first walk, the pilot's, finds the scales
** that errors refer to.
*/
#ifndef YLM_LIGHT_TREE_PACKET_H
#define YLM_LIGHT_TREE_PACKET_H

#include "far.h"

typedef struct packet {
  size_t n, to[YLM__PACKET]; /* points, and which they are */
  real x[YLM__PACKET][3];
  seen_from from[YLM__PACKET], whole; /* each point, and all of them */
  bool together;
} packet;

/* Scratch of one worker beside what sums and scales need. */
typedef struct tree_work {
  uint64_t pairs; /* first: the caller reads it */
  tree_walk walk;
  lone_point alone;
  crowd crowd;
  far_field far[LEVELS], *shared; /* of blocks in blocks; what a packet is in, or NULL */
  work main, pilot;
  packet *packet; /* of a block */
  vreal xyz[VECTORS][3], c[VECTORS][YLM__STRENGTHS][3], tail[VECTORS][YLM__TAILS];
  vmask inside[VECTORS];
} tree_work;

static ylm_status tree_work_create(const ylm__tree_plan *p, void **scratch, tree_work **out) {
  tree_work *k = scratch[0];
  const ylm__plan *sums = p->sums, *pilot = p->pilot;
  if (!k) {
    size_t n = (size_t)(sums->n_lum + 3 * sums->n_rgb), m = (size_t)pilot->n_lum;
    size_t dim = (size_t)(p->dim.n_lum + 3 * p->dim.n_rgb), most = n > m ? n : m;
    size_t W = (size_t)ylm__weight_slots(sums->q->lmax) * YLM__TILE;
    size_t stack = BROAD + (size_t)(p->tree->depth + 4) * YLM__GROUP; /* two ways down */
    size_t nodes = (p->nodes + LANES - 1) / LANES, table = nodes * n;
    size_t vectors =
        most + dim + W + VECTORS * (n + dim + m) + LEVELS * (nodes * (4 + n + dim) + table);
    size_t packets = (p->block + YLM__PACKET - 1) / YLM__PACKET;
    k = ylm_alloc_zero(1, sizeof *k + vectors * sizeof(vreal) + packets * sizeof(packet) +
                              stack * sizeof(uint32_t));
    if (!k) return YLM_ENOMEM;
    scratch[0] = k;
    vreal *at = (vreal *)(k + 1);
    k->alone.sums = at, at += most;
    k->alone.dim_sums = at, at += dim;
    k->alone.scaled = at, at += W;
    k->crowd.sums = at, at += VECTORS * n;
    k->crowd.dim_sums = at, at += VECTORS * dim;
    k->crowd.pilot_sums = at, at += VECTORS * m;
    for (int i = 0; i < LEVELS; i++) {
      crowd *c = &k->far[i].crowd;
      c->xyz = (vreal(*)[3])at, at += 3 * nodes;
      c->inside = (vmask *)at, at += nodes;
      c->sums = at, at += nodes * n;
      c->dim_sums = at, at += nodes * dim;
      k->far[i].table = (real *)at, at += table;
    }
    k->crowd.xyz = k->xyz, k->crowd.c = k->c, k->crowd.tail = k->tail;
    k->crowd.inside = k->inside;
    k->packet = (packet *)at;
    k->walk.stack = (uint32_t *)(k->packet + packets);
    k->walk.plan = p;
  }
  if (work_create(&k->main, sums, &scratch[1]) != YLM_OK) return YLM_ENOMEM;
  if (work_create(&k->pilot, pilot, &scratch[2]) != YLM_OK) return YLM_ENOMEM;
  *out = k;
  return YLM_OK;
}

/* -- scales --------------------------------------------------------------------------------- */

/* Norms of value, gradient and Hessian by the pilot's sums, in parts of the sums of the lights' own
   norms, 1/`down`: numbers about 1 in any unit. */
static void norms(const ylm__tree_plan *p, tree_work *k, const vreal down[3], vreal norm[3]) {
  static const real times[6] = {1, 2, 2, 1, 2, 1};
  const ylm__plan *q = p->pilot;
  work *w = &k->pilot;
  int lmax = q->q->lmax;
  size_t count = (size_t)(lmax + 1) * (size_t)(lmax + 1);
  for (int n = 0; n < 3; n++) norm[n] = (vreal){0};
  if (p->want[0]) apply(&q->lum.value, 0, count, w->lum, w->out);
  for (size_t i = 0; p->want[0] && i < count; i++) {
    vreal x = w->out[i] * down[0];
    norm[0] += x * x;
  }
  if (p->want[1]) apply(&q->lum.gradient, 0, 3 * count, w->lum, w->out);
  for (size_t i = 0; p->want[1] && i < 3 * count; i++) {
    vreal x = w->out[i] * down[1];
    norm[1] += x * x;
  }
  if (p->want[2]) apply(&q->lum.to_u, 0, q->lum.to_u.n, w->lum, w->u);
  if (p->want[2]) apply(&q->hessian, 0, 6 * count, w->u, w->out);
  for (size_t i = 0; p->want[2] && i < 6 * count; i++) {
    vreal x = w->out[i] * down[2];
    norm[2] += times[i % 6] * x * x;
  }
  for (int n = 0; n < 3; n++) norm[n] = vreal_sqrt(norm[n]);
}

/* The errors that a point allows, from its norms and sums of strength u^(2+k) in scene units. */
static void allow(const ylm__tree_plan *p, const double norm[3], double c[YLM__STRENGTHS][3],
                  const double tail[YLM__TAILS], seen_from *from) {
  double unit = p->tree->size * p->tree->size / p->tree->total, part[3];
  for (int k = 0; k < 3; k++, unit *= p->tree->size) {
    part[k] = p->tolerance * fmax(norm[k], 1.0 / YLM__CANCELLED);
    from->part[k] = (float)part[k];
    double share = p->share[k] * part[k] * (1 - YLM__ONE_SIGN * fmin(norm[k] * norm[k], 1));
    from->allowed[k] = (float)(share * share * unit * c[p->at[k]][k]);
    from->error[k] = (float)(part[k] * unit * c[p->at[k]][k]);
  }
  double small = YLM__SKIP * part[2] * c[p->at[2]][2];
  from->skip = INFINITY;
  for (int j = 0; p->want[2] && j < YLM__TAILS && tail[j] <= small; j++) from->skip = p->skip[j];
}

/* -- packets of points ------------------------------------------------------------------------ */

static void gather(const ylm__tree_plan *p, const size_t *order, size_t n, const real *points,
                   packet *q) {
  const ylm_light_tree *t = p->tree;
  float lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY}, d2 = 0;
  memset(q, 0, sizeof *q);
  q->n = n;
  for (size_t i = 0; i < n; i++) {
    q->to[i] = order[i];
    for (int a = 0; a < 3; a++) {
      q->x[i][a] = points[3 * order[i] + (size_t)a];
      float x = (float)(((double)q->x[i][a] - t->centre[a]) / t->size);
      q->from[i].x[a] = x;
      lo[a] = fminf(lo[a], x), hi[a] = fmaxf(hi[a], x);
    }
  }
  for (int a = 0; a < 3; a++) {
    q->whole.x[a] = lo[a] / 2 + hi[a] / 2;
    q->whole.half[a] = fmaxf(hi[a] - q->whole.x[a], q->whole.x[a] - lo[a]);
    d2 += q->whole.half[a] * q->whole.half[a];
  }
  q->whole.radius = sqrtf(d2);
  q->together = n * YLM__LONELY >= LANES;
}

/* The points that are to be summed at, lanes beside each other. */
static void attend(const packet *q, crowd *c) {
  c->vectors = (int)((q->n + LANES - 1) / LANES);
  for (int i = 0; i < c->vectors * LANES; i++)
    for (int a = 0; a < 3; a++) c->xyz[i / LANES][a][i % LANES] = q->x[(size_t)i < q->n ? i : 0][a];
  c->by.vectors = (int)((q->n + YLM_VF - 1) / YLM_VF);
  for (size_t i = 0; i < (size_t)c->by.vectors * YLM_VF; i++) {
    const seen_from *from = &q->from[i < q->n ? i : 0];
    size_t v = i / YLM_VF, lane = i % YLM_VF;
    for (int a = 0; a < 3; a++) c->by.x[v][a][lane] = from->x[a];
    for (int j = 0; j < 3; j++) c->by.allowed[v][j][lane] = from->allowed[j];
    c->by.radius[v][lane] = from->radius;
    c->by.skip[v][lane] = from->skip;
  }
}

/* The packet's walk, from what its block left to it: leaves its points groups to walk on from. */
static void begin_together(tree_work *k, const packet *q, work *w) {
  static const uint32_t root = 1;
  tree_walk *walk = &k->walk;
  seen_from whole = q->whole;
  const far_field *shared = whole.pilot ? NULL : k->shared;
  const uint32_t *start = shared ? shared->start : &root;
  walk->n_left = shared ? shared->n_start : 1;
  memcpy(walk->left, start, walk->n_left * sizeof *start);
  if (!q->together) return;
  walk_from(walk, start, walk->n_left);
  walk->n_left = walk->lights_left = 0;
  k->pairs += q->n * walk_together(walk, &k->crowd, w, &whole);
  double fine = 0.01 / walk->plan->tolerance; /* then points alone need more of them, too */
  double left = (double)walk->lights_left, all = (double)walk->plan->tree->lights->active;
  if (left * (1 + left / all) > YLM__WORTH * (fine > 1 ? sqrt(fine) : 1)) return;
  walk_from(walk, walk->left, walk->n_left);
  walk->n_left = 0;
  whole.radius = 0; /* nothing is left */
  k->pairs += q->n * walk_together(walk, &k->crowd, w, &whole);
}

/* The i-th point walks on alone. */
static void go_on_alone(tree_work *k, packet *q, size_t i, work *w, vmask *inside) {
  walk_from(&k->walk, k->walk.left, k->walk.n_left);
  k->pairs += walk_alone(&k->walk, &k->alone, w, &q->from[i], q->x[i], inside);
}

static real total(vreal x) {
  real s = 0;
  for (int i = 0; i < LANES; i++) s += x[i];
  return s;
}

/* All points must keep the errors that one of them allows. */
static void be_strict(const seen_from *one, seen_from *all) {
  all->skip = fmaxf(all->skip, one->skip);
  for (int k = 0; k < 3; k++) {
    all->allowed[k] = fminf(all->allowed[k], one->allowed[k]);
    all->part[k] = fminf(all->part[k], one->part[k]);
    all->error[k] = fminf(all->error[k], one->error[k]);
  }
}

/* The errors that each point of a packet allows, and the strictest of them. */
static void find_scales(const ylm__tree_plan *p, tree_work *k, packet *q) {
  crowd *c = &k->crowd;
  size_t m = (size_t)p->pilot->n_lum;
  memset(c->pilot_sums, 0, VECTORS * m * sizeof(vreal));
  memset(c->c, 0, (size_t)c->vectors * sizeof *c->c);
  memset(c->tail, 0, (size_t)c->vectors * sizeof *c->tail);
  q->whole.pilot = true, q->whole.skip = INFINITY;
  begin_together(k, q, &k->pilot);
  for (size_t i = 0; k->walk.n_left && i < q->n; i++) {
    vmask unused = {0};
    vreal *sums = c->pilot_sums + i / LANES * m;
    memset(k->alone.sums, 0, m * sizeof(vreal));
    memset(k->alone.c, 0, sizeof k->alone.c);
    memset(k->alone.tail, 0, sizeof k->alone.tail);
    q->from[i].pilot = true, q->from[i].skip = INFINITY;
    go_on_alone(k, q, i, &k->pilot, &unused);
    add_lanes(k->alone.sums, m, (int)(i % LANES), sums);
    for (int s = 0; s < YLM__STRENGTHS; s++)
      for (int j = 0; j < 3; j++) c->c[i / LANES][s][j][i % LANES] += total(k->alone.c[s][j]);
    for (int j = 0; j < YLM__TAILS; j++)
      c->tail[i / LANES][j][i % LANES] += total(k->alone.tail[j]);
  }
  for (int v = 0; v < c->vectors; v++) {
    vreal down[3] = {{0}}, norm[3];
    for (int j = 0; j < 3; j++) {
      vreal sum = (real)p->norm[j] * c->c[v][p->at[0]][j];
      down[j] = keep_lanes(sum > 0, 1 / larger(sum, (vreal){0} + TINY));
    }
    memcpy(k->pilot.lum, c->pilot_sums + (size_t)v * m, m * sizeof(vreal));
    norms(p, k, down, norm);
    for (size_t i = (size_t)v * LANES, lane = 0; i < q->n && lane < LANES; i++, lane++) {
      double at[3], power[YLM__STRENGTHS][3], tail[YLM__TAILS];
      for (int j = 0; j < YLM__TAILS; j++) tail[j] = (double)c->tail[v][j][lane];
      for (int j = 0; j < 3; j++) at[j] = (double)norm[j][lane];
      for (int s = 0; s < YLM__STRENGTHS; s++)
        for (int j = 0; j < 3; j++) power[s][j] = (double)c->c[v][s][j][lane];
      allow(p, at, power, tail, &q->from[i]);
      q->from[i].pilot = false;
    }
  }
  q->whole.pilot = false, q->whole.skip = 0;
  for (int j = 0; j < 3; j++) q->whole.allowed[j] = q->whole.part[j] = q->whole.error[j] = INFINITY;
  for (size_t i = 0; i < q->n; i++) be_strict(&q->from[i], &q->whole);
}

/* Sums over lights at the points of a packet. */
static void sum_packet(const ylm__tree_plan *p, tree_work *k, packet *q) {
  crowd *c = &k->crowd;
  size_t n = (size_t)(p->sums->n_lum + 3 * p->sums->n_rgb);
  size_t dim = (size_t)(p->dim.n_lum + 3 * p->dim.n_rgb);
  memset(c->sums, 0, VECTORS * n * sizeof(vreal));
  memset(c->dim_sums, 0, VECTORS * dim * sizeof(vreal));
  memset(c->inside, 0, (size_t)c->vectors * sizeof *c->inside);
  for (int v = 0; k->shared && v < c->vectors; v++)
    interpolate(k->shared, c->xyz[v], n, c->sums + (size_t)v * n);
  begin_together(k, q, &k->main);
  for (int v = 0; v < c->vectors; v++)
    add_dim(p, c->dim_sums + (size_t)v * dim, c->sums + (size_t)v * n);
  for (size_t i = 0; k->walk.n_left && i < q->n; i++) {
    vmask inside = {0};
    memset(k->alone.sums, 0, n * sizeof(vreal));
    memset(k->alone.dim_sums, 0, dim * sizeof(vreal));
    go_on_alone(k, q, i, &k->main, &inside);
    add_dim(p, k->alone.dim_sums, k->alone.sums);
    add_lanes(k->alone.sums, n, (int)(i % LANES), c->sums + i / LANES * n);
    for (int j = 0; j < LANES; j++) c->inside[i / LANES][i % LANES] |= inside[j];
  }
}

/* Writes the results of a packet. */
static void write_packet(const ylm__tree_plan *p, tree_work *k, const packet *q,
                         ylm_field_result *r) {
  size_t n = (size_t)(p->sums->n_lum + 3 * p->sums->n_rgb);
  for (int v = 0; v < k->crowd.vectors; v++) {
    size_t done = (size_t)v * LANES;
    int lanes = q->n - done < LANES ? (int)(q->n - done) : LANES;
    memcpy(k->main.lum, k->crowd.sums + (size_t)v * n, n * sizeof(vreal));
    mix(p->sums, &k->main);
    results(p->sums, &k->main, q->to + done, lanes, r);
    if (p->sums->q->want & YLM_WANT_METRIC) metric(p->sums, &k->main, q->to + done, lanes, r);
    for (int i = 0; r->inside && i < lanes; i++)
      r->inside[q->to[done + (size_t)i]] = k->crowd.inside[v][i] != 0;
  }
}

#endif
