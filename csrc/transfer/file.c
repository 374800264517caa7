/*
** file.c - elements and links as files (docs/bouncing.md has the table).
**
** A header, the cuts and the links; elements are made again from the scene, which must have the
** meshes that the links were found for. Files are written in this machine's byte order and read in
** either; the fingerprint of the meshes is that of little-endian bytes.
*/
#include <math.h>

#include "calibration.h"
#include "transfer.h"

#define ORDER 0x01020304u
#define SWAPPED 0x04030201u
#define VERSION 2u
#define LITTLE (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__)
/* Bytes that are summed at a time. */
#define CHUNK 65536

static const char magic[8] = {(char)0x89, 'Y', 'L', 'M', 'l', 'i', 'n', 'k'};

/* All numbers behind the version, in their order; no padding. */
typedef struct header {
  char magic[8];
  uint32_t order, version;
  uint64_t size;                      /* of the file */
  uint32_t lmax, links, meshes, zero; /* lmax + 1, so that none is 0 */
  uint64_t triangles, elements, fingerprint, seed, max_elements;
  double spacing;
  uint64_t degenerate, closed, rooms, dead, rays, escaped, buried, lost;
} header;
_Static_assert(sizeof(header) == 152, "the header of links has padding");

/* The sections behind the header; each begins at a multiple of 8 bytes. */
enum { SIDES, CUTS, SHARES, LINKS, ESCAPE, SECTIONS };
typedef struct section {
  size_t width, count; /* bytes of a number, and how many */
} section;

static void sections_of(const header *h, section out[SECTIONS]) {
  size_t row = h->lmax;
  out[SIDES] = (section){1, h->meshes};
  out[CUTS] = (section){2, 4 * h->triangles};
  out[SHARES] = (section){4, h->elements};
  out[LINKS] = (section){4, h->elements * h->links};
  out[ESCAPE] = (section){4, h->elements * row * row};
}

static size_t padded(const section *s) { return (s->width * s->count + 7) / 8 * 8; }

static size_t size_of(const header *h) {
  section s[SECTIONS];
  size_t size = sizeof *h + 8;
  sections_of(h, s);
  for (int i = 0; i < SECTIONS; i++) size += padded(&s[i]);
  return size;
}

/* -- fingerprint -------------------------------------------------------------------- */

/* crc of n numbers of `width` bytes as little-endian machines have them. */
static uint64_t sum_numbers(uint64_t crc, const void *numbers, size_t n, size_t width) {
  const unsigned char *from = numbers;
  if (LITTLE) return ylm_crc64(crc, from, n * width);
  unsigned char turned[8];
  for (size_t i = 0; i < n; i++, from += width) {
    for (size_t k = 0; k < width; k++) turned[k] = from[width - 1 - k];
    crc = ylm_crc64(crc, turned, width);
  }
  return crc;
}

ylm_status ylm__transfer_fingerprint(const ylm_scene *scene, uint64_t *print) {
  size_t n = ylm_scene_vertices(scene, NULL);
  float *positions = ylm_alloc(n, 12);
  if (!positions) return YLM_ENOMEM;
  ylm_scene_vertices(scene, positions);
  uint64_t crc = sum_numbers(0, positions, 3 * n, 4);
  if (ylm_scene_origin(scene)) crc = sum_numbers(crc, ylm_scene_origin(scene), 3, 8);
  for (size_t m = 0; m < ylm_scene_meshes(scene); m++) {
    uint64_t of[3] = {ylm_scene_first_vertex(scene, m), ylm_scene_triangles(scene, m),
                      ylm_scene_occludes(scene, m)};
    crc = sum_numbers(crc, of, 3, 8);
    if (of[1]) crc = sum_numbers(crc, ylm_scene_triangle(scene, m, 0), 3 * of[1], 4);
  }
  ylm_free(positions);
  *print = crc;
  return YLM_OK;
}

ylm_status ylm__transfer_same(const ylm_scene *a, const ylm_scene *b, bool *same) {
  uint64_t print[2];
  *same = a == b || (ylm_scene_meshes(a) > 0 && ylm_scene_meshes(a) == ylm_scene_meshes(b) &&
                     ylm_scene_triangles(a, 0) > 0 && ylm_scene_triangles(b, 0) > 0 &&
                     ylm_scene_triangle(a, 0, 0) == ylm_scene_triangle(b, 0, 0));
  if (*same) return YLM_OK;
  ylm_status s = ylm__transfer_fingerprint(a, &print[0]);
  if (s == YLM_OK) s = ylm__transfer_fingerprint(b, &print[1]);
  *same = s == YLM_OK && print[0] == print[1];
  return s;
}

