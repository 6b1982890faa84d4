/* The rises of all chosen sensors as a zero-mean Gaussian, given by its precision matrix. */
#include "spare.h"

#include <math.h>
#include <string.h>

#include "constants.h"
#include "numbers.h"

void spare_make(struct setup *setup, struct spare *self)
{
    size_t count = model_chosen_count;
    if (model_spare.precision == NULL) {
        return;
    }
    self->rises = setup_take(setup, count, sizeof(double));
    self->moved = setup_take(setup, count, sizeof(double));
    self->solved = setup_take(setup, count, sizeof(double));
    self->rows = setup_take(setup, count * count, sizeof(double));
    self->broken = setup_take(setup, count, sizeof(size_t));
}

size_t spare_states(void)
{
    size_t size = sizeof(struct spare_state) + model_chosen_count * sizeof(struct spared);
    return model_spare.precision == NULL ? 0 : size / sizeof(double);
}

void spare_reset(struct spare_state *state)
{
    memset(state, 0, spare_states() * sizeof(double));
    for (size_t place = 0; place < model_chosen_count; place++) {
        state->sensors[place].good_for = -1.0;
    }
}

static const double *row_of(size_t place)
{
    return model_spare.precision + place * model_chosen_count;
}

/* Whether a sensor is replaced, including while it waits to be used again. */
static bool is_out(const struct spared *sensor)
{
    return sensor->good_for >= 0.0;
}

static void find_broken(struct spare *self, const struct spare_state *state)
{
    self->count = 0;
    for (size_t place = 0; place < model_chosen_count; place++) {
        if (is_out(&state->sensors[place])) {
            self->broken[self->count++] = place;
        }
    }
}

/* Solves P_bb solved = moved by elimination: P_bb is positive definite. */
static void solve(const struct spare *self)
{
    double *found = self->solved;
    size_t count = self->count;
    for (size_t i = 0; i < count; i++) {
        for (size_t k = 0; k < count; k++) {
            self->rows[i * count + k] = row_of(self->broken[i])[self->broken[k]];
        }
        found[i] = self->moved[i];
    }
    for (size_t i = 0; i < count; i++) {
        const double *row = self->rows + i * count;
        for (size_t below = i + 1; below < count; below++) {
            double *other = self->rows + below * count, part = other[i] / row[i];
            for (size_t k = i; k < count; k++) {
                other[k] -= part * row[k];
            }
            found[below] -= part * found[i];
        }
    }
    for (size_t i = count; i-- > 0;) {
        const double *row = self->rows + i * count;
        double known = dot(row + i + 1, found + i + 1, count - i - 1);
        found[i] = (found[i] - known) / row[i];
    }
}

/* Computes what broken sensors add to the variance of the drift, for X, Y, Z [um^2]. */
static void add_up(const struct spare *self, struct spare_state *state, const double *axes)
{
    for (size_t axis = 0; axis < 3; axis++, axes += model_target_count) {
        for (size_t i = 0; i < self->count; i++) {
            size_t place = self->broken[i];
            double since = state->clock - state->sensors[place].seen;
            double told = -expm1(-2.0 * since / model_spare.memory_s);
            const double *does = model_spare.sensitivity + place * model_target_count;
            self->moved[i]
                = sqrt(model_spare.growth[place] * told) * dot(axes, does, model_target_count);
        }
        solve(self);
        state->extra[axis] = fmax(dot(self->moved, self->solved, self->count), state->lasting[axis]);
    }
}

/* Tracks how long the broken sensors have been good again. */
static void count_good(struct spare_state *state, const struct spare_sample *sample)
{
    for (size_t place = 0; place < model_chosen_count; place++) {
        double *good_for = &state->sensors[place].good_for;
        if (sample->bad[place]) {
            *good_for = 0.0;
        } else if (*good_for >= 0.0) {
            *good_for += sample->elapsed_s;
            *good_for = *good_for >= model_limits.recover_s ? -1.0 : *good_for;
        }
    }
}

/* Replaces the rises of the broken sensors by their estimates from the others, plus a share of
   their last own deviation. */
static void estimate(
    const struct spare *self, const struct spare_state *state, double *rises, double share)
{
    for (size_t i = 0; i < self->count; i++) {
        rises[self->broken[i]] = 0.0;
    }
    for (size_t i = 0; i < self->count; i++) {
        size_t place = self->broken[i];
        const struct spared *sensor = &state->sensors[place];
        double kept = share * exp(-(state->clock - sensor->seen) / model_spare.memory_s);
        double told = dot(row_of(place), rises, model_chosen_count);
        self->moved[i] = row_of(place)[place] * sensor->own * kept - told;
    }
    solve(self);
    for (size_t i = 0; i < self->count; i++) {
        rises[self->broken[i]] = self->solved[i];
    }
}

