/* Operations of numpy that C has not. */
#ifndef FORMULAS_H
#define FORMULAS_H

#include <math.h>

/* A value that is not a number stays one. */
static inline double larger(double a, double b)
{
    return a > b || a != a ? a : b;
}

static inline double smaller(double a, double b)
{
    return a < b || a != a ? a : b;
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
