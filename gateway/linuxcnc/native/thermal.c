/* The compensator as a component of LinuxCNC: no Python, no bus.

   thermal NAME SLEW SPEED_UP WAY [STATE]: SLEW of an axis [um/s]; SPEED_UP of thermal time (1: real
   time); WAY: external or own offsets; STATE: a file from which a restart continues. The pins are
   those of component.py, where they are described. */
#define _GNU_SOURCE
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "axes.h"
#include "hal.h"
#include "instance.h"
#include "memory.h"
#include "rtapi.h"

#define CYCLE_S 0.1
#define WAIT_UM 0.5     /* the feed waits while an axis is further from its wanted offset */
#define SAVE_CYCLES 10
#define OLDEST_S 3600.0 /* an older state says nothing about the machine */
#define AGREE_S 10.0    /* largest difference of its age by the time of day and the steady clock */
#define AXES 3

static const char *const AXIS_NAMES[AXES] = {"x", "y", "z"};
static const char *const OFFSET_NAMES[AXES] = {"dX", "dY", "dZ"};

struct pins {
    hal_bit_t *alive, *cold, *enable, *clear, *on, *homed, *coord, *teleop;
    hal_bit_t *heartbeat, *running, *wait, *moved, *valid, *following;
    hal_s32_t *status, *counts[AXES];
    hal_float_t *request[AXES], *command[AXES], *offset[AXES];
    hal_float_t *in[]; /* by value reference; NULL if the variable is not an input */
};

struct component {
    struct pins *pins;
    struct instance *compensator;
    struct axis_offset axes[AXES];
    size_t offsets[AXES], valid, status; /* value references */
    double slew_um_s, speed_up;
    bool external, cold, taken_up;
    const char *state;
};

static volatile sig_atomic_t stopped;

static void stop(int number)
{
    (void)number;
    stopped = 1;
}

