// live.cpp - a window that answers: a float picture, shapes in it, events that are polled.
#include "picture.h"
#include "scene.h"

#include <vtkCamera.h>
#include <vtkLight.h>
#include <vtkLightCollection.h>
#include <vtkPropCollection.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>

#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <X11/keysym.h>
#undef Success

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <deque>
#include <dlfcn.h>
#include <poll.h>

using ylm::guarded;
template <class T> using Ptr = vtkSmartPointer<T>;

enum { MOST_EVENTS = 4096 }; // that wait; later ones are dropped, but for CLOSE

struct ylm_vtk_live {
  int size[2];
  Ptr<vtkRenderWindow> window;
  Ptr<vtkRenderer> seen, over; // the picture with shapes, the panel
  Ptr<ylm::Picture> picture, panel;
  std::vector<Ptr<vtkProp>> shapes;
  double range[2] = {0.01, 1000};
  bool with_panel = false;
  std::deque<ylm_vtk_event> queue;
  // Of a window on a display:
  Display *display = nullptr;
  Window id = 0;
  Atom close = 0, protocols = 0;
  bool gone = false;  // the display
  bool stale = false; // the window shows less than it should
};

static std::atomic<bool> is_open; // a window of this process

// -- events ---------------------------------------------------------------------------------------

static void push(ylm_vtk_live *l, const ylm_vtk_event &event) {
  const bool folds = event.kind == YLM_VTK_MOVE || event.kind == YLM_VTK_RESIZE;
  if (folds && !l->queue.empty() && l->queue.back().kind == event.kind)
    l->queue.back() = event;
  else if (l->queue.size() < MOST_EVENTS || event.kind == YLM_VTK_CLOSE)
    l->queue.push_back(event);
}

static ylm_vtk_event event_at(ylm_vtk_event_kind kind, int x, int y, unsigned state) {
  ylm_vtk_event event = {};
  event.kind = kind, event.x = x, event.y = y;
  event.shift = (state & ShiftMask) != 0, event.control = (state & ControlMask) != 0;
  return event;
}

// X's name of a key; keys of the number block are those of the others.
static const char *name_of(KeySym symbol) {
  switch (symbol) {
  case XK_Prior:
  case XK_KP_Prior: return "Page_Up";
  case XK_Next:
  case XK_KP_Next: return "Page_Down";
  case XK_ISO_Left_Tab: return "Tab";
  case XK_KP_Add: return "plus";
  case XK_KP_Subtract: return "minus";
  case XK_KP_Enter: return "Return";
  case XK_KP_Delete: return "Delete";
  default: return XKeysymToString(symbol);
  }
}

static void take_key(ylm_vtk_live *l, XKeyEvent *key) {
  char letters[16];
  KeySym symbol = NoSymbol;
  XLookupString(key, letters, sizeof letters, &symbol, nullptr);
  const char *name = symbol == NoSymbol || IsModifierKey(symbol) ? nullptr : name_of(symbol);
  if (!name) return;
  ylm_vtk_event event = event_at(YLM_VTK_KEY, key->x, key->y, key->state);
  std::strncpy(event.key, name, sizeof event.key - 1);
  push(l, event);
}

static void take_button(ylm_vtk_live *l, const XButtonEvent &b, bool pressed) {
  if (b.button == Button4 || b.button == Button5) {
    ylm_vtk_event event = event_at(YLM_VTK_WHEEL, b.x, b.y, b.state);
    event.button = b.button == Button4 ? 1 : -1;
    if (pressed) push(l, event);
  } else if (b.button >= Button1 && b.button <= Button3) {
    ylm_vtk_event event = event_at(pressed ? YLM_VTK_PRESS : YLM_VTK_RELEASE, b.x, b.y, b.state);
    event.button = int(b.button);
    push(l, event);
  }
}

static void take_size(ylm_vtk_live *l, int width, int height) {
  if (width == l->size[0] && height == l->size[1]) return;
  l->size[0] = width, l->size[1] = height;
  ylm_vtk_event event = event_at(YLM_VTK_RESIZE, width, height, 0);
  push(l, event);
}

