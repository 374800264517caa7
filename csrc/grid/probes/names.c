/*
** names.c - the points of bricks' corners, as files have them: a corner has the point that the last brick before of its number in a
** leaf has at its place, or, where none has, the last brick before, or, where none has, that of the corner beside; or it is named.
** docs/engines.md, "The file".
*/
#include "probes.h"
#include "ylm_list.h"

#include <string.h>

#define MOST_EDGES (1u << PROBES_DEPTH) /* a coordinate has 20 bits of a key */

uint64_t ylm__probes_key(const uint32_t at[3]) {
  return (uint64_t)at[0] | (uint64_t)at[1] << 20 | (uint64_t)at[2] << 40;
}

void ylm__probes_lattice_free(probes_lattice *l) {
  ylm_free(l->at);
  ylm_free(l->level);
  *l = (probes_lattice){NULL};
}

ylm_status ylm__probes_lattice(const ylm_grid_probes *p, probes_lattice *l) {
  l->at = ylm_alloc(p->cells + 1, sizeof *l->at);
  l->level = ylm_alloc_zero(p->cells + 1, sizeof *l->level);
  l->deepest = 0;
  if (!l->at || !l->level) {
    ylm__probes_lattice_free(l);
    return YLM_ENOMEM;
  }
  for (size_t i = 0; i < p->cells; i++) {
    if (l->level[i] > l->deepest) l->deepest = l->level[i];
    for (size_t k = 0; p->parts[i] == PROBES_SPLIT && k < 8; k++)
      l->level[p->first[i] + k] = (uint8_t)(l->level[i] + 1);
  }
  uint32_t most = 0, root = 0;
  for (int a = 0; a < 3; a++) most = p->roots[a] > most ? p->roots[a] : most;
  if ((uint64_t)most << l->deepest > MOST_EDGES) {
    ylm__probes_lattice_free(l);
    return YLM_ELIMIT;
  }
  for (uint32_t z = 0; z < p->roots[2]; z++)
    for (uint32_t y = 0; y < p->roots[1]; y++)
      for (uint32_t x = 0; x < p->roots[0]; x++, root++) {
        const uint32_t at[3] = {x << l->deepest, y << l->deepest, z << l->deepest};
        memcpy(l->at[root], at, sizeof at);
      }
  for (size_t i = 0; i < p->cells; i++)
    for (uint32_t k = 0; p->parts[i] == PROBES_SPLIT && k < 8; k++)
      for (uint32_t a = 0; a < 3; a++)
        l->at[p->first[i] + k][a] = l->at[i][a] + ((k >> a & 1) << (l->deepest - l->level[i] - 1));
  return YLM_OK;
}

uint64_t ylm__probes_corner(const probes_lattice *l, size_t cell, uint32_t k) {
  uint32_t at[3], edge = 1u << (l->deepest - l->level[cell]);
  for (uint32_t a = 0; a < 3; a++) at[a] = l->at[cell][a] + (k >> a & 1) * edge;
  return ylm__probes_key(at);
}

/* Points by places, of all bricks and of those of each number in their leaf. */
typedef struct seen {
  lattice_hash hash;
} seen;

/* The key of a place and a number, which are below PROBES_PARTS. */
static uint64_t numbered(uint64_t key, size_t number) { return key | (uint64_t)(number + 1) << 60; }

/* The point of corner k of a brick, unless it is named; YLM_GRID_NONE: there is none. */
static uint32_t seen_at(const seen *s, uint64_t key, size_t number, const uint32_t corner[8],
                        uint32_t k) {
  uint32_t point = ylm__lattice_hash_find(&s->hash, numbered(key, number));
  if (point == YLM_GRID_NONE) point = ylm__lattice_hash_find(&s->hash, key);
  return point == YLM_GRID_NONE && k ? corner[k & (k - 1)] : point;
}

static ylm_status see(seen *s, uint64_t key, size_t number, uint32_t point) {
  ylm_status status = ylm__lattice_hash_reserve(&s->hash, s->hash.used + 2);
  if (status != YLM_OK) return status;
  *ylm__lattice_hash_at(&s->hash, key) = point;
  *ylm__lattice_hash_at(&s->hash, numbered(key, number)) = point;
  return YLM_OK;
}

/* -- writing --------------------------------------------------------------------------------------- */

void ylm__probes_names_free(probes_names *n) {
  ylm_free(n->mask);
  ylm_free(n->name);
  ylm_free(n->number);
  *n = (probes_names){NULL};
}

/* Numbers of points that are not ties, in their order. */
static void number_points(const ylm_grid_probes *p, probes_names *n) {
  for (size_t i = 0; i < p->points; i++)
    n->number[i] = p->tie && p->tie[i][0] != YLM_GRID_NONE ? YLM_GRID_NONE : (uint32_t)n->points++;
}

/* Whether a point can be written as the mean of others: these have numbers. */
static bool is_mean(const ylm_grid_probes *p, const probes_names *n, uint32_t point) {
  for (int k = 0; k < 4; k++)
    if (n->number[p->tie[point][k]] == YLM_GRID_NONE) return false;
  return true;
}

/* Names a tied point that has no number yet: numbers of means follow those of the two words for them. Until all are known they
   begin at PROBES_MEANS. */
static void name_mean(const ylm_grid_probes *p, uint32_t point, probes_names *n) {
  const uint32_t *tie = p->tie[point];
  bool two = tie[0] == tie[2] && tie[1] == tie[3];
  n->name[n->names++] = PROBES_MEANS + !two;
  for (int k = 0; k < (two ? 2 : 4); k++) n->name[n->names++] = n->number[tie[k]];
  n->number[point] = PROBES_MEANS + 2 + (uint32_t)n->means++;
}

