/* run.c - a bake in bricks by one process: the loop over jobs and their tasks. */
#include "brick.h"

#include <stdatomic.h>

/* One job; the first failure is kept. */
typedef struct running {
  plan *p;
  const ylm_progress *progress;
  size_t tasks;
  int inner; /* threads of a task */
  _Atomic size_t done;
  _Atomic int failed; /* 0: none, 1: somebody writes *e, whose status is `status` */
  ylm_error *e;
} running;

static ylm_status run_tasks(void *context, size_t begin, size_t end, int worker) {
  running *r = context;
  ylm_status s = YLM_OK;
  for (size_t i = begin; i < end && s == YLM_OK; i++) {
    ylm_error own = {0};
    ylm_progress_part part;
    size_t done = atomic_load(&r->done);
    /* Worker 0 is the calling thread, which may report. */
    const ylm_progress *progress =
        worker == 0
            ? ylm_progress_part_of(&part, r->progress, ylm__plan_stage(r->p), done, 1, r->tasks)
            : NULL;
    s = ylm__plan_task(r->p, i, r->inner, progress, &own);
    atomic_fetch_add(&r->done, 1);
    if (s != YLM_OK && r->e && atomic_exchange(&r->failed, 1) == 0) *r->e = own;
    if (s == YLM_OK && worker == 0)
      s = ylm_report(r->progress, atomic_load(&r->done), r->tasks, ylm__plan_stage(r->p));
  }
  return s;
}

/* All tasks of the job at hand: each by a thread, or one after the other by all. */
static ylm_status run_job(plan *p, ylm_error *e) {
  int threads = ylm_threads(p->source->threads);
  running r = {.p = p, .progress = p->source->progress, .tasks = ylm__plan_tasks(p), .e = e};
  bool each = !p->how.alone && threads > 1 && r.tasks >= (size_t)threads;
  r.inner = each ? 1 : threads;
  return each ? ylm_parallel(r.tasks, 1, threads, run_tasks, &r, NULL, NULL)
              : run_tasks(&r, 0, r.tasks, 0);
}

ylm_status ylm_grid_bake_bricks(const ylm_grid_form *form, const ylm_grid_source *source,
                                const ylm_grid_bricks *how, ylm_error *e) {
  plan *p;
  ylm_status s = ylm__plan_open(form, source, how, true, &p, e);
  while (s == YLM_OK && ylm__plan_tasks(p) > 0) {
    s = run_job(p, e);
    if (s == YLM_OK) s = ylm__plan_advance(p, e);
  }
  ylm__plan_close(p);
  return s;
}
