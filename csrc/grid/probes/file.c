/* file.c - probes as a file of fixed-size numbers: docs/engines.md, "Probes of ylm". */
#include "probes.h"

#include <string.h>

#define MAGIC "\x89YLMP\r\n\x1a"
#define VERSION 2
#define HEADER 116
#define CHECKED 24 /* the checksum is of the bytes from here on */
#define MIDDLE 32768.0
#define PER_OCTAVE 512.0

/* Where parts of the file begin. */
typedef struct probes_layout {
  size_t tree, cuts, masks, names, points, point, size; /* point: bytes of one */
} probes_layout;

static size_t padded(size_t n) { return (n + 3) & ~(size_t)3; }

/* Bytes of a leaf's planes, and of what tells its brick. */
static size_t cut_bytes(int planes) { return 1 + 5 * (size_t)planes + ((size_t)1 << planes) / 2; }

static size_t name_bytes(size_t names, int bits) { return padded((names * (size_t)bits + 7) / 8); }

/* `cuts`: bytes of all planes; names of `name` bits each. */
static probes_layout lay_out(size_t cells, size_t cuts, size_t bricks, size_t names, int name,
                             size_t points, int count, int bits) {
  probes_layout l = {.tree = HEADER};
  l.cuts = l.tree + padded(cells);
  l.masks = l.cuts + padded(cuts);
  l.names = l.masks + padded(bricks);
  l.points = l.names + name_bytes(names, name);
  l.point = (16 + 3 * (size_t)count * (size_t)bits + 7) / 8;
  l.size = l.points + padded(points * l.point);
  return l;
}

static size_t bytes_of_cuts(const ylm_grid_probes *p) {
  size_t sum = 0;
  for (size_t i = 0; i < p->several; i++) sum += cut_bytes(p->cut[i].planes);
  return sum;
}

static probes_layout layout_of(const ylm_grid_probes *p, const probes_names *n, int bits) {
  return lay_out(p->cells, bytes_of_cuts(p), p->bricks, n->names, n->bits, n->points, p->count,
                 bits);
}

ylm_status ylm_grid_probes_measure(const ylm_grid_probes *p, int bits, ylm_grid_probes_bytes *b) {
  probes_names n;
  ylm_status s = ylm__probes_name(p, &n);
  if (s != YLM_OK) return s;
  probes_layout l = layout_of(p, &n, bits);
  *b = (ylm_grid_probes_bytes){
      .all = l.size, .points = n.points, .means = n.means, .names = n.names, .rest = l.names};
  ylm__probes_names_free(&n);
  return YLM_OK;
}

/* -- little-endian numbers, and numbers of some bits ------------------------------------------------- */

static void put(unsigned char *to, uint64_t x, int bytes) {
  for (int i = 0; i < bytes; i++) to[i] = (unsigned char)(x >> 8 * i);
}
static uint64_t get(const unsigned char *from, int bytes) {
  uint64_t x = 0;
  for (int i = 0; i < bytes; i++) x |= (uint64_t)from[i] << 8 * i;
  return x;
}
static void put_double(unsigned char *to, double x) {
  uint64_t u;
  memcpy(&u, &x, 8);
  put(to, u, 8);
}
static double get_double(const unsigned char *from) {
  uint64_t u = get(from, 8);
  double x;
  memcpy(&x, &u, 8);
  return x;
}
static void put_bits(unsigned char *to, size_t at, int bits, uint32_t x) {
  for (int i = 0; i < bits; i++, at++)
    to[at / 8] = (unsigned char)(to[at / 8] | (x >> i & 1) << at % 8);
}
static uint32_t get_bits(const unsigned char *from, size_t at, int bits) {
  uint32_t x = 0;
  for (int i = 0; i < bits; i++, at++) x |= (uint32_t)(from[at / 8] >> at % 8 & 1) << i;
  return x;
}

/* -- points ---------------------------------------------------------------------------------------- */

/* Numbers of a point in the order of the file: the channels of a coefficient beside each other. */
static float *number_of(const ylm_grid_probes *p, size_t point, size_t j) {
  return p->value + (point * 3 + j % 3) * (size_t)p->count + j / 3;
}

