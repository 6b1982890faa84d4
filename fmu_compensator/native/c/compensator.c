#include "compensator.h"

#include <math.h>
#include <string.h>

#include "constants.h"
#include "numbers.h"

struct parts compensator_parts(const struct compensator *self, double *numbers)
{
    struct parts parts;
    parts.reference = numbers;
    parts.checks = (struct sensor_memory *)(parts.reference + model_chosen_count);
    parts.measured = (double *)(parts.checks + model_chosen_count);
    parts.targets = parts.measured + model_target_count;
    parts.gaussian = parts.targets + model_target_count;
    parts.spare = parts.gaussian + self->gaussian.states;
    parts.error_model = parts.spare + (self->spare == NULL ? 0 : self->spare->states);
    return parts;
}

void compensator_make(struct setup *setup, struct compensator *self)
{
    size_t chosen = model_chosen_count, targets = model_target_count;
    geometry_make(setup, &model_geometry, &self->geometry);
    gaussian_make(setup, &model_gaussian, chosen, targets, &self->gaussian);
    self->error_model = error_model_make(setup, &model_error_model, chosen, targets);
    self->spare = spare_make(setup, &model_spare, chosen, targets);
    self->bad = setup_take(setup, chosen, sizeof(bool));
    self->rises = setup_take(setup, chosen, sizeof(double));
    self->readings = setup_take(setup, chosen, sizeof(double));
    self->missed = setup_take(setup, targets, sizeof(double));
    self->axes = setup_take(setup, 3 * targets, sizeof(double));
    self->spread = setup_take(setup, 4, sizeof(double));
    self->moved = setup_take(setup, targets, sizeof(double));
    if (self->error_model == NULL || self->moved == NULL) {
        setup_fail(setup, "the compiled-in file cannot be used", "error_model");
        return;
    }
    self->spread[3] = NAN;
    self->numbers = chosen * (1 + sizeof(struct sensor_memory) / sizeof(double)) + 2 * targets
                    + self->gaussian.states + self->error_model->states
                    + (self->spare == NULL ? 0 : self->spare->states);
}

/* Puts down an output; the reason is NULL where there is none. */
static void put(
    const struct remembered *memory, bool valid, int32_t status, const struct reason *reason,
    struct output *output)
{
    static const struct reason no_reason = {0, 0, 0.0, 0.0, 0.0};
    output->dX = memory->offset[0];
    output->dY = memory->offset[1];
    output->dZ = memory->offset[2];
    output->elongation = memory->pose[0];
    output->yaw = memory->pose[1];
    output->pitch = memory->pose[2];
    output->dX_uncertainty = memory->half_width[0];
    output->dY_uncertainty = memory->half_width[1];
    output->dZ_uncertainty = memory->half_width[2];
    output->valid = valid;
    output->status = status;
    output->reason = reason == NULL ? no_reason : *reason;
    output->status_sensor = output->reason.sensor;
    memset(output->also_without, 0, sizeof output->also_without);
}

void compensator_reset(
    const struct compensator *self, struct remembered *memory, double *numbers,
    struct output *output)
{
    static const struct remembered nothing;
    struct parts parts = compensator_parts(self, numbers);
    *memory = nothing;
    memory->last_time = NAN;
    for (size_t axis = 0; axis < 3; axis++) {
        memory->half_width[axis] = PREDICTION_NOT_KNOWN;
    }
    for (size_t place = 0; place < model_chosen_count; place++) {
        parts.reference[place] = NAN;
        sensor_reset(&parts.checks[place]);
    }
    memset(parts.measured, 0, 2 * model_target_count * sizeof(double));
    gaussian_reset(&self->gaussian, parts.gaussian);
    if (self->spare != NULL) {
        spare_reset(self->spare, parts.spare);
    }
    error_model_reset(self->error_model, parts.error_model);
    put(memory, false, COMPENSATOR_WAITING, NULL, output);
}

