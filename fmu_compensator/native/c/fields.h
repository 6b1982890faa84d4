/* Tables of the compensator file, as constant data. Python has checked every value; looking up a
   name that the file does not have is noted as a problem of the setup. */
#ifndef FIELDS_H
#define FIELDS_H

#include <stddef.h>

#include "setup.h"

enum field_form {
    FIELD_NULL, FIELD_NUMBER, FIELD_TEXT, FIELD_NUMBERS, FIELD_MATRIX, FIELD_LIST, FIELD_TABLE
};

struct field {
    const char *name; /* in a table; NULL in a list */
    enum field_form form;
    size_t count;               /* of numbers, of rows, or of items */
    const double *numbers;      /* a matrix row by row */
    const char *text;
    const struct field *items;  /* of a list or a table */
};

double field_number(struct setup *setup, const struct field *table, const char *name);
const char *field_text(struct setup *setup, const struct field *table, const char *name);
const double *field_numbers(
    struct setup *setup, const struct field *table, const char *name, size_t *count);
const double *field_matrix(
    struct setup *setup, const struct field *table, const char *name, size_t *rows);
const struct field *field_list(
    struct setup *setup, const struct field *table, const char *name, size_t *count);
const struct field *field_table(struct setup *setup, const struct field *table, const char *name);

#endif
