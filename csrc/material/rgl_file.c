/* rgl_file.c - measured materials from RGL's files (Dupuy & Jakob 2018): which fields a file has to
   have, and their numbers as tables. */
#include <math.h>
#include <string.h>

#include "rgl.h"
#include "tensor.h"

/* Numbers that are larger cannot be measurements, and their products could overflow. */
#define LARGEST 1e12f

typedef struct fields {
  tensor_field phi, theta, ndf, sigma, vndf, luminance, rgb, jacobian;
} fields;

static ylm_status wrong(const tensor *t, const char *field, const char *wanted, ylm_error *e) {
  return ylm_fail(e, YLM_EFORMAT, "%s: field '%s' %s", t->name, field, wanted);
}

static ylm_status find_all(const tensor *t, fields *f, ylm_error *e) {
  tensor_field other;
  if (!ylm__tensor_find(t, "rgb", &other) && ylm__tensor_find(t, "wavelengths", &other))
    return ylm_fail(e, YLM_EFORMAT,
                    "%s: field 'rgb' is missing: use the _rgb.bsdf, this one has wavelengths",
                    t->name);
  const struct {
    const char *name;
    tensor_type type;
    int axes;
    tensor_field *to;
  } wanted[] = {{"phi_i", TENSOR_F32, 1, &f->phi}, {"theta_i", TENSOR_F32, 1, &f->theta},
                {"ndf", TENSOR_F32, 2, &f->ndf},   {"sigma", TENSOR_F32, 2, &f->sigma},
                {"vndf", TENSOR_F32, 4, &f->vndf}, {"luminance", TENSOR_F32, 4, &f->luminance},
                {"rgb", TENSOR_F32, 5, &f->rgb},   {"jacobian", TENSOR_U8, 1, &f->jacobian}};
  for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++) {
    ylm_status s =
        ylm__tensor_field(t, wanted[i].name, wanted[i].type, wanted[i].axes, wanted[i].to, e);
    if (s != YLM_OK) return s;
    if (wanted[i].to->count == 0) return wrong(t, wanted[i].name, "is empty", e);
  }
  return YLM_OK;
}

/* Whether the first two extents are those of the directions, and the last two make cells. */
static bool is_sliced(const fields *f, const tensor_field *x) {
  return x->shape[0] == f->phi.count && x->shape[1] == f->theta.count &&
         x->shape[x->axes - 1] >= 2 && x->shape[x->axes - 2] >= 2;
}

static ylm_status check_shapes(const tensor *t, const fields *f, ylm_error *e) {
  const char *sliced =
      "must have extents [phi_i][theta_i] and two more, of which none is smaller than 2";
  if (!is_sliced(f, &f->vndf)) return wrong(t, "vndf", sliced, e);
  if (!is_sliced(f, &f->luminance)) return wrong(t, "luminance", sliced, e);
  if (!is_sliced(f, &f->rgb) || f->rgb.shape[2] != 3 || f->rgb.shape[3] != f->luminance.shape[2] ||
      f->rgb.shape[4] != f->luminance.shape[3])
    return wrong(t, "rgb", "must have the extents of luminance, with 3 in the middle", e);
  if (f->jacobian.count != 1) return wrong(t, "jacobian", "must be one number", e);
  return YLM_OK;
}

/* Copies the field's numbers to *at, which then points behind them. */
static ylm_status copy(const tensor *t, const tensor_field *f, const char *name, float **at,
                       float **out, ylm_error *e) {
  *out = *at;
  *at += f->count;
  ylm_status s = ylm__tensor_floats(t, f, *out, e);
  for (size_t i = 0; s == YLM_OK && i < f->count; i++)
    if (fabsf((*out)[i]) > LARGEST)
      return ylm_fail(e, YLM_EFORMAT, "%s: number %zu of field '%s' is %g, at most %g expected",
                      t->name, i + 1, name, (double)(*out)[i], (double)LARGEST);
  return s;
}

static ylm_status copy_increasing(const tensor *t, const tensor_field *f, const char *name,
                                  float **at, float **out, ylm_error *e) {
  ylm_status s = copy(t, f, name, at, out, e);
  for (size_t i = 1; s == YLM_OK && i < f->count; i++)
    if (!((*out)[i] > (*out)[i - 1]))
      return ylm_fail(e, YLM_EFORMAT, "%s: field '%s' must increase, but number %zu is %g after %g",
                      t->name, name, i + 1, (double)(*out)[i], (double)(*out)[i - 1]);
  return s;
}

static ylm_status copy_raster(const tensor *t, const tensor_field *f, const char *name, float **at,
                              raster *r, ylm_error *e) {
  r->height = (int)f->shape[0];
  r->width = (int)f->shape[1];
  return copy(t, f, name, at, &r->value, e);
}

/* The first part of the numbers at *at holds densities as the file has them, until they are
   filled. */
