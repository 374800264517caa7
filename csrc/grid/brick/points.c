/* points.c - points and voxels in files of a bake under way: boundaries of bricks, points in lights. */
#include "brick.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#define POINTS_VERSION 1u
#define POINTS_MAGIC "YLMpoint"
#define BORDER_MAGIC "YLMbordr"

static ylm_status damaged(const char *path, ylm_error *e) {
  return ylm_fail(e, YLM_ECHECKSUM,
                  "%s: the file is damaged: bake anew, with fresh = true (ylm bake --fresh)", path);
}

static ylm_status no_memory(const char *path, ylm_error *e) { return ylm_no_memory_for(e, path); }

/* -- points --------------------------------------------------------------------------------------- */

void ylm__point_put(const ylm_grid *g, uint32_t point, void *record) {
  point_record r = {.flags = g->flags[point] & YLM_GRID_POINT_INVALID,
                    .lambda = g->lambda[point],
                    .norm = g->norm[point],
                    .validity = g->validity ? g->validity[point] : 1};
  memcpy(r.at, g->lattice + 3 * (size_t)point, sizeof r.at);
  memcpy(record, &r, sizeof r);
  memcpy((char *)record + sizeof r, ylm__grid_row(g, point, 0), 4 * g->stride * sizeof(float));
}

void ylm__point_take(ylm_grid *g, uint32_t point, const void *record) {
  point_record r;
  memcpy(&r, record, sizeof r);
  g->flags[point] = (uint8_t)r.flags;
  g->lambda[point] = r.lambda;
  g->norm[point] = r.norm;
  if (g->validity) g->validity[point] = r.validity;
  memcpy(g->data + (size_t)point * 4 * g->stride, (const char *)record + sizeof r,
         4 * g->stride * sizeof(float));
}

/* -- lists ------------------------------------------------------------------------------------------ */

typedef struct list_head {
  char magic[8];
  uint32_t version, zero;
  uint64_t voxels, points, bytes, crc; /* of all behind */
} list_head;

void ylm__points_free(point_list *l) {
  ylm_free(l->voxel);
  ylm_free(l->point);
  *l = (point_list){0};
}

ylm_status ylm__points_write(const char *path, const point_list *l, ylm_error *e) {
  size_t voxels = l->voxels * sizeof *l->voxel, points = l->points * l->bytes;
  list_head h = {.magic = POINTS_MAGIC,
                 .version = POINTS_VERSION,
                 .voxels = l->voxels,
                 .points = l->points,
                 .bytes = l->bytes};
  h.crc = ylm_crc64(ylm_crc64(0, l->voxel, voxels), l->point, points);
  ylm_file *f;
  ylm_status s = ylm_file_create(path, &f, e);
  if (s != YLM_OK) return s;
  ylm_file_write(f, &h, sizeof h);
  ylm_file_write(f, l->voxel, voxels);
  ylm_file_write(f, l->point, points);
  s = ylm_file_commit(f, e);
  if (s == YLM_OK) ylm__folder_sync(path);
  return s;
}

/* Are the numbers of points in voxels less than there are? */
static bool voxels_hold(const point_list *l) {
  for (size_t i = 0; i < l->voxels; i++)
    for (int k = 0; k < 8; k++)
      if (l->voxel[i].corner[k] != YLM_GRID_NONE && l->voxel[i].corner[k] >= l->points)
        return false;
  return true;
}

ylm_status ylm__points_read(const char *path, const ylm_grid *g, point_list *l, ylm_error *e) {
  unsigned char *data;
  size_t size;
  list_head h;
  *l = (point_list){0};
  ylm_status s = ylm_file_read(path, SIZE_MAX, &data, &size, e);
  if (s != YLM_OK) return s;
  bool holds = size >= sizeof h;
  if (holds) memcpy(&h, data, sizeof h);
  holds = holds && memcmp(h.magic, POINTS_MAGIC, 8) == 0 && h.version == POINTS_VERSION &&
          h.bytes == point_bytes(g) && h.voxels <= size / sizeof *l->voxel &&
          h.points <= size / h.bytes &&
          size == sizeof h + h.voxels * sizeof *l->voxel + h.points * h.bytes &&
          h.crc == ylm_crc64(0, data + sizeof h, size - sizeof h);
  if (holds) {
    size_t voxels = h.voxels * sizeof *l->voxel;
    *l = (point_list){.voxels = h.voxels, .points = h.points, .bytes = h.bytes};
    l->voxel = ylm_alloc_copy(data + sizeof h, h.voxels, sizeof *l->voxel);
    l->point = ylm_alloc_copy(data + sizeof h + voxels, h.points, h.bytes);
    if (!l->voxel || !l->point)
      s = no_memory(path, e);
    else if (!voxels_hold(l))
      holds = false;
  }
  ylm_free(data);
  if (s == YLM_OK && !holds) s = damaged(path, e);
  if (s != YLM_OK) ylm__points_free(l);
  return s;
}

