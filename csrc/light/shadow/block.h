/*
** block.h - light behind casters at the points of a block, for the element type `real`; block_float.c and
** block_double.c include it.
**
** Rows of coefficients: [rows][count], the value and, with gradients, its derivatives to x, y, z.
*/
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "shadow.h"

#include "profile.h"
#include "ylm_list.h"

typedef struct request {
  size_t point, light;
} request;

typedef struct block {
  shadow_query *w;
  size_t begin, m;
  double point[SHADOW_BLOCK][3];
  uint8_t inside[SHADOW_BLOCK], any[SHADOW_BLOCK]; /* in a caster; on a light */
  size_t *by_caster_first, *by_caster;             /* [casters + 1] of the list of [seens] */
  size_t seen_first[SHADOW_BLOCK + 1], seens, seen_room, befores, before_room, terms, term_room,
      lights, light_room, requests, by_room, blur_room;
  shadow_seen *seen;
  shadow_before *before;
  shadow_term *term;
  request request[SHADOW_BLOCK];
  real *hidden; /* [seens][rows][count] visibilities where the casters stand */
  real *light;  /* [lights][channels][rows][count] */
  real *out;    /* [m][channels][rows][count] */
  double *blur; /* [seens] lambda of visibilities */
  double lambda[SHADOW_BLOCK];
  ylm_error *e;
  int worker;
} block;

/* Room for n things, whatever they were. */
static bool have(void **list, size_t n, size_t *room, size_t size) {
  if (*list && n <= *room) return true;
  ylm_free(*list);
  *list = ylm_alloc(n, size);
  *room = *list ? n : 0;
  return *list != NULL;
}

/* Memory of at least so many numbers, which the thread's next block uses again; NULL without any. */
static real *room(block *b, int which, size_t numbers) {
  shadow_room *r = &b->w->room[(size_t)b->worker * ROOMS + (size_t)which];
  if (r->bytes < numbers * sizeof(real)) {
    ylm_free(r->at);
    r->at = ylm_alloc(numbers, sizeof(real));
    r->bytes = r->at ? numbers * sizeof(real) : 0;
  }
  return r->at;
}

/* -- asking fields ---------------------------------------------------------------------------- */

/* A field's answer at n points, as rows. */
typedef struct answer {
  real *value, *gradient, *lambda;
  uint8_t *inside;
} answer;

static void answer_free(answer *a) {
  ylm_free(a->lambda);
  ylm_free(a->inside);
}

/* Points are relative to `origin`; NULL: to 0. `into`: where values go, or NULL. */
static ylm_status ask(block *b, const ylm_field *f, int lmax, size_t channels, size_t n,
                      const real *points, const double *origin, real *into, answer *a) {
  const shadow_query *w = b->w;
  size_t wide = n * channels * ylm_sh_count(lmax);
  bool gradient = w->rows > 1;
  memset(a, 0, sizeof *a);
  a->value = into ? into : room(b, ROOM_VALUE, wide);
  a->gradient = gradient ? room(b, ROOM_GRADIENT, 3 * wide) : NULL;
  a->lambda = w->metric ? ylm_alloc_zero(n, sizeof *a->lambda) : NULL;
  a->inside = ylm_alloc_zero(n, 1);
  if (!a->value || (gradient && !a->gradient) || (w->metric && !a->lambda) || !a->inside)
    return YLM_ENOMEM;
  ylm_field_query q = {.lmax = lmax,
                       .channels = (int)channels,
                       .want = YLM_WANT_VALUE | (gradient ? YLM_WANT_GRADIENT : 0) |
                               (w->metric ? YLM_WANT_METRIC : 0),
                       .metric_channels = channels == 3 ? w->q->metric_channels : 1,
                       .dtype = DTYPE,
                       .threads = 1,
                       .origin = origin};
  ylm_field_result r = {
      .value = a->value, .gradient = a->gradient, .lambda = a->lambda, .inside = a->inside};
  ylm_status s = ylm_field_evaluate(f, &q, n, points, &r, b->e);
  atomic_fetch_add(&b->w->pairs, r.pairs);
  return s;
}

/* Row i of an answer of `own` coefficients to a row of the query's, whose other coefficients are 0. */
static void unfold(const shadow_query *w, const answer *a, size_t i, size_t own, real *to) {
  if (own < w->count) memset(to, 0, w->rows * w->count * sizeof *to);
  memcpy(to, a->value + i * own, own * sizeof *to);
  const real *g = a->gradient + (w->rows > 1 ? 3 * i * own : 0);
  for (size_t k = 0; w->rows > 1 && k < own; k++)
    for (size_t d = 0; d < 3; d++) to[(d + 1) * w->count + k] = g[3 * k + d];
}

/* -- casters as points see them --------------------------------------------------------------- */

/* Casters that are sorted one by one. */
#define FEW_SEEN 32

static int by_distance(const void *a, const void *b) {
  const shadow_seen *p = a, *q = b;
  if (p->distance != q->distance) return p->distance < q->distance ? -1 : 1;
  return p->caster < q->caster ? -1 : p->caster > q->caster;
}

/* A body of that radius as the point sees it; false where it hides too little to count. */
static bool look(const double p[3], const double at[3], double radius, double least,
                 shadow_seen *to) {
  double d2 = 0;
  for (int a = 0; a < 3; a++) {
    to->w[a] = at[a] - p[a];
    d2 += to->w[a] * to->w[a];
  }
  to->distance = sqrt(d2);
  for (int a = 0; a < 3; a++) to->w[a] = d2 > 0 ? to->w[a] / to->distance : 0;
  to->sine = to->distance > radius ? radius / to->distance : 1;
  to->angle = to->sine < 1 ? asin(to->sine) : YLM_PI;
  /* the part of all directions that its cone takes: (1 - sqrt(1 - s^2))/2 */
  double s2 = to->sine * to->sine;
  to->cosine = to->sine < 1 ? sqrt(1 - s2) : -1;
  return s2 / (2 * (1 + sqrt(1 - s2))) >= least;
}

/* The nearest first. Most points see few casters. */
static void sort_seen(shadow_seen *s, size_t n) {
  if (n > FEW_SEEN) {
    qsort(s, n, sizeof *s, by_distance);
    return;
  }
  for (size_t i = 1; i < n; i++) {
    shadow_seen x = s[i];
    size_t k = i;
    for (; k > 0 && by_distance(&x, &s[k - 1]) < 0; k--) s[k] = s[k - 1];
    s[k] = x;
  }
}

