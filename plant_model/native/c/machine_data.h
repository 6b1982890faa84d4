/* What one machine says: the generated machine_data.c defines it, machine_sizes.h its sizes. */
#ifndef MACHINE_DATA_H
#define MACHINE_DATA_H

#include <stdbool.h>
#include <stddef.h>

#include "machine_sizes.h"
#include "model.h"

#define SIZE (NODES + STATES)
#define ROW ((NODES + 3) / 4 * 4) /* nodes, so that the next row begins where this one does */
#define AT_LEAST_ONE(count) ((count) > 0 ? (count) : 1)

/* An effect that a tunable parameter may switch off. */
struct acting {
    size_t amplitude; /* among the tunable parameters; NONE: it is always on */
    double off;
    bool dependent; /* makes the network non-linear while it is on */
    size_t first_state, state_count;
};

/* Where a node starts: at an input, or above the first boundary temperature by a start_rise; or a
   share of the way there from that boundary. */
struct start {
    size_t input;
    size_t rise; /* among the start_rise parameters; NONE: none */
    double share;
};

/* Where a node stands when the machine has been at rest for long: see the Python twin, rest.py. */
struct resting {
    size_t node;
    double shares[BOUNDARIES + RISES + 1]; /* of boundaries, of start rises, and a constant [degC] */
};

/* What a variable of the FMU must lie in. */
struct range {
    double low, high;
    const char *unit; /* a space before it, or nothing */
};

/* Value references: the inputs come first, then tool_length and dX, dY, dZ; behind noise_seed the
   start_rise parameters and the tunable ones. */
struct ports {
    size_t noise_seed;
};

struct sensor_noise {
    double deviation, resolution;
};

struct axis_limits {
    double slew_um_per_s, limit_um, increment_um;
};

extern const size_t machine_boundaries[AT_LEAST_ONE(BOUNDARIES)]; /* their places among inputs */
extern const size_t machine_levels[AT_LEAST_ONE(LEVELS)]; /* inputs that conductances depend on */
extern const struct acting machine_acting[AT_LEAST_ONE(ACTING)];
extern const struct start machine_starts[NODES];
extern const struct resting machine_resting[AT_LEAST_ONE(RESTING)];
extern const struct range machine_ranges[]; /* by value reference; of an output empty */
extern const struct ports model_ports;
extern const struct sensor_noise machine_sensors[AT_LEAST_ONE(SENSORS)];
extern const struct axis_limits machine_axis;
extern const double machine_nominals[SIZE]; /* of temperatures and own states */
extern const double machine_state_scales[AT_LEAST_ONE(STATES)];
extern const bool machine_lags[AT_LEAST_ONE(STATES)];
extern const bool machine_one_way; /* heat flows one way between nodes */
extern const bool machine_settles; /* some own state jumps at the end of a step */

/* The equations. Rows: p tunable parameters, k what follows from them alone, u inputs, h what
   follows from k and u, T temperatures, x own states, s temperatures at the start, w time since
   the start [s] and length of the tool [mm]. */
void equations_prepare(const double *p, double *k);
void equations_fixed(
    const double *k, double *capacity, double *decay, double *time_constants);
/* Conductances: of each the part that no input moves; then those that inputs move, in whole. */
void equations_still(const double *k, double *diagonal, double *entries, double *outside);
void equations_moving(
    const double *k, const double *u, double *diagonal, double *entries, double *outside);
/* Finds the rates C^-1 L T [K/s] less the last; share is 1 / C. The sum gets T, times a weight. */
void equations_product(
    const double *diagonal, const double *entries, const double *share, const double *T,
    const double *last, double weight, double *restrict next, double *restrict sum);
void equations_held(const double *k, const double *u, double *h);
/* The heat that depends on inputs only [W], what comes by the conductances to outside included. */
void equations_force(
    const double *k, const double *u, const double *h, const double *outside, double *force);
void equations_dependent(
    const double *k, const double *u, const double *h, const double *T, const double *x,
    double *heat, double *rates);
/* Derivatives of rates and outputs by inputs, tool_length, offsets and states, the
   direction or weights in d. */
void equations_forward(
    const double *k, const double *u, const double *T, const double *x, const double *s,
    const double *w, const double *d, double *found);
void equations_backward(
    const double *k, const double *u, const double *T, const double *x, const double *s,
    const double *w, const double *d, double *found);
void equations_target(const double *k, const double *u, const double *T, double *target);
void equations_settled(
    const double *k, const double *u, const double *T, const double *x, double *settled);
void equations_first(const double *k, const double *u, const double *T, double *first);
void equations_outputs(
    const double *k, const double *u, const double *T, const double *x, const double *s,
    const double *w, double *outputs);

#endif
