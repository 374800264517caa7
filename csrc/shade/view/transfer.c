/* transfer.c - SH coefficients of what a material weighs light with (matte: the clamped cosine),
   times visibility. */
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "../calibration.h"
#include "../gloss/gloss.h"

typedef struct job {
  const ylm_shade_view *view;
  bool shadows;
  const uint32_t *mesh;
  const float (*normal)[3], (*origin)[3];
  float *transfer;
  const float *share; /* [points] of rays, or NULL: such are nowhere alone */
  double *zonal;      /* of ylm__shade_zonal */
  float (*disk)[2];   /* [samples] cos and sin of the unshifted azimuth */
  float *height;      /* [samples] i / samples         */
  shade_kernels k;
  atomic_uint_fast64_t rays;
} job;

typedef struct scratch {
  ylm_trace_ray *ray; /* [points*samples] */
  float *direction;   /* [SHADE_OCCLUSION_RAYS][3]       */
  float *Y;           /* [SHADE_OCCLUSION_RAYS][count]   */
  float *seen, *all;  /* [count]          */
  uint8_t *visible;   /* [samples], [SHADE_OCCLUSION_RAYS] at least */
} scratch;

/* Does point i gloss, so that its visibility is wanted alone? */
static bool is_glossy(const job *j, size_t i) {
  const shade_gloss *g = j->view->gloss;
  return g && j->shadows && ylm__shade_gloss_slot(g, j->mesh[i]) != YLM_SHADE_MATTE;
}

/* Do rays to lamps alone shade point i, so that its row is of no use? */
static bool is_idle(const job *j, size_t i) { return j->share && j->share[i] >= 1; }

/* Rays about the normal of point i, dense as the cosine; evenly where it glosses. */
static void point_rays(const job *j, size_t i, ylm_trace_ray *ray) {
  int samples = j->view->o.transfer_samples;
  float a[3], b[3], far = (float)fmin(j->view->o.occlusion_distance, 3e38);
  const float *n = j->normal[i];
  bool glossy = is_glossy(j, i);
  ylm_rng rng;
  bool own = j->normal == (const float(*)[3])j->view->normal;
  ylm_rng_seed(&rng, ~j->view->o.seed, own ? ylm__shade_stream(j->view, i) : i);
  float shift = (float)ylm_rng_double(&rng);
  double turn = 2 * YLM_PI * ylm_rng_double(&rng);
  float c = (float)cos(turn), s = (float)sin(turn);
  ylm_scene_basis(n, a, b);
  for (int k = 0; k < samples; k++) {
    float h = j->height[k] + shift, r, z;
    if (h >= 1) h -= 1;
    r = glossy ? sqrtf((1 - h) * (1 + h)) : sqrtf(h);
    z = glossy ? h : sqrtf(1 - h);
    float x = r * (j->disk[k][0] * c - j->disk[k][1] * s);
    float y = r * (j->disk[k][0] * s + j->disk[k][1] * c);
    for (int q = 0; q < 3; q++) {
      ray[k].org[q] = j->origin[i][q];
      ray[k].dir[q] = x * a[q] + y * b[q] + z * n[q];
    }
    ray[k].near = 0;
    ray[k].far = far;
  }
}

/* The estimate of ylm_shade_view_create for one point whose rays have been traced. */
static ylm_status estimate(const job *j, const ylm_trace_ray *ray, const scratch *x, float *T) {
  int lmax = j->view->o.lmax, samples = j->view->o.transfer_samples, visible = 0;
  size_t count = ylm_sh_count(lmax);
  for (int k = 0; k < samples; k++) visible += x->visible[k] = !(ray[k].far < 0);
  if (visible == samples) return YLM_OK;
  if (visible == 0) {
    memset(T, 0, count * sizeof *T);
    return YLM_OK;
  }
  memset(x->seen, 0, count * sizeof(float));
  memset(x->all, 0, count * sizeof(float));
  for (int first = 0; first < samples; first += SHADE_OCCLUSION_RAYS) {
    int n = samples - first < SHADE_OCCLUSION_RAYS ? samples - first : SHADE_OCCLUSION_RAYS;
    for (int k = 0; k < n; k++) memcpy(x->direction + 3 * k, ray[first + k].dir, 12);
    ylm_status s =
        ylm_sh_eval(lmax, 0, false, YLM_FLOAT, (size_t)n, x->direction, x->Y, NULL, NULL, 1, NULL);
    if (s != YLM_OK) return s;
    j->k.sums(count, (size_t)n, x->Y, x->visible + first, x->seen, x->all);
  }
  float each = (float)(YLM_PI / samples), open = (float)visible / (float)samples;
  for (size_t k = 0; k < count; k++) T[k] = each * x->seen[k] + open * (T[k] - each * x->all[k]);
  return YLM_OK;
}

