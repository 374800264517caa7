/*
** dome.c - light that fills the sky, as tiles that rays are aimed at.
**
** A pixel is chosen as its luminance times its solid angle. Panoramas that are images have their own
** pixels, whose radiance is one; other domes have a latitude-longitude table, whose cells hold a
** mean and a little more, so that no direction with light is left out.
*/
#include <math.h>

#include "alias.h"
#include "calibration.h"
#include "dome.h"
#include "ylm_base.h"

/* Tiles of each mapping, about 45 degrees wide or less. */
static const size_t tiles[][2] = {[YLM_MAPPING_LATLONG] = {16, 8},
                                  [YLM_MAPPING_ANGULAR] = {12, 12},
                                  [YLM_MAPPING_CUBE] = {4, 24}};

/* -- pixels ------------------------------------------------------------------------------------ */

static size_t pixels_of(const scene_dome *d) { return (size_t)d->width * (size_t)d->height; }

/* Where tile i of `count` along a side of n pixels begins; which holds pixel x. */
static size_t first_of(size_t i, size_t count, int n) { return i * (size_t)n / count; }
static size_t holder_of(size_t x, size_t count, int n) { return ((x + 1) * count - 1) / (size_t)n; }

typedef struct tile {
  size_t x, y, width, height; /* of its pixels */
} tile;

static tile tile_at(const scene_dome *d, size_t i) {
  size_t tx = i % d->across, ty = i / d->across;
  tile t = {.x = first_of(tx, d->across, d->width), .y = first_of(ty, d->down, d->height)};
  t.width = first_of(tx + 1, d->across, d->width) - t.x;
  t.height = first_of(ty + 1, d->down, d->height) - t.y;
  return t;
}

/* Pixel k of a tile, row by row. Tiles have less than 2^32 pixels, and short numbers are divided faster. */
static size_t pixel_in(const scene_dome *d, const tile *t, size_t k) {
  uint32_t y = (uint32_t)k / (uint32_t)t->width;
  return (t->y + y) * (size_t)d->width + t->x + k - y * t->width;
}

size_t ylm__scene_dome_tile(const scene_dome *d, size_t pixel) {
  size_t x = pixel % (size_t)d->width, y = pixel / (size_t)d->width;
  return holder_of(y, d->down, d->height) * d->across + holder_of(x, d->across, d->width);
}

static size_t cell_at(const scene_dome *d, size_t column, size_t row) {
  return d->holder[1][row] * d->cells[0] + d->holder[0][column];
}

size_t ylm__scene_dome_cell(const scene_dome *d, size_t pixel) {
  return cell_at(d, pixel % (size_t)d->width, pixel / (size_t)d->width);
}

/* A direction in a pixel; false outside of the disc of an angular map, and zeros. */
static bool within(const scene_dome *d, size_t pixel, double u, double v, double direction[3]) {
  return ylm_mapping_within(d->mapping, d->up, d->width, d->height, pixel, u, v, direction, NULL);
}

static double spread(const scene_dome *d, size_t pixel, const double direction[3]) {
  return ylm_mapping_spread(d->mapping, d->up, d->width, d->height, pixel, direction);
}

/* The solid angle of a pixel: of its middle where all of it is on the sphere, else of the parts that
   are. */
static double solid_angle(const scene_dome *d, size_t pixel) {
  double direction[3], sum = 0;
  bool whole = true;
  for (int i = 0; i < 4 && d->mapping == YLM_MAPPING_ANGULAR; i++)
    whole = whole && within(d, pixel, i & 1, i >> 1, direction);
  if (whole && within(d, pixel, 0.5, 0.5, direction)) return spread(d, pixel, direction);
  for (int i = 0; i < 16; i++)
    if (within(d, pixel, i % 4 / 3.0, i / 4 / 3.0, direction))
      sum += spread(d, pixel, direction) / 16;
  return sum;
}

void ylm__scene_dome_radiance(const scene_dome *d, size_t pixel, const double direction[3],
                              double rgb[3]) {
  const ylm_light_panorama *p = d->light.panorama;
  if (p && p->texel)
    for (size_t c = 0; c < 3; c++) rgb[c] = p->scale * (double)p->texel[3 * pixel + c];
  else
    ylm_light_dome_radiance(&d->light, direction, rgb);
}

/* The mean luminance of a pixel, from places in it. */
static double look(const scene_dome *d, size_t pixel) {
  double sum = 0, direction[3], rgb[3];
  int looks = d->light.panorama && d->light.panorama->texel ? 1 : TABLE_LOOKS;
  for (int i = 0; i < looks * looks; i++) {
    within(d, pixel, (i % looks + 0.5) / looks, (i / looks + 0.5) / looks, direction);
    ylm__scene_dome_radiance(d, pixel, direction, rgb);
    sum += ylm_luminance_size(rgb) / (looks * looks);
  }
  return sum;
}

