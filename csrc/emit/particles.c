/* particles.c - particles from lamps to surfaces, and on from there. */
#include "emit.h"
#include "ylm_list.h"

/* Particles that are traced together. */
#define GRAIN 256
/* Blocks of these, at least, whose landings are kept before they are put into order. */
#define WAVE 64
/* The bound of the chance to be reflected once more. */
#define MOST_CHANCE 0.95

typedef struct particle {
  ylm_rng rng;
  double power[3], solid;
  uint32_t number;
} particle;

/* Landings and counts of a block of particles; blocks are added up in their order. */
typedef struct block {
  emit_landing *landing; /* its own, or its part of all */
  size_t n, room, begin; /* of all landings, its first */
  ylm_emit_report counts;
} block;

/* The particles of a block that are under way. */
typedef struct flight {
  size_t n;
  particle p[GRAIN];
  ylm_trace_ray ray[GRAIN];
  ylm_trace_hit hit[GRAIN];
  uint32_t landed[GRAIN]; /* those that met a surface */
  ylm_scene_place place[GRAIN];
  ylm_scene_surface surface[GRAIN];
} flight;

typedef struct job {
  const ylm_scene *scene;
  const ylm_emit_options *o;
  emit_lamps lamps;
  emit_sequence numbers;
  const emit_gloss *gloss; /* NULL: all is matte */
  float (*albedo)[3];      /* [meshes] mean */
  size_t begin;            /* the first particle of a wave */
  size_t kept, room;       /* landings of the waves before; room in out */
  block *blocks;           /* [blocks of a wave] */
  flight *flight;          /* [threads] */
  emit_landings *out;
} job;

static void add(double sum[3], const double x[3]) {
  for (int c = 0; c < 3; c++) sum[c] += x[c];
}

static void set_out(const job *j, size_t begin, size_t end, flight *f, block *b) {
  bool goes_on = j->o->bounces > 1 || j->gloss;
  f->n = 0;
  for (size_t i = begin; i < end; i++) {
    particle *p = &f->p[f->n];
    double u[EMIT_NUMBERS];
    if (j->o->grid) {
      if (!ylm__emit_texel(&j->lamps, i, &f->ray[f->n], p->power, &p->solid)) continue;
    } else {
      ylm__emit_numbers(&j->numbers, i, u);
      if (!ylm__emit_start(&j->lamps, u, &f->ray[f->n], p->power)) continue;
    }
    add(b->counts.emitted, p->power);
    if (goes_on) ylm_rng_seed(&p->rng, j->o->seed, i);
    p->number = (uint32_t)i;
    f->n++;
  }
}

/* The surfaces that rays hit, seen from where they came: f->surface[k] is that of ray f->landed[k]. */
static size_t surfaces(const job *j, flight *f) {
  size_t n = 0;
  for (size_t i = 0; i < f->n; i++) {
    const ylm_trace_hit *h = &f->hit[i];
    bool back = ylm_dot3(h->normal, f->ray[i].dir) > 0;
    f->place[n] = (ylm_scene_place){(uint32_t)h->mesh, h->element, h->u, h->v, back};
    f->landed[n] = (uint32_t)i;
    n += h->mesh >= 0;
  }
  ylm_scene_surfaces(j->scene, n, f->place, f->surface);
  return n;
}

/* The direction from which particle i comes, in a frame of the surface. */
static void arrive(const flight *f, size_t i, const float x[3], const float y[3],
                   const float normal[3], float wo[3]) {
  const float *dir = f->ray[i].dir;
  wo[0] = -ylm_dot3(dir, x), wo[1] = -ylm_dot3(dir, y), wo[2] = -ylm_dot3(dir, normal);
}

/* Room for n more landings of a block. */
static ylm_status make_room(block *b, size_t n) {
  return ylm_list_reserve(&b->landing, b->n, b->n + n, &b->room, sizeof *b->landing) ? YLM_OK
                                                                                     : YLM_ENOMEM;
}

/* Leaves a landing of particle i, whose power becomes what is reflected. */
static void land(const job *j, flight *f, size_t i, int order, ylm_scene_surface *s, block *b) {
  particle *p = &f->p[i];
  const ylm_trace_ray *ray = &f->ray[i];
  float albedo[3], azimuth = 0, area = 0, way = f->hit[i].t;
  uint32_t slot = ylm__emit_slot(j->gloss, (size_t)f->hit[i].mesh);
  if (!(ylm_dot3(s->normal, ray->dir) < 0)) {
    memcpy(s->normal, s->flat, sizeof s->normal);
    b->counts.turned++;
  }
  memcpy(albedo, j->albedo[f->hit[i].mesh], sizeof albedo);
  if (ylm_material_glosses(s->material)) b->counts.glossy++;
  if (slot != EMIT_MATTE) {
    float x[3], y[3], wo[3];
    ylm__emit_frame(s, x, y);
    arrive(f, i, x, y, s->normal, wo);
    ylm__emit_reflectance(j->gloss, slot, wo, albedo);
    azimuth = atan2f(wo[1], wo[0]);
  }
  if (order == 1) add(b->counts.landed, p->power);
  for (int c = 0; c < 3; c++) p->power[c] *= (double)albedo[c] * (double)s->tint[c];
  add(b->counts.reflected, p->power);
  b->counts.landings[order - 1]++;
  if (j->o->grid) {
    double cosine = fmax(0.1, -(double)ylm_dot3(s->flat, ray->dir));
    area = (float)(p->solid * (double)way * (double)way / cosine);
  }
  emit_landing *l = &b->landing[b->n];
  for (int k = 0; k < 3; k++) {
    l->at[k] = s->position[k], l->normal[k] = s->normal[k];
    l->from[k] = -ray->dir[k], l->power[k] = (float)p->power[k];
  }
  l->azimuth = azimuth, l->way = way, l->area = area;
  l->particle = p->number, l->slot = slot;
  if (ylm__emit_luminous(l) > 0) b->n++; /* a dark one is no light */
}

