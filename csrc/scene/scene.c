/* scene.c - meshes, materials and lamps, copied and traced; the surface at a place. */
#include <math.h>
#include <string.h>

#include "scene.h"
#include "ylm_sets.h"

static void normalise(float v[3]) {
  float d = sqrtf(ylm_dot3(v, v));
  for (int a = 0; a < 3; a++) v[a] = d > 0 ? v[a] / d : a == 2;
}

/* Twice the area times the normal of a triangle. */
static void triangle_normal(const float *p0, const float *p1, const float *p2, float n[3]) {
  float a[3], b[3];
  for (int k = 0; k < 3; k++) a[k] = p1[k] - p0[k], b[k] = p2[k] - p0[k];
  n[0] = a[1] * b[2] - a[2] * b[1];
  n[1] = a[2] * b[0] - a[0] * b[2];
  n[2] = a[0] * b[1] - a[1] * b[0];
}

/* How far rays start off a triangle and, as a part of the way to its middle, off its edges: four
   lifts and the rounding of positions. */
static scene_off off_of(const float *const p[3]) {
  double e[3][3], n[3], longest = 0, largest = 0, twice, lift = ylm_trace_lift(p), pull;
  for (int i = 0; i < 3; i++)
    for (int a = 0; a < 3; a++) {
      e[i][a] = (double)p[(i + 1) % 3][a] - (double)p[i][a];
      largest = fmax(largest, fabs((double)p[i][a]));
    }
  for (int i = 0; i < 3; i++) longest = fmax(longest, ylm_dot3d(e[i], e[i]));
  ylm_cross3d(e[0], e[1], n);
  twice = sqrt(ylm_dot3d(n, n));
  pull = 3 * sqrt(longest) * (4 * lift + 0x1p-22 * largest);
  return (scene_off){(float)lift, pull < twice / 2 ? (float)(pull / twice) : 0.5f};
}

/* Fills m->off and m->around. */
static void find_offs(scene_mesh *m) {
  for (size_t i = 0; i < m->vertices; i++) m->around[i] = UINT32_MAX;
  for (size_t i = 0; i < m->count; i++) {
    const uint32_t *t = &m->triangle[3 * i];
    const float *p[3];
    for (int k = 0; k < 3; k++) p[k] = &m->position[3 * (size_t)t[k]];
    m->off[i] = off_of(p);
    for (int k = 0; k < 3; k++) {
      uint32_t *most = &m->around[t[k]];
      if (*most == UINT32_MAX || m->off[i].lift > m->off[*most].lift) *most = (uint32_t)i;
    }
  }
}

/* Area-weighted means over the triangles around each vertex. */
static void mean_normals(scene_mesh *m) {
  memset(m->normal, 0, m->vertices * 12);
  for (size_t i = 0; i < m->count; i++) {
    const uint32_t *t = &m->triangle[3 * i];
    float n[3];
    triangle_normal(&m->position[3 * t[0]], &m->position[3 * t[1]], &m->position[3 * t[2]], n);
    for (int k = 0; k < 9; k++) m->normal[3 * t[k / 3] + k % 3] += n[k % 3];
  }
  for (size_t i = 0; i < m->vertices; i++) normalise(&m->normal[3 * i]);
}

static ylm_status copy_mesh(scene_mesh *m, size_t i, const ylm_scene_mesh *in, ylm_error *e) {
  size_t where;
  if (in->normals && !ylm_all_finite(YLM_FLOAT, in->normals, 3 * in->vertices, &where))
    return ylm_fail(e, YLM_EDOMAIN, "mesh %zu: normal %zu is not finite", i + 1, where / 3 + 1);
  if (in->uvs && !ylm_all_finite(YLM_FLOAT, in->uvs, 2 * in->vertices, &where))
    return ylm_fail(e, YLM_EDOMAIN, "mesh %zu: texture coordinate %zu is not finite", i + 1,
                    where / 2 + 1);
  m->vertices = in->vertices;
  m->count = in->count;
  m->material = ylm_material_keep(in->material);
  m->smooth = in->normals != NULL;
  m->occludes = in->occludes;
  m->position = ylm_alloc(in->vertices, 12);
  m->normal = ylm_alloc(in->vertices, 12);
  m->triangle = ylm_alloc(in->count, 12);
  m->uv = in->uvs ? ylm_alloc_copy(in->uvs, 2 * in->vertices, sizeof(float)) : NULL;
  m->around = ylm_alloc(in->vertices, sizeof *m->around);
  m->off = ylm_alloc(in->count, sizeof *m->off);
  if (!m->position || !m->normal || !m->triangle || !m->around || !m->off || (in->uvs && !m->uv))
    return YLM_ENOMEM;
  memcpy(m->position, in->positions, in->vertices * 12);
  memcpy(m->triangle, in->triangles, in->count * 12);
  find_offs(m);
  if (!m->smooth)
    mean_normals(m);
  else {
    memcpy(m->normal, in->normals, in->vertices * 12);
    for (size_t k = 0; k < m->vertices; k++) normalise(&m->normal[3 * k]);
  }
  return ylm__scene_copy_tint(m, i, in, e);
}

