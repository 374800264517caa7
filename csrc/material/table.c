/* table.c - materials as tables of spherical harmonics: slices at rows and columns, and what is between them. */
#include "ylm_material_table.h"

#include <math.h>
#include <string.h>

#include "fit.h"
#include "kind.h"
#include "slice.h"
#include "table.h"
#include "ylm_sh.h"

/* -- making -------------------------------------------------------------------- */

/* Slices in the making, one behind the other: numbers [3][width], then the part missed [lmax + 1]. */
typedef struct making {
  const ylm_material *m;
  ylm_material_table_form form;
  bool halves, mirrored; /* mirrored: a quarter of the columns says what the others are */
  size_t width, size;    /* of a channel; of a slice */
  int rows, columns;
  double *slice; /* [columns][rows][size] */
  slice_room **room;
  material_fit *fit; /* NULL: slices are as they are */
} making;

typedef struct wanted {
  double angle, azimuth;
  double *to;
} wanted;

typedef struct batch {
  making *x;
  const wanted *list;
} batch;

static void keep(const making *x, const material_slice *s, double *to) {
  size_t count = ylm_sh_count(x->form.lmax), k = 0;
  double total = s->total[0] + s->total[1] + s->total[2], left = total;
  if (x->fit)
    for (size_t c = 0; c < 3; c++) left -= ylm__fit(x->fit, s->c + c * count);
  for (size_t c = 0; c < 3; c++)
    for (int l = 0; l <= x->form.lmax; l++)
      for (int m = x->halves ? 0 : -l; m <= l; m++, k++)
        to[k] = s->c[c * count + (size_t)(l * l + l + m)];
  for (int l = 0; l <= x->form.lmax; l++) {
    for (size_t c = 0; c < 3; c++)
      for (int i = l * l; i < (l + 1) * (l + 1); i++) {
        double v = s->c[c * count + (size_t)i];
        if (!x->fit) left -= v * v;
      }
    to[k++] = total > 0 ? sqrt(fmax(0, left / total)) : 0;
  }
}

static ylm_status slices(void *context, size_t begin, size_t end, int worker) {
  const batch *b = context;
  making *x = b->x;
  material_slice s = {.c = ylm_alloc(3 * ylm_sh_count(x->form.lmax), sizeof(double))};
  if (!x->room[worker]) x->room[worker] = ylm__slice_room(x->form.lmax);
  ylm_status status = s.c && x->room[worker] ? YLM_OK : YLM_ENOMEM;
  for (size_t i = begin; status == YLM_OK && i < end; i++) {
    const wanted *w = b->list + i;
    status = ylm__slice(x->m, x->room[worker], w->angle, w->azimuth, x->form.slice, &s);
    if (status == YLM_OK) keep(x, &s, w->to);
  }
  ylm_free(s.c);
  return status;
}

static ylm_status make(making *x, size_t n, const wanted *list) {
  batch b = {x, list};
  return ylm_parallel(n, 1, x->form.threads, slices, &b, x->form.progress, "table");
}

static double angle_of(double row, int rows) { return TABLE_LAST * row / (rows - 1); }
static double azimuth_of(double column, int columns) { return 2 * YLM_PI * column / columns; }

/* Slice (row, column), rows from -1 to `rows`: of what is beyond the normal, the other side's. */
static double *at(const making *x, int row, int column) {
  int turned = row < 0 ? (column + x->columns / 2) % x->columns : column;
  return x->slice + x->size * ((size_t)turned * (size_t)x->rows + (size_t)(row < 0 ? -row : row));
}

/* Adds `weight` times that to [3][width]. */
static void add_slice(const making *x, int row, int column, double weight, double *to) {
  if (row == x->rows) { /* straight on */
    add_slice(x, x->rows - 1, column, 2 * weight, to);
    add_slice(x, x->rows - 2, column, -weight, to);
    return;
  }
  const double *from = at(x, row, column);
  size_t k = 0;
  for (int c = 0; c < 3; c++)
    for (int l = 0; l <= x->form.lmax; l++)
      for (int m = x->halves ? 0 : -l; m <= l; m++, k++)
        to[k] += (row < 0 && (m & 1) ? -weight : weight) * from[k];
}

/* The distance of slice `exact` from what stands between, relative to its norm. */
static double difference(const making *x, const double *between, const double *exact) {
  double d = 0, norm = 0;
  for (size_t k = 0; k < 3 * x->width; k++) {
    d += (between[k] - exact[k]) * (between[k] - exact[k]);
    norm += exact[k] * exact[k];
  }
  return norm > 0 ? sqrt(d / norm) : 0;
}

