/* The plant: one machine stepped in time with held inputs. */
#ifndef PLANT_H
#define PLANT_H

#include <stdint.h>

#include "machine_data.h"
#include "network.h"
#include "series.h"

#define AXES 3
#define OUTPUTS (SENSORS + 3 * AXES) /* readings; then drift, offset in force and error an axis */

struct axis_state {
    double counts, allowance;
};

/* Temperatures and own states, or what changes them [K/s]. */
struct point {
    double nodes[NODES], states[AT_LEAST_ONE(STATES)];
};

/* All that a continued trajectory needs. */
struct plant_memory {
    double time_s;
    double start[NODES], temperatures[NODES], states[AT_LEAST_ONE(STATES)];
    struct axis_state axes[AXES];
    double began_s, completed_s; /* of model exchange: its clock at the start; time_s of late */
    double part;  /* of a step that error control goes at a time */
    double drawn; /* random numbers */
    double outputs[OUTPUTS];
};

/* What follows from the parameters, and what is kept because it may be needed again: never
   anything that the memory and the parameters do not decide. */
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

/* Takes parameters in: tunable ones in the order of machine_tunable; the seed of the noise, 0 for
   none. */
void plant_prepare(struct plant *self, const double *parameters, uint32_t seed);

/* Starts: inputs are the machine's, rises those of machine_rises [K], tool_length [mm]. */
void plant_start(
    struct plant *self, struct plant_memory *memory, const double *inputs, const double *rises,
    double tool_length);

/* Advances by a step with inputs and the offsets received held; what is wrong, NULL for nothing,
   and then the memory is as before. */
const char *plant_step(
    struct plant *self, struct plant_memory *memory, double step_s, const double *inputs,
    double tool_length, const double offsets[AXES]);

/* Computes all outputs for the state as it is. */
void plant_show(
    const struct plant *self, struct plant_memory *memory, const double *inputs,
    double tool_length);

/* Computes the rates of temperatures and own states [K/s, 1/s]; what is wrong, NULL for nothing. */
const char *plant_rates(
    struct plant *self, const struct plant_memory *memory, const double *inputs,
    double rates[SIZE]);

/* What is not continuous goes on: axes move, and sensors draw noise anew. */
void plant_go_on(struct plant_memory *memory, double step_s, const double offsets[AXES]);

/* One step of a state where something depends on temperature; held is what equations_held finds.
   What is wrong, NULL for nothing. */
const char *dependent_advance(
    struct plant *self, double step_s, const double *inputs, const double *held,
    const double *force, double *part, struct point *state);

#endif
