/* The error of a prediction as an Ornstein-Uhlenbeck process, filtered (Kalman). */
#include "correction.h"

#include <math.h>

#include "constants.h"

struct correction *correction_make(
    struct setup *setup, const struct field *table, size_t targets)
{
    if (table->form == FIELD_NULL) {
        return NULL;
    }
    struct correction *self = setup_take(setup, 1, sizeof *self);
    if (self == NULL) {
        return NULL;
    }
    self->targets = targets;
    self->states = 5 * targets;
    self->memory_s = field_number(setup, table, "memory_s");
    self->spread = field_numbers(setup, table, "spread", NULL);
    self->noise = field_numbers(setup, table, "noise", NULL);
    self->fast = field_number(setup, table, "fast");
    return self;
}

void correction_reset(const struct correction *self, double *state)
{
    for (size_t target = 0; target < self->targets; target++) {
        state[target] = 0.0;
        state[self->targets + target] = 1.0;
        state[2 * self->targets + target] = 0.0;
        state[3 * self->targets + target] = 0.0;
        state[4 * self->targets + target] = 0.0;
    }
}

void correction_take(
    const struct correction *self, double *state, const double *measured,
    const double *predicted, double growth)
{
    double *bias = state, *doubt = state + self->targets;
    double *suspect = doubt + self->targets, *suspected = suspect + self->targets;
    double *held = suspected + self->targets;
    for (size_t target = 0; target < self->targets; target++) {
        double missed = measured[target] - predicted[target];
        double left = doubt[target] * pow(self->spread[target] * growth, 2.0);
        double gain = left / (left + self->noise[target]);
        double furthest = CORRECTION_FURTHEST * sqrt(left + self->noise[target]);
        double whole = bias[target] + missed;
        int confirmed =
            suspected[target] > 0.0 && fabs(whole - suspect[target]) <= furthest;
        if (fabs(missed) <= furthest || confirmed) {
            bias[target] += gain * missed;
            doubt[target] *= 1.0 - gain;
            suspect[target] = 0.0;
            suspected[target] = 0.0;
            held[target] = predicted[target] + gain * missed;
        } else {
            suspect[target] = whole;
            suspected[target] = 1.0;
        }
    }
}

static double largest_doubt(const struct correction *self, const double *state)
{
    const double *doubt = state + self->targets;
    double largest = doubt[0];
    for (size_t target = 1; target < self->targets; target++) {
        largest = doubt[target] > largest ? doubt[target] : largest;
    }
    return largest;
}

void correction_wait(const struct correction *self, double *state, double elapsed_s)
{
    double *bias = state, *doubt = state + self->targets;
    if (largest_doubt(self, state) >= 1.0) {
        return;
    }
    double kept = exp(-elapsed_s / self->memory_s);
    for (size_t target = 0; target < self->targets; target++) {
        bias[target] *= kept;
        doubt[target] = 1.0 - (1.0 - doubt[target]) * kept * kept;
    }
}

double correction_doubt(const struct correction *self, const double *state)
{
    return self->fast + (1.0 - self->fast) * largest_doubt(self, state);
}

const double *correction_held(const struct correction *self, const double *state)
{
    return state + 4 * self->targets;
}
