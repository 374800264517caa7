/*
** ylm_light_photometry.h - luminous intensity by direction, as photometric files of lamps have it.
**
**   ylm_light_photometry_file   what a file says: bytes to numbers and texts, and back
**   ylm_light_photometry        a table that is asked for intensities: immutable, counted
**
** Directions stand in the frame of the lamp: gamma is the angle to its axis, z; C is the angle around
** it, 0 along x, C0, and 90 degrees along y, C90. A lamp that looks down has C90 to the left of C0 as seen
** from above, so x, y and z are a left-handed frame.
**
** Source  IES LM-63-1986 to -2019; Stockmar 1990, EULUMDAT; docs/photometry.md
*/
#ifndef YLM_LIGHT_PHOTOMETRY_H
#define YLM_LIGHT_PHOTOMETRY_H

#include "ylm_base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The most angles of a plane, planes of a table, and numbers of a table. */
#define YLM_LIGHT_PHOTOMETRY_ANGLES 3601
#define YLM_LIGHT_PHOTOMETRY_NUMBERS ((size_t)4000000)

/* -- tables: csrc/light/photometric/table.c ------------------------------------------------------ */

/* Intensities at angles of planes. One plane: the same all around. */
typedef struct ylm_light_photometry_grid {
  size_t angles, planes;
  const double *angle;   /* [angles] degrees from the axis, increasing, 0 .. 180 */
  const double *plane;   /* [planes] degrees around it, increasing, 0 .. below 360 */
  const double *candela; /* [planes][angles] cd, not negative */
  bool linear;           /* between them linear; else splines */
} ylm_light_photometry_grid;

typedef struct ylm_light_photometry ylm_light_photometry;

/*
** ylm_light_photometry_create - a table of these intensities.
**
** Between nodes the intensity is a bicubic spline, C2 in both angles; within the first ring about a
** pole it is a polynomial of the direction, so that it is smooth there too. Where neighbours of a plane
** differ by more than a factor of 4, and by more than a tenth of the peak, slopes are monotone. Negative
** values of the spline count as 0. Beyond the first and last angle there is no light.
**
** Returns  YLM_OK; YLM_EDOMAIN (not finite, negative, above 1e20, angles that do not increase or are out of
**          range), YLM_ERANGE (counts): `e` says which; YLM_ENOMEM
** Cost     O(numbers), 32 bytes for each
** Source   de Boor 1978 (splines); Fritsch & Carlson 1980 (monotone slopes)
*/
YLM_API ylm_status ylm_light_photometry_create(const ylm_light_photometry_grid *grid,
                                               ylm_light_photometry **out, ylm_error *e);
YLM_API ylm_light_photometry *ylm_light_photometry_keep(const ylm_light_photometry *p);
YLM_API void ylm_light_photometry_free(ylm_light_photometry *p);
/* A number that records of lights name it by: the same wherever a table is the same. */
YLM_API double ylm_light_photometry_name(const ylm_light_photometry *p);
/* The table of a name, kept; NULL: there is none. */
YLM_API ylm_light_photometry *ylm_light_photometry_named(double name);
YLM_API size_t ylm_light_photometry_bytes(const ylm_light_photometry *p);
/* Its numbers as they were given, as long as it lives. */
YLM_API ylm_light_photometry_grid ylm_light_photometry_grid_of(const ylm_light_photometry *p);

/*
** ylm_light_photometry_intensity - intensities in directions, with derivatives.
**
**   way       in   [n][3]  unit vectors in the lamp's frame
**   cd        out  [n]
**   gradient  out  [n][3] or NULL
**   hessian   out  [n][6] or NULL: xx xy xz yy yz zz
**
** Derivatives are those of I(y/|y|) at y = way. No allocation.
*/
YLM_API void ylm_light_photometry_intensity(const ylm_light_photometry *p, size_t n,
                                            const double (*way)[3], double *cd,
                                            double (*gradient)[3], double (*hessian)[6]);
