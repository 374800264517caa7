/*
** rims_seen.glsl - flat lights seen from a point, arc by arc: csrc/light/flat/contour_polygon.c, contour_ellipse.c.
**
** Rows of a light: normal and sides (0: an ellipse); centroid and a bound of a rim's |y'|; red, green, blue, luminance;
** horizon and whether there is one; vertices, or centre and half axes.
*/
#define LINE 0u  /* arcs: an edge, or along the horizon */
#define STEPPED 1u /* a rim in equal steps */
#define PANEL 2u /* part of one by a rule */
#define CUT_AT 3u  /* a place where a horizon cuts */

shared double arcs[15][ARCS]; /* of rims: c, u, v, facing, middle, half; last the weight of all nodes */
shared uint arc_rule[ARCS], arc_kind[ARCS];
uvec2 panel; /* of a rim that is halved: number, level */
double omega; /* what this invocation has found of solid angles, times radiance */
uint store_at;

void put(uint t, int at, rvec3 v) {
  for (int i = 0; i < 3; i++) arcs[at + i][t] = v[i];
}
rvec3 take(uint t, int at) { return rvec3(arcs[at][t], arcs[at + 1][t], arcs[at + 2][t]); }

/* The shortest rule of at least `least` nodes for so much degree times half angle. */
uint rule_for(double need, double least) {
  uint r = 0, reach = FINE ? 1 : 2;
  while (r < RULES - 1 && (rule[r * RULE_ROW + reach] < need || rule[r * RULE_ROW] < least)) r++;
  return r;
}
/* The degree of sums along an edge. */
uint edge_degree() { return LMAX + ((KINDS & 4) != 0 ? 3 : (KINDS & 2) != 0 ? 1 : 0); }

/* Node i of arc a and its weight. */
node node_of(uint a, uint i, out double weight) {
  node n;
  uint from = arc_rule[a] * RULE_ROW;
  double x = rule[from + 3 + min(i, MOST_NODES - 1)];
  weight = arcs[14][a] * arcs[13][a];
  if (arc_kind[a] == CUT_AT) {
    weight = 1;
    n.s = take(a, 3), n.m = take(a, 0), n.inverse = 0, n.angle = 0;
    return n;
  }
  if (arc_kind[a] == LINE) {
    weight *= rule[from + 3 + MOST_NODES + i];
    arc edge;
    edge.normal = take(a, 0), edge.foot = take(a, 3), edge.along = take(a, 6);
    edge.near = arcs[9][a], edge.middle = arcs[12][a], edge.span = arcs[13][a];
    return arc_node(edge, x);
  }
  if (arc_kind[a] == STEPPED)
    x = (2 * double(i) + 1) * arcs[13][a] / PI - 1;
  else
    weight *= rule[from + 3 + MOST_NODES + i];
  turned half_way = turn(0.5lf * (arcs[12][a] + (arc_kind[a] == STEPPED ? PI : arcs[13][a]) * x));
  double c = half_way.cosine, s = half_way.sine;
  if (arc_kind[a] == STEPPED) weight *= 2;
  return rim_node(take(a, 0), take(a, 3), take(a, 6), take(a, 9), 2 * c * c - 1, 2 * s * c);
}

/* An arc of the great circle from v to w; `moves`: it is of the light's rim. Its nodes, 0 where it has no length. */
uint put_line(rvec3 v, rvec3 w, double weight, bool moves, uint t) {
  rvec3 e = w - v, n = cross(v, e);
  double r0 = sqrt(dot(v, v)), r1 = sqrt(dot(w, w)), size = sqrt(dot(e, e));
  if (!(sqrt(dot(n, n)) > 1e-15lf * r0 * size) || !(size > 0)) return 0;
  arc a = arc_of(v, w, r0, r1, e, size);
  put(t, 0, a.normal), put(t, 3, a.foot), put(t, 6, a.along);
  arcs[9][t] = moves ? a.near : 0.0lf, arcs[12][t] = a.middle, arcs[13][t] = a.span, arcs[14][t] = weight;
  arc_kind[t] = LINE, arc_rule[t] = rule_for(double(edge_degree()) * a.span, 0);
  return uint(rule[arc_rule[t] * RULE_ROW]);
}

/* The solid angle of the triangle a b c with its sign. */
double solid_angle(rvec3 a, rvec3 b, rvec3 c) {
  number z = triangle(a, b, c, sqrt(dot(a, a)), sqrt(dot(b, b)), sqrt(dot(c, c)), cross(b - a, c - a));
  return z.im < 0 ? -2 * argument(z.re, -z.im) : 2 * argument(z.re, z.im);
}

/* The Hessian's term for a horizon that cuts the rim at y, where it runs along dy. */
uint put_cut(rvec3 y, rvec3 dy, rvec3 up, double weight, uint t) {
  double rho = sqrt(dot(y, y)), speed = dot(dy, up);
  if (speed == 0) return 0;
  put(t, 0, cross(y, dy) * (0.5lf * weight / (speed * rho * rho * rho)));
  put(t, 3, y / rho), put(t, 6, up);
  arc_kind[t] = CUT_AT, arc_rule[t] = 0;
  return 1;
}

