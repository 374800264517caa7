/*
** ylm_vulkan.h - compute on a graphics processor: devices, memory, kernels, work.
**
** libvulkan is opened when it is first needed; nothing is linked against it. Kernels
** are the files of shaders/, compiled to SPIR-V when ylm is built and embedded.
**
** Ownership   the caller of a *_create / *_open frees the pointer with the matching
**             *_free; every *_free accepts NULL. Buffers keep their device's memory of
**             itself alive: they may be freed before or after it. Kernels belong to the
**             device and are never freed by the caller.
** Threads     a device and all that belongs to it is used by one thread at a time;
**             different devices are independent.
** Errors      YLM_EMISSING   no libvulkan, no driver, no such device, a feature it lacks
**             YLM_ENOMEM     memory of the device or of this machine ran out
**             YLM_ELIMIT     more than the device's limits allow
**             YLM_EDEVICE    a driver failed, or the device was lost; from then on everything
**                            that uses the device answers so (but *_free and _close)
**             YLM_ECLOSED    after ylm_gpu_close
** Time        calls return when the device is done. No dispatch is meant to run longer than
**             YLM_GPU_SLICE seconds: ylm_gpu_run cuts work into slices of groups.
*/
#ifndef YLM_VULKAN_H
#define YLM_VULKAN_H

#include "ylm_base.h"
#include "ylm_grid.h"

