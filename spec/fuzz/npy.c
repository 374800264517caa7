/* npy.c - fuzzes the .npy reader. */
#include "ylm_numbers.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  ylm_error e;
  ylm_array_file a;
  if (ylm_array_file_parse(data, size, "fuzz", &a, &e) != YLM_OK) return 0;
  void *copy = ylm_alloc(a.count, ylm_numbers_size(a.dtype));
  if (copy) ylm_array_file_copy(&a, copy);
  ylm_free(copy);
  return 0;
}