/* The flux, lm, between two angles to the axis, degrees. flux.c */
YLM_API double ylm_light_photometry_flux(const ylm_light_photometry *p, double from, double to);
/* The largest intensity, cd; the part of the sphere where the spline is negative, which counts as 0. */
YLM_API double ylm_light_photometry_peak(const ylm_light_photometry *p);
YLM_API double ylm_light_photometry_clipped(const ylm_light_photometry *p);

/*
** ylm_light_photometry_sample - a direction about in proportion to the intensity, by u [2] of 0 .. below 1.
** Returns its density, sr^-1, above 0 wherever there is light; 0: the lamp is dark. sample.c
*/
YLM_API double ylm_light_photometry_sample(const ylm_light_photometry *p, const double u[2],
                                           double way[3]);

/* -- files: csrc/light/photometric/file.c, ies.c, ldt.c, write.c ------------------------------------ */

typedef enum ylm_light_opening {
  YLM_LIGHT_OPENING_point,
  YLM_LIGHT_OPENING_sphere,
  YLM_LIGHT_OPENING_disk,
  YLM_LIGHT_OPENING_rectangle
} ylm_light_opening;

/* A word of a file, with its name; of EULUMDAT the name of the line. */
typedef struct ylm_light_photometry_text {
  char *name, *text;
} ylm_light_photometry_text;

/* The contents of a file. Intensities are those of the whole lamp at full power; symmetries are undone. */
typedef struct ylm_light_photometry_file {
  const char *format; /* "IES LM-63-2002", "EULUMDAT" .. */
  size_t angles, planes;
  double *angle, *plane, *candela; /* as of ylm_light_photometry_grid */
  double lumens;                   /* of the bare lamps; 0: the file does not say, it is absolute */
  double watts;
  ylm_light_opening opening;
  double size[3]; /* m: of the opening along C0, along C90; its luminous height */
  size_t texts, notes;
  ylm_light_photometry_text *text;
  char **note;
  char *
      tilt_file; /* a file of tilt factors that the file names, and that was not given; else NULL */
} ylm_light_photometry_file;

typedef struct ylm_light_photometry_form {
  int lamps; /* of an EULUMDAT file with several sets of lamps the set, from 1 */
  double
      tilt; /* degrees that the lamp hangs off the vertical: by the file's table of tilt factors; NAN: none */
  const unsigned char *factors; /* a file that TILT= names; NULL: it is not there */
  size_t factors_size;
} ylm_light_photometry_form;

/*
** ylm_light_photometry_read - an IES LM-63 or EULUMDAT file out of its bytes.
**
**   name  in   of the file, for messages
**   out   out  to be freed with ylm_light_photometry_file_free; empty on failure
**
** Returns  YLM_OK; YLM_EFORMAT (`e` names the line), YLM_ELIMIT (more numbers than a table may have), YLM_ENOMEM
*/
YLM_API ylm_status ylm_light_photometry_read(const unsigned char *bytes, size_t size,
                                             const char *name,
                                             const ylm_light_photometry_form *form,
                                             ylm_light_photometry_file *out, ylm_error *e);
YLM_API void ylm_light_photometry_file_free(ylm_light_photometry_file *f);
/* Whether bytes may be the beginning of such a file: 'i' (IES LM-63), 'l' (EULUMDAT), 0: of neither. */
YLM_API int ylm_light_photometry_is(const unsigned char *bytes, size_t size);

/*
** ylm_light_photometry_write - the bytes of a file: LM-63-2002, absolute, or EULUMDAT. Symmetries are found: planes that
** differ by less than 1e-6 of the peak are alike.
**
**   bytes  out  to be freed with ylm_free
**
** Returns  YLM_OK; YLM_EINVAL (more planes or angles than EULUMDAT has); YLM_ENOMEM
*/
YLM_API ylm_status ylm_light_photometry_write(const ylm_light_photometry_file *f, bool ldt,
                                              char **bytes, size_t *size, ylm_error *e);

#ifdef __cplusplus
}
#endif
#endif
