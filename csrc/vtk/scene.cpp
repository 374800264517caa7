// scene.cpp - what a scene holds, and its picture.
#include "scene.h"

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkColorTransferFunction.h>
#include <vtkFloatArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkGPUVolumeRayCastMapper.h>
#include <vtkImageData.h>
#include <vtkLight.h>
#include <vtkOpenGLRenderer.h>
#include <vtkPiecewiseFunction.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataNormals.h>
#include <vtkProperty.h>
#include <vtkSmartVolumeMapper.h>
#include <vtkTexture.h>
#include <vtkUnsignedCharArray.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>

#include <cmath>
#include <cstring>

using ylm::guarded;
template <class T> using Ptr = vtkSmartPointer<T>;

// A light fixed to the camera, from direction x, y, z in its axes.
static void add_light(vtkRenderer *r, double x, double y, double z, double intensity) {
  auto light = Ptr<vtkLight>::New();
  light->SetLightTypeToCameraLight();
  light->SetPosition(x, y, z);
  light->SetFocalPoint(0, 0, 0);
  light->SetIntensity(intensity);
  r->AddLight(light);
}

ylm_vtk_scene::ylm_vtk_scene() : renderer(Ptr<vtkRenderer>::New()) {
  renderer->SetAutomaticLightCreation(false);
  renderer->SetTwoSidedLighting(true);
  add_light(renderer, 0.45, 0.65, 1, 0.75); // key, over the right shoulder
  add_light(renderer, -0.8, 0.15, 0.7, 0.3);
  add_light(renderer, 0.2, -0.9, 0.35, 0.15);
}

extern "C" ylm_status ylm_vtk_scene_create(ylm_vtk_scene **s, ylm_error *e) {
  *s = nullptr;
  return guarded(e, [&] {
    *s = new ylm_vtk_scene;
    return YLM_OK;
  });
}

extern "C" void ylm_vtk_scene_free(ylm_vtk_scene *s) {
  ylm_error e;
  guarded(&e, [&] {
    delete s;
    return YLM_OK;
  });
}

static Ptr<vtkPolyData> polydata(const ylm_figure_shape *shape) {
  auto points = Ptr<vtkPoints>::New();
  auto position = Ptr<vtkFloatArray>::New();
  position->SetNumberOfComponents(3);
  position->SetNumberOfTuples(vtkIdType(shape->points));
  std::memcpy(position->GetPointer(0), shape->position, shape->points * 3 * sizeof(float));
  points->SetData(position);
  auto offsets = Ptr<vtkIdTypeArray>::New(), ids = Ptr<vtkIdTypeArray>::New();
  offsets->SetNumberOfValues(vtkIdType(shape->cells) + 1);
  ids->SetNumberOfValues(vtkIdType(shape->cells) * shape->corners);
  for (size_t i = 0; i <= shape->cells; i++)
    offsets->SetValue(vtkIdType(i), vtkIdType(i) * shape->corners);
  for (size_t i = 0; i < shape->cells * size_t(shape->corners); i++)
    ids->SetValue(vtkIdType(i), shape->index[i]);
  auto cells = Ptr<vtkCellArray>::New();
  cells->SetData(offsets, ids);
  auto data = Ptr<vtkPolyData>::New();
  data->SetPoints(points);
  if (shape->corners == 3)
    data->SetPolys(cells);
  else
    data->SetLines(cells);
  auto colour = Ptr<vtkUnsignedCharArray>::New();
  colour->SetNumberOfComponents(4);
  colour->SetNumberOfTuples(vtkIdType(shape->points));
  std::memcpy(colour->GetPointer(0), shape->colour, shape->points * 4);
  data->GetPointData()->SetScalars(colour);
  if (shape->normal) {
    auto normal = Ptr<vtkFloatArray>::New();
    normal->SetNumberOfComponents(3);
    normal->SetNumberOfTuples(vtkIdType(shape->points));
    std::memcpy(normal->GetPointer(0), shape->normal, shape->points * 3 * sizeof(float));
    data->GetPointData()->SetNormals(normal);
  }
  return data;
}

