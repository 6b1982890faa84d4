#include "fields.h"

#include <stdbool.h>
#include <string.h>

/* Returns the field, or an empty one if it is absent or of another form; null and an empty list
   are of any form. */
static const struct field *find(
    struct setup *setup, const struct field *table, const char *name, enum field_form form,
    size_t *count)
{
    static const struct field none;
    const struct field *found = &none;
    for (size_t i = 0; i < table->count; i++) {
        const struct field *field = &table->items[i];
        bool any = field->form == FIELD_NULL || (field->form == FIELD_LIST && field->count == 0);
        if (strcmp(field->name, name) == 0 && (any || field->form == form)) {
            found = field;
        }
    }
    if (found == &none) {
        setup_fail(setup, "the compiled-in file lacks, or has another kind of value in", name);
    }
    if (count != NULL) {
        *count = found->count;
    }
    return found;
}

double field_number(struct setup *setup, const struct field *table, const char *name)
{
    const struct field *field = find(setup, table, name, FIELD_NUMBER, NULL);
    return field->numbers == NULL ? 0.0 : field->numbers[0];
}

const char *field_text(struct setup *setup, const struct field *table, const char *name)
{
    const struct field *field = find(setup, table, name, FIELD_TEXT, NULL);
    return field->text == NULL ? "" : field->text;
}

const double *field_numbers(
    struct setup *setup, const struct field *table, const char *name, size_t *count)
{
    return find(setup, table, name, FIELD_NUMBERS, count)->numbers;
}

const double *field_matrix(
    struct setup *setup, const struct field *table, const char *name, size_t *rows)
{
    return find(setup, table, name, FIELD_MATRIX, rows)->numbers;
}

const struct field *field_list(
    struct setup *setup, const struct field *table, const char *name, size_t *count)
{
    return find(setup, table, name, FIELD_LIST, count)->items;
}

const struct field *field_table(struct setup *setup, const struct field *table, const char *name)
{
    return find(setup, table, name, FIELD_TABLE, NULL);
}
