/*
** file.c - light on surfaces as a file (docs/surfaces.md has the table).
**
** Charts are made again from the scene, which must have the meshes that the light was found for. Files are little-endian.
*/
#include <math.h>

#include "surface.h"

#define VERSION 1u
#define LITTLE (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__)

static const char magic[8] = {(char)0x89, 'Y', 'L', 'M', 's', 'u', 'r', 'f'};

/* All numbers behind the version, in their order; no padding. */
typedef struct header {
  char magic[8];
  uint32_t version, quantity;
  uint64_t size;      /* of the file */
  uint64_t prints[3]; /* of geometry, materials, lamps */
  double tolerance;
  uint32_t charts, nodes, planes, rectangles, rows, corners;
  uint64_t places, rounds, rays, verified, failed;
  double error, rms, seconds;
} header;
_Static_assert(sizeof(header) == 144, "the header of surfaces has padding");

/* The sections behind the header: roots, nodes, planes, rectangles, rows. */
typedef struct sections {
  void *data[5];
  size_t bytes[5];
} sections;

static sections sections_of(const header *h, const ylm_surface_grid *g) {
  return (sections){{g->root, g->node, g->plane, g->rectangle, g->row},
                    {h->charts * sizeof *g->root, h->nodes * sizeof *g->node,
                     h->planes * sizeof *g->plane, h->rectangles * sizeof *g->rectangle,
                     h->rows * sizeof *g->row}};
}

static uint64_t size_of(const sections *s) {
  uint64_t size = sizeof(header) + 8;
  for (int i = 0; i < 5; i++) size += s->bytes[i];
  return size;
}

/* -- writing ------------------------------------------------------------------------------------ */

static void put(ylm_file *f, uint64_t *crc, const void *data, size_t size) {
  *crc = ylm_crc64(*crc, data, size);
  ylm_file_write(f, data, size); /* errors stick */
}

ylm_status ylm_surface_write(const ylm_surface_grid *g, const char *path, ylm_error *e) {
  const ylm_surface_stats *x = &g->stats;
  header h = {.version = VERSION,
              .quantity = (uint32_t)x->quantity,
              .prints = {x->prints.geometry, x->prints.materials, x->prints.lights},
              .tolerance = x->tolerance,
              .charts = (uint32_t)g->charts.charts,
              .nodes = (uint32_t)g->nodes,
              .planes = (uint32_t)g->planes,
              .rectangles = (uint32_t)x->rectangles,
              .rows = (uint32_t)x->rows,
              .corners = (uint32_t)x->corners,
              .places = x->places,
              .rounds = x->rounds,
              .rays = x->rays,
              .verified = x->verified,
              .failed = x->failed,
              .error = x->error,
              .rms = x->rms,
              .seconds = x->seconds};
  ylm_file *f;
  uint64_t crc = 0;
  if (!LITTLE)
    return ylm_fail(e, YLM_ETYPE, "%s: these files are for little-endian machines", path);
  sections s = sections_of(&h, g);
  memcpy(h.magic, magic, sizeof magic);
  h.size = size_of(&s);
  ylm_status status = ylm_file_create(path, &f, e);
  if (status != YLM_OK) return status;
  put(f, &crc, &h, sizeof h);
  for (int i = 0; i < 5; i++) put(f, &crc, s.data[i], s.bytes[i]);
  ylm_file_write(f, &crc, sizeof crc);
  return ylm_file_commit(f, e);
}

/* -- reading ------------------------------------------------------------------------------------ */

static ylm_status damaged(const char *name, const char *what, ylm_error *e) {
  return ylm_fail(e, YLM_EFORMAT, "%s: %s of the light on surfaces cannot be", name, what);
}

static ylm_status read_header(const unsigned char *bytes, size_t size, const char *name, header *h,
                              ylm_error *e) {
  uint64_t crc;
  if (size < 16 || memcmp(bytes, magic, sizeof magic) != 0)
    return ylm_fail(e, YLM_EFORMAT, "%s: this is no light on surfaces", name);
  *h = (header){.version = 0};
  memcpy(h, bytes, size < sizeof *h ? size : sizeof *h);
  if (!LITTLE)
    return ylm_fail(e, YLM_ETYPE, "%s: these files are for little-endian machines", name);
  if (h->version > VERSION)
    return ylm_fail(e, YLM_EVERSION, "%s: light on surfaces of version %u, this ylm reads up to %u",
                    name, h->version, VERSION);
  if (h->version != VERSION) return damaged(name, "the version", e);
  if (h->size != size || size < sizeof *h + 8)
    return ylm_fail(e, YLM_EFORMAT, "%s: the file is cut short, or longer than it says", name);
  memcpy(&crc, bytes + size - 8, 8);
  if (crc != ylm_crc64(0, bytes, size - 8))
    return ylm_fail(e, YLM_ECHECKSUM, "%s: the file has been damaged (checksum)", name);
  return YLM_OK;
}

static const char *check_header(const header *h) {
  if (h->quantity >= YLM_QUANTITY_COUNT) return "the quantity";
  if (!(h->tolerance > 0) || !isfinite(h->tolerance)) return "the tolerance";
  if (isnan(h->error) || isnan(h->rms) || isnan(h->seconds)) return "an error";
  return NULL;
}

