/* baker.c - a bake under way, from its beginning to its end. */
#include "baker.h"

#include <string.h>

/* Reports the progress of some work under the bake's own stage. */
static bool forward(void *user, uint64_t done, uint64_t total, const char *stage) {
  const baker *b = user;
  (void)stage;
  return ylm_report(b->source->progress, done, total, b->stage) == YLM_OK;
}

void ylm__baker_begin(baker *b, ylm_grid *g, const ylm_grid_source *source, ylm_error *e) {
  *b = (baker){.g = g, .source = source, .remote = source->backend, .e = e};
  b->own = ylm__processor_backend(b);
  if (g) b->measure = ylm__measure_of(&g->contents.form);
  if (g && source->backend) memset(g->origin, 0, sizeof g->origin); /* it asks at positions */
  b->stage = strcpy(b->stage_text, "verifying"); /* points that judge come before any level */
  b->progress = (ylm_progress){forward, b};
  b->making = (ylm_grid_making){.source = source,
                                .grid = g,
                                .stats = g ? &g->stats : NULL,
                                .progress = source->progress ? &b->progress : NULL,
                                .e = e};
}

void ylm__baker_free(baker *b) {
  ylm__evaluate_free_block(&b->block);
  ylm_free(b->row);
  ylm_free(b->wave.cell);
  ylm_free(b->next.cell);
  ylm_free(b->parent.cell);
  ylm_free(b->used);
}