static float luminance_of(const float *c) {
  return (float)YLM_LUMINANCE_R * fabsf(c[0]) + (float)YLM_LUMINANCE_G * fabsf(c[1]) +
         (float)YLM_LUMINANCE_B * fabsf(c[2]);
}

static ylm_status copy_lamps(ylm_scene *s, const ylm_scene_lamps *l, ylm_error *e) {
  const ylm_trace_lamps *shape = &l->shape;
  size_t count = shape->spheres, patches = shape->triangles + shape->disks, where;
  size_t padded = (count + YLM_LAMP_CHUNK - 1) / YLM_LAMP_CHUNK * YLM_LAMP_CHUNK;
  if (!ylm_all_finite(YLM_FLOAT, l->radiance, 3 * (count + patches), &where))
    return ylm_fail(e, YLM_EDOMAIN, "the radiance of lamp %zu is not finite", where / 3 + 1);
  for (int a = 0; a < 4; a++)
    if (!(s->lamp[a] = ylm_alloc_zero(padded, sizeof(float)))) return YLM_ENOMEM;
  s->lamp_luminance = ylm_alloc_zero(padded, sizeof(float));
  s->lamp_radiance = ylm_alloc_copy(l->radiance, 3 * (count + patches), sizeof(float));
  s->triangle = ylm_alloc_copy(shape->triangle, 9 * shape->triangles, sizeof(float));
  s->disk = ylm_alloc_copy(shape->disk, 7 * shape->disks, sizeof(float));
  s->patch_luminance = ylm_alloc(patches, sizeof(float));
  if (l->horizon) {
    s->horizon = ylm_alloc_copy(l->horizon, 3 * patches, sizeof(float));
    if (!s->horizon) return YLM_ENOMEM;
  }
  if (!s->lamp_luminance || !s->lamp_radiance || !s->triangle || !s->disk || !s->patch_luminance)
    return YLM_ENOMEM;
  s->lamps = count;
  s->triangles = shape->triangles;
  s->disks = shape->disks;
  for (size_t i = 0; i < count; i++) {
    for (int a = 0; a < 4; a++) s->lamp[a][i] = shape->sphere[4 * i + a];
    s->lamp_luminance[i] = luminance_of(&l->radiance[3 * i]);
  }
  for (size_t i = 0; i < patches; i++)
    s->patch_luminance[i] = luminance_of(&l->radiance[3 * (count + i)]);
  ylm_status status = ylm__scene_copy_directed(s, l);
  return status == YLM_OK ? ylm__scene_copy_textures(s, l, e) : status;
}

void ylm_scene_origin_of(size_t meshes, const ylm_scene_mesh *mesh, double origin[3]) {
  double box[6] = {0};
  bool any = false;
  for (size_t i = 0; i < meshes; i++)
    for (size_t k = 0; k < mesh[i].vertices; k++, any = true)
      for (size_t a = 0; a < 3; a++) {
        double x = (double)mesh[i].positions[3 * k + a] + (mesh[i].origin ? mesh[i].origin[a] : 0);
        box[a] = any && box[a] < x ? box[a] : x;
        box[a + 3] = any && box[a + 3] > x ? box[a + 3] : x;
      }
  ylm_origin(box, origin);
}

