/*
** ylm_vtk.h - pictures drawn by VTK, as a C library.
**
** A scene is filled with shapes and volumes (csrc/figure) and seen by a camera. Pixels are rendered without any display; a
** window shows it where there is a display. Charts and texts are rendered to pixels too. VTK's own messages become
** ylm_error; no exception leaves this library, and no OpenGL context is left current.
**
** Where it draws, tried in this order: EGL without a surface (Mesa), the X server of DISPLAY,
** an Xvfb that it starts and ends itself; then YLM_EMISSING says what to install.
** YLM_VTK_WINDOW = egl | x | xvfb | none forces one.
**
** Threads   any number; calls wait for one another, as VTK has global state.
*/
#ifndef YLM_VTK_H
#define YLM_VTK_H

#include "ylm_base.h"
#include "ylm_figure.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ylm_vtk_scene ylm_vtk_scene;

YLM_API ylm_status ylm_vtk_scene_create(ylm_vtk_scene **s, ylm_error *e);
YLM_API void ylm_vtk_scene_free(ylm_vtk_scene *s);

/* How a shape is drawn. */
typedef struct ylm_vtk_style {
  double ambient, diffuse, specular; /* 0 .. 1; ambient 1 and diffuse 0 shows colours as they are */
  double line_width;                 /* pixels of the final picture */
  double opacity;                    /* on top of the colours' alpha */
  int flat;                          /* facets instead of interpolated normals */
  int ghost;                         /* translucent, but only its nearest layer */
} ylm_vtk_style;

/* Copies the shape into the scene; an empty one adds nothing. YLM_EINVAL: a cell of other corners than 2 or 3, or of a point that
   is not there. */
YLM_API ylm_status ylm_vtk_add_shape(ylm_vtk_scene *s, const ylm_figure_shape *shape,
                                     const ylm_vtk_style *style, ylm_error *e);

/*
** ylm_vtk_add_volume - a cloud.
**   place    volume of 1 component, 0 .. 1 (clamped); NaN is empty
**   table    [256][4] colour and opacity per unit `distance`
*/
YLM_API ylm_status ylm_vtk_add_volume(ylm_vtk_scene *s, const ylm_figure_volume *place,
                                      const double *table, double distance, int smooth,
                                      ylm_error *e);

/* The surfaces where a volume of 1 component has value[i]: colour [n][4]. NaN bounds them. */
YLM_API ylm_status ylm_vtk_add_isosurfaces(ylm_vtk_scene *s, const ylm_figure_volume *v, size_t n,
                                           const double *value, const double *colour, ylm_error *e);

/* A picture on the parallelogram corner, corner+u, corner+v: rgba [h][w][4], first row at
   `corner`. YLM_ERANGE: sides are 1 .. 32768 pixels. */
YLM_API ylm_status ylm_vtk_add_picture(ylm_vtk_scene *s, const double corner[3], const double u[3],
                                       const double v[3], int w, int h, const uint8_t *rgba,
                                       int smooth, ylm_error *e);

/* Perspective from `from` towards `at`; fov is the vertical angle in degrees. */
YLM_API void ylm_vtk_camera(ylm_vtk_scene *s, const double from[3], const double at[3],
                            const double up[3], double fov);

/*
** ylm_vtk_render - the scene in 8-bit RGB, [height][width][3], top row first.
**   supersample   1 .. 4: renders that many times larger and averages
** YLM_ERANGE: supersample; sides are 1 .. 32768 pixels
*/
YLM_API ylm_status ylm_vtk_render(ylm_vtk_scene *s, int width, int height, int supersample,
                                  const double background[3], uint8_t *rgb, ylm_error *e);

/* The scene's triangles, lines and pictures, with its camera, as a .gltf file with its data inside, written whole or not
   at all. Clouds are left out. width : height is the camera's aspect ratio. No display is asked for. */
YLM_API ylm_status ylm_vtk_save_gltf(ylm_vtk_scene *s, int width, int height, const char *path,
                                     ylm_error *e);

/* Called with the point under the mouse where 'p' is pressed or a double click falls;
   its text (a static string of the caller's) is shown in the window's corner. */
typedef const char *ylm_vtk_pick(void *user, const double point[3]);

