/* gloss.c - the surfaces of a view that gloss: their materials, and tables of these by degree. */
#include <stdatomic.h>
#include <string.h>

#include "slices.h"

_Static_assert(YLM_SHADE_DEGREES == YLM_MATERIAL_TABLE_LMAX + 1, "a factor for each degree");

/* Rotations of one degree, and products by one method. */
typedef struct plan {
  struct plan *next;
  int lmax;
  ylm_sh_product_method method;
  ylm_sh_rotator *rotator;
  ylm_sh_product *product;
} plan;

struct shade_gloss {
  size_t materials, meshes, points;
  const ylm_material **material; /* [materials], each once    */
  bool *seen;                    /* [materials]: at some point */
  uint32_t *slot;                /* [meshes]: of its material; YLM_SHADE_MATTE: matte */
  float (*tangent)[3];           /* [points of the view]; NULL: all materials are isotropic */
  shade_gloss *before; /* of the view that its own is made of; NULL: none. The tangents are its */
  _Atomic(struct plan *) plans; /* of it and of all that are made of it */
  _Atomic(shade_tables *) tables;
  _Atomic(shade_kept *) kept;
  atomic_uint_fast64_t stage[SHADE_STAGES]; /* nanoseconds */
  atomic_size_t grown;                      /* bytes since the last ylm_shade_view_grown */
};

/* Gives a material its number. */
static uint32_t number_of(shade_gloss *g, const ylm_material *m) {
  for (size_t k = 0; k < g->materials; k++)
    if (g->material[k] == m) return (uint32_t)k;
  g->material[g->materials] = m;
  return (uint32_t)g->materials++;
}

/* Whether a mesh's points hold visibility times the cosine, and so must stay matte. */
static bool must_be_matte(const ylm_shade_view *v, const shade_gloss *before, size_t mesh) {
  return v->base && ylm__shade_shadows(v, YLM_SHADE_TRANSFER) &&
         (!before || before->slot[mesh] == YLM_SHADE_MATTE);
}

/* Whether a mesh is shaded by tables, matte or not. */
static bool has_table(const ylm_shade_view *v, const shade_gloss *before, size_t mesh) {
  if (before && ylm__shade_shadows(v, YLM_SHADE_TRANSFER))
    return before->slot[mesh] != YLM_SHADE_MATTE;
  return ylm_material_glosses(ylm__shade_mesh_material(v, mesh));
}

/* Refuses what a mesh has become in a view that is made of another. */
static ylm_status check_mesh(const ylm_shade_view *v, const shade_gloss *before, size_t mesh,
                             ylm_error *e) {
  const ylm_material *m = ylm__shade_mesh_material(v, mesh);
  const char *kind = ylm_material_kind_name(ylm_material_kind(m));
  if (!v->base || !v->base->o.gloss) return YLM_OK;
  if (ylm_material_glosses(m) && must_be_matte(v, before, mesh))
    return ylm_fail(e, YLM_EINVAL,
                    "mesh %zu is matte in the prepared view, which keeps its visibility times the "
                    "cosine: it cannot become %s, prepare the view with a material that glosses",
                    mesh + 1, kind);
  if (!ylm_material_isotropic(m) && !(before && before->tangent) && v->points > 0)
    return ylm_fail(
        e, YLM_EINVAL,
        "mesh %zu cannot become %s with two roughnesses: the prepared view has isotropic "
        "materials alone, and no tangents, prepare it with one that has them",
        mesh + 1, kind);
  return YLM_OK;
}

ylm_status ylm__shade_gloss_create(const ylm_shade_view *v, const shade_gloss *before,
                                   shade_gloss **out, ylm_error *e) {
  size_t meshes = ylm_scene_meshes(v->scene), n = 0;
  *out = NULL;
  for (size_t i = 0; i < meshes; i++) {
    ylm_status s = check_mesh(v, before, i, e);
    if (s != YLM_OK) return s;
    n += has_table(v, before, i);
  }
  if (n == 0) return YLM_OK;
  shade_gloss *g = *out = ylm_alloc_zero(1, sizeof *g);
  if (!g) return YLM_ENOMEM;
  g->meshes = meshes;
  g->material = ylm_alloc(n, sizeof *g->material);
  g->seen = ylm_alloc_zero(n, sizeof *g->seen);
  g->slot = ylm_alloc(meshes, sizeof *g->slot);
  if (!g->material || !g->seen || !g->slot) return YLM_ENOMEM;
  for (size_t i = 0; i < meshes; i++)
    g->slot[i] =
        has_table(v, before, i) ? number_of(g, ylm__shade_mesh_material(v, i)) : YLM_SHADE_MATTE;
  if (!v->base) return YLM_OK;
  g->before = (shade_gloss *)(uintptr_t)before;
  g->tangent = before ? before->tangent : NULL;
  for (size_t i = 0; i < v->points; i++) {
    if (g->slot[v->mesh[i]] == YLM_SHADE_MATTE) continue;
    g->seen[g->slot[v->mesh[i]]] = true;
    g->points++;
  }
  return YLM_OK;
}

