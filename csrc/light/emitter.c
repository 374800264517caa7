/* emitter.c - lights as rays and particles meet them: each question goes to the light's kind. */
#include <string.h>

#include "distant/distant.h"
#include "set.h"

bool ylm_light_set_emitter(const ylm_light_set *set, size_t i, ylm_light_emitter *out) {
  for (size_t k = 0; k < set->packs; k++) {
    const ylm__light_pack *p = set->pack[k];
    if (!p->kind->emits || !p->kind->emits->numbers) continue;
    if (i < p->n) {
      *out = (ylm_light_emitter){.kind = p->kind};
      out->numbers = p->kind->emits->numbers(p->of, i, out->x);
      return true;
    }
    i -= p->n;
  }
  return false;
}

void ylm_light_emitter_move(ylm_light_emitter *e, const double way[3]) {
  if (e->kind->emits->move) e->kind->emits->move(e->x, way);
}

double ylm_light_emitter_power(const ylm_light_emitter *e) { return e->kind->emits->power(e->x); }

bool ylm_light_emitter_place(const ylm_light_emitter *e, ylm_light_place *out) {
  return e->kind->emits->place(e->x, out);
}

/* Kinds without a function send no light of its sort. */
bool ylm_light_emitter_toward(const ylm_light_emitter *e, const double from[3],
                              ylm_light_way *out) {
  return e->kind->emits->toward && e->kind->emits->toward(e->x, from, out);
}

double ylm_light_emitter_weight(const ylm_light_emitter *e, const double from[3],
                                const float *normal) {
  return e->kind->emits->weight ? e->kind->emits->weight(e->x, from, normal) : 0;
}

void ylm_light_emitter_intensity(const ylm_light_emitter *e, const double way[3], double out[3]) {
  out[0] = out[1] = out[2] = 0;
  if (e->kind->emits->intensity) e->kind->emits->intensity(e->x, way, out);
}

double ylm_light_emitter_part(const ylm_light_emitter *e, const double from[3]) {
  return e->kind->emits->part ? e->kind->emits->part(e->x, from) : 1;
}

void ylm_light_emitter_keep(const ylm_light_emitter *e) {
  if (e->kind->emits->hold) e->kind->emits->hold(e->x, true);
}

void ylm_light_emitter_drop(const ylm_light_emitter *e) {
  if (e->kind->emits->hold) e->kind->emits->hold(e->x, false);
}

void ylm_light_emitter_radiance(const ylm_light_emitter *e, const double way[3], double out[3]) {
  out[0] = out[1] = out[2] = 0;
  if (e->kind->emits->radiance) e->kind->emits->radiance(e->x, way, out);
}

bool ylm_light_emitter_leave(const ylm_light_emitter *e, const double u[4],
                             ylm_light_leaving *out) {
  *out = (ylm_light_leaving){.extent = 0};
  for (int i = 0; i < 4; i++)
    if (!(u[i] >= 0 && u[i] < 1)) return false;
  return e->kind->emits->leave(e->x, u, out);
}

/* -- light fields --------------------------------------------------------------------------- */

size_t ylm_light_emitter_record(const ylm_light_emitter *e, double part, double *to,
                                const char **kind) {
  *kind = e->kind->name;
  memcpy(to, e->x, e->numbers * sizeof *to);
  for (int c = 0; c < 3; c++) to[c] *= part;
  return e->numbers;
}

size_t ylm_light_emitter_order(const ylm_light_emitter *e) {
  return ylm__light_kind_index(e->kind);
}

const char *ylm_light_emitter_fieldless(const ylm_light_emitter *e) {
  return e->kind->emits->fieldless;
}

ylm_status ylm__fieldless(const ylm_field *f, const ylm_field_query *q, size_t n,
                          const void *points, ylm_field_result *r, ylm_error *e) {
  (void)q, (void)n, (void)points, (void)r;
  return ylm_fail(e, YLM_EINVAL, "%s", ((const ylm__distant *)f->self)->kind->emits->fieldless);
}
