/* fit.c - values at corners by least squares: conjugate gradients, each channel alone. */
#include <math.h>

#include "surface.h"

/* Rows of weights of unknowns. */
typedef struct rows {
  surface_term *term;
  size_t terms, term_room;
  size_t *first; /* [n + 1] */
  size_t n, first_room;
  double (*target)[3], (*weight)[3]; /* [n] */
  size_t target_room, weight_room;
} rows;

typedef struct fit {
  surface_bake *b;
  surface_term *term; /* of classes */
  size_t terms, term_room;
  size_t *first, *count; /* [classes] */
  uint8_t *state;        /* [classes] */
  rows row;
  double *x; /* [3][unknowns] */
} fit;

enum { STATE_NEW, STATE_OPEN, STATE_DONE };

/* -- classes as sums of unknowns --------------------------------------------------------------- */

/* Adds a term to those from `first` on. */
static ylm_status add(surface_term **term, size_t *n, size_t *room, size_t first, uint32_t unknown,
                      float weight) {
  for (size_t i = first; i < *n; i++)
    if ((*term)[i].unknown == unknown) {
      (*term)[i].weight += weight;
      return YLM_OK;
    }
  if (!ylm_list_reserve(term, *n, *n + 1, room, sizeof **term)) return YLM_ENOMEM;
  (*term)[(*n)++] = (surface_term){unknown, weight};
  return YLM_OK;
}

static ylm_status make_free(fit *f, uint32_t k) {
  surface_class *c = &f->b->class[k];
  if (c->free == SURFACE_NONE) c->free = (uint32_t)f->b->unknowns++;
  f->first[k] = f->terms;
  f->count[k] = 1;
  f->state[k] = STATE_DONE;
  return add(&f->term, &f->terms, &f->term_room, f->terms, c->free, 1);
}

/* The terms of a class. One that hangs on itself over others is free. */
static ylm_status expand(fit *f, uint32_t k) {
  surface_class *c = &f->b->class[k];
  if (f->state[k] == STATE_DONE) return YLM_OK;
  if (f->state[k] == STATE_OPEN || c->host == SURFACE_NONE) return make_free(f, k);
  f->state[k] = STATE_OPEN;
  const surface_leaf *host = &f->b->leaf[c->host];
  const surface_branch *r = &f->b->branch[host->branch];
  const float at[2] = {c->at[0], c->at[1]};
  float w[4];
  ylm__surface_weights(r->lo, r->hi, at, w);
  for (int i = 0; i < 4; i++) {
    if (!(w[i] > 1e-6f)) continue;
    ylm_status s = expand(f, host->corner[i]);
    if (s != YLM_OK) return s;
  }
  if (f->state[k] == STATE_DONE) return YLM_OK; /* freed below */
  size_t first = f->terms;
  for (int i = 0; i < 4; i++) {
    if (!(w[i] > 1e-6f)) continue;
    size_t from = f->first[host->corner[i]], n = f->count[host->corner[i]];
    for (size_t t = from; t < from + n; t++) {
      surface_term x = f->term[t];
      ylm_status s = add(&f->term, &f->terms, &f->term_room, first, x.unknown, w[i] * x.weight);
      if (s != YLM_OK) return s;
    }
  }
  f->first[k] = first;
  f->count[k] = f->terms - first;
  f->state[k] = STATE_DONE;
  return YLM_OK;
}

static ylm_status expand_all(fit *f) {
  f->b->unknowns = 0;
  ylm_status s = YLM_OK;
  for (uint32_t k = 0; s == YLM_OK && k < f->b->classes; k++) s = expand(f, k);
  return s;
}

/* -- rows ------------------------------------------------------------------------------------- */

