/* ylm_crc.h - sums of floats that are looked at on the way. */
#ifndef YLM_CRC_H
#define YLM_CRC_H

#include "ylm_base.h"

/* ylm_crc64 of `size` bytes of floats, at any address; *finite becomes false where one of them is not a finite number. */
uint64_t ylm_crc64_floats(uint64_t crc, const void *data, size_t size, bool *finite);

#endif
