// gltf.cpp - a scene's shapes as a glTF file.
#include "scene.h"

#include <vtkActor.h>
#include <vtkActorCollection.h>
#include <vtkCamera.h>
#include <vtkFloatArray.h>
#include <vtkGLTFExporter.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkMatrix4x4.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataNormals.h>
#include <vtkProperty.h>
#include <vtkUnsignedCharArray.h>

#include <cmath>

using ylm::guarded;
template <class T> using Ptr = vtkSmartPointer<T>;

// Linear light of an sRGB value of 0 .. 1: glTF's colours and factors are linear.
static double linear(double x) {
  return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
}

// The vector as one of length 1; false where it has no direction.
static bool make_unit(double n[3]) {
  const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  if (!(length > 1e-12 && std::isfinite(length))) return false;
  for (int a = 0; a < 3; a++) n[a] /= length;
  return true;
}

// Normals of length 1. Isosurfaces have none beside voxels without a value: the surface's own stand there.
static Ptr<vtkFloatArray> unit_normals(vtkPolyData *data) {
  vtkDataArray *given = data->GetPointData()->GetNormals();
  auto made = Ptr<vtkFloatArray>::New();
  auto filter = Ptr<vtkPolyDataNormals>::New();
  made->SetName("NORMAL");
  made->SetNumberOfComponents(3);
  made->SetNumberOfTuples(given->GetNumberOfTuples());
  for (vtkIdType i = 0; i < given->GetNumberOfTuples(); i++) {
    double n[3];
    given->GetTuple(i, n);
    if (!make_unit(n)) {
      if (!filter->GetInput()) {
        filter->SetInputData(data);
        filter->SplittingOff();
        filter->ConsistencyOff();
        filter->Update();
      }
      filter->GetOutput()->GetPointData()->GetNormals()->GetTuple(i, n);
      if (!make_unit(n)) n[0] = n[1] = 0, n[2] = 1;
    }
    made->SetTuple(i, n);
  }
  return made;
}

// The actor's triangles or lines: colours of points are linear, normals have the name by which the exporter finds them.
static Ptr<vtkPolyData> for_export(vtkPolyData *data) {
  auto copy = Ptr<vtkPolyData>::New();
  copy->ShallowCopy(data);
  if (auto *colour = vtkUnsignedCharArray::SafeDownCast(data->GetPointData()->GetScalars())) {
    auto made = Ptr<vtkUnsignedCharArray>::New();
    made->DeepCopy(colour);
    const int k = made->GetNumberOfComponents();
    for (vtkIdType i = 0; i < made->GetNumberOfValues(); i++)
      if (i % k < 3)
        made->SetValue(i, (unsigned char)(255 * linear(colour->GetValue(i) / 255.0) + 0.5));
    copy->GetPointData()->SetScalars(made);
  }
  if (data->GetPointData()->GetNormals()) copy->GetPointData()->SetNormals(unit_normals(data));
  return copy;
}

// Entries of an actor's material that the exporter leaves out.
static std::string more_of_material(vtkActor *actor) {
  std::string out = "\"doubleSided\": true, ";
  if (actor->HasTranslucentPolygonalGeometry()) out += "\"alphaMode\": \"BLEND\", ";
  if (!actor->GetProperty()->GetLighting())
    out += "\"extensions\": {\"KHR_materials_unlit\": {}}, ";
  return out;
}

// The actor with factors of glTF; null where it has no triangles and lines.
static Ptr<vtkActor> for_export(vtkActor *actor) {
  auto *old = vtkPolyDataMapper::SafeDownCast(actor->GetMapper());
  if (!old || !old->GetInput()) return nullptr;
  auto mapper = Ptr<vtkPolyDataMapper>::New();
  mapper->ShallowCopy(old);
  mapper->SetInputData(for_export(old->GetInput()));
  auto copy = Ptr<vtkActor>::New();
  copy->ShallowCopy(actor);
  auto property = Ptr<vtkProperty>::New();
  property->DeepCopy(actor->GetProperty());
  double c[3];
  property->GetColor(c);
  property->SetColor(linear(c[0]), linear(c[1]), linear(c[2]));
  property->SetSpecular(0); // metallic 0, roughness 1
  property->SetSpecularPower(0);
  copy->SetProperty(property);
  copy->SetMapper(mapper);
  return copy;
}

// The exporter's text with `more` put into its materials, one each.
static std::string with_materials(const std::string &text, const std::vector<std::string> &more) {
  static const char key[] = "\"pbrMetallicRoughness\"";
  std::string out = "{ \"extensionsUsed\": [\"KHR_materials_unlit\"],";
  size_t from = text.find('{') + 1, at;
  for (size_t i = 0; (at = text.find(key, from)) != std::string::npos; i++) {
    if (i == more.size()) return text;
    out.append(text, from, at - from).append(more[i]).append(key);
    from = at + sizeof key - 1;
  }
  return out.append(text, from, std::string::npos);
}

// The text with the camera's place: VTK 9.1 writes its inverse. No other node has a matrix.
static std::string with_camera(const std::string &text, vtkCamera *camera) {
  size_t from = text.find("\"matrix\""), to = text.find(']', from);
  if (from == std::string::npos || to == std::string::npos) return text;
  auto place = Ptr<vtkMatrix4x4>::New();
  vtkMatrix4x4::Invert(camera->GetViewTransformMatrix(), place);
  std::string matrix = "\"matrix\": [";
  for (int i = 0; i < 16; i++) {
    char number[40];
    std::snprintf(number, sizeof number, "%s%.17g", i ? ", " : "",
                  place->GetElement(i % 4, i / 4)); // columns first
    matrix += number;
  }
  return text.substr(0, from) + matrix + text.substr(to);
}

extern "C" ylm_status ylm_vtk_save_gltf(ylm_vtk_scene *s, int width, int height, const char *path,
                                        ylm_error *e) {
  return guarded(e, [&] {
    auto renderer = Ptr<vtkRenderer>::New();
    vtkActorCollection *actors = s->renderer->GetActors();
    actors->InitTraversal();
    std::vector<std::string> more;
    while (vtkActor *actor = actors->GetNextActor())
      if (auto copy = for_export(actor)) {
        renderer->AddActor(copy);
        more.push_back(more_of_material(actor));
      }
    renderer->GetActiveCamera()->DeepCopy(s->renderer->GetActiveCamera());
    // It is never drawn: no display is asked for.
    auto window = Ptr<vtkGenericOpenGLRenderWindow>::New();
    window->SetSize(width, height);
    window->AddRenderer(renderer);
    auto exporter = Ptr<vtkGLTFExporter>::New();
    exporter->SetRenderWindow(window);
    exporter->InlineDataOn();
    exporter->SaveNormalOn();
    std::string text = exporter->WriteToString();
    window->RemoveRenderer(renderer);
    if (text.empty()) return ylm_fail(e, YLM_EDEVICE, "%s: VTK writes nothing", path);
    text = with_camera(with_materials(text, more), renderer->GetActiveCamera());
    return ylm_file_save(path, text.data(), text.size(), e);
  });
}
