/* What arrives from the machine, judged frame by frame and put together: gateway.reception. */
#ifndef RECEPTION_H
#define RECEPTION_H

#include "frames.h"
#include "node_data.h"

struct finding {
    int32_t fault; /* FAULT_NONE: nothing is wrong */
    uint32_t id;   /* of the frame */
};

struct watch {
    int32_t started, astray, missed;
    int32_t heard, out_of_step, fresh;
    uint32_t last, cycle; /* counts: of the frame that came last; of the newest that was taken */
    uint32_t counter;
    double seen_s;
    unsigned char data[FRAME_BYTES];
    struct finding stray, spoilt;
};

/* What one cycle of the machine brought. */
struct cycle {
    bool usable;
    struct finding finding;
    double values[HEARD];     /* of all signals; NaN where there is none */
    double heartbeat[HEARD];  /* the same, also of a cycle that is not usable */
    bool came[MACHINE_FRAMES];
};

/* Judges a frame; returns whether it closes a cycle. */
bool reception_take(
    struct watch watches[], uint32_t id, const unsigned char *data, size_t size, double now_s);
void reception_look(struct watch watches[], bool silent, struct cycle *cycle);
/* Trusts again the frames that keep step with the closing one. */
void reception_renew(struct watch watches[]);

#endif
