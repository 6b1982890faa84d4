/* A host for Linux and for Windows: runs an FMU through good and bad samples, and prints it all.

   printing_host LIBRARY GUID, for the compensator of tests/fmus/models.py. */
#include <math.h>
#include <stdio.h>

#include "fmi2FunctionTypes.h"

#ifdef _WIN32
#include <windows.h>
static void *opened(const char *path)
{
    return (void *)LoadLibraryA(path);
}
static void find(void *library, const char *name, void *function)
{
    *(FARPROC *)function = GetProcAddress((HMODULE)library, name);
}
#else
#include <dlfcn.h>
static void *opened(const char *path)
{
    return dlopen(path, RTLD_NOW);
}
static void find(void *library, const char *name, void *function)
{
    *(void **)function = dlsym(library, name);
}
#endif

/* Six inputs for measurements lie between those that are set and the outputs. */
enum { SENSORS = 11, INPUTS = 13, FIRST = 19, OUTPUTS = 9, TEXT = 31 };

static void logger(
    fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
    fmi2String message, ...)
{
    (void)environment, (void)name, (void)status, (void)category, (void)message;
}

int main(int count, char **arguments)
{
    static const fmi2CallbackFunctions host = {logger, NULL, NULL, NULL, NULL};
    fmi2InstantiateTYPE *instantiate;
    fmi2SetupExperimentTYPE *set_up;
    fmi2EnterInitializationModeTYPE *enter;
    fmi2ExitInitializationModeTYPE *start;
    fmi2SetRealTYPE *set;
    fmi2GetRealTYPE *get;
    fmi2GetStringTYPE *get_text;
    fmi2DoStepTYPE *step;
    void *library = count == 3 ? opened(arguments[1]) : NULL;
    if (library == NULL) {
        return 1;
    }
    find(library, "fmi2Instantiate", &instantiate);
    find(library, "fmi2SetupExperiment", &set_up);
    find(library, "fmi2EnterInitializationMode", &enter);
    find(library, "fmi2ExitInitializationMode", &start);
    find(library, "fmi2SetReal", &set);
    find(library, "fmi2GetReal", &get);
    find(library, "fmi2GetString", &get_text);
    find(library, "fmi2DoStep", &step);
    fmi2Component c = instantiate("one", fmi2CoSimulation, arguments[2], "", &host, 0, 0);
    if (c == NULL || set_up(c, fmi2False, 0.0, 0.0, fmi2False, 0.0) != fmi2OK
        || enter(c) != fmi2OK || start(c) != fmi2OK) {
        return 1;
    }
    for (int k = 0; k < 300; k++) {
        fmi2ValueReference refs[FIRST + OUTPUTS], text_ref = TEXT;
        double in[INPUTS], out[OUTPUTS];
        fmi2String text = NULL;
        for (int i = 0; i < FIRST + OUTPUTS; i++) {
            refs[i] = (fmi2ValueReference)i;
        }
        for (int i = 0; i < SENSORS; i++) {
            in[i] = 20.0 + 0.01 * (i + 1) * k;
        }
        in[0] = k == 200 ? 1e300 : in[0];
        in[3] = k > 100 && k < 160 ? NAN : in[3];
        in[SENSORS] = 3000.0;
        in[SENSORS + 1] = 120.0;
        set(c, refs, INPUTS, in);
        printf("%d", (int)step(c, k, 1.0, fmi2True));
        get(c, refs + FIRST, OUTPUTS, out);
        get_text(c, &text_ref, 1, &text);
        for (int i = 0; i < OUTPUTS; i++) {
            printf(" %.17g", out[i]);
        }
        printf(" %s\n", text);
    }
    return 0;
}