/* Adds a corner of a leaf to the row in the making. */
static ylm_status put(fit *f, const surface_leaf *l, int corner, float weight) {
  rows *r = &f->row;
  uint32_t k = l->corner[corner];
  ylm_status s = YLM_OK;
  for (size_t t = f->first[k]; s == YLM_OK && t < f->first[k] + f->count[k]; t++)
    s = add(&r->term, &r->terms, &r->term_room, r->first[r->n], f->term[t].unknown,
            weight * f->term[t].weight);
  return s;
}

/* The row in the making is whole. */
static ylm_status end_row(rows *r, const double target[3], const double weight[3]) {
  size_t n = r->n + 1;
  if (!ylm_list_reserve(&r->first, n, n + 1, &r->first_room, sizeof *r->first) ||
      !ylm_list_reserve(&r->target, r->n, n, &r->target_room, sizeof *r->target) ||
      !ylm_list_reserve(&r->weight, r->n, n, &r->weight_room, sizeof *r->weight))
    return YLM_ENOMEM;
  memcpy(r->target[r->n], target, sizeof r->target[0]);
  memcpy(r->weight[r->n], weight, sizeof r->weight[0]);
  r->n = n;
  r->first[n] = r->terms;
  return YLM_OK;
}

/* Weights of the places of a leaf, by the mean of their light: if each had that of its own, those whose noise makes them
   bright would count less, and light would be too dim. */
static void weigh(const surface_bake *b, const surface_leaf *l, double weight[3]) {
  double sum[3] = {0, 0, 0}, E[3];
  for (size_t k = l->first; k < l->first + l->sampled; k++) {
    ylm__surface_mid(&b->light[b->site[b->entry[k].site].light], E);
    for (int c = 0; c < 3; c++) sum[c] += E[c] / (double)l->sampled;
  }
  for (int c = 0; c < 3; c++) {
    double m = ylm__surface_scale(b, sum[c], c);
    weight[c] = m > 0 ? 1 / (m * m) : 0;
  }
}

static ylm_status add_site(fit *f, const surface_site *p, const double weight[3]) {
  const surface_bake *b = f->b;
  surface_spot spot[3];
  uint32_t leaf[3];
  float have = 0;
  int n = ylm__surface_spots(&b->charts, &p->at, p->position, p->normal, spot);
  ylm_status s = YLM_OK;
  for (int i = 0; i < n; i++) {
    leaf[i] = ylm__surface_descend(b, &spot[i], p->position);
    if (leaf[i] != SURFACE_NONE && b->leaf[leaf[i]].sampled) have += spot[i].weight;
  }
  for (int i = 0; s == YLM_OK && i < n; i++) {
    if (leaf[i] == SURFACE_NONE || !b->leaf[leaf[i]].sampled) continue;
    const surface_leaf *l = &b->leaf[leaf[i]];
    float w[4];
    const surface_branch *r = &b->branch[l->branch];
    ylm__surface_weights(r->lo, r->hi, spot[i].at, w);
    for (int c = 0; s == YLM_OK && c < 4; c++) s = put(f, l, c, spot[i].weight / have * w[c]);
  }
  double E[3];
  ylm__surface_mid(&b->light[p->light], E);
  return s == YLM_OK ? end_row(&f->row, E, weight) : s;
}

/* Holds a leaf where places are few: it twists little, and its edges are level. */
static ylm_status add_leaf(fit *f, const surface_leaf *l) {
  static const float rule[5][4] = {
      {1, -1, -1, 1}, {1, -1, 0, 0}, {0, 0, 1, -1}, {1, 0, -1, 0}, {0, 1, 0, -1}};
  static const double none[3] = {0, 0, 0};
  ylm_status s = YLM_OK;
  for (int k = 0; s == YLM_OK && k < 5; k++) {
    double weight[3];
    for (int c = 0; c < 3; c++) {
      double m = f->b->mean[c];
      weight[c] = m > 0 ? (k ? SLOPE : TWIST) / (m * m) : 0;
    }
    for (int c = 0; s == YLM_OK && c < 4; c++)
      if (rule[k][c] != 0) s = put(f, l, c, rule[k][c]);
    if (s == YLM_OK) s = end_row(&f->row, none, weight);
  }
  return s;
}

