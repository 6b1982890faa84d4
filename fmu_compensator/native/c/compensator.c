#include "compensator.h"

#include <math.h>
#include <string.h>

#include "constants.h"
#include "interval.h"
#include "numbers.h"

/* The parts of the row of numbers. */
struct parts {
    double *reference;
    struct sensor_memory *checks;
    double *measured, *predicted, *guard, *correction, *spare, *error_model;
};

static struct parts parts_of(const struct compensator *self, double *numbers)
{
    struct parts parts;
    parts.reference = numbers;
    parts.checks = (struct sensor_memory *)(parts.reference + model_chosen_count);
    parts.measured = (double *)(parts.checks + model_chosen_count);
    parts.predicted = parts.measured + model_target_count;
    parts.guard = parts.predicted + model_target_count;
    parts.correction = parts.guard + (self->guard == NULL ? 0 : self->guard->states);
    parts.spare = parts.correction + (self->correction == NULL ? 0 : self->correction->states);
    parts.error_model = parts.spare + (self->spare == NULL ? 0 : self->spare->states);
    return parts;
}

void compensator_make(struct setup *setup, struct compensator *self)
{
    geometry_make(setup, &model_geometry, &self->geometry);
    self->error_model
        = error_model_make(setup, &model_error_model, model_chosen_count, model_target_count);
    self->guard = guard_make(setup, &model_guard, model_chosen_count, model_target_count);
    self->correction = correction_make(setup, &model_correction, model_target_count);
    self->spare = spare_make(setup, &model_spare, model_chosen_count);
    self->bad = setup_take(setup, model_chosen_count, sizeof(bool));
    self->unread = setup_take(setup, model_chosen_count, sizeof(bool));
    self->first = setup_take(setup, model_chosen_count, sizeof(double));
    self->sorted = setup_take(setup, 2 * model_chosen_count, sizeof(double));
    self->inputs = setup_take(setup, model_chosen_count, sizeof(double));
    self->readings = setup_take(setup, model_chosen_count, sizeof(double));
    self->targets = setup_take(setup, model_target_count, sizeof(double));
    self->careful = setup_take(setup, model_target_count, sizeof(double));
    if (self->error_model == NULL) {
        setup_fail(setup, "the compiled-in file cannot be used", "error_model");
        return;
    }
    self->numbers = model_chosen_count + 2 * model_target_count + self->error_model->states
                    + model_chosen_count * (sizeof(struct sensor_memory) / sizeof(double));
    self->numbers += self->guard == NULL ? 0 : self->guard->states;
    self->numbers += self->correction == NULL ? 0 : self->correction->states;
    self->numbers += self->spare == NULL ? 0 : self->spare->states;
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
    output->also_without = 0;
}