/* Replaces the readings of the broken sensors by their estimates [degC]. */
static void fill(const struct spare *self, const struct spare_state *state, double *readings)
{
    for (size_t place = 0; place < model_chosen_count; place++) {
        self->rises[place] = readings[place] - state->sensors[place].first;
    }
    estimate(self, state, self->rises, 1.0);
    for (size_t i = 0; i < self->count; i++) {
        size_t place = self->broken[i];
        readings[place] = state->sensors[place].first + self->rises[place];
    }
}

void spare_derive(struct spare *self, const struct spare_state *state, double *readings)
{
    find_broken(self, state);
    estimate(self, state, readings, 0.0);
}

/* Stores the deviation of one sensor from its estimate by the others; sensors take turns. An
   unchanged reading tells nothing new. */
static void compare(struct spare_state *state, const struct spare_sample *sample)
{
    size_t place = (size_t)state->turn;
    const double *row = row_of(place);
    double total = 0.0;
    state->turn = (double)((place + 1) % model_chosen_count);
    if (is_out(&state->sensors[place]) || sample->sensors[place].unchanged > 0.0) {
        return;
    }
    for (size_t i = 0; i < model_chosen_count; i++) {
        total += row[i] * (sample->readings[i] - state->sensors[i].first);
    }
    state->sensors[place].own = total / row[place];
    state->sensors[place].seen = state->clock;
}

/* Computes the references of rises if some sensors are bad; false if levels matter. */
static bool guess_first(
    const struct spare *self, struct spare_state *state, const struct spare_sample *sample)
{
    size_t count = 0;
    for (size_t place = 0; place < model_chosen_count; place++) {
        if (!sample->bad[place]) {
            self->moved[count++] = sample->readings[place];
        }
    }
    if (model_spare.usual_start == NULL || count == 0) {
        return false;
    }
    double middle = median(self->moved, count, self->solved);
    for (size_t place = 0; place < model_chosen_count; place++) {
        struct spared *sensor = &state->sensors[place];
        double reference = sample->sensors[place].reference;
        sensor->unread = isnan(reference);
        sensor->first = isnan(reference) ? middle + model_spare.usual_start[place] : reference;
        sensor->good_for = sample->bad[place] ? 0.0 : -1.0;
        sample->sensors[place].reference = sensor->first;
    }
    return true;
}

/* Processes a sample before the first one that is used, without some sensors. */
static bool start_without(
    struct spare *self, struct spare_state *state, const struct spare_sample *sample)
{
    if (state->clock < model_limits.recover_s || !guess_first(self, state, sample)) {
        state->clock = clamped(state->clock + sample->elapsed_s, 0.0, FIELDS_LARGEST);
        return false;
    }
    state->clock = 0.0;
    find_broken(self, state);
    fill(self, state, sample->readings);
    return true;
}

/* Lets a sensor that is good for the first time continue from its estimate; shifts readings. */
static void read_at_last(struct spare_state *state, double *readings)
{
    for (size_t place = 0; place < model_chosen_count; place++) {
        struct spared *sensor = &state->sensors[place];
        if (sensor->unread != 0.0 && !is_out(sensor)) {
            sensor->unread = 0.0;
            sensor->shift = sensor->last - readings[place];
            for (size_t axis = 0; axis < 3; axis++) {
                state->lasting[axis] = fmax(state->lasting[axis], state->extra[axis]);
            }
        }
        readings[place] += sensor->shift;
    }
}

/* Processes a sample after the first one that was used. */
static bool go_on(
    struct spare *self, struct spare_state *state, const struct spare_sample *sample)
{
    state->clock = clamped(state->clock + sample->elapsed_s, 0.0, FIELDS_LARGEST);
    count_good(state, sample);
    find_broken(self, state);
    if (self->count == model_chosen_count) {
        if (sample->any_bad) {
            return false;
        }
        /* All are good again, and the offsets wait for recovery anyway. */
        for (size_t place = 0; place < model_chosen_count; place++) {
            state->sensors[place].good_for = -1.0;
        }
        self->count = 0;
    }
    read_at_last(state, sample->readings);
    if (self->count > 0) {
        fill(self, state, sample->readings);
    }
    add_up(self, state, sample->axes);
    compare(state, sample);
    return true;
}

bool spare_step(
    struct spare *self, struct spare_state *state, const struct spare_sample *sample)
{
    bool starts = state->started == 0.0, whole = starts && !sample->any_bad;
    if (whole) {
        state->clock = 0.0;
        self->count = 0;
    } else if (!(starts ? start_without(self, state, sample) : go_on(self, state, sample))) {
        return false;
    }
    for (size_t place = 0; place < model_chosen_count; place++) {
        struct spared *sensor = &state->sensors[place];
        sensor->first = whole ? sample->readings[place] : sensor->first;
        sensor->last = sample->readings[place];
    }
    state->started = 1.0;
    return true;
}
