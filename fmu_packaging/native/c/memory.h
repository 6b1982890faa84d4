/* Where an FMU's memory comes from: the heap, or, with NO_HEAP, memory that is there from the
   beginning. */
#ifndef MEMORY_H
#define MEMORY_H

#include <stddef.h>

/* Returns zeroed memory, aligned for everything that is kept in it; NULL where there is none. */
void *memory_take(size_t count, size_t size);

void memory_give(void *memory);

/* How much has been taken at most [bytes]; known with NO_HEAP only. */
size_t memory_most(void);

#endif
