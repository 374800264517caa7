/* memory.c - aligned blocks whose sizes cannot overflow, and shapes. */
#include "ylm_base.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Bytes to ask for, rounded up to the alignment; 0 if that is too many. */
static size_t block_size(size_t count, size_t size) {
  size_t bytes;
  if (__builtin_mul_overflow(count, size, &bytes)) return 0;
  if (bytes > PTRDIFF_MAX - YLM_ALIGN) return 0;
  if (bytes == 0) bytes = 1;
  return (bytes + YLM_ALIGN - 1) / YLM_ALIGN * YLM_ALIGN;
}

void *ylm_alloc(size_t count, size_t size) {
  size_t bytes = block_size(count, size);
  return bytes ? aligned_alloc(YLM_ALIGN, bytes) : NULL;
}

void *ylm_alloc_zero(size_t count, size_t size) {
  void *p = ylm_alloc(count, size);
  if (p) memset(p, 0, block_size(count, size));
  return p;
}

void *ylm_realloc(void *p, size_t used, size_t count, size_t size) {
  size_t bytes = block_size(count, size);
  void *q = bytes ? aligned_alloc(YLM_ALIGN, bytes) : NULL;
  if (!q) return NULL;
  if (p && used) memcpy(q, p, used < bytes ? used : bytes);
  free(p);
  return q;
}

void ylm_free(void *p) { free(p); }

bool ylm_shape_count(int axes, const size_t *shape, size_t *count) {
  size_t n = 1, bytes;
  for (int i = 0; i < axes; i++)
    if (__builtin_mul_overflow(n, shape[i], &n)) return false;
  if (__builtin_mul_overflow(n, sizeof(double), &bytes)) return false;
  if (bytes > PTRDIFF_MAX - YLM_ALIGN) return false;
  *count = n;
  return true;
}

bool ylm_all_finite(ylm_dtype t, const void *x, size_t n, size_t *where) {
  const float *f = x;
  const double *d = x;
  for (size_t i = 0; i < n; i++) {
    if (t == YLM_DOUBLE ? isfinite(d[i]) : isfinite(f[i])) continue;
    if (where) *where = i;
    return false;
  }
  return true;
}
