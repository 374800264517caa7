/*
** bodies.c - bodies that move: their radiance from transfer vectors that are turned with them, and their pixels over a
** picture of all that stands still.
**
** A body is a view of a scene of its own, whose shading points are all its vertices: its transfer vectors know the body
** alone and stay what they are while it moves. Camera rays are traced in its frame, so that no tree is built anew.
*/
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "../calibration.h"
#include "../gen/picture.h"
#include "../view.h"
#include "uncovered.h"
#include "ylm_sh.h"
#include "ylm_shade_over.h"

/* -- light ------------------------------------------------------------------------------------- */

static ylm_status check_body(const ylm_shade_body *b, ylm_error *e) {
  const ylm_shade_view *v = b->view;
  if (!v->o.all_vertices || !v->transfer || v->gloss)
    return ylm_fail(e, YLM_EINVAL,
                    "a body is a view of all vertices with transfer vectors, of matte surfaces");
  if (!ylm_all_finite(YLM_DOUBLE, b->at, 3, NULL) || !(b->scale > 0) || !isfinite(b->scale))
    return ylm_fail(e, YLM_EDOMAIN, "a body's place must be finite, and its scale above 0");
  double exact[9];
  return ylm_sh_rotation_check(b->rotation, exact, e);
}

/* Where the origin of the body's positions stands in the world, relative to `origin` (NULL: 0). */
static void stand(const ylm_shade_body *b, const double *origin, double at[3]) {
  const double *own = b->view->world;
  for (int a = 0; a < 3; a++) {
    at[a] = b->at[a] - (origin ? origin[a] : 0);
    for (int k = 0; own && k < 3; k++) at[a] += b->scale * b->rotation[3 * a + k] * own[k];
  }
}

/* The place of a point of the body's frame, whose origin stands at `at`. */
static void place(const ylm_shade_body *b, const double at[3], const float p[3], float out[3]) {
  for (int a = 0; a < 3; a++) {
    double x = at[a];
    for (int k = 0; k < 3; k++) x += b->scale * b->rotation[3 * a + k] * (double)p[k];
    out[a] = (float)x;
  }
}

/* The body's transfer vectors, turned. */
static ylm_status turn(const ylm_shade_body *b, int threads, float *out, ylm_error *e) {
  const ylm_shade_view *v = b->view;
  ylm_sh_rotator *rotator = NULL;
  ylm_sh_rotation *rotation = NULL;
  ylm_status s = ylm_sh_rotator_create(v->o.lmax, &rotator, e);
  if (s == YLM_OK)
    s = ylm_sh_rotation_create(rotator, b->rotation, v->o.lmax, YLM_FLOAT, &rotation, e);
  if (s == YLM_OK)
    s = ylm_sh_rotation_apply(rotation, v->o.lmax, v->points, v->transfer, out, threads, NULL);
  ylm_sh_rotation_free(rotation);
  ylm_sh_rotator_free(rotator);
  return s;
}

/* The origin for positions of a body where it stands. */
static void origin_of(const ylm_shade_body *b, double origin[3]) {
  double lo[3], hi[3], middle[3], r = 0, box[6];
  ylm_scene_bounds(b->view->scene, lo, hi);
  stand(b, NULL, middle);
  for (int a = 0; a < 3; a++) {
    r += (hi[a] - lo[a]) * (hi[a] - lo[a]) / 4;
    for (int k = 0; k < 3; k++)
      middle[a] += b->scale * b->rotation[3 * a + k] * (lo[k] + hi[k]) / 2;
  }
  for (int a = 0; a < 6; a++) box[a] = middle[a % 3] + (a < 3 ? -1 : 1) * b->scale * sqrt(r);
  ylm_origin(box, origin);
}

ylm_status ylm_shade_body_field(const ylm_shade_body *b, const ylm_field *light, int threads,
                                const ylm_progress *progress, float *out, uint64_t *pairs,
                                ylm_error *e) {
  ylm_status s = check_body(b, e);
  if (s != YLM_OK) return s;
  ylm_shade_view there = *b->view;
  double origin[3], at[3];
  origin_of(b, origin);
  stand(b, origin, at);
  there.world = origin;
  there.position = ylm_alloc(there.points, sizeof *there.position);
  there.transfer = ylm_alloc(there.points, ylm_sh_count(there.o.lmax) * sizeof *there.transfer);
  s = there.position && there.transfer ? turn(b, threads, there.transfer, e) : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < there.points; i++)
    place(b, at, b->view->position[i], there.position[i]);
  if (s == YLM_OK)
    s = ylm_shade_field(&there, light, YLM_SHADE_TRANSFER, YLM_FLOAT, threads, progress, out, pairs,
                        e);
  ylm_free(there.position);
  ylm_free(there.transfer);
  return s;
}