/* -- boundaries ------------------------------------------------------------------------------------- */

/* The section that a point of a brick is in; -1: inside. */
static int section_of(const ylm_grid *g, const uint32_t at[3]) {
  int section = 0, three = 1;
  for (int a = 0; a < 3; a++, three *= 3)
    section += three * (at[a] == g->contents.root[a] ? 0 : at[a] > g->last[a] ? 2 : 1);
  return section == 13 ? -1 : section;
}

/* Records of the points on the boundary, by section, in their order. */
static void put_sections(const ylm_grid *g, border_head *h, char *record) {
  size_t bytes = point_bytes(g);
  uint64_t next[27];
  memcpy(next, h->first, sizeof next);
  for (size_t i = 0; i < g->evaluated; i++) {
    int section = section_of(g, g->lattice + 3 * i);
    if (section < 0) continue;
    h->invalid += (g->flags[i] & YLM_GRID_POINT_INVALID) != 0;
    ylm__point_put(g, (uint32_t)i, record + bytes * next[section]++);
  }
  for (int k = 0; k < 27; k++)
    h->sum[k] = ylm_crc64(0, record + bytes * h->first[k], bytes * (h->first[k + 1] - h->first[k]));
  h->crc = ylm_crc64(0, h, offsetof(border_head, crc));
}

ylm_status ylm__border_write(const ylm_grid *g, const char *path, ylm_error *e) {
  border_head h = {.magic = BORDER_MAGIC,
                   .version = POINTS_VERSION,
                   .stride = (uint32_t)g->stride,
                   .evaluated = g->evaluated};
  for (size_t i = 0; i < g->evaluated; i++) {
    int section = section_of(g, g->lattice + 3 * i);
    if (section >= 0) h.first[section + 1]++;
  }
  for (int k = 0; k < 27; k++) h.first[k + 1] += h.first[k];
  size_t size = sizeof h + h.first[27] * point_bytes(g);
  char *file = ylm_alloc(size, 1);
  if (!file) return no_memory(path, e);
  put_sections(g, &h, file + sizeof h);
  memcpy(file, &h, sizeof h);
  ylm_status s = ylm_file_save(path, file, size, e);
  ylm_free(file);
  return s;
}

ylm_status ylm__border_head(const char *path, border_head *h, ylm_error *e) {
  size_t n;
  ylm_status s = ylm_file_head(path, (unsigned char *)h, sizeof *h, &n, e);
  if (s != YLM_OK) return s;
  bool holds = n == sizeof *h && memcmp(h->magic, BORDER_MAGIC, 8) == 0 &&
               h->version == POINTS_VERSION &&
               h->crc == ylm_crc64(0, h, offsetof(border_head, crc));
  for (int k = 0; holds && k < 27; k++) holds = h->first[k] <= h->first[k + 1];
  return holds ? YLM_OK : damaged(path, e);
}

ylm_status ylm__border_section(const char *path, const ylm_grid *g, const border_head *h,
                               int section, char **records, ylm_error *e) {
  size_t bytes = point_bytes(g), n = h->first[section + 1] - h->first[section];
  *records = NULL;
  if (h->stride != g->stride) return damaged(path, e);
  FILE *f = fopen(path, "rb");
  if (!f) return ylm_fail(e, YLM_EIO, "%s: %s", path, strerror(errno));
  char *r = ylm_alloc(n, bytes);
  ylm_status s = r ? YLM_OK : no_memory(path, e);
  if (s == YLM_OK && (fseeko(f, (off_t)(sizeof *h + h->first[section] * bytes), SEEK_SET) != 0 ||
                      fread(r, bytes, n, f) != n || ylm_crc64(0, r, n * bytes) != h->sum[section]))
    s = ferror(f) ? ylm_fail(e, YLM_EIO, "%s: %s", path, strerror(errno)) : damaged(path, e);
  fclose(f);
  if (s == YLM_OK)
    *records = r;
  else
    ylm_free(r);
  return s;
}
