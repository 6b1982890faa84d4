#include "instance.h"

#include <math.h>
#include <string.h>

#include "memory.h"

const char *const category_names[] = {"logStatusDiscard", "logStatusError"};

static const char *const NOT_OF_THIS_KIND = "there is no such variable of this type";

/* Larger than the relative rounding error of a sum of steps. */
#define ROUNDING 1e-9

struct instance *instance_new(void)
{
    struct instance *self = memory_take(1, sizeof *self);
    size_t content = 0;
    if (self == NULL) {
        return NULL;
    }
    self->model = model_make(&self->setup, &content);
    if (self->setup.problem == NULL) {
        content = (content + sizeof(double) - 1) / sizeof(double) * sizeof(double);
        self->memory_size =
            sizeof *self->memory + model_variable_count * sizeof(double) + content;
        self->memory_size += model_bus == NULL ? 0 : model_bus->size;
        self->memory = setup_take(&self->setup, 1, self->memory_size);
    }
    if (self->memory != NULL && model_continuous != NULL) {
        self->rates = setup_take(&self->setup, model_continuous->count, sizeof(double));
    }
    if (self->memory != NULL) {
        self->values = self->memory->numbers;
        self->content = self->values + model_variable_count;
        if (model_bus != NULL) {
            self->terminal = (void *)((char *)self->content + content);
        }
        instance_reset(self);
    }
    return self;
}

void instance_free(struct instance *self)
{
    if (self != NULL) {
        setup_free(&self->setup);
        memory_give(self);
    }
}

void instance_reset(struct instance *self)
{
    memset(self->memory, 0, self->memory_size);
    self->memory->stop_s = INFINITY;
    model_reset(self->model, self->content);
    for (size_t ref = 0; ref < model_variable_count; ref++) {
        self->values[ref] = model_variables[ref].start;
    }
    if (model_bus != NULL) {
        model_bus->reset(self->terminal);
    }
}

const char *instance_experiment(struct instance *self, double start_s, bool has_stop, double stop_s)
{
    if (self->memory->phase != INSTANTIATED) {
        return "the experiment must be set up before the initialisation";
    }
    if (!isfinite(start_s) || (has_stop && !(stop_s >= start_s))) {
        return "the experiment must begin at a finite time and not stop before it begins";
    }
    self->memory->time_s = start_s;
    self->memory->fresh = 0;
    self->memory->stop_s = has_stop ? stop_s : INFINITY;
    return NULL;
}

const char *instance_initialise(struct instance *self)
{
    if (self->memory->phase != INSTANTIATED) {
        return "the initialisation has begun already: reset first";
    }
    self->memory->phase = INITIALISING;
    return NULL;
}

const char *instance_refresh(struct instance *self)
{
    struct memory *memory = self->memory;
    bool before = memory->phase < STEPPING;
    if (memory->fresh || !(before || self->exchange)) {
        return NULL;
    }
    const char *problem =
        (before ? model_start : model_continuous->show)(
            self->model, self->content, self->values, memory->time_s, self->problem);
    memory->fresh = problem == NULL;
    return problem;
}

const char *instance_start(struct instance *self)
{
    if (self->memory->phase != INITIALISING) {
        return "the initialisation has not begun, or has ended";
    }
    const char *problem = instance_refresh(self);
    if (problem == NULL) {
        self->memory->phase = self->events ? EVENTS : STEPPING;
    }
    if (problem == NULL && model_bus != NULL) {
        model_bus->start(self);
    }
    return problem;
}

const char *instance_terminate(struct instance *self)
{
    if (self->memory->phase < STEPPING || self->memory->phase == TERMINATED) {
        return "there is no simulation to be terminated";
    }
    self->memory->phase = TERMINATED;
    return NULL;
}

const char *instance_may_step(const struct instance *self, double time_s, double step_s)
{
    const struct memory *memory = self->memory;
    double slack = clock_slack(memory->time_s, step_s);
    if (self->exchange) {
        return "this instance is for model exchange";
    }
    if (memory->phase == TERMINATED) {
        return "a step after the end of the simulation";
    }
    if (memory->phase < STEPPING) {
        return "a step before the end of the initialisation";
    }
    if (memory->phase == EVENTS) {
        return "the FMU is in event mode";
    }
    if (!isfinite(time_s)) {
        return "the step does not begin at a finite time";
    }
    if (!model_clock_may_jump && !(fabs(time_s - memory->time_s) <= slack)) {
        return "the step does not begin at the time that has been reached";
    }
    if (time_s + step_s > memory->stop_s + slack) {
        return "the step goes beyond the stop time of the experiment";
    }
    return NULL;
}

bool instance_is_due(const struct instance *self, double time_s)
{
    return time_s - self->memory->time_s <= ROUNDING * (fabs(self->memory->time_s) + 1.0);
}

