/* sides.c - which sides of closed meshes light reaches: those that a lamp or a given place can see. */
#include <math.h>

#include "calibration.h"
#include "transfer.h"
#include "ylm_light_emitter.h"

/* A closed mesh whose sides are to be found. */
typedef struct body {
  size_t mesh;
  const float *positions;
  size_t vertices;
  double lo[3], hi[3];
  bool turned;       /* its front is inside */
  bool outer, inner; /* that side is seen */
} body;

typedef struct crowd {
  const ylm_scene *scene;
  body *body;
  size_t bodies;
  uint32_t seen[SIDES_SETS][SIDES_NESTED + 1]; /* the number of bodies, and these, in order */
  size_t sets;
} crowd;

/* Whether a ray from p in a fixed direction crosses the triangle. */
static bool crosses(const double p[3], const float *a, const float *b, const float *c) {
  static const double d[3] = {0.3574067443365933, 0.6816387600233341, 0.6383733009012513};
  double u[3], v[3], w[3], n[3];
  for (int k = 0; k < 3; k++)
    u[k] = (double)b[k] - a[k], v[k] = (double)c[k] - a[k], w[k] = p[k] - a[k];
  for (int k = 0; k < 3; k++) {
    int i = (k + 1) % 3, j = (k + 2) % 3;
    n[k] = d[i] * v[j] - d[j] * v[i];
  }
  double det = u[0] * n[0] + u[1] * n[1] + u[2] * n[2];
  if (det == 0) return false;
  double s = (w[0] * n[0] + w[1] * n[1] + w[2] * n[2]) / det;
  if (s < 0 || s > 1) return false;
  for (int k = 0; k < 3; k++) {
    int i = (k + 1) % 3, j = (k + 2) % 3;
    n[k] = w[i] * u[j] - w[j] * u[i];
  }
  double t = (d[0] * n[0] + d[1] * n[1] + d[2] * n[2]) / det;
  if (t < 0 || s + t > 1) return false;
  return (v[0] * n[0] + v[1] * n[1] + v[2] * n[2]) / det > 0;
}

/* By the parity of a ray. */
static bool contains(const crowd *c, const body *b, const double p[3]) {
  bool odd = false;
  for (int a = 0; a < 3; a++)
    if (!(p[a] > b->lo[a] && p[a] < b->hi[a])) return false;
  for (size_t i = 0; i < ylm_scene_triangles(c->scene, b->mesh); i++) {
    const uint32_t *t = ylm_scene_triangle(c->scene, b->mesh, i);
    odd ^= crosses(p, b->positions + 3 * t[0], b->positions + 3 * t[1], b->positions + 3 * t[2]);
  }
  return odd;
}

/* Whether a body lies inside of another, by one of its corners. */
static bool holds(const crowd *c, const body *outer, const body *inner) {
  const double p[3] = {(double)inner->positions[0], (double)inner->positions[1],
                       (double)inner->positions[2]};
  return outer != inner && contains(c, outer, p);
}

/* Marks what is seen from a place that the n bodies `in` surround. */
static void mark(crowd *c, size_t n, const uint32_t *in) {
  for (size_t m = 0; m < c->bodies; m++) {
    body *b = &c->body[m];
    bool around = false, all = true;
    for (size_t i = 0; i < n; i++) {
      around = around || in[i] == m;
      if (in[i] != m) all = all && holds(c, &c->body[in[i]], b);
    }
    if (all && around) b->inner = true;
    if (all && !around) b->outer = true;
  }
}

/* Looks around from p. */
static void look(crowd *c, const double p[3]) {
  uint32_t set[SIDES_NESTED + 1] = {0};
  for (size_t m = 0; m < c->bodies && set[0] < SIDES_NESTED; m++)
    if (contains(c, &c->body[m], p)) set[++set[0]] = (uint32_t)m;
  for (size_t k = 0; k < c->sets; k++)
    if (memcmp(c->seen[k], set, (set[0] + 1) * sizeof *set) == 0) return;
  if (c->sets < SIDES_SETS) memcpy(c->seen[c->sets++], set, sizeof set);
  mark(c, set[0], set + 1);
}

