/*
** ylm_display.h - pictures sent to an image viewer while they are made: tev, and viewers that speak its protocol.
**
** A packet is its length (u32, itself included), a type (u8) and what it holds; integers are little-endian, strings end
** in 0. Viewers never answer.
**
** Threads   one call at a time per connection
*/
#ifndef YLM_DISPLAY_H
#define YLM_DISPLAY_H

#include "ylm_base.h"

#ifdef __cplusplus
extern "C" {
#endif

#define YLM_DISPLAY_NAME 255 /* bytes of a picture's name, at most */

typedef struct ylm_display ylm_display;

/*
** ylm_display_open - a connection to the viewer that listens at host:port.
**   host   a name or an address
**   port   1 .. 65535
** Returns  YLM_OK; YLM_EIO (no viewer listens there, or it does not answer within a second), YLM_ERANGE (port), YLM_ENOMEM
*/
YLM_API ylm_status ylm_display_open(const char *host, int port, ylm_display **d, ylm_error *e);
YLM_API void ylm_display_free(ylm_display *d);

/* Channels of a picture that lie side by side, top row first. */
typedef struct ylm_display_layer {
  int channels;        /* 1 .. 4 */
  char channel[4][64]; /* their names: "R", "depth.Z" */
  const float *pixels; /* [height][width][channels] */
} ylm_display_layer;

#define YLM_DISPLAY_LAYERS 32

typedef struct ylm_display_picture {
  const char *name; /* UTF-8 without control characters */
  int width, height, layers;
  const ylm_display_layer
      *layer; /* [layers], 1 .. YLM_DISPLAY_LAYERS; no two channels of one name */
} ylm_display_picture;

/*
** ylm_display_send - the rows of a picture that differ from those that were sent under its name last; the first time,
** or with another size or other channels, the whole picture.
** Returns  YLM_OK; YLM_EINVAL (name), YLM_ESHAPE (size, channels), YLM_ENOMEM; YLM_EIO (the viewer has gone, or takes
** nothing for two seconds: the connection is closed, as a packet that was cut cannot be mended, and later calls say so)
*/
YLM_API ylm_status ylm_display_send(ylm_display *d, const ylm_display_picture *p, ylm_error *e);

/* The viewer drops the picture of that name. */
YLM_API ylm_status ylm_display_drop(ylm_display *d, const char *name, ylm_error *e);

#ifdef __cplusplus
}
#endif
#endif
