/* Operations of numpy that C has not. */
#ifndef FORMULAS_H
#define FORMULAS_H

#include <math.h>
#include <stddef.h>

/* A value that is not a number stays one. */
static inline double larger(double a, double b)
{
    return a > b || a != a ? a : b;
}

static inline double smaller(double a, double b)
{
    return a < b || a != a ? a : b;
}

/* The largest magnitude in a row, in two chains that do not wait for each other. */
static inline double largest_of(const double *row, size_t count)
{
    double even = 0.0, odd = 0.0;
    for (size_t i = 0; i + 1 < count; i += 2) {
        even = fabs(row[i]) > even ? fabs(row[i]) : even;
        odd = fabs(row[i + 1]) > odd ? fabs(row[i + 1]) : odd;
    }
    return larger(larger(even, odd), count % 2 ? fabs(row[count - 1]) : 0.0);
}

static inline double sign_of(double a)
{
    return a != a ? a : (double)((a > 0.0) - (a < 0.0));
}

/* The remainder has the divisor's sign. */
static inline double modulo(double a, double b)
{
    double left = fmod(a, b);
    return left != 0.0 && (left < 0.0) != (b < 0.0) ? left + b : left;
}

static inline double radians(double degrees)
{
    return degrees * (3.14159265358979323846 / 180.0);
}

static inline double square(double a)
{
    return a * a;
}

static inline double cube(double a)
{
    return a * a * a;
}

static inline double fourth(double a)
{
    return a * a * (a * a);
}

#endif
