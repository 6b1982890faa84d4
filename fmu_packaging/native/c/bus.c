/* The bus terminal: binary data in both directions, with a clock for each. */
#include "bus.h"

#include <math.h>
#include <string.h>

#include "instance.h"

static const char *const TICKS_ITSELF = "the FMU ticks this clock itself";

/* Returns why a port, which must be one of two, cannot be used now; NULL if it can. */
static const char *refusal(
    const struct instance *self, enum port port, enum port either, enum port other, int32_t first)
{
    if (self->terminal == NULL || (port != either && port != other)) {
        return "there is no such variable of this type";
    }
    if (!self->events) {
        return "this instance was made without event mode";
    }
    return self->memory->phase < first || self->memory->phase == TERMINATED
               ? "the FMU is not in event mode"
               : NULL;
}

const char *instance_enter_step(struct instance *self)
{
    if (!self->events || self->memory->phase != EVENTS) {
        return "the FMU is not in event mode";
    }
    self->memory->phase = STEPPING;
    return NULL;
}

const char *instance_get_port(
    struct instance *self, enum port port, const unsigned char **bytes, size_t *size)
{
    const char *problem = refusal(self, port, RX_DATA, TX_DATA, INSTANTIATED);
    if (problem == NULL) {
        struct terminal *terminal = self->terminal;
        *bytes = port == RX_DATA ? terminal->rx : terminal->tx;
        *size = port == RX_DATA ? terminal->rx_size
                                : terminal->tx_active ? terminal->tx_size : 0;
    }
    return problem;
}

const char *instance_set_port(
    struct instance *self, enum port port, const unsigned char *bytes, size_t size)
{
    const char *problem = refusal(self, port, RX_DATA, RX_DATA, INSTANTIATED);
    if (problem == NULL && size > BUS_BYTES) {
        problem = "these are more bytes than the variable takes";
    }
    if (problem == NULL) {
        if (size > 0) {
            memcpy(self->terminal->rx, bytes, size);
        }
        self->terminal->rx_size = (uint32_t)size;
    }
    return problem;
}

const char *instance_get_clock(
    struct instance *self, enum port port, size_t frame, bool *active)
{
    const char *problem = refusal(self, port, RX_CLOCK, TX_CLOCK, INITIALISING);
    if (problem == NULL) {
        *active = port == RX_CLOCK ? self->terminal->rx_active >> frame & 1u
                                   : (uint64_t)self->terminal->tx_active;
    }
    return problem;
}

const char *instance_set_clock(struct instance *self, enum port port, size_t frame, bool active)
{
    const char *problem = refusal(self, port, RX_CLOCK, TX_CLOCK, EVENTS);
    uint64_t bit = (uint64_t)1 << frame;
    if (problem == NULL && port == RX_CLOCK) {
        self->terminal->rx_active &= ~bit;
        self->terminal->rx_active |= active ? bit : 0;
    } else if (problem == NULL && model_bus->signals) {
        problem = TICKS_ITSELF;
    } else if (problem == NULL && self->terminal->tx_active != (int32_t)active) {
        self->terminal->tx_active = active;
        problem = active ? model_bus->tick(self) : NULL;
    }
    return problem;
}

const char *instance_interval(
    struct instance *self, enum port port, double *interval_s, bool *changed)
{
    const char *problem = refusal(self, port, TX_CLOCK, TX_CLOCK, INITIALISING);
    if (problem == NULL && model_bus->signals) {
        problem = TICKS_ITSELF;
    }
    if (problem == NULL) {
        *interval_s = self->terminal->due_s - self->memory->time_s;
        *changed = !self->terminal->announced && isfinite(*interval_s);
        self->terminal->announced |= *changed;
    }
    return problem;
}

bool instance_next_event(const struct instance *self, double *time_s)
{
    bool known = self->events && model_bus->signals && isfinite(self->terminal->due_s);
    *time_s = known ? self->terminal->due_s : 0.0;
    return known;
}

const char *instance_update(struct instance *self, bool *again)
{
    struct terminal *terminal = self->terminal;
    const char *problem = NULL;
    *again = false;
    if (terminal == NULL) {
        return NULL;
    }
    if (terminal->tx_active) {
        terminal->tx_active = 0;
        terminal->tx_size = 0;
        model_bus->sent(self);
    }
    if (terminal->rx_active) {
        problem = model_bus->receive(self);
        terminal->rx_active = 0;
        terminal->rx_size = 0;
    }
    if (problem == NULL && model_bus->signals && instance_is_due(self, terminal->due_s)) {
        terminal->tx_active = 1;
        *again = true;
        problem = model_bus->tick(self);
    }
    return problem;
}
