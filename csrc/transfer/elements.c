/* elements.c - surfaces cut into elements, and the element at a place. */
#include <math.h>

#include "calibration.h"
#include "transfer.h"

/* Corners of triangle i of mesh m. */
static void corners_of(const ylm_scene *s, const float *positions, size_t m, size_t i,
                       double p[3][3]) {
  const uint32_t *t = ylm_scene_triangle(s, m, i);
  const float *of = positions + 3 * ylm_scene_first_vertex(s, m);
  for (int k = 0; k < 9; k++) p[k / 3][k % 3] = (double)of[3 * t[k / 3] + k % 3];
}

static double area_of(double p[3][3]) {
  double a[3], b[3], n[3];
  for (int k = 0; k < 3; k++) a[k] = p[1][k] - p[0][k], b[k] = p[2][k] - p[0][k];
  for (int k = 0; k < 3; k++)
    n[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
  return sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) / 2;
}

static void find_shapes(const ylm_transfer *t, const float *positions, transfer_shape *shape) {
  for (size_t m = 0; m < t->meshes; m++)
    for (size_t i = 0; i < t->first[m + 1] - t->first[m]; i++) {
      double p[3][3];
      corners_of(t->scene, positions, m, i, p);
      shape[t->first[m] + i] = ylm__cut_shape(p);
    }
}

static void keep_feet(ylm_transfer *t, const transfer_shape *shape) {
  for (size_t i = 0; i < t->triangles; i++) t->foot[i] = shape[i].foot;
}

static double diagonal_of(double lo[3], double hi[3]) {
  double square = 0;
  for (int a = 0; a < 3; a++) square += (hi[a] - lo[a]) * (hi[a] - lo[a]);
  return sqrt(square);
}

/* Finds the grounds, and the part of their area that counts: that of the largest face of the box of what stands on them, whose
   diagonal over that of all is *core. */
static ylm_status find_grounds(ylm_transfer *t, size_t places, const float (*place)[3],
                               const float *positions, double *core) {
  double lo[3], hi[3], least = INFINITY, face = 1, area = 0;
  uint8_t *ground = ylm_alloc(t->triangles ? t->triangles : 1, 1);
  if (!ground) return YLM_ENOMEM;
  ylm_scene_bounds(t->scene, lo, hi);
  double all = diagonal_of(lo, hi);
  ylm_status s = ylm_scene_core(t->scene, places, place, lo, hi, ground);
  *core = all > 0 ? diagonal_of(lo, hi) / all : 1;
  for (int a = 0; a < 3; a++) face *= hi[a] - lo[a], least = fmin(least, hi[a] - lo[a]);
  for (size_t m = 0; s == YLM_OK && m < t->meshes; m++)
    for (size_t i = t->first[m]; i < t->first[m + 1]; i++) {
      double p[3][3];
      if (!ground[i]) continue;
      corners_of(t->scene, positions, m, i - t->first[m], p);
      area += area_of(p);
    }
  if (s == YLM_OK && area > 0) {
    t->ground = ground;
    t->ground_share = fmin(1, face / least / area);
    return s;
  }
  ylm_free(ground);
  return s;
}

/* Triangles of grounds become smaller, as if all were no wider than what stands on them. */
static void shorten_grounds(const ylm_transfer *t, double core, transfer_shape *shape) {
  for (size_t i = 0; t->ground && i < t->triangles; i++)
    if (t->ground[i] && shape[i].edge > 0) ylm__cut_scale(&shape[i], (float)core);
}

double ylm_transfer_ground_share(const ylm_transfer *t, size_t mesh, size_t triangle) {
  return t->ground && t->ground[t->first[mesh] + triangle] ? t->ground_share : 1;
}

static int sides_of(const ylm_transfer *t, size_t m) {
  return (t->side[m] & TRANSFER_FRONT ? 1 : 0) + (t->side[m] & TRANSFER_BACK ? 1 : 0);
}

/* How many elements a spacing makes. */
static double count_at(const ylm_transfer *t, const transfer_shape *shape, double spacing) {
  double n = 0;
  for (size_t m = 0; m < t->meshes; m++) {
    double one = 0;
    for (size_t i = t->first[m]; i < t->first[m + 1]; i++)
      one += ylm__cut_number(&shape[i], spacing);
    n += one * sides_of(t, m);
  }
  return n;
}

