/* jpeg.c - JPEG through libjpeg; where it is not installed, a sentence. */
#include "codec.h"

#ifdef YLM_JPEG
#include <jpeglib.h>

#include <jerror.h>
#include <setjmp.h>
#include <string.h>

enum { SCANS = 500, PACKED = 1024 }; /* scans of a file; pixels that a byte stands for at most */

/* libjpeg's manager of errors, with a place to return to. */
typedef struct state {
  struct jpeg_error_mgr base;
  jmp_buf back;
  char message[JMSG_LENGTH_MAX];
} state;

static void on_error(j_common_ptr c) {
  state *s = (state *)c->err;
  s->base.format_message(c, s->message);
  longjmp(s->back, 1);
}

/* Warnings are of data that is missing or damaged. */
static void on_message(j_common_ptr c, int level) {
  if (level < 0) on_error(c);
}

static void on_scan(j_common_ptr c) {
  state *s = (state *)c->err;
  if (((j_decompress_ptr)c)->input_scan_number <= SCANS) return;
  snprintf(s->message, sizeof s->message, "more than %d scans", SCANS);
  longjmp(s->back, 1);
}

/* Values that survive a longjmp. */
typedef struct work {
  struct jpeg_decompress_struct jpeg;
  struct jpeg_progress_mgr progress;
  state st;
  ylm_image *image;
  unsigned char *row;
} work;

static ylm_status read_all(work *w, const unsigned char *bytes, size_t size, const char *name,
                           const ylm_codec_input *input, ylm_error *e) {
  j_decompress_ptr j = &w->jpeg;
  jpeg_mem_src(j, bytes, (unsigned long)size);
  jpeg_read_header(j, TRUE);
  if (j->num_components != 1 && j->num_components != 3)
    return ylm_fail(e, YLM_EFORMAT, "%s: %d components: grey and RGB are read", name,
                    j->num_components);
  int channels = j->num_components;
  j->out_color_space = channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
  uint64_t least = (uint64_t)j->image_width * j->image_height / PACKED;
  ylm_status s = ylm__codec_start(name, input, j->image_width, j->image_height, channels, size,
                                  (size_t)least, &w->image, e);
  if (s != YLM_OK) return s;
  jpeg_start_decompress(j);
  size_t n = (size_t)j->output_width * (size_t)channels;
  w->row = ylm_alloc_zero(n, 1);
  if (!w->row) return ylm_no_memory_for(e, name);
  float table[256], *out = w->image->layer[0].data;
  for (int i = 0; i < 256; i++)
    table[i] = input->raw ? (float)i / 255 : ylm_tone_decode_srgb((float)i / 255);
  while (j->output_scanline < j->output_height) {
    jpeg_read_scanlines(j, &w->row, 1);
    for (size_t i = 0; i < n; i++) *out++ = table[w->row[i]];
  }
  jpeg_finish_decompress(j);
  return YLM_OK;
}

ylm_status ylm__jpeg_parse(const unsigned char *bytes, size_t size, const char *name,
                           const ylm_codec_input *input, ylm_image **image, ylm_error *e) {
  *image = NULL;
  work *w = ylm_alloc_zero(1, sizeof *w);
  if (!w) return ylm_no_memory_for(e, name);
  volatile ylm_status s = YLM_OK;
  w->jpeg.err = jpeg_std_error(&w->st.base);
  w->st.base.error_exit = on_error;
  w->st.base.emit_message = on_message;
  if (setjmp(w->st.back)) {
    s = w->st.base.msg_code == JERR_OUT_OF_MEMORY
            ? ylm_no_memory_for(e, name)
            : ylm_fail(e, YLM_EFORMAT, "%s: not a whole JPEG image: %s", name, w->st.message);
  } else {
    jpeg_create_decompress(&w->jpeg);
    w->progress.progress_monitor = on_scan;
    w->jpeg.progress = &w->progress;
    s = read_all(w, bytes, size, name, input, e);
  }
  jpeg_destroy_decompress(&w->jpeg);
  ylm_free(w->row);
  if (s == YLM_OK)
    *image = w->image;
  else
    ylm_image_free(w->image);
  ylm_free(w);
  return s;
}
#else
ylm_status ylm__jpeg_parse(const unsigned char *bytes, size_t size, const char *name,
                           const ylm_codec_input *input, ylm_image **image, ylm_error *e) {
  (void)bytes, (void)size, (void)input;
  *image = NULL;
  return ylm_fail(e, YLM_EMISSING,
                  "%s: JPEG needs libjpeg: install libjpeg-dev, and build ylm again", name);
}
#endif
