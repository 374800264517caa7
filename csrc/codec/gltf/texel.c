/* texel.c - means of texels under triangles: alpha that cuts triangles off, groups of one colour. */
#include <math.h>
#include <stdlib.h>

#include "gltf.h"

/* The mean of a triangle's texels. */
typedef struct swatch {
  float colour[3], alpha;
  float area;
  uint32_t triangle;
} swatch;

/* An image as it is looked up. */
typedef struct source {
  const ylm_layer *layer;
  size_t width, height;
  const ylm_texture_wrap *wrap;
} source;

/* -- means over triangles ------------------------------------------------------------------- */

static size_t texel_of(ylm_texture_wrap wrap, double x, size_t n) {
  size_t i = (size_t)(ylm_texture_fold(wrap, x) * (double)n);
  return i < n ? i : n - 1;
}

/* Adds the texel at u, v: red, green, blue, alpha. */
static void add_texel(const source *s, double u, double v, double sum[4]) {
  size_t column = texel_of(s->wrap[0], u, s->width), row = texel_of(s->wrap[1], 1 - v, s->height);
  size_t k = (size_t)s->layer->channels;
  const float *t = s->layer->data + (row * s->width + column) * k;
  for (size_t c = 0; c < 3; c++) sum[c] += (double)t[k < 3 ? 0 : c];
  sum[3] += k % 2 == 0 ? (double)t[k - 1] : 1;
}

/* The mean at the centres of k^2 triangles that make up one with these texture coordinates. */
static void mean_of(const source *s, const float *const uv[3], size_t k, double mean[4]) {
  double edge[2][2];
  for (int a = 0; a < 2; a++)
    for (int c = 0; c < 2; c++) edge[c][a] = ((double)uv[c + 1][a] - (double)uv[0][a]) / (double)k;
  for (int c = 0; c < 4; c++) mean[c] = 0;
  for (size_t j = 0; j < k; j++)
    for (size_t i = 0; i < 2 * (k - j) - 1; i++) { /* every other one is turned */
      double third = i % 2 ? 2.0 / 3 : 1.0 / 3, x = (double)(i / 2) + third, y = (double)j + third;
      add_texel(s, (double)uv[0][0] + x * edge[0][0] + y * edge[1][0],
                (double)uv[0][1] + x * edge[0][1] + y * edge[1][1], mean);
    }
  for (int c = 0; c < 4; c++) mean[c] /= (double)(k * k);
}

/* Looks at texels that a triangle is worth: 16 each, at least 256. */
static double looks_at(const source *s, const float *const uv[3]) {
  double u[2], v[2];
  for (int a = 0; a < 2; a++) {
    u[a] = (double)uv[1][a] - (double)uv[0][a];
    v[a] = (double)uv[2][a] - (double)uv[0][a];
  }
  double n = fabs(u[0] * v[1] - u[1] * v[0]) / 2 * (double)s->width * (double)s->height;
  return n > 16 ? 16 * fmin(n, 1 << 20) : 256;
}

static void corners_uv(const ylm_mesh *m, size_t t, const float *uv[3]) {
  for (int c = 0; c < 3; c++) uv[c] = m->uv + 2 * (size_t)m->index[3 * t + (size_t)c];
}

static double area_of(const ylm_mesh *m, size_t t) {
  double u[3], v[3], sum = 0;
  const uint32_t *k = m->index + 3 * t;
  for (size_t a = 0; a < 3; a++) {
    double p = (double)m->position[3 * (size_t)k[0] + a];
    u[a] = (double)m->position[3 * (size_t)k[1] + a] - p;
    v[a] = (double)m->position[3 * (size_t)k[2] + a] - p;
  }
  for (int a = 0; a < 3; a++) {
    double c = u[(a + 1) % 3] * v[(a + 2) % 3] - u[(a + 2) % 3] * v[(a + 1) % 3];
    sum += c * c;
  }
  return sqrt(sum) / 2;
}

/* Fewer looks where the file's allowance does not reach. A multiple of four along an edge meets borders of texels. */
static void fill_colours(gltf *g, const ylm_mesh *m, const source *s, swatch *w) {
  const float *uv[3];
  double wanted = 0;
  for (size_t t = 0; t < m->triangles; t++) {
    corners_uv(m, t, uv);
    wanted += looks_at(s, uv);
  }
  double part = wanted > g->lookups ? g->lookups / wanted : 1;
  g->lookups -= wanted * part;
  for (size_t t = 0; t < m->triangles; t++) {
    double mean[4];
    corners_uv(m, t, uv);
    double k = sqrt(part * looks_at(s, uv));
    mean_of(s, uv, k > 4 ? 4 * (size_t)ceil(k / 4) : k > 1 ? (size_t)k : 1, mean);
    for (int c = 0; c < 3; c++) w[t].colour[c] = (float)mean[c];
    w[t].alpha = (float)mean[3];
  }
}

