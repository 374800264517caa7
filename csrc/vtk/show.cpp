// show.cpp - a window to look around in, where there is a display.
#include "scene.h"

#include <vtkActor2D.h>
#include <vtkCallbackCommand.h>
#include <vtkCellPicker.h>
#include <vtkImageData.h>
#include <vtkImageMapper.h>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkPlaneSource.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkProperty2D.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkTexture.h>
#include <vtkTexturedActor2D.h>

#include <cstring>

using ylm::guarded;
template <class T> using Ptr = vtkSmartPointer<T>;

// State for key presses.
struct Picking {
  vtkRenderer *renderer;
  vtkTextActor *words;
  ylm_vtk_pick *pick;
  void *user;
};

static void on_key(vtkObject *caller, unsigned long, void *data, void *) {
  auto *interactor = static_cast<vtkRenderWindowInteractor *>(caller);
  auto *p = static_cast<Picking *>(data);
  if (!p->pick || interactor->GetKeyCode() != 'p') return;
  int at[2];
  interactor->GetEventPosition(at);
  auto picker = Ptr<vtkCellPicker>::New();
  picker->SetTolerance(0.001);
  if (!picker->Pick(at[0], at[1], 0, p->renderer)) return;
  const char *text = p->pick(p->user, picker->GetPickPosition());
  p->words->SetInput(text ? text : "");
  interactor->Render();
}

// Titles and bars, drawn over the scene; they stay at the window's upper left.
static Ptr<vtkActor2D> overlay_actor(const uint8_t *rgba, int width, int height) {
  auto picture = Ptr<vtkImageData>::New();
  picture->SetDimensions(width, height, 1);
  picture->AllocateScalars(VTK_UNSIGNED_CHAR, 4);
  auto *to = static_cast<uint8_t *>(picture->GetScalarPointer());
  const size_t row = size_t(width) * 4;
  for (int y = 0; y < height; y++)
    std::memcpy(to + size_t(y) * row, rgba + size_t(height - 1 - y) * row, row);
  auto plane = Ptr<vtkPlaneSource>::New();
  plane->SetOrigin(0, 0, 0);
  plane->SetPoint1(width, 0, 0);
  plane->SetPoint2(0, height, 0);
  auto texture = Ptr<vtkTexture>::New();
  texture->SetInputData(picture);
  auto mapper = Ptr<vtkPolyDataMapper2D>::New();
  mapper->SetInputConnection(plane->GetOutputPort());
  auto actor = Ptr<vtkTexturedActor2D>::New();
  actor->SetMapper(mapper);
  actor->SetTexture(texture);
  return actor;
}

extern "C" ylm_status ylm_vtk_show(ylm_vtk_scene *s, int width, int height,
                                   const double background[3], const uint8_t *overlay,
                                   const char *title, ylm_vtk_pick *pick, void *user,
                                   ylm_error *e) {
  return guarded(e, [&] {
    const auto display = ylm::hold_display();
    if (!display)
      return ylm_fail(e, YLM_EMISSING,
                      "no display to open a window on (DISPLAY); save the picture instead");
    ylm::ContextGuard guard;
    auto window = Ptr<vtkRenderWindow>::New();
    window->SetSize(width, height);
    window->SetMultiSamples(s->peel ? 0 : 4);
    window->SetWindowName(title);
    s->prepare(background, 1);
    window->AddRenderer(s->renderer);
    auto words = Ptr<vtkTextActor>::New();
    words->SetPosition(12, 12);
    if (const char *font = ylm::font_file(false)) {
      words->GetTextProperty()->SetFontFamily(VTK_FONT_FILE);
      words->GetTextProperty()->SetFontFile(font);
    }
    const double grey = background[0] + background[1] + background[2] > 1.5 ? 0.1 : 0.9;
    words->GetTextProperty()->SetColor(grey, grey, grey);
    words->GetTextProperty()->SetFontSize(13);
    words->SetInput(
        pick ? "drag: turn   wheel: nearer   shift+drag: move   p: what is here   q: close" : "");
    Ptr<vtkActor2D> over;
    if (overlay) s->renderer->AddActor2D(over = overlay_actor(overlay, width, height));
    s->renderer->AddActor2D(words);
    auto interactor = Ptr<vtkRenderWindowInteractor>::New();
    interactor->SetRenderWindow(window);
    interactor->SetInteractorStyle(Ptr<vtkInteractorStyleTrackballCamera>::New());
    Picking picking = {s->renderer, words, pick, user};
    auto command = Ptr<vtkCallbackCommand>::New();
    command->SetCallback(on_key);
    command->SetClientData(&picking);
    interactor->AddObserver(vtkCommand::CharEvent, command, 1);
    window->Render();
    interactor->Start();
    s->renderer->RemoveActor2D(words);
    if (over) s->renderer->RemoveActor2D(over);
    window->RemoveRenderer(s->renderer);
    window->Finalize();
    return YLM_OK;
  });
}
