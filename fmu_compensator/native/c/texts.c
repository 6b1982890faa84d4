#include "texts.h"

#include <stdio.h>
#include <string.h>

#include "constants.h"

static void add(char *text, size_t size, const char *words)
{
    size_t used = strlen(text);
    if (used + 1 < size) {
        strncat(text, words, size - used - 1);
    }
}

/* Adds a number with a point, whatever the host's locale puts there. */
static void add_number(char *text, size_t size, const char *form, double value)
{
    char written[TEXT_LENGTH], plain[TEXT_LENGTH];
    size_t used = 0;
    /* The forms below are constants of this file. */
    snprintf(written, sizeof written, form, value);
    for (const char *c = written; *c != '\0'; c++) {
        if ((*c >= '0' && *c <= '9') || *c == '+' || *c == '-' || (*c >= 'a' && *c <= 'z')) {
            plain[used++] = *c;
        } else if (used > 0 && plain[used - 1] != '.') {
            plain[used++] = '.';
        }
    }
    plain[used] = '\0';
    add(text, size, plain);
}

static void add_reading(char *text, size_t size, const struct sensor *sensor, double value)
{
    add(text, size, sensor->name);
    add(text, size, " ");
    add_number(text, size, "%.1f", value);
}

static void add_new(char *text, size_t size, const struct reason *reason)
{
    const double others[] = {reason->extent, reason->allowed};
    add(text, size, "conditions outside training make ");
    add_number(text, size, "%.0f", reason->value);
    add(text, size, " % of the uncertainty: ");
    add(text, size, model_sensors[reason->sensor - 1].name);
    for (size_t i = 0; i < 2 && others[i] != 0.0; i++) {
        add(text, size, ", ");
        add(text, size, model_sensors[(size_t)others[i] - 1].name);
    }
}

static void add_tool_fault(char *text, size_t size, const struct reason *reason)
{
    if (reason->cause == CHECKS_MISSING) {
        add(text, size, "tool_length is missing");
        return;
    }
    add(text, size, "tool_length ");
    add_number(text, size, "%g", reason->value);
    add(text, size, " mm is not in ");
    add_number(text, size, "%g", model_limits.tool_length_mm[0]);
    add(text, size, " to ");
    add_number(text, size, "%g", model_limits.tool_length_mm[1]);
    add(text, size, " mm");
}

static void add_sensor_fault(char *text, size_t size, const struct reason *reason)
{
    const struct sensor *sensor = &model_sensors[reason->sensor - 1];
    if (reason->cause == CHECKS_MISSING) {
        add(text, size, sensor->name);
        add(text, size, " is missing");
        return;
    }
    add_reading(text, size, sensor, reason->value);
    if (reason->cause == CHECKS_IMPLAUSIBLE) {
        bool below = reason->value < sensor->low;
        add(text, size, below ? " degC is below " : " degC is above ");
        add_number(text, size, "%g", below ? sensor->low : sensor->high);
        add(text, size, " degC");
    } else if (reason->cause == CHECKS_TOO_FAST) {
        add(text, size, " degC jumped by ");
        add_number(text, size, "%.1f", reason->extent);
        add(text, size, " K, ");
        add_number(text, size, "%.2g", reason->allowed);
        add(text, size, " K allowed");
    } else {
        add(text, size, " degC is unchanged for ");
        add_number(text, size, "%.0f", reason->extent);
        add(text, size, " s, ");
        add_number(text, size, "%g", sensor->stale_after_s);
        add(text, size, " s allowed");
    }
}

void status_text(const struct output *output, char *text, size_t size)
{
    const struct reason *reason = &output->reason;
    int32_t status = output->status;
    text[0] = '\0';
    if (status == COMPENSATOR_UNTRAINED) {
        add_new(text, size, reason);
        return;
    }
    status = status < COMPENSATOR_HOLDING ? status : status - status % 10;
    for (size_t i = 0; i < model_status_text_count; i++) {
        if (model_status_texts[i].status == status) {
            add(text, size, model_status_texts[i].text);
        }
    }
    if (reason->cause != 0) {
        add(text, size, ": ");
        if (reason->sensor == 0) {
            add_tool_fault(text, size, reason);
        } else {
            add_sensor_fault(text, size, reason);
        }
    }
    for (size_t i = 0; i < GAUSSIAN_NAMED && output->also_without[i] != 0; i++) {
        add(text, size, i == 0 ? "; and without " : ", ");
        add(text, size, model_sensors[output->also_without[i] - 1].name);
    }
}
