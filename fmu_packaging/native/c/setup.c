#include "setup.h"

#include <stdint.h>

#include "memory.h"

struct block {
    struct block *next;
    double content[]; /* aligned for everything that is kept here */
};

void *setup_take(struct setup *setup, size_t count, size_t size)
{
    struct block *block = NULL;
    if (size == 0 || count <= (SIZE_MAX - sizeof *block) / size) {
        block = memory_take(1, sizeof *block + count * size);
    }
    if (block == NULL) {
        setup_fail(setup, "there is not enough memory", "the model");
        return NULL;
    }
    block->next = setup->blocks;
    setup->blocks = block;
    return block->content;
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
