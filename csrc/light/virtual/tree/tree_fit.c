/*
** tree_fit.c - the node of a tree: where its lights are, and the lights that stand for them.
**
** Places of proxies, and the part a_j of a light that goes to each, are those of sphere lights
** (../tree/proxy.c): moments of degree 0 and 1 are kept for each direction of emission. A proxy has to send
** Q_j(u) = sum over lights of a_j P(u). Where all lights have one normal and one shift, their numbers are added.
** Elsewhere max(0, s + n.u) times a polynomial of degree 2 is fitted to Q_j in 98 directions, n the
** mean normal. Of three s the one is taken that misses least: 0, the sine of the normals' spread,
** and no cosine at all.
**
** Source  docs/math.md "Many virtual lights"
*/
#include <float.h>
#include <string.h>

#include "tree.h"
#include "ylm_sh.h"

#define N YLM__VIRTUAL_PADDED
enum { RICH = YLM__VIRTUAL_RICH, CHANNELS = 3 * YLM__MOST_PROXIES };
typedef float wide __attribute__((vector_size(32)));

/* -- directions ----------------------------------------------------------------------------- */

static ylm_status find_harmonics(ylm__virtual_fit *f, int degree, const double *u) {
  const size_t wide_of = YLM_LIGHT_VIRTUAL_NUMBERS(degree);
  double *Y = ylm_alloc(YLM__VIRTUAL_DIRECTIONS * wide_of, sizeof *Y);
  f->harmonic = ylm_alloc_zero(N * wide_of, sizeof *f->harmonic);
  ylm_status s = Y && f->harmonic ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK)
    s = ylm_sh_eval(degree, 0, false, YLM_DOUBLE, YLM__VIRTUAL_DIRECTIONS, u, Y, NULL, NULL, 1,
                    NULL);
  for (size_t i = 0; s == YLM_OK && i < YLM__VIRTUAL_DIRECTIONS; i++)
    for (size_t q = 0; q < wide_of; q++) f->harmonic[q * N + i] = Y[i * wide_of + q];
  ylm_free(Y);
  return s;
}

ylm_status ylm__virtual_fit_create(ylm__virtual_fit *f, int degree) {
  double u[YLM__VIRTUAL_DIRECTIONS][3], w[YLM__VIRTUAL_DIRECTIONS];
  ylm_status s = ylm_sh_sphere_rule(7, 14, -1, 1, u[0], w);
  for (int i = 0; s == YLM_OK && i < YLM__VIRTUAL_DIRECTIONS; i++) {
    const float x = (float)u[i][0], y = (float)u[i][1], z = (float)u[i][2];
    const float form[RICH] = {1,        x, y, z, x * x - z * z, 2 * x * y, 2 * x * z, y * y - z * z,
                              2 * y * z};
    f->u[0][i] = x, f->u[1][i] = y, f->u[2][i] = z;
    f->weight[i] = (float)w[i];
    for (int k = 0; k < RICH; k++) f->form[k][i] = form[k];
  }
  return s == YLM_OK && degree > 2 ? find_harmonics(f, degree, u[0]) : s;
}

void ylm__virtual_fit_free(ylm__virtual_fit *f) {
  ylm_free(f->harmonic);
  f->harmonic = NULL;
}

static double dot(const float *a, const float *b) {
  wide sum = {0};
  for (int i = 0; i < N; i += 8) {
    wide x, y;
    memcpy(&x, a + i, sizeof x);
    memcpy(&y, b + i, sizeof y);
    sum += x * y;
  }
  double s = 0;
  for (int i = 0; i < 8; i++) s += (double)sum[i];
  return s;
}

/* max(0, shift + n.u) of all directions; 1 without a normal. */
static void clamp(const ylm__virtual_fit *f, const double n[3], double shift, float *out) {
  const float x = (float)n[0], y = (float)n[1], z = (float)n[2], s = (float)shift;
  const bool none = n[0] == 0 && n[1] == 0 && n[2] == 0;
  for (int i = 0; i < N; i++) {
    float c = s + x * f->u[0][i] + y * f->u[1][i] + z * f->u[2][i];
    out[i] = none ? 1 : c > 0 ? c : 0;
  }
}

/* -- sources -------------------------------------------------------------------------------- */

/* One that a node stands for: one of its lights, or a proxy of a child. */
typedef struct source {
  double at[3], normal[3], shift;
  int degree;
  float b[3 * RICH];   /* numbers as a proxy's, to degree 2 */
  const double *far_b; /* [3][(degree+1)^2] beyond */
} source;

