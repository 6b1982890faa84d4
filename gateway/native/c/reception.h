/* Checks the machine's frames one by one and assembles cycles: the twin of gateway.reception. */
#ifndef RECEPTION_H
#define RECEPTION_H

#include "frames.h"
#include "node_data.h"

struct finding {
    int32_t fault; /* or FAULT_NONE */
    uint32_t id;   /* the frame's identifier */
};

struct watch {
    int32_t started, astray, missed;
    int32_t heard, out_of_step, fresh;
    uint32_t last, cycle; /* counter of the last frame; cycle count of the newest accepted one */
    uint32_t counter;
    double seen_s;
    unsigned char data[FRAME_BYTES];
    struct finding stray, spoilt;
};

/* The content of one cycle of the machine. */
struct cycle {
    bool usable;
    struct finding finding;
    double values[HEARD];     /* of all signals; NaN if missing */
    double heartbeat[HEARD];  /* the same, even if the cycle is not usable */
    bool came[MACHINE_FRAMES];
};

/* Checks a frame; returns whether it closes a cycle. */
bool reception_take(
    struct watch watches[], uint32_t id, const unsigned char *data, size_t size, double now_s);
void reception_look(struct watch watches[], bool silent, struct cycle *cycle);
/* Trusts the frames that are in step with the closing one again. */
void reception_renew(struct watch watches[]);

#endif
