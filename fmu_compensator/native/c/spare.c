/* The rises of all chosen sensors as a Gaussian of mean zero, by its precision matrix. */
#include "spare.h"

#include <math.h>
#include <string.h>

#include "constants.h"
#include "numbers.h"

struct spare_state spare_state(const struct spare *self, double *state)
{
    struct spare_state at;
    at.started = state;
    at.stopped = state + 1;
    at.clock = state + 2;
    at.turn = state + 3;
    at.first = state + 4;
    at.last = at.first + self->inputs;
    at.own = at.last + self->inputs;
    at.seen = at.own + self->inputs;
    at.gap = at.seen + self->inputs;
    at.good_for = at.gap + self->inputs;
    at.unread = at.good_for + self->inputs;
    at.shift = at.unread + self->inputs;
    at.extra = at.shift + self->inputs;
    at.lasting = at.extra + 3;
    return at;
}

struct spare *spare_make(
    struct setup *setup, const struct field *table, size_t inputs, size_t targets)
{
    struct spare *self = table->form == FIELD_NULL ? NULL : setup_take(setup, 1, sizeof *self);
    if (self == NULL) {
        return NULL;
    }
    self->inputs = inputs;
    self->targets = targets;
    self->states = 4 + 8 * inputs + 6;
    self->memory_s = field_number(setup, table, "memory_s");
    self->precision = field_matrix(setup, table, "precision", NULL);
    self->growth = field_numbers(setup, table, "growth", NULL);
    self->usual_start = field_numbers(setup, table, "usual_start", NULL);
    self->sensitivity = field_matrix(setup, table, "sensitivity", NULL);
    self->usual = field_matrix(setup, table, "usual", NULL);
    self->before = setup_take(setup, inputs, sizeof(double));
    self->rises = setup_take(setup, inputs, sizeof(double));
    self->moved = setup_take(setup, inputs, sizeof(double));
    self->solved = setup_take(setup, inputs, sizeof(double));
    self->rows = setup_take(setup, inputs * inputs, sizeof(double));
    self->broken = setup_take(setup, inputs, sizeof(size_t));
    return self;
}

void spare_reset(const struct spare *self, double *state)
{
    struct spare_state at = spare_state(self, state);
    memset(state, 0, self->states * sizeof(double));
    for (size_t place = 0; place < self->inputs; place++) {
        at.good_for[place] = -1.0;
    }
}

/* Notes which sensors are done without, or wait for their return; returns how many. */
static size_t count_broken(const struct spare *self, const struct spare_state *at)
{
    size_t count = 0;
    for (size_t place = 0; place < self->inputs; place++) {
        if (at->good_for[place] >= 0.0) {
            self->broken[count++] = place;
        }
    }
    return count;
}

