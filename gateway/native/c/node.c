/* The compensator as a node of a CAN bus: the twin of gateway.node, by the machine's clock. */
#include <math.h>
#include <string.h>

#include "instance.h"
#include "model_data.h"
#include "reception.h"

#define TRANSMIT 0x10u
#define CONFIGURATION 0x40u
#define FORMAT_ERROR 0x01u
#define HEAD 8u           /* bytes of code and length at the beginning of each operation */
#define TRANSMIT_HEAD 16u /* all bytes before a frame's data */
#define CAN_BAUDRATE 1u
#define CHALLENGES 8u /* more than are drawn while one stays valid */
#define SMALL_GAP_S 1e-6

struct node {
    struct terminal terminal;
    struct watch watches[MACHINE_FRAMES];
    struct { double at_s; uint32_t value; } challenges[CHALLENGES];
    uint32_t drawn, issued;
    double start_s, deadline_s, stepped_s, unit_s, covered_s, expected, raw_time;
    double cold_s, tool_length;
    double followed[AXES]; /* the offsets when they last followed the model */
    int32_t begun, stepped, late_start, state, waiting, proven;
    struct finding finding;
    uint32_t counts[COMPENSATOR_FRAMES], heard; /* cycles sent, and cycles received as signals */
};

static struct node *node_of(struct instance *self)
{
    return (struct node *)(void *)self->terminal;
}

static void put(struct terminal *terminal, uint64_t value, unsigned bytes)
{
    for (unsigned i = 0; i < bytes; i++) {
        terminal->tx[terminal->tx_size++] = (unsigned char)(value >> 8 * i);
    }
}

/* Begins an operation; returns whether there is room for it. */
static bool begin(struct terminal *terminal, unsigned code, uint32_t size)
{
    bool fits = terminal->tx_size + size <= BUS_BYTES;
    if (fits) {
        put(terminal, code, 4);
        put(terminal, size, 4);
    }
    return fits;
}

static void due(struct node *node, double time_s)
{
    node->terminal.due_s = time_s;
    node->terminal.announced = 0;
}

static void reset(struct terminal *terminal)
{
    struct node *node = (struct node *)(void *)terminal;
    node->drawn = 1;
    node->covered_s = node->expected = node->tool_length = NAN;
    node->cold_s = terminal->due_s = INFINITY;
    node->state = STATE_STARTING;
}

static void start(struct instance *self)
{
    struct node *node = node_of(self);
    node->start_s = node->deadline_s = self->memory->time_s;
    if (!SIGNALS && begin(&node->terminal, CONFIGURATION, HEAD + 5)) {
        put(&node->terminal, CAN_BAUDRATE, 1);
        put(&node->terminal, BIT_RATE, 4);
    }
    due(node, node->start_s + FRAME_S);
}

static double output_of(struct instance *self, size_t ref)
{
    double real = NAN;
    int32_t whole = 0;
    if (ref == NONE) {
        return NAN;
    }
    if (model_variables[ref].kind == REAL) {
        instance_get_real(self, REAL, ref, &real);
        return real;
    }
    instance_get_whole(self, model_variables[ref].kind, ref, &whole);
    return whole;
}

/* Draws a new challenge; the sequence is the same in every run. */
static uint32_t draw(struct node *node)
{
    do {
        node->drawn = node->drawn * 1664525u + 1013904223u;
    } while ((node->drawn & 0xFFFFu) > LARGEST_ECHO);
    return node->drawn;
}

/* Adds counts and check value to a frame. */
static void seal(unsigned char data[FRAME_BYTES], const struct frame *frame, uint32_t count)
{
    put_bits(data, FRAME_BYTES, count % COUNTERS);
    put_bits(data, frame->cycle_start, count % (1u << frame->cycle_bits));
    data[0] = check_of(data, frame->data_id);
}

