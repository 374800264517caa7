/* before.real.c - lights at the points of a block, and the casters before each. */
#include "block.h"

#include <math.h>
#include <string.h>

static ylm_status new_light(block *b, size_t *at) {
  size_t wide = b->w->channels * b->w->rows * b->w->count * sizeof(real);
  if (!grow((void **)&b->light, b->lights, &b->light_room, wide)) return YLM_ENOMEM;
  memset((char *)b->light + b->lights * wide, 0, wide);
  *at = b->lights++;
  return YLM_OK;
}

static ylm_status new_term(block *b, shadow_term t) {
  if (!grow((void **)&b->term, b->terms, &b->term_room, sizeof *b->term)) return YLM_ENOMEM;
  b->term[b->terms++] = t;
  return YLM_OK;
}

/* A part of which there is none yet, or all of a caster. */
static ylm_status new_part(block *b, shadow_part p, uint32_t *at) {
  if (!grow((void **)&b->part, b->parts, &b->part_room, sizeof *b->part)) return YLM_ENOMEM;
  if (!b->parts) b->part[b->parts++] = (shadow_part){.weight = 1};
  *at = 0;
  if (p.weight == 1) return YLM_OK;
  if (!grow((void **)&b->part, b->parts, &b->part_room, sizeof *b->part)) return YLM_ENOMEM;
  b->part[ *at = (uint32_t)b->parts++] = p;
  return YLM_OK;
}

static ylm_status add_before(block *b, shadow_before x) {
  if (!grow((void **)&b->before, b->befores, &b->before_room, sizeof *b->before)) return YLM_ENOMEM;
  b->before[b->befores++] = x;
  return YLM_OK;
}

/* Casters seen from `first` on stand wholly before the next light. */
static ylm_status all_before(block *b, size_t first, size_t n) {
  uint32_t all;
  ylm_status s = new_part(b, (shadow_part){.weight = 1}, &all);
  if (s != YLM_OK) return s;
  for (size_t j = 0; j < n; j++) {
    if (!grow((void **)&b->before, b->befores, &b->before_room, sizeof *b->before))
      return YLM_ENOMEM;
    shadow_before *x = &b->before[b->befores++];
    x->seen = first + j;
    x->layer = 0;
    x->part = all;
  }
  return YLM_OK;
}

/* How much of caster c counts before lamp l, and its derivative: all where their cones meet, nothing where they are
   farther apart than a wave of lmax. */
static double meets(int lmax, const shadow_seen *c, const shadow_seen *l, double slope[3]) {
  double cosine = c->w[0] * l->w[0] + c->w[1] * l->w[1] + c->w[2] * l->w[2];
  double margin = YLM_PI / (lmax + 1), apart = acos(fmax(-1, fmin(1, cosine)));
  double t = (apart - shadow_angle(c) - shadow_angle(l)) / margin;
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
    if (b->before[k].part) return NULL;
  for (size_t j = from; j < b->terms; j++) {
    shadow_term *t = &b->term[j];
    bool same = t->point == point && t->n == n;
    for (size_t k = 0; same && k < n; k++)
      same = b->before[t->first + k].seen == b->before[first + k].seen &&
             !b->before[t->first + k].part;
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
  answer a;
  ylm_status s = one ? SHADOW(ask)(b, ylm_light_set_field(l->grey), w->q->lmax, 1, b->requests,
                                   points, from, NULL, &a)
                     : YLM_ENOMEM;
  for (size_t i = 0; i < b->requests && s == YLM_OK; i++) {
    SHADOW(unfold)(w, &a, i, w->count, one);
    for (size_t c = 0; c < w->channels; c++) {
      real *to = b->light + (b->request[i].light * w->channels + c) * row;
      double rgb = ylm__emission(l->rgb, (int)w->channels, (int)c);
      for (size_t k = 0; k < row; k++) to[k] += (real)rgb * one[k];
    }
  }
  ylm_free(one);
  return s;
}

ylm_status SHADOW(before_lamp)(block *b, const shadow_lamp *l, size_t from) {
  ylm_status s = YLM_OK;
  b->requests = 0;
  for (size_t i = 0; i < b->m && s == YLM_OK; i++) {
    shadow_seen lamp;
    size_t first = b->befores, light = 0;
    SHADOW(look)(b->point[i], l->at, l->radius, 0, &lamp);
    for (size_t j = b->seen_first[i]; j < b->seen_first[i + 1] && s == YLM_OK; j++) {
      shadow_before x = {.seen = j};
      if (b->seen[j].distance >= lamp.distance) break;
      shadow_part part;
      part.weight = meets(b->w->q->lmax, &b->seen[j], &lamp, part.slope);
      if (!(part.weight > 0)) continue;
      s = new_part(b, part, &x.part);
      if (s == YLM_OK) s = add_before(b, x);
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

ylm_status SHADOW(add_even)(block *b) {
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
      memcpy(out_row(b, i) + c * w->rows * w->count, even_row(w, c), w->count * sizeof(real));
  }
  return s;
}

ylm_status SHADOW(sum_lights)(block *b, const ylm_field *f, bool behind) {
  const shadow_query *w = b->w;
  const real *points = (const real *)w->points + 3 * b->begin;
  size_t row = w->rows * w->count;
  answer a;
  ylm_status s = SHADOW(ask)(b, f, w->q->lmax, w->channels, b->m, points, w->q->origin, NULL, &a);
  for (size_t i = 0; i < b->m && s == YLM_OK; i++) {
    real *to = out_row(b, i);
    size_t n = b->seen_first[i + 1] - b->seen_first[i], light = 0, first = b->befores;
    b->any[i] |= a.inside[i];
    if (w->metric) b->lambda[i] += (double)a.lambda[i];
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
        SHADOW(unfold)(w, &a, i * w->channels + c, w->count, one);
      else {
        /* added: lamps and light behind casters may both be there */
        const real *v = a.value + (i * w->channels + c) * w->count;
        for (size_t k = 0; k < w->count; k++) one[k] += v[k];
        const real *g = w->rows > 1 ? a.gradient + 3 * (i * w->channels + c) * w->count : NULL;
        for (size_t k = 0; g && k < w->count; k++)
          for (size_t d = 0; d < 3; d++) one[(d + 1) * w->count + k] += g[3 * k + d];
      }
  }
  return s;
}
