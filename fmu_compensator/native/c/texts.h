/* The status in words, letter for letter those of the Python twin. */
#ifndef TEXTS_H
#define TEXTS_H

#include <stddef.h>

#include "compensator.h"

/* Room for a sentence with the largest number written out in full. */
#define TEXT_LENGTH 640

void status_text(const struct output *output, char *text, size_t size);

#endif
