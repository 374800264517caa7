/* matrices.c - transfer matrices: the light that arrives at places, as coefficients of distant light. */
#include <math.h>

#include "calibration.h"
#include "transfer.h"

typedef struct job {
  const ylm_transfer *t;
  ylm_transfer_outer_fn *outer;
  const float *B; /* [elements + 1][width] albedo/pi times vectors, or NULL */
  const float (*origin)[3], (*normal)[3];
  const uint64_t *stream;
  int rays, lmax_out;
  uint64_t seed;
  float (*disk)[2];                         /* [rays] cos and sin of the unturned azimuth */
  size_t count_in, count_out, width, plain; /* rows of B, rows of one channel */
  float *out;
} job;

typedef struct scratch {
  ylm_trace_ray *ray; /* [rays] */
  ylm_trace_hit *hit;
  uint32_t *target;
  float *direction;     /* [rays][3] */
  float *Y;             /* [rays][count of the higher degree] */
  float *left, *right;  /* [MATRIX_STEP][count_out], [MATRIX_STEP][width] */
  float *sky, *surface; /* [count_out][plain], [count_out][width] */
} scratch;

static void scratch_free(scratch *x) {
  ylm_free(x->ray);
  ylm_free(x->hit);
  ylm_free(x->target);
  ylm_free(x->direction);
  ylm_free(x->Y);
  ylm_free(x->left);
  ylm_free(x->right);
  ylm_free(x->sky);
  ylm_free(x->surface);
}

static size_t wider(const job *j) {
  return j->count_in > j->count_out ? j->count_in : j->count_out;
}

static bool scratch_create(scratch *x, const job *j) {
  size_t rays = (size_t)j->rays;
  x->ray = ylm_alloc(rays, sizeof *x->ray);
  x->hit = ylm_alloc(rays, sizeof *x->hit);
  x->target = ylm_alloc(rays, sizeof *x->target);
  x->direction = ylm_alloc(rays, 3 * sizeof *x->direction);
  x->Y = ylm_alloc(rays, wider(j) * sizeof *x->Y);
  x->left = ylm_alloc(MATRIX_STEP, j->count_out * sizeof *x->left);
  x->right = ylm_alloc_zero(MATRIX_STEP, j->width * sizeof *x->right);
  x->sky = ylm_alloc(j->count_out, j->plain * sizeof *x->sky);
  x->surface = ylm_alloc(j->count_out, j->width * sizeof *x->surface);
  return x->ray && x->hit && x->target && x->direction && x->Y && x->left && x->right && x->sky &&
         x->surface;
}

/* Rays of place i, even over the hemisphere about its normal. */
static void aim(const job *j, size_t i, scratch *x) {
  float a[3], b[3];
  const float *n = j->normal[i];
  ylm_rng rng;
  ylm_rng_seed(&rng, j->seed, j->stream ? j->stream[i] : i);
  float shift = (float)ylm_rng_double(&rng), each = 1 / (float)j->rays;
  double turn = 2 * YLM_PI * ylm_rng_double(&rng);
  float c = (float)cos(turn), s = (float)sin(turn);
  ylm_scene_basis(n, a, b);
  for (int k = 0; k < j->rays; k++) {
    float z = fminf(((float)k + shift) * each, 1), r = sqrtf(1 - z * z);
    float u = r * (j->disk[k][0] * c - j->disk[k][1] * s);
    float v = r * (j->disk[k][0] * s + j->disk[k][1] * c), *d = x->direction + 3 * k;
    ylm_trace_ray *ray = &x->ray[k];
    for (int q = 0; q < 3; q++) {
      d[q] = ray->dir[q] = u * a[q] + v * b[q] + z * n[q];
      ray->org[q] = j->origin[i][q];
    }
    ray->near = 0;
    ray->far = INFINITY;
  }
}

/* Sums of rays whose light is `sky` or comes from surfaces: m[o][k] += Y_o(ray) light_k(ray). */
static void add(const job *j, scratch *x, bool sky, float *m) {
  size_t n = 0, wide = wider(j), row = sky ? j->plain : j->width;
  uint32_t none = (uint32_t)j->t->elements;
  memset(m, 0, j->count_out * row * sizeof *m);
  for (int k = 0; k <= j->rays; k++) {
    if (n == MATRIX_STEP || (k == j->rays && n > 0)) {
      j->outer(n, j->count_out, row, x->left, x->right, m);
      n = 0;
    }
    if (k == j->rays || (x->hit[k].mesh < 0) != sky || x->target[k] > none) continue;
    float *to = x->right + n * row;
    if (!sky && k + MATRIX_AHEAD < j->rays)
      for (size_t line = 0; line < row; line += 16)
        __builtin_prefetch(j->B + x->target[k + MATRIX_AHEAD] % (none + 1) * j->width + line);
    memcpy(x->left + n * j->count_out, x->Y + (size_t)k * wide, j->count_out * sizeof *x->left);
    if (sky)
      memcpy(to, x->Y + (size_t)k * wide, j->count_in * sizeof *to);
    else
      memcpy(to, j->B + x->target[k] * j->width, row * sizeof *to);
    n++;
  }
}

