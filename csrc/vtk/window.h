// window.h - where VTK draws, and where its messages go. Private to csrc/vtk.
#pragma once

#include "ylm_vtk.h"

#include <vtkRenderWindow.h>
#include <vtkSmartPointer.h>

#include <exception>
#include <memory>
#include <mutex>
#include <new>
#include <string>

class vtkOutputWindow;

namespace ylm {

class MessageWindow;

// VTK's warnings and errors go to a string for as long as this lives. VTK has one window of messages, and other
// state of the process: one thread at a time has a Messages.
class Messages {
public:
  Messages();
  ~Messages();
  Messages(const Messages &) = delete;
  Messages &operator=(const Messages &) = delete;
  const std::string &errors() const;

private:
  std::unique_lock<std::recursive_mutex> only;
  vtkSmartPointer<MessageWindow> window;
  vtkSmartPointer<vtkOutputWindow> before;
};

// The EGL context, or none, that was current before is current again when this goes.
class ContextGuard {
public:
  ContextGuard();
  ~ContextGuard();
  ContextGuard(const ContextGuard &) = delete;
  ContextGuard &operator=(const ContextGuard &) = delete;

private:
  void *display, *draw, *read, *context;
};

// A render window that needs no display; null with the reason in `e`.
vtkSmartPointer<vtkRenderWindow> offscreen_window(int width, int height, ylm_error *e);
// A connection to the X server of DISPLAY; null where there is none. A server without clients may end, or begin anew.
std::shared_ptr<void> hold_display();
// The way offscreen_window would go: "egl", "x", "xvfb", or nullptr.
const char *offscreen_way(ylm_error *e);

// YLM_ERANGE unless sides are 1 .. 32768 pixels and `supersample` is 1 .. 4.
ylm_status check_sides(const char *what, int width, int height, int supersample, ylm_error *e);

// The window's picture, averaged over supersample^2 pixels, top row first.
ylm_status read_pixels(vtkRenderWindow *w, int width, int height, int supersample, uint8_t *rgb,
                       ylm_error *e);

// Path of a font with Greek letters, or nullptr; regular or bold.
const char *font_file(bool bold);

// Runs `body` so that no exception and no message of VTK leaves it.
template <class Body> ylm_status guarded(ylm_error *e, Body body) {
  try {
    Messages messages;
    ylm_status s = body();
    if (s == YLM_OK && !messages.errors().empty())
      return ylm_fail(e, YLM_EDEVICE, "VTK: %s", messages.errors().c_str());
    return s;
  } catch (const std::bad_alloc &) {
    return ylm_fail(e, YLM_ENOMEM, "memory ran out in VTK");
  } catch (const std::exception &x) {
    return ylm_fail(e, YLM_EDEVICE, "VTK: %s", x.what());
  } catch (...) {
    return ylm_fail(e, YLM_EDEVICE, "VTK failed");
  }
}

} // namespace ylm