/* Directions of the next occluded rays from *first on, and their mirror images, if wanted; returns how many,
   at most SHADE_OCCLUSION_RAYS. */
static int list_occluded(const float *n, bool mirror, int samples, const ylm_trace_ray *ray,
                         int *first, float *out) {
  int found = 0;
  for (; *first < samples && found + 2 <= SHADE_OCCLUSION_RAYS; ++*first) {
    const float *d = ray[*first].dir;
    if (!(ray[*first].far < 0)) continue;
    float up = 2 * ylm_dot3(d, n);
    for (int a = 0; a < 3; a++) {
      out[3 * found + a] = d[a];
      if (mirror) out[3 * found + 3 + a] = d[a] - up * n[a];
    }
    found += mirror ? 2 : 1;
  }
  return found;
}

/* Adds the coefficients of 1 over the hemisphere about n. */
static ylm_status add_hemisphere(int lmax, const float *n, float *Y, float *V) {
  double at[YLM_SHADE_DEGREES + 2] = {1, 0}; /* Legendre polynomials at 0 */
  ylm_status s = ylm_sh_eval(lmax, 0, false, YLM_FLOAT, 1, n, Y, NULL, NULL, 1, NULL);
  for (int l = 2; l <= lmax + 1; l++) at[l] = -(l - 1.0) / l * at[l - 2];
  for (int l = 0; s == YLM_OK && l <= lmax; l++) {
    double part = 2 * YLM_PI * (l == 0 ? 1 : (at[l - 1] - at[l + 1]) / (2 * l + 1));
    for (int k = l * l; k < (l + 1) * (l + 1); k++) V[k] += (float)part * Y[k];
  }
  return s;
}

/* The visibility of one point that glosses, whose rays have been traced. */
static ylm_status estimate_visibility(const job *j, const float *n, const ylm_trace_ray *ray,
                                      const scratch *x, float *V) {
  int lmax = j->view->o.lmax, samples = j->view->o.transfer_samples, occluded = 0;
  size_t count = ylm_sh_count(lmax);
  for (int k = 0; k < samples; k++) occluded += ray[k].far < 0;
  bool mirror = !j->view->o.below_dark;
  memset(V, 0, count * sizeof *V);
  if (occluded == samples) return YLM_OK;
  memset(x->seen, 0, count * sizeof(float));
  memset(x->all, 0, count * sizeof(float));
  for (int first = 0, m; (m = list_occluded(n, mirror, samples, ray, &first, x->direction)) > 0;) {
    ylm_status s =
        ylm_sh_eval(lmax, 0, false, YLM_FLOAT, (size_t)m, x->direction, x->Y, NULL, NULL, 1, NULL);
    if (s != YLM_OK) return s;
    j->k.sums(count, (size_t)m, x->Y, x->visible, x->seen, x->all);
  }
  float each = (float)(2 * YLM_PI / samples);
  if (occluded)
    for (size_t k = 0; k < count; k++) V[k] = -each * x->all[k];
  if (!mirror) return add_hemisphere(lmax, n, x->Y, V);
  V[0] += YLM_SHADE_OPEN;
  return YLM_OK;
}

static void scratch_free(scratch *x) {
  ylm_free(x->ray);
  ylm_free(x->direction);
  ylm_free(x->Y);
  ylm_free(x->seen);
  ylm_free(x->all);
  ylm_free(x->visible);
}

static bool scratch_create(scratch *x, size_t samples, size_t rays, size_t count) {
  size_t batch = 2 * samples < SHADE_OCCLUSION_RAYS
                     ? 2 * samples
                     : SHADE_OCCLUSION_RAYS; /* directions with mirror images */
  x->ray = ylm_alloc(rays, sizeof *x->ray);
  x->direction = ylm_alloc(batch, 12);
  x->Y = ylm_alloc(batch * count, sizeof *x->Y);
  x->seen = ylm_alloc(count, sizeof *x->seen);
  x->all = ylm_alloc(count, sizeof *x->all);
  x->visible = ylm_alloc_zero(samples > batch ? samples : batch, 1);
  return x->ray && x->direction && x->Y && x->seen && x->all && x->visible;
}

/* Rays of n points from `first` on meet the points' own meshes alone. */
static void occlude_apart(const job *j, size_t first, size_t n, scratch *x) {
  size_t samples = (size_t)j->view->o.transfer_samples;
  ylm_trace_ray *ray = x->ray;
  for (size_t i = 0; i < n; i++) {
    if (is_idle(j, first + i)) continue;
    ylm_trace_occluded(j->view->own[j->mesh[first + i]], samples, ray);
    ray += samples;
  }
}

