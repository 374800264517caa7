/* set.c - sets of lights of any kinds: packs, one for each sum. */
#include "set.h"

#include <string.h>

/* -- packs ---------------------------------------------------------------------------------- */

static void discard(const ylm__light_pack *made) {
  if (made->kind->free) made->kind->free(made->of);
}

static void drop(ylm__light_pack *p) {
  if (--p->users > 0) return;
  discard(p);
  ylm_free(p);
}

/* Appends a pack of its own, which is discarded without memory, or one that other sets have too.
   The set has room. */
static ylm_status append_new(ylm_light_set *set, const ylm__light_pack *made) {
  ylm__light_pack *p = ylm_alloc_copy(made, 1, sizeof *p);
  if (!p) {
    discard(made);
    return YLM_ENOMEM;
  }
  p->users = 1;
  set->pack[set->packs++] = p;
  set->n += p->n;
  return YLM_OK;
}

static void append_shared(ylm_light_set *set, ylm__light_pack *p) {
  p->users++;
  set->pack[set->packs++] = p;
  set->n += p->n;
}

ylm__light_pack *ylm__light_set_spheres(const ylm_light_set *set) {
  return set->packs && set->pack[0]->kind == &ylm__sphere_kind ? set->pack[0] : NULL;
}

/* -- records -------------------------------------------------------------------------------- */

/* A record of a source, and where its light comes to lie. */
typedef struct entry {
  const ylm__light_kind *kind;
  const double *record;
  ylm__light_place place;
  bool taken;
} entry;

typedef struct maker {
  ylm_light_set *set;
  size_t sources;
  const ylm_light_source *source;
  size_t n;
  entry *entry;          /* [n] all records, in order */
  const double **record; /* [n] scratch */
  ylm_error *e;
} maker;

/* Counts the records of a source, or lists them at `to`; false where they are cut short. */
static bool split(const ylm_light_source *s, const ylm__light_kind *kind, entry *to, size_t *n) {
  const double *x = s->record;
  size_t left = s->numbers;
  while (left) {
    size_t used = kind->length(x, left);
    if (!used) return false;
    if (to) to[*n] = (entry){.kind = kind, .record = x};
    ++*n;
    x += used;
    left -= used;
  }
  return true;
}

static ylm_status list_records(maker *m) {
  for (int pass = 0; pass < 2; pass++) {
    m->n = 0;
    for (size_t i = 0; i < m->sources; i++) {
      const ylm_light_source *s = &m->source[i];
      if (!s->kind) continue;
      const ylm__light_kind *kind = ylm__light_kind_of(s->kind);
      if (!kind || !kind->length)
        return ylm_fail(m->e, YLM_EINVAL, "no records of kind '%s'", s->kind);
      if (!split(s, kind, m->entry, &m->n))
        return ylm_fail(m->e, YLM_EINVAL, "a record of kind '%s' is cut short", s->kind);
    }
    if (pass) break;
    m->entry = ylm_alloc(m->n, sizeof *m->entry);
    m->record = ylm_alloc(m->n, sizeof *m->record);
    if (!m->entry || !m->record) return YLM_ENOMEM;
  }
  return YLM_OK;
}

/* -- spheres -------------------------------------------------------------------------------- */

/* How many spheres there are, in records and in packs of other sets; how many of these packs. */
static size_t count_spheres(const maker *m, size_t *packs) {
  size_t n = 0;
  *packs = 0;
  for (size_t i = 0; i < m->n; i++) n += m->entry[i].kind == &ylm__sphere_kind;
  for (size_t i = 0; i < m->sources; i++) {
    ylm__light_pack *p = m->source[i].set ? ylm__light_set_spheres(m->source[i].set) : NULL;
    if (p) n += p->n, ++*packs;
  }
  return n;
}

/* Arrays of all spheres, which are filled from the front. */
typedef struct spheres {
  double *at, *radius, *radiance;
  size_t n;
} spheres;

static void add_record(spheres *s, entry *x) {
  memcpy(s->radiance + 3 * s->n, x->record, 3 * sizeof *s->at);
  memcpy(s->at + 3 * s->n, x->record + 3, 3 * sizeof *s->at);
  s->radius[s->n] = x->record[6];
  x->place = (ylm__light_place){0, s->n++};
  x->taken = true;
}

