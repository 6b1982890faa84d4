/* A logger for an FMU in WebAssembly, because a page cannot pass one. */
#include <stdio.h>

#include "fmi3Functions.h"

static char newest[1024];

static void keep(
    fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message)
{
    (void)environment, (void)status, (void)category;
    snprintf(newest, sizeof newest, "%s", message);
}

__attribute__((export_name("web_logger"))) fmi3LogMessageCallback web_logger(void)
{
    return keep;
}

/* The newest message. */
__attribute__((export_name("web_message"))) const char *web_message(void)
{
    return newest;
}
