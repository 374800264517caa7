/*
** ylm_gltf.h - glTF 2.0: triangles, materials, lamps and cameras of .gltf and .glb files.
**
** All is in world coordinates: a mesh for each node and primitive. Triangles are counter-clockwise seen
** from outside; texture coordinates have v upwards (in the file it points down). Directional and
** punctual intensities are the file's candela and lux. Source: Khronos, glTF 2.0 specification
** (2021); KHR_lights_punctual, EXT_lights_ies, KHR_mesh_quantization, KHR_texture_transform, KHR_materials_*.
*/
#ifndef YLM_GLTF_H
#define YLM_GLTF_H

#include "ylm_geom.h"
#include "ylm_image_texture.h"

#ifdef __cplusplus
extern "C" {
#endif

#define YLM_GLTF_NAME 64 /* bytes of a name, with the final 0; longer ones are cut */
#define YLM_GLTF_PIECES 65536
#define YLM_GLTF_GROUPS 256

/* Opens a file that the JSON names by a relative path, percent signs decoded, without "..". */
typedef ylm_status ylm_gltf_open(void *user, const char *path, unsigned char **data, size_t *size,
                                 ylm_error *e);

/* Zeros are the defaults. */
typedef struct ylm_gltf_options {
  ylm_gltf_open *open; /* NULL: files of their own are refused            */
  void *user;
  uint64_t triangles; /* most of all instances; 0: YLM_MESH_MAX          */
  uint64_t texels;    /* most of all images that are used; 0: 2^26       */
  int scene;          /* one-based; 0: the one that the file names       */
  bool no_images;     /* images are not decoded: factors stand alone     */
  int groups; /* most groups of a piece's triangles by the colours of their texture; 0: none */
} ylm_gltf_options;

typedef enum ylm_gltf_alpha { YLM_GLTF_OPAQUE, YLM_GLTF_MASK, YLM_GLTF_BLEND } ylm_gltf_alpha;

typedef struct ylm_gltf_material {
  char name[YLM_GLTF_NAME];
  float base[4];             /* baseColorFactor, linear                            */
  float emission[3];         /* emissiveFactor times KHR_materials_emissive_strength */
  float metallic, roughness; /* factors, times the mean of their texture           */
  float f0;                  /* of what is no metal: KHR_materials_ior, _specular  */
  float cutoff;              /* of YLM_GLTF_MASK                                   */
  ylm_gltf_alpha alpha;
  bool unlit, both_sides;
  int32_t base_image, emission_image;              /* places in `image`, or -1                  */
  int32_t base_set, emission_set;                  /* which TEXCOORD                            */
  ylm_texture_wrap base_wrap[2], emission_wrap[2]; /* along u and v                    */
  float base_map[6], emission_map[6]; /* rows of the map of texture coordinates of the file */
  char *extras;                       /* extras.ylm as JSON, or NULL */
} ylm_gltf_material;

typedef struct ylm_gltf_piece {
  char name[YLM_GLTF_NAME]; /* of its node, else of its mesh           */
  ylm_mesh *mesh;           /* NULL once taken (the caller's to free)  */
  int32_t material;         /* place in `material`, or -1              */
  bool grouped;             /* `tint` stands for the texture           */
  float tint[3];            /* mean of the base texture, weighted by area */
  float alpha;  /* the same of alpha, colours of vertices included; 1 where nothing says it */
  char *extras; /* extras.ylm of its node as JSON, or NULL */
} ylm_gltf_piece;

typedef enum ylm_gltf_lamp_kind {
  YLM_GLTF_POINT,
  YLM_GLTF_SPOT,
  YLM_GLTF_DIRECTIONAL,
  YLM_GLTF_PROFILE
} ylm_gltf_lamp_kind;

typedef struct ylm_gltf_lamp {
  char name[YLM_GLTF_NAME];
  ylm_gltf_lamp_kind kind;
  double at[3], direction[3]; /* unit: where it shines                       */
  double across[3];           /* unit: where C0 of a profile looks           */
  double intensity[3];        /* candela (directional: lux; a profile: 1) times the colour */
  double inner, outer;        /* of a spot: radians from the axis            */
  bool range;                 /* it has a range, which is ignored                    */
  size_t profile;             /* of a profile: which one                             */
  char *extras;               /* extras.ylm as JSON, or NULL                         */
} ylm_gltf_lamp;

/* A photometric file (EXT_lights_ies). */
typedef struct ylm_gltf_profile {
  unsigned char *data;
  size_t size;
} ylm_gltf_profile;

typedef struct ylm_gltf_camera {
  char name[YLM_GLTF_NAME];
  double from[3], forward[3], up[3]; /* unit                               */
  double yfov;                       /* radians; 0: orthographic           */
  char *extras;                      /* extras.ylm as JSON, or NULL        */
} ylm_gltf_camera;

typedef struct ylm_gltf {
  size_t pieces, materials, lamps, cameras, images, notes, profiles;
  ylm_gltf_piece *piece;
  ylm_gltf_material *material;
  ylm_gltf_lamp *lamp;
  ylm_gltf_camera *camera;
  ylm_gltf_profile *profile; /* [profiles]; those that no node has are empty */
  ylm_image **image; /* linear, alpha last; NULL where it cannot be read (a note says why) */
  char **note;       /* what was left out, a sentence each                */
  char *extras;      /* extras.ylm of the scene as JSON, or NULL */
  size_t nodes, triangles;
} ylm_gltf;

/*
** ylm_gltf_decode - reads a .gltf or .glb file's bytes.
**
** Order of checks: container, JSON (counted before it is parsed), version, required extensions,
** buffers, views, accessors, nodes, triangles of all instances; then memory for meshes is taken.
** Messages are "NAME: /json/pointer: sentence". min and max of accessors are not believed.
** Of YLM_GLTF_MASK triangles whose mean alpha is below the cutoff are left out. Areas are those of the mesh before its
** node moves it. Means over triangles are sums over some 2^24 texels of a file at most.
**
**   data  in   [size] bytes
**   name  in   what messages begin with
**   g     out  the caller's to free
**
** Returns  YLM_OK; YLM_EFORMAT, YLM_ELIMIT (depth 64, 64 MiB of JSON, 2^20 entries of a list,
**          YLM_GLTF_PIECES, triangles, texels), YLM_EVERSION, YLM_EMISSING (no jansson), YLM_EIO, YLM_ENOMEM
** Cost     O(size + results); memory: 80 x JSON + 1 MiB, decoded buffers, results
*/
YLM_API ylm_status ylm_gltf_decode(const unsigned char *data, size_t size, const char *name,
                                   const ylm_gltf_options *o, ylm_gltf **g, ylm_error *e);
/* ylm_gltf_decode of a file; others that it names lie in its folder. `limit`: most bytes of each; 0: 4 GiB. */
YLM_API ylm_status ylm_gltf_read(const char *path, size_t limit, const ylm_gltf_options *o,
                                 ylm_gltf **g, ylm_error *e);
YLM_API void ylm_gltf_free(ylm_gltf *g);
/* Whether these first bytes are of a .glb file. */
YLM_API bool ylm_gltf_is_binary(const unsigned char *data, size_t size);

#ifdef __cplusplus
}
#endif
#endif