/* A swatch for each triangle; NULL and a failure. */
static swatch *swatches(gltf *g, const ylm_mesh *m, const float *alpha, const source *s) {
  swatch *w = ylm__gltf_alloc(g, m->triangles, sizeof *w);
  if (!w) return NULL;
  for (size_t t = 0; t < m->triangles; t++)
    w[t] = (swatch){{1, 1, 1}, 1, (float)area_of(m, t), (uint32_t)t};
  if (s) fill_colours(g, m, s, w);
  for (size_t t = 0; alpha && t < m->triangles; t++) {
    const uint32_t *k = m->index + 3 * t;
    w[t].alpha *= (alpha[k[0]] + alpha[k[1]] + alpha[k[2]]) / 3;
  }
  return w;
}

/* -- groups: median cut --------------------------------------------------------------------- */

/* Swatches `first` to first + count - 1, and the channel along which they differ most. */
typedef struct box {
  size_t first, count;
  int channel;
  double spread; /* sum of area times squared distance to the mean along it */
} box;

static void measure(const swatch *w, box *b) {
  b->spread = 0;
  b->channel = 0;
  for (int c = 0; c < 3; c++) {
    double area = 0, sum = 0, squares = 0;
    for (size_t i = b->first; i < b->first + b->count; i++) area += (double)w[i].area;
    for (size_t i = b->first; i < b->first + b->count; i++)
      sum += (double)w[i].area * (double)w[i].colour[c];
    double mean = area > 0 ? sum / area : 0;
    for (size_t i = b->first; i < b->first + b->count; i++) {
      double d = (double)w[i].colour[c] - mean;
      squares += (double)w[i].area * d * d;
    }
    if (squares <= b->spread) continue;
    b->spread = squares;
    b->channel = c;
  }
}

#define BY(name, c)                                                                                \
  static int name(const void *a, const void *b) {                                                  \
    const swatch *x = a, *y = b;                                                                   \
    if (x->colour[c] != y->colour[c]) return x->colour[c] < y->colour[c] ? -1 : 1;                 \
    return (x->triangle > y->triangle) - (x->triangle < y->triangle);                              \
  }
BY(by_red, 0)
BY(by_green, 1)
BY(by_blue, 2)

/* Cuts a box where half of its area is on either side; false where its colours are all alike. */
static bool cut_box(swatch *w, box *b, box *rest) {
  static int (*const by[3])(const void *, const void *) = {by_red, by_green, by_blue};
  if (b->count < 2 || !(b->spread > 0)) return false;
  qsort(w + b->first, b->count, sizeof *w, by[b->channel]);
  double area = 0, sum = 0;
  for (size_t i = 0; i < b->count; i++) area += (double)w[b->first + i].area;
  size_t n = 0;
  do sum += (double)w[b->first + n++].area;
  while (n + 1 < b->count && sum < area / 2);
  size_t least =
      (b->count + 15) / 16; /* few cuts of many triangles: no more than 16 sorts of all */
  n = n < least ? least : n > b->count - least ? b->count - least : n;
  *rest = (box){.first = b->first + n, .count = b->count - n};
  b->count = n;
  measure(w, b);
  measure(w, rest);
  return true;
}

/* Orders swatches into at most `most` boxes; their number. */
static size_t make_boxes(swatch *w, size_t n, size_t most, box *b) {
  size_t boxes = 1;
  b[0] = (box){.count = n};
  measure(w, b);
  while (boxes < most) {
    size_t widest = 0;
    for (size_t i = 1; i < boxes; i++)
      if (b[i].spread > b[widest].spread) widest = i;
    if (!cut_box(w, &b[widest], &b[boxes])) break;
    boxes++;
  }
  return boxes;
}

/* -- parts -------------------------------------------------------------------------------------- */

