/* The rises of all chosen sensors as a Gaussian of mean zero, by its precision matrix.

   State: started, stopped, the clock, whose turn it is; then of each sensor its first reading, the
   last used one, what is its own, when that was seen, the gap, for how long it is good again,
   whether it has not read since the start, and the shift from its readings to those used; then the
   variances of X, Y and Z, and what stays of them. */
#include "spare.h"

#include <math.h>
#include <string.h>

#include "numbers.h"

/* The parts of the state. */
struct memory {
    double *started, *stopped, *clock, *turn;
    double *first, *last, *own, *seen, *gap, *good_for, *unread, *shift, *extra, *lasting;
};

/* The inverse of the broken sensors' part of the precision, times its determinant. */
struct covariance {
    double aa, ab, bb, determinant;
};

static struct memory memory_of(const struct spare *self, double *state)
{
    struct memory memory;
    memory.started = state;
    memory.stopped = state + 1;
    memory.clock = state + 2;
    memory.turn = state + 3;
    memory.first = state + 4;
    memory.last = memory.first + self->inputs;
    memory.own = memory.last + self->inputs;
    memory.seen = memory.own + self->inputs;
    memory.gap = memory.seen + self->inputs;
    memory.good_for = memory.gap + self->inputs;
    memory.unread = memory.good_for + self->inputs;
    memory.shift = memory.unread + self->inputs;
    memory.extra = memory.shift + self->inputs;
    memory.lasting = memory.extra + 3;
    return memory;
}

struct spare *spare_make(struct setup *setup, const struct field *table, size_t inputs)
{
    if (table->form == FIELD_NULL) {
        return NULL;
    }
    struct spare *self = setup_take(setup, 1, sizeof *self);
    if (self == NULL) {
        return NULL;
    }
    self->inputs = inputs;
    self->states = 4 + 8 * inputs + 6;
    self->memory_s = field_number(setup, table, "memory_s");
    self->deviations = field_number(setup, table, "deviations");
    self->precision = field_matrix(setup, table, "precision", NULL);
    self->growth = field_numbers(setup, table, "growth", NULL);
    self->um_per_k[0] = field_matrix(setup, table, "shortest_tool_um_per_K", NULL);
    self->um_per_k[1] = field_matrix(setup, table, "longest_tool_um_per_K", NULL);
    self->usual_um[0] = field_numbers(setup, table, "shortest_tool_usual_um", NULL);
    self->usual_um[1] = field_numbers(setup, table, "longest_tool_usual_um", NULL);
    self->before = setup_take(setup, inputs, sizeof(double));
    self->rises = setup_take(setup, inputs, sizeof(double));
    return self;
}

void spare_reset(const struct spare *self, double *state)
{
    struct memory memory = memory_of(self, state);
    memset(state, 0, self->states * sizeof(double));
    for (size_t place = 0; place < self->inputs; place++) {
        memory.good_for[place] = -1.0;
    }
}

size_t spare_turn(const double *state)
{
    return (size_t)state[3];
}

static struct broken broken_of(const struct spare *self, const struct memory *memory)
{
    struct broken broken = {0, {0, 0}};
    for (size_t place = 0; place < self->inputs; place++) {
        if (memory->good_for[place] >= 0.0) {
            if (broken.count < SPARE_MOST_BROKEN) {
                broken.places[broken.count] = place;
            }
            broken.count++;
        }
    }
    return broken;
}

struct broken spare_broken(const struct spare *self, const double *state)
{
    /* The memory is only looked at. */
    struct memory memory = memory_of(self, (double *)state);
    return broken_of(self, &memory);
}

static const double *row_of(const struct spare *self, size_t place)
{
    return self->precision + place * self->inputs;
}

static double between(double shortest, double longest, double tool_share)
{
    return shortest + tool_share * (longest - shortest);
}

static double usual(const struct spare *self, size_t axis, double tool_share)
{
    return between(self->usual_um[0][axis], self->usual_um[1][axis], tool_share);
}

static struct covariance covariance_of(const struct spare *self, const struct broken *broken)
{
    size_t a = broken->places[0], b = broken->places[1];
    struct covariance found = {1.0, 0.0, 0.0, row_of(self, a)[a]};
    if (broken->count > 1) {
        double p = row_of(self, a)[a], q = row_of(self, a)[b], r = row_of(self, b)[b];
        found.aa = r;
        found.ab = -q;
        found.bb = p;
        found.determinant = p * r - q * q;
    }
    return found;
}

/* Returns what a unit of the precision's deviation of one sensor does to the drift [um/K]. */
static double weight(
    const struct spare *self, const struct memory *memory, size_t axis, size_t place,
    double tool_share, bool lasting)
{
    size_t at = axis * self->inputs + place;
    double told = 1.0;
    if (!lasting) {
        told = -expm1(-2.0 * (*memory->clock - memory->seen[place]) / self->memory_s);
    }
    return between(self->um_per_k[0][at], self->um_per_k[1][at], tool_share)
           * sqrt(self->growth[place] * told);
}

