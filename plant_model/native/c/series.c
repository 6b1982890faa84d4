#include "series.h"

#include <math.h>
#include <string.h>

#include "formulas.h"

/* Truncation error of series, relative to a temperature's distance to go. Set on four machines,
   random inputs and steps of 10 ms to 300 s: outputs then differ from Python's by at most 7e-9. */
#define SMALL 5e-10
#define LEAST_SCALE 1e-290 /* so that capacities divided by it are finite */
#define LEAST_REACH 1e-9
#define CLOSE 0.5
#define PI 3.14159265358979323846

/* The Taylor series of phi, for x close to 0, where the quotient cancels. */
static double phi_close(int order, double x)
{
    static const double inverse[] = {
        1.0, 1.0, 1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0, 1.0 / 720.0, 1.0 / 5040.0,
        1.0 / 40320.0, 1.0 / 362880.0, 1.0 / 3628800.0, 1.0 / 39916800.0, 1.0 / 479001600.0,
        1.0 / 6227020800.0, 1.0 / 87178291200.0, 1.0 / 1307674368000.0, 1.0 / 20922789888000.0,
        1.0 / 355687428096000.0, 1.0 / 6402373705728000.0};
    double value = 0.0;
    for (int j = 15; j >= 0; j--) {
        value = value * x + inverse[j + order];
    }
    return value;
}

double phi(int order, double x)
{
    if (fabs(x) < CLOSE) {
        return phi_close(order, x);
    }
    double value = expm1(x) / x, factorial = 1.0;
    for (int k = 2; k <= order; k++) {
        factorial *= k - 1;
        value = (value - 1.0 / factorial) / x;
    }
    return value;
}

/* All kinds at once: with e = exp(z / 2), each follows from the previous one or, if the quotient
   cancels, from the next one. */
static void values_at(double z, double values[SERIES])
{
    double e, three;
    if (z > -CLOSE) {
        three = phi_close(3, z);
        values[TWO] = z * three + 0.5;
        values[ONE] = z * values[TWO] + 1.0;
        e = sqrt(1.0 + z * values[ONE]);
    } else {
        e = exp(z / 2.0);
        values[ONE] = (e * e - 1.0) / z;
        values[TWO] = (values[ONE] - 1.0) / z;
        three = (values[TWO] - 0.5) / z;
    }
    values[BENT] = 4.0 * three - values[TWO];
    values[HALF] = values[ONE] / (1.0 + e);
}

/* A rate times the step is at most the reach times the distance to go. */
static double small_for(double reach)
{
    return SMALL / larger(1.0, reach);
}

/* Returns more than enough terms, an even number. */
static size_t enough(double reach)
{
    size_t count = 4, most = 12 + (size_t)(7.4 * sqrt(reach / 2.0));
    double small = small_for(reach);
    /* No derivative of phi_k is above 1, so a weight is at most 2 (reach / 4)^k / k!. */
    for (double weight = cube(reach / 4.0) / 6.0; weight > small && count < most; count++) {
        weight *= reach / (4.0 * (double)count);
    }
    return count + count % 2;
}

/* Finds the weights from the values at the zeros of a Chebyshev polynomial, in pairs on both sides
   of the middle; returns the number of weights that are not small. */
static size_t make(struct term *terms, size_t count, double reach)
{
    memset(terms, 0, count * sizeof *terms);
    double x = cos(PI / 2.0 / (double)count), before = x, turn = 2.0 * cos(PI / (double)count);
    for (size_t j = 0; j < count / 2; j++) {
        double low[SERIES], high[SERIES], both[2][SERIES], last = x, now = 1.0;
        values_at(-reach * (1.0 + x) / 2.0, low);
        values_at(-reach * (1.0 - x) / 2.0, high);
        for (int kind = 0; kind < SERIES; kind++) {
            both[0][kind] = (low[kind] + high[kind]) / (double)count;
            both[1][kind] = (low[kind] - high[kind]) / (double)count;
        }
        for (size_t k = 0; k < count; k++) {
            double next = 2.0 * x * now - last;
            for (int kind = 0; kind < SERIES; kind++) {
                terms[k].weights[kind] += both[k % 2][kind] * now;
            }
            last = now;
            now = next;
        }
        double following = turn * x - before;
        before = x;
        x = following;
    }
    double rest = 0.0, small = small_for(reach);
    size_t needed = 2;
    for (size_t k = count; k-- > 0;) {
        rest = larger(rest, 2.0 * largest_of(terms[k].weights, SERIES));
        terms[k].rest = rest;
        needed = rest > small && k >= needed ? k + 1 : needed;
    }
    /* The last kept term makes up for the dropped ones at zero decay: slow changes are exact. */
    for (size_t k = needed; k < count; k++) {
        for (int kind = 0; kind < SERIES; kind++) {
            double left = terms[k].weights[kind];
            terms[needed - 1].weights[kind] += (k - needed) % 2 == 0 ? -left : left;
        }
    }
    return needed;
}

