/*
** fit.c - numbers at the middles of equal cells, by least squares to what an engine reads at places of surfaces.
**
** Each channel is solved alone, by conjugate gradients with a diagonal preconditioner. A place that is wanted dark and is read below
** 0 has no error, since engines show nothing below 0; which places these are is found anew in each round.
*/
#include <math.h>
#include <string.h>

#include "../grid.h"
#include "ylm_list.h"

#define ROUNDS 4
#define STEPS 80
#define QUICK_STEPS 25 /* in one round */
#define SMALL 1e-7     /* of what the preconditioned gradient was */
#define DARK 1e-6      /* of the mean: wanted below it is dark */
#define FEW 64         /* places for each probe, above which the normal matrix is made */
#define MOST_NUMBERS 4 /* with which it is */

/* The eight middles around a place. */
typedef struct around {
  uint32_t probe[8];
  float weight[8];
} around;

typedef struct fit {
  const ylm_grid_fit *f;
  size_t probes, unknowns;
  const size_t *first; /* of the probes around each place */
  const uint32_t *probe;
  const float *share;
  void *own[3]; /* theirs, of a lattice */
  double mean[3];
  size_t *of;       /* [probes + 1] NULL: no normal matrix is made. The first of a probe's shares */
  uint32_t *shares; /* indices into `probe`, by probe */
  uint32_t *place;  /* their places */
} fit;

/* The normal matrix of some weights: blocks [numbers][numbers] of probes that places have in common. */
typedef struct normal_matrix {
  size_t *first;  /* [probes + 1] of a probe's blocks */
  uint32_t *with; /* their other probes */
  double *block;
  size_t with_room, block_room;
  uint32_t *slot; /* [probes] in the row that is made */
} normal_matrix;

/* -- how an engine reads ------------------------------------------------------------------------- */

static around find(const uint32_t cells[3], const double at[3]) {
  uint32_t low[3];
  double part[3];
  around p;
  for (int a = 0; a < 3; a++) {
    double most = (double)(cells[a] - 1), x = fmin(fmax(at[a] - 0.5, 0), most);
    double floor_x = fmin(floor(x), most > 1 ? most - 1 : 0);
    low[a] = (uint32_t)floor_x;
    part[a] = x - floor_x;
  }
  for (uint32_t k = 0; k < 8; k++) {
    size_t probe = 0, stride = 1;
    double w = 1;
    for (int a = 0; a < 3; a++) {
      uint32_t up = k >> a & 1, i = low[a] + up;
      w *= up ? part[a] : 1 - part[a];
      probe += stride * (i < cells[a] ? i : cells[a] - 1);
      stride *= cells[a];
    }
    p.probe[k] = (uint32_t)probe;
    p.weight[k] = (float)w;
  }
  return p;
}

/* `look` of n numbers: with a constant n, loops over them are unrolled. */
static inline double look_n(const fit *t, size_t n, size_t i, const double *x) {
  const float *basis = t->f->basis + i * n;
  double sum = 0;
  for (size_t k = t->first[i]; k < t->first[i + 1]; k++) {
    const double *v = x + n * t->probe[k];
    double s = 0;
    for (size_t j = 0; j < n; j++) s += (double)basis[j] * v[j];
    sum += (double)t->share[k] * s;
  }
  return sum;
}

static inline void put_n(const fit *t, size_t n, size_t i, double y, double *x) {
  const float *basis = t->f->basis + i * n;
  for (size_t k = t->first[i]; k < t->first[i + 1]; k++) {
    double w = y * (double)t->share[k], *v = x + n * t->probe[k];
    if (w == 0) continue;
    for (size_t j = 0; j < n; j++) v[j] += w * (double)basis[j];
  }
}

/* The irradiance that is read at a place of numbers x [probes][numbers]. */
static double look(const fit *t, size_t i, const double *x) {
  size_t n = (size_t)t->f->numbers;
  return n == 4 ? look_n(t, 4, i, x) : n == 9 ? look_n(t, 9, i, x) : look_n(t, n, i, x);
}

/* Adds y times the row of a place. */
static void put(const fit *t, size_t i, double y, double *x) {
  size_t n = (size_t)t->f->numbers;
  if (n == 4)
    put_n(t, 4, i, y, x);
  else if (n == 9)
    put_n(t, 9, i, y, x);
  else
    put_n(t, n, i, y, x);
}

/* -- a channel ----------------------------------------------------------------------------------- */

typedef struct channel {
  const fit *t;
  int c;
  double *x, *begin, *weight; /* [unknowns], [unknowns], [places] */
  double *g, *z, *d, *q, *p;
  normal_matrix m;
} channel;