static void put_point(const ylm_grid_probes *p, size_t point, int bits, unsigned char *to) {
  size_t n = 3 * (size_t)p->count;
  double most = 0, top = (double)((1 << (bits - 1)) - 1);
  for (size_t j = 0; j < n; j++) most = fmax(most, fabs((double)*number_of(p, point, j)));
  double scale = ceil(PER_OCTAVE * log2(fmax(most, 1e-18) / top) + MIDDLE);
  scale = fmin(fmax(scale, 0), 65535);
  double step = exp2((scale - MIDDLE) / PER_OCTAVE);
  put(to, (uint64_t)scale, 2);
  for (size_t j = 0; j < n; j++) {
    double q = fmin(fmax(round((double)*number_of(p, point, j) / step), -top), top);
    put_bits(to, 16 + j * (size_t)bits, bits, (uint32_t)(int32_t)q);
  }
}

static void get_point(const ylm_grid_probes *p, size_t point, int bits, const unsigned char *from) {
  double step = exp2(((double)get(from, 2) - MIDDLE) / PER_OCTAVE);
  for (size_t j = 0; j < 3 * (size_t)p->count; j++) {
    int32_t q = (int32_t)get_bits(from, 16 + j * (size_t)bits, bits);
    if (q >> (bits - 1)) q -= 1 << bits;
    *number_of(p, point, j) = (float)(q * step);
  }
}

/* -- writing --------------------------------------------------------------------------------------- */

static void put_header(const ylm_grid_probes *p, const probes_names *n, size_t size, int bits,
                       unsigned char *to) {
  memcpy(to, MAGIC, 8);
  put(to + 8, VERSION, 4);
  put(to + 12, HEADER, 4);
  put(to + 24, size, 8);
  for (size_t a = 0; a < 6; a++) put_double(to + 32 + 8 * a, p->bounds[a]);
  const size_t counts[7] = {p->roots[0], p->roots[1], p->roots[2], p->cells,
                            p->several,  p->bricks,   n->points};
  for (size_t i = 0; i < 7; i++) put(to + 80 + 4 * i, counts[i], 4);
  to[108] = (unsigned char)p->lmax;
  to[109] = (unsigned char)bits;
  to[110] = (unsigned char)n->bits;
  to[111] = (unsigned char)p->quantity;
  put(to + 112, n->names, 4);
}

static void put_cuts(const ylm_grid_probes *p, unsigned char *to) {
  for (size_t i = 0; i < p->several; i++) {
    const probes_cut *c = &p->cut[i];
    *to++ = c->planes;
    for (int k = 0; k < c->planes; k++, to += 5) {
      for (int a = 0; a < 3; a++) to[a] = (unsigned char)c->normal[k][a];
      put(to + 3, (uint16_t)c->offset[k], 2);
    }
    for (int k = 0; k < 1 << c->planes; k += 2)
      *to++ = (unsigned char)(c->part[k] | c->part[k + 1] << 4);
  }
}

static void put_all(const ylm_grid_probes *p, const probes_names *n, const probes_layout *l,
                    int bits, unsigned char *d) {
  put_header(p, n, l->size, bits, d);
  memcpy(d + l->tree, p->parts, p->cells);
  put_cuts(p, d + l->cuts);
  memcpy(d + l->masks, n->mask, p->bricks);
  for (size_t i = 0; i < n->names; i++)
    put_bits(d + l->names, i * (size_t)n->bits, n->bits, n->name[i]);
  for (size_t i = 0; i < p->points; i++)
    if (n->number[i] < PROBES_MEANS) put_point(p, i, bits, d + l->points + n->number[i] * l->point);
  put(d + 16, ylm_crc64(0, d + CHECKED, l->size - CHECKED), 8);
}

ylm_status ylm_grid_probes_encode(const ylm_grid_probes *p, int bits, unsigned char **data,
                                  size_t *size, ylm_error *e) {
  *data = NULL;
  if (bits < 6 || bits > 16)
    return ylm_fail(e, YLM_ERANGE, "bits of a number are 6 to 16, got %d", bits);
  probes_names n;
  ylm_status s = ylm__probes_name(p, &n);
  if (s == YLM_ELIMIT)
    return ylm_fail(e, s, "a leaf is smaller than 2^-20 of the longest edge of the bounds");
  if (s != YLM_OK) return ylm_fail(e, s, "no memory for the points of bricks");
  probes_layout l = layout_of(p, &n, bits);
  unsigned char *d = ylm_alloc_zero(l.size, 1);
  if (d) put_all(p, &n, &l, bits, d);
  ylm__probes_names_free(&n);
  if (!d) return ylm_fail(e, YLM_ENOMEM, "no memory for a file of %zu bytes", l.size);
  *data = d;
  *size = l.size;
  return YLM_OK;
}

/* -- reading --------------------------------------------------------------------------------------- */

typedef struct probes_reader {
  const unsigned char *data;
  size_t size;
  const char *name;
  ylm_grid_probes *p;
  ylm_error *e;
} probes_reader;