static void source_of_light(const ylm_light_virtual *v, uint32_t i, source *s) {
  const float *c = v->seen + i * v->stride + YLM__VIRTUAL_EMISSION;
  const size_t numbers = YLM_LIGHT_VIRTUAL_NUMBERS(v->degree);
  memcpy(s->at, v->local + 3 * i, sizeof s->at);
  memcpy(s->normal, v->normal + 3 * i, sizeof s->normal);
  s->shift = v->shift[i];
  s->degree = v->degree == 0 ? 0 : v->degree <= 2 ? 2 : v->degree;
  s->far_b = v->emission + 3 * i * numbers;
  if (s->degree > 2) return;
  memset(s->b, 0, sizeof s->b);
  memcpy(s->b, c, 3 * numbers * sizeof *c);
}

static void source_of_proxy(const ylm__virtual_tree *t, const ylm__virtual_node *x, int j,
                            source *s) {
  const size_t numbers = x->degree ? 3 * RICH : 3;
  const float *p = t->proxies + x->proxies + (size_t)j * (YLM__VIRTUAL_PLACE + numbers);
  for (int a = 0; a < 3; a++) s->at[a] = (double)p[a], s->normal[a] = (double)x->normal[a];
  s->shift = (double)x->shift;
  s->degree = x->degree;
  s->far_b = NULL;
  memcpy(s->b, p + YLM__VIRTUAL_PLACE, numbers * sizeof *p);
}

/* How many sources a node has, and the i-th of them. */
static size_t count_sources(const ylm__virtual_tree *t, const ylm__virtual_node *node) {
  if (!node->child || node->lights <= VIRTUAL_DIRECT) return node->lights;
  size_t n = 0;
  for (int k = 0; k < 2; k++) {
    const ylm__virtual_node *x = &t->node[node->child + (uint32_t)k];
    n += x->many ? x->many : x->lights;
  }
  return n;
}

static void get_source(const ylm__virtual_tree *t, const ylm__virtual_node *node, size_t i,
                       source *s) {
  if (!node->child || node->lights <= VIRTUAL_DIRECT) {
    source_of_light(t->lights, t->order[node->begin + i], s);
    return;
  }
  const ylm__virtual_node *x = &t->node[node->child];
  size_t first = x->many ? x->many : x->lights;
  if (i >= first) i -= first, x++;
  if (x->many)
    source_of_proxy(t, x, (int)i, s);
  else
    source_of_light(t->lights, t->order[x->begin + i], s);
}

/* -- normals -------------------------------------------------------------------------------- */

/* Normals of a node's lights, by strength: their mean, of length 1 or 0, the root mean square of their
   distance from it, the largest, and the mean shift. */
typedef struct normals {
  double mean[3], spread, most, shift, most_shift, back;
  bool alike; /* one normal, one shift */
} normals;

static void find_normals(const ylm__virtual_fit *f, const ylm__virtual_node *node, const cluster *q,
                         normals *m) {
  const ylm_light_virtual *v = f->tree->lights;
  const uint32_t *order = f->tree->order + node->begin;
  double sum[3] = {0}, all = 0, first[4];
  *m = (normals){.alike = true};
  for (int a = 0; a < 3; a++) first[a] = v->normal[3 * order[0] + (uint32_t)a];
  first[3] = v->shift[order[0]];
  for (uint32_t i = 0; i < node->lights; i++) {
    const double *n = v->normal + 3 * order[i];
    const ylm__lamp_d *l = &f->lamp[order[i]];
    double w = fabs(l->luminance) * l->radius * l->radius;
    all += w;
    m->shift += w * v->shift[order[i]];
    m->most_shift = fmax(m->most_shift, v->shift[order[i]]);
    for (int a = 0; a < 3; a++) sum[a] += w * n[a], m->alike &= n[a] == first[a];
    m->alike &= v->shift[order[i]] == first[3];
  }
  double length = sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
  if (all > 0) m->shift /= all;
  for (int a = 0; a < 3; a++)
    m->mean[a] = m->alike ? first[a] : length > 1e-6 * all ? sum[a] / length : 0;
  m->back = -INFINITY;
  for (uint32_t i = 0; i < node->lights; i++) {
    const double *n = v->normal + 3 * order[i], *x = v->local + 3 * order[i];
    const ylm__lamp_d *l = &f->lamp[order[i]];
    double d2 = 0, back = 0;
    for (int a = 0; a < 3; a++) {
      d2 += (n[a] - m->mean[a]) * (n[a] - m->mean[a]);
      back += m->mean[a] * (q->at[a] - x[a]);
    }
    if (n[0] == 0 && n[1] == 0 && n[2] == 0) d2 = 4;
    m->spread += fabs(l->luminance) * l->radius * l->radius * d2;
    m->most = fmax(m->most, d2);
    m->back = fmax(m->back, back);
  }
  m->spread = all > 0 ? sqrt(m->spread / all) : 0;
  m->most = sqrt(m->most);
}

