/*
** profile.h - a sphere at the directions of a rule, for the element type `real`: the plain form, which judges the
** kernels of profile.isa.c.
*/

/* The smaller of v [rows][padded] and a cap's profile, or their product; with gradients its derivatives. */
static void profile_plain(const shadow_rings *r, const shadow_cap *c, bool times, size_t rows,
                          real *v) {
  const double *at = r->at;
  for (size_t k = 0; k < r->n; k++) {
    if (r->z[k] < c->low || r->z[k] > c->high) continue;
    size_t end = r->first[2 * k] + r->first[2 * k + 1];
    for (size_t i = r->first[2 * k]; i < end; i++) {
      double n[3] = {at[i], at[r->padded + i], at[2 * r->padded + i]};
      double d = c->w[0] * n[0] + c->w[1] * n[1] + c->w[2] * n[2];
      if (!(d > c->limit)) continue;
      double across = sqrt(fmax(0, 1 - d * d));
      double y = across * c->cosine - d * c->sine, z = d * c->cosine + across * c->sine;
      double u = fmin(1, fmax(0, 0.5 + atan2(y, z) / c->step));
      double hidden = 1 - u * u * (3 - 2 * u), p = 1 - c->deep * hidden, was = (double)v[i];
      if (!times && !(p < was)) continue;
      v[i] = (real)(times ? was * p : p);
      double steep = 6 * c->deep / c->step * u * (1 - u) * c->over,
             away = across > 0 ? 1 / across : 0;
      for (size_t a = 0; a + 1 < rows; a++) {
        double slope =
            steep * ((n[a] - c->w[a] * d) * away - c->w[a] * c->turn) - c->fade[a] * hidden;
        real *to = v + (a + 1) * r->padded + i;
        *to = (real)(times ? (double)*to * p + was * slope : slope);
      }
    }
  }
}