static double held(const fit *t, size_t i) {
  size_t n = (size_t)t->f->numbers;
  return (double)t->f->hold[i / n] * (double)t->f->norm[i % n];
}

/* Weights of places: 0 where one is wanted dark and read so. True: some are other than before. */
static bool weigh(channel *h) {
  const fit *t = h->t;
  int channels = t->f->channels;
  bool changed = false;
  for (size_t i = 0; i < t->f->places; i++) {
    double wanted = (double)t->f->wanted[i * (size_t)channels + (size_t)h->c];
    bool dark = wanted <= DARK * t->mean[h->c] && look(t, i, h->x) <= wanted;
    double weight = dark ? 0 : (double)t->f->weight[i];
    changed |= weight != h->weight[i];
    h->weight[i] = weight;
  }
  return changed;
}

/* -- the normal matrix --------------------------------------------------------------------------- */

static void leave_matrix(normal_matrix *m) {
  ylm_free(m->first);
  ylm_free(m->with);
  ylm_free(m->block);
  ylm_free(m->slot);
}

/* Adds w times the product of a basis with itself to a block. */
static inline void add_product(size_t n, double w, const float *basis, double *block) {
  for (size_t a = 0; a < n; a++) {
    double wa = w * (double)basis[a];
    for (size_t b = 0; b < n; b++) block[a * n + b] += wa * (double)basis[b];
  }
}

/* The row of a probe, whose first block is block `at`. */
static bool make_row(channel *h, size_t probe, size_t at) {
  const fit *t = h->t;
  normal_matrix *m = &h->m;
  size_t n = (size_t)t->f->numbers, end = at;
  for (size_t s = t->of[probe]; s < t->of[probe + 1]; s++) {
    size_t i = t->place[s];
    double w = h->weight[i] * (double)t->share[t->shares[s]];
    for (size_t k = t->first[i]; w != 0 && k < t->first[i + 1]; k++) {
      uint32_t other = t->probe[k];
      if (m->slot[other] < at || m->slot[other] >= end || m->with[m->slot[other]] != other) {
        if (!ylm_list_reserve(&m->with, end, end + 1, &m->with_room, sizeof *m->with) ||
            !ylm_list_reserve(&m->block, end, end + 1, &m->block_room, n * n * sizeof *m->block))
          return false;
        memset(m->block + end * n * n, 0, n * n * sizeof *m->block);
        m->with[end] = other;
        m->slot[other] = (uint32_t)end++;
      }
      double *block = m->block + m->slot[other] * n * n, x = w * (double)t->share[k];
      if (n == 4)
        add_product(4, x, t->f->basis + 4 * i, block);
      else
        add_product(n, x, t->f->basis + n * i, block);
    }
  }
  m->first[probe + 1] = end;
  return true;
}

/* The matrix of a channel's weights. False: no memory. */
static bool make_matrix(channel *h) {
  const fit *t = h->t;
  normal_matrix *m = &h->m;
  if (!t->of) return true;
  if (!m->first) {
    m->first = ylm_alloc_zero(t->probes + 1, sizeof *m->first);
    m->slot = ylm_alloc_zero(t->probes, sizeof *m->slot);
  }
  bool ok = m->first && m->slot;
  for (size_t i = 0; ok && i < t->probes; i++) ok = make_row(h, i, m->first[i]);
  return ok;
}

/* The product of a probe's row of blocks with d, added to sum [n]: blocks are symmetric. */
static inline void multiply_row(const normal_matrix *m, size_t n, size_t probe, const double *d,
                                double *sum) {
  for (size_t k = m->first[probe]; k < m->first[probe + 1]; k++) {
    const double *block = m->block + k * n * n, *v = d + m->with[k] * n;
    for (size_t b = 0; b < n; b++)
      for (size_t a = 0; a < n; a++) sum[a] += block[b * n + a] * v[b];
  }
}

static void apply_matrix(const channel *h, const double *d, double *out) {
  size_t n = (size_t)h->t->f->numbers;
  for (size_t i = 0; i < h->t->probes; i++) {
    double sum[MOST_NUMBERS] = {0};
    if (n == 4)
      multiply_row(&h->m, 4, i, d, sum);
    else
      multiply_row(&h->m, n, i, d, sum);
    for (size_t a = 0; a < n; a++) out[i * n + a] = sum[a] + held(h->t, i * n + a) * d[i * n + a];
  }
}