/* Returns the time since the sample before this one [s]; 0 for the first. */
static double elapsed_since(struct remembered *memory, double time_s, double step_s)
{
    double last = memory->last_time;
    memory->last_time = isfinite(time_s) ? time_s : NAN;
    if (isnan(last) || !isfinite(time_s) || time_s < last) {
        return step_s;
    }
    double elapsed_s = time_s - last;
    return elapsed_s > FIELDS_LARGEST ? FIELDS_LARGEST : elapsed_s;
}

static struct reason look_at_tool(double tool_length)
{
    struct reason fault = {0, 0, tool_length, 0.0, 0.0};
    if (!isfinite(tool_length)) {
        fault.cause = CHECKS_MISSING;
    } else if (!(model_limits.tool_length_mm[0] <= tool_length
                 && tool_length <= model_limits.tool_length_mm[1])) {
        fault.cause = CHECKS_IMPLAUSIBLE;
    }
    return fault;
}

/* Puts down what follows from a tool's length; the nearest allowed one where it is none. */
static void set_tool(const struct compensator *self, double tool_length)
{
    double low = model_limits.tool_length_mm[0], high = model_limits.tool_length_mm[1];
    double nearest = tool_length > low ? clamped(tool_length, low, high) : low;
    if (nearest == self->spread[3]) {
        return;
    }
    geometry_weights(&self->geometry, nearest, model_target_count, self->axes);
    for (size_t axis = 0; axis < 3; axis++) {
        self->spread[axis] = gaussian_axis_deviation(
            &self->gaussian, self->axes + axis * model_target_count);
    }
    self->spread[3] = nearest;
}

/* Replaces what broken sensors read; returns the fault that is left. */
static struct reason replaced(
    const struct compensator *self, struct remembered *memory, const struct parts *parts,
    const struct reason *fault, double elapsed_s)
{
    static const struct reason no_fault = {0, 0, 0.0, 0.0, 0.0};
    size_t turn = (size_t)*spare_state(self->spare, parts->spare).turn;
    struct spare_sample sample = {
        self->readings, self->bad, parts->reference,
        parts->checks[turn].unchanged > 0.0, elapsed_s, model_limits.recover_s, self->axes};
    bool goes_on = spare_step(self->spare, parts->spare, &sample);
    if (fault->cause != 0) {
        memory->spared = *fault;
    }
    if (!goes_on) {
        return *fault;
    }
    const double *good_for = spare_state(self->spare, parts->spare).good_for;
    for (size_t place = 0; place < model_chosen_count; place++) {
        if (good_for[place] >= 0.0) {
            return no_fault;
        }
    }
    memory->spared = no_fault;
    return no_fault;
}

/* Returns the first fault; every sensor is looked at, so that none loses count of time. What broken
   sensors read is replaced where the file knows what that is likely to be. */
static struct reason look(
    const struct compensator *self, struct remembered *memory, const struct parts *parts,
    double elapsed_s, double tool_length)
{
    struct reason first = {0, 0, 0.0, 0.0, 0.0};
    for (size_t place = 0; place < model_chosen_count; place++) {
        size_t index = model_chosen[place];
        double value = self->readings[place];
        struct reason fault
            = sensor_look(&model_sensors[index], &parts->checks[place], value, elapsed_s);
        self->bad[place] = fault.cause != 0;
        if (fault.cause != 0 && first.cause == 0) {
            first = fault;
            first.sensor = (int32_t)index + 1;
        } else if (fault.cause == 0 && isnan(parts->reference[place])) {
            parts->reference[place] = value;
        }
    }
    if (self->spare != NULL) {
        first = replaced(self, memory, parts, &first, elapsed_s);
    }
    if (first.cause == 0 && self->geometry.needs_tool_length) {
        return look_at_tool(tool_length);
    }
    return first;
}