static ylm_status refuse(const probes_reader *r, const char *why) {
  return ylm_fail(r->e, YLM_EFORMAT, "%s: %s", r->name, why);
}

static ylm_status get_header(const probes_reader *r, int *bits, int *name) {
  const unsigned char *d = r->data;
  ylm_grid_probes *p = r->p;
  if (r->size < HEADER || memcmp(d, MAGIC, 8) != 0) return refuse(r, "no probes of ylm are in it");
  if (get(d + 8, 4) != VERSION)
    return ylm_fail(r->e, YLM_EVERSION, "%s: version %u of probes, this library reads %d", r->name,
                    (unsigned)get(d + 8, 4), VERSION);
  if (get(d + 24, 8) != r->size || get(d + 12, 4) != HEADER)
    return refuse(r, "it is not as long as it says");
  if (get(d + 16, 8) != ylm_crc64(0, d + CHECKED, r->size - CHECKED))
    return ylm_fail(r->e, YLM_ECHECKSUM, "%s is damaged: its checksum is another", r->name);
  for (size_t a = 0; a < 6; a++) p->bounds[a] = get_double(d + 32 + 8 * a);
  for (size_t a = 0; a < 3; a++) {
    p->roots[a] = (uint32_t)get(d + 80 + 4 * a, 4);
    double extent = p->bounds[a + 3] - p->bounds[a];
    if (!(extent > 0 && extent < HUGE_VAL && isfinite(p->bounds[a])))
      return refuse(r, "its bounds are no box");
  }
  p->cells = (size_t)get(d + 92, 4);
  p->several = (size_t)get(d + 96, 4);
  p->bricks = (size_t)get(d + 100, 4);
  p->points = (size_t)get(d + 104, 4);
  p->lmax = d[108];
  p->quantity = d[111];
  *bits = d[109];
  *name = d[110];
  if (*name < 1 || *name > 32 || p->points >> *name || p->points >= YLM_GRID_NONE)
    return refuse(r, "names of its points are too short");
  if (p->lmax < 1 || p->lmax > 2 || *bits < 6 || *bits > 16 || p->quantity >= YLM_QUANTITY_COUNT)
    return refuse(r, "degree 1 or 2, 6 to 16 bits and a light that is known are expected");
  p->count = (p->lmax + 1) * (p->lmax + 1);
  return YLM_OK;
}

/* Children and bricks of the cells, in their order. */
static ylm_status get_tree(const probes_reader *r) {
  ylm_grid_probes *p = r->p;
  uint64_t next = 1, bricks = 0, several = 0, level_end = 0;
  int depth = 0;
  for (int a = 0; a < 3; a++) {
    if (!p->roots[a] || p->roots[a] > p->cells)
      return refuse(r, "its roots are more than its cells");
    next *= p->roots[a];
    if (next > p->cells) return refuse(r, "its roots are more than its cells");
  }
  level_end = next;
  for (size_t i = 0; i < p->cells; i++) {
    uint8_t parts = r->data[HEADER + i];
    if (i >= next) return refuse(r, "a cell of its tree has no parent");
    if (i >= level_end) {
      level_end = next;
      if (++depth > PROBES_DEPTH) return refuse(r, "its tree is too deep");
    }
    p->parts[i] = parts;
    p->row[i] = YLM_GRID_NONE;
    if (parts == PROBES_SPLIT) {
      p->first[i] = (uint32_t)next;
      next += 8;
      continue;
    }
    if (parts > PROBES_PARTS) return refuse(r, "a leaf has too many bricks");
    p->first[i] = (uint32_t)bricks;
    bricks += parts;
    if (parts > 1) p->row[i] = (uint32_t)several++;
  }
  if (next != p->cells || bricks != p->bricks || several != p->several)
    return refuse(r, "its tree has other numbers of cells or bricks than it says");
  return YLM_OK;
}

/* The planes of a leaf with so many bricks, from `left` bytes; the bytes that they take, 0: they cannot be. */
static size_t get_cut(const unsigned char *from, size_t left, uint8_t parts, probes_cut *c) {
  if (!left || from[0] < 1 || from[0] > PROBES_PLANES || cut_bytes(from[0]) > left) return 0;
  c->planes = *from++;
  for (int k = 0; k < c->planes; k++, from += 5) {
    for (int a = 0; a < 3; a++) c->normal[k][a] = (int8_t)from[a];
    c->offset[k] = (int16_t)get(from + 3, 2);
  }
  for (int k = 0; k < 1 << c->planes; k++) {
    c->part[k] = from[k / 2] >> 4 * (k & 1) & 15;
    if (c->part[k] >= parts) return 0;
  }
  return cut_bytes(c->planes);
}

