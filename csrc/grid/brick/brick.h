/*
** brick.h - a bake in bricks: jobs of tasks, which any process that sees the folder may do.
**
** A brick is the subtree of the octree under one cell, of level `bricks` or, where such a subtree grows too large, deeper. It
** is baked alone, by one call, and its files depend on nothing but form, source and brick. A bake is a sequence of jobs,
** equal in every process:
**
**   refine  one task a brick: its cells and evaluated points (CODE.a, CODE.b), or a mark that it is given up (CODE.s)
**   refine  the children of bricks that were given up, until none is
**   lights  one task a brick near points in lights: the voxels around these (CODE.c); no task where there are none
**   fill    one task: values for these points (fill)
**   join    one task a brick, and one for the top: the finished files (CODE.ylm, top.ylm)
**   finish  one task: the index
**
** The loop of a process, alone or of many:
**
**   ylm__plan_open(...)                                everyone; bakes the top, which is small
**   while ((n = ylm__plan_tasks(p)) > 0) {
**     for each task i of 0 .. n-1 that is handed out   one process each; threads may share them
**       ylm__plan_task(p, i, threads, progress, &e);
**     wait until all tasks of all processes are done, agree on errors
**     ylm__plan_advance(p, &e);                        everyone: reads from the folder what the others did
**   }
**   ylm__plan_close(p);
**
** A task whose files are there and whole is done at once: so bakes go on where they were. Everything that decides about
** later jobs stands in the folder; processes exchange nothing but the end of a job. run.c is that loop, by one process or by
** those of a team.
*/
#ifndef YLM_GRID_BRICK_H
#define YLM_GRID_BRICK_H

#include "../bake/baker.h"
#include "../file/file.h"
#include "calibration.h"

/* -- plan.c ------------------------------------------------------------------------------ */

#define BRICK_CODE (YLM_GRID_MAX_DEPTH + 1) /* octal digits of a brick's name, and the final 0 */

/* A cell that is a brick, and its name: the octants from the root. */
typedef struct brick {
  uint32_t origin[3]; /* lattice */
  uint32_t cell;      /* of the top */
  int level;
  float error; /* of the cell */
  char code[BRICK_CODE];
} brick;

typedef enum plan_job {
  PLAN_REFINE,
  PLAN_LIGHTS,
  PLAN_FILL,
  PLAN_JOIN,
  PLAN_FINISH,
  PLAN_DONE
} plan_job;

/* The processes that share a bake. */
typedef struct plan_team {
  ylm_team *team;
  bool agreed; /* all know that the bake has failed */
} plan_team;

typedef struct plan {
  plan_team *team;
  ylm_grid_form form; /* with the quantity of its field */
  const ylm_grid_source *source;
  ylm_grid_bricks how;
  bool owner; /* this process looks after the folder: the first of the team */
  int lock;   /* a descriptor; -1: none */
  baker top;
  plan_job job;
  brick *brick; /* [bricks] by code, once all are refined */
  size_t bricks;
  brick *wanted; /* [wanteds] of the refinement at hand, or near points in lights */
  size_t wanteds;
  bool filled; /* the file `fill` has values for points in lights */
} plan;

/*
** ylm__plan_open - begin a bake in bricks, or go on with it.
**
**   form, source  in  as of ylm_grid_bake; the source lives as long as the plan
**   how           in  level of the bricks, folder, limits
**   team          in  the first process looks after the folder: it makes it, writes `form`, holds the
**                     lock; the others wait until it has
**
** Returns  YLM_OK; YLM_EINVAL (form and options, or a folder of another bake: what differs), YLM_EBUSY
**          (another bake is at work), YLM_EIO, YLM_ENOMEM, what the field returns
*/
ylm_status ylm__plan_open(const ylm_grid_form *form, const ylm_grid_source *source,
                          const ylm_grid_bricks *how, plan_team *team, plan **p, ylm_error *e);
