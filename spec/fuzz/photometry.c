/* photometry.c - fuzzes the readers of IES LM-63 and EULUMDAT, what their tables answer, and the writers. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ylm_light_photometry.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Tables of more numbers are slow, and no different. */
#define MANY 400

/* Claims about every table. */
static void look(const ylm_light_photometry_file *f, bool linear) {
  ylm_light_photometry_grid g = {f->angles, f->planes, f->angle, f->plane, f->candela, linear};
  ylm_light_photometry *p;
  if (ylm_light_photometry_create(&g, &p, NULL) != YLM_OK) return;
  double flux = ylm_light_photometry_flux(p, 0, 180);
  if (!(flux >= 0) || !isfinite(flux)) abort();
  for (int i = 0; i < 8; i++) {
    const double u[2] = {(i + 0.5) / 8, (i * 5 % 8 + 0.5) / 8};
    double way[3] = {0, 0, 1}, cd, gradient[3], hessian[6];
    double density = ylm_light_photometry_sample(p, u, way);
    if (!(density >= 0)) abort();
    ylm_light_photometry_intensity(p, 1, (const double(*)[3])way, &cd, &gradient, &hessian);
    if (!(cd >= 0) || !isfinite(cd)) abort();
  }
  ylm_light_photometry_free(p);
}

/* A file that is written can be read. */
static void write_and_read(const ylm_light_photometry_file *f, bool ldt) {
  char *bytes;
  size_t size;
  ylm_light_photometry_file again;
  ylm_light_photometry_form form = {.lamps = 1, .tilt = NAN};
  if (ylm_light_photometry_write(f, ldt, &bytes, &size, NULL) != YLM_OK) return;
  if (ylm_light_photometry_read((unsigned char *)bytes, size, "again", &form, &again, NULL) ==
      YLM_OK)
    ylm_light_photometry_file_free(&again);
  ylm_free(bytes);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static const unsigned char factors[] = "1 2 0 90 1 0.5";
  ylm_light_photometry_file f;
  ylm_error e = {0};
  ylm_light_photometry_form form = {
      .lamps = 1, .tilt = 30, .factors = factors, .factors_size = sizeof factors - 1};
  ylm_status s = ylm_light_photometry_read(data, size, "fuzzed", &form, &f, &e);
  if (s != YLM_OK) {
    if (!e.text[0]) abort(); /* a sentence */
    return 0;
  }
  if (f.angles * f.planes <= MANY) {
    look(&f, size % 2);
    write_and_read(&f, size % 3 == 0);
  }
  ylm_light_photometry_file_free(&f);
  return 0;
}
