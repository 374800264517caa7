/* closed.c - whether a mesh is closed: every edge is passed in both directions equally often. */
#include "transfer.h"
#include "ylm_keys.h"

/* Bits of a position; -0 is 0. */
static void bits_of(const float p[3], uint32_t bits[3]) {
  for (int a = 0; a < 3; a++) {
    float x = p[a] + 0.0f;
    memcpy(&bits[a], &x, 4);
  }
}

/* place[v]: the number of the position of vertex v. */
static bool number_places(size_t n, const float *p, uint32_t *place) {
  ylm_keys places = {0};
  bool ok = true;
  for (size_t v = 0; ok && v < n; v++) {
    uint32_t bits[3];
    bits_of(p + 3 * v, bits);
    ok = ylm_keys_put(&places, bits, sizeof bits, &place[v]) == YLM_OK;
  }
  ylm_keys_free(&places);
  return ok;
}

/* Passes along the edge from a to b; passes[edge] is how often it was passed upwards. */
static bool pass(ylm_keys *edges, int32_t *passes, uint32_t a, uint32_t b) {
  uint32_t ends[2] = {a < b ? a : b, a < b ? b : a}, edge;
  if (ylm_keys_put(edges, ends, sizeof ends, &edge) != YLM_OK) return false;
  passes[edge] += a < b ? 1 : -1;
  return true;
}

static double volume_of(const float *a, const float *b, const float *c, const double o[3]) {
  double p[3], q[3], r[3];
  for (int k = 0; k < 3; k++)
    p[k] = (double)a[k] - o[k], q[k] = (double)b[k] - o[k], r[k] = (double)c[k] - o[k];
  return (p[0] * (q[1] * r[2] - q[2] * r[1]) + p[1] * (q[2] * r[0] - q[0] * r[2]) +
          p[2] * (q[0] * r[1] - q[1] * r[0])) /
         6;
}

ylm_status ylm__transfer_closed(const ylm_scene *scene, size_t mesh, const float *positions,
                                bool *closed, double *volume) {
  size_t first = ylm_scene_first_vertex(scene, mesh), count = ylm_scene_triangles(scene, mesh);
  size_t n = ylm_scene_first_vertex(scene, mesh + 1) - first;
  const float *p = positions + 3 * first;
  uint32_t *place = ylm_alloc(n, sizeof *place);
  int32_t *passes = ylm_alloc_zero(3 * count, sizeof *passes);
  ylm_keys edges = {0};
  bool ok = place && passes && number_places(n, p, place);
  const double zero[3] = {n ? (double)p[0] : 0, n ? (double)p[1] : 0, n ? (double)p[2] : 0};
  *volume = 0;
  for (size_t i = 0; ok && i < count; i++) {
    const uint32_t *t = ylm_scene_triangle(scene, mesh, i);
    for (int k = 0; k < 3; k++) {
      uint32_t a = place[t[k]], b = place[t[(k + 1) % 3]];
      if (a != b) ok = ok && pass(&edges, passes, a, b);
    }
    *volume += volume_of(p + 3 * t[0], p + 3 * t[1], p + 3 * t[2], zero);
  }
  *closed = ok && count > 0;
  for (size_t i = 0; ok && i < edges.n; i++) *closed = *closed && passes[i] == 0;
  ylm_keys_free(&edges);
  ylm_free(passes);
  ylm_free(place);
  return ok ? YLM_OK : YLM_ENOMEM;
}