/* Positions of a mesh relative to the scene's origin, new if they are relative to another one. */
static ylm_status lay(ylm_scene_mesh *m, const double origin[3], float **positions) {
  double way[3];
  for (int a = 0; a < 3; a++) way[a] = (m->origin ? m->origin[a] : 0) - origin[a];
  if (way[0] == 0 && way[1] == 0 && way[2] == 0) return YLM_OK;
  float *x = *positions = ylm_alloc(m->vertices, 3 * sizeof *x);
  if (!x) return YLM_ENOMEM;
  for (size_t i = 0; i < 3 * m->vertices; i++) x[i] = (float)((double)m->positions[i] + way[i % 3]);
  m->positions = x;
  return YLM_OK;
}

static void free_laid(size_t meshes, ylm_scene_mesh *mesh, float **positions) {
  for (size_t i = 0; positions && i < meshes; i++) ylm_free(positions[i]);
  ylm_free(positions);
  ylm_free(mesh);
}

/* Meshes relative to the scene's origin, and the positions that are new; to be freed in any case. */
static ylm_status lay_meshes(const ylm_scene *s, size_t meshes, const ylm_scene_mesh *mesh,
                             ylm_scene_mesh **laid, float ***positions) {
  *laid = ylm_alloc_copy(mesh, meshes, sizeof *mesh);
  *positions = ylm_alloc_zero(meshes, sizeof **positions);
  ylm_status status = *laid && *positions ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; status == YLM_OK && i < meshes; i++)
    status = lay(*laid + i, s->origin, *positions + i);
  return status;
}

static ylm_status trace_scene(ylm_scene *s, size_t meshes, const ylm_scene_mesh *mesh,
                              const ylm_scene_lamps *lamps, ylm_error *e) {
  ylm_trace_mesh *m = ylm_alloc(meshes, sizeof *m);
  if (!m) return YLM_ENOMEM;
  for (size_t i = 0; i < meshes; i++)
    m[i] = (ylm_trace_mesh){mesh[i].positions, mesh[i].vertices, mesh[i].triangles, mesh[i].count,
                            mesh[i].occludes};
  ylm_status status = ylm_trace_create(meshes, m, &lamps->shape, &s->trace, e);
  ylm_free(m);
  return status;
}

ylm_status ylm_scene_trace_mesh(const ylm_scene *s, size_t m, ylm_trace **out, ylm_error *e) {
  const scene_mesh *x = &s->mesh[m];
  ylm_trace_mesh mesh = {x->position, x->vertices, x->triangle, x->count, x->occludes};
  return ylm_trace_create(1, &mesh, &(ylm_trace_lamps){0}, out, e);
}

/* Copies meshes; to be freed in any case. */
static ylm_status share_meshes(size_t meshes, const ylm_scene_mesh *mesh, scene_meshes **shared,
                               ylm_error *e) {
  scene_meshes *m = *shared = ylm_alloc_zero(1, sizeof *m);
  if (!m) return YLM_ENOMEM;
  m->references = 1;
  if (!(m->mesh = ylm_alloc_zero(meshes, sizeof *m->mesh))) return YLM_ENOMEM;
  for (; m->meshes < meshes; m->vertices += mesh[m->meshes++].vertices) {
    scene_mesh *to = &m->mesh[m->meshes];
    to->first_vertex = m->vertices;
    ylm_status s = copy_mesh(to, m->meshes, &mesh[m->meshes], e);
    if (s == YLM_OK) continue;
    m->meshes++;
    return s;
  }
  if (m->vertices > UINT32_MAX / 2)
    return ylm_fail(e, YLM_EOVERFLOW, "the scene has more than 2^31 vertices");
  return YLM_OK;
}

static void free_meshes(scene_meshes *m) {
  if (!m || atomic_fetch_sub(&m->references, 1) > 1) return;
  for (size_t i = 0; i < m->meshes; i++) {
    ylm_free(m->mesh[i].position);
    ylm_free(m->mesh[i].normal);
    ylm_free(m->mesh[i].around);
    ylm_free(m->mesh[i].off);
    ylm_free(m->mesh[i].uv);
    ylm_free(m->mesh[i].triangle);
    ylm_material_free(m->mesh[i].material);
    ylm__scene_free_tint(&m->mesh[i]);
  }
  ylm_free(m->mesh);
  ylm_free(m);
}

static void take_meshes(ylm_scene *s, scene_meshes *shared) {
  s->shared = shared;
  s->mesh = shared->mesh;
  s->meshes = shared->meshes;
  s->vertices = shared->vertices;
}