/* Moments of luminance times normals about the centroid: [3][MOMENTS]. */
static void turn_moments(const ylm__virtual_fit *f, const ylm__virtual_node *node, const cluster *q,
                         double sum[3][MOMENTS]) {
  const ylm_light_virtual *v = f->tree->lights;
  const uint32_t *order = f->tree->order + node->begin;
  memset(sum, 0, 3 * sizeof *sum);
  for (uint32_t i = 0; i < node->lights; i++) {
    const ylm__lamp_d *l = &f->lamp[order[i]];
    double x[3], r2 = l->radius * l->radius;
    for (int a = 0; a < 3; a++) x[a] = l->at[a] - q->at[a];
    for (int a = 0; a < 3; a++)
      ylm__tree_add(sum[a], l->luminance * r2 * v->normal[3 * order[i] + (uint32_t)a], x, r2);
  }
}

/* Adds to the third moments that proxies miss those of normals. */
static void miss_turns(const cluster *q, double A[3][3], basis *b, const double sum[3][MOMENTS],
                       proxies *p) {
  static const double times3[10] = {1, 3, 3, 3, 6, 3, 1, 3, 3, 1};
  double m3 = 0;
  for (int a = 0; a < 3; a++) {
    double rest[MOMENTS], power[YLM__MOST_PROXIES];
    memcpy(rest, sum[a], sizeof rest);
    ylm__tree_share(p, A, b, rest, power);
    for (int j = 0; j < p->n; j++) ylm__tree_add(rest, -power[j], p->x[j], q->radius2);
    for (int i = 0; i < 10; i++) m3 += times3[i] * rest[M3 + i] * rest[M3 + i];
  }
  for (int s = 0; s < YLM__STRENGTHS; s++) {
    double lum = q->strength[YLM__STRENGTH_LUM];
    double part = VIRTUAL_TURNED * (lum > 0 ? q->strength[s] / lum : 0);
    p->missing[s][1] = hypot(p->missing[s][1], part * sqrt(m3) / 6);
  }
}

/* -- fits ----------------------------------------------------------------------------------- */

/* Light to be sent in all directions, by proxy and colour, and by all together; luminance times places, and times
   products of two of their coordinates xx xy xz yy yz zz. */
typedef struct target {
  float of[CHANNELS][N], all[3][N], moment[9][N];
} target;

/* Adds luminance from a place about the centroid. */
static void add_place(const double *x, const float *lum, float moment[9][N]) {
  int k = 3;
  for (int a = 0; a < 3; a++) {
    const float y = (float)x[a];
    for (int i = 0; i < N; i++) moment[a][i] += y * lum[i];
    for (int b = a; b < 3; b++, k++) {
      const float yz = (float)(x[a] * x[b]);
      for (int i = 0; i < N; i++) moment[k][i] += yz * lum[i];
    }
  }
}

/* Adds a source at x about the centroid. */
static void add_source(const ylm__virtual_fit *f, const source *s, const double *x,
                       const double *share, int many, target *t) {
  float cosine[N], P[3][N];
  clamp(f, s->normal, s->shift, cosine);
  for (int c = 0; c < 3; c++) {
    float *p = P[c];
    if (s->degree == 0) {
      for (int i = 0; i < N; i++) p[i] = cosine[i] * s->b[c];
    } else if (s->degree == 2) {
      for (int i = 0; i < N; i++) p[i] = s->b[c];
      for (int k = 1; k < RICH; k++)
        for (int i = 0; i < N; i++) p[i] += s->b[3 * k + c] * f->form[k][i];
      for (int i = 0; i < N; i++) p[i] *= cosine[i];
    } else {
      const size_t n = YLM_LIGHT_VIRTUAL_NUMBERS(s->degree);
      for (int i = 0; i < N; i++) p[i] = 0;
      for (size_t k = 0; k < n; k++)
        for (int i = 0; i < N; i++)
          p[i] += (float)(s->far_b[(size_t)c * n + k] * f->harmonic[k * N + (size_t)i]);
      for (int i = 0; i < N; i++) p[i] *= cosine[i];
    }
    for (int j = 0; j < many; j++) {
      const float a = (float)share[j];
      float *to = t->of[3 * j + c];
      for (int i = 0; i < N; i++) to[i] += a * p[i];
    }
    for (int i = 0; i < N; i++) t->all[c][i] += p[i];
  }
  for (int i = 0; i < N; i++)
    P[0][i] = (float)YLM_LUMINANCE_R * P[0][i] + (float)YLM_LUMINANCE_G * P[1][i] +
              (float)YLM_LUMINANCE_B * P[2][i];
  add_place(x, P[0], t->moment);
}

