/* divide.c - a bake by a team: which points a process evaluates, and results to all of them. */
#include "baker.h"

static ylm_team *team_of(const baker *b) {
  ylm_team *t = b->source->team;
  return t && t->size > 1 ? t : NULL;
}

size_t ylm__divide_round(const baker *b) {
  const ylm_team *t = team_of(b);
  size_t block = YLM_GRID_BLOCK, most = DIVIDE_ROUND / block;
  if (!t) return block;
  return block * ((size_t)t->size < most ? (size_t)t->size : most);
}

/* A field whose results depend on the query is asked in the blocks of one process. */
size_t ylm__divide_part(const baker *b, size_t n) {
  const ylm_team *t = team_of(b);
  if (!t) return n;
  if (!b->source->field->pointwise) return n < YLM_GRID_BLOCK ? n : YLM_GRID_BLOCK;
  size_t grains = (n + DIVIDE_GRAIN - 1) / DIVIDE_GRAIN, size = (size_t)t->size;
  size_t part = (grains + size - 1) / size * DIVIDE_GRAIN;
  return part < n ? part : n;
}

ylm_status ylm__divide_agree(baker *b, ylm_status s) {
  ylm_team *t = team_of(b);
  if (!t || b->agreed) return s;
  if (s != YLM_OK && !(b->e && b->e->status == s)) ylm_fail_plain(b->e, s);
  s = t->agree(t->self, s, b->e);
  b->told |= b->agreed = s != YLM_OK;
  return s;
}

/* A failure of the exchange itself is known to all. */
static ylm_status known(baker *b, ylm_status s) {
  if (s != YLM_OK) b->told = b->agreed = true;
  return s;
}

static ylm_status exchange(baker *b, const void *mine, size_t *bytes, void *all) {
  ylm_team *t = team_of(b);
  return known(b, t->exchange(t->self, mine, bytes, all, b->e));
}

ylm_status ylm__divide_share(baker *b, size_t n, size_t part, size_t size, void *rows) {
  const ylm_team *t = team_of(b);
  size_t *bytes = ylm_alloc((size_t)t->size, sizeof *bytes), at = 0, mine = 0;
  ylm_status s = ylm__divide_agree(b, bytes ? YLM_OK : YLM_ENOMEM);
  for (int r = 0; s == YLM_OK && r < t->size; at += bytes[r++] / size) {
    if (r == t->rank) mine = at;
    bytes[r] = (n - at < part ? n - at : part) * size;
  }
  if (s == YLM_OK) s = exchange(b, (char *)rows + mine * size, bytes, rows);
  ylm_free(bytes);
  return s;
}

ylm_status ylm__divide_count(baker *b, uint64_t before, uint64_t *count) {
  const ylm_team *t = team_of(b);
  size_t size = (size_t)t->size;
  uint64_t *all = ylm_alloc(size, 2 * sizeof *all), mine = *count - before;
  size_t *bytes = (size_t *)(all ? all + size : NULL);
  ylm_status s = ylm__divide_agree(b, all ? YLM_OK : YLM_ENOMEM);
  for (size_t r = 0; s == YLM_OK && r < size; r++) bytes[r] = sizeof mine;
  if (s == YLM_OK) s = exchange(b, &mine, bytes, all);
  *count = before;
  for (size_t r = 0; s == YLM_OK && r < size; r++) *count += all[r];
  ylm_free(all);
  return s;
}

ylm_status ylm__divide_compare(baker *b, const float *numbers, size_t n) {
  static const char *const name = "light field";
  ylm_team *t = team_of(b);
  uint64_t crc = ylm_crc64(0, numbers, n * sizeof *numbers);
  return known(b, ylm_team_same(t, "", 1, &name, &crc, b->e));
}

/* -- arguments ------------------------------------------------------------------------------ */

enum { ARGUMENTS_MOST = 24 };

typedef struct arguments {
  size_t n;
  const char *name[ARGUMENTS_MOST];
  uint64_t value[ARGUMENTS_MOST];
} arguments;

static void add(arguments *a, const char *name, const void *data, size_t bytes) {
  a->name[a->n] = name;
  a->value[a->n++] = data ? ylm_crc64(0, data, bytes) : 0;
}

static uint64_t crc_of_meshes(const ylm_grid_source *source) {
  uint64_t crc = 0;
  for (size_t i = 0; i < source->meshes; i++) {
    const ylm_grid_mesh *m = &source->mesh[i];
    crc = ylm_crc64(crc, m->position, m->vertices * 3 * ylm_dtype_size(m->dtype));
    crc = ylm_crc64(crc, m->index, m->triangles * 3 * sizeof *m->index);
  }
  return crc;
}

ylm_status ylm__divide_same(ylm_team *t, const ylm_grid_form *f, const ylm_grid_source *source,
                            ylm_error *e) {
  size_t points = source->occupied_points ? source->occupied : 0,
         bytes = points * 3 * ylm_dtype_size(source->occupied_dtype);
  uint64_t meshes = crc_of_meshes(source);
  int flags = f->continuous + 2 * (int)f->measure + 8 * (int)f->quantity, isa = ylm_isa_current();
  arguments a = {0};
  add(&a, "set of kernels (the environment's YLM_ISA gives all the same)", &isa, sizeof isa);
  add(&a, "kind of grid", &f->kind, sizeof f->kind);
  add(&a, "box of bounds", f->bounds, sizeof f->bounds);
  add(&a, "lmax", &f->lmax, sizeof f->lmax);
  add(&a, "number of channels", &f->channels, sizeof f->channels);
  add(&a, "number of channels of the metric", &f->metric_channels, sizeof f->metric_channels);
  add(&a, "depth", &f->depth, sizeof f->depth);
  add(&a, "number of cells", f->cells, sizeof f->cells);
  add(&a, "metric", &f->metric, sizeof f->metric);
  add(&a, "threshold", &f->threshold, sizeof f->threshold);
  add(&a, "tolerance", &f->tolerance, sizeof f->tolerance);
  add(&a, "continuity, measure or quantity", &flags, sizeof flags);
  add(&a, "sides", &f->sides, sizeof f->sides);
  add(&a, "seed", &source->seed, sizeof source->seed);
  add(&a, "limit of points", &source->max_points, sizeof source->max_points);
  add(&a, "list of occupied points", points ? source->occupied_points : NULL, bytes);
  add(&a, "list of normals", points ? source->normals : NULL, bytes);
  add(&a, "geometry", &meshes, sizeof meshes);
  return ylm_team_same(t, "", a.n, a.name, a.value, e);
}

ylm_status ylm__divide_begin(baker *b) {
  ylm_team *t = team_of(b);
  return t ? known(b, ylm__divide_same(t, &b->g->contents.form, b->source, b->e)) : YLM_OK;
}