/* -- tables ------------------------------------------------------------------------------------ */

/* Luminances times solid angles [height][width]. */
static void measure(const scene_dome *d, double *power) {
  size_t n = pixels_of(d);
  double sum = 0;
  for (size_t i = 0; i < n; i++) sum += power[i] = look(d, i) * solid_angle(d, i);
  if (d->light.panorama && d->light.panorama->texel) return;
  for (size_t i = 0; i < n; i++) power[i] += TABLE_LEAST * sum / (4 * YLM_PI) * solid_angle(d, i);
}

/* Room for the alias table of a tile. */
typedef struct table {
  double *height;
  uint32_t *list, *other;
  float *stay;
} table;

/* The alias table of a tile, whose pixels are counted in it. */
static void pair_up(scene_dome *d, const tile *t, const double *power, const table *x) {
  size_t n = t->width * t->height;
  double total = 0;
  for (size_t k = 0; k < n; k++) total += power[pixel_in(d, t, k)];
  for (size_t k = 0; k < n; k++) {
    double share = total > 0 ? power[pixel_in(d, t, k)] / total : 0;
    d->share[pixel_in(d, t, k)] = (float)share;
    x->height[k] = total > 0 ? share * (double)n : 1; /* of a dark tile each pixel keeps its own */
  }
  ylm__alias_fill(n, x->height, x->list, x->stay, x->other);
  for (size_t k = 0; k < n; k++) {
    size_t i = pixel_in(d, t, k);
    d->keep[i] = x->stay[k];
    d->other[i] = x->other[k];
  }
}

/* -- bounds ------------------------------------------------------------------------------------ */

/* No direction of a pixel is farther than this from that of its middle. */
static double radius_of(const scene_dome *d) {
  double w = d->width, h = d->height;
  if (d->mapping == YLM_MAPPING_LATLONG) return YLM_PI / (2 * h) + YLM_PI / w;
  return d->mapping == YLM_MAPPING_ANGULAR ? YLM_PI * sqrt(2) / w : sqrt(2) / w;
}

static double distance(const double a[3], const double b[3]) {
  double s = 0;
  for (int k = 0; k < 3; k++) s += (a[k] - b[k]) * (a[k] - b[k]);
  return sqrt(s);
}

/* The middle of a pixel; of one outside of the disc, the direction behind. */
static void middle(const scene_dome *d, size_t pixel, double out[3]) {
  if (within(d, pixel, 0.5, 0.5, out)) return;
  out[d->up == YLM_UP_Z ? 0 : 2] = d->up == YLM_UP_Z ? -1 : 1;
}

static void bound_tile(const scene_dome *d, const tile *t, const double *power,
                       scene_sky_bound *out) {
  double direction[3], farthest = 0;
  size_t n = t->width * t->height;
  *out = (scene_sky_bound){0};
  for (size_t k = 0; k < n; k++) {
    size_t i = pixel_in(d, t, k);
    middle(d, i, direction);
    for (int a = 0; a < 3; a++) out->mean[a] += (double)d->share[i] * direction[a];
    out->power += power[i] / YLM_PI;
  }
  for (size_t k = 0; k < n; k++) {
    size_t i = pixel_in(d, t, k);
    middle(d, i, direction);
    if (power[i] > 0) farthest = fmax(farthest, distance(direction, out->mean) + radius_of(d));
  }
  for (int a = 0; a < 3; a++) out->mean[a] *= out->power;
  out->spread = farthest * out->power;
}

/* A spread of 4 about no direction is the clamped cosine's, for every normal. */
static void bound_uniform(const scene_dome *d, scene_sky_bound *out) {
  double rgb[3], direction[3] = {0, 0, 1};
  ylm_light_dome_radiance(&d->light, direction, rgb);
  *out = (scene_sky_bound){.power = 4 * ylm_luminance_size(rgb),
                           .spread = 4 * ylm_luminance_size(rgb)};
}

/* -- domes ------------------------------------------------------------------------------------- */

/* Columns and rows of cells; false: there is no memory. */
static bool make_holders(scene_dome *d) {
  const int n[2] = {d->width, d->height};
  for (size_t k = 0; k < 2; k++) {
    d->holder[k] = ylm_alloc((size_t)n[k], sizeof *d->holder[k]);
    for (size_t x = 0; d->holder[k] && x < (size_t)n[k]; x++)
      d->holder[k][x] = (uint32_t)holder_of(x, d->cells[k], n[k]);
  }
  return d->holder[0] && d->holder[1];
}

