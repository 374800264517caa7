/* lightmap.c - irradiance at places of surfaces, and at the texels of a mesh: direct light at each, and what its links bring. */
#include <math.h>

#include "calibration.h"
#include "transfer.h"

typedef struct job {
  const ylm_radiosity *r;
  const ylm_radiosity_map *m;
  const uint64_t *stream; /* [n] */
  const ylm_scene_place *place;
  float (*out)[3];
  float *share; /* [n] of each place's rays, those that do not begin inside of a body */
} job;

typedef struct scratch {
  ylm_scene_surface at[LIGHTMAP_TEXELS];
  float origin[LIGHTMAP_TEXELS][3], normal[LIGHTMAP_TEXELS][3];
  ylm_links link; /* [LIGHTMAP_TEXELS][links] */
  float *sum;     /* [LIGHTMAP_TEXELS][4] */
  float *escape;  /* [LIGHTMAP_TEXELS][count] or NULL */
  float *light;   /* [LIGHTMAP_TEXELS][3][count] or NULL */
  ylm_scene_batch lit;
} scratch;

static void scratch_free(scratch *x) {
  ylm_scene_batch_free(&x->lit);
  ylm_links_free(x->link);
  ylm_free(x->sum);
  ylm_free(x->escape);
  ylm_free(x->light);
  ylm_free(x);
}

static scratch *scratch_create(const job *j) {
  const ylm_radiosity_map *m = j->m;
  scratch *x = ylm_alloc_zero(1, sizeof *x);
  size_t count = ylm_sh_count(m->lmax);
  if (!x) return NULL;
  x->link = ylm_transfer_room(j->r->t, (size_t)LIGHTMAP_TEXELS * (size_t)m->links);
  x->sum = ylm_alloc(LIGHTMAP_TEXELS, 16);
  bool ok = !ylm_links_are_none(x->link) && x->sum;
  if (m->scene) {
    ok = ylm_scene_batch_create(m->scene, (size_t)m->light_samples, &x->lit) == YLM_OK && ok;
    if (ok) ylm_scene_chooser_follow(x->lit.lamps, j->r->guide); /* of other lamps: by none */
  } else if (m->field) {
    x->escape = ylm_alloc(LIGHTMAP_TEXELS * count, sizeof *x->escape);
    x->light = ylm_alloc(LIGHTMAP_TEXELS * 3 * count, sizeof *x->light);
    ok = ok && x->escape && x->light;
  }
  if (ok) return x;
  scratch_free(x);
  return NULL;
}

/* Adds direct light by rays from place i of the batch, whose random numbers are those of `stream`; flow [3][3] or NULL. */
static void add_rays(const job *j, scratch *x, size_t i, uint64_t stream, float E[3],
                     float (*flow)[3]) {
  ylm_rng rng;
  ylm_rng_seed(&rng, ~j->m->seed, stream);
  ylm_scene_batch_aim(&x->lit, x->at[i].lit, x->normal[i], x->at[i].origin, j->m->light_samples,
                      &rng);
  ylm_scene_batch_trace(&x->lit);
  for (size_t k = 0; k < x->lit.rays; k++)
    for (size_t c = 0; c < 3; c++)
      if (!(x->lit.ray[k].far < 0)) E[c] += x->lit.value[k][c];
  for (size_t k = 0; flow && k < x->lit.rays; k++) {
    const float *w = x->lit.ray[k].dir;
    if (x->lit.ray[k].far < 0) continue;
    float level = fmaxf(ylm_dot3(w, x->normal[i]), (float)FLOW_LEVEL * sqrtf(ylm_dot3(w, w)));
    for (int a = 0; a < 9; a++) flow[a / 3][a % 3] += x->lit.value[k][a % 3] * w[a / 3] / level;
  }
  x->lit.rays = 0;
}

