/*
** divide.c - charts whose parts miss unlike errors become several charts, each with a density of its own.
**
** Triangles of large charts are cut first, so that charts can end within them. A chart of area A that misses a square error q
** takes A q^g of the texels, g = 2 / (p + 2), where errors fall with the power p of the density. Cut in two, the parts take
** less, as g < 1, and their borders take texels of their own: whoever saves more than these is cut, in two and again, across
** either axis; cuts that do not pay in the end are taken back (Breiman et al. 1984 prune trees so).
*/
#include "map.h"

/* -- fine triangles ----------------------------------------------------------------------------------- */

/* Numbers of charts that are joined at edges become one: the largest. root [charts] is room; 1 joins nothing. */
static void join(const ylm_surface_map *m, size_t charts, uint8_t *number, uint32_t *root) {
  for (size_t i = 0; i < charts; i++) root[i] = (uint32_t)i;
  for (size_t i = 0; i < m->sheets; i++)
    for (size_t t = 0; t < 3 * m->sheet[i].fine; t++) {
      size_t other;
      int edge;
      if (!ylm_unwrap_across(m->charts, i, t / 3, (int)(t % 3), &other, &edge)) continue;
      uint32_t a = ylm_unwrap_chart(m->charts, i, t / 3), b = ylm_unwrap_chart(m->charts, i, other);
      if (number[a] == 1 || number[b] == 1) continue;
      a = ylm_list_root(root, a), b = ylm_list_root(root, b);
      root[a < b ? b : a] = a < b ? a : b;
    }
  for (size_t i = 0; i < charts; i++) {
    uint32_t to = ylm_list_root(root, (uint32_t)i);
    if (number[i] > number[to]) number[to] = number[i];
  }
  for (size_t i = 0; i < charts; i++) number[i] = number[ylm_list_root(root, (uint32_t)i)];
}

/* The longest edges of charts, and their numbers of triangles. */
static ylm_status find_edges(const ylm_surface_map *m, double *longest, double *count) {
  float *all = ylm_alloc(ylm_scene_vertices(m->scene, NULL), 3 * sizeof *all);
  if (!all) return YLM_ENOMEM;
  ylm_scene_vertices(m->scene, all);
  for (size_t i = 0; i < m->sheets; i++) {
    const float *at = all + 3 * ylm_scene_first_vertex(m->scene, m->sheet[i].mesh);
    for (size_t t = 0; t < m->sheet[i].triangles; t++) {
      const uint32_t *of = ylm_scene_triangle(m->scene, m->sheet[i].mesh, t);
      uint32_t chart = ylm_unwrap_chart(m->charts, i, t);
      if (chart == YLM_UNWRAP_NONE) continue;
      count[chart]++;
      for (int k = 0; k < 3; k++) {
        const float *a = at + 3 * of[k], *b = at + 3 * of[(k + 1) % 3];
        double d[3] = {(double)b[0] - (double)a[0], (double)b[1] - (double)a[1],
                       (double)b[2] - (double)a[2]};
        longest[chart] = fmax(longest[chart], sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]));
      }
    }
  }
  ylm_free(all);
  return YLM_OK;
}

/* Gives the triangles of charts their parts, a number a chart; the charts are those of before then. */
static ylm_status set_parts(ylm_surface_map *m, const uint8_t *parts) {
  ylm_status status = YLM_OK;
  for (size_t i = 0; status == YLM_OK && i < m->sheets; i++) {
    map_sheet *s = &m->sheet[i];
    for (size_t f = 0; f < s->fine; f++) {
      uint32_t chart = ylm_unwrap_chart(m->charts, i, f);
      s->parts[s->of[f]] = chart == YLM_UNWRAP_NONE ? 1 : parts[chart];
    }
    status = ylm__map_count(s);
  }
  return status;
}

/* Parts of charts by their longest edges, in squares of `side`; 1: of small triangles, and of many needles. How many are
   larger. */
