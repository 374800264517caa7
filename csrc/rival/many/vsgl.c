/*
** vsgl.c - virtual spherical Gaussian lights: groups of virtual lights as one lobe of places and one of directions.
**
** A group of power P has a mean place m and a variance s^2 of places. Its lobe of directions has
** the axis x and the sharpness k:
**
**   L(w') = P/(2 pi s^2) g(w'; w, d^2/s^2) g(-w'; x, k)/A(k),   g(w; a, k) = e^(k (w.a - 1)),   A(k) = 2 pi (1 - e^(-2k))/k
**
** The product of two lobes is a lobe. Its mean of the clamped cosine is that of a normal
** distribution with the lobe's mean and variance of N.w'. A factor for wide lobes comes on top. The
** error is within 1.5 % of the largest for all sharpnesses.
**
** Source: Tokuyoshi 2015, "Virtual Spherical Gaussian Lights for Real-time Glossy Indirect Illumination"; Banerjee et al. 2005
** (sharpness from a mean direction).
*/
#include <math.h>
#include <stdlib.h>

#include "many.h"
#include "ylm_sh.h"

/* The mean direction's length of a cosine lobe, and that of the lobe that stands for it. */
#define COSINE_MEAN (2.0 / 3)
#define MATTE_LOBE 0.57493
/* The least deviation of places, in parts of the lights' extent; the greatest length of a mean direction. */
#define LEAST_WIDTH 1e-4
#define MOST_MEAN (1 - 1e-6)
#define RINGS 7
#define TURNS 14

/* A light, as groups want it. */
typedef struct item {
  double at[3], axis[3]; /* the mean direction of what it sends, as long as its lobe's */
  double power[3], weight;
  double width2; /* of its own places, per axis of its disk */
} item;

typedef struct group {
  size_t begin, end;
  double spread; /* power times the variance of places and directions along the widest axis */
  int axis;
} group;

/* -- lights ------------------------------------------------------------------------- */

/* The mean direction of the light that a light of a degree sends, by luminance. */
static void mean_direction(const ylm_light_virtual_form *f, size_t i, const float (*u)[3],
                           const float *Y, const double *part, double mean[3]) {
  size_t count = ylm_sh_count(f->degree);
  const double *b = f->emission + 3 * i * count, *n = f->normal + 3 * i;
  double all = 0;
  for (int k = 0; k < 3; k++) mean[k] = 0;
  for (size_t q = 0; q < RINGS * TURNS; q++) {
    double colour[3] = {0, 0, 0}, cosine = f->shift[i];
    for (size_t c = 0; c < 3; c++)
      for (size_t k = 0; k < count; k++) colour[c] += b[c * count + k] * (double)Y[q * count + k];
    for (int k = 0; k < 3; k++) cosine += n[k] * (double)u[q][k];
    bool turned = n[0] != 0 || n[1] != 0 || n[2] != 0;
    double weight = ylm_luminance_size(colour) * (turned ? fmax(0, cosine) : 1) * part[q / TURNS];
    for (int k = 0; k < 3; k++) mean[k] += weight * (double)u[q][k];
    all += weight;
  }
  for (int k = 0; k < 3; k++) mean[k] = all > 0 ? mean[k] / all : 0;
}

/* From the length of a mean direction to that of the lobe which stands for it: a cosine's is the matte one. */
static double lobe_length(double mean) {
  if (mean <= COSINE_MEAN) return mean / COSINE_MEAN * MATTE_LOBE;
  double over = (mean - COSINE_MEAN) / (1 - COSINE_MEAN);
  return fmin(MOST_MEAN, MATTE_LOBE + over * (1 - MATTE_LOBE));
}

