/*
** ylm_image.h - rasters of named float layers, and what is computed from them.
**
** Pixels are linear (Rec. 709 where they are colours); pixel (0, 0) is the top left
** corner; the sample of pixel (x, y) lies at (x + 1/2, y + 1/2). Nothing here
** knows a file format (csrc/codec does) or draws on a screen.
*/
#ifndef YLM_IMAGE_H
#define YLM_IMAGE_H

#include <math.h>

#include "ylm_base.h"

#ifdef __cplusplus
extern "C" {
#endif

#define YLM_IMAGE_MAX_SIDE 65536
#define YLM_IMAGE_MAX_PIXELS ((size_t)1 << 29)
#define YLM_IMAGE_MAX_LAYERS 64
#define YLM_IMAGE_MAX_NAME 64 /* bytes of a layer's name, without the final 0 */

/* -- rasters ------------------------------------------------------------------ */

typedef struct ylm_layer {
  char name[YLM_IMAGE_MAX_NAME + 1];
  int channels; /* 1 .. 4 */
  float *data;  /* [height][width][channels] */
} ylm_layer;

typedef struct ylm_text {
  char *key, *value;
} ylm_text;

/* The first layer is the picture, by habit "radiance". */
typedef struct ylm_image {
  int width, height; /* 1 .. YLM_IMAGE_MAX_SIDE */
  int layers, texts;
  ylm_layer layer[YLM_IMAGE_MAX_LAYERS];
  ylm_text *text; /* metadata, by key: equal images are equal files */
} ylm_image;

/* An image without layers. YLM_ERANGE (a side), YLM_EOVERFLOW (too many pixels), YLM_ENOMEM. */
YLM_API ylm_status ylm_image_create(int width, int height, ylm_image **image, ylm_error *e);
YLM_API void ylm_image_free(ylm_image *image);
/*
** ylm_image_add - a further layer of zeros.
**
**   name      in  1 .. YLM_IMAGE_MAX_NAME bytes of letters, digits, '_', '-', '.', that no other layer has
**   channels  in  1 .. 4
**
** Returns  YLM_OK; YLM_EINVAL (name), YLM_ERANGE (channels, too many layers), YLM_ENOMEM
*/
YLM_API ylm_status ylm_image_add(ylm_image *image, const char *name, int channels, ylm_error *e);
/* The layer of that name (NULL: the first), or NULL. */
YLM_API ylm_layer *ylm_image_find(const ylm_image *image, const char *name);
/* Sets (value NULL: removes) a metadata entry. Keys: 1 .. 255 bytes. YLM_EINVAL, YLM_ENOMEM. */
YLM_API ylm_status ylm_image_set_text(ylm_image *image, const char *key, const char *value);
/* The entry's value, or NULL. */
YLM_API const char *ylm_image_get_text(const ylm_image *image, const char *key);

/* -- pictures from pictures --------------------------------------------------- */

/* The rectangle at (x, y), every layer and the metadata. YLM_ERANGE if it leaves the image. */
YLM_API ylm_status ylm_image_crop(const ylm_image *in, int x, int y, int width, int height,
                                  ylm_image **out, ylm_error *e);

typedef enum ylm_filter { YLM_FILTER_BOX, YLM_FILTER_LINEAR, YLM_FILTER_LANCZOS } ylm_filter;

/*
** ylm_image_resize - every layer at another size.
**
** The filter is widened by the reduction, so that shrinking averages; enlarging with
** YLM_FILTER_BOX repeats pixels. At edges the weights that remain are normalised.
** Source  separable; Lanczos with three lobes (Duchon 1979)
*/
YLM_API ylm_status ylm_image_resize(const ylm_image *in, int width, int height, ylm_filter filter,
                                    int threads, const ylm_progress *progress, ylm_image **out,
                                    ylm_error *e);
/*
** ylm_image_paste - copies layer `from` of `source` into layer `to` of `target` at (x, y).
**
** Parts outside the target are cut off. `mask` (NULL: everywhere) is [height][width] of the
** source, 0 keeps the target, 1 replaces it, between mixes. Channels: equal, or 1 into many.
** Returns  YLM_OK; YLM_EINVAL (no such layer), YLM_ESHAPE (channels)
*/
YLM_API ylm_status ylm_image_paste(ylm_image *target, const char *to, int x, int y,
                                   const ylm_image *source, const char *from, const float *mask,
                                   ylm_error *e);
/* Fills a rectangle (cut to the image) of a layer with `colour` [channels]. */
YLM_API ylm_status ylm_image_fill(ylm_image *image, const char *layer, int x, int y, int width,
                                  int height, const float *colour, ylm_error *e);
/*
** ylm_image_write_text - ASCII text in a built-in 5 x 7 font.
**
** (x, y) is the top left corner; a character cell is 6*scale by 9*scale pixels; '\n' begins a new
** line; other characters than printable ASCII become boxes. Parts outside the image are cut off.
*/
YLM_API ylm_status ylm_image_write_text(ylm_image *image, const char *layer, int x, int y,
                                        int scale, const char *text, const float *colour,
                                        ylm_error *e);
/* Its size in pixels. */
YLM_API void ylm_image_measure_text(const char *text, int scale, int *width, int *height);

/* -- tone curves -------------------------------------------------------------- */

/*
** From linear radiance to what a file with 8 or 16 bits shows, 0 .. 1.
**   srgb    the sRGB encoding (IEC 61966-2-1), cut at 1
**   linear  the number itself, cut to 0 .. 1: for data, not for looking at
**   hable   the filmic curve of Uncharted 2 (Hable 2010), exposure bias 2, white 11.2, then sRGB
**   aces    a fit of the ACES filmic curve (Narkowicz 2015), then sRGB
**   reinhard  x/(1+x) per channel (Reinhard et al. 2002, Eq. 3), then sRGB
*/
#define YLM_TONE_LIST(X) X(srgb) X(linear) X(hable) X(aces) X(reinhard)

typedef enum ylm_tone {
#define X(name) YLM_TONE_##name,
  YLM_TONE_LIST(X)
#undef X
      YLM_TONE_COUNT
} ylm_tone;

YLM_API const char *ylm_tone_name(ylm_tone curve);
/* True if `name` is that of a curve. */
YLM_API bool ylm_tone_find(const char *name, ylm_tone *curve);
/* One number; NaN gives 0. */
YLM_API float ylm_tone_apply(ylm_tone curve, float x);
/* y = curve(2^stops * x) for n numbers; may be in place. */
YLM_API void ylm_tone_map(ylm_tone curve, double stops, size_t n, const float *x, float *y);
/* From sRGB-encoded 0 .. 1 back to linear. */
YLM_API float ylm_tone_decode_srgb(float x);

/* How a picture is exposed: parts of its pixels that are shown as black and as white under `stops`. */
typedef struct ylm_exposure {
  double stops, black, white;
} ylm_exposure;

/*
** ylm_image_expose - the exposure under which a picture is seen well.
**
** The mean logarithm of luminance becomes that of 0.18. Black pixels are left out, those of lamps (layer "emitter"), and
** those 16 times as bright as the others are: windows, patches of sun. Pixels darker than a thousandth of that mean count as
** one. A layer of one channel or two is taken by its first.
**
**   layer  in  NULL: the first
**   stops  in  NULL, or the exposure that is asked about instead
**
** Returns  YLM_OK; YLM_EINVAL: no such layer. A picture without light has 0 stops
** Source   Reinhard et al. 2002, Eqs. 1-2
*/
YLM_API ylm_status ylm_image_expose(const ylm_image *image, const char *layer, const double *stops,
                                    ylm_exposure *out, ylm_error *e);

/* -- colour maps -------------------------------------------------------------- */

/*
** viridis, magma: cubics through 17 colours each of the CC0 maps of Smith, van der Walt and
** Firing (2015), within 0.005 of them; coolwarm: a diverging map of our own, blue - light grey -
** red, alike in OKLab lightness on both sides; grey. Numbers are sRGB-encoded.
*/
#define YLM_COLOURMAP_LIST(X) X(viridis) X(magma) X(coolwarm) X(grey)

typedef enum ylm_colourmap {
#define X(name) YLM_COLOURMAP_##name,
  YLM_COLOURMAP_LIST(X)
#undef X
      YLM_COLOURMAP_COUNT
} ylm_colourmap;

YLM_API const char *ylm_colourmap_name(ylm_colourmap map);
YLM_API bool ylm_colourmap_find(const char *name, ylm_colourmap *map);
/* The sRGB-encoded colour at t, cut to 0 .. 1; NaN gives magenta. */
YLM_API void ylm_colourmap_at(ylm_colourmap map, double t, float rgb[3]);

/*
** ylm_image_false_colour - a layer's numbers as colours, in linear rgb (so that the tone curve
** "srgb" shows the map's own colours).
**
** Several channels count by their Rec. 709 luminance (3, 4) or their first (2). The range is
** lo .. hi with lo < hi; with `log`, lo > 0.
*/
YLM_API ylm_status ylm_image_false_colour(const ylm_image *in, const char *layer, ylm_colourmap map,
                                          double lo, double hi, bool log, ylm_image **out,
                                          ylm_error *e);

/* -- metrics ------------------------------------------------------------------ */

/*
** How far an image is from a reference. Sums run over all channels of all pixels whose mask is
** not 0; in double, in blocks whose order does not depend on the number of threads.
**   mse, rmse  mean of squared differences, its root
**   peak       what psnr refers to: as asked for, else the largest absolute reference value
**   psnr       10 log10(peak^2 / mse) dB; infinite where mse is 0
**   mae, max   mean and largest absolute difference
**   mape       mean of |a - b| / max(|b|, floor), in percent; the floor as asked for, else
**              peak / 1000
**   relmse     mean of (a - b)^2 / (b^2 + epsilon) (Rousselle et al. 2011); epsilon as asked for,
**              else 0.01
**   ssim       mean structural similarity (Wang et al. 2004) over pixels of the mask and channels:
**              Gaussian window, sigma 1.5, 11 x 11, cut at the edges and normalised,
**              K1 = 0.01, K2 = 0.03, dynamic range = peak
*/
typedef struct ylm_metrics {
  double mse, rmse, psnr, peak, mae, mape, floor, relmse, epsilon, ssim, max;
  size_t pixels; /* that counted */
} ylm_metrics;

/*
** ylm_image_compare - metrics of layer `name` (NULL: the first) of `a` against that of `b`.
**
**   mask   in  [height][width] or NULL: everywhere
**   peak   in  > 0, or 0: from the reference
**   floor  in  > 0, or 0: peak / 1000
**   epsilon  in  > 0, or 0: 0.01
**   progress   in  may be NULL
**
** Returns  YLM_OK; YLM_EINVAL (no such layer, an empty mask), YLM_ESHAPE (sizes, channels),
**          YLM_EDOMAIN (a number that counts is not finite: the pixel is named), YLM_ENOMEM,
**          YLM_ECANCELLED
*/
YLM_API ylm_status ylm_image_compare(const ylm_image *a, const ylm_image *b, const char *name,
                                     const float *mask, double peak, double floor, double epsilon,
                                     int threads, const ylm_progress *progress, ylm_metrics *m,
                                     ylm_error *e);

/* The parameters of ylm_image_flip, and its results behind them. */
typedef struct ylm_flip {
  double pixels_per_degree; /* 67.02: 0.7 m before a screen of 0.7 m with 3840 pixels */
  bool hdr;                 /* pictures of radiance; else 0 .. 1, linear, cut off there */
  double start, stop; /* hdr: first and last exposure, stops; NAN: as the reference asks for */
  int exposures;      /* from start to stop: 2, or one for each stop */
  double mean, max;
} ylm_flip;

/*
** ylm_image_flip - how different two pictures look when they alternate on a screen, 0 .. 1.
**
** Layers of less than 3 channels are grey, a fourth channel is left out; negative numbers are 0.
** Edges repeat. Pixels that the mask leaves out are seen beside others, black where they are not
** finite; the map is 0 there.
**
**   o     in/out  parameters, results
**   mask  in      [height][width] or NULL: everywhere
**   map   out     an image of one layer "flip" of one channel
**
** Returns  YLM_OK; as ylm_image_compare, YLM_ERANGE (pixels per degree, start above stop)
** Cost     80 bytes a pixel, some 2 us a pixel, exposure and thread
** Source   Andersson et al. 2020, 2021: csrc/image/flip.c
*/
YLM_API ylm_status ylm_image_flip(const ylm_image *a, const ylm_image *b, const char *name,
                                  const float *mask, ylm_flip *o, int threads,
                                  const ylm_progress *progress, ylm_image **map, ylm_error *e);

/*
** How far two estimates are apart, in terms of their noise: sums run over all channels of all pixels
** whose mask is not 0.
**   z2        sum of (a - b)^2 over the sum of the variances of both: its expectation is 1 where
**             both are unbiased estimates of one picture, however many samples they have
**   z2_block  the largest such ratio over blocks of 16 x 9 pixels: bias that is local
**   block     the left and top pixel of that block
*/
typedef struct ylm_agreement {
  double z2, z2_block;
  int block[2];
  size_t pixels; /* that counted */
} ylm_agreement;

/*
** ylm_image_agree - whether layer `name` (NULL: the first) of `a` and that of `b` agree within their
** layers `variance`, the variances of what stands there. An image without one is taken as exact.
**
**   mask   in  [height][width] or NULL: everywhere
**
** Returns  YLM_OK; YLM_EINVAL (no such layer, no variance in either, an empty mask), YLM_ESHAPE
**          (sizes, channels), YLM_EDOMAIN (a number that counts is not finite, or a variance
**          negative: the pixel is named)
*/
YLM_API ylm_status ylm_image_agree(const ylm_image *a, const ylm_image *b, const char *name,
                                   const float *mask, ylm_agreement *out, ylm_error *e);

typedef enum ylm_difference {
  YLM_DIFFERENCE_ABSOLUTE, /* |a - b| * scale                   */
  YLM_DIFFERENCE_SIGNED,   /* (a - b) * scale                   */
  YLM_DIFFERENCE_RELATIVE  /* |a - b| / max(|b|, floor) * scale */
} ylm_difference;

/* An image of one layer with the difference of two; errors as ylm_image_compare (floor > 0). */
YLM_API ylm_status ylm_image_difference(const ylm_image *a, const ylm_image *b, const char *name,
                                        ylm_difference kind, double scale, double floor,
                                        ylm_image **out, ylm_error *e);

/* -- images of the sphere ----------------------------------------------------- */

/*
** latlong  the whole sphere, width = 2*height by habit: rows from the pole down
** angular  the whole sphere in a disc (Debevec's light probe): angle from the middle
**          proportional to the radius; corners see nothing
** cube     six faces in a column, height = 6*width: +x -x +y -y +z -z, each oriented as OpenGL
**          does (independent of `up`)
** All are seen from inside: to turn right is to go right.
** up z: the pole is +z, the middle of the image +x.  up y: the pole is +y, the middle -z.
*/
typedef enum ylm_mapping { YLM_MAPPING_LATLONG, YLM_MAPPING_ANGULAR, YLM_MAPPING_CUBE } ylm_mapping;
typedef enum ylm_up { YLM_UP_Z, YLM_UP_Y } ylm_up;

/* Unit direction of image position (x, y) in pixels (a pixel's middle is at + 1/2); false and
   zeros outside of the disc. */
YLM_API bool ylm_mapping_direction(ylm_mapping m, ylm_up up, int width, int height, double x,
                                   double y, double d[3]);
/* The image position of a direction of any length but 0; false for a zero or non-finite one. */
YLM_API bool ylm_mapping_position(ylm_mapping m, ylm_up up, int width, int height,
                                  const double d[3], double *x, double *y);
/* Whether an image of the whole sphere may have this size: latlong twice as wide as high, angular as
   wide as high. */
YLM_API bool ylm_mapping_fits(ylm_mapping m, int width, int height);
/* The pixel, row by row, that a direction falls into; false as ylm_mapping_position. */
YLM_API bool ylm_mapping_pixel(ylm_mapping m, ylm_up up, int width, int height, const double d[3],
                               size_t *pixel);
/*
** ylm_mapping_within - a direction in a pixel, for u and v of 0 .. 1 that are uniform.
**
** Directions are uniform in solid angle (latlong), or positions uniform in the pixel (angular,
** cube). Their density at d is 1/ylm_mapping_spread(.., d) sr^-1, an area that a pixel would fill
** if all of it were stretched as it is there. `spread` NULL: it is not asked for.
**
** Returns  false and zeros outside of the disc
*/
YLM_API bool ylm_mapping_within(ylm_mapping m, ylm_up up, int width, int height, size_t pixel,
                                double u, double v, double d[3], double *spread);
YLM_API double ylm_mapping_spread(ylm_mapping m, ylm_up up, int width, int height, size_t pixel,
                                  const double d[3]);
/*
** ylm_mapping_pixels - direction and solid angle of every pixel's middle.
**
**   direction    out  [height][width][3]   unit, or zeros outside of the disc
**   solid_angle  out  [height][width]      sr; exact for latlong and cube (the sum is 4 pi),
**                                          to second order for angular; may be NULL
** Returns  YLM_OK; YLM_ESHAPE (cube: height is not 6*width)
*/
YLM_API ylm_status ylm_mapping_pixels(ylm_mapping m, ylm_up up, int width, int height,
                                      double *direction, double *solid_angle);

/* -- textures ----------------------------------------------------------------- */

/* An image that is looked up at texture coordinates. A texture does not change and is reference
   counted. */
typedef struct ylm_texture ylm_texture;

/*
** ylm_texture_create - a texture of numbers from 0 to 1, which are copied.
**
**   channels  in  1 .. 4; one or two are grey (and alpha), the fourth is left out
**   texel     in  [height][width][channels], the top row first
**
** Returns  YLM_OK; YLM_EDOMAIN naming row, column and channel of a number outside of 0 .. 1, YLM_ERANGE,
**          YLM_EOVERFLOW, YLM_ENOMEM
*/
YLM_API ylm_status ylm_texture_create(size_t width, size_t height, int channels, const float *texel,
                                      ylm_texture **texture, ylm_error *e);
/* Another hold of the texture, to be freed once more; of NULL NULL. */
YLM_API const ylm_texture *ylm_texture_keep(const ylm_texture *texture);
YLM_API void ylm_texture_free(const ylm_texture *texture);
YLM_API void ylm_texture_size(const ylm_texture *texture, size_t *width, size_t *height);
/* A fingerprint of its size, its borders and its texels. */
YLM_API uint64_t ylm_texture_print(const ylm_texture *texture);
/* The mean of all texels. */
YLM_API void ylm_texture_mean(const ylm_texture *texture, float mean[3]);
/*
** ylm_texture_at - the colour at texture coordinates: bilinear between the centres of texels.
**
**   u, v  in   finite; u grows to the right, v upwards, (0, 0) is the bottom left corner; the image is
**              repeated beyond 0 .. 1
**   out   out  [3]
*/
YLM_API void ylm_texture_at(const ylm_texture *texture, float u, float v, float out[3]);

#ifdef __cplusplus
}
#endif
#endif
