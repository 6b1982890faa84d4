#include "memory.h"

#ifndef NO_HEAP

#include <stdlib.h>

void *memory_take(size_t count, size_t size)
{
    return calloc(count > 0 ? count : 1, size > 0 ? size : 1);
}

void memory_give(void *memory)
{
    free(memory);
}

size_t memory_most(void)
{
    return 0;
}

#else

#include <stdint.h>
#include <string.h>

/* Memory of an instance and of a state, measured by the build of the FMU. */
#ifndef MEMORY_OF_INSTANCE
#include "memory_size.h"
#endif
#ifndef NO_HEAP_INSTANCES
#define NO_HEAP_INSTANCES 1
#endif
#ifndef NO_HEAP_STATES
#define NO_HEAP_STATES 0
#endif

#define TOTAL (NO_HEAP_INSTANCES * MEMORY_OF_INSTANCE + NO_HEAP_STATES * MEMORY_OF_STATE)

/* Header of each piece. */
struct piece {
    size_t size; /* of the piece [bytes] */
    size_t used;
};

#define UNIT sizeof(double)
#define HEAD ((sizeof(struct piece) + UNIT - 1) / UNIT * UNIT)

static union {
    double aligned;
    struct piece piece;
    unsigned char bytes[TOTAL];
} arena;
static size_t end; /* of the memory ever taken */

static struct piece *piece_at(size_t place)
{
    return (struct piece *)(void *)(arena.bytes + place);
}

/* A returned piece is only reused for the same size. Instances and states always have the same
   sizes, so no piece is ever split, and memory does not fragment. */
void *memory_take(size_t count, size_t size)
{
    size_t place = 0, wanted = 0;
    if (size != 0 && count > (SIZE_MAX - UNIT) / size) {
        return NULL;
    }
    wanted = (count * size + UNIT - 1) / UNIT * UNIT;
    while (place < end && (piece_at(place)->used != 0 || piece_at(place)->size != wanted)) {
        place += HEAD + piece_at(place)->size;
    }
    if (place == end) {
        if (wanted > TOTAL || TOTAL - end < HEAD + wanted) {
            return NULL;
        }
        end += HEAD + wanted;
    }
    piece_at(place)->size = wanted;
    piece_at(place)->used = 1;
    return memset(arena.bytes + place + HEAD, 0, wanted);
}

void memory_give(void *memory)
{
    if (memory != NULL) {
        piece_at((size_t)((unsigned char *)memory - arena.bytes) - HEAD)->used = 0;
    }
}

size_t memory_most(void)
{
    return end;
}

#endif