/* -- writing ------------------------------------------------------------------------ */

/* Bytes to a file, summed. */
static void put(ylm_file *f, uint64_t *crc, const void *data, size_t size) {
  for (size_t at = 0; at < size; at += CHUNK) {
    size_t part = size - at < CHUNK ? size - at : CHUNK;
    *crc = ylm_crc64(*crc, (const char *)data + at, part);
    ylm_file_write(f, (const char *)data + at, part); /* errors stick */
  }
}

/* Links to a file, in four bytes each. */
static void put_links(ylm_file *f, uint64_t *crc, ylm_links l, size_t n) {
  uint32_t some[CHUNK / 4];
  for (size_t k = 0; k < n; k += CHUNK / 4) {
    size_t part = n - k < CHUNK / 4 ? n - k : CHUNK / 4;
    for (size_t i = 0; i < part; i++) some[i] = ylm_links_at(l, k + i);
    put(f, crc, some, 4 * part);
  }
}

static ylm_status describe(const ylm_transfer *t, header *h) {
  const ylm_transfer_stats *s = &t->stats;
  *h = (header){.order = ORDER,
                .version = VERSION,
                .lmax = (uint32_t)(t->form.lmax + 1),
                .links = (uint32_t)t->form.links,
                .meshes = (uint32_t)t->meshes,
                .triangles = t->triangles,
                .elements = t->elements,
                .seed = t->form.seed,
                .max_elements = t->form.max_elements,
                .spacing = t->form.spacing,
                .degenerate = s->degenerate,
                .closed = s->closed,
                .rooms = s->rooms,
                .dead = s->dead,
                .rays = s->rays,
                .escaped = s->escaped,
                .buried = s->buried,
                .lost = s->lost};
  memcpy(h->magic, magic, sizeof magic);
  h->size = size_of(h);
  return ylm__transfer_fingerprint(t->scene, &h->fingerprint);
}

ylm_status ylm_transfer_write(const ylm_transfer *t, const char *path, ylm_error *e) {
  static const char zeros[8] = {0};
  const void *data[SECTIONS] = {t->side, t->cut, t->share, NULL, t->escape};
  section sections[SECTIONS];
  header h;
  ylm_file *f;
  ylm_status s = describe(t, &h);
  if (s == YLM_OK) s = ylm_file_create(path, &f, e);
  if (s != YLM_OK) return s;
  uint64_t crc = 0;
  put(f, &crc, &h, sizeof h);
  sections_of(&h, sections);
  for (int i = 0; i < SECTIONS; i++) {
    size_t bytes = sections[i].width * sections[i].count;
    if (i == LINKS)
      put_links(f, &crc, t->link, sections[i].count);
    else
      put(f, &crc, data[i], bytes);
    put(f, &crc, zeros, padded(&sections[i]) - bytes);
  }
  ylm_file_write(f, &crc, sizeof crc);
  return ylm_file_commit(f, e);
}

/* -- reading ------------------------------------------------------------------------ */

static void turn(void *numbers, size_t n, size_t width) {
  unsigned char *p = numbers;
  for (size_t i = 0; i < n; i++, p += width)
    for (size_t a = 0, b = width - 1; a < b; a++, b--) {
      unsigned char c = p[a];
      p[a] = p[b];
      p[b] = c;
    }
}

/* The header as it would stand on this machine. */
static void turn_header(header *h) {
  turn(&h->order, 2, 4);
  turn(&h->size, 1, 8);
  turn(&h->lmax, 4, 4);
  turn(&h->triangles, 5, 8);
  turn(&h->spacing, 1, 8);
  turn(&h->degenerate, 8, 8);
}

static ylm_status damaged(const char *name, const char *what, ylm_error *e) {
  return ylm_fail(e, YLM_EFORMAT, "%s: %s of the links cannot be", name, what);
}

