/*
** file_place.h - where a file is saved: beside the one that it will replace. Private to csrc/base.
*/
#ifndef YLM_FILE_PLACE_H
#define YLM_FILE_PLACE_H

#include <sys/stat.h>

#include "ylm_base.h"

/* Bytes of the name of a file that is not whole yet, with its final 0. */
#define YLM__UNFINISHED_NAME 32

/* A folder, the name in it, and what has that name. */
typedef struct ylm__place {
  int folder;       /* of the file behind all links; opened for reaching what is in it */
  char *path;       /* of that file */
  const char *name; /* its last part */
  bool exists;
  struct stat old; /* the present file, where `exists` */
} ylm__place;

/* Finds the place of `path`, which may be a link, and checks that a file there may be replaced.
   YLM_EIO with a sentence, YLM_ENOMEM. After YLM_OK, ylm__place_leave frees what it holds. */
ylm_status ylm__place_find(const char *path, ylm__place *place, ylm_error *e);
void ylm__place_leave(ylm__place *place);

/* A new file beside the place, locked for as long as this process lives; its name goes to `name`.
   Owner, group, mode and access list are those of the file there, as far as they can be given. Every user whom that file
   shuts out is shut out. -1 with errno. */
int ylm__place_open(const ylm__place *place, char name[YLM__UNFINISHED_NAME]);

/* Removes files of ylm__place_open whose process ended before them, from an hour after their last
   change on. */
void ylm__place_sweep(const ylm__place *place);

#endif
