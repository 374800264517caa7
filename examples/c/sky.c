/*
** sky.c - spherical harmonics of an environment image, twice as wide as high, and of the irradiance under it.
**
**     cc sky.c $(pkg-config --cflags --libs ylm_codec) -o sky && ./sky env.hdr
**
** Prints nine rows: radiance r g b, irradiance r g b. The pole is +y, the middle of the image -z.
** C11 and C++17.
*/
#include <stdio.h>

#include <ylm/ylm_codec.h>
#include <ylm/ylm_sh.h>

enum { LMAX = 2, COUNT = (LMAX + 1) * (LMAX + 1) };

/* The projection of the image's first layer: out [channels][COUNT]. */
static ylm_status project(const ylm_image *image, double *out, ylm_error *e) {
  const ylm_layer *layer = &image->layer[0];
  int width = image->width, height = image->height;
  size_t n = (size_t)width * (size_t)height, numbers = n * (size_t)layer->channels;
  double *direction = (double *)ylm_alloc(n, 3 * sizeof(double));
  double *solid_angle = (double *)ylm_alloc(n, sizeof(double));
  double *value = (double *)ylm_alloc(numbers, sizeof(double));
  ylm_status s = direction && solid_angle && value ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK && !ylm_mapping_fits(YLM_MAPPING_LATLONG, width, height))
    s = ylm_fail(e, YLM_ESHAPE, "%d x %d pixels: the image must be twice as wide as high", width,
                 height);
  if (s == YLM_OK)
    s = ylm_mapping_pixels(YLM_MAPPING_LATLONG, YLM_UP_Y, width, height, direction, solid_angle);
  for (size_t i = 0; s == YLM_OK && i < numbers; i++) value[i] = layer->data[i];
  if (s == YLM_OK)
    s = ylm_sh_project_samples(LMAX, n, direction, solid_angle, layer->channels, value, out, NULL,
                               0, NULL, e);
  ylm_free(value);
  ylm_free(solid_angle);
  ylm_free(direction);
  return s;
}

int main(int argc, char **argv) {
  static const double cosine[LMAX + 1] = {3.14159265358979324, 2.09439510239319549,
                                          0.785398163397448310};
  double c[4][COUNT]; /* an image has 4 channels at most */
  ylm_error error = {YLM_OK, ""};
  ylm_image *image = NULL;
  if (argc != 2) return fprintf(stderr, "usage: sky IMAGE\n"), 2;
  ylm_status s = ylm_codec_read(argv[1], NULL, &image, &error);
  if (s == YLM_OK) s = project(image, c[0], &error);
  if (s != YLM_OK)
    fprintf(stderr, "sky: %s\n", error.status == s ? error.text : ylm_status_text(s));
  int channels = s == YLM_OK && image->layer[0].channels >= 3 ? 3 : 1;
  for (int l = 0, i = 0; s == YLM_OK && l <= LMAX; l++)
    for (int m = -l; m <= l; m++, i++) {
      printf("%d %2d", l, m);
      for (int k = 0; k < channels; k++) printf(" %12.9f", c[k][i]);
      for (int k = 0; k < channels; k++) printf(" %12.9f", cosine[l] * c[k][i]);
      printf("\n");
    }
  ylm_image_free(image);
  return s == YLM_OK ? 0 : 1;
}