/* Returns what the broken sensors add to the variance of the drift along an axis [um^2]. */
static double variance(
    const struct spare *self, const struct memory *memory, const struct broken *broken,
    size_t axis, double tool_share, bool lasting)
{
    struct covariance by = covariance_of(self, broken);
    double a = weight(self, memory, axis, broken->places[0], tool_share, lasting);
    double total = by.aa * a * a;
    if (broken->count > 1) {
        double b = weight(self, memory, axis, broken->places[1], tool_share, lasting);
        total += 2.0 * by.ab * a * b + by.bb * b * b;
    }
    total /= by.determinant;
    return total > 0.0 ? total : 0.0;
}

/* Counts how long the broken sensors have been good again. */
static void count(
    const struct spare *self, const struct memory *memory, const bool *bad, double elapsed_s,
    double recover_s)
{
    for (size_t place = 0; place < self->inputs; place++) {
        double *good_for = &memory->good_for[place];
        if (bad[place]) {
            *good_for = 0.0;
        } else if (*good_for >= 0.0) {
            *good_for += elapsed_s;
            *good_for = *good_for >= recover_s ? -1.0 : *good_for;
        }
    }
}

/* Returns whether some drift stays known to better than its usual size, for long. */
static bool can_go_on(
    const struct spare *self, const struct memory *memory, const struct broken *broken,
    double tool_share)
{
    if (broken->count == 0) {
        return true;
    }
    for (size_t axis = 0; axis < 3 && broken->count <= SPARE_MOST_BROKEN; axis++) {
        double size = usual(self, axis, tool_share);
        if (size > 0.0
            && variance(self, memory, broken, axis, tool_share, true) <= size * size) {
            return true;
        }
    }
    return false;
}

/* Replaces the readings of the broken sensors by what they are likely to be [degC]. */
static void fill(
    const struct spare *self, const struct memory *memory, const struct broken *broken,
    double *readings)
{
    double pulls[SPARE_MOST_BROKEN];
    if (broken->count == 0) {
        return;
    }
    for (size_t place = 0; place < self->inputs; place++) {
        bool out = memory->good_for[place] >= 0.0;
        self->rises[place] = out ? 0.0 : readings[place] - memory->first[place];
    }
    for (size_t i = 0; i < broken->count; i++) {
        size_t place = broken->places[i];
        const double *row = row_of(self, place);
        double kept = exp(-(*memory->clock - memory->seen[place]) / self->memory_s);
        pulls[i] = row[place] * memory->own[place] * kept - dot(row, self->rises, self->inputs);
    }
    struct covariance by = covariance_of(self, broken);
    size_t a = broken->places[0], b = broken->places[1];
    if (broken->count == 1) {
        readings[a] = memory->first[a] + by.aa * pulls[0] / by.determinant;
    } else {
        readings[a]
            = memory->first[a] + (by.aa * pulls[0] + by.ab * pulls[1]) / by.determinant;
        readings[b]
            = memory->first[b] + (by.ab * pulls[0] + by.bb * pulls[1]) / by.determinant;
    }
}

/* Lets no reading step when it comes from elsewhere than in the sample before. */
static void blend(
    const struct spare *self, const struct memory *memory, double *used, double kept)
{
    bool changed = false;
    if (*memory->stopped != 0.0) {
        /* The offsets are elsewhere as well. */
        memset(memory->gap, 0, self->inputs * sizeof(double));
        return;
    }
    for (size_t place = 0; place < self->inputs; place++) {
        changed = changed || (self->before[place] >= 0.0) != (memory->good_for[place] >= 0.0);
        memory->gap[place] *= kept;
    }
    for (size_t place = 0; place < self->inputs; place++) {
        if (changed && (self->before[place] >= 0.0 || memory->good_for[place] >= 0.0)) {
            memory->gap[place] = memory->last[place] - used[place];
        }
        used[place] += memory->gap[place];
    }
}

static void fade_extra(
    const struct spare *self, const struct memory *memory, const struct broken *broken,
    double kept, double tool_share)
{
    for (size_t axis = 0; axis < 3; axis++) {
        memory->extra[axis] *= kept;
        if (broken->count > 0) {
            double now = variance(self, memory, broken, axis, tool_share, false);
            memory->extra[axis] = now > memory->extra[axis] ? now : memory->extra[axis];
        }
        if (memory->extra[axis] < memory->lasting[axis]) {
            memory->extra[axis] = memory->lasting[axis];
        }
    }
}

