/* display.c - the protocol of tev over TCP, see ylm_display.h. */
#include "ylm_display.h"
#include "ylm_list.h"

#include <errno.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum { CLOSE = 2, CREATE = 4, UPDATE = 6 };     /* types of packets */
enum { CONNECT_MS = 1000, PATIENCE_MS = 2000 }; /* until the viewer is given up */
enum { STRIP = 32, MOST_BYTES = 4 << 20 };      /* rows and bytes of an update, at most */
enum { MOST_SIDE = 1 << 16 };

/* Notes of a picture that a viewer has been sent. */
typedef struct sent {
  struct sent *next;
  char *name, *channels; /* names of channels, each with its 0 */
  size_t channel_bytes;
  int width, height;
  float *pixels; /* layer behind layer */
} sent;

struct ylm_display {
  int socket; /* -1: given up */
  char where[300];
  sent *pictures;
};

/* -- packets ------------------------------------------------------------------------------ */

typedef struct packet {
  unsigned char *bytes;
  size_t size, room;
  bool failed; /* memory ran out */
} packet;

static void put(packet *p, const void *from, size_t n) {
  p->failed = p->failed || !ylm_list_reserve(&p->bytes, p->size, p->size + n, &p->room, 1);
  if (p->failed) return;
  memcpy(p->bytes + p->size, from, n);
  p->size += n;
}

static void put_u8(packet *p, unsigned x) { put(p, &(unsigned char){(unsigned char)x}, 1); }

static void put_integer(packet *p, uint64_t x, int bytes) {
  for (int i = 0; i < bytes; i++) put_u8(p, (unsigned)(x >> 8 * i & 255));
}

static void put_string(packet *p, const char *s) { put(p, s, strlen(s) + 1); }

static void put_floats(packet *p, const float *x, size_t n) {
  const uint16_t one = 1;
  if (*(const unsigned char *)&one) {
    put(p, x, n * sizeof *x);
    return;
  }
  for (size_t i = 0; i < n; i++) {
    uint32_t bits;
    memcpy(&bits, &x[i], sizeof bits);
    put_integer(p, bits, 4);
  }
}

static void begin(packet *p, unsigned type) {
  p->size = 0;
  put_integer(p, 0, 4);
  put_u8(p, type);
}

static void put_length(packet *p) {
  for (int i = 0; i < 4 && !p->failed; i++) p->bytes[i] = (unsigned char)(p->size >> 8 * i & 255);
}

/* -- the connection ------------------------------------------------------------------------- */

static int64_t milliseconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (int64_t)t.tv_sec * 1000 + t.tv_nsec / 1000000;
}

static ylm_status give_up(ylm_display *d, ylm_error *e, const char *why) {
  if (d->socket >= 0) close(d->socket);
  d->socket = -1;
  return ylm_fail(e, YLM_EIO, "the image viewer at %s %s", d->where, why);
}

/* Sends the packet whole, or gives the viewer up. */
static ylm_status post(ylm_display *d, packet *p, ylm_error *e) {
  if (p->failed) return ylm_fail(e, YLM_ENOMEM, "memory ran out for a packet to an image viewer");
  put_length(p);
  int64_t until = milliseconds() + PATIENCE_MS;
  for (size_t at = 0; at < p->size;) {
    ssize_t n = send(d->socket, p->bytes + at, p->size - at, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (n > 0) {
      at += (size_t)n;
      until = milliseconds() + PATIENCE_MS;
      continue;
    }
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && errno != EAGAIN && errno != EWOULDBLOCK) return give_up(d, e, "has gone");
    int64_t left = until - milliseconds();
    if (left <= 0) return give_up(d, e, "takes nothing for two seconds: it is given up");
    struct pollfd wait = {d->socket, POLLOUT, 0};
    poll(&wait, 1, (int)left);
  }
  return YLM_OK;
}

/* A socket that is connected to the address, or -1. */
static int reach(const struct addrinfo *a, int64_t until) {
  int s = socket(a->ai_family, a->ai_socktype | SOCK_CLOEXEC | SOCK_NONBLOCK, a->ai_protocol);
  if (s < 0) return -1;
  int error = 0;
  socklen_t size = sizeof error;
  if (connect(s, a->ai_addr, a->ai_addrlen) != 0) {
    struct pollfd wait = {s, POLLOUT, 0};
    int64_t left = until - milliseconds();
    if (errno != EINPROGRESS || left <= 0 || poll(&wait, 1, (int)left) != 1 ||
        getsockopt(s, SOL_SOCKET, SO_ERROR, &error, &size) != 0 || error) {
      close(s);
      return -1;
    }
  }
  setsockopt(s, IPPROTO_TCP, TCP_NODELAY, &(int){1}, sizeof(int));
  return s;
}