/* Writes a frame's signals to their variables, as a receiver reads them. */
static void show(
    struct instance *self, const struct frame *frame, const unsigned char data[FRAME_BYTES])
{
    double *values = &self->values[frame->first], *last = values + frame->signal_count;
    for (size_t i = 0; i < frame->signal_count; i++) {
        value_of(&frame->signals[i], data, &values[i]);
    }
    last[0] = data[0];
    last[1] = (double)bits_at(data, FRAME_BYTES, COUNTER_BITS);
    last[2] = (double)bits_at(data, frame->cycle_start, frame->cycle_bits);
}

static void send_frames(struct node *node, struct instance *self, const double told[])
{
    for (size_t place = 0; place < COMPENSATOR_FRAMES; place++) {
        const struct frame *frame = &compensator_frames[place];
        unsigned char data[FRAME_BYTES] = {0};
        for (size_t i = 0; i < frame->signal_count; i++) {
            const struct signal *signal = &frame->signals[i];
            double value = signal->role < 0 ? output_of(self, signal->ref) : told[signal->role];
            put_bits(data, signal->start, raw_of(signal, value));
        }
        uint32_t count = node->counts[place], cycles = 1u << frame->cycle_bits;
        node->counts[place] = (count + 1) % (COUNTERS * cycles);
        seal(data, frame, count);
        if (SIGNALS) {
            show(self, frame, data);
        } else if (begin(&node->terminal, TRANSMIT, TRANSMIT_HEAD + FRAME_BYTES)) {
            put(&node->terminal, frame->id, 4);
            put(&node->terminal, 0, 2); /* a standard identifier, not a remote frame */
            put(&node->terminal, FRAME_BYTES, 2);
            for (unsigned i = 0; i < FRAME_BYTES; i++) {
                put(&node->terminal, data[i], 1);
            }
        }
    }
    node->waiting = 1;
}

static void answer(struct instance *self, struct finding finding, bool usable, bool ready)
{
    struct node *node = node_of(self);
    double told[ROLES], now_s = self->memory->time_s;
    bool follows = output_of(self, valid_ref) != 0.0, known = node->begun;
    bool valid = usable && known && follows;
    for (size_t i = 0; i < offset_count; i++) {
        double offset = output_of(self, offset_signals[i].ref);
        valid = valid && offset_signals[i].low <= offset && offset <= offset_signals[i].high;
    }
    if (finding.fault != FAULT_NONE || valid || (usable && !known)) {
        node->finding = finding;
    }
    if (node->begun || usable) {
        node->state = usable ? STATE_RUNNING : STATE_FAULT;
    } else if (!ready) {
        node->state = node->late_start ? STATE_STARTUP_TIMEOUT : STATE_STARTING;
    }
    uint32_t challenge = draw(node), place = node->issued++ % CHALLENGES;
    node->challenges[place].at_s = now_s;
    node->challenges[place].value = challenge;
    told[ROLE_VALID] = valid ? VALID_VALID : VALID_INVALID;
    told[ROLE_GATEWAY_STATE] = state_codes[node->state];
    told[ROLE_STATUS] = usable && !known ? STATUS_REFERENCE_UNKNOWN
                                         : status_codes[(size_t)output_of(self, status_ref)];
    told[ROLE_BUS_FAULT] = fault_codes[node->finding.fault];
    told[ROLE_BUS_FAULT_FRAME] = node->finding.fault != FAULT_NONE ? node->finding.id & 0xFFu : 0.0;
    told[ROLE_ANSWERED_TIME] = fmod(node->raw_time, ANSWERED_COUNT) * TIME_SCALE;
    told[ROLE_CHALLENGE] = challenge;
    told[ROLE_FRESHNESS] = node->proven && usable ? FRESHNESS_PROVEN : FRESHNESS_NOT_PROVEN;
    told[ROLE_PROBES_TAKEN] = 0.0;
    for (size_t axis = 0; axis < AXES; axis++) {
        double width = known ? output_of(self, axes[axis].uncertainty) : NAN;
        told[ROLE_UNCERTAINTY + axis] = width >= 0.0 ? width : NAN;
        double tilt = axis == AXES - 1 ? 0.0 : output_of(self, axes[axis].tilt);
        /* While the offset is ramped to zero or back, so is its slope. */
        double offset = output_of(self, axes[axis].offset), left = 0.0;
        if (follows) {
            node->followed[axis] = offset;
        }
        if (node->followed[axis] != 0.0) {
            left = fmin(fmax(offset / node->followed[axis], 0.0), 1.0);
        }
        told[ROLE_SLOPE + axis] = 0.0 - model_limits.share * (follows ? 1.0 : left) * tilt;
    }
    told[ROLE_TOOL_LENGTH] = node->tool_length;
    send_frames(node, self, told);
    due(node, now_s + FRAME_S);
}