static double clock_s(clockid_t clock)
{
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static size_t reference_of(const char *name)
{
    for (size_t ref = 0; ref < model_variable_count; ref++) {
        if (strcmp(model_variables[ref].name, name) == 0) {
            return ref;
        }
    }
    return NONE;
}

static bool is_pin(size_t ref)
{
    return model_variables[ref].causality == INPUT && model_variables[ref].kind == REAL
           && strncmp(model_variables[ref].name, "measured", strlen("measured")) != 0;
}

/* Returns whether all pins could be made. */
static bool make_pins(struct pins *pins, int id, const char *name)
{
    const struct {
        const char *name;
        hal_bit_t **pin;
        hal_pin_dir_t direction;
    } bits[] = {
        {"alive", &pins->alive, HAL_IN},
        {"cold", &pins->cold, HAL_IN},           {"enable", &pins->enable, HAL_IN},
        {"clear", &pins->clear, HAL_IN},         {"on", &pins->on, HAL_IN},
        {"homed", &pins->homed, HAL_IN},         {"coord", &pins->coord, HAL_IN},
        {"teleop", &pins->teleop, HAL_IN},       {"heartbeat", &pins->heartbeat, HAL_OUT},
        {"running", &pins->running, HAL_OUT},    {"wait", &pins->wait, HAL_OUT},
        {"moved", &pins->moved, HAL_OUT},        {"valid", &pins->valid, HAL_OUT},
        {"following", &pins->following, HAL_OUT},
    };
    int failed = hal_pin_s32_newf(HAL_OUT, &pins->status, id, "%s.status", name);
    for (size_t i = 0; i < sizeof bits / sizeof bits[0]; i++) {
        failed |= hal_pin_bit_newf(bits[i].direction, bits[i].pin, id, "%s.%s", name, bits[i].name);
    }
    if (!failed) {
        /* Without a watchdog, assume that none has tripped. */
        *pins->alive = true;
    }
    for (size_t i = 0; i < AXES; i++) {
        const char *axis = AXIS_NAMES[i];
        failed |= hal_pin_float_newf(HAL_IN, &pins->request[i], id, "%s.request-%s", name, axis);
        failed |= hal_pin_float_newf(HAL_IN, &pins->command[i], id, "%s.command-%s", name, axis);
        failed |= hal_pin_float_newf(HAL_OUT, &pins->offset[i], id, "%s.offset-%s", name, axis);
        failed |= hal_pin_s32_newf(HAL_OUT, &pins->counts[i], id, "%s.counts-%s", name, axis);
    }
    for (size_t ref = 0; ref < model_variable_count && !failed; ref++) {
        if (is_pin(ref)) {
            failed |= hal_pin_float_newf(
                HAL_IN, &pins->in[ref], id, "%s.in.%s", name, model_variables[ref].name);
            /* An unconnected pin is missing. */
            *pins->in[ref] = NAN;
        }
    }
    return failed == 0;
}

/* The clocks that give a state's age; written before its bytes. */
struct stamp {
    double day_s, steady_s;
};

static struct stamp stamp_now(void)
{
    return (struct stamp){clock_s(CLOCK_REALTIME), clock_s(CLOCK_BOOTTIME)};
}

/* Saves the state completely, or leaves the old file as it is. */
static void save(const struct component *self)
{
    char other[4096];
    struct stamp stamp = stamp_now();
    size_t size = state_bytes_size(self->compensator);
    void *bytes = malloc(size);
    int length = snprintf(other, sizeof other, "%s.new", self->state);
    FILE *file = length < (int)sizeof other ? fopen(other, "wb") : NULL;
    if (bytes != NULL && file != NULL) {
        state_to_bytes(self->compensator, self->compensator->memory, bytes);
        bool written = fwrite(&stamp, sizeof stamp, 1, file) == 1
                       && fwrite(bytes, size, 1, file) == 1 && fflush(file) == 0
                       && fsync(fileno(file)) == 0;
        if (fclose(file) == 0 && written) {
            rename(other, self->state);
        }
    } else if (file != NULL) {
        fclose(file);
    }
    free(bytes);
}

/* Restores a saved state; returns NULL, or why it cannot be used. */
static const char *load(struct component *self)
{
    struct stamp then, now = stamp_now();
    const char *problem = NULL;
    size_t size = state_bytes_size(self->compensator);
    void *bytes = malloc(size + 1);
    FILE *file = fopen(self->state, "rb");
    if (bytes == NULL || file == NULL || fread(&then, sizeof then, 1, file) != 1) {
        problem = "there is none";
    } else {
        double day_s = now.day_s - then.day_s, steady_s = now.steady_s - then.steady_s;
        size_t got = fread(bytes, 1, size + 1, file);
        struct memory *state = state_from_bytes(self->compensator, bytes, got, &problem);
        if (state != NULL && !(fabs(day_s - steady_s) <= AGREE_S)) {
            problem = "the clocks do not agree on its age";
        } else if (state != NULL && !(steady_s * self->speed_up <= OLDEST_S)) {
            problem = "it is too old";
        } else if (state != NULL) {
            instance_restore(self->compensator, state);
            self->cold = true;
        }
        memory_give(state);
    }
    if (file != NULL) {
        fclose(file);
    }
    free(bytes);
    return problem;
}

/* Steps the compensator, once the machine is known to be cold. */
static void compensate(struct component *self, double step_s)
{
    struct instance *compensator = self->compensator;
    self->cold = self->cold || *self->pins->cold;
    if (!self->cold) {
        return;
    }
    for (size_t ref = 0; ref < model_variable_count; ref++) {
        if (self->pins->in[ref] != NULL) {
            compensator->values[ref] = *self->pins->in[ref];
        }
    }
    double time_s = clock_s(CLOCK_BOOTTIME) * self->speed_up;
    const char *problem = instance_step(compensator, time_s - step_s, step_s);
    if (problem != NULL) {
        fprintf(stderr, "thermal: %s\n", problem);
    }
}

static double output(struct component *self, size_t ref)
{
    double value = NAN;
    return instance_get_real(self->compensator, REAL, ref, &value) == NULL ? value : NAN;
}

static int32_t whole_output(struct component *self, enum kind kind, size_t ref)
{
    int32_t value = 0;
    return instance_get_whole(self->compensator, kind, ref, &value) == NULL ? value : 0;
}

/* Moves the axes towards the compensator's offsets. */
static void apply(struct component *self, double elapsed_s)
{
    struct pins *pins = self->pins;
    *pins->heartbeat = !*pins->heartbeat;
    if (*pins->running && !*pins->alive) {
        /* A tripped watchdog is reset when this rises. */
        *pins->running = false;
        return;
    }
    /* A delayed component does not make up for the delay in one step. */
    elapsed_s = fmin(elapsed_s, CYCLE_S);
    bool takes = *pins->on && *pins->homed && (*pins->coord || *pins->teleop);
    bool following = self->cold && whole_output(self, BOOLEAN, self->valid), moved = false;
    double furthest_um = 0.0;
    for (size_t i = 0; i < AXES; i++) {
        struct axis_offset *axis = &self->axes[i];
        double held_um = 1e3 * *pins->request[i];
        double wanted_um = *pins->clear || !self->cold ? 0.0 : output(self, self->offsets[i]);
        if (!self->taken_up) {
            int32_t counts = self->external ? *pins->counts[i] : (int32_t)lrint(held_um / COUNT_UM);
            axis_begin(axis, self->slew_um_s, held_um, counts);
        } else if (isfinite(wanted_um)) {
            axis_step(axis, wanted_um, takes, held_um, *pins->command[i], elapsed_s);
            furthest_um = fmax(furthest_um, fabs(wanted_um - axis->in_force_um));
        }
        if (self->external) {
            *pins->counts[i] = axis->counts;
        } else {
            *pins->offset[i] = axis->counts * COUNT_UM / 1e3;
        }
        moved = moved || !axis_at_zero(axis);
    }
    *pins->wait = takes && following && furthest_um > WAIT_UM;
    *pins->moved = moved;
    *pins->valid = *pins->following = following;
    *pins->status = whole_output(self, INTEGER, self->status);
    *pins->running = self->taken_up;
    self->taken_up = true;
}

static void sleep_until(double *due_s)
{
    double left_s = (*due_s += CYCLE_S) - clock_s(CLOCK_MONOTONIC);
    if (left_s > 0.0) {
        usleep((useconds_t)(left_s * 1e6));
    } else {
        *due_s -= left_s;
    }
}

static void run(struct component *self)
{
    double due_s = clock_s(CLOCK_MONOTONIC), last_s = due_s;
    for (long cycle = 1; !stopped; cycle++) {
        sleep_until(&due_s);
        double now_s = clock_s(CLOCK_MONOTONIC), elapsed_s = now_s - last_s;
        last_s = now_s;
        compensate(self, elapsed_s * self->speed_up);
        if (*self->pins->enable) {
            apply(self, elapsed_s);
        }
        if (self->state != NULL && self->cold && cycle % SAVE_CYCLES == 0) {
            save(self);
        }
    }
}

int main(int count, char **arguments)
{
    struct component self = {0};
    if (count < 5 || count > 6) {
        fprintf(stderr, "usage: thermal NAME SLEW_UM_S SPEED_UP external|own [STATE]\n");
        return 2;
    }
    self.slew_um_s = atof(arguments[2]);
    self.speed_up = atof(arguments[3]);
    self.external = strcmp(arguments[4], "external") == 0;
    self.state = count == 6 ? arguments[5] : NULL;
    if (!(self.slew_um_s > 0.0 && self.speed_up > 0.0)) {
        fprintf(stderr, "thermal: slew and speed-up must be above 0\n");
        return 2;
    }
    self.compensator = instance_new();
    if (self.compensator == NULL || self.compensator->setup.problem != NULL
        || instance_initialise(self.compensator) != NULL
        || instance_start(self.compensator) != NULL) {
        fprintf(stderr, "thermal: the compensator does not start\n");
        return 1;
    }
    for (size_t i = 0; i < AXES; i++) {
        self.offsets[i] = reference_of(OFFSET_NAMES[i]);
    }
    self.valid = reference_of("valid");
    self.status = reference_of("status");
    if (self.state != NULL) {
        const char *problem = load(&self);
        fprintf(stderr, "thermal: %s: %s\n", self.state, problem == NULL ? "taken up" : problem);
    }
    signal(SIGTERM, stop);
    signal(SIGINT, stop);
    int id = hal_init(arguments[1]);
    size_t size = sizeof *self.pins + model_variable_count * sizeof(hal_float_t *);
    self.pins = id < 0 ? NULL : hal_malloc((long)size);
    if (self.pins == NULL) {
        fprintf(stderr, "thermal: no component %s\n", arguments[1]);
        return 1;
    }
    memset(self.pins, 0, size);
    if (!make_pins(self.pins, id, arguments[1])) {
        hal_exit(id);
        return 1;
    }
    hal_ready(id);
    run(&self);
    hal_exit(id);
    instance_free(self.compensator);
    return 0;
}