/* Opens a window and returns when it is closed; YLM_EMISSING where there is no display.
   overlay: RGBA [height][width][4] drawn over the scene, or NULL. */
YLM_API ylm_status ylm_vtk_show(ylm_vtk_scene *s, int width, int height, const double background[3],
                                const uint8_t *overlay, const char *title, ylm_vtk_pick *pick,
                                void *user, ylm_error *e);

/* -- a window that answers -------------------------------------------------------- */

/*
** ylm_vtk_live - a window that shows a float picture, with shapes in it that the picture's depth hides.
**
** One at a time in a process. Events are polled; no call runs an event loop. A hidden window has no events and
** is drawn where pictures without a display are (see above).
*/
typedef struct ylm_vtk_live ylm_vtk_live;

typedef enum ylm_vtk_event_kind {
  YLM_VTK_MOVE,
  YLM_VTK_PRESS,
  YLM_VTK_RELEASE,
  YLM_VTK_WHEEL,
  YLM_VTK_KEY,
  YLM_VTK_RESIZE, /* x, y: the new width and height */
  YLM_VTK_CLOSE
} ylm_vtk_event_kind;

typedef struct ylm_vtk_event {
  ylm_vtk_event_kind kind;
  int x, y;   /* pixels from the upper left corner; may lie outside while a button is held */
  int button; /* 1 left 2 middle 3 right; WHEEL: 1 away, -1 towards */
  int shift, control;
  char key[24]; /* X's name: "a", "A", "plus", "Page_Up", "F1" */
  double
      age; /* seconds since the pointer moved, where the server's clock is this machine's; else -1 */
  uint32_t time; /* of the server, milliseconds */
} ylm_vtk_event;

/* Opens it. YLM_EMISSING: no display, no OpenGL 3.2; YLM_EBUSY: there is one; YLM_ERANGE: sides are 1 .. 8192 pixels. */
YLM_API ylm_status ylm_vtk_live_open(int width, int height, const char *title, bool hidden,
                                     ylm_vtk_live **live, ylm_error *e);
/* Closes it; of a display that has gone its memory is left to the process. */
YLM_API void ylm_vtk_live_close(ylm_vtk_live *live);
/* Waits at most `seconds` for events and takes at most `room` of them; successive moves come as the last one.
   YLM_EDEVICE: the display has gone, as of every function below. */
YLM_API ylm_status ylm_vtk_live_poll(ylm_vtk_live *live, double seconds, size_t room,
                                     ylm_vtk_event *event, size_t *n, ylm_error *e);
/* Whether poll would return an event; takes none. */
YLM_API ylm_status ylm_vtk_live_waiting(ylm_vtk_live *live, bool *some, ylm_error *e);
/* Width and height of the window. */
YLM_API void ylm_vtk_live_size(const ylm_vtk_live *live, int size[2]);
/* Width and height of a hidden window become these; the user resizes others. YLM_ERANGE. */
YLM_API ylm_status ylm_vtk_live_resize(ylm_vtk_live *live, int width, int height, ylm_error *e);
/* The picture: rgb [h][w][3] radiance, top row first; depth [h][w] along the view axis, infinity: nothing; NULL:
   what was given last. Copied, and scaled to the rectangle x, y, width, height of the window. */
YLM_API ylm_status ylm_vtk_live_picture(ylm_vtk_live *live, int w, int h, const float *rgb,
                                        const float *depth, const int rectangle[4], ylm_error *e);
/* Radiance to display values: table [n] of 0 .. 1 over log2(radiance) from first to last, linear between; below
   `first` in proportion to the radiance. */
YLM_API ylm_status ylm_vtk_live_tone(ylm_vtk_live *live, size_t n, const float *table, double first,
                                     double last, ylm_error *e);
/* Shapes that lie in the picture, seen by the scene's camera (ylm_vtk_camera), with the distances along the view
   axis between which the picture's depth counts; `scene` NULL: none. */
YLM_API ylm_status ylm_vtk_live_overlay(ylm_vtk_live *live, ylm_vtk_scene *scene, double nearest,
                                        double farthest, ylm_error *e);