static ylm_status see(block *b) {
  const ylm_light_shadowed *s = b->w->s;
  double least = s->n ? s->form.cull / (double)s->n / (double)(b->w->q->lmax + 1) : 0;
  for (size_t i = 0; i < b->m; i++) {
    size_t first = b->seen_first[i] = b->seens;
    for (size_t k = 0; k < s->n; k++) {
      if (k >= b->w->skip && k - b->w->skip < b->w->skips) continue;
      if (!ylm_list_reserve(&b->seen, b->seens, b->seens + 1, &b->seen_room, sizeof *b->seen))
        return YLM_ENOMEM;
      shadow_seen *to = &b->seen[b->seens];
      to->caster = k;
      to->point = i;
      if (look(b->point[i], s->caster[k].centre, s->caster[k].radius, least, to)) b->seens++;
    }
    sort_seen(b->seen + first, b->seens - first);
  }
  b->seen_first[b->m] = b->seens;
  return YLM_OK;
}

/* -- what casters hide ------------------------------------------------------------------------ */

/* Points of the block that see a caster, in its frame. */
typedef struct viewers {
  size_t n, seen[SHADOW_BLOCK];
  real at[3 * SHADOW_BLOCK];
  double distance[SHADOW_BLOCK]; /* from `centre`, in its frame */
} viewers;

static void gather_viewers(const block *b, size_t caster, viewers *v) {
  const ylm_light_caster *c = &b->w->s->caster[caster].form;
  v->n = 0;
  for (size_t j = b->by_caster_first[caster]; j < b->by_caster_first[caster + 1]; j++) {
    size_t seen = b->by_caster[j];
    const double *at = b->point[b->seen[seen].point];
    double p[3], d2 = 0;
    for (int a = 0; a < 3; a++) {
      p[a] = 0;
      for (int k = 0; k < 3; k++) {
        double x = c->rotation[3 * k + a] * (at[k] - c->at[k]);
        p[a] += c->scale == 1 ? x : x / c->scale;
      }
      v->at[3 * v->n + (size_t)a] = (real)p[a];
      d2 += (p[a] - c->centre[a]) * (p[a] - c->centre[a]);
    }
    v->distance[v->n] = sqrt(d2);
    v->seen[v->n++] = seen;
  }
}

/* Lists what points see by casters, each in the order of the points. */
static ylm_status sort_by_caster(block *b) {
  size_t n = b->w->s->n;
  if (!b->by_caster_first) b->by_caster_first = ylm_alloc(n + 2, sizeof *b->by_caster_first);
  if (!b->by_caster_first ||
      !have((void **)&b->by_caster, b->seens, &b->by_room, sizeof *b->by_caster) ||
      !have((void **)&b->blur, b->seens, &b->blur_room, sizeof *b->blur))
    return YLM_ENOMEM;
  size_t *first = b->by_caster_first;
  memset(first, 0, (n + 2) * sizeof *first);
  memset(b->blur, 0, b->seens * sizeof *b->blur);
  for (size_t j = 0; j < b->seens; j++) first[b->seen[j].caster + 2]++;
  for (size_t k = 0; k < n; k++) first[k + 2] += first[k + 1];
  for (size_t j = 0; j < b->seens; j++)
    b->by_caster[b->seen[j].row = first[b->seen[j].caster + 1]++] = j;
  return YLM_OK;
}

/* The share of the disk at a distance, and its derivative. */
static double share(const ylm_light_caster *c, double distance, double *slope) {
  double from = SHADOW_BLEND * c->far, t = (distance - from) / (c->far - from);
  *slope = 0;
  if (!(c->far > 0) || t <= 0) return 0;
  if (t >= 1) return 1;
  *slope = 6 * t * (1 - t) / (c->far - from);
  return t * t * (3 - 2 * t);
}

/* Rows of visibility at the viewers, in the body's frame: of its field, of its disk, or between them. */
static ylm_status hide_near(block *b, const shadow_caster *c, const viewers *v, bool disk,
                            real *rows) {
  const shadow_query *w = b->w;
  size_t n = 0, own[SHADOW_BLOCK], row = w->rows * w->count;
  real *points = ylm_alloc(3 * v->n, sizeof *points), *one = ylm_alloc(row, sizeof *one);
  const ylm_field *f = disk ? ylm_light_occluder_field(c->disk) : c->form.hides;
  int lmax = disk || c->form.lmax > w->q->lmax ? w->q->lmax : c->form.lmax;
  double slope;
  answer a = {0};
  ylm_status s = points && one ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; i < v->n && s == YLM_OK; i++) {
    double t = share(&c->form, v->distance[i], &slope);
    if (disk ? t == 0 : t == 1) continue;
    memcpy(points + 3 * n, v->at + 3 * i, 3 * sizeof *points);
    own[n++] = i;
  }
  /* values of a field that knows all degrees stand where they are wanted */
  real *into = w->rows == 1 && !disk && n == v->n && lmax == w->q->lmax ? rows : NULL;
  if (s == YLM_OK && n) s = ask(b, f, lmax, 1, n, points, NULL, into, &a);
  for (size_t i = 0; i < n && s == YLM_OK; i++) {
    size_t j = own[i], seen = v->seen[j];
    double t = share(&c->form, v->distance[j], &slope);
    real *to = rows + j * row;
    if (a.lambda && (!disk || t == 1)) b->blur[seen] = (double)a.lambda[i];
    if (a.inside[i] && !disk) b->inside[b->seen[seen].point] = 1;
    if (!disk || t == 1) {
      if (!into) unfold(w, &a, i, ylm_sh_count(lmax), to);
      continue;
    }
    unfold(w, &a, i, ylm_sh_count(lmax), one);
    for (size_t d = 0; d < 3 && w->rows > 1; d++) {
      double away = ((double)v->at[3 * j + d] - c->form.centre[d]) / v->distance[j];
      for (size_t k = 0; k < w->count; k++) {
        real *x = to + (d + 1) * w->count + k;
        *x +=
            (real)t * (one[(d + 1) * w->count + k] - *x) + (real)(slope * away) * (one[k] - to[k]);
      }
    }
    for (size_t k = 0; k < w->count; k++) to[k] += (real)t * (one[k] - to[k]);
  }
  answer_free(&a);
  ylm_free(points);
  ylm_free(one);
  return s;
}