void compensator_reset(
    const struct compensator *self, struct remembered *memory, double *numbers,
    struct output *output)
{
    static const struct remembered nothing;
    struct parts parts = parts_of(self, numbers);
    *memory = nothing;
    memory->last_time = NAN;
    memory->growth = 1.0;
    for (size_t axis = 0; axis < 3; axis++) {
        memory->half_width[axis] = INTERVAL_NOT_KNOWN;
    }
    for (size_t place = 0; place < model_chosen_count; place++) {
        parts.reference[place] = NAN;
        sensor_reset(&parts.checks[place]);
    }
    for (size_t target = 0; target < model_target_count; target++) {
        parts.measured[target] = parts.predicted[target] = 0.0;
    }
    for (size_t i = 0; self->guard != NULL && i < self->guard->states; i++) {
        parts.guard[i] = 0.0;
    }
    if (self->correction != NULL) {
        correction_reset(self->correction, parts.correction);
    }
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
    return elapsed_s > COMPENSATOR_LONGEST_S ? COMPENSATOR_LONGEST_S : elapsed_s;
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

/* Returns where a tool is from the shortest (0) to the longest (1); NaN counts as 0. */
static double tool_share(double length)
{
    double low = model_limits.tool_length_mm[0], high = model_limits.tool_length_mm[1];
    double share = low < high ? (length - low) / (high - low) : 0.0;
    if (!(share > 0.0)) {
        return 0.0;
    }
    return share > 1.0 ? 1.0 : share;
}

/* Returns from where rises may count without the bad sensors; not known where a level matters. */
static struct starts starts_of(const struct compensator *self, const struct parts *parts)
{
    struct starts starts = {false, self->first, self->unread};
    double *good = self->sorted + model_chosen_count;
    size_t count = 0;
    for (size_t place = 0; place < model_chosen_count; place++) {
        if (!self->bad[place]) {
            good[count++] = self->readings[place];
        }
    }
    if (!model_takes_rises || self->guard == NULL || count == 0) {
        return starts;
    }
    double middle = median(good, count, self->sorted);
    starts.known = true;
    for (size_t place = 0; place < model_chosen_count; place++) {
        self->unread[place] = isnan(parts->reference[place]);
        self->first[place] = parts->reference[place];
        if (self->unread[place]) {
            self->first[place] = guard_usual_start(self->guard, place, middle);
        }
        starts.known = starts.known && !isnan(self->first[place]);
    }
    return starts;
}

/* Replaces what broken sensors read; returns the fault that is left. */
static struct reason replaced(
    const struct compensator *self, struct remembered *memory, const struct parts *parts,
    const struct reason *fault, double elapsed_s, double tool_length)
{
    static const struct reason no_fault = {0, 0, 0.0, 0.0, 0.0};
    struct starts starts = {false, self->first, self->unread};
    size_t turn = spare_turn(parts->spare);
    double idle = sensor_idle(&model_sensors[model_chosen[turn]], &parts->checks[turn]);
    if (!memory->started && fault->cause != 0) {
        starts = starts_of(self, parts);
    }
    bool can_go_on = spare_step(
        self->spare, parts->spare, self->readings, self->bad, idle, elapsed_s,
        model_limits.recover_s, tool_share(tool_length), &starts);
    if (fault->cause != 0) {
        memory->spared = *fault;
    }
    if (!can_go_on) {
        return *fault;
    }
    if (starts.known) {
        memcpy(parts->reference, self->first, model_chosen_count * sizeof(double));
    }
    if (spare_broken(self->spare, parts->spare).count == 0) {
        memory->spared = no_fault;
    }
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
        first = replaced(self, memory, parts, &first, elapsed_s, tool_length);
    }
    if (first.cause == 0 && self->geometry.needs_tool_length) {
        return look_at_tool(tool_length);
    }
    return first;
}

/* Takes in what was measured with the sample before; returns the doubt that is left [1]. */
static double corrected(
    const struct compensator *self, const struct remembered *memory, const struct parts *parts)
{
    if (self->correction == NULL) {
        return 1.0;
    }
    if (memory->has_measured && memory->has_predicted) {
        correction_take(
            self->correction, parts->correction, parts->measured, parts->predicted,
            memory->growth);
    }
    correction_wait(self->correction, parts->correction, memory->unmodelled);
    return correction_doubt(self->correction, parts->correction);
}

static void add_bias(double *targets, const double *bias)
{
    for (size_t target = 0; target < model_target_count; target++) {
        targets[target] += bias[target];
    }
}

/* Keeps the prediction near the careful one, both with what measurements corrected. Returns what
   the correction follows: of an error model that corrects itself it is the careful model. */
static const double *corrected_targets(const struct compensator *self, const double *bias)
{
    bool own = self->correction == NULL || model_corrects_itself;
    if (self->guard != NULL) {
        if (self->correction != NULL && own) {
            add_bias(self->careful, bias);
        }
        guard_hold(self->guard, self->targets, self->careful);
    }
    if (!own) {
        add_bias(self->targets, bias);
    }
    return self->guard != NULL && own ? self->careful : self->targets;
}

