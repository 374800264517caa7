// text.cpp - texts, and canvases as .png files.
#include "window.h"

#include <vtkImageData.h>
#include <vtkPNGWriter.h>
#include <vtkTextProperty.h>
#include <vtkTextRenderer.h>
#include <vtkUnsignedCharArray.h>

#include <cmath>
#include <cstring>

using ylm::guarded;
template <class T> using Ptr = vtkSmartPointer<T>;

extern "C" ylm_status ylm_vtk_text(const char *text, double size, int bold, const double rgb[3],
                                   int *width, int *height, uint8_t **rgba, ylm_error *e) {
  *width = *height = 0;
  *rgba = nullptr;
  if (!*text) return YLM_OK;
  return guarded(e, [&] {
    auto property = Ptr<vtkTextProperty>::New();
    if (const char *font = ylm::font_file(bold != 0)) {
      property->SetFontFamily(VTK_FONT_FILE);
      property->SetFontFile(font);
    } else
      property->SetBold(bold);
    property->SetFontSize(int(size + 0.5));
    property->SetColor(rgb[0], rgb[1], rgb[2]);
    property->SetJustification(VTK_TEXT_LEFT);
    property->SetLineSpacing(1.15);
    auto data = Ptr<vtkImageData>::New();
    int dims[2] = {0, 0};
    vtkTextRenderer *tools = vtkTextRenderer::GetInstance();
    if (!tools) return ylm_fail(e, YLM_EMISSING, "VTK was built without text rendering");
    tools->SetScaleToPowerOfTwo(false);
    const bool ok = tools->RenderString(property, text, data, dims, 72, vtkTextRenderer::FreeType);
    tools->SetScaleToPowerOfTwo(true);
    if (!ok || data->GetScalarType() != VTK_UNSIGNED_CHAR ||
        data->GetNumberOfScalarComponents() != 4)
      return ylm_fail(e, YLM_EDEVICE, "a text cannot be drawn");
    int d[3];
    data->GetDimensions(d);
    *rgba = static_cast<uint8_t *>(ylm_alloc(size_t(d[0]) * size_t(d[1]), 4));
    if (!*rgba) return YLM_ENOMEM;
    const auto *from = static_cast<const uint8_t *>(data->GetScalarPointer());
    for (int y = 0; y < d[1]; y++)
      std::memcpy(*rgba + size_t(y) * size_t(d[0]) * 4,
                  from + size_t(d[1] - 1 - y) * size_t(d[0]) * 4, size_t(d[0]) * 4);
    *width = d[0];
    *height = d[1];
    return YLM_OK;
  });
}

extern "C" ylm_status ylm_vtk_save_png(const char *path, const ylm_figure_canvas *c, ylm_error *e) {
  ylm_status good = ylm::check_sides("a canvas", c->width, c->height, 1, e);
  if (good != YLM_OK) return good;
  return guarded(e, [&] {
    auto data = Ptr<vtkImageData>::New();
    data->SetDimensions(c->width, c->height, 1);
    data->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
    auto *to = static_cast<uint8_t *>(data->GetScalarPointer());
    const size_t row = size_t(c->width) * 3;
    for (int y = 0; y < c->height; y++)
      std::memcpy(to + size_t(y) * row, c->pixel + size_t(c->height - 1 - y) * row, row);
    auto writer = Ptr<vtkPNGWriter>::New();
    writer->SetInputData(data);
    writer->WriteToMemoryOn();
    writer->Write();
    vtkUnsignedCharArray *bytes = writer->GetResult();
    if (!bytes || bytes->GetNumberOfValues() == 0)
      return ylm_fail(e, YLM_EDEVICE, "%s: the picture cannot be encoded", path);
    return ylm_file_save(path, bytes->GetPointer(0), size_t(bytes->GetNumberOfValues()), e);
  });
}