/* Puts down the wanted offsets, the pose and the half widths for a good sample. */
static void predict(
    const struct compensator *self, struct remembered *memory, const struct parts *parts,
    const struct input *input)
{
    const struct gaussian *gaussian = &self->gaussian;
    const double *start = gaussian->fixed ? gaussian->usual : parts->reference;
    double drift[3], kept_back = 1.0 - model_limits.share, limit = model_limits.offset_um;
    struct sample sample = {
        model_takes_rises ? self->rises : self->readings, memory->unmodelled, input->speed,
        memory->has_measured ? parts->measured : NULL};
    for (size_t place = 0; place < model_chosen_count; place++) {
        self->rises[place] = self->readings[place] - start[place];
    }
    self->error_model->kind->predict(
        self->error_model, parts->error_model, &sample, parts->targets);
    gaussian_step(gaussian, parts->gaussian, self->rises, memory->unmodelled);
    struct gaussian_state at = gaussian_state(gaussian, parts->gaussian);
    for (size_t target = 0; target < model_target_count; target++) {
        parts->targets[target] += at.added[target];
    }
    geometry_drift(&self->geometry, parts->targets, input->tool_length, drift);
    geometry_pose(&self->geometry, parts->targets, memory->pose);
    for (size_t axis = 0; axis < 3; axis++) {
        double spread = self->spread[axis], variance = *at.variance * spread * spread;
        if (self->spare != NULL) {
            variance += spare_state(self->spare, parts->spare).extra[axis];
        }
        memory->wanted[axis] = clamped(0.0 - model_limits.share * drift[axis], -limit, limit);
        memory->half_width[axis] = PREDICTION_NOT_KNOWN;
        if (spread > 0.0) {
            memory->half_width[axis]
                = gaussian->deviations * sqrt(variance) + kept_back * fabs(drift[axis]);
        }
    }
    memory->unmodelled = 0.0;
    memory->has_measured = 0;
    memory->predicted = 1;
}

/* Conditions on what was measured with this sample; one that is not finite in all targets counts as
   none. An error model that corrects itself has it with the next sample. */
static void take(
    const struct compensator *self, struct remembered *memory, const struct parts *parts,
    const double *measured)
{
    double *values = model_corrects_itself ? parts->measured : self->missed;
    for (size_t target = 0; target < model_target_count; target++) {
        if (!isfinite(measured[target])) {
            return;
        }
    }
    for (size_t target = 0; target < model_target_count; target++) {
        values[target] = clamped(measured[target], -FIELDS_LARGEST, FIELDS_LARGEST);
        self->missed[target] = values[target] - parts->targets[target];
    }
    if (model_corrects_itself) {
        memory->has_measured = 1;
    } else {
        gaussian_take(&self->gaussian, parts->gaussian, self->missed);
    }
}

/* Counts how long the inputs have been bad or good again. */
static void follow(struct remembered *memory, const struct reason *fault, double elapsed_s)
{
    if (fault->cause != 0) {
        /* A new fault starts a new hold; one within the wait for recovery continues the old. */
        memory->fault_age = memory->fault.cause == 0 ? 0.0 : memory->fault_age + elapsed_s;
        memory->fault = *fault;
        memory->good_for = 0.0;
        memory->recovering = 0;
    } else if (memory->fault.cause != 0) {
        memory->fault_age += elapsed_s;
        memory->good_for += elapsed_s;
        if (memory->good_for >= model_limits.recover_s) {
            memory->fault.cause = 0;
            memory->recovering = 1;
        }
    }
}

/* The last guard, too: what is not a number moves nothing, and no offset leaves its limit. */
static double slewed(double offset, double wanted, double step_s)
{
    double reach = model_limits.slew_um_per_s * step_s, limit = model_limits.offset_um;
    if (fabs(wanted - offset) <= reach) {
        return clamped(wanted, -limit, limit);
    }
    if (wanted > offset) {
        return clamped(offset + reach, -limit, limit);
    }
    return wanted < offset ? clamped(offset - reach, -limit, limit) : offset;
}

/* Puts down a valid output of a file that goes on without a sensor, and names further ones. */
static void put_spared(
    const struct compensator *self, const struct remembered *memory, const struct parts *parts,
    struct output *output)
{
    const double *good_for = spare_state(self->spare, parts->spare).good_for;
    put(memory, true, COMPENSATOR_SPARED, &memory->spared, output);
    size_t named = 0;
    for (size_t place = 0; place < model_chosen_count && named < GAUSSIAN_NAMED; place++) {
        int32_t sensor = (int32_t)model_chosen[place] + 1;
        if (good_for[place] >= 0.0 && sensor != memory->spared.sensor) {
            output->also_without[named++] = sensor;
        }
    }
}