/* -- pixels ------------------------------------------------------------------------------------ */

typedef struct span {
  int x0, x1, y0, y1; /* pixels that the body may be in */
} span;

typedef struct job {
  const ylm_shade_view *v;
  const ylm_shade_body *body;
  const span *box;
  size_t n;
  float *out;
  atomic_uint_fast64_t rays;
} job;

/* Hits of the rays of a pixel. */
typedef struct scratch {
  ylm_trace_ray *ray, *own; /* [samples] the camera's, and in a body's frame */
  ylm_trace_hit *hit, *nearest;
  size_t *of; /* [samples] the body of the nearest */
} scratch;

/* The pixels of a sphere around a body: all where the camera is near it, none where it is behind. */
static span box_of(const ylm_shade_view *v, const ylm_shade_body *b) {
  const ylm_camera_frame *f = &v->frame;
  double lo[3], hi[3], r = 0, to[3], stands[3], width = v->o.width, height = v->o.height;
  float middle[3], at[3];
  ylm_scene_bounds(b->view->scene, lo, hi);
  for (int a = 0; a < 3; a++) {
    middle[a] = (float)((lo[a] + hi[a]) / 2);
    r += (hi[a] - lo[a]) * (hi[a] - lo[a]) / 4;
  }
  r = 1.001 * sqrt(r) * b->scale;
  stand(b, v->world, stands);
  place(b, stands, middle, at);
  for (int a = 0; a < 3; a++) to[a] = (double)at[a] - f->from[a];
  double far = sqrt(ylm_dot3d(to, to)), z = ylm_dot3d(to, f->forward);
  if (z < -r) return (span){0, 0, 0, 0};
  if (!(z > 1.01 * r) || !(far > 1.01 * r)) return (span){0, v->o.width, 0, v->o.height};
  double x = (ylm_dot3d(to, f->right) / ylm_dot3d(f->right, f->right) / z + 1) / 2 * width;
  double y = (1 - ylm_dot3d(to, f->up) / ylm_dot3d(f->up, f->up) / z) / 2 * height;
  double tangent = r / sqrt(far * far - r * r),
         reach = 2 + tangent * 1.5 * (far / z) * (far / z) / f->pixel;
  if (z < 2 * r) return (span){0, v->o.width, 0, v->o.height};
  return (span){(int)fmax(0, floor(x - reach)), (int)fmin(width, ceil(x + reach)),
                (int)fmax(0, floor(y - reach)), (int)fmin(height, ceil(y + reach))};
}

static bool is_in(const span *s, int x, int y) {
  return x >= s->x0 && x < s->x1 && y >= s->y0 && y < s->y1;
}

/* A camera ray, relative to `origin`, in a body's frame: distances along it stay what they are. */
static void into_frame(const ylm_shade_body *b, const double *origin, const ylm_trace_ray *ray,
                       ylm_trace_ray *own) {
  double at[3];
  stand(b, origin, at);
  *own = *ray;
  for (int a = 0; a < 3; a++) {
    double org = 0, dir = 0;
    for (int k = 0; k < 3; k++) {
      double r = b->rotation[3 * k + a] / b->scale;
      org += r * ((double)ray->org[k] - at[k]);
      dir += r * (double)ray->dir[k];
    }
    own->org[a] = (float)org;
    own->dir[a] = (float)dir;
  }
}

/* The radiance at a hit. */
static void colour_of(const ylm_shade_body *b, const ylm_trace_hit *h, float out[3]) {
  const ylm_shade_view *v = b->view;
  const uint32_t *corner = ylm_scene_triangle(v->scene, (size_t)h->mesh, h->element);
  size_t first = ylm_scene_first_vertex(v->scene, (size_t)h->mesh);
  float w[3] = {1 - h->u - h->v, h->u, h->v};
  memset(out, 0, 3 * sizeof *out);
  for (int k = 0; k < 3; k++) {
    uint32_t point = v->vertex[2 * (first + corner[k])];
    for (size_t c = 0; c < 3; c++) out[c] += w[k] * b->radiance[3 * point + c];
  }
}