/* Where the edge between heights ha and hb meets the horizon. */
rvec3 crossing(rvec3 a, rvec3 b, double ha, double hb) { return a + ha / (ha - hb) * (b - a); }

/* Does x, in the polygon's plane, lie in it or on its rim? */
bool polygon_holds(uint row, uint sides, rvec3 x, rvec3 normal) {
  bool on_left = true, on_right = true;
  for (uint k = 0; k < sides; k++) {
    rvec3 a = lamp[row + 4 + k].xyz - x, d = lamp[row + 4 + (k + 1) % sides].xyz - x - a;
    double side = dot(cross(a, d), normal), slack = 1e-15lf * sqrt(dot(a, a) * dot(d, d));
    on_left = on_left && side >= -slack, on_right = on_right && side <= slack;
  }
  return on_left || on_right;
}

/* Which side of its plane a polygon is seen from: 1, -1; 0: edge-on; 2: x is on it. */
double polygon_side(uint row, uint sides, rvec3 x, rvec3 normal) {
  double nearest = 1e300lf, farthest = 0, height = 0;
  for (uint k = 0; k < sides; k++) {
    rvec3 v = lamp[row + 4 + k].xyz - x;
    double d = dot(v, v);
    if (d < nearest) nearest = d, height = dot(v, normal);
    farthest = max(farthest, d);
  }
  if (abs(height) > 1e-15lf * sqrt(farthest)) return height < 0 ? -1.0lf : 1.0lf;
  return polygon_holds(row, sides, x, normal) ? 2.0lf : 0.0lf;
}

/* Edge `edge` of a polygon. */
uint polygon_arc(rvec3 x, uint row, uint sides, uint edge, double radiance, double side, uint t, bool cutting) {
  rvec3 c = lamp[row + 1].xyz - x, up = lamp[row + 3].xyz, v, w;
  double weight = side * radiance;
  bool cuts = CUT && lamp[row + 3].w > 0, moves = edge < sides;
  if (moves) {
    v = lamp[row + 4 + edge].xyz - x, w = lamp[row + 4 + (edge + 1) % sides].xyz - x;
    double ha = cuts ? dot(v, up) : 1.0lf, hb = cuts ? dot(w, up) : 1.0lf;
    if (ha < 0 && hb < 0) return 0;
    if (ha < 0 || hb < 0) {
      rvec3 y = crossing(v, w, ha, hb);
      if (cutting) return put_cut(y, w - v, up, ha < 0 ? -weight : weight, t);
      if (ha < 0) v = y;
      else w = y;
    }
    if (cutting) return 0;
  } else {
    bool leaves = false, enters = false;
    for (uint k = 0; k < sides && !cutting; k++) {
      rvec3 a = lamp[row + 4 + k].xyz - x, b = lamp[row + 4 + (k + 1) % sides].xyz - x;
      double ha = dot(a, up), hb = dot(b, up);
      if (ha >= 0 && hb < 0) v = crossing(a, b, ha, hb), leaves = true;
      if (ha < 0 && hb >= 0) w = crossing(a, b, ha, hb), enters = true;
    }
    if (!leaves || !enters) return 0;
  }
  omega += weight * solid_angle(c, v, w);
  return put_line(v, w, weight, moves, t);
}

/* A disk or an ellipse seen from x: centre, half axes such that it is highest above the horizon at angle 0. */
struct Ellipse {
  rvec3 c, u, v, facing;
  double size, wide; /* bound of |y'|; half the angle that is above the horizon: pi: all, 0: none */
  double sign;
};

/* Its side as polygon_side. */
double ellipse_seen(rvec3 x, uint row, out Ellipse o) {
  rvec3 normal = lamp[row].xyz, up = lamp[row + 3].xyz;
  o.c = lamp[row + 4].xyz - x, o.u = lamp[row + 5].xyz, o.v = lamp[row + 6].xyz;
  o.size = lamp[row + 1].w, o.wide = PI;
  double height = dot(o.c, normal), side = height < 0 ? -1.0lf : 1.0lf;
  double uu = dot(o.u, o.u), vv = dot(o.v, o.v), uv = dot(o.u, o.v), cu = dot(o.c, o.u), cv = dot(o.c, o.v);
  o.facing = side * normal;
  o.sign = dot(cross(o.u, o.v), normal) < 0 ? -side : side;
  if (!(abs(height) > 1e-15lf * (sqrt(dot(o.c, o.c)) + sqrt(uu + vv)))) {
    double det = uu * vv - uv * uv, a = (cu * vv - cv * uv) / det, b = (cv * uu - cu * uv) / det;
    return a * a + b * b <= 1 + 1e-14lf ? 2.0lf : 0.0lf;
  }
  if (CUT && lamp[row + 3].w > 0) {
    double h = dot(o.c, up), hu = dot(o.u, up), hv = dot(o.v, up), swing = sqrt(hu * hu + hv * hv);
    if (h <= -swing) o.wide = 0;
    else if (h < swing) {
      rvec3 u = (hu * o.u + hv * o.v) / swing;
      o.v = (hu * o.v - hv * o.u) / swing, o.u = u;
      double below = h / swing;
      o.wide = argument(-below, sqrt((1 - below) * (1 + below)));
    }
  }
  return side;
}

