/* primary.c - camera rays, and the grouping of what they hit into shading points. */
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "../calibration.h"
#include "../view.h"
#include "ylm_list.h"

/* Samples of one pixel that are shaded as one. */
typedef struct group {
  uint32_t mesh;
  float position[3], normal[3]; /* of its first sample */
  double sum[3];
  float tint[3]; /* summed */
  int count;
} group;

/* A row of the image while it is made. */
typedef struct row {
  shade_entry *entry;
  float (*tint)[3];          /* [room] mean tints, where the scene has some */
  size_t count, room, first; /* first: of its entries among those of all rows */
} row;

/* How far samples of a mesh are from each other in one shading point. */
typedef struct nearness {
  float cosine; /* of normals */
  double share; /* pixel widths */
} nearness;

typedef struct job {
  ylm_shade_view *view;
  nearness *near; /* [meshes] */
  bool tinted;
  const ylm_camera_frame *frame;
  row *rows;
  const float *radical; /* [samples] */
  atomic_size_t hits;
} job;

/* Scratch for one pixel and one batch of rays. */
typedef struct scratch {
  ylm_trace_ray *ray;
  ylm_trace_hit *hit;
  shade_entry *entry;         /* [samples], of one pixel */
  ylm_scene_surface *surface; /* [samples] */
  group *groups;              /* [samples] */
  int *group_of, *sample;     /* [samples]: of what surfaces are at */
} scratch;

static float wrap(double x) { return (float)(x - floor(x)); }

/* Ray i of n through places of pixel (x, y): a Hammersley set shifted by a, b. */
static void pixel_ray(const ylm_camera_frame *f, const int image[2], int x, int y, int i, int n,
                      double radical, const double shift[2], ylm_trace_ray *ray) {
  double sx = 2 * (x + wrap((double)i / n + shift[0])) / image[0] - 1;
  double sy = 1 - 2 * (y + wrap(radical + shift[1])) / image[1];
  for (int k = 0; k < 3; k++) {
    ray->org[k] = (float)f->from[k];
    ray->dir[k] = (float)(f->forward[k] + sx * f->right[k] + sy * f->up[k]);
  }
  ray->near = 0;
  ray->far = INFINITY;
}

/* Of pixel (x, y) of the view: its place in the image, and what its set is shifted by. */
static void pixel_shift(const ylm_shade_view *v, uint64_t seed, int *x, int *y, double shift[2]) {
  ylm_rng rng;
  if (v->number) {
    uint32_t number = v->number[*y];
    *x = (int)(number % (uint32_t)v->image[0]);
    *y = (int)(number / (uint32_t)v->image[0]);
  }
  ylm_rng_seed(&rng, seed, (uint64_t)*y * (uint64_t)v->image[0] + (uint64_t)*x);
  shift[0] = ylm_rng_double(&rng);
  shift[1] = ylm_rng_double(&rng);
}

/* The rays through stratified places of pixel (x, y). */
static void pixel_rays(const job *j, int x, int y, ylm_trace_ray *ray) {
  const ylm_shade_view *v = j->view;
  double shift[2];
  pixel_shift(v, v->o.seed, &x, &y, shift);
  for (int i = 0; i < v->o.samples; i++)
    pixel_ray(j->frame, v->image, x, y, i, v->o.samples, (double)j->radical[i], shift, ray + i);
}

void ylm__shade_pixel_rays(const ylm_shade_view *v, size_t p, int n, uint64_t seed,
                           ylm_trace_ray *ray) {
  int x = (int)(p % (size_t)v->o.width), y = (int)(p / (size_t)v->o.width);
  double shift[2];
  pixel_shift(v, seed, &x, &y, shift);
  for (int i = 0; i < n; i++)
    pixel_ray(&v->frame, v->image, x, y, i, n, ylm_scene_radical((uint32_t)i), shift, ray + i);
}

void ylm__shade_pixel_shift(const ylm_shade_view *v, size_t p, int at[2], double shift[2]) {
  at[0] = (int)(p % (size_t)v->o.width), at[1] = (int)(p / (size_t)v->o.width);
  pixel_shift(v, v->o.seed, &at[0], &at[1], shift);
}

void ylm__shade_pixel_ray(const ylm_shade_view *v, const int at[2], const double shift[2], int i,
                          ylm_trace_ray *ray) {
  pixel_ray(&v->frame, v->image, at[0], at[1], i, v->o.samples, ylm_scene_radical((uint32_t)i),
            shift, ray);
}

