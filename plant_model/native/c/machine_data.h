/* Data of one machine: the generated machine_data.c defines them, machine_sizes.h their sizes and
   the numbers of the Python twins. */
#ifndef MACHINE_DATA_H
#define MACHINE_DATA_H

#include <stdbool.h>
#include <stddef.h>

#include "machine_sizes.h"
#include "model.h"

#define SIZE (NODES + STATES)
#define ROW ((NODES + 3) / 4 * 4) /* nodes, padded so that all rows are aligned alike */
#define AT_LEAST_ONE(count) ((count) > 0 ? (count) : 1)

/* An effect that a tunable parameter may switch off. */
struct acting {
    size_t amplitude; /* among the tunable parameters; NONE: always on */
    double off;
    bool dependent; /* makes the network non-linear while it is on */
    size_t first_state, state_count;
};

/* Start of a node: at an input, or a start_rise above the first boundary temperature, or a share of
   the way there from that boundary. */
struct start {
    size_t input;
    size_t rise; /* among the start_rise parameters; NONE: none */
    double share;
};

/* Start of a node in a machine long at rest: see the Python twin, rest.py. */
struct resting {
    size_t node;
    double shares[BOUNDARIES + RISES + 1]; /* of boundaries, of start rises, and a constant [degC] */
};

/* Allowed range of an FMU variable. */
struct range {
    double low, high;
    const char *unit; /* with a space before it, or empty */
};

/* Value references: first the inputs, then tool_length and dX, dY, dZ; after noise_seed the
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
extern const struct range machine_ranges[]; /* by value reference; unlimited for an output */
extern const struct ports model_ports;
extern const struct sensor_noise machine_sensors[AT_LEAST_ONE(SENSORS)];
extern const struct axis_limits machine_axis;
extern const double machine_nominals[SIZE]; /* of temperatures and own states */
extern const double machine_node_scales[NODES]; /* error that counts as much as 1 K */
extern const double machine_state_scales[AT_LEAST_ONE(STATES)];
extern const bool machine_lags[AT_LEAST_ONE(STATES)];
extern const bool machine_one_way; /* heat flows one way between nodes */
extern const bool machine_settles; /* some own state jumps at the end of a step */

/* The equations. Rows: p tunable parameters, k values that depend only on them, u inputs, h values
   that depend on k and u, T temperatures, x own states, s temperatures at the start, w time since
   the start [s] and length of the tool [mm]. */
void equations_prepare(const double *p, double *k);
void equations_fixed(
    const double *k, double *capacity, double *decay, double *time_constants);
/* Conductances: first the part of each that does not depend on inputs; then the full value of those
   that do. */
void equations_still(const double *k, double *diagonal, double *entries, double *outside);
void equations_moving(
    const double *k, const double *u, double *diagonal, double *entries, double *outside);
/* Finds the rates C^-1 L T [K/s] minus last, with share = 1 / C, and adds weight times T to sum. */
void equations_product(
    const double *diagonal, const double *entries, const double *share, const double *T,
    const double *last, double weight, double *restrict next, double *restrict sum);
void equations_held(const double *k, const double *u, double *h);
/* The heat that depends on inputs only [W], including that through conductances to outside. */
void equations_force(
    const double *k, const double *u, const double *h, const double *outside, double *force);
void equations_dependent(
    const double *k, const double *u, const double *h, const double *T, const double *x,
    double *heat, double *rates);
/* Derivatives of rates and outputs by inputs, tool_length, offsets, states and tunable parameters,
   with the direction or weights in d. */
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