static void add_pack(spheres *s, const ylm__light_pack *p) {
  for (size_t i = 0; i < p->n; i++, s->n++) {
    ylm_light l;
    p->kind->get(p->of, i, &l, NULL);
    memcpy(s->radiance + 3 * s->n, l.radiance, sizeof l.radiance);
    memcpy(s->at + 3 * s->n, l.at, sizeof l.at);
    s->radius[s->n] = l.radius;
  }
}

/* All spheres are one pack, in the order of the sources: that of a set that has them all, or a new
   one. */
static ylm_status pack_spheres(maker *m) {
  size_t packs, n = count_spheres(m, &packs), next = 0;
  ylm__light_pack *shared = NULL, made;
  for (size_t i = 0; i < m->sources && packs; i++)
    if (m->source[i].set && !shared) shared = ylm__light_set_spheres(m->source[i].set);
  if (!n && !packs) return YLM_OK;
  if (packs == 1 && shared->n == n) {
    append_shared(m->set, shared);
    return YLM_OK;
  }
  double *x = ylm_alloc(n, 7 * sizeof *x);
  if (!x) return YLM_ENOMEM;
  spheres all = {x, x + 3 * n, x + 4 * n, 0};
  for (size_t i = 0; i < m->sources; i++) {
    const ylm_light_source *s = &m->source[i];
    const double *end = s->kind ? s->record + s->numbers : NULL;
    for (; s->kind && next < m->n && m->entry[next].record >= s->record &&
           m->entry[next].record < end;
         next++)
      if (m->entry[next].kind == &ylm__sphere_kind) add_record(&all, &m->entry[next]);
    ylm__light_pack *p = s->set ? ylm__light_set_spheres(s->set) : NULL;
    if (p) add_pack(&all, p);
  }
  ylm_status s = ylm__sphere_pack(n, all.at, all.radius, all.radiance, &made, m->e);
  ylm_free(x);
  return s == YLM_OK ? append_new(m->set, &made) : s;
}

/* -- other kinds ---------------------------------------------------------------------------- */

/* Packs of other sets, spheres excepted, and fields of another origin, in order. */
static ylm_status pack_others(maker *m) {
  ylm_status status = YLM_OK;
  for (size_t i = 0; i < m->sources && status == YLM_OK; i++) {
    const ylm_light_source *s = &m->source[i];
    for (size_t k = 0; s->set && k < s->set->packs; k++)
      if (s->set->pack[k]->kind != &ylm__sphere_kind) append_shared(m->set, s->set->pack[k]);
    if (s->field)
      status = append_new(m->set, &(ylm__light_pack){.kind = &ylm__foreign_kind,
                                                     .of = (void *)(uintptr_t)s->field,
                                                     .field = s->field,
                                                     .n = 1});
  }
  return status;
}

/* The record's light goes into one pack with all that have the same in common. */
static ylm_status pack_alike(maker *m, size_t first) {
  const ylm__light_kind *kind = m->entry[first].kind;
  const double *common = m->entry[first].record + 3;
  ylm__light_pack made;
  size_t n = 0;
  for (size_t i = first; i < m->n; i++) {
    entry *x = &m->entry[i];
    if (x->taken || x->kind != kind || memcmp(x->record + 3, common, kind->common * sizeof *common))
      continue;
    x->taken = true;
    x->place = (ylm__light_place){(uint32_t)m->set->packs, n};
    m->record[n++] = x->record;
  }
  ylm_status s = kind->create(n, m->record, &made, m->e);
  return s == YLM_OK ? append_new(m->set, &made) : s;
}

/* -- the set -------------------------------------------------------------------------------- */

/* Packs that a set has room for. */
static size_t most_packs(const maker *m) {
  size_t n = 1 + m->n;
  for (size_t i = 0; i < m->sources; i++) n += 1 + (m->source[i].set ? m->source[i].set->packs : 0);
  return n;
}

/* Several packs are summed as fields. */
static ylm_status sum_packs(ylm_light_set *set) {
  if (set->packs < 2) return YLM_OK;
  const ylm_field **field = ylm_alloc(set->packs, sizeof *field);
  if (!field) return YLM_ENOMEM;
  for (size_t i = 0; i < set->packs; i++) field[i] = set->pack[i]->field;
  ylm_status s = ylm_field_sum_create(set->packs, field, &set->sum);
  ylm_free((void *)field);
  return s;
}

