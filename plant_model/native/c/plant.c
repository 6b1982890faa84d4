#include "plant.h"

#include <math.h>
#include <string.h>

#include "formulas.h"
#include "noise.h"

#define NOT_FINITE "the thermal network is not finite"
#define TOO_LONG "the step is too long: temperatures would go on changing"
#define STEADY 1e-14 /* a smaller relative change in a part is a steady state */
#define FINEST 1e-12 /* rounding to a resolution this fine changes nothing */

void plant_prepare(struct plant *self, const double *parameters, uint32_t seed)
{
    memset(self, 0, sizeof *self);
    equations_prepare(parameters, self->k);
    struct network *network = &self->network;
    equations_fixed(self->k, network->capacity, self->decay, self->time_constants);
    for (size_t i = 0; i < NODES; i++) {
        network->share[i] = 1.0 / network->capacity[i];
    }
    network_prepare(network, self->k);
    memcpy(self->scales, machine_state_scales, sizeof self->scales);
    self->linear = !machine_one_way;
    for (int i = 0; i < ACTING; i++) {
        const struct acting *effect = &machine_acting[i];
        bool on = effect->amplitude == NONE || parameters[effect->amplitude] != effect->off;
        self->linear = self->linear && !(on && effect->dependent);
        for (size_t j = 0; !on && j < effect->state_count; j++) {
            self->scales[effect->first_state + j] = INFINITY;
        }
    }
    self->seed = seed;
}

void plant_show(
    const struct plant *self, struct plant_memory *memory, const double *inputs,
    double tool_length)
{
    const double at[] = {memory->time_s, tool_length};
    double found[SENSORS + AXES], *out = memory->outputs;
    equations_outputs(
        self->k, inputs, memory->temperatures, memory->states, memory->start, at, found);
    for (int i = 0; i < SENSORS; i++) {
        double shown = found[i];
        if (self->seed != 0) {
            double resolution = machine_sensors[i].resolution;
            resolution = resolution > 0.0 ? resolution : FINEST;
            shown += machine_sensors[i].deviation * noise_normal(self->seed, memory->drawn + i);
            shown = rint(rint(shown / resolution) * resolution * 1e9) / 1e9;
        }
        out[i] = shown;
    }
    for (size_t i = 0; i < AXES; i++) {
        double drift = found[SENSORS + i];
        double offset = memory->axes[i].counts * machine_axis.increment_um;
        out[SENSORS + 3 * i] = drift;
        out[SENSORS + 3 * i + 1] = offset;
        out[SENSORS + 3 * i + 2] = drift + offset;
    }
}

static void rest(struct plant_memory *memory, const double *inputs, const double *rises)
{
    for (int i = 0; i < RESTING; i++) {
        const double *share = machine_resting[i].shares;
        double sum = share[BOUNDARIES + RISES];
        for (int j = 0; j < BOUNDARIES; j++) {
            sum += share[j] * inputs[machine_boundaries[j]];
        }
        for (int j = 0; j < RISES; j++) {
            sum += share[BOUNDARIES + j] * rises[j];
        }
        memory->start[machine_resting[i].node] = sum;
    }
}

void plant_start(
    struct plant *self, struct plant_memory *memory, const double *inputs, const double *rises,
    double tool_length)
{
    memset(memory, 0, sizeof *memory);
    memory->part = 1.0;
    for (size_t i = 0; i < NODES; i++) {
        struct start start = machine_starts[i];
        double rise = start.rise == NONE ? 0.0 : rises[start.rise];
        double value = inputs[start.input] + rise, usual = inputs[machine_boundaries[0]];
        memory->start[i] = start.share == 1.0 ? value : usual + start.share * (value - usual);
    }
    rest(memory, inputs, rises);
    memcpy(memory->temperatures, memory->start, sizeof memory->start);
    equations_first(self->k, inputs, memory->start, memory->states);
    plant_show(self, memory, inputs, tool_length);
}

/* The own states of a linear network after a step: a lag follows a target linear in between. */
static void follow(
    const struct plant *self, double step_s, const double *inputs, const double *before,
    const double *after, double *states)
{
    double first[AT_LEAST_ONE(STATES)], last[AT_LEAST_ONE(STATES)];
    double settled[AT_LEAST_ONE(STATES)];
    equations_target(self->k, inputs, before, first);
    equations_target(self->k, inputs, after, last);
    equations_settled(self->k, inputs, after, states, settled);
    for (int i = 0; i < STATES; i++) {
        if (machine_lags[i]) {
            double decay = 1.0 / self->time_constants[i], x = -decay * step_s;
            double one = phi(1, x) * step_s, two = phi(2, x) * step_s;
            states[i] = exp(x) * states[i] + one * decay * first[i]
                        + two * decay * (last[i] - first[i]);
        } else {
            states[i] = settled[i];
        }
    }
}

