/* lanes.h - vectors of BYTES bytes for kernels that are compiled once per instruction set. Kernels that serve a few lamps
   include it a second time, for 16: short vectors are divided and rooted in a third of the time of long ones. Private to
   csrc/scene. */
#define OF_(name, n) name##_##n
#define OF__(name, n) OF_(name, n)
#define OF(name) OF__(name, BYTES)
#define floats OF(floats)
#define masks OF(masks)
#define load OF(load)
#define store OF(store)
#define choose OF(choose)
#define root OF(root)

typedef float floats __attribute__((vector_size(BYTES)));
typedef int32_t masks __attribute__((vector_size(BYTES)));

YLM_INLINE floats load(const float *p) {
  floats v;
  memcpy(&v, p, sizeof v);
  return v;
}
YLM_INLINE void store(float *p, floats v) { memcpy(p, &v, sizeof v); }
YLM_INLINE floats choose(masks m, floats a, floats b) {
  return (floats)(((masks)a & m) | ((masks)b & ~m));
}
YLM_INLINE floats root(floats x) {
  for (int i = 0; i < BYTES / 4; i++) x[i] = sqrtf(x[i]);
  return x;
}