static size_t choose_parts(const ylm_surface_map *m, size_t charts, double side,
                           const double *longest, const double *count, uint8_t *parts) {
  size_t cut = 0;
  for (size_t i = 0; i < charts; i++) {
    double n = fmin(ceil(longest[i] / (side * sqrt(2.0))), MAP_FINE_MOST);
    double fine = n * n * count[i] * side * side / 2;
    parts[i] = n > 1 && fine <= 8 * ylm_unwrap_area(m->charts, i) ? (uint8_t)n : 1;
    cut += parts[i] > 1;
  }
  return cut;
}

/* The charts of all triangles of all sheets, to be freed; NULL without memory. */
static uint32_t *charts_of(const ylm_surface_map *m) {
  size_t n = 0, at = 0;
  for (size_t i = 0; i < m->sheets; i++) n += m->sheet[i].triangles;
  uint32_t *of = ylm_alloc(n, sizeof *of);
  for (size_t i = 0; of && i < m->sheets; i++)
    for (size_t t = 0; t < m->sheet[i].triangles; t++) of[at++] = ylm_unwrap_chart(m->charts, i, t);
  return of;
}

/* Counts the new charts that begin on each old one: fine triangles that lie over each other join none, and are charts each. */
static ylm_status count_charts(const ylm_surface_map *m, const uint32_t *old, size_t charts,
                               uint32_t *count) {
  ylm_unwrap_stats stats;
  ylm_unwrap_look(m->charts, &stats);
  uint8_t *seen = ylm_alloc_zero(stats.charts, 1);
  if (!seen) return YLM_ENOMEM;
  memset(count, 0, charts * sizeof *count);
  for (size_t i = 0; i < m->sheets; old += m->sheet[i++].triangles)
    for (size_t f = 0; f < m->sheet[i].fine; f++) {
      uint32_t chart = ylm_unwrap_chart(m->charts, i, f), from = old[m->sheet[i].of[f]];
      if (chart == YLM_UNWRAP_NONE || from == YLM_UNWRAP_NONE || seen[chart]) continue;
      seen[chart] = 1;
      count[from]++;
    }
  ylm_free(seen);
  return YLM_OK;
}

/* Makes triangles of charts that fell apart whole again, with all that are joined to them; *changed: there are some. */
static ylm_status mend(ylm_surface_map *m, const uint32_t *old, size_t charts, uint8_t *parts,
                       uint32_t *root, bool *changed) {
  uint32_t *count = ylm_alloc(charts, sizeof *count);
  uint8_t *broken = ylm_alloc_zero(charts, 1);
  ylm_status s = count && broken ? count_charts(m, old, charts, count) : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < charts; i++)
    if (count[i] > MAP_FINE_CHARTS) broken[ylm_list_root(root, (uint32_t)i)] = *changed = true;
  for (size_t i = 0; s == YLM_OK && i < charts; i++)
    if (broken[ylm_list_root(root, (uint32_t)i)]) parts[i] = 1;
  for (size_t i = 0; s == YLM_OK && i < m->sheets; old += m->sheet[i++].triangles) {
    map_sheet *sheet = &m->sheet[i];
    for (size_t t = 0; t < sheet->triangles; t++)
      sheet->parts[t] = old[t] == YLM_UNWRAP_NONE ? 1 : parts[old[t]];
    s = ylm__map_count(sheet);
  }
  ylm_free(count), ylm_free(broken);
  return s;
}

/* Cuts the triangles of charts, and makes charts of them. */
static ylm_status cut_all(ylm_surface_map *m, const ylm_surface_map_form *form, size_t charts,
                          uint8_t *parts, ylm_error *e) {
  uint32_t *root = ylm_alloc(charts, sizeof *root), *old = charts_of(m);
  bool changed = false;
  ylm_status s = root && old ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) {
    join(m, charts, parts, root);
    s = set_parts(m, parts);
  }
  if (s == YLM_OK) s = ylm__map_unwrap(m, form, NULL, e);
  if (s == YLM_OK) s = mend(m, old, charts, parts, root, &changed);
  if (s == YLM_OK && changed) s = ylm__map_unwrap(m, form, NULL, e);
  ylm_free(root), ylm_free(old);
  return s;
}