/* The functions that are fitted with, and the factor of their products. */
typedef struct fitting {
  float f[RICH][N], weighed[RICH][N];
  double L[RICH][RICH];
} fitting;

static void find_fitting(const ylm__virtual_fit *f, const double n[3], double shift, fitting *g) {
  float cosine[N];
  clamp(f, n, shift, cosine);
  for (int k = 0; k < RICH; k++)
    for (int i = 0; i < N; i++) {
      g->f[k][i] = cosine[i] * f->form[k][i];
      g->weighed[k][i] = g->f[k][i] * f->weight[i];
    }
  for (int i = 0; i < RICH; i++)
    for (int j = 0; j <= i; j++) {
      double s = dot(g->f[i], g->weighed[j]);
      if (i == j) s = s * (1 + 1e-5) + 1e-12;
      for (int k = 0; k < j; k++) s -= g->L[i][k] * g->L[j][k];
      g->L[i][j] = i == j ? sqrt(fmax(s, 1e-12)) : s / g->L[j][j];
    }
}

/* The numbers whose light is nearest to that of one channel. */
static void solve(const fitting *g, const float *want, double b[RICH]) {
  for (int i = 0; i < RICH; i++) {
    double s = dot(g->weighed[i], want);
    for (int k = 0; k < i; k++) s -= g->L[i][k] * b[k];
    b[i] = s / g->L[i][i];
  }
  for (int i = RICH - 1; i >= 0; i--) {
    for (int k = i + 1; k < RICH; k++) b[i] -= g->L[k][i] * b[k];
    b[i] /= g->L[i][i];
  }
}

/* The most light that a fit misses in any direction, by kinds of strength. */
static void find_missed(const fitting *g, const target *t, double most[YLM__STRENGTHS]) {
  float rest[3][N];
  for (int c = 0; c < 3; c++) {
    double b[RICH];
    solve(g, t->all[c], b);
    memcpy(rest[c], t->all[c], sizeof rest[c]);
    for (int k = 0; k < RICH; k++)
      for (int i = 0; i < N; i++) rest[c][i] -= (float)b[k] * g->f[k][i];
  }
  most[0] = most[1] = 0;
  for (int i = 0; i < YLM__VIRTUAL_DIRECTIONS; i++) {
    double rgb[3] = {(double)rest[0][i], (double)rest[1][i], (double)rest[2][i]};
    most[YLM__STRENGTH_RGB] =
        fmax(most[YLM__STRENGTH_RGB], sqrt(rgb[0] * rgb[0] + rgb[1] * rgb[1] + rgb[2] * rgb[2]));
    most[YLM__STRENGTH_LUM] = fmax(most[YLM__STRENGTH_LUM], fabs(ylm__emission(rgb, 1, 0)));
  }
}

/* The most luminance times places, and times products of these, that proxies miss in any direction. */
static void find_missed_moments(const target *t, double most[2]) {
  static const float times2[6] = {1, 2, 2, 1, 2, 1};
  most[0] = most[1] = 0;
  for (int i = 0; i < YLM__VIRTUAL_DIRECTIONS; i++) {
    float first = 0, second = 0;
    for (int k = 0; k < 3; k++) first += t->moment[k][i] * t->moment[k][i];
    for (int k = 0; k < 6; k++) second += times2[k] * t->moment[3 + k][i] * t->moment[3 + k][i];
    most[0] = fmax(most[0], sqrt((double)first));
    most[1] = fmax(most[1], sqrt((double)second) / 2);
  }
}

/* -- nodes ---------------------------------------------------------------------------------- */

