/* A host without Python: both FMUs in a loop, as the project's own master couples them.

   loop_host PLANT GUID COMPENSATOR GUID STEPS STEP_S reads from standard input the counts of the
   plant's driven inputs, of the compensator's, of readings, of offsets, of the plant's outputs and of
   the compensator's, then the value references of each row, two rows for readings (the plant's
   outputs, the compensator's inputs) and for offsets (the compensator's outputs, the plant's inputs),
   then the driven values of every point. It prints all outputs at every point in hexadecimal. */
#define _POSIX_C_SOURCE 200809L
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>

#include "fmi2FunctionTypes.h"

#define MOST 200

struct fmu {
    fmi2InstantiateTYPE *instantiate;
    fmi2SetupExperimentTYPE *setup;
    fmi2EnterInitializationModeTYPE *enter;
    fmi2ExitInitializationModeTYPE *leave;
    fmi2SetRealTYPE *set;
    fmi2GetRealTYPE *get;
    fmi2DoStepTYPE *step;
    fmi2TerminateTYPE *terminate;
    fmi2FreeInstanceTYPE *release;
    fmi2Component c;
};

struct row {
    size_t count;
    fmi2ValueReference refs[MOST];
    double values[MOST];
};

static void logger(
    fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
    fmi2String message, ...)
{
    (void)environment, (void)category;
    fprintf(stderr, "%s: %d: %s\n", name, (int)status, message);
}

static const fmi2CallbackFunctions host = {logger, NULL, NULL, NULL, NULL};

static void must(int well, const char *what)
{
    if (!well) {
        fprintf(stderr, "%s failed\n", what);
        exit(1);
    }
}

/* ISO C has no conversion from a data pointer to a function pointer; POSIX asks for this one. */
static void find(void *library, const char *name, void *function)
{
    *(void **)function = dlsym(library, name);
    must(*(void **)function != NULL, name);
}

static struct fmu opened(const char *path, const char *guid)
{
    struct fmu fmu;
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    must(library != NULL, path);
    find(library, "fmi2Instantiate", &fmu.instantiate);
    find(library, "fmi2SetupExperiment", &fmu.setup);
    find(library, "fmi2EnterInitializationMode", &fmu.enter);
    find(library, "fmi2ExitInitializationMode", &fmu.leave);
    find(library, "fmi2SetReal", &fmu.set);
    find(library, "fmi2GetReal", &fmu.get);
    find(library, "fmi2DoStep", &fmu.step);
    find(library, "fmi2Terminate", &fmu.terminate);
    find(library, "fmi2FreeInstance", &fmu.release);
    fmu.c = fmu.instantiate(path, fmi2CoSimulation, guid, "", &host, fmi2False, fmi2True);
    must(fmu.c != NULL, "to instantiate");
    return fmu;
}

static void read_refs(struct row *row)
{
    for (size_t i = 0; i < row->count; i++) {
        must(scanf("%u", &row->refs[i]) == 1, "to read a value reference");
    }
}

static void read_values(struct row *row)
{
    for (size_t i = 0; i < row->count; i++) {
        must(scanf("%lf", &row->values[i]) == 1, "to read a value");
    }
}

static void set(const struct fmu *fmu, const struct row *row)
{
    must(fmu->set(fmu->c, row->refs, row->count, row->values) == fmi2OK, "to set");
}

static void get(const struct fmu *fmu, struct row *row)
{
    must(fmu->get(fmu->c, row->refs, row->count, row->values) == fmi2OK, "to get");
}

/* Takes values from one FMU to the other. */
static void carry(const struct fmu *from, struct row *source, const struct fmu *to, struct row *sink)
{
    get(from, source);
    for (size_t i = 0; i < source->count; i++) {
        sink->values[i] = source->values[i];
    }
    set(to, sink);
}

static void begin(const struct fmu *fmu, double stop_s)
{
    must(fmu->setup(fmu->c, fmi2False, 0.0, 0.0, fmi2True, stop_s) == fmi2OK, "to set up");
    must(fmu->enter(fmu->c) == fmi2OK, "to enter the initialisation");
}

int main(int count, char **arguments)
{
    static struct row driven, told, shown, seen, sent, received, plant_out, compensator_out;
    must(count == 7, "to be called with six arguments");
    struct fmu plant = opened(arguments[1], arguments[2]);
    struct fmu compensator = opened(arguments[3], arguments[4]);
    long steps = atol(arguments[5]);
    double step_s = atof(arguments[6]);
    must(scanf("%zu %zu %zu %zu %zu %zu", &driven.count, &told.count, &shown.count, &sent.count,
               &plant_out.count, &compensator_out.count) == 6, "to read the counts");
    seen.count = shown.count;
    received.count = sent.count;
    must(driven.count < MOST && told.count < MOST && shown.count < MOST && sent.count < MOST
             && plant_out.count < MOST && compensator_out.count < MOST, "to have the room");
    struct row *rows[] = {&driven, &told, &shown, &seen, &sent, &received, &plant_out,
                          &compensator_out};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        read_refs(rows[i]);
    }
    for (long k = 0; k <= steps; k++) {
        read_values(&driven);
        read_values(&told);
        if (k == 0) {
            begin(&plant, (double)steps * step_s);
            set(&plant, &driven);
            must(plant.leave(plant.c) == fmi2OK, "to start the plant");
            begin(&compensator, (double)steps * step_s);
            set(&compensator, &told);
            carry(&plant, &shown, &compensator, &seen);
            must(compensator.leave(compensator.c) == fmi2OK, "to start the compensator");
        }
        get(&plant, &plant_out);
        get(&compensator, &compensator_out);
        for (size_t i = 0; i < plant_out.count; i++) {
            printf("%a ", plant_out.values[i]);
        }
        for (size_t i = 0; i < compensator_out.count; i++) {
            printf("%a ", compensator_out.values[i]);
        }
        printf("\n");
        if (k < steps) {
            set(&plant, &driven);
            set(&compensator, &told);
            carry(&plant, &shown, &compensator, &seen);
            carry(&compensator, &sent, &plant, &received);
            double now = (double)k * step_s;
            must(plant.step(plant.c, now, step_s, fmi2True) == fmi2OK, "to step the plant");
            must(compensator.step(compensator.c, now, step_s, fmi2True) == fmi2OK,
                 "to step the compensator");
        }
    }
    must(plant.terminate(plant.c) == fmi2OK, "to end the plant");
    must(compensator.terminate(compensator.c) == fmi2OK, "to end the compensator");
    plant.release(plant.c);
    compensator.release(compensator.c);
    return 0;
}
