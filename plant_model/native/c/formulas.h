/* Operations of numpy that C lacks. */
#ifndef FORMULAS_H
#define FORMULAS_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

/* Compiles a function over all nodes twice; the wider form runs if the processor supports it. Both
   give the same numbers: no sum is reordered or contracted. */
#if defined __GNUC__ && !defined __clang__ && defined __x86_64__ && defined __gnu_linux__
#define WIDE __attribute__((target_clones("avx2", "default")))
#else
#define WIDE
#endif

/* NaN stays NaN. */
static inline double larger(double a, double b)
{
    return a > b || a != a ? a : b;
}

static inline double smaller(double a, double b)
{
    return a < b || a != a ? a : b;
}

/* The largest magnitude in a row, in four interleaved parts that a compiler handles at once. */
static inline double largest_of(const double *row, size_t count)
{
    double most[4];
    size_t whole = count / 4 * 4;
    for (size_t j = 0; j < 4; j++) {
        double found = 0.0;
        for (size_t i = 0; i < whole; i += 4) {
            found = fabs(row[i + j]) > found ? fabs(row[i + j]) : found;
        }
        most[j] = found;
    }
    for (size_t i = whole; i < count; i++) {
        most[0] = fabs(row[i]) > most[0] ? fabs(row[i]) : most[0];
    }
    return larger(larger(most[0], most[1]), larger(most[2], most[3]));
}

/* Zero times a number that is not finite is NaN. */
static inline bool are_finite(const double *row, size_t count)
{
    double sums[4] = {0.0, 0.0, 0.0, 0.0};
    size_t whole = count / 4 * 4;
    for (size_t i = 0; i < whole; i += 4) {
        for (size_t j = 0; j < 4; j++) {
            sums[j] += 0.0 * row[i + j];
        }
    }
    for (size_t i = whole; i < count; i++) {
        sums[0] += 0.0 * row[i];
    }
    return isfinite((sums[0] + sums[1]) + (sums[2] + sums[3]));
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