/* The direction in which particle i leaves a surface that glosses, its power weighed by it; false: it is absorbed. */
static bool scatter(const job *j, flight *f, size_t i, uint32_t slot, const ylm_scene_surface *s,
                    double u, double v, float dir[3]) {
  particle *p = &f->p[i];
  float x[3], y[3], wo[3], wi[3], weight[3], albedo[3];
  float by[3] = {(float)u, (float)v, (float)ylm_rng_double(&p->rng)};
  for (int k = 0; k < 3; k++) by[k] = fminf(by[k], 0x1.fffffep-1f);
  ylm__emit_frame(s, x, y);
  arrive(f, i, x, y, s->normal, wo);
  ylm__emit_reflectance(j->gloss, slot, wo, albedo);
  if (!ylm__emit_sample(j->gloss, slot, wo, by, wi, weight)) return false;
  for (int k = 0; k < 3; k++) dir[k] = wi[0] * x[k] + wi[1] * y[k] + wi[2] * s->normal[k];
  for (int c = 0; c < 3; c++)
    p->power[c] *= albedo[c] > 0 ? (double)weight[c] / (double)albedo[c] : 0;
  return true;
}

/* Sends particle i on, as the k-th that is under way; false: it ends. */
static bool go_on(const job *j, flight *f, size_t i, size_t k, const ylm_scene_surface *s,
                  block *b) {
  particle *p = &f->p[i];
  const float *mean = j->albedo[f->hit[i].mesh];
  uint32_t slot = ylm__emit_slot(j->gloss, (size_t)f->hit[i].mesh);
  double albedo[3], u = ylm_rng_double(&p->rng), v = ylm_rng_double(&p->rng);
  for (int c = 0; c < 3; c++) albedo[c] = (double)mean[c] * (double)s->tint[c];
  double chance = fmin(MOST_CHANCE, ylm_luminance_size(albedo));
  if (!(ylm_rng_double(&p->rng) < chance)) return false;
  for (int c = 0; c < 3; c++) p->power[c] /= chance;
  ylm_trace_ray ray = {.far = INFINITY};
  if (slot == EMIT_MATTE)
    ylm__emit_cosine(s->normal, u, v, ray.dir);
  else if (!scatter(j, f, i, slot, s, u, v, ray.dir)) {
    b->counts.absorbed++;
    return false;
  }
  memcpy(ray.org, s->origin, sizeof ray.org);
  if (ylm_dot3(ray.dir, s->flat) <= 0) {
    b->counts.absorbed++;
    return false;
  }
  f->p[k] = *p;
  f->ray[k] = ray;
  return true;
}

/* Follows all particles that are under way to where they land, or out of the scene. */
static ylm_status follow(const job *j, flight *f, int order, block *b) {
  size_t n = 0;
  ylm_trace_nearest(ylm_scene_trace(j->scene), f->n, f->ray, false, f->hit);
  b->counts.rays += f->n;
  for (size_t i = 0; order == 1 && i < f->n; i++)
    if (f->hit[i].mesh < 0) add(b->counts.lost, f->p[i].power);
  size_t landed = surfaces(j, f);
  ylm_status status = make_room(b, landed);
  if (status != YLM_OK) return status;
  for (size_t k = 0; k < landed; k++) {
    size_t i = f->landed[k];
    ylm_scene_surface *s = &f->surface[k];
    land(j, f, i, order, s, b);
    if (order == j->o->bounces)
      add(b->counts.going, f->p[i].power);
    else if (go_on(j, f, i, n, s, b))
      n++;
  }
  f->n = n;
  return YLM_OK;
}

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  const job *j = context;
  block *b = &j->blocks[begin / GRAIN];
  flight *f = &j->flight[worker];
  ylm_status s = YLM_OK;
  b->n = 0;
  b->counts = (ylm_emit_report){0};
  if (j->o->bounces == 1) {
    b->landing = j->out->landing + j->begin + begin;
    b->room = GRAIN;
  }
  set_out(j, j->begin + begin, j->begin + end, f, b);
  for (int order = 1; s == YLM_OK && order <= j->o->bounces && f->n > 0; order++)
    s = follow(j, f, order, b);
  return s;
}