/* Everything that is made of lamps; `from`: a scene that may have the same sky, or NULL. */
static ylm_status light(ylm_scene *s, const ylm_scene_lamps *lamps, const ylm_scene *from,
                        ylm_error *e) {
  ylm_status status = copy_lamps(s, lamps, e);
  if (status == YLM_OK) status = ylm__scene_make_far(s);
  if (status == YLM_OK) status = ylm__scene_plant(s, lamps->one_by_one);
  if (status == YLM_OK) status = ylm__scene_copy_points(s, lamps);
  return status == YLM_OK ? ylm__scene_share_sky(s, lamps, from) : status;
}

/* Gives the scene to *out, or frees it. */
static ylm_status deliver(ylm_status status, ylm_scene *s, ylm_scene **out) {
  if (status == YLM_OK)
    *out = s;
  else
    ylm_scene_free(s);
  return status;
}

ylm_status ylm_scene_create(size_t meshes, const ylm_scene_mesh *mesh, const ylm_scene_lamps *lamps,
                            ylm_scene **scene, ylm_error *e) {
  *scene = NULL;
  ylm_scene *s = ylm_alloc_zero(1, sizeof *s);
  if (!s) return YLM_ENOMEM;
  scene_meshes *shared = NULL;
  ylm_scene_mesh *laid;
  float **positions;
  ylm_scene_origin_of(meshes, mesh, s->origin);
  ylm_status status = lay_meshes(s, meshes, mesh, &laid, &positions);
  if (status == YLM_OK)
    status = trace_scene(s, meshes, laid, lamps, e); /* checks positions, indices */
  if (status == YLM_OK) status = share_meshes(meshes, laid, &shared, e);
  free_laid(meshes, laid, positions);
  if (shared) take_meshes(s, shared);
  if (status == YLM_OK) status = light(s, lamps, NULL, e);
  return deliver(status, s, scene);
}

ylm_status ylm_scene_relight(const ylm_scene *from, const ylm_scene_lamps *lamps, ylm_scene **scene,
                             ylm_error *e) {
  *scene = NULL;
  ylm_scene *s = ylm_alloc_zero(1, sizeof *s);
  if (!s) return YLM_ENOMEM;
  atomic_fetch_add(&from->shared->references, 1);
  take_meshes(s, from->shared);
  memcpy(s->origin, from->origin, sizeof s->origin);
  ylm_status status = ylm_trace_relight(from->trace, &lamps->shape, &s->trace, e);
  if (status == YLM_OK) status = light(s, lamps, from, e);
  return deliver(status, s, scene);
}

void ylm_scene_free(ylm_scene *s) {
  if (!s) return;
  ylm_trace_free(s->trace);
  free_meshes(s->shared);
  for (int a = 0; a < 4; a++) ylm_free(s->lamp[a]);
  ylm_free(s->lamp_luminance);
  ylm_free(s->lamp_radiance);
  ylm_free(s->triangle);
  ylm_free(s->disk);
  ylm_free(s->patch_luminance);
  ylm_free(s->horizon);
  ylm_free(s->far);
  ylm__scene_free_tree(s);
  ylm__scene_free_textures(s);
  ylm__scene_free_directed(s);
  ylm__scene_free_sky(s);
  ylm__scene_free_points(s);
  ylm_free(s);
}

const double *ylm_scene_origin(const ylm_scene *s) {
  const double *o = s->origin;
  return o[0] != 0 || o[1] != 0 || o[2] != 0 ? o : NULL;
}

void ylm_scene_enter(const ylm_scene *s, const double world[3], float x[3]) {
  for (int a = 0; a < 3; a++) x[a] = (float)(world[a] - s->origin[a]);
}

void ylm_scene_leave(const ylm_scene *s, const float x[3], double world[3]) {
  for (int a = 0; a < 3; a++) world[a] = (double)x[a] + s->origin[a];
}

void ylm_scene_bounds(const ylm_scene *s, double lo[3], double hi[3]) {
  float a[3], b[3];
  ylm_trace_bounds(s->trace, a, b);
  for (int k = 0; k < 3; k++) lo[k] = a[k], hi[k] = b[k];
}

size_t ylm_scene_vertices(const ylm_scene *s, float *out) {
  for (size_t i = 0; out && i < s->meshes; i++)
    memcpy(out + 3 * s->mesh[i].first_vertex, s->mesh[i].position, s->mesh[i].vertices * 12);
  return s->vertices;
}

