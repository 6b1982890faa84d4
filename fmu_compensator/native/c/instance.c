#include "instance.h"

#include <stdlib.h>
#include <string.h>

#include "model_data.h"

static const char *const NOT_OF_THIS_KIND = "there is no such variable of this type";

struct instance *instance_new(void)
{
    struct instance *self = calloc(1, sizeof *self);
    if (self == NULL) {
        return NULL;
    }
    compensator_make(&self->setup, &self->compensator);
    if (self->setup.problem == NULL) {
        size_t numbers = self->compensator.numbers + model_variable_count;
        self->memory_size = sizeof *self->memory + numbers * sizeof(double);
        self->memory = setup_take(&self->setup, 1, self->memory_size);
    }
    if (self->memory != NULL) {
        self->values = self->memory->numbers + self->compensator.numbers;
        instance_reset(self);
    }
    return self;
}

void instance_free(struct instance *self)
{
    if (self != NULL) {
        setup_free(&self->setup);
        free(self);
    }
}

void instance_reset(struct instance *self)
{
    struct memory *memory = self->memory;
    memset(memory, 0, self->memory_size);
    compensator_reset(
        &self->compensator, &memory->remembered, memory->numbers, &memory->output);
    for (size_t ref = 0; ref < model_variable_count; ref++) {
        self->values[ref] = model_variables[ref].start;
    }
}

const char *instance_start(struct instance *self)
{
    if (self->memory->model_file[0] != '\0') {
        return "model_file: this FMU has its compensator file compiled in and reads no other; "
               "build another FMU from that file";
    }
    self->memory->running = 1;
    return NULL;
}

const char *instance_step(struct instance *self, double time_s, double step_s)
{
    struct memory *memory = self->memory;
    struct input input = {time_s, step_s, self->values, 0.0, 0.0, NULL};
    if (!(step_s > 0.0)) {
        return "the step must be above 0 s";
    }
    input.speed = self->values[model_ports.speed];
    input.tool_length = self->values[model_ports.tool_length];
    if (model_ports.measured != NONE && self->values[model_ports.measured] != 0.0) {
        input.measured = self->values + model_ports.measured_targets;
    }
    compensator_step(
        &self->compensator, &memory->remembered, memory->numbers, &input, &memory->output);
    memory->time_s = time_s + step_s;
    return NULL;
}

static const struct variable *variable_of(enum kind kind, size_t ref)
{
    if (ref >= model_variable_count || model_variables[ref].kind != kind) {
        return NULL;
    }
    return &model_variables[ref];
}

/* Returns where an output stands; its form is that of its declaration in struct output. */
static const void *output_of(const struct instance *self, const struct variable *variable)
{
    return (const char *)&self->memory->output + variable->offset;
}

const char *instance_get_real(struct instance *self, size_t ref, double *value)
{
    const struct variable *variable = variable_of(REAL, ref);
    if (variable == NULL) {
        return NOT_OF_THIS_KIND;
    }
    bool output = variable->causality == OUTPUT;
    *value = output ? *(const double *)output_of(self, variable) : self->values[ref];
    return NULL;
}

const char *instance_get_whole(struct instance *self, enum kind kind, size_t ref, int32_t *value)
{
    const struct variable *variable = variable_of(kind, ref);
    if (variable == NULL) {
        return NOT_OF_THIS_KIND;
    }
    bool output = variable->causality == OUTPUT;
    *value = output ? *(const int32_t *)output_of(self, variable) : (int32_t)self->values[ref];
    return NULL;
}

const char *instance_get_string(struct instance *self, size_t ref, const char **value)
{
    const struct variable *variable = variable_of(STRING, ref);
    if (variable == NULL) {
        return NOT_OF_THIS_KIND;
    }
    if (variable->causality == OUTPUT) {
        status_text(&self->memory->output, self->text, sizeof self->text);
        *value = self->text;
    } else {
        *value = self->memory->model_file;
    }
    return NULL;
}

/* Returns why a variable cannot be set now, NULL if it can. */
static const char *refusal(const struct instance *self, const struct variable *variable)
{
    if (variable == NULL) {
        return NOT_OF_THIS_KIND;
    }
    if (variable->causality == OUTPUT) {
        return "an output cannot be set";
    }
    if (variable->causality == PARAMETER && self->memory->running) {
        return "a parameter cannot be set after the start";
    }
    return NULL;
}

const char *instance_set_number(struct instance *self, enum kind kind, size_t ref, double value)
{
    const char *problem = refusal(self, variable_of(kind, ref));
    if (problem == NULL) {
        self->values[ref] = value;
    }
    return problem;
}

const char *instance_set_string(struct instance *self, size_t ref, const char *value)
{
    const char *problem = refusal(self, variable_of(STRING, ref));
    if (problem != NULL) {
        return problem;
    }
    if (value == NULL || strlen(value) >= FILE_LENGTH) {
        return "the text is too long";
    }
    memset(self->memory->model_file, 0, FILE_LENGTH);
    strcpy(self->memory->model_file, value);
    return NULL;
}