// All that the server has sent, as events.
static void drain(ylm_vtk_live *l) {
  if (!l->display || l->gone) return;
  while (!l->gone && XPending(l->display) > 0) {
    XEvent x;
    ylm_vtk_event event;
    XNextEvent(l->display, &x);
    if (l->gone || x.xany.window != l->id) continue;
    switch (x.type) {
    case MotionNotify:
      event = event_at(YLM_VTK_MOVE, x.xmotion.x, x.xmotion.y, x.xmotion.state);
      event.time = uint32_t(x.xmotion.time);
      push(l, event);
      break;
    case ButtonPress: take_button(l, x.xbutton, true); break;
    case ButtonRelease: take_button(l, x.xbutton, false); break;
    case KeyPress: take_key(l, &x.xkey); break;
    case ConfigureNotify: take_size(l, x.xconfigure.width, x.xconfigure.height); break;
    case Expose: l->stale = true; break;
    case DestroyNotify: push(l, event_at(YLM_VTK_CLOSE, 0, 0, 0)); break;
    case ClientMessage:
      if (x.xclient.message_type == l->protocols && Atom(x.xclient.data.l[0]) == l->close)
        push(l, event_at(YLM_VTK_CLOSE, 0, 0, 0));
      break;
    default: break;
    }
  }
}

// -- the display ----------------------------------------------------------------------------------

// Instead of exit(): nothing of the display, nor of VTK's window on it, is used any more.
static void on_lost(Display *, void *user) { static_cast<ylm_vtk_live *>(user)->gone = true; }
static int on_io_error(Display *) { return 0; }
// A window that goes between a request and its answer is no reason to end the process.
static int on_error(Display *, XErrorEvent *) { return 0; }

static ylm_status lost(ylm_error *e) { return ylm_fail(e, YLM_EDEVICE, "the display has gone"); }

static ylm_status open_display(ylm_vtk_live *l, const char *title, ylm_error *e) {
  const char *name = std::getenv("DISPLAY");
  l->display = name && *name ? XOpenDisplay(name) : nullptr;
  if (!l->display)
    return ylm_fail(e, YLM_EMISSING,
                    "no display to open a window on (DISPLAY); a replay needs none (hidden)");
  using Handler = void(Display *, void (*)(Display *, void *), void *);
  if (auto set = reinterpret_cast<Handler *>(dlsym(RTLD_DEFAULT, "XSetIOErrorExitHandler"))) {
    set(l->display, on_lost, l);
    XSetIOErrorHandler(on_io_error);
  }
  l->window = Ptr<vtkRenderWindow>::New();
  l->window->SetDisplayId(l->display);
  l->window->SetWindowName(title);
  l->window->SetSize(l->size);
  l->window->SetMultiSamples(0);
  return YLM_OK;
}

// Asks the server for events; after the first picture, which makes the window.
static ylm_status listen(ylm_vtk_live *l, ylm_error *e) {
  l->id = Window(reinterpret_cast<uintptr_t>(l->window->GetGenericWindowId()));
  if (!l->id || !l->window->SupportsOpenGL())
    return ylm_fail(e, YLM_EMISSING, "the display has no OpenGL 3.2");
  XSetErrorHandler(on_error);
  XSelectInput(l->display, l->id,
               KeyPressMask | ButtonPressMask | ButtonReleaseMask | PointerMotionMask |
                   StructureNotifyMask | ExposureMask);
  l->protocols = XInternAtom(l->display, "WM_PROTOCOLS", False);
  l->close = XInternAtom(l->display, "WM_DELETE_WINDOW", False);
  XSetWMProtocols(l->display, l->id, &l->close, 1);
  XFlush(l->display);
  return YLM_OK;
}

// -- interface ------------------------------------------------------------------------------------

static Ptr<vtkRenderer> renderer_with(vtkProp *prop, int layer) {
  auto r = Ptr<vtkRenderer>::New();
  r->SetLayer(layer);
  r->SetAutomaticLightCreation(false);
  r->SetTwoSidedLighting(true);
  r->SetBackground(0, 0, 0);
  r->InteractiveOff();
  r->GetActiveCamera()->SetClippingRange(0.01, 1000);
  r->AddViewProp(prop);
  return r;
}

static void render(ylm_vtk_live *l) {
  l->seen->GetActiveCamera()->SetClippingRange(l->range);
  l->window->Render();
  l->window->WaitForCompletion();
  l->stale = false;
}

static ylm_status open_window(ylm_vtk_live *l, const char *title, bool hidden, ylm_error *e) {
  ylm_status s = YLM_OK;
  if (hidden) {
    l->window = ylm::offscreen_window(l->size[0], l->size[1], e);
    if (!l->window) return YLM_EMISSING;
    l->window->SetMultiSamples(0);
  } else
    s = open_display(l, title, e);
  if (s != YLM_OK) return s;
  l->picture = Ptr<ylm::Picture>::New();
  l->panel = Ptr<ylm::Picture>::New();
  l->seen = renderer_with(l->picture, 0);
  l->over = renderer_with(l->panel, 1);
  l->over->SetDraw(false);
  l->window->SetNumberOfLayers(2);
  l->window->AddRenderer(l->seen);
  l->window->AddRenderer(l->over);
  render(l);
  return hidden ? YLM_OK : listen(l, e);
}