/* All directions, and their solid angles. */
static ylm_status sphere_of(int degree, float (*u)[3], double *part, float *Y) {
  double z[RINGS], weight[RINGS];
  ylm_sh_gauss_legendre(RINGS, z, weight);
  for (int i = 0, k = 0; i < RINGS; i++) {
    part[i] = weight[i] * 2 * YLM_PI / TURNS;
    for (int j = 0; j < TURNS; j++, k++) {
      double turn = 2 * YLM_PI * j / TURNS, r = sqrt(1 - z[i] * z[i]);
      u[k][0] = (float)(r * cos(turn)), u[k][1] = (float)(r * sin(turn)), u[k][2] = (float)z[i];
    }
  }
  return ylm_sh_eval(degree, 0, true, YLM_FLOAT, RINGS * TURNS, u[0], Y, NULL, NULL, 1, NULL);
}

static ylm_status list_items(const ylm_light_virtual *lights, const ylm_light_virtual_form *f,
                             item *list, size_t *n) {
  float u[RINGS * TURNS][3];
  double part[RINGS];
  float *Y = ylm_alloc(RINGS * TURNS, ylm_sh_count(f->degree) * sizeof *Y);
  ylm_status s = Y ? sphere_of(f->degree, u, part, Y) : YLM_ENOMEM;
  *n = 0;
  for (size_t i = 0; s == YLM_OK && i < f->n; i++) {
    item *x = &list[*n];
    double r = f->radius ? f->radius[i] : 0, length = 0;
    ylm_light_virtual_power_one(lights, i, x->power);
    x->weight = ylm_luminance_size(x->power);
    if (!(x->weight > 0)) continue;
    x->width2 = r * r / 4;
    for (int k = 0; k < 3; k++) {
      x->at[k] = f->at[3 * i + (size_t)k];
      x->axis[k] = f->normal[3 * i + (size_t)k] * COSINE_MEAN;
    }
    if (f->degree > 0 || f->shift[i] > 0)
      mean_direction(f, i, (const float(*)[3])u, Y, part, x->axis);
    for (int k = 0; k < 3; k++) length += x->axis[k] * x->axis[k];
    length = sqrt(length);
    for (int k = 0; k < 3 && length > 0; k++) x->axis[k] *= lobe_length(length) / length;
    ++*n;
  }
  ylm_free(Y);
  return s;
}

/* -- groups ------------------------------------------------------------------------- */

static double key(const item *x, int axis, double size) {
  return axis < 3 ? x->at[axis] : size * x->axis[axis - 3];
}

/* Finds the axis of places and directions along which a group is widest. */
static void measure(const item *list, double size, group *g) {
  g->spread = 0, g->axis = 0;
  if (g->end - g->begin < 2) return;
  for (int a = 0; a < 6; a++) {
    double sum = 0, square = 0, all = 0;
    for (size_t i = g->begin; i < g->end; i++) {
      double x = key(&list[i], a, size), w = list[i].weight;
      sum += w * x, square += w * x * x, all += w;
    }
    double spread = square - sum * sum / all;
    if (spread > g->spread) g->spread = spread, g->axis = a;
  }
}

typedef struct ordered {
  double key;
  item x;
} ordered;

static int compare(const void *a, const void *b) {
  double x = ((const ordered *)a)->key, y = ((const ordered *)b)->key;
  return (x > y) - (x < y);
}

/* Parts a group where half of its power lies on either side; false: it cannot be. */
static bool part(item *list, ordered *room, double size, group *g, group *other) {
  size_t n = g->end - g->begin, at = 0;
  double all = 0, upto = 0;
  if (n < 2 || !(g->spread > 0)) return false;
  for (size_t i = 0; i < n; i++) {
    room[i] = (ordered){key(&list[g->begin + i], g->axis, size), list[g->begin + i]};
    all += room[i].x.weight;
  }
  qsort(room, n, sizeof *room, compare);
  for (size_t i = 0; i < n; i++) {
    list[g->begin + i] = room[i].x;
    upto += room[i].x.weight;
    if (upto <= all / 2) at = i + 1;
  }
  if (at == 0) at = 1;
  if (at == n) at = n - 1;
  *other = (group){.begin = g->begin + at, .end = g->end};
  g->end = g->begin + at;
  measure(list, size, g);
  measure(list, size, other);
  return true;
}

