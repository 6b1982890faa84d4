/* The setup of an instance: memory allocated at the start and freed at the end. */
#ifndef SETUP_H
#define SETUP_H

#include <stddef.h>

struct block;

struct setup {
    struct block *blocks;
    const char *problem; /* the first problem; NULL: none */
    const char *about;   /* the field or thing concerned */
};

/* Returns zeroed memory, or NULL with the problem noted. */
void *setup_take(struct setup *setup, size_t count, size_t size);

/* Notes a problem, unless there already is one. */
void setup_fail(struct setup *setup, const char *problem, const char *about);

/* Frees everything. */
void setup_free(struct setup *setup);

#endif
