/* The status texts. */
#include "compensator.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Appends text as printf does; the format is a constant of this file. */
static void add(char *text, size_t size, const char *form, ...)
{
    size_t used = strlen(text);
    va_list values;
    va_start(values, form);
    vsnprintf(text + used, size - used, form, values);
    va_end(values);
}

/* Puts a point between two digits, whatever the host's locale uses. */
static void with_points(char *text)
{
    static const char digits[] = "0123456789";
    static const char plain[]
        = "0123456789 +-_abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";
    for (char *at = strpbrk(text, digits); at != NULL; at = strpbrk(at + 1, digits)) {
        size_t odd = strcspn(at + 1, plain);
        if (odd > 0 && at[1 + odd] != '\0' && strchr(digits, at[1 + odd]) != NULL) {
            at[1] = '.';
            memmove(at + 2, at + 1 + odd, strlen(at + 1 + odd) + 1);
        }
    }
}

/* Returns the name of a sensor, or of another input that may be to blame. */
static const char *name_of(int32_t number)
{
    if (number == 0) {
        return "tool_length";
    }
    return number == SPEED_NUMBER ? "speed" : model_sensors[number - 1].name;
}

static void add_fault(char *text, size_t size, const struct reason *reason)
{
    bool of_sensor = reason->sensor != 0 && reason->sensor != SPEED_NUMBER;
    const struct sensor *sensor = &model_sensors[of_sensor ? reason->sensor - 1 : 0];
    const double *tool = model_limits.tool_length_mm;
    double value = reason->value;
    if (reason->cause == CHECKS_MISSING) {
        add(text, size, ": %s is missing", name_of(reason->sensor));
    } else if (!of_sensor) {
        add(text, size, ": tool_length %g mm is not in %g to %g mm", value, tool[0], tool[1]);
    } else if (reason->cause == CHECKS_IMPLAUSIBLE) {
        bool below = value < sensor->low;
        add(text, size, ": %s %.1f degC is %s %g degC", sensor->name, value,
            below ? "below" : "above", below ? sensor->low : sensor->high);
    } else if (reason->cause == CHECKS_TOO_FAST) {
        add(text, size, ": %s %.1f degC jumped by %.1f K, %.2g K allowed", sensor->name, value,
            reason->extent, reason->allowed);
    } else {
        add(text, size, ": %s %.1f degC is unchanged for %.0f s, %g s allowed", sensor->name, value,
            reason->extent, sensor->stale_after_s);
    }
}

void status_text(const struct output *output, char *text, size_t size)
{
    const struct reason *reason = &output->reason;
    int32_t status = output->status;
    text[0] = '\0';
    status = status < COMPENSATOR_HOLDING ? status : status - status % 10;
    for (const struct status_text *one = model_status_texts; one->text != NULL; one++) {
        if (one->status == status && status != COMPENSATOR_UNTRAINED) {
            add(text, size, "%s", one->text);
        }
    }
    if (status == COMPENSATOR_UNTRAINED) {
        add(text, size, "conditions outside training make %.0f %% of the uncertainty: %s",
            reason->value, name_of(reason->sensor));
    } else if (reason->cause != 0) {
        add_fault(text, size, reason);
    }
    for (size_t i = 0; i < GAUSSIAN_NAMED && output->others[i] != 0; i++) {
        bool first = i == 0 && status == COMPENSATOR_SPARED;
        add(text, size, "%s%s", first ? "; and without " : ", ", name_of(output->others[i]));
    }
    for (size_t axis = 0; axis < 3; axis++) {
        if (output->valid && fabs(output->offset[axis]) == model_limits.offset_um) {
            double limit = model_limits.offset_um;
            add(text, size, "; d%c is at its limit of %g um", "XYZ"[axis], limit);
        }
    }
    with_points(text);
}