/* Puts down the targets and the novelty of a good sample; returns the doubt that is left [1]. */
static double predict_targets(
    const struct compensator *self, struct remembered *memory, const struct parts *parts,
    double speed)
{
    struct sample sample = {self->inputs, memory->unmodelled, speed, NULL};
    /* An error model that only adds a bias leaves that to the correction. */
    if (memory->has_measured && (self->correction == NULL || model_corrects_itself)) {
        sample.measured = parts->measured;
    }
    self->error_model->kind->predict(
        self->error_model, parts->error_model, &sample, self->targets);
    double doubt = corrected(self, memory, parts);
    if (self->guard != NULL) {
        memory->novelty = guard_step(
            self->guard, parts->guard, self->readings, memory->unmodelled, self->careful);
    }
    const double *followed = corrected_targets(self, parts->correction);
    if (self->correction != NULL) {
        memcpy(parts->predicted, followed, model_target_count * sizeof(double));
        memory->has_predicted = 1;
    }
    memory->unmodelled = 0.0;
    memory->has_measured = 0;
    return doubt;
}

/* Turns drift into offsets in proportion to what is known, and puts down how much was given up
   [um]. What is not known falls back to what was measured last; to zero if nothing was. */
static void fade(
    const struct compensator *self, const struct remembered *memory, const struct parts *parts,
    double tool_length, double doubt, double drift[3], double given_up[3])
{
    double last[3] = {0.0, 0.0, 0.0}, share = tool_share(tool_length);
    bool fresh = self->guard != NULL && memory->novelty > self->guard->known;
    if ((fresh || self->spare != NULL) && self->correction != NULL) {
        const double *held = correction_held(self->correction, parts->correction);
        geometry_drift(&self->geometry, held, tool_length, last);
    }
    for (size_t axis = 0; axis < 3; axis++) {
        double offset = 0.0 - drift[axis], part = 1.0;
        if (fresh) {
            part = guard_faded(self->guard, axis, memory->novelty, share, doubt);
        }
        if (self->spare != NULL) {
            part *= spare_faded(self->spare, parts->spare, axis, share, doubt);
        }
        double moved = (1.0 - part) * (offset - (0.0 - last[axis]));
        drift[axis] = offset - moved;
        given_up[axis] = fabs(moved);
    }
}

/* Puts down the wanted offsets and the pose for a good sample. */
static void predict(
    const struct compensator *self, struct remembered *memory, const struct parts *parts,
    const struct input *input)
{
    double drift[3], given_up[3], share = tool_share(input->tool_length);
    double doubt = predict_targets(self, memory, parts, input->speed);
    geometry_drift(&self->geometry, self->targets, input->tool_length, drift);
    fade(self, memory, parts, input->tool_length, doubt, drift, given_up);
    for (size_t axis = 0; axis < 3; axis++) {
        memory->wanted[axis]
            = clamped(drift[axis], -model_limits.offset_um, model_limits.offset_um);
    }
    geometry_pose(&self->geometry, self->targets, memory->pose);
    if (model_interval != NULL) {
        memory->growth
            = interval_growth(model_interval, memory->since_start, memory->novelty);
        half_width(model_interval, memory->growth * sqrt(doubt), share, memory->half_width);
        if (self->spare != NULL) {
            spare_widen(self->spare, parts->spare, memory->half_width, doubt);
        }
        for (size_t axis = 0; axis < 3; axis++) {
            if (memory->half_width[axis] != INTERVAL_NOT_KNOWN) {
                memory->half_width[axis] += given_up[axis];
            }
        }
    }
    if (!memory->started) {
        memory->started = memory->recovering = 1;
    }
}

