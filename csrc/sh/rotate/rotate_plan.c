/* rotate_plan.c - the plan of rotations: quarter turns of all degrees in the orders that kernels
 * read. */
#include "rotate.h"

/* The vector kernels in use; NULL for the plain forms. */
static const ylm__rotate_kernels *choose_kernels(void) {
  switch (ylm_isa_current()) {
#define X(isa)                                                                                     \
  case YLM_ISA_##isa: {                                                                            \
    static const ylm__rotate_kernels kernels = {&ylm__rotate_kernels_float_##isa,                  \
                                                &ylm__rotate_kernels_double_##isa};                \
    return &kernels;                                                                               \
  }
    YLM_SETS(X)
#undef X
  default: return NULL;
  }
}

/* Elements of all blocks of degrees < l. */
static size_t blocks_before(int l) {
  size_t k = (size_t)l;
  return k * (2 * k - 1) * (2 * k + 1) / 3;
}

/* Writes J of degree l in class order: for each class its columns, rows in the partner class. */
static void pack(int l, const double *dense, double *packed) {
  int n = 2 * l + 1, row = rotate_row(l);
  for (int c = 0; c < 4; c++) {
    int columns = class_columns(l, c), to = class_partner(l, c);
    for (int i = 0; i < columns; i++, packed += row) {
      int m = 2 * i + (c > 1);
      if (c & 1) m = -m;
      if ((c & 1) && m == 0) continue;
      for (int k = 0; k < row; k++) {
        int q = 2 * k + (to > 1);
        if ((to & 1) && q == 0) continue;
        if (to & 1) q = -q;
        if (q < -l || q > l) continue;
        packed[k] = dense[(q + l) * n + (m + l)];
      }
    }
  }
}

/* Writes J of degree l in panels. */
static void pack_panels(int l, int panel, const double *dense, double *out) {
  int n = 2 * l + 1;
  for (int c = 0; c < 4; c++) {
    int to = class_partner(l, c), columns = class_size(l, c), rows = class_size(l, to);
    for (int first = 0; first < rows; first += panel)
      for (int i = 0; i < columns; i++)
        for (int k = first; k < rows && k < first + panel; k++) {
          int q = class_first(to) + (to & 1 ? -2 : 2) * k,
              m = class_first(c) + (c & 1 ? -2 : 2) * i;
          *out++ = dense[(q + l) * n + (m + l)];
        }
  }
}

void ylm_sh_rotator_free(ylm_sh_rotator *p) {
  if (!p || __atomic_sub_fetch(&p->users, 1, __ATOMIC_ACQ_REL) > 0) return;
  ylm_free(p->panels_d);
  ylm_free(p->panels_f);
  ylm_free(p->panel_at);
  ylm_free(p->dense);
  ylm_free(p->dense_at);
  ylm_free(p->packed_d);
  ylm_free(p->packed_f);
  ylm_free(p->packed_at);
  ylm_free(p);
}

ylm_status ylm_sh_rotator_create(int lmax, ylm_sh_rotator **out, ylm_error *e) {
  *out = NULL;
  if (lmax < 0 || lmax > YLM_SH_ROTATE_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax must be from 0 to %d, got %d", YLM_SH_ROTATE_LMAX, lmax);
  ylm_sh_rotator *p = ylm_alloc_zero(1, sizeof *p);
  if (!p) return YLM_ENOMEM;
  p->lmax = lmax;
  p->users = 1;
  p->kernels = choose_kernels();
  p->panel_at = ylm_alloc((size_t)lmax + 1, sizeof(size_t));
  p->dense = ylm_alloc(blocks_before(lmax + 1), sizeof(double));
  p->dense_at = ylm_alloc((size_t)lmax + 1, sizeof(size_t));
  p->packed_at = ylm_alloc((size_t)lmax + 1, sizeof(size_t));
  size_t packed = 0, panels = 0;
  for (int l = 0; l <= lmax && p->packed_at && p->dense_at && p->panel_at; l++) {
    p->dense_at[l] = blocks_before(l);
    p->packed_at[l] = packed;
    p->panel_at[l] = panels;
    for (int c = 0; c < 4; c++) {
      packed += (size_t)(class_columns(l, c) * rotate_row(l));
      panels += (size_t)(class_size(l, c) * class_size(l, class_partner(l, c)));
    }
  }
  p->panels_d = ylm_alloc(panels, sizeof(double));
  p->panels_f = ylm_alloc(panels, sizeof(float));
  p->packed_d = ylm_alloc_zero(packed, sizeof(double));
  p->packed_f = ylm_alloc_zero(packed, sizeof(float));
  if (!p->dense || !p->dense_at || !p->packed_at || !p->packed_d || !p->packed_f || !p->panel_at ||
      !p->panels_d || !p->panels_f || ylm__sh_quarter_turns(lmax, p->dense) != YLM_OK) {
    ylm_sh_rotator_free(p);
    return YLM_ENOMEM;
  }
  for (int l = 0; l <= lmax; l++) {
    pack(l, p->dense + p->dense_at[l], p->packed_d + p->packed_at[l]);
    if (p->kernels)
      pack_panels(l, p->kernels->f->panel, p->dense + p->dense_at[l], p->panels_d + p->panel_at[l]);
  }
  for (size_t i = 0; p->kernels && i < panels; i++) p->panels_f[i] = (float)p->panels_d[i];
  for (size_t i = 0; i < packed; i++) p->packed_f[i] = (float)p->packed_d[i];
  *out = p;
  return YLM_OK;
}