ylm_status ylm__shade_gloss_room(shade_gloss *g, size_t points) {
  bool turned = false;
  for (size_t k = 0; g && k < g->materials; k++) turned |= !ylm_material_isotropic(g->material[k]);
  if (!turned) return YLM_OK;
  g->tangent = ylm_alloc(points, sizeof *g->tangent);
  return g->tangent ? YLM_OK : YLM_ENOMEM;
}

void ylm__shade_gloss_point(shade_gloss *g, size_t i, uint32_t mesh, const ylm_scene_surface *s) {
  if (g->tangent) memcpy(g->tangent[i], s->tangent, 12);
  if (g->slot[mesh] == YLM_SHADE_MATTE) return;
  g->seen[g->slot[mesh]] = true;
  g->points++;
}

uint32_t ylm__shade_gloss_slot(const shade_gloss *g, uint32_t mesh) { return g->slot[mesh]; }
const float (*ylm__shade_gloss_tangents(const shade_gloss *g))[3] {
  return (const float(*)[3])g->tangent;
}

/* -- tables ------------------------------------------------------------------------------------ */

static void tables_free(shade_tables *t) {
  if (!t) return;
  for (size_t k = 0; t->table && k < t->materials; k++) /* its own */
    ylm_material_table_free((ylm_material_table *)(uintptr_t)t->table[k]);
  ylm_free(t->table);
  ylm_free(t);
}

static void plan_free(plan *p) {
  if (!p) return;
  ylm_sh_rotator_free(p->rotator);
  ylm_sh_product_free(p->product);
  ylm_free(p);
}

/* The plan of a degree and a method, made at the first call. */
static ylm_status plan_of(shade_gloss *g, int lmax, ylm_sh_product_method method, const plan **out,
                          ylm_error *e) {
  if (g->before) g = g->before;
  plan *head = atomic_load(&g->plans), *p = head;
  while (p && (p->lmax != lmax || p->method != method)) p = p->next;
  if ((*out = p)) return YLM_OK;
  if (!(p = ylm_alloc_zero(1, sizeof *p))) return YLM_ENOMEM;
  p->lmax = lmax;
  p->method = method;
  ylm_status s = ylm_sh_rotator_create(lmax, &p->rotator, e);
  if (s == YLM_OK) s = ylm_sh_product_create(lmax, 2, method, YLM_SH_PRODUCT_auto, &p->product, e);
  if (s != YLM_OK) {
    plan_free(p);
    return s;
  }
  do p->next = head; /* others that made the same at the same time stay behind it, unused */
  while (!atomic_compare_exchange_weak(&g->plans, &head, p));
  *out = p;
  return YLM_OK;
}

/* A table of which the nearest row is taken: nobody keeps it. */
static ylm_status create_nearest(const ylm_material *m, int lmax, int threads,
                                 const ylm_progress *progress, const ylm_material_table **out,
                                 ylm_error *e) {
  ylm_material_table *t;
  ylm_status s = ylm_material_table_create(
      m,
      &(ylm_material_table_form){.lmax = lmax,
                                 .rows = YLM_MATERIAL_NEAREST_ROWS,
                                 .columns = 4 * (YLM_MATERIAL_NEAREST_ROWS / 2),
                                 .threads = threads,
                                 .progress = progress},
      &t, e);
  *out = t;
  return s;
}

