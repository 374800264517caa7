/* view.c - what a camera sees, made once and shaded as often as one likes. */
#include <math.h>
#include <string.h>

#include "../calibration.h"
#include "../gen/picture.h"
#include "../gloss/gloss.h"
#include "ylm_light.h"

static ylm_status check_options(const ylm_shade_options *o, ylm_error *e) {
  if (o->width < 1 || o->height < 1 || o->width > YLM_IMAGE_MAX_SIDE ||
      o->height > YLM_IMAGE_MAX_SIDE)
    return ylm_fail(e, YLM_ERANGE, "an image has 1 to %d pixels each way", YLM_IMAGE_MAX_SIDE);
  if (o->samples < 1 || o->samples > YLM_SHADE_SAMPLES)
    return ylm_fail(e, YLM_ERANGE, "samples must be from 1 to %d, got %d", YLM_SHADE_SAMPLES,
                    o->samples);
  if (o->lmax < 0 || o->lmax > YLM_LIGHT_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax must be from 0 to %d, got %d", YLM_LIGHT_LMAX, o->lmax);
  if (o->transfer_samples < 1 || o->transfer_samples > YLM_SCENE_SAMPLES)
    return ylm_fail(e, YLM_ERANGE, "transfer_samples must be from 1 to %d, got %d",
                    YLM_SCENE_SAMPLES, o->transfer_samples);
  if (!(o->occlusion_distance > 0))
    return ylm_fail(e, YLM_ERANGE, "occlusion_distance must be > 0, got %g", o->occlusion_distance);
  if (o->all_vertices && !o->per_vertex)
    return ylm_fail(e, YLM_EINVAL, "shading points are vertices where they are all vertices");
  if (o->gloss == YLM_SHADE_GLOSS_RAYS && o->per_vertex)
    return ylm_fail(e, YLM_EINVAL, "surfaces that gloss are shaded by rays from pixels alone");
  if (o->gloss == YLM_SHADE_GLOSS_AUTO &&
      !(o->gloss_error[0] >= 0 && o->gloss_error[0] < o->gloss_error[1]))
    return ylm_fail(e, YLM_ERANGE, "gloss_error must be two numbers, 0 <= first < second");
  if (!(o->share >= 0)) return ylm_fail(e, YLM_ERANGE, "share must be >= 0, got %g", o->share);
  if (o->pixel && (o->pixels < 1 || o->pixels > YLM_SHADE_PIXELS))
    return ylm_fail(e, YLM_ERANGE, "from 1 to %d pixels are listed, got %zu", YLM_SHADE_PIXELS,
                    o->pixels);
  for (size_t i = 0; o->pixel && i < o->pixels; i++)
    if (o->pixel[i] >= (uint64_t)o->width * (uint64_t)o->height)
      return ylm_fail(e, YLM_ERANGE, "pixel %u is not of an image of %dx%d", o->pixel[i], o->width,
                      o->height);
  return YLM_OK;
}

/* Room for `n` points and, if asked for, their transfer vectors. */
static ylm_status make_points(ylm_shade_view *v, size_t n) {
  v->points = n;
  v->mesh = ylm_alloc(n, sizeof *v->mesh);
  v->position = ylm_alloc(n, sizeof *v->position);
  v->normal = ylm_alloc(n, sizeof *v->normal);
  v->origin = ylm_alloc(n, sizeof *v->origin);
  v->lit = ylm_alloc(n, sizeof *v->lit);
  bool rays = v->o.visibility == YLM_SHADE_RAYS;
  if (!rays) v->transfer = ylm_alloc(n, ylm_sh_count(v->o.lmax) * sizeof *v->transfer);
  if (!v->mesh || !v->position || !v->normal || !v->origin || !v->lit || (!rays && !v->transfer))
    return YLM_ENOMEM;
  ylm_status s = ylm__shade_gloss_room(v->gloss, n);
  return s == YLM_OK ? ylm__shade_make_tints(v) : s;
}

static void set_point(ylm_shade_view *v, size_t i, uint32_t mesh, const ylm_scene_surface *s) {
  v->mesh[i] = mesh;
  memcpy(v->position[i], s->position, 12);
  memcpy(v->normal[i], s->normal, 12);
  memcpy(v->origin[i], s->origin, 12);
  memcpy(v->lit[i], s->lit, 12);
  if (v->tint && v->tint != v->seen) memcpy(v->tint[i], s->tint, 12);
  if (v->gloss) ylm__shade_gloss_point(v->gloss, i, mesh, s);
}

static ylm_status set_points(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  ylm_shade_view *v = context;
  for (size_t i = begin; i < end; i++) {
    ylm_scene_surface s;
    ylm_scene_surfaces(v->scene, 1, &v->entry[i].at, &s);
    set_point(v, i, v->entry[i].at.mesh, &s);
  }
  return YLM_OK;
}

/* Points are the entries themselves. */
static ylm_status points_of_entries(ylm_shade_view *v) {
  size_t rows = (size_t)v->o.height;
  ylm_progress_part whole; /* the stage before stays at its end */
  ylm_status status = make_points(v, v->entries);
  if (status != YLM_OK) return status;
  return ylm_parallel(
      v->entries, SHADE_GRAIN, v->gloss ? 1 : v->o.threads, set_points, v, /* gloss counts points */
      ylm_progress_part_of(&whole, v->o.progress, "primary rays", rows, 0, rows), NULL);
}

/* Points are vertices; takes x->corner over. */
static ylm_status points_of_vertices(ylm_shade_view *v, shade_vertices *x) {
  ylm_status status = make_points(v, x->count);
  for (size_t i = 0; status == YLM_OK && i < x->count; i++) {
    ylm_scene_surface s;
    ylm_scene_vertex(v->scene, x->mesh[i], x->vertex[i], x->back[i], &s);
    set_point(v, i, x->mesh[i], &s);
  }
  v->corner = x->corner;
  x->corner = NULL;
  if (!v->o.all_vertices) return status;
  v->vertex = x->place;
  x->place = NULL;
  return status;
}

/* The pixel of point i. */
static size_t pixel_of(const ylm_shade_view *v, size_t i) {
  size_t low = 0, high = v->stats.pixels; /* the pixel is among low .. high-1 */
  while (high - low > 1) {
    size_t middle = low + (high - low) / 2;
    if (v->pixel[middle].first <= i)
      low = middle;
    else
      high = middle;
  }
  return low;
}

shade_stream ylm__shade_stream_at(const ylm_shade_view *v, size_t i) {
  return (shade_stream){i, v->corner ? 0 : pixel_of(v, i)};
}

uint64_t ylm__shade_stream_next(const ylm_shade_view *v, shade_stream *at) {
  size_t i = at->point++;
  if (v->corner) return i;
  while (v->pixel[at->pixel + 1].first <= i) at->pixel++;
  return (uint64_t)(v->number ? v->number[at->pixel] : at->pixel) << 24 |
         (i - v->pixel[at->pixel].first);
}

uint64_t ylm__shade_stream(const ylm_shade_view *v, size_t i) {
  shade_stream at = ylm__shade_stream_at(v, i);
  return ylm__shade_stream_next(v, &at);
}

uint64_t *ylm__shade_streams(const ylm_shade_view *v) {
  uint64_t *stream = ylm_alloc(v->points, sizeof *stream);
  shade_stream at = ylm__shade_stream_at(v, 0);
  for (size_t i = 0; stream && i < v->points; i++) stream[i] = ylm__shade_stream_next(v, &at);
  return stream;
}

void ylm__shade_corner_weights(const shade_entry *e, float w[3]) {
  w[0] = 1 - e->at.u - e->at.v;
  w[1] = e->at.u;
  w[2] = e->at.v;
}

/* Transfer vectors of entries from those at vertices. */
static ylm_status transfer_by_vertices(ylm_shade_view *v, const shade_vertices *x) {
  size_t count = ylm_sh_count(v->o.lmax);
  float(*normal)[3] = ylm_alloc(x->count, sizeof *normal);
  float(*origin)[3] = ylm_alloc(x->count, sizeof *origin);
  float *T = ylm_alloc(x->count, count * sizeof *T);
  ylm_status status = normal && origin && T ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; status == YLM_OK && i < x->count; i++) {
    ylm_scene_surface s;
    ylm_scene_vertex(v->scene, x->mesh[i], x->vertex[i], x->back[i], &s);
    memcpy(normal[i], s.normal, 12);
    memcpy(origin[i], s.origin, 12);
  }
  if (status == YLM_OK)
    status = ylm__shade_transfer(v, true, x->count, x->mesh, (const float(*)[3])normal,
                                 (const float(*)[3])origin, NULL, T, &v->stats.occlusion_rays);
  for (size_t i = 0; status == YLM_OK && i < v->entries; i++) {
    const uint32_t *c = x->corner[i];
    float w[3];
    ylm__shade_corner_weights(&v->entry[i], w);
    for (size_t k = 0; k < count; k++)
      v->transfer[i * count + k] =
          w[0] * T[c[0] * count + k] + w[1] * T[c[1] * count + k] + w[2] * T[c[2] * count + k];
  }
  ylm_free(normal);
  ylm_free(origin);
  ylm_free(T);
  return status;
}

