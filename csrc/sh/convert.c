/* convert.c - conventions of coefficient vectors and translation between them. */
#include "calibration.h"
#include "ylm_sh.h"

#include <math.h>
#include <string.h>

static const char *const systems[] = {
#define X(name, text) text,
    YLM_SH_SYSTEM_LIST(X)
#undef X
};

static const char permutations[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                        {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};

static bool is_packed(ylm_sh_system s) {
  return s == YLM_SH_SYSTEM_unity || s == YLM_SH_SYSTEM_threejs || s == YLM_SH_SYSTEM_filament;
}

static bool is_e3nn(ylm_sh_system s) {
  return s == YLM_SH_SYSTEM_e3nn || s == YLM_SH_SYSTEM_e3nn_component ||
         s == YLM_SH_SYSTEM_e3nn_norm;
}

/* Systems of even degrees only. */
static bool is_even(ylm_sh_system s) {
  return s == YLM_SH_SYSTEM_mrtrix || s == YLM_SH_SYSTEM_dipy;
}

/* The place of (l, m) there. */
static size_t even_index(int l, int m) { return (size_t)(l * (l + 1) / 2 + m); }

/* The quantity: 0 radiance, 1 irradiance, 2 irradiance over pi. */
static int quantity(uint32_t c) {
  ylm_sh_system s = ylm_sh_convention_system(c);
  if (s == YLM_SH_SYSTEM_unity || s == YLM_SH_SYSTEM_filament) return 2;
  return (c & YLM_SH_IRRADIANCE) != 0;
}

static bool valid(uint32_t c) {
  if (ylm_sh_convention_system(c) >= YLM_SH_SYSTEM_COUNT || (c & ~0x3f3fu) ||
      ylm_sh_convention_axes(c) >= 48)
    return false;
  return !(quantity(c) == 2 && (c & YLM_SH_IRRADIANCE));
}

/* -- words
 * ------------------------------------------------------------------------------------------ */

static bool parse_axes(const char *w, size_t n, uint32_t *axes) {
  int order[3] = {-1, -1, -1}, k = 0, negative = 0;
  for (size_t i = 0; i < n; k++) {
    if (k == 3) return false;
    if (w[i] == '-') negative |= 1 << k, i++;
    if (i == n || w[i] < 'x' || w[i] > 'z') return false;
    order[k] = w[i++] - 'x';
    if (k < 2 ? i == n || w[i++] != ',' : i != n) return false;
  }
  if (k != 3) return false;
  for (uint32_t p = 0; p < 6; p++)
    if (order[0] == permutations[p][0] && order[1] == permutations[p][1] &&
        order[2] == permutations[p][2]) {
      *axes = p * 8 + (uint32_t)negative;
      return true;
    }
  return false;
}

static bool is_word(const char *w, size_t n, const char *text) {
  return strlen(text) == n && memcmp(w, text, n) == 0;
}

/* Second names of systems. */
static const struct {
  const char *word;
  uint32_t system;
} others[] = {{"sphericart", YLM_SH_SYSTEM_plain},
              {"sph_harm_y", YLM_SH_SYSTEM_scipy},
              {"lovr", YLM_SH_SYSTEM_filament}};

ylm_status ylm_sh_convention_parse(const char *text, uint32_t *convention, ylm_error *e) {
  uint32_t c = 0, axes;
  bool system_given = false;
  for (const char *w = text; *w;) {
    size_t n = strcspn(w, " ");
    bool known = n == 0;
    for (uint32_t s = 0; n && !system_given && s < YLM_SH_SYSTEM_COUNT; s++)
      if (is_word(w, n, systems[s])) c |= s, known = system_given = true;
    for (size_t k = 0; !known && !system_given && k < sizeof others / sizeof *others; k++)
      if (is_word(w, n, others[k].word)) c |= others[k].system, known = system_given = true;
    if (!known && is_word(w, n, "irradiance")) c |= YLM_SH_IRRADIANCE, known = true;
    if (!known && is_word(w, n, "radiance")) known = true;
    if (!known && parse_axes(w, n, &axes)) c = (c & 0xffu) | axes << 8, known = true;
    if (!known)
      return ylm_fail(
          e, YLM_EINVAL,
          "'%.*s' is no convention: ylm, plain, sphericart, n3d, sn3d, scipy, sph_harm_y, "
          "unity, three.js, filament, lovr, e3nn, e3nn-component, e3nn-norm, 3dgs, mrtrix or "
          "dipy, with 'irradiance' and axes like 'x,z,-y' behind it",
          (int)(n > 60 ? 60 : n), w);
    w += n + (w[n] == ' ');
  }
  if (!valid(c))
    return ylm_fail(e, YLM_EINVAL, "unity and filament hold irradiance anyway: leave the word out");
  *convention = c;
  return YLM_OK;
}

ylm_status ylm_sh_convention_name(uint32_t c, char text[64]) {
  if (!valid(c)) return YLM_EINVAL;
  int axes = ylm_sh_convention_axes(c),
      n = snprintf(text, 64, "%s", systems[ylm_sh_convention_system(c)]);
  if (c & YLM_SH_IRRADIANCE) n += snprintf(text + n, (size_t)(64 - n), " irradiance");
  for (int i = 0; axes && i < 3; i++)
    n += snprintf(text + n, (size_t)(64 - n), "%s%s%c", i ? "," : " ", axes >> i & 1 ? "-" : "",
                  'x' + permutations[axes / 8][i]);
  return YLM_OK;
}

/* -- one group of vectors, in double ---------------------------------------------------------- */

double ylm_sh_cosine_factor(int l) {
  if (l == 0) return YLM_PI;
  if (l == 1) return 2 * YLM_PI / 3;
  if (l & 1) return 0;
  double a = YLM_PI / 4; /* l = 2; A(l) = -A(l-2) (l-3)/(l+2) */
  for (int k = 4; k <= l; k += 2) a *= -(double)(k - 3) / (k + 2);
  return a;
}

/* The constant before the polynomial of Y(l,m) without phase in the order 1, y, z, x, xy, yz,
   3z^2-1, xz, x^2-y^2. */
static double polynomial_constant(int i) {
  static const double square[9] = {1, 3, 3, 3, 15, 15, 1.25, 15, 3.75}; /* times 1/4pi */
  return sqrt(square[i] / (4 * YLM_PI));
}

/* Factor from radiance without phase to what `system` holds, but for its quantity; real systems. */
static double normalisation(ylm_sh_system s, int l) {
  switch (s) {
  case YLM_SH_SYSTEM_n3d: return sqrt(4 * YLM_PI);
  case YLM_SH_SYSTEM_sn3d: return sqrt(4 * YLM_PI / (2 * l + 1));
  case YLM_SH_SYSTEM_e3nn_component: return sqrt(1 / (4 * YLM_PI));
  case YLM_SH_SYSTEM_e3nn_norm: return sqrt((2 * l + 1) / (4 * YLM_PI));
  default: return 1;
  }
}

typedef struct shape {
  ylm_sh_system system;
  int lmax;
  size_t count, channels, numbers; /* numbers in a group of `channels` vectors */
} shape;

static shape shape_of(ylm_sh_system s, int lmax) {
  size_t count = ylm_sh_count(lmax);
  switch (s) {
  case YLM_SH_SYSTEM_scipy: return (shape){s, lmax, count, 1, 2 * count};
  case YLM_SH_SYSTEM_unity: return (shape){s, lmax, count, 3, 28};
  case YLM_SH_SYSTEM_threejs:
  case YLM_SH_SYSTEM_filament:
  case YLM_SH_SYSTEM_splats: return (shape){s, lmax, count, 3, 3 * count};
  case YLM_SH_SYSTEM_mrtrix:
  case YLM_SH_SYSTEM_dipy: return (shape){s, lmax, count, 1, even_index(lmax, lmax) + 1};
  default: return (shape){s, lmax, count, 1, count};
  }
}

/* x: a group in its own shape; c [channels][count]: ylm's system, same quantity and axes. */
static void decode(const shape *f, const double *x, double *c) {
  const double h = sqrt(0.5);
  for (int l = 0; l <= f->lmax; l++)
    for (int m = -l; m <= l; m++) {
      size_t i = ylm_sh_index(l, m), opposite = ylm_sh_index(l, -m);
      double phase = m & 1 ? -1 : 1;
      for (size_t k = 0; k < f->channels; k++) {
        double *to = c + k * f->count + i;
        switch (f->system) {
        case YLM_SH_SYSTEM_ylm: *to = x[i]; break;
        case YLM_SH_SYSTEM_scipy: /* a(l,m) = (c(l,m) - i c(l,-m))/sqrt 2, a(l,-m) = (-1)^m conj;
                                     both are read */
          if (m == 0)
            *to = x[2 * i];
          else if (m > 0)
            *to = h * (x[2 * i] + phase * x[2 * opposite]);
          else
            *to = -h * (x[2 * opposite + 1] - phase * x[2 * i + 1]);
          break;
        case YLM_SH_SYSTEM_threejs: *to = phase * x[3 * i + k]; break;
        case YLM_SH_SYSTEM_splats: *to = x[3 * i + k]; break;
        case YLM_SH_SYSTEM_mrtrix: *to = l & 1 ? 0 : x[even_index(l, m)]; break;
        case YLM_SH_SYSTEM_dipy: *to = l & 1 ? 0 : x[even_index(l, -m)]; break;
        case YLM_SH_SYSTEM_filament:
          *to = phase * x[3 * i + k] / polynomial_constant((int)i);
          break;
        case YLM_SH_SYSTEM_unity: {
          const double *a = x + 4 * k, *b = x + 12 + 4 * k;
          double s[9] = {a[3] + b[2] / 3, a[1], a[2], a[0], b[0], b[1], b[2] / 3, b[3], x[24 + k]};
          *to = phase * s[i] / polynomial_constant((int)i);
          break;
        }
        default: *to = phase * x[i] / normalisation(f->system, l);
        }
      }
    }
}

/* The other way. */
static void encode(const shape *f, const double *c, double *x) {
  const double h = sqrt(0.5);
  for (size_t k = 0; k < f->channels; k++) {
    const double *from = c + k * f->count;
    double s[9];
    for (int l = 0; l <= f->lmax; l++)
      for (int m = -l; m <= l; m++) {
        size_t i = ylm_sh_index(l, m), positive = ylm_sh_index(l, m < 0 ? -m : m),
               negative = ylm_sh_index(l, m < 0 ? m : -m);
        double phase = m & 1 ? -1 : 1;
        switch (f->system) {
        case YLM_SH_SYSTEM_ylm: x[i] = from[i]; break;
        case YLM_SH_SYSTEM_scipy:
          if (m == 0)
            x[2 * i] = from[i], x[2 * i + 1] = 0;
          else if (m > 0)
            x[2 * i] = h * from[positive], x[2 * i + 1] = -h * from[negative];
          else
            x[2 * i] = phase * h * from[positive], x[2 * i + 1] = phase * h * from[negative];
          break;
        case YLM_SH_SYSTEM_threejs: x[3 * i + k] = phase * from[i]; break;
        case YLM_SH_SYSTEM_splats: x[3 * i + k] = from[i]; break;
        case YLM_SH_SYSTEM_mrtrix:
          if (l % 2 == 0) x[even_index(l, m)] = from[i];
          break;
        case YLM_SH_SYSTEM_dipy:
          if (l % 2 == 0) x[even_index(l, -m)] = from[i];
          break;
        case YLM_SH_SYSTEM_filament:
          x[3 * i + k] = phase * from[i] * polynomial_constant((int)i);
          break;
        case YLM_SH_SYSTEM_unity: s[i] = phase * from[i] * polynomial_constant((int)i); break;
        default: x[i] = phase * from[i] * normalisation(f->system, l);
        }
      }
    if (f->system == YLM_SH_SYSTEM_unity) {
      double *a = x + 4 * k, *b = x + 12 + 4 * k;
      a[0] = s[3], a[1] = s[1], a[2] = s[2], a[3] = s[0] - s[6];
      b[0] = s[4], b[1] = s[5], b[2] = 3 * s[6], b[3] = s[7];
      x[24 + k] = s[8];
      x[27] = 1;
    }
  }
}

/* The x, y, z of the convention's basis as rows: its axes, which e3nn takes in the order z, x, y. Returns the
   determinant. */
static int axes_matrix(uint32_t convention, double a[9]) {
  int axes = ylm_sh_convention_axes(convention), p = axes / 8;
  int turn = is_e3nn(ylm_sh_convention_system(convention)) ? 1 : 0;
  memset(a, 0, 9 * sizeof *a);
  for (int i = 0; i < 3; i++) a[3 * ((i + turn) % 3) + permutations[p][i]] = axes >> i & 1 ? -1 : 1;
  int swapped = p == 1 || p == 2 || p == 5,
      negatives = (axes & 1) + (axes >> 1 & 1) + (axes >> 2 & 1);
  return (swapped + negatives) & 1 ? -1 : 1;
}

/* The matrix from functions in the axes of `from` to those of `to`: a rotation, or minus one. */
static bool change_of_axes(uint32_t from, uint32_t to, double r[9], bool *mirrored) {
  if (ylm_sh_convention_axes(from) == ylm_sh_convention_axes(to) &&
      is_e3nn(ylm_sh_convention_system(from)) == is_e3nn(ylm_sh_convention_system(to)))
    return false;
  double f[9], t[9];
  *mirrored = axes_matrix(from, f) * axes_matrix(to, t) < 0;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      double sum = 0;
      for (int k = 0; k < 3; k++) sum += t[3 * i + k] * f[3 * j + k];
      r[3 * i + j] = *mirrored ? -sum : sum;
    }
  return true;
}

