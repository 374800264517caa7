/* material.c - materials of any kind, by the table of kinds. */
#include <stdatomic.h>
#include <string.h>

#include "gen/material.h"
#include "kind.h"

struct ylm_material {
  atomic_size_t holders;
  int kind;
  float x[YLM_MATERIAL_NUMBERS];
};

static const material_kind *const kinds[] = {
#define X(name) &ylm__material_##name,
    MATERIAL_KINDS(X)
#undef X
};

int ylm_material_kinds(void) { return (int)(sizeof kinds / sizeof *kinds); }

const char *ylm_material_kind_name(int kind) { return kinds[kind]->name; }

int ylm_material_kind_find(const char *name) {
  for (int i = 0; i < ylm_material_kinds(); i++)
    if (strcmp(kinds[i]->name, name) == 0) return i;
  return -1;
}

ylm_status ylm_material_transfer(int kind, int lmax, double *a) {
  if (lmax < 0 || lmax > YLM_MATERIAL_LMAX) return YLM_ERANGE;
  return kinds[kind]->transfer(lmax, a);
}

ylm_status ylm_material_create(int kind, size_t n, const float *numbers, ylm_material **m,
                               ylm_error *e) {
  *m = NULL;
  if (kind < 0 || kind >= ylm_material_kinds())
    return ylm_fail(e, YLM_EINVAL, "there is no such kind of material");
  const material_kind *k = kinds[kind];
  if (n != k->numbers)
    return ylm_fail(e, YLM_EINVAL, "a %s material has %zu numbers, got %zu", k->name, k->numbers,
                    n);
  ylm_status s = k->check(numbers, e);
  if (s != YLM_OK) return s;
  ylm_material *new = ylm_alloc_zero(1, sizeof *new);
  if (!new) return YLM_ENOMEM;
  atomic_init(&new->holders, 1);
  new->kind = kind;
  memcpy(new->x, numbers, n * sizeof *numbers);
  *m = new;
  return YLM_OK;
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
  if (m && atomic_fetch_sub(holders(m), 1) == 1) ylm_free((void *)(uintptr_t)m);
}

int ylm_material_kind(const ylm_material *m) { return m->kind; }

void ylm_material_albedo(const ylm_material *m, float albedo[3]) {
  kinds[m->kind]->albedo(m->x, albedo);
}

void ylm_material_radiance(const ylm_material *m, size_t n, float *light) {
  kinds[m->kind]->radiance(m->x, n, light);
}

void ylm_material_reflect(const ylm_material *m, const double irradiance[3], float radiance[3]) {
  kinds[m->kind]->reflect(m->x, irradiance, radiance);
}

bool ylm_material_isotropic(const ylm_material *m) { return kinds[m->kind]->isotropic(m->x); }

void ylm_material_eval(const ylm_material *m, size_t n, const float (*wi)[3], const float (*wo)[3],
                       float (*f)[3]) {
  kinds[m->kind]->eval(m->x, n, wi, wo, f);
}

void ylm_material_sample(const ylm_material *m, size_t n, const float (*wo)[3], const float (*u)[3],
                         float (*wi)[3], float (*weight)[3], float *pdf) {
  kinds[m->kind]->sample(m->x, n, wo, u, wi, weight, pdf);
}

void ylm_material_pdf(const ylm_material *m, size_t n, const float (*wi)[3], const float (*wo)[3],
                      float *pdf) {
  kinds[m->kind]->pdf(m->x, n, wi, wo, pdf);
}

ylm_status ylm_material_row(const ylm_material *m, float *row, ylm_error *e) {
  const material_kind *k = kinds[m->kind];
  if (!k->row) return ylm_fail(e, YLM_EMISSING, "a device shades no %s surfaces", k->name);
  k->row(m->x, row);
  return YLM_OK;
}

void ylm_material_row_radiance(const float *row, float light[3]) {
  for (int c = 0; c < 3; c++) light[c] = matte_radiance(light[c], row[c]);
}