/* The errors halfway between rows, at TABLE_JUDGES columns; `exact` gets the slices there: [TABLE_JUDGES][rows - 1][size]. */
static ylm_status judge_rows(making *x, double *exact, double *between, wanted *list, double *error,
                             double *grazing) {
  int judges = x->columns == 1 ? 1 : x->mirrored ? TABLE_JUDGES / 2 : TABLE_JUDGES, n = 0;
  for (int j = 0; j < judges; j++)
    for (int i = 0; i + 1 < x->rows; i++, n++)
      list[n] = (wanted){angle_of(i + 0.5, x->rows),
                         azimuth_of(j * x->columns / TABLE_JUDGES, x->columns),
                         exact + x->size * (size_t)n};
  ylm_status s = make(x, (size_t)n, list);
  *error = *grazing = 0;
  for (int k = 0; s == YLM_OK && k < n; k++) {
    int i = k % (x->rows - 1), j = k / (x->rows - 1) * x->columns / TABLE_JUDGES;
    double w[4];
    ylm__table_cubic(0.5, w);
    memset(between, 0, 3 * x->width * sizeof *between);
    for (int q = 0; q < 4; q++) add_slice(x, i - 1 + q, j, w[q], between);
    double *worst = list[k].angle <= TABLE_LAST_TOLD ? error : grazing;
    *worst = fmax(*worst, difference(x, between, list[k].to));
  }
  return s;
}

/* The error halfway between columns, at TABLE_JUDGES rows. */
static ylm_status judge_columns(making *x, double *exact, double *between, wanted *list,
                                double *error) {
  int n = 0, beside = x->mirrored ? x->columns / 4 : x->columns;
  for (int j = 0; j < TABLE_JUDGES; j++)
    for (int i = 0; i < beside; i++, n++)
      list[n] = (wanted){angle_of((j + 1) * (x->rows - 3) / TABLE_JUDGES, x->rows),
                         azimuth_of(i + 0.5, x->columns), exact + x->size * (size_t)n};
  ylm_status s = make(x, (size_t)n, list);
  *error = 0;
  for (int k = 0; s == YLM_OK && k < n; k++) {
    int i = k % beside, row = (k / beside + 1) * (x->rows - 3) / TABLE_JUDGES;
    double w[4];
    ylm__table_cubic(0.5, w);
    memset(between, 0, 3 * x->width * sizeof *between);
    for (int q = 0; q < 4; q++)
      add_slice(x, row, (i - 1 + q + x->columns) % x->columns, w[q], between);
    *error = fmax(*error, difference(x, between, list[k].to));
  }
  return s;
}

/* Slices beyond the first quarter of the columns, each as one before, mirrored: m < 0 changes sign. */
static void mirror(making *x) {
  for (int j = x->columns / 4 + 1; j < x->columns; j++) {
    int as = j <= x->columns / 2 ? x->columns / 2 - j : x->columns - j;
    for (int i = 0; i < x->rows; i++) {
      const double *from = at(x, i, as);
      double *to = at(x, i, j);
      memcpy(to, from, x->size * sizeof *to);
      for (size_t c = 0, k = 0; c < 3; c++)
        for (int l = 0; l <= x->form.lmax; l++)
          for (int m = -l; m <= l; m++, k++)
            if (m < 0) to[k] = -to[k];
    }
  }
}

/* Makes all slices of x->rows and x->columns that `old`, of half as many (or NULL), has not. */
static ylm_status fill(making *x, const making *old) {
  size_t n = 0, all = (size_t)x->rows * (size_t)x->columns;
  wanted *list = ylm_alloc(all, sizeof *list);
  x->slice = ylm_alloc(all * x->size, sizeof *x->slice);
  ylm_status s = list && x->slice ? YLM_OK : YLM_ENOMEM;
  int by_row = old && old->rows < x->rows ? 2 : 1,
      by_column = old && old->columns < x->columns ? 2 : 1;
  for (int j = 0; s == YLM_OK && j < x->columns; j++)
    for (int i = 0; i < x->rows; i++) {
      double *to = at(x, i, j);
      if (old && i % by_row == 0 && j % by_column == 0)
        memcpy(to, at(old, i / by_row, j / by_column), x->size * sizeof *to);
      else if (!x->mirrored || j <= x->columns / 4)
        list[n++] = (wanted){angle_of(i, x->rows), azimuth_of(j, x->columns), to};
    }
  if (s == YLM_OK) s = make(x, n, list);
  if (s == YLM_OK && x->mirrored) mirror(x);
  ylm_free(list);
  return s;
}

