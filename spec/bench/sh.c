/* sh.c - nanoseconds a point of ylm_sh_eval: one thread, batches of 256 points, each kernel set. */
#include "bench.h"
#include "ylm_sh.h"

#define POINTS 256

typedef struct job {
  ylm_sh_how how;
  int lmax;
  ylm_dtype t;
  void *p, *y, *dy, *ddy;
} job;

static void eval(void *context) {
  job *j = context;
  ylm_sh_eval_how(&j->how, j->lmax, j->t, POINTS, j->p, j->y, j->dy, j->ddy, NULL);
}

static void store(void *context) {
  job *j = context;
  size_t n = POINTS * ylm_sh_count(j->lmax) * ylm_dtype_size(j->t);
  memset(j->y, 1, n);
  if (j->how.derivatives > 0) memset(j->dy, 1, 3 * n);
  if (j->how.derivatives > 1) memset(j->ddy, 1, 6 * n);
}

static double nanoseconds(bench_fn *fn, job *j) { return bench_seconds(fn, j) / POINTS * 1e9; }

int main(void) {
  static const int degrees[] = {1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20};
  size_t most = POINTS * ylm_sh_count(20) * sizeof(double);
  job j = {.how = {.threads = 1}};
  j.p = ylm_alloc(POINTS, 3 * sizeof(double));
  j.y = ylm_alloc(1, most), j.dy = ylm_alloc(3, most), j.ddy = ylm_alloc(6, most);
  if (!j.p || !j.y || !j.dy || !j.ddy) return 1;
  printf("spherical harmonics: ns per point, %d points, one thread; value / + gradient / + Hessian\n", POINTS);
  printf("%-7s %-10s", "type", "kernel");
  for (size_t k = 0; k < sizeof degrees / sizeof *degrees; k++) printf("  lmax %-14d", degrees[k]);
  printf("\n");
  for (int t = 1; t >= 0; t--) {
    j.t = (ylm_dtype)t;
    bench_fill(j.t, j.p, 3 * POINTS);
    for (int isa = -1; isa < YLM_ISA_COUNT; isa++) {
      if (isa >= 0 && !ylm_isa_available((ylm_isa)isa)) continue;
      if (isa == YLM_ISA_reference && bench_is_quick()) continue;
      j.how.isa = isa;
      printf("%-7s %-10s", t ? "double" : "float", isa < 0 ? "(memset)" : ylm_isa_name((ylm_isa)isa));
      for (size_t k = 0; k < sizeof degrees / sizeof *degrees; k++) {
        char text[64];
        double ns[3];
        j.lmax = degrees[k];
        for (j.how.derivatives = 0; j.how.derivatives < 3; j.how.derivatives++)
          ns[j.how.derivatives] = nanoseconds(isa < 0 ? store : eval, &j);
        snprintf(text, sizeof text, "%.3g/%.3g/%.3g", ns[0], ns[1], ns[2]);
        printf("  %-19s", text);
        fflush(stdout);
      }
      printf("\n");
    }
  }
  ylm_free(j.p), ylm_free(j.y), ylm_free(j.dy), ylm_free(j.ddy);
  return 0;
}
