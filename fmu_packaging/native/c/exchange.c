/* Model exchange, in which the host integrates the states of a model, and derivatives. */
#include <math.h>
#include <string.h>

#include "instance.h"

/* Returns why a call cannot be made in this phase, NULL if it can. */
static const char *phase_refusal(const struct instance *self, int32_t first)
{
    if (self->memory->phase < first) {
        return first == INITIALISING ? "the initialisation has not begun"
                                     : "the initialisation has not ended";
    }
    return self->memory->phase == TERMINATED && first >= STEPPING
               ? "a call after the end of the simulation"
               : NULL;
}

/* The same for a call of model exchange. */
static const char *refusal(const struct instance *self, int32_t first)
{
    return self->exchange ? phase_refusal(self, first) : "this instance is for co-simulation";
}

/* The same for a row with one value per state. */
static const char *row_refusal(const struct instance *self, int32_t first, size_t count)
{
    const char *problem = refusal(self, first);
    return problem == NULL && count != model_continuous->count
               ? "there are not as many values as states"
               : problem;
}

static double *states_of(const struct instance *self)
{
    return (double *)(void *)((char *)self->content + model_continuous->offset);
}

const char *instance_enter(struct instance *self, enum phase mode)
{
    if (self->events && mode == STEPPING && self->memory->phase == STEPPING) {
        self->memory->phase = EVENTS;
        return NULL;
    }
    const char *problem = refusal(self, STEPPING);
    if (problem == NULL && self->memory->phase == (int32_t)mode) {
        return "the FMU is in this mode already";
    }
    if (problem == NULL) {
        self->memory->phase = mode;
    }
    return problem;
}

const char *instance_in_event(struct instance *self)
{
    if (self->events && self->memory->phase == EVENTS) {
        return NULL;
    }
    const char *problem = refusal(self, STEPPING);
    return problem == NULL && self->memory->phase != STEPPING ? "the FMU is not in event mode"
                                                              : problem;
}

const char *instance_set_time(struct instance *self, double time_s)
{
    const char *problem = refusal(self, STEPPING);
    if (problem == NULL && !isfinite(time_s)) {
        return "the time is not finite";
    }
    if (problem == NULL) {
        self->memory->time_s = time_s;
        self->memory->fresh = 0;
    }
    return problem;
}

const char *instance_get_states(struct instance *self, double *states, size_t count)
{
    const char *problem = row_refusal(self, INITIALISING, count);
    problem = problem == NULL ? instance_refresh(self) : problem;
    if (problem == NULL) {
        memcpy(states, states_of(self), count * sizeof *states);
    }
    return problem;
}

const char *instance_set_states(struct instance *self, const double *states, size_t count)
{
    const char *problem = row_refusal(self, STEPPING, count);
    if (problem == NULL && self->memory->phase != CONTINUOUS) {
        return "states are set in continuous-time mode";
    }
    if (problem == NULL) {
        memcpy(states_of(self), states, count * sizeof *states);
        self->memory->fresh = 0;
    }
    return problem;
}

const char *instance_compute_rates(struct instance *self)
{
    const char *problem = self->memory->phase < STEPPING ? instance_refresh(self) : NULL;
    return problem != NULL ? problem
                           : model_continuous->rates(
                               self->model, self->content, self->values, self->rates,
                               self->problem);
}

const char *instance_get_rates(struct instance *self, double *rates, size_t count)
{
    const char *problem = row_refusal(self, INITIALISING, count);
    problem = problem == NULL ? instance_compute_rates(self) : problem;
    if (problem == NULL) {
        memcpy(rates, self->rates, count * sizeof *rates);
    }
    return problem;
}

const char *instance_get_nominals(struct instance *self, double *nominals, size_t count)
{
    const char *problem = row_refusal(self, INITIALISING, count);
    if (problem == NULL) {
        memcpy(nominals, model_continuous->nominals, count * sizeof *nominals);
    }
    return problem;
}

const char *instance_complete(struct instance *self)
{
    const char *problem = refusal(self, STEPPING);
    if (problem == NULL) {
        problem = model_continuous->complete(
            self->model, self->content, self->values, self->memory->time_s, self->problem);
        self->memory->fresh = 0;
    }
    return problem;
}

const char *instance_begin_derivatives(struct instance *self)
{
    const char *problem = model_derivatives == NULL ? "this FMU gives no derivatives"
                                                    : phase_refusal(self, STEPPING);
    for (int i = 0; problem == NULL && i < 2; i++) {
        if (self->sides[i] == NULL) {
            self->sides[i] = setup_take(&self->setup, model_variable_count, sizeof(double));
        }
        if (self->sides[i] == NULL) {
            return "there is not enough memory for derivatives";
        }
        memset(self->sides[i], 0, model_variable_count * sizeof(double));
    }
    return problem;
}

static const char *find_place(enum side side, size_t ref, size_t *place)
{
    *place = ref < model_variable_count ? model_derivatives->place(side, ref) : NONE;
    return *place != NONE ? NULL
           : side == KNOWN ? "derivatives are by inputs, states and parameters"
                           : "derivatives are of outputs and derivatives of states";
}

const char *instance_seed(struct instance *self, enum side side, size_t ref, double seed)
{
    size_t place;
    const char *problem = find_place(side, ref, &place);
    if (problem == NULL) {
        self->sides[side][place] += seed;
    }
    return problem;
}

const char *instance_derive(struct instance *self, enum side from)
{
    double *const *sides = self->sides;
    return model_derivatives->derive(
        self->model, self->content, self->values, self->memory->time_s, from, sides[from],
        sides[1 - from], self->problem);
}

const char *instance_get_derivative(
    const struct instance *self, enum side side, size_t ref, double *found)
{
    size_t place;
    const char *problem = find_place(side, ref, &place);
    *found = problem == NULL ? self->sides[side][place] : NAN;
    return problem;
}
