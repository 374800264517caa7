/* vtkfile.c - .vtu, .vtp and .vti files: an XML header and raw arrays behind it. */
#include "ylm_figure.h"

#include <string.h>

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

static ylm_status finish(writer *w, const char *kind, ylm_error *e) {
  fprintf(w->out, "</Piece>\n</%s>\n<AppendedData encoding=\"raw\">\n_", kind);
  for (int i = 0; i < w->arrays; i++) {
    uint64_t n = data_bytes(&w->array[i]);
    ylm_file_write(w->file, &n, sizeof n);
    ylm_file_write(w->file, w->array[i].data, (size_t)n);
  }
  fprintf(w->out, "\n</AppendedData>\n</VTKFile>\n");
  return ylm_file_commit(w->file, e);
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

ylm_status ylm_figure_save_cells(const char *path, size_t points, const double *point, size_t cells,
                                 const int64_t *corner, int point_arrays,
                                 const ylm_figure_data *point_data, int cell_arrays,
                                 const ylm_figure_data *cell_data, ylm_error *e) {
  for (size_t i = 0; i < 8 * cells; i++)
    if (corner[i] < 0 || (uint64_t)corner[i] >= points)
      return ylm_fail(e, YLM_ERANGE, "cell %zu has a corner that is none of the points", i / 8 + 1);
  int64_t *order = ylm_alloc(cells, 8 * sizeof *order), *ends = ylm_alloc(cells, sizeof *ends);
  uint8_t *type = ylm_alloc(cells, 1);
  writer w;
  ylm_status s = order && ends && type ? open_file(&w, path, e) : YLM_ENOMEM;
  if (s == YLM_OK) {
    order_corners(cells, corner, order);
    for (size_t i = 0; i < cells; i++) ends[i] = (int64_t)(8 * (i + 1)), type[i] = HEXAHEDRON;
    const ylm_figure_data at = {"Points", YLM_FIGURE_F64, 3, points, point};
    const ylm_figure_data layout[3] = {{"connectivity", YLM_FIGURE_I64, 1, 8 * cells, order},
                                       {"offsets", YLM_FIGURE_I64, 1, cells, ends},
                                       {"types", YLM_FIGURE_U8, 1, cells, type}};
    begin(&w, "UnstructuredGrid");
    fprintf(w.out, "<UnstructuredGrid>\n<Piece NumberOfPoints=\"%zu\" NumberOfCells=\"%zu\">\n",
            points, cells);
    declare_all(&w, "PointData", point_arrays, point_data);
    declare_all(&w, "CellData", cell_arrays, cell_data);
    declare_all(&w, "Points", 1, &at);
    declare_all(&w, "Cells", 3, layout);
    s = finish(&w, "UnstructuredGrid", e);
  }
  ylm_free(order);
  ylm_free(ends);
  ylm_free(type);
  return s;
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