/* The widest group comes to the front of a heap. */
static void sink(group *heap, size_t n, size_t i) {
  for (;;) {
    size_t child = 2 * i + 1;
    if (child >= n) return;
    if (child + 1 < n && heap[child + 1].spread > heap[child].spread) child++;
    if (heap[child].spread <= heap[i].spread) return;
    group x = heap[i];
    heap[i] = heap[child];
    heap[i = child] = x;
  }
}

static void rise(group *heap, size_t i) {
  for (size_t up; i > 0 && heap[up = (i - 1) / 2].spread < heap[i].spread; i = up) {
    group x = heap[i];
    heap[i] = heap[up];
    heap[up] = x;
  }
}

/* Puts a group as light i: place, axis, deviation, sharpness, power over A. */
static void put(const item *list, const group *g, double least, const ylm_many_lights *l,
                size_t i) {
  double m[3] = {0}, x[3] = {0}, power[3] = {0}, square = 0, all = 0, length = 0;
  for (size_t k = g->begin; k < g->end; k++) {
    double w = list[k].weight;
    all += w;
    square += w * 2 * list[k].width2;
    for (int a = 0; a < 3; a++) {
      m[a] += w * list[k].at[a];
      square += w * list[k].at[a] * list[k].at[a];
      x[a] += w * list[k].axis[a];
      power[a] += list[k].power[a];
    }
  }
  for (int a = 0; a < 3; a++) {
    m[a] /= all, x[a] /= all;
    length += x[a] * x[a];
    square -= all * m[a] * m[a];
  }
  length = fmin(MOST_MEAN, sqrt(length));
  double sharp = length * (3 - length * length) / (1 - length * length);
  double area = sharp > 1e-6 ? 2 * YLM_PI * -expm1(-2 * sharp) / sharp : 4 * YLM_PI;
  for (int a = 0; a < 3; a++) {
    l->at[a][i] = (float)m[a];
    l->normal[a][i] = length > 0 ? (float)(x[a] / length) : 0;
    l->intensity[a][i] = (float)(power[a] / area);
  }
  l->shift[i] = (float)sharp;
  l->radius[i] = (float)fmax(sqrt(fmax(0, square / all / 2)), least);
}

static double extent(const item *list, size_t n) {
  double d2 = 0;
  for (int a = 0; a < 3; a++) {
    double low = INFINITY, high = -INFINITY;
    for (size_t i = 0; i < n; i++) {
      low = fmin(low, list[i].at[a]);
      high = fmax(high, list[i].at[a]);
    }
    if (n > 0) d2 += (high - low) * (high - low);
  }
  return sqrt(d2);
}

ylm_status ylm__many_parts(const ylm_light_virtual *lights, size_t groups, size_t *count,
                           const ylm_many_lights *out) {
  ylm_light_virtual_form f;
  ylm_light_virtual_get(lights, &f);
  item *list = ylm_alloc(f.n, sizeof *list);
  ordered *room = ylm_alloc(f.n, sizeof *room);
  group *heap = ylm_alloc(groups, sizeof *heap);
  size_t n = 0, made = 0;
  ylm_status s = list && room && heap ? list_items(lights, &f, list, &n) : YLM_ENOMEM;
  if (s == YLM_OK && n > 0) {
    double size = extent(list, n);
    heap[0] = (group){.begin = 0, .end = n};
    measure(list, size, &heap[0]);
    for (made = 1; made < groups && part(list, room, size, &heap[0], &heap[made]); made++) {
      sink(heap, made, 0);
      rise(heap, made);
    }
    for (size_t i = 0; i < made; i++) put(list, &heap[i], fmax(LEAST_WIDTH * size, 1e-12), out, i);
  }
  *count = made;
  ylm_free(list);
  ylm_free(room);
  ylm_free(heap);
  return s;
}