/* Shares by their probes, where a matrix is worth its making. */
static ylm_status sort_shares(fit *t) {
  const ylm_grid_fit *f = t->f;
  if (!f->first || f->numbers > MOST_NUMBERS || t->probes * FEW > f->places) return YLM_OK;
  size_t shares = f->first[f->places];
  t->of = ylm_alloc_zero(t->probes + 2, sizeof *t->of);
  t->shares = ylm_alloc(shares + 1, sizeof *t->shares);
  t->place = ylm_alloc(shares + 1, sizeof *t->place);
  if (!t->of || !t->shares || !t->place) return YLM_ENOMEM;
  for (size_t k = 0; k < shares; k++) t->of[t->probe[k] + 2]++;
  for (size_t i = 1; i < t->probes; i++) t->of[i + 1] += t->of[i];
  for (size_t i = 0; i < f->places; i++)
    for (size_t k = t->first[i]; k < t->first[i + 1]; k++) {
      size_t to = t->of[t->probe[k] + 1]++;
      t->shares[to] = (uint32_t)k;
      t->place[to] = (uint32_t)i;
    }
  return YLM_OK;
}

/* -- conjugate gradients --------------------------------------------------------------------------- */

/* out = the rows' transpose times weights times rows of d, and what holds probes. */
static void apply(const channel *h, const double *d, double *out) {
  const fit *t = h->t;
  if (t->of) {
    apply_matrix(h, d, out);
    return;
  }
  for (size_t i = 0; i < t->unknowns; i++) out[i] = held(t, i) * d[i];
  for (size_t i = 0; i < t->f->places; i++)
    if (h->weight[i] > 0) put(t, i, h->weight[i] * look(t, i, d), out);
}

/* The gradient's opposite at x. */
static void descend(const channel *h) {
  const fit *t = h->t;
  size_t channels = (size_t)t->f->channels;
  for (size_t i = 0; i < t->unknowns; i++) h->g[i] = held(t, i) * (h->begin[i] - h->x[i]);
  for (size_t i = 0; i < t->f->places; i++)
    if (h->weight[i] > 0)
      put(t, i,
          h->weight[i] * ((double)t->f->wanted[i * channels + (size_t)h->c] - look(t, i, h->x)),
          h->g);
}

static void precondition(const channel *h) {
  const fit *t = h->t;
  size_t n = (size_t)t->f->numbers;
  for (size_t i = 0; i < t->unknowns; i++) h->p[i] = held(t, i);
  for (size_t i = 0; i < t->f->places; i++) {
    const float *basis = t->f->basis + i * n;
    for (size_t k = t->first[i]; h->weight[i] > 0 && k < t->first[i + 1]; k++)
      for (size_t j = 0; j < n; j++) {
        double w = (double)t->share[k] * (double)basis[j];
        h->p[n * t->probe[k] + j] += h->weight[i] * w * w;
      }
  }
  for (size_t i = 0; i < t->unknowns; i++) h->p[i] = h->p[i] > 0 ? 1 / h->p[i] : 0;
}

static double dot(size_t n, const double *a, const double *b) {
  double s = 0;
  for (size_t i = 0; i < n; i++) s += a[i] * b[i];
  return s;
}

static void descend_to_rest(channel *h) {
  size_t n = h->t->unknowns;
  precondition(h);
  descend(h);
  for (size_t i = 0; i < n; i++) h->d[i] = h->z[i] = h->p[i] * h->g[i];
  double rz = dot(n, h->g, h->z), enough = SMALL * rz;
  for (int step = 0; step < (h->t->f->quick ? QUICK_STEPS : STEPS) && rz > enough; step++) {
    apply(h, h->d, h->q);
    double dq = dot(n, h->d, h->q), before = rz;
    if (!(dq > 0)) return;
    double a = rz / dq;
    for (size_t i = 0; i < n; i++) {
      h->x[i] += a * h->d[i];
      h->g[i] -= a * h->q[i];
      h->z[i] = h->p[i] * h->g[i];
    }
    rz = dot(n, h->g, h->z);
    for (size_t i = 0; i < n; i++) h->d[i] = h->z[i] + rz / before * h->d[i];
  }
}

/* One channel of the probes, in place. */
static ylm_status solve(void *context, size_t begin, size_t end, int worker) {
  (void)end;
  (void)worker;
  const fit *t = context;
  size_t n = t->unknowns, numbers = (size_t)t->f->numbers, channels = (size_t)t->f->channels;
  double *room = ylm_alloc_zero(7 * n + t->f->places, sizeof *room);
  if (!room) return YLM_ENOMEM;
  channel h = {.t = t,
               .c = (int)begin,
               .x = room,
               .begin = room + n,
               .g = room + 2 * n,
               .z = room + 3 * n,
               .d = room + 4 * n,
               .q = room + 5 * n,
               .p = room + 6 * n,
               .weight = room + 7 * n};
  for (size_t i = 0; i < n; i++)
    h.x[i] = h.begin[i] =
        (double)t->f->probe[(i / numbers * channels + begin) * numbers + i % numbers];
  bool ok = true;
  for (int round = 0; ok && round < (t->f->quick ? 1 : ROUNDS) && weigh(&h); round++) {
    ok = make_matrix(&h);
    if (ok) descend_to_rest(&h);
  }
  for (size_t i = 0; i < n; i++)
    t->f->probe[(i / numbers * channels + begin) * numbers + i % numbers] = (float)h.x[i];
  leave_matrix(&h.m);
  ylm_free(room);
  return ok ? YLM_OK : YLM_ENOMEM;
}

