/* resize.c - parts of images and images of another size. */
#include "calibration.h"
#include "ylm_image.h"

#include <math.h>
#include <string.h>

/* An image with the layers and metadata of `in` but another size. */
static ylm_status make_like(const ylm_image *in, int width, int height, ylm_image **out,
                            ylm_error *e) {
  ylm_status s = ylm_image_create(width, height, out, e);
  for (int i = 0; s == YLM_OK && i < in->layers; i++)
    s = ylm_image_add(*out, in->layer[i].name, in->layer[i].channels, e);
  for (int i = 0; s == YLM_OK && i < in->texts; i++) {
    s = ylm_image_set_text(*out, in->text[i].key, in->text[i].value);
    if (s != YLM_OK) ylm_fail(e, s, "memory ran out");
  }
  if (s != YLM_OK) {
    ylm_image_free(*out);
    *out = NULL;
  }
  return s;
}

ylm_status ylm_image_crop(const ylm_image *in, int x, int y, int width, int height, ylm_image **out,
                          ylm_error *e) {
  *out = NULL;
  if (x < 0 || y < 0 || width < 1 || height < 1 || width > in->width - x || height > in->height - y)
    return ylm_fail(e, YLM_ERANGE,
                    "the rectangle of %d x %d at (%d, %d) is not within the image of %d x %d",
                    width, height, x + 1, y + 1, in->width, in->height);
  ylm_status s = make_like(in, width, height, out, e);
  if (s != YLM_OK) return s;
  for (int i = 0; i < in->layers; i++) {
    size_t c = (size_t)in->layer[i].channels;
    for (size_t row = 0; row < (size_t)height; row++)
      memcpy((*out)->layer[i].data + row * (size_t)width * c,
             in->layer[i].data + (((size_t)y + row) * (size_t)in->width + (size_t)x) * c,
             (size_t)width * c * sizeof(float));
  }
  return YLM_OK;
}

/* -- resizing ------------------------------------------------------------------------- */

static double box(double x) { return x >= -0.5 && x < 0.5; }
static double tent(double x) { return fabs(x) < 1 ? 1 - fabs(x) : 0; }

static double lanczos(double x) {
  const double pi = YLM_PI;
  if (x == 0) return 1;
  return fabs(x) < 3 ? 3 * sin(pi * x) * sin(pi * x / 3) / (pi * pi * x * x) : 0;
}

static const struct {
  double (*weight)(double);
  double radius;
} filters[] = {{box, 0.5}, {tent, 1}, {lanczos, 3}};

/* Weights of the inputs first[i] .. first[i]+taps-1 for each output sample along an axis. */
typedef struct kernel {
  int taps;
  int *first;
  float *weight; /* [outputs][taps] */
} kernel;

static void free_kernel(kernel *k) {
  ylm_free(k->first);
  ylm_free(k->weight);
}

static bool make_kernel(int inputs, int outputs, ylm_filter filter, kernel *k) {
  double ratio = (double)inputs / outputs, widen = ratio > 1 ? ratio : 1,
         radius = filters[filter].radius * widen;
  int taps = (int)ceil(2 * radius) + 2;
  k->taps = taps > inputs ? inputs : taps;
  k->first = ylm_alloc((size_t)outputs, sizeof *k->first);
  k->weight = ylm_alloc((size_t)outputs * (size_t)k->taps, sizeof *k->weight);
  if (!k->first || !k->weight) return false;
  for (int i = 0; i < outputs; i++) {
    double middle = (i + 0.5) * ratio - 0.5, sum = 0;
    int first = (int)floor(middle - radius);
    if (first > inputs - k->taps) first = inputs - k->taps;
    if (first < 0) first = 0;
    k->first[i] = first;
    float *w = k->weight + (size_t)i * (size_t)k->taps;
    for (int t = 0; t < k->taps; t++)
      sum += w[t] = (float)filters[filter].weight((first + t - middle) / widen);
    if (sum == 0) { /* a box that falls between samples at an edge */
      int near = (int)lround(middle) - first;
      near = near < 0 ? 0 : near >= k->taps ? k->taps - 1 : near;
      w[near] = 1;
      sum = 1;
    }
    for (int t = 0; t < k->taps; t++) w[t] = (float)(w[t] / sum);
  }
  return true;
}

