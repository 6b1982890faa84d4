/* Small sums that several parts need, each in the order of the Python twin: the last bit counts. */
#ifndef NUMBERS_H
#define NUMBERS_H

#include <stddef.h>

/* Returns the nearest number within the limits; NaN stays NaN. */
double clamped(double value, double low, double high);

/* Returns the sum of a[i] b[i], from the first on. */
double dot(const double *a, const double *b, size_t count);

/* Returns the median of count > 0 numbers; the row of as many to sort them in is the caller's. */
double median(const double *values, size_t count, double *kept);

/* Returns how much of the way to its input a first-order lag goes [1]. */
double lag_share(double elapsed_s, double tau_s);

/* Returns the speed without its sign [rpm]; the last one while it is not known or absurd. */
double known_speed(double speed, double last);

/* Returns how many steps of an even clock have passed, and takes them off the age [s]. */
long clock_ticks(double *age_s, double step_s);

#endif