// Everything that VTK holds on the device goes while its context is there.
static void close_window(ylm_vtk_live *l) {
  if (l->gone) { // what is left is left: a call on a display that has gone may not return
    l->window->Register(nullptr);
    l->seen->Register(nullptr);
    l->over->Register(nullptr);
    l->picture->Register(nullptr);
    l->panel->Register(nullptr);
    for (auto &p : l->shapes) p->Register(nullptr);
    return;
  }
  if (l->window) {
    for (auto &r : {l->seen, l->over}) {
      if (!r) continue;
      r->RemoveAllViewProps();
      l->window->RemoveRenderer(r);
    }
    l->shapes.clear();
    l->window->Finalize();
    if (l->display) l->window->SetDisplayId(nullptr);
  }
  l->seen = l->over = nullptr;
  l->picture = l->panel = nullptr;
  l->window = nullptr;
  if (l->display) XCloseDisplay(l->display);
}

extern "C" void ylm_vtk_live_close(ylm_vtk_live *l) {
  if (!l) return;
  ylm_error e;
  guarded(&e, [&] {
    ylm::ContextGuard guard;
    close_window(l);
    delete l;
    return YLM_OK;
  });
  is_open = false;
}

static bool is_side(int n) { return n >= 1 && n <= 8192; }

extern "C" ylm_status ylm_vtk_live_open(int width, int height, const char *title, bool hidden,
                                        ylm_vtk_live **live, ylm_error *e) {
  *live = nullptr;
  if (!is_side(width) || !is_side(height))
    return ylm_fail(e, YLM_ERANGE, "a window of %d x %d pixels: sides are 1 .. 8192", width,
                    height);
  if (is_open.exchange(true))
    return ylm_fail(e, YLM_EBUSY, "one live window at a time: another one is open");
  ylm_vtk_live *l = nullptr;
  ylm_status s = guarded(e, [&] {
    ylm::ContextGuard guard;
    l = new ylm_vtk_live;
    l->size[0] = width, l->size[1] = height;
    return open_window(l, title, hidden, e);
  });
  if (s == YLM_OK && l->gone) s = lost(e);
  if (s == YLM_OK)
    *live = l;
  else if (l)
    ylm_vtk_live_close(l);
  else
    is_open = false;
  return s;
}

// A server on this machine counts the milliseconds of its monotonic clock.
static double age_of(const ylm_vtk_event &event) {
  const uint32_t passed = uint32_t(uint64_t(ylm_seconds() * 1e3)) - event.time;
  return event.time && passed < 10000 ? passed * 1e-3 : -1;
}

extern "C" ylm_status ylm_vtk_live_poll(ylm_vtk_live *l, double seconds, size_t room,
                                        ylm_vtk_event *event, size_t *n, ylm_error *e) {
  *n = 0;
  return guarded(e, [&] {
    drain(l);
    if (l->queue.empty() && l->display && !l->gone && seconds > 0) {
      pollfd wait = {ConnectionNumber(l->display), POLLIN, 0};
      ::poll(&wait, 1, int(std::min(seconds, 60.0) * 1e3 + 0.5));
      drain(l);
    }
    if (l->stale && !l->gone) {
      ylm::ContextGuard guard;
      render(l);
    }
    if (l->gone) return lost(e);
    for (; *n < room && !l->queue.empty(); l->queue.pop_front()) {
      event[*n] = l->queue.front();
      event[*n].age = age_of(event[*n]);
      ++*n;
    }
    return YLM_OK;
  });
}

extern "C" ylm_status ylm_vtk_live_waiting(ylm_vtk_live *l, bool *some, ylm_error *e) {
  return guarded(e, [&] {
    drain(l);
    *some = !l->queue.empty() || l->gone;
    return YLM_OK;
  });
}

extern "C" void ylm_vtk_live_size(const ylm_vtk_live *l, int size[2]) {
  size[0] = l->size[0], size[1] = l->size[1];
}

extern "C" ylm_status ylm_vtk_live_resize(ylm_vtk_live *l, int width, int height, ylm_error *e) {
  if (!is_side(width) || !is_side(height))
    return ylm_fail(e, YLM_ERANGE, "a window of %d x %d pixels: sides are 1 .. 8192", width,
                    height);
  return guarded(e, [&] {
    if (!l->display) l->size[0] = width, l->size[1] = height;
    return YLM_OK;
  });
}

