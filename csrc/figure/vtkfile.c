/* vtkfile.c - .vtu, .vtp and .vti files: an XML header and raw arrays behind it. */
#include "ylm_figure.h"

#include <string.h>
#include <sys/types.h>

typedef struct type_info {
  const char *name;
  size_t size;
} type_info;

static const type_info types[] = {[YLM_FIGURE_F32] = {"Float32", 4},
                                  [YLM_FIGURE_F64] = {"Float64", 8},
                                  [YLM_FIGURE_U8] = {"UInt8", 1},
                                  [YLM_FIGURE_I32] = {"Int32", 4},
                                  [YLM_FIGURE_I64] = {"Int64", 8}};

static uint64_t data_bytes(const ylm_figure_data *d) {
  return (uint64_t)d->n * (uint64_t)d->components * types[d->type].size;
}

/* A file being written: the offset of the next array in the appended block. */
typedef struct writer {
  ylm_file *file;
  FILE *out;
  uint64_t offset;
  int arrays;
  ylm_figure_data array[64];
} writer;

static void begin(writer *w, const char *kind) {
  const uint16_t one = 1;
  fprintf(w->out,
          "<?xml version=\"1.0\"?>\n<VTKFile type=\"%s\" version=\"1.0\" byte_order=\"%s\" "
          "header_type=\"UInt64\">\n",
          kind, *(const uint8_t *)&one ? "LittleEndian" : "BigEndian");
}

/* Text with what XML reserves replaced. */
static void put_name(FILE *out, const char *s) {
  for (; *s; s++) {
    if (*s == '<')
      fputs("&lt;", out);
    else if (*s == '>')
      fputs("&gt;", out);
    else if (*s == '&')
      fputs("&amp;", out);
    else if (*s == '"')
      fputs("&quot;", out);
    else
      fputc(*s, out);
  }
}

/* Declares an array; its bytes follow at the end. */
static void declare(writer *w, const ylm_figure_data *d) {
  fprintf(w->out, "<DataArray type=\"%s\" Name=\"", types[d->type].name);
  put_name(w->out, d->name);
  fprintf(w->out, "\" NumberOfComponents=\"%d\" format=\"appended\" offset=\"%llu\"/>\n",
          d->components, (unsigned long long)w->offset);
  w->offset += 8 + data_bytes(d);
  w->array[w->arrays++] = *d;
}

static void declare_all(writer *w, const char *section, int n, const ylm_figure_data *d) {
  fprintf(w->out, "<%s>\n", section);
  for (int i = 0; i < n && w->arrays < 60; i++) declare(w, &d[i]);
  fprintf(w->out, "</%s>\n", section);
}

static void begin_data(writer *w, const char *kind) {
  fprintf(w->out, "</%s>\n<AppendedData encoding=\"raw\">\n_", kind);
}

/* The bytes of the arrays that were declared last. */
static void put_data(writer *w) {
  for (int i = 0; i < w->arrays; i++) {
    uint64_t n = data_bytes(&w->array[i]);
    ylm_file_write(w->file, &n, sizeof n);
    ylm_file_write(w->file, w->array[i].data, (size_t)n);
  }
  w->arrays = 0;
}

static ylm_status end_data(writer *w, ylm_error *e) {
  fprintf(w->out, "\n</AppendedData>\n</VTKFile>\n");
  return ylm_file_commit(w->file, e);
}

static ylm_status finish(writer *w, const char *kind, ylm_error *e) {
  fprintf(w->out, "</Piece>\n");
  begin_data(w, kind);
  put_data(w);
  return end_data(w, e);
}

static ylm_status open_file(writer *w, const char *path, ylm_error *e) {
  memset(w, 0, sizeof *w);
  ylm_status s = ylm_file_create(path, &w->file, e);
  if (s == YLM_OK) w->out = ylm_file_stream(w->file);
  return s;
}

/* VTK counts a hexahedron's corners around its lower and its upper face. */
static void order_corners(size_t cells, const int64_t *corner, int64_t *out) {
  static const uint8_t order[8] = {0, 1, 3, 2, 4, 5, 7, 6};
  for (size_t i = 0; i < cells; i++)
    for (size_t k = 0; k < 8; k++) out[8 * i + k] = corner[8 * i + order[k]];
}

#define HEXAHEDRON 12

/* Arrays of hexahedra that VTK wants besides points and numbers. */
typedef struct cell_layout {
  int64_t *order, *ends;
  uint8_t *type;
} cell_layout;

static void layout_free(cell_layout *l) {
  ylm_free(l->order);
  ylm_free(l->ends);
  ylm_free(l->type);
}