static ylm_status tables_create(const ylm_shade_view *v, int lmax, int threads,
                                const ylm_progress *progress, shade_tables **out, ylm_error *e) {
  shade_gloss *g = v->gloss;
  double start = ylm_seconds();
  shade_tables *t = *out = ylm_alloc_zero(1, sizeof *t);
  if (!t) return YLM_ENOMEM;
  t->lmax = lmax;
  if (v->o.nearest) {
    t->nearest = ylm_material_rival_nearest();
    t->materials = g->materials;
    if (!t->nearest)
      return ylm_fail(e, YLM_EMISSING, "nearest rows need libylm_rival: call ylm_rival_register()");
  }
  t->table = ylm_alloc_zero(g->materials, sizeof *t->table);
  const plan *p = NULL;
  ylm_status s = t->table ? plan_of(v->gloss, lmax, v->o.product, &p, e) : YLM_ENOMEM;
  if (s == YLM_OK) {
    t->rotator = p->rotator;
    t->product = p->product;
  }
  for (size_t k = 0; s == YLM_OK && k < g->materials; k++)
    if (g->seen[k]) {
      ylm_material_table_facts f = {0};
      size_t kept = ylm_material_table_kept_bytes(g->material[k]);
      s = v->o.nearest
              ? create_nearest(g->material[k], lmax, threads, progress, &t->table[k], e)
              : ylm_material_table_kept(g->material[k], lmax, threads, progress, &t->table[k], e);
      if (s == YLM_OK) ylm_material_table_look(t->table[k], &f);
      t->bytes += f.bytes;
      kept = v->o.nearest ? f.bytes : ylm_material_table_kept_bytes(g->material[k]) - kept;
      atomic_fetch_add(&g->grown, kept);
    }
  t->seconds = ylm_seconds() - start;
  return s;
}

static const shade_tables *find(shade_tables *t, int lmax) {
  while (t && t->lmax != lmax) t = t->next;
  return t;
}

ylm_status ylm__shade_gloss_tables(const ylm_shade_view *v, int lmax, int threads,
                                   const ylm_progress *progress, const shade_tables **out,
                                   ylm_error *e) {
  shade_gloss *g = v->gloss;
  *out = NULL;
  if (!g || g->points == 0 || v->o.gloss == YLM_SHADE_GLOSS_RAYS) return YLM_OK;
  shade_tables *head = atomic_load(&g->tables), *made;
  if ((*out = find(head, lmax))) return YLM_OK;
  if (lmax > YLM_MATERIAL_TABLE_LMAX)
    return ylm_fail(e, YLM_ERANGE,
                    "surfaces that gloss are shaded by tables of degree 0 to %d, here is light of "
                    "degree %d: lower lmax, or set gloss = 'rays' or 'matte'",
                    YLM_MATERIAL_TABLE_LMAX, lmax);
  ylm_status s = tables_create(v, lmax, threads, progress, &made, e);
  if (s != YLM_OK) {
    tables_free(made);
    return s;
  }
  do made->next = head; /* others that made the same at the same time stay behind it, unused */
  while (!atomic_compare_exchange_weak(&g->tables, &head, made));
  *out = made;
  return YLM_OK;
}

/* -- products that are kept -------------------------------------------------------------------- */

static void kept_free(shade_kept *k) {
  if (!k) return;
  ylm_free(k->slice);
  ylm_free(k->at);
  ylm_free(k);
}

/* Room for the slices of all points. */
static ylm_status kept_create(const ylm_shade_view *v, const shade_tables *tables, bool shadows,
                              shade_kept **out) {
  const shade_gloss *g = v->gloss;
  size_t numbers = 0, count = ylm_sh_count(tables->lmax);
  shade_kept *k = *out = ylm_alloc_zero(1, sizeof *k);
  if (!k) return YLM_ENOMEM;
  k->tables = tables;
  k->shadows = shadows;
  k->at = ylm_alloc_zero(v->points, sizeof *k->at);
  if (!k->at) return YLM_ENOMEM;
  for (size_t i = 0; i < v->points; i++) {
    ylm_material_table_facts f;
    uint32_t slot = g->slot[v->mesh[i]];
    if (slot == YLM_SHADE_MATTE) continue;
    ylm_material_table_look(tables->table[slot], &f);
    k->at[i] = numbers;
    numbers += (size_t)f.functions * count;
  }
  k->bytes = numbers * sizeof(float) + v->points * sizeof *k->at;
  k->slice = ylm_alloc(numbers, sizeof *k->slice);
  return k->slice ? YLM_OK : YLM_ENOMEM;
}

ylm_status ylm__shade_gloss_kept(const ylm_shade_view *v, const shade_tables *tables, bool shadows,
                                 shade_make_fn *make, int threads, const ylm_progress *progress,
                                 const shade_kept **out) {
  shade_gloss *g = v->gloss;
  shade_kept *head = atomic_load(&g->kept), *k = head;
  while (k && (k->tables != tables || k->shadows != shadows)) k = k->next;
  if ((*out = k)) return YLM_OK;
  ylm_status s = kept_create(v, tables, shadows, &k);
  if (s == YLM_OK) s = make(v, k, threads, progress);
  if (s != YLM_OK) {
    kept_free(k);
    return s;
  }
  atomic_fetch_add(&g->grown, k->bytes);
  do k->next = head; /* others that made the same at the same time stay behind it, unused */
  while (!atomic_compare_exchange_weak(&g->kept, &head, k));
  *out = k;
  return YLM_OK;
}