static ylm_status make_tables(scene_dome *d) {
  size_t n = pixels_of(d);
  double *power = ylm_alloc(n, sizeof *power);
  table x = {.height = ylm_alloc(n, sizeof *x.height),
             .list = ylm_alloc(n, sizeof *x.list),
             .other = ylm_alloc(n, sizeof *x.other),
             .stay = ylm_alloc(n, sizeof *x.stay)};
  d->share = ylm_alloc(n, sizeof *d->share);
  d->keep = ylm_alloc(n, sizeof *d->keep);
  d->other = ylm_alloc(n, sizeof *d->other);
  bool room = make_holders(d) && power && x.height && x.list && x.other && x.stay && d->share &&
              d->keep && d->other;
  if (room) measure(d, power);
  for (size_t i = 0; room && i < d->lights; i++) {
    tile t = tile_at(d, i);
    pair_up(d, &t, power, &x);
    bound_tile(d, &t, power, &d->bound[i]);
  }
  ylm_free(power);
  ylm_free(x.height);
  ylm_free(x.list);
  ylm_free(x.other);
  ylm_free(x.stay);
  return room ? YLM_OK : YLM_ENOMEM;
}

static size_t at_most(size_t n, int pixels) { return n < (size_t)pixels ? n : (size_t)pixels; }

ylm_status ylm__scene_dome_create(scene_dome *d, const ylm_light_dome *light) {
  const ylm_light_panorama *p = light->panorama;
  *d = (scene_dome){.light = *light, .across = 1, .down = 1, .lights = 1};
  if (!(d->references = ylm_alloc(1, sizeof *d->references))) return YLM_ENOMEM;
  *d->references = 1;
  if (light->uniform) {
    d->bound = ylm_alloc(1, sizeof *d->bound);
    if (d->bound) bound_uniform(d, d->bound);
    return d->bound ? YLM_OK : YLM_ENOMEM;
  }
  d->width = TABLE_WIDTH, d->height = TABLE_HEIGHT;
  if (p && p->texel) {
    d->mapping = p->mapping, d->up = p->up;
    d->width = p->width, d->height = p->height;
  }
  const size_t *most = tiles[d->mapping];
  d->across = at_most(most[0], d->width);
  d->down = at_most(most[1], d->height);
  d->cells[0] = at_most(DOME_CELLS * most[0], d->width);
  d->cells[1] = at_most(DOME_CELLS * most[1], d->height);
  d->lights = d->across * d->down;
  d->bound = ylm_alloc(d->lights, sizeof *d->bound);
  return d->bound ? make_tables(d) : YLM_ENOMEM;
}

void ylm__scene_dome_share(const scene_dome *from, scene_dome *d) {
  *d = *from;
  atomic_fetch_add(d->references, 1);
}

void ylm__scene_dome_free(scene_dome *d) {
  if (d->references && atomic_fetch_sub(d->references, 1) > 1) return;
  ylm_free(d->references);
  ylm_free(d->bound);
  ylm_free(d->share);
  ylm_free(d->keep);
  ylm_free(d->other);
  ylm_free(d->holder[0]);
  ylm_free(d->holder[1]);
}

/* A pixel of a tile for u, counted in the tile. */
static uint32_t draw(const scene_dome *d, const tile *t, double u, double *rest) {
  uint32_t n = (uint32_t)(t->width * t->height), k = (uint32_t)(u * (double)n);
  if (k >= n) k = n - 1;
  double f = u * (double)n - (double)k;
  size_t pixel = pixel_in(d, t, k);
  double keep = (double)d->keep[pixel];
  *rest = f < keep ? f / keep : (f - keep) / (1 - keep);
  return f < keep ? k : d->other[pixel];
}

size_t ylm__scene_dome_pixel(const scene_dome *d, size_t i, double u, double *rest) {
  tile t = tile_at(d, i);
  return pixel_in(d, &t, draw(d, &t, u, rest));
}

void ylm__scene_dome_looks(const scene_dome *d, size_t i, double u, size_t *pixel, double *rest,
                           size_t *cell) {
  tile t = tile_at(d, i);
  uint32_t width = (uint32_t)t.width;
  for (size_t q = 0; q < DOME_LOOKS; q++) {
    double at = u + (double)q * 0.61803398874989485;
    uint32_t k = draw(d, &t, at - (double)(int)at, &rest[q]), y = k / width;
    size_t column = t.x + k - y * width, row = t.y + y;
    pixel[q] = row * (size_t)d->width + column;
    cell[q] = cell_at(d, column, row);
  }
}
