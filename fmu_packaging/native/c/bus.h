/* A bus terminal (FMI-LS-BUS) in front of a model. no_bus.c is for a model without one. */
#ifndef BUS_H
#define BUS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct instance;

/* Its variables; their value references follow that of the time. Rx is incoming. With signals (high
   cut) there is only a clock for each frame: the signals are the model's variables RECEIVED and
   SENT. */
enum port { RX_CLOCK, TX_CLOCK, RX_DATA, TX_DATA, NO_PORT };

#define BUS_BYTES 2048 /* of operations passed at once */

/* The host's view of it; all of this is part of the FMU's state. */
struct terminal {
    double due_s;       /* next tick of the Tx clocks */
    int32_t announced;  /* whether the host knows it */
    int32_t tx_active;  /* whether the Tx clocks tick */
    uint64_t rx_active; /* one bit per Rx clock */
    uint32_t rx_size, tx_size;
    unsigned char rx[BUS_BYTES], tx[BUS_BYTES];
};

/* Its implementation. The functions return an error message, or NULL. */
struct bus {
    size_t size; /* of its state, which begins with the terminal [bytes] */
    bool signals;
    size_t rx_clocks, tx_clocks; /* number; the Tx clocks tick together */
    void (*reset)(struct terminal *terminal);
    void (*start)(struct instance *self);          /* the initialisation ends */
    const char *(*tick)(struct instance *self);    /* the Tx clock has ticked */
    const char *(*receive)(struct instance *self); /* operations have come */
    void (*sent)(struct instance *self);           /* the outgoing data has been taken */
};

extern const struct bus *const model_bus; /* NULL: none */

#endif
