/* numbers_slice.c - parts of arrays: where they lie, copies out and in. */
#include "ylm_numbers.h"

bool ylm_slices_run(int axes, const size_t *shape, const ylm_slice *slice, size_t *start) {
  size_t at = 0;
  int i = 0;
  for (int k = 0; k < axes; k++) at = at * shape[k] + slice[k].first;
  *start = at;
  while (i < axes && slice[i].count == 1) i++;
  if (i < axes && slice[i].step != 1) return false;
  for (i++; i < axes; i++)
    if (slice[i].first != 0 || slice[i].step != 1 || slice[i].count != shape[i]) return false;
  return true;
}

typedef struct walk {
  int axes;
  const size_t *shape;
  const ylm_slice *slice;
  size_t size;
  char *dense;
  bool out; /* from the array to dense, else back */
} walk;

/* n elements of `step` elements each apart, to or from dense ones. */
#define ELEMENTS(T)                                                                                \
  static void elements_##T(size_t n, ptrdiff_t step, T *array, T *dense, bool out) {               \
    if (out)                                                                                       \
      for (size_t i = 0; i < n; i++) dense[i] = array[(ptrdiff_t)i * step];                        \
    else                                                                                           \
      for (size_t i = 0; i < n; i++) array[(ptrdiff_t)i * step] = dense[i];                        \
  }
ELEMENTS(uint16_t)
ELEMENTS(uint32_t)
ELEMENTS(uint64_t)

/* Axis k, of whose part `array` is the beginning. */
static void each(walk *w, int k, char *array) {
  const ylm_slice *s = &w->slice[k];
  size_t stride = w->size;
  for (int i = k + 1; i < w->axes; i++) stride *= w->shape[i];
  array += s->first * stride;
  if (k < w->axes - 1) {
    for (size_t i = 0; i < s->count; i++)
      each(w, k + 1, array + (ptrdiff_t)i * s->step * (ptrdiff_t)stride);
    return;
  }
  if (w->size == 8)
    elements_uint64_t(s->count, s->step, (uint64_t *)(void *)array, (uint64_t *)(void *)w->dense,
                      w->out);
  else if (w->size == 4)
    elements_uint32_t(s->count, s->step, (uint32_t *)(void *)array, (uint32_t *)(void *)w->dense,
                      w->out);
  else
    elements_uint16_t(s->count, s->step, (uint16_t *)(void *)array, (uint16_t *)(void *)w->dense,
                      w->out);
  w->dense += s->count * w->size;
}

static bool any(int axes, const ylm_slice *slice) {
  for (int i = 0; i < axes; i++)
    if (slice[i].count == 0) return false;
  return true;
}

void ylm_slices_gather(int axes, const size_t *shape, const ylm_slice *slice, size_t size,
                       const void *array, void *dense) {
  walk w = {axes, shape, slice, size, dense, true};
  if (any(axes, slice)) each(&w, 0, (char *)(uintptr_t)array);
}

void ylm_slices_scatter(int axes, const size_t *shape, const ylm_slice *slice, size_t size,
                        void *array, const void *dense) {
  walk w = {axes, shape, slice, size, (char *)(uintptr_t)dense, false};
  if (any(axes, slice)) each(&w, 0, array);
}
