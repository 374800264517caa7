/* lamp.c - lights of any kind: taken from their sets, compared, kept, asked as a field. */
#include "lamp.h"

#include <string.h>

/* -- from sets of lights ---------------------------------------------------------------------- */

static size_t shape_bytes(size_t rows) {
  return sizeof(lamp_shape) + rows * sizeof((lamp_shape *)0)->row[0];
}

static size_t rows_of(const ylm_polygon *p) { return p->sides ? (size_t)p->sides : 3; }

static void add_spheres(const ylm_lights *lights, lamp_set *set) {
  const double *at, *radius, *radiance;
  size_t n = ylm_lights_count(lights);
  ylm_lights_arrays(lights, &at, &radius, &radiance);
  for (size_t i = 0; i < n; i++) {
    lamp *l = &set->lamp[set->n++];
    *l = (lamp){.radius = radius[i]};
    memcpy(l->at, at + 3 * i, sizeof l->at);
    memcpy(l->radiance, radiance + 3 * i, sizeof l->radiance);
  }
}

/* Appends a flat light whose shape is written to `shape`. */
static void add_flat(const ylm_polygon *p, lamp_shape *shape, lamp_set *set) {
  lamp *l = &set->lamp[set->n++];
  *shape = (lamp_shape){.sides = p->sides,
                        .exact = p->exact,
                        .clipped = p->horizon != NULL,
                        .reach = p->reach,
                        .rows = rows_of(p)};
  if (p->horizon) memcpy(shape->horizon, p->horizon, sizeof shape->horizon);
  memcpy(shape->normal, p->normal, sizeof shape->normal);
  memcpy(shape->row, p->vertices, shape->rows * sizeof shape->row[0]);
  *l = (lamp){.radius = p->radius, .shape = shape};
  memcpy(l->at, p->centroid, sizeof l->at);
  memcpy(l->radiance, p->radiance, sizeof l->radiance);
}

ylm_status ylm__lamps(const ylm_light_parts *lights, lamp_set *set) {
  ylm_polygon p;
  size_t n = lights->spheres ? ylm_lights_count(lights->spheres) : 0, bytes = 0;
  *set = (lamp_set){0};
  for (size_t k = 0; k < lights->flats; k++)
    for (size_t i = 0; i < ylm_polygons_count(lights->flat[k]); i++, n++) {
      ylm_polygons_get(lights->flat[k], i, &p);
      bytes += shape_bytes(rows_of(&p));
    }
  set->lamp = ylm_alloc(n, sizeof *set->lamp);
  char *shapes = set->shapes = ylm_alloc(bytes, 1);
  if (!set->lamp || !shapes) {
    ylm__lamps_free(set);
    return YLM_ENOMEM;
  }
  if (lights->spheres) add_spheres(lights->spheres, set);
  for (size_t k = 0; k < lights->flats; k++)
    for (size_t i = 0; i < ylm_polygons_count(lights->flat[k]); i++) {
      ylm_polygons_get(lights->flat[k], i, &p);
      add_flat(&p, (lamp_shape *)(void *)shapes, set);
      shapes += shape_bytes(rows_of(&p));
    }
  return YLM_OK;
}

void ylm__lamps_free(lamp_set *set) {
  ylm_free(set->lamp);
  ylm_free(set->shapes);
  *set = (lamp_set){0};
}

/* -- shapes that are kept --------------------------------------------------------------------- */

ylm_status ylm__lamp_keep(shape_list *list, lamp *l) {
  if (!l->shape) return YLM_OK;
  if (list->n == list->room) {
    size_t room = list->room ? 2 * list->room : 16;
    lamp_shape **more = ylm_realloc(list->shape, list->n * sizeof *more, room, sizeof *more);
    if (!more) return YLM_ENOMEM;
    list->shape = more;
    list->room = room;
  }
  lamp_shape *own = ylm_alloc_copy(l->shape, 1, shape_bytes(l->shape->rows));
  if (!own) return YLM_ENOMEM;
  own->marked = false;
  list->shape[list->n++] = own;
  list->bytes += shape_bytes(own->rows);
  l->shape = own;
  return YLM_OK;
}

void ylm__shapes_sweep(shape_list *list) {
  size_t left = 0;
  for (size_t i = 0; i < list->n; i++) {
    lamp_shape *s = list->shape[i];
    if (s->marked) {
      s->marked = false;
      list->shape[left++] = s;
      continue;
    }
    list->bytes -= shape_bytes(s->rows);
    ylm_free(s);
  }
  list->n = left;
}

/* -- comparisons ------------------------------------------------------------------------------ */

static int compare_shapes(const lamp_shape *a, const lamp_shape *b) {
  if (a == b) return 0;
  if (!a || !b) return a ? 1 : -1;
  if (a->sides != b->sides) return a->sides < b->sides ? -1 : 1;
  if (a->exact != b->exact) return a->exact < b->exact ? -1 : 1;
  int c = memcmp(a->horizon, b->horizon, sizeof a->horizon);
  return c ? c : memcmp(a->row, b->row, a->rows * sizeof a->row[0]);
}