/* Rows in the body's frame become rows where it stands. */
static ylm_status place(block *b, size_t caster, const viewers *v, real *rows) {
  const shadow_query *w = b->w;
  const shadow_caster *c = &w->s->caster[caster];
  double size = c->form.scale;
  real r[9];
  ylm_status s = YLM_OK;
  if (c->turned)
    s = ylm_sh_rotation_apply(w->turn[caster], w->q->lmax, v->n * w->rows, rows, rows, 1, NULL);
  for (size_t i = 0; i < 9; i++) r[i] = (real)(c->form.rotation[i] / size);
  for (size_t i = 0; i < v->n && s == YLM_OK; i++) {
    b->blur[v->seen[i]] /= size * size;
    real *x = rows + i * w->rows * w->count + w->count, *y = x + w->count, *z = y + w->count;
    for (size_t k = 0; w->rows > 1 && k < w->count; k++) {
      real g[3] = {x[k], y[k], z[k]};
      x[k] = r[0] * g[0] + r[1] * g[1] + r[2] * g[2];
      y[k] = r[3] * g[0] + r[4] * g[1] + r[5] * g[2];
      z[k] = r[6] * g[0] + r[7] * g[1] + r[8] * g[2];
    }
  }
  return s;
}

static ylm_status hide(block *b) {
  const shadow_query *w = b->w;
  size_t row = w->rows * w->count;
  b->hidden = room(b, ROOM_HIDDEN, b->seens * row);
  viewers *v = ylm_alloc(1, sizeof *v);
  ylm_status s = b->hidden && v ? sort_by_caster(b) : YLM_ENOMEM;
  for (size_t k = 0; k < w->s->n && s == YLM_OK; k++) {
    const shadow_caster *c = &w->s->caster[k];
    real *rows = b->hidden + b->by_caster_first[k] * row;
    if (!c->form.hides || w->exponential) {
      for (size_t j = b->by_caster_first[k]; j < b->by_caster_first[k + 1]; j++) {
        const shadow_seen *seen = &b->seen[b->by_caster[j]];
        if (seen->distance <= c->radius) b->inside[seen->point] = 1;
      }
      continue;
    }
    gather_viewers(b, k, v);
    if (v->n) s = hide_near(b, c, v, false, rows);
    if (v->n && c->disk && s == YLM_OK) s = hide_near(b, c, v, true, rows);
    if (v->n && s == YLM_OK) s = place(b, k, v, rows);
  }
  ylm_free(v);
  return s;
}

/* -- lights and the casters before them -------------------------------------------------------- */

static ylm_status new_light(block *b, size_t *at) {
  size_t wide = b->w->channels * b->w->rows * b->w->count * sizeof(real);
  if (!ylm_list_reserve(&b->light, b->lights, b->lights + 1, &b->light_room, wide))
    return YLM_ENOMEM;
  memset((char *)b->light + b->lights * wide, 0, wide);
  *at = b->lights++;
  return YLM_OK;
}

static ylm_status new_term(block *b, shadow_term t) {
  if (!ylm_list_reserve(&b->term, b->terms, b->terms + 1, &b->term_room, sizeof *b->term))
    return YLM_ENOMEM;
  b->term[b->terms++] = t;
  return YLM_OK;
}

static ylm_status add_before(block *b, shadow_before x) {
  if (!ylm_list_reserve(&b->before, b->befores, b->befores + 1, &b->before_room, sizeof *b->before))
    return YLM_ENOMEM;
  b->before[b->befores++] = x;
  return YLM_OK;
}

/* Casters seen from `first` on stand wholly before the next light. */
static ylm_status all_before(block *b, size_t first, size_t n) {
  for (size_t j = 0; j < n; j++) {
    if (!ylm_list_reserve(&b->before, b->befores, b->befores + 1, &b->before_room,
                          sizeof *b->before))
      return YLM_ENOMEM;
    shadow_before *x = &b->before[b->befores++];
    x->seen = first + j;
    x->layer = 0;
    x->weight = 1;
    x->slope[0] = x->slope[1] = x->slope[2] = 0;
  }
  return YLM_OK;
}

/* How much of caster c counts before lamp l, and its derivative: all where their cones meet, nothing where they are
   farther apart than a wave of lmax. */
static double meets(int lmax, const shadow_seen *c, const shadow_seen *l, double slope[3]) {
  double cosine = c->w[0] * l->w[0] + c->w[1] * l->w[1] + c->w[2] * l->w[2];
  double margin = YLM_PI / (lmax + 1), apart = acos(fmax(-1, fmin(1, cosine)));
  double t = (apart - c->angle - l->angle) / margin;
  memset(slope, 0, 3 * sizeof *slope);
  if (t <= 0) return 1;
  if (t >= 1) return 0;
  double sine = sqrt(fmax(1e-30, 1 - cosine * cosine)), steep = -6 * t * (1 - t) / margin;
  for (int a = 0; a < 3; a++) {
    double turn =
        ((l->w[a] - c->w[a] * cosine) / c->distance + (c->w[a] - l->w[a] * cosine) / l->distance) /
        sine;
    double wide = c->sine / sqrt(1 - c->sine * c->sine) * c->w[a] / c->distance +
                  l->sine / sqrt(1 - l->sine * l->sine) * l->w[a] / l->distance;
    slope[a] = steep * (turn - wide);
  }
  return 1 - t * t * (3 - 2 * t);
}

/* The term of a point with the same casters before its light, all of them wholly; or none. */
static shadow_term *same_term(block *b, size_t from, size_t point, size_t first) {
  size_t n = b->befores - first;
  for (size_t k = first; k < b->befores; k++)
    if (b->before[k].weight != 1) return NULL;
  for (size_t j = from; j < b->terms; j++) {
    shadow_term *t = &b->term[j];
    bool same = t->point == point && t->n == n;
    for (size_t k = 0; same && k < n; k++)
      same = b->before[t->first + k].seen == b->before[first + k].seen &&
             b->before[t->first + k].weight == 1;
    if (same) return t;
  }
  return NULL;
}

/* Adds lamp l to the rows of the lights that wait for it. */
static ylm_status add_lamp(block *b, const shadow_lamp *l) {
  const shadow_query *w = b->w;
  real points[3 * SHADOW_BLOCK];
  size_t row = w->rows * w->count;
  const double *from = w->q->origin;
  for (size_t i = 0; i < b->requests; i++)
    for (size_t a = 0; a < 3; a++)
      points[3 * i + a] = (real)(b->point[b->request[i].point][a] - (from ? from[a] : 0));
  real *one = ylm_alloc(row, sizeof *one);
  answer a = {0};
  ylm_status s =
      one ? ask(b, ylm_light_set_field(l->grey), w->q->lmax, 1, b->requests, points, from, NULL, &a)
          : YLM_ENOMEM;
  for (size_t i = 0; i < b->requests && s == YLM_OK; i++) {
    unfold(w, &a, i, w->count, one);
    for (size_t c = 0; c < w->channels; c++) {
      real *to = b->light + (b->request[i].light * w->channels + c) * row;
      double rgb = ylm__emission(l->rgb, (int)w->channels, (int)c);
      for (size_t k = 0; k < row; k++) to[k] += (real)rgb * one[k];
    }
  }
  answer_free(&a);
  ylm_free(one);
  return s;
}