// The part of the window that a rectangle of pixels covers, rows from the top.
static void place(ylm_vtk_live *l, vtkRenderer *r, double x, double y, double w, double h) {
  const double W = l->size[0], H = l->size[1];
  auto within = [](double v) { return std::min(1.0, std::max(0.0, v)); };
  r->SetViewport(within(x / W), within(1 - (y + h) / H), within((x + w) / W), within(1 - y / H));
}

extern "C" ylm_status ylm_vtk_live_picture(ylm_vtk_live *l, int w, int h, const float *rgb,
                                           const float *depth, const int rectangle[4],
                                           ylm_error *e) {
  if (!is_side(w) || !is_side(h) || rectangle[2] < 1 || rectangle[3] < 1)
    return ylm_fail(e, YLM_ERANGE, "a picture of %d x %d pixels: sides are 1 .. 8192", w, h);
  return guarded(e, [&] {
    l->picture->set_radiance(w, h, rgb, depth);
    place(l, l->seen, rectangle[0], rectangle[1], rectangle[2], rectangle[3]);
    return YLM_OK;
  });
}

extern "C" ylm_status ylm_vtk_live_tone(ylm_vtk_live *l, size_t n, const float *table, double first,
                                        double last, ylm_error *e) {
  if (n < 2 || n > 8192 || !(first < last))
    return ylm_fail(e, YLM_ERANGE, "a tone table has 2 .. 8192 entries from first < last");
  return guarded(e, [&] {
    l->picture->set_tone(n, table, first, last);
    return YLM_OK;
  });
}

extern "C" ylm_status ylm_vtk_live_overlay(ylm_vtk_live *l, ylm_vtk_scene *scene, double nearest,
                                           double farthest, ylm_error *e) {
  if (!(nearest > 0 && farthest > nearest))
    return ylm_fail(e, YLM_ERANGE, "an overlay's depth: 0 < nearest < farthest");
  if (l->gone) return lost(e);
  return guarded(e, [&] {
    ylm::ContextGuard guard;
    for (auto &p : l->shapes) l->seen->RemoveViewProp(p);
    l->shapes.clear();
    l->seen->RemoveAllLights();
    l->range[0] = nearest, l->range[1] = farthest;
    if (!scene) return YLM_OK;
    const double black[3] = {0, 0, 0};
    scene->prepare(black, 1);
    vtkCamera *from = scene->renderer->GetActiveCamera(), *to = l->seen->GetActiveCamera();
    to->SetPosition(from->GetPosition());
    to->SetFocalPoint(from->GetFocalPoint());
    to->SetViewUp(from->GetViewUp());
    to->SetViewAngle(from->GetViewAngle());
    vtkCollectionSimpleIterator at;
    vtkLightCollection *lights = scene->renderer->GetLights();
    lights->InitTraversal(at);
    while (vtkLight *light = lights->GetNextLight(at)) l->seen->AddLight(light);
    vtkPropCollection *props = scene->renderer->GetViewProps();
    props->InitTraversal(at);
    while (vtkProp *p = props->GetNextProp(at)) {
      l->seen->AddViewProp(p);
      l->shapes.push_back(p);
    }
    return YLM_OK;
  });
}

extern "C" ylm_status ylm_vtk_live_panel(ylm_vtk_live *l, int x, int y, int w, int h,
                                         const uint8_t *rgb, ylm_error *e) {
  if (rgb && (!is_side(w) || !is_side(h)))
    return ylm_fail(e, YLM_ERANGE, "a panel of %d x %d pixels: sides are 1 .. 8192", w, h);
  return guarded(e, [&] {
    l->over->SetDraw(rgb != nullptr);
    if (!rgb) return YLM_OK;
    l->panel->set_bytes(w, h, rgb);
    place(l, l->over, x, y, w, h);
    return YLM_OK;
  });
}

extern "C" ylm_status ylm_vtk_live_show(ylm_vtk_live *l, ylm_error *e) {
  if (l->gone) return lost(e);
  return guarded(e, [&] {
    ylm::ContextGuard guard;
    const int *now = l->window->GetSize();
    if (now[0] != l->size[0] || now[1] != l->size[1]) l->window->SetSize(l->size);
    render(l);
    return l->gone ? lost(e) : YLM_OK;
  });
}

extern "C" ylm_status ylm_vtk_live_read(ylm_vtk_live *l, uint8_t *rgb, ylm_error *e) {
  if (l->gone) return lost(e);
  return guarded(e, [&] {
    ylm::ContextGuard guard;
    return ylm::read_pixels(l->window, l->size[0], l->size[1], 1, rgb, e);
  });
}
