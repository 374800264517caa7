// picture.cpp - a float picture with depth as a prop.
#include "picture.h"

#include <vtkCamera.h>
#include <vtkObjectFactory.h>
#include <vtkOpenGLQuadHelper.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkOpenGLShaderCache.h>
#include <vtkOpenGLState.h>
#include <vtkRenderer.h>
#include <vtkShaderProgram.h>
#include <vtkTextureObject.h>
#include <vtk_glew.h>

#include <cmath>
#include <limits>

namespace ylm {

vtkStandardNewMacro(Picture);

// Row 0 of a picture is the top. Depth is that of the camera whose clipping range is `near`, `far`.
static const char *const fragment = R"(//VTK::System::Dec
in vec2 texCoord;
uniform sampler2D colours;
uniform sampler2D depths;
uniform sampler2D tones;
uniform int bytes;
uniform float first;
uniform float last;
uniform float entries;
uniform float nearest;
uniform float farthest;
//VTK::Output::Dec

float tone(float x) {
  if (!(x > 0.0)) return 0.0;
  float place = (log2(min(x, 3.0e38)) - first) / (last - first);
  if (place < 0.0) return texture(tones, vec2(0.5 / entries, 0.5)).r * x * exp2(-first);
  return texture(tones, vec2((0.5 + min(place, 1.0) * (entries - 1.0)) / entries, 0.5)).r;
}

void main() {
  vec2 at = vec2(texCoord.x, 1.0 - texCoord.y);
  vec3 c = texture(colours, at).rgb;
  if (bytes == 0) {
    c = vec3(tone(c.r), tone(c.g), tone(c.b));
    float z = clamp(texture(depths, at).r, nearest, farthest);
    gl_FragDepth = farthest * (z - nearest) / (z * (farthest - nearest));
  } else gl_FragDepth = 0.0;
  gl_FragData[0] = vec4(c, 1.0);
}
)";

Picture::Picture() { set_tone(2, std::vector<float>{0, 1}.data(), 0, 1); }
Picture::~Picture() = default;

void Picture::set_radiance(int w, int h, const float *rgb_, const float *depth_) {
  const size_t n = size_t(w) * size_t(h);
  bytes = false;
  rgb.assign(rgb_, rgb_ + 3 * n);
  colour.w = w, colour.h = h, colour.fresh = true;
  if (depth_) {
    depth.assign(depth_, depth_ + n);
    range.w = w, range.h = h, range.fresh = true;
  } else if (!range.w) {
    depth.assign(1, std::numeric_limits<float>::infinity());
    range.w = range.h = 1, range.fresh = true;
  }
}

void Picture::set_bytes(int w, int h, const uint8_t *rgb_) {
  bytes = true;
  rgb8.assign(rgb_, rgb_ + size_t(w) * size_t(h) * 3);
  colour.w = w, colour.h = h, colour.fresh = true;
  if (!range.w) {
    depth.assign(1, 0);
    range.w = range.h = 1, range.fresh = true;
  }
}

void Picture::set_tone(size_t n, const float *table_, double first_, double last_) {
  tone.assign(table_, table_ + n);
  first = first_, last = last_;
  table.w = int(n), table.h = 1, table.fresh = true;
}

bool Picture::upload(vtkRenderWindow *window) {
  auto *w = vtkOpenGLRenderWindow::SafeDownCast(window);
  auto fill = [&](Layer &layer, int components, int type, void *data, int filter) {
    if (!layer.fresh && layer.texture) return true;
    if (!layer.texture) layer.texture = vtkSmartPointer<vtkTextureObject>::New();
    layer.texture->SetContext(w);
    layer.texture->SetWrapS(vtkTextureObject::ClampToEdge);
    layer.texture->SetWrapT(vtkTextureObject::ClampToEdge);
    layer.texture->SetMinificationFilter(filter);
    layer.texture->SetMagnificationFilter(filter);
    layer.fresh = false;
    return layer.texture->Create2DFromRaw(unsigned(layer.w), unsigned(layer.h), components, type,
                                          data);
  };
  const int sharp = vtkTextureObject::Nearest, smooth = vtkTextureObject::Linear;
  return fill(colour, 3, bytes ? VTK_UNSIGNED_CHAR : VTK_FLOAT,
              bytes ? static_cast<void *>(rgb8.data()) : rgb.data(), bytes ? sharp : smooth) &&
         fill(range, 1, VTK_FLOAT, depth.data(), sharp) &&
         fill(table, 1, VTK_FLOAT, tone.data(), smooth);
}

void Picture::draw(vtkViewport *viewport) {
  auto *renderer = static_cast<vtkRenderer *>(viewport);
  auto *window = vtkOpenGLRenderWindow::SafeDownCast(renderer->GetRenderWindow());
  if (!colour.w || !window || !upload(window)) return;
  if (!quad) quad.reset(new vtkOpenGLQuadHelper(window, nullptr, fragment, ""));
  window->GetShaderCache()->ReadyShaderProgram(quad->Program);
  vtkShaderProgram *p = quad->Program;
  if (!p || !p->GetCompiled()) return;
  vtkOpenGLState *state = window->GetState();
  vtkOpenGLState::ScopedglDepthFunc func(state);
  vtkOpenGLState::ScopedglDepthMask mask(state);
  vtkOpenGLState::ScopedglEnableDisable blend(state, GL_BLEND), test(state, GL_DEPTH_TEST);
  state->vtkglEnable(GL_DEPTH_TEST);
  state->vtkglDepthFunc(GL_ALWAYS);
  state->vtkglDepthMask(GL_TRUE);
  state->vtkglDisable(GL_BLEND);
  double clip[2];
  renderer->GetActiveCamera()->GetClippingRange(clip);
  for (Layer *layer : {&colour, &range, &table}) layer->texture->Activate();
  p->SetUniformi("colours", colour.texture->GetTextureUnit());
  p->SetUniformi("depths", range.texture->GetTextureUnit());
  p->SetUniformi("tones", table.texture->GetTextureUnit());
  p->SetUniformi("bytes", bytes);
  p->SetUniformf("first", float(first));
  p->SetUniformf("last", float(last));
  p->SetUniformf("entries", float(table.w));
  p->SetUniformf("nearest", float(clip[0]));
  p->SetUniformf("farthest", float(clip[1]));
  quad->Render();
  for (Layer *layer : {&colour, &range, &table}) layer->texture->Deactivate();
}

int Picture::RenderOpaqueGeometry(vtkViewport *viewport) {
  if (bytes) return 0;
  draw(viewport);
  return 1;
}

int Picture::RenderOverlay(vtkViewport *viewport) {
  if (!bytes) return 0;
  draw(viewport);
  return 1;
}

void Picture::ReleaseGraphicsResources(vtkWindow *window) {
  quad.reset();
  for (Layer *layer : {&colour, &range, &table}) {
    if (layer->texture) layer->texture->ReleaseGraphicsResources(window);
    layer->texture = nullptr;
    layer->fresh = true;
  }
  vtkProp::ReleaseGraphicsResources(window);
}

} // namespace ylm