/* Casters before a lamp at each point. */
static ylm_status before_lamp(block *b, const shadow_lamp *l, size_t from) {
  ylm_status s = YLM_OK;
  b->requests = 0;
  for (size_t i = 0; i < b->m && s == YLM_OK; i++) {
    shadow_seen lamp;
    size_t first = b->befores, light;
    look(b->point[i], l->at, l->radius, 0, &lamp);
    for (size_t j = b->seen_first[i]; j < b->seen_first[i + 1] && s == YLM_OK; j++) {
      shadow_before x = {.seen = j};
      if (b->seen[j].distance >= lamp.distance) break;
      x.weight = meets(b->w->q->lmax, &b->seen[j], &lamp, x.slope);
      if (x.weight > 0) s = add_before(b, x);
    }
    if (s != YLM_OK || b->befores == first) continue;
    shadow_term *same = same_term(b, from, i, first);
    if (same) {
      b->befores = first;
      light = same->light;
    } else {
      s = new_light(b, &light);
      if (s == YLM_OK)
        s = new_term(b, (shadow_term){.point = i,
                                      .first = first,
                                      .n = b->befores - first,
                                      .light = light,
                                      .again = true});
    }
    b->request[b->requests++] = (request){i, light};
  }
  return s == YLM_OK && b->requests ? add_lamp(b, l) : s;
}

/* Rows of even light: [channels][rows][count], of which gradients are 0; its values at nodes: [channels][values]. */
static const real *even_row(const shadow_query *w, size_t c) {
  return (const real *)w->even + c * w->rows * w->count;
}

static size_t tile_values(const shadow_query *w) {
  return ylm_sh_nodes_lanes(w->nodes, DTYPE) * ylm_sh_nodes_count(w->nodes);
}

/* Up to the next 16, with which rows begin. */
static size_t sixteens(size_t n) { return (n + 15) / 16 * 16; }

/* Numbers of even light before the values at nodes of channel c; c of all channels: its numbers. */
static size_t even_before(const shadow_query *w, size_t c) {
  return sixteens(w->channels * w->rows * w->count) + c * sixteens(tile_values(w));
}

static real *even_nodes(const shadow_query *w, size_t c) {
  return (real *)w->even + even_before(w, c);
}

/* Row c of a light. */
static const real *light_row(const block *b, size_t light, size_t c) {
  const shadow_query *w = b->w;
  return light == SHADOW_EVEN ? even_row(w, c)
                              : b->light + (light * w->channels + c) * w->rows * w->count;
}

/* Even light at the points of the block. */
static ylm_status add_even(block *b) {
  const shadow_query *w = b->w;
  ylm_status s = YLM_OK;
  for (size_t i = 0; i < b->m && s == YLM_OK; i++) {
    size_t n = b->seen_first[i + 1] - b->seen_first[i], first = b->befores;
    if (n) {
      s = all_before(b, b->seen_first[i], n);
      if (s == YLM_OK)
        s = new_term(b, (shadow_term){.point = i, .first = first, .n = n, .light = SHADOW_EVEN});
      continue;
    }
    for (size_t c = 0; c < w->channels; c++)
      memcpy(b->out + (i * w->channels + c) * w->rows * w->count, even_row(w, c),
             w->count * sizeof(real));
  }
  return s;
}

/* Light that all lamps send, and light behind all casters, at the points of the block. */
static ylm_status sum_lights(block *b, const ylm_field *f, bool behind) {
  const shadow_query *w = b->w;
  const real *points = (const real *)w->points + 3 * b->begin;
  size_t row = w->rows * w->count;
  answer a = {0};
  ylm_status s = ask(b, f, w->q->lmax, w->channels, b->m, points, w->q->origin, NULL, &a);
  for (size_t i = 0; i < b->m && s == YLM_OK; i++) {
    real *to = b->out + i * w->channels * row;
    size_t n = b->seen_first[i + 1] - b->seen_first[i], light, first = b->befores;
    b->any[i] |= a.inside[i];
    if (a.lambda) b->lambda[i] += (double)a.lambda[i];
    if (behind && n) {
      s = new_light(b, &light);
      if (s == YLM_OK) s = all_before(b, b->seen_first[i], n);
      if (s == YLM_OK)
        s = new_term(b, (shadow_term){.point = i, .first = first, .n = n, .light = light});
      if (s != YLM_OK) break;
      to = b->light + light * w->channels * row;
    }
    real *one = to;
    for (size_t c = 0; c < w->channels; c++, one += row)
      if (behind && n)
        unfold(w, &a, i * w->channels + c, w->count, one);
      else {
        /* added: lamps and light behind casters may both be there */
        const real *v = a.value + (i * w->channels + c) * w->count;
        for (size_t k = 0; k < w->count; k++) one[k] += v[k];
        const real *g = w->rows > 1 ? a.gradient + 3 * (i * w->channels + c) * w->count : NULL;
        for (size_t k = 0; g && k < w->count; k++)
          for (size_t d = 0; d < 3; d++) one[(d + 1) * w->count + k] += g[3 * k + d];
      }
  }
  answer_free(&a);
  return s;
}

/* -- layers ------------------------------------------------------------------------------------ */

/* Do their cones meet? The cosine of the sum of half angles, by their sines and cosines. */
static bool overlap(const shadow_seen *a, const shadow_seen *b) {
  double cosine = a->w[0] * b->w[0] + a->w[1] * b->w[1] + a->w[2] * b->w[2];
  return a->angle + b->angle >= YLM_PI || cosine > a->cosine * b->cosine - a->sine * b->sine;
}

/* The first layer of a term where nothing overlaps caster k of it. */
static int layer_of(const block *b, const shadow_term *t, size_t k) {
  const shadow_before *x = b->before + t->first;
  if (!b->w->s->form.layers) return (int)t->layers;
  for (int layer = 0;; layer++) {
    bool free = true;
    for (size_t j = 0; j < k && free; j++)
      free = x[j].layer != layer || !overlap(&b->seen[x[j].seen], &b->seen[x[k].seen]);
    if (free) return layer;
  }
}

static void layer(block *b) {
  for (size_t i = 0; i < b->terms; i++) {
    shadow_term *t = &b->term[i];
    t->layers = 0;
    for (size_t k = 0; k < t->n; k++) {
      shadow_before *x = &b->before[t->first + k];
      bool sphere = b->w->exponential || !b->w->s->caster[b->seen[x->seen].caster].form.hides;
      x->layer = sphere ? -1 : layer_of(b, t, k);
      if (x->layer >= (int)t->layers) t->layers = (size_t)x->layer + 1;
    }
  }
}