static void apply(vtkProperty *p, const ylm_vtk_style *style) {
  p->SetAmbient(style->ambient);
  p->SetDiffuse(style->diffuse);
  p->SetSpecular(style->specular);
  p->SetSpecularPower(30);
  p->SetOpacity(style->opacity);
  if (style->flat) p->SetInterpolationToFlat();
  if (style->ambient >= 1 && style->diffuse <= 0) p->SetLighting(false);
}

// True if any colour is translucent.
static bool translucent(const ylm_figure_shape *shape) {
  for (size_t i = 0; i < shape->points; i++)
    if (shape->colour[4 * i + 3] < 255) return true;
  return false;
}

static ylm_status check_shape(const ylm_figure_shape *s, ylm_error *e) {
  if (s->corners != 2 && s->corners != 3)
    return ylm_fail(e, YLM_EINVAL, "a shape of %d corners a cell: 2 or 3 expected", s->corners);
  for (size_t i = 0; i < s->cells * size_t(s->corners); i++)
    if (s->index[i] >= s->points)
      return ylm_fail(e, YLM_EINVAL, "cell %zu of a shape names point %zu of %zu",
                      i / size_t(s->corners) + 1, size_t(s->index[i]) + 1, s->points);
  return YLM_OK;
}

extern "C" ylm_status ylm_vtk_add_shape(ylm_vtk_scene *s, const ylm_figure_shape *shape,
                                        const ylm_vtk_style *style, ylm_error *e) {
  if (shape->cells == 0) return YLM_OK;
  ylm_status good = check_shape(shape, e);
  if (good != YLM_OK) return good;
  return guarded(e, [&] {
    auto mapper = Ptr<vtkPolyDataMapper>::New();
    mapper->SetInputData(polydata(shape));
    mapper->SetColorModeToDirectScalars();
    auto actor = Ptr<vtkActor>::New();
    actor->SetMapper(mapper);
    apply(actor->GetProperty(), style);
    bool clear = style->opacity < 1 || translucent(shape);
    if (!clear) actor->ForceOpaqueOn();
    if (shape->corners == 2) {
      actor->GetProperty()->SetLineWidth(float(style->line_width));
      actor->GetProperty()->SetLighting(false);
      s->lines.push_back({actor, style->line_width});
    } else if (clear)
      s->peel = true;
    if (style->ghost && clear) s->ghosts.push_back(actor);
    s->renderer->AddActor(actor);
    return YLM_OK;
  });
}

// A lattice of one component; NaN becomes `none`.
static Ptr<vtkImageData> image(const ylm_figure_volume *v, float none) {
  auto data = Ptr<vtkImageData>::New();
  data->SetDimensions(int(v->size[0]), int(v->size[1]), int(v->size[2]));
  data->SetOrigin(v->origin[0], v->origin[1], v->origin[2]);
  data->SetSpacing(v->spacing[0], v->spacing[1], v->spacing[2]);
  data->AllocateScalars(VTK_FLOAT, 1);
  auto *to = static_cast<float *>(data->GetScalarPointer());
  const size_t n = v->size[0] * v->size[1] * v->size[2];
  for (size_t i = 0; i < n; i++) to[i] = std::isnan(v->value[i]) ? none : v->value[i];
  return data;
}