static ylm_status layout_make(const ylm_figure_hexahedra *h, cell_layout *l, ylm_error *e) {
  *l = (cell_layout){NULL, NULL, NULL};
  for (size_t i = 0; i < 8 * h->cells; i++)
    if (h->corner[i] < 0 || (uint64_t)h->corner[i] >= h->points)
      return ylm_fail(e, YLM_ERANGE, "cell %zu has a corner that is none of the points", i / 8 + 1);
  l->order = ylm_alloc(h->cells, 8 * sizeof *l->order);
  l->ends = ylm_alloc(h->cells, sizeof *l->ends);
  l->type = ylm_alloc(h->cells, 1);
  if (!l->order || !l->ends || !l->type) {
    layout_free(l);
    return ylm_no_memory(e);
  }
  order_corners(h->cells, h->corner, l->order);
  for (size_t i = 0; i < h->cells; i++)
    l->ends[i] = (int64_t)(8 * (i + 1)), l->type[i] = HEXAHEDRON;
  return YLM_OK;
}

static void begin_cells(writer *w) {
  begin(w, "UnstructuredGrid");
  fprintf(w->out, "<UnstructuredGrid>\n");
}

/* Declares all arrays of a piece. */
static void declare_piece(writer *w, const ylm_figure_hexahedra *h, const cell_layout *l) {
  const ylm_figure_data at = {"Points", YLM_FIGURE_F64, 3, h->points, h->point};
  const ylm_figure_data cells[3] = {{"connectivity", YLM_FIGURE_I64, 1, 8 * h->cells, l->order},
                                    {"offsets", YLM_FIGURE_I64, 1, h->cells, l->ends},
                                    {"types", YLM_FIGURE_U8, 1, h->cells, l->type}};
  fprintf(w->out, "<Piece NumberOfPoints=\"%zu\" NumberOfCells=\"%zu\">\n", h->points, h->cells);
  declare_all(w, "PointData", h->point_arrays, h->point_data);
  declare_all(w, "CellData", h->cell_arrays, h->cell_data);
  declare_all(w, "Points", 1, &at);
  declare_all(w, "Cells", 3, cells);
}

ylm_status ylm_figure_save_cells(const char *path, const ylm_figure_hexahedra *h, ylm_error *e) {
  cell_layout l;
  writer w;
  ylm_status s = layout_make(h, &l, e);
  if (s != YLM_OK) return s;
  s = open_file(&w, path, e);
  if (s == YLM_OK) {
    begin_cells(&w);
    declare_piece(&w, h, &l);
    s = finish(&w, "UnstructuredGrid", e);
  }
  layout_free(&l);
  return s;
}

/* -- several pieces: their declarations stand before all arrays, in room that is kept for them --- */

/* Digits by which a number of a later piece may be longer than that of the first. */
#define MORE_DIGITS 20

struct ylm_figure_pieces {
  writer w;
  size_t pieces, added;
  off_t first, room; /* of the declarations: the place of the first, bytes of each */
};

ylm_status ylm_figure_pieces_begin(const char *path, size_t pieces, ylm_figure_pieces **out,
                                   ylm_error *e) {
  *out = NULL;
  ylm_figure_pieces *p = ylm_alloc_zero(1, sizeof *p);
  if (!p) return ylm_no_memory_for(e, path);
  ylm_status s = open_file(&p->w, path, e);
  if (s != YLM_OK) {
    ylm_free(p);
    return s;
  }
  p->pieces = pieces;
  begin_cells(&p->w);
  p->first = ftello(p->w.out);
  *out = p;
  return YLM_OK;
}

/* Blanks for the declarations of the pieces behind the first, which ends here. */
static void keep_room(ylm_figure_pieces *p) {
  const off_t end = ftello(p->w.out);
  p->room = end - p->first + MORE_DIGITS * (p->w.arrays + 2);
  for (off_t i = end; i < p->first + (off_t)p->pieces * p->room; i++) fputc(' ', p->w.out);
  fputc('\n', p->w.out);
  begin_data(&p->w, "UnstructuredGrid");
}

/* Removes the file, and says why. */
static ylm_status give_up(ylm_figure_pieces *p, ylm_error *e) {
  ylm_file *file = p->w.file;
  p->w.file = NULL;
  if (ferror(p->w.out)) return ylm_file_commit(file, e);
  ylm_file_discard(file);
  return ylm_fail(e, YLM_EINVAL, "piece %zu has other arrays than the first", p->added);
}

