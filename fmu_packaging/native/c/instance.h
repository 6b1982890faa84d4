/* One instance of the FMU, independent of the version of FMI. */
#ifndef INSTANCE_H
#define INSTANCE_H

#include <stdbool.h>
#include <stdint.h>

#include "bus.h"
#include "model.h"
#include "setup.h"

/* STEPPING is the event mode of model exchange; that of co-simulation is EVENTS. */
enum phase { INSTANTIATED, INITIALISING, STEPPING, CONTINUOUS, EVENTS, TERMINATED };

/* Everything that changes, in one piece of memory: an FMU state is a copy of it. */
struct memory {
    double time_s; /* current time */
    double stop_s; /* no step goes further; infinite if the host gave none */
    int32_t phase;
    int32_t fresh;    /* whether outputs that are not from a step are up to date */
    double numbers[]; /* one value per variable (used: inputs and parameters); then the content */
};

struct instance {
    struct setup setup;
    struct model *model;
    struct memory *memory;
    size_t memory_size; /* [bytes] */
    double *values;     /* by value reference */
    void *content;      /* of the model */
    double *rates;      /* of its states, as last computed */
    double *sides[2];   /* of derivatives: seeds and results; NULL: none requested yet */
    bool exchange;      /* for model exchange */
    bool events;        /* a co-simulation with event mode */
    struct terminal *terminal; /* of a bus; NULL: none */
    char text[PROBLEM_LENGTH], problem[PROBLEM_LENGTH];
};

/* Returns a new instance; NULL if out of memory. Its setup tells whether it can be used. */
struct instance *instance_new(void);
void instance_free(struct instance *self);

/* Restores the start values. */
void instance_reset(struct instance *self);

/* Each returns an error message, or NULL. */
const char *instance_experiment(struct instance *self, double start_s, bool has_stop, double stop_s);
const char *instance_initialise(struct instance *self); /* begins the initialisation */
const char *instance_start(struct instance *self);      /* ends it */
const char *instance_terminate(struct instance *self);

/* Returns why a step of this length cannot begin at this time, NULL if it can. */
const char *instance_may_step(const struct instance *self, double time_s, double step_s);

/* Whether a time has been reached, within the rounding of a clock's sums. */
bool instance_is_due(const struct instance *self, double time_s);

/* Advances by a step; returns an error message, or NULL. */
const char *instance_step(struct instance *self, double time_s, double step_s);

/* Updates outputs that are not from a step to the current values; returns an error message, or
   NULL. */
const char *instance_refresh(struct instance *self);

/* Model exchange; each returns an error message, or NULL. */
const char *instance_enter(struct instance *self, enum phase mode);
const char *instance_set_time(struct instance *self, double time_s);
const char *instance_get_states(struct instance *self, double *states, size_t count);
const char *instance_set_states(struct instance *self, const double *states, size_t count);
const char *instance_get_rates(struct instance *self, double *rates, size_t count);
const char *instance_get_nominals(struct instance *self, double *nominals, size_t count);
const char *instance_complete(struct instance *self);  /* a solver's step has ended */
const char *instance_in_event(struct instance *self);  /* checks that it is in event mode */
/* Directional derivatives: begin, seed variables of one side, derive, get those of the other. */
const char *instance_begin_derivatives(struct instance *self);
const char *instance_seed(struct instance *self, enum side side, size_t ref, double seed);
const char *instance_derive(struct instance *self, enum side from);
const char *instance_get_derivative(
    const struct instance *self, enum side side, size_t ref, double *found);

/* Computes the rates of the states. */
const char *instance_compute_rates(struct instance *self);

/* Get and set a variable by value reference; each returns an error message, or NULL. Unless really,
   setting only checks whether it is possible, so that a row is set as a whole or not at all. */
const char *instance_get_real(struct instance *self, enum kind kind, size_t ref, double *value);
const char *instance_get_whole(struct instance *self, enum kind kind, size_t ref, int32_t *value);
const char *instance_get_string(
    struct instance *self, enum kind kind, size_t ref, const char **value);
const char *instance_set_number(
    struct instance *self, enum kind kind, size_t ref, double value, bool really);
const char *instance_set_string(
    struct instance *self, enum kind kind, size_t ref, const char *value, bool really);

/* A bus terminal; each returns an error message, or NULL. */
const char *instance_enter_step(struct instance *self); /* leaves event mode */
const char *instance_get_port(
    struct instance *self, enum port port, const unsigned char **bytes, size_t *size);
const char *instance_set_port(
    struct instance *self, enum port port, const unsigned char *bytes, size_t size);
const char *instance_get_clock(
    struct instance *self, enum port port, size_t frame, bool *active);
const char *instance_set_clock(struct instance *self, enum port port, size_t frame, bool active);
/* Time until the Tx clock ticks [s], and whether it has changed since the last call. */
const char *instance_interval(
    struct instance *self, enum port port, double *interval_s, bool *changed);
/* Ends an event iteration; again: another one is needed, for clocks that tick now. */
const char *instance_update(struct instance *self, bool *again);
/* Returns whether the next tick of the FMU's own clocks is known, and its time [s]. */
bool instance_next_event(const struct instance *self, double *time_s);

/* The categories of messages, named as in the model description; a set has one bit for each. */
enum category { DISCARDED, REFUSED, CATEGORIES };
extern const char *const category_names[];

/* Sets what is logged: nothing, the named categories, or without names all. Returns whether they
   are known; if not, nothing changes. */
bool instance_log(unsigned *logged, bool on, size_t count, const char *const categories[]);

/* A state is a copy of the memory; NULL if out of memory. memory_give() frees it. */
struct memory *instance_state(const struct instance *self);
void instance_restore(struct instance *self, const struct memory *state);

/* A state as bytes: a header with a checksum, so that damaged and foreign bytes are refused. */
size_t state_bytes_size(const struct instance *self);
void state_to_bytes(const struct instance *self, const struct memory *state, void *bytes);
struct memory *state_from_bytes(
    const struct instance *self, const void *bytes, size_t size, const char **problem);

#endif