rvec3 on_rim(Ellipse o, double angle) {
  turned half_way = turn(0.5lf * angle);
  double c = half_way.cosine, s = half_way.sine;
  return o.c + (2 * c * c - 1) * o.u + (2 * s * c) * o.v;
}
rvec3 along_rim(Ellipse o, double angle) {
  turned half_way = turn(0.5lf * angle);
  double c = half_way.cosine, s = half_way.sine;
  return (2 * c * c - 1) * o.v - (2 * s * c) * o.u;
}

/* The next panel of the rim: halved until it is shorter than 4/3 of its distance; `more`: others follow. */
uint put_panel(Ellipse o, double weight, uint t, out bool more) {
  double middle, half_width;
  for (;;) {
    half_width = o.wide / double(1u << panel.y);
    middle = -o.wide + (2 * double(panel.x) + 1) * half_width;
    rvec3 y = on_rim(o, middle);
    if ((1.5lf * half_width * o.size <= sqrt(dot(y, y)) && half_width <= 0.8lf) || panel.y == 31) break;
    panel = uvec2(2 * panel.x, panel.y + 1);
  }
  panel.x++;
  while (panel.y > 0 && panel.x % 2 == 0) panel = uvec2(panel.x / 2, panel.y - 1);
  more = panel.y > 0;
  put(t, 0, o.c), put(t, 3, o.u), put(t, 6, o.v), put(t, 9, o.facing);
  arcs[12][t] = middle, arcs[13][t] = half_width, arcs[14][t] = weight;
  arc_kind[t] = PANEL, arc_rule[t] = rule_for((double(LMAX) + 3) * 0.6lf, FINE ? 24 : 18);
  return uint(rule[arc_rule[t] * RULE_ROW]);
}

/* Equal steps that leave 1e-16, or 1e-10, around a whole rim; 0: too many. csrc/light/flat/contour_ellipse.c */
uint equal_steps(Ellipse o) {
  double cu = dot(o.c, o.u), cv = dot(o.c, o.v);
  double across = dot(o.c, o.c) + o.size * o.size, swing = 2 * sqrt(cu * cu + cv * cv);
  float ratio = float(min(across / max(swing, 1e-300lf), 1e6lf)), digits = FINE ? 37 : 23;
  if (ratio < 1.001) return 0;
  float n = max((digits + 1.5 * LMAX) / (0.7 * acosh(ratio)) + 4, float(LMAX) + 12);
  return n <= STEPS ? uint(ceil(n)) : 0;
}

uint ellipse_arc(Ellipse o, bool chord, rvec3 up, double radiance, uint t, bool cutting, out bool more) {
  double weight = o.sign * radiance;
  bool cut_off = o.wide < PI;
  more = false;
  if (o.wide == 0 || (cutting || chord) && !cut_off) return 0;
  if (cutting) {
    double end = chord ? -o.wide : o.wide;
    return put_cut(on_rim(o, end), along_rim(o, end), up, chord ? -weight : weight, t);
  }
  if (chord) {
    rvec3 from = on_rim(o, o.wide), to = on_rim(o, -o.wide);
    omega += weight * solid_angle(o.facing, normalize(from), normalize(to));
    return put_line(from, to, weight, false, t);
  }
  uint steps = cut_off ? 0 : equal_steps(o);
  if (steps == 0) return put_panel(o, weight, t, more);
  put(t, 0, o.c), put(t, 3, o.u), put(t, 6, o.v), put(t, 9, o.facing);
  arcs[12][t] = 0, arcs[13][t] = PI / double(steps), arcs[14][t] = weight;
  arc_kind[t] = STEPPED, arc_rule[t] = 0;
  return steps;
}

/* The arc of an edge, or of a rim the next, to place t, or where a horizon cuts it; how many nodes it has. */
uint find_arc(rvec3 x, uvec2 which_arc, uint channel, uint t, bool cutting, uint i, out bool more) {
  uint row = which_arc.x, edge = which_arc.y, sides = uint(lamp[row].w);
  double radiance = lamp[row + 2][channel];
  Ellipse o;
  double side = sides > 0 ? polygon_side(row, sides, x, lamp[row].xyz) : ellipse_seen(x, row, o);
  more = false;
  if (side == 2 && edge == 0 && !cutting) {
    omega += 2 * PI * radiance;
    atomicOr(inside[i], 1u);
  }
  if (side == 2 || side == 0) return 0;
  if (sides > 0) return polygon_arc(x, row, sides, edge, radiance, side, t, cutting);
  return ellipse_arc(o, edge > 0, lamp[row + 3].xyz, radiance, t, cutting, more);
}