/* Rounds up, so that what is enclosed stays so. */
static float up(double x) { return nextafterf((float)x, INFINITY); }

/* The source i of a node, its place x in the cluster, and the parts of it that proxies take. */
static void share_source(const ylm__virtual_tree *t, const ylm__virtual_node *node, size_t i,
                         const cluster *q, double A[3][3], basis *b, const proxies *p, source *s,
                         double x[3], double share[YLM__MOST_PROXIES]) {
  double m[MOMENTS] = {0};
  get_source(t, node, i, s);
  for (int a = 0; a < 3; a++) x[a] = s->at[a] - q->at[a];
  ylm__tree_add(m, 1, x, 0);
  ylm__tree_share(p, A, b, m, share);
}

/* Numbers of proxies that share the sources' numbers. */
static void add_numbers(const ylm__virtual_tree *t, const ylm__virtual_node *node, const cluster *q,
                        double A[3][3], basis *b, const proxies *p, int degree,
                        double sum[YLM__MOST_PROXIES][3 * RICH]) {
  const size_t n = count_sources(t, node);
  const int numbers = degree ? 3 * RICH : 3;
  memset(sum, 0, YLM__MOST_PROXIES * sizeof *sum);
  for (size_t i = 0; i < n; i++) {
    source s;
    double share[YLM__MOST_PROXIES], x[3];
    share_source(t, node, i, q, A, b, p, &s, x, share);
    for (int j = 0; j < p->n; j++)
      for (int k = 0; k < numbers; k++) sum[j][k] += share[j] * (double)s.b[k];
  }
}

/* Numbers of proxies that are fitted; the node's normal, shift and what is missed. */
static void fit_numbers(const ylm__virtual_fit *f, ylm__virtual_node *node, const cluster *q,
                        const normals *m, double A[3][3], basis *b, const proxies *p,
                        double sum[YLM__MOST_PROXIES][3 * RICH], double flat[YLM__STRENGTHS],
                        double missed[2]) {
  const ylm__virtual_tree *t = f->tree;
  const size_t n = count_sources(t, node);
  target want;
  memset(want.of, 0, (size_t)(3 * p->n) * sizeof *want.of);
  memset(want.all, 0, sizeof want.all);
  memset(want.moment, 0, sizeof want.moment);
  for (size_t i = 0; i < n; i++) {
    source s;
    double share[YLM__MOST_PROXIES], x[3];
    share_source(t, node, i, q, A, b, p, &s, x, share);
    add_source(f, &s, x, share, p->n, &want);
  }
  static const double none[3] = {0, 0, 0};
  const double half = fmin(M_SQRT2 * m->spread, 1), sine = fmin(1, m->shift + half);
  const double shifts[3] = {m->shift, sine, 0};
  const bool directed = m->mean[0] != 0 || m->mean[1] != 0 || m->mean[2] != 0;
  fitting g, best;
  double least = INFINITY, shift = 0;
  bool has_normal = false;
  for (int k = 0; k < 3; k++) {
    double rest[YLM__STRENGTHS];
    if (k < 2 && !directed) continue;
    if (k == 0 && m->spread > 0.35) continue;
    if (k == 2 && directed && m->spread < 0.5) continue;
    find_fitting(f, k < 2 ? m->mean : none, shifts[k], &g);
    find_missed(&g, &want, rest);
    if (rest[0] >= least) continue;
    least = rest[0], best = g, shift = shifts[k], has_normal = k < 2;
    memcpy(flat, rest, sizeof rest);
  }
  for (int a = 0; a < 3; a++) node->normal[a] = has_normal ? (float)m->mean[a] : 0;
  node->shift = (float)shift;
  for (int j = 0; j < p->n; j++) {
    float lum[N] = {0};
    for (int c = 0; c < 3; c++) {
      double x[RICH];
      solve(&best, want.of[3 * j + c], x);
      for (int k = 0; k < RICH; k++) sum[j][3 * k + c] = x[k];
    }
    for (int k = 0; k < RICH; k++) {
      const float e = -(float)ylm__emission(&sum[j][3 * k], 1, 0);
      for (int i = 0; i < N; i++) lum[i] += e * best.f[k][i];
    }
    add_place(p->x[j], lum, want.moment);
  }
  find_missed_moments(&want, missed);
}

