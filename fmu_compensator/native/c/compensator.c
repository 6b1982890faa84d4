#include "compensator.h"

#include <math.h>
#include <string.h>

#include "geometry.h"
#include "numbers.h"

static const struct reason no_fault = {0, 0, 0.0, 0.0, 0.0};
static const struct sensor_memory unread
    = {.reference = NAN, .good = NAN, .jumped_after = NAN, .last = NAN};

static void attach(struct compensator *self, struct content *content)
{
    self->now = content;
    self->sensors = (struct sensor_memory *)content->numbers;
    self->learnt = (struct gaussian_state *)(self->sensors + model_chosen_count);
    self->spared = (struct spare_state *)((double *)self->learnt + gaussian_states());
    self->mean = (double *)self->spared + spare_states();
}

void compensator_make(struct setup *setup, struct compensator *self)
{
    size_t chosen = model_chosen_count;
    self->error_model = error_model_make(setup, &model_error_model, chosen, model_target_count);
    gaussian_make(setup, &self->gaussian);
    spare_make(setup, &self->spare);
    self->bad = setup_take(setup, chosen, sizeof(bool));
    self->rises = setup_take(setup, model_gaussian.inputs, sizeof(double));
    self->readings = setup_take(setup, chosen, sizeof(double));
    self->tool_length = NAN;
    if (setup->problem == NULL) {
        size_t states = gaussian_states() + spare_states() + self->error_model->states;
        self->size = sizeof(struct content) + chosen * sizeof(struct sensor_memory)
                     + states * sizeof(double);
    }
}

/* Sets validity and status of the output. */
static void put(struct compensator *self, bool valid, int32_t status, struct reason reason)
{
    struct output *output = &self->now->output;
    output->valid = valid;
    output->status = status;
    output->reason = reason;
    output->status_sensor = reason.sensor == SPEED_NUMBER ? 0 : reason.sensor;
    memset(output->others, 0, sizeof output->others);
}

void compensator_reset(struct compensator *self, struct content *content)
{
    attach(self, content);
    memset(content, 0, offsetof(struct content, model_file));
    content->last_time = NAN;
    for (size_t axis = 0; axis < 3; axis++) {
        content->output.half_width[axis] = PREDICTION_NOT_KNOWN;
    }
    for (size_t place = 0; place < model_chosen_count; place++) {
        self->sensors[place] = unread;
    }
    gaussian_reset(self->learnt);
    if (model_spare.precision != NULL) {
        spare_reset(self->spared);
    }
    error_model_reset(self->error_model, self->mean);
    put(self, false, COMPENSATOR_WAITING, no_fault);
}

/* Returns the time since the previous sample [s]; the step's length if that is unknown. */
static double elapsed_since(struct content *now, double time_s, double step_s)
{
    double last = now->last_time;
    now->last_time = isfinite(time_s) ? time_s : NAN;
    return time_s >= last && isfinite(time_s) ? fmin(time_s - last, FIELDS_LARGEST) : step_s;
}

double compensator_noise(const struct compensator *self, size_t axis, size_t column)
{
    size_t count = model_target_count;
    return dot(self->axes + axis * count, model_gaussian.noise + column * count, count);
}

/* Computes what depends on the tool length; the nearest allowed one is used if it is invalid. */
static void set_tool(struct compensator *self, double tool_length)
{
    double low = model_limits.tool_length_mm[0], high = model_limits.tool_length_mm[1];
    double nearest = tool_length > low ? clamped(tool_length, low, high) : low;
    if (nearest == self->tool_length) {
        return;
    }
    self->tool_length = nearest;
    geometry_weights(nearest, self->axes);
    for (size_t axis = 0; axis < 3; axis++) {
        double squares = 0.0;
        for (size_t column = 0; column < model_target_count; column++) {
            double along = compensator_noise(self, axis, column);
            squares += along * along;
        }
        self->spread[axis] = sqrt(squares);
    }
}

/* Replaces the readings of broken sensors; returns the fault if that is not possible. */
static struct reason replaced(struct compensator *self, struct reason fault, double elapsed_s)
{
    struct spare_sample sample = {
        self->readings, self->bad, fault.cause != 0, self->sensors, elapsed_s, self->axes};
    bool goes_on = spare_step(&self->spare, self->spared, &sample);
    if (fault.cause != 0) {
        self->now->spared = fault;
    }
    if (goes_on && self->spare.count == 0) {
        self->now->spared = no_fault;
    }
    return goes_on ? no_fault : fault;
}

/* Returns the first fault; every sensor is checked, so that none loses track of time. Readings of
   broken sensors are replaced by estimates if the file has a spare. */