/* The group that a surface belongs to, a new one if none fits. */
static int find_group(const nearness *near, group *groups, int *count, const shade_entry *e,
                      const ylm_scene_surface *s, double pixel) {
  double reach = near[e->at.mesh].share * pixel * (double)e->depth;
  for (int g = 0; g < *count; g++) {
    if (groups[g].mesh != e->at.mesh ||
        ylm_dot3(groups[g].normal, s->normal) < near[e->at.mesh].cosine)
      continue;
    double d2 = 0;
    for (int a = 0; a < 3; a++) {
      double d = (double)s->position[a] - (double)groups[g].position[a];
      d2 += d * d;
    }
    if (d2 < reach * reach) return g;
  }
  group *g = &groups[*count];
  memset(g, 0, sizeof *g);
  g->mesh = e->at.mesh;
  memcpy(g->position, s->position, 12);
  memcpy(g->normal, s->normal, 12);
  return (*count)++;
}

/* Room for another entry, and its tint if wanted. */
static bool widen(row *r, bool tinted) {
  size_t room = ylm_list_room(r->room, r->count + 1);
  if (!ylm_list_resize(&r->entry, r->count, room, sizeof *r->entry) ||
      (tinted && !ylm_list_resize(&r->tint, r->count, room, sizeof *r->tint)))
    return false;
  r->room = room;
  return true;
}

static bool append(row *r, const shade_entry *e, bool tinted, const group *g) {
  if (r->count == r->room && !widen(r, tinted)) return false;
  for (int c = 0; tinted && c < 3; c++) r->tint[r->count][c] = g->tint[c] / (float)g->count;
  r->entry[r->count++] = *e;
  return true;
}

/* The samples of the pixel that hit the triangle of `best`, among those that have a bit. */
static uint32_t samples_of(const scratch *s, int best, int count, int samples) {
  uint32_t bits = 0;
  int known = samples < SHADE_PLACES ? samples : SHADE_PLACES;
  for (int b = 0, i = 0; b < known; b++) {
    int sample = b * samples / known;
    while (i < count && s->sample[i] < sample) i++;
    if (i < count && s->sample[i] == sample && s->group_of[i] == s->group_of[best] &&
        s->entry[i].at.element == s->entry[best].at.element)
      bits |= (uint32_t)1 << b;
  }
  return bits;
}

/* Adds for each group the sample nearest to its mean. */
static bool append_groups(row *r, bool tinted, const scratch *s, int groups, int count,
                          int samples) {
  for (int g = 0; g < groups; g++) {
    const group *q = &s->groups[g];
    int best = -1;
    double nearest = INFINITY;
    for (int i = 0; i < count; i++) {
      if (s->group_of[i] != g) continue;
      double d2 = 0;
      for (int a = 0; a < 3; a++) {
        double d = (double)s->surface[i].position[a] - q->sum[a] / q->count;
        d2 += d * d;
      }
      if (best < 0 || d2 < nearest) best = i, nearest = d2;
    }
    shade_entry e = s->entry[best];
    e.weight = (float)q->count / (float)samples;
    e.samples = samples_of(s, best, count, samples);
    if (!append(r, &e, tinted, q)) return false;
  }
  return true;
}