/* Moves an axis towards an offset; a value that is not finite leaves the axis where it is. */
static void axis_step(struct axis_state *self, double wanted, double step_s)
{
    double limit = machine_axis.limit_um, increment = machine_axis.increment_um;
    if (!isfinite(wanted)) {
        return;
    }
    double target = wanted < -limit ? -limit : wanted > limit ? limit : wanted;
    double missing = rint(target / increment) - self->counts;
    /* Travel of less than an increment is kept for the next step, but does not accumulate. */
    self->allowance += machine_axis.slew_um_per_s * step_s / increment;
    self->allowance = self->allowance < MOST_ALLOWANCE ? self->allowance : MOST_ALLOWANCE;
    double reach = trunc(self->allowance);
    double move = missing < -reach ? -reach : missing > reach ? reach : missing;
    self->allowance -= fabs(move);
    self->allowance = self->allowance < 1.0 ? self->allowance : 1.0;
    self->counts += move;
}

/* T(t + h) = T + h phi_1(-h A) (f / C - A T) with held heat. */
WIDE static const char *linear_advance(
    struct plant *self, double step_s, const double *force, const double *before, double *after)
{
    const int kinds[] = {ONE};
    double warming[ROW], loss[ROW], sum[ROW], *const sums[] = {sum};
    struct network *network = &self->network;
    double parts = larger(1.0, ceil(network->fastest * step_s / MOST_REACH));
    double h = step_s / parts;
    const struct series *series = series_for(&self->series, network->fastest * h);
    for (size_t i = 0; i < NODES; i++) {
        warming[i] = force[i] * network->share[i];
    }
    for (double part = 0.0; part < parts; part++) {
        if (part == MOST_PARTS) {
            return TOO_LONG;
        }
        memset(sum, 0, sizeof sum);
        equations_product(
            network->diagonal, network->entries, network->share, before, warming, 0.0, loss, sum);
        series_add(series, network, h, loss, 0.0, 1, kinds, sums);
        for (size_t i = 0; i < NODES; i++) {
            after[i] = before[i] - h * sum[i];
        }
        if (parts > 1.0 && h * largest_of(sum, NODES) <= STEADY * largest_of(after, NODES)) {
            break;
        }
        before = after;
    }
    return NULL;
}

void plant_go_on(struct plant_memory *memory, double step_s, const double offsets[AXES])
{
    for (size_t i = 0; i < AXES; i++) {
        axis_step(&memory->axes[i], offsets[i], step_s);
    }
    memory->drawn += SENSORS;
}

/* Updates the network and the heat for inputs. */
static void enter(struct plant *self, const double *inputs, double *h, double *force)
{
    network_at(&self->network, self->k, inputs);
    equations_held(self->k, inputs, h);
    equations_force(self->k, inputs, h, self->network.outside, force);
}

const char *plant_rates(
    struct plant *self, const struct plant_memory *memory, const double *inputs,
    double rates[SIZE])
{
    const struct network *network = &self->network;
    double h[AT_LEAST_ONE(KEPT_OF_INPUTS)], force[NODES], heat[NODES];
    double warming[NODES], own[AT_LEAST_ONE(STATES)];
    enter(self, inputs, h, force);
    equations_dependent(
        self->k, inputs, h, memory->temperatures, memory->states, heat, own);
    for (size_t i = 0; i < NODES; i++) {
        warming[i] = (force[i] + heat[i]) * network->share[i];
    }
    equations_product(
        network->diagonal, network->entries, network->share, memory->temperatures, warming, 0.0,
        rates, heat);
    for (size_t i = 0; i < NODES; i++) {
        rates[i] = -rates[i];
    }
    memcpy(rates + NODES, own, STATES * sizeof *own);
    return are_finite(rates, SIZE) ? NULL : NOT_FINITE;
}

const char *plant_step(
    struct plant *self, struct plant_memory *memory, double step_s, const double *inputs,
    double tool_length, const double offsets[AXES])
{
    double h[AT_LEAST_ONE(KEPT_OF_INPUTS)], force[NODES], part = memory->part;
    const char *problem;
    struct point next;
    memcpy(next.states, memory->states, sizeof next.states);
    enter(self, inputs, h, force);
    if (!self->linear) {
        memcpy(next.nodes, memory->temperatures, sizeof next.nodes);
        problem = dependent_advance(self, step_s, inputs, h, force, &part, &next);
    } else {
        problem = linear_advance(self, step_s, force, memory->temperatures, next.nodes);
        if (problem == NULL && STATES > 0) {
            follow(self, step_s, inputs, memory->temperatures, next.nodes, next.states);
        }
    }
    if (problem != NULL || !are_finite(next.nodes, NODES)) {
        return problem != NULL ? problem : NOT_FINITE;
    }
    memcpy(memory->temperatures, next.nodes, sizeof next.nodes);
    memcpy(memory->states, next.states, sizeof next.states);
    memory->part = part;
    memory->time_s += step_s;
    plant_go_on(memory, step_s, offsets);
    plant_show(self, memory, inputs, tool_length);
    return NULL;
}
