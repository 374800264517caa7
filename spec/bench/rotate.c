/*
** rotate.c - rotating one vector, construction included, and batches with a rotation made before.
*/
#include "ylm_sh.h"

#include "bench.h"

enum { BATCH = 1000 };

typedef struct job {
  const ylm_sh_rotator *plan;
  const ylm_sh_rotation *rotation;
  double r[9];
  int lmax;
  ylm_dtype t;
  size_t rows;
  void *in, *out;
} job;

static void one(void *context) {
  job *j = context;
  ylm_sh_rotate(j->plan, j->r, j->lmax, j->t, 1, j->in, j->out, 1, NULL, NULL);
}

static void batch(void *context) {
  job *j = context;
  ylm_sh_rotation_apply(j->rotation, j->lmax, j->rows, j->in, j->out, 1, NULL);
}

static void create(void *context) {
  job *j = context;
  ylm_sh_rotation *r;
  ylm_sh_rotation_create(j->plan, j->r, j->lmax, j->t, &r, NULL);
  ylm_sh_rotation_free(r);
}

int main(void) {
  static const int degrees[] = {1, 2, 3, 4, 5, 9, 19, 30, 60};
  static const double q[4] = {0.3, 0.5, -0.2, 0.7};
  printf("rotation, one thread, ns: one vector from a matrix; making the blocks; each of %d "
         "vectors by them\n",
         BATCH);
  printf("(to beat, one float vector: DirectXMath 58 at lmax 3, 91 at 5; ducc 4800 at 9, 14300 at "
         "19)\n");
  printf("lmax  type    one       blocks     of batch  one/batch\n");
  for (size_t i = 0; i < sizeof degrees / sizeof *degrees; i++)
    for (int t = YLM_FLOAT; t <= YLM_DOUBLE; t++) {
      job j = {.lmax = degrees[i], .t = (ylm_dtype)t, .rows = BATCH};
      ylm_sh_rotator *plan;
      ylm_sh_rotation *rotation;
      size_t n = BATCH * ylm_sh_count(j.lmax);
      ylm_sh_rotation_from_quaternion(q, j.r, NULL);
      if (ylm_sh_rotator_create(j.lmax, &plan, NULL) != YLM_OK ||
          ylm_sh_rotation_create(plan, j.r, j.lmax, j.t, &rotation, NULL) != YLM_OK)
        return 1;
      j.plan = plan;
      j.rotation = rotation;
      j.in = ylm_alloc(n, 8);
      j.out = ylm_alloc(n, 8);
      if (!j.in || !j.out) return 1;
      bench_fill(j.t, j.in, n);
      double a = bench_seconds(one, &j), b = bench_seconds(create, &j),
             c = bench_seconds(batch, &j) / BATCH;
      printf("%4d  %-6s %8.1f  %9.0f  %9.2f  %6.1f\n", j.lmax, t ? "double" : "float", a * 1e9,
             b * 1e9, c * 1e9, a / c);
      ylm_free(j.in);
      ylm_free(j.out);
      ylm_sh_rotation_free(rotation);
      ylm_sh_rotator_free(plan);
    }
  return 0;
}
