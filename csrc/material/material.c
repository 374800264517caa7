/* material.c - materials of any kind, by the table of kinds. */
#include <string.h>

#include "gen/material.h"
#include "kind.h"

static const material_kind *const kinds[] = {
#define X(name) &ylm__material_##name,
    MATERIAL_KINDS(X)
#undef X
};

int ylm_material_kinds(void) { return (int)(sizeof kinds / sizeof *kinds); }

static bool is_kind(int kind) { return kind >= 0 && kind < ylm_material_kinds(); }

const char *ylm_material_kind_name(int kind) { return is_kind(kind) ? kinds[kind]->name : "?"; }

int ylm_material_kind_find(const char *name) {
  for (int i = 0; i < ylm_material_kinds(); i++)
    if (strcmp(kinds[i]->name, name) == 0) return i;
  return -1;
}

/* The kind whose functions of transfer vectors hold for a material, and their numbers: without any,
   matte surfaces of the mean albedo. */
static const material_kind *shaded(const ylm_material *m, const float **x) {
  const material_kind *k = kinds[m->kind];
  *x = k->radiance ? m->x : m->albedo;
  return k->radiance ? k : &ylm__material_matte;
}

ylm_status ylm_material_transfer(int kind, int lmax, double *a) {
  if (lmax < 0 || lmax > YLM_MATERIAL_LMAX) return YLM_ERANGE;
  if (!is_kind(kind)) return YLM_EINVAL;
  const material_kind *k = kinds[kind];
  return (k->transfer ? k : &ylm__material_matte)->transfer(lmax, a);
}

ylm_status ylm_material_cosine(int lmax, double *a) {
  return lmax < 0 || lmax > YLM_MATERIAL_LMAX ? YLM_ERANGE : ylm__material_matte.transfer(lmax, a);
}

bool ylm_material_glosses(const ylm_material *m) { return !kinds[m->kind]->radiance; }

float ylm_material_excess(const ylm_material *m, float cosine) {
  int k = (int)(cosine * MATERIAL_EYES);
  return m->excess[k < 0 ? 0 : k < MATERIAL_EYES ? k : MATERIAL_EYES - 1];
}

/* -- making them ----------------------------------------------------------------- */

ylm_status ylm_material_check(int kind, size_t n, const float *numbers, ylm_error *e) {
  if (kind < 0 || kind >= ylm_material_kinds())
    return ylm_fail(e, YLM_EINVAL, "there is no such kind of material");
  const material_kind *k = kinds[kind];
  if (n != k->numbers)
    return ylm_fail(e, YLM_EINVAL, "a %s material has %zu numbers, got %zu", k->name, k->numbers,
                    n);
  return k->check(numbers, e);
}

/* Completes a material whose numbers are there: its table, then its albedo. */
static ylm_status complete(ylm_material *m, const void *bytes, size_t size, const char *name,
                           ylm_error *e) {
  const material_kind *k = kinds[m->kind];
  ylm_status s = YLM_OK;
  if (k->load)
    s = k->load(m, bytes, size, name, e);
  else if (k->prepare)
    s = k->prepare(m, e);
  if (s == YLM_OK) (k->mean ? k->mean : ylm__material_mean)(m, m->albedo);
  if (s == YLM_OK && !k->radiance) ylm__material_fill_excess(m);
  return s;
}

static ylm_status make(int kind, size_t n, const float *numbers, const void *bytes, size_t size,
                       const char *name, ylm_material **m, ylm_error *e) {
  *m = NULL;
  ylm_status s = ylm_material_check(kind, n, numbers, e);
  if (s != YLM_OK) return s;
  if (!kinds[kind]->load != !bytes)
    return ylm_fail(e, YLM_EINVAL,
                    bytes ? "a %s material is of numbers, not of a file"
                          : "a %s material is made of a file's bytes",
                    kinds[kind]->name);
  ylm_material *new = ylm_alloc_zero(1, sizeof *new);
  if (!new) return YLM_ENOMEM;
  atomic_init(&new->holders, 1);
  new->kind = kind;
  memcpy(new->x, numbers, n * sizeof *numbers);
  new->print = ylm_crc64(0, kinds[kind]->name, strlen(kinds[kind]->name));
  new->print = ylm_crc64(ylm_crc64(new->print, numbers, n * sizeof *numbers), bytes, size);
  s = complete(new, bytes, size, name, e);
  if (s == YLM_OK)
    *m = new;
  else
    ylm_material_free(new);
  return s;
}

