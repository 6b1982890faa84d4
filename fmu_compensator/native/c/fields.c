#include "fields.h"

#include <string.h>

/* Returns the field, or NULL where it is absent or of another form; null and an empty list are of
   any form. */
static const struct field *find(
    struct setup *setup, const struct field *table, const char *name, enum field_form form)
{
    for (size_t i = 0; table != NULL && i < table->count; i++) {
        const struct field *field = &table->items[i];
        if (strcmp(field->name, name) != 0) {
            continue;
        }
        if (field->form == form || field->form == FIELD_NULL
            || (field->form == FIELD_LIST && field->count == 0)) {
            return field;
        }
        setup_fail(setup, "the compiled-in file has another kind of value in", name);
        return NULL;
    }
    setup_fail(setup, "the compiled-in file lacks", name);
    return NULL;
}

static const struct field *counted(
    struct setup *setup, const struct field *table, const char *name, enum field_form form,
    size_t *count)
{
    const struct field *field = find(setup, table, name, form);
    if (count != NULL) {
        *count = field == NULL ? 0 : field->count;
    }
    return field;
}

double field_number(struct setup *setup, const struct field *table, const char *name)
{
    const struct field *field = find(setup, table, name, FIELD_NUMBER);
    return field == NULL || field->numbers == NULL ? 0.0 : field->numbers[0];
}

const char *field_text(struct setup *setup, const struct field *table, const char *name)
{
    const struct field *field = find(setup, table, name, FIELD_TEXT);
    return field == NULL || field->text == NULL ? "" : field->text;
}

const double *field_numbers(
    struct setup *setup, const struct field *table, const char *name, size_t *count)
{
    const struct field *field = counted(setup, table, name, FIELD_NUMBERS, count);
    return field == NULL ? NULL : field->numbers;
}

const double *field_matrix(
    struct setup *setup, const struct field *table, const char *name, size_t *rows)
{
    const struct field *field = counted(setup, table, name, FIELD_MATRIX, rows);
    return field == NULL ? NULL : field->numbers;
}

const struct field *field_list(
    struct setup *setup, const struct field *table, const char *name, size_t *count)
{
    const struct field *field = counted(setup, table, name, FIELD_LIST, count);
    return field == NULL ? NULL : field->items;
}

const struct field *field_table(struct setup *setup, const struct field *table, const char *name)
{
    return find(setup, table, name, FIELD_TABLE);
}