const struct series *series_for(struct all_series *self, double reach)
{
    reach = smaller(larger(reach, LEAST_REACH), MOST_REACH);
    for (size_t i = 0; i < SERIES_KEPT; i++) {
        const struct series *kept = &self->kept[i];
        if (kept->count > 0 && kept->above < reach && reach <= kept->reach) {
            return kept;
        }
    }
    /* Rounded up in steps of at most an eighth, so that similar conductances share a series. */
    int exponent;
    double part = frexp(reach, &exponent), step = ldexp(1.0 / 16.0, exponent);
    double wide = ceil(part * 16.0) * step, above = wide - (part > 0.5 ? step : step / 2.0);
    size_t count = enough(wide), first = self->end + count > TERMS_KEPT ? 0 : self->end;
    struct term *terms = self->terms + first;
    for (size_t i = 0; i < SERIES_KEPT; i++) {
        struct series *old = &self->kept[i];
        if (old->count > 0 && old->terms < terms + count && terms < old->terms + old->count) {
            old->count = 0;
        }
    }
    struct series *found = &self->kept[self->next];
    self->next = (self->next + 1) % SERIES_KEPT;
    *found = (struct series){wide, above, make(terms, count, wide), terms};
    self->end = first + found->count;
    return found;
}

/* Sets the arrays with which a product is 2 (scale A - 1) times a vector. */
static void stretch(struct network *self, double scale)
{
    if (self->scale != scale) {
        for (size_t i = 0; i < NODES; i++) {
            self->stretched[i] = 2.0 * scale * self->share[i];
        }
        self->scale = scale;
        self->shifts = false;
    }
    if (!self->shifts) {
        for (size_t i = 0; i < NODES; i++) {
            self->shifted[i] = self->diagonal[i] - self->capacity[i] * (1.0 / scale);
        }
        self->shifts = true;
    }
}

static inline void add(double *restrict sum, double weight, const double *row)
{
    for (size_t i = 0; i < NODES; i++) {
        sum[i] += weight * row[i];
    }
}

WIDE void series_add(
    const struct series *self, struct network *network, double h, const double vector[NODES],
    double beside, size_t count, const int kinds[], double *const sums[])
{
    static const double none[NODES];
    double (*rows)[ROW] = network->rows, least = small_for(self->reach);
    const double *last = none, *now = vector;
    if (beside > 0.0) {
        least *= larger(1.0, beside / largest_of(vector, NODES));
    }
    stretch(network, larger(2.0 * h / self->reach, LEAST_SCALE));
    /* From the second term on, rows hold twice the polynomials. */
    for (size_t i = 0; i < NODES; i++) {
        rows[2][i] = 2.0 * vector[i];
    }
    size_t k = 0;
    for (; k + 1 < self->count && (k == 0 || self->terms[k + 1].rest > least); k++) {
        double *next = rows[k % 3];
        equations_product(
            network->shifted, network->entries, network->stretched, now, last,
            self->terms[k].weights[kinds[0]], next, sums[0]);
        for (size_t j = 1; j < count; j++) {
            add(sums[j], self->terms[k].weights[kinds[j]], now);
        }
        last = k == 0 ? rows[2] : now;
        now = next;
    }
    for (size_t j = 0; j < count; j++) {
        add(sums[j], self->terms[k].weights[kinds[j]], now);
    }
}
