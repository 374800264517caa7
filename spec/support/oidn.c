/* oidn.c - a stand-in for Open Image Denoise, which says what it was asked for: the functions that csrc/shade/view/oidn.c calls.
   Its picture is colour + 2 albedo + 4 normal, so that a spec can tell which layer went where. STAND_IN_FAILS: it fails. */
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

static struct {
  const float *colour, *albedo, *normal;
  float *output;
  size_t width, height;
  bool hdr, committed;
} filter;
static int device, error;
static const char *message;

static void fail(int code, const char *text) { error = code, message = text; }

void *oidnNewDevice(int type) { return type == 0 ? &device : NULL; }
void oidnCommitDevice(void *d) { device += d == &device; }
void oidnReleaseDevice(void *d) { device -= d == &device; }
int oidnGetDeviceError(void *d, const char **text) {
  int code = error;
  (void)d;
  if (text) *text = message;
  error = 0;
  return code;
}
void *oidnNewFilter(void *d, const char *type) {
  memset(&filter, 0, sizeof filter);
  return d == &device && device > 0 && strcmp(type, "RT") == 0 ? &filter : NULL;
}
void oidnSetSharedFilterImage(void *f, const char *name, void *data, int format, size_t width,
                              size_t height, size_t offset, size_t pixel, size_t row) {
  if (f != &filter || format != 3 || offset || pixel || row) fail(2, "a bad image");
  if (filter.width && (width != filter.width || height != filter.height)) fail(2, "sizes differ");
  filter.width = width, filter.height = height;
  if (strcmp(name, "color") == 0) filter.colour = data;
  if (strcmp(name, "albedo") == 0) filter.albedo = data;
  if (strcmp(name, "normal") == 0) filter.normal = data;
  if (strcmp(name, "output") == 0) filter.output = data;
}
void STAND_IN_BOOL(void *f, const char *name, bool value) {
  if (f == &filter && strcmp(name, "hdr") == 0) filter.hdr = value;
}
void oidnCommitFilter(void *f) { filter.committed = f == &filter; }
void oidnExecuteFilter(void *f) {
  if (f != &filter || !filter.committed || !filter.hdr || !filter.output || !filter.colour)
    fail(3, "not ready");
  if (getenv("STAND_IN_FAILS")) fail(4, "no memory for the network");
  if (error) return;
  for (size_t i = 0; i < 3 * filter.width * filter.height; i++)
    filter.output[i] = filter.colour[i] + 2 * (filter.albedo ? filter.albedo[i] : 0) +
                       4 * (filter.normal ? filter.normal[i] : 0);
}
void oidnReleaseFilter(void *f) { (void)f; }