/* Adds the light that children's proxies miss. */
static void add_below(const ylm__virtual_tree *t, const ylm__virtual_node *node, double *flat) {
  if (!node->child || node->lights <= VIRTUAL_DIRECT) return;
  for (int k = 0; k < 2; k++) {
    const ylm__virtual_node *x = &t->node[node->child + (uint32_t)k];
    for (int s = 0; s < YLM__STRENGTHS; s++) flat[s] += (double)x->flat[s] * t->total;
  }
}

/* The proxies of a node of more than four lights, and what they miss. */
static double make_proxies(const ylm__virtual_fit *f, ylm__virtual_node *node, const cluster *q,
                           const normals *m, proxies *p, double flat[YLM__STRENGTHS],
                           double first[YLM__STRENGTHS], ylm__virtual_proxies out) {
  const ylm__virtual_tree *t = f->tree;
  double A[3][3], sum[YLM__MOST_PROXIES][3 * RICH], spread = 0;
  basis b;
  ylm__tree_choose(q, node->lights, A, p);
  ylm__tree_basis(p, A, &b);
  const int degree = t->lights->degree;
  const bool adds = m->alike && degree <= 2;
  node->degree = adds && degree == 0 ? 0 : 2;
  node->many = (uint8_t)p->n;
  if (adds) {
    add_numbers(t, node, q, A, &b, p, node->degree, sum);
    for (int a = 0; a < 3; a++) node->normal[a] = (float)m->mean[a];
    node->shift = (float)m->shift;
  } else {
    double missed[2];
    fit_numbers(f, node, q, m, A, &b, p, sum, flat, missed);
    for (int s = 0; s < YLM__STRENGTHS; s++) {
      const double lum = q->strength[YLM__STRENGTH_LUM], part = lum > 0 ? q->strength[s] / lum : 0;
      first[s] = part * missed[0];
      p->missing[s][0] = hypot(p->missing[s][0], part * missed[1]);
    }
    add_below(t, node, flat);
    double turned[3][MOMENTS];
    turn_moments(f, node, q, turned);
    miss_turns(q, A, &b, turned, p);
  }
  const int numbers = node->degree ? 3 * RICH : 3;
  for (int j = 0; j < p->n; j++) {
    float *to = out + j * (YLM__VIRTUAL_PLACE + numbers);
    const double *x = p->x[j];
    for (int a = 0; a < 3; a++) to[a] = (float)(q->at[a] + x[a]);
    for (int k = 0; k < numbers; k++) to[YLM__VIRTUAL_PLACE + k] = (float)sum[j][k];
    spread = fmax(spread, sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]) + sqrt(q->radius2));
  }
  return spread;
}

void ylm__virtual_fit_node(const ylm__virtual_fit *f, ylm__virtual_node *node,
                           ylm__virtual_proxies out) {
  const ylm__virtual_tree *t = f->tree;
  const double s = t->size, s2 = s * s;
  double flat[YLM__STRENGTHS] = {0}, first[YLM__STRENGTHS] = {0}, spread = 0;
  cluster q;
  normals m;
  proxies p = {.n = 0};
  ylm__tree_cluster(&q, f->lamp, t->order + node->begin, node->lights);
  find_normals(f, node, &q, &m);
  for (int a = 0; a < 3; a++) { /* places of children's proxies are float */
    const double e = 64 * (double)FLT_EPSILON * q.at[a];
    q.grain = fmax(q.grain, e * e);
  }
  if (node->lights > YLM__PROXIES) spread = make_proxies(f, node, &q, &m, &p, flat, first, out);
  q.reach = fmax(q.reach, spread);
  for (int a = 0; a < 3; a++) {
    node->at[a] = (float)((q.at[a] - t->centre[a]) / s);
    node->axis[a] = (float)m.mean[a];
  }
  node->reach = up(q.reach / s);
  node->open = m.most < 1 ? up((m.most + m.most_shift) * (1 + 1e-5) + 1e-6) : 2;
  node->back = up(m.back / s + 1e-6 * (double)node->reach);
  node->radius = (float)sqrt(q.radius2);
  for (int i = 0; i < YLM__STRENGTHS; i++) {
    node->strength[i] = (float)(q.strength[i] / t->total);
    node->flat[i] = up(flat[i] / t->total);
    node->first[i] = up(first[i] / s / t->total);
    node->second[i] = up(p.missing[i][0] / s2 / t->total);
    node->third[i] = up(p.missing[i][1] / s2 / s / t->total);
  }
  node->fourth = up(p.fourth / s2 / s2);
}