static ylm_status too_many(const ylm_transfer *t, const transfer_shape *shape, double spacing,
                           double most, ylm_error *e) {
  double n = count_at(t, shape, spacing), least = count_at(t, shape, INFINITY), wider = spacing;
  if (least > most)
    return ylm_fail(e, YLM_ELIMIT,
                    "max_elements = %.0f is less than the sides of the scene's triangles, %.0f",
                    most, least);
  for (double step = 1; count_at(t, shape, wider) > most && step < 200; step++)
    wider *= count_at(t, shape, wider) > 4 * most ? 2 : 1.1;
  double unit = pow(10, floor(log10(wider)) - 1);
  wider = ceil(wider / unit - 1e-9) * unit;
  return ylm_fail(e, YLM_ELIMIT,
                  "spacing = %g would make %.2g elements; spacing %g makes %.2g (at most "
                  "max_elements = %.0f)",
                  spacing, n, wider, count_at(t, shape, wider), most);
}

/* Settles t->form.spacing; `core`: of find_grounds. */
static ylm_status choose_spacing(ylm_transfer *t, double core, transfer_shape *shape,
                                 ylm_error *e) {
  double most = (double)t->form.max_elements;
  if (t->form.spacing == 0) {
    double lo[3], hi[3];
    ylm_scene_bounds(t->scene, lo, hi);
    double wide = core * diagonal_of(lo, hi);
    shorten_grounds(t, core, shape);
    t->form.spacing = wide > 0 ? wide / 100 : 1;
    if (count_at(t, shape, INFINITY) <= most)
      while (count_at(t, shape, t->form.spacing) > most) t->form.spacing *= 1.05;
  }
  double k = 0;
  for (size_t i = 0; i < t->triangles; i++)
    k = fmax(k, ylm__cut_pieces(&shape[i], t->form.spacing));
  if (count_at(t, shape, t->form.spacing) > most || k > TRANSFER_CUT)
    return too_many(t, shape, t->form.spacing, most, e);
  return YLM_OK;
}

/* Numbers the elements, whose cuts are known; how many there are. */
static size_t number(ylm_transfer *t) {
  size_t n = 0;
  for (size_t m = 0; m < t->meshes; m++)
    for (size_t i = t->first[m]; i < t->first[m + 1]; i++) {
      size_t size = ylm__cut_size(&t->cut[i]);
      for (int side = 0; side < 2; side++) {
        bool used = size > 0 && (t->side[m] & (side ? TRANSFER_BACK : TRANSFER_FRONT));
        t->start[i][side] = used ? (uint32_t)n : TRANSFER_NONE;
        if (used) n += size;
      }
    }
  return n;
}

/* Cuts triangles of these shapes. */
static void cut(ylm_transfer *t, const transfer_shape *shape) {
  for (size_t m = 0; m < t->meshes; m++)
    for (size_t i = t->first[m]; i < t->first[m + 1]; i++) {
      t->cut[i] = ylm__cut_of(&shape[i], t->form.spacing);
      if (t->side[m] && ylm__cut_size(&t->cut[i]) == 0) t->stats.degenerate++;
    }
}

void ylm__transfer_corners(const ylm_transfer *t, size_t e, ylm_scene_place *place,
                           float corner[3][2]) {
  size_t of = t->first[t->mesh[e]] + t->triangle[e];
  bool back = ylm__transfer_is_back(t, e);
  ylm__cut_corners(&t->cut[of], t->foot[of], e - t->start[of][back], corner);
  *place = (ylm_scene_place){.mesh = t->mesh[e], .element = t->triangle[e], .back = back};
}

/* The mean tint of an element. */
static void tint_of(const ylm_transfer *t, ylm_scene_place place, float corner[3][2],
                    float tint[3]) {
  double sum[3] = {0, 0, 0}, x = 0.5, y = 0.5;
  for (int k = 0; k < TRANSFER_TINTS; k++) {
    ylm_scene_surface at;
    x += 0.7548776662466927, y += 0.5698402909980532;
    x -= floor(x), y -= floor(y);
    ylm__transfer_inside(corner, x, y, &place);
    ylm_scene_surfaces(t->scene, 1, &place, &at);
    for (int c = 0; c < 3; c++) sum[c] += (double)at.tint[c];
  }
  for (int c = 0; c < 3; c++) tint[c] = (float)(sum[c] / TRANSFER_TINTS);
}

typedef struct job {
  ylm_transfer *t;
  const float *positions;
  bool tinted;
} job;

