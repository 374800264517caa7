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

#endif