/* The shares of rays at the points of a view, in memory of their own. */
static ylm_status make_shares(ylm_shade_view *v, const shade_tables *tables, float **share) {
  *share = ylm_alloc(v->points, sizeof **share);
  if (!*share) return YLM_ENOMEM;
  ylm__shade_gloss_shares(v, tables, v->o.lmax, 0, v->points, *share, NULL);
  bool shadows = v->o.visibility == YLM_SHADE_PIXEL; /* others' rows are made all the same */
  for (size_t i = 0; shadows && i < v->points; i++) v->idle += (*share)[i] >= 1;
  return YLM_OK;
}

static void free_own(ylm_shade_view *v) {
  for (size_t m = 0; v->own && m < ylm_scene_meshes(v->scene); m++) ylm_trace_free(v->own[m]);
  ylm_free(v->own);
  v->own = NULL;
}

/* Each mesh alone, where occlusion rays are to meet no other. */
static ylm_status make_own(ylm_shade_view *v, ylm_error *e) {
  size_t meshes = ylm_scene_meshes(v->scene);
  if (!v->o.self || !v->transfer || v->o.visibility == YLM_SHADE_UNSHADOWED) return YLM_OK;
  v->own = ylm_alloc_zero(meshes, sizeof *v->own);
  ylm_status s = v->own ? YLM_OK : YLM_ENOMEM;
  for (size_t m = 0; s == YLM_OK && m < meshes; m++)
    s = ylm_scene_trace_mesh(v->scene, m, &v->own[m], e);
  return s;
}