/* Describes elements begin .. end-1, whose mesh and triangle are known. */
static ylm_status describe(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  ylm_transfer *t = j->t;
  for (size_t e = begin; e < end; e++) {
    ylm_scene_place place;
    ylm_scene_surface at;
    float corner[3][2], tint[3] = {1, 1, 1};
    double p[3][3];
    ylm__transfer_corners(t, e, &place, corner);
    place.u = (corner[0][0] + corner[1][0] + corner[2][0]) / 3;
    place.v = (corner[0][1] + corner[1][1] + corner[2][1]) / 3;
    ylm_scene_surfaces(t->scene, 1, &place, &at);
    memcpy(t->centre[e], at.position, 12);
    memcpy(t->normal[e], at.normal, 12);
    corners_of(t->scene, j->positions, place.mesh, place.element, p);
    const transfer_cut *cut = &t->cut[t->first[place.mesh] + place.element];
    double part = cut->columns ? ylm__cut_share(corner) : 1.0 / ((double)cut->k * cut->k);
    t->area[e] = (float)(area_of(p) * part);
    ylm_material_albedo(at.material, t->albedo[e]);
    if (j->tinted) tint_of(t, place, corner, tint);
    for (int c = 0; c < 3; c++) t->albedo[e][c] *= tint[c];
  }
  return YLM_OK;
}

static ylm_status make(ylm_transfer *t, const float *positions, const ylm_progress *progress) {
  size_t n = t->elements;
  t->stats.elements = n;
  t->centre = ylm_alloc(n, sizeof *t->centre);
  t->normal = ylm_alloc(n, sizeof *t->normal);
  t->area = ylm_alloc(n, sizeof *t->area);
  t->albedo = ylm_alloc(n, sizeof *t->albedo);
  t->mesh = ylm_alloc(n, sizeof *t->mesh);
  t->triangle = ylm_alloc(n, sizeof *t->triangle);
  if (!t->share) t->share = ylm_alloc(n, sizeof *t->share);
  if (!t->centre || !t->normal || !t->area || !t->albedo || !t->mesh || !t->triangle || !t->share)
    return YLM_ENOMEM;
  for (size_t m = 0; m < t->meshes; m++)
    for (size_t i = t->first[m]; i < t->first[m + 1]; i++)
      for (int side = 0; side < 2; side++) {
        size_t of = t->start[i][side], each = ylm__cut_size(&t->cut[i]);
        for (size_t e = 0; of != TRANSFER_NONE && e < each; e++)
          t->mesh[of + e] = (uint32_t)m, t->triangle[of + e] = (uint32_t)(i - t->first[m]);
      }
  job j = {t, positions, ylm_scene_is_tinted(t->scene)};
  ylm_status s =
      ylm_parallel(n, TRANSFER_GRAIN, t->form.threads, describe, &j, progress, "elements");
  return s == YLM_OK ? ylm__transfer_cross(t, progress) : s;
}

static ylm_status list_triangles(ylm_transfer *t) {
  t->meshes = ylm_scene_meshes(t->scene);
  t->first = ylm_alloc(t->meshes + 1, sizeof *t->first);
  if (!t->first) return YLM_ENOMEM;
  t->first[0] = 0;
  for (size_t m = 0; m < t->meshes; m++)
    t->first[m + 1] = t->first[m] + ylm_scene_triangles(t->scene, m);
  t->triangles = t->first[t->meshes];
  t->start = ylm_alloc(t->triangles, sizeof *t->start);
  return t->start ? YLM_OK : YLM_ENOMEM;
}

/* The positions of all vertices, or NULL. */
static float *positions_of(const ylm_scene *scene) {
  float *positions = ylm_alloc(ylm_scene_vertices(scene, NULL), 12);
  if (positions) ylm_scene_vertices(scene, positions);
  return positions;
}

ylm_status ylm__transfer_cut(ylm_transfer *t, const ylm_transfer_form *form, ylm_error *e) {
  ylm_status s = list_triangles(t);
  float *positions = positions_of(t->scene);
  transfer_shape *shape = ylm_alloc(t->triangles, sizeof *shape);
  t->side = ylm_alloc_zero(t->meshes, 1);
  t->cut = ylm_alloc_zero(t->triangles, sizeof *t->cut);
  t->foot = ylm_alloc(t->triangles, sizeof *t->foot);
  if (s == YLM_OK && (!positions || !shape || !t->side || !t->cut || !t->foot)) s = YLM_ENOMEM;
  if (s == YLM_OK) s = ylm__transfer_sides(t, form, positions);
  if (s == YLM_OK) {
    double core = 1;
    find_shapes(t, positions, shape);
    keep_feet(t, shape);
    if (form->places) s = find_grounds(t, form->places, form->inside, positions, &core);
    if (s == YLM_OK) s = choose_spacing(t, core, shape, e);
  }
  if (s == YLM_OK) {
    cut(t, shape);
    t->elements = number(t);
    s = make(t, positions, form->progress);
  }
  ylm_free(shape);
  ylm_free(positions);
  return s;
}