/* The status of the first process that has a bad one, once all have come; s where there is no team, or all know already. */
ylm_status ylm__plan_agree(plan_team *team, ylm_status s, ylm_error *e);
void ylm__plan_close(plan *p);
/* Tasks of the job at hand, the longest first; 0: the bake is done. */
size_t ylm__plan_tasks(const plan *p);
/* The job at hand, for progress. */
const char *ylm__plan_stage(const plan *p);
/*
** One task. Threads of a process may do tasks of one job at the same time, each with threads = 1, if the source's field may be
** asked by several. `progress` is called on the calling thread; it may be NULL.
*/
ylm_status ylm__plan_task(plan *p, size_t task, int threads, const ylm_progress *progress,
                          ylm_error *e);
/* The next job, once all tasks of this one are done in all processes. */
ylm_status ylm__plan_advance(plan *p, ylm_error *e);
/* Do several processes share the bake? */
static inline bool plan_is_shared(const plan *p) { return p->team->team->size > 1; }
/* The bricks whose closed boxes meet box [6] (lattice: lowest, highest), as numbers in p->brick, sorted.
   The caller frees *list. */
ylm_status ylm__plan_touching(const plan *p, const uint32_t box[6], uint32_t **list, size_t *n);
/* Before a brick in all that is decided by order? The top, NULL, is before all. */
bool ylm__brick_before(const brick *a, const brick *b);
/* The closed box of a brick, or of a cell of a level. */
static inline void brick_box(const plan *p, const uint32_t origin[3], int level, uint32_t box[6]) {
  for (int a = 0; a < 3; a++) {
    box[a] = origin[a];
    box[a + 3] = origin[a] + (1u << (p->form.depth - level));
  }
}
static inline bool boxes_touch(const uint32_t a[6], const uint32_t b[6]) {
  bool touch = true;
  for (int k = 0; k < 3; k++) touch &= a[k] <= b[k + 3] && b[k] <= a[k + 3];
  return touch;
}

/* -- top.c -------------------------------------------------------------------------------- */

/* Levels 0 to that of the bricks; p->wanted becomes the cells that go on. */
ylm_status ylm__top_bake(plan *p, ylm_error *e);
/* The cells of n bricks that were given up are split; p->wanted becomes their children that go on. */
ylm_status ylm__top_split(plan *p, size_t n, const brick *given_up, ylm_error *e);
/* A copy of the top, of its own: the cells of bricks are flagged. */
ylm_status ylm__top_copy(const plan *p, ylm_grid **g, ylm_error *e);
/* A checksum of the light that the top has seen. */
uint64_t ylm__top_light(const plan *p);
/* A checksum of where light is needed. */
uint64_t ylm__top_occupied(const plan *p);

/* -- folder.c ----------------------------------------------------------------------------- */

#define FOLDER_PATH 4096

/* The path of a file of the whole, or of a brick. */
void ylm__folder_file(const char *folder, const char *name, char out[FOLDER_PATH]);
void ylm__folder_brick(const char *folder, const char *code, const char *ending,
                       char out[FOLDER_PATH]);
bool ylm__folder_has(const char *path);
/* ylm__folder_has, of a file that another process of the team has written: a network file system may show it late. */
bool ylm__folder_awaits(const plan *p, const char *path);
/* Some milliseconds, before another look. */
void ylm__folder_rest(void);
/* Makes the folder, locks it, writes or compares the form. */
ylm_status ylm__folder_open(plan *p, ylm_error *e);
void ylm__folder_close(plan *p);
/* Makes renames in the folder of `path` durable, as far as the system can. */
void ylm__folder_sync(const char *path);
/* Makes a folder for a set in few bytes, which no bake goes on with; one that is such a folder already is emptied. */
ylm_status ylm__folder_pack(const char *folder, ylm_error *e);
/* Removes the files of a set; the folder too, where nothing else is in it. */
void ylm__folder_remove(const char *folder);
/* Files that only a bake under way needs. */
void ylm__folder_clean(const plan *p);

/* -- points.c: points and voxels in files ---------------------------------------------------- */