/* Groups what the rays of one pixel hit; appends to the row and fills the pixel. */
static bool finish_pixel(job *j, row *r, shade_pixel *p, const scratch *s, const ylm_trace_ray *ray,
                         const ylm_trace_hit *hit) {
  const ylm_shade_view *v = j->view;
  int samples = v->o.samples, count = 0, groups = 0, lamps = 0;
  double light[3] = {0}, sky[3];
  for (int i = 0; i < samples; i++) {
    const ylm_trace_hit *h = &hit[i];
    if (h->mesh == YLM_TRACE_LAMP) {
      float seen[3];
      ylm_scene_lamp_radiance(v->scene, &ray[i], h, seen);
      lamps++;
      for (int c = 0; c < 3; c++) light[c] += seen[c];
    }
    if (h->mesh == YLM_TRACE_NOTHING && ylm_scene_sky_radiance(v->scene, &ray[i], sky)) {
      lamps++;
      for (int c = 0; c < 3; c++) light[c] += sky[c];
    }
    if (h->mesh < 0) continue;
    shade_entry *e = &s->entry[count];
    bool back = ylm_dot3(h->normal, ray[i].dir) > 0;
    *e = (shade_entry){{(uint32_t)h->mesh, h->element, h->u, h->v, back}, 0, h->t, 0};
    ylm_scene_surfaces(v->scene, 1, &e->at, &s->surface[count]);
    int g = find_group(j->near, s->groups, &groups, e, &s->surface[count], j->frame->pixel);
    s->groups[g].count++;
    for (int a = 0; a < 3; a++) s->groups[g].sum[a] += s->surface[count].position[a];
    for (int c = 0; c < 3; c++) s->groups[g].tint[c] += s->surface[count].tint[c];
    s->sample[count] = i;
    s->group_of[count++] = g;
  }
  p->first = r->count;
  p->coverage = (float)count / (float)samples;
  p->emitter = (float)lamps / (float)samples;
  for (int c = 0; c < 3; c++) p->lamps[c] = (float)(light[c] / samples);
  atomic_fetch_add_explicit(&j->hits, (size_t)count, memory_order_relaxed);
  return append_groups(r, j->tinted, s, groups, count, samples);
}

static void scratch_free(scratch *s) {
  ylm_free(s->ray);
  ylm_free(s->hit);
  ylm_free(s->entry);
  ylm_free(s->surface);
  ylm_free(s->groups);
  ylm_free(s->group_of);
  ylm_free(s->sample);
}

static bool scratch_create(scratch *s, size_t samples, size_t rays) {
  s->ray = ylm_alloc(rays, sizeof *s->ray);
  s->hit = ylm_alloc(rays, sizeof *s->hit);
  s->entry = ylm_alloc(samples, sizeof *s->entry);
  s->surface = ylm_alloc(samples, sizeof *s->surface);
  s->groups = ylm_alloc(samples, sizeof *s->groups);
  s->group_of = ylm_alloc(samples, sizeof *s->group_of);
  s->sample = ylm_alloc(samples, sizeof *s->sample);
  return s->ray && s->hit && s->entry && s->surface && s->groups && s->group_of && s->sample;
}

static bool trace_row(job *j, int y, scratch *s, int batch) {
  ylm_shade_view *v = j->view;
  int width = v->o.width, samples = v->o.samples;
  memset(v->pixel + (size_t)y * (size_t)width, 0, (size_t)width * sizeof *v->pixel);
  for (int x = 0; x < width; x += batch) {
    int n = width - x < batch ? width - x : batch;
    for (int i = 0; i < n; i++) pixel_rays(j, x + i, y, s->ray + (size_t)i * (size_t)samples);
    ylm_trace_intersect(ylm_scene_trace(v->scene), (size_t)n * (size_t)samples, s->ray, true,
                        s->hit);
    for (int i = 0; i < n; i++) {
      size_t first = (size_t)i * (size_t)samples;
      shade_pixel *p = &v->pixel[(size_t)y * (size_t)width + (size_t)(x + i)];
      if (!finish_pixel(j, &j->rows[y], p, s, s->ray + first, s->hit + first)) return false;
    }
  }
  return true;
}

/* Rows begin .. end-1. */
static ylm_status trace_rows(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  job *j = context;
  int samples = j->view->o.samples, batch = SHADE_RAYS / samples > 1 ? SHADE_RAYS / samples : 1;
  scratch s = {0};
  bool ok = scratch_create(&s, (size_t)samples, (size_t)batch * (size_t)samples);
  for (size_t y = begin; ok && y < end; y++) ok = trace_row(j, (int)y, &s, batch);
  scratch_free(&s);
  return ok ? YLM_OK : YLM_ENOMEM;
}

static void row_free(row *r) {
  ylm_free(r->entry);
  ylm_free(r->tint);
  memset(r, 0, sizeof *r);
}

/* Puts rows where they belong, and frees them. */
static ylm_status move_rows(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  ylm_shade_view *v = j->view;
  size_t width = (size_t)v->o.width;
  for (size_t y = begin; y < end; y++) {
    row *r = &j->rows[y];
    ylm_copy(v->entry + r->first, r->entry, r->count * sizeof *v->entry);
    if (j->tinted) ylm_copy(v->seen + r->first, r->tint, r->count * sizeof *v->seen);
    for (size_t x = 0; x < width; x++) v->pixel[y * width + x].first += r->first;
    row_free(r);
  }
  return YLM_OK;
}

