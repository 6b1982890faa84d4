/* The plant: one machine stepped in time with held inputs. */
#ifndef PLANT_H
#define PLANT_H

#include <stdint.h>

#include "machine_data.h"
#include "network.h"
#include "series.h"

#define AXES 3
#define OUTPUTS (SENSORS + 3 * AXES) /* readings; then drift, offset and error of each axis */

struct axis_state {
    double counts, allowance;
};

/* Temperatures and own states, or their rates [K/s]. */
struct point {
    double nodes[NODES], states[AT_LEAST_ONE(STATES)];
};

/* The state needed to continue. */
struct plant_memory {
    double time_s;
    double start[NODES], temperatures[NODES], states[AT_LEAST_ONE(STATES)];
    struct axis_state axes[AXES];
    double began_s, completed_s; /* of model exchange: clock at the start; last completed time_s */
    double part;  /* fraction of a step that error control steps at a time */
    double drawn; /* random numbers drawn so far */
    double outputs[OUTPUTS];
};

/* Values derived from the parameters, and cached results. Everything here is determined by memory
   and parameters. */
struct plant {
    struct network network;
    double k[AT_LEAST_ONE(KEPT_OF_PARAMETERS)];
    double decay[AT_LEAST_ONE(STATES)], time_constants[AT_LEAST_ONE(STATES)];
    double scales[AT_LEAST_ONE(STATES)]; /* infinite for a state whose effect is off */
    bool linear;
    uint32_t seed;
    struct all_series series;
    double weights_step_s, weights[6][AT_LEAST_ONE(STATES)]; /* of own states; see dependent.c */
};

/* Sets the parameters: tunable ones in the order of their value references, and the seed of the
   noise, 0 for none. */
void plant_prepare(struct plant *self, const double *parameters, uint32_t seed);

/* Starts with the machine's inputs, the start_rise parameters [K] and tool_length [mm]. */
void plant_start(
    struct plant *self, struct plant_memory *memory, const double *inputs, const double *rises,
    double tool_length);

/* Advances by a step with inputs and received offsets held. Returns NULL, or an error message; the
   memory is then unchanged. */
const char *plant_step(
    struct plant *self, struct plant_memory *memory, double step_s, const double *inputs,
    double tool_length, const double offsets[AXES]);

/* Computes all outputs for the present state. */
void plant_show(
    const struct plant *self, struct plant_memory *memory, const double *inputs,
    double tool_length);

/* Computes the rates of temperatures and own states [K/s, 1/s]. Returns NULL or an error text. */
const char *plant_rates(
    struct plant *self, const struct plant_memory *memory, const double *inputs,
    double rates[SIZE]);

/* Advances the parts that are not continuous: axes move, and sensors draw new noise. */
void plant_go_on(struct plant_memory *memory, double step_s, const double offsets[AXES]);

/* One step of a state if something depends on temperature; held is the result of equations_held.
   Returns NULL or an error message. */
const char *dependent_advance(
    struct plant *self, double step_s, const double *inputs, const double *held,
    const double *force, double *part, struct point *state);

#endif