/* Shading points and their transfer vectors, once the entries are known. */
static ylm_status make_transfer(ylm_shade_view *v, ylm_error *e) {
  const shade_tables *tables = NULL;
  float *share = NULL;
  double start = ylm_seconds();
  bool by_vertex = !v->o.per_vertex && v->o.visibility == YLM_SHADE_VERTEX;
  shade_vertices x = {0};
  ylm_status s = YLM_OK;
  if (v->o.per_vertex || by_vertex) s = ylm__shade_vertices(v, &x);
  if (s == YLM_OK) s = v->o.per_vertex ? points_of_vertices(v, &x) : points_of_entries(v);
  if (s == YLM_OK) s = make_own(v, e);
  if (s == YLM_OK && v->transfer) /* refused, or made, here rather than at the first picture */
    s = ylm__shade_gloss_tables(v, v->o.lmax, v->o.threads, v->o.progress, &tables, e);
  if (s == YLM_OK && v->transfer && v->gloss) s = make_shares(v, tables, &share);
  if (s == YLM_OK) s = ylm__shade_choose_samples(v, tables, share, e);
  if (s == YLM_OK && by_vertex)
    s = transfer_by_vertices(v, &x);
  else if (s == YLM_OK && v->transfer)
    s = ylm__shade_transfer(v, v->o.visibility != YLM_SHADE_UNSHADOWED, v->points, v->mesh,
                            (const float(*)[3])v->normal, (const float(*)[3])v->origin, share,
                            v->transfer, &v->stats.occlusion_rays);
  ylm__shade_vertices_free(&x);
  ylm_free(share);
  free_own(v);
  v->stats.transfer_seconds = ylm_seconds() - start;
  return s;
}

