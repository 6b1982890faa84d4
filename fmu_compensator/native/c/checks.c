#include "checks.h"

#include <math.h>

#include "constants.h"

struct reason sensor_look(
    const struct sensor *sensor, struct sensor_memory *memory, double value, double elapsed_s)
{
    struct reason reason = {0, 0, value, 0.0, 0.0};
    memory->since_good += elapsed_s;
    if (!isfinite(value)) {
        memory->last = NAN;
        reason.cause = CHECKS_MISSING;
        return reason;
    }
    if (value == memory->last) {
        memory->unchanged += elapsed_s;
    } else {
        if (!isnan(memory->last) && memory->moves < CHECKS_ALIVE_AFTER) {
            memory->moves += 1.0;
        }
        memory->last = value;
        memory->unchanged = 0.0;
    }
    double extent = 0.0, allowed = 0.0, span = memory->since_good;
    if (!isnan(memory->jumped_after)) {
        span = fmin(span, fmax(CHECKS_SPAN_S, memory->jumped_after));
    }
    if (!isnan(memory->good)) {
        extent = fabs(value - memory->good);
        allowed = sensor->noise + sensor->rate_per_s * span;
        if (extent > allowed && isnan(memory->jumped_after)) {
            memory->jumped_after = memory->since_good;
        }
    }
    if (!(sensor->low <= value && value <= sensor->high)) {
        reason.cause = CHECKS_IMPLAUSIBLE;
    } else if (extent > allowed) {
        reason.cause = CHECKS_TOO_FAST;
        reason.extent = extent;
        reason.allowed = allowed;
    } else if (memory->moves == CHECKS_ALIVE_AFTER && memory->unchanged > sensor->stale_after_s) {
        /* Without a limit in the file it is NaN, and nothing is greater than NaN. */
        reason.cause = CHECKS_STALE;
        reason.extent = memory->unchanged;
    } else {
        memory->good = value;
        memory->since_good = 0.0;
        memory->jumped_after = NAN;
    }
    return reason;
}
