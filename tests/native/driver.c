/* Drives an instance by lines on standard input, and shows everything it holds after each.

   i VALUE...   set all inputs, in the order of their value references
   d TIME STEP  do a step
   s            carry the state over to a fresh instance, by way of bytes
   r            reset and start again

   After each line: the status, the outputs in the order of their value references, what is
   remembered beside the row of numbers, that row, and the status text; numbers in hexadecimal. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "compensator.h"
#include "instance.h"
#include "model_data.h"

/* The heads of what fmi2.c keeps, and of a model. */
struct seen {
    struct instance *instance;
};
struct model {
    struct compensator compensator;
};

static void logger(
    fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
    fmi2String form, ...)
{
    (void)environment, (void)name, (void)status, (void)category, (void)form;
}

/* Of the address sanitizer; not every compiler's package has the header. */
int __sanitizer_install_malloc_and_free_hooks(
    void (*on_malloc)(const volatile void *, size_t), void (*on_free)(const volatile void *));

/* How often memory was taken or given back: a step must do neither. */
static int takings, returns;

static void on_malloc(const volatile void *pointer, size_t size)
{
    (void)pointer, (void)size;
    takings++;
}

static void on_free(const volatile void *pointer)
{
    (void)pointer;
    returns++;
}

static const fmi2CallbackFunctions host = {logger, NULL, NULL, NULL, NULL};

static void must(fmi2Status status, const char *what)
{
    if (status != fmi2OK) {
        fprintf(stderr, "%s: status %d\n", what, (int)status);
        exit(1);
    }
}

static fmi2Component fresh(void)
{
    fmi2Component c = fmi2Instantiate("driver", fmi2CoSimulation, model_guid, "", &host, 0, 0);
    if (c == NULL) {
        fprintf(stderr, "no instance\n");
        exit(1);
    }
    return c;
}

static fmi2Component started(fmi2Component c)
{
    must(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), "setup");
    must(fmi2EnterInitializationMode(c), "enter");
    must(fmi2ExitInitializationMode(c), "exit");
    return c;
}

static void set_inputs(fmi2Component c, char *rest)
{
    for (fmi2ValueReference ref = 0; ref < model_variable_count; ref++) {
        if (model_variables[ref].causality == INPUT) {
            double value = strtod(rest, &rest);
            int whole = (int)(value != 0.0);
            if (model_variables[ref].kind == REAL) {
                must(fmi2SetReal(c, &ref, 1, &value), "set real");
            } else {
                must(fmi2SetBoolean(c, &ref, 1, &whole), "set boolean");
            }
        }
    }
}

static fmi2Component carried(fmi2Component c)
{
    fmi2FMUstate state = NULL, other = NULL;
    size_t size = 0;
    fmi2Component next = fresh();
    must(fmi2GetFMUstate(c, &state), "get state");
    must(fmi2SerializedFMUstateSize(c, state, &size), "size");
    fmi2Byte *bytes = malloc(size);
    must(fmi2SerializeFMUstate(c, state, bytes, size), "serialise");
    must(fmi2DeSerializeFMUstate(next, bytes, size, &other), "deserialise");
    bytes[size / 2] = (fmi2Byte)(bytes[size / 2] ^ 1);
    fmi2FMUstate damaged = NULL;
    if (fmi2DeSerializeFMUstate(next, bytes, size, &damaged) == fmi2OK) {
        fprintf(stderr, "damaged bytes were taken\n");
        exit(1);
    }
    must(fmi2SetFMUstate(next, other), "set state");
    must(fmi2FreeFMUstate(c, &state), "free state");
    must(fmi2FreeFMUstate(next, &other), "free state");
    free(bytes);
    fmi2FreeInstance(c);
    return next;
}

static void show_numbers(const double *numbers, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        printf(" %a", numbers[i]);
    }
    printf(" |");
}

static void show_outputs(fmi2Component c)
{
    for (fmi2ValueReference ref = 0; ref < model_variable_count; ref++) {
        const struct variable *variable = &model_variables[ref];
        double real = 0.0;
        int whole = 0;
        if (variable->causality == OUTPUT && variable->kind == REAL) {
            must(fmi2GetReal(c, &ref, 1, &real), "get real");
            printf(" %a", real);
        } else if (variable->causality == OUTPUT && variable->kind != STRING) {
            must(variable->kind == INTEGER ? fmi2GetInteger(c, &ref, 1, &whole)
                                           : fmi2GetBoolean(c, &ref, 1, &whole), "get whole");
            printf(" %a", (double)whole);
        }
    }
    printf(" |");
}

static void show_text(fmi2Component c)
{
    for (fmi2ValueReference ref = 0; ref < model_variable_count; ref++) {
        fmi2String text = NULL;
        if (model_variables[ref].kind == STRING && model_variables[ref].causality == OUTPUT) {
            must(fmi2GetString(c, &ref, 1, &text), "get string");
            printf("%s", text);
        }
    }
    printf("\n");
}

static void show(fmi2Component c, fmi2Status status)
{
    const struct instance *instance = ((struct seen *)c)->instance;
    const struct content *content = instance->content;
    printf("%d |", (int)status);
    show_outputs(c);
    size_t count = (instance->model->compensator.size - sizeof *content) / sizeof(double);
    double single[] = {content->last_time,     content->started,     content->recovering,
                       content->fault.cause,   content->fault.sensor, content->spared.cause,
                       content->spared.sensor, content->fault_age,   content->good_for,
                       content->unmodelled,    content->has_measured};
    show_numbers(single, sizeof single / sizeof single[0]);
    show_numbers(content->wanted, 3);
    show_numbers(content->output.offset, 3);
    show_numbers(content->output.pose, 3);
    show_numbers(content->output.half_width, 3);
    show_numbers(content->measured, model_target_count);
    show_numbers(content->targets, model_target_count);
    show_numbers(content->numbers, count);
    show_text(c);
}

int main(void)
{
    static char line[1 << 16];
    __sanitizer_install_malloc_and_free_hooks(on_malloc, on_free);
    fmi2Component c = started(fresh());
    if (takings == 0) {
        fprintf(stderr, "the count of memory taken does not work\n");
        return 1;
    }
    while (fgets(line, sizeof line, stdin) != NULL) {
        fmi2Status status = fmi2OK;
        char *rest = line + 1;
        if (line[0] == 'i') {
            set_inputs(c, rest);
            continue;
        }
        if (line[0] == 'd') {
            double time = strtod(rest, &rest);
            double step = strtod(rest, &rest);
            int before = takings + returns;
            status = fmi2DoStep(c, time, step, fmi2True);
            if (takings + returns != before) {
                fprintf(stderr, "a step took memory\n");
                return 1;
            }
        } else if (line[0] == 's') {
            c = carried(c);
        } else if (line[0] == 'r') {
            must(fmi2Reset(c), "reset");
            started(c);
        }
        show(c, status);
    }
    fmi2FreeInstance(c);
    return 0;
}
