/* unwrap.c - charts of meshes from beginning to end, and the meshes that they make. */
#include <math.h>
#include <stdlib.h>

#include "unwrap.h"

static const double radian = 3.14159265358979323846 / 180;

void ylm_unwrap_free(ylm_unwrap *u) {
  if (!u) return;
  for (size_t i = 0; i < u->charts; i++) ylm_free(u->chart[i].flat);
  ylm_free(u->first);
  ylm_free(u->vertices);
  ylm_free(u->index);
  ylm_free(u->corner);
  ylm_free(u->of);
  ylm_free(u->list);
  ylm_free(u->across);
  ylm_free(u->chart);
  ylm_free(u);
}

static ylm_status check(size_t meshes, const ylm_unwrap_mesh *mesh, const ylm_unwrap_form *f,
                        ylm_error *e) {
  size_t triangles = 0;
  if (!(f->angle >= 1 && f->angle <= 80))
    return ylm_fail(e, YLM_ERANGE, "angle must be from 1 to 80 degrees, got %g", f->angle);
  if (!(f->stretch >= 1.001 && f->stretch <= 10))
    return ylm_fail(e, YLM_ERANGE, "stretch must be from 1.001 to 10, got %g", f->stretch);
  for (size_t m = 0; m < meshes; m++) triangles += mesh[m].triangles;
  if (triangles == 0) return ylm_fail(e, YLM_EDOMAIN, "there is no triangle");
  if (triangles > YLM_MESH_MAX)
    return ylm_fail(e, YLM_ELIMIT, "%zu triangles are more than %zu", triangles, YLM_MESH_MAX);
  return YLM_OK;
}

/* Room for all triangles, and their vertices. */
static ylm_status begin(size_t meshes, const ylm_unwrap_mesh *mesh, ylm_unwrap *u) {
  u->meshes = meshes;
  u->first = ylm_alloc_zero(meshes + 1, sizeof *u->first);
  u->vertices = ylm_alloc_zero(meshes, sizeof *u->vertices);
  if (!u->first || !u->vertices) return YLM_ENOMEM;
  for (size_t m = 0; m < meshes; m++) {
    u->first[m + 1] = u->first[m] + mesh[m].triangles;
    u->vertices[m] = mesh[m].vertices;
  }
  size_t n = u->triangles = u->stats.triangles = u->first[meshes];
  u->index = ylm_alloc(3 * n, sizeof *u->index);
  u->corner = ylm_alloc(3 * n, sizeof *u->corner);
  u->of = ylm_alloc(n, sizeof *u->of);
  u->list = ylm_alloc(n, sizeof *u->list);
  u->across = ylm_alloc(3 * n, sizeof *u->across);
  if (!u->index || !u->corner || !u->of || !u->list || !u->across) return YLM_ENOMEM;
  for (size_t m = 0; m < meshes; m++)
    if (mesh[m].triangles)
      memcpy(u->index + 3 * u->first[m], mesh[m].index,
             3 * mesh[m].triangles * sizeof *mesh[m].index);
  return YLM_OK;
}

/* -- charts ------------------------------------------------------------------------------------------ */

typedef struct flattening {
  ylm_unwrap *u;
  const unwrap_surface *s;
  const uint32_t *chart; /* [n] to be flattened */
  bool *valid;           /* [n] */
} flattening;

static ylm_status flatten(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  flattening *f = context;
  ylm_status s = YLM_OK;
  for (size_t i = begin; s == YLM_OK && i < end; i++)
    s = ylm__unwrap_flatten(f->u, f->s, &f->u->chart[f->chart[i]], &f->valid[i]);
  return s;
}

/* Whether a chart stays: it is flat without overlap, stretched little, and no large one leaves most of its rectangle. */
static bool is_good(const unwrap_chart *c, bool valid, double stretch, double whole) {
  bool sparse = c->area > SPARSE_LEAST * whole && c->area < FILLED * c->size[0] * c->size[1];
  return valid && (c->triangles == 1 || (c->stretch <= stretch && !sparse));
}