/* Area-weighted means of swatches; equal weights where nothing has an area. */
static void average(const swatch *w, size_t n, gltf_part *p) {
  double area = 0, sum[4] = {0};
  for (size_t i = 0; i < n; i++) area += (double)w[i].area;
  for (size_t i = 0; i < n; i++) {
    double weight = area > 0 ? (double)w[i].area / area : 1 / (double)n;
    for (int c = 0; c < 3; c++) sum[c] += weight * (double)w[i].colour[c];
    sum[3] += weight * (double)w[i].alpha;
  }
  for (int c = 0; c < 3; c++) p->tint[c] = (float)fmin(1, sum[c]);
  p->alpha = (float)fmin(1, sum[3]);
}

/* Moves the swatches of triangles that are seen to the front; their number. */
static size_t cut_off(const ylm_gltf_material *m, swatch *w, size_t n) {
  size_t kept = 0;
  for (size_t i = 0; i < n; i++)
    if (m->base[3] * w[i].alpha >= m->cutoff) w[kept++] = w[i];
  return kept;
}

/* A mesh for each box of swatches; m stands for one that has all triangles. */
static void split(gltf *g, ylm_mesh **m, const swatch *w, const box *b, size_t boxes,
                  gltf_part *part) {
  ylm_mesh_groups groups = {.names = boxes, .triangles = (*m)->triangles};
  if (boxes == 1 && b[0].count == (*m)->triangles) {
    part[0].mesh = *m;
    *m = NULL;
    return;
  }
  ylm_mesh **mesh = ylm__gltf_alloc(g, boxes + 1, sizeof(ylm_mesh *));
  groups.group = ylm__gltf_alloc(g, groups.triangles, sizeof *groups.group);
  for (size_t k = 0; g->status == YLM_OK && k < boxes; k++)
    for (size_t i = 0; i < b[k].count; i++)
      groups.group[w[b[k].first + i].triangle] = (uint32_t)k + 1;
  if (g->status == YLM_OK) g->status = ylm_mesh_split(*m, &groups, mesh, g->e);
  for (size_t k = 0; g->status == YLM_OK && k < boxes; k++) part[k].mesh = mesh[k + 1];
  if (g->status == YLM_OK) ylm_mesh_free(mesh[0]); /* triangles that are cut off */
  ylm_free(mesh);
  ylm_free(groups.group);
}

static bool has_alpha(const source *s) { return s && s->layer->channels % 2 == 0; }

/* The image of a material on a mesh; false where it has none. */
static bool find_source(const gltf *g, const ylm_gltf_material *m, const ylm_mesh *mesh,
                        source *s) {
  if (!m || m->base_image < 0 || !mesh->uv) return false;
  const ylm_image *image = g->out->image[m->base_image];
  *s = (source){&image->layer[0], (size_t)image->width, (size_t)image->height, m->base_wrap};
  return true;
}

static bool emits(const ylm_gltf_material *m) {
  return m->emission[0] > 0 || m->emission[1] > 0 || m->emission[2] > 0;
}

size_t ylm__gltf_parts(gltf *g, ylm_mesh *m, const float *alpha, int32_t material, gltf_part **part,
                       size_t *cut) {
  const ylm_gltf_material *of = material < 0 ? NULL : &g->out->material[material];
  source from, *s = find_source(g, of, m, &from) ? &from : NULL;
  bool cuts = of && of->alpha == YLM_GLTF_MASK && (alpha || has_alpha(s));
  bool blends = of && of->alpha == YLM_GLTF_BLEND && (alpha || has_alpha(s));
  bool grouped = s && g->o->groups > 0 && !emits(of);
  size_t most = grouped ? (size_t)g->o->groups : 1, n = m->triangles, boxes = 1;
  if (most > n) most = n;
  box *b = ylm__gltf_alloc(g, most, sizeof *b);
  *part = ylm__gltf_alloc(g, most, sizeof **part);
  swatch *w = cuts || blends || grouped ? swatches(g, m, alpha, s) : NULL;
  if (g->status == YLM_OK) {
    (*part)[0].alpha = 1;
    b[0].count = n;
    if (cuts) b[0].count = cut_off(of, w, n);
    *cut += n - b[0].count;
    if (grouped && b[0].count > 0) boxes = make_boxes(w, b[0].count, most, b);
    for (size_t k = 0; w && k < boxes; k++) {
      average(w + b[k].first, b[k].count, *part + k);
      (*part)[k].grouped = grouped;
    }
    if (b[0].count > 0) split(g, &m, w, b, boxes, *part);
  }
  bool none = g->status != YLM_OK || b[0].count == 0;
  ylm_mesh_free(m);
  ylm_free(b);
  ylm_free(w);
  return none ? 0 : boxes;
}