/* Doubles rows or columns as long as there is too much between them. */
static ylm_status refine(making *x, double *error, double *grazing) {
  for (;;) {
    size_t judged = TABLE_JUDGES * (size_t)(x->rows > x->columns ? x->rows : x->columns);
    double *exact = ylm_alloc(judged * x->size, sizeof *exact);
    double *between = ylm_alloc(3 * x->width, sizeof *between);
    wanted *list = ylm_alloc(judged, sizeof *list);
    double by_rows = 0, by_columns = 0;
    ylm_status s = exact && between && list ? YLM_OK : YLM_ENOMEM;
    if (s == YLM_OK) s = judge_rows(x, exact, between, list, &by_rows, grazing);
    if (s == YLM_OK && x->columns > 1) s = judge_columns(x, exact, between, list, &by_columns);
    ylm_free(exact), ylm_free(between), ylm_free(list);
    *error = fmax(by_rows, by_columns);
    if (s != YLM_OK || x->form.error <= 0 || *error <= x->form.error) return s;
    making old = *x;
    if (by_rows > x->form.error && 2 * x->rows - 1 <= YLM_MATERIAL_TABLE_ROWS)
      x->rows = 2 * x->rows - 1;
    if (by_columns > x->form.error && 2 * x->columns <= YLM_MATERIAL_TABLE_ROWS) x->columns *= 2;
    if (x->rows == old.rows && x->columns == old.columns) return YLM_OK;
    s = fill(x, &old);
    ylm_free(old.slice);
    if (s != YLM_OK) return s;
  }
}

/* Eigenvectors v[k] of a symmetric 3 x 3 matrix and their eigenvalues: Jacobi's rotations. */
static void eigenvectors(double a[3][3], double v[3][3], double value[3]) {
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) v[i][j] = i == j;
  for (int sweep = 0; sweep < 30; sweep++)
    for (int p = 0; p < 2; p++)
      for (int q = p + 1; q < 3; q++) {
        if (a[p][q] == 0) continue;
        double turn = 0.5 * atan2(2 * a[p][q], a[q][q] - a[p][p]), c = cos(turn), s = sin(turn);
        for (int k = 0; k < 3; k++) {
          double x = a[k][p], y = a[k][q];
          a[k][p] = c * x - s * y, a[k][q] = s * x + c * y;
        }
        for (int k = 0; k < 3; k++) {
          double x = a[p][k], y = a[q][k];
          a[p][k] = c * x - s * y, a[q][k] = s * x + c * y;
          x = v[p][k], y = v[q][k];
          v[p][k] = c * x - s * y, v[q][k] = s * x + c * y;
        }
      }
  for (int k = 0; k < 3; k++) value[k] = a[k][k];
}

/* Which functions the channels are mixtures of. */
static void choose_functions(const making *x, ylm_material_table *t) {
  double gram[3][3] = {{0}}, v[3][3], value[3], total = 0;
  size_t all = (size_t)x->rows * (size_t)x->columns;
  for (size_t i = 0; i < all; i++) {
    const double *s = x->slice + i * x->size;
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++)
        for (size_t k = 0; k < x->width; k++)
          gram[a][b] += s[(size_t)a * x->width + k] * s[(size_t)b * x->width + k];
  }
  eigenvectors(gram, v, value);
  for (int k = 0; k < 3; k++) total += value[k];
  bool used[3] = {false};
  for (t->functions = 0; t->functions < 3; t->functions++) {
    int best = -1;
    for (int k = 0; k < 3; k++)
      if (!used[k] && (best < 0 || value[k] > value[best])) best = k;
    if (t->functions > 0 && value[best] <= TABLE_FAINT * TABLE_FAINT * total) break;
    used[best] = true;
    for (int c = 0; c < 3; c++) t->mix[c][t->functions] = (float)v[best][c];
  }
}

