/* A terminal of a bus (FMI-LS-BUS) in front of a model. no_bus.c is for a model that has none. */
#ifndef BUS_H
#define BUS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct instance;

/* Its variables; their value references follow that of the time. Rx is what comes in. With signals
   (high cut) there is a clock for each frame and nothing else: the signals are the model's
   variables, RECEIVED and SENT. */
enum port { RX_CLOCK, TX_CLOCK, RX_DATA, TX_DATA, NO_PORT };

#define BUS_BYTES 2048 /* of operations that are passed at once */

/* What the host sees of it; all of this belongs to the FMU's state. */
struct terminal {
    double due_s;       /* when the Tx clocks are to tick, */
    int32_t announced;  /* and whether the host knows */
    int32_t tx_active;  /* the clocks; */
    uint64_t rx_active; /* a bit each */
    uint32_t rx_size, tx_size;
    unsigned char rx[BUS_BYTES], tx[BUS_BYTES];
};

/* What stands behind it. The functions return what is wrong, NULL for nothing. */
struct bus {
    size_t size; /* of what it remembers, which begins with the terminal [bytes] */
    bool signals;
    size_t rx_clocks, tx_clocks; /* how many; the Tx clocks tick together */
    void (*reset)(struct terminal *terminal);
    void (*start)(struct instance *self);          /* the initialisation ends */
    const char *(*tick)(struct instance *self);    /* the Tx clock has ticked */
    const char *(*receive)(struct instance *self); /* operations have come */
    void (*sent)(struct instance *self);           /* what was to be sent is on its way */
};

extern const struct bus *const model_bus; /* NULL: none */

#endif