/* Keeps a measurement for the next sample; one that is not finite in all targets counts as none. */
static void keep_measured(
    struct remembered *memory, const struct parts *parts, const double *measured)
{
    for (size_t target = 0; target < model_target_count; target++) {
        if (!isfinite(measured[target])) {
            return;
        }
    }
    for (size_t target = 0; target < model_target_count; target++) {
        parts->measured[target]
            = clamped(measured[target], -PREDICTION_LARGEST, PREDICTION_LARGEST);
    }
    memory->has_measured = 1;
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

/* Returns the inputs that lie outside what training saw only when taken together. */
static struct reason together(const struct guard *guard, double novelty)
{
    struct reason reason = {COMPENSATOR_JOINT, 0, PREDICTION_LARGEST, 0.0, 0.0};
    size_t places[GUARD_CULPRITS];
    size_t count = guard_culprits(guard, novelty, places);
    if (guard->known > 0.0) {
        reason.value = clamped(novelty / guard->known, 0.0, PREDICTION_LARGEST);
    }
    reason.sensor = (int32_t)model_chosen[places[0]] + 1;
    reason.extent = count > 1 ? (double)model_chosen[places[1]] + 1.0 : 0.0;
    reason.allowed = count > 2 ? (double)model_chosen[places[2]] + 1.0 : 0.0;
    return reason;
}

/* Puts down a valid output of a file that goes on without a sensor, and names a second one. */
static void put_spared(
    const struct compensator *self, const struct remembered *memory, const struct parts *parts,
    struct output *output)
{
    struct broken broken = spare_broken(self->spare, parts->spare);
    put(memory, true, COMPENSATOR_SPARED, &memory->spared, output);
    for (size_t i = 0; i < broken.count && output->also_without == 0; i++) {
        int32_t sensor = (int32_t)model_chosen[broken.places[i]] + 1;
        if (sensor != memory->spared.sensor) {
            output->also_without = sensor;
        }
    }
}

/* Puts down a valid output, which says so if an input lies outside what training saw. */
static void put_trained(
    const struct compensator *self, const struct remembered *memory, const struct parts *parts,
    struct output *output)
{
    if (memory->spared.cause != 0) {
        put_spared(self, memory, parts, output);
        return;
    }
    for (size_t place = 0; place < model_chosen_count; place++) {
        const struct sensor *sensor = &model_sensors[model_chosen[place]];
        double value = self->inputs[place];
        if (!(sensor->trained_low <= value && value <= sensor->trained_high)) {
            struct reason reason = {0, (int32_t)model_chosen[place] + 1, value, 0.0, 0.0};
            put(memory, true, COMPENSATOR_UNTRAINED, &reason, output);
            return;
        }
    }
    if (self->guard != NULL && memory->novelty > self->guard->known) {
        struct reason reason = together(self->guard, memory->novelty);
        put(memory, true, COMPENSATOR_UNTRAINED, &reason, output);
        return;
    }
    put(memory, true, COMPENSATOR_OK, NULL, output);
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
        put_trained(self, memory, parts, output);
    }
}

void compensator_step(
    const struct compensator *self, struct remembered *memory, double *numbers,
    const struct input *input, struct output *output)
{
    struct parts parts = parts_of(self, numbers);
    double step_s = isfinite(input->step_s) && input->step_s > 0.0 ? input->step_s : 0.0;
    step_s = step_s > COMPENSATOR_LONGEST_S ? COMPENSATOR_LONGEST_S : step_s;
    double elapsed_s = elapsed_since(memory, input->time_s, step_s);
    for (size_t place = 0; place < model_chosen_count; place++) {
        self->readings[place] = input->temperatures[model_chosen[place]];
    }
    struct reason fault = look(self, memory, &parts, elapsed_s, input->tool_length);
    memory->unmodelled += elapsed_s;
    if (memory->started) {
        memory->since_start
            = clamped(memory->since_start + elapsed_s, 0.0, COMPENSATOR_LONGEST_S);
    }
    for (size_t place = 0; place < model_chosen_count; place++) {
        double value = self->readings[place];
        self->inputs[place] = model_takes_rises ? value - parts.reference[place] : value;
    }
    if (fault.cause == 0) {
        predict(self, memory, &parts, input);
    }
    /* What was measured while the inputs were bad has no prediction to be compared with. */
    if (input->measured != NULL && fault.cause == 0) {
        keep_measured(memory, &parts, input->measured);
    }
    if (!memory->started) {
        put(memory, false, COMPENSATOR_WAITING, fault.cause == 0 ? NULL : &fault, output);
        return;
    }
    follow(memory, &fault, elapsed_s);
    move(self, memory, &parts, step_s, output);
}