ylm_status ylm__map_refine(ylm_surface_map *m, const ylm_surface_map_form *form, ylm_error *e) {
  ylm_unwrap_stats stats;
  ylm_unwrap_look(m->charts, &stats);
  size_t n = stats.charts;
  double *edge = ylm_alloc_zero(2 * n, sizeof *edge), whole = 0;
  uint8_t *parts = ylm_alloc(n, 1);
  ylm_status s = edge && parts ? find_edges(m, edge, edge + n) : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < n; i++) whole += ylm_unwrap_area(m->charts, i);
  if (s == YLM_OK && choose_parts(m, n, sqrt(whole / MAP_FINE), edge, edge + n, parts))
    s = cut_all(m, form, n, parts, e);
  ylm_free(edge), ylm_free(parts);
  return s;
}

/* -- cuts --------------------------------------------------------------------------------------------- */

/* A fine triangle on its chart: texels of the picture that the products are of. */
typedef struct piece {
  double low[2], high[2], middle[2];
  double area;               /* of the surface */
  double sites, sum, square; /* products of sites, their sum, and that of their squares */
  uint32_t number;           /* among all fine triangles */
} piece;

typedef struct division {
  map_bake *b;
  piece *piece; /* [n] of one chart */
  size_t n, room;
  double density;    /* texels a scene unit of the chart */
  double least, all; /* a square error that is added; the sum of area times error^g of all charts */
  double texels;
  uint32_t *label, labels; /* [fine] */
} division;

static double share_of(double square, double least) {
  return pow(square + least, 2 / (MAP_DIVIDE_SLOPE + 2));
}

/* Area, sites and sums of a set of pieces. */
typedef struct total {
  double area, sites, sum, square;
} total;

static void add_piece(total *t, const piece *p) {
  t->area += p->area;
  t->sites += p->sites;
  t->sum += p->sum;
  t->square += p->square;
}

/* The square error of a total, at least what it may be off by. */
static double error_of(const total *t) {
  return t->sites > 0 ? fmax(t->sum / t->sites, sqrt(t->square) / t->sites) : 0;
}

typedef struct cut {
  double gain, at;
  int axis;
} cut;

/* Keeps a cut if it gains more than `best`. */
static void try_cut(const division *d, size_t first, size_t n, double whole, const double extent[2],
                    int axis, double at, cut *best) {
  total side[2] = {{0, 0, 0, 0}, {0, 0, 0, 0}};
  double crossed = 0;
  for (size_t i = first; i < first + n; i++) {
    const piece *p = &d->piece[i];
    add_piece(&side[p->middle[axis] > at], p);
    if (p->low[axis] < at - 0.01 && p->high[axis] > at + 0.01)
      crossed += p->high[!axis] - p->low[!axis];
  }
  if (side[0].sites < 8 || side[1].sites < 8) return;
  double q[2] = {error_of(&side[0]), error_of(&side[1])};
  double parts = side[0].area * share_of(q[0], d->least) + side[1].area * share_of(q[1], d->least);
  /* a texel of border and a gutter along the new edge, as dense as its denser side; ragged ones twice */
  double length = (extent[!axis] + crossed) / d->density;
  double border = (1 + d->b->form->gutter) * length *
                  sqrt(share_of(fmax(q[0], q[1]), d->least) * d->all / d->texels);
  double gain = whole - parts - MAP_DIVIDE_GAIN * border;
  if (gain > best->gain) *best = (cut){gain, at, axis};
}

