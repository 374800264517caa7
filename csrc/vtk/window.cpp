// window.cpp - render windows without a display: EGL surfaceless, an X server, an own Xvfb.
#include "window.h"

#include <vtkAutoInit.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkLogger.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkUnsignedCharArray.h>
#include <vtkVersion.h>
#include <vtk_glew.h>

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <X11/Xlib.h>
#undef Success

#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

VTK_MODULE_INIT(vtkRenderingOpenGL2);
VTK_MODULE_INIT(vtkRenderingFreeType);
VTK_MODULE_INIT(vtkInteractionStyle);
VTK_MODULE_INIT(vtkRenderingVolumeOpenGL2);
VTK_MODULE_INIT(vtkRenderingContextOpenGL2);

extern char **environ;

namespace ylm {

// -- messages -----------------------------------------------------------------

class MessageWindow : public vtkOutputWindow {
public:
  static MessageWindow *New();
  vtkTypeMacro(MessageWindow, vtkOutputWindow);
  void DisplayText(const char *) override {}
  void DisplayWarningText(const char *) override {}
  void DisplayGenericWarningText(const char *) override {}
  void DisplayDebugText(const char *) override {}
  void DisplayErrorText(const char *text) override {
    if (errors.size() < 300) errors += text;
    for (char &c : errors)
      if (c == '\n') c = ' ';
  }
  std::string errors;
};
vtkStandardNewMacro(MessageWindow);

static std::recursive_mutex the_only;

Messages::Messages()
    : only(the_only), window(vtkSmartPointer<MessageWindow>::New()),
      before(vtkOutputWindow::GetInstance()) {
  vtkOutputWindow::SetInstance(window);
  vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
}

Messages::~Messages() { vtkOutputWindow::SetInstance(before); }

const std::string &Messages::errors() const { return window->errors; }

// -- contexts -----------------------------------------------------------------

ContextGuard::ContextGuard()
    : display(eglGetCurrentDisplay()), draw(eglGetCurrentSurface(EGL_DRAW)),
      read(eglGetCurrentSurface(EGL_READ)), context(eglGetCurrentContext()) {}

ContextGuard::~ContextGuard() {
  if (context != EGL_NO_CONTEXT)
    eglMakeCurrent(display, draw, read, context);
  else if (EGLDisplay now = eglGetCurrentDisplay())
    eglMakeCurrent(now, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
}

// An OpenGL 3.2 core context without any surface; VTK draws into its own framebuffers.
struct EglContext {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;

  bool create(ylm_error *e) {
    auto platform = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(
        eglGetProcAddress("eglGetPlatformDisplayEXT"));
    if (platform) display = platform(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (display == EGL_NO_DISPLAY || !eglInitialize(display, nullptr, nullptr)) {
      ylm_fail(e, YLM_EMISSING, "EGL has no surfaceless platform");
      return false;
    }
    EGLenum before = eglQueryAPI();
    const EGLint config_wanted[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
    const EGLint context_wanted[] = {EGL_CONTEXT_MAJOR_VERSION,
                                     3,
                                     EGL_CONTEXT_MINOR_VERSION,
                                     2,
                                     EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                     EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                     EGL_NONE};
    EGLConfig config = nullptr;
    EGLint n = 0;
    if (eglBindAPI(EGL_OPENGL_API)) {
      eglChooseConfig(display, config_wanted, &config, 1, &n);
      context = eglCreateContext(display, n ? config : nullptr, EGL_NO_CONTEXT, context_wanted);
    }
    eglBindAPI(before);
    if (context == EGL_NO_CONTEXT) ylm_fail(e, YLM_EMISSING, "EGL gives no OpenGL 3.2 context");
    return context != EGL_NO_CONTEXT;
  }

  bool make_current() {
    eglBindAPI(EGL_OPENGL_API);
    return eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context);
  }

  void destroy() {
    if (context == EGL_NO_CONTEXT) return;
    if (eglGetCurrentContext() == context)
      eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display, context);
    context = EGL_NO_CONTEXT;
  }
};

class EglWindow : public vtkGenericOpenGLRenderWindow {
public:
  static EglWindow *New();
  vtkTypeMacro(EglWindow, vtkGenericOpenGLRenderWindow);

  bool begin(int width, int height, ylm_error *e) {
    if (!egl.create(e)) return false;
    SetOffScreenRendering(1);
    SetShowWindow(false);
    SetUseOffScreenBuffers(true);
    SetSize(width, height);
    if (!egl.make_current()) return ylm_fail(e, YLM_EDEVICE, "the EGL context is refused"), false;
    OpenGLInit();
    if (!Initialized) ylm_fail(e, YLM_EMISSING, "OpenGL 3.2 is not available");
    return Initialized;
  }
  void MakeCurrent() override { egl.make_current(); }
  bool IsCurrent() override {
    return egl.context != EGL_NO_CONTEXT && eglGetCurrentContext() == egl.context;
  }
  int SupportsOpenGL() override { return 1; }
  vtkTypeBool IsDirect() override { return 1; }
  void Frame() override {}
  void OpenGLInitContext() override {
    ContextCreationTime.Modified();
    if (Initialized) return;
    glewExperimental = GL_TRUE;
    GLenum r = glewInit();
    // GLEW looks for GLX once OpenGL's functions are there; without an X server that fails,
    // rightly.
    GlewInitValid = r == GLEW_OK || r == GLEW_ERROR_NO_GLX_DISPLAY;
    if (!GlewInitValid || !GLEW_VERSION_3_2) return;
    Initialized = true;
    GLfloat range[2] = {1, 1};
    glGetFloatv(GL_ALIASED_LINE_WIDTH_RANGE, range);
    MaximumHardwareLineWidth = range[1];
  }

protected:
  EglWindow() = default;
  ~EglWindow() override {
    if (egl.context == EGL_NO_CONTEXT) return;
    egl.make_current();
    Finalize();
    egl.destroy();
  }
  EglContext egl;
};
vtkStandardNewMacro(EglWindow);

// -- X servers ------------------------------------------------------------------

std::shared_ptr<void> hold_display() {
  const char *name = std::getenv("DISPLAY");
  Display *d = name && *name ? XOpenDisplay(name) : nullptr;
  return std::shared_ptr<void>(d, [](void *p) {
    if (p) XCloseDisplay(static_cast<Display *>(p));
  });
}

static bool has_display() { return hold_display() != nullptr; }

// An Xvfb that lives as long as the object.
class OwnServer {
public:
  ~OwnServer() { stop(); }
  Display *start() {
    int pipes[2];
    if (pipe2(pipes, 0) != 0) return nullptr;
    fcntl(pipes[0], F_SETFD, FD_CLOEXEC);
    std::string fd = std::to_string(pipes[1]);
    const char *words[] = {"Xvfb",     "-displayfd", fd.c_str(), "-screen",  "0",
                           "64x64x24", "-nolisten",  "tcp",      "-noreset", nullptr};
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
    if (posix_spawnp(&child, "Xvfb", &actions, nullptr, const_cast<char **>(words), environ) != 0)
      child = -1;
    posix_spawn_file_actions_destroy(&actions);
    close(pipes[1]);
    const std::string number = read_line(pipes[0]);
    close(pipes[0]);
    // The number may come before the server answers.
    for (int attempt = 0; !number.empty() && attempt < 100; attempt++) {
      if (Display *d = XOpenDisplay((":" + number).c_str())) return d;
      usleep(50000);
    }
    stop();
    return nullptr;
  }
  void stop() {
    if (child <= 0) return;
    kill(child, SIGTERM);
    waitpid(child, nullptr, 0);
    child = -1;
  }

private:
  // The server's answer within ten seconds, up to the end of the line.
  static std::string read_line(int fd) {
    std::string line;
    pollfd wait = {fd, POLLIN, 0};
    char c;
    for (int attempt = 0; attempt < 100; attempt++) {
      if (poll(&wait, 1, 100) <= 0) continue;
      if (read(fd, &c, 1) != 1 || c == '\n') break;
      line += c;
    }
    return line;
  }
  pid_t child = -1;
};

static vtkSmartPointer<vtkRenderWindow> x_window(Display *display, int width, int height) {
  auto w = vtkSmartPointer<vtkRenderWindow>::New();
  if (display) w->SetDisplayId(display);
  w->SetOffScreenRendering(1);
  w->SetShowWindow(false);
  w->SetUseOffScreenBuffers(true);
  w->SetSize(width, height);
  return w;
}

// One server for the process, ended with it: VTK may use its display until then.
static Display *own_display() {
  static OwnServer server;
  static Display *display = server.start();
  return display;
}

static const char *choose_way(ylm_error *e, vtkSmartPointer<EglWindow> *egl, int width,
                              int height) {
  const char *forced = std::getenv("YLM_VTK_WINDOW");
  auto allowed = [forced](const char *way) {
    return !forced || !*forced || std::strcmp(forced, way) == 0;
  };
  if (allowed("egl")) {
    auto w = vtkSmartPointer<EglWindow>::New();
    if (w->begin(width, height, e)) {
      if (egl) *egl = w;
      return "egl";
    }
  }
  if (allowed("x") && has_display()) return "x";
  if (allowed("xvfb") && own_display()) return "xvfb";
  ylm_fail(e, YLM_EMISSING,
           "nothing to draw with: no EGL without a display, no X server and no Xvfb; "
           "install libegl1 and libgl1-mesa-dri, or xvfb");
  return nullptr;
}

const char *offscreen_way(ylm_error *e) { return choose_way(e, nullptr, 16, 16); }

vtkSmartPointer<vtkRenderWindow> offscreen_window(int width, int height, ylm_error *e) {
  vtkSmartPointer<EglWindow> egl;
  const char *way = choose_way(e, &egl, width, height);
  if (!way) return nullptr;
  if (egl) return egl;
  return x_window(std::strcmp(way, "x") == 0 ? nullptr : own_display(), width, height);
}

// -- pixels -----------------------------------------------------------------------

ylm_status check_sides(const char *what, int width, int height, int supersample, ylm_error *e) {
  if (width < 1 || width > 32768 || height < 1 || height > 32768)
    return ylm_fail(e, YLM_ERANGE, "%s of %d x %d pixels: sides are 1 .. 32768", what, width,
                    height);
  if (supersample < 1 || supersample > 4)
    return ylm_fail(e, YLM_ERANGE, "%s: supersample is 1 .. 4, not %d", what, supersample);
  return YLM_OK;
}

ylm_status read_pixels(vtkRenderWindow *w, int width, int height, int supersample, uint8_t *rgb,
                       ylm_error *e) {
  auto pixels = vtkSmartPointer<vtkUnsignedCharArray>::New();
  const int k = supersample, W = width * k, H = height * k;
  if (w->GetPixelData(0, 0, W - 1, H - 1, 0, pixels) != VTK_OK ||
      pixels->GetNumberOfValues() != vtkIdType(W) * H * 3)
    return ylm_fail(e, YLM_EDEVICE, "the picture could not be read back");
  const unsigned char *from = pixels->GetPointer(0);
  for (int y = 0; y < height; y++)
    for (int x = 0; x < width; x++)
      for (int c = 0; c < 3; c++) {
        int sum = 0;
        for (int j = 0; j < k; j++)
          for (int i = 0; i < k; i++)
            sum +=
                from[(size_t(H - 1 - (y * k + j)) * size_t(W) + size_t(x * k + i)) * 3 + size_t(c)];
        rgb[(size_t(y) * size_t(width) + size_t(x)) * 3 + size_t(c)] =
            uint8_t((sum + k * k / 2) / (k * k));
      }
  return YLM_OK;
}

const char *font_file(bool bold) {
  static const char *const folders[] = {"/usr/share/fonts/truetype/dejavu/",
                                        "/usr/share/fonts/dejavu/", "/usr/share/fonts/TTF/",
                                        "/usr/share/fonts/dejavu-sans-fonts/"};
  static const std::string found[2] = {[] {
                                         for (const char *f : folders) {
                                           std::string path = std::string(f) + "DejaVuSans.ttf";
                                           if (access(path.c_str(), R_OK) == 0) return path;
                                         }
                                         return std::string();
                                       }(),
                                       [] {
                                         for (const char *f : folders) {
                                           std::string path =
                                               std::string(f) + "DejaVuSans-Bold.ttf";
                                           if (access(path.c_str(), R_OK) == 0) return path;
                                         }
                                         return std::string();
                                       }()};
  const std::string &path = found[bold ? 1 : 0];
  return path.empty() ? nullptr : path.c_str();
}

} // namespace ylm

extern "C" const char *ylm_vtk_version(void) { return vtkVersion::GetVTKVersion(); }

extern "C" ylm_status ylm_vtk_where(const char **name, ylm_error *e) {
  return ylm::guarded(e, [&] {
    ylm::ContextGuard guard;
    *name = ylm::offscreen_way(e);
    return *name ? YLM_OK : YLM_EMISSING;
  });
}