int ylm__lamp_compare(const lamp *a, const lamp *b) {
  int c = memcmp(a, b, offsetof(lamp, shape));
  return c ? c : compare_shapes(a->shape, b->shape);
}

/* A polygon's vertices move with its centroid, to a part in 1e9 of its size; axes stay. */
static bool translated(const lamp *a, const lamp *b) {
  const lamp_shape *s = a->shape, *t = b->shape;
  double most = 0;
  if (s->sides != t->sides || s->clipped || t->clipped) return false;
  for (size_t i = 0; i < s->rows; i++)
    for (int k = 0; k < 3; k++) {
      double way = s->sides || i == 0 ? b->at[k] - a->at[k] : 0;
      most = fmax(most, fabs(t->row[i][k] - s->row[i][k] - way));
    }
  return most <= 1e-9 * s->reach;
}

bool ylm__lamp_slides(const lamp *a, const lamp *b) {
  if (lamp_kind_of(a) != lamp_kind_of(b)) return false;
  if (!a->shape) return a->radius == b->radius;
  return compare_shapes(a->shape, b->shape) == 0 || translated(a, b);
}

bool ylm__lamps_alike(const lamp *a, const lamp *b) {
  if (lamp_kind_of(a) != lamp_kind_of(b)) return false;
  return !a->shape || memcmp(a->shape->horizon, b->shape->horizon, sizeof a->shape->horizon) == 0;
}

/* -- where it is ------------------------------------------------------------------------------ */

void ylm__lamp_box(const lamp *l, double box[6]) {
  double reach = l->shape ? fmax(l->radius, l->shape->reach) : l->radius;
  for (int a = 0; a < 3; a++) {
    box[a] = l->at[a] - reach;
    box[a + 3] = l->at[a] + reach;
  }
}

/* A lamp's centre moved along `normal` to the height of p, and how far that is. */
static double level(const lamp *l, const double p[3], const double normal[3], double out[3]) {
  double height = 0;
  for (int k = 0; k < 3; k++) height += normal[k] * (l->at[k] - p[k]);
  for (int k = 0; k < 3; k++) out[k] = l->at[k] - height * normal[k];
  return fabs(height);
}

/* In its plane the disk's way is a segment, seen from the nearer of two planes. */
double ylm__lamp_flat_distance(const lamp *a, const lamp *b, const double p[3]) {
  double from[3], to[3], ha = level(a, p, a->shape->normal, from),
                         hb = level(b, p, a->shape->normal, to);
  return hypot(fmin(ha, hb), fmax(0, segment_distance(p, from, to) - a->shape->reach));
}

/* -- as a field ------------------------------------------------------------------------------- */

static ylm_status spheres_field(size_t n, const lamp *const *lamps, const double *strength,
                                lamp_field *f) {
  double at[6], radius[2], radiance[6];
  for (size_t k = 0; k < n; k++) {
    memcpy(at + 3 * k, lamps[k]->at, sizeof lamps[k]->at);
    radius[k] = lamps[k]->radius;
    for (size_t c = 0; c < 3; c++) radiance[3 * k + c] = strength[k];
  }
  ylm_status s = ylm_lights_create(n, at, radius, radiance, &f->spheres, NULL);
  if (s == YLM_OK) f->field = ylm_lights_field(f->spheres);
  return s;
}

static ylm_status flat_field(size_t n, const lamp *const *lamps, const double *strength,
                             lamp_field *f) {
  double row[2 * YLM_POLYGON_VERTICES][3], radiance[6];
  const lamp_shape *first = lamps[0]->shape;
  int sides[2];
  size_t rows = 0;
  for (size_t k = 0; k < n; k++) {
    const lamp_shape *s = lamps[k]->shape;
    sides[k] = s->sides;
    memcpy(row[rows], s->row, s->rows * sizeof row[0]);
    rows += s->rows;
    for (size_t c = 0; c < 3; c++) radiance[3 * k + c] = strength[k];
  }
  ylm_status s = ylm_polygons_create(n, sides, row[0], radiance, first->exact,
                                     first->clipped ? first->horizon : NULL, &f->flat, NULL);
  if (s == YLM_OK) f->field = ylm_polygons_field(f->flat);
  return s;
}

ylm_status ylm__lamp_field(size_t n, const lamp *const *lamps, const double *strength,
                           lamp_field *f) {
  *f = (lamp_field){0};
  return (lamps[0]->shape ? flat_field : spheres_field)(n, lamps, strength, f);
}

void ylm__lamp_field_free(lamp_field *f) {
  ylm_lights_free(f->spheres);
  ylm_polygons_free(f->flat);
}