/* The cosine's coefficients at n places, in place of transfer vectors. */
static ylm_status cosines(const job *j, scratch *x, size_t n) {
  int lmax = j->m->lmax;
  double zonal[YLM_TRANSFER_LMAX + 1];
  size_t count = ylm_sh_count(lmax);
  ylm_status s = ylm_material_cosine(lmax, zonal);
  if (s == YLM_OK)
    s = ylm_sh_eval(lmax, 0, false, YLM_FLOAT, n, x->normal, x->escape, NULL, NULL, 1, NULL);
  for (size_t i = 0; s == YLM_OK && i < n; i++)
    for (int l = 0; l <= lmax; l++)
      for (size_t k = ylm_sh_index(l, -l); k <= ylm_sh_index(l, l); k++)
        x->escape[i * count + k] *= (float)zonal[l];
  return s;
}

static bool is_shadowed(const job *j) {
  return j->m->field && j->m->field->quantity != YLM_QUANTITY_lights;
}

/* Adds direct light by coefficients to n places. */
static ylm_status add_field(const job *j, scratch *x, size_t n, float *E) {
  int lmax = j->m->lmax;
  size_t count = ylm_sh_count(lmax);
  ylm_field_query q = {.lmax = lmax,
                       .channels = 3,
                       .want = YLM_WANT_VALUE,
                       .metric_channels = 1,
                       .dtype = YLM_FLOAT,
                       .threads = 1,
                       .origin = ylm_scene_origin(j->r->t->scene)};
  ylm_field_result out = {.value = x->light};
  ylm_status s = is_shadowed(j) ? cosines(j, x, n) : YLM_OK;
  if (s == YLM_OK && is_shadowed(j))
    ylm__transfer_off(j->r->t, n, (const float(*)[3])x->origin, (const float(*)[3])x->normal,
                      x->origin);
  if (s == YLM_OK) s = ylm_field_evaluate(j->m->field, &q, n, x->origin, &out, NULL);
  for (size_t i = 0; s == YLM_OK && i < n; i++)
    for (size_t c = 0; c < 3; c++) {
      double sum = 0;
      for (size_t k = 0; k < count; k++)
        sum += (double)x->escape[i * count + k] * (double)x->light[(3 * i + c) * count + k];
      E[4 * i + c] += (float)sum;
    }
  return s;
}

/* Places begin .. end-1 of the list. */
static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  const ylm_transfer *t = j->r->t;
  size_t n = end - begin;
  scratch *x = scratch_create(j);
  const float *leaving = j->r->averaged ? j->r->averaged : j->r->leaving;
  transfer_flow flow = {leaving, j->m->flow ? j->m->flow + begin : NULL};
  if (!x) return YLM_ENOMEM;
  ylm_scene_surfaces(t->scene, n, j->place + begin, x->at);
  for (size_t i = 0; i < n; i++) {
    memcpy(x->origin[i], x->at[i].origin, 12);
    memcpy(x->normal[i], x->at[i].normal, 12);
  }
  bool aims = j->r->targets && j->m->indirect && !j->m->field && j->m->links % 2 == 0;
  ylm_status s = aims
                     ? ylm__transfer_gather(j->r->targets, leaving, n, (const float(*)[3])x->origin,
                                            (const float(*)[3])x->normal, j->stream + begin,
                                            j->m->links, j->m->seed, 1, NULL, (float(*)[4])x->sum,
                                            j->share + begin, flow.out ? &flow : NULL)
                     : ylm__transfer_find_shares(t, n, (const float(*)[3])x->origin,
                                                 (const float(*)[3])x->normal, j->stream + begin,
                                                 j->m->links, j->m->seed, 1, NULL, x->link,
                                                 j->m->lmax, is_shadowed(j) ? NULL : x->escape,
                                                 j->share + begin, flow.out ? &flow : NULL);
  if (s == YLM_OK && !aims) ylm__transfer_sum()(n, j->m->links, x->link, 4, leaving, NULL, x->sum);
  for (size_t i = 0; s == YLM_OK && i < 4 * n; i++)
    x->sum[i] = j->m->indirect ? (float)YLM_PI * x->sum[i] : 0;
  if (s == YLM_OK && flow.out && !j->m->indirect) memset(flow.out, 0, n * sizeof *flow.out);
  if (s == YLM_OK && j->m->field) s = add_field(j, x, n, x->sum);
  for (size_t i = 0; s == YLM_OK && i < n; i++) {
    if (j->m->scene)
      add_rays(j, x, i, j->stream[begin + i], x->sum + 4 * i, flow.out ? flow.out[i] : NULL);
    memcpy(j->out[begin + i], x->sum + 4 * i, 12);
  }
  scratch_free(x);
  return s;
}

