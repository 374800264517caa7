/*
** calibration.h - the tuned constants of images. Private to csrc/image.
**
** Sizes of work move time alone. No bench is about them: spec/bench/frames.lua has pictures with their layers.
*/
#ifndef YLM_IMAGE_CALIBRATION_H
#define YLM_IMAGE_CALIBRATION_H

/* Rows that a thread takes at a time. Sums are added block by block of these, so that they do not depend on the number
   of threads. */
#define IMAGE_ROWS 16
/* The largest half width of FLIP's filters, in pixels. */
#define FLIP_RADIUS 512
/* Luminance that the middle of a picture is shown as, that of a grey card; luminance up to which a pixel is shown as black, a
   code of 6 in 255; how many times brighter than the middle a pixel is left out, and how many times darker it counts; rounds in
   which the middle is found. */
#define EXPOSURE_KEY 0.18
#define EXPOSURE_BLACK 0.002
#define EXPOSURE_BRIGHT 16
#define EXPOSURE_DARK 1000
#define EXPOSURE_ROUNDS 4

#endif