static ylm_status make_rows(fit *f) {
  const surface_bake *b = f->b;
  if (!ylm_list_reserve(&f->row.first, 0, 1, &f->row.first_room, sizeof *f->row.first))
    return YLM_ENOMEM;
  f->row.first[0] = 0;
  ylm_status s = YLM_OK;
  for (size_t i = 0; s == YLM_OK && i < b->leaves; i++) {
    const surface_leaf *l = &b->leaf[i];
    double weight[2][3] = {{0}}; /* of open and of covered places */
    if (l->sampled) weigh(b, l, weight[0]);
    for (int c = 0; c < 3; c++) weight[1][c] = COVERED_WEIGHT * weight[0][c];
    for (size_t k = l->first; s == YLM_OK && k < l->first + l->sampled; k++) {
      const surface_site *p = &b->site[b->entry[k].site];
      s = add_site(f, p, weight[p->known == SITE_COVERED]);
    }
    if (s == YLM_OK && l->sampled) s = add_leaf(f, l);
  }
  return s;
}

/* -- the solution ----------------------------------------------------------------------------- */

/* The mean of what the leaves had at a class's corners before; of the first fit that of all light. */
static ylm_status guess(fit *f) {
  surface_bake *b = f->b;
  uint32_t *n = ylm_alloc_zero(b->unknowns, sizeof *n);
  if (!n) return YLM_ENOMEM;
  for (size_t i = 0; i < 3 * b->unknowns; i++) f->x[i] = 0;
  for (size_t i = 0; i < b->leaves; i++)
    for (int c = 0; b->leaf[i].sampled && c < 4; c++) {
      uint32_t u = b->class[b->leaf[i].corner[c]].free;
      if (u == SURFACE_NONE) continue;
      n[u]++;
      for (size_t k = 0; k < 3; k++)
        f->x[k * b->unknowns + u] += b->stats.rounds ? (double)b->leaf[i].value[c][k] : b->mean[k];
    }
  for (size_t u = 0; u < b->unknowns; u++)
    for (size_t k = 0; k < 3; k++) f->x[k * b->unknowns + u] /= n[u] ? n[u] : 1;
  ylm_free(n);
  return YLM_OK;
}

/* out = sum over rows of weight (row . d - target) row; `target` false: without targets. */
static void apply(const rows *r, int c, const double *d, bool target, size_t n, double *out) {
  for (size_t i = 0; i < n; i++) out[i] = 0;
  for (size_t i = 0; i < r->n; i++) {
    double sum = target ? -r->target[i][c] : 0;
    for (size_t t = r->first[i]; t < r->first[i + 1]; t++)
      sum += (double)r->term[t].weight * d[r->term[t].unknown];
    sum *= r->weight[i][c];
    for (size_t t = r->first[i]; t < r->first[i + 1]; t++)
      out[r->term[t].unknown] += (double)r->term[t].weight * sum;
  }
}

static double dot(size_t n, const double *a, const double *b) {
  double s = 0;
  for (size_t i = 0; i < n; i++) s += a[i] * b[i];
  return s;
}

