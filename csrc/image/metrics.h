/* metrics.h - what comparisons of two images share. Private to csrc/image. */
#ifndef YLM_IMAGE_METRICS_H
#define YLM_IMAGE_METRICS_H

#include "calibration.h"
#include "ylm_image.h"

/* One layer of both images, checked: equal sizes and numbers of channels. */
ylm_status ylm__image_match(const ylm_image *a, const ylm_image *b, const char *name,
                            const ylm_layer **la, const ylm_layer **lb, ylm_error *e);
/* YLM_EDOMAIN: pixel i, of rows of `width`, counts and is not finite. */
ylm_status ylm__image_not_finite(size_t i, size_t width, ylm_error *e);

#endif