static ylm_status finish(const making *x, ylm_material_table *t) {
  t->lmax = x->form.lmax, t->rows = x->rows, t->columns = x->columns;
  t->halves = x->halves, t->width = x->width;
  choose_functions(x, t);
  size_t degrees = (size_t)t->lmax + 1, line = (size_t)t->functions * t->width;
  size_t floats = (size_t)t->columns * (size_t)(t->rows + 2) * line;
  size_t misses = (size_t)t->columns * (size_t)t->rows * degrees;
  double *s = ylm_alloc(3 * t->width, sizeof *s);
  t->data = ylm_alloc(floats, sizeof *t->data);
  t->missed = ylm_alloc(misses, sizeof *t->missed);
  if (s && t->data && t->missed)
    for (int j = 0; j < t->columns; j++)
      for (int i = -1; i <= t->rows; i++) {
        float *to = ylm__table_row(t, i, j);
        memset(s, 0, 3 * t->width * sizeof *s);
        add_slice(x, i, j, 1, s);
        for (size_t f = 0; f < (size_t)t->functions; f++)
          for (size_t k = 0; k < t->width; k++) {
            double sum = 0;
            for (size_t c = 0; c < 3; c++) sum += (double)t->mix[c][f] * s[c * t->width + k];
            *to++ = (float)sum;
          }
        if (i < 0 || i == t->rows) continue;
        const double *missed = at(x, i, j) + 3 * t->width;
        for (size_t l = 0; l < degrees; l++)
          t->missed[((size_t)j * (size_t)t->rows + (size_t)i) * degrees + l] = (float)missed[l];
      }
  ylm_status status = s && t->data && t->missed ? YLM_OK : YLM_ENOMEM;
  ylm_free(s);
  t->facts = (ylm_material_table_facts){.lmax = t->lmax,
                                        .rows = t->rows,
                                        .columns = t->columns,
                                        .functions = t->functions,
                                        .width = t->width,
                                        .halves = t->halves,
                                        .bytes = sizeof *t + 4 * (floats + misses)};
  return status;
}

static ylm_status check(const ylm_material *m, const ylm_material_table_form *f, ylm_error *e) {
  const int most = YLM_MATERIAL_TABLE_ROWS;
  if (f->lmax < 0 || f->lmax > YLM_MATERIAL_TABLE_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax of a table must be from 0 to %d, got %d",
                    YLM_MATERIAL_TABLE_LMAX, f->lmax);
  if (f->slice == YLM_MATERIAL_TABLE_FIT && f->lmax > YLM_MATERIAL_TABLE_FIT_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax of fits must be from 0 to %d, got %d",
                    YLM_MATERIAL_TABLE_FIT_LMAX, f->lmax);
  if (f->rows < 4 || f->rows > most)
    return ylm_fail(e, YLM_ERANGE, "rows must be from 4 to %d, got %d", most, f->rows);
  if (!ylm_material_isotropic(m) && (f->columns < 4 || f->columns > most || f->columns % 4))
    return ylm_fail(e, YLM_ERANGE, "columns must be from 4 to %d, a multiple of 4, got %d", most,
                    f->columns);
  return YLM_OK;
}

ylm_status ylm_material_table_create(const ylm_material *m, const ylm_material_table_form *form,
                                     ylm_material_table **table, ylm_error *e) {
  *table = NULL;
  ylm_status s = check(m, form, e);
  if (s != YLM_OK) return s;
  double start = ylm_seconds(), error = 0, grazing = 0;
  int workers = ylm_threads(form->threads);
  making x = {.m = m, .form = *form, .halves = ylm_material_isotropic(m), .rows = form->rows};
  size_t L = (size_t)form->lmax;
  x.mirrored = !x.halves && ylm__material_mirrored(m);
  x.columns = x.halves ? 1 : form->columns;
  x.width = x.halves ? (L + 1) * (L + 2) / 2 : (L + 1) * (L + 1);
  x.size = 3 * x.width + L + 1;
  x.room = ylm_alloc_zero((size_t)workers, sizeof(slice_room *));
  ylm_material_table *t = ylm_alloc_zero(1, sizeof *t);
  if (form->slice == YLM_MATERIAL_TABLE_FIT) x.fit = ylm__fit_create(form->lmax);
  s = x.room && t && (x.fit || form->slice != YLM_MATERIAL_TABLE_FIT) ? fill(&x, NULL) : YLM_ENOMEM;
  if (s == YLM_OK) s = refine(&x, &error, &grazing);
  if (s == YLM_OK) s = finish(&x, t);
  for (int i = 0; x.room && i < workers; i++) ylm__slice_room_free(x.room[i]);
  ylm_free(x.room);
  ylm_free(x.slice);
  ylm_free(x.fit);
  if (s != YLM_OK) {
    ylm_material_table_free(t);
    return s;
  }
  t->facts.error = error, t->facts.grazing = grazing;
  t->facts.seconds = ylm_seconds() - start;
  *table = t;
  return YLM_OK;
}

void ylm_material_table_free(ylm_material_table *t) {
  if (!t) return;
  ylm_free(t->data);
  ylm_free(t->missed);
  ylm_free(t);
}

void ylm_material_table_look(const ylm_material_table *t, ylm_material_table_facts *facts) {
  *facts = t->facts;
}

const float (*ylm_material_table_mix(const ylm_material_table *t))[3] {
  return (const float(*)[3])t->mix;
}