/* Puts down what one sensor reads beyond what the others say; each has its turn. */
static void compare(
    const struct spare *self, const struct memory *memory, const double *used, double idle)
{
    size_t place = (size_t)*memory->turn;
    *memory->turn = (double)((place + 1) % self->inputs);
    if (memory->good_for[place] >= 0.0 || idle > SPARE_FRESH) {
        return;
    }
    for (size_t i = 0; i < self->inputs; i++) {
        self->rises[i] = used[i] - memory->first[i];
    }
    const double *row = row_of(self, place);
    memory->own[place] = dot(row, self->rises, self->inputs) / row[place];
    memory->seen[place] = *memory->clock;
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

/* Takes in a sample before the first one in use. */
static bool start(
    const struct spare *self, const struct memory *memory, double *readings, const bool *bad,
    double elapsed_s, double tool_share, const struct starts *starts)
{
    size_t size = self->inputs * sizeof(double);
    if (!any(bad, self->inputs)) {
        *memory->started = 1.0;
        *memory->clock = 0.0;
        memcpy(memory->first, readings, size);
        memcpy(memory->last, readings, size);
        return true;
    }
    if (!starts->known || *memory->clock < SPARE_START_AFTER_S) {
        *memory->clock = clamped(*memory->clock + elapsed_s, 0.0, SPARE_MOST_S);
        return false;
    }
    double waited = *memory->clock;
    *memory->clock = 0.0;
    for (size_t place = 0; place < self->inputs; place++) {
        memory->good_for[place] = bad[place] ? 0.0 : -1.0;
    }
    struct broken broken = broken_of(self, memory);
    if (!can_go_on(self, memory, &broken, tool_share)) {
        *memory->clock = waited;
        for (size_t place = 0; place < self->inputs; place++) {
            memory->good_for[place] = -1.0;
        }
        return false;
    }
    *memory->started = 1.0;
    for (size_t place = 0; place < self->inputs; place++) {
        memory->first[place] = starts->first[place];
        memory->unread[place] = starts->unread[place] ? 1.0 : 0.0;
    }
    fill(self, memory, &broken, readings);
    memcpy(memory->last, readings, size);
    return true;
}

/* Lets a sensor that is good for the first time go on from its estimate. */
static void read_at_last(
    const struct spare *self, const struct memory *memory, const double *readings)
{
    for (size_t place = 0; place < self->inputs; place++) {
        if (memory->unread[place] == 0.0 || memory->good_for[place] >= 0.0) {
            continue;
        }
        memory->unread[place] = 0.0;
        memory->shift[place] = memory->last[place] - readings[place];
        for (size_t axis = 0; axis < 3; axis++) {
            if (memory->lasting[axis] < memory->extra[axis]) {
                memory->lasting[axis] = memory->extra[axis];
            }
        }
    }
}

bool spare_step(
    const struct spare *self, double *state, double *readings, const bool *bad, double idle,
    double elapsed_s, double recover_s, double tool_share, const struct starts *starts)
{
    struct memory memory = memory_of(self, state);
    size_t size = self->inputs * sizeof(double);
    if (*memory.started == 0.0) {
        return start(self, &memory, readings, bad, elapsed_s, tool_share, starts);
    }
    *memory.clock = clamped(*memory.clock + elapsed_s, 0.0, SPARE_MOST_S);
    memcpy(self->before, memory.good_for, size);
    count(self, &memory, bad, elapsed_s, recover_s);
    struct broken broken = broken_of(self, &memory);
    if (!can_go_on(self, &memory, &broken, tool_share)) {
        if (any(bad, self->inputs)) {
            *memory.stopped = 1.0;
            return false;
        }
        /* All are good, and the offsets wait for them anyway. */
        for (size_t place = 0; place < self->inputs; place++) {
            memory.good_for[place] = -1.0;
        }
        broken.count = 0;
    }
    read_at_last(self, &memory, readings);
    for (size_t place = 0; place < self->inputs; place++) {
        readings[place] += memory.shift[place];
    }
    fill(self, &memory, &broken, readings);
    double kept = exp(-elapsed_s / SPARE_BLEND_S);
    blend(self, &memory, readings, kept);
    fade_extra(self, &memory, &broken, kept, tool_share);
    compare(self, &memory, readings, idle);
    *memory.stopped = 0.0;
    memcpy(memory.last, readings, size);
    return true;
}

double spare_faded(
    const struct spare *self, const double *state, size_t axis, double tool_share, double doubt)
{
    double extra = state[self->states - 6 + axis] * doubt;
    double size = usual(self, axis, tool_share);
    return extra > 0.0 ? size * size / (size * size + extra) : 1.0;
}

void spare_widen(
    const struct spare *self, const double *state, double half_width[3], double doubt)
{
    const double *extra = state + self->states - 6;
    double scale = self->deviations * self->deviations * doubt;
    for (size_t axis = 0; axis < 3; axis++) {
        double width = half_width[axis];
        /* A root of a square need not be the number again: without doubt it is left alone. */
        if (width >= 0.0 && extra[axis] > 0.0) {
            half_width[axis] = sqrt(width * width + scale * extra[axis]);
        }
    }
}