static size_t bytes_held(const ylm_shade_view *v) {
  return sizeof *v + v->entries * (sizeof(shade_entry) + (v->corner ? 12 : 0)) +
         (v->stats.pixels + 1) * sizeof(shade_pixel) +
         v->points * (4 + 4 * 12 + (v->transfer ? 4 * ylm_sh_count(v->o.lmax) : 0)) +
         (v->vertex ? 8 * ylm_scene_vertices(v->scene, NULL) : 0) +
         (v->seen ? 12 * v->entries : 0) + (v->tint != v->seen ? 12 * v->points : 0);
}

/* The pixels that are listed make an image of one column. */
static ylm_status list_pixels(ylm_shade_view *v) {
  v->image[0] = v->o.width;
  v->image[1] = v->o.height;
  if (!v->o.pixel) return YLM_OK;
  v->number = ylm_alloc_copy(v->o.pixel, v->o.pixels, sizeof *v->number);
  v->o.width = 1;
  v->o.height = (int)v->o.pixels;
  return v->number ? YLM_OK : YLM_ENOMEM;
}

ylm_status ylm_shade_view_create(const ylm_scene *scene, const ylm_camera *camera,
                                 const ylm_shade_options *o, ylm_shade_view **view, ylm_error *e) {
  *view = NULL;
  ylm_camera_frame frame;
  ylm_status s = check_options(o, e);
  if (s == YLM_OK) s = ylm_scene_frame(scene, camera, o->width, o->height, &frame, e);
  if (s != YLM_OK) return s;
  ylm_shade_view *v = ylm_alloc_zero(1, sizeof *v);
  if (!v) return YLM_ENOMEM;
  v->scene = scene;
  v->world = ylm_scene_origin(scene);
  v->o = *o;
  v->frame = frame;
  s = list_pixels(v);
  if (s == YLM_OK && o->gloss) s = ylm__shade_gloss_create(v, NULL, &v->gloss, e);
  if (s == YLM_OK) s = ylm__shade_primary(v, &frame);
  if (s == YLM_OK) s = make_transfer(v, e);
  v->o.progress = NULL;
  v->o.light = NULL;
  v->o.pixel = NULL;
  v->stats.points = v->points;
  v->stats.bytes = bytes_held(v);
  if (s == YLM_OK)
    *view = v;
  else
    ylm_shade_view_free(v);
  return s;
}

void ylm_shade_view_free(ylm_shade_view *v) {
  if (!v) return;
  if (v->base) {
    ylm__shade_change_free(v);
    return;
  }
  ylm_free(v->entry);
  ylm_free(v->pixel);
  ylm_free(v->number);
  ylm_free(v->corner);
  ylm_free(v->mesh);
  ylm_free(v->position);
  ylm_free(v->normal);
  ylm_free(v->origin);
  ylm_free(v->lit);
  ylm_free(v->transfer);
  ylm_free(v->vertex);
  ylm__shade_free_tints(v);
  ylm__shade_gloss_free(v->gloss);
  ylm_free(v);
}