/* The matrices of place i, [3][count_out][count_in]. */
static void write(const job *j, const scratch *x, size_t i, double each) {
  size_t in = j->count_in, known = ylm_sh_count(j->t->form.lmax);
  float *out = j->out + i * 3 * j->count_out * in;
  for (size_t c = 0; c < 3; c++)
    for (size_t o = 0; o < j->count_out; o++)
      for (size_t k = 0; k < in; k++) {
        float surface = j->B ? x->surface[o * j->width + c * known + k] : 0;
        out[(c * j->count_out + o) * in + k] = (float)each * (x->sky[o * j->plain + k] + surface);
      }
}

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  size_t rays = (size_t)j->rays;
  int lmax_in = (int)lround(sqrt((double)j->count_in)) - 1;
  int lmax = lmax_in > j->lmax_out ? lmax_in : j->lmax_out;
  scratch x = {0};
  ylm_status s = scratch_create(&x, j) ? YLM_OK : YLM_ENOMEM;
  for (size_t i = begin; s == YLM_OK && i < end; i++) {
    size_t good = 0;
    aim(j, i, &x);
    ylm_trace_nearest(ylm_scene_trace(j->t->scene), rays, x.ray, false, x.hit);
    ylm_transfer_hits(j->t, rays, x.ray, x.hit, x.target);
    for (size_t k = 0; k < rays; k++) good += x.target[k] <= j->t->elements;
    s = ylm_sh_eval(lmax, 0, false, YLM_FLOAT, rays, x.direction, x.Y, NULL, NULL, 1, NULL);
    if (s != YLM_OK) break;
    add(j, &x, true, x.sky);
    if (j->B) add(j, &x, false, x.surface);
    write(j, &x, i, good ? 2 * YLM_PI / (double)good : 0);
  }
  scratch_free(&x);
  return s;
}

static ylm_status check(const ylm_transfer *t, int rays, int lmax_in, int lmax_out, ylm_error *e) {
  if (!t->escape)
    return ylm_fail(e, YLM_EINVAL, "the transfer was made without transfer vectors (lmax = -1)");
  if (rays < 1 || rays > YLM_SCENE_SAMPLES)
    return ylm_fail(e, YLM_ERANGE, "rays must be from 1 to %d, got %d", YLM_SCENE_SAMPLES, rays);
  if (lmax_in < 0 || lmax_in > t->form.lmax)
    return ylm_fail(e, YLM_ERANGE, "lmax_in must be from 0 to that of the transfer, %d, got %d",
                    t->form.lmax, lmax_in);
  if (lmax_out < 0 || lmax_out > YLM_TRANSFER_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax_out must be from 0 to %d, got %d", YLM_TRANSFER_LMAX,
                    lmax_out);
  return YLM_OK;
}

ylm_status ylm_transfer_matrices(const ylm_transfer *t, const float *vectors, size_t n,
                                 const float (*origin)[3], const float (*normal)[3],
                                 const uint64_t *stream, int rays, uint64_t seed, int lmax_in,
                                 int lmax_out, int threads, const ylm_progress *progress,
                                 float *out, ylm_error *e) {
  ylm_status s = check(t, rays, lmax_in, lmax_out, e);
  if (s != YLM_OK) return s;
  job j = {.t = t,
           .outer = ylm__transfer_outer(),
           .origin = origin,
           .normal = normal,
           .stream = stream,
           .rays = rays,
           .lmax_out = lmax_out,
           .seed = seed,
           .count_in = ylm_sh_count(lmax_in),
           .count_out = ylm_sh_count(lmax_out),
           .width = ylm_transfer_width(t),
           .out = out};
  j.plain = (j.count_in + 3) / 4 * 4;
  j.disk = ylm_alloc((size_t)rays, sizeof *j.disk);
  float *B = vectors ? ylm__transfer_reflected(t, vectors, 1 / YLM_PI) : NULL;
  if (!j.disk || (vectors && !B)) s = YLM_ENOMEM;
  for (int k = 0; s == YLM_OK && k < rays; k++) {
    double phi = 2 * YLM_PI * ylm_scene_radical((uint32_t)k);
    j.disk[k][0] = (float)cos(phi);
    j.disk[k][1] = (float)sin(phi);
  }
  j.B = B;
  if (s == YLM_OK) s = ylm_parallel(n, MATRIX_GRAIN, threads, run, &j, progress, "matrices");
  ylm_free(B);
  ylm_free(j.disk);
  return s;
}
