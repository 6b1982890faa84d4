#include "numbers.h"

#include <math.h>
#include <string.h>

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

/* Brings the value of a rank to its place, what is not above it before it: selection by Hoare,
   Commun. ACM 4 (1961) 321-322, doi:10.1145/366622.366647. */
static double of_rank(double *values, size_t count, size_t rank)
{
    size_t low = 0, high = count - 1;
    while (low < high) {
        double pivot = values[low + (high - low) / 2];
        size_t i = low, j = high + 1; /* j is one behind: it must not fall below 0 */
        while (i < j) {
            while (values[i] < pivot) {
                i++;
            }
            while (pivot < values[j - 1]) {
                j--;
            }
            if (i < j) {
                double kept = values[i];
                values[i++] = values[j - 1];
                values[--j] = kept;
            }
        }
        if (rank < j) {
            high = j - 1;
        } else if (rank >= i) {
            low = i;
        } else {
            break;
        }
    }
    return values[rank];
}

double median(const double *values, size_t count, double *kept)
{
    memcpy(kept, values, count * sizeof *values);
    size_t half = count / 2;
    double upper = of_rank(kept, count, half), lower = kept[0];
    if (count % 2 != 0) {
        return upper;
    }
    for (size_t i = 1; i < half; i++) {
        lower = kept[i] > lower ? kept[i] : lower;
    }
    return (lower + upper) / 2.0;
}
