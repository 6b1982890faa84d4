/* Hybrid: a weighted sum of other error models' predictions.

   State: started, the speed at the previous sample [rpm], the time since it changed [s]; the
   predictions, model by model; the current weights and, if measurements change them, the recent
   squared errors, target by target; then the states of the models. */
#include <math.h>

#include "../constants.h"
#include "../error_model.h"
#include "../numbers.h"

struct vac {
    struct error_model base;
    size_t targets, models;
    struct error_model **model;
    const double *stopped, *changing, *steady;
    const double *prior; /* NULL: measurements do not change the weights */
    double settle_s, blend_s, memory_s;
    double *moved; /* weights of one target */
};

/* The parts of the state. */
struct memory {
    double *speed, *since, *parts, *blended, *errors, *models;
};

static struct memory memory_of(const struct vac *self, double *state)
{
    struct memory memory;
    size_t size = self->models * self->targets;
    memory.speed = state + 1;
    memory.since = state + 2;
    memory.parts = state + 3;
    memory.blended = memory.parts + size;
    memory.errors = memory.blended + size;
    memory.models = memory.errors + (self->prior == NULL ? 0 : size);
    return memory;
}

static struct error_model *make(
    struct setup *setup, const struct field *table, size_t inputs, size_t targets)
{
    struct vac *self = setup_take(setup, 1, sizeof *self);
    if (self == NULL) {
        return NULL;
    }
    const struct field *tables = field_list(setup, table, "models", &self->models);
    const struct field *weights = field_table(setup, table, "weights");
    self->targets = targets;
    self->stopped = field_matrix(setup, weights, "stopped", NULL);
    self->changing = field_matrix(setup, weights, "changing", NULL);
    self->steady = field_matrix(setup, weights, "steady", NULL);
    self->prior = field_matrix(setup, table, "prior", NULL);
    self->settle_s = field_number(setup, table, "settle_s");
    self->blend_s = field_number(setup, table, "blend_s");
    self->memory_s = field_number(setup, table, "memory_s");
    self->moved = setup_take(setup, self->models, sizeof(double));
    self->model = setup_take(setup, self->models, sizeof *self->model);
    if (self->model == NULL) {
        return NULL;
    }
    self->base.states = 3 + self->models * targets * (self->prior == NULL ? 2 : 3);
    for (size_t i = 0; i < self->models; i++) {
        self->model[i] = error_model_make(setup, &tables[i], inputs, targets);
        if (self->model[i] == NULL) {
            return NULL;
        }
        self->base.states += self->model[i]->states;
    }
    return &self->base;
}

static void reset(const struct error_model *model, double *state)
{
    const struct vac *self = (const struct vac *)model;
    struct memory memory = memory_of(self, state);
    for (size_t i = 0; self->prior != NULL && i < self->models * self->targets; i++) {
        memory.errors[i] = self->prior[i];
    }
    for (size_t i = 0; i < self->models; i++) {
        error_model_reset(self->model[i], memory.models);
        memory.models += self->model[i]->states;
    }
}

/* Updates every model's recent error with its error at the previous sample. */
static void learn(const struct vac *self, struct memory *memory, const struct sample *sample)
{
    double part = lag_share(sample->elapsed_s, self->memory_s);
    for (size_t target = 0; target < self->targets; target++) {
        for (size_t i = 0; i < self->models; i++) {
            double *error = &memory->errors[target * self->models + i];
            double missed = sample->measured[target] - memory->parts[i * self->targets + target];
            missed = fabs(missed) > 1e6 ? 1e6 : fabs(missed);
            *error += part * (missed * missed - *error);
        }
    }
}

/* Moves the weights towards those of the condition. */
static void follow(const struct vac *self, double *started, struct memory *memory,
                   const struct sample *sample)
{
    double now = known_speed(sample->speed, *memory->speed);
    double larger = now < *memory->speed ? *memory->speed : now;
    *memory->since += sample->elapsed_s;
    if (fabs(now - *memory->speed) > LAGS_SAME_SPEED_SHARE * larger) {
        *memory->since = 0.0;
    }
    *memory->speed = now;
    *memory->since = *memory->since > 1e9 ? 1e9 : *memory->since;
    const double *wanted = self->steady;
    if (now < LAGS_STILL_RPM) {
        wanted = self->stopped;
    } else if (*memory->since < self->settle_s) {
        wanted = self->changing;
    }
    double part = *started != 0.0 ? lag_share(sample->elapsed_s, self->blend_s) : 1.0;
    *started = 1.0;
    for (size_t i = 0; i < self->targets * self->models; i++) {
        memory->blended[i] += part * (wanted[i] - memory->blended[i]);
    }
}

/* Returns the weights of a target: models that recently did better than in training gain weight. */
static const double *in_force(const struct vac *self, const struct memory *memory, size_t target)
{
    const double *blended = memory->blended + target * self->models;
    double total = 0.0, wanted = 0.0;
    if (self->prior == NULL) {
        return blended;
    }
    for (size_t i = 0; i < self->models; i++) {
        double prior = self->prior[target * self->models + i];
        double error = memory->errors[target * self->models + i];
        error = 1e-3 * prior > error ? 1e-3 * prior : error;
        self->moved[i] = blended[i] * prior / error;
        total += self->moved[i];
        wanted += blended[i];
    }
    if (!(total > 0.0)) {
        return blended;
    }
    for (size_t i = 0; i < self->models; i++) {
        self->moved[i] = self->moved[i] * wanted / total;
    }
    return self->moved;
}

static void predict(
    const struct error_model *model, double *state, const struct sample *sample, double *targets)
{
    const struct vac *self = (const struct vac *)model;
    struct memory memory = memory_of(self, state);
    double *own = memory.models;
    if (sample->measured != NULL && self->prior != NULL) {
        learn(self, &memory, sample);
    }
    for (size_t i = 0; i < self->models; i++) {
        const struct error_model *one = self->model[i];
        one->kind->predict(one, own, sample, memory.parts + i * self->targets);
        own += one->states;
    }
    follow(self, state, &memory, sample);
    for (size_t target = 0; target < self->targets; target++) {
        const double *weights = in_force(self, &memory, target);
        double total = 0.0;
        for (size_t i = 0; i < self->models; i++) {
            total += weights[i] * memory.parts[i * self->targets + target];
        }
        targets[target] = total;
    }
}

const struct error_model_kind vac_kind = {"vac", make, reset, predict};