const ylm_trace *ylm_scene_trace(const ylm_scene *s) { return s->trace; }

size_t ylm_scene_meshes(const ylm_scene *s) { return s->meshes; }

const ylm_material *ylm_scene_material(const ylm_scene *s, size_t m) { return s->mesh[m].material; }

const uint32_t *ylm_scene_triangle(const ylm_scene *s, size_t m, size_t element) {
  return &s->mesh[m].triangle[3 * element];
}

size_t ylm_scene_triangles(const ylm_scene *s, size_t m) { return s->mesh[m].count; }

bool ylm_scene_occludes(const ylm_scene *s, size_t m) { return s->mesh[m].occludes; }

size_t ylm_scene_first_vertex(const ylm_scene *s, size_t m) {
  return m < s->meshes ? s->mesh[m].first_vertex : s->vertices;
}

/* A place of a triangle, by the weights of its second and third corner. */
typedef struct corners {
  const float *p[3];
  float u, v, edge[2][3]; /* from the first corner to the others */
  scene_off off;
} corners;

static inline void look_at(const scene_mesh *m, const ylm_scene_place *e, corners *c) {
  const uint32_t *t = &m->triangle[3 * e->element];
  c->u = e->u, c->v = e->v;
  c->off = m->off[e->element];
  for (int i = 0; i < 3; i++) c->p[i] = &m->position[3 * (size_t)t[i]];
  for (int i = 0; i < 2; i++)
    for (int a = 0; a < 3; a++) c->edge[i][a] = c->p[i + 1][a] - c->p[0][a];
}

/* The unit normal on the side that is seen. */
static inline void flat_of(const corners *c, bool back, float flat[3]) {
  const float *a = c->edge[0], *b = c->edge[1], side = back ? -1 : 1;
  flat[0] = side * (a[1] * b[2] - a[2] * b[1]);
  flat[1] = side * (a[2] * b[0] - a[0] * b[2]);
  flat[2] = side * (a[0] * b[1] - a[1] * b[0]);
  normalise(flat);
}

/* From a place of the flat triangle to the surface that the corners' normals describe. */
static inline void leave_triangle(const corners *c, const float *const normal[3],
                                  const float weight[3], float side, float way[3]) {
  for (int i = 0; i < 3; i++) {
    float below = 0, u = c->u - (float)(i == 1), v = c->v - (float)(i == 2);
    for (int a = 0; a < 3; a++)
      below += (u * c->edge[0][a] + v * c->edge[1][a]) * normal[i][a] * side;
    for (int a = 0; below < 0 && a < 3; a++) way[a] -= weight[i] * below * normal[i][a] * side;
  }
}

/* Where u grows on a triangle with corners p, as a part of the plane across n; else any direction
   in it. Source: Lengyel 2001, "Computing Tangent Space Basis Vectors for an Arbitrary Mesh". */
static void find_tangent(const scene_mesh *m, const uint32_t *t, const float *const p[3],
                         const float n[3], float tangent[3]) {
  float other[3], d[3] = {0, 0, 0}, along, length;
  if (m->uv) {
    const float *a = m->uv + 2 * t[0], *b = m->uv + 2 * t[1], *c = m->uv + 2 * t[2];
    float area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
    float side = area < 0 ? -1 : 1;
    for (int k = 0; k < 3; k++)
      d[k] = side * ((c[1] - a[1]) * (p[1][k] - p[0][k]) - (b[1] - a[1]) * (p[2][k] - p[0][k]));
  }
  along = ylm_dot3(d, n);
  for (int k = 0; k < 3; k++) tangent[k] = d[k] - along * n[k];
  length = sqrtf(ylm_dot3(tangent, tangent));
  if (!(length > 0)) {
    ylm_scene_basis(n, tangent, other);
    return;
  }
  for (int k = 0; k < 3; k++) tangent[k] /= length;
}

/* The place, as exact as double is. */
static inline void place_of(const corners *c, double u, double v, double at[3]) {
  for (int a = 0; a < 3; a++) {
    double p = (double)c->p[0][a];
    at[a] = p + u * ((double)c->p[1][a] - p) + v * ((double)c->p[2][a] - p);
  }
}

/* Where rays start that leave the place `at` of a triangle by `way`, on the side of its normal. Near an
   edge they start inside of it, so that rounding does not carry them through a wall that stands there. */