// A cloud has voxels of 8 bits: 0 is empty, 1 .. 255 the place in the table.
static Ptr<vtkImageData> cloud(const ylm_figure_volume *v) {
  auto data = Ptr<vtkImageData>::New();
  data->SetDimensions(int(v->size[0]), int(v->size[1]), int(v->size[2]));
  data->SetOrigin(v->origin[0], v->origin[1], v->origin[2]);
  data->SetSpacing(v->spacing[0], v->spacing[1], v->spacing[2]);
  data->AllocateScalars(VTK_UNSIGNED_CHAR, 1);
  auto *to = static_cast<unsigned char *>(data->GetScalarPointer());
  const size_t n = v->size[0] * v->size[1] * v->size[2];
  for (size_t i = 0; i < n; i++) {
    float x = v->value[i];
    to[i] = std::isnan(x) ? 0 : (unsigned char)(1 + 254 * std::fmin(1, std::fmax(0, x)) + 0.5);
  }
  return data;
}

extern "C" ylm_status ylm_vtk_add_volume(ylm_vtk_scene *s, const ylm_figure_volume *place,
                                         const double *table, double distance, int smooth,
                                         ylm_error *e) {
  return guarded(e, [&] {
    auto colour = Ptr<vtkColorTransferFunction>::New();
    auto opacity = Ptr<vtkPiecewiseFunction>::New();
    opacity->AddPoint(0, 0);
    for (int i = 1; i < 256; i++) {
      const double *t = table + 4 * i;
      colour->AddRGBPoint(i, t[0], t[1], t[2]);
      opacity->AddPoint(i, t[3]);
    }
    auto property = Ptr<vtkVolumeProperty>::New();
    property->SetColor(colour);
    property->SetScalarOpacity(opacity);
    property->SetScalarOpacityUnitDistance(distance);
    if (smooth)
      property->SetInterpolationTypeToLinear();
    else
      property->SetInterpolationTypeToNearest();
    property->ShadeOff();
    auto mapper = Ptr<vtkGPUVolumeRayCastMapper>::New();
    mapper->SetInputData(cloud(place));
    double step = std::fmin(place->spacing[0], std::fmin(place->spacing[1], place->spacing[2]));
    mapper->SetAutoAdjustSampleDistances(0);
    mapper->SetSampleDistance(float(step));
    mapper->SetImageSampleDistance(1);
    mapper->SetUseJittering(0);
    mapper->SetBlendModeToComposite();
    auto volume = Ptr<vtkVolume>::New();
    volume->SetMapper(mapper);
    volume->SetProperty(property);
    s->clouds.push_back(mapper);
    s->renderer->AddVolume(volume);
    return YLM_OK;
  });
}

extern "C" ylm_status ylm_vtk_add_isosurfaces(ylm_vtk_scene *s, const ylm_figure_volume *v,
                                              size_t n, const double *value, const double *colour,
                                              ylm_error *e) {
  return guarded(e, [&] {
    auto data = image(v, -1e30f);
    for (size_t i = 0; i < n; i++) {
      auto edges = Ptr<vtkFlyingEdges3D>::New();
      edges->SetInputData(data);
      edges->SetValue(0, value[i]);
      edges->ComputeNormalsOn();
      edges->ComputeScalarsOff();
      edges->Update();
      if (edges->GetOutput()->GetNumberOfCells() == 0) continue;
      auto mapper = Ptr<vtkPolyDataMapper>::New();
      mapper->SetInputData(edges->GetOutput());
      mapper->ScalarVisibilityOff();
      auto actor = Ptr<vtkActor>::New();
      actor->SetMapper(mapper);
      ylm_vtk_style style = {0.45, 0.65, 0.2, 1, colour[4 * i + 3], 0, 0};
      apply(actor->GetProperty(), &style);
      actor->GetProperty()->SetColor(colour[4 * i], colour[4 * i + 1], colour[4 * i + 2]);
      if (colour[4 * i + 3] < 1) s->peel = true;
      s->renderer->AddActor(actor);
    }
    return YLM_OK;
  });
}

