/* closed.c - whether a mesh is closed: every edge is passed in both directions equally often. */
#include "transfer.h"

/* A table of keys with a number each, half full at best. */
typedef struct table {
  size_t mask;
  uint64_t *key; /* [mask + 1] 0: free */
  int32_t *value;
} table;

static bool table_create(table *x, size_t keys) {
  size_t n = 16;
  while (n < 2 * keys) n *= 2;
  x->mask = n - 1;
  x->key = ylm_alloc_zero(n, sizeof *x->key);
  x->value = ylm_alloc_zero(n, sizeof *x->value);
  return x->key && x->value;
}

static void table_free(table *x) {
  ylm_free(x->key);
  ylm_free(x->value);
}

/* Source: Steele, Lea, Flood 2014, "Fast Splittable Pseudorandom Number Generators" (the mix). */
static uint64_t mix(uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

/* The number of a key, which is not 0; a new one has 0. */
static int32_t *table_at(table *x, uint64_t key) {
  size_t i = mix(key) & x->mask;
  while (x->key[i] && x->key[i] != key) i = (i + 1) & x->mask;
  x->key[i] = key;
  return &x->value[i];
}

/* Bits of a position; -0 is 0. */
static void bits_of(const float p[3], uint32_t bits[3]) {
  for (int a = 0; a < 3; a++) {
    float x = p[a] + 0.0f;
    memcpy(&bits[a], &x, 4);
  }
}

/* same[v]: the first vertex at the position of vertex v. */
static bool find_same(size_t n, const float *p, uint32_t *same) {
  table x;
  bool ok = table_create(&x, n);
  for (size_t v = 0; ok && v < n; v++) {
    uint32_t bits[3], other[3];
    bits_of(p + 3 * v, bits);
    uint64_t hash = mix(mix(bits[0] + 1) ^ ((uint64_t)bits[1] << 32 | bits[2]));
    size_t i = hash & x.mask;
    for (; x.key[i]; i = (i + 1) & x.mask) {
      bits_of(p + 3 * (x.key[i] - 1), other);
      if (memcmp(bits, other, sizeof bits) == 0) break;
    }
    if (!x.key[i]) x.key[i] = v + 1;
    same[v] = (uint32_t)(x.key[i] - 1);
  }
  table_free(&x);
  return ok;
}

/* Passes along the edge from a to b. */
static void pass(table *x, uint32_t a, uint32_t b) {
  uint32_t low = a < b ? a : b, high = a < b ? b : a;
  *table_at(x, ((uint64_t)high << 32 | low)) += a < b ? 1 : -1;
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
  uint32_t *same = ylm_alloc(n, sizeof *same);
  table edges;
  bool ok = table_create(&edges, 3 * count) && same && find_same(n, p, same);
  const double zero[3] = {n ? (double)p[0] : 0, n ? (double)p[1] : 0, n ? (double)p[2] : 0};
  *volume = 0;
  for (size_t i = 0; ok && i < count; i++) {
    const uint32_t *t = ylm_scene_triangle(scene, mesh, i);
    for (int k = 0; k < 3; k++) {
      uint32_t a = same[t[k]], b = same[t[(k + 1) % 3]];
      if (a != b) pass(&edges, a, b);
    }
    *volume += volume_of(p + 3 * t[0], p + 3 * t[1], p + 3 * t[2], zero);
  }
  *closed = ok && count > 0;
  for (size_t i = 0; ok && i <= edges.mask; i++) *closed = *closed && edges.value[i] == 0;
  table_free(&edges);
  ylm_free(same);
  return ok ? YLM_OK : YLM_ENOMEM;
}