/* Flattens the n charts of a list, and cuts those that fail: their parts are the next list. */
static ylm_status flatten_round(ylm_unwrap *u, const unwrap_surface *s, const ylm_unwrap_form *form,
                                uint32_t **list, size_t *n) {
  flattening f = {u, s, *list, ylm_alloc_zero(*n, sizeof(bool))};
  if (!f.valid) return YLM_ENOMEM;
  size_t before = u->charts, left = 0;
  ylm_status status = ylm_parallel(*n, 16, form->threads, flatten, &f, form->progress, "unwrap");
  for (size_t i = 0; status == YLM_OK && i < *n; i++) {
    uint32_t chart = (*list)[i];
    if (is_good(&u->chart[chart], f.valid[i], form->stretch, s->whole) ||
        u->chart[chart].triangles == 1)
      continue;
    ylm_free(u->chart[chart].flat);
    u->chart[chart].flat = NULL;
    status = ylm__unwrap_halve(u, s, chart);
    (*list)[left++] = chart;
  }
  ylm_free(f.valid);
  size_t more = u->charts - before;
  uint32_t *next = status == YLM_OK ? ylm_alloc(left + more, sizeof *next) : NULL;
  if (status != YLM_OK || !next) return status != YLM_OK ? status : YLM_ENOMEM;
  memcpy(next, *list, left * sizeof *next);
  for (size_t i = 0; i < more; i++) next[left + i] = (uint32_t)(before + i);
  ylm_free(*list);
  *list = next;
  *n = left + more;
  return YLM_OK;
}

static ylm_status flatten_all(ylm_unwrap *u, const unwrap_surface *s, const ylm_unwrap_form *form) {
  size_t n = u->charts;
  uint32_t *list = ylm_alloc(n, sizeof *list);
  ylm_status status = list ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; list && i < n; i++) list[i] = (uint32_t)i;
  while (status == YLM_OK && n) status = flatten_round(u, s, form, &list, &n);
  ylm_free(list);
  return status;
}

static void measure(ylm_unwrap *u) {
  double area = 0, square = 0;
  for (size_t i = 0; i < u->charts; i++) {
    const unwrap_chart *c = &u->chart[i];
    area += c->area;
    square += c->area * c->stretch * c->stretch;
    u->stats.worst = fmax(u->stats.worst, c->stretch);
    u->stats.curved += c->curved;
  }
  u->stats.charts = u->charts;
  u->stats.stretch = sqrt(square / area);
}

ylm_status ylm_unwrap_create(size_t meshes, const ylm_unwrap_mesh *mesh,
                             const ylm_unwrap_form *form, ylm_unwrap **out, ylm_error *e) {
  *out = NULL;
  ylm_status status = check(meshes, mesh, form, e);
  if (status != YLM_OK) return status;
  unwrap_surface s = {.label = form->label};
  ylm_unwrap *u = ylm_alloc_zero(1, sizeof *u);
  status = u ? begin(meshes, mesh, u) : YLM_ENOMEM;
  if (status == YLM_OK) status = ylm__unwrap_surface(meshes, mesh, u, &s, e);
  if (status == YLM_OK) status = ylm_report(form->progress, 0, 1, "unwrap");
  if (status == YLM_OK) status = ylm__unwrap_grow(u, &s, cos(form->angle * radian));
  if (status == YLM_OK) status = flatten_all(u, &s, form);
  ylm__unwrap_surface_free(&s);
  if (status == YLM_OK) {
    measure(u);
    *out = u;
  } else
    ylm_unwrap_free(u);
  return status;
}

/* -- what is asked ----------------------------------------------------------------------------------- */

void ylm_unwrap_look(const ylm_unwrap *u, ylm_unwrap_stats *stats) { *stats = u->stats; }

uint32_t ylm_unwrap_chart(const ylm_unwrap *u, size_t mesh, size_t triangle) {
  return u->of[u->first[mesh] + triangle];
}

bool ylm_unwrap_across(const ylm_unwrap *u, size_t mesh, size_t triangle, int edge,
                       size_t *triangle_across, int *edge_across) {
  size_t first = u->first[mesh];
  uint32_t other = u->across[3 * (first + triangle) + (size_t)edge];
  if (other == UNWRAP_NONE) return false;
  *triangle_across = other / 3 - first;
  *edge_across = (int)(other % 3);
  return true;
}

double ylm_unwrap_area(const ylm_unwrap *u, size_t chart) { return u->chart[chart].area; }

