/* One instance of the FMU, whatever version of FMI stands in front of it. */
#ifndef INSTANCE_H
#define INSTANCE_H

#include <stdbool.h>
#include <stdint.h>

#include "bus.h"
#include "model.h"
#include "setup.h"

/* STEPPING is the event mode of model exchange; in co-simulation that is EVENTS. */
enum phase { INSTANTIATED, INITIALISING, STEPPING, CONTINUOUS, EVENTS, TERMINATED };

/* All that changes, in one piece of memory: an FMU state is a copy of it. */
struct memory {
    double time_s; /* the time that has been reached */
    double stop_s; /* no step goes farther; infinite where the host said nothing */
    int32_t phase;
    int32_t fresh;    /* where they are not those of a step: the outputs are those of the values */
    double numbers[]; /* a value per variable, of which inputs and parameters count; the content */
};

struct instance {
    struct setup setup;
    struct model *model;
    struct memory *memory;
    size_t memory_size; /* [bytes] */
    double *values;     /* by value reference */
    void *content;      /* of the model */
    double *rates;      /* of its states, as they were last computed */
    double *sides[2];   /* of derivatives: seeds and what is found; NULL: none was asked for */
    bool exchange;      /* for model exchange */
    bool events;        /* a co-simulation with event mode */
    struct terminal *terminal; /* of a bus; NULL: none */
    char text[PROBLEM_LENGTH], problem[PROBLEM_LENGTH];
};

/* Returns a fresh instance; NULL without memory. Its setup says whether it can be used. */
struct instance *instance_new(void);
void instance_free(struct instance *self);

/* Brings back the start values. */
void instance_reset(struct instance *self);

/* Each returns what is wrong, NULL for nothing. */
const char *instance_experiment(struct instance *self, double start_s, bool has_stop, double stop_s);
const char *instance_initialise(struct instance *self); /* begins the initialisation */
const char *instance_start(struct instance *self);      /* ends it */
const char *instance_terminate(struct instance *self);

/* Says why no step of a length can begin at a time at all, NULL if one can. */
const char *instance_may_step(const struct instance *self, double time_s, double step_s);

/* Whether a time has been reached, to what a clock's sums round. */
bool instance_is_due(const struct instance *self, double time_s);

/* Advances by a step; returns what is wrong, NULL for nothing. */
const char *instance_step(struct instance *self, double time_s, double step_s);

/* Sees to it that the outputs, where they are not those of a step, are those of the values in
   force; returns what is wrong, NULL for nothing. */
const char *instance_refresh(struct instance *self);

/* Model exchange; each returns what is wrong, NULL for nothing. */
const char *instance_enter(struct instance *self, enum phase mode);
const char *instance_set_time(struct instance *self, double time_s);
const char *instance_get_states(struct instance *self, double *states, size_t count);
const char *instance_set_states(struct instance *self, const double *states, size_t count);
const char *instance_get_rates(struct instance *self, double *rates, size_t count);
const char *instance_get_nominals(struct instance *self, double *nominals, size_t count);
const char *instance_complete(struct instance *self);  /* a solver's step has ended */
const char *instance_in_event(struct instance *self);  /* that it is in event mode */
/* Directional derivatives: begin, seed variables of a side, derive, and get those of the other. */
const char *instance_begin_derivatives(struct instance *self);
const char *instance_seed(struct instance *self, enum side side, size_t ref, double seed);
const char *instance_derive(struct instance *self, enum side from);
const char *instance_get_derivative(
    const struct instance *self, enum side side, size_t ref, double *found);

/* Computes the rates of the states. */
const char *instance_compute_rates(struct instance *self);

/* Read and set a variable by value reference; each returns what is wrong, NULL for nothing. Unless
   really, setting only says whether it could be done: a row is set whole or not at all. */
const char *instance_get_real(struct instance *self, enum kind kind, size_t ref, double *value);
const char *instance_get_whole(struct instance *self, enum kind kind, size_t ref, int32_t *value);
const char *instance_get_string(
    struct instance *self, enum kind kind, size_t ref, const char **value);
const char *instance_set_number(
    struct instance *self, enum kind kind, size_t ref, double value, bool really);
const char *instance_set_string(
    struct instance *self, enum kind kind, size_t ref, const char *value, bool really);

/* A bus terminal; each returns what is wrong, NULL for nothing. */
const char *instance_enter_step(struct instance *self); /* leaves event mode */
const char *instance_get_port(
    struct instance *self, enum port port, const unsigned char **bytes, size_t *size);
const char *instance_set_port(
    struct instance *self, enum port port, const unsigned char *bytes, size_t size);
const char *instance_get_clock(
    struct instance *self, enum port port, size_t frame, bool *active);
const char *instance_set_clock(struct instance *self, enum port port, size_t frame, bool active);
/* How long until the Tx clock ticks [s], and whether that has changed since it was asked last. */
const char *instance_interval(
    struct instance *self, enum port port, double *interval_s, bool *changed);
/* Ends an instant of event mode, or says that there is more to it: clocks that tick now. */
const char *instance_update(struct instance *self, bool *again);
/* Returns whether the FMU knows when clocks of its own tick next, and when [s]. */
bool instance_next_event(const struct instance *self, double *time_s);

/* The categories of messages, by the names in the model description; a set of them has a bit each. */
enum category { DISCARDED, REFUSED, CATEGORIES };
extern const char *const category_names[];

/* Takes note of what is logged: nothing, or the categories named, or all without names. Returns
   whether they are known; nothing changes if not. */
bool instance_log(unsigned *logged, bool on, size_t count, const char *const categories[]);

/* A state is a copy of the memory; NULL without memory. memory_give() ends it. */
struct memory *instance_state(const struct instance *self);
void instance_restore(struct instance *self, const struct memory *state);

/* A state as bytes: a head with a check sum, so that damaged and foreign bytes are refused. */
size_t state_bytes_size(const struct instance *self);
void state_to_bytes(const struct instance *self, const struct memory *state, void *bytes);
struct memory *state_from_bytes(
    const struct instance *self, const void *bytes, size_t size, const char **problem);

#endif
