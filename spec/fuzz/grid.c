/*
** grid.c - fuzzes the reader of grid files.
**
** Mutations get a size and checksums that fit, or else nothing behind them would ever be reached;
** one in sixteen goes through as it is. Most mutations are of one section,
** whose size they keep. Accepted files must be safe to sample and, saved, be accepted again.
*/
#include <math.h>
#include <string.h>

#include "../../csrc/grid/file/file.h"
#include "ylm_light.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
extern size_t fuzz_accepted;
size_t fuzz_accepted; /* inputs that were read */
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t room);

#ifndef FUZZ_LIBRARY /* the library as it is built */

/* The kernels are not what is fuzzed: all sets are the reference. */
#define KERNEL(isa)                                                                                \
  void ylm_k_grid_sample_##isa(const sample_batch *b) { ylm_k_grid_sample_reference(b); }
YLM_SETS(KERNEL)

/* Nor are lights: grids from files have none, and what would need them traps. */
void ylm_light_set_free(ylm_light_set *set) {
  if (set) __builtin_trap();
}
void ylm_light_list_free(ylm_light_list *list) {
  if (list->n) __builtin_trap();
}
void ylm_light_sweep(ylm_light_shapes *shapes) {
  if (shapes->n) __builtin_trap();
}
const ylm_field *ylm_light_set_field(const ylm_light_set *set) {
  (void)set;
  __builtin_trap();
}
ylm_status ylm_light_set_list(const ylm_light_set *set, ylm_light_list *list) {
  (void)set, (void)list;
  __builtin_trap();
}
ylm_status ylm_light_set_of(size_t n, const ylm_light *const *light, const double *strength,
                            ylm_light_set **set) {
  (void)n, (void)light, (void)strength, (void)set;
  __builtin_trap();
}
ylm_status ylm_light_keep(ylm_light_shapes *shapes, ylm_light *l) {
  (void)shapes, (void)l;
  __builtin_trap();
}
void ylm_light_mark(const ylm_light *l) {
  (void)l;
  __builtin_trap();
}
int ylm_light_compare(const ylm_light *a, const ylm_light *b) {
  (void)a, (void)b;
  __builtin_trap();
}
bool ylm_light_alike(const ylm_light *a, const ylm_light *b) {
  (void)a, (void)b;
  __builtin_trap();
}
bool ylm_light_slides(const ylm_light *a, const ylm_light *b) {
  (void)a, (void)b;
  __builtin_trap();
}
void ylm_light_box(const ylm_light *l, double box[6]) {
  (void)l, (void)box;
  __builtin_trap();
}
ylm_status ylm_light_bounds_meet(ylm_light_bounds *b, size_t n, const ylm_light *light,
                                 ylm_error *e) {
  (void)b, (void)n, (void)light, (void)e;
  __builtin_trap();
}
bool ylm_light_bounds_add(const ylm_light_bounds *bounds, const ylm_light *a, const ylm_light *b,
                          bool slides, const double p[3], double bound[3]) {
  (void)bounds, (void)a, (void)b, (void)slides, (void)p, (void)bound;
  __builtin_trap();
}

#endif

/* How many entries of the table are there; 0: the file is none of ylm. */
static size_t sections(const uint8_t *data, size_t size) {
  grid_file_header h;
  if (size < sizeof h) return 0;
  memcpy(&h, data, sizeof h);
  size_t room = (size - sizeof h) / sizeof(grid_file_entry);
  return h.order != GRID_FILE_ORDER ? 0 : h.sections < room ? h.sections : room;
}

static grid_file_entry entry_of(const uint8_t *data, size_t i) {
  grid_file_entry entry;
  memcpy(&entry, data + sizeof(grid_file_header) + i * sizeof entry, sizeof entry);
  return entry;
}

static bool inside(const grid_file_entry *entry, size_t size) {
  return entry->offset <= size && entry->size <= size - entry->offset;
}

/* Size and checksums of a file with n sections. */
static void seal_sections(uint8_t *data, size_t size, size_t n) {
  grid_file_header h;
  for (size_t i = 0; i < n; i++) {
    grid_file_entry entry = entry_of(data, i);
    if (inside(&entry, size)) entry.crc = ylm_crc64(0, data + entry.offset, entry.size);
    memcpy(data + sizeof h + i * sizeof entry, &entry, sizeof entry);
  }
  memcpy(&h, data, sizeof h);
  h.size = size;
  h.crc = ylm_crc64(0, &h, offsetof(grid_file_header, crc));
  h.crc = ylm_crc64(h.crc, data + sizeof h, n * sizeof(grid_file_entry));
  memcpy(data, &h, sizeof h);
}

/* Changes one section, and not its size. */
static void mutate_section(uint8_t *data, size_t size, unsigned which) {
  grid_file_entry entry = entry_of(data, which);
  if (!inside(&entry, size) || !entry.size) return;
  uint8_t *section = data + entry.offset;
  size_t left = LLVMFuzzerMutate(section, entry.size, entry.size);
  if (left < entry.size) memset(section + left, 0, entry.size - left);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed) {
  size_t n = sections(data, size);
  if (n && seed % 16 > 3)
    mutate_section(data, size, seed / 16 % (unsigned)n);
  else
    size = LLVMFuzzerMutate(data, size, room);
  if (size < 40 || seed % 16 == 0) return size;
  n = sections(data, size);
  if (n) seal_sections(data, size, n);
  return size;
}

/* Samples a grid inside, outside, and at its corners. */
static void sample(const ylm_grid *g) {
  const double *b = ylm_grid_look(g)->form.bounds;
  double points[8][3];
  for (int i = 0; i < 8; i++)
    for (int a = 0; a < 3; a++) {
      double t = i < 4 ? 0.37 * (i + 1) - 0.1 * a : i - 5;
      points[i][a] = b[a] + t * (b[a + 3] - b[a]);
      if (!isfinite(points[i][a])) points[i][a] = 0;
    }
  size_t width = (size_t)ylm_grid_look(g)->count * (size_t)ylm_grid_look(g)->form.channels;
  float *value = ylm_alloc(8 * 4 * width, sizeof *value);
  ylm_grid_query q = {.point_dtype = YLM_DOUBLE, .dtype = YLM_FLOAT, .threads = 1};
  bool sampled =
      value && ylm_grid_sample(g, &q, 8, points, value, value + 8 * width, NULL, NULL) == YLM_OK;
  for (size_t i = 0; sampled && i < 8 * width; i++)
    if (isnan(value[i])) __builtin_trap();
  ylm_free(value);
  for (int i = 0; i < 8; i++) ylm_grid_locate(g, points[i], i & 1, NULL);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  ylm_error e;
  ylm_grid *g;
  if (ylm_grid_decode(data, size, "fuzz", &g, &e) != YLM_OK) {
    if (g) __builtin_trap();
    return 0;
  }
  fuzz_accepted++;
  sample(g);
  unsigned char *once, *twice;
  size_t bytes, more;
  ylm_grid *h;
  if (ylm_grid_encode(g, &once, &bytes, &e) == YLM_OK) {
    ylm_status s = ylm_grid_decode(once, bytes, "again", &h, &e);
    if (s != YLM_OK && s != YLM_ENOMEM) __builtin_trap();
    if (s == YLM_OK && ylm_grid_encode(h, &twice, &more, &e) == YLM_OK) {
      if (more != bytes || memcmp(once, twice, bytes) != 0) __builtin_trap();
      ylm_free(twice);
    }
    ylm_grid_free(s == YLM_OK ? h : NULL);
    ylm_free(once);
  }
  ylm_grid_free(g);
  return 0;
}
