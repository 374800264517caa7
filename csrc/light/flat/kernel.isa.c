/* kernel.isa.c - polygons and disks at as many points as a vector has lanes. */
#include "disk.h"
#include "ylm_sh.h"

/* Two nodes: directions, and weights over rho to the power 0, 1, 2. */
typedef struct nodes {
  v3 s[2];
  V w[3][2];
} nodes;

/* Adds two nodes to an edge's moments: all harmonics up to plan->top, m by m. */
YLM_INLINE void add_nodes(const ylm__flat_plan *plan, const int kinds, const nodes *n, V *moment) {
  int top = plan->top, stride = plan->lmax + 2;
  V re[2] = {set(1), set(1)}, im[2] = {set(0), set(0)}, z[2] = {n->s[0].z, n->s[1].z};
  for (int m = 0; m <= top; m++) {
    const double *monic = plan->monic + m * stride;
    V c[3][2], s[3][2], p[2] = {set(1), set(1)}, before[2] = {set(0), set(0)};
    for (int k = 0; k < 3; k++)
      for (int j = 0; j < 2 && kinds & 1 << k; j++)
        c[k][j] = n->w[k][j] * re[j], s[k][j] = n->w[k][j] * im[j];
    for (int l = m; l <= top; l++) {
      size_t at = (size_t)(l * (l + 1)), up = at + (size_t)m, down = at - (size_t)m;
      for (int k = 0; k < 3; k++) {
        if (!(kinds & 1 << k) || l > plan->lmax - 1 + k) continue;
        V *out = moment + plan->offset[k];
        out[up] += p[0] * c[k][0] + p[1] * c[k][1];
        if (m) out[down] += p[0] * s[k][0] + p[1] * s[k][1];
      }
      V factor = set(monic[l]);
      for (int j = 0; j < 2; j++) {
        V next = z[j] * p[j] - factor * before[j];
        before[j] = p[j];
        p[j] = next;
      }
    }
    for (int j = 0; j < 2; j++) {
      V t = re[j] * n->s[j].x - im[j] * n->s[j].y;
      im[j] = re[j] * n->s[j].y + im[j] * n->s[j].x;
      re[j] = t;
    }
  }
}

/* Numbers of the rules that lanes need; the largest count of nodes. */
YLM_INLINE int choose(const ylm__flat_plan *plan, V half, int *rule, bool *alike) {
  int most = 0;
  *alike = true;
  for (int i = 0; i < LANES; i++) {
    double need = plan->degree * half[i];
    int r = 0;
    while (r < YLM__RULES - 1 && plan->reach[r] < need) r++;
    rule[i] = r;
    *alike &= r == rule[0];
    most = most > ylm__rule_table[r].n ? most : ylm__rule_table[r].n;
  }
  return most;
}

/* Moments of the edge from v along e (of a length), which r0 and r1 are the distances of the ends
   of; the unit normal of its great circle. */
YLM_INLINE void edge_moments(const ylm__flat_plan *plan, const int kinds, v3 v, v3 w, V r0, V r1,
                             v3 e, double length, V *moment, v3 *normal) {
  arc edge = arc_of(v, w, r0, r1, e, set(length));
  *normal = edge.normal;
  int rule[LANES];
  bool alike;
  int count = choose(plan, edge.span, rule, &alike);
  for (size_t k = 0; k < plan->width; k++) moment[k] = set(0);
  for (int i = 0; i < count; i += 2) {
    nodes two;
    for (int j = 0; j < 2; j++) {
      V x = set(0), weight = set(0);
      if (alike) {
        x = set(ylm__rule_table[rule[0]].x[i + j]);
        weight = set(ylm__rule_table[rule[0]].w[i + j]);
      } else {
        for (int k = 0; k < LANES; k++) {
          x[k] = ylm__rule_table[rule[k]].x[i + j];
          weight[k] = ylm__rule_table[rule[k]].w[i + j];
        }
      }
      node at = arc_node(edge, x);
      two.s[j] = at.s;
      two.w[0][j] = edge.span * weight;
      two.w[1][j] = two.w[0][j] * at.inverse;
      two.w[2][j] = two.w[1][j] * at.inverse;
    }
    add_nodes(plan, kinds, &two, moment);
  }
}

