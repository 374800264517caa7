/*
** fit.c - texels by least squares, as bilinear look-ups read them: conjugate gradients for each channel of each half of the rays.
**
** Rows are places of light, bends of three texels in a line, differences of two, and places of seams. Bends weigh as the
** places around them do, so that they blur bright and dark light alike. All channels and halves have one matrix, so the mean
** of the halves is the fit of both.
*/
#include "map.h"

typedef struct fit {
  const map_bake *b;
  float *value; /* [6][texels] */
  const float *diagonal;
  const uint8_t *dark; /* [3][texels] those that stay 0, or NULL */
  float seam;          /* weight of a seam's place, over that of a place of light */
  float *missed; /* [6][seams] what fits before this one have missed of seams, summed, or NULL */
} fit;

/* out = matrix x; the diagonal where x is NULL. */
static void apply_pairs(const map_bake *b, const float *x, float *out) {
  size_t n = b->texels, step[5] = {0, 1, b->width - 1, b->width, b->width + 1};
  const float *own = b->matrix.pair;
  for (size_t i = 0; i < n; i++) out[i] = x ? own[i] * x[i] : own[i];
  for (size_t k = 1; x && k < 5; k++) {
    const float *pair = b->matrix.pair + k * n;
    for (size_t i = 0; i + step[k] < n; i++) {
      out[i] += pair[i] * x[i + step[k]];
      out[i + step[k]] += pair[i] * x[i];
    }
  }
}

/* Adds bends to out. */
static void apply_bends(const map_bake *b, const float *x, float *out) {
  for (size_t axis = 0; axis < 2; axis++) {
    size_t step = axis ? b->width : 1;
    const float *line = b->matrix.line + axis * b->texels;
    for (size_t i = step; i + step < b->texels; i++) {
      float w = line[i] * b->bend[i];
      float t = x ? w * (x[i - step] - 2 * x[i] + x[i + step]) : w;
      out[i - step] += t;
      out[i] += x ? -2 * t : 4 * t;
      out[i + step] += t;
    }
  }
}

/* The difference of both sides at a place of a seam. */
static float miss_of(const map_seam *s, const float *x) {
  float sum = 0;
  for (int k = 0; k < 8; k++) sum += s->weight[k] * x[s->texel[k]];
  return sum;
}

/* Adds seams to out. */
static void apply_seams(const map_bake *b, float seam, const float *x, float *out) {
  for (size_t i = 0; i < b->seams; i++) {
    const map_seam *s = &b->seam[i];
    float w = seam * b->matrix.scale[s->texel[0]], sum = x ? miss_of(s, x) : 0;
    for (int k = 0; k < 8; k++) out[s->texel[k]] += w * s->weight[k] * (x ? sum : s->weight[k]);
  }
}

static void apply(const map_bake *b, float seam, const float *x, float *out) {
  apply_pairs(b, x, out);
  apply_bends(b, x, out);
  apply_seams(b, seam, x, out);
}

/* out = the sum over sites of weight times light times row. */
static void project(const map_bake *b, size_t which, float *out) {
  memset(out, 0, b->texels * sizeof *out);
  for (size_t i = 0; i < b->sites; i++) {
    const map_site *s = &b->site[i];
    if (!map_counts(s)) continue;
    float w = s->weight * (which < 3 ? s->light.a : s->light.b)[which % 3];
    for (int k = 0; k < 4; k++) out[s->tap.texel[k]] += w * s->tap.weight[k];
  }
}

static double dot(size_t n, const float *a, const float *b) {
  double sum = 0;
  for (size_t i = 0; i < n; i++) sum += (double)(a[i] * b[i]);
  return sum;
}

/* z = g over the diagonal; 0 of texels that stay. */
static void scale(const fit *f, size_t which, const float *g, float *z) {
  size_t n = f->b->texels;
  const uint8_t *dark = f->dark ? f->dark + which % 3 * n : NULL;
  for (size_t i = 0; i < n; i++)
    z[i] = f->diagonal[i] > 0 && !(dark && dark[i]) ? g[i] / f->diagonal[i] : 0;
}

