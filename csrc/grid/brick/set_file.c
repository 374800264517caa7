/* set_file.c - the files of a grid in bricks, for those who read them one by one. */
#include "set.h"

bool ylm_grid_set_file(const ylm_grid_set *s, size_t i, char *path, size_t room) {
  char full[FOLDER_PATH];
  if (i > s->bricks) return false;
  if (i == s->bricks)
    ylm__folder_file(s->folder, "top.ylm", full);
  else
    ylm__folder_brick(s->folder, s->brick[i].code, "ylm", full);
  return (size_t)snprintf(path, room, "%s", full) < room;
}
