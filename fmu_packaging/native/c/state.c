/* The FMU state: a copy of an instance's memory, and that copy as bytes. */
#include <string.h>

#include "instance.h"
#include "memory.h"

/* Header before the copy. Model and size identify whose state it is. */
struct head {
    char model[64];
    uint64_t size;
    uint64_t sum;
};

struct memory *instance_state(const struct instance *self)
{
    struct memory *state = memory_take(1, self->memory_size);
    if (state != NULL) {
        memcpy(state, self->memory, self->memory_size);
    }
    return state;
}

void instance_restore(struct instance *self, const struct memory *state)
{
    memcpy(self->memory, state, self->memory_size);
}

/* FNV-1a, 64 bits. */
static uint64_t sum_of(const unsigned char *bytes, size_t size)
{
    uint64_t sum = 14695981039346656037u;
    for (size_t i = 0; i < size; i++) {
        sum = (sum ^ bytes[i]) * 1099511628211u;
    }
    return sum;
}

static struct head head_of(const struct instance *self, const unsigned char *copy)
{
    struct head head;
    memset(&head, 0, sizeof head);
    strncpy(head.model, model_guid, sizeof head.model - 1);
    head.size = self->memory_size;
    head.sum = sum_of(copy, self->memory_size);
    return head;
}

size_t state_bytes_size(const struct instance *self)
{
    return sizeof(struct head) + self->memory_size;
}

void state_to_bytes(const struct instance *self, const struct memory *state, void *bytes)
{
    unsigned char *copy = (unsigned char *)bytes + sizeof(struct head);
    memcpy(copy, state, self->memory_size);
    struct head head = head_of(self, copy);
    memcpy(bytes, &head, sizeof head);
}

struct memory *state_from_bytes(
    const struct instance *self, const void *bytes, size_t size, const char **problem)
{
    struct head found, expected;
    struct memory *state = NULL;
    if (size != state_bytes_size(self)) {
        *problem = "the state has another size than those of this FMU";
        return NULL;
    }
    const unsigned char *copy = (const unsigned char *)bytes + sizeof found;
    memcpy(&found, bytes, sizeof found);
    expected = head_of(self, copy);
    if (memcmp(found.model, expected.model, sizeof found.model) != 0) {
        *problem = "the state belongs to another FMU";
    } else if (found.size != expected.size || found.sum != expected.sum) {
        *problem = "the bytes of the state are damaged";
    } else {
        state = memory_take(1, self->memory_size);
        if (state == NULL) {
            *problem = "there is not enough memory for the state";
        } else {
            memcpy(state, copy, self->memory_size);
        }
    }
    return state;
}
