/* A terminal of a bus (FMI-LS-BUS) in front of a model. no_bus.c is for a model that has none. */
#ifndef BUS_H
#define BUS_H

#include <stddef.h>
#include <stdint.h>

struct instance;

/* Its variables; their value references follow that of the time. Rx data are what comes in. */
enum port { RX_DATA, TX_DATA, RX_CLOCK, TX_CLOCK, NOTIFICATIONS, PORTS };

#define BUS_BYTES 2048 /* of operations that are passed at once */

/* What the host sees of it; all of this belongs to the FMU's state. */
struct terminal {
    double due_s;       /* when the Tx clock is to tick, */
    int32_t announced;  /* and whether the host knows */
    int32_t rx_active, tx_active; /* the clocks */
    int32_t notifications;
    uint32_t rx_size, tx_size;
    unsigned char rx[BUS_BYTES], tx[BUS_BYTES];
};

/* What stands behind it. The functions return what is wrong, NULL for nothing. */
struct bus {
    size_t size; /* of what it remembers, which begins with the terminal [bytes] */
    void (*reset)(struct terminal *terminal);
    void (*start)(struct instance *self);          /* the initialisation ends */
    const char *(*tick)(struct instance *self);    /* the Tx clock has ticked */
    const char *(*receive)(struct instance *self); /* operations have come */
    void (*sent)(struct instance *self);           /* what was to be sent is on its way */
};

extern const struct bus *const model_bus; /* NULL: none */

#endif
