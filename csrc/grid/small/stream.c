/* stream.c - what stands beside points' numbers, and the tables of these, as bits. */
#include "small.h"

#include <string.h>

#define CLASS_BITS 5
#define TABLE_BITS 6
#define EXPONENTS 3 /* contexts: without a prediction, by kin, by parents */

/* -- tables ------------------------------------------------------------------------------------- */

ylm_status ylm__small_tables_room(small_tables *t, size_t components) {
  *t = (small_tables){.table = NULL};
  t->table = ylm_alloc_zero(SMALL_CLASSES, components);
  return t->table ? YLM_OK : YLM_ENOMEM;
}

void ylm__small_tables_free(small_tables *t) {
  ylm_free(t->table);
  ylm_free(t->coded);
  ylm_free(t->codes);
}

ylm_status ylm__small_tables_list(small_tables *t, size_t rows, size_t count) {
  size_t all = SMALL_CLASSES * rows;
  t->coded = ylm_alloc(all * count, sizeof *t->coded);
  t->codes = ylm_alloc_zero(all, sizeof *t->codes);
  if (!t->coded || !t->codes) return YLM_ENOMEM;
  for (size_t i = 0; i < all; i++)
    for (size_t k = 0; k < count; k++)
      if (t->table[i * count + k]) t->coded[i * count + t->codes[i]++] = (uint16_t)k;
  return YLM_OK;
}

struct table_chances {
  bit_chance below[RANS_TABLES][1 << TABLE_BITS], beside[RANS_TABLES][1 << TABLE_BITS];
  bit_chance frequency[RANS_SYMBOLS][64], used;
};

/* The table of each class and component, by those of the class below and of the component before. */
static void code_choice(small_tables *t, size_t n, bit_coder *c, struct table_chances *p) {
  for (size_t class = 1; class < SMALL_CLASSES; class ++)
    for (size_t i = 0; i < n; i++) {
      uint8_t *table = t->table + class * n + i;
      uint8_t below = t->table[(class - 1) * n + i], beside = i ? table[-1] : 0;
      *table =
          (uint8_t)ylm__coder_symbol_of(c, p->below[below], p->beside[beside], TABLE_BITS, *table);
    }
}

ylm_status ylm__small_tables_code(small_tables *t, size_t components, bit_coder *c) {
  struct table_chances *p = ylm_alloc(1, sizeof *p);
  if (!p) return YLM_ENOMEM;
  ylm__coder_even((bit_chance *)p, sizeof *p / sizeof(bit_chance));
  code_choice(t, components, c, p);
  bool holds = true;
  for (size_t k = 1; k < RANS_TABLES; k++) {
    uint32_t left = RANS_SUM, any = 0;
    for (size_t i = 0; i < RANS_SYMBOLS; i++) any |= t->frequency[k][i];
    if (!ylm__coder_bit(c, &p->used, any != 0)) continue;
    for (size_t i = 0; i < RANS_SYMBOLS; i++) {
      uint32_t f = ylm__coder_number(c, p->frequency[i], t->frequency[k][i]);
      if (f > left) f = left, holds = false;
      t->frequency[k][i] = (uint16_t)f;
      left -= f;
    }
    holds &= !left;
  }
  ylm_free(p);
  return holds && !c->short_by ? YLM_OK : YLM_EFORMAT;
}

/* -- points ---------------------------------------------------------------------------------------- */

struct point_chances {
  bit_chance invalid[2], way[3], exponent[EXPONENTS][64], validity[8][256];
  bit_chance above[SMALL_KINDS][SMALL_CLASSES][SMALL_CLASSES],
      left[SMALL_KINDS][SMALL_CLASSES][SMALL_CLASSES];
};

ylm_status ylm__small_points_begin(small_points *s, bit_coder *c) {
  *s = (small_points){.c = c, .chance = ylm_alloc(1, sizeof *s->chance)};
  if (!s->chance) return YLM_ENOMEM;
  ylm__coder_even((bit_chance *)s->chance, sizeof *s->chance / sizeof(bit_chance));
  return YLM_OK;
}

void ylm__small_points_free(small_points *s) { ylm_free(s->chance); }

/* Classes, each by that of the point before, and by one of the same point. */
static void code_classes(small_points *s, const small_frame *f, small_point *p) {
  int channels = f->channels, kinds = f->rows > 1 ? 2 * channels : channels;
  for (int k = 0; k < kinds; k++) {
    int left = k >= channels ? p->class[k - channels] : k ? p->class[k - 1] : 0;
    p->class[k] = (uint8_t)ylm__coder_symbol_of(s->c, s->chance->above[k][s->before.class[k]],
                                                s->chance->left[k][left], CLASS_BITS, p->class[k]);
  }
}

void ylm__small_point_code(small_points *s, const small_frame *f, int ways, int expected,
                           small_point *p) {
  struct point_chances *c = s->chance;
  p->invalid = (uint8_t)ylm__coder_bit(s->c, &c->invalid[s->before.invalid], p->invalid);
  if (f->g->validity)
    p->validity =
        (uint8_t)ylm__coder_symbol(s->c, c->validity[s->before.validity >> 5], 8, p->validity);
  if (!ways) expected = s->before.exponent;
  p->exponent = expected + ylm__coder_signed(s->c,
                                             c->exponent[ways > 1 ? 1
                                                         : ways   ? 2
                                                                  : 0],
                                             p->exponent - expected);
  code_classes(s, f, p);
  s->before = *p;
}

int ylm__small_way_code(small_points *s, int ways, int way) {
  if (ways != 3) return ways;
  int before = s->before.way;
  return ylm__coder_bit(s->c, &s->chance->way[before == 3 ? 0 : before], way == 2) ? 2 : 1;
}
