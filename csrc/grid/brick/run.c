/* run.c - a bake in bricks: the loop over jobs and their tasks, by the threads of one process or of those of a team. */
#include "brick.h"

#include <pthread.h>
#include <stdatomic.h>

/* One job; the first failure is kept. */
typedef struct running {
  plan *p;
  const ylm_progress *progress;
  uint32_t job; /* of the team */
  size_t tasks;
  int inner;            /* threads of a task */
  double deadline;      /* on the clock of ylm_seconds; 0: none */
  pthread_mutex_t lock; /* around calls of the team */
  _Atomic size_t done;
  _Atomic double longest; /* seconds of a task */
  _Atomic bool late;      /* a task is left, the time for it is not */
  _Atomic int failed;     /* 0: none, 1: somebody writes *e, whose status is `status` */
  ylm_error *e;
} running;

/* The next task, in order, of this process or of the team; none where the next would end too late. */
static ylm_status next_task(running *r, size_t *task, ylm_error *e) {
  ylm_team *t = r->p->team->team;
  pthread_mutex_lock(&r->lock);
  ylm_status s = t->next(t->self, r->job, r->tasks, task, e);
  pthread_mutex_unlock(&r->lock);
  if (s == YLM_OK && *task < r->tasks && r->deadline > 0 &&
      ylm_seconds() + atomic_load(&r->longest) > r->deadline) {
    atomic_store(&r->late, true); /* a later call finds it */
    *task = r->tasks;
  }
  return s;
}

static ylm_status run_task(running *r, size_t task, int worker, ylm_error *e) {
  ylm_progress_part part;
  /* Worker 0 is the calling thread, which may report. */
  const ylm_progress *progress =
      worker == 0 ? ylm_progress_part_of(&part, r->progress, ylm__plan_stage(r->p),
                                         atomic_load(&r->done), 1, r->tasks)
                  : NULL;
  double begin = ylm_seconds();
  ylm_status s = ylm__plan_task(r->p, task, r->inner, progress, e);
  double seconds = ylm_seconds() - begin;
  if (seconds > atomic_load(&r->longest)) atomic_store(&r->longest, seconds);
  /* Tasks are handed out in order: those before this one have been taken. */
  if (task + 1 > atomic_load(&r->done)) atomic_store(&r->done, task + 1);
  if (s == YLM_OK && worker == 0)
    s = ylm_report(r->progress, atomic_load(&r->done), r->tasks, ylm__plan_stage(r->p));
  return s;
}

/* A thread: one task after another, until none is left. */
static ylm_status run_tasks(void *context, size_t begin, size_t end, int worker) {
  running *r = context;
  ylm_team *t = r->p->team->team;
  ylm_status s = YLM_OK;
  (void)begin;
  (void)end;
  while (s == YLM_OK) {
    ylm_error own = {0};
    size_t task;
    s = next_task(r, &task, &own);
    if (s == YLM_OK && task == r->tasks) break;
    if (s == YLM_OK) s = run_task(r, task, worker, &own);
    if (s != YLM_OK && r->e && atomic_exchange(&r->failed, 1) == 0) *r->e = own;
  }
  if (s != YLM_OK || atomic_load(&r->late)) {
    pthread_mutex_lock(&r->lock);
    t->stop(t->self, r->job);
    pthread_mutex_unlock(&r->lock);
  }
  return s;
}

/* Has any process of the team left a task for want of time? */
static ylm_status ask_late(plan_team *team, bool *late, ylm_error *e) {
  ylm_team *t = team->team;
  size_t size = (size_t)t->size;
  uint8_t mine = *late, *all = ylm_alloc(size, 1);
  size_t *bytes = ylm_alloc(size, sizeof *bytes);
  ylm_status s = ylm__plan_agree(team, all && bytes ? YLM_OK : YLM_ENOMEM, e);
  for (size_t i = 0; s == YLM_OK && i < size; i++) bytes[i] = 1;
  if (s == YLM_OK) {
    s = t->exchange(t->self, &mine, bytes, all, e);
    team->agreed |= s != YLM_OK;
  }
  for (size_t i = 0; s == YLM_OK && i < size; i++) *late |= all[i];
  ylm_free(all);
  ylm_free(bytes);
  return s;
}

/* All tasks of the job at hand: each by a thread, or one after the other by all. */
static ylm_status run_job(plan *p, const ylm_progress *progress, double deadline, ylm_error *e) {
  int threads = ylm_threads(p->source->threads);
  ylm_team *t = p->team->team;
  running r = {.p = p,
               .progress = progress,
               .job = ylm_team_job(t),
               .tasks = ylm__plan_tasks(p),
               .deadline = deadline,
               .e = e};
  pthread_mutex_init(&r.lock, NULL);
  bool each = !p->how.alone && threads > 1 && r.tasks >= (size_t)threads * (size_t)t->size;
  r.inner = each ? 1 : threads;
  ylm_status s = each ? ylm_parallel((size_t)threads, 1, threads, run_tasks, &r, NULL, NULL)
                      : run_tasks(&r, 0, 1, 0);
  pthread_mutex_destroy(&r.lock);
  if (s != YLM_OK && e && e->status != YLM_OK) s = e->status; /* of several, that of *e */
  s = ylm__plan_agree(p->team, s, e);
  bool late = atomic_load(&r.late);
  if (s == YLM_OK && deadline > 0) s = ask_late(p->team, &late, e);
  if (s == YLM_OK && late) {
    p->team->agreed = true;
    s = ylm_fail(e, YLM_ELIMIT, "%s: not finished: the time is over; a call again goes on",
                 p->how.folder);
  }
  return s;
}

/* Whether the processes of a team were given folders of one name. Where they lie may differ from machine to machine. */
static ylm_status same_folder(ylm_team *t, const char *folder, ylm_error *e) {
  static const char *const name = "name of the folder of bricks (to, -o)";
  const char *slash = strrchr(folder, '/'), *last = slash ? slash + 1 : folder;
  uint64_t print = ylm_crc64(0, last, strlen(last));
  return ylm_team_same(t, "", 1, &name, &print, e);
}

static ylm_status run_jobs(plan_team *team, const ylm_grid_form *form,
                           const ylm_grid_source *source, const ylm_grid_bricks *how,
                           ylm_error *e) {
  plan *p = NULL;
  double begin = ylm_seconds();
  ylm_status s = team->team->size > 1 ? ylm__divide_same(team->team, form, source, e) : YLM_OK;
  if (s == YLM_OK && team->team->size > 1) s = same_folder(team->team, how->folder, e);
  team->agreed = s != YLM_OK;
  if (s == YLM_OK) s = ylm__plan_open(form, source, how, team, &p, e);
  while (s == YLM_OK && ylm__plan_tasks(p) > 0) {
    s = run_job(p, source->progress, how->seconds > 0 ? begin + how->seconds : 0, e);
    if (s == YLM_OK) s = ylm__plan_advance(p, e);
  }
  s = ylm__plan_agree(team, s, e);
  ylm__plan_close(p);
  return s;
}

ylm_status ylm_grid_bake_bricks(const ylm_grid_form *form, const ylm_grid_source *source,
                                const ylm_grid_bricks *how, ylm_error *e) {
  ylm_team *one = NULL;
  ylm_grid_source own = *source;
  ylm_status s = YLM_OK;
  if (!source->team) s = ylm_team_alone(&one);
  if (s != YLM_OK) return ylm__grid_no_room(s, source, e);
  plan_team team = {.team = one ? one : source->team};
  own.team = NULL; /* a brick is one process's */
  s = run_jobs(&team, form, &own, how, e);
  ylm_team_free(one);
  return s;
}