static ylm_status keep_places(maker *m) {
  ylm_light_set *set = m->set;
  set->place = ylm_alloc(m->n, sizeof *set->place);
  if (!set->place) return YLM_ENOMEM;
  for (size_t i = 0; i < m->n; i++)
    if (m->entry[i].kind != &ylm__sphere_kind) set->place[set->places++] = m->entry[i].place;
  return YLM_OK;
}

static ylm_status make(maker *m) {
  ylm__light_pack none;
  ylm_status s = list_records(m);
  if (s != YLM_OK) return s;
  m->set->pack = ylm_alloc(most_packs(m), sizeof(ylm__light_pack *));
  if (!m->set->pack) return YLM_ENOMEM;
  s = pack_spheres(m);
  if (s == YLM_OK) s = pack_others(m);
  for (size_t i = 0; i < m->n && s == YLM_OK; i++)
    if (!m->entry[i].taken) s = pack_alike(m, i);
  if (s == YLM_OK && !m->set->packs) {
    s = ylm__sphere_pack(0, NULL, NULL, NULL, &none, m->e);
    if (s == YLM_OK) s = append_new(m->set, &none);
  }
  if (s == YLM_OK) s = keep_places(m);
  return s == YLM_OK ? sum_packs(m->set) : s;
}

ylm_status ylm_light_set_create(size_t n, const ylm_light_source *source, ylm_light_set **set,
                                ylm_error *e) {
  maker m = {.set = ylm_alloc_zero(1, sizeof *m.set), .sources = n, .source = source, .e = e};
  *set = NULL;
  ylm_status s = m.set ? make(&m) : YLM_ENOMEM;
  ylm_free(m.entry);
  ylm_free((void *)m.record);
  if (s == YLM_OK)
    *set = m.set;
  else
    ylm_light_set_free(m.set);
  return s == YLM_ENOMEM ? ylm_no_memory(e) : s;
}

ylm_status ylm__light_set_of_pack(const ylm__light_pack *made, ylm_light_set **set, ylm_error *e) {
  ylm_light_set *s = ylm_alloc_zero(1, sizeof *s);
  if (s) s->pack = ylm_alloc(1, sizeof(ylm__light_pack *));
  bool room = s && s->pack;
  if (!room) discard(made);
  if (room && append_new(s, made) == YLM_OK) {
    *set = s;
    return YLM_OK;
  }
  ylm_light_set_free(s);
  return ylm_no_memory(e);
}

ylm_status ylm_light_set_spheres(size_t n, const double *at, const double *radius,
                                 const double *radiance, ylm_light_set **set, ylm_error *e) {
  ylm__light_pack made;
  *set = NULL;
  ylm_status s = ylm__sphere_pack(n, at, radius, radiance, &made, e);
  return s == YLM_OK ? ylm__light_set_of_pack(&made, set, e) : s;
}

void ylm_light_set_free(ylm_light_set *set) {
  if (!set) return;
  ylm_field_sum_free(set->sum);
  for (size_t i = 0; i < set->packs; i++) drop(set->pack[i]);
  ylm_free(set->pack);
  ylm_free(set->place);
  ylm_free(set);
}

size_t ylm_light_set_count(const ylm_light_set *set) { return set->n; }

size_t ylm_light_set_sphere_count(const ylm_light_set *set) {
  const ylm__light_pack *p = ylm__light_set_spheres(set);
  return p ? p->n : 0;
}

const ylm_field *ylm_light_set_field(const ylm_light_set *set) {
  return set->sum ? ylm_field_sum_field(set->sum) : set->pack[0]->field;
}

ylm_status ylm_light_set_evaluate(const ylm_light_set *set, ylm_isa isa, const ylm_field_query *q,
                                  size_t n, const void *points, ylm_field_result *r, ylm_error *e) {
  const ylm__light_pack *p = set->pack[0];
  if (set->packs > 1)
    return ylm_fail(e, YLM_EINVAL, "kernels are chosen for lights that are summed together");
  if (!p->kind->evaluate) return ylm_field_evaluate(p->field, q, n, points, r, e);
  return p->kind->evaluate(p->of, isa, q, n, points, r, e);
}

/* -- fields of another origin --------------------------------------------------------------- */

const ylm__light_kind ylm__foreign_kind = {.name = "field"};

bool ylm_light_set_part(const ylm_light_set *set, size_t i, ylm_light_part *out) {
  if (i >= set->packs) return false;
  const ylm__light_pack *p = set->pack[i];
  *out = (ylm_light_part){.kind = p->kind->name};
  if (p->kind->device) p->kind->device(p->of, out);
  return true;
}