typedef struct job {
  const float *in;
  float *out;
  const kernel *k;
  size_t in_width, out_width, channels;
} job;

/* Rows begin .. end-1 along x: in [rows][in_width][c] to out [rows][out_width][c]. */
static ylm_status along_x(void *context, size_t begin, size_t end, int worker) {
  const job *j = context;
  (void)worker;
  for (size_t y = begin; y < end; y++)
    for (size_t x = 0; x < j->out_width; x++) {
      const float *w = j->k->weight + x * (size_t)j->k->taps;
      const float *p = j->in + (y * j->in_width + (size_t)j->k->first[x]) * j->channels;
      float *q = j->out + (y * j->out_width + x) * j->channels, sum[4] = {0};
      for (int t = 0; t < j->k->taps; t++)
        for (size_t c = 0; c < j->channels; c++)
          if (w[t] != 0) sum[c] += w[t] * p[(size_t)t * j->channels + c]; /* 0 * inf stays out */
      memcpy(q, sum, j->channels * sizeof *q);
    }
  return YLM_OK;
}

/* Output rows begin .. end-1 along y; both have out_width columns. */
static ylm_status along_y(void *context, size_t begin, size_t end, int worker) {
  const job *j = context;
  (void)worker;
  size_t n = j->out_width * j->channels;
  for (size_t y = begin; y < end; y++) {
    float *q = j->out + y * n;
    const float *w = j->k->weight + y * (size_t)j->k->taps;
    memset(q, 0, n * sizeof *q);
    for (int t = 0; t < j->k->taps; t++) {
      const float *p = j->in + ((size_t)j->k->first[y] + (size_t)t) * n;
      if (w[t] == 0) continue;
      for (size_t i = 0; i < n; i++) q[i] += w[t] * p[i];
    }
  }
  return YLM_OK;
}

ylm_status ylm_image_resize(const ylm_image *in, int width, int height, ylm_filter filter,
                            int threads, const ylm_progress *progress, ylm_image **out,
                            ylm_error *e) {
  *out = NULL;
  if ((unsigned)filter > YLM_FILTER_LANCZOS) return ylm_fail(e, YLM_EINVAL, "no such filter");
  ylm_status s = make_like(in, width, height, out, e);
  if (s != YLM_OK) return s;
  kernel kx = {0}, ky = {0};
  float *half = ylm_alloc((size_t)in->height * (size_t)width * 4, sizeof *half);
  if (!half || !make_kernel(in->width, width, filter, &kx) ||
      !make_kernel(in->height, height, filter, &ky))
    s = ylm_no_memory(e);
  for (int i = 0; s == YLM_OK && i < in->layers; i++) {
    size_t c = (size_t)in->layer[i].channels;
    job jx = {in->layer[i].data, half, &kx, (size_t)in->width, (size_t)width, c};
    job jy = {half, (*out)->layer[i].data, &ky, (size_t)width, (size_t)width, c};
    s = ylm_parallel((size_t)in->height, IMAGE_ROWS, threads, along_x, &jx, progress, "resizing");
    if (s == YLM_OK)
      s = ylm_parallel((size_t)height, IMAGE_ROWS, threads, along_y, &jy, progress, "resizing");
    if (s != YLM_OK) ylm_fail_plain(e, s);
  }
  free_kernel(&kx);
  free_kernel(&ky);
  ylm_free(half);
  if (s != YLM_OK) {
    ylm_image_free(*out);
    *out = NULL;
  }
  return s;
}
