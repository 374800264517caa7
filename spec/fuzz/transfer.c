/*
** transfer.c - fuzzes the reader of transfer files, for a scene of a box and a quad.
**
** Mutations get a size, a fingerprint and a checksum that fit, or else nothing behind them would be
** reached; one in sixteen goes through as it is. Most keep their size. Elements and links of files
** that are accepted are used.
*/
#include <string.h>

#include "../../csrc/transfer/transfer.h"
#include "ylm_geom.h"
#include "ylm_sets.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t room);

#define SWAPPED 0x04030201u

/* The kernels are not what is fuzzed. */
#define STUB(isa)                                                                                  \
  ylm_transfer_sum_fn ylm_k_transfer_sum_##isa;                                                    \
  void ylm_k_transfer_sum_##isa(size_t n, int links, ylm_links link, int width, const float *in,   \
                                const float *start, float *out) {                                  \
    size_t row = (size_t)width, each = (size_t)links;                                              \
    (void)start;                                                                                   \
    for (size_t i = 0; i < n * row; i++) {                                                         \
      out[i] = 0;                                                                                  \
      for (size_t k = 0; k < each; k++)                                                            \
        out[i] += in[ylm_links_at(link, i / row * each + k) * row + i % row];                      \
    }                                                                                              \
  }
YLM_SETS(STUB)

static ylm_scene_mesh part(const ylm_mesh *m, const ylm_material *material) {
  return (ylm_scene_mesh){.positions = m->position,
                          .vertices = m->vertices,
                          .triangles = m->index,
                          .count = m->triangles,
                          .material = material,
                          .occludes = true};
}

static const ylm_scene *scene(void) {
  static ylm_scene *s = NULL;
  const double lo[3] = {-0.5, -0.5, -0.5}, hi[3] = {0.5, 0.5, 0.5};
  const double corner[3] = {-1, -0.5, 1}, u[3] = {2, 0, 0}, v[3] = {0, 0, -2};
  const float grey[3] = {0.5f, 0.5f, 0.5f};
  ylm_mesh *box, *quad;
  ylm_material *m;
  const ylm_scene_lamps none = {.sky = NULL};
  if (s) return s;
  if (ylm_mesh_box(lo, hi, 1, &box, NULL) != YLM_OK ||
      ylm_mesh_quad(corner, u, v, 1, 1, &quad, NULL) != YLM_OK ||
      ylm_material_create(ylm_material_kind_find("matte"), 3, grey, &m, NULL) != YLM_OK)
    __builtin_trap();
  const ylm_scene_mesh meshes[2] = {part(box, m), part(quad, m)};
  if (ylm_scene_create(2, meshes, &none, &s, NULL) != YLM_OK) __builtin_trap();
  ylm_mesh_free(box);
  ylm_mesh_free(quad);
  ylm_material_free(m);
  return s;
}

static uint64_t turned(uint64_t x, bool swap) { return swap ? __builtin_bswap64(x) : x; }

static void seal(uint8_t *data, size_t size) {
  static uint64_t print = 0;
  uint32_t order;
  if (!print && ylm__transfer_fingerprint(scene(), &print) != YLM_OK) __builtin_trap();
  memcpy(&order, data + 8, sizeof order);
  bool swap = order == SWAPPED;
  uint64_t x = turned(size, swap);
  memcpy(data + 16, &x, sizeof x);
  x = turned(print, swap);
  memcpy(data + 56, &x, sizeof x);
  x = turned(ylm_crc64(0, data, size - 8), swap);
  memcpy(data + size - 8, &x, sizeof x);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed) {
  size_t before = size;
  size = LLVMFuzzerMutate(data, size, seed % 4 ? size : room);
  if (seed % 4 && before <= room) {
    memset(data + size, 0, before - size);
    size = before;
  }
  if (size >= 160 && seed % 16) seal(data, size);
  return size;
}

/* Asks for elements, the places of their corners, and a bounce. */
static void use(const ylm_transfer *t) {
  size_t n = ylm_transfer_count(t);
  float *in = ylm_alloc_zero(n + 1, 16), *out = ylm_alloc_zero(n + 1, 16);
  if (in && out)
    ylm_transfer_sum(n, ylm_transfer_made(t)->links, ylm_transfer_links(t), 4, in, NULL, out, 1);
  ylm_free(in);
  ylm_free(out);
  for (size_t i = 0; i < n; i++) {
    ylm_scene_place p;
    float corner[3][2];
    ylm__transfer_corners(t, i, &p, corner);
    p.u = (corner[0][0] + corner[1][0] + corner[2][0]) / 3;
    p.v = (corner[0][1] + corner[1][1] + corner[2][1]) / 3;
    if (ylm__cut_size(&t->cut[t->first[p.mesh] + p.element]) < 65536 &&
        ylm_transfer_element(t, &p) != i)
      __builtin_trap();
  }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  ylm_error e;
  ylm_transfer *t;
  if (ylm_transfer_read(scene(), data, size, "fuzz", &t, &e) != YLM_OK) {
    if (t) __builtin_trap();
    return 0;
  }
  use(t);
  ylm_transfer_free(t);
  return 0;
}