/* All planes, and their bytes. */
static ylm_status get_cuts(const probes_reader *r, size_t *bytes) {
  ylm_grid_probes *p = r->p;
  size_t at = HEADER + padded(p->cells), begin = at;
  for (size_t i = 0; i < p->cells; i++) {
    if (p->row[i] == YLM_GRID_NONE) continue;
    size_t taken =
        get_cut(r->data + at, at < r->size ? r->size - at : 0, p->parts[i], &p->cut[p->row[i]]);
    if (!taken) return refuse(r, "a plane of a leaf cannot be");
    at += taken;
  }
  *bytes = at - begin;
  return YLM_OK;
}

uint32_t ylm__probes_packed(const probes_packed *p, size_t i) {
  return get_bits(p->data, i * (size_t)p->bits, p->bits);
}

static ylm_status get_bricks(const probes_reader *r, const probes_layout *l, int bits) {
  probes_packed packed = {r->data + l->names, (size_t)get(r->data + 112, 4), bits};
  ylm_status s = ylm__probes_read_names(r->p, r->data + l->masks, &packed);
  if (s == YLM_ENOMEM) return ylm_fail(r->e, s, "no memory for %s", r->name);
  if (s == YLM_ELIMIT) return refuse(r, "its leaves are too small");
  return s == YLM_OK ? s : refuse(r, "a corner of a brick has no point");
}

/* The points of the file, and those that are the mean of others. */
static ylm_status get_points(const probes_reader *r, const probes_layout *l, size_t points,
                             int bits) {
  ylm_grid_probes *p = r->p;
  size_t width = 3 * (size_t)p->count;
  p->value = ylm_alloc(p->points + 1, width * sizeof *p->value);
  if (!p->value) return ylm_fail(r->e, YLM_ENOMEM, "no memory for %s", r->name);
  for (size_t i = 0; i < points; i++) get_point(p, i, bits, r->data + l->points + i * l->point);
  for (size_t i = points; i < p->points; i++)
    for (size_t j = 0; j < width; j++) {
      float sum = 0;
      for (int k = 0; k < 4; k++) sum += p->value[p->tie[i - points][k] * width + j];
      p->value[i * width + j] = sum / 4;
    }
  ylm_free(p->tie); /* its rows are those of a file */
  p->tie = NULL;
  return YLM_OK;
}

static ylm_status get_all(const probes_reader *r) {
  ylm_grid_probes *p = r->p;
  size_t cuts = 0;
  int bits = 0, name = 0;
  ylm_status s = get_header(r, &bits, &name);
  if (s != YLM_OK) return s;
  size_t points = p->points, least = HEADER + p->cells + 7 * p->several + p->bricks + 2 * points;
  if (least > r->size) return refuse(r, "it is not as long as it says");
  p->parts = ylm_alloc(p->cells + 1, sizeof *p->parts);
  p->first = ylm_alloc(p->cells + 1, sizeof *p->first);
  p->row = ylm_alloc(p->cells + 1, sizeof *p->row);
  p->cut = ylm_alloc_zero(p->several + 1, sizeof *p->cut);
  p->corner = ylm_alloc(p->bricks + 1, sizeof *p->corner);
  if (!p->parts || !p->first || !p->row || !p->cut || !p->corner)
    return ylm_fail(r->e, YLM_ENOMEM, "no memory for %s", r->name);
  s = get_tree(r);
  if (s == YLM_OK) s = get_cuts(r, &cuts);
  if (s != YLM_OK) return s;
  probes_layout l = lay_out(p->cells, cuts, p->bricks, (size_t)get(r->data + 112, 4), name, points,
                            p->count, bits);
  if (l.size != r->size) return refuse(r, "it is not as long as it says");
  s = get_bricks(r, &l, name);
  return s == YLM_OK ? get_points(r, &l, points, bits) : s;
}

ylm_status ylm_grid_probes_decode(const unsigned char *data, size_t size, const char *name,
                                  ylm_grid_probes **p, ylm_error *e) {
  probes_reader r = {
      .data = data, .size = size, .name = name, .p = ylm_alloc_zero(1, sizeof *r.p), .e = e};
  *p = NULL;
  if (!r.p) return ylm_fail(e, YLM_ENOMEM, "no memory for %s", name);
  ylm_status s = get_all(&r);
  if (s == YLM_OK)
    *p = r.p;
  else
    ylm_grid_probes_free(r.p);
  return s;
}