/* Looks from a lamp that is not distant, a flat one from both sides. */
static void look_from(crowd *c, size_t lamp) {
  ylm_light_emitter e;
  ylm_light_place place;
  double p[3];
  ylm_scene_emitter(c->scene, lamp, &e);
  ylm_light_emitter_place(&e, &place);
  float middle[3] = {(float)place.at[0], (float)place.at[1], (float)place.at[2]};
  double aside = 4 * (double)ylm_trace_offset(ylm_scene_trace(c->scene), middle);
  bool flat = ylm_dot3d(place.normal, place.normal) > 0;
  for (int side = flat ? -1 : 1; side <= 1; side += 2) {
    for (int a = 0; a < 3; a++) p[a] = place.at[a] + side * aside * place.normal[a];
    look(c, p);
  }
}

static void look_from_lamps(crowd *c) {
  size_t n = ylm_scene_near(c->scene), step = n / SIDES_LAMPS + 1,
         all = ylm_scene_lamps_all(c->scene);
  for (size_t i = 0; i < n; i += step) look_from(c, i);
  for (size_t i = all - ylm_scene_points(c->scene, NULL); i < all; i++) look_from(c, i);
  if (ylm_scene_distant(c->scene) > 0) mark(c, 0, NULL);
}

/* A body of mesh m, if it is closed and encloses something. */
static ylm_status add(crowd *c, ylm_transfer *t, size_t m, const float *positions) {
  bool closed;
  double volume, size = 0;
  ylm_status s = ylm__transfer_closed(t->scene, m, positions, &closed, &volume);
  if (s != YLM_OK || !closed) return s;
  size_t first = ylm_scene_first_vertex(t->scene, m);
  body *b = &c->body[c->bodies];
  *b = (body){.mesh = m, .positions = positions + 3 * first, .turned = volume < 0};
  b->vertices = ylm_scene_first_vertex(t->scene, m + 1) - first;
  for (int a = 0; a < 3; a++) b->lo[a] = INFINITY, b->hi[a] = -INFINITY;
  for (size_t i = 0; i < 3 * b->vertices; i++) {
    b->lo[i % 3] = fmin(b->lo[i % 3], (double)b->positions[i]);
    b->hi[i % 3] = fmax(b->hi[i % 3], (double)b->positions[i]);
  }
  for (int a = 0; a < 3; a++) size = fmax(size, b->hi[a] - b->lo[a]);
  if (!(fabs(volume) > 1e-9 * size * size * size)) return YLM_OK;
  c->bodies++;
  t->stats.closed++;
  return YLM_OK;
}

/* Bits of the sides that are asked for; 0: they are to be found. */
static uint8_t asked(const ylm_transfer_form *form, size_t m) {
  int sides = form->mesh_sides ? form->mesh_sides[m] : form->sides;
  return sides == YLM_TRANSFER_BOTH    ? TRANSFER_FRONT | TRANSFER_BACK
         : sides == YLM_TRANSFER_FRONT ? TRANSFER_FRONT
         : sides == YLM_TRANSFER_BACK  ? TRANSFER_BACK
                                       : 0;
}

ylm_status ylm__transfer_sides(ylm_transfer *t, const ylm_transfer_form *form,
                               const float *positions) {
  crowd *c = ylm_alloc_zero(1, sizeof *c);
  if (!c || !(c->body = ylm_alloc(t->meshes, sizeof *c->body))) {
    ylm_free(c);
    return YLM_ENOMEM;
  }
  ylm_status s = YLM_OK;
  c->scene = t->scene;
  for (size_t m = 0; s == YLM_OK && m < t->meshes; m++) {
    uint8_t sides = asked(form, m);
    t->side[m] = sides ? sides : TRANSFER_FRONT | TRANSFER_BACK;
    if (!ylm_scene_occludes(t->scene, m))
      t->side[m] = 0;
    else if (!sides)
      s = add(c, t, m, positions);
  }
  if (s == YLM_OK && c->bodies > 0) {
    look_from_lamps(c);
    for (size_t i = 0; i < form->places; i++)
      look(c, (const double[3]){(double)form->inside[i][0], (double)form->inside[i][1],
                                (double)form->inside[i][2]});
  }
  for (size_t i = 0; i < c->bodies; i++) {
    const body *b = &c->body[i];
    uint8_t outer = b->turned ? TRANSFER_BACK : TRANSFER_FRONT, inner = 3 & ~outer;
    t->side[b->mesh] = (b->inner ? inner : 0) | (b->outer || !b->inner ? outer : 0);
    t->stats.rooms += b->inner;
  }
  ylm_free(c->body);
  ylm_free(c);
  return s;
}