static struct reason look(struct compensator *self, double elapsed_s, const struct input *input)
{
    struct reason first = no_fault;
    for (size_t place = 0; place < model_chosen_count; place++) {
        size_t index = model_chosen[place];
        struct sensor_memory *memory = &self->sensors[place];
        double value = self->readings[place];
        struct reason fault = sensor_look(&model_sensors[index], memory, value, elapsed_s);
        self->bad[place] = fault.cause != 0;
        if (fault.cause != 0 && first.cause == 0) {
            first = fault;
            first.sensor = (int32_t)index + 1;
        } else if (fault.cause == 0 && isnan(memory->reference)) {
            memory->reference = value;
        }
    }
    if (model_spare.precision != NULL) {
        first = replaced(self, first, elapsed_s);
    }
    if (first.cause == 0 && model_geometry.needs_tool_length) {
        const double *limits = model_limits.tool_length_mm;
        double length = input->tool_length;
        bool allowed = limits[0] <= length && length <= limits[1];
        first.value = length;
        first.cause = !isfinite(length) ? CHECKS_MISSING : allowed ? 0 : CHECKS_IMPLAUSIBLE;
    }
    /* Later the last known speed holds. */
    self->unheard = !gaussian_knows(input->speed);
    if (first.cause == 0 && self->unheard && !self->now->started) {
        first.cause = CHECKS_MISSING;
        first.sensor = SPEED_NUMBER;
    }
    return first;
}

double compensator_variance(const struct compensator *self, size_t axis)
{
    double variance = self->learnt->variance * self->spread[axis] * self->spread[axis];
    return variance + (model_spare.precision == NULL ? 0.0 : self->spared->extra[axis]);
}

void compensator_mean(struct compensator *self, const struct sample *sample, double *mean)
{
    self->error_model->kind->predict(self->error_model, self->mean, sample, mean);
    for (size_t target = 0; target < model_target_count; target++) {
        mean[target] *= model_gaussian.mean_share[target];
    }
}

/* Sets the wanted offsets, the pose and the half widths for a good sample. */
static void predict(struct compensator *self, const struct input *input)
{
    struct content *now = self->now;
    double drift[3], share = model_limits.share, limit = model_limits.offset_um;
    struct sample sample = {
        model_takes_rises ? self->rises : self->readings, now->unmodelled, input->speed,
        now->has_measured ? now->measured : NULL};
    for (size_t place = 0; place < model_chosen_count; place++) {
        const double *usual = model_gaussian.usual;
        double start = usual == NULL ? self->sensors[place].reference : usual[place];
        self->rises[place] = self->readings[place] - start;
    }
    compensator_mean(self, &sample, now->targets);
    gaussian_step(&self->gaussian, self->learnt, self->rises, now->unmodelled, input->speed);
    for (size_t target = 0; target < model_target_count; target++) {
        now->targets[target] += self->learnt->added[target];
    }
    geometry_drift(now->targets, input->tool_length, drift);
    geometry_pose(now->targets, now->output.pose);
    for (size_t axis = 0; axis < 3; axis++) {
        double deviation = model_gaussian.deviations * sqrt(compensator_variance(self, axis));
        double wanted = clamped(0.0 - share * drift[axis], -limit, limit);
        double half_width = deviation + fabs(drift[axis] + wanted);
        now->wanted[axis] = wanted;
        now->output.half_width[axis] = self->spread[axis] > 0.0 ? half_width : PREDICTION_NOT_KNOWN;
    }
    now->unmodelled = 0.0;
    now->has_measured = 0;
}

/* Conditions on the targets measured with this sample; if any is not finite, all are ignored. An
   error model that uses them itself gets them with the next sample. */
static void take(struct compensator *self, const double *measured)
{
    struct content *now = self->now;
    for (size_t target = 0; target < model_target_count; target++) {
        if (!isfinite(measured[target])) {
            return;
        }
    }
    for (size_t target = 0; target < model_target_count; target++) {
        double value = clamped(measured[target], -FIELDS_LARGEST, FIELDS_LARGEST);
        now->measured[target] = value;
        self->missed[target] = value - now->targets[target];
    }
    now->has_measured = model_uses_measured;
    if (!model_uses_measured) {
        gaussian_take(&self->gaussian, self->learnt, self->missed);
    }
}

/* Tracks how long the inputs have been bad, or good again. */
static void follow(struct content *now, struct reason fault, double elapsed_s)
{
    if (fault.cause != 0) {
        /* A new fault starts a new hold; one during recovery continues the old hold. */
        now->fault_age = now->fault.cause == 0 ? 0.0 : now->fault_age + elapsed_s;
        now->fault = fault;
        now->good_for = 0.0;
        now->recovering = 0;
    } else if (now->fault.cause != 0) {
        now->fault_age += elapsed_s;
        now->good_for += elapsed_s;
        if (now->good_for >= model_limits.recover_s) {
            now->fault.cause = 0;
            now->recovering = 1;
        }
    }
}

