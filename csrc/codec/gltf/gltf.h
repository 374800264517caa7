/* gltf.h - what the files of this room share: the file while it is read. Private to csrc/codec/gltf. */
#ifndef YLM_GLTF_PRIVATE_H
#define YLM_GLTF_PRIVATE_H

#include <jansson.h>

#include "ylm_gltf.h"

#define GLTF_COUNT ((size_t)1 << 20) /* entries of a list of the file */

/* A place in the JSON: a key or an index below another place. */
typedef struct place {
  const struct place *up;
  const char *key; /* NULL: index */
  size_t index;
} place;

typedef struct gltf_bytes {
  const unsigned char *data;
  size_t size;
  unsigned char *own; /* to be freed, or NULL */
} gltf_bytes;

typedef struct gltf_view {
  const unsigned char *data;
  size_t size, stride; /* stride 0: tightly packed */
} gltf_view;

typedef struct gltf_accessor {
  size_t count, stride;   /* elements; bytes from one to the next */
  int numbers, component; /* numbers of an element; 5120 .. 5126  */
  bool normalized;
  const unsigned char *data; /* NULL: zeros */
  size_t sparse;             /* elements that differ */
  int sparse_component;
  const unsigned char *sparse_index, *sparse_value;
} gltf_accessor;

/* A file while it is read. The first failure stays: functions that find `status` set do nothing. */
typedef struct gltf {
  const char *name;
  const ylm_gltf_options *o;
  ylm_status status;
  ylm_error *e;
  json_t *root;
  gltf_bytes binary; /* the chunk BIN */
  size_t buffers, views, accessors;
  gltf_bytes *buffer;
  gltf_view *view;
  gltf_accessor *accessor;
  uint64_t texels;      /* of images so far */
  unsigned char *tried; /* images that were decoded, or cannot be: 1, for their means: 2 */
  float *mean;          /* [images][2] of green and blue */
  size_t room;          /* pieces that out->piece has room for */
  double lookups;       /* of texels, that are left for means over triangles */
  ylm_gltf *out;
} gltf;

/* Fails at a place of the JSON (NULL: the file); keeps an earlier failure. */
void ylm__gltf_fail(gltf *g, ylm_status s, const place *at, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
void ylm__gltf_note(gltf *g, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Zeros, or NULL and a failure. */
void *ylm__gltf_alloc(gltf *g, size_t count, size_t size);

/* -- json.c --------------------------------------------------------------------------- */

/* Counts what the text would make jansson allocate, then parses it. */
void ylm__gltf_parse(gltf *g, const unsigned char *text, size_t size);
/* The list `key` of an object and its length; NULL where there is none. */
json_t *ylm__gltf_list(gltf *g, const place *at, const json_t *o, const char *key, size_t *n);
/* The object `key`; NULL where there is none. */
json_t *ylm__gltf_object(gltf *g, const place *at, const json_t *o, const char *key);
/* Entry i of a list, which must be an object; an empty one after a failure. */
json_t *ylm__gltf_entry(gltf *g, const place *at, json_t *list, size_t i);
/* The extension `name` of an object; NULL where there is none. */
json_t *ylm__gltf_extension(gltf *g, const place *at, const json_t *o, const char *name);
const char *ylm__gltf_string(gltf *g, const place *at, const json_t *o, const char *key);
bool ylm__gltf_boolean(gltf *g, const place *at, const json_t *o, const char *key);
/* A finite number from lo to hi; `none` where there is none. */
double ylm__gltf_number(gltf *g, const place *at, const json_t *o, const char *key, double none,
                        double lo, double hi);
/* An integer from 0 to 2^53; 1.0 is one too. */
uint64_t ylm__gltf_integer(gltf *g, const place *at, const json_t *o, const char *key,
                           uint64_t none);
/* The number of one of `count` things, from 0; -1 where there is none. */
int64_t ylm__gltf_reference(gltf *g, const place *at, const json_t *o, const char *key,
                            const char *what, size_t count);
/* n numbers; false where there are none. */
bool ylm__gltf_numbers(gltf *g, const place *at, const json_t *o, const char *key, int n,
                       double *out);
/* The object extras.ylm as text, or NULL. */
char *ylm__gltf_extras(gltf *g, const json_t *o);
/* A name, cut between characters to YLM_GLTF_NAME bytes; empty where there is none. */
void ylm__gltf_name(gltf *g, const place *at, const json_t *o, char *out);

/* -- container.c ---------------------------------------------------------------------- */

/* The JSON of a file, and its chunk BIN. */
void ylm__gltf_unwrap(gltf *g, const unsigned char *data, size_t size, gltf_bytes *json);
/* The bytes that a URI names: base64 or a file. */
void ylm__gltf_fetch(gltf *g, const place *at, const char *uri, gltf_bytes *b);

/* -- accessor.c ------------------------------------------------------------------------- */

/* Buffers, views, accessors, all checked. */
void ylm__gltf_accessors(gltf *g);
size_t ylm__gltf_component_size(int component);
/* Element i as numbers, normalised where the accessor says so. */
void ylm__gltf_element(const gltf_accessor *a, size_t i, float *out);
/* Element i of an accessor of one unsigned integer. */
uint32_t ylm__gltf_index(const gltf_accessor *a, size_t i);

/* -- texel.c ------------------------------------------------------------------------------ */

/* A part of a primitive: triangles whose texels have one colour in the end. */
typedef struct gltf_part {
  ylm_mesh *mesh;
  bool grouped;
  float tint[3], alpha;
} gltf_part;

/* The parts of a mesh, which is the callee's from now on: without the triangles that the material's alpha cuts off,
   in groups by colour where the options say so. alpha: [vertices] or NULL. Their number; `cut` counts triangles. */
size_t ylm__gltf_parts(gltf *g, ylm_mesh *m, const float *alpha, int32_t material, gltf_part **part,
                       size_t *cut);

/* -- node.c, primitive.c, material.c ------------------------------------------------------ */

/* Nodes of the scene, and what hangs on them: pieces, lamps, cameras. */
void ylm__gltf_nodes(gltf *g);
/* Triangles of each primitive of a mesh; their sum. Counts what is left out. */
uint64_t ylm__gltf_count_triangles(gltf *g, size_t mesh, size_t *primitives);
/* Adds the pieces of a mesh for `n` transforms (3 x 4) and names. */
typedef struct gltf_instance {
  double m[12];
  size_t mesh;
  char name[YLM_GLTF_NAME];
  const json_t *node;
} gltf_instance;
void ylm__gltf_pieces(gltf *g, size_t mesh, const gltf_instance *instance, size_t n);
void ylm__gltf_materials(gltf *g);

#endif