void ylm_shade_view_stats(const ylm_shade_view *v, ylm_shade_stats *stats) {
  *stats = v->stats;
  ylm__shade_gloss_stats(v, stats);
}
const ylm_shade_options *ylm_shade_view_options(const ylm_shade_view *v) { return &v->o; }
const float *ylm_shade_view_positions(const ylm_shade_view *v) { return v->position[0]; }
const double *ylm_shade_view_origin(const ylm_shade_view *v) { return v->world; }
const float *ylm_shade_view_normals(const ylm_shade_view *v) { return v->normal[0]; }
const float *ylm_shade_view_transfer(const ylm_shade_view *v) { return v->transfer; }

/* -- pixels -------------------------------------------------------------------- */

typedef struct resolve_job {
  const ylm_shade_view *v;
  int channels;
  const float *values, *fill;
  bool covered;
  float *out;
} resolve_job;

/* The values at an entry. */
static float entry_value(const resolve_job *j, size_t i, int c) {
  size_t n = (size_t)j->channels;
  if (!j->v->corner) return j->values[i * n + (size_t)c];
  float w[3], s = 0;
  ylm__shade_corner_weights(&j->v->entry[i], w);
  for (int k = 0; k < 3; k++)
    s = with_share(s, w[k], j->values[j->v->corner[i][k] * n + (size_t)c]);
  return s;
}

static ylm_status resolve_pixels(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const resolve_job *j = context;
  for (size_t p = begin; p < end; p++) {
    const shade_pixel *q = &j->v->pixel[p];
    for (int c = 0; c < j->channels; c++) {
      float s = 0, weight = 0, fill = j->fill ? j->fill[c] : 0;
      for (size_t i = q[0].first; i < q[1].first; i++) {
        s += j->v->entry[i].weight * entry_value(j, i, c);
        weight += j->v->entry[i].weight;
      }
      if (j->covered)
        s = weight > 0 ? s / weight : fill;
      else
        s += fill * fmaxf(0, 1 - q->coverage - q->emitter);
      j->out[p * (size_t)j->channels + (size_t)c] = s;
    }
  }
  return YLM_OK;
}

ylm_status ylm_shade_resolve(const ylm_shade_view *v, int channels, const float *values,
                             const float *fill, bool covered, int threads, float *out) {
  if (channels < 1 || channels > 4) return YLM_ERANGE;
  resolve_job j = {v, channels, values, fill, covered, out};
  return ylm_parallel(v->stats.pixels, SHADE_GRAIN, threads, resolve_pixels, &j, NULL, NULL);
}

typedef struct compose_job {
  const ylm_shade_view *v;
  const float *colours, *background;
  float *out;
} compose_job;

static ylm_status compose_pixels(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const compose_job *j = context;
  const ylm_shade_view *v = j->v;
  resolve_job values = {.v = v, .channels = 3, .values = j->colours};
  for (size_t p = begin; p < end; p++) {
    const shade_pixel *q = &v->pixel[p];
    float rest = fmaxf(0, 1 - q->coverage - q->emitter), sum[3];
    for (int c = 0; c < 3; c++) sum[c] = with_share(q->lamps[c], rest, j->background[c]);
    for (size_t i = q[0].first; i < q[1].first; i++) {
      float weight = v->entry[i].weight;
      for (int c = 0; c < 3; c++)
        sum[c] = with_share(sum[c], weight,
                            v->corner ? entry_value(&values, i, c) : j->colours[3 * i + (size_t)c]);
    }
    memcpy(j->out + 3 * p, sum, sizeof sum);
  }
  return YLM_OK;
}

ylm_status ylm_shade_compose(const ylm_shade_view *v, const float *colours,
                             const float background[3], int threads, float *out) {
  compose_job j = {v, colours, background, out};
  return ylm_parallel(v->stats.pixels, SHADE_GRAIN, threads, compose_pixels, &j, NULL, NULL);
}

/* -- layers -------------------------------------------------------------------- */

typedef struct layer_job {
  const ylm_shade_view *v;
  ylm_shade_layer layer;
  float *out;
} layer_job;