/* This is also the last guard: NaN moves nothing, and no offset leaves its limit. */
static double slewed(double offset, double wanted, double step_s)
{
    double reach = model_limits.slew_um_per_s * step_s, limit = model_limits.offset_um;
    if (fabs(wanted - offset) > reach) {
        wanted = wanted > offset ? offset + reach : offset - reach;
    }
    return isnan(wanted) ? offset : clamped(wanted, -limit, limit);
}

/* Returns the number of an input of the Gaussian, from 1. */
static int32_t number_of(size_t place)
{
    return place < model_chosen_count ? (int32_t)model_chosen[place] + 1 : SPEED_NUMBER;
}

/* Names further inputs from a list of places. */
static void name_others(struct output *output, const size_t *places, size_t count)
{
    size_t named = 0;
    for (size_t i = 0; i < count && named < GAUSSIAN_NAMED; i++) {
        int32_t sensor = number_of(places[i]);
        if (sensor != output->reason.sensor) {
            output->others[named++] = sensor;
        }
    }
}

/* Sets a valid output, which names the sensors that are replaced, or else those that contribute
   most to the uncertainty from new conditions. */
static void put_valid(struct compensator *self)
{
    const struct gaussian_state *learnt = self->learnt;
    double usual = gaussian_usual_variance(learnt);
    if (self->now->spared.cause != 0) {
        put(self, true, COMPENSATOR_SPARED, self->now->spared);
        name_others(&self->now->output, self->spare.broken, self->spare.count);
    } else if (self->unheard) {
        struct reason reason = {CHECKS_MISSING, SPEED_NUMBER, 0.0, 0.0, 0.0};
        put(self, true, COMPENSATOR_SPARED, reason);
    } else if (learnt->novelty > usual) {
        size_t places[GAUSSIAN_NAMED];
        size_t count = gaussian_culprits(&self->gaussian, learnt, places);
        double share = 100.0 * learnt->novelty / (learnt->novelty + usual);
        struct reason reason = {0, number_of(places[0]), share, 0.0, 0.0};
        put(self, true, COMPENSATOR_UNTRAINED, reason);
        name_others(&self->now->output, places, count);
    } else {
        put(self, true, COMPENSATOR_OK, no_fault);
    }
}

/* Moves the offsets for one step and sets the output. */
static void move(struct compensator *self, double step_s)
{
    struct content *now = self->now;
    bool arrived = true, anywhere = false;
    int32_t cause = now->fault.cause;
    if (cause != 0 && now->fault_age < model_limits.hold_s) {
        put(self, false, COMPENSATOR_HOLDING + cause, now->fault);
        return;
    }
    for (size_t axis = 0; axis < 3; axis++) {
        double wanted = cause != 0 ? 0.0 : now->wanted[axis], *offset = &now->output.offset[axis];
        *offset = slewed(*offset, wanted, step_s);
        arrived = arrived && *offset == wanted;
        anywhere = anywhere || *offset != 0.0;
    }
    if (cause != 0) {
        int32_t phase = anywhere ? COMPENSATOR_RAMPING : COMPENSATOR_AT_ZERO;
        put(self, false, phase + cause, now->fault);
    } else if (now->recovering && !arrived) {
        put(self, false, COMPENSATOR_RECOVERING, no_fault);
    } else {
        now->recovering = 0;
        put_valid(self);
    }
}

void compensator_step(
    struct compensator *self, struct content *content, const struct input *input)
{
    double step_s = isfinite(input->step_s) ? clamped(input->step_s, 0.0, FIELDS_LARGEST) : 0.0;
    double elapsed_s = elapsed_since(content, input->time_s, step_s);
    attach(self, content);
    for (size_t place = 0; place < model_chosen_count; place++) {
        self->readings[place] = input->temperatures[model_chosen[place]];
    }
    set_tool(self, input->tool_length);
    struct reason fault = look(self, elapsed_s, input);
    /* Lags and walk begin with the first complete sample, as in training. */
    if (content->started) {
        content->unmodelled += elapsed_s;
    }
    if (fault.cause == 0) {
        predict(self, input);
        content->recovering = content->recovering || !content->started;
        content->started = 1;
        /* A measurement taken while the inputs are bad has no prediction to compare with. */
        if (input->measured != NULL) {
            take(self, input->measured);
        }
    }
    if (!content->started) {
        put(self, false, COMPENSATOR_WAITING, fault);
        return;
    }
    follow(content, fault, elapsed_s);
    move(self, step_s);
}