/* A panel of 8-bit RGB [h][w][3] over everything, its upper left corner at x, y; rgb NULL: none. */
YLM_API ylm_status ylm_vtk_live_panel(ylm_vtk_live *live, int x, int y, int w, int h,
                                      const uint8_t *rgb, ylm_error *e);
/* Draws and shows all of it; returns when it is drawn. */
YLM_API ylm_status ylm_vtk_live_show(ylm_vtk_live *live, ylm_error *e);
/* Reads the window, rgb [height][width][3]. */
YLM_API ylm_status ylm_vtk_live_read(ylm_vtk_live *live, uint8_t *rgb, ylm_error *e);

/* -- charts -------------------------------------------------------------------- */

typedef struct ylm_vtk_series {
  size_t n;
  const double *x, *y;
  const char *label; /* NULL: not in the legend */
  double colour[4];
  double width;       /* of the line; 0: none */
  double marker_size; /* 0: none */
  int marker;         /* 0 none 1 cross 2 plus 3 square 4 circle 5 diamond */
  int dash;           /* 0 solid 1 dashed 2 dotted */
} ylm_vtk_series;

typedef struct ylm_vtk_axis {
  double least, largest;
  int logarithmic;
  size_t ticks;
  const double *tick;
  const char *const *label;
} ylm_vtk_axis;

typedef struct ylm_vtk_chart {
  int width, height, supersample;
  double left, right, top, bottom; /* margins around the axes, pixels; titles are the caller's */
  ylm_vtk_axis x, y;
  size_t n;
  const ylm_vtk_series *series;
  int legend; /* 0 none 1 top right 2 top left 3 bottom right 4 bottom left */
  double background[3], foreground[3];
  double font; /* size of labels, pixels */
} ylm_vtk_chart;

/* A line plot in 8-bit RGB, [height][width][3]; YLM_ERANGE as of ylm_vtk_render. */
YLM_API ylm_status ylm_vtk_plot(const ylm_vtk_chart *c, uint8_t *rgb, ylm_error *e);

/* -- texts, files ---------------------------------------------------------------- */

/*
** ylm_vtk_text - one or more lines of UTF-8 as RGBA, [height][width][4], allocated.
**   size   of the letters, pixels; bold 0 | 1
** All texts of one size and line count have the same height, ascenders and descenders included.
*/
YLM_API ylm_status ylm_vtk_text(const char *text, double size, int bold, const double rgb[3],
                                int *width, int *height, uint8_t **rgba, ylm_error *e);

/* The canvas as a .png file, written whole or not at all. YLM_ERANGE: sides are 1 .. 32768 pixels. */
YLM_API ylm_status ylm_vtk_save_png(const char *path, const ylm_figure_canvas *c, ylm_error *e);
/* A page is drawn with such: a line, an area, or words. Places are pixels from the upper left corner. */
typedef struct ylm_vtk_mark {
  const double *xy; /* [n][2]; of words one place: the left end of the line that letters stand on */
  size_t n;
  const char *text; /* NULL: none */
  double size;      /* of letters, pixels */
  int bold;
  int fill; /* an area, whose border is closed */
  double colour[4];
  double width; /* of the line */
  int dash;     /* 0 solid 1 dashed 2 dotted */
} ylm_vtk_mark;

/* The marks, in order, as a .pdf page of width x height points, written whole or not at all. Text stays text, the font
   is in the file. */
YLM_API ylm_status ylm_vtk_save_pdf(const char *path, int width, int height, size_t n,
                                    const ylm_vtk_mark *marks, ylm_error *e);

/* Reads a .vtu, .vtp, .vti, .gltf or .glb file by VTK's own readers. Lists counts, bounds, and for each array its
   name, components and range, as text lines; of glTF the points, triangles, bounds, area and signed volume of all
   pieces. For checks. */
YLM_API ylm_status ylm_vtk_describe(const char *path, char **text, ylm_error *e);

/* Where pictures are drawn on this machine: "egl", "x", "xvfb", or the error. */
YLM_API ylm_status ylm_vtk_where(const char **name, ylm_error *e);

/* Version of VTK, "9.1.0". */
YLM_API const char *ylm_vtk_version(void);

#ifdef __cplusplus
}
#endif
#endif