/* Whether each node names what there is, and children come behind their parents: look-ups end. */
static const char *check_nodes(const ylm_surface_grid *g) {
  for (size_t c = 0; c < g->charts.charts; c++)
    if (g->root[c] != SURFACE_NONE && g->root[c] >= g->nodes) return "a root";
  for (size_t i = 0; i < g->nodes; i++) {
    uint32_t kind = g->node[i] & ((1u << NODE_BITS) - 1), value = g->node[i] >> NODE_BITS;
    if (kind > NODE_RECTANGLE) return "a node";
    if (kind == NODE_PLANE && value >= g->planes) return "a plane";
    if (kind == NODE_RECTANGLE) {
      if (value >= g->stats.rectangles) return "a node";
      continue;
    }
    uint32_t child = kind == NODE_PLANE ? g->plane[value].child : value;
    if (child <= i || child + 1 >= g->nodes) return "a child";
  }
  return NULL;
}

static const char *check_numbers(const ylm_surface_grid *g) {
  for (size_t i = 0; i < g->planes; i++)
    for (int a = 0; a < 4; a++)
      if (!isfinite(g->plane[i].a[a])) return "a plane";
  for (size_t i = 0; i < g->stats.rectangles; i++) {
    const surface_rectangle *r = &g->rectangle[i];
    for (int a = 0; a < 2; a++)
      if (r->lo[a] >= r->hi[a] || r->hi[a] > SURFACE_TOP) return "a rectangle";
    for (int c = 0; c < 4; c++)
      if (r->corner[c] >= g->stats.rows) return "a corner";
    if (r->chart >= g->charts.charts) return "a chart";
  }
  for (size_t i = 0; i < g->stats.rows; i++)
    for (int c = 0; c < 3; c++)
      if (!(g->row[i][c] >= 0) || !isfinite(g->row[i][c])) return "a value";
  return NULL;
}

static ylm_status read_sections(ylm_surface_grid *g, const header *h, const unsigned char *bytes,
                                const char *name, ylm_error *e) {
  sections s = sections_of(h, g);
  void **to[5] = {(void **)&g->root, (void **)&g->node, (void **)&g->plane, (void **)&g->rectangle,
                  (void **)&g->row};
  bytes += sizeof *h;
  for (int i = 0; i < 5; i++) {
    if (!(*to[i] = ylm_alloc_copy(bytes, s.bytes[i], 1))) return YLM_ENOMEM;
    bytes += s.bytes[i];
  }
  const char *what = check_header(h);
  if (!what) what = check_nodes(g);
  if (!what) what = check_numbers(g);
  return what ? damaged(name, what, e) : YLM_OK;
}

static ylm_surface_stats stats_of(const header *h) {
  return (ylm_surface_stats){.rectangles = h->rectangles,
                             .rows = h->rows,
                             .corners = h->corners,
                             .places = h->places,
                             .rounds = h->rounds,
                             .rays = h->rays,
                             .verified = h->verified,
                             .failed = h->failed,
                             .error = h->error,
                             .rms = h->rms,
                             .met = h->error <= h->tolerance,
                             .tolerance = h->tolerance,
                             .quantity = (ylm_quantity)h->quantity,
                             .prints = {h->prints[0], h->prints[1], h->prints[2]},
                             .seconds = h->seconds};
}

static void restore(ylm_surface_grid *g, const header *h) {
  g->nodes = h->nodes;
  g->planes = h->planes;
  g->stats = stats_of(h);
}

/* Charts that have rectangles. */
static size_t count_charts(const uint32_t *root, size_t charts) {
  size_t n = 0;
  for (size_t c = 0; c < charts; c++) n += root[c] != SURFACE_NONE;
  return n;
}

ylm_status ylm_surface_inspect(const unsigned char *bytes, size_t size, const char *name,
                               ylm_surface_stats *stats, ylm_error *e) {
  const ylm_surface_grid none = {.root = NULL};
  header h;
  ylm_status s = read_header(bytes, size, name, &h, e);
  if (s != YLM_OK) return s;
  const char *what = check_header(&h);
  sections all = sections_of(&h, &none);
  if (!what && size_of(&all) != size) what = "the size";
  if (what) return damaged(name, what, e);
  *stats = stats_of(&h);
  for (size_t c = 0; c < h.charts; c++) {
    uint32_t root;
    memcpy(&root, bytes + sizeof h + c * sizeof root, sizeof root);
    stats->charts += count_charts(&root, 1);
  }
  return YLM_OK;
}

ylm_status ylm_surface_read(const ylm_scene *scene, const unsigned char *bytes, size_t size,
                            const char *name, ylm_surface_grid **out, ylm_error *e) {
  header h;
  ylm_scene_prints prints;
  *out = NULL;
  ylm_status s = read_header(bytes, size, name, &h, e);
  if (s != YLM_OK) return s;
  ylm_scene_print(scene, &prints);
  if (h.prints[0] != prints.geometry)
    return ylm_fail(e, YLM_EINVAL,
                    "%s: the light is of the surfaces of another scene (make it again)", name);
  ylm_surface_grid *g = ylm_alloc_zero(1, sizeof *g);
  if (!g) return YLM_ENOMEM;
  restore(g, &h);
  sections all = sections_of(&h, g);
  s = size_of(&all) == size ? ylm__surface_charts(scene, &g->charts, e)
                            : damaged(name, "the size", e);
  if (s == YLM_OK && g->charts.charts != h.charts) s = damaged(name, "the number of charts", e);
  if (s == YLM_OK) s = read_sections(g, &h, bytes, name, e);
  if (s == YLM_OK) {
    g->stats.charts = count_charts(g->root, h.charts);
    ylm__surface_weigh(g);
    *out = g;
  } else
    ylm_surface_free(g);
  return s;
}
