/* info.c - what a grid file says of itself, without its cells and rows. */
#include "file.h"

#include <string.h>

/* The sections of a table, for the caller. */
static ylm_status list_sections(const file_table *t, ylm_grid_file_info *info) {
  info->section = ylm_alloc_zero(t->sections, sizeof *info->section);
  if (!info->section) return YLM_ENOMEM;
  info->sections = t->sections;
  for (size_t i = 0; i < t->sections; i++) {
    const grid_file_entry *entry = &t->entry[i];
    ylm_grid_file_section *s = &info->section[i];
    memcpy(s->name, entry->name, sizeof s->name);
    s->offset = entry->offset;
    s->size = entry->size;
    s->record = entry->record;
    s->required = entry->flags & GRID_FILE_REQUIRED;
    s->known = ylm__file_table_kind(entry) != GRID_FILE_COUNT;
  }
  return YLM_OK;
}

/* The report of a file of few bytes; any other has none. */
static ylm_status take_report(const file_table *t, const file_source *source,
                              ylm_grid_file_info *info, ylm_error *e) {
  if (!ylm__file_table_find(t, GRID_FILE_small_report)) return YLM_OK;
  info->is_small = true;
  return ylm__file_table_take(t, source, GRID_FILE_small_report, sizeof info->small,
                              sizeof info->small, &info->small, e);
}

/* Header, table, form and stats are read and checked. */
static ylm_status info_of_sections(const file_source *source, ylm_grid_file_info *info,
                                   ylm_error *e) {
  file_table t;
  grid_file_form form;
  ylm_status s = ylm__file_table_read(&t, source, e);
  if (s == YLM_OK) s = ylm__file_table_form(&t, source, &form, &info->form, &info->stats, e);
  if (s == YLM_OK) s = take_report(&t, source, info, e);
  if (s == YLM_OK && list_sections(&t, info) != YLM_OK) s = ylm_no_memory_for(e, source->name);
  ylm_free(t.entry);
  return s;
}

ylm_status ylm_grid_file_look(const char *path, ylm_grid_file_info *info, ylm_error *e) {
  file_source source;
  *info = (ylm_grid_file_info){0};
  ylm_status s = ylm__file_source_open(&source, path, e);
  info->version = GRID_FILE_VERSION;
  info->size = source.size;
  if (s == YLM_OK) s = info_of_sections(&source, info, e);
  ylm__file_source_close(&source);
  if (s != YLM_OK) ylm_grid_file_forget(info);
  return s;
}

void ylm_grid_file_forget(ylm_grid_file_info *info) {
  ylm_free(info->section);
  *info = (ylm_grid_file_info){0};
}
