/* tensor.h - fields of a tensor file, RGL's container of named arrays. Private to csrc/material. */
#ifndef YLM_MATERIAL_TENSOR_H
#define YLM_MATERIAL_TENSOR_H

#include "ylm_base.h"

/* The most axes of a field. */
#define TENSOR_AXES 8

typedef enum tensor_type { TENSOR_U8 = 1, TENSOR_F32 = 10, TENSOR_F64 = 11 } tensor_type;

/* A file whose header has been checked; the bytes stay the caller's. */
typedef struct tensor {
  const unsigned char *bytes;
  size_t size;
  const char *name;   /* of the file, for messages */
  size_t fields, end; /* end: of the header */
} tensor;

typedef struct tensor_field {
  const char *name; /* not terminated */
  size_t length;
  int type, axes;
  size_t shape[TENSOR_AXES], count;
  const unsigned char *data; /* count numbers, little-endian, not aligned */
} tensor_field;

/* YLM_OK; YLM_EFORMAT (another format, truncated, a field outside of the file or within the
   header), YLM_EVERSION. */
ylm_status ylm__tensor_open(const unsigned char *bytes, size_t size, const char *name, tensor *t,
                            ylm_error *e);

/* The field of that name, false: there is none. */
bool ylm__tensor_find(const tensor *t, const char *name, tensor_field *f);

/* The field of that name with `axes` axes of `type`; YLM_EFORMAT names what is wrong. */
ylm_status ylm__tensor_field(const tensor *t, const char *name, tensor_type type, int axes,
                             tensor_field *f, ylm_error *e);

/* Number i of a field of TENSOR_F32. */
float ylm__tensor_float(const tensor_field *f, size_t i);

/* The field's numbers, all finite; YLM_EFORMAT names the first that is not. */
ylm_status ylm__tensor_floats(const tensor *t, const tensor_field *f, float *out, ylm_error *e);

#endif