/* Puts the rows behind each other. */
static ylm_status join_rows(const job *j) {
  ylm_shade_view *v = j->view;
  size_t width = (size_t)v->o.width, height = (size_t)v->o.height, total = 0;
  for (size_t y = 0; y < height; total += j->rows[y++].count) j->rows[y].first = total;
  if (total > UINT32_MAX) return YLM_EOVERFLOW;
  v->entry = ylm_alloc(total, sizeof *v->entry);
  if (j->tinted) v->seen = ylm_alloc(total, sizeof *v->seen);
  if (!v->entry || (j->tinted && !v->seen)) return YLM_ENOMEM;
  v->entries = total;
  v->pixel[width * height] = (shade_pixel){.first = total};
  ylm_progress_part whole; /* the stage stays at its end */
  return ylm_parallel(
      height, 8, v->o.threads, move_rows, (void *)(uintptr_t)j,
      ylm_progress_part_of(&whole, v->o.progress, "primary rays", height, 0, height), NULL);
}

/* The angle between normals over which the peak of a material's lobe falls to a quarter: alpha of GGX, about 1 of
   a matte surface. */
static double lobe(const ylm_material *m) {
  float albedo[3], w[2][3] = {{0, 0, 1}, {0.6f, 0, 0.8f}}, wi[2][3] = {{0, 0, 1}, {-0.6f, 0, 0.8f}};
  float f[2][3];
  double least = 1;
  ylm_material_albedo(m, albedo);
  ylm_material_eval(m, 2, (const float(*)[3])wi, (const float(*)[3])w, f);
  for (int i = 0; i < 2; i++)
    for (int c = 0; c < 3; c++)
      if (f[i][c] > 0)
        least = fmin(least,
                     0.5 * sqrt((double)albedo[c] / (YLM_PI * (double)f[i][c] * (double)w[i][2])));
  return least;
}

/* The nearness of each mesh; NULL without memory. */
static nearness *nearness_of(const ylm_shade_view *v, double pixel) {
  size_t meshes = ylm_scene_meshes(v->scene);
  nearness *out = ylm_alloc(meshes, sizeof *out);
  for (size_t i = 0; out && i < meshes; i++) {
    const ylm_material *m = ylm__shade_mesh_material(v, i);
    out[i] = (nearness){SHADE_SAME_NORMAL, v->o.share};
    if (!v->o.fine || v->o.per_vertex || !ylm_material_glosses(m)) continue;
    double width = lobe(m);
    if (v->o.gloss == YLM_SHADE_GLOSS_SH) width = fmax(width, 2.0 / (v->o.lmax + 1));
    width *= SHADE_FINE;
    out[i].cosine = fmaxf(SHADE_SAME_NORMAL, (float)cos(width));
    out[i].share = fmin(v->o.share, 2 * width / pixel);
  }
  return out;
}

ylm_status ylm__shade_primary(ylm_shade_view *v, const ylm_camera_frame *f) {
  double start = ylm_seconds();
  size_t height = (size_t)v->o.height, pixels = height * (size_t)v->o.width;
  float *radical = ylm_alloc((size_t)v->o.samples, sizeof *radical);
  job j = {.view = v,
           .near = nearness_of(v, f->pixel),
           .tinted = ylm_scene_is_tinted(v->scene),
           .frame = f,
           .rows = ylm_alloc_zero(height, sizeof(row)),
           .radical = radical};
  v->pixel = ylm_alloc(pixels + 1, sizeof *v->pixel); /* rows write theirs */
  ylm_status s = radical && j.near && j.rows && v->pixel ? YLM_OK : YLM_ENOMEM;
  for (int i = 0; s == YLM_OK && i < v->o.samples; i++)
    radical[i] = (float)ylm_scene_radical((uint32_t)i);
  if (s == YLM_OK)
    s = ylm_parallel(height, 1, v->o.threads, trace_rows, &j, v->o.progress, "primary rays");
  if (s == YLM_OK) s = join_rows(&j);
  for (size_t y = 0; j.rows && y < height; y++) row_free(&j.rows[y]);
  ylm_free(j.rows);
  ylm_free(j.near);
  ylm_free(radical);
  v->stats.pixels = pixels;
  v->stats.hits = j.hits;
  v->stats.primary_rays = pixels * (uint64_t)v->o.samples;
  v->stats.primary_seconds = ylm_seconds() - start;
  return s;
}
