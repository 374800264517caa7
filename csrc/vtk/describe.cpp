// describe.cpp - what VTK's readers see in a file.
#include "window.h"

#include <vtkCellData.h>
#include <vtkCompositeDataIterator.h>
#include <vtkDataArray.h>
#include <vtkDataSet.h>
#include <vtkGLTFReader.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkTriangleFilter.h>
#include <vtkXMLGenericDataObjectReader.h>

#include <cmath>
#include <cstring>

using ylm::guarded;
template <class T> using Ptr = vtkSmartPointer<T>;

static void describe(std::string &out, const char *where, vtkFieldData *fields) {
  for (int i = 0; i < fields->GetNumberOfArrays(); i++) {
    vtkDataArray *a = fields->GetArray(i);
    if (!a) continue;
    double range[2];
    a->GetRange(range, a->GetNumberOfComponents() > 1 ? -1 : 0);
    char line[256];
    std::snprintf(line, sizeof line, "%s %s %d %lld %.9g %.9g\n", where,
                  a->GetName() ? a->GetName() : "", a->GetNumberOfComponents(),
                  (long long)a->GetNumberOfTuples(), range[0], range[1]);
    out += line;
  }
}

static void describe(std::string &out, const char *name, long long points, long long cells,
                     const double b[6]) {
  char line[256];
  std::snprintf(line, sizeof line, "%s %lld %lld\nbounds %.9g %.9g %.9g %.9g %.9g %.9g\n", name,
                points, cells, b[0], b[2], b[4], b[1], b[3], b[5]);
  out += line;
}

// Sums over the triangles of a piece: their number, area, signed volume; its bounds are widened by their corners.
static void measure(vtkPolyData *piece, long long *n, double *area, double *volume, double b[6]) {
  auto filter = Ptr<vtkTriangleFilter>::New();
  filter->SetInputData(piece);
  filter->PassVertsOff();
  filter->PassLinesOff();
  filter->Update();
  vtkPolyData *data = filter->GetOutput();
  for (vtkIdType i = 0; i < data->GetNumberOfCells(); i++) {
    vtkIdType corners;
    const vtkIdType *at;
    data->GetCellPoints(i, corners, at);
    if (corners != 3) continue;
    double p[3][3], u[3], v[3];
    for (int k = 0; k < 3; k++) {
      data->GetPoint(at[k], p[k]);
      for (int a = 0; a < 3; a++) {
        b[2 * a] = std::fmin(b[2 * a], p[k][a]);
        b[2 * a + 1] = std::fmax(b[2 * a + 1], p[k][a]);
      }
    }
    for (int a = 0; a < 3; a++) u[a] = p[1][a] - p[0][a], v[a] = p[2][a] - p[0][a];
    const double c[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                         u[0] * v[1] - u[1] * v[0]};
    ++*n;
    *area += std::sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]) / 2;
    *volume += (p[0][0] * c[0] + p[0][1] * c[1] + p[0][2] * c[2]) / 6;
  }
}

// Triangles of all pieces of a glTF file, in world coordinates.
static ylm_status describe_gltf(const char *path, std::string &out, ylm_error *e) {
  auto reader = Ptr<vtkGLTFReader>::New();
  reader->SetFileName(path);
  reader->Update();
  vtkMultiBlockDataSet *all = reader->GetOutput();
  if (!all || all->GetNumberOfBlocks() == 0)
    return ylm_fail(e, YLM_EFORMAT, "%s: VTK does not read it", path);
  long long points = 0, triangles = 0;
  double area = 0, volume = 0;
  double b[6] = {HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL};
  auto at = Ptr<vtkCompositeDataIterator>::Take(all->NewIterator());
  for (at->InitTraversal(); !at->IsDoneWithTraversal(); at->GoToNextItem()) {
    vtkPolyData *piece = vtkPolyData::SafeDownCast(at->GetCurrentDataObject());
    if (!piece) continue;
    points += piece->GetNumberOfPoints();
    measure(piece, &triangles, &area, &volume, b);
  }
  describe(out, "glTF", points, triangles, b);
  char line[128];
  std::snprintf(line, sizeof line, "area %.17g\nvolume %.17g\n", area, volume);
  out += line;
  return YLM_OK;
}

static ylm_status describe_xml(const char *path, std::string &out, ylm_error *e) {
  auto reader = Ptr<vtkXMLGenericDataObjectReader>::New();
  reader->SetFileName(path);
  reader->Update();
  vtkDataSet *data = vtkDataSet::SafeDownCast(reader->GetOutput());
  if (!data) return ylm_fail(e, YLM_EFORMAT, "%s: VTK does not read it", path);
  double b[6];
  data->GetBounds(b);
  describe(out, data->GetClassName(), data->GetNumberOfPoints(), data->GetNumberOfCells(), b);
  if (data->GetNumberOfCells() > 0) out += "type " + std::to_string(data->GetCellType(0)) + "\n";
  describe(out, "point", data->GetPointData());
  describe(out, "cell", data->GetCellData());
  return YLM_OK;
}

static bool ends_in(const std::string &path, const char *ending) {
  const size_t n = std::strlen(ending);
  return path.size() >= n && path.compare(path.size() - n, n, ending) == 0;
}

extern "C" ylm_status ylm_vtk_describe(const char *path, char **text, ylm_error *e) {
  *text = nullptr;
  return guarded(e, [&] {
    std::string out;
    const bool gltf = ends_in(path, ".gltf") || ends_in(path, ".glb");
    ylm_status s = gltf ? describe_gltf(path, out, e) : describe_xml(path, out, e);
    if (s != YLM_OK) return s;
    *text = static_cast<char *>(ylm_alloc(out.size() + 1, 1));
    if (!*text) return YLM_ENOMEM;
    std::memcpy(*text, out.c_str(), out.size() + 1);
    return YLM_OK;
  });
}