/* Steps the compensator; NULL: every input is missing. */
static const char *step(struct instance *self, const double *heard, double step_s)
{
    struct node *node = node_of(self);
    const char *problem = NULL;
    node->stepped_s = self->memory->time_s, node->stepped = 1;
    if (!(step_s > 0.0)) {
        return NULL;
    }
    for (size_t i = 0; i < HEARD; i++) {
        if (machine_signals[i].ref != NONE) {
            self->values[machine_signals[i].ref] = heard == NULL ? NAN : heard[i];
        }
    }
    problem = model_step(
        self->model, self->content, self->values, node->unit_s, step_s, self->problem);
    node->unit_s += step_s;
    if (heard != NULL && !isnan(heard[HEARD_TOOL_LENGTH])) {
        node->tool_length = heard[HEARD_TOOL_LENGTH];
    }
    return problem;
}

static double own_step(const struct instance *self, const struct node *node)
{
    return node->stepped ? self->memory->time_s - node->stepped_s : CYCLE_S;
}

/* Steps over a cycle; a gap before it counts as time without inputs. */
static const char *advance(struct instance *self, const double *heard, const double *beat)
{
    struct node *node = node_of(self);
    double begins_s = beat[HEARD_MACHINE_TIME], step_s = beat[HEARD_MACHINE_STEP], unseen_s = 0.0;
    const char *problem = NULL;
    if (isnan(begins_s + step_s)) {
        return step(self, heard, own_step(self, node));
    }
    unseen_s = isnan(node->covered_s) ? 0.0 : begins_s - node->covered_s;
    node->covered_s = begins_s + step_s;
    if (unseen_s > SMALL_GAP_S) {
        /* In two steps, because a single missing sample could be a slip. */
        double last_s = fmin(unseen_s, CYCLE_S);
        problem = step(self, NULL, unseen_s - last_s);
        problem = problem != NULL ? problem : step(self, NULL, last_s);
    }
    return problem != NULL ? problem : step(self, heard, step_s);
}

/* Returns whether a cycle was made after a recent challenge. */
static bool proves(const struct node *node, const struct cycle *cycle, double now_s)
{
    for (uint32_t i = 0; i < CHALLENGES && i < node->issued; i++) {
        uint32_t challenge = node->challenges[i].value, crc = 0;
        unsigned char bytes[4];
        if (now_s - node->challenges[i].at_s > TIMEOUT_S + CYCLE_S
            || cycle->heartbeat[HEARD_ECHO] != (double)(challenge & 0xFFFFu)) {
            continue;
        }
        for (unsigned byte = 0; byte < 4; byte++) {
            bytes[byte] = (unsigned char)(challenge >> 8 * byte);
        }
        crc = crc32_of(0, bytes, sizeof bytes);
        for (int place = 0; place < MACHINE_FRAMES; place++) {
            if (place != PROOF_FRAME && cycle->came[place]) {
                crc = crc32_of(crc, node->watches[place].data, FRAME_BYTES);
            }
        }
        if (cycle->heartbeat[HEARD_PROOF] == (double)crc) {
            return true;
        }
    }
    return false;
}

/* Compares the machine's time with the one that the previous cycle announced. */
static int32_t time_fault(struct node *node, const double *beat, bool running)
{
    double time_s = beat[HEARD_MACHINE_TIME], step_s = beat[HEARD_MACHINE_STEP];
    double raw = nearbyint(time_s / TIME_SCALE), expected = node->expected;
    if (isnan(time_s + step_s)) {
        node->expected = NAN;
        return FAULT_NOT_AVAILABLE_VALUE;
    }
    node->expected = fmod(raw + nearbyint(step_s / TIME_SCALE), TIME_COUNT);
    if (running && step_s <= 0.0) {
        return FAULT_TIME_STANDS;
    }
    return isnan(expected) || raw == expected ? FAULT_NONE : FAULT_TIME_JUMP;
}

