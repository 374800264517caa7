/* hide.real.c - what casters hide from the points of a block. */
#include "block.h"

#include <math.h>
#include <string.h>

/* Points of the block that see a caster, in its frame. */
typedef struct viewers {
  size_t n, seen[SHADOW_BLOCK];
  real at[3 * SHADOW_BLOCK];
  double
      distance[SHADOW_BLOCK]; /* from `centre`, in its frame, where a disk stands for what is far */
  bool far;                   /* some see of that disk */
  answer answer;
} viewers;

static void gather_viewers(const block *b, size_t caster, viewers *v) {
  const ylm_light_caster *c = &b->w->s->caster[caster].form;
  const double *r = c->rotation;
  v->n = 0;
  v->far = false;
  for (size_t j = b->by_caster_first[caster]; j < b->by_caster_first[caster + 1]; j++) {
    size_t seen = b->by_caster[j];
    const double *at = b->point[b->seen[seen].point];
    double x = at[0] - c->at[0], y = at[1] - c->at[1], z = at[2] - c->at[2];
    for (size_t a = 0; a < 3; a++) {
      double p = r[a] * x + r[3 + a] * y + r[6 + a] * z;
      v->at[3 * v->n + a] = (real)(c->scale == 1 ? p : p / c->scale);
    }
    if (c->far > 0) v->distance[v->n] = b->seen[seen].distance / c->scale;
    v->far |= c->far > 0 && v->distance[v->n] > SHADOW_BLEND * c->far;
    v->seen[v->n++] = seen;
  }
}

/* Lists what points see by casters, each in the order of the points. */
static ylm_status sort_by_caster(block *b) {
  size_t n = b->w->s->n;
  if (!b->by_caster_first) b->by_caster_first = ylm_alloc(n + 2, sizeof *b->by_caster_first);
  if (!b->by_caster_first ||
      !ylm__shadow_have((void **)&b->by_caster, b->seens, &b->by_room, sizeof *b->by_caster) ||
      (b->w->metric &&
       !ylm__shadow_have((void **)&b->blur, b->seens, &b->blur_room, sizeof *b->blur)))
    return YLM_ENOMEM;
  size_t *first = b->by_caster_first;
  memset(first, 0, (n + 2) * sizeof *first);
  if (b->w->metric) memset(b->blur, 0, b->seens * sizeof *b->blur);
  for (size_t j = 0; j < b->seens; j++) first[b->seen[j].caster + 2]++;
  for (size_t k = 0; k < n; k++) first[k + 2] += first[k + 1];
  for (size_t j = 0; j < b->seens; j++) {
    size_t at = first[b->seen[j].caster + 1]++;
    b->by_caster[at] = j;
    if (!b->layered) b->seen[j].row = at;
  }
  return YLM_OK;
}

/* The share of the disk at a distance, and its derivative. */
static double share(const ylm_light_caster *c, double distance, double *slope) {
  double from = SHADOW_BLEND * c->far;
  *slope = 0;
  if (!(c->far > 0) || distance <= from) return 0;
  double t = (distance - from) / (c->far - from);
  if (t >= 1) return 1;
  *slope = 6 * t * (1 - t) / (c->far - from);
  return t * t * (3 - 2 * t);
}

/* Rows of visibility at the viewers, in the body's frame, of its field alone. */
static ylm_status hide_all(block *b, const shadow_caster *c, viewers *v, real *rows) {
  const shadow_query *w = b->w;
  int lmax = c->form.lmax > w->q->lmax ? w->q->lmax : c->form.lmax;
  /* values of a field that knows all degrees stand where they are wanted */
  bool stands = w->rows == 1 && lmax == w->q->lmax;
  answer *a = &v->answer;
  ylm_status s = SHADOW(ask)(b, c->form.hides, lmax, 1, v->n, v->at, NULL, stands ? rows : NULL, a);
  for (size_t i = 0; i < v->n && s == YLM_OK; i++) {
    if (a->inside[i]) b->inside[b->seen[v->seen[i]].point] = 1;
    if (w->metric) b->blur[v->seen[i]] = (double)a->lambda[i];
    if (!stands) SHADOW(unfold)(w, a, i, ylm_sh_count(lmax), rows + i * w->rows * w->count);
  }
  return s;
}

/* Rows of visibility at the viewers, in the body's frame: of its field, of its disk, or between them. */
static ylm_status hide_near(block *b, const shadow_caster *c, viewers *v, bool disk, real *rows) {
  const shadow_query *w = b->w;
  size_t n = 0, own[SHADOW_BLOCK], row = w->rows * w->count;
  real *points = ylm_alloc(3 * v->n, sizeof *points), *one = ylm_alloc(row, sizeof *one);
  const ylm_field *f = disk ? ylm_light_occluder_field(c->disk) : c->form.hides;
  int lmax = disk || c->form.lmax > w->q->lmax ? w->q->lmax : c->form.lmax;
  double slope;
  answer *a = &v->answer;
  ylm_status s = points && one ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; i < v->n && s == YLM_OK; i++) {
    double t = share(&c->form, v->distance[i], &slope);
    if (disk ? t == 0 : t == 1) continue;
    memcpy(points + 3 * n, v->at + 3 * i, 3 * sizeof *points);
    own[n++] = i;
  }
  if (s == YLM_OK && n) s = SHADOW(ask)(b, f, lmax, 1, n, points, NULL, NULL, a);
  for (size_t i = 0; i < n && s == YLM_OK; i++) {
    size_t j = own[i], seen = v->seen[j];
    double t = share(&c->form, v->distance[j], &slope);
    real *to = rows + j * row;
    if (w->metric && (!disk || t == 1)) b->blur[seen] = (double)a->lambda[i];
    if (a->inside[i] && !disk) b->inside[b->seen[seen].point] = 1;
    if (!disk || t == 1) {
      SHADOW(unfold)(w, a, i, ylm_sh_count(lmax), to);
      continue;
    }
    SHADOW(unfold)(w, a, i, ylm_sh_count(lmax), one);
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
  ylm_free(points);
  ylm_free(one);
  return s;
}

