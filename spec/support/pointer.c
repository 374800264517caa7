/* pointer.c - a hand for windows: reads commands, makes events on the X server of DISPLAY. For spec/live_display_spec.lua.

   wait                   until a window is there, 30 s at most
   move X Y               pointer to a place of the window
   down N, up N           buttons: 1 left, 2 middle, 3 right, 4 and 5 the wheel
   key NAME               presses and releases
   drag X0 Y0 X1 Y1 N MS  presses, makes N moves in MS milliseconds, lets go
   resize W H             of the window
   close                  as the window's button does
   sleep MS

   libXtst is opened at run time: its header need not be there. Status 2: it is missing, 3: there is no window. */
#include <X11/XKBlib.h>
#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <X11/keysym.h>
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef int motion_fn(Display *, int, int, int, unsigned long);
typedef int press_fn(Display *, unsigned, int, unsigned long);

static Display *display;
static Window window;
static motion_fn *fake_motion;
static press_fn *fake_button, *fake_key;

static int ignore(Display *d, XErrorEvent *e) {
  (void)d;
  (void)e;
  return 0;
}

/* The window that answers the close button, at or below `w`. */
static Window find(Window w) {
  Window root, parent, *child = NULL, found = 0;
  unsigned n = 0;
  Atom *protocol;
  int protocols;
  if (XGetWMProtocols(display, w, &protocol, &protocols)) {
    XFree(protocol);
    if (protocols > 0) return w;
  }
  if (!XQueryTree(display, w, &root, &parent, &child, &n)) return 0;
  for (unsigned i = 0; i < n && !found; i++) found = find(child[i]);
  if (child) XFree(child);
  return found;
}

static int wait_for_window(void) {
  for (int i = 0; i < 600 && !(window = find(DefaultRootWindow(display))); i++) usleep(50000);
  return window ? 0 : 3;
}

static void place(int x, int y) {
  int rx = x, ry = y;
  Window child;
  if (window)
    XTranslateCoordinates(display, window, DefaultRootWindow(display), x, y, &rx, &ry, &child);
  fake_motion(display, -1, rx, ry, 0);
  XFlush(display);
}

static void button(unsigned b, int down) {
  fake_button(display, b, down, 0);
  XFlush(display);
}

static void key(const char *name) {
  KeySym symbol = XStringToKeysym(name);
  KeyCode code = XKeysymToKeycode(display, symbol);
  int shift = code && XkbKeycodeToKeysym(display, code, 0, 0) != symbol;
  KeyCode shifted = XKeysymToKeycode(display, XK_Shift_L);
  if (shift) fake_key(display, shifted, True, 0);
  fake_key(display, code, True, 0);
  fake_key(display, code, False, 0);
  if (shift) fake_key(display, shifted, False, 0);
  XFlush(display);
}

static void drag(int x0, int y0, int x1, int y1, int n, int ms) {
  place(x0, y0);
  usleep(100000);
  button(1, True);
  for (int i = 1; i <= n; i++) {
    usleep((useconds_t)(1000.0 * ms / n));
    place(x0 + (x1 - x0) * i / n, y0 + (y1 - y0) * i / n);
  }
  button(1, False);
}

static void close_window(void) {
  XEvent e;
  memset(&e, 0, sizeof e);
  e.xclient.type = ClientMessage;
  e.xclient.window = window;
  e.xclient.message_type = XInternAtom(display, "WM_PROTOCOLS", False);
  e.xclient.format = 32;
  e.xclient.data.l[0] = (long)XInternAtom(display, "WM_DELETE_WINDOW", False);
  XSendEvent(display, window, False, NoEventMask, &e);
  XFlush(display);
}

static int obey(const char *line) {
  char word[16] = "", name[64] = "";
  int a[6] = {0};
  sscanf(line, "%15s %d %d %d %d %d %d", word, a, a + 1, a + 2, a + 3, a + 4, a + 5);
  if (!strcmp(word, "wait")) return wait_for_window();
  if (!strcmp(word, "move")) place(a[0], a[1]);
  if (!strcmp(word, "down")) button((unsigned)a[0], True);
  if (!strcmp(word, "up")) button((unsigned)a[0], False);
  if (!strcmp(word, "key") && sscanf(line, "%*s %63s", name) == 1) key(name);
  if (!strcmp(word, "drag")) drag(a[0], a[1], a[2], a[3], a[4], a[5]);
  if (!strcmp(word, "resize"))
    XResizeWindow(display, window, (unsigned)a[0], (unsigned)a[1]), XFlush(display);
  if (!strcmp(word, "close")) close_window();
  if (!strcmp(word, "sleep")) usleep((useconds_t)a[0] * 1000);
  return 0;
}

int main(void) {
  void *library = dlopen("libXtst.so.6", RTLD_NOW);
  if (!library) return 2;
  *(void **)&fake_motion = dlsym(library, "XTestFakeMotionEvent");
  *(void **)&fake_button = dlsym(library, "XTestFakeButtonEvent");
  *(void **)&fake_key = dlsym(library, "XTestFakeKeyEvent");
  display = XOpenDisplay(NULL);
  if (!display) return 1;
  XSetErrorHandler(ignore);
  char line[200];
  int status = 0;
  while (!status && fgets(line, sizeof line, stdin)) status = obey(line);
  XCloseDisplay(display);
  return status;
}
