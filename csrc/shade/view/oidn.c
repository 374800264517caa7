/*
** oidn.c - a picture without its noise by Intel's Open Image Denoise, which is opened at run time.
**
** No header of it is needed: the few functions of its C interface, versions 1 and 2, are declared here.
**
** Source  Open Image Denoise, https://www.openimagedenoise.org (Apache 2.0), its documentation's "RT" filter
*/
#include <dlfcn.h>
#include <stdlib.h>

#include "ylm_shade.h"

enum { DEVICE_DEFAULT = 0, FORMAT_FLOAT3 = 3 };

typedef struct oidn {
  void *library;
  void *(*new_device)(int type);
  void (*commit_device)(void *device);
  int (*device_error)(void *device, const char **message);
  void (*release_device)(void *device);
  void *(*new_filter)(void *device, const char *type);
  void (*set_image)(void *filter, const char *name, void *data, int format, size_t width,
                    size_t height, size_t offset, size_t pixel_stride, size_t row_stride);
  void (*set_bool)(void *filter, const char *name, bool value);
  void (*commit_filter)(void *filter);
  void (*execute_filter)(void *filter);
  void (*release_filter)(void *filter);
} oidn;

/* A function of the library, by its name in version 2 or, if that is another, in version 1. A function pointer through a
   pointer to it: ISO C has no cast from void *. */
static bool find(const oidn *o, void *to, const char *name, const char *older) {
  void *found = dlsym(o->library, name);
  if (!found && older) found = dlsym(o->library, older);
  *(void **)to = found;
  return found != NULL;
}

static ylm_status open_library(oidn *o, ylm_error *e) {
  static const char *const known[] = {"libOpenImageDenoise.so.2", "libOpenImageDenoise.so.1",
                                      "libOpenImageDenoise.so"};
  const char *asked = getenv("YLM_OIDN_LIBRARY");
  if (asked && *asked) o->library = dlopen(asked, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  for (size_t i = 0; !(asked && *asked) && !o->library && i < sizeof known / sizeof *known; i++)
    o->library = dlopen(known[i], RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (!o->library)
    return ylm_fail(e, YLM_EMISSING,
                    "Open Image Denoise is not installed: %s cannot be opened "
                    "(https://www.openimagedenoise.org; YLM_OIDN_LIBRARY names the file)",
                    asked && *asked ? asked : known[0]);
  bool all = find(o, &o->new_device, "oidnNewDevice", NULL) &&
             find(o, &o->commit_device, "oidnCommitDevice", NULL) &&
             find(o, &o->device_error, "oidnGetDeviceError", NULL) &&
             find(o, &o->release_device, "oidnReleaseDevice", NULL) &&
             find(o, &o->new_filter, "oidnNewFilter", NULL) &&
             find(o, &o->set_image, "oidnSetSharedFilterImage", NULL) &&
             find(o, &o->set_bool, "oidnSetFilterBool", "oidnSetFilter1b") &&
             find(o, &o->commit_filter, "oidnCommitFilter", NULL) &&
             find(o, &o->execute_filter, "oidnExecuteFilter", NULL) &&
             find(o, &o->release_filter, "oidnReleaseFilter", NULL);
  if (all) return YLM_OK;
  dlclose(o->library);
  return ylm_fail(e, YLM_EMISSING, "%s is no Open Image Denoise",
                  asked && *asked ? asked : known[0]);
}

/* The first error of a device since it was asked; NULL: why none was made. */
static ylm_status error_of(const oidn *o, void *device, ylm_error *e) {
  const char *message = NULL;
  if (o->device_error(device, &message) == 0 && device) return YLM_OK;
  return ylm_fail(e, YLM_EDEVICE, "Open Image Denoise: %s",
                  message && *message ? message : "there is no device");
}

static void set_image(const oidn *o, void *filter, const char *name, const float *data, int width,
                      int height) {
  if (data) /* inputs are only read */
    o->set_image(filter, name, (void *)data, FORMAT_FLOAT3, (size_t)width, (size_t)height, 0, 0, 0);
}

static ylm_status run(const oidn *o, void *device, const ylm_shade_picture *p, float *out,
                      ylm_error *e) {
  o->commit_device(device);
  ylm_status s = error_of(o, device, e);
  void *filter = s == YLM_OK ? o->new_filter(device, "RT") : NULL;
  if (s == YLM_OK && !filter) s = error_of(o, device, e);
  if (!filter) return s == YLM_OK ? YLM_EDEVICE : s;
  set_image(o, filter, "color", p->radiance, p->width, p->height);
  set_image(o, filter, "albedo", p->albedo, p->width, p->height);
  set_image(o, filter, "normal", p->normal, p->width, p->height);
  set_image(o, filter, "output", out, p->width, p->height);
  o->set_bool(filter, "hdr", true);
  o->commit_filter(filter);
  o->execute_filter(filter);
  s = error_of(o, device, e);
  o->release_filter(filter);
  return s;
}

ylm_status ylm_shade_oidn(const ylm_shade_picture *p, float *out, ylm_error *e) {
  oidn o = {0};
  ylm_status s = open_library(&o, e);
  if (s != YLM_OK) return s;
  void *device = p ? o.new_device(DEVICE_DEFAULT) : NULL;
  if (p) s = device ? run(&o, device, p, out, e) : error_of(&o, NULL, e);
  if (device) o.release_device(device);
  dlclose(o.library);
  return s;
}