/* Divides pieces first .. first + n - 1 and labels them; what that gains, 0: they stay together. */
static double divide(division *d, size_t first, size_t n, int depth) {
  double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY}, extent[2];
  uint32_t own = d->labels++;
  total t = {0, 0, 0, 0};
  cut best = {-INFINITY, 0, 0};
  for (size_t i = first; i < first + n; i++) {
    add_piece(&t, &d->piece[i]);
    for (int a = 0; a < 2; a++) {
      low[a] = fmin(low[a], d->piece[i].low[a]);
      high[a] = fmax(high[a], d->piece[i].high[a]);
    }
  }
  for (int a = 0; a < 2; a++) extent[a] = high[a] - low[a];
  double whole = t.area * share_of(error_of(&t), d->least);
  for (int axis = 0; depth < MAP_DIVIDE_DEPTH && axis < 2; axis++)
    for (int k = 1; k < MAP_DIVIDE_LINES; k++) {
      /* lines of thirds and quarters are among those of 48 parts; the nearest corner is where triangles end */
      double at = low[axis] + extent[axis] * k / MAP_DIVIDE_LINES, near = INFINITY;
      for (size_t i = first; i < first + n; i++)
        if (fabs(d->piece[i].high[axis] - at) < fabs(near - at)) near = d->piece[i].high[axis];
      if (fabs(near - at) <= 0.5 * extent[axis] / MAP_DIVIDE_LINES)
        try_cut(d, first, n, whole, extent, axis, near, &best);
    }
  if (best.gain > -INFINITY) {
    size_t left = first;
    for (size_t i = first; i < first + n; i++)
      if (!(d->piece[i].middle[best.axis] > best.at)) {
        piece p = d->piece[i];
        d->piece[i] = d->piece[left];
        d->piece[left++] = p;
      }
    double gain = best.gain + divide(d, first, left - first, depth + 1) +
                  divide(d, left, first + n - left, depth + 1);
    if (gain > 0) return gain;
  }
  for (size_t i = first; i < first + n; i++) d->label[d->piece[i].number] = own;
  return 0;
}

/* -- the whole ---------------------------------------------------------------------------------------- */

/* Corners, area and number of each fine triangle that is a part of one, by chart: piece [fine], order by chart in `list`. */
static void measure(const map_bake *b, const size_t *before, piece *all) {
  const ylm_surface_map *m = b->m;
  for (size_t i = 0; i < m->sheets; i++)
    for (size_t f = 0; f < m->sheet[i].fine; f++) {
      piece *p = &all[before[i] + f];
      double c[3][2];
      uint32_t chart = ylm_unwrap_chart(m->charts, i, f);
      *p = (piece){.number = (uint32_t)(before[i] + f)};
      if (chart == YLM_UNWRAP_NONE) continue;
      double density = ylm_unwrap_density(m->charts, chart);
      ylm_unwrap_corners(m->charts, i, f, c);
      for (int a = 0; a < 2; a++) {
        p->low[a] = fmin(c[0][a], fmin(c[1][a], c[2][a]));
        p->high[a] = fmax(c[0][a], fmax(c[1][a], c[2][a]));
        p->middle[a] = (c[0][a] + c[1][a] + c[2][a]) / 3;
      }
      p->area = 0.5 *
                fabs((c[1][0] - c[0][0]) * (c[2][1] - c[0][1]) -
                     (c[2][0] - c[0][0]) * (c[1][1] - c[0][1])) /
                (density * density);
    }
}

/* Adds the products of sites to their fine triangles. */
static void gather(const map_bake *b, const size_t *before, const double *product, piece *all) {
  for (size_t i = 0; i < b->sites; i++) {
    const ylm_scene_place *p = &b->site[i].place;
    if (!map_counts(&b->site[i])) continue;
    uint32_t sheet = b->m->of[2 * p->mesh + p->back];
    double u = (double)(p->back ? p->v : p->u), v = (double)(p->back ? p->u : p->v);
    piece *of = &all[before[sheet] + ylm__map_fine(&b->m->sheet[sheet], p->element, &u, &v)];
    of->sites++;
    of->sum += product[i];
    of->square += product[i] * product[i];
  }
}

/* The pieces of all fine triangles by their charts: own [fine], first [charts + 1]. */
static ylm_status sort_pieces(const map_bake *b, const size_t *before, size_t fine,
                              const double *product, piece *own, size_t *first) {
  const ylm_surface_map *m = b->m;
  piece *all = ylm_alloc(fine, sizeof *all);
  size_t *next = ylm_alloc(b->charts, sizeof *next);
  ylm_status s = all && next ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) {
    measure(b, before, all);
    gather(b, before, product, all);
    memset(first, 0, (b->charts + 1) * sizeof *first);
  }
  for (int pass = 0; s == YLM_OK && pass < 2; pass++) {
    for (size_t i = 0; i < m->sheets; i++)
      for (size_t f = 0; f < m->sheet[i].fine; f++) {
        uint32_t chart = ylm_unwrap_chart(m->charts, i, f);
        if (chart == YLM_UNWRAP_NONE) continue;
        if (pass == 0)
          first[chart + 1]++;
        else
          own[next[chart]++] = all[before[i] + f];
      }
    for (size_t i = 0; pass == 0 && i < b->charts; i++) {
      first[i + 1] += first[i];
      next[i] = first[i];
    }
  }
  ylm_free(all), ylm_free(next);
  return s;
}

