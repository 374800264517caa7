/* team.c - processes that share work: the team of one, and the check that all were called alike. */
#include "ylm_base.h"

typedef struct alone {
  ylm_team team;
  uint32_t job;
  bool stopped;
  size_t handed;
} alone;

static ylm_status next(void *self, uint32_t job, size_t n, size_t *task, ylm_error *e) {
  alone *t = self;
  (void)e;
  if (job != t->job) t->job = job, t->handed = 0, t->stopped = false;
  *task = t->handed < n && !t->stopped ? t->handed++ : n;
  return YLM_OK;
}

static void stop(void *self, uint32_t job) {
  alone *t = self;
  if (job == t->job) t->stopped = true;
}

static void serve(void *self) { (void)self; }

static ylm_status exchange(void *self, const void *mine, const size_t *bytes, void *all,
                           ylm_error *e) {
  (void)self;
  (void)e;
  if (bytes[0]) memmove(all, mine, bytes[0]);
  return YLM_OK;
}

static ylm_status agree(void *self, ylm_status mine, ylm_error *e) {
  (void)self;
  (void)e;
  return mine;
}

static void release(ylm_team *team) { ylm_free(team->self); }

ylm_status ylm_team_alone(ylm_team **team) {
  alone *t = ylm_alloc_zero(1, sizeof *t);
  *team = NULL;
  if (!t) return YLM_ENOMEM;
  t->team = (ylm_team){.self = t,
                       .size = 1,
                       .next = next,
                       .stop = stop,
                       .serve = serve,
                       .exchange = exchange,
                       .agree = agree,
                       .free = release};
  *team = &t->team;
  return YLM_OK;
}

void ylm_team_free(ylm_team *team) {
  if (team && team->free) team->free(team);
}

uint32_t ylm_team_job(ylm_team *team) { return ++team->jobs; }

ylm_status ylm_team_same(ylm_team *team, const char *what, size_t n, const char *const *names,
                         const uint64_t *values, ylm_error *e) {
  size_t size = (size_t)team->size;
  if (size == 1) return YLM_OK;
  uint64_t *all = ylm_alloc(size * n, sizeof *all);
  size_t *bytes = ylm_alloc(size, sizeof *bytes);
  ylm_status s = team->agree(team->self, all && bytes ? YLM_OK : YLM_ENOMEM, e);
  for (size_t r = 0; s == YLM_OK && r < size; r++) bytes[r] = n * sizeof *all;
  if (s == YLM_OK) s = team->exchange(team->self, values, bytes, all, e);
  for (size_t r = 1; r < size; r++)
    for (size_t i = 0; i < n && s == YLM_OK; i++)
      if (all[r * n + i] != all[i])
        s = ylm_fail(e, YLM_EINVAL, "%s%sprocess %zu was called with another %s than process 1",
                     what, *what ? ": " : "", r + 1, names[i]);
  ylm_free(all);
  ylm_free(bytes);
  return s;
}