/* One channel, in place. */
static ylm_status solve(void *context, size_t begin, size_t end, int worker) {
  (void)end;
  (void)worker;
  fit *f = context;
  size_t n = f->b->unknowns;
  const rows *r = &f->row;
  int c = (int)begin;
  double *x = f->x + begin * n, *room = ylm_alloc_zero(5 * n, sizeof *room);
  if (!room) return YLM_ENOMEM;
  double *g = room, *z = g + n, *d = z + n, *q = d + n, *p = q + n, size = 0;
  for (size_t i = 0; i < r->n; i++)
    for (size_t t = r->first[i]; t < r->first[i + 1]; t++) {
      double w = (double)r->term[t].weight;
      p[r->term[t].unknown] += r->weight[i][c] * w * w;
    }
  for (size_t i = 0; i < n; i++) size += p[i] * f->b->mean[c] * f->b->mean[c];
  apply(r, c, x, true, n, g);
  for (size_t i = 0; i < n; i++) {
    g[i] = -g[i];
    d[i] = z[i] = p[i] > 0 ? g[i] / p[i] : 0;
  }
  double rz = dot(n, g, z);
  for (int step = 0; step < FIT_STEPS && rz > FIT_SMALL * size; step++) {
    apply(r, c, d, false, n, q);
    double dq = dot(n, d, q);
    if (!(dq > 0)) break;
    double a = rz / dq, before = rz;
    for (size_t i = 0; i < n; i++) {
      x[i] += a * d[i];
      g[i] -= a * q[i];
      z[i] = p[i] > 0 ? g[i] / p[i] : 0;
    }
    rz = dot(n, g, z);
    for (size_t i = 0; i < n; i++) d[i] = z[i] + rz / before * d[i];
  }
  ylm_free(room);
  return YLM_OK;
}

/* Values of classes, at least 0, and of the leaves' corners. */
static void spread(fit *f) {
  surface_bake *b = f->b;
  size_t n = b->unknowns;
  for (size_t k = 0; k < b->classes; k++)
    for (size_t c = 0; c < 3; c++) {
      double sum = 0;
      for (size_t t = f->first[k]; t < f->first[k] + f->count[k]; t++)
        sum += (double)f->term[t].weight * fmax(0, f->x[c * n + f->term[t].unknown]);
      b->class[k].value[c] = (float)sum;
    }
  for (size_t i = 0; i < b->leaves; i++)
    for (int c = 0; b->leaf[i].sampled && c < 4; c++)
      memcpy(b->leaf[i].value[c], b->class[b->leaf[i].corner[c]].value, sizeof b->leaf[i].value[c]);
}

void ylm__surface_mean(surface_bake *b) {
  double sum[3] = {0, 0, 0}, all = 0;
  for (size_t i = 0; i < b->leaves; i++) {
    const surface_leaf *l = &b->leaf[i];
    if (!l->sampled) continue;
    double part = l->weight / (double)l->sampled, E[3];
    for (size_t k = l->first; k < l->first + l->sampled; k++) {
      ylm__surface_mid(&b->light[b->site[b->entry[k].site].light], E);
      for (int c = 0; c < 3; c++) sum[c] += part * E[c];
    }
    all += l->weight;
  }
  for (int c = 0; c < 3; c++) b->mean[c] = all > 0 ? sum[c] / all : 0;
}

ylm_status ylm__surface_fit(surface_bake *b) {
  fit f = {.b = b};
  ylm__surface_mean(b);
  f.first = ylm_alloc(b->classes, sizeof *f.first);
  f.count = ylm_alloc(b->classes, sizeof *f.count);
  f.state = ylm_alloc_zero(b->classes, 1);
  ylm_status s = f.first && f.count && f.state ? expand_all(&f) : YLM_ENOMEM;
  if (s == YLM_OK) s = make_rows(&f);
  if (s == YLM_OK && !(f.x = ylm_alloc(3 * b->unknowns, sizeof *f.x))) s = YLM_ENOMEM;
  if (s == YLM_OK) s = guess(&f);
  if (s == YLM_OK && b->unknowns)
    s = ylm_parallel(3, 1, b->form->light.threads, solve, &f, NULL, NULL);
  if (s == YLM_OK) spread(&f);
  ylm_free(f.term);
  ylm_free(f.first);
  ylm_free(f.count);
  ylm_free(f.state);
  ylm_free(f.row.term);
  ylm_free(f.row.first);
  ylm_free(f.row.target);
  ylm_free(f.row.weight);
  ylm_free(f.x);
  return s;
}