ylm_status ylm_display_open(const char *host, int port, ylm_display **d, ylm_error *e) {
  *d = NULL;
  if (port < 1 || port > 65535)
    return ylm_fail(e, YLM_ERANGE, "a port from 1 to 65535 expected, got %d", port);
  ylm_display *new = ylm_alloc_zero(1, sizeof *new);
  if (!new) return ylm_fail(e, YLM_ENOMEM, "memory ran out for an image viewer");
  snprintf(new->where, sizeof new->where, "%s:%d", host, port);
  new->socket = -1;
  struct addrinfo wanted = {.ai_family = AF_UNSPEC, .ai_socktype = SOCK_STREAM}, *found = NULL;
  char number[8];
  snprintf(number, sizeof number, "%d", port);
  int64_t until = milliseconds() + CONNECT_MS;
  if (getaddrinfo(host, number, &wanted, &found) == 0)
    for (const struct addrinfo *a = found; a && new->socket < 0; a = a->ai_next)
      new->socket = reach(a, until);
  if (found) freeaddrinfo(found);
  if (new->socket < 0) {
    ylm_status s = ylm_fail(e, YLM_EIO, "no image viewer listens at %s", new->where);
    ylm_free(new);
    return s;
  }
  *d = new;
  return YLM_OK;
}

static void forget(sent *s) {
  ylm_free(s->name);
  ylm_free(s->channels);
  ylm_free(s->pixels);
  ylm_free(s);
}

void ylm_display_free(ylm_display *d) {
  if (!d) return;
  if (d->socket >= 0) close(d->socket);
  for (sent *s = d->pictures, *next; s; s = next) {
    next = s->next;
    forget(s);
  }
  ylm_free(d);
}

/* -- pictures --------------------------------------------------------------------------------- */

static ylm_status check_name(const char *what, const char *name, size_t most, ylm_error *e) {
  size_t n = strlen(name);
  for (size_t i = 0; i < n; i++)
    if ((unsigned char)name[i] < 32 || name[i] == 127)
      return ylm_fail(e, YLM_EINVAL, "%s: a name without control characters expected", what);
  if (n == 0 || n > most)
    return ylm_fail(e, YLM_EINVAL, "%s: a name of 1 to %zu bytes expected, got %zu", what, most, n);
  return YLM_OK;
}

static ylm_status check_picture(const ylm_display_picture *p, ylm_error *e) {
  ylm_status s = check_name("name of a picture", p->name, YLM_DISPLAY_NAME, e);
  if (s != YLM_OK) return s;
  if (p->width < 1 || p->height < 1 || p->width > MOST_SIDE || p->height > MOST_SIDE)
    return ylm_fail(e, YLM_ESHAPE, "%s: 1 to %d pixels a side expected, got %d x %d", p->name,
                    MOST_SIDE, p->width, p->height);
  if (p->layers < 1 || p->layers > YLM_DISPLAY_LAYERS)
    return ylm_fail(e, YLM_ESHAPE, "%s: 1 to %d layers expected, got %d", p->name,
                    YLM_DISPLAY_LAYERS, p->layers);
  for (int l = 0; l < p->layers && s == YLM_OK; l++) {
    const ylm_display_layer *layer = &p->layer[l];
    if (layer->channels < 1 || layer->channels > 4)
      return ylm_fail(e, YLM_ESHAPE, "%s: 1 to 4 channels a layer expected, got %d", p->name,
                      layer->channels);
    for (int c = 0; c < layer->channels && s == YLM_OK; c++)
      s = check_name("name of a channel", layer->channel[c], sizeof layer->channel[c] - 1, e);
  }
  return s;
}

/* All channels of a picture, or those of one layer. */
static void put_names(packet *out, const ylm_display_layer *layer, int layers) {
  for (int l = 0; l < layers; l++)
    for (int c = 0; c < layer[l].channels; c++) put_string(out, layer[l].channel[c]);
}

static int channels_of(const ylm_display_picture *p) {
  int n = 0;
  for (int l = 0; l < p->layers; l++) n += p->layer[l].channels;
  return n;
}

static sent **find(ylm_display *d, const char *name) {
  sent **at = &d->pictures;
  while (*at && strcmp((*at)->name, name) != 0) at = &(*at)->next;
  return at;
}

static void drop(ylm_display *d, const char *name) {
  sent **at = find(d, name), *s = *at;
  if (!s) return;
  *at = s->next;
  forget(s);
}

/* Notes of a picture that nothing has been sent of. */
static sent *note(const ylm_display_picture *p, const packet *names) {
  sent *s = ylm_alloc_zero(1, sizeof *s);
  if (!s) return NULL;
  s->name = ylm_alloc_copy(p->name, strlen(p->name) + 1, 1);
  s->channels = ylm_alloc_copy(names->bytes, names->size, 1);
  s->pixels = ylm_alloc_zero((size_t)p->width * (size_t)p->height,
                             (size_t)channels_of(p) * sizeof *s->pixels);
  s->channel_bytes = names->size;
  s->width = p->width;
  s->height = p->height;
  if (s->name && s->channels && s->pixels) return s;
  forget(s);
  return NULL;
}

