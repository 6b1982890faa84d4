#include "numbers.h"

#include <math.h>

#include "constants.h"

double clamped(double value, double low, double high)
{
    if (value < low) {
        return low;
    }
    return value > high ? high : value;
}

double dot(const double *a, const double *b, size_t count)
{
    double total = 0.0;
    for (size_t i = 0; i < count; i++) {
        total += a[i] * b[i];
    }
    return total;
}

double median(const double *values, size_t count, double *sorted)
{
    for (size_t i = 0; i < count; i++) {
        size_t place = i;
        for (; place > 0 && sorted[place - 1] > values[i]; place--) {
            sorted[place] = sorted[place - 1];
        }
        sorted[place] = values[i];
    }
    size_t half = count / 2;
    return count % 2 == 0 ? (sorted[half - 1] + sorted[half]) / 2.0 : sorted[half];
}

double lag_share(double elapsed_s, double tau_s)
{
    return -expm1(-elapsed_s / tau_s);
}

double known_speed(double speed, double last)
{
    return fabs(speed) <= LAGS_FASTEST_RPM ? fabs(speed) : last;
}

/* Floor division as Python defines it: from the remainder, which is exact. */
static double floor_division(double value, double divisor)
{
    double quotient = (value - fmod(value, divisor)) / divisor;
    double whole = floor(quotient);
    return quotient - whole > 0.5 ? whole + 1.0 : whole;
}

long clock_ticks(double *age_s, double step_s)
{
    double count = floor_division(*age_s + 0.5 * step_s, step_s);
    *age_s -= count * step_s;
    return count < TICKS_MOST_TICKS ? (long)count : (long)TICKS_MOST_TICKS;
}
