/*
** rigid.c - a curved chart flattened as rigidly as possible.
**
** Rounds alternate: each triangle is turned to where its vertices are, and the vertices move to where the turned triangles
** want them, by least squares. Edges weigh as the cotangents of the angles opposite, which are kept above 0.
**
** Source  Liu et al. 2008, Eqs. 4 and 6
*/
#include <math.h>

#include "unwrap.h"
#include "ylm_vector.h"

#define COTANGENT_LEAST 0.02
#define COTANGENT_MOST 50

/* A triangle by itself: its edges on a plane, their weights, and its vertices. */
typedef struct piece {
  double edge[3][2], weight[3]; /* edge k from vertex k to the next */
  uint32_t vertex[3];
} piece;

typedef struct rigid {
  size_t pieces, vertices;
  piece *piece;
  double *diagonal;                          /* [vertices] */
  double (*b)[2], (*r)[2], (*p)[2], (*q)[2]; /* [vertices] right side; of the solution */
} rigid;

static void lay_out(const unwrap_surface *s, size_t t, piece *p) {
  double at[3][2] = {{0, 0}}, b[3], d[3], x[3], n[3];
  for (int a = 0; a < 3; a++) {
    x[a] = b[a] = s->point[t][1][a] - s->point[t][0][a];
    d[a] = s->point[t][2][a] - s->point[t][0][a];
  }
  ylm_unit3(x);
  ylm_cross3d(s->normal[t], x, n);
  at[1][0] = ylm_dot3d(b, x);
  at[2][0] = ylm_dot3d(d, x);
  at[2][1] = ylm_dot3d(d, n);
  for (int k = 0; k < 3; k++)
    for (int a = 0; a < 2; a++) p->edge[k][a] = at[(k + 1) % 3][a] - at[k][a];
  for (int k = 0; k < 3; k++) { /* the angle opposite of edge k: between the other two */
    const double *u = p->edge[(k + 1) % 3], *v = p->edge[(k + 2) % 3];
    double cotangent = -(u[0] * v[0] + u[1] * v[1]) / fabs(u[0] * v[1] - u[1] * v[0]);
    p->weight[k] = fmin(COTANGENT_MOST, fmax(COTANGENT_LEAST, cotangent));
  }
}

/* The right side: edges of all triangles, each turned to where its vertices are. */
static void turn_all(rigid *g, const double (*at)[2]) {
  memset(g->b, 0, g->vertices * sizeof *g->b);
  for (size_t i = 0; i < g->pieces; i++) {
    const piece *p = &g->piece[i];
    double cosine = 0, sine = 0;
    for (int k = 0; k < 3; k++) {
      const double *from = at[p->vertex[k]], *to = at[p->vertex[(k + 1) % 3]], *e = p->edge[k];
      double x = to[0] - from[0], y = to[1] - from[1];
      cosine += p->weight[k] * (e[0] * x + e[1] * y);
      sine += p->weight[k] * (e[0] * y - e[1] * x);
    }
    double length = hypot(cosine, sine);
    if (!(length > 0)) cosine = length = 1;
    cosine /= length, sine /= length;
    for (int k = 0; k < 3; k++) {
      const double *e = p->edge[k];
      double x = p->weight[k] * (cosine * e[0] - sine * e[1]),
             y = p->weight[k] * (sine * e[0] + cosine * e[1]);
      double *from = g->b[p->vertex[k]], *to = g->b[p->vertex[(k + 1) % 3]];
      from[0] -= x, from[1] -= y;
      to[0] += x, to[1] += y;
    }
  }
}

static void apply(const rigid *g, const double (*x)[2], double (*out)[2]) {
  memset(out, 0, g->vertices * sizeof *out);
  for (size_t i = 0; i < g->pieces; i++)
    for (int k = 0; k < 3; k++) {
      const piece *p = &g->piece[i];
      uint32_t from = p->vertex[k], to = p->vertex[(k + 1) % 3];
      for (int a = 0; a < 2; a++) {
        double d = p->weight[k] * (x[to][a] - x[from][a]);
        out[to][a] += d;
        out[from][a] -= d;
      }
    }
}