static const char *on_cycle(struct instance *self)
{
    struct node *node = node_of(self);
    struct cycle cycle;
    reception_look(node->watches, false, &cycle);
    const double *beat = cycle.heartbeat;
    double now_s = self->memory->time_s;
    bool running = beat[HEARD_MACHINE_STATE] == MACHINE_RUNNING, usable = cycle.usable && running;
    int32_t wrong = FAULT_NONE;
    struct finding finding = cycle.finding;
    uint32_t closing = machine_frames[MACHINE_FRAMES - 1].id;
    const char *problem = NULL;
    bool needs_proof = PROOF_FRAME >= 0;
    node->proven = needs_proof && cycle.came[needs_proof ? PROOF_FRAME : 0]
                   && proves(node, &cycle, now_s);
    if (!isnan(beat[HEARD_MACHINE_TIME])) {
        node->raw_time = nearbyint(beat[HEARD_MACHINE_TIME] / TIME_SCALE);
    }
    if (node->proven || !needs_proof) {
        wrong = time_fault(node, beat, running);
    }
    if (cycle.usable && needs_proof && !node->proven) {
        usable = false;
        finding = (struct finding){FAULT_NOT_FRESH, machine_frames[needs_proof ? PROOF_FRAME : 0].id};
    } else if (cycle.usable && wrong != FAULT_NONE && running) {
        usable = false;
        finding = (struct finding){wrong, closing};
    } else if (
        cycle.usable && !running
        && (!isnan(beat[HEARD_MACHINE_STATE]) || finding.fault == FAULT_NONE)) {
        finding = (struct finding){FAULT_MACHINE_NOT_RUNNING, closing};
    }
    if (node->proven) {
        reception_renew(node->watches);
    }
    if (!node->begun && (usable || finding.fault == FAULT_MACHINE_NOT_RUNNING)) {
        bool cold = cycle.values[HEARD_THERMAL_STATE] == THERMAL_COLD;
        node->cold_s = cold ? 0.0 : node->cold_s + cycle.values[HEARD_MACHINE_STEP];
    }
    if (node->begun || (usable && node->cold_s <= COLD_FOR_S)) {
        node->begun = 1;
        problem = advance(self, usable ? cycle.values : NULL, beat);
    } else if (cycle.usable && !usable) {
        node->state = STATE_READY, node->late_start = 0;
    }
    answer(self, finding, usable, cycle.usable);
    node->deadline_s = now_s + TIMEOUT_S;
    return problem;
}

/* Handles that nothing came in time. */
static const char *silence(struct instance *self)
{
    struct node *node = node_of(self);
    struct cycle cycle;
    double now_s = self->memory->time_s, step_s = own_step(self, node);
    const char *problem = NULL;
    reception_look(node->watches, true, &cycle);
    node->expected = NAN;
    if (node->begun) {
        node->covered_s += step_s;
        problem = step(self, NULL, step_s);
    } else if (now_s - node->start_s > STARTUP_S) {
        uint32_t closing = machine_frames[MACHINE_FRAMES - 1].id;
        cycle.finding = (struct finding){FAULT_STARTUP_TIMEOUT, closing};
        node->late_start = 1;
    }
    answer(self, cycle.finding, false, false);
    node->deadline_s = now_s + CYCLE_S;
    return problem;
}

static const char *tick(struct instance *self)
{
    return node_of(self)->waiting ? NULL : silence(self);
}

static void sent(struct instance *self)
{
    struct node *node = node_of(self);
    node->waiting = 0;
    due(node, fmax(node->deadline_s, self->memory->time_s + FRAME_S));
}

#if SIGNALS
/* Makes frames from the signals whose clocks tick. Signals cannot be damaged on the way, so the
   frames' protection is added here, with the number of closed cycles as count. */
