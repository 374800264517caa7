/*
** crowd.h - sums over lists of lights and proxies that a packet of points shares, for one
** element type; included by body.h. Here lanes are points, as in the exact sum.
*/

/* Vectors of points in a packet, and lights to sum over: room for one more leaf. */
#define VECTORS (YLM__PACKET > LANES ? YLM__PACKET / LANES : 1)
#define CROWD (YLM__BLOCK + YLM__LEAF)

typedef struct NAME(lamp_list) {
  size_t n;
  LAMP lamp[CROWD];
} NAME(lamp_list);

/* State of a packet, or of the nodes of a block; sums are of all its vectors. */
typedef struct NAME(crowd) {
  NAME(lamp_list) near, dim;
  V (*xyz)[3], (*c)[YLM__STRENGTHS][3]; /* [vectors]; sums of strength u^(2+k), a packet's */
  V (*tail)[YLM__TAILS];                /* of u^4 beyond distances */
  VI *inside;
  seen_by by;
  int vectors;
  V *sums, *dim_sums, *pilot_sums;
} NAME(crowd);

/* Appends the first n lights of a block [FIELDS][width]. */
YLM_INLINE void NAME(append_lamps)(NAME(lamp_list) * l, const REAL *block, const size_t width,
                                   size_t n) {
  for (size_t i = 0; i < n; i++) {
    LAMP *to = &l->lamp[l->n++];
    for (size_t a = 0; a < 3; a++) {
      to->at[a] = block[(YLM__X + a) * width + i];
      to->rgb[a] = block[(YLM__E + a) * width + i];
    }
    to->radius = block[YLM__R * width + i];
    to->luminance = block[YLM__LUM * width + i];
  }
}

/* The pilot's: sums of strength u^(2+k), and lights whose luminance is their strength. */
static void NAME(add_strengths)(const ylm__tree_plan *p, NAME(crowd) * k, NAME(lamp_list) * l) {
  for (size_t i = 0; i < l->n; i++) {
    LAMP *m = &l->lamp[i];
    V e2 = (V){0} + (m->rgb[0] * m->rgb[0] + m->rgb[1] * m->rgb[1] + m->rgb[2] * m->rgb[2]);
    REAL each[YLM__STRENGTHS] = {SQRT(e2)[0], m->luminance < 0 ? -m->luminance : m->luminance};
    m->luminance = each[p->at[0]];
    for (int v = 0; v < k->vectors; v++) {
      const V *x = k->xyz[v];
      V dx = m->at[0] - x[0], dy = m->at[1] - x[1], dz = m->at[2] - x[2];
      V d = SQRT(dx * dx + dy * dy + dz * dz);
      V u = NAME(keep_lanes)(d > m->radius, 1 / NAME(larger)(d, (V){0} + TINY));
      for (int s = 0; s < YLM__STRENGTHS; s++) {
        V e = u * m->radius * (u * m->radius) * each[s];
        if (p->want[2] && s == p->at[2]) NAME(add_tail)(p, d, e * u * u, k->tail[v]);
        for (int n = 0; n < 3; n++) k->c[v][s][n] += e, e *= u;
      }
    }
  }
}

/* Adds a list to the sums of a plan for each vector of points, and empties it; how many pairs. */
static size_t NAME(sum_lamps)(const ylm__tree_plan *p, const ylm__plan *s, NAME(crowd) * k,
                              NAME(work) * w, NAME(lamp_list) * l, V *sums) {
  size_t count = (size_t)(s->n_lum + 3 * s->n_rgb), n = l->n;
  if (s == p->pilot) NAME(add_strengths)(p, k, l);
  for (int v = 0; count && n && v < k->vectors; v++, sums += count) {
    memset(w->part, 0, count * sizeof(V));
    for (size_t i = 0; i < n; i += YLM__TILE) NAME(add_tile)
    (s, w, n - i < YLM__TILE ? (int)(n - i) : YLM__TILE, &l->lamp[i], k->xyz[v], w->part,
     &k->inside[v]);
    for (size_t i = 0; i < count; i++) sums[i] += w->part[i];
  }
  l->n = 0;
  return n;
}

/* Adds what a walk noted of a kind to a list, which is summed whenever it is full. */
static size_t NAME(list_lamps)(const tree_walk *walk, NAME(crowd) * k, NAME(work) * w,
                               const ylm__plan *s, int kind, bool dim, V *to) {
  const ylm_light_tree *t = walk->plan->tree;
  const uint32_t *at = walk->notes.at[kind + (dim ? OF_DIM : 0)];
  const size_t n = walk->notes.n[kind + (dim ? OF_DIM : 0)];
  const size_t width = kind == OF_FEW ? YLM__PROXIES : YLM__MOST_PROXIES;
  NAME(lamp_list) *l = dim ? &k->dim : &k->near;
  size_t pairs = 0;
  for (size_t i = 0; i < n; i++) {
    if (kind == OF_WHOLE)
      l->lamp[l->n++] = NAME(whole)(t, at[i]);
    else
      NAME(append_lamps)
    (l, NAME(block)(t, kind, at[i]), width, kind == OF_LEAF ? at[i] >> YLM__COUNT_AT & 15 : width);
    if (l->n >= YLM__BLOCK) pairs += NAME(sum_lamps)(walk->plan, s, k, w, l, to);
  }
  return pairs;
}

/* Adds sums without Hessians, [dim], to those with. */
static void NAME(add_dim)(const ylm__tree_plan *p, const V *from, V *to) {
  size_t lum = (size_t)p->dim.n_lum, rgb = (size_t)p->dim.n_rgb;
  for (size_t i = 0; i < lum; i++) to[p->dim_at[i]] += from[i];
  for (size_t c = 0; c < 3; c++)
    for (size_t i = 0; i < rgb; i++)
      to[(size_t)p->sums->n_lum + c * (size_t)p->sums->n_rgb + p->dim_at[lum + i]] +=
          from[lum + c * rgb + i];
}

/* Sums over what a walk comes to, for a packet of points or the nodes of a block; how many lights
   and proxies. */
static size_t NAME(walk_together)(tree_walk *walk, NAME(crowd) * k, NAME(work) * w,
                                  const seen_from *from) {
  const ylm__tree_plan *p = walk->plan;
  const ylm__plan *sums = from->pilot ? p->pilot : p->sums;
  V *to = from->pilot ? k->pilot_sums : k->sums;
  size_t pairs = 0;
  while (walk_on(walk, from, from->pilot ? NULL : &k->by) > 0)
    for (int kind = 0; kind < OF_DIM; kind++) {
      pairs += NAME(list_lamps)(walk, k, w, sums, kind, false, to);
      if (!from->pilot) pairs += NAME(list_lamps)(walk, k, w, &p->dim, kind, true, k->dim_sums);
    }
  pairs += NAME(sum_lamps)(p, sums, k, w, &k->near, to);
  if (!from->pilot) pairs += NAME(sum_lamps)(p, &p->dim, k, w, &k->dim, k->dim_sums);
  return pairs;
}
