#include "reception.h"

#include <math.h>
#include <string.h>

#define CLOSING (MACHINE_FRAMES - 1)

static void note(struct finding *finding, int32_t fault, uint32_t id)
{
    if (finding->fault == FAULT_NONE) {
        *finding = (struct finding){fault, id};
    }
}

/* Checks a frame's counter; returns whether its content is kept. */
static bool in_sequence(struct watch *watch, const struct frame *frame, unsigned counter, double now_s)
{
    unsigned ahead = (counter + COUNTERS - watch->last) % COUNTERS;
    bool expected = (int32_t)ahead <= watch->missed + 1;
    if (counter >= COUNTERS) {
        note(&watch->spoilt, FAULT_OUT_OF_SEQUENCE, frame->id);
        return false;
    }
    if (!watch->started) {
        watch->started = 1, watch->last = counter, watch->seen_s = now_s;
        note(&watch->stray, FAULT_STARTUP, frame->id);
        return false;
    }
    if (ahead == 0 && watch->missed < (int32_t)COUNTERS - 1) {
        note(&watch->spoilt, FAULT_REPEATED, frame->id);
        return false;
    }
    watch->last = counter;
    if (now_s - watch->seen_s > TIMEOUT_S) {
        watch->out_of_step = 0;
        note(&watch->spoilt, FAULT_LATE, frame->id);
        return true;
    }
    if (!expected && ahead > COUNTERS / 2) {
        watch->out_of_step = 1, watch->seen_s = now_s;
        note(&watch->spoilt, FAULT_OUT_OF_SEQUENCE, frame->id);
        return false;
    }
    if (watch->out_of_step) {
        watch->out_of_step = !expected;
        note(&watch->spoilt, FAULT_OUT_OF_SEQUENCE, frame->id);
        return false;
    }
    if (!expected) {
        note(&watch->spoilt, FAULT_MISSING, frame->id);
    }
    return true;
}

bool reception_take(
    struct watch watches[], uint32_t id, const unsigned char *data, size_t size, double now_s)
{
    size_t place = 0;
    while (place < MACHINE_FRAMES && machine_frames[place].id != id) {
        place++;
    }
    if (place == MACHINE_FRAMES) {
        return false;
    }
    const struct frame *frame = &machine_frames[place];
    struct watch *watch = &watches[place];
    if (size != FRAME_BYTES || data[0] != check_of(data, frame->data_id)) {
        note(&watch->stray, size != FRAME_BYTES ? FAULT_WRONG_LENGTH : FAULT_BAD_CRC, id);
        return false;
    }
    unsigned counter = data[1] & 0x0Fu;
    bool taken = in_sequence(watch, frame, counter, now_s);
    watch->heard = 1, watch->missed = 0;
    if (taken) {
        watch->seen_s = now_s, watch->fresh = 1;
        watch->counter = counter;
        watch->cycle = (uint32_t)bits_at(data, frame->cycle_start, frame->cycle_bits);
        memcpy(watch->data, data, FRAME_BYTES);
    }
    return taken && place == CLOSING;
}

/* Compares a frame's counts with those of the closing one. */
static struct finding out_of_step(struct watch *watch, const struct watch *closing, uint32_t id)
{
    int32_t most = (int32_t)(COUNTERS * ((1u << machine_frames[CLOSING].cycle_bits) - 1u));
    bool together = watch->fresh && watch->counter == closing->counter
                    && watch->cycle == closing->cycle;
    if (watch->astray >= most) {
        return (struct finding){FAULT_DELAYED, id};
    }
    watch->astray = together ? 0 : watch->astray + 1;
    return (struct finding){together || !watch->fresh ? FAULT_NONE : FAULT_MIXED_CYCLES, id};
}

/* Reads a frame's values; returns the fault of the first unusable one. */
static int32_t read_values(const struct watch *watch, const struct frame *frame, double *values)
{
    static const int32_t faults[] = {
        FAULT_NONE, FAULT_NOT_AVAILABLE_VALUE, FAULT_ERROR_VALUE, FAULT_OUT_OF_RANGE};
    int32_t first = FAULT_NONE;
    for (size_t i = 0; i < frame->signal_count; i++) {
        int32_t fault = faults[value_of(&frame->signals[i], watch->data, &values[i])];
        first = first == FAULT_NONE ? fault : first;
    }
    return first;
}

void reception_look(struct watch watches[], bool silent, struct cycle *cycle)
{
    struct finding spoilt = {FAULT_NONE, 0}, wrong = {FAULT_NONE, 0};
    const struct watch closing = watches[CLOSING];
    for (size_t i = 0; i < HEARD; i++) {
        cycle->heartbeat[i] = NAN;
    }
    /* In a silence the closing frame comes first: the silence is its absence. */
    for (size_t i = 0; i < MACHINE_FRAMES; i++) {
        size_t place = silent ? CLOSING - i : i;
        struct watch *watch = &watches[place];
        const struct frame *frame = &machine_frames[place];
        struct finding first = {FAULT_NONE, 0}, second = watch->stray;
        if (!silent) {
            first = out_of_step(watch, &closing, frame->id);
        }
        if (watch->spoilt.fault != FAULT_NONE) {
            bool lost = watch->spoilt.fault == FAULT_MISSING && watch->stray.fault != FAULT_NONE;
            first = lost ? watch->stray : watch->spoilt;
        } else if (watch->out_of_step) {
            first = watch->stray;
        }
        cycle->came[place] = watch->fresh;
        if (watch->fresh) {
            double *values = &cycle->heartbeat[frame->signals - machine_signals];
            int32_t fault = read_values(watch, frame, values);
            second = fault == FAULT_NONE ? second : (struct finding){fault, frame->id};
        } else if (first.fault == FAULT_NONE) {
            int32_t fault = watch->started ? FAULT_MISSING : FAULT_STARTUP;
            first = watch->stray.fault != FAULT_NONE ? watch->stray
                                                     : (struct finding){fault, frame->id};
        }
        note(&spoilt, first.fault, first.id);
        note(&wrong, second.fault, second.id);
        watch->missed += !watch->heard;
        watch->fresh = watch->heard = 0;
        watch->stray.fault = watch->spoilt.fault = FAULT_NONE;
    }
    cycle->usable = !silent && spoilt.fault == FAULT_NONE;
    cycle->finding = spoilt.fault != FAULT_NONE ? spoilt : wrong;
    for (size_t i = 0; i < HEARD; i++) {
        cycle->values[i] = cycle->usable ? cycle->heartbeat[i] : NAN;
    }
}

void reception_renew(struct watch watches[])
{
    for (size_t i = 0; i < MACHINE_FRAMES; i++) {
        if (watches[i].counter == watches[CLOSING].counter
            && watches[i].cycle == watches[CLOSING].cycle) {
            watches[i].astray = 0;
        }
    }
}
