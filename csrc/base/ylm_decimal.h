/* ylm_decimal.h - decimal numbers in texts, for readers of files. */
#ifndef YLM_DECIMAL_H
#define YLM_DECIMAL_H

#include "ylm_base.h"

/*
** A decimal number at *p, ended by `end`: sign, digits, point, exponent; correctly rounded.
** On success *p is behind it. False if there is none. "nan" and "inf" are none.
*/
YLM_API bool ylm_decimal_read(const unsigned char **p, const unsigned char *end, double *x);

#endif
