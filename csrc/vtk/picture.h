// picture.h - a float picture with depth as a prop. Private to csrc/vtk.
#pragma once

#include "window.h"

#include <vtkProp.h>

#include <memory>
#include <vector>

class vtkOpenGLQuadHelper;
class vtkTextureObject;

namespace ylm {

// Fills the viewport of its renderer: with radiance through a tone table and depth, or with bytes as they are.
class Picture : public vtkProp {
public:
  static Picture *New();
  vtkTypeMacro(Picture, vtkProp);
  void set_radiance(int w, int h, const float *rgb, const float *depth);
  void set_bytes(int w, int h, const uint8_t *rgb);
  void set_tone(size_t n, const float *table, double first, double last);
  double *GetBounds() VTK_SIZEHINT(6) override { return nullptr; }
  int RenderOpaqueGeometry(vtkViewport *viewport) override;
  int RenderOverlay(vtkViewport *viewport) override;
  void ReleaseGraphicsResources(vtkWindow *window) override;

protected:
  Picture();
  ~Picture() override;

private:
  struct Layer {
    int w = 0, h = 0;
    bool fresh = false;
    vtkSmartPointer<vtkTextureObject> texture;
  };
  bool upload(vtkRenderWindow *window);
  void draw(vtkViewport *viewport);

  bool bytes = false;
  std::vector<float> rgb, depth, tone; // until they are on the device
  std::vector<uint8_t> rgb8;
  double first = -12, last = 8;
  Layer colour, range, table;
  std::unique_ptr<vtkOpenGLQuadHelper> quad;
  Picture(const Picture &) = delete;
  Picture &operator=(const Picture &) = delete;
};

} // namespace ylm