static const char *receive(struct instance *self)
{
    struct node *node = node_of(self);
    const char *problem = NULL;
    for (size_t place = 0; place < MACHINE_FRAMES && problem == NULL; place++) {
        const struct frame *frame = &machine_frames[place];
        unsigned char data[FRAME_BYTES] = {0};
        if (!(node->terminal.rx_active >> place & 1u)) {
            continue;
        }
        for (size_t i = 0; i < frame->signal_count; i++) {
            const struct signal *signal = &frame->signals[i];
            put_bits(data, signal->start, raw_of(signal, self->values[frame->first + i]));
        }
        seal(data, frame, node->heard);
        if (reception_take(node->watches, frame->id, data, FRAME_BYTES, self->memory->time_s)) {
            problem = on_cycle(self);
        }
    }
    if (node->terminal.rx_active >> (MACHINE_FRAMES - 1) & 1u) {
        node->heard = (node->heard + 1) % (COUNTERS << 16);
    }
    return problem;
}
#else
static uint32_t number_at(const unsigned char *bytes, unsigned count)
{
    uint32_t number = 0;
    for (unsigned i = 0; i < count; i++) {
        number |= (uint32_t)bytes[i] << 8 * i;
    }
    return number;
}

/* The CAN operations: length of the fixed part, and offset of the variable part's length. */
static const struct { uint32_t code, head, length_at; } operations[] = {
    {FORMAT_ERROR, 10, 8}, {TRANSMIT, TRANSMIT_HEAD, 14},
    {0x11, 17, 15}, {0x12, 22, 20}, /* the frames of CAN FD and CAN XL */
    {0x20, 12, 0},                  /* Confirm */
    {0x30, 12, 0},                  /* Arbitration Lost */
    {0x31, 15, 0},                  /* Bus Error */
    {CONFIGURATION, 13, 0},         /* the bit rate */
    {CONFIGURATION, 10, 0},         /* the behaviour after a lost arbitration */
    {0x41, 9, 0},                   /* Status */
    {0x42, 8, 0},                   /* Wakeup */
};

static bool is_operation(const unsigned char *at, size_t size)
{
    for (size_t i = 0; i < sizeof operations / sizeof *operations; i++) {
        size_t head = operations[i].head, place = operations[i].length_at;
        if (number_at(at, 4) == operations[i].code && size >= head
            && size == head + (place > 0 ? number_at(at + place, 2) : 0)) {
            return true;
        }
    }
    return false;
}

/* Takes frames. Other operations are ignored; anything else is returned as a format error. */
static const char *receive(struct instance *self)
{
    struct node *node = node_of(self);
    const unsigned char *at = node->terminal.rx, *end = at + node->terminal.rx_size;
    const char *problem = NULL;
    while (at < end && problem == NULL) {
        size_t left = (size_t)(end - at), size = left < HEAD ? 0 : number_at(at + 4, 4);
        if (size < HEAD || size > left) {
            size = left; /* the start of the next one is unknown */
        }
        if (size < HEAD || size != number_at(at + 4, 4) || !is_operation(at, size)) {
            if (begin(&node->terminal, FORMAT_ERROR, (uint32_t)(HEAD + 2 + size))) {
                put(&node->terminal, size, 2);
                memcpy(node->terminal.tx + node->terminal.tx_size, at, size);
                node->terminal.tx_size += (uint32_t)size;
            }
        } else if (
            /* A standard identifier, not a remote frame. */
            number_at(at, 4) == TRANSMIT && at[12] == 0 && at[13] == 0
            && reception_take(
                node->watches, number_at(at + 8, 4), at + TRANSMIT_HEAD, size - TRANSMIT_HEAD,
                self->memory->time_s)) {
            problem = on_cycle(self);
        }
        at += size;
    }
    return problem;
}

#endif

static const struct bus bus = {
    sizeof(struct node), SIGNALS, RX_CLOCKS, TX_CLOCKS, reset, start, tick, receive, sent};
const struct bus *const model_bus = &bus;
