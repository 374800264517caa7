/* part.c - some pixels of a view, as a view of their own. */
#include <string.h>

#include "view.h"
#include "ylm_sh.h"

/* Rows [of `size` bytes] of `from` for the points of all pixels of the part. */
static void *pick(const ylm_shade_view *whole, const ylm_shade_view *part, const void *from,
                  size_t size) {
  char *to = from ? ylm_alloc(part->points, size) : NULL;
  for (size_t p = 0; to && p < part->stats.pixels; p++) {
    const shade_pixel *q = &whole->pixel[part->number[p]];
    ylm_copy(to + part->pixel[p].first * size, (const char *)from + q[0].first * size,
             (q[1].first - q[0].first) * size);
  }
  return to;
}

static bool pick_pixels(const ylm_shade_view *whole, ylm_shade_view *part, const uint32_t *pixel) {
  size_t n = part->stats.pixels, first = 0;
  part->number = ylm_alloc_copy(pixel, n, sizeof *pixel);
  part->pixel = ylm_alloc_zero(n + 1, sizeof *part->pixel);
  if (!part->number || !part->pixel) return false;
  for (size_t i = 0; i < n; i++) {
    const shade_pixel *q = &whole->pixel[pixel[i]];
    part->pixel[i] = *q;
    part->pixel[i].first = first;
    first += q[1].first - q[0].first;
  }
  part->pixel[n].first = part->points = part->entries = part->stats.points = first;
  return true;
}

ylm_status ylm_shade_view_part(const ylm_shade_view *whole, size_t n, const uint32_t *pixel,
                               ylm_shade_view **part, ylm_error *e) {
  *part = NULL;
  if (whole->corner) return ylm_fail(e, YLM_EINVAL, "a view per vertex has no parts");
  if (n > 65536) return ylm_fail(e, YLM_ERANGE, "a part has at most 65536 pixels");
  for (size_t i = 0; i < n; i++)
    if (pixel[i] >= whole->stats.pixels)
      return ylm_fail(e, YLM_ERANGE, "pixel %u is not one of %zu", pixel[i], whole->stats.pixels);
  ylm_shade_view *v = ylm_alloc_zero(1, sizeof *v);
  if (!v) return YLM_ENOMEM;
  v->scene = whole->scene;
  v->o = whole->o;
  v->frame = whole->frame;
  v->o.width = (int)n;
  v->o.height = 1;
  v->stats = (ylm_shade_stats){.pixels = n, .noise = -1};
  bool ok = pick_pixels(whole, v, pixel);
  if (ok) {
    v->entry = pick(whole, v, whole->entry, sizeof *v->entry);
    v->mesh = pick(whole, v, whole->mesh, sizeof *v->mesh);
    v->position = pick(whole, v, whole->position, sizeof *v->position);
    v->normal = pick(whole, v, whole->normal, sizeof *v->normal);
    v->origin = pick(whole, v, whole->origin, sizeof *v->origin);
    v->transfer = pick(whole, v, whole->transfer, ylm_sh_count(v->o.lmax) * sizeof *v->transfer);
    v->seen = v->tint = pick(whole, v, whole->seen, sizeof *v->seen);
    ok = v->entry && v->mesh && v->position && v->normal && v->origin &&
         (v->transfer || !whole->transfer) && (v->seen || !whole->seen);
  }
  if (!ok) {
    ylm_shade_view_free(v);
    return YLM_ENOMEM;
  }
  *part = v;
  return YLM_OK;
}
