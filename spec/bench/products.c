/* products.c - products of two coefficient vectors: one at a time by method, and batches. */
#include "ylm_rival.h"
#include "ylm_sh.h"

#include "bench.h"

enum { BATCH = 1000 };

typedef struct job {
  const ylm_sh_product *plan;
  ylm_dtype t;
  size_t rows;
  const void *factor[2];
  void *out;
} job;

static void multiply(void *context) {
  job *j = context;
  ylm_sh_product_apply(j->plan, j->t, j->rows, j->factor, NULL, j->out, 1, NULL, NULL);
}

/* Nanoseconds for a product; 0 where the method does not do the size. */
static double measure(int lmax, ylm_sh_product_method m, ylm_dtype t, size_t rows,
                      void *const *memory) {
  ylm_sh_product *plan;
  if (ylm_sh_product_create(lmax, 2, m, YLM_SH_PRODUCT_auto, &plan, NULL) != YLM_OK) return 0;
  job j = {plan, t, rows, {memory[0], memory[1]}, memory[2]};
  double s = bench_seconds(multiply, &j) / (double)rows;
  ylm_sh_product_free(plan);
  return s * 1e9;
}

/* -- the traditional way, as plainly as it is written down ------------------------------------ */

typedef struct triple {
  uint16_t i, j, k;
  float integral;
} triple;

typedef struct list {
  triple *entry;
  size_t n, count; /* entries; coefficients */
  float a[400], b[400], out[400];
} list;

/* Every integral of Y_i Y_j Y_k that is not zero: the list of the paper's Sec. 3.1.3. */
static bool list_integrals(int lmax, list *all) {
  size_t n = ylm_sh_count(lmax), room = 0;
  double *unit = ylm_alloc(n, sizeof *unit), *matrix = ylm_alloc(n * n, sizeof *matrix);
  *all = (list){.count = n};
  for (size_t i = 0; unit && matrix && i < n; i++) {
    memset(unit, 0, n * sizeof *unit);
    unit[i] = 1;
    if (ylm_sh_product_matrix(lmax, unit, lmax, matrix, NULL) != YLM_OK) return false;
    for (size_t jk = 0; jk < n * n; jk++) {
      if (matrix[jk] > -1e-12 && matrix[jk] < 1e-12) continue;
      if (all->n == room) {
        triple *more = ylm_realloc(all->entry, room * sizeof *more, room * 2 + 4096, sizeof *more);
        if (!more) return false;
        all->entry = more;
        room = room * 2 + 4096;
      }
      all->entry[all->n++] =
          (triple){(uint16_t)i, (uint16_t)(jk / n), (uint16_t)(jk % n), (float)matrix[jk]};
    }
  }
  ylm_free(unit);
  ylm_free(matrix);
  bench_fill(YLM_FLOAT, all->a, n);
  bench_fill(YLM_FLOAT, all->b, n);
  return true;
}

static void walk(void *context) {
  list *t = context;
  memset(t->out, 0, t->count * sizeof *t->out);
  for (size_t e = 0; e < t->n; e++) {
    const triple *x = &t->entry[e];
    t->out[x->k] += x->integral * t->a[x->i] * t->b[x->j];
  }
}

/* How much faster the Fourier method is than that list: the paper says 3.0, 9.9, 21.7. */
static void traditional(void *const *memory) {
  static const int orders[] = {5, 7, 10, 15, 20};
  static const double paper[21] = {[10] = 3.0, [15] = 9.9, [20] = 21.7};
  static list all;
  printf("the paper's comparison, float: a list of all integrals that are not zero, walked one by "
         "one\n"
         "   n  integrals      list us  Fourier us  list/Fourier  (paper)\n");
  for (size_t i = 0; i < sizeof orders / sizeof *orders; i++) {
    if (!list_integrals(orders[i] - 1, &all)) return;
    double t = bench_seconds(walk, &all) * 1e6;
    double f = measure(orders[i] - 1, YLM_SH_PRODUCT_fourier, YLM_FLOAT, 1, memory) * 1e-3;
    printf("%4d %10zu %12.2f %11.2f %13.1f", orders[i], all.n, t, f, t / f);
    if (paper[orders[i]] > 0) printf("  (%.1f)", paper[orders[i]]);
    printf("\n");
    ylm_free(all.entry);
  }
}

int main(void) {
  static const int orders[] = {2, 3, 4, 5, 6, 7, 8, 10, 12, 15, 16, 20};
  /* Xin et al.'s method with FFTW, and DirectXMath's generated code, measured on this processor */
  static const double fftw[21] = {
      [8] = 3900, [10] = 10400, [12] = 14000, [16] = 36000, [20] = 127000};
  static const double directx[21] = {[3] = 20, [4] = 68, [5] = 176, [6] = 394};
  size_t n = BATCH * ylm_sh_count(19);
  ylm_rival_register();
  void *memory[3];
  for (int i = 0; i < 3; i++) {
    memory[i] = ylm_alloc(n, sizeof(double));
    if (!memory[i]) return 1;
  }
  printf("products of two vectors, one thread, ns each; n = lmax + 1 as in Xin et al. 2021\n");
  printf("to beat: FFTW %.0f %.0f %.0f %.0f %.0f at n = 8 10 12 16 20; DirectXMath 20 68 176 394 "
         "at n = 3 4 5 6\n",
         fftw[8], fftw[10], fftw[12], fftw[16], fftw[20]);
  for (int t = YLM_FLOAT; t <= YLM_DOUBLE; t++) {
    for (int i = 0; i < 2; i++) bench_fill((ylm_dtype)t, memory[i], n);
    printf("%s\n   n  auto      gaunt     quadrature  fourier   batch of %d  fourier/batch  best "
           "other\n",
           t ? "double" : "float", BATCH);
    for (size_t i = 0; i < sizeof orders / sizeof *orders; i++) {
      int order = orders[i];
      double a = measure(order - 1, YLM_SH_PRODUCT_auto, (ylm_dtype)t, 1, memory);
      double g =
          order <= 16 ? measure(order - 1, YLM_SH_PRODUCT_gaunt, (ylm_dtype)t, 1, memory) : 0;
      double q = measure(order - 1, YLM_SH_PRODUCT_quadrature, (ylm_dtype)t, 1, memory);
      double f = measure(order - 1, YLM_SH_PRODUCT_fourier, (ylm_dtype)t, 1, memory);
      double b = measure(order - 1, YLM_SH_PRODUCT_auto, (ylm_dtype)t, BATCH, memory);
      double other = fftw[order] ? fftw[order] : directx[order];
      printf("%4d  %8.1f  %8.1f  %8.1f  %9.1f  %8.1f  %11.1f   %8.0f\n", order, a, g, q, f, b,
             f / b, other);
    }
  }
  traditional(memory);
  return 0;
}
