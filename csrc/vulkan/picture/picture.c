/*
** picture.c - pictures from the radiance of shading points: filtering into pixels, lamps over them.
*/
#include "picture.h"

#include <string.h>

#define GROUP 64 /* picture.comp: pixels; picture_lamps.real.comp: those of a tile */

/* -- the arrays of a view ------------------------------------------------------------------ */

/* The numbers as 32 bits each; the caller frees them. NULL: a number that is none, at *bad, or no
   memory (*bad then n). */
static uint32_t *words(const double *x, size_t n, double below, bool rising, size_t *bad) {
  uint32_t *w = ylm_alloc(n, sizeof *w);
  *bad = n;
  for (size_t i = 0; w && i < n; i++) {
    if (!(x[i] >= 0 && x[i] < below) || (rising && i && x[i] < x[i - 1])) {
      *bad = i;
      ylm_free(w);
      return NULL;
    }
    w[i] = (uint32_t)x[i];
  }
  return w;
}

/* A buffer of whole numbers below `below`. */
static ylm_status take_words(ylm_gpu *g, const double *x, size_t n, double below, bool rising,
                             ylm_gpu_buffer **b, ylm_error *e) {
  size_t bad;
  uint32_t *w = words(x, n, below, rising, &bad);
  if (!w && bad < n)
    return ylm_fail(e, YLM_EINVAL, "a picture's entries: number %zu is %g, from 0 to below %g%s",
                    bad, x[bad], below, rising ? " and no less than the last" : "");
  if (!w) return ylm_no_memory(e);
  ylm_status s = ylm_gpu_buffer_from(g, n * sizeof *w, w, b, e);
  ylm_free(w);
  return s;
}

/* The camera's numbers in the type that lamps are drawn in. */
ylm_status ylm__picture_reals(const ylm_gpu_picture *k, const double *x, size_t n,
                              ylm_gpu_buffer **b, ylm_error *e) {
  ylm_gpu *g = k->g;
  float *f = NULL;
  const void *from = x;
  size_t bytes = n * (k->wide ? sizeof *x : sizeof *f);
  if (!k->wide) {
    f = ylm_alloc(n, sizeof *f);
    if (!f) return ylm_no_memory(e);
    for (size_t i = 0; i < n; i++) f[i] = (float)x[i];
    from = f;
  }
  ylm_status s = ylm__steps_reserve(g, b, bytes, e);
  if (s == YLM_OK) s = ylm_gpu_upload(*b, 0, bytes, from, e);
  ylm_free(f);
  return s;
}

/* Strips of pixels whose cost is known: that of a group is about what its entries are. */
static void cut_strips(ylm_gpu_picture *k, const double *first) {
  uint64_t pixels = (uint64_t)k->width * k->height, begin = 0;
  k->strips = 0;
  for (int i = 0; i < PICTURE_STRIPS; i++) {
    uint64_t end = i + 1 < PICTURE_STRIPS
                       ? (pixels * (uint64_t)(i + 1) / PICTURE_STRIPS + GROUP - 1) / GROUP * GROUP
                       : pixels;
    if (end > pixels) end = pixels;
    if (end == begin) continue;
    double cost = 1 + (first[end] - first[begin]) / (double)(end - begin);
    picture_strip *last = k->strips ? &k->strip[k->strips - 1] : NULL;
    if (last && cost < 2 * last->cost && last->cost < 2 * cost) {
      last->end = (uint32_t)end;
      last->cost = cost > last->cost ? cost : last->cost;
    } else
      k->strip[k->strips++] = (picture_strip){(uint32_t)begin, (uint32_t)end, cost};
    begin = end;
  }
}

