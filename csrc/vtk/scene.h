// scene.h - a scene's insides. Private to csrc/vtk.
#pragma once

#include "window.h"

#include <vtkRenderer.h>

#include <utility>
#include <vector>

class vtkActor;
class vtkGPUVolumeRayCastMapper;

struct ylm_vtk_scene {
  vtkSmartPointer<vtkRenderer> renderer;
  std::vector<std::pair<vtkSmartPointer<vtkActor>, double>> lines; // with their widths
  std::vector<vtkSmartPointer<vtkGPUVolumeRayCastMapper>> clouds;
  std::vector<vtkSmartPointer<vtkActor>> ghosts;
  bool peel = false;

  ylm_vtk_scene();
  void prepare(const double background[3], int supersample);
};