static ylm_status copy_warp(const tensor *t, const tensor_field *f, const char *name, float **at,
                            float *slice, warp *w, ylm_error *e) {
  size_t slices = f->shape[0] * f->shape[1], size = f->shape[2] * f->shape[3];
  w->height = (int)f->shape[2];
  w->width = (int)f->shape[3];
  ylm_status s = copy(t, f, name, at, &w->density, e);
  if (s != YLM_OK) return s;
  w->conditional = *at;
  *at += f->count;
  w->marginal = *at;
  *at += slices * f->shape[2];
  for (size_t i = 0; i < slices; i++) {
    memcpy(slice, w->density + i * size, size * sizeof *slice);
    if (!ylm__warp_fill(w, i, slice))
      return ylm_fail(e, YLM_EFORMAT,
                      "%s: field '%s' has no positive density at phi_i %zu, theta_i %zu", t->name,
                      name, i / f->shape[1] + 1, i % f->shape[1] + 1);
  }
  return YLM_OK;
}

/* Colours of a node side by side, and a zero. */
static ylm_status copy_colours(const tensor *t, const tensor_field *f, float *plane, float *out,
                               ylm_error *e) {
  float *at = plane, *from;
  ylm_status s = copy(t, f, "rgb", &at, &from, e);
  size_t size = f->shape[3] * f->shape[4], slices = f->shape[0] * f->shape[1];
  for (size_t i = 0; s == YLM_OK && i < slices; i++)
    for (size_t k = 0; k < size; k++)
      for (size_t c = 0; c < 4; c++)
        out[4 * (i * size + k) + c] = c < 3 ? from[(3 * i + c) * size + k] : 0;
  return s;
}

/* How much of all azimuths is measured, and where it lies. */
static ylm_status set_reduction(const tensor *t, rgl_table *r, ylm_error *e) {
  r->isotropic = r->phis <= 2;
  r->reduction = 1;
  if (r->isotropic) return YLM_OK;
  float first = r->phi[0], last = r->phi[r->phis - 1];
  double times = round(2 * YLM_PI / (double)(last - first));
  if (times != 1 && times != 2 && times != 4)
    return ylm_fail(e, YLM_EFORMAT,
                    "%s: field 'phi_i' goes from %g to %g: 1/%g of the circle, 1, 1/2 or 1/4 "
                    "expected",
                    t->name, (double)first, (double)last, times);
  r->reduction = (int)times;
  r->middle[0] = cosf((first + last) / 2);
  r->middle[1] = sinf((first + last) / 2);
  return YLM_OK;
}

static ylm_status fill(const tensor *t, const fields *f, rgl_table *r, float *spare, ylm_error *e) {
  float *at = (float *)(void *)(r + 1);
  /* Colours come first, where they are aligned. */
  r->colour = at;
  at += f->rgb.count / 3 * 4;
  ylm_status s = copy_colours(t, &f->rgb, spare, r->colour, e);
  if (s == YLM_OK) s = copy_increasing(t, &f->phi, "phi_i", &at, &r->phi, e);
  if (s == YLM_OK) s = copy_increasing(t, &f->theta, "theta_i", &at, &r->theta, e);
  if (s == YLM_OK) s = copy_raster(t, &f->ndf, "ndf", &at, &r->ndf, e);
  if (s == YLM_OK) s = copy_raster(t, &f->sigma, "sigma", &at, &r->sigma, e);
  if (s == YLM_OK) s = copy_warp(t, &f->vndf, "vndf", &at, spare, &r->vndf, e);
  if (s == YLM_OK) s = copy_warp(t, &f->luminance, "luminance", &at, spare, &r->luminance, e);
  if (s == YLM_OK) s = set_reduction(t, r, e);
  r->jacobian = f->jacobian.data[0] != 0;
  return s;
}

/* Numbers of all tables of a file: at most four for each number in it. */
static size_t numbers_of(const fields *f) {
  size_t slices = f->phi.count * f->theta.count;
  return f->rgb.count / 3 * 4 + f->phi.count + f->theta.count + f->ndf.count + f->sigma.count +
         2 * (f->vndf.count + f->luminance.count) +
         slices * (f->vndf.shape[2] + f->luminance.shape[2]);
}

ylm_status ylm__rgl_read(const unsigned char *bytes, size_t size, const char *name, float rotate,
                         rgl_table **t, size_t *held, ylm_error *e) {
  tensor file;
  fields f;
  ylm_status s = ylm__tensor_open(bytes, size, name, &file, e);
  if (s == YLM_OK) s = find_all(&file, &f, e);
  if (s == YLM_OK) s = check_shapes(&file, &f, e);
  if (s != YLM_OK) return s;
  size_t spares = f.rgb.count > f.vndf.count ? f.rgb.count : f.vndf.count;
  *held = sizeof(rgl_table) + numbers_of(&f) * sizeof(float);
  rgl_table *r = ylm_alloc_zero(*held, 1);
  float *spare = ylm_alloc(spares, sizeof *spare);
  s = r && spare ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) {
    r->phis = (int)f.phi.count;
    r->thetas = (int)f.theta.count;
    r->turn[0] = cosf(rotate * (float)(YLM_PI / 180));
    r->turn[1] = sinf(rotate * (float)(YLM_PI / 180));
    s = fill(&file, &f, r, spare, e);
  }
  ylm_free(spare);
  if (s != YLM_OK) {
    ylm_free(r);
    return s;
  }
  *t = r;
  return YLM_OK;
}