const char *instance_step(struct instance *self, double time_s, double step_s)
{
    if (!(step_s > 0.0 && isfinite(time_s + step_s))) {
        return "the step must be above 0 s and finite";
    }
    /* Data from a bus steps the model. */
    const char *problem =
        model_bus != NULL
            ? NULL
            : model_step(self->model, self->content, self->values, time_s, step_s, self->problem);
    if (problem == NULL) {
        self->memory->time_s = time_s + step_s;
    }
    return problem;
}

static const struct variable *variable_of(enum kind kind, size_t ref)
{
    if (ref >= model_variable_count || model_variables[ref].kind != kind) {
        return NULL;
    }
    return &model_variables[ref];
}

/* Returns the address of an output, whose type is that of its declaration in the content. */
static const char *find_output(
    struct instance *self, const struct variable *variable, const void **place)
{
    *place = (const char *)self->content + variable->offset;
    return instance_refresh(self);
}

const char *instance_get_real(struct instance *self, enum kind kind, size_t ref, double *value)
{
    const struct variable *variable = variable_of(kind, ref);
    const void *place = NULL;
    if (variable == NULL) {
        return NOT_OF_THIS_KIND;
    }
    if (variable->causality == DERIVATIVE) {
        const char *problem = instance_compute_rates(self);
        *value = problem == NULL ? self->rates[variable->offset] : NAN;
        return problem;
    }
    if (variable->causality != OUTPUT) {
        *value = self->values[ref];
        return NULL;
    }
    const char *problem = find_output(self, variable, &place);
    *value = problem == NULL ? *(const double *)place : NAN;
    return problem;
}

const char *instance_get_whole(struct instance *self, enum kind kind, size_t ref, int32_t *value)
{
    const struct variable *variable = variable_of(kind, ref);
    const void *place = NULL;
    if (variable == NULL) {
        return NOT_OF_THIS_KIND;
    }
    if (variable->causality != OUTPUT) {
        *value = (int32_t)self->values[ref];
        return NULL;
    }
    const char *problem = find_output(self, variable, &place);
    *value = problem == NULL ? *(const int32_t *)place : 0;
    return problem;
}

const char *instance_get_string(
    struct instance *self, enum kind kind, size_t ref, const char **value)
{
    const struct variable *variable = variable_of(kind, ref);
    size_t size = 0;
    if (variable == NULL) {
        return NOT_OF_THIS_KIND;
    }
    if (variable->causality == OUTPUT) {
        model_text(self->content, self->text);
        *value = self->text;
    } else {
        *value = model_text_parameter(self->content, &size);
    }
    return NULL;
}

/* Returns why a variable cannot be set now, NULL if it can. */
static const char *refusal(const struct instance *self, const struct variable *variable)
{
    if (variable == NULL) {
        return NOT_OF_THIS_KIND;
    }
    if (variable->causality == OUTPUT || variable->causality == DERIVATIVE
        || variable->causality == SENT) {
        return "what the FMU computes cannot be set";
    }
    if (variable->causality == INPUT && model_bus != NULL) {
        return "this comes from the bus and cannot be set";
    }
    if (variable->causality == RECEIVED && self->memory->phase == STEPPING) {
        return "this is set in event mode, when its clock ticks";
    }
    if (self->memory->phase == TERMINATED) {
        return "nothing can be set after the end of the simulation";
    }
    if (variable->causality != INPUT && self->exchange && self->memory->phase == CONTINUOUS) {
        return "a parameter cannot be set in continuous-time mode";
    }
    if (variable->causality == PARAMETER && self->memory->phase >= STEPPING) {
        return "a parameter cannot be set after the start";
    }
    return NULL;
}

const char *instance_set_number(
    struct instance *self, enum kind kind, size_t ref, double value, bool really)
{
    const char *problem = refusal(self, variable_of(kind, ref));
    if (problem == NULL && really) {
        self->values[ref] = value;
        self->memory->fresh = 0;
    }
    return problem;
}

const char *instance_set_string(
    struct instance *self, enum kind kind, size_t ref, const char *value, bool really)
{
    const char *problem = refusal(self, variable_of(kind, ref));
    size_t size = 0;
    char *kept = model_text_parameter(self->content, &size);
    if (problem != NULL) {
        return problem;
    }
    if (value == NULL || strlen(value) >= size) {
        return "the text is too long";
    }
    if (really) {
        memset(kept, 0, size);
        strcpy(kept, value);
        self->memory->fresh = 0;
    }
    return NULL;
}

bool instance_log(unsigned *logged, bool on, size_t count, const char *const categories[])
{
    unsigned chosen = count == 0 ? ~0u : 0u;
    for (size_t i = 0; i < count; i++) {
        size_t place = 0;
        while (place < CATEGORIES
               && (categories == NULL || categories[i] == NULL
                   || strcmp(categories[i], category_names[place]) != 0)) {
            place++;
        }
        if (place == CATEGORIES) {
            return false;
        }
        chosen |= 1u << place;
    }
    *logged = on ? chosen : 0u;
    return true;
}
