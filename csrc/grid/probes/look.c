/* look.c - irradiance that is read from bricks. */
#include "probes.h"

/* A leaf, in roots. */
typedef struct probes_leaf {
  uint32_t cell;
  double low[3], edge;
} probes_leaf;

static probes_leaf leaf_at(const ylm_grid_probes *p, const double u[3]) {
  probes_leaf l = {.edge = 1};
  uint32_t stride = 1;
  for (int a = 0; a < 3; a++) {
    uint32_t i = u[a] > 0 ? (uint32_t)fmin(u[a], p->roots[a] - 1.0) : 0;
    l.low[a] = i;
    l.cell += stride * i;
    stride *= p->roots[a];
  }
  while (p->parts[l.cell] == PROBES_SPLIT) {
    uint32_t child = 0;
    l.edge /= 2;
    for (uint32_t a = 0; a < 3; a++) {
      bool up = u[a] >= l.low[a] + l.edge;
      child |= (uint32_t)up << a;
      l.low[a] += up ? l.edge : 0;
    }
    l.cell = p->first[l.cell] + child;
  }
  return l;
}

uint8_t ylm__probes_side(const probes_cut *c, const double at[3]) {
  size_t index = 0;
  for (size_t k = 0; k < c->planes; k++) {
    double height = 0;
    for (int a = 0; a < 3; a++) height += c->normal[k][a] / PROBES_NORMAL * at[a];
    index |= (size_t)(height >= c->offset[k] / PROBES_OFFSET) << k;
  }
  return c->part[index];
}

probes_front ylm__probes_front(const ylm_grid_probes *p, const double x[3], const float normal[3]) {
  double u[3], front[3], scale[3], thick = 0;
  for (int a = 0; a < 3; a++) {
    scale[a] = p->roots[a] / (p->bounds[a + 3] - p->bounds[a]);
    u[a] = fmin(fmax((x[a] - p->bounds[a]) * scale[a], 0), p->roots[a]);
  }
  probes_leaf l = leaf_at(p, u);
  for (int a = 0; normal && a < 3; a++)
    thick += PROBES_FRONT * l.edge * fabs((double)normal[a]) / scale[a];
  for (int a = 0; a < 3; a++) front[a] = u[a] + (normal ? thick * (double)normal[a] * scale[a] : 0);
  l = leaf_at(p, front);
  probes_front f = {.cell = l.cell};
  for (int a = 0; a < 3; a++) {
    f.at[a] = (u[a] - l.low[a]) / l.edge;
    f.front[a] = (front[a] - l.low[a]) / l.edge;
  }
  return f;
}

probes_place ylm__probes_find(const ylm_grid_probes *p, const double x[3], const float normal[3]) {
  probes_front f = ylm__probes_front(p, x, normal);
  probes_place at = {YLM_GRID_NONE, {0, 0, 0}};
  if (!p->parts[f.cell]) return at;
  uint32_t row = p->row[f.cell];
  at.brick =
      p->first[f.cell] + (row == YLM_GRID_NONE ? 0 : ylm__probes_side(&p->cut[row], f.front));
  for (int a = 0; a < 3; a++) at.t[a] = (float)fmin(fmax(f.at[a], 0), 1);
  return at;
}

void ylm__probes_shares(const probes_place *at, float share[8]) {
  for (int k = 0; k < 8; k++) {
    share[k] = at->brick == YLM_GRID_NONE ? 0 : 1;
    for (int a = 0; a < 3; a++) share[k] *= k >> a & 1 ? at->t[a] : 1 - at->t[a];
  }
}

const float ylm__probes_norm[9] = {1,        1.f / 3, 1.f / 3,  1.f / 3, 1.f / 15,
                                   1.f / 15, 4.f / 5, 1.f / 15, 4.f / 15};

void ylm__probes_basis(const float n[3], float basis[9]) {
  float x = n[0], y = n[1], z = n[2];
  const float all[9] = {1, y, z, x, x * y, y * z, 3 * z * z - 1, x * z, x * x - y * y};
  for (int k = 0; k < 9; k++) basis[k] = all[k];
}

void ylm_grid_probes_irradiance(const ylm_grid_probes *p, size_t n, const double (*points)[3],
                                const float (*normals)[3], float (*out)[3]) {
  size_t count = (size_t)p->count;
  for (size_t i = 0; i < n; i++) {
    float share[8], basis[9];
    probes_place at = ylm__probes_find(p, points[i], normals[i]);
    ylm__probes_shares(&at, share);
    ylm__probes_basis(normals[i], basis);
    for (size_t c = 0; c < 3; c++) {
      double sum = 0;
      for (size_t k = 0; at.brick != YLM_GRID_NONE && k < 8; k++) {
        const float *v = p->value + (p->corner[at.brick][k] * 3 + c) * count;
        double s = 0;
        for (size_t j = 0; j < count; j++) s += (double)basis[j] * (double)v[j];
        sum += (double)share[k] * s;
      }
      out[i][c] = (float)fmax(0, sum);
    }
  }
}