static ylm_status check(uint32_t from, uint32_t to, int lmax, size_t rows, ylm_error *e) {
  if (!valid(from) || !valid(to)) return ylm_fail(e, YLM_EINVAL, "no such convention");
  if (lmax < 0 || lmax > YLM_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax must be from 0 to %d", YLM_LMAX);
  for (int i = 0; i < 2; i++) {
    ylm_sh_system s = ylm_sh_convention_system(i ? to : from);
    if (is_even(s) && lmax % 2)
      return ylm_fail(e, YLM_ERANGE,
                      "'%s' holds even degrees, got lmax %d (sh.resize cuts or extends)",
                      systems[s], lmax);
    if (s == YLM_SH_SYSTEM_splats && rows % 3)
      return ylm_fail(e, YLM_ESHAPE, "'%s' holds three channels", systems[s]);
    if (!is_packed(s)) continue;
    if (lmax != 2)
      return ylm_fail(e, YLM_ERANGE, "'%s' holds lmax 2, got lmax %d (sh.resize cuts or extends)",
                      systems[s], lmax);
    if (rows % 3) return ylm_fail(e, YLM_ESHAPE, "'%s' holds three channels", systems[s]);
  }
  if (quantity(from) && !quantity(to) && lmax > 2)
    return ylm_fail(
        e, YLM_EDOMAIN,
        "irradiance holds nothing of degree 3: radiance up to lmax 2 can be had, got lmax %d",
        lmax);
  return YLM_OK;
}

typedef struct job {
  const shape *from, *to;
  size_t channels;         /* of a group: as many as the larger of the two shapes holds */
  const double *factor;    /* [lmax+1] */
  const ylm_sh_rotator *p; /* where axes change: by r */
  const double *r;
  bool mirrored;
  ylm_dtype t;
  const void *in;
  void *out;
} job;

/* Groups begin .. end-1. */
static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  const shape *f = j->from, *g = j->to;
  size_t channels = j->channels, nf = f->numbers * channels / f->channels,
         ng = g->numbers * channels / g->channels;
  /* a complex vector has 2 numbers a coefficient, unity's group of three 28 */
  size_t room = channels * 2 * f->count + 4;
  double *x = ylm_alloc(4 * room, sizeof *x), *c = x + room, *d = c + room, *y = d + room;
  if (!x) return YLM_ENOMEM;
  ylm_status s = YLM_OK;
  for (size_t group = begin; group < end && s == YLM_OK; group++) {
    for (size_t i = 0; i < nf; i++) x[i] = ylm_get(j->t, j->in, group * nf + i);
    for (size_t k = 0; k < channels; k += f->channels)
      decode(f, x + k * f->numbers, c + k * f->count);
    for (size_t k = 0; k < channels; k++)
      for (int l = 0; l <= f->lmax; l++)
        for (int m = -l; m <= l; m++)
          c[k * f->count + ylm_sh_index(l, m)] *=
              j->mirrored && (l & 1) ? -j->factor[l] : j->factor[l];
    if (j->p)
      s = ylm_sh_rotate(j->p, j->r, f->lmax, YLM_DOUBLE, channels, c, d, 1, NULL, NULL);
    else
      memcpy(d, c, channels * f->count * sizeof *d);
    for (size_t k = 0; k < channels; k += g->channels)
      encode(g, d + k * f->count, y + k * g->numbers);
    for (size_t i = 0; i < ng; i++) {
      if (j->t == YLM_DOUBLE)
        ((double *)j->out)[group * ng + i] = y[i];
      else
        ((float *)j->out)[group * ng + i] = (float)y[i];
    }
  }
  ylm_free(x);
  return s;
}