static void draw_pixel(job *j, scratch *s, int x, int y) {
  const ylm_shade_view *v = j->v;
  int samples = v->o.samples, met = 0;
  size_t pixel = (size_t)y * (size_t)v->o.width + (size_t)x, rays = 0;
  bool asked = false;
  for (size_t k = 0; k < j->n; k++) {
    const ylm_shade_body *b = &j->body[k];
    if (!is_in(&j->box[k], x, y)) continue;
    if (!asked) ylm__shade_pixel_rays(v, pixel, samples, v->o.seed, s->ray);
    for (int i = 0; i < samples; i++) into_frame(b, v->world, &s->ray[i], &s->own[i]);
    ylm_trace_intersect(ylm_scene_trace(b->view->scene), (size_t)samples, s->own, true, s->hit);
    rays += (size_t)samples;
    for (int i = 0; i < samples; i++) {
      if (!asked) s->nearest[i].mesh = YLM_TRACE_NOTHING;
      if (s->hit[i].mesh < 0) continue;
      if (s->nearest[i].mesh >= 0 && s->nearest[i].t <= s->hit[i].t) continue;
      s->nearest[i] = s->hit[i];
      s->of[i] = k;
      met++;
    }
    asked = true;
  }
  atomic_fetch_add_explicit(&j->rays, rays, memory_order_relaxed);
  if (!met) return;
  float *to = j->out + 3 * pixel, sum[3] = {0}, covered = 0;
  for (int i = 0; i < samples; i++) {
    if (s->nearest[i].mesh < 0) continue;
    float colour[3], part = (float)(open_part(v, pixel, (double)s->nearest[i].t) / samples);
    colour_of(&j->body[s->of[i]], &s->nearest[i], colour);
    covered += part;
    for (int c = 0; c < 3; c++) sum[c] += part * colour[c];
  }
  for (int c = 0; c < 3; c++) to[c] = (1 - covered) * to[c] + sum[c];
}

static ylm_status draw_rows(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  job *j = context;
  size_t samples = (size_t)j->v->o.samples;
  scratch s = {.ray = ylm_alloc(samples, sizeof *s.ray),
               .own = ylm_alloc(samples, sizeof *s.own),
               .hit = ylm_alloc(samples, sizeof *s.hit),
               .nearest = ylm_alloc(samples, sizeof *s.nearest),
               .of = ylm_alloc(samples, sizeof *s.of)};
  bool ok = s.ray && s.own && s.hit && s.nearest && s.of;
  for (int y = (int)begin; ok && y < (int)end; y++) {
    int from = j->v->o.width, to = 0;
    for (size_t k = 0; k < j->n; k++)
      if (y >= j->box[k].y0 && y < j->box[k].y1) {
        from = j->box[k].x0 < from ? j->box[k].x0 : from;
        to = j->box[k].x1 > to ? j->box[k].x1 : to;
      }
    for (int x = from; x < to; x++) draw_pixel(j, &s, x, y);
  }
  ylm_free(s.ray);
  ylm_free(s.own);
  ylm_free(s.hit);
  ylm_free(s.nearest);
  ylm_free(s.of);
  return ok ? YLM_OK : YLM_ENOMEM;
}

ylm_status ylm_shade_draw_bodies(const ylm_shade_view *v, size_t n, const ylm_shade_body *body,
                                 int threads, float *out, uint64_t *rays, ylm_error *e) {
  span *box = ylm_alloc(n, sizeof *box);
  ylm_status s = box ? YLM_OK : YLM_ENOMEM;
  for (size_t k = 0; k < n && s == YLM_OK; k++) {
    s = check_body(&body[k], e);
    if (s == YLM_OK) box[k] = box_of(v, &body[k]);
  }
  job j = {.v = v, .body = body, .box = box, .n = n, .out = out};
  if (s == YLM_OK)
    s = ylm_parallel((size_t)v->o.height, SHADE_LAMP_ROWS, threads, draw_rows, &j, NULL, NULL);
  if (rays) *rays = atomic_load(&j.rays);
  ylm_free(box);
  return s;
}