/* The square error that is added to those of parts, and the shares of all charts. */
static void prepare(division *d) {
  const map_bake *b = d->b;
  double area = 0, wanted = 0;
  for (size_t i = 0; i < b->charts; i++) {
    area += ylm_unwrap_area(b->m->charts, i);
    wanted += ylm_unwrap_area(b->m->charts, i) * b->square[i];
  }
  d->least = 1e-4 * wanted / area;
  for (size_t i = 0; i < b->charts; i++)
    d->all += ylm_unwrap_area(b->m->charts, i) * share_of(b->square[i], d->least);
}

/* Labels of all fine triangles, 0 of charts that stay; parts [charts] of those that are cut become 1 where they stay. How many
   charts are divided. */
static ylm_status label_all(map_bake *b, const size_t *before, size_t fine, size_t texels,
                            const double *product, uint32_t *label, uint8_t *parts,
                            size_t *divided) {
  division d = {.b = b, .texels = (double)texels, .label = label, .labels = 1};
  size_t *first = ylm_alloc(b->charts + 1, sizeof *first);
  *divided = 0;
  d.piece = ylm_alloc(fine, sizeof *d.piece);
  ylm_status s = first && d.piece ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) s = sort_pieces(b, before, fine, product, d.piece, first);
  if (s == YLM_OK) {
    prepare(&d);
    memset(label, 0, fine * sizeof *label);
  }
  for (size_t i = 0; s == YLM_OK && i < b->charts; i++) {
    size_t n = first[i + 1] - first[i];
    if (parts[i] == 1) continue;
    d.density = ylm_unwrap_density(b->m->charts, i);
    if (divide(&d, first[i], n, 0) > 0) {
      ++*divided;
      continue;
    }
    parts[i] = 1;
    for (size_t k = first[i]; k < first[i + 1]; k++) label[d.piece[k].number] = 0;
  }
  ylm_free(first), ylm_free(d.piece);
  return s;
}

/* The parts of charts as they are. */
static void find_parts(const ylm_surface_map *m, uint8_t *parts) {
  for (size_t i = 0; i < m->sheets; i++)
    for (size_t f = 0; f < m->sheet[i].fine; f++) {
      uint32_t chart = ylm_unwrap_chart(m->charts, i, f);
      if (chart != YLM_UNWRAP_NONE) parts[chart] = m->sheet[i].parts[m->sheet[i].of[f]];
    }
}

/* Charts whose groups no divided one is in lose their parts. */
static ylm_status keep_groups(map_bake *b, const uint8_t *divided, uint8_t *parts) {
  uint32_t *root = ylm_alloc(b->charts, sizeof *root);
  uint8_t *kept = ylm_alloc_zero(b->charts, 1);
  ylm_status s = root && kept ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) join(b->m, b->charts, parts, root);
  for (size_t i = 0; s == YLM_OK && i < b->charts; i++)
    if (divided[i] > 1) kept[ylm_list_root(root, (uint32_t)i)] = 1;
  for (size_t i = 0; s == YLM_OK && i < b->charts; i++)
    if (!kept[ylm_list_root(root, (uint32_t)i)]) parts[i] = 1;
  ylm_free(root), ylm_free(kept);
  return s;
}

