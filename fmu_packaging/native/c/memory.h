/* Allocates an FMU's memory from the heap or, with NO_HEAP, from static memory. */
#ifndef MEMORY_H
#define MEMORY_H

#include <stddef.h>

/* Returns zeroed memory, aligned for all of its contents; NULL if there is none. */
void *memory_take(size_t count, size_t size);

void memory_give(void *memory);

/* Most memory ever taken [bytes]; only known with NO_HEAP. */
size_t memory_most(void);

#endif
