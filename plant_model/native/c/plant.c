#include "plant.h"

#include <math.h>
#include <string.h>

#include "formulas.h"
#include "noise.h"

#define NO_MODES "the thermal network is not finite"
#define MOST_PARTS 16        /* a Taylor series in as many parts costs less than to find modes */
#define LARGEST_PART 6.0     /* its terms grow to 6^6/6! = 65 and cost no more than two digits */
#define MOST_TERMS 60
#define SMALL 1e-18
#define REPEATED_ENOUGH 8.0  /* from then on modes pay */
#define MOST_ALLOWANCE 1e15  /* see the Python twin, axis.py */
#define FINEST 1e-12         /* rounding to a resolution far below a double's changes nothing */

void plant_prepare(struct plant *self, const double *parameters, uint32_t seed)
{
    memset(self, 0, sizeof *self);
    equations_prepare(parameters, self->k);
    equations_fixed(self->k, self->capacity, self->decay, self->time_constants);
    for (size_t i = 0; i < NODES; i++) {
        self->root[i] = sqrt(self->capacity[i]);
    }
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

/* Computes all outputs for the state as it is. */
static void refresh(
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
    if (self->seed != 0) {
        memory->drawn += SENSORS;
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
    refresh(self, memory, inputs, tool_length);
}

/* Sees to it that the conductances at the level of the inputs are there. */
static void take_level(struct plant *self, const double *inputs)
{
    double level[AT_LEAST_ONE(LEVELS)] = {0.0};
    for (int i = 0; i < LEVELS; i++) {
        level[i] = inputs[machine_levels[i]];
    }
    if (!self->conductances.known || !same_level(level, self->conductances.level)) {
        conductances_at(&self->conductances, self->k, self->root, inputs);
    }
}

struct modes *plant_modes(struct plant *self)
{
    for (int i = 0; i < LEVELS_KEPT; i++) {
        struct modes *modes = &self->modes[i];
        if (modes->known && same_level(modes->level, self->conductances.level)) {
            return modes;
        }
    }
    struct modes *modes = &self->modes[self->next];
    self->next = (self->next + 1) % LEVELS_KEPT;
    if (self->weights_of == modes) {
        self->weights_of = NULL;
    }
    return modes_of(modes, &self->conductances, self->root) ? modes : NULL;
}

/* T(t + h) = T + h phi_1(-A h) (f / C - A T) by its Taylor series. */
static void taylor(
    const struct plant *self, double step_s, double parts, const double *force,
    double *temperatures)
{
    const struct conductances *at = &self->conductances;
    double h = step_s / parts, y[NODES], f[NODES], term[NODES], next[NODES];
    for (size_t i = 0; i < NODES; i++) {
        y[i] = temperatures[i] * self->root[i];
        f[i] = force[i] / self->root[i];
    }
    for (double part = 0.0; part < parts; part++) {
        double largest = 0.0;
        conductances_times(at, y, term);
        for (size_t i = 0; i < NODES; i++) {
            largest = larger(largest, fabs(y[i]));
            term[i] = h * (f[i] - term[i]);
            y[i] += term[i];
        }
        for (int order = 2; order < MOST_TERMS; order++) {
            double most = 0.0;
            conductances_times(at, term, next);
            for (size_t i = 0; i < NODES; i++) {
                term[i] = next[i] * (-h / order);
                y[i] += term[i];
                most = larger(most, fabs(term[i]));
            }
            if (most <= SMALL * largest) {
                break;
            }
        }
    }
    for (size_t i = 0; i < NODES; i++) {
        temperatures[i] = y[i] / self->root[i];
    }
}

/* The same by the modes. */
static void by_modes(
    const struct plant *self, struct modes *modes, double step_s, const double *force,
    double *temperatures)
{
    double rate[NODES], old[NODES], driven[NODES];
    if (!modes->step_known || modes->step_s != step_s) {
        for (size_t i = 0; i < NODES; i++) {
            double x = -modes->decay[i] * step_s;
            modes->keep[i] = exp(x);
            modes->gain[i] = step_s * phi(1, x);
        }
        modes->step_s = step_s;
        modes->step_known = true;
    }
    for (size_t i = 0; i < NODES; i++) {
        rate[i] = force[i] / self->capacity[i];
    }
    matrix_times(modes->to_modes[0], temperatures, old);
    matrix_times(modes->to_modes[0], rate, driven);
    for (size_t i = 0; i < NODES; i++) {
        old[i] = modes->keep[i] * old[i] + modes->gain[i] * driven[i];
    }
    matrix_times(modes->to_state[0], old, temperatures);
}

/* The own states of a linear network after a step: a lag follows what is linear between. */
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

/* Moves an axis towards an offset; a value that is not finite is not an offset. */
static void axis_step(struct axis_state *self, double wanted, double step_s)
{
    double limit = machine_axis.limit_um, increment = machine_axis.increment_um;
    if (!isfinite(wanted)) {
        return;
    }
    double target = wanted < -limit ? -limit : wanted > limit ? limit : wanted;
    double missing = rint(target / increment) - self->counts;
    /* Travel that is less than an increment is kept for the next step, but not hoarded. */
    self->allowance += machine_axis.slew_um_per_s * step_s / increment;
    self->allowance = self->allowance < MOST_ALLOWANCE ? self->allowance : MOST_ALLOWANCE;
    double reach = trunc(self->allowance);
    double move = missing < -reach ? -reach : missing > reach ? reach : missing;
    self->allowance -= fabs(move);
    self->allowance = self->allowance < 1.0 ? self->allowance : 1.0;
    self->counts += move;
}

/* Notes for how long level and step have stayed. What is done next must follow from the memory
   alone, or a restored instance would not continue bit for bit. */
static void count(const struct plant *self, struct plant_memory *memory, double step_s)
{
    bool same = memory->step_s == step_s && same_level(memory->level, self->conductances.level);
    memory->repeated = same ? memory->repeated + 1.0 : 0.0;
    if (memory->repeated > REPEATED_ENOUGH) {
        memory->repeated = REPEATED_ENOUGH;
    }
    memory->step_s = step_s;
    memcpy(memory->level, self->conductances.level, sizeof memory->level);
}

static const char *linear_advance(
    struct plant *self, double repeated, double step_s, const double *inputs,
    const double *force, double *temperatures, double *states)
{
    double before[NODES];
    /* Without any exchange of heat nothing is fast, and the step is still one part. */
    double parts = larger(1.0, ceil(self->conductances.fastest * step_s / LARGEST_PART));
    memcpy(before, temperatures, sizeof before);
    if (repeated < REPEATED_ENOUGH && parts <= MOST_PARTS) {
        taylor(self, step_s, parts, force, temperatures);
    } else {
        struct modes *modes = plant_modes(self);
        if (modes == NULL) {
            return NO_MODES;
        }
        by_modes(self, modes, step_s, force, temperatures);
    }
    if (STATES > 0) {
        follow(self, step_s, inputs, before, temperatures, states);
    }
    return NULL;
}

const char *plant_step(
    struct plant *self, struct plant_memory *memory, double step_s, const double *inputs,
    double tool_length, const double offsets[AXES])
{
    double h[AT_LEAST_ONE(KEPT_OF_INPUTS)], force[NODES];
    struct plant_memory next;
    const char *problem = NULL;
    memcpy(&next, memory, sizeof next);
    take_level(self, inputs);
    count(self, &next, step_s);
    equations_held(self->k, inputs, h);
    equations_heat(self->k, inputs, h, force);
    for (int i = 0; i < OUTSIDE; i++) {
        struct pair pair = machine_outside[i];
        double outside = inputs[machine_boundaries[pair.other]];
        force[pair.node] += self->conductances.outside[i] * outside;
    }
    if (self->linear) {
        problem = linear_advance(
            self, next.repeated, step_s, inputs, force, next.temperatures, next.states);
    } else {
        problem = dependent_advance(
            self, step_s, inputs, force, &next.part, next.temperatures, next.states);
    }
    for (size_t i = 0; problem == NULL && i < NODES; i++) {
        problem = isfinite(next.temperatures[i]) ? NULL : NO_MODES;
    }
    if (problem != NULL) {
        return problem;
    }
    next.time_s += step_s;
    for (size_t i = 0; i < AXES; i++) {
        axis_step(&next.axes[i], offsets[i], step_s);
    }
    refresh(self, &next, inputs, tool_length);
    memcpy(memory, &next, sizeof next);
    return NULL;
}