static inline void lift_off(const corners *c, const double at[3], const float way[3],
                            const float flat[3], float origin[3]) {
  double from[3] = {at[0], at[1], at[2]};
  float pull = c->off.pull, third = 1.f / 3;
  if (c->u < pull || c->v < pull || 1 - c->u - c->v < pull)
    place_of(c, (double)(c->u + pull * (third - c->u)), (double)(c->v + pull * (third - c->v)),
             from);
  for (int a = 0; a < 3; a++)
    origin[a] = ylm_away(from[a] + (double)(way[a] + c->off.lift * flat[a]), flat[a]);
}

/* The surface at one place. Vectors stay in registers until they are whole: a load of what was just stored
   in parts waits for the parts. */
static void surface(const ylm_scene *s, const ylm_scene_place *e, ylm_scene_surface *out) {
  const scene_mesh *m = &s->mesh[e->mesh];
  const uint32_t *t = &m->triangle[3 * e->element];
  const float *n[3], w[3] = {1 - e->u - e->v, e->u, e->v};
  float flat[3], normal[3], way[3] = {0, 0, 0}, origin[3], tangent[3];
  corners c;
  look_at(m, e, &c);
  flat_of(&c, e->back, flat);
  for (int i = 0; i < 3; i++) n[i] = &m->normal[3 * (size_t)t[i]];
  for (int a = 0; a < 3; a++) normal[a] = flat[a];
  if (m->smooth) {
    float mean[3];
    for (int a = 0; a < 3; a++) mean[a] = w[0] * n[0][a] + w[1] * n[1][a] + w[2] * n[2][a];
    float turn = ylm_dot3(mean, flat) < 0 ? -1 : 1; /* normals count, not the winding */
    if (ylm_dot3(mean, mean) > 0) {
      for (int a = 0; a < 3; a++) normal[a] = mean[a] * turn;
      normalise(normal);
      leave_triangle(&c, n, w, turn, way);
    }
  }
  double at[3];
  place_of(&c, (double)e->u, (double)e->v, at);
  lift_off(&c, at, way, flat, origin);
  find_tangent(m, t, c.p, normal, tangent);
  for (int a = 0; a < 3; a++) {
    out->position[a] = (float)at[a], out->lit[a] = (float)(at[a] + (double)way[a]);
    out->normal[a] = normal[a], out->origin[a] = origin[a];
    out->flat[a] = flat[a], out->tangent[a] = tangent[a];
  }
  out->material = m->material;
  ylm__scene_tint(m, t, w, out->tint);
}

YLM_KERNEL_CHOICE(ylm_scene_lanes_fn, ylm__scene_lanes, ylm_k_scene_lanes, NULL);

static inline void put_lane(const ylm_scene *s, const ylm_scene_place *e, size_t k,
                            scene_lanes *to) {
  static const float none[3] = {0, 0, 0};
  const scene_mesh *m = &s->mesh[e->mesh];
  const uint32_t *t = &m->triangle[3 * e->element];
  for (int i = 0; i < 3; i++) {
    const float *p = &m->position[3 * (size_t)t[i]];
    const float *n = m->smooth ? &m->normal[3 * (size_t)t[i]] : none;
    const float *uv = m->uv ? &m->uv[2 * (size_t)t[i]] : none;
    for (int a = 0; a < 3; a++) to->p[i][a][k] = p[a], to->n[i][a][k] = n[a];
    for (int a = 0; a < 2; a++) to->uv[i][a][k] = uv[a];
  }
  to->u[k] = e->u, to->v[k] = e->v;
  to->side[k] = e->back ? -1 : 1;
  to->lift[k] = m->off[e->element].lift, to->pull[k] = m->off[e->element].pull;
}

static inline void take_lane(const ylm_scene *s, const ylm_scene_place *e, size_t k,
                             const scene_lanes *from, ylm_scene_surface *out) {
  const scene_mesh *m = &s->mesh[e->mesh];
  const uint32_t *t = &m->triangle[3 * e->element];
  for (int a = 0; a < 3; a++) {
    out->position[a] = from->position[a][k], out->lit[a] = from->lit[a][k];
    out->normal[a] = from->normal[a][k], out->origin[a] = from->origin[a][k];
    out->flat[a] = from->flat[a][k], out->tangent[a] = from->tangent[a][k];
  }
  out->material = m->material;
  ylm__scene_tint(m, t, (const float[3]){1 - e->u - e->v, e->u, e->v}, out->tint);
}

