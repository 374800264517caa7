/*
** ylm_image_texture.h - textures beyond 0 .. 1.
*/
#ifndef YLM_IMAGE_TEXTURE_H
#define YLM_IMAGE_TEXTURE_H

#include "ylm_image.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum ylm_texture_wrap {
  YLM_TEXTURE_REPEAT, /* the image again; of a new texture       */
  YLM_TEXTURE_MIRROR, /* the image again, every other one turned */
  YLM_TEXTURE_CLAMP   /* the texels of its border                */
} ylm_texture_wrap;

/* Along u and v; before the texture is shared or looked up. */
YLM_API void ylm_texture_set_wrap(ylm_texture *texture, ylm_texture_wrap u, ylm_texture_wrap v);
/* The place of 0 .. 1 at which a wrapped coordinate is looked up; x is finite. */
YLM_API double ylm_texture_fold(ylm_texture_wrap wrap, double x);

#ifdef __cplusplus
}
#endif
#endif