/* A point in a file; its rows [4][stride] are behind it. */
typedef struct point_record {
  uint32_t at[3], flags;
  float lambda, norm, validity, zero;
} point_record;
/* A voxel in a file; corners are numbers of its points, or YLM_GRID_NONE. */
typedef struct voxel_record {
  uint32_t origin[3], level, corner[8];
} voxel_record;

static inline size_t point_bytes(const ylm_grid *g) {
  return sizeof(point_record) + 4 * g->stride * sizeof(float);
}
void ylm__point_put(const ylm_grid *g, uint32_t point, void *record);
void ylm__point_take(ylm_grid *g, uint32_t point, const void *record);

/* Points and voxels of a file in memory. */
typedef struct point_list {
  size_t voxels, points, bytes;
  voxel_record *voxel;
  char *point; /* records of `bytes` bytes */
} point_list;
ylm_status ylm__points_write(const char *path, const point_list *l, ylm_error *e);
ylm_status ylm__points_read(const char *path, const ylm_grid *g, point_list *l, ylm_error *e);
void ylm__points_free(point_list *l);

/*
** The evaluated points on the boundary of a brick, by the 26 faces, edges and corners: section
** x + 3 y + 9 z, 0 at the lowest coordinate, 2 at the highest, 1 between.
*/
typedef struct border_head {
  char magic[8];
  uint32_t version, stride;
  uint64_t evaluated, invalid; /* points of the brick; those in lights on the boundary */
  uint64_t first[28];          /* of each section in the file; the number of all */
  uint64_t sum[27], crc;       /* of each section; of all before */
} border_head;
ylm_status ylm__border_write(const ylm_grid *g, const char *path, ylm_error *e);
ylm_status ylm__border_head(const char *path, border_head *h, ylm_error *e);
/* The records of a section; the caller frees them. */
ylm_status ylm__border_section(const char *path, const ylm_grid *g, const border_head *h,
                               int section, char **records, ylm_error *e);

/* -- tasks ----------------------------------------------------------------------------------- */

/* refine.c: bakes a brick, or gives it up. */
ylm_status ylm__brick_refine(const plan *p, const brick *k, int threads,
                             const ylm_progress *progress, ylm_error *e);
/* Has a brick been refined, or given up? YLM_OK: refined; YLM_ENOMEM where memory ran out; another status where it has not. */
ylm_status ylm__brick_look(const plan *p, const brick *k);
bool ylm__brick_given_up(const plan *p, const brick *k);
/* join.c: finishes a brick; the top where it is NULL. */
ylm_status ylm__brick_join(const plan *p, const brick *k, int threads, ylm_error *e);
/* lights.c: the voxels of a brick around points in lights that others have too; values for all of these. */
ylm_status ylm__brick_lights(const plan *p, const brick *k, int threads, ylm_error *e);
ylm_status ylm__brick_fill(const plan *p, ylm_error *e);
/* join.c: the grid of a brick, or of the top, with the evaluated points of its neighbours, in b->g. */
ylm_status ylm__brick_gather(const plan *p, const brick *k, int threads, ylm_grid_source *source,
                             baker *b, ylm_error *e);
/* index.c: the index, once all is joined. */
ylm_status ylm__brick_finish(const plan *p, ylm_error *e);

/* -- index.c ---------------------------------------------------------------------------------- */

typedef struct index_entry {
  uint32_t origin[3], level;
  uint64_t size;      /* bytes of its file */
  uint64_t evaluated; /* points, by this brick's own bake */
} index_entry;
typedef struct index_head {
  char magic[8];
  uint32_t version, level; /* of the bricks that were asked for */
  uint64_t bricks, points, interpolated, cells;
  grid_file_stats stats; /* of all */
  uint64_t crc;          /* of all before and of the entries */
} index_head;
/* Puts the checksum into h. */
ylm_status ylm__index_write(const char *folder, index_head *h, const index_entry *entries,
                            ylm_error *e);
ylm_status ylm__index_read(const char *folder, index_head *h, index_entry **entries, ylm_error *e);

#endif