/* Adds what texels miss of seams, beyond what they may, to what was missed before, and asks for that much more (the method of
   multipliers, Hestenes 1969): rows that weigh little become as exact as heavy ones, which would end all steps early. */
static void press(const fit *f, size_t which, const float *x, float *g) {
  const map_bake *b = f->b;
  for (size_t i = 0; f->missed && i < b->seams; i++) {
    const map_seam *s = &b->seam[i];
    float *missed = f->missed + which * b->seams + i;
    float miss = miss_of(s, x), side = 0;
    for (int k = 0; k < 4; k++) side += s->weight[k] * x[s->texel[k]];
    float most = (float)MAP_SLACK * fmaxf(side, (float)b->mean[which % 3]);
    *missed += miss - fminf(fmaxf(miss, -most), most);
    float w = f->seam * b->matrix.scale[s->texel[0]] * *missed;
    for (int k = 0; k < 8; k++) g[s->texel[k]] -= w * s->weight[k];
  }
}

/* Moves x to the solution; room [4][texels]. */
static void descend(const fit *f, size_t which, float *x, float *room) {
  const map_bake *b = f->b;
  size_t n = b->texels;
  float *g = room, *z = g + n, *d = z + n, *q = d + n;
  double mean = b->mean[which % 3], size = 0;
  project(b, which, g);
  press(f, which, x, g);
  apply(b, f->seam, x, q);
  for (size_t i = 0; i < n; i++) {
    size += (double)f->diagonal[i] * mean * mean;
    g[i] -= q[i];
  }
  scale(f, which, g, z);
  memcpy(d, z, n * sizeof *d);
  double rest = dot(n, g, z);
  for (int step = 0; step < MAP_STEPS && rest > MAP_SMALL * size; step++) {
    apply(b, f->seam, d, q);
    double bend = dot(n, d, q);
    if (!(bend > 0)) break;
    float length = (float)(rest / bend);
    double before = rest;
    for (size_t i = 0; i < n; i++) {
      x[i] += length * d[i];
      g[i] -= length * q[i];
    }
    scale(f, which, g, z);
    rest = dot(n, g, z);
    float turn = (float)(rest / before);
    for (size_t i = 0; i < n; i++) d[i] = z[i] + turn * d[i];
  }
}

static ylm_status solve(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const fit *f = context;
  size_t n = f->b->texels;
  float *room = ylm_alloc(4 * n, sizeof *room);
  if (!room) return YLM_ENOMEM;
  for (size_t i = begin; i < end; i++) descend(f, i, f->value + i * n, room);
  ylm_free(room);
  return YLM_OK;
}

static ylm_status solve_all(const map_bake *b, float *value, float seam, float *missed,
                            const uint8_t *dark) {
  float *diagonal = ylm_alloc(b->texels, sizeof *diagonal);
  if (!diagonal) return YLM_ENOMEM;
  apply(b, seam, NULL, diagonal);
  fit f = {b, value, diagonal, dark, seam, missed};
  ylm_status s = ylm_parallel(6, 1, b->form->light.threads, solve, &f, NULL, NULL);
  ylm_free(diagonal);
  return s;
}

ylm_status ylm__map_fit(const map_bake *b, float *value) {
  return solve_all(b, value, MAP_SEAM, NULL, NULL);
}

ylm_status ylm__map_lift(const map_bake *b, float *value) {
  size_t n = 3 * b->texels;
  uint8_t *dark = ylm_alloc_zero(n, sizeof *dark);
  float *missed = ylm_alloc_zero(6 * b->seams + 1, sizeof *missed);
  ylm_status s = dark && missed ? YLM_OK : YLM_ENOMEM;
  for (int round = 0; s == YLM_OK && round < MAP_LIFTS; round++) {
    for (size_t i = 0; i < n; i++)
      if (value[i] + value[n + i] < 0) dark[i] = 1, value[i] = value[n + i] = 0;
    s = solve_all(b, value, MAP_PRESS, missed, dark);
  }
  ylm_free(missed);
  ylm_free(dark);
  return s;
}
