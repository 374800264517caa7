/*
** tev.c - stands in for an image viewer: puts together what a client sends by the protocol of tev, and checks each packet.
**
**   tev MODE FOLDER
**
** Prints the port that it listens at. Takes one connection, until it is closed. MODE: all; close (hangs up after the
** third packet); deaf (accepts, and never reads). Writes FOLDER/picture (a line "width height channels names..", then
** floats, as they lie in the picture, channels side by side), FOLDER/packets (a line a packet: seconds since the
** connection, type, length, y, rows) and FOLDER/first (the first 200 bytes, as hexadecimal digits).
*/
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <poll.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum { CHANNELS = 128 };

static struct picture {
  char name[300], channel[CHANNELS][80];
  int width, height, channels;
  float *pixels;
} picture;

static void die(const char *why) {
  fprintf(stderr, "tev: %s\n", why);
  exit(1);
}

static double seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* -- what a packet holds ---------------------------------------------------------------- */

typedef struct bytes {
  const unsigned char *at, *end;
} bytes;

static uint64_t integer(bytes *b, int n) {
  uint64_t x = 0;
  if (b->end - b->at < n) die("a packet ends within a number");
  for (int i = 0; i < n; i++) x |= (uint64_t)b->at[i] << 8 * i;
  b->at += n;
  return x;
}

static void string(bytes *b, char *to, size_t most) {
  const unsigned char *end = memchr(b->at, 0, (size_t)(b->end - b->at));
  if (!end || (size_t)(end - b->at) >= most) die("a string without an end, or too long");
  memcpy(to, b->at, (size_t)(end - b->at) + 1);
  b->at = end + 1;
}

static void create(bytes *b) {
  if (integer(b, 1) > 1) die("create: grab focus is no boolean");
  string(b, picture.name, sizeof picture.name);
  picture.width = (int)integer(b, 4);
  picture.height = (int)integer(b, 4);
  picture.channels = (int)integer(b, 4);
  if (picture.width < 1 || picture.height < 1 || picture.channels < 1 ||
      picture.channels > CHANNELS)
    die("create: no such size");
  for (int c = 0; c < picture.channels; c++) {
    string(b, picture.channel[c], sizeof picture.channel[c]);
    for (int k = 0; k < c; k++)
      if (!strcmp(picture.channel[c], picture.channel[k])) die("create: two channels of one name");
  }
  free(picture.pixels);
  picture.pixels = calloc((size_t)picture.width * (size_t)picture.height * (size_t)picture.channels,
                          sizeof(float));
}

static int channel_of(const char *name) {
  for (int c = 0; c < picture.channels; c++)
    if (!strcmp(name, picture.channel[c])) return c;
  die("update: a channel that was not created");
  return -1;
}

static void update(bytes *b, int *y, int *rows) {
  char name[300], channel[80];
  int place[CHANNELS];
  uint64_t offset[CHANNELS], stride[CHANNELS];
  if (integer(b, 1) > 1) die("update: grab focus is no boolean");
  string(b, name, sizeof name);
  if (!picture.pixels || strcmp(name, picture.name) != 0)
    die("update: of a picture that was not created");
  int n = (int)integer(b, 4);
  if (n < 1 || n > picture.channels) die("update: no such number of channels");
  for (int c = 0; c < n; c++) {
    string(b, channel, sizeof channel);
    place[c] = channel_of(channel);
  }
  int x = (int)integer(b, 4);
  *y = (int)integer(b, 4);
  int width = (int)integer(b, 4);
  *rows = (int)integer(b, 4);
  if (x < 0 || *y < 0 || width < 1 || *rows < 1 || x + width > picture.width ||
      *y + *rows > picture.height)
    die("update: outside of the picture");
  uint64_t most = 0, pixels = (uint64_t)width * (uint64_t)*rows;
  for (int c = 0; c < n; c++) offset[c] = integer(b, 8);
  for (int c = 0; c < n; c++) stride[c] = integer(b, 8);
  for (int c = 0; c < n; c++) {
    uint64_t need = offset[c] + (pixels - 1) * stride[c] + 1;
    if (need > most) most = need;
  }
  if ((uint64_t)(b->end - b->at) != 4 * most)
    die("update: another number of floats than offsets and strides say");
  for (uint64_t i = 0; i < pixels; i++)
    for (int c = 0; c < n; c++) {
      size_t to = (size_t)(*y + (int)(i / (uint64_t)width)) * (size_t)picture.width + (size_t)x +
                  (size_t)(i % (uint64_t)width);
      memcpy(&picture.pixels[to * (size_t)picture.channels + (size_t)place[c]],
             b->at + 4 * (offset[c] + i * stride[c]), sizeof(float));
    }
  b->at = b->end;
}