/* Returns the inputs that make most of the uncertainty that is due to new conditions. */
static struct reason blamed(const struct gaussian *gaussian, double *state)
{
    double novelty = *gaussian_state(gaussian, state).novelty;
    size_t places[GAUSSIAN_NAMED], count = gaussian_culprits(gaussian, state, places);
    struct reason reason = {0, (int32_t)model_chosen[places[0]] + 1, 0.0, 0.0, 0.0};
    reason.value = 100.0 * novelty / (novelty + gaussian_usual_variance(gaussian, state));
    reason.extent = count > 1 ? (double)model_chosen[places[1]] + 1.0 : 0.0;
    reason.allowed = count > 2 ? (double)model_chosen[places[2]] + 1.0 : 0.0;
    return reason;
}

/* Puts down a valid output, which says so where training did not see such conditions. */
static void put_valid(
    const struct compensator *self, const struct remembered *memory, const struct parts *parts,
    struct output *output)
{
    struct gaussian_state at = gaussian_state(&self->gaussian, parts->gaussian);
    if (memory->spared.cause != 0) {
        put_spared(self, memory, parts, output);
    } else if (*at.novelty > gaussian_usual_variance(&self->gaussian, parts->gaussian)) {
        struct reason reason = blamed(&self->gaussian, parts->gaussian);
        put(memory, true, COMPENSATOR_UNTRAINED, &reason, output);
    } else {
        put(memory, true, COMPENSATOR_OK, NULL, output);
    }
}

/* Moves the offsets for one step and says how they stand. */
static void move(
    const struct compensator *self, struct remembered *memory, const struct parts *parts,
    double step_s, struct output *output)
{
    static const double zero[3];
    const struct reason *fault = &memory->fault;
    if (fault->cause != 0 && memory->fault_age < model_limits.hold_s) {
        put(memory, false, COMPENSATOR_HOLDING + fault->cause, fault, output);
        return;
    }
    const double *wanted = fault->cause != 0 ? zero : memory->wanted;
    bool arrived = true, anywhere = false;
    for (size_t axis = 0; axis < 3; axis++) {
        memory->offset[axis] = slewed(memory->offset[axis], wanted[axis], step_s);
        arrived = arrived && memory->offset[axis] == wanted[axis];
        anywhere = anywhere || memory->offset[axis] != 0.0;
    }
    if (fault->cause != 0) {
        int32_t phase = anywhere ? COMPENSATOR_RAMPING : COMPENSATOR_AT_ZERO;
        put(memory, false, phase + fault->cause, fault, output);
    } else if (memory->recovering && !arrived) {
        put(memory, false, COMPENSATOR_RECOVERING, NULL, output);
    } else {
        memory->recovering = 0;
        put_valid(self, memory, parts, output);
    }
}

void compensator_step(
    const struct compensator *self, struct remembered *memory, double *numbers,
    const struct input *input, struct output *output)
{
    struct parts parts = compensator_parts(self, numbers);
    double step_s = isfinite(input->step_s) && input->step_s > 0.0 ? input->step_s : 0.0;
    step_s = step_s > FIELDS_LARGEST ? FIELDS_LARGEST : step_s;
    double elapsed_s = elapsed_since(memory, input->time_s, step_s);
    for (size_t place = 0; place < model_chosen_count; place++) {
        self->readings[place] = input->temperatures[model_chosen[place]];
    }
    set_tool(self, input->tool_length);
    struct reason fault = look(self, memory, &parts, elapsed_s, input->tool_length);
    memory->unmodelled += elapsed_s;
    if (fault.cause == 0) {
        predict(self, memory, &parts, input);
        memory->recovering = memory->recovering || !memory->started;
        memory->started = 1;
        /* What was measured while the inputs were bad has no prediction to be compared with. */
        if (input->measured != NULL) {
            take(self, memory, &parts, input->measured);
        }
    }
    if (!memory->started) {
        put(memory, false, COMPENSATOR_WAITING, fault.cause == 0 ? NULL : &fault, output);
        return;
    }
    follow(memory, &fault, elapsed_s);
    move(self, memory, &parts, step_s, output);
}