/* -- the plain form ----------------------------------------------------------------- */

/* The mean of the clamped cosine under a lobe of sharpness k, c the cosine from its axis to the normal. */
static double clamped(double k, double c) {
  double R = k < 0.1 ? k / 3 * (1 - k * k / 15) : 1 / tanh(k) - 1 / k;
  double each = k < 0.1 ? 1.0 / 3 - k * k / 45 : R / k, mean = c * R;
  double v = fmax(1e-30, each + c * c * (1 - 3 * each) - mean * mean), s = sqrt(v), t = mean / s;
  return (mean * 0.5 * erfc(-t / sqrt(2)) + s * exp(-0.5 * t * t) / sqrt(2 * YLM_PI)) *
         (1 + 0.0858 * exp(-k / 2.2));
}

/* The weight of group i at x, normal N: out [1]; r not NULL: of the lobe of that receiver, out [3]. */
static void weigh(const ylm_many_lights *l, const ylm_many_receiver *r, size_t i, const float x[3],
                  const float N[3], double out[3]) {
  double w[3], v[3], d2 = 0, along = 0, k2 = 0, c = 0, s = (double)l->radius[i];
  double lam = (double)l->shift[i];
  for (int a = 0; a < 3; a++) {
    w[a] = (double)l->at[a][i] - (double)x[a];
    d2 += w[a] * w[a];
  }
  double d = sqrt(d2), k1 = d2 / (s * s);
  for (int a = 0; a < 3; a++) {
    w[a] = d > 0 ? w[a] / d : 0;
    along += w[a] * (double)l->normal[a][i];
    v[a] = k1 * w[a] - lam * (double)l->normal[a][i];
    k2 += v[a] * v[a];
  }
  double k = fmax(sqrt(k2), 1e-6);
  double part = exp(-2 * k1 * lam * (1 + along) / fmax(k + k1 + lam, 1e-30)) / (s * s);
  if (!r) {
    for (int a = 0; a < 3; a++) c += v[a] / k * (double)N[a];
    out[0] = part * -expm1(-2 * k) / k * clamped(k, fmin(1, fmax(-1, c)));
    return;
  }
  double sharp = (double)r->sharp, both = 0, toward = 0, q[3];
  for (int a = 0; a < 3; a++) {
    q[a] = v[a] + sharp * (double)r->lobe[a];
    both += q[a] * q[a];
    toward += v[a] / k * (double)r->lobe[a];
  }
  both = fmax(sqrt(both), 1e-6);
  for (int a = 0; a < 3; a++) c += q[a] / both * (double)N[a];
  part *= exp(-2 * k * sharp * (1 - toward) / fmax(both + k + sharp, 1e-30)) * -expm1(-2 * both) /
          both * clamped(both, fmin(1, fmax(-1, c)));
  for (int a = 0; a < 3; a++) out[a] = part * (double)r->lobes[a];
}

void ylm__many_gaussians(const ylm_many_lights *l, const ylm_many_ask *a, size_t first, size_t n,
                         const float x[3], const float N[3], float *w) {
  (void)a;
  for (size_t k = 0; k < n; k++) {
    double one[3] = {0, 0, 0};
    if (first + k < l->n) weigh(l, NULL, first + k, x, N, one);
    w[k] = (float)one[0];
  }
}

void ylm__many_gaussians_gloss(const ylm_many_lights *l, const ylm_many_ask *a,
                               const ylm_many_receiver *r, size_t first, size_t n, const float x[3],
                               float (*w)[YLM_MANY_CHUNK]) {
  (void)a;
  for (size_t k = 0; k < n; k++) {
    double one[3] = {0, 0, 0};
    if (first + k < l->n) weigh(l, r, first + k, x, r->axis[2], one);
    for (int f = 0; f < 3; f++) w[f][k] = (float)one[f];
  }
}
