/*
** harmonics.c - the values and gradients of the basis functions of degree <= 2 at a direction.
**
**     cc harmonics.c $(pkg-config --cflags --libs ylm) -lm -o harmonics && ./harmonics 1 2 2
**
** A row is l, m, Y(l, m) and its three derivatives. The last line is the addition theorem: the
** squares of all values sum to (lmax + 1)^2 / (4 pi), whatever the direction. C11 and C++17.
*/
#include <stdio.h>
#include <stdlib.h>

#include <ylm/ylm_sh.h>

enum { LMAX = 2, COUNT = (LMAX + 1) * (LMAX + 1) };

int main(int argc, char **argv) {
  double at[3], y[COUNT], dy[COUNT][3], sum = 0;
  ylm_error error = {YLM_OK, ""};
  if (argc != 4) return fprintf(stderr, "usage: harmonics X Y Z\n"), 2;
  for (int a = 0; a < 3; a++) at[a] = atof(argv[1 + a]);
  if (ylm_sh_eval(LMAX, 1, false, YLM_DOUBLE, 1, at, y, dy, NULL, 1, &error) != YLM_OK)
    return fprintf(stderr, "harmonics: %s\n", error.text), 1;
  for (int l = 0; l <= LMAX; l++)
    for (int m = -l; m <= l; m++) {
      size_t k = ylm_sh_index(l, m);
      printf("%d %2d  %12.9f  %12.9f %12.9f %12.9f\n", l, m, y[k], dy[k][0], dy[k][1], dy[k][2]);
      sum += y[k] * y[k];
    }
  printf("sum of squares, times 4 pi / (lmax + 1)^2: %.12f\n", sum * 4 * YLM_PI / COUNT);
  return 0;
}