ylm_status ylm_sh_convert(uint32_t from, uint32_t to, int lmax, ylm_dtype t, size_t rows,
                          const void *in, void *out, int threads, const ylm_progress *progress,
                          ylm_error *e) {
  ylm_status s = check(from, to, lmax, rows, e);
  if (s != YLM_OK) return s;
  shape f = shape_of(ylm_sh_convention_system(from), lmax),
        g = shape_of(ylm_sh_convention_system(to), lmax);
  size_t channels = f.channels > g.channels ? f.channels : g.channels;
  double r[9];
  bool mirrored = false;
  ylm_sh_rotator *p = NULL;
  if (change_of_axes(from, to, r, &mirrored)) s = ylm_sh_rotator_create(lmax, &p, e);
  if (s != YLM_OK) return s;
  double *factor = ylm_alloc((size_t)lmax + 1, sizeof *factor);
  if (!factor) s = YLM_ENOMEM;
  if (s == YLM_OK) {
    int qf = quantity(from), qt = quantity(to);
    for (int l = 0; l <= lmax; l++) {
      double a = qf && qt ? 1 : qt ? ylm_sh_cosine_factor(l) : qf ? 1 / ylm_sh_cosine_factor(l) : 1;
      factor[l] = a * (qf == 2 ? YLM_PI : 1) / (qt == 2 ? YLM_PI : 1);
    }
    job j = {&f, &g, channels, factor, p, r, mirrored, t, in, out};
    size_t groups = rows / channels;
    s = groups <= 256 && !progress
            ? run(&j, 0, groups, 0)
            : ylm_parallel(groups, CONVERT_GRAIN, threads, run, &j, progress, "convert");
  }
  ylm_free(factor);
  ylm_sh_rotator_free(p);
  return s;
}