/* Notes how much there is to multiply. */
static void count(const block *b) {
  size_t factors = 0;
  for (size_t i = 0; i < b->terms; i++) {
    const shadow_term *t = &b->term[i];
    factors += t->layers;
    for (size_t k = 0; k < t->n; k++) factors += b->before[t->first + k].layer < 0;
  }
  atomic_fetch_add(&b->w->casters, b->seens);
  atomic_fetch_add(&b->w->products, b->terms);
  atomic_fetch_add(&b->w->factors, factors);
}

/* -- products at nodes -------------------------------------------------------------------------- */

/* Values at nodes: [count][lanes] each. */
typedef struct tile {
  block *b;
  size_t lanes, n, values; /* terms in lanes, numbers of one function */
  const shadow_term *term[16];
  real *f, *g[3], *one, *two;
  real *row, *unit, *zero, *result; /* [lanes][rows][count]; [count] each; [lanes][count] */
  real *profile;                    /* [1 + lanes][rows][rings->padded] */
  void *scratch;
} tile;

/* Adds what a caster hides, of its visibility v, to the row of a layer. */
static void add_hidden(const shadow_query *w, const shadow_before *x, const real *restrict v,
                       real *restrict to) {
  size_t n = w->count;
  real weight = (real)x->weight, first = v[0] - (real)LIGHT_ONE;
  to[0] += weight * first;
  for (size_t i = 1; i < n; i++) to[i] += weight * v[i];
  for (size_t d = 1; d < w->rows; d++) {
    const real *restrict g = v + d * n;
    real *restrict out = to + d * n, slope = (real)x->slope[d - 1];
    out[0] += weight * g[0] + slope * first;
    if (slope == 0)
      for (size_t i = 1; i < n; i++) out[i] += weight * g[i];
    else
      for (size_t i = 1; i < n; i++) out[i] += weight * g[i] + slope * v[i];
  }
}

/* The row of a layer in a lane: what it points to, or is put together at `to`. */
static const real *layer_row(const tile *t, size_t lane, int layer, real *to) {
  const block *b = t->b;
  const shadow_query *w = b->w;
  const shadow_term *term = t->term[lane];
  size_t row = w->rows * w->count, found = 0;
  const shadow_before *only = NULL;
  for (size_t k = 0; k < term->n; k++)
    if (b->before[term->first + k].layer == layer) only = &b->before[term->first + k], found++;
  if (!found) return NULL;
  if (found == 1 && only->weight == 1) return b->hidden + b->seen[only->seen].row * row;
  memset(to, 0, row * sizeof *to);
  to[0] = (real)LIGHT_ONE;
  for (size_t k = 0; k < term->n; k++) {
    const shadow_before *x = &b->before[term->first + k];
    if (x->layer == layer) add_hidden(w, x, b->hidden + b->seen[x->seen].row * row, to);
  }
  return to;
}

/* Value or derivative d of a layer to nodes. */
static void to_nodes(const tile *t, const real *const *row, size_t d, bool multiply, real *to) {
  const void *at[16];
  for (size_t i = 0; i < t->lanes; i++)
    at[i] = row[i] ? row[i] + d * t->b->w->count : d ? t->zero : t->unit;
  ylm_sh_nodes_synthesise(t->b->w->nodes, DTYPE, at, multiply, to, t->scratch);
}

/* f and its derivatives, cut off at lmax. */
static void cut_off(const tile *t, real *f) {
  const void *in[16];
  void *out[16];
  for (size_t i = 0; i < t->lanes; i++) in[i] = out[i] = t->result + i * t->b->w->count;
  ylm_sh_nodes_analyse(t->b->w->nodes, DTYPE, f, out, t->scratch);
  ylm_sh_nodes_synthesise(t->b->w->nodes, DTYPE, in, false, f, t->scratch);
}

static void multiply_layer(const tile *t, int layer) {
  const shadow_query *w = t->b->w;
  const real *row[16];
  bool cut = w->s->form.product == YLM_SHADOW_PRODUCT_recursive && layer > 0;
  for (size_t i = 0; i < t->lanes; i++)
    row[i] = layer_row(t, i, layer, t->row + i * w->rows * w->count);
  if (w->rows == 1 || layer == 0)
    to_nodes(t, row, 0, layer > 0, t->f);
  else
    to_nodes(t, row, 0, false, t->one);
  for (size_t d = 1; d < w->rows; d++) {
    real *g = t->g[d - 1];
    if (layer == 0) {
      to_nodes(t, row, d, false, g);
      continue;
    }
    to_nodes(t, row, d, false, t->two);
    SUMS(w, t->values, g, g, t->one, t->f, t->two);
    if (cut) cut_off(t, g);
  }
  for (size_t i = 0; w->rows > 1 && layer > 0 && i < t->values; i++) t->f[i] *= t->one[i];
  if (cut) cut_off(t, t->f);
}

/* -- spheres, evaluated at nodes ----------------------------------------------------------------- */

/* 1 at all directions, without a slope. */
static void clear_profile(const shadow_query *w, real *v) {
  for (size_t i = 0; i < w->rings->padded; i++) v[i] = 1;
  memset(v + w->rings->padded, 0, (w->rows - 1) * w->rings->padded * sizeof *v);
}

/* Spheres of a body that has several, in a term, from its first one on: their smallest value multiplies v. */
static void multiply_body(const tile *t, const shadow_term *term, size_t k, real *least, real *v) {
  const block *b = t->b;
  const shadow_query *w = b->w;
  const shadow_before *x = b->before + term->first;
  uint32_t body = w->s->caster[b->seen[x[k].seen].caster].form.body;
  size_t wide = w->rings->padded;
  shadow_cap cap;
  clear_profile(w, least);
  for (; k < term->n; k++) {
    const shadow_caster *c = &w->s->caster[b->seen[x[k].seen].caster];
    if (x[k].layer >= 0 || c->form.body != body) continue;
    ylm__shadow_cap_of(&w->blur[0], &b->seen[x[k].seen], &x[k], false, &cap);
    PROFILE(w, &cap, false, least);
  }
  for (size_t d = 1; d < w->rows; d++)
    for (size_t i = 0; i < wide; i++)
      v[d * wide + i] = v[d * wide + i] * least[i] + v[i] * least[d * wide + i];
  for (size_t i = 0; i < wide; i++) v[i] *= least[i];
}