extern "C" ylm_status ylm_vtk_add_picture(ylm_vtk_scene *s, const double corner[3],
                                          const double u[3], const double v[3], int w, int h,
                                          const uint8_t *rgba, int smooth, ylm_error *e) {
  ylm_status good = ylm::check_sides("a picture", w, h, 1, e);
  if (good != YLM_OK) return good;
  return guarded(e, [&] {
    auto points = Ptr<vtkPoints>::New();
    auto uv = Ptr<vtkFloatArray>::New();
    uv->SetNumberOfComponents(2);
    static const double corners[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    auto quad = Ptr<vtkCellArray>::New();
    quad->InsertNextCell(4);
    for (int i = 0; i < 4; i++) {
      double p[3];
      for (int a = 0; a < 3; a++) p[a] = corner[a] + corners[i][0] * u[a] + corners[i][1] * v[a];
      quad->InsertCellPoint(points->InsertNextPoint(p));
      uv->InsertNextTuple2(corners[i][0], corners[i][1]);
    }
    auto data = Ptr<vtkPolyData>::New();
    data->SetPoints(points);
    data->SetPolys(quad);
    data->GetPointData()->SetTCoords(uv);
    auto picture = Ptr<vtkImageData>::New();
    picture->SetDimensions(w, h, 1);
    picture->AllocateScalars(VTK_UNSIGNED_CHAR, 4);
    std::memcpy(picture->GetScalarPointer(), rgba, size_t(w) * size_t(h) * 4);
    auto texture = Ptr<vtkTexture>::New();
    texture->SetInputData(picture);
    texture->SetInterpolate(smooth);
    texture->MipmapOff();
    texture->RepeatOff();
    texture->EdgeClampOn();
    auto mapper = Ptr<vtkPolyDataMapper>::New();
    mapper->SetInputData(data);
    auto actor = Ptr<vtkActor>::New();
    actor->SetMapper(mapper);
    actor->SetTexture(texture);
    actor->GetProperty()->SetLighting(false);
    for (size_t i = 0; i < size_t(w) * size_t(h); i++)
      if (rgba[4 * i + 3] < 255) s->peel = true;
    if (!s->peel)
      actor->ForceOpaqueOn();
    else
      actor->ForceTranslucentOn();
    s->renderer->AddActor(actor);
    return YLM_OK;
  });
}

extern "C" void ylm_vtk_camera(ylm_vtk_scene *s, const double from[3], const double at[3],
                               const double up[3], double fov) {
  vtkCamera *c = s->renderer->GetActiveCamera();
  c->SetPosition(from);
  c->SetFocalPoint(at);
  c->SetViewUp(up);
  c->SetViewAngle(fov);
}

void ylm_vtk_scene::prepare(const double background[3], int supersample) {
  renderer->SetBackground(background[0], background[1], background[2]);
  for (auto &line : lines)
    line.first->GetProperty()->SetLineWidth(float(line.second * supersample));
  for (auto &mapper : clouds) mapper->SetImageSampleDistance(float(supersample));
  renderer->SetUseDepthPeeling(peel);
  renderer->SetMaximumNumberOfPeels(8);
  renderer->SetOcclusionRatio(0.001);
  renderer->ResetCameraClippingRange();
}

extern "C" ylm_status ylm_vtk_render(ylm_vtk_scene *s, int width, int height, int supersample,
                                     const double background[3], uint8_t *rgb, ylm_error *e) {
  ylm_status good = ylm::check_sides("a picture", width, height, supersample, e);
  if (good != YLM_OK) return good;
  return guarded(e, [&] {
    ylm::ContextGuard guard;
    auto window = ylm::offscreen_window(width * supersample, height * supersample, e);
    if (!window) return YLM_EMISSING;
    // Depth peeling does not work with multisamples.
    window->SetMultiSamples(supersample > 1 || s->peel ? 0 : 4);
    s->prepare(background, supersample);
    window->AddRenderer(s->renderer);
    window->Render();
    ylm_status status = ylm::read_pixels(window, width, height, supersample, rgb, e);
    window->RemoveRenderer(s->renderer);
    window->Finalize();
    return status;
  });
}
