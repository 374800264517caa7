/* nodes.c - how much each child of a node of the tree of lamps may bring to a point: the plain form,
   which judges the others, and their choice. */
#include <math.h>

#include "scene.h"
#include "tree.h"
#include "ylm_sets.h"

/* The root of the mean squared cosine at flat lamps; `spread` more is as if it came from all sides. */
static double cosine_of(const scene_node *node, int i, const double v[3], double d2,
                        double spread) {
  double f[6], q;
  for (int k = 0; k < 6; k++) f[k] = (double)node->facing[k][i];
  q = f[0] * v[0] * v[0] + f[1] * v[1] * v[1] + f[2] * v[2] * v[2] +
      2 * (f[3] * v[0] * v[1] + f[4] * v[0] * v[2] + f[5] * v[1] * v[2]);
  return sqrt((fmax(q, 0) + (f[0] + f[1] + f[2]) / 3 * spread) / (d2 + spread));
}

static void nodes(const scene_node *node, bool flat, const float x[3], const float *n, float limit,
                  scene_seen *seen) {
  seen->live = seen->near = seen->doubtful = 0;
  for (int i = 0; i < SCENE_WIDTH; i++) {
    double v[3], d2 = 0, r = (double)node->radius[i];
    for (int a = 0; a < 3; a++) {
      v[a] = (double)node->x[a][i] - (double)x[a];
      d2 += v[a] * v[a];
    }
    double spread = SCENE_SPREAD * (double)node->spread[i];
    double far2 = fmax(d2 + spread, 0.01 * r * r), w = (double)node->power[i] / far2,
           doubt = spread / far2 * w;
    if (d2 < SCENE_NEAR * SCENE_NEAR * r * r) seen->near |= 1u << i;
    if (n) {
      double h = v[0] * (double)n[0] + v[1] * (double)n[1] + v[2] * (double)n[2];
      double over = fmax(0, h + r), soft = fmin(over, 2 * r);
      doubt = (doubt * over + 0.25 * w * fmin(soft, 2 * r - soft)) / sqrt(far2);
      w *= (soft * soft / (4 * r) + (over - soft)) / sqrt(far2);
    }
    if (flat) {
      double cosine = cosine_of(node, i, v, d2, far2 - d2);
      w *= cosine;
      doubt *= cosine;
    }
    seen->weight[i] = node->power[i] > 0 ? (float)w : 0;
    seen->doubt[i] = (float)doubt;
    if (seen->weight[i] > 0) seen->live |= 1u << i;
    if (seen->doubt[i] > limit) seen->doubtful |= 1u << i;
  }
}

YLM_KERNEL_CHOICE(ylm_scene_nodes_fn, ylm__scene_nodes, ylm_k_scene_nodes, nodes);