/* Points begin .. end-1. */
static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  job *j = context;
  const ylm_shade_view *v = j->view;
  size_t samples = (size_t)v->o.transfer_samples, count = ylm_sh_count(v->o.lmax);
  size_t batch = SHADE_OCCLUSION_RAYS / samples > 1 ? SHADE_OCCLUSION_RAYS / samples : 1,
         traced = 0;
  ylm_status s = ylm__shade_cosines(v, v->o.lmax, j->zonal, end - begin, j->mesh + begin,
                                    j->normal + begin, j->transfer + begin * count);
  if (s != YLM_OK || !j->shadows) return s;
  scratch x = {0};
  if (!scratch_create(&x, samples, batch * samples, count)) s = YLM_ENOMEM;
  for (size_t first = begin; s == YLM_OK && first < end; first += batch) {
    size_t n = end - first < batch ? end - first : batch, busy = 0;
    for (size_t i = 0; i < n; i++)
      if (!is_idle(j, first + i)) point_rays(j, first + i, x.ray + busy++ * samples);
    if (v->own)
      occlude_apart(j, first, n, &x);
    else
      ylm_trace_occluded(ylm_scene_trace(v->scene), busy * samples, x.ray);
    traced += busy * samples;
    const ylm_trace_ray *ray = x.ray;
    for (size_t i = 0; s == YLM_OK && i < n; i++) {
      float *T = j->transfer + (first + i) * count;
      if (is_idle(j, first + i)) {
        memset(T, 0, count * sizeof *T);
        continue;
      }
      s = is_glossy(j, first + i) ? estimate_visibility(j, j->normal[first + i], ray, &x, T)
                                  : estimate(j, ray, &x, T);
      ray += samples;
    }
  }
  scratch_free(&x);
  atomic_fetch_add_explicit(&j->rays, traced, memory_order_relaxed);
  return s;
}

ylm_status ylm__shade_transfer(const ylm_shade_view *v, bool shadows, size_t n,
                               const uint32_t *mesh, const float (*normal)[3],
                               const float (*origin)[3], const float *share, float *transfer,
                               uint64_t *rays) {
  int samples = v->o.transfer_samples;
  job j = {.view = v,
           .shadows = shadows,
           .mesh = mesh,
           .normal = normal,
           .origin = origin,
           .share = share,
           .transfer = transfer,
           .k = ylm__shade_kernels()};
  j.disk = ylm_alloc((size_t)samples, sizeof *j.disk);
  j.height = ylm_alloc((size_t)samples, sizeof *j.height);
  j.zonal = ylm__shade_zonal(v->o.lmax);
  ylm_status s = j.disk && j.height && j.zonal ? YLM_OK : YLM_ENOMEM;
  for (int k = 0; s == YLM_OK && k < samples; k++) {
    double turn = 2 * YLM_PI * ylm_scene_radical((uint32_t)k);
    j.disk[k][0] = (float)cos(turn);
    j.disk[k][1] = (float)sin(turn);
    j.height[k] = (float)k / (float)samples;
  }
  if (s == YLM_OK)
    s = ylm_parallel(n, SHADE_TRANSFER_GRAIN, v->o.threads, run, &j, v->o.progress, "transfer");
  *rays += j.rays;
  ylm_free(j.zonal);
  ylm_free(j.disk);
  ylm_free(j.height);
  return s;
}

/* -- the cosine alone ---------------------------------------------------------------------- */

double *ylm__shade_zonal(int lmax) {
  int kinds = ylm_material_kinds();
  size_t row = (size_t)lmax + 1;
  double *zonal = ylm_alloc((size_t)kinds * row, sizeof *zonal);
  for (int i = 0; zonal && i < kinds; i++) /* views have an lmax that materials have too */
    (void)ylm_material_transfer(i, lmax, zonal + (size_t)i * row);
  return zonal;
}

ylm_status ylm__shade_cosines(const ylm_shade_view *v, int lmax, const double *zonal, size_t n,
                              const uint32_t *mesh, const float (*normal)[3], float *out) {
  size_t count = ylm_sh_count(lmax);
  ylm_status s = ylm_sh_eval(lmax, 0, false, YLM_FLOAT, n, normal, out, NULL, NULL, 1, NULL);
  const double *a = NULL;
  for (size_t i = 0; s == YLM_OK && i < n; i++, out += count) {
    if (i == 0 || mesh[i] != mesh[i - 1])
      a = zonal +
          ((size_t)lmax + 1) * (size_t)ylm_material_kind(ylm__shade_mesh_material(v, mesh[i]));
    for (int l = 0; l <= lmax; l++)
      for (size_t k = ylm_sh_index(l, -l); k <= ylm_sh_index(l, l); k++) out[k] *= (float)a[l];
  }
  return s;
}