/* One polygon seen from the lanes' points. */
typedef struct seen {
  int n;
  v3 v[YLM_POLYGON_VERTICES];
  V r[YLM_POLYGON_VERTICES];
  V sign; /* on which side of its plane */
} seen;

/* Which lanes are for the reference: on the light, edge-on, on an edge's line, far away. */
YLM_INLINE VI difficult(const ylm__flat_plan *plan, size_t light, const seen *s) {
  const ylm_polygons *p = plan->p;
  const double *vertex = p->vertices + 3 * p->first[light];
  V height = dot(s->v[0], spread(p->normal + 3 * light)), far = s->r[0];
  VI out = {0};
  for (int i = 0; i < s->n; i++) {
    const double *a = vertex + 3 * i, *b = vertex + 3 * ((i + 1) % s->n);
    v3 e = {set(b[0] - a[0]), set(b[1] - a[1]), set(b[2] - a[2])}, c = cross(s->v[i], e);
    V ee = dot(e, e);
    out |= (VI)(~(dot(c, c) > 1e-24 * ee * s->r[i] * s->r[i]) & (ee > 0));
    far = larger(far, s->r[i]);
  }
  out |= (VI) ~(absolute(height) > 1e-13 * far);
  out |= (VI) ~(p->reach[light] * (plan->lmax + 4) > plan->far * far);
  return out;
}

/* Twice the argument of the product of the triangles' complex numbers. */
YLM_INLINE V solid_angle(const double *vertex, const seen *s) {
  V re = set(1), im = set(0), r0 = s->r[0];
  for (int i = 1; i + 1 < s->n; i++) {
    const double *o = vertex, *a = vertex + 3 * i, *b = a + 3;
    double c[3], p[3] = {a[0] - o[0], a[1] - o[1], a[2] - o[2]},
                 q[3] = {b[0] - o[0], b[1] - o[1], b[2] - o[2]};
    ylm_cross3d(p, q, c);
    number z = triangle(s->v[0], s->v[i], s->v[i + 1], r0, s->r[i], s->r[i + 1],
                        scale(spread(c), s->sign));
    V next = re * z.re - im * z.im;
    im = re * z.im + im * z.re;
    re = next;
    V size = larger(absolute(re), absolute(im));
    size = ylm_vd_select(size > 0, size, set(1));
    re /= size, im /= size;
  }
  return 2 * argument(re, im);
}