/* -- the connection ------------------------------------------------------------------------ */

static FILE *open_in(const char *folder, const char *name) {
  char path[1000];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  FILE *f = fopen(path, "wb");
  if (!f) die("a file cannot be written");
  return f;
}

static int read_whole(int s, void *to, size_t n) {
  for (size_t at = 0; at < n;) {
    ssize_t k = read(s, (char *)to + at, n - at);
    if (k <= 0) return 0;
    at += (size_t)k;
  }
  return 1;
}

static void save(const char *folder) {
  FILE *f = open_in(folder, "picture");
  fprintf(f, "%d %d %d", picture.width, picture.height, picture.channels);
  for (int c = 0; c < picture.channels; c++) fprintf(f, " %s", picture.channel[c]);
  fprintf(f, "\n");
  if (picture.pixels)
    fwrite(picture.pixels, sizeof(float),
           (size_t)picture.width * (size_t)picture.height * (size_t)picture.channels, f);
  fclose(f);
}

static void serve(int s, const char *mode, const char *folder) {
  FILE *log = open_in(folder, "packets"), *first = open_in(folder, "first");
  double began = seconds();
  size_t shown = 0;
  for (int packets = 0; strcmp(mode, "close") != 0 || packets < 3; packets++) {
    unsigned char head[4];
    if (!read_whole(s, head, 4)) break;
    uint32_t size = (uint32_t)head[0] | (uint32_t)head[1] << 8 | (uint32_t)head[2] << 16 |
                    (uint32_t)head[3] << 24;
    if (size < 5 || size > 5u << 20) die("a packet of that length");
    unsigned char *whole = malloc(size);
    memcpy(whole, head, 4);
    if (!read_whole(s, whole + 4, size - 4)) die("a packet that was cut");
    for (size_t i = 0; i < size && shown < 200; i++, shown++) fprintf(first, "%02x", whole[i]);
    bytes b = {whole + 5, whole + size};
    int y = 0, rows = 0;
    if (whole[4] == 4)
      create(&b);
    else if (whole[4] == 6)
      update(&b, &y, &rows);
    else if (whole[4] == 2)
      string(&b, picture.name, sizeof picture.name);
    else
      die("a packet of that type");
    if (b.at != b.end) die("a packet with something behind its end");
    fprintf(log, "%.3f %d %u %d %d\n", seconds() - began, whole[4], size, y, rows);
    free(whole);
  }
  fclose(log);
  fclose(first);
  save(folder);
}

int main(int argc, char **argv) {
  if (argc != 3) die("MODE and FOLDER expected");
  int listener = socket(AF_INET, SOCK_STREAM, 0);
  struct sockaddr_in a = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
  socklen_t n = sizeof a;
  if (bind(listener, (struct sockaddr *)&a, sizeof a) || listen(listener, 1) ||
      getsockname(listener, (struct sockaddr *)&a, &n))
    die("no port can be had");
  printf("%d\n", ntohs(a.sin_port));
  fflush(stdout);
  alarm(60);
  int s = accept(listener, NULL, NULL);
  if (s < 0) die("nobody came");
  if (!strcmp(argv[1], "deaf")) {
    poll(&(struct pollfd){s, POLLRDHUP, 0}, 1, 6000);
    return 0;
  }
  serve(s, argv[1], argv[2]);
  return 0;
}