#ifdef __cplusplus
extern "C" {
#endif

/* -- devices --------------------------------------------------------------- */

typedef enum ylm_gpu_type {
  YLM_GPU_OTHER,
  YLM_GPU_INTEGRATED,
  YLM_GPU_DISCRETE,
  YLM_GPU_VIRTUAL,
  YLM_GPU_CPU /* a driver in software */
} ylm_gpu_type;

/* "other", "integrated", "discrete", "virtual", "cpu". */
YLM_API const char *ylm_gpu_type_name(ylm_gpu_type t);

typedef struct ylm_gpu_info {
  char name[256], driver[256]; /* "llvmpipe (LLVM 15.0.6, 256 bits)", "llvmpipe Mesa 22.3.6" */
  ylm_gpu_type type;
  uint32_t vulkan[3];        /* version of the interface */
  bool usable;               /* Vulkan 1.2 and a queue that computes: ylm_gpu_open takes it */
  bool float64, int64;       /* types in shaders */
  bool timestamps;           /* the queue measures time; else wall time stands in */
  uint32_t subgroup;         /* invocations that run in lockstep */
  uint32_t binds;            /* buffers of one kernel */
  uint32_t group_size;       /* invocations of a group */
  uint32_t groups;           /* groups of a dispatch (longer ones are cut) */
  uint64_t shared_bytes;     /* memory shared within a group */
  uint64_t bind_bytes;       /* of a buffer as a kernel sees it: longer ones go in passes */
  uint64_t allocation_bytes; /* the longest buffer */
  uint64_t memory_bytes;     /* the device's own memory */
} ylm_gpu_info;

/* Every device there is, in the loader's order; the caller frees *list with ylm_free.
   YLM_EMISSING (no loader, no driver), YLM_EDEVICE, YLM_ENOMEM. */
YLM_API ylm_status ylm_gpu_list(ylm_gpu_info **list, size_t *n, ylm_error *e);

typedef struct ylm_gpu_options {
  int index;        /* of ylm_gpu_list, or -1: by name, or the best (discrete before integrated) */
  const char *name; /* NULL, or part of the name in any case */
  bool validate;    /* with the Khronos validation layer; YLM_VULKAN_VALIDATION=1 says so too */
  bool staging;     /* copy by way of staging memory even where the host sees the device's */
} ylm_gpu_options;

typedef struct ylm_gpu ylm_gpu;

/*
** ylm_gpu_open - open a device.
**
** The environment's YLM_VULKAN_LIBRARY names another libvulkan (for tests).
** YLM_EMISSING, YLM_ERANGE (index), YLM_EDEVICE, YLM_ENOMEM.
*/
YLM_API ylm_status ylm_gpu_open(const ylm_gpu_options *o, ylm_gpu **g, ylm_error *e);
/* Gives back all the device holds, buffers' memory included; what uses it afterwards is
   refused with YLM_ECLOSED. YLM_EBUSY, from a progress function, while it works. */
YLM_API ylm_status ylm_gpu_close(ylm_gpu *g);
/* Counts users: a device is closed and freed by the last ylm_gpu_free. */
YLM_API ylm_gpu *ylm_gpu_share(ylm_gpu *g);
YLM_API void ylm_gpu_free(ylm_gpu *g);
YLM_API const ylm_gpu_info *ylm_gpu_about(const ylm_gpu *g);
/* YLM_OK, or why the device is of no use: YLM_ECLOSED, YLM_EDEVICE. */
YLM_API ylm_status ylm_gpu_state(const ylm_gpu *g, ylm_error *e);
/* Makes the device behave as if the driver had said that it is lost (for tests). */
YLM_API void ylm_gpu_lose(ylm_gpu *g);
/* Makes the i-th of the driver's functions that may fail do so: memory is out (YLM_ENOMEM), the
   device lost (YLM_EDEVICE), or else an error of no known kind; YLM_OK mends it (for tests). Its
   name; NULL: there are fewer. */
YLM_API const char *ylm_gpu_break(ylm_gpu *g, size_t i, ylm_status s);
/* Makes the device behave as a smaller one (for tests): so many bytes of memory in all, so many for
   a kernel to see of a buffer, so many buffers of a kernel, no float64. 0: as it is. */
YLM_API void ylm_gpu_shrink(ylm_gpu *g, uint64_t memory_bytes, uint64_t bind_bytes, uint32_t binds,
                            bool narrow);
/* Uses the interface wrongly, for the validation layer to complain (for tests). */
YLM_API void ylm_gpu_blunder(ylm_gpu *g);
/* Number of warnings and errors of the validation layer so far, and the first of them ("").
   Also of a closed device. */
YLM_API size_t ylm_gpu_messages(const ylm_gpu *g, const char **first);

/* Uses of a device so far. */
typedef struct ylm_gpu_use {
  uint64_t buffers, bytes;       /* that exist */
  uint64_t uploaded, downloaded; /* bytes */
  double upload, download, run;  /* seconds, of copies and of ylm_gpu_run */
  uint64_t dispatches, submissions, pipelines;
} ylm_gpu_use;
YLM_API ylm_gpu_use ylm_gpu_used(const ylm_gpu *g);

/* -- buffers --------------------------------------------------------------- */

typedef struct ylm_gpu_buffer ylm_gpu_buffer;

/* `bytes` of the device's memory, not cleared; 0 is allowed. YLM_ENOMEM, YLM_ELIMIT. */
YLM_API ylm_status ylm_gpu_buffer_create(ylm_gpu *g, uint64_t bytes, ylm_gpu_buffer **b,
                                         ylm_error *e);
YLM_API void ylm_gpu_buffer_free(ylm_gpu_buffer *b);
YLM_API uint64_t ylm_gpu_buffer_bytes(const ylm_gpu_buffer *b);
YLM_API ylm_gpu *ylm_gpu_buffer_device(const ylm_gpu_buffer *b);

/* Copies that have happened when the call returns. YLM_EOVERFLOW (outside of the buffer). */
YLM_API ylm_status ylm_gpu_upload(ylm_gpu_buffer *b, uint64_t offset, uint64_t bytes,
                                  const void *data, ylm_error *e);
YLM_API ylm_status ylm_gpu_download(const ylm_gpu_buffer *b, uint64_t offset, uint64_t bytes,
                                    void *data, ylm_error *e);
/* The two in one: a buffer with those bytes. */
YLM_API ylm_status ylm_gpu_buffer_from(ylm_gpu *g, uint64_t bytes, const void *data,
                                       ylm_gpu_buffer **b, ylm_error *e);

/* -- kernels --------------------------------------------------------------- */

#define YLM_GPU_BINDS 12       /* buffers of a kernel at most */
#define YLM_GPU_CONSTANTS 12   /* specialisation constants of a kernel at most */
#define YLM_GPU_PUSH_BYTES 124 /* push constants of a kernel at most */

typedef struct ylm_gpu_kernel ylm_gpu_kernel;

/*
** ylm_gpu_kernel_get - the kernel shaders/NAME.comp with these specialisation constants.
**
** A file NAME.real.comp is compiled twice: NAME_float and NAME_double (which needs
** float64). Constant k has constant_id k, 32 bits; constant 0 is the size of a group
** (local_size_x_id = 0). Made once, then found again: ask for it in each call.
** Set 0, bindings 0 .. n-1 are storage buffers; shaders/ylm.glsl has the rest.
**
** YLM_EINVAL (no such name), YLM_EMISSING (float64, int64, too many buffers), YLM_ELIMIT
** (group size)
*/
YLM_API ylm_status ylm_gpu_kernel_get(ylm_gpu *g, const char *name, int constants,
                                      const uint32_t *constant, ylm_gpu_kernel **k, ylm_error *e);

/* -- work ------------------------------------------------------------------ */

#define YLM_GPU_SLICE 0.05 /* seconds: what no dispatch should take */

/* `bytes` of a buffer from `offset` (a multiple of 256) on; bytes 0: to its end. */
typedef struct ylm_gpu_bind {
  ylm_gpu_buffer *buffer;
  uint64_t offset, bytes;
} ylm_gpu_bind;

typedef enum ylm_gpu_verb {
  YLM_GPU_DISPATCH, /* `groups` groups of `kernel` */
  YLM_GPU_FILL,     /* bind[0] with the 32 bits of `value`; offset and bytes multiples of 4 */
  YLM_GPU_COPY      /* bind[0] to bind[1], as many bytes as bind[0] has; multiples of 4 */
} ylm_gpu_verb;

/*
** One step of work. Each step sees what the steps before it wrote.
**
** A dispatch of `groups` groups is run in slices: a shader asks ylm_group() of
** shaders/ylm.glsl which group it is. The push constants are those of the caller after
** one uint that is the slice's own (see PUSH there).
** `cost` is that of a group, in any unit that stays the same for a kernel (say, light x
** point pairs); with it the time that a slice will take is foreseen. 0 counts as 1.
** `stage` is for progress and times: a literal.
*/
typedef struct ylm_gpu_work {
  ylm_gpu_verb verb;
  const char *stage;
  ylm_gpu_kernel *kernel;
  uint64_t groups;
  double cost;
  const void *push;
  size_t push_bytes; /* a multiple of 4, at most YLM_GPU_PUSH_BYTES */
  int binds;
  ylm_gpu_bind bind[YLM_GPU_BINDS];
  uint32_t value;
} ylm_gpu_work;

#define YLM_GPU_STAGES 16

/* Times by stage, added to what stands there; zero it first. */
typedef struct ylm_gpu_times {
  int stages;
  struct ylm_gpu_stage {
    const char *name;
    double seconds; /* on the device, by its timestamps (else wall time) */
    double longest; /* of one dispatch */
    uint64_t dispatches;
  } stage[YLM_GPU_STAGES]; /* later ones are added to the last */
} ylm_gpu_times;

/*
** ylm_gpu_run - do `n` steps of work in order and wait for them.
**
** As many slices as are foreseen to take some milliseconds go into one submission; between
** submissions progress is reported, in parts of 10000 by cost, and may cancel (buffers then
** hold part of the results). A kernel's first group is run alone, to measure it.
**   times     may be NULL
**   progress  may be NULL
** YLM_ECANCELLED, YLM_EDEVICE, YLM_ELIMIT (a bind longer than bind_bytes), YLM_EINVAL (a bind
** that is missing or misaligned), YLM_EOVERFLOW (a bind outside of its buffer), YLM_ENOMEM
*/
YLM_API ylm_status ylm_gpu_run(ylm_gpu *g, size_t n, const ylm_gpu_work *work, ylm_gpu_times *times,
                               const ylm_progress *progress, ylm_error *e);

/*
** ylm_gpu_rows - how many of `n` rows to handle in one pass, a multiple of 64 or all n: such
** that a pass of rows of `row_bytes` each (the widest array; a multiple of 4) neither passes
** what a kernel can see of a buffer nor `bytes` in all its arrays, of `sum_bytes` a row.
** Offsets of passes are then aligned for ylm_gpu_bind. 0 only where n is 0 or 64 rows are
** too long.
*/
YLM_API size_t ylm_gpu_rows(const ylm_gpu *g, size_t n, size_t row_bytes, size_t sum_bytes,
                            uint64_t bytes);

/*
** ylm_gpu_peak - the device's peaks as small kernels reach them: operations per second of
** float (a fused multiplication and addition is two), bytes per second read or written.
*/
YLM_API ylm_status ylm_gpu_peak(ylm_gpu *g, double *flops, double *bytes, ylm_error *e);

/* -- lights: light/lights.c --------------------------------------------------- */

typedef struct ylm_light_set ylm_light_set; /* ylm_light.h */

/* Highest degree of sums by the product rule; merged moments go to YLM_LIGHT_LMAX. */
#define YLM_GPU_PRODUCT_LMAX 8

/* How a field is summed; all give the same. */
typedef enum ylm_gpu_method {
  YLM_GPU_MERGED,  /* merged moments: the fastest */
  YLM_GPU_FORWARD, /* product rule per light, all orders m in one dispatch (to compare with) */
  YLM_GPU_REVERSED /* product rule, a dispatch for each order m (Mezieres et al. 2022) */
} ylm_gpu_method;

/* Lights in the device's memory, with what evaluating them needs there. */
typedef struct ylm_gpu_lights ylm_gpu_lights;

/*
** ylm_gpu_lights_create - put a set of lights onto a device: spheres, exact flat lights, and one
** pack at most of flat lights that spheres times a cosine approximate (Mezieres et al. 2022, Eqs.
** 24-28).
**
** The set must outlive the object (it answers which boxes lights cross). The copy of spheres in
** double is made at the first query in double. Exact flat lights are summed along their rims, in
** double: lmax <= YLM_LIGHT_RIM_LMAX, method YLM_GPU_MERGED. YLM_EINVAL (another method with them,
** two approximated packs, a kind that no device sums), YLM_EMISSING (exact ones on a device without
** float64), YLM_ENOMEM, YLM_ELIMIT, YLM_EDEVICE, YLM_ECLOSED.
*/
YLM_API ylm_status ylm_gpu_lights_create(ylm_gpu *g, const ylm_light_set *set,
                                         ylm_gpu_method method, ylm_gpu_lights **l, ylm_error *e);
YLM_API void ylm_gpu_lights_free(ylm_gpu_lights *l);

/*
** Their light field (ylm_base.h), which lives as long as the object.
**
** As lights without a device, but for lmax <= YLM_GPU_PRODUCT_LMAX by the product rule. Further
** statuses are YLM_EMISSING (double on a device without float64) and those of ylm_gpu_run. A result
** depends on the point, the lights and the device, not on the other points.
** Accuracy  that of csrc/light/sphere/sphere.h; lights are summed in chunks, these with
**           compensation. A flat light's share is within 1e-7/|cos gamma| more in float, as its
**           position is rounded
** Memory    at most 96 MiB of the device's for a pass
*/
YLM_API const ylm_field *ylm_gpu_lights_field(const ylm_gpu_lights *l);
YLM_API ylm_gpu *ylm_gpu_lights_device(const ylm_gpu_lights *l);
/* Times of everything that the field has done so far, by stage; "upload" of points and "download"
   of results by the host's clock, with no dispatches. */
YLM_API const ylm_gpu_times *ylm_gpu_lights_times(const ylm_gpu_lights *l);

/* -- baking grids: grid/bake.c --------------------------------------------------- */

/* A copy of a grid in the device's memory. */
typedef struct ylm_gpu_grid ylm_gpu_grid;

/*
** ylm_gpu_grid_bake - ylm_grid_bake of a grid that is not dynamic, on the device.
**
** The loop is that of ylm_grid_bake, the device its back end (ylm_grid_backend). Adaptive with a
** threshold, and uniform: occupancy, corners, their light field, the metric and what is split stay on
** the device; the host reads counts for each level, and everything at the end. With a tolerance the
** host decides, by residuals and held-out errors that the device measures; so with a uniform grid
** too large for kernels.
**
**   form    in   lmax as the lights can
**   source  in   its field, lights and back end are not read
**   there   in   its shading points in the device's memory, source->occupied of its type, instead
**                of source->occupied_points; NULL: none. They stay; held-out ones are copied
**   g       out  as by ylm_grid_bake with the lights' field: cells and points in the same order,
**                cells the same but where |error - threshold| < 1e-4 threshold; with a tolerance
**                but where an estimate is as near to what it is compared with
**   copy    out  the grid as it stays on the device, for sampling; NULL where it did not fit, or
**                was not baked there: ylm_gpu_grid_create makes one then
** Times     in those of the lights: "occupancy", "points" (finding corners, positions, data),
**           those of sums, "crossing", "subdivide" (the metric too), "residuals", "continuity"
**           (rows of points that only this needs); "upload" and "download" by the host's clock
** Returns   what ylm_grid_bake returns, and ylm_gpu_run. YLM_ELIMIT: a level's voxels take 32
**           bytes each, points 12, of what a kernel sees of a buffer
**           On a device whose kernels have fewer than 11 buffers the host decides, by ylm_grid_bake
** Results   the same to the bit each time, on the same device
** Source    Iwasaki & Dobashi 2025, Sec. 5.1
*/
YLM_API ylm_status ylm_gpu_grid_bake(ylm_gpu_lights *l, const ylm_grid_form *form,
                                     const ylm_grid_source *source, ylm_gpu_buffer *there,
                                     ylm_grid **g, ylm_gpu_grid **copy, ylm_error *e);

/* -- spherical harmonics ----------------------------------------------------- */

/*
** ylm_gpu_sh_eval - ylm_sh_eval on the device; arrays are the host's, copied in passes.
**
**   lmax   in   0 .. YLM_LMAX; with float 0 .. 128
**   p      in   [n][3], y [n][count], dy [n][count][3], ddy [n][count][6]: as ylm_sh_eval has them
**   times  out  stage "spherical harmonics"; may be NULL
** YLM_ERANGE, YLM_EDOMAIN (points), YLM_EMISSING (double without float64), YLM_ELIMIT,
** YLM_ENOMEM, YLM_EDEVICE, YLM_ECANCELLED
** Accuracy relative to the largest of its degree: 1e-12 (double), 1e-5 (float)
*/
YLM_API ylm_status ylm_gpu_sh_eval(ylm_gpu *g, int lmax, int derivatives, bool solid, ylm_dtype t,
                                   size_t n, const void *p, void *y, void *dy, void *ddy,
                                   ylm_gpu_times *times, const ylm_progress *progress,
                                   ylm_error *e);

/* -- grids: grid/sample.c ------------------------------------------------------ */

/* packed: rows as ylm_grid_pack makes them, a word a coefficient. YLM_ELIMIT where the grid has more data than a kernel sees;
   YLM_EDOMAIN (packed: light that is not finite), YLM_ENOMEM, YLM_EDEVICE. */
YLM_API ylm_status ylm_gpu_grid_create(ylm_gpu *g, const ylm_grid *grid, bool packed,
                                       ylm_gpu_grid **k, ylm_error *e);
/* Whether a copy is packed, and what rounding errs by; report may be NULL. */
YLM_API bool ylm_gpu_grid_packed(const ylm_gpu_grid *k, ylm_grid_packing *report);
YLM_API void ylm_gpu_grid_free(ylm_gpu_grid *k);
YLM_API ylm_gpu *ylm_gpu_grid_device(const ylm_gpu_grid *k);
YLM_API uint64_t ylm_gpu_grid_bytes(const ylm_gpu_grid *k);
/* Whether the copy has the grid's present state: false once the grid was updated. */
YLM_API bool ylm_gpu_grid_current(const ylm_gpu_grid *k, const ylm_grid *grid);

/* An array of the host's, or one in the device's memory; both NULL: none. */
typedef struct ylm_gpu_input {
  const void *host;
  ylm_gpu_buffer *there;
} ylm_gpu_input;
typedef struct ylm_gpu_output {
  void *host;
  ylm_gpu_buffer *there;
} ylm_gpu_output;

/*
** ylm_gpu_grid_sample - ylm_grid_sample on the device, in float. Data in the device's memory
** stay there; the host's arrays are copied.
**
** `grid` is the one that was copied: it answers where it has no data of its own. Points are
** located in double where the device has float64; without it, fractions of a voxel's edges are
** off by up to 2^(depth - 24). Results within 1e-5 of ylm_grid_sample.
**   points    in   [n][3] of q->point_dtype; finite, which is not checked of those on the device
**   value     out  [n][channels][count], gradient [n][channels][count][3] or none
**   times     stages "locate", "sort", "sample", and by the host's clock "upload", "download" of
**             the host's arrays; may be NULL
** YLM_EINVAL (the grid was updated since; an array is another device's), YLM_EMISSING (points in
** double on a device without), YLM_ENOMEM, YLM_EDEVICE, YLM_ECANCELLED
*/
YLM_API ylm_status ylm_gpu_grid_sample(ylm_gpu_grid *k, const ylm_grid *grid,
                                       const ylm_grid_query *q, size_t n, ylm_gpu_input points,
                                       ylm_gpu_output value, ylm_gpu_output gradient,
                                       ylm_grid_report *report, ylm_gpu_times *times, ylm_error *e);

/*
** ylm_gpu_grid_shade - the grid at shading points, dotted with their transfer vectors.
**
**   points    in   [n][3], of q->point_dtype
**   transfer  in   [n][row]
**   material  in   [n][YLM_MATERIAL_ROW]: ylm_material_row of each point's, or none
**   radiance  out  [n][3]: sum over coefficients that both have, and what the material makes of it
**                  where there is one; a luminance grid gives grey
**   times     stages "locate", "sort", "shade", "upload", "download"; may be NULL
** As ylm_gpu_grid_sample.
*/
YLM_API ylm_status ylm_gpu_grid_shade(ylm_gpu_grid *k, const ylm_grid *grid,
                                      const ylm_grid_query *q, size_t n, ylm_gpu_input points,
                                      size_t row, ylm_gpu_input transfer, ylm_gpu_input material,
                                      ylm_gpu_output radiance, ylm_grid_report *report,
                                      ylm_gpu_times *times, ylm_error *e);

/* -- pictures: picture/picture.c ------------------------------------------------- */

/*
** The entries of a view's pixels: ylm_shade_entries of ylm_shade.h, as arrays of the host's.
** Whole numbers are doubles, and are checked.
*/
typedef struct ylm_gpu_pixels {
  size_t width, height, entries, points;
  const double *first;  /* [pixels + 1] of each pixel's entries                          */
  const float *shown;   /* [pixels][4]  what lamps in sight add; the background's share  */
  const float *weight;  /* [entries]    share of the pixel                               */
  const float *depth;   /* [entries]    along the view axis                              */
  const double *point;  /* [entries][3] points on whose triangle an entry is; NULL: entry i is
                           point i                                                       */
  const float *part;    /* [entries][3] their weights; NULL as `point`                   */
  const double *camera; /* [10] ylm_shade_view_camera                                    */
} ylm_gpu_pixels;

/* They in a device's memory: 20 bytes a pixel, 8 an entry, with points 32. */
typedef struct ylm_gpu_picture ylm_gpu_picture;

/* YLM_EINVAL (entries out of order, points that there are not), YLM_ESHAPE, YLM_ERANGE; YLM_ELIMIT
   where one array is longer than what a kernel sees; YLM_ENOMEM, YLM_EDEVICE. */
YLM_API ylm_status ylm_gpu_picture_create(ylm_gpu *g, const ylm_gpu_pixels *p, ylm_gpu_picture **k,
                                          ylm_error *e);
YLM_API void ylm_gpu_picture_free(ylm_gpu_picture *k);
/* Shading points whose radiance it takes; pixels that it has. */
YLM_API void ylm_gpu_picture_size(const ylm_gpu_picture *k, size_t *points, size_t *pixels);

#define YLM_GPU_DISC 12

/*
** ylm_gpu_picture_make - radiance of shading points to pixels, lamps drawn over them: what
** ylm_shade_compose and ylm_shade_draw_lamps do.
**
**   radiance  in   [points][3]
**   disc      in   [discs][YLM_GPU_DISC], from ylm_shade_view_discs: the farthest first
**   image     out  [height][width][3]; the host's is what comes back
**   times     stages "filter", "lamps", by the host's clock "upload" (radiance of the host's,
**             lamps; with finding which tiles of 8 x 8 pixels they touch), "download"; may be NULL
** Within 1e-5 of the CPU's pixels. On a device without float64 rims of lamps are placed in float,
** to some 1e-4 of a pixel. YLM_EINVAL (an array is another device's), YLM_ENOMEM, YLM_ELIMIT,
** YLM_EDEVICE, YLM_EBUSY, YLM_ECANCELLED
*/
YLM_API ylm_status ylm_gpu_picture_make(ylm_gpu_picture *k, ylm_gpu_input radiance,
                                        const float background[3], size_t discs, const double *disc,
                                        ylm_gpu_output image, ylm_gpu_times *times,
                                        const ylm_progress *progress, ylm_error *e);

#ifdef __cplusplus
}
#endif
#endif
