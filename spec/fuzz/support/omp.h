/* omp.h - one thread: the fuzzers are built with clang, which comes without an OpenMP runtime. */
#ifndef YLM_FUZZ_OMP_H
#define YLM_FUZZ_OMP_H
static inline int omp_get_thread_num(void) { return 0; }
static inline int omp_get_num_procs(void) { return 1; }
static inline int omp_get_max_threads(void) { return 1; }
#endif