static ylm_status check_size(ylm_gpu *g, const ylm_gpu_pixels *p, ylm_error *e) {
  uint64_t most = ylm_gpu_about(g)->bind_bytes, pixels = (uint64_t)p->width * p->height;
  if (!p->width || !p->height || pixels >= UINT32_MAX)
    return ylm_fail(e, YLM_ERANGE, "a picture of %zu x %zu pixels", p->width, p->height);
  if (pixels > most / 16 || p->entries > most / (p->point ? 12 : 4) || p->points > most / 12 ||
      (!p->point && p->points < p->entries))
    return ylm_fail(e, p->points < p->entries && !p->point ? YLM_ESHAPE : YLM_ELIMIT,
                    "a picture of %.0f million pixels, %.0f million entries, %.0f million points: "
                    "kernels of '%s' see %.0f MiB of each",
                    (double)pixels / 1e6, (double)p->entries / 1e6, (double)p->points / 1e6,
                    ylm_gpu_about(g)->name, (double)most / 1048576);
  return YLM_OK;
}

static ylm_status copy_pixels(ylm_gpu_picture *k, const ylm_gpu_pixels *p, ylm_error *e) {
  size_t pixels = p->width * p->height;
  ylm_gpu *g = k->g;
  ylm_status s = take_words(g, p->first, pixels + 1, (double)p->entries + 1, true, &k->first, e);
  if (s == YLM_OK && p->first[pixels] != (double)p->entries)
    return ylm_fail(e, YLM_EINVAL, "a picture's pixels have %g entries, not %zu", p->first[pixels],
                    p->entries);
  if (s == YLM_OK) s = ylm_gpu_buffer_from(g, 16 * pixels, p->shown, &k->shown, e);
  if (s == YLM_OK) s = ylm_gpu_buffer_from(g, 4 * p->entries, p->weight, &k->weight, e);
  if (s == YLM_OK) s = ylm_gpu_buffer_from(g, 4 * p->entries, p->depth, &k->depth, e);
  if (s == YLM_OK && p->point)
    s = take_words(g, p->point, 3 * p->entries, (double)p->points, false, &k->corner, e);
  if (s == YLM_OK && p->point) s = ylm_gpu_buffer_from(g, 12 * p->entries, p->part, &k->part, e);
  if (s == YLM_OK) s = ylm__picture_reals(k, p->camera, 10, &k->camera, e);
  if (s == YLM_OK) cut_strips(k, p->first);
  return s;
}

ylm_status ylm_gpu_picture_create(ylm_gpu *g, const ylm_gpu_pixels *p, ylm_gpu_picture **out,
                                  ylm_error *e) {
  *out = NULL;
  ylm_status s = ylm_gpu_state(g, e);
  if (s == YLM_OK) s = check_size(g, p, e);
  if (s != YLM_OK) return s;
  ylm_gpu_picture *k = ylm_alloc_zero(1, sizeof *k);
  if (!k) return ylm_no_memory(e);
  k->g = ylm_gpu_share(g);
  k->width = (uint32_t)p->width;
  k->height = (uint32_t)p->height;
  k->points = p->points;
  k->wide = ylm_gpu_about(g)->float64;
  s = copy_pixels(k, p, e);
  if (s == YLM_OK)
    *out = k;
  else
    ylm_gpu_picture_free(k);
  return s;
}

void ylm_gpu_picture_free(ylm_gpu_picture *k) {
  if (!k) return;
  ylm_gpu_buffer *all[] = {k->first,  k->shown, k->weight, k->depth, k->corner, k->part,
                           k->camera, k->disc,  k->tile,   k->list,  k->image,  k->radiance};
  for (size_t i = 0; i < sizeof all / sizeof *all; i++) ylm_gpu_buffer_free(all[i]);
  ylm__steps_free(&k->queue);
  ylm_gpu_free(k->g);
  ylm_free(k);
}

void ylm_gpu_picture_size(const ylm_gpu_picture *k, size_t *points, size_t *pixels) {
  *points = k->points;
  *pixels = (size_t)k->width * k->height;
}

/* -- a picture -------------------------------------------------------------------------------- */