static void add_counts(const ylm_emit_report *b, ylm_emit_report *r) {
  r->rays += b->rays;
  r->turned += b->turned;
  r->absorbed += b->absorbed;
  r->glossy += b->glossy;
  for (int k = 0; k < YLM_EMIT_BOUNCES; k++) r->landings[k] += b->landings[k];
  add(r->emitted, b->emitted);
  add(r->landed, b->landed);
  add(r->lost, b->lost);
  add(r->reflected, b->reflected);
  add(r->going, b->going);
}

/* Puts landings of blocks into the order of their particles; each particle's are in order already. */
static ylm_status sort(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  for (size_t i = begin; i < end; i++) {
    const block *b = &j->blocks[i];
    if (b->n == 0) continue;
    emit_landing *to = j->out->landing + b->begin;
    size_t first[GRAIN + 1] = {0};
    for (size_t k = 0; k < b->n; k++) first[b->landing[k].particle % GRAIN + 1]++;
    for (size_t k = 0; k < GRAIN; k++) first[k + 1] += first[k];
    for (size_t k = 0; k < b->n; k++) to[first[b->landing[k].particle % GRAIN]++] = b->landing[k];
  }
  return YLM_OK;
}

/* Room for all landings so far; what all particles will leave is guessed from those that are done. */
static ylm_status widen(job *j, size_t done) {
  emit_landings *x = j->out;
  if (x->n <= j->room) return YLM_OK;
  size_t guess = (size_t)(1.02 * (double)x->n / (double)done * (double)j->o->particles) + GRAIN;
  size_t room = guess > x->n ? guess : x->n;
  if (!ylm_list_resize(&x->landing, j->kept, room, sizeof *x->landing)) return YLM_ENOMEM;
  j->room = room;
  return YLM_OK;
}

/* Appends the landings and adds the counts of a wave's blocks. */
static ylm_status join(job *j, size_t particles, ylm_emit_report *report) {
  emit_landings *out = j->out;
  size_t blocks = (particles + GRAIN - 1) / GRAIN;
  j->kept = out->n;
  for (size_t i = 0; i < blocks; i++) {
    block *b = &j->blocks[i];
    b->begin = out->n;
    out->n += b->n;
    add_counts(&b->counts, report);
    if (j->o->bounces == 1 && b->landing != out->landing + b->begin)
      memmove(out->landing + b->begin, b->landing, b->n * sizeof *b->landing);
  }
  if (j->o->bounces == 1) return YLM_OK;
  ylm_status s = widen(j, j->begin + particles);
  return s == YLM_OK ? ylm_parallel(blocks, 4, j->o->threads, sort, j, NULL, NULL) : s;
}

/* Particles are followed in waves, so that what blocks keep of their own stays small. */
static ylm_status run_waves(job *j, size_t wave, ylm_emit_report *report) {
  size_t all = j->o->particles;
  ylm_status s = YLM_OK;
  for (j->begin = 0; s == YLM_OK && j->begin < all; j->begin += wave * GRAIN) {
    ylm_progress_part part;
    size_t n = all - j->begin < wave * GRAIN ? all - j->begin : wave * GRAIN;
    s = ylm_parallel(n, GRAIN, j->o->threads, run, j,
                     ylm_progress_part_of(&part, j->o->progress, NULL, j->begin, n, all),
                     "particles");
    if (s == YLM_OK) s = join(j, n, report);
  }
  return s;
}

static ylm_status find_albedos(job *j) {
  size_t meshes = ylm_scene_meshes(j->scene);
  j->albedo = ylm_alloc(meshes, sizeof *j->albedo);
  if (!j->albedo) return YLM_ENOMEM;
  for (size_t m = 0; m < meshes; m++)
    ylm_material_albedo(ylm_scene_material(j->scene, m), j->albedo[m]);
  return YLM_OK;
}

ylm_status ylm__emit_trace(const ylm_scene *scene, const emit_gloss *g, const ylm_emit_options *o,
                           emit_landings *out, ylm_emit_report *report) {
  size_t threads = (size_t)ylm_threads(o->threads), wave = 8 * threads > WAVE ? 8 * threads : WAVE;
  job j = {.scene = scene, .o = o, .gloss = g, .out = out};
  j.blocks = ylm_alloc_zero(wave, sizeof *j.blocks);
  j.flight = ylm_alloc(threads, sizeof *j.flight);
  ylm__emit_sequence(o->seed, &j.numbers);
  ylm_status s = ylm__emit_lamps(scene, o->particles, &j.lamps);
  j.lamps.side = o->grid;
  if (s == YLM_OK) s = j.blocks && j.flight ? find_albedos(&j) : YLM_ENOMEM;
  if (s == YLM_OK && o->bounces == 1) {
    out->landing = ylm_alloc(o->particles, sizeof *out->landing);
    if (!out->landing) s = YLM_ENOMEM;
  }
  if (s == YLM_OK) s = run_waves(&j, wave, report);
  for (size_t b = 0; o->bounces > 1 && j.blocks && b < wave; b++) ylm_free(j.blocks[b].landing);
  ylm_free(j.blocks);
  ylm_free(j.flight);
  ylm_free(j.albedo);
  ylm__emit_lamps_free(&j.lamps);
  return s;
}