/* Adds a polygon to sums [channels][3 width + 1]; lanes of `out` have no part in it. */
YLM_INLINE void add_polygon(const ylm__flat_plan *plan, const int kinds, size_t light, v3 x,
                            VI *out, V *moment, V *one, V *sum) {
  const ylm_polygons *p = plan->p;
  const double *vertex = p->vertices + 3 * p->first[light],
               *e = plan->radiance + light * (size_t)plan->channels;
  size_t width = plan->width, row = 3 * width + 1;
  seen s;
  memset(&s.v[0], 0, sizeof s.v[0]);
  memset(&s.r[0], 0, sizeof s.r[0]);
  s.n = p->sides[light];
  for (int pass = 0; pass < 2; pass++) {
    for (int i = 0; i < s.n; i++) {
      v3 at = spread(vertex + 3 * i);
      s.v[i] = (v3){at.x - x.x, at.y - x.y, at.z - x.z};
      s.r[i] = ylm_vd_sqrt(dot(s.v[i], s.v[i]));
    }
    if (pass) break;
    *out = difficult(plan, light, &s);
    if (!any(*out)) break;
    /* what these lanes compute is thrown away: somewhere harmless */
    const double *c = p->centroid + 3 * light, *n = p->normal + 3 * light;
    double away = p->reach[light];
    x.x = ylm_vd_select(*out, set(c[0] + away * n[0]), x.x);
    x.y = ylm_vd_select(*out, set(c[1] + away * n[1]), x.y);
    x.z = ylm_vd_select(*out, set(c[2] + away * n[2]), x.z);
  }
  s.sign = ylm_vd_select(dot(s.v[0], spread(p->normal + 3 * light)) < 0, set(-1), set(1));
  V on = ylm_vd_select(*out, set(0), set(1)), sign = s.sign * on;
  V *to = plan->channels == 1 ? sum : one;
  if (plan->channels == 1)
    sign *= e[0], on *= e[0];
  else
    for (size_t k = 0; k < row; k++) one[k] = set(0);
  to[3 * width] += on * solid_angle(vertex, &s);
  for (int i = 0; i < s.n && plan->top >= 0; i++) {
    int j = i + 1 < s.n ? i + 1 : 0;
    const double *a = vertex + 3 * i, *b = vertex + 3 * j;
    double d[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, length = sqrt(ylm_dot3d(d, d));
    if (!(length > 0)) continue;
    v3 normal;
    edge_moments(plan, kinds, s.v[i], s.v[j], s.r[i], s.r[j], spread(d), length, moment, &normal);
    V n[3] = {normal.x * sign, normal.y * sign, normal.z * sign};
    for (int q = 0; q < 3; q++)
      for (size_t k = 0; k < width; k++) to[(size_t)q * width + k] += n[q] * moment[k];
  }
  for (size_t c = 0; c < 3 && plan->channels == 3; c++)
    for (size_t k = 0; k < row; k++) sum[c * row + k] += e[c] * one[k];
}

/* On which side of each polygon the lanes' points are: -1, 1, or 0 where it is seen edge-on. Returns the lanes that
   are for the reference: far away, or near a polygon in its plane. */
YLM_INLINE VI sides_of(const ylm__flat_plan *plan, v3 x, V *side) {
  const ylm_polygons *p = plan->p;
  VI out = {0};
  for (size_t f = 0; f < p->n; f++) {
    const double *vertex = p->vertices + 3 * p->first[f];
    v3 n = spread(p->normal + 3 * f), c = spread(p->centroid + 3 * f);
    V height = set(0), far2 = set(0), reach = set(p->reach[f]);
    for (int i = 0; i < p->sides[f]; i++) {
      v3 at = spread(vertex + 3 * i), v = {at.x - x.x, at.y - x.y, at.z - x.z};
      if (i == 0) height = dot(v, n);
      far2 = larger(far2, dot(v, v));
    }
    V far = ylm_vd_sqrt(far2);
    v3 way = {c.x - x.x, c.y - x.y, c.z - x.z};
    VI flat = (VI) ~(absolute(height) > 1e-13 * far);
    side[f] = ylm_vd_select(flat, set(0), ylm_vd_select(height < 0, set(-1), set(1)));
    out |= flat & (VI) ~(dot(way, way) > 1.001 * reach * reach);
    out |= (VI) ~(reach * (plan->lmax + 4) > plan->far * far);
  }
  return out;
}

/* An edge seen from the lanes' points, and its share. */
typedef struct seen_edge {
  v3 v, w, e;
  V r0, r1, weight;
} seen_edge;

/* Points of the lanes in `which` become that of lane i. */
YLM_INLINE v3 put_at(v3 x, VI which, int i) {
  return (v3){ylm_vd_select(which, set(x.x[i]), x.x), ylm_vd_select(which, set(x.y[i]), x.y),
              ylm_vd_select(which, set(x.z[i]), x.z)};
}

/* The first lane that is not in `which`; LANES: there is none. */
YLM_INLINE int first_without(VI which) {
  int i = 0;
  while (i < LANES && which[i]) i++;
  return i;
}

/* false: the edge has no share in any lane. Lanes without one, whose points may lie on its line, are put elsewhere. */
YLM_INLINE bool see_edge(const ylm_polygons *p, const ylm__flat_edge *e, v3 x, const V *side,
                         seen_edge *s) {
  s->weight = side[e->left] - side[e->right];
  VI none = (VI)(s->weight == 0);
  int some = first_without(none);
  if (some == LANES) return false;
  x = put_at(x, none, some);
  v3 a = spread(p->vertices + 3 * (size_t)e->from), b = spread(p->vertices + 3 * (size_t)e->to);
  s->v = (v3){a.x - x.x, a.y - x.y, a.z - x.z};
  s->w = (v3){b.x - x.x, b.y - x.y, b.z - x.z};
  s->e = (v3){b.x - a.x, b.y - a.y, b.z - a.z};
  s->r0 = ylm_vd_sqrt(dot(s->v, s->v));
  s->r1 = ylm_vd_sqrt(dot(s->w, s->w));
  return true;
}

/* Sides of the polygons, and lanes whose points lie on the line of an edge that has a share. */
YLM_INLINE VI look(const ylm__flat_plan *plan, v3 x, V *side) {
  VI out = sides_of(plan, x, side);
  for (size_t i = 0; i < plan->p->edges; i++) {
    seen_edge s;
    if (!see_edge(plan->p, &plan->p->edge[i], x, side, &s)) continue;
    v3 c = cross(s.v, s.e);
    out |= (VI) ~(dot(c, c) > 1e-24 * dot(s.e, s.e) * s.r0 * s.r0) & (VI)(s.weight != 0);
  }
  return out;
}

/* Adds what the outline of a closed surface encloses to sums, as add_polygon; side [n]. */
YLM_INLINE void add_joined(const ylm__flat_plan *plan, const int kinds, v3 x, VI *out, V *moment,
                           V *side, V *one, V *sum) {
  const ylm_polygons *p = plan->p;
  size_t width = plan->width, row = 3 * width + 1;
  const double *e = plan->radiance;
  *out = look(plan, x, side);
  if (any(*out)) { /* these lanes compute what another one does, times 0 */
    int good = first_without(*out);
    if (good == LANES) return;
    x = put_at(x, *out, good);
    look(plan, x, side);
    for (size_t f = 0; f < p->n; f++) side[f] = ylm_vd_select(*out, set(0), side[f]);
  }
  V *to = plan->channels == 1 ? sum : one;
  V share = set(plan->channels == 1 ? e[0] : 1);
  for (size_t k = 0; k < row && plan->channels == 3; k++) one[k] = set(0);
  for (size_t f = 0; f < p->n; f++) {
    const double *vertex = p->vertices + 3 * p->first[f];
    seen s;
    s.n = p->sides[f];
    s.sign = side[f];
    for (int i = 0; i < s.n; i++) {
      v3 at = spread(vertex + 3 * i);
      s.v[i] = (v3){at.x - x.x, at.y - x.y, at.z - x.z};
      s.r[i] = ylm_vd_sqrt(dot(s.v[i], s.v[i]));
    }
    V angle = solid_angle(vertex, &s);
    to[3 * width] += share * ylm_vd_select(side[f] == 0, set(0), angle);
  }
  for (size_t i = 0; i < p->edges && plan->top >= 0; i++) {
    seen_edge s;
    v3 normal;
    if (!see_edge(p, &p->edge[i], x, side, &s)) continue;
    double length = sqrt(s.e.x[0] * s.e.x[0] + s.e.y[0] * s.e.y[0] + s.e.z[0] * s.e.z[0]);
    edge_moments(plan, kinds, s.v, s.w, s.r0, s.r1, s.e, length, moment, &normal);
    V weight = s.weight * share, n[3] = {normal.x * weight, normal.y * weight, normal.z * weight};
    for (int q = 0; q < 3; q++)
      for (size_t k = 0; k < width; k++) to[(size_t)q * width + k] += n[q] * moment[k];
  }
  for (size_t c = 0; c < 3 && plan->channels == 3; c++)
    for (size_t k = 0; k < row; k++) sum[c * row + k] += e[c] * one[k];
}

YLM_INLINE void put(double *sum, size_t step, size_t lanes, V v) {
  for (size_t i = 0; i < lanes; i++) sum[i * step] += v[i];
}

/* Results of one channel from its sums, added where lane i's begin: out + i*step. */
YLM_INLINE void finish(const ylm__flat_plan *plan, const int kinds, const V *sum, size_t lanes,
                       double *out, size_t step) {
  static const int index[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  size_t width = plan->width, count = plan->count;
  for (size_t k = 0; k < count; k++) {
    V v = k ? set(0) : sum[3 * width] * sqrt(1 / (4 * YLM_PI));
    for (size_t i = plan->value.begin[k]; i < plan->value.begin[k + 1]; i++) {
      const ylm__flat_entry *e = plan->value.entry + i;
      v += e->factor * sum[(size_t)e->axis * width + e->from];
    }
    put(out + k, step, lanes, v);
    for (size_t a = 0; a < 3 && kinds & YLM__K1; a++)
      put(out + count + 3 * k + a, step, lanes,
          plan->norm[k] * sum[a * width + plan->offset[1] + k]);
    if (!(kinds & YLM__K2)) continue;
    V h[6] = {set(0), set(0), set(0), set(0), set(0), set(0)};
    for (size_t i = plan->hessian.begin[k]; i < plan->hessian.begin[k + 1]; i++) {
      const ylm__flat_entry *e = plan->hessian.entry + i;
      for (int a = 0; a < 3; a++)
        h[index[a][e->axis]] +=
            (a == e->axis ? 1 : 0.5) * e->factor * sum[(size_t)a * width + e->from];
    }
    for (size_t q = 0; q < 6; q++) put(out + 4 * count + 6 * k + q, step, lanes, h[q]);
  }
}

YLM_INLINE ylm_status range(const ylm__flat_plan *plan, const int kinds, const ylm__contour *k,
                            size_t n, const double (*x)[3], double *sum, uint8_t *inside) {
  size_t row = 3 * plan->width + 1, wide = plan->wide, channels = (size_t)plan->channels;
  size_t joined = plan->p->edges ? plan->p->n : 0, steps = joined ? 1 : plan->p->n;
  V *moment = ylm_alloc(plan->width + row * (channels + 1) + joined, sizeof(V)),
    *one = moment ? moment + plan->width : NULL, *sums = one ? one + row : NULL,
    *side = sums ? sums + row * channels : NULL;
  ylm_status s = moment ? YLM_OK : YLM_ENOMEM;
  for (size_t begin = 0; begin < n && s == YLM_OK; begin += LANES) {
    size_t lanes = n - begin < LANES ? n - begin : LANES;
    double place[3][LANES];
    for (size_t i = 0; i < LANES; i++)
      for (int a = 0; a < 3; a++) place[a][i] = x[begin + (i < lanes ? i : 0)][a];
    v3 at = {ylm_vd_load(place[0]), ylm_vd_load(place[1]), ylm_vd_load(place[2])};
    for (size_t i = 0; i < row * channels; i++) sums[i] = set(0);
    for (size_t l = 0; l < steps && s == YLM_OK; l++) {
      VI out;
      if (joined)
        add_joined(plan, kinds, at, &out, moment, side, one, sums);
      else if (plan->p->sides[l])
        add_polygon(plan, kinds, l, at, &out, moment, one, sums);
      else
        add_disk(plan, kinds, l, at, &out, one, sums);
      for (size_t i = 0; i < lanes && s == YLM_OK; i++)
        for (size_t f = l; f < (joined ? joined : l + 1) && out[i] && s == YLM_OK; f++)
          s = ylm__polygon_add(plan->p, k, f, x[begin + i], sum + (begin + i) * 3 * wide,
                               inside + begin + i);
    }
    for (size_t c = 0; c < 3; c++) /* luminance in all three: their weights add up to one */
      finish(plan, kinds, sums + (channels == 3 ? c : 0) * row, lanes, sum + (3 * begin + c) * wide,
             3 * wide);
  }
  ylm_free(moment);
  return s;
}

ylm__flat_range YLM_KERNEL(ylm__flat_range);
ylm_status YLM_KERNEL(ylm__flat_range)(const ylm__flat_plan *plan, const ylm__contour *k, size_t n,
                                       const double (*x)[3], double *sum, uint8_t *inside) {
  switch (plan->kinds) {
  case YLM__K0: return range(plan, YLM__K0, k, n, x, sum, inside);
  case YLM__K0 | YLM__K1: return range(plan, YLM__K0 | YLM__K1, k, n, x, sum, inside);
  case YLM__K0 | YLM__K2: return range(plan, YLM__K0 | YLM__K2, k, n, x, sum, inside);
  default: return range(plan, YLM__K0 | YLM__K1 | YLM__K2, k, n, x, sum, inside);
  }
}