/* The visibility of the spheres of a term: v; false where there are none. */
static bool open_spheres(const tile *t, const shadow_term *term, real *least, real *v) {
  const block *b = t->b;
  const shadow_query *w = b->w;
  const shadow_before *x = b->before + term->first;
  size_t n = 0;
  clear_profile(w, v);
  for (size_t k = 0; k < term->n; k++) {
    if (x[k].layer >= 0) continue;
    const shadow_caster *c = &w->s->caster[b->seen[x[k].seen].caster];
    shadow_cap cap;
    n++;
    if (c->lone) {
      ylm__shadow_cap_of(&w->blur[1], &b->seen[x[k].seen], &x[k], true, &cap);
      PROFILE(w, &cap, true, v);
      continue;
    }
    bool first = true;
    for (size_t j = k; j-- > 0 && first;)
      first = x[j].layer >= 0 || w->s->caster[b->seen[x[j].seen].caster].form.body != c->form.body;
    if (first) multiply_body(t, term, k, least, v);
  }
  return n > 0;
}

/* Multiplies the lanes by their spheres. */
static void multiply_spheres(const tile *t) {
  const shadow_query *w = t->b->w;
  const shadow_rings *r = w->rings;
  size_t wide = w->rows * r->padded, lanes = t->lanes;
  bool some = false;
  const real *v = t->profile + wide;
  if (!w->s->spheres) return;
  for (size_t lane = 0; lane < lanes; lane++) {
    real *to = t->profile + (lane + 1) * wide;
    if (lane < t->n)
      some |= open_spheres(t, t->term[lane], t->profile, to);
    else
      clear_profile(w, to);
  }
  for (size_t k = 0; k < r->n && some; k++)
    for (size_t i = r->first[2 * k]; i < r->first[2 * k] + r->first[2 * k + 1]; i++) {
      real *f = t->f + r->node[i] * lanes;
      for (size_t d = 0; d + 1 < w->rows; d++) {
        real *g = t->g[d] + r->node[i] * lanes;
        const real *slope = v + (d + 1) * r->padded + i;
        for (size_t lane = 0; lane < lanes; lane++)
          g[lane] = g[lane] * v[lane * wide + i] + f[lane] * slope[lane * wide];
      }
      for (size_t lane = 0; lane < lanes; lane++) f[lane] *= v[lane * wide + i];
    }
}

/* -- exponentials of sums of logarithms ---------------------------------------------------------- */

/* Adds the logarithm of a circle to a row: its table, turned to where the circle stands. y, dy: the basis there. */
static void add_logarithm(const shadow_query *w, const shadow_seen *s, const shadow_before *x,
                          const real *y, const real *dy, real *to) {
  double z[YLM_SH_LOG_LMAX + 1], slope[YLM_SH_LOG_LMAX + 1], over = 1 / fmax(1e-300, s->distance);
  double wide = s->sine < 1 ? s->sine / sqrt(1 - s->sine * s->sine) * over : 0;
  ylm_sh_exponential_circle(w->exponential, s->angle, z, slope);
  for (int l = 0; l <= w->q->lmax; l++) {
    double part = LIGHT_ONE / sqrt(2 * l + 1);
    for (size_t k = ylm_sh_index(l, -l); k <= ylm_sh_index(l, l); k++) {
      double value = part * z[l] * (double)y[k];
      to[k] += (real)(x->weight * value);
      for (size_t d = 0; d + 1 < w->rows; d++)
        to[(d + 1) * w->count + k] += (real)(x->weight * part *
                                                 (slope[l] * wide * s->w[d] * (double)y[k] -
                                                  z[l] * over * (double)dy[3 * k + d]) +
                                             x->slope[d] * value);
    }
  }
}

/* Sums of logarithms of the lanes' casters. */
static ylm_status sum_logarithms(const tile *t, real *sum) {
  const block *b = t->b;
  const shadow_query *w = b->w;
  size_t n = 0, k = 0;
  for (size_t i = 0; i < t->n; i++) n += t->term[i]->n;
  real *at = ylm_alloc(3 * n, sizeof *at), *y = ylm_alloc(n * w->count, sizeof *y),
       *dy = w->rows > 1 ? ylm_alloc(3 * n * w->count, sizeof *dy) : NULL;
  ylm_status s = at && y && (w->rows == 1 || dy) ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; i < t->n && s == YLM_OK; i++)
    for (size_t j = 0; j < t->term[i]->n; j++, k++) {
      const double *v = b->seen[b->before[t->term[i]->first + j].seen].w;
      bool middle = v[0] == 0 && v[1] == 0 && v[2] == 0; /* of the caster: dark in any case */
      for (size_t a = 0; a < 3; a++) at[3 * k + a] = middle ? 1 : (real)v[a];
    }
  if (s == YLM_OK && n)
    s = ylm_sh_eval(w->q->lmax, w->rows > 1, false, DTYPE, n, at, y, dy, NULL, 1, b->e);
  k = 0;
  for (size_t i = 0; i < t->n && s == YLM_OK; i++)
    for (size_t j = 0; j < t->term[i]->n; j++, k++) {
      const shadow_before *x = &b->before[t->term[i]->first + j];
      add_logarithm(w, &b->seen[x->seen], x, y + k * w->count, dy ? dy + 3 * k * w->count : NULL,
                    sum + i * w->rows * w->count);
    }
  ylm_free(at);
  ylm_free(y);
  ylm_free(dy);
  return s;
}

/* The visibility of casters in each lane, at nodes. */
static ylm_status exponentials(const tile *t) {
  const block *b = t->b;
  const shadow_query *w = b->w;
  size_t wide = w->rows * w->count;
  real *sum = ylm_alloc_zero(t->n * wide, sizeof *sum),
       *open = ylm_alloc(t->n * wide, sizeof *open);
  const real *row[16];
  ylm_status s = sum && open ? sum_logarithms(t, sum) : YLM_ENOMEM;
  if (s == YLM_OK)
    s = ylm_sh_exponential_apply(w->exponential, DTYPE, t->n, w->rows > 1 ? 3 : 0, sum, open, 1,
                                 NULL, NULL);
  if (s == YLM_ERANGE) {
    const double *p = b->point[t->term[0]->point];
    ylm_fail(
        b->e, s,
        "the series of the exponential diverges near {%.6g, %.6g, %.6g}, where casters look too "
        "large: exp = 'HYB' does not",
        p[0], p[1], p[2]);
  }
  for (size_t i = 0; i < t->lanes && s == YLM_OK; i++)
    row[i] = open + (i < t->n ? i : t->n - 1) * wide;
  for (size_t d = 0; d < w->rows && s == YLM_OK; d++)
    to_nodes(t, row, d, false, d ? t->g[d - 1] : t->f);
  ylm_free(sum);
  ylm_free(open);
  return s;
}

/* -- the light behind ----------------------------------------------------------------------------- */