double ylm__shade_clock(const ylm_shade_view *v, shade_stage stage, double start) {
  double now = ylm_seconds();
  if (v->gloss)
    atomic_fetch_add_explicit(&v->gloss->stage[stage], (uint64_t)((now - start) * 1e9),
                              memory_order_relaxed);
  return now;
}

void ylm_shade_view_stages(const ylm_shade_view *v, ylm_shade_stages *out) {
  double t[SHADE_STAGES] = {0};
  for (int i = 0; v->gloss && i < SHADE_STAGES; i++)
    t[i] = 1e-9 * (double)atomic_load(&v->gloss->stage[i]);
  *out = (ylm_shade_stages){t[SHADE_ROWS], t[SHADE_ROTATION], t[SHADE_PRODUCT], t[SHADE_LIGHT],
                            t[SHADE_DOT]};
}

static float smoothstep(const double band[2], double e) {
  double x = (e - band[0]) / (band[1] - band[0]);
  if (x <= 0) return 0;
  if (x >= 1) return 1;
  return (float)(x * x * (3 - 2 * x));
}

void ylm__shade_gloss_shares(const ylm_shade_view *v, const shade_tables *t, int lmax, size_t first,
                             size_t n, float *share, float *missed) {
  for (size_t i = 0; i < n; i++) {
    uint32_t k = ylm__shade_gloss_slot(v->gloss, v->mesh[first + i]);
    float e = 0, wo[3], frame[3][3];
    share[i] = k != YLM_SHADE_MATTE && v->o.gloss == YLM_SHADE_GLOSS_RAYS;
    if (k != YLM_SHADE_MATTE && t) {
      ylm__shade_look(v, first + i, wo, frame);
      ylm_material_table_missed(t->table[k], lmax, 1, (const float(*)[3])wo, &e);
      if (v->o.gloss == YLM_SHADE_GLOSS_AUTO && !v->corner && !v->base)
        share[i] = smoothstep(v->o.gloss_error, (double)e);
    }
    if (missed) missed[i] = e;
  }
}

size_t ylm_shade_view_grown(const ylm_shade_view *v) {
  return v->gloss ? atomic_exchange(&v->gloss->grown, 0) : 0;
}

void ylm__shade_gloss_stats(const ylm_shade_view *v, ylm_shade_stats *stats) {
  shade_gloss *g = v->gloss;
  if (!g) return;
  stats->glossy = g->points;
  stats->bytes += g->meshes * sizeof *g->slot + (g->tangent ? 12 * v->points : 0);
  for (const shade_tables *t = atomic_load(&g->tables); t; t = t->next) {
    stats->gloss_bytes += t->bytes;
    stats->gloss_seconds += t->seconds;
  }
  for (const shade_kept *k = atomic_load(&g->kept); k; k = k->next) stats->bytes += k->bytes;
}

shade_gloss *ylm__shade_gloss_pick(const shade_gloss *g, size_t n, const size_t *point) {
  shade_gloss *out = ylm_alloc_zero(1, sizeof *out);
  if (!out) return NULL;
  out->meshes = g->meshes;
  out->slot = g->slot;
  out->tangent = g->tangent ? ylm_alloc(n, sizeof *out->tangent) : NULL;
  for (size_t i = 0; out->tangent && i < n; i++)
    memcpy(out->tangent[i], g->tangent[point[i]], sizeof *out->tangent);
  if (!g->tangent == !out->tangent) return out;
  ylm_free(out);
  return NULL;
}

void ylm__shade_gloss_drop(shade_gloss *g) {
  if (!g) return;
  ylm_free(g->tangent);
  ylm_free(g);
}

void ylm__shade_gloss_free(shade_gloss *g) {
  if (!g) return;
  for (shade_tables *t = atomic_load(&g->tables), *next; t; t = next) {
    next = t->next;
    tables_free(t);
  }
  for (shade_kept *k = atomic_load(&g->kept), *next; k; k = next) {
    next = k->next;
    kept_free(k);
  }
  for (plan *p = atomic_load(&g->plans), *next; p; p = next) {
    next = p->next;
    plan_free(p);
  }
  ylm_free(g->material);
  ylm_free(g->seen);
  ylm_free(g->slot);
  if (!g->before) ylm_free(g->tangent);
  ylm_free(g);
}