/* -- texels -------------------------------------------------------------------------- */

/* The places of all texels whose middles lie on the mesh; element UINT32_MAX: on none. */
static void raster(const ylm_radiosity_map *m, const ylm_scene *scene, ylm_scene_place *place,
                   size_t *overlaps) {
  size_t w = (size_t)m->width, h = (size_t)m->height;
  for (size_t i = 0; i < w * h; i++) place[i].element = UINT32_MAX;
  for (size_t i = 0; i < ylm_scene_triangles(scene, m->mesh); i++) {
    const uint32_t *t = ylm_scene_triangle(scene, m->mesh, i);
    double x[3], y[3], lo[2] = {INFINITY, INFINITY}, hi[2] = {-INFINITY, -INFINITY};
    for (int k = 0; k < 3; k++) {
      x[k] = (double)m->uvs[2 * t[k]] * (double)w - 0.5;
      y[k] = (1 - (double)m->uvs[2 * t[k] + 1]) * (double)h - 0.5;
      lo[0] = fmin(lo[0], x[k]), hi[0] = fmax(hi[0], x[k]);
      lo[1] = fmin(lo[1], y[k]), hi[1] = fmax(hi[1], y[k]);
    }
    double area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
    if (!(area != 0) || !isfinite(area)) continue;
    long x1 = (long)fmin((double)w - 1, floor(hi[0])), y1 = (long)fmin((double)h - 1, floor(hi[1]));
    for (long b = (long)fmax(0, ceil(lo[1])); b <= y1; b++)
      for (long a = (long)fmax(0, ceil(lo[0])); a <= x1; a++) {
        double u = (((double)a - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * ((double)b - y[0])) / area;
        double v = ((x[1] - x[0]) * ((double)b - y[0]) - ((double)a - x[0]) * (y[1] - y[0])) / area;
        if (u < 0 || v < 0 || u + v > 1) continue;
        ylm_scene_place *p = &place[(size_t)b * w + (size_t)a];
        double edge = fmin(fmin(u, v), 1 - u - v);
        if (p->element != UINT32_MAX && edge > 1e-6) ++*overlaps;
        *p = (ylm_scene_place){.mesh = (uint32_t)m->mesh,
                               .element = (uint32_t)i,
                               .u = (float)u,
                               .v = (float)v,
                               .back = m->back};
      }
  }
}

/* Texels beside those that have light take their neighbours' mean, `rings` times. */
static void fill_gutter(int w, int h, int rings, uint8_t *age, float *out) {
  for (int ring = 1; ring <= rings; ring++)
    for (int y = 0; y < h; y++)
      for (int x = 0; x < w; x++) {
        size_t at = (size_t)y * (size_t)w + (size_t)x;
        double sum[3] = {0, 0, 0};
        int n = 0;
        if (age[at]) continue;
        for (int k = 0; k < 9; k++) {
          int a = x + k % 3 - 1, b = y + k / 3 - 1;
          if (a < 0 || b < 0 || a >= w || b >= h) continue;
          size_t of = (size_t)b * (size_t)w + (size_t)a;
          if (!age[of] || age[of] > ring) continue;
          for (size_t c = 0; c < 3; c++) sum[c] += (double)out[3 * of + c];
          n++;
        }
        if (!n) continue;
        age[at] = (uint8_t)(ring + 1);
        for (size_t c = 0; c < 3; c++) out[3 * at + c] = (float)(sum[c] / n);
      }
}

/* Checks the fields of a form that places and texels have. */
static ylm_status check(const ylm_radiosity *r, const ylm_radiosity_map *m, ylm_error *e) {
  const ylm_transfer *t = r->t;
  bool same = true;
  if (m->scene && (m->light_samples < 1 || m->light_samples > YLM_TRANSFER_LINKS))
    return ylm_fail(e, YLM_ERANGE, "light_samples must be from 1 to %d", YLM_TRANSFER_LINKS);
  if (m->field && (m->lmax < 0 || m->lmax > YLM_TRANSFER_LMAX))
    return ylm_fail(e, YLM_ERANGE, "lmax must be from 0 to %d, got %d", YLM_TRANSFER_LMAX, m->lmax);
  ylm_status s = ylm__transfer_check_links(m->links, e);
  if (s == YLM_OK && m->scene) s = ylm__transfer_same(t->scene, m->scene, &same);
  if (s == YLM_OK && !same)
    s = ylm_fail(e, YLM_EINVAL, "the scene has other meshes than those of the links");
  return s;
}

ylm_status ylm_radiosity_places(const ylm_radiosity *r, const ylm_radiosity_map *m, size_t n,
                                const ylm_scene_place *place, const uint64_t *stream,
                                float (*out)[3], float *share, ylm_error *e) {
  job j = {r, m, stream, place, out, share};
  ylm_status s = check(r, m, e);
  if (s != YLM_OK) return s;
  return ylm_parallel(n, LIGHTMAP_TEXELS, m->threads, run, &j, m->progress, "lightmap");
}

static ylm_status check_texels(const ylm_radiosity *r, const ylm_radiosity_map *m, ylm_error *e) {
  if (m->mesh >= r->t->meshes) return ylm_fail(e, YLM_ERANGE, "there is no mesh %zu", m->mesh + 1);
  if (m->width < 1 || m->height < 1 || m->width > 16384 || m->height > 16384)
    return ylm_fail(e, YLM_ERANGE, "a lightmap has 1 to 16384 texels a side");
  if (m->gutter < 0 || m->gutter > 64)
    return ylm_fail(e, YLM_ERANGE, "gutter: 0 to 64 texels, got %d", m->gutter);
  return YLM_OK;
}

ylm_status ylm_radiosity_lightmap(const ylm_radiosity *r, const ylm_radiosity_map *m, float *out,
                                  float *coverage, size_t *overlaps, ylm_error *e) {
  ylm_status s = check_texels(r, m, e);
  if (s != YLM_OK) return s;
  size_t all = (size_t)m->width * (size_t)m->height, n = 0;
  ylm_scene_place *place = ylm_alloc(all, sizeof *place);
  uint64_t *texel = ylm_alloc(all, sizeof *texel);
  uint8_t *age = ylm_alloc_zero(all, 1);
  float *share = ylm_alloc(all, sizeof *share), (*light)[3] = ylm_alloc(all, sizeof *light);
  *overlaps = 0;
  if (place && texel && age && share && light) {
    raster(m, r->t->scene, place, overlaps);
    for (size_t i = 0; i < all; i++) {
      if (place[i].element == UINT32_MAX) continue;
      place[n] = place[i];
      texel[n++] = i;
    }
    s = ylm_radiosity_places(r, m, n, place, texel, light, share, e);
    memset(coverage, 0, all * sizeof *coverage);
    for (size_t i = 0; s == YLM_OK && i < n; i++) {
      memcpy(out + 3 * texel[i], light[i], sizeof light[i]);
      coverage[texel[i]] = age[texel[i]] = share[i] >= 0.5f;
    }
  } else
    s = YLM_ENOMEM;
  if (s == YLM_OK) fill_gutter(m->width, m->height, m->gutter, age, out);
  ylm_free(place);
  ylm_free(texel);
  ylm_free(age);
  ylm_free(share);
  ylm_free(light);
  return s;
}
