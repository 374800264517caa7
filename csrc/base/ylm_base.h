/*
** ylm_base.h - the ground that every other folder stands on.
**
** The folder has status codes and messages, memory, threads with progress and cancellation, and
** processor features. Files are replaced whole or not at all. ylm_field is the one interface
** through which light is asked for.
**
** Ownership   the caller of a *_create / *_read frees the pointer with the
**             matching *_free; every *_free accepts NULL.
** Threads     functions are re-entrant; objects may be read from many threads
**             at once, written from one.
** Errors      functions return ylm_status and never print or abort. Where a
**             sentence can say more, an optional `ylm_error *` takes it.
*/
#ifndef YLM_BASE_H
#define YLM_BASE_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "ylm_math.h"

#ifdef __cplusplus
extern "C" {
#endif

#if defined(_WIN32)
#define YLM_API
#else
#define YLM_API __attribute__((visibility("default")))
#endif

#define YLM_VERSION "0.1.0"

/* -- status ---------------------------------------------------------------- */

/*
** The only list of status codes: name, class, sentence.
** CALLER  the call was wrong: the Lua layer raises an error at the caller's line
** WORLD   a file, a driver, memory or a user's wish: returned as nil, message, code
*/
#define YLM_STATUS_LIST(X)                                                                         \
  X(OK, WORLD, "no error")                                                                         \
  X(EINVAL, CALLER, "an argument has a value that is not allowed")                                 \
  X(ERANGE, CALLER, "a number is outside of the range that is supported")                          \
  X(EDOMAIN, CALLER, "a number is outside of the function's domain")                               \
  X(ESHAPE, CALLER, "array shapes do not fit together")                                            \
  X(ETYPE, CALLER, "the element type does not fit")                                                \
  X(ECONVENTION, CALLER, "two conventions are mixed")                                              \
  X(ECLOSED, CALLER, "the object has been closed")                                                 \
  X(EBUSY, CALLER, "the object is in use by a call that has not returned")                         \
  X(EOVERFLOW, CALLER, "a size is too large to be represented")                                    \
  X(ENOMEM, WORLD, "memory ran out")                                                               \
  X(EIO, WORLD, "a file cannot be read or written")                                                \
  X(EFORMAT, WORLD, "a file is not of the format it should be")                                    \
  X(ECHECKSUM, WORLD, "a file has been damaged")                                                   \
  X(EVERSION, WORLD, "a file was written by a newer version")                                      \
  X(ELIMIT, WORLD, "a limit on size, time or memory was reached")                                  \
  X(EMISSING, WORLD, "a library or a driver is not installed")                                     \
  X(EDEVICE, WORLD, "a device failed")                                                             \
  X(EPEER, WORLD, "another process failed")                                                        \
  X(ECANCELLED, WORLD, "cancelled")

typedef enum ylm_status {
#define X(name, class, text) YLM_##name,
  YLM_STATUS_LIST(X)
#undef X
      YLM_STATUS_COUNT
} ylm_status;

/* One failure in words: the status and a sentence that names the place. */
typedef struct ylm_error {
  ylm_status status;
  char text[400];
} ylm_error;

/* The code's name without its prefix, "ERANGE"; "?" for a number that is none. */
YLM_API const char *ylm_status_name(ylm_status s);
/* The general sentence of the list above. */
YLM_API const char *ylm_status_text(ylm_status s);
/* True where the caller, not the world, has to change something. */
YLM_API bool ylm_status_is_callers(ylm_status s);
/* Writes status and formatted sentence to `e` (may be NULL) and returns `s`. */
YLM_API ylm_status ylm_fail(ylm_error *e, ylm_status s, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* ylm_fail with the status's general sentence. */
YLM_API ylm_status ylm_fail_plain(ylm_error *e, ylm_status s);
/* Memory ran out: YLM_ENOMEM with its general sentence, which the second form says of a file or a place. */
YLM_API ylm_status ylm_no_memory(ylm_error *e);
YLM_API ylm_status ylm_no_memory_for(ylm_error *e, const char *name);

/* -- memory ---------------------------------------------------------------- */

#define YLM_ALIGN 64

/* count*size bytes aligned to YLM_ALIGN; NULL if the product overflows or memory runs out.
   A size of 0 gives a valid pointer. */
YLM_API void *ylm_alloc(size_t count, size_t size) __attribute__((malloc));
/* ylm_alloc, with zeros. */
YLM_API void *ylm_alloc_zero(size_t count, size_t size) __attribute__((malloc));
/* A new block with a copy of `from`, which may be NULL where count is 0. */
YLM_API void *ylm_alloc_copy(const void *from, size_t count, size_t size) __attribute__((malloc));
/* Grows or shrinks a block of `used` valid bytes; on failure NULL, and `p` stays valid. */
YLM_API void *ylm_realloc(void *p, size_t used, size_t count, size_t size);
YLM_API void ylm_free(void *p);

/* memcpy and memset to 0 that may be told of NULL where there is nothing to do. */
static inline void ylm_copy(void *to, const void *from, size_t bytes) {
  if (bytes) memcpy(to, from, bytes);
}
static inline void ylm_zero(void *to, size_t bytes) {
  if (bytes) memset(to, 0, bytes);
}

/*
** ylm_regrow - ylm_realloc for arrays that become large: from some megabytes on, the system moves
** their pages instead of copying their contents, where it can.
**
**   p      in   NULL, or what the last call for this array gave
**   old    in   bytes asked for then; 0 with NULL
**   bytes  in   > 0; where fewer than before, what is behind is lost
**
** Returns NULL where memory runs out; p then stays valid. Such an array is freed by ylm_regrow_free
** with its last size.
*/
YLM_API void *ylm_regrow(void *p, size_t old, size_t bytes);
YLM_API void ylm_regrow_free(void *p, size_t bytes);

/* -- element types and shapes ---------------------------------------------- */

typedef enum ylm_dtype { YLM_FLOAT = 0, YLM_DOUBLE = 1 } ylm_dtype;

#define YLM_MAX_AXES 8

static inline size_t ylm_dtype_size(ylm_dtype t) {
  return t == YLM_DOUBLE ? sizeof(double) : sizeof(float);
}

/* Number i of numbers of type t; and x put in its place. */
static inline double ylm_get(ylm_dtype t, const void *from, size_t i) {
  return t == YLM_DOUBLE ? ((const double *)from)[i] : (double)((const float *)from)[i];
}
static inline void ylm_put(ylm_dtype t, void *to, size_t i, double x) {
  if (t == YLM_DOUBLE)
    ((double *)to)[i] = x;
  else
    ((float *)to)[i] = (float)x;
}

/* Product of the extents in *count; false if it, times 8 bytes, would overflow. */
YLM_API bool ylm_shape_count(int axes, const size_t *shape, size_t *count);

/* True if all n numbers are finite; else *where is the index of the first that is not. */
YLM_API bool ylm_all_finite(ylm_dtype t, const void *x, size_t n, size_t *where);
/* True if all n numbers are from -limit to limit, which is a number of the type, at least 0. */
YLM_API bool ylm_all_within(ylm_dtype t, const void *x, size_t n, double limit);

/* -- processor ------------------------------------------------------------- */

/*
** The instruction sets that kernels are compiled for, worst first.
** "reference" is the short scalar form that judges the others.
*/
#define YLM_ISA_LIST(X) X(reference) X(sse2) X(neon) X(avx2) X(avx512)

typedef enum ylm_isa {
#define X(name) YLM_ISA_##name,
  YLM_ISA_LIST(X)
#undef X
      YLM_ISA_COUNT
} ylm_isa;

YLM_API const char *ylm_isa_name(ylm_isa isa);
/* True if kernels for `isa` are built in and this processor runs them. */
YLM_API bool ylm_isa_available(ylm_isa isa);
/* The set in use: the environment's YLM_ISA where that names an available one, else the best. */
YLM_API ylm_isa ylm_isa_current(void);

/*
** ylm_environment_check - name the error in the environment's YLM_ISA and YLM_THREADS.
**
** The library falls back in silence; a program that wants its user to know asks here, once.
** Unset and empty are good. Returns YLM_OK, or YLM_EDOMAIN with a sentence that names the variable
** and what it may be: also for a set that this build or this processor lacks.
*/
YLM_API ylm_status ylm_environment_check(ylm_error *e);

/* -- progress and threads -------------------------------------------------- */

/*
** How long work reports and is stopped. `step` is called on the calling thread
** only, a few times a second at most, with done <= total; false cancels.
*/
typedef struct ylm_progress {
  bool (*step)(void *user, uint64_t done, uint64_t total, const char *stage);
  void *user;
} ylm_progress;

/* YLM_OK, or YLM_ECANCELLED if `p` (may be NULL) wants no more. */
YLM_API ylm_status ylm_report(const ylm_progress *p, uint64_t done, uint64_t total,
                              const char *stage);

/* Work that is a part of other work: steps begin .. begin + steps of `of`. */
typedef struct ylm_progress_part {
  ylm_progress base;
  const ylm_progress *whole;
  const char *stage; /* by which the whole names it; NULL: by the part's own stages */
  uint64_t begin, steps, of;
} ylm_progress_part;

/* The progress of that part, to be given to it while *p lives; NULL where `whole` is. */
YLM_API const ylm_progress *ylm_progress_part_of(ylm_progress_part *p, const ylm_progress *whole,
                                                 const char *stage, uint64_t begin, uint64_t steps,
                                                 uint64_t of);

#define YLM_THREADS_MOST 1024

/* The number of threads to use: `asked` if > 0, else the environment's YLM_THREADS where that is an
   integer from 1 to YLM_THREADS_MOST, else all cores; 1 .. YLM_THREADS_MOST. */
YLM_API int ylm_threads(int asked);

/* Work on items begin .. end-1; `worker` is 0 .. threads-1. */
typedef ylm_status ylm_range_fn(void *context, size_t begin, size_t end, int worker);

/*
** ylm_parallel - run `fn` over 0 .. n-1 in blocks of `grain` items.
**
** The cut into blocks depends on n and grain alone, so results that depend on
** blocks are the same whatever the number of threads. The first status other
** than YLM_OK stops the rest and is returned. With `progress`, the calling thread
** reports `stage` between two of its blocks, while others may still be at work.
** Not to be used in a fork()ed child of a process that has used it (OpenMP).
*/
YLM_API ylm_status ylm_parallel(size_t n, size_t grain, int threads, ylm_range_fn *fn,
                                void *context, const ylm_progress *progress, const char *stage);

/* Seconds on a clock that only goes forward. */
YLM_API double ylm_seconds(void);

/* -- random numbers -------------------------------------------------------- */

/* PCG32 (O'Neill 2014): small, seekable by stream, the same everywhere. */
typedef struct ylm_rng {
  uint64_t state, stream;
} ylm_rng;
YLM_API void ylm_rng_seed(ylm_rng *r, uint64_t seed, uint64_t stream);
YLM_API uint32_t ylm_rng_u32(ylm_rng *r);
/* Uniform in [0, 1), 53 random bits. */
YLM_API double ylm_rng_double(ylm_rng *r);

/* -- files ----------------------------------------------------------------- */

/* CRC-64/XZ of `size` bytes, continued from `crc` (0 to begin). */
YLM_API uint64_t ylm_crc64(uint64_t crc, const void *data, size_t size);
/* The sum of bytes whose sum is `a`, and of `size` bytes behind them whose sum, begun with 0, is `b`. */
YLM_API uint64_t ylm_crc64_join(uint64_t a, uint64_t b, uint64_t size);

/*
** ylm_file_read - a regular file's bytes, with a final 0 that is not counted.
** YLM_EIO (missing, a directory, a device), YLM_ELIMIT (larger than `limit`; 0: 4 GiB), YLM_ENOMEM.
** The caller frees *data with ylm_free.
*/
YLM_API ylm_status ylm_file_read(const char *path, size_t limit, unsigned char **data, size_t *size,
                                 ylm_error *e);

/* Reads up to `size` bytes of an open file, fewer at its end; writes all of them. False after an error, which errno tells; an
   interruption by a signal is none. */
YLM_API bool ylm_descriptor_read(int file, void *data, size_t size, size_t *got);
YLM_API bool ylm_descriptor_write(int file, const void *data, size_t size);

/* The first `room` bytes of a regular file, or all of them where it has fewer. YLM_EIO. */
YLM_API ylm_status ylm_file_head(const char *path, unsigned char *bytes, size_t room, size_t *size,
                                 ylm_error *e);

/* Whether ylm_file_create can open `path`, to be asked before long work. The commit's status has to
   be looked at all the same. Leaves nothing behind. */
YLM_API ylm_status ylm_file_probe(const char *path, ylm_error *e);

/*
** A file written beside its target, which ylm_file_commit renames over the target. The target holds
** the old bytes or the new ones and never a part, also where the process is killed. Links are
** followed; mode, owner and group of a target stay. A target that may not be written is refused,
** and so is one whose folder may not. Files of killed processes are removed an hour later. Errors
** stick; without a commit, ylm_file_discard removes what was written.
*/
typedef struct ylm_file ylm_file;
YLM_API ylm_status ylm_file_create(const char *path, ylm_file **f, ylm_error *e);
YLM_API ylm_status ylm_file_write(ylm_file *f, const void *data, size_t size);
/* The stream behind it, for libraries that want one. */
YLM_API FILE *ylm_file_stream(ylm_file *f);
YLM_API ylm_status ylm_file_commit(ylm_file *f, ylm_error *e); /* frees f */
YLM_API void ylm_file_discard(ylm_file *f);                    /* frees f */
/* All at once. */
YLM_API ylm_status ylm_file_save(const char *path, const void *data, size_t size, ylm_error *e);

/* -- array files ----------------------------------------------------------- */

/* The header of an .npy file (versions 1 to 3; float32 or float64, C order). */
typedef struct ylm_array_file {
  ylm_dtype dtype;
  int axes;
  size_t shape[YLM_MAX_AXES], count;
  uint32_t convention; /* of SH coefficients, from a comment that NumPy ignores; 0: ylm's */
  bool big_endian;
  const unsigned char *data; /* within the bytes given */
} ylm_array_file;

/* YLM_OK; YLM_EFORMAT (damaged, truncated, other elements), YLM_EVERSION, YLM_ELIMIT. */
YLM_API ylm_status ylm_array_file_parse(const unsigned char *bytes, size_t size, const char *name,
                                        ylm_array_file *a, ylm_error *e);
/* Its elements in this machine's byte order; out holds a->count of them. */
YLM_API void ylm_array_file_copy(const ylm_array_file *a, void *out);
/* Writes version 1. YLM_ESHAPE, YLM_EIO. */
YLM_API ylm_status ylm_array_file_write(const char *path, ylm_dtype t, int axes,
                                        const size_t *shape, uint32_t convention, const void *data,
                                        ylm_error *e);

/* -- light fields ---------------------------------------------------------- */

/* Results that are wanted of a light field at points; the bits add up. */
enum {
  YLM_WANT_VALUE = 1,    /* coefficients                          [n][channels][count]    */
  YLM_WANT_GRADIENT = 2, /* with respect to the point             [n][channels][count][3] */
  YLM_WANT_HESSIAN = 4,  /* xx xy xz yy yz zz                     [n][channels][count][6] */
  YLM_WANT_METRIC = 8    /* lambda and norm, see ylm_field_result [n]                     */
};

/* The content of a light field, or of a grid of it: light of lamps and sky that nothing occludes; with
   shadows; what surfaces send back; both; visibility. */
#define YLM_QUANTITY_LIST(X) X(lights) X(direct) X(indirect) X(all) X(visibility)

typedef enum ylm_quantity {
#define X(name) YLM_QUANTITY_##name,
  YLM_QUANTITY_LIST(X)
#undef X
      YLM_QUANTITY_COUNT
} ylm_quantity;

YLM_API const char *ylm_quantity_name(ylm_quantity q);
/* True where the field jumps at surfaces, which shadow it or send it back. */
static inline bool ylm_quantity_jumps(ylm_quantity q) { return q != YLM_QUANTITY_lights; }

typedef struct ylm_field_query {
  int lmax;                     /* 0 .. YLM_LMAX */
  int channels;                 /* 1 luminance (Rec. 709 weights), 3 linear rgb */
  int want;                     /* YLM_WANT_* added up */
  int metric_channels;          /* 1 or 3: of what lambda and norm are */
  ylm_dtype dtype;              /* of points and results */
  int threads;                  /* 0: the default */
  const ylm_progress *progress; /* may be NULL */
  const double *origin;         /* [3] points are relative to it; NULL: to 0. ylm_field_evaluate */
} ylm_field_query;

/*
** Where results go: pointers may be NULL where nothing is wanted.
**   lambda   L2 norm over coefficients of the largest absolute eigenvalue of each Hessian
**   norm     L2 norm of the coefficients
**   inside   1 where the point lies in or on a light (the field jumps there), or in a body, else 0
**   validity 1 less the share of directions that see sides of surfaces that are not used; written by
**            fields that tell it (ylm_field.tells_validity), float whatever the dtype
**   pairs    number of light x point evaluations, added to what stands there
*/
typedef struct ylm_field_result {
  void *value, *gradient, *hessian; /* dtype of the query */
  void *lambda, *norm;              /* dtype of the query */
  uint8_t *inside;
  uint64_t pairs;
  float *validity;
} ylm_field_result;

typedef struct ylm_field ylm_field;
struct ylm_field {
  const void *self;
  /* points [n][3]; overwrites the results asked for */
  ylm_status (*evaluate)(const ylm_field *f, const ylm_field_query *q, size_t n, const void *points,
                         ylm_field_result *r, ylm_error *e);
  /* out[i] = 1 if a surface on which the field jumps meets box i (boxes [n][6]: min, max) */
  ylm_status (*crosses)(const ylm_field *f, size_t n, const double *boxes, uint8_t *out);
  ylm_quantity quantity; /* what it holds */
  bool tells_validity;   /* evaluate writes r->validity where there is room for it */
  bool pointwise; /* a point's results are the same bits whatever other points the query has */
  bool relative;  /* evaluate honours the query's origin */
};

/*
** ylm_field_check - refuse a query that a field cannot answer.
**
**   points  in   [n][3] in the query's dtype; NULL: they are not looked at
**   most    in   the field's highest lmax
**   what    in   the light that is asked for, in the message on lmax: "these lights"
**
** Returns  YLM_OK; YLM_ERANGE (lmax), YLM_EINVAL (channels, a result without a place), YLM_EDOMAIN (a point or an origin that
** is not finite), YLM_ERANGE too of an origin beyond 1e15. field.c
*/
YLM_API ylm_status ylm_field_check(const ylm_field_query *q, size_t n, const void *points,
                                   const ylm_field_result *r, int most, const char *what,
                                   ylm_error *e);

/*
** ylm_field_evaluate - the field's `evaluate` for queries that may have an origin.
**
** Far from 0 a float keeps few digits of a position. Callers then take the points of a query
** relative to an origin nearby. Fields that do not know origins are asked in double at the points
** themselves, and their results are rounded.
**
** Returns  as the field; YLM_ENOMEM. field.c
*/
YLM_API ylm_status ylm_field_evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                                      const void *points, ylm_field_result *r, ylm_error *e);
/*
** ylm_origin - the origin for positions within a box (min, max).
**
** An origin is 0 unless the box is far from 0: its middle is beyond YLM_ORIGIN_NEAR and beyond
** YLM_ORIGIN_RATIO of its half edges. Otherwise the origin is the middle, rounded to a power of two
** that is at most half of the longest edge, so that differences from it are exact in double.
*/
#define YLM_ORIGIN_NEAR 64
#define YLM_ORIGIN_RATIO 16
YLM_API void ylm_origin(const double box[6], double origin[3]);

/* -- teams ----------------------------------------------------------------- */

/*
** Processes that run the same program with the same arguments, numbered 0 .. size-1. They call
** exchange and agree in the same order, and so the first next of each job. Results of work that is
** divided never depend on `size`: sums over processes are in nobody's power here.
**
** Threads   one at a time
** Failures  a process that says another status than YLM_OK waits some seconds for the others to hear
**           of it, and then goes on alone: every later call fails with YLM_EPEER.
*/
typedef struct ylm_team {
  void *self;
  int rank, size;
  uint32_t jobs; /* so many have begun; ylm_team_job */
  /* A task of a job, 0 .. n-1, each handed out once, in order; n: none is left. Every process asks
     until none is left, and agrees with the others before the next job. */
  ylm_status (*next)(void *self, uint32_t job, size_t n, size_t *task, ylm_error *e);
  /* No more tasks of the job are handed out. */
  void (*stop)(void *self, uint32_t job);
  /* Answers the others; called where progress is reported. */
  void (*serve)(void *self);
  /* Every process's bytes to every process. bytes [size], the same everywhere; `all` has their sum,
     in the order of processes. */
  ylm_status (*exchange)(void *self, const void *mine, const size_t *bytes, void *all,
                         ylm_error *e);
  /* The status of the first process that did not say YLM_OK, and its sentence, which *e has where
     `mine` is not YLM_OK. Returns once all have come. */
  ylm_status (*agree)(void *self, ylm_status mine, ylm_error *e);
  void (*free)(struct ylm_team *team); /* NULL: it lasts as long as the process */
} ylm_team;

/* The team of one process. YLM_ENOMEM. */
YLM_API ylm_status ylm_team_alone(ylm_team **team);
YLM_API void ylm_team_free(ylm_team *team);
/* The number of a new job, the same on every process. */
YLM_API uint32_t ylm_team_job(ylm_team *team);
/*
** ylm_team_same - refuse processes that were called differently.
**
**   what    in   the function, "bake"
**   names   in   [n] of its arguments
**   values  in   [n] checksums of theirs
**
** Returns  YLM_EINVAL where a process has another value than process 0: "bake: process 3 was called
** with another tolerance than process 1"; of exchange
*/
YLM_API ylm_status ylm_team_same(ylm_team *team, const char *what, size_t n,
                                 const char *const *names, const uint64_t *values, ylm_error *e);

#ifdef __cplusplus
}
#endif
#endif