/* Coefficients of `f`, of channel c and derivative d, are added to the results of the lanes' points. */
static void add_result(const tile *t, real *f, size_t c, size_t d) {
  block *b = t->b;
  const shadow_query *w = b->w;
  void *out[16];
  for (size_t i = 0; i < t->lanes; i++) out[i] = t->result + i * w->count;
  ylm_sh_nodes_analyse(w->nodes, DTYPE, f, out, t->scratch);
  for (size_t i = 0; i < t->n; i++) {
    const shadow_term *term = t->term[i];
    real *to = b->out + ((term->point * w->channels + c) * w->rows + d) * w->count;
    const real *from = t->result + i * w->count,
               *light = light_row(b, term->light, c) + d * w->count;
    for (size_t k = 0; k < w->count; k++) to[k] += term->again ? from[k] - light[k] : from[k];
  }
}

/* The largest value of a lane at nodes. */
static double largest(const real *light, size_t values, size_t lanes, size_t lane) {
  real x = 0;
  for (size_t i = lane; i < values; i += lanes) {
    real y = light[i] < 0 ? -light[i] : light[i];
    x = y > x ? y : x;
  }
  return (double)x;
}

/* Adds to lambda of the lanes' points: the largest light at nodes times lambda of visibilities. light NULL: even light. */
static void add_metric(const tile *t, const real *light, size_t c, double (*most)[3]) {
  block *b = t->b;
  for (size_t lane = 0; lane < t->n; lane++) {
    most[lane][c] = light ? largest(light, t->values, t->lanes, lane) : b->w->even_most[c];
    if (c + 1 < b->w->channels) continue;
    const shadow_term *term = t->term[lane];
    double blur = 0, *m = most[lane];
    for (size_t k = 0; k < term->n; k++) {
      const shadow_before *x1 = &b->before[term->first + k];
      blur += x1->layer < 0 ? 0 : x1->weight * b->blur[x1->seen];
    }
    double peak = b->w->channels == 1             ? m[0]
                  : b->w->q->metric_channels == 3 ? sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2])
                                                  : ylm__emission(m, 1, 0);
    b->lambda[term->point] += peak * blur;
  }
}

/* The lanes' light in channel c times what they let through, to the results. */
static void add_light(const tile *t, size_t c, double (*most)[3]) {
  const shadow_query *w = t->b->w;
  const real *row[16];
  for (size_t i = 0; i < t->lanes; i++) row[i] = light_row(t->b, t->term[i]->light, c);
  to_nodes(t, row, 0, false, t->one);
  if (w->metric) add_metric(t, t->one, c, most);
  for (size_t d = 1; d < w->rows; d++) {
    to_nodes(t, row, d, false, t->two);
    SUMS(w, t->values, t->two, t->g[d - 1], t->one, t->f, t->two);
    add_result(t, t->two, c, d);
  }
  for (size_t i = 0; i < t->values; i++) t->one[i] *= t->f[i];
  add_result(t, t->one, c, 0);
}

/* As add_light, where the light of all lanes is even. */
static void add_even_light(const tile *t, size_t c, double (*most)[3]) {
  const shadow_query *w = t->b->w;
  const real *light = even_nodes(w, c);
  if (w->metric) add_metric(t, NULL, c, most);
  for (size_t d = 0; d < w->rows; d++) {
    const real *f = d ? t->g[d - 1] : t->f;
    for (size_t i = 0; i < t->values; i++) t->two[i] = f[i] * light[i];
    add_result(t, t->two, c, d);
  }
}

static ylm_status run_tile(tile *t) {
  const shadow_query *w = t->b->w;
  size_t layers = 0;
  bool even = true;
  double most[16][3];
  for (size_t i = 0; i < t->n; i++)
    layers = t->term[i]->layers > layers ? t->term[i]->layers : layers;
  for (size_t i = t->n; i < t->lanes; i++) t->term[i] = t->term[t->n - 1];
  if (w->exponential) {
    ylm_status s = exponentials(t);
    if (s != YLM_OK) return s;
  } else if (!layers) {
    for (size_t i = 0; i < t->values; i++) t->f[i] = 1;
    for (size_t d = 0; d + 1 < w->rows; d++) memset(t->g[d], 0, t->values * sizeof(real));
  }
  for (size_t k = 0; k < layers; k++) multiply_layer(t, (int)k);
  if (!w->exponential) multiply_spheres(t);
  for (size_t i = 0; i < t->lanes; i++) even = even && t->term[i]->light == SHADOW_EVEN;
  for (size_t c = 0; c < w->channels; c++) (even ? add_even_light : add_light)(t, c, most);
  return YLM_OK;
}

/* All terms, those with the most layers first, so that the lanes of a tile have about as many. */
static ylm_status multiply(block *b) {
  const shadow_query *w = b->w;
  size_t lanes = ylm_sh_nodes_lanes(w->nodes, DTYPE), nodes = ylm_sh_nodes_count(w->nodes),
         most = 0;
  if (!b->terms) return YLM_OK;
  tile t = {.b = b, .lanes = lanes, .values = lanes * nodes};
  size_t rows = w->rows * w->count, values = sixteens(t.values),
         scratch = ylm_sh_nodes_scratch(w->nodes, DTYPE);
  size_t gradients = w->rows > 1 ? 3 : 0;
  size_t profiles = w->s->spheres ? (1 + lanes) * w->rows * w->rings->padded : 0;
  t.f = room(b, ROOM_TILE,
             (3 + gradients) * values + lanes * (rows + w->count) + 2 * w->count + profiles + 64);
  t.scratch = room(b, ROOM_SCRATCH, (scratch + sizeof(real) - 1) / sizeof(real));
  if (!t.f || !t.scratch) return YLM_ENOMEM;
  t.one = t.f + values;
  t.two = t.one + values;
  for (size_t d = 0; d < gradients; d++) t.g[d] = t.two + (d + 1) * values;
  t.row = t.two + (gradients + 1) * values;
  t.result = t.row + lanes * rows;
  t.unit = t.result + lanes * w->count;
  t.zero = t.unit + w->count;
  t.profile = t.zero + w->count;
  memset(t.unit, 0, 2 * w->count * sizeof *t.unit);
  t.unit[0] = (real)LIGHT_ONE;
  for (size_t i = 0; i < b->terms; i++) most = b->term[i].layers > most ? b->term[i].layers : most;
  ylm_status s = YLM_OK;
  for (size_t left = most + 1; left-- > 0;)
    for (size_t i = 0; i < b->terms && s == YLM_OK; i++) {
      if (b->term[i].layers != left) continue;
      t.term[t.n++] = &b->term[i];
      if (t.n == lanes) s = run_tile(&t), t.n = 0;
    }
  if (t.n && s == YLM_OK) s = run_tile(&t);
  return s;
}

/* -- results -------------------------------------------------------------------------------------- */