static double product(const rigid *g, const double (*x)[2], const double (*y)[2], bool scaled) {
  double sum = 0;
  for (size_t i = 0; i < g->vertices; i++)
    sum += (x[i][0] * y[i][0] + x[i][1] * y[i][1]) / (scaled ? g->diagonal[i] : 1);
  return sum;
}

/* Moves the vertices towards the solution, by conjugate gradients scaled by the diagonal. */
static void solve(rigid *g, double (*at)[2]) {
  apply(g, (const double(*)[2])at, g->q);
  for (size_t i = 0; i < g->vertices; i++)
    for (int a = 0; a < 2; a++) {
      g->r[i][a] = g->b[i][a] - g->q[i][a];
      g->p[i][a] = g->r[i][a] / g->diagonal[i];
    }
  double rest = product(g, (const double(*)[2])g->r, (const double(*)[2])g->r, true), first = rest;
  for (int step = 0; step < RIGID_STEPS && rest > RIGID_SMALL * RIGID_SMALL * first; step++) {
    apply(g, (const double(*)[2])g->p, g->q);
    double bend = product(g, (const double(*)[2])g->p, (const double(*)[2])g->q, false);
    if (!(bend > 0)) break;
    double length = rest / bend, before = rest;
    for (size_t i = 0; i < g->vertices; i++)
      for (int a = 0; a < 2; a++) {
        at[i][a] += length * g->p[i][a];
        g->r[i][a] -= length * g->q[i][a];
      }
    rest = product(g, (const double(*)[2])g->r, (const double(*)[2])g->r, true);
    for (size_t i = 0; i < g->vertices; i++)
      for (int a = 0; a < 2; a++)
        g->p[i][a] = g->r[i][a] / g->diagonal[i] + rest / before * g->p[i][a];
  }
}

/* Rounds until the vertices hardly move. */
static void relax(rigid *g, double (*at)[2]) {
  double first = 0;
  for (int round = 0; round < RIGID_ROUNDS; round++) {
    turn_all(g, (const double(*)[2])at);
    apply(g, (const double(*)[2])at, g->q);
    double force = 0;
    for (size_t i = 0; i < g->vertices; i++)
      for (int a = 0; a < 2; a++) force += (g->b[i][a] - g->q[i][a]) * (g->b[i][a] - g->q[i][a]);
    if (round == 0) first = force;
    if (!(force > RIGID_SMALL * RIGID_SMALL * first)) return;
    solve(g, at);
  }
}

ylm_status ylm__unwrap_rigid(const ylm_unwrap *u, const unwrap_surface *s, unwrap_chart *c) {
  size_t n = c->vertices;
  rigid g = {.pieces = c->triangles, .vertices = n};
  g.piece = ylm_alloc(c->triangles, sizeof *g.piece);
  g.diagonal = ylm_alloc_zero(n, sizeof *g.diagonal);
  g.b = ylm_alloc(n, sizeof *g.b);
  g.r = ylm_alloc(n, sizeof *g.r);
  g.p = ylm_alloc(n, sizeof *g.p);
  g.q = ylm_alloc(n, sizeof *g.q);
  bool ok = g.piece && g.diagonal && g.b && g.r && g.p && g.q;
  for (size_t i = 0; ok && i < c->triangles; i++) {
    uint32_t t = u->list[c->first + i];
    memcpy(g.piece[i].vertex, u->corner + 3 * (size_t)t, sizeof g.piece[i].vertex);
    lay_out(s, t, &g.piece[i]);
    for (int k = 0; k < 3; k++) {
      g.diagonal[g.piece[i].vertex[k]] += g.piece[i].weight[k];
      g.diagonal[g.piece[i].vertex[(k + 1) % 3]] += g.piece[i].weight[k];
    }
  }
  if (ok) relax(&g, c->flat);
  ylm_free(g.piece);
  ylm_free(g.diagonal);
  ylm_free(g.b);
  ylm_free(g.r);
  ylm_free(g.p);
  ylm_free(g.q);
  return ok ? YLM_OK : YLM_ENOMEM;
}
