/* picture.h - what picture.c and lamps.c share. Private. */
#ifndef YLM_GPU_PICTURE_H
#define YLM_GPU_PICTURE_H

#include "../calibration.h"
#include "../device/steps.h"

/* Pixels begin .. end-1; cost of a group of them. */
typedef struct picture_strip {
  uint32_t begin, end;
  double cost;
} picture_strip;

struct ylm_gpu_picture {
  ylm_gpu *g;
  uint32_t width, height;
  size_t points;
  bool wide; /* lamps are drawn in double */
  bool busy; /* a call has not returned: its progress function runs */
  int strips;
  picture_strip strip[PICTURE_STRIPS];
  ylm_gpu_buffer *first, *shown, *weight, *depth, *corner, *part, *camera;
  /* Of a call, kept for the next. */
  ylm_gpu_buffer *disc, *tile, *list, *image, *radiance;
  step_queue queue;
};

/* Numbers in the type that lamps are drawn in, to *b, which is made longer where it has to. */
ylm_status ylm__picture_reals(const ylm_gpu_picture *k, const double *x, size_t n,
                              ylm_gpu_buffer **b, ylm_error *e);
/* Queues drawing discs [n][YLM_GPU_DISC] over the image. */
void ylm__picture_lamps(ylm_gpu_picture *k, size_t n, const double *disc, ylm_gpu_buffer *image,
                        ylm_gpu_times *times, ylm_error *e);

#endif