ylm_status ylm_figure_pieces_add(ylm_figure_pieces *p, const ylm_figure_hexahedra *h,
                                 ylm_error *e) {
  cell_layout l;
  writer *w = &p->w;
  if (!w->file) return ylm_fail(e, YLM_EIO, "the file could not be written before");
  if (p->added == p->pieces)
    return ylm_fail(e, YLM_EINVAL, "the file was begun for %zu pieces", p->pieces);
  ylm_status s = layout_make(h, &l, e);
  if (s != YLM_OK) return s;
  const off_t place = p->first + (off_t)p->added * p->room;
  bool fits = fseeko(w->out, place, SEEK_SET) == 0;
  declare_piece(w, h, &l);
  fprintf(w->out, "</Piece>\n");
  if (p->added == 0) {
    keep_room(p);
  } else {
    fits = fits && ftello(w->out) <= place + p->room;
    fits = fseeko(w->out, 0, SEEK_END) == 0 && fits;
  }
  put_data(w);
  layout_free(&l);
  p->added++;
  return fits && !ferror(w->out) ? YLM_OK : give_up(p, e);
}

ylm_status ylm_figure_pieces_end(ylm_figure_pieces *p, ylm_error *e) {
  ylm_status s = YLM_OK;
  if (!p->w.file)
    s = ylm_fail(e, YLM_EIO, "the file could not be written before");
  else if (p->added < p->pieces)
    s = ylm_fail(e, YLM_EINVAL, "the file was begun for %zu pieces and has %zu", p->pieces,
                 p->added);
  else
    s = end_data(&p->w, e), p->w.file = NULL;
  ylm_figure_pieces_free(p);
  return s;
}

void ylm_figure_pieces_free(ylm_figure_pieces *p) {
  if (!p) return;
  ylm_file_discard(p->w.file);
  ylm_free(p);
}

ylm_status ylm_figure_save_shape(const char *path, const ylm_figure_shape *shape, ylm_error *e) {
  size_t n = shape->cells, corners = (size_t)shape->corners;
  int64_t *index = ylm_alloc(n, corners * sizeof *index), *ends = ylm_alloc(n, sizeof *ends);
  writer w;
  ylm_status s = index && ends ? open_file(&w, path, e) : YLM_ENOMEM;
  if (s == YLM_OK) {
    for (size_t i = 0; i < n * corners; i++) index[i] = shape->index[i];
    for (size_t i = 0; i < n; i++) ends[i] = (int64_t)(corners * (i + 1));
    const ylm_figure_data at = {"Points", YLM_FIGURE_F32, 3, shape->points, shape->position};
    const ylm_figure_data data[2] = {{"colour", YLM_FIGURE_U8, 4, shape->points, shape->colour},
                                     {"normal", YLM_FIGURE_F32, 3, shape->points, shape->normal}};
    const ylm_figure_data layout[2] = {{"connectivity", YLM_FIGURE_I64, 1, n * corners, index},
                                       {"offsets", YLM_FIGURE_I64, 1, n, ends}};
    bool lines = corners == 2;
    begin(&w, "PolyData");
    fprintf(
        w.out,
        "<PolyData>\n<Piece NumberOfPoints=\"%zu\" NumberOfLines=\"%zu\" NumberOfPolys=\"%zu\">\n",
        shape->points, lines ? n : 0, lines ? 0 : n);
    declare_all(&w, "PointData", shape->normal ? 2 : 1, data);
    declare_all(&w, "Points", 1, &at);
    declare_all(&w, lines ? "Lines" : "Polys", 2, layout);
    s = finish(&w, "PolyData", e);
  }
  ylm_free(index);
  ylm_free(ends);
  return s;
}

ylm_status ylm_figure_save_volume(const char *path, const ylm_figure_volume *v, const char *name,
                                  ylm_error *e) {
  writer w;
  ylm_status s = open_file(&w, path, e);
  if (s != YLM_OK) return s;
  size_t n = v->size[0] * v->size[1] * v->size[2];
  char extent[128];
  snprintf(extent, sizeof extent, "0 %zu 0 %zu 0 %zu", v->size[0] - 1, v->size[1] - 1,
           v->size[2] - 1);
  const ylm_figure_data data = {name, YLM_FIGURE_F32, v->components, n, v->value};
  begin(&w, "ImageData");
  fprintf(
      w.out,
      "<ImageData WholeExtent=\"%s\" Origin=\"%.17g %.17g %.17g\" Spacing=\"%.17g %.17g %.17g\">\n"
      "<Piece Extent=\"%s\">\n",
      extent, v->origin[0], v->origin[1], v->origin[2], v->spacing[0], v->spacing[1], v->spacing[2],
      extent);
  declare_all(&w, "PointData", 1, &data);
  return finish(&w, "ImageData", e);
}
