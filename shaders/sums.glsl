/* sums.glsl - merged moments that are plain numbers: what gen/moments.glsl wants to know of each kind. */
#define PART1 0u
#define SUM0(a) real a;
#define SUM1(a) real a;
#define SUM2(a) real a;
#define CLEAR0(a) a = REAL(0.0lf)
#define CLEAR1(a) a = REAL(0.0lf)
#define CLEAR2(a) a = REAL(0.0lf)
#define ADD0(a, e) a += e
#define ADD1(a, e) a += e
#define ADD2(a, e) a += e
#define KEEP0(a, b) real b = a
#define KEEP1(a, b) real b = a
#define KEEP2(a, b) real b = a
#define STORE0(n, p, a) partial[store_at + (n) * stride] = a
#define STORE1(n, p, a) partial[store_at + (n) * stride] = a
#define STORE2(n, p, a) partial[store_at + (n) * stride] = a