/* The header of a file that is whole. */
static ylm_status read_header(const unsigned char *bytes, size_t size, const char *name, header *h,
                              bool *turned, ylm_error *e) {
  uint64_t crc;
  if (size < 24 || memcmp(bytes, magic, sizeof magic) != 0)
    return ylm_fail(e, YLM_EFORMAT, "%s: these are no links", name);
  *h = (header){0};
  memcpy(h, bytes, size < sizeof *h ? size : sizeof *h);
  *turned = h->order == SWAPPED;
  if (*turned) turn_header(h);
  if (h->order != ORDER) return damaged(name, "the byte order", e);
  if (h->version > VERSION)
    return ylm_fail(e, YLM_EVERSION, "%s: links of version %u, this ylm reads up to %u", name,
                    h->version, VERSION);
  if (h->version != VERSION) return damaged(name, "the version", e);
  if (h->size != size || size < sizeof *h + 8)
    return ylm_fail(e, YLM_EFORMAT, "%s: the file is cut short, or longer than it says", name);
  memcpy(&crc, bytes + size - 8, 8);
  if (*turned) turn(&crc, 1, 8);
  if (crc != ylm_crc64(0, bytes, size - 8))
    return ylm_fail(e, YLM_ECHECKSUM, "%s: the file has been damaged (checksum)", name);
  return YLM_OK;
}

/* Whether the numbers of the header can be, for this scene. */
static ylm_status check_header(const header *h, const ylm_scene *scene, const char *name,
                               ylm_error *e) {
  size_t triangles = 0;
  uint64_t print;
  for (size_t m = 0; m < ylm_scene_meshes(scene); m++) triangles += ylm_scene_triangles(scene, m);
  ylm_status s = ylm__transfer_fingerprint(scene, &print);
  if (s != YLM_OK) return s;
  if (h->fingerprint != print || h->meshes != ylm_scene_meshes(scene) || h->triangles != triangles)
    return ylm_fail(e, YLM_EINVAL,
                    "%s: the links are of another scene: its meshes are others (make them again)",
                    name);
  if (h->lmax > YLM_TRANSFER_LMAX + 1) return damaged(name, "lmax", e);
  if (ylm__transfer_check_links((int)h->links, NULL) != YLM_OK || h->links > YLM_TRANSFER_LINKS)
    return damaged(name, "the number of links", e);
  if (!(h->spacing > 0) || !(h->spacing < 1e300)) return damaged(name, "the spacing", e);
  if (h->elements > h->size / (4 * h->links) || h->elements >= UINT32_MAX / 2 ||
      h->max_elements > UINT32_MAX / 2)
    return damaged(name, "the number of elements", e);
  return size_of(h) == h->size ? YLM_OK : damaged(name, "the size", e);
}

/* A section in new memory. */
static void *copy_section(const unsigned char *from, const section *s, bool turned) {
  void *to = ylm_alloc_copy(from, s->count, s->width);
  if (to && turned && s->width > 1) turn(to, s->count, s->width);
  return to;
}

/* How many links of an element lead to nothing: they stand last. */
static uint32_t open_links(const ylm_transfer *t, const header *h, size_t i) {
  ylm_links link = ylm_links_from(t->link, i * h->links);
  uint32_t n = 0;
  while (n < h->links && ylm_links_at(link, h->links - 1 - n) == (uint32_t)h->elements) n++;
  return n;
}

/*
** Whether counts of the statistics can be. An element's share is that of its rays that do not begin inside of a body,
** of all or of those that do not go below their triangle, which lead to nothing: so many rays are buried in all.
*/
static bool check_counts(const header *h, const ylm_transfer *t) {
  uint64_t dead = 0, rays = h->elements * h->links;
  double least = 0, most = 0;
  for (size_t i = 0; i < h->elements; i++) {
    dead += t->share[i] == 0;
    least += (1 - (double)t->share[i]) * (h->links - open_links(t, h, i));
    most += (1 - (double)t->share[i]) * h->links;
  }
  double rounding = SHARE_ROUNDING * (double)rays, buried = (double)h->buried;
  return h->rays == rays && h->escaped <= rays && h->lost <= rays && h->dead == dead &&
         buried >= least - rounding && buried <= most + rounding && h->closed <= h->meshes &&
         h->rooms <= h->closed;
}

/* Whether an element's share can be: of rays that are at most the links. */
static bool check_share(const header *h, float share) {
  return share == 0 || (share * (float)h->links >= 1 - SHARE_ROUNDING && share <= 1);
}

/*
** Whether the transfer vector of element i can be. Its first number is the part of the element's rays that leave the
** scene, which are among the links to nothing. Its norm is at most that of the cosine, sqrt(2 pi/3), and the noise of
** so many rays: ESCAPE_NOISE times the root mean square of independent ones.
*/
static bool check_escape(const ylm_transfer *t, const header *h, size_t i) {
  size_t count = (size_t)h->lmax * h->lmax;
  const float *T = t->escape + i * count;
  double square = 0, part = (double)T[0] / sqrt(YLM_PI / 4), rays = h->links;
  for (size_t k = 0; k < count; k++) square += (double)T[k] * (double)T[k];
  double most = sqrt(2 * YLM_PI / 3) + ESCAPE_NOISE * h->lmax * sqrt(YLM_PI / (4 * rays));
  return square <= most * most && part >= -ESCAPE_ROUNDING &&
         part <= open_links(t, h, i) / rays + ESCAPE_ROUNDING;
}

