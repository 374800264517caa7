/*
** steps.h - lists of work, built step by step: for long sequences of small kernels. Private.
**
** After a failure the functions do nothing; ylm__steps_run says what it was.
*/
#ifndef YLM_GPU_STEPS_H
#define YLM_GPU_STEPS_H

#include "ylm_vulkan.h"

#define STEP_GROUP 64u /* invocations of a group */
#define STEP_WORDS 12

typedef struct step_queue {
  ylm_gpu *g;
  const char *stage;            /* of the steps that come next */
  ylm_gpu_times *times;         /* may be NULL */
  const ylm_progress *progress; /* may be NULL */
  ylm_gpu_work *work;
  uint32_t (*push)[STEP_WORDS];
  size_t n, room;
  ylm_gpu_buffer *blocks[2]; /* of scans */
  ylm_status status;
  ylm_error *e;
} step_queue;

/* Constants of a kernel beside the group's size; `cost` is that of a group. */
typedef struct step_kernel {
  const char *name;
  int constants;
  uint32_t constant[4];
  double cost;
} step_kernel;

void ylm__steps_free(step_queue *q);

/* A dispatch of `items` invocations, rounded up to groups. */
void ylm__steps_dispatch(step_queue *q, const step_kernel *k, uint64_t items, int words,
                         const uint32_t *push, int binds, ylm_gpu_buffer *const *buffer);
/* Of the last step's buffer `bind` only so many bytes from `offset` on. */
void ylm__steps_part(step_queue *q, int bind, uint64_t offset, uint64_t bytes);
/* A step as it is, of the stage at hand; its push constants are copied. */
void ylm__steps_work(step_queue *q, const ylm_gpu_work *w);
void ylm__steps_fill(step_queue *q, ylm_gpu_buffer *b, uint32_t value);
void ylm__steps_copy(step_queue *q, ylm_gpu_buffer *from, uint64_t bytes, ylm_gpu_buffer *to);

enum { SCAN_PLAIN, SCAN_BITS, SCAN_OWN }; /* KIND of octree_scan.comp */
#define SCAN_NO_SUM UINT32_MAX

/* before[i] = sum of f(x[k]), k < i; the sum of all goes to counts[slot]. */
void ylm__steps_scan(step_queue *q, int kind, uint32_t mask, ylm_gpu_buffer *x, uint32_t n,
                     ylm_gpu_buffer *before, ylm_gpu_buffer *counts, uint32_t slot);

/* Does what is queued and empties the queue. */
ylm_status ylm__steps_run(step_queue *q);

/* Does what is queued, reads n counts and queues that they become 0. */
ylm_status ylm__steps_counts(step_queue *q, ylm_gpu_buffer *counts, int n, uint32_t *count);

/* A buffer of at least so many bytes in *b: the one that is there if it is long enough. */
ylm_status ylm__steps_reserve(ylm_gpu *g, ylm_gpu_buffer **b, uint64_t bytes, ylm_error *e);

/* Adds the host's seconds since `start` to a stage that dispatches nothing; times may be NULL. */
void ylm__steps_copied(ylm_gpu_times *times, const char *stage, double start);

#endif
