#include "setup.h"

#include <stdint.h>

#include "memory.h"

#define LINE 64 /* of a processor's cache; numbers used together should not cross one */

struct block {
    struct block *next;
};

void *setup_take(struct setup *setup, size_t count, size_t size)
{
    struct block *block = NULL;
    size_t before = sizeof *block + LINE - 1;
    if (size == 0 || count <= (SIZE_MAX - before) / size) {
        block = memory_take(1, before + count * size);
    }
    if (block == NULL) {
        setup_fail(setup, "there is not enough memory", "the model");
        return NULL;
    }
    block->next = setup->blocks;
    setup->blocks = block;
    unsigned char *content = (unsigned char *)(block + 1);
    return content + (LINE - (uintptr_t)content % LINE) % LINE;
}

void setup_fail(struct setup *setup, const char *problem, const char *about)
{
    if (setup->problem == NULL) {
        setup->problem = problem;
        setup->about = about;
    }
}

void setup_free(struct setup *setup)
{
    while (setup->blocks != NULL) {
        struct block *next = setup->blocks->next;
        memory_give(setup->blocks);
        setup->blocks = next;
    }
}
