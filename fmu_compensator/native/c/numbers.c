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

double lag_share(double elapsed_s, double tau_s)
{
    return -expm1(-elapsed_s / tau_s);
}

double lag_behind(double elapsed_s, double tau_s)
{
    double moved = lag_share(elapsed_s, tau_s);
    return moved > 0.0 ? tau_s / elapsed_s - (1.0 - moved) / moved : 0.0;
}

double known_speed(double speed, double last)
{
    return fabs(speed) <= FIELDS_LARGEST ? fabs(speed) : last;
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

double median(const double *values, size_t count, double *kept)
{
    for (size_t i = 0; i < count; i++) {
        size_t at = i;
        for (; at > 0 && values[i] < kept[at - 1]; at--) {
            kept[at] = kept[at - 1];
        }
        kept[at] = values[i];
    }
    return count % 2 != 0 ? kept[count / 2] : (kept[count / 2 - 1] + kept[count / 2]) / 2.0;
}