void ylm_scene_surfaces(const ylm_scene *s, size_t n, const ylm_scene_place *p,
                        ylm_scene_surface *out) {
  ylm_scene_lanes_fn *lanes = n < SURFACES_FEW ? NULL : ylm__scene_lanes();
  scene_lanes block;
  for (size_t i = 0; !lanes && i < n; i++) surface(s, &p[i], &out[i]);
  for (size_t i = 0; lanes && i < n; i += SCENE_LANES) {
    size_t count = n - i < SCENE_LANES ? n - i : SCENE_LANES;
    for (size_t k = 0; k < SCENE_LANES; k++) put_lane(s, &p[k < count ? i + k : i], k, &block);
    lanes(count, &block);
    for (size_t k = 0; k < count; k++) take_lane(s, &p[i + k], k, &block, &out[i + k]);
  }
}

/* By Cramer's rule. */
bool ylm_scene_cross(const ylm_scene *s, const ylm_scene_place *p, const ylm_trace_ray *ray,
                     ylm_scene_place *out) {
  corners c;
  double d[3], a[3], b[3], from[3], over[3], across[3];
  look_at(&s->mesh[p->mesh], p, &c);
  for (int k = 0; k < 3; k++) {
    d[k] = (double)ray->dir[k];
    a[k] = (double)c.p[1][k] - (double)c.p[0][k];
    b[k] = (double)c.p[2][k] - (double)c.p[0][k];
    from[k] = (double)ray->org[k] - (double)c.p[0][k];
  }
  ylm_cross3d(d, b, over);
  ylm_cross3d(from, a, across);
  double scale = ylm_dot3d(a, over);
  if (scale == 0) return false;
  double u = ylm_dot3d(from, over) / scale, v = ylm_dot3d(d, across) / scale;
  *out = *p;
  out->u = (float)u, out->v = (float)v;
  return u >= 0 && v >= 0 && u + v <= 1;
}

/* Where rays start at a vertex: above all its triangles, to which the normal may be aslant. */
static void leave_vertex(const scene_mesh *m, size_t vertex, const float normal[3],
                         float origin[3]) {
  uint32_t around = m->around[vertex];
  corners c;
  memcpy(origin, &m->position[3 * vertex], 12);
  if (around == UINT32_MAX) return;
  const uint32_t *t = &m->triangle[3 * (size_t)around];
  ylm_scene_place place = {.element = around, .u = t[1] == vertex, .v = t[2] == vertex};
  look_at(m, &place, &c);
  c.off.lift *= 4;
  double at[3];
  place_of(&c, (double)c.u, (double)c.v, at);
  lift_off(&c, at, (const float[3]){0, 0, 0}, normal, origin);
}

void ylm_scene_vertex(const ylm_scene *s, size_t mesh, size_t vertex, bool back,
                      ylm_scene_surface *out) {
  const scene_mesh *m = &s->mesh[mesh];
  float side = back ? -1 : 1;
  for (int a = 0; a < 3; a++) {
    out->position[a] = out->lit[a] = m->position[3 * vertex + a];
    out->normal[a] = out->flat[a] = side * m->normal[3 * vertex + a];
  }
  leave_vertex(m, vertex, out->normal, out->origin);
  float other[3];
  ylm_scene_basis(out->normal, out->tangent, other);
  out->material = m->material;
  ylm__scene_tint(m, (uint32_t[3]){(uint32_t)vertex, (uint32_t)vertex, (uint32_t)vertex},
                  (float[3]){1, 0, 0}, out->tint);
}

void ylm_scene_ray_origin(const ylm_scene *s, const float x[3], const float normal[3],
                          float origin[3]) {
  ylm_trace_hit h;
  corners c;
  float flat[3];
  memcpy(origin, x, 12);
  if (!ylm_trace_touch(s->trace, x, normal, &h)) return;
  look_at(&s->mesh[h.mesh], &(ylm_scene_place){.element = h.element, .u = h.u, .v = h.v}, &c);
  flat_of(&c, ylm_dot3(h.normal, normal) < 0, flat);
  double at[3];
  place_of(&c, (double)c.u, (double)c.v, at);
  lift_off(&c, at, (const float[3]){0, 0, 0}, flat, origin);
}