static void filter(ylm_gpu_picture *k, ylm_gpu_buffer *radiance, const float background[3],
                   ylm_gpu_buffer *image, ylm_error *e) {
  uint32_t constant[] = {GROUP, k->corner != NULL};
  ylm_gpu_work w = {.verb = YLM_GPU_DISPATCH, .binds = 7};
  step_queue *q = &k->queue;
  q->stage = "filter";
  if (q->status == YLM_OK)
    q->status = ylm_gpu_kernel_get(k->g, "picture", 2, constant, &w.kernel, e);
  ylm_gpu_buffer *buffer[] = {k->first,
                              k->shown,
                              k->weight,
                              radiance,
                              k->corner ? k->corner : k->weight,
                              k->part ? k->part : k->weight,
                              image};
  for (int i = 0; i < 7; i++) w.bind[i].buffer = buffer[i];
  for (int i = 0; i < k->strips; i++) {
    struct {
      uint32_t begin, end;
      float background[3];
    } push = {k->strip[i].begin, k->strip[i].end, {background[0], background[1], background[2]}};
    w.groups = (push.end - push.begin + GROUP - 1) / GROUP;
    w.cost = k->strip[i].cost;
    w.push = &push;
    w.push_bytes = sizeof push;
    ylm__steps_work(q, &w);
  }
}

static ylm_status check(const ylm_gpu_picture *k, const ylm_gpu_input *radiance,
                        const ylm_gpu_output *image, ylm_error *e) {
  const ylm_gpu_buffer *there[] = {radiance->there, image->there};
  uint64_t rows[] = {k->points, (uint64_t)k->width * k->height};
  ylm_status s = ylm_gpu_state(k->g, e);
  if (s != YLM_OK) return s;
  if (k->busy)
    return ylm_fail(e, YLM_EBUSY, "the picture is in use by a call that has not returned");
  for (int i = 0; i < 2; i++) {
    if (there[i] && ylm_gpu_buffer_device(there[i]) != k->g)
      return ylm_fail(e, YLM_EINVAL, "an array is in the memory of another device");
    if (there[i] && ylm_gpu_buffer_bytes(there[i]) < 12 * rows[i])
      return ylm_fail_plain(e, YLM_ESHAPE);
  }
  return YLM_OK;
}

/* Radiance on the device. */
static ylm_status bring(ylm_gpu_picture *k, const ylm_gpu_input *radiance, ylm_gpu_buffer **out,
                        ylm_gpu_times *times, ylm_error *e) {
  *out = radiance->there;
  if (*out) return YLM_OK;
  double start = ylm_seconds();
  ylm_status s = ylm__steps_reserve(k->g, &k->radiance, 12 * k->points, e);
  if (s == YLM_OK) s = ylm_gpu_upload(k->radiance, 0, 12 * k->points, radiance->host, e);
  ylm__steps_copied(times, "upload", start);
  *out = k->radiance;
  return s;
}

ylm_status ylm_gpu_picture_make(ylm_gpu_picture *k, ylm_gpu_input radiance,
                                const float background[3], size_t discs, const double *disc,
                                ylm_gpu_output image, ylm_gpu_times *times,
                                const ylm_progress *progress, ylm_error *e) {
  ylm_gpu_buffer *from = NULL, *to = image.there;
  size_t bytes = 12 * (size_t)k->width * k->height;
  ylm_status s = check(k, &radiance, &image, e);
  if (s == YLM_OK) s = bring(k, &radiance, &from, times, e);
  if (s == YLM_OK && !to) {
    s = ylm__steps_reserve(k->g, &k->image, bytes, e);
    to = k->image;
  }
  if (s != YLM_OK) return s;
  k->queue.g = k->g;
  k->queue.times = times;
  k->queue.progress = progress;
  k->queue.status = YLM_OK;
  k->queue.e = e;
  filter(k, from, background, to, e);
  if (discs) ylm__picture_lamps(k, discs, disc, to, times, e);
  k->busy = true;
  s = ylm__steps_run(&k->queue);
  k->busy = false;
  double start = ylm_seconds();
  if (s == YLM_OK && image.host) {
    s = ylm_gpu_download(to, 0, bytes, image.host, e);
    ylm__steps_copied(times, "download", start);
  }
  return s;
}