/* Labels of the fine triangles of new parts, from those of the old; NULL without memory, to be freed. */
static uint32_t *carry(ylm_surface_map *m, const uint8_t *parts, const size_t *before,
                       const uint32_t *old) {
  uint32_t **first = ylm_alloc_zero(m->sheets, sizeof *first), *label = NULL;
  size_t fine = 0, at = 0;
  bool ok = first != NULL;
  for (size_t i = 0; ok && i < m->sheets; i++) {
    first[i] = ylm_alloc_copy(m->sheet[i].first, m->sheet[i].triangles + 1, sizeof **first);
    ok = first[i] != NULL;
  }
  ok = ok && set_parts(m, parts) == YLM_OK;
  for (size_t i = 0; ok && i < m->sheets; i++) fine += m->sheet[i].fine;
  if (ok) label = ylm_alloc_zero(fine, sizeof *label);
  for (size_t i = 0; label && i < m->sheets; at += m->sheet[i++].fine)
    for (size_t t = 0; t < m->sheet[i].triangles; t++) {
      const uint32_t *now = m->sheet[i].first;
      uint32_t n = now[t + 1] - now[t];
      if (n != first[i][t + 1] - first[i][t]) continue;
      memcpy(label + at + now[t], old + before[i] + first[i][t], n * sizeof *label);
    }
  for (size_t i = 0; first && i < m->sheets; i++) ylm_free(first[i]);
  ylm_free(first);
  return label;
}

/* Square errors and slopes of new charts, by sites that were fitted on the old; coarse: or NULL. */
static ylm_status judge(map_bake *b, const double *product, const double *coarse) {
  ylm_status s = ylm__map_begin(b);
  double *square = ylm_alloc(b->charts, sizeof *square);
  if (s == YLM_OK && !square) s = YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < b->sites; i++) {
    b->site[i].chart = ylm__map_chart(b->m, &b->site[i].place);
    if (b->site[i].chart == YLM_UNWRAP_NONE) b->site[i].read = false;
  }
  if (s == YLM_OK) s = ylm__map_square(b, product, b->square);
  if (s == YLM_OK && coarse) s = ylm__map_square(b, coarse, square);
  if (s == YLM_OK && coarse) ylm__map_slopes(b, square);
  ylm_free(square);
  return s;
}

/* Charts of triangles that are not cut, where divided ones do not fit into the texels. */
static ylm_status take_back(map_bake *b, uint8_t *parts, const double *product,
                            const double *coarse) {
  memset(parts, 1, b->charts);
  ylm_status s = set_parts(b->m, parts);
  if (s == YLM_OK) s = ylm__map_unwrap(b->m, b->form, NULL, b->e);
  return s == YLM_OK ? judge(b, product, coarse) : s;
}

ylm_status ylm__map_divide(map_bake *b, size_t texels, const double *product,
                           const double *coarse) {
  ylm_surface_map *m = b->m;
  size_t fine = 0, divided = 0, *before = ylm_alloc(m->sheets, sizeof *before);
  for (size_t i = 0; before && i < m->sheets; fine += m->sheet[i++].fine) before[i] = fine;
  uint32_t *label = ylm_alloc(fine, sizeof *label), *next = NULL;
  uint8_t *parts = ylm_alloc(2 * b->charts, 1), *own = parts ? parts + b->charts : NULL;
  ylm_status s = before && label && parts ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) {
    memset(parts, 1, b->charts);
    find_parts(m, parts);
    memcpy(own, parts, b->charts);
    s = label_all(b, before, fine, texels, product, label, own, &divided);
  }
  if (s == YLM_OK) s = keep_groups(b, own, parts);
  if (s == YLM_OK && !(next = carry(m, parts, before, label))) s = YLM_ENOMEM;
  if (s == YLM_OK) s = ylm__map_unwrap(m, b->form, next, b->e);
  if (s == YLM_OK) s = judge(b, product, coarse);
  if (s == YLM_OK && divided) {
    s = ylm_unwrap_fit(m->charts, b->density, b->form->gutter, texels, NULL, b->e);
    uint8_t *whole = s == YLM_ELIMIT ? ylm_alloc(b->charts, 1) : NULL;
    if (s == YLM_ELIMIT) s = whole ? take_back(b, whole, product, coarse) : YLM_ENOMEM;
    ylm_free(whole);
  }
  ylm_free(before), ylm_free(label), ylm_free(next), ylm_free(parts);
  return s;
}