/* Rows of n viewers from `from` on in the body's frame become rows where it stands. */
static ylm_status place(block *b, size_t caster, const viewers *v, size_t from, size_t n,
                        real *rows) {
  const shadow_query *w = b->w;
  const shadow_caster *c = &w->s->caster[caster];
  double size = c->form.scale;
  real r[9];
  ylm_status s = YLM_OK;
  if (c->turned)
    s = ylm_sh_rotation_apply(w->turn[caster], w->q->lmax, n * w->rows, rows, rows, 1, NULL);
  for (size_t i = 0; i < 9; i++) r[i] = (real)(c->form.rotation[i] / size);
  for (size_t i = 0; i < n && (w->metric || w->rows > 1) && s == YLM_OK; i++) {
    if (w->metric) b->blur[v->seen[from + i]] /= size * size;
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

/* Room for the layers of all terms, none of which has anything yet. */
static ylm_status make_layers(block *b) {
  size_t n = 0;
  for (size_t i = 0; i < b->terms; i++) {
    shadow_term *t = &b->term[i];
    t->row = n;
    n += t->layers;
    for (size_t k = t->first; k < t->first + t->n; k++)
      b->seen[b->before[k].seen].row = t->row + (size_t)b->before[k].layer;
  }
  if (!ylm__shadow_have((void **)&b->filled, n + 1, &b->filled_room, 1)) return YLM_ENOMEM;
  memset(b->filled, 0, n);
  b->layers = room(b, ROOM_LAYERS, (n + 1) * b->w->rows * b->w->count);
  return b->layers ? YLM_OK : YLM_ENOMEM;
}

static void add_row(const shadow_query *w, real *to, const real *from) {
#ifdef YLM_REAL_IS_FLOAT
  w->add(w->rows * w->count, to, from);
#else
  for (size_t i = 0; i < w->rows * w->count; i++) to[i] += from[i];
#endif
}

/* Adds what a caster hides from n viewers from `first` on to the layers that it is in. */
static void add_to_layers(block *b, const viewers *v, size_t first, size_t n, const real *rows) {
  const shadow_query *w = b->w;
  size_t row = w->rows * w->count;
  for (size_t i = 0; i < n; i++) {
    size_t at = b->seen[v->seen[first + i]].row;
    real *to = b->layers + at * row;
    const real *from = rows + i * row;
    if (!b->filled[at]) {
      memcpy(to, from, row * sizeof *to);
      b->filled[at] = 1;
      continue;
    }
    real mean = to[0] + (from[0] - (real)LIGHT_ONE);
    add_row(w, to, from);
    to[0] = mean;
  }
}

/* Places rows of all viewers, some at a time that stay in the cache until they are added to layers. */
static ylm_status place_all(block *b, size_t caster, const viewers *v, real *rows) {
  size_t row = b->w->rows * b->w->count;
  ylm_status s = YLM_OK;
  for (size_t i = 0; i < v->n && s == YLM_OK; i += SHADOW_PLACED) {
    size_t n = v->n - i < SHADOW_PLACED ? v->n - i : SHADOW_PLACED;
    s = place(b, caster, v, i, n, rows + i * row);
    if (s == YLM_OK && b->layered) add_to_layers(b, v, i, n, rows + i * row);
  }
  return s;
}

/* Visibilities of all casters; or, where layers are known, of one after the other, which are summed while they are in the cache. */
ylm_status SHADOW(hide)(block *b) {
  const shadow_query *w = b->w;
  size_t row = w->rows * w->count;
  b->hidden = room(b, ROOM_HIDDEN, (b->layered ? b->m : b->seens) * row);
  if (!b->viewers) b->viewers = ylm_alloc(1, sizeof *b->viewers);
  viewers *v = b->viewers;
  ylm_status s = b->hidden && v ? sort_by_caster(b) : YLM_ENOMEM;
  if (s == YLM_OK && b->layered) s = make_layers(b);
  for (size_t i = 0; i < w->s->n && s == YLM_OK; i++) {
    size_t k = w->order[i];
    const shadow_caster *c = &w->s->caster[k];
    real *rows = b->hidden + (b->layered ? 0 : b->by_caster_first[k] * row);
    if (!c->form.hides || w->exponential) {
      for (size_t j = b->by_caster_first[k]; j < b->by_caster_first[k + 1]; j++) {
        const shadow_seen *seen = &b->seen[b->by_caster[j]];
        if (seen->distance <= c->radius) b->inside[seen->point] = 1;
      }
      continue;
    }
    gather_viewers(b, k, v);
    if (v->n) s = v->far ? hide_near(b, c, v, false, rows) : hide_all(b, c, v, rows);
    if (v->far && s == YLM_OK) s = hide_near(b, c, v, true, rows);
    if (s == YLM_OK) s = place_all(b, k, v, rows);
  }
  return s;
}