static void name_point(const ylm_grid_probes *p, uint32_t point, probes_names *n) {
  if (n->number[point] == YLM_GRID_NONE && is_mean(p, n, point)) {
    name_mean(p, point, n);
    return;
  }
  if (n->number[point] == YLM_GRID_NONE) n->number[point] = (uint32_t)n->points++;
  n->name[n->names++] = n->number[point];
}

static ylm_status name_corner(const ylm_grid_probes *p, const probes_lattice *l, seen *known,
                              size_t cell, size_t b, uint32_t k, probes_names *n) {
  size_t brick = p->first[cell] + b;
  uint32_t point = p->corner[brick][k];
  uint64_t key = ylm__probes_corner(l, cell, k);
  if (seen_at(known, key, b, p->corner[brick], k) != point) {
    n->mask[brick] = (uint8_t)(n->mask[brick] | 1u << k);
    name_point(p, point, n);
  }
  return see(known, key, b, point);
}

int ylm__probes_name_bits(size_t points) {
  int bits = 1;
  while ((points + 1) >> bits) bits++;
  return bits;
}

ylm_status ylm__probes_name(const ylm_grid_probes *p, probes_names *n) {
  probes_lattice l = {NULL};
  seen known = {{NULL}};
  *n = (probes_names){.mask = ylm_alloc_zero(p->bricks + 1, 1),
                      .name = ylm_alloc(40 * p->bricks + 1, sizeof *n->name),
                      .number = ylm_alloc(p->points + 1, sizeof *n->number)};
  ylm_status s = n->mask && n->name && n->number ? ylm__probes_lattice(p, &l) : YLM_ENOMEM;
  if (s == YLM_OK) number_points(p, n);
  for (size_t i = 0; s == YLM_OK && i < p->cells; i++)
    for (size_t b = 0; p->parts[i] != PROBES_SPLIT && b < p->parts[i]; b++)
      for (uint32_t k = 0; s == YLM_OK && k < 8; k++) s = name_corner(p, &l, &known, i, b, k, n);
  for (size_t i = 0; i < n->names; i++)
    if (n->name[i] >= PROBES_MEANS) n->name[i] = n->name[i] - PROBES_MEANS + (uint32_t)n->points;
  n->bits = ylm__probes_name_bits(n->points + n->means);
  ylm__probes_lattice_free(&l);
  ylm__lattice_hash_free(&known.hash);
  if (s != YLM_OK) ylm__probes_names_free(n);
  return s;
}

/* -- reading --------------------------------------------------------------------------------------- */

typedef struct name_reader {
  ylm_grid_probes *p;
  probes_lattice lattice;
  seen known;
  const probes_packed *packed;
  size_t tie_room, points, means, named; /* points of the file; means, names read so far */
} name_reader;

/* The next name; YLM_EFORMAT: there is none. */
static ylm_status next_name(name_reader *r, uint32_t *name) {
  if (r->named >= r->packed->n) return YLM_EFORMAT;
  *name = ylm__probes_packed(r->packed, r->named++);
  return YLM_OK;
}

/* The next name, of a point that is known: those of means are behind those of points. */
static ylm_status known_name(const name_reader *r, uint32_t name, uint32_t *point) {
  size_t means = r->points + 2;
  if (name >= r->points && (name < means || name - means >= r->means)) return YLM_EFORMAT;
  *point = name < r->points ? name : name - 2;
  return YLM_OK;
}

/* The point of a named corner; YLM_EFORMAT: it cannot be. */
static ylm_status read_name(name_reader *r, uint32_t *point) {
  ylm_grid_probes *p = r->p;
  uint32_t name, end;
  ylm_status s = next_name(r, &name);
  if (s != YLM_OK) return s;
  if (name != r->points && name != r->points + 1) return known_name(r, name, point);
  if (r->points + r->means + 3 >= YLM_GRID_NONE) return YLM_EFORMAT;
  if (!ylm_list_reserve(&p->tie, r->means, r->means + 1, &r->tie_room, sizeof *p->tie))
    return YLM_ENOMEM;
  for (int k = 0; s == YLM_OK && k < 4; k++) {
    if (k > 1 && name == r->points) {
      p->tie[r->means][k] = p->tie[r->means][k - 2];
      continue;
    }
    s = next_name(r, &end);
    if (s == YLM_OK) s = known_name(r, end, &p->tie[r->means][k]);
  }
  *point = (uint32_t)(r->points + r->means++);
  return s;
}

ylm_status ylm__probes_read_names(ylm_grid_probes *p, const unsigned char *mask,
                                  const probes_packed *packed) {
  name_reader r = {.p = p, .points = p->points, .packed = packed};
  ylm_status s = ylm__probes_lattice(p, &r.lattice);
  for (size_t i = 0; s == YLM_OK && i < p->cells; i++)
    for (size_t b = 0; p->parts[i] != PROBES_SPLIT && b < p->parts[i]; b++)
      for (uint32_t k = 0; s == YLM_OK && k < 8; k++) {
        uint64_t key = ylm__probes_corner(&r.lattice, i, k);
        size_t brick = p->first[i] + b;
        uint32_t *corner = &p->corner[brick][k];
        *corner = seen_at(&r.known, key, b, p->corner[brick], k);
        if (mask[brick] >> k & 1)
          s = read_name(&r, corner);
        else if (*corner == YLM_GRID_NONE)
          s = YLM_EFORMAT;
        if (s == YLM_OK) s = see(&r.known, key, b, *corner);
      }
  if (s == YLM_OK && r.named != packed->n) s = YLM_EFORMAT;
  p->points += r.means;
  ylm__probes_lattice_free(&r.lattice);
  ylm__lattice_hash_free(&r.known.hash);
  return s;
}