int ylm_shade_layer_channels(ylm_shade_layer layer) {
  switch (layer) {
  case YLM_SHADE_DEPTH:
  case YLM_SHADE_COVERAGE:
  case YLM_SHADE_EMITTER:
  case YLM_SHADE_OBJECT: return 1;
  default: return 3;
  }
}

/* Means over the surface of one pixel: normal, position, albedo or depth. */
static void surface_mean(const layer_job *j, const shade_pixel *q, float *out) {
  int channels = ylm_shade_layer_channels(j->layer);
  float sum[3] = {0}, weight = 0;
  for (size_t i = q[0].first; i < q[1].first; i++) {
    const shade_entry *e = &j->v->entry[i];
    ylm_scene_surface s;
    const float *x = &e->depth;
    float albedo[3];
    if (j->layer == YLM_SHADE_ALBEDO) {
      ylm__shade_seen_albedo(j->v, i, albedo);
      x = albedo;
    } else if (j->layer != YLM_SHADE_DEPTH) {
      ylm_scene_surfaces(j->v->scene, 1, &e->at, &s);
      x = j->layer == YLM_SHADE_NORMAL ? s.normal : s.position;
    }
    for (int c = 0; c < channels; c++) sum[c] += e->weight * x[c];
    weight += e->weight;
  }
  if (j->layer == YLM_SHADE_NORMAL) weight = sqrtf(ylm_dot3(sum, sum));
  for (int c = 0; c < channels; c++)
    out[c] = weight > 0 ? sum[c] / weight : j->layer == YLM_SHADE_DEPTH ? INFINITY : 0;
  for (int c = 0; j->layer == YLM_SHADE_POSITION && j->v->world && weight > 0 && c < 3; c++)
    out[c] = (float)((double)out[c] + j->v->world[c]);
}

/* The entry that has the largest part of a pixel; NULL: there is none. */
static const shade_entry *largest(const ylm_shade_view *v, const shade_pixel *q) {
  const shade_entry *best = NULL;
  for (size_t i = q[0].first; i < q[1].first; i++)
    if (!best || v->entry[i].weight > best->weight) best = &v->entry[i];
  return best;
}

static float object_of(const ylm_shade_view *v, const shade_pixel *q) {
  const shade_entry *e = largest(v, q);
  return e ? (float)(e->at.mesh + 1) : 0;
}

bool ylm_shade_view_hit(const ylm_shade_view *v, int x, int y, ylm_shade_hit *hit) {
  if (x < 0 || y < 0 || x >= v->o.width || y >= v->o.height) return false;
  const shade_entry *e = largest(v, &v->pixel[(size_t)y * (size_t)v->o.width + (size_t)x]);
  ylm_scene_surface s;
  if (!e) return false;
  ylm_scene_surfaces(v->scene, 1, &e->at, &s);
  *hit = (ylm_shade_hit){.depth = e->depth, .object = e->at.mesh};
  memcpy(hit->position, s.position, sizeof s.position);
  memcpy(hit->normal, s.normal, sizeof s.normal);
  return true;
}

static ylm_status write_layer(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const layer_job *j = context;
  int channels = ylm_shade_layer_channels(j->layer);
  for (size_t p = begin; p < end; p++) {
    const shade_pixel *q = &j->v->pixel[p];
    float *out = j->out + p * (size_t)channels;
    switch (j->layer) {
    case YLM_SHADE_RADIANCE_OF_LAMPS: memcpy(out, q->lamps, 12); break;
    case YLM_SHADE_COVERAGE: *out = q->coverage; break;
    case YLM_SHADE_EMITTER: *out = q->emitter; break;
    case YLM_SHADE_OBJECT: *out = object_of(j->v, q); break;
    default: surface_mean(j, q, out);
    }
  }
  return YLM_OK;
}

ylm_status ylm_shade_layer_write(const ylm_shade_view *v, ylm_shade_layer layer, int threads,
                                 float *out) {
  layer_job j = {v, layer, out};
  return ylm_parallel(v->stats.pixels, SHADE_LAYER_GRAIN, threads, write_layer, &j, NULL, NULL);
}
