/* What an instance is made with: memory that is taken at the start and given back at the end. */
#ifndef SETUP_H
#define SETUP_H

#include <stddef.h>

struct block;

struct setup {
    struct block *blocks;
    const char *problem; /* what went wrong first; NULL: nothing */
    const char *about;   /* the field or thing that it is about */
};

/* Returns zeroed memory, or NULL with the problem noted. */
void *setup_take(struct setup *setup, size_t count, size_t size);

/* Notes a problem, unless another was there first. */
void setup_fail(struct setup *setup, const char *problem, const char *about);

/* Gives everything back. */
void setup_free(struct setup *setup);

#endif