/* Solves P_bb x = right by elimination: P_bb is positive definite. */
static void solve(const struct spare *self, size_t count, const double *right)
{
    double *found = self->solved;
    for (size_t i = 0; i < count; i++) {
        const double *row = self->precision + self->broken[i] * self->inputs;
        for (size_t k = 0; k < count; k++) {
            self->rows[i * count + k] = row[self->broken[k]];
        }
        found[i] = right[i];
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

/* Puts down what the broken sensors add to the variance of the drift, for X, Y, Z [um^2]. */
static void add_up(
    const struct spare *self, const struct spare_state *at, size_t count, const double *axes,
    bool lasting, double added[3])
{
    for (size_t axis = 0; axis < 3; axis++) {
        const double *weights = axes + axis * self->targets;
        for (size_t i = 0; i < count; i++) {
            size_t place = self->broken[i];
            double told = 1.0, moved = 0.0;
            if (!lasting) {
                told = -expm1(-2.0 * (*at->clock - at->seen[place]) / self->memory_s);
            }
            for (size_t target = 0; target < self->targets; target++) {
                moved += weights[target] * self->sensitivity[target * self->inputs + place];
            }
            self->moved[i] = sqrt(self->growth[place] * told) * moved;
        }
        solve(self, count, self->moved);
        double total = dot(self->moved, self->solved, count);
        added[axis] = total > 0.0 ? total : 0.0;
    }
}

/* Returns the mean square of the drift along an axis in training [um^2]. */
static double usual(const struct spare *self, const double *weights)
{
    double total = 0.0;
    for (size_t row = 0; row < self->targets; row++) {
        for (size_t column = 0; column < self->targets; column++) {
            double square = self->usual[row * self->targets + column];
            total += weights[row] * weights[column] * square;
        }
    }
    return total;
}

/* Returns whether some drift stays known to better than its usual size, for long. */
static bool can_go_on(
    const struct spare *self, const struct spare_state *at, size_t count, const double *axes)
{
    double lost[3];
    if (count == 0 || count == self->inputs) {
        return count == 0;
    }
    add_up(self, at, count, axes, true, lost);
    for (size_t axis = 0; axis < 3; axis++) {
        double most = usual(self, axes + axis * self->targets);
        if (most > 0.0 && lost[axis] <= most) {
            return true;
        }
    }
    return false;
}

/* Counts how long the broken sensors have been good again. */
static void count_good(
    const struct spare *self, const struct spare_state *at, const struct spare_sample *sample)
{
    for (size_t place = 0; place < self->inputs; place++) {
        double *good_for = &at->good_for[place];
        if (sample->bad[place]) {
            *good_for = 0.0;
        } else if (*good_for >= 0.0) {
            *good_for += sample->elapsed_s;
            *good_for = *good_for >= sample->recover_s ? -1.0 : *good_for;
        }
    }
}

/* Replaces the readings of the broken sensors by what they are likely to be [degC]. */
static void fill(
    const struct spare *self, const struct spare_state *at, size_t count, double *readings)
{
    for (size_t place = 0; place < self->inputs; place++) {
        bool out = at->good_for[place] >= 0.0;
        self->rises[place] = out ? 0.0 : readings[place] - at->first[place];
    }
    for (size_t i = 0; i < count; i++) {
        size_t place = self->broken[i];
        const double *row = self->precision + place * self->inputs;
        double kept = exp(-(*at->clock - at->seen[place]) / self->memory_s);
        self->moved[i] = row[place] * at->own[place] * kept - dot(row, self->rises, self->inputs);
    }
    solve(self, count, self->moved);
    for (size_t i = 0; i < count; i++) {
        readings[self->broken[i]] = at->first[self->broken[i]] + self->solved[i];
    }
}

/* Whether a sensor is done without, or was in the sample before. */
static bool involved(const struct spare *self, const struct spare_state *at, size_t place)
{
    return self->before[place] >= 0.0 || at->good_for[place] >= 0.0;
}

/* Whether other sensors are done without than in the sample before. */
static bool has_changed(const struct spare *self, const struct spare_state *at)
{
    bool changed = false;
    for (size_t place = 0; place < self->inputs; place++) {
        changed = changed || (self->before[place] >= 0.0) != (at->good_for[place] >= 0.0);
    }
    return changed;
}

void spare_derive(const struct spare *self, double *state, double *readings)
{
    struct spare_state at = spare_state(self, state);
    size_t count = count_broken(self, &at);
    for (size_t i = 0; i < count; i++) {
        readings[self->broken[i]] = 0.0;
    }
    for (size_t i = 0; i < count; i++) {
        const double *row = self->precision + self->broken[i] * self->inputs;
        self->moved[i] = 0.0 - dot(row, readings, self->inputs);
    }
    solve(self, count, self->moved);
    for (size_t i = 0; i < count; i++) {
        readings[self->broken[i]] = self->solved[i];
    }
    /* Where this sample came from elsewhere than the one before, that one was shown again. */
    bool changed = has_changed(self, &at);
    for (size_t place = 0; place < self->inputs; place++) {
        if (changed && at.gap[place] != 0.0 && involved(self, &at, place)) {
            readings[place] = 0.0;
        }
    }
}

/* Lets no reading step when it comes from elsewhere than in the sample before. */
static void blend(
    const struct spare *self, const struct spare_state *at, double *used, double kept)
{
    bool changed = has_changed(self, at);
    if (*at->stopped != 0.0) {
        /* The offsets are elsewhere as well. */
        memset(at->gap, 0, self->inputs * sizeof(double));
        return;
    }
    for (size_t place = 0; place < self->inputs; place++) {
        at->gap[place] *= kept;
        if (changed && involved(self, at, place)) {
            at->gap[place] = at->last[place] - used[place];
        }
        used[place] += at->gap[place];
    }
}

static double larger(double a, double b)
{
    return a > b ? a : b;
}

static void fade_extra(
    const struct spare *self, const struct spare_state *at, size_t count, double kept,
    const double *axes)
{
    double now[3] = {0.0, 0.0, 0.0};
    if (count > 0) {
        add_up(self, at, count, axes, false, now);
    }
    for (size_t axis = 0; axis < 3; axis++) {
        at->extra[axis] = larger(now[axis], at->extra[axis] * kept);
        at->extra[axis] = larger(at->extra[axis], at->lasting[axis]);
    }
}

/* Puts down what one sensor reads beyond what the others say; each has its turn. */
static void compare(
    const struct spare *self, const struct spare_state *at, const double *used, bool stands)
{
    size_t place = (size_t)*at->turn;
    *at->turn = (double)((place + 1) % self->inputs);
    if (at->good_for[place] >= 0.0 || stands) {
        return;
    }
    const double *row = self->precision + place * self->inputs;
    double total = 0.0;
    for (size_t i = 0; i < self->inputs; i++) {
        total += row[i] * (used[i] - at->first[i]);
    }
    at->own[place] = total / row[place];
    at->seen[place] = *at->clock;
}

/* Puts down from where rises may count without the bad sensors; false where a level matters. */
static bool guess_first(
    const struct spare *self, const struct spare_state *at, const struct spare_sample *sample)
{
    double *good = self->moved;
    size_t count = 0;
    for (size_t place = 0; place < self->inputs; place++) {
        if (!sample->bad[place]) {
            good[count++] = sample->readings[place];
        }
    }
    if (self->usual_start == NULL || count == 0) {
        return false;
    }
    double middle = median(good, count, self->solved);
    for (size_t place = 0; place < self->inputs; place++) {
        bool unread = isnan(sample->reference[place]);
        double likely = middle + self->usual_start[place];
        at->first[place] = unread ? likely : sample->reference[place];
        at->unread[place] = unread;
    }
    return true;
}

/* Takes in a sample before the first one in use, without some sensors. */
static bool start_without(
    const struct spare *self, double *state, const struct spare_sample *sample)
{
    struct spare_state at = spare_state(self, state);
    double waited = *at.clock;
    if (waited >= SPARE_START_AFTER_S && guess_first(self, &at, sample)) {
        *at.clock = 0.0;
        for (size_t place = 0; place < self->inputs; place++) {
            at.good_for[place] = sample->bad[place] ? 0.0 : -1.0;
        }
        size_t count = count_broken(self, &at);
        if (can_go_on(self, &at, count, sample->axes)) {
            *at.started = 1.0;
            memcpy(sample->reference, at.first, self->inputs * sizeof(double));
            fill(self, &at, count, sample->readings);
            return true;
        }
        spare_reset(self, state);
    } else {
        waited = clamped(waited + sample->elapsed_s, 0.0, FIELDS_LARGEST);
    }
    *at.clock = waited;
    return false;
}

/* Lets a sensor that is good for the first time go on from its estimate. */
static void read_at_last(
    const struct spare *self, const struct spare_state *at, const double *readings)
{
    for (size_t place = 0; place < self->inputs; place++) {
        if (at->unread[place] != 0.0 && at->good_for[place] < 0.0) {
            at->unread[place] = 0.0;
            at->shift[place] = at->last[place] - readings[place];
            for (size_t axis = 0; axis < 3; axis++) {
                at->lasting[axis] = larger(at->lasting[axis], at->extra[axis]);
            }
        }
    }
}

static bool any(const bool *bad, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (bad[i]) {
            return true;
        }
    }
    return false;
}

/* Takes in a sample after the first one in use. */
static bool go_on(const struct spare *self, double *state, const struct spare_sample *sample)
{
    struct spare_state at = spare_state(self, state);
    double *readings = sample->readings;
    *at.clock = clamped(*at.clock + sample->elapsed_s, 0.0, FIELDS_LARGEST);
    memcpy(self->before, at.good_for, self->inputs * sizeof(double));
    count_good(self, &at, sample);
    size_t count = count_broken(self, &at);
    if (!can_go_on(self, &at, count, sample->axes)) {
        if (any(sample->bad, self->inputs)) {
            *at.stopped = 1.0;
            return false;
        }
        /* All are good, and the offsets wait for them anyway. */
        for (size_t place = 0; place < self->inputs; place++) {
            at.good_for[place] = -1.0;
        }
        count = 0;
    }
    read_at_last(self, &at, readings);
    for (size_t place = 0; place < self->inputs; place++) {
        readings[place] += at.shift[place];
    }
    if (count > 0) {
        fill(self, &at, count, readings);
    }
    double kept = exp(-sample->elapsed_s / SPARE_BLEND_S);
    blend(self, &at, readings, kept);
    fade_extra(self, &at, count, kept, sample->axes);
    compare(self, &at, readings, sample->stands);
    *at.stopped = 0.0;
    return true;
}

bool spare_step(const struct spare *self, double *state, const struct spare_sample *sample)
{
    struct spare_state at = spare_state(self, state);
    size_t size = self->inputs * sizeof(double);
    if (*at.started != 0.0) {
        if (!go_on(self, state, sample)) {
            return false;
        }
    } else if (any(sample->bad, self->inputs)) {
        if (!start_without(self, state, sample)) {
            return false;
        }
    } else {
        *at.started = 1.0;
        *at.clock = 0.0;
        memcpy(at.first, sample->readings, size);
    }
    memcpy(at.last, sample->readings, size);
    return true;
}
