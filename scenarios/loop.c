/* The loop of scenarios/cosimulation.py in C: the same calls in the same order, on the same memory.
   What needs Python, a change of the status and a failure, ends a call; another one goes on. */
#include <stddef.h>
#include <stdint.h>

#include "fmi2FunctionTypes.h"

#if defined(_WIN32)
#define SHOWN __declspec(dllexport)
#else
#define SHOWN __attribute__((visibility("default")))
#endif

#define NONE SIZE_MAX

/* Some variables of one type, moved together. */
struct reals {
    const fmi2ValueReference *refs;
    size_t count;
    fmi2Real *values;
};

struct wholes {
    const fmi2ValueReference *refs;
    size_t count;
    fmi2Integer *values;
};

struct fmu {
    fmi2Component component; /* NULL: there is none */
    fmi2DoStepTYPE *step;
    fmi2SetRealTYPE *set;
    fmi2GetRealTYPE *get;
    fmi2GetIntegerTYPE *get_integer;
    fmi2GetBooleanTYPE *get_boolean;
};

/* As in scenarios/faults.py. */
enum act { NOTHING, ADD, REPLACE, HOLD };

struct fault {
    size_t place;         /* of the reading among the compensator's inputs */
    const int8_t *acts;   /* by point */
    const double *values; /* by point: what is added, or what takes its place */
    double held;
    int32_t holds;
};

enum outcome { REACHED, CHANGED, FAILED };

/* Which call failed. */
enum call { PLANT_IN, PLANT_OUT, PLANT_STEP, SEEN_IN, SENT, CODES, FLAGS, COMPENSATOR_STEP };

struct loop {
    size_t steps, k; /* the point that has been reached, from 0 to steps */
    double step_s;
    const double *time_s;
    struct fmu plant, compensator;
    struct reals plant_in, plant_out, seen_in, sent;
    struct wholes codes, flags;
    size_t driven, told, measured, offsets, faults;
    const double *plant_rows, *seen_rows; /* the signals, by point */
    const size_t *take;                   /* of the plant's outputs, what the compensator sees */
    const size_t *give;                   /* of the compensator's outputs, the offsets */
    struct fault *fault;
    double *plant_table, *seen_table, *sent_table, *code_table; /* to be filled, by point */
    size_t status, sensor;                                      /* places among the codes; NONE */
    int32_t noted, last_status, last_sensor;                    /* of the newest change */
    int32_t call, said;                                         /* what failed, and its status */
};

SHOWN const size_t loop_size = sizeof(struct loop);

/* Notes a call that failed; returns whether it did. */
static int failed(struct loop *self, enum call call, fmi2Status said)
{
    if (said > fmi2Warning) {
        self->call = call;
        self->said = (int32_t)said;
        return 1;
    }
    return 0;
}

static void copy(double *to, const double *from, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        to[i] = from[i];
    }
}

static int set(struct loop *self, const struct fmu *fmu, const struct reals *port, enum call call)
{
    if (port->count == 0) {
        return 0;
    }
    return failed(self, call, fmu->set(fmu->component, port->refs, port->count, port->values));
}

static int get(struct loop *self, const struct fmu *fmu, const struct reals *port, enum call call)
{
    if (port->count == 0) {
        return 0;
    }
    return failed(self, call, fmu->get(fmu->component, port->refs, port->count, port->values));
}

static int32_t code_of(const struct loop *self, size_t place)
{
    return place == NONE ? 0 : (int32_t)self->codes.values[place];
}

static int changed(struct loop *self)
{
    int32_t status = code_of(self, self->status), sensor = code_of(self, self->sensor);
    if (self->noted && status == self->last_status && sensor == self->last_sensor) {
        return 0;
    }
    self->noted = 1;
    self->last_status = status;
    self->last_sensor = sensor;
    return 1;
}

static void disturb(const struct loop *self, struct fault *fault)
{
    double *reading = &self->seen_in.values[fault->place];
    switch ((enum act)fault->acts[self->k]) {
    case NOTHING:
        break;
    case ADD:
        *reading += fault->values[self->k];
        break;
    case REPLACE:
        *reading = fault->values[self->k];
        break;
    case HOLD:
        if (!fault->holds) {
            fault->held = *reading;
            fault->holds = 1;
        }
        *reading = fault->held;
        break;
    }
}

/* Records the compensator at this point and gives it what it sees. */
static int gather_compensator(struct loop *self)
{
    size_t k = self->k, wide = self->codes.count + self->flags.count;
    double *seen = self->seen_in.values, *code = self->code_table + k * wide;
    copy(self->sent_table + k * self->sent.count, self->sent.values, self->sent.count);
    for (size_t i = 0; i < self->codes.count; i++) {
        code[i] = self->codes.values[i];
    }
    for (size_t i = 0; i < self->flags.count; i++) {
        code[self->codes.count + i] = self->flags.values[i];
    }
    for (size_t i = 0; i < self->measured; i++) {
        seen[i] = self->plant_out.values[self->take[i]];
    }
    copy(seen + self->measured, self->seen_rows + k * self->told, self->told);
    for (size_t i = 0; i < self->faults; i++) {
        disturb(self, &self->fault[i]);
    }
    if (set(self, &self->compensator, &self->seen_in, SEEN_IN)) {
        return 1;
    }
    copy(self->seen_table + k * self->seen_in.count, seen, self->seen_in.count);
    for (size_t i = 0; i < self->offsets; i++) {
        self->plant_in.values[self->driven + i] = self->sent.values[self->give[i]];
    }
    return 0;
}

/* Records this point and sets the inputs of the step that begins there. */
static int gather(struct loop *self)
{
    size_t k = self->k, outputs = self->plant_out.count;
    copy(self->plant_table + k * outputs, self->plant_out.values, outputs);
    copy(self->plant_in.values, self->plant_rows + k * self->driven, self->driven);
    if (self->compensator.component != NULL && gather_compensator(self)) {
        return 1;
    }
    return k < self->steps && set(self, &self->plant, &self->plant_in, PLANT_IN);
}

static int step(struct loop *self, const struct fmu *fmu, enum call call)
{
    double now = self->time_s[self->k];
    return failed(self, call, fmu->step(fmu->component, now, self->step_s, fmi2True));
}

static int read_compensator(struct loop *self)
{
    const struct fmu *fmu = &self->compensator;
    const struct wholes *codes = &self->codes, *flags = &self->flags;
    if (get(self, fmu, &self->sent, SENT)) {
        return 1;
    }
    if (codes->count > 0
        && failed(self, CODES,
                  fmu->get_integer(fmu->component, codes->refs, codes->count, codes->values))) {
        return 1;
    }
    return flags->count > 0
           && failed(self, FLAGS,
                     fmu->get_boolean(fmu->component, flags->refs, flags->count, flags->values));
}

/* Goes on until the point *end* has been reached, or, beyond the last, recorded. */
SHOWN int32_t loop_run(struct loop *self, size_t end)
{
    int compensated = self->compensator.component != NULL;
    while (self->k < end) {
        if (compensated && changed(self)) {
            return CHANGED;
        }
        if (gather(self)) {
            return FAILED;
        }
        if (self->k < self->steps
            && ((compensated && step(self, &self->compensator, COMPENSATOR_STEP))
                || step(self, &self->plant, PLANT_STEP)
                || get(self, &self->plant, &self->plant_out, PLANT_OUT)
                || (compensated && read_compensator(self)))) {
            return FAILED;
        }
        self->k++;
    }
    return REACHED;
}
