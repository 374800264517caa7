/* memory.c - aligned blocks whose sizes cannot overflow, and shapes. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* mremap */
#endif
#include "ylm_base.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

/* Bytes to ask for, rounded up to the alignment; 0 if that is too many. */
static size_t block_size(size_t count, size_t size) {
  size_t bytes;
  if (__builtin_mul_overflow(count, size, &bytes)) return 0;
  if (bytes > PTRDIFF_MAX - YLM_ALIGN) return 0;
  if (bytes == 0) bytes = 1;
  return (bytes + YLM_ALIGN - 1) / YLM_ALIGN * YLM_ALIGN;
}

/*
** Blocks from this size on ask for huge pages: a grid of 10^5 points is 10^4 times 4 KiB, whose
** page faults cost as much as the arithmetic of a small bake.
*/
#define LARGE ((size_t)4 << 20)

static void advise(void *p, size_t bytes) {
#ifdef MADV_HUGEPAGE
  const uintptr_t page = 1 << 21, begin = ((uintptr_t)p + page - 1) & ~(page - 1);
  const uintptr_t end = ((uintptr_t)p + bytes) & ~(page - 1);
  if (bytes >= LARGE && begin < end) madvise((void *)begin, end - begin, MADV_HUGEPAGE);
#else
  (void)p, (void)bytes;
#endif
}

void *ylm_alloc(size_t count, size_t size) {
  size_t bytes = block_size(count, size);
  void *p = bytes ? aligned_alloc(YLM_ALIGN, bytes) : NULL;
  if (p) advise(p, bytes);
  return p;
}

void *ylm_alloc_zero(size_t count, size_t size) {
  void *p = ylm_alloc(count, size);
  if (p) memset(p, 0, block_size(count, size));
  return p;
}

void *ylm_alloc_copy(const void *from, size_t count, size_t size) {
  void *p = ylm_alloc(count, size);
  if (p) ylm_copy(p, from, count * size);
  return p;
}

void *ylm_realloc(void *p, size_t used, size_t count, size_t size) {
  void *q = ylm_alloc(count, size);
  size_t bytes = block_size(count, size);
  if (!q) return NULL;
  ylm_copy(q, p, used < bytes ? used : bytes);
  free(p);
  return q;
}

void ylm_free(void *p) { free(p); }

/* Pages of their own for what is LARGE, where they can be moved; under a sanitizer, which could not
   watch their ends, everything is copied. */
#if defined(MREMAP_MAYMOVE) && defined(MADV_HUGEPAGE) && !defined(__SANITIZE_ADDRESS__)

void *ylm_regrow(void *p, size_t old, size_t bytes) {
  if (bytes > PTRDIFF_MAX) return NULL;
  if (bytes < LARGE && old >= LARGE) {
    void *small = ylm_alloc(bytes, 1);
    if (!small) return NULL;
    memcpy(small, p, bytes);
    munmap(p, old);
    return small;
  }
  if (bytes < LARGE) return ylm_realloc(p, old, bytes, 1);
  void *q = old >= LARGE
                ? mremap(p, old, bytes, MREMAP_MAYMOVE)
                : mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (q == MAP_FAILED) return NULL;
  if (old >= LARGE) return q;
  madvise(q, bytes, MADV_HUGEPAGE); /* all of it, so that it stays one mapping */
  ylm_copy(q, p, old);
  free(p);
  return q;
}

void ylm_regrow_free(void *p, size_t bytes) {
  if (bytes >= LARGE)
    munmap(p, bytes);
  else
    free(p);
}

#else

void *ylm_regrow(void *p, size_t old, size_t bytes) { return ylm_realloc(p, old, bytes, 1); }

void ylm_regrow_free(void *p, size_t bytes) {
  (void)bytes;
  free(p);
}

#endif

bool ylm_shape_count(int axes, const size_t *shape, size_t *count) {
  size_t n = 1, bytes;
  for (int i = 0; i < axes; i++)
    if (__builtin_mul_overflow(n, shape[i], &n)) return false;
  if (__builtin_mul_overflow(n, sizeof(double), &bytes)) return false;
  if (bytes > PTRDIFF_MAX - YLM_ALIGN) return false;
  *count = n;
  return true;
}
