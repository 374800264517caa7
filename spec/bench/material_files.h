/* material_files.h - materials of files to measure: MERL's bins of GGX, RGL's tables of noise in the
   sizes that are published. */
#ifndef YLM_BENCH_MATERIAL_FILES_H
#define YLM_BENCH_MATERIAL_FILES_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ylm_material.h"

/* A material of a file's bytes; NULL where that fails. */
static ylm_material *bench_material(const char *kind, float x, const unsigned char *bytes,
                                    size_t size) {
  ylm_material *m = NULL;
  ylm_material_load(ylm_material_kind_find(kind), 1, &x, bytes, size, kind, &m, NULL);
  return m;
}

/* GGX of roughness 0.3 in MERL's bins, linear or nearest. */
static ylm_material *bench_merl(bool linear) {
  static const float ggx[] = {0.3f, 0.3f, 1, 0.8f, 0.3f, 0, 0, 0, 0};
  char path[] = "/tmp/ylm_bench_XXXXXX";
  ylm_material *from = NULL, *m = NULL;
  unsigned char *bytes = NULL;
  size_t size;
  int file = mkstemp(path);
  if (file < 0) return NULL;
  close(file);
  if (ylm_material_create(ylm_material_kind_find("ggx"), 9, ggx, &from, NULL) == YLM_OK &&
      ylm_material_write_merl(from, path, NULL) == YLM_OK &&
      ylm_file_read(path, 0, &bytes, &size, NULL) == YLM_OK)
    m = bench_material("merl", linear, bytes, size);
  unlink(path);
  ylm_free(bytes);
  ylm_material_free(from);
  return m;
}

/* A tensor file as it grows; numbers as this machine has them, which is little-endian. */
typedef struct bench_tensor {
  unsigned char *bytes;
  size_t header, size;
} bench_tensor;

static void bench_put(bench_tensor *t, uint64_t x, int n) {
  for (int i = 0; i < n; i++, x >>= 8) t->bytes[t->header++] = (unsigned char)x;
}

/* Adds a field of floats from `first` to first + step, or in between by chance. */
static void bench_field(bench_tensor *t, ylm_rng *r, const char *name, int axes, const int *shape,
                        float first, float step) {
  size_t count = 1;
  bench_put(t, strlen(name), 2);
  memcpy(t->bytes + t->header, name, strlen(name));
  t->header += strlen(name);
  bench_put(t, (uint64_t)axes, 2);
  bench_put(t, 10, 1);
  bench_put(t, t->size, 8);
  for (int a = 0; a < axes; a++) {
    bench_put(t, (uint64_t)shape[a], 8);
    count *= (size_t)shape[a];
  }
  for (size_t i = 0; i < count; i++, t->size += 4) {
    float share = axes == 1 ? (float)i / (float)count : (float)ylm_rng_double(r);
    float x = first + step * share;
    memcpy(t->bytes + t->size, &x, sizeof x);
  }
}

/* 8 elevations, and one azimuth or 17, of 32 x 32 nodes. */
static __attribute__((unused)) ylm_material *bench_rgl(int phis) {
  bench_tensor t = {.header = 18, .size = 1024};
  ylm_rng r;
  ylm_rng_seed(&r, 2, 1);
  t.bytes = ylm_alloc_zero((size_t)phis * 8 * 32 * 32 * 4 * 6 + (1 << 16), 1);
  if (!t.bytes) return NULL;
  memcpy(t.bytes, "tensor_file\0\1", 14);
  t.header = 14;
  bench_put(&t, 8, 4);
  int slices[] = {phis, 8, 32, 32}, colours[] = {phis, 8, 3, 32, 32};
  bench_field(&t, &r, "phi_i", 1, &phis, -3.14159265f, 6.2831853f * (float)phis / 16);
  bench_field(&t, &r, "theta_i", 1, (int[]){8}, 0, 1.6f);
  bench_field(&t, &r, "ndf", 2, (int[]){32, 32}, 0.5f, 1);
  bench_field(&t, &r, "sigma", 2, (int[]){32, 32}, 0.5f, 1);
  bench_field(&t, &r, "vndf", 4, slices, 0.5f, 1);
  bench_field(&t, &r, "luminance", 4, slices, 0.5f, 1);
  bench_field(&t, &r, "rgb", 5, colours, 0.5f, 1);
  bench_put(&t, 8, 2);
  memcpy(t.bytes + t.header, "jacobian", 8);
  t.header += 8;
  bench_put(&t, 1, 2);
  bench_put(&t, 1, 1);
  bench_put(&t, t.size, 8);
  bench_put(&t, 1, 8);
  t.bytes[t.size++] = 1;
  ylm_material *m = bench_material("rgl", 0, t.bytes, t.size);
  ylm_free(t.bytes);
  return m;
}

#endif
