/*
** sh.c - nanoseconds a point of ylm_sh_eval: one thread, batches of 256 points, each kernel set.
** With PEER=prefix in the environment, the sphericart that is installed there too, in double.
*/
#include <dlfcn.h>
#include <omp.h>

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

/* The C interface of sphericart: arrays with their lengths; its Hessians have 9 numbers. */
typedef struct peer {
  void *library, *calculator;
  void *(*create)(size_t lmax);
  void (*destroy)(void *calculator);
  void (*values)(void *, const double *, size_t, double *, size_t);
  void (*gradients)(void *, const double *, size_t, double *, size_t, double *, size_t);
  void (*hessians)(void *, const double *, size_t, double *, size_t, double *, size_t, double *,
                   size_t);
  job *j;
} peer;

/* Opens the library of a prefix; false if it or a function of it is missing. */
static bool open_peer(peer *p, const char *prefix) {
  static const char *const folders[] = {"lib", "lib64"};
  char path[4096];
  for (size_t i = 0; i < 2 && !p->library; i++) {
    snprintf(path, sizeof path, "%s/%s/libsphericart.so", prefix, folders[i]);
    p->library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
  }
  if (!p->library) return false;
#define FIND(member, name)                                                                         \
  *(void **)&p->member = dlsym(p->library, "sphericart_spherical_harmonics_" name)
  FIND(create, "new");
  FIND(destroy, "delete");
  FIND(values, "compute_array");
  FIND(gradients, "compute_array_with_gradients");
  FIND(hessians, "compute_array_with_hessians");
#undef FIND
  return p->create && p->destroy && p->values && p->gradients && p->hessians;
}

static void peer_eval(void *context) {
  peer *p = context;
  job *j = p->j;
  size_t n = POINTS * ylm_sh_count(j->lmax);
  if (j->how.derivatives == 0)
    p->values(p->calculator, j->p, 3 * POINTS, j->y, n);
  else if (j->how.derivatives == 1)
    p->gradients(p->calculator, j->p, 3 * POINTS, j->y, n, j->dy, 3 * n);
  else
    p->hessians(p->calculator, j->p, 3 * POINTS, j->y, n, j->dy, 3 * n, j->ddy, 9 * n);
}

static double nanoseconds(bench_fn *fn, job *j) { return bench_seconds(fn, j) / POINTS * 1e9; }

static const int degrees[] = {1,  2,  3,  4,  5,  6,  7,  8,  9,  10,
                              11, 12, 13, 14, 15, 16, 17, 18, 19, 20};
#define DEGREES (sizeof degrees / sizeof *degrees)

/* One line of the table: `p` measures sphericart, else isa < 0 only stores. */
static void line(job *j, const char *name, int isa, peer *p) {
  printf("%-7s %-10s", j->t == YLM_DOUBLE ? "double" : "float", name);
  j->how.isa = isa;
  for (size_t k = 0; k < DEGREES; k++) {
    char text[64];
    double ns[3];
    j->lmax = degrees[k];
    if (p) p->calculator = p->create((size_t)j->lmax);
    for (j->how.derivatives = 0; j->how.derivatives < 3; j->how.derivatives++)
      ns[j->how.derivatives] =
          p ? bench_seconds(peer_eval, p) / POINTS * 1e9 : nanoseconds(isa < 0 ? store : eval, j);
    if (p) p->destroy(p->calculator);
    snprintf(text, sizeof text, "%.3g/%.3g/%.3g", ns[0], ns[1], ns[2]);
    printf("  %-19s", text);
    fflush(stdout);
  }
  printf("\n");
}

int main(void) {
  size_t most = POINTS * ylm_sh_count(20) * sizeof(double);
  job j = {.how = {.threads = 1}};
  const char *prefix = getenv("PEER");
  peer p = {.j = &j};
  j.p = ylm_alloc(POINTS, 3 * sizeof(double));
  j.y = ylm_alloc(1, most), j.dy = ylm_alloc(3, most), j.ddy = ylm_alloc(9, most);
  if (!j.p || !j.y || !j.dy || !j.ddy) return 1;
  omp_set_num_threads(1); /* for the peer */
  printf(
      "spherical harmonics: ns per point, %d points, one thread; value / + gradient / + Hessian\n",
      POINTS);
  printf("%-7s %-10s", "type", "kernel");
  for (size_t k = 0; k < DEGREES; k++) printf("  lmax %-14d", degrees[k]);
  printf("\n");
  for (int t = 1; t >= 0; t--) {
    j.t = (ylm_dtype)t;
    bench_fill(j.t, j.p, 3 * POINTS);
    line(&j, "(memset)", -1, NULL);
    for (int isa = bench_is_quick() ? 1 : 0; isa < YLM_ISA_COUNT; isa++)
      if (ylm_isa_available((ylm_isa)isa)) line(&j, ylm_isa_name((ylm_isa)isa), isa, NULL);
    if (t == YLM_DOUBLE && prefix && *prefix) {
      if (open_peer(&p, prefix))
        line(&j, "sphericart", -1, &p);
      else
        fprintf(stderr, "PEER: no sphericart with C functions in %s/lib\n", prefix);
    }
  }
  ylm_free(j.p), ylm_free(j.y), ylm_free(j.dy), ylm_free(j.ddy);
  return 0;
}