ylm_status ylm_material_create(int kind, size_t n, const float *numbers, ylm_material **m,
                               ylm_error *e) {
  return make(kind, n, numbers, NULL, 0, NULL, m, e);
}

ylm_status ylm_material_load(int kind, size_t n, const float *numbers, const void *bytes,
                             size_t size, const char *name, ylm_material **m, ylm_error *e) {
  return make(kind, n, numbers, bytes ? bytes : "", size, name, m, e);
}

/* The count of holders is no part of what a material is. */
static atomic_size_t *holders(const ylm_material *m) {
  return &((ylm_material *)(uintptr_t)m)->holders;
}

const ylm_material *ylm_material_keep(const ylm_material *m) {
  atomic_fetch_add(holders(m), 1);
  return m;
}

void ylm_material_free(const ylm_material *m) {
  if (!m || atomic_fetch_sub(holders(m), 1) != 1) return;
  if (m->table && kinds[m->kind]->free)
    kinds[m->kind]->free(m->table);
  else
    ylm_free(m->table);
  ylm__material_free_kept((ylm_material *)(uintptr_t)m);
  ylm_free((void *)(uintptr_t)m);
}

int ylm_material_kind(const ylm_material *m) { return m->kind; }

uint64_t ylm_material_print(const ylm_material *m) { return m->print; }

size_t ylm_material_bytes(const ylm_material *m) { return sizeof *m + m->bytes; }

/* -- what they do with light ----------------------------------------------------- */

void ylm_material_albedo(const ylm_material *m, float albedo[3]) {
  memcpy(albedo, m->albedo, sizeof m->albedo);
}

void ylm_material_reflectance(const ylm_material *m, size_t n, const float (*wo)[3],
                              float (*albedo)[3]) {
  const material_kind *k = kinds[m->kind];
  (k->reflectance ? k->reflectance : ylm__material_reflectance)(m, n, wo, albedo);
}

void ylm_material_radiance(const ylm_material *m, size_t n, float *light) {
  const float *x;
  shaded(m, &x)->radiance(x, n, light);
}

void ylm_material_reflect(const ylm_material *m, const double irradiance[3], float radiance[3]) {
  const float *x;
  shaded(m, &x)->reflect(x, irradiance, radiance);
}

bool ylm__material_mirrored(const ylm_material *m) { return kinds[m->kind]->mirrored; }
bool ylm_material_isotropic(const ylm_material *m) { return kinds[m->kind]->isotropic(m); }

/* The argument of kernels: the table, or else the numbers. */
static const void *made_of(const ylm_material *m) { return m->table ? m->table : m->x; }

void ylm_material_eval(const ylm_material *m, size_t n, const float (*wi)[3], const float (*wo)[3],
                       float (*f)[3]) {
  const material_kind *k = kinds[m->kind];
  if (k->kernels)
    k->kernels()->eval(made_of(m), n, wi, wo, f);
  else
    k->eval(m, n, wi, wo, f);
}

void ylm_material_sample(const ylm_material *m, size_t n, const float (*wo)[3], const float (*u)[3],
                         float (*wi)[3], float (*weight)[3], float *pdf) {
  const material_kind *k = kinds[m->kind];
  if (k->kernels)
    k->kernels()->sample(made_of(m), n, wo, u, wi, weight, pdf);
  else
    k->sample(m, n, wo, u, wi, weight, pdf);
}

void ylm_material_pdf(const ylm_material *m, size_t n, const float (*wi)[3], const float (*wo)[3],
                      float *pdf) {
  const material_kind *k = kinds[m->kind];
  if (k->kernels)
    k->kernels()->pdf(made_of(m), n, wi, wo, pdf);
  else
    k->pdf(m, n, wi, wo, pdf);
}

void ylm_material_facts(const ylm_material *m, ylm_material_fact *fact, void *to) {
  const material_kind *k = kinds[m->kind];
  if (k->facts) k->facts(m, fact, to);
}

ylm_status ylm_material_row(const ylm_material *m, float *row, ylm_error *e) {
  const material_kind *k = kinds[m->kind];
  if (!k->row)
    return ylm_fail(e, YLM_EMISSING, "a device shades matte surfaces only, not %s", k->name);
  k->row(m->x, row);
  return YLM_OK;
}

void ylm_material_row_radiance(const float *row, float light[3]) {
  for (int c = 0; c < 3; c++) light[c] = matte_radiance(light[c], row[c]);
}

void ylm_material_row_tint(float *row, const float tint[3]) {
  for (int c = 0; c < 3; c++) row[c] *= tint[c];
}
