/* light.c - lights one by one: listed, compared, kept, made into a set again. */
#include "kind.h"
#include "set.h"
#include "ylm_list.h"

#include <string.h>

static const ylm__light_kind *kind_of(const ylm_light *l) { return l->shape->kind; }

static size_t bytes_of(size_t numbers) {
  return numbers ? sizeof(ylm_light_shape) + numbers * sizeof((ylm_light_shape *)0)->x[0] : 0;
}

/* -- lists ---------------------------------------------------------------------------------- */

bool ylm_light_set_is_listable(const ylm_light_set *set) {
  for (size_t k = 0; k < set->packs; k++)
    if (!set->pack[k]->kind->get) return false;
  return true;
}

static size_t shape_bytes(const ylm__light_pack *p, size_t i) {
  ylm_light unused;
  return bytes_of(p->kind->get(p->of, i, &unused, NULL));
}

ylm_status ylm_light_set_list(const ylm_light_set *set, ylm_light_list *list) {
  size_t bytes = 0;
  *list = (ylm_light_list){0};
  if (!ylm_light_set_is_listable(set)) return YLM_EINVAL;
  for (size_t k = 0; k < set->packs; k++)
    for (size_t i = 0; i < set->pack[k]->n; i++) bytes += shape_bytes(set->pack[k], i);
  list->light = ylm_alloc(ylm_light_set_count(set), sizeof *list->light);
  char *shapes = list->shapes = ylm_alloc(bytes, 1);
  if (!list->light || !shapes) {
    ylm_light_list_free(list);
    return YLM_ENOMEM;
  }
  for (size_t k = 0; k < set->packs; k++) {
    const ylm__light_pack *p = set->pack[k];
    for (size_t i = 0; i < p->n; i++) {
      p->kind->get(p->of, i, &list->light[list->n++], (ylm_light_shape *)(void *)shapes);
      shapes += shape_bytes(p, i);
    }
  }
  return YLM_OK;
}

void ylm_light_list_free(ylm_light_list *list) {
  ylm_free(list->light);
  ylm_free(list->shapes);
  *list = (ylm_light_list){0};
}

/* -- sets of few ---------------------------------------------------------------------------- */

ylm_status ylm_light_set_of(size_t n, const ylm_light *const *light, const double *strength,
                            ylm_light_set **set) {
  const ylm__light_kind *kind = kind_of(light[0]);
  const double grey[3] = {0};
  size_t numbers = 0;
  *set = NULL;
  for (size_t i = 0; i < n; i++) numbers += kind->record(light[i], grey, NULL);
  double *record = ylm_alloc(numbers, sizeof *record), *to = record;
  if (!record) return YLM_ENOMEM;
  for (size_t i = 0; i < n; i++)
    to += kind->record(light[i], (const double[]){strength[i], strength[i], strength[i]}, to);
  ylm_light_source from = {.kind = kind->name, .record = record, .numbers = numbers};
  ylm_status s = ylm_light_set_create(1, &from, set, NULL);
  ylm_free(record);
  return s;
}

/* -- shapes that are kept ------------------------------------------------------------------- */

ylm_status ylm_light_keep(ylm_light_shapes *list, ylm_light *l) {
  if (!l->shape->numbers) return YLM_OK;
  if (!ylm_list_reserve(&list->shape, list->n, list->n + 1, &list->room, sizeof *list->shape))
    return YLM_ENOMEM;
  ylm_light_shape *own = ylm_alloc_copy(l->shape, 1, bytes_of(l->shape->numbers));
  if (!own) return YLM_ENOMEM;
  own->marked = false;
  if (own->kind->hold) own->kind->hold(own, true);
  list->shape[list->n++] = own;
  list->bytes += bytes_of(own->numbers);
  l->shape = own;
  return YLM_OK;
}

void ylm_light_mark(const ylm_light *l) {
  if (l->shape->numbers) ((ylm_light_shape *)(uintptr_t)l->shape)->marked = true;
}

void ylm_light_sweep(ylm_light_shapes *list) {
  size_t left = 0;
  for (size_t i = 0; i < list->n; i++) {
    ylm_light_shape *s = list->shape[i];
    if (s->marked) {
      s->marked = false;
      list->shape[left++] = s;
      continue;
    }
    list->bytes -= bytes_of(s->numbers);
    if (s->kind->hold) s->kind->hold(s, false);
    ylm_free(s);
  }
  list->n = left;
}

/* -- comparisons ---------------------------------------------------------------------------- */

static int order(size_t a, size_t b) { return a < b ? -1 : a > b; }

int ylm_light_compare(const ylm_light *a, const ylm_light *b) {
  const ylm_light_shape *s = a->shape, *t = b->shape;
  int c = memcmp(a, b, offsetof(ylm_light, shape));
  if (c || s == t) return c;
  c = order(ylm__light_kind_index(s->kind), ylm__light_kind_index(t->kind));
  if (!c) c = order(s->numbers, t->numbers);
  return c ? c : memcmp(s->x, t->x, s->numbers * sizeof *s->x);
}

bool ylm_light_alike(const ylm_light *a, const ylm_light *b) {
  return kind_of(a) == kind_of(b) &&
         memcmp(a->shape->x, b->shape->x, kind_of(a)->common * sizeof *a->shape->x) == 0;
}

bool ylm_light_slides(const ylm_light *a, const ylm_light *b) {
  return kind_of(a) == kind_of(b) && kind_of(a)->slides(a, b);
}

void ylm_light_box(const ylm_light *l, double box[6]) {
  double reach = kind_of(l)->reach ? kind_of(l)->reach(l) : -INFINITY;
  for (int a = 0; a < 3; a++) {
    box[a] = l->at[a] - reach;
    box[a + 3] = l->at[a] + reach;
  }
}