/* Channel c of `channels` of a number of the light. */
static double channel(const shadow_query *w, const real *x, int channels, int c) {
  size_t step = w->rows * w->count;
  if (w->channels == 1) return (double)x[0];
  if (channels == 3) return (double)x[(size_t)c * step];
  return YLM_LUMINANCE_R * (double)x[0] + YLM_LUMINANCE_G * (double)x[step] +
         YLM_LUMINANCE_B * (double)x[2 * step];
}

/* Values of channel c, as they stand or as a luminance, and derivatives. */
static void write_channel(const shadow_query *w, const real *x, int c, real *value,
                          real *gradient) {
  size_t n = w->count, step = w->rows * n;
  bool stands = w->channels == 1 || w->q->channels == 3;
  const real *from = w->channels == 1 ? x : x + (size_t)c * step;
  if (value && stands) memcpy(value, from, n * sizeof *value);
  for (size_t k = 0; value && !stands && k < n; k++)
    value[k] = (real)channel(w, x + k, w->q->channels, c);
  for (size_t k = 0; gradient && k < n; k++)
    for (size_t d = 0; d < 3; d++)
      gradient[3 * k + d] =
          stands ? from[(d + 1) * n + k] : (real)channel(w, x + (d + 1) * n + k, w->q->channels, c);
}

static void write(const block *b) {
  const shadow_query *w = b->w;
  const ylm_field_query *q = w->q;
  size_t channels = (size_t)q->channels;
  real *value = q->want & YLM_WANT_VALUE ? w->r->value : NULL,
       *gradient = q->want & YLM_WANT_GRADIENT ? w->r->gradient : NULL;
  for (size_t i = 0; i < b->m; i++) {
    real *x = b->out + i * w->channels * w->rows * w->count;
    size_t at = b->begin + i;
    double square = 0;
    if (b->inside[i]) memset(x, 0, w->channels * w->rows * w->count * sizeof *x);
    for (size_t c = 0; c < channels; c++) {
      size_t to = (at * channels + c) * w->count;
      write_channel(w, x, (int)c, value ? value + to : NULL, gradient ? gradient + 3 * to : NULL);
    }
    if (w->r->inside) w->r->inside[at] = b->inside[i] | b->any[i];
    if (!w->metric) continue;
    for (int c = 0; c < q->metric_channels; c++)
      for (size_t k = 0; k < w->count; k++) {
        double y = channel(w, x + k, q->metric_channels, c);
        square += y * y;
      }
    if (w->r->norm) ((real *)w->r->norm)[at] = (real)sqrt(square);
    if (w->r->lambda) ((real *)w->r->lambda)[at] = b->inside[i] ? 0 : (real)b->lambda[i];
  }
}

/* The block of a thread, which keeps its lists from block to block; NULL without memory. */
static block *block_of(shadow_query *w, size_t begin, size_t end, int worker, ylm_error *e) {
  void **kept = &w->block[worker];
  if (!*kept) *kept = ylm_alloc_zero(1, sizeof(block));
  block *b = *kept;
  if (!b) return NULL;
  b->w = w;
  b->begin = begin;
  b->m = end - begin;
  b->e = e;
  b->worker = worker;
  b->seens = b->befores = b->terms = b->lights = b->requests = 0;
  memset(b->inside, 0, sizeof b->inside);
  memset(b->any, 0, sizeof b->any);
  memset(b->lambda, 0, sizeof b->lambda);
  for (size_t i = 0; i < b->m; i++)
    for (size_t a = 0; a < 3; a++)
      b->point[i][a] = (double)((const real *)w->points)[3 * (begin + i) + a] +
                       (w->q->origin ? w->q->origin[a] : 0);
  return b;
}

void BLOCK_FREE(void *kept) {
  block *b = kept;
  if (!b) return;
  ylm_free(b->seen);
  ylm_free(b->by_caster_first);
  ylm_free(b->by_caster);
  ylm_free(b->before);
  ylm_free(b->term);
  ylm_free(b->blur);
  ylm_free(b->light);
  ylm_free(b);
}

/* Points begin .. end-1 of a query. */
ylm_status BLOCK(shadow_query *w, size_t begin, size_t end, int worker, ylm_error *e) {
  const ylm_light_shadowed *s = w->s;
  block *b = block_of(w, begin, end, worker, e);
  if (!b) return YLM_ENOMEM;
  size_t numbers = b->m * w->channels * w->rows * w->count;
  b->out = room(b, ROOM_OUT, numbers);
  if (b->out) memset(b->out, 0, numbers * sizeof *b->out);
  ylm_status status = b->out ? see(b) : YLM_ENOMEM;
  if (status == YLM_OK && b->seens) status = hide(b);
  if (status == YLM_OK && s->rest) status = w->even ? add_even(b) : sum_lights(b, s->rest, true);
  if (status == YLM_OK && s->local) status = sum_lights(b, s->local, false);
  size_t from = b->terms;
  for (size_t k = 0; k < s->lamps && b->seens && status == YLM_OK; k++)
    status = before_lamp(b, &s->lamp[k], from);
  if (status == YLM_OK) {
    layer(b);
    count(b);
    status = multiply(b);
  }
  if (status == YLM_OK) write(b);
  return status;
}

ylm_status EVEN(shadow_query *w, ylm_error *e) {
  size_t lanes = ylm_sh_nodes_lanes(w->nodes, DTYPE), values = tile_values(w);
  void *scratch = ylm_alloc(ylm_sh_nodes_scratch(w->nodes, DTYPE), 1);
  real *even = w->even = ylm_alloc_zero(even_before(w, w->channels), sizeof *even);
  ylm_field_query q = {.lmax = w->q->lmax,
                       .channels = (int)w->channels,
                       .want = YLM_WANT_VALUE,
                       .metric_channels = 1,
                       .dtype = DTYPE,
                       .threads = 1,
                       .origin = w->q->origin};
  /* the room of values at nodes, of which there are more than coefficients */
  real *value = even ? even_nodes(w, 0) : NULL;
  ylm_field_result r = {.value = value};
  ylm_status s = scratch && even ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) s = ylm_field_evaluate(w->s->rest, &q, 1, w->points, &r, e);
  for (size_t c = 0; c < w->channels && s == YLM_OK; c++)
    memcpy(even + c * w->rows * w->count, value + c * w->count, w->count * sizeof *even);
  for (size_t c = 0; c < w->channels && s == YLM_OK; c++) {
    const void *row[16];
    real *to = even_nodes(w, c);
    for (size_t i = 0; i < lanes; i++) row[i] = even_row(w, c);
    ylm_sh_nodes_synthesise(w->nodes, DTYPE, row, false, to, scratch);
    w->even_most[c] = largest(to, values, lanes, 0);
  }
  atomic_fetch_add(&w->pairs, r.pairs);
  ylm_free(scratch);
  return s;
}
