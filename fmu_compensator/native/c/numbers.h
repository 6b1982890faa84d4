/* Shared small computations in the order of the Python twin, so that every bit agrees. */
#ifndef NUMBERS_H
#define NUMBERS_H

#include <stddef.h>

/* Returns the nearest number within the limits; NaN stays NaN. */
double clamped(double value, double low, double high);

/* Returns the sum of a[i] b[i], added from the first on. */
double dot(const double *a, const double *b, size_t count);

/* Returns the median of count > 0 numbers; the caller provides kept, as long, to sort them in. */
double median(const double *values, size_t count, double *kept);

/* Returns the fraction of the way to its input that a first-order lag moves [1]. */
double lag_share(double elapsed_s, double tau_s);

/* Returns which share of its last move an input is behind, as a lag sees it [1]. */
double lag_behind(double elapsed_s, double tau_s);

/* Returns the absolute speed [rpm]; the last known one while it is unknown or absurd. */
double known_speed(double speed, double last);

/* Returns how many steps of an even clock have passed, and subtracts them from the age [s]. */
long clock_ticks(double *age_s, double step_s);

#endif