/* Whether the cuts are those of triangles of these shapes: pieces may differ by rounding elsewhere. */
static bool cuts_can_be(const ylm_transfer *t, const transfer_shape *shape, size_t elements) {
  double n = 0, degenerate = 0;
  for (size_t m = 0; m < t->meshes; m++)
    for (size_t i = t->first[m]; i < t->first[m + 1]; i++) {
      size_t size = ylm__cut_size(&t->cut[i]);
      if (!ylm__cut_can_be(&shape[i], t->form.spacing, &t->cut[i])) return false;
      n += (double)size * sides_of(t, m);
      degenerate += t->side[m] && size == 0;
    }
  return n == (double)elements && degenerate == (double)t->stats.degenerate;
}

/* As the above where grounds have elements of their own size. */
static ylm_status cuts_of_grounds(ylm_transfer *t, const float *positions, transfer_shape *shape,
                                  size_t elements) {
  double core;
  ylm_status s = find_grounds(t, 0, NULL, positions, &core);
  if (s == YLM_OK) shorten_grounds(t, core, shape);
  return s == YLM_OK && !cuts_can_be(t, shape, elements) ? YLM_EFORMAT : s;
}

ylm_status ylm__transfer_cut_again(ylm_transfer *t, size_t elements) {
  ylm_status s = list_triangles(t);
  float *positions = s == YLM_OK ? positions_of(t->scene) : NULL;
  transfer_shape *shape = positions ? ylm_alloc(t->triangles, sizeof *shape) : NULL;
  t->foot = shape ? ylm_alloc(t->triangles, sizeof *t->foot) : NULL;
  s = t->foot ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) {
    find_shapes(t, positions, shape);
    keep_feet(t, shape);
    s = cuts_can_be(t, shape, elements) ? YLM_OK : YLM_EFORMAT;
    if (s != YLM_OK) s = cuts_of_grounds(t, positions, shape, elements);
  }
  if (s == YLM_OK) {
    t->elements = number(t);
    s = make(t, positions, NULL);
  }
  ylm_free(shape);
  ylm_free(positions);
  return s;
}

uint32_t ylm_transfer_element(const ylm_transfer *t, const ylm_scene_place *p) {
  size_t of = t->first[p->mesh] + p->element;
  uint32_t start = t->start[of][p->back];
  if (start == TRANSFER_NONE) return (uint32_t)t->elements;
  return start + (uint32_t)ylm__cut_at(&t->cut[of], t->foot[of], p->u, p->v);
}

/* The place of a ray's hit on a mesh. */
static ylm_scene_place place_of_hit(const ylm_trace_ray *ray, const ylm_trace_hit *hit) {
  bool back = ylm_dot3(hit->normal, ray->dir) > 0;
  return (ylm_scene_place){(uint32_t)hit->mesh, hit->element, hit->u, hit->v, back};
}

uint32_t ylm_transfer_hit(const ylm_transfer *t, const ylm_trace_ray *ray,
                          const ylm_trace_hit *hit) {
  if (hit->mesh < 0) return (uint32_t)t->elements;
  ylm_scene_place place = place_of_hit(ray, hit);
  return ylm_transfer_element(t, &place);
}

void ylm_transfer_hits(const ylm_transfer *t, size_t n, const ylm_trace_ray *ray,
                       const ylm_trace_hit *hit, uint32_t *out) {
  for (size_t i = 0; i < n; i++) {
    const ylm_trace_hit *h = &hit[i];
    out[i] = (uint32_t)t->elements;
    if (h->mesh < 0) continue;
    ylm_scene_place place = place_of_hit(&ray[i], h);
    out[i] = ylm_transfer_element(t, &place);
    uint8_t side = place.back ? TRANSFER_BACK : TRANSFER_FRONT;
    if (!(t->side[h->mesh] & side)) out[i] = YLM_TRANSFER_BURIED(t);
    if (out[i] < t->elements && t->crossed[out[i]]) out[i] = ylm__transfer_own(t, out[i], &place);
  }
}

void ylm_transfer_elements(const ylm_transfer *t, float *centre, float *normal, float *area,
                           float *albedo, uint32_t *mesh) {
  size_t n = t->elements;
  if (centre) ylm_copy(centre, t->centre, n * 12);
  if (normal) ylm_copy(normal, t->normal, n * 12);
  for (size_t i = 0; area && i < n; i++) area[i] = t->area[i] * t->share[i];
  if (albedo) ylm_copy(albedo, t->albedo, n * 12);
  if (mesh) ylm_copy(mesh, t->mesh, n * sizeof *mesh);
}
