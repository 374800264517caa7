/*
** calibration.h - the tuned constants of rays. Private to csrc/trace.
**
** `make bench BENCH=trace` prints rays a second and thread by kind of ray, in scenes of few and of many triangles.
*/
#ifndef YLM_TRACE_CALIBRATION_H
#define YLM_TRACE_CALIBRATION_H

/* Rays of a stream: Embree 3 sorts it by direction, and longer ones gain nothing. With Embree 4, which has
   no streams, embree4.c puts as many into order. */
#define TRACE_STREAM 256
/* Rays of a packet, and the squared cosine above which two of them are alike. Moved by: `spec/bench/frames.lua` with one lamp. */
#define TRACE_PACKET 16
#define TRACE_ALIKE 0.8f
/* Up to so many lamps are enclosed in balls, which rays are tried for before the tree of lamps. Moved by: `make bench BENCH=path`. */
#define TRACE_BALLS 16

#endif