/* -- all of it ----------------------------------------------------------------------------------- */

static void leave(fit *t) {
  for (int i = 0; i < 3; i++) ylm_free(t->own[i]);
  ylm_free(t->of);
  ylm_free(t->shares);
  ylm_free(t->place);
}

/* The eight middles around each place of a lattice. */
static ylm_status find_all(fit *t) {
  const ylm_grid_fit *f = t->f;
  size_t *first = t->own[0] = ylm_alloc(f->places + 1, sizeof *first);
  uint32_t *probe = t->own[1] = ylm_alloc(f->places + 1, 8 * sizeof *probe);
  float *share = t->own[2] = ylm_alloc(f->places + 1, 8 * sizeof *share);
  if (!first || !probe || !share) return YLM_ENOMEM;
  for (size_t i = 0; i < f->places; i++) {
    around p = find(f->cells, f->at[i]);
    first[i] = 8 * i;
    memcpy(probe + 8 * i, p.probe, sizeof p.probe);
    memcpy(share + 8 * i, p.weight, sizeof p.weight);
  }
  first[f->places] = 8 * f->places;
  t->first = first;
  t->probe = probe;
  t->share = share;
  return YLM_OK;
}

static ylm_status prepare(fit *t) {
  const ylm_grid_fit *f = t->f;
  t->probes = f->first ? f->probes : (size_t)f->cells[0] * f->cells[1] * f->cells[2];
  t->unknowns = t->probes * (size_t)f->numbers;
  t->first = f->first;
  t->probe = f->around;
  t->share = f->share;
  for (size_t i = 0; i < f->places; i++)
    for (int c = 0; f->wanted && c < f->channels; c++)
      t->mean[c] += (double)f->wanted[i * (size_t)f->channels + (size_t)c] / (double)f->places;
  return f->first ? YLM_OK : find_all(t);
}

/* How many channels are solved: 1 where what is wanted, and what probes have, are grey. */
static size_t different(const fit *t) {
  const ylm_grid_fit *f = t->f;
  size_t channels = (size_t)f->channels;
  for (size_t i = 0; i < f->places; i++)
    for (size_t c = 1; c < channels; c++)
      if (f->wanted[i * channels + c] != f->wanted[i * channels]) return channels;
  for (size_t i = 0; i < t->unknowns; i++)
    for (size_t c = 1, n = (size_t)f->numbers; c < channels; c++) {
      const float *one = f->probe + i / n * channels * n + i % n;
      if (one[c * n] != one[0]) return channels;
    }
  return 1;
}

/* The other channels of grey probes are the first. */
static void spread(const fit *t) {
  size_t n = (size_t)t->f->numbers, channels = (size_t)t->f->channels;
  for (size_t i = 0; i < t->probes; i++)
    for (size_t c = 1; c < channels; c++) {
      float *one = t->f->probe + i * channels * n;
      memcpy(one + c * n, one, n * sizeof *one);
    }
}

ylm_status ylm_grid_fit_probes(const ylm_grid_fit *f) {
  fit t = {.f = f};
  ylm_status s = prepare(&t);
  if (s == YLM_OK) s = sort_shares(&t);
  size_t channels = s == YLM_OK ? different(&t) : 0;
  if (s == YLM_OK) s = ylm_parallel(channels, 1, f->threads, solve, &t, NULL, NULL);
  if (s == YLM_OK && channels == 1) spread(&t);
  leave(&t);
  return s;
}

ylm_status ylm_grid_fit_look(const ylm_grid_fit *f, float *out) {
  fit t = {.f = f};
  size_t n = (size_t)f->numbers, channels = (size_t)f->channels;
  ylm_status s = prepare(&t);
  double *x = s == YLM_OK ? ylm_alloc(t.unknowns, sizeof *x) : NULL;
  if (!x) s = YLM_ENOMEM;
  for (size_t c = 0; s == YLM_OK && c < channels; c++) {
    for (size_t i = 0; i < t.unknowns; i++)
      x[i] = (double)f->probe[(i / n * channels + c) * n + i % n];
    for (size_t i = 0; i < f->places; i++) out[i * channels + c] = (float)fmax(0, look(&t, i, x));
  }
  ylm_free(x);
  leave(&t);
  return s;
}