void ylm_unwrap_corners(const ylm_unwrap *u, size_t mesh, size_t triangle, double at[3][2]) {
  size_t t = u->first[mesh] + triangle;
  if (u->of[t] == UNWRAP_NONE) {
    for (int k = 0; k < 6; k++) at[k / 2][k % 2] = 0.5;
    return;
  }
  const unwrap_chart *c = &u->chart[u->of[t]];
  for (size_t k = 0; k < 3; k++) {
    unwrap_texel(c, c->flat[u->corner[3 * t + k]], at[k]);
    for (int a = 0; a < 2; a++) at[k][a] += (double)c->at[a];
  }
}

double ylm_unwrap_density(const ylm_unwrap *u, size_t chart) {
  return sqrt(u->chart[chart].scale[0] * u->chart[chart].scale[1]);
}

ylm_status ylm_unwrap_texels(const ylm_unwrap *u, uint32_t *chart) {
  for (size_t i = 0; i < u->width * u->height; i++) chart[i] = UNWRAP_NONE;
  for (size_t i = 0; i < u->charts; i++) {
    const unwrap_chart *c = &u->chart[i];
    unwrap_mask m;
    ylm_status s = ylm__unwrap_mask(u, c, &m);
    if (s != YLM_OK) return s;
    for (size_t y = 0; y < m.height; y++)
      for (size_t x = 0; x < m.width; x++)
        if (unwrap_is_set(&m, x, y)) chart[(c->at[1] + y) * u->width + c->at[0] + x] = (uint32_t)i;
    ylm_free(m.bit);
  }
  return YLM_OK;
}

/* -- meshes ------------------------------------------------------------------------------------------- */

/* A vertex of a mesh on a chart, as a corner has them. */
typedef struct joint {
  uint32_t vertex, chart, on, corner;
} joint;

static int by_joint(const void *a, const void *b) {
  const joint *p = a, *q = b;
  if (p->vertex != q->vertex) return p->vertex < q->vertex ? -1 : 1;
  if (p->chart != q->chart) return p->chart < q->chart ? -1 : 1;
  if (p->on != q->on) return p->on < q->on ? -1 : 1;
  return p->corner < q->corner ? -1 : p->corner > q->corner;
}

static bool is_one(const joint *a, const joint *b) {
  return a->vertex == b->vertex && a->chart == b->chart && a->on == b->on;
}

/* The joints of a mesh in order; how many differ. */
static size_t list_joints(const ylm_unwrap *u, size_t mesh, joint *list, size_t n) {
  size_t start = 3 * u->first[mesh], count = 0;
  for (size_t i = 0; i < n; i++) {
    uint32_t chart = u->of[(start + i) / 3];
    list[i] = (joint){u->index[start + i], chart, chart == UNWRAP_NONE ? 0 : u->corner[start + i],
                      (uint32_t)i};
  }
  qsort(list, n, sizeof *list, by_joint);
  for (size_t i = 0; i < n; i++) count += !i || !is_one(&list[i - 1], &list[i]);
  return count;
}

ylm_status ylm_unwrap_split(const ylm_unwrap *u, size_t mesh, size_t *vertices, uint32_t **from,
                            float **uv, uint32_t **index, ylm_error *e) {
  size_t n = 3 * (u->first[mesh + 1] - u->first[mesh]), count = 0;
  if (!u->width) return ylm_fail(e, YLM_EINVAL, "the charts are not packed yet");
  joint *list = ylm_alloc(n, sizeof *list);
  if (list) *vertices = list_joints(u, mesh, list, n);
  *from = list ? ylm_alloc(*vertices, sizeof **from) : NULL;
  *uv = list ? ylm_alloc(*vertices, 2 * sizeof **uv) : NULL;
  *index = list ? ylm_alloc(n, sizeof **index) : NULL;
  if (!*from || !*uv || !*index) {
    ylm_free(list), ylm_free(*from), ylm_free(*uv), ylm_free(*index);
    return ylm_no_memory(e);
  }
  for (size_t i = 0; i < n; i++) {
    if (!i || !is_one(&list[i - 1], &list[i])) {
      double at[3][2];
      ylm_unwrap_corners(u, mesh, list[i].corner / 3, at);
      (*uv)[2 * count] = (float)(at[list[i].corner % 3][0] / (double)u->width);
      (*uv)[2 * count + 1] = (float)(1 - at[list[i].corner % 3][1] / (double)u->height);
      (*from)[count++] = list[i].vertex;
    }
    (*index)[list[i].corner] = (uint32_t)count - 1;
  }
  ylm_free(list);
  return YLM_OK;
}