/* Rows y .. y + rows - 1 of a layer, interleaved as they are. */
static ylm_status send_rows(ylm_display *d, const ylm_display_picture *p,
                            const ylm_display_layer *layer, int y, int rows, packet *out,
                            ylm_error *e) {
  begin(out, UPDATE);
  put_u8(out, 0);
  put_string(out, p->name);
  put_integer(out, (uint64_t)layer->channels, 4);
  put_names(out, layer, 1);
  put_integer(out, 0, 4);
  put_integer(out, (uint64_t)y, 4);
  put_integer(out, (uint64_t)p->width, 4);
  put_integer(out, (uint64_t)rows, 4);
  for (int c = 0; c < layer->channels; c++) put_integer(out, (uint64_t)c, 8);
  for (int c = 0; c < layer->channels; c++) put_integer(out, (uint64_t)layer->channels, 8);
  size_t row = (size_t)p->width * (size_t)layer->channels;
  put_floats(out, layer->pixels + (size_t)y * row, (size_t)rows * row);
  return post(d, out, e);
}

/* The picture's entry: the one there is, or a new one, which the viewer is told of. */
static ylm_status entry(ylm_display *d, const ylm_display_picture *p, packet *out, sent **s,
                        bool *fresh, ylm_error *e) {
  packet names = {0};
  put_names(&names, p->layer, p->layers);
  *s = *find(d, p->name);
  *fresh = names.failed || !*s || (*s)->width != p->width || (*s)->height != p->height ||
           (*s)->channel_bytes != names.size ||
           memcmp((*s)->channels, names.bytes, names.size) != 0;
  ylm_status status = YLM_OK;
  if (*fresh) {
    drop(d, p->name);
    *s = names.failed ? NULL : note(p, &names);
    if (!*s)
      status = ylm_fail(e, YLM_ENOMEM, "memory ran out for the picture %s", p->name);
    else {
      (*s)->next = d->pictures;
      d->pictures = *s;
      begin(out, CREATE);
      put_u8(out, 0);
      put_string(out, p->name);
      put_integer(out, (uint64_t)p->width, 4);
      put_integer(out, (uint64_t)p->height, 4);
      put_integer(out, (uint64_t)channels_of(p), 4);
      put(out, names.bytes, names.size);
      status = post(d, out, e);
    }
  }
  ylm_free(names.bytes);
  return status;
}

/* Strips of a layer that are not as they were `before`. */
static ylm_status send_layer(ylm_display *d, const ylm_display_picture *p,
                             const ylm_display_layer *layer, float *before, bool fresh, packet *out,
                             ylm_error *e) {
  ylm_status s = YLM_OK;
  size_t row = (size_t)p->width * (size_t)layer->channels, bytes = row * sizeof(float);
  int most = bytes * STRIP <= MOST_BYTES ? STRIP
             : MOST_BYTES / bytes > 1    ? (int)(MOST_BYTES / bytes)
                                         : 1;
  for (int y = 0; y < p->height && s == YLM_OK; y += most) {
    int rows = p->height - y < most ? p->height - y : most;
    const float *now = layer->pixels + (size_t)y * row;
    if (!fresh && memcmp(now, before + (size_t)y * row, (size_t)rows * bytes) == 0) continue;
    s = send_rows(d, p, layer, y, rows, out, e);
    if (s == YLM_OK) memcpy(before + (size_t)y * row, now, (size_t)rows * bytes);
  }
  return s;
}

ylm_status ylm_display_send(ylm_display *d, const ylm_display_picture *p, ylm_error *e) {
  ylm_status s = check_picture(p, e);
  if (s != YLM_OK) return s;
  if (d->socket < 0) return give_up(d, e, "has been given up");
  packet out = {0};
  sent *known;
  bool fresh;
  s = entry(d, p, &out, &known, &fresh, e);
  float *before = s == YLM_OK ? known->pixels : NULL;
  for (int l = 0; l < p->layers && s == YLM_OK; l++) {
    const ylm_display_layer *layer = &p->layer[l];
    s = send_layer(d, p, layer, before, fresh, &out, e);
    before += (size_t)p->width * (size_t)p->height * (size_t)layer->channels;
  }
  ylm_free(out.bytes);
  return s;
}

ylm_status ylm_display_drop(ylm_display *d, const char *name, ylm_error *e) {
  ylm_status s = check_name("name of a picture", name, YLM_DISPLAY_NAME, e);
  if (s != YLM_OK) return s;
  if (d->socket < 0) return give_up(d, e, "has been given up");
  packet out = {0};
  drop(d, name);
  begin(&out, CLOSE);
  put_string(&out, name);
  s = post(d, &out, e);
  ylm_free(out.bytes);
  return s;
}