/* Takes sections over; which of them cannot be, or NULL. */
static const char *check_sections(const ylm_transfer *t, const header *h) {
  uint32_t none = (uint32_t)h->elements;
  for (size_t m = 0; m < t->meshes; m++)
    if (t->side[m] > 3 || (t->side[m] != 0) != ylm_scene_occludes(t->scene, m)) return "a side";
  for (size_t i = 0; i < h->elements; i++)
    if (!check_share(h, t->share[i])) return "an element";
  for (size_t i = 0; i < h->elements; i++)
    for (uint32_t k = 0; k < h->links; k++) {
      const uint32_t *link = t->link.four + i * h->links + k;
      if (*link > none || (k > 0 && *link < link[-1])) return "a link";
    }
  for (size_t i = 0; t->escape && i < h->elements; i++)
    if (!check_escape(t, h, i)) return "a transfer vector";
  return check_counts(h, t) ? NULL : "a count";
}

/* Keeps links in two bytes each where all elements have such numbers. */
static ylm_status narrow(ylm_transfer *t, const header *h) {
  size_t n = h->elements * h->links;
  if (!ylm__links_are_short(h->elements)) return YLM_OK;
  ylm_links l = {.two = ylm_alloc(n, sizeof *l.two)};
  if (!l.two) return YLM_ENOMEM;
  ylm__links_put(l, 0, n, t->link.four);
  ylm_links_free(t->link);
  t->link = l;
  return YLM_OK;
}

static ylm_status read_sections(ylm_transfer *t, const header *h, const unsigned char *bytes,
                                bool turned, const char *name, ylm_error *e) {
  section s[SECTIONS];
  void *data[SECTIONS] = {NULL};
  bool room = true;
  sections_of(h, s);
  bytes += sizeof *h;
  for (int i = 0; i < SECTIONS; bytes += padded(&s[i++])) {
    if (i == ESCAPE && !h->lmax) continue;
    data[i] = copy_section(bytes, &s[i], turned);
    room = room && data[i];
  }
  t->side = data[SIDES], t->cut = data[CUTS], t->share = data[SHARES];
  t->link.four = data[LINKS], t->escape = data[ESCAPE];
  t->meshes = ylm_scene_meshes(t->scene);
  if (!room) return YLM_ENOMEM;
  const char *what = check_sections(t, h);
  return what ? damaged(name, what, e) : narrow(t, h);
}

/* Form and statistics as the header has them. */
static void restore(ylm_transfer *t, const header *h) {
  t->form = (ylm_transfer_form){.spacing = h->spacing,
                                .max_elements = h->max_elements,
                                .links = (int)h->links,
                                .lmax = (int)h->lmax - 1,
                                .seed = h->seed};
  t->stats = (ylm_transfer_stats){.degenerate = h->degenerate,
                                  .closed = h->closed,
                                  .rooms = h->rooms,
                                  .dead = h->dead,
                                  .rays = h->rays,
                                  .escaped = h->escaped,
                                  .buried = h->buried,
                                  .lost = h->lost};
}

ylm_status ylm_transfer_read(const ylm_scene *scene, const unsigned char *bytes, size_t size,
                             const char *name, ylm_transfer **out, ylm_error *e) {
  *out = NULL;
  header h;
  bool turned = false;
  double begun = ylm_seconds();
  ylm_status s = read_header(bytes, size, name, &h, &turned, e);
  if (s == YLM_OK) s = check_header(&h, scene, name, e);
  if (s != YLM_OK) return s;
  ylm_transfer *t = ylm_alloc_zero(1, sizeof *t);
  if (!t) return YLM_ENOMEM;
  t->scene = scene;
  restore(t, &h);
  s = read_sections(t, &h, bytes, turned, name, e);
  if (s == YLM_OK) {
    s = ylm__transfer_cut_again(t, h.elements);
    if (s == YLM_EFORMAT) damaged(name, "the cut of a triangle", e);
  }
  if (s == YLM_OK) {
    t->stats.seconds = ylm_seconds() - begun;
    t->stats.bytes = ylm__transfer_bytes(t);
    *out = t;
  } else
    ylm_transfer_free(t);
  return s;
}
