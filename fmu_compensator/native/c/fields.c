#include "fields.h"

#include <string.h>

/* Returns the field of whatever form, or NULL where it is absent. */
static const struct field *named(
    struct setup *setup, const struct field *table, const char *name)
{
    for (size_t i = 0; table != NULL && i < table->count; i++) {
        if (strcmp(table->items[i].name, name) == 0) {
            return &table->items[i];
        }
    }
    setup_fail(setup, "the compiled-in file lacks", name);
    return NULL;
}

/* Returns the field, or NULL where it is absent or of another form; an empty list is of any. */
static const struct field *find(
    struct setup *setup, const struct field *table, const char *name, enum field_form form)
{
    const struct field *field = named(setup, table, name);
    if (field == NULL || field->form == form
        || (field->form == FIELD_LIST && field->count == 0)) {
        return field;
    }
    setup_fail(setup, "the compiled-in file has another kind of value in", name);
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

void field_axes(
    struct setup *setup, const struct field *table, const char *name, double absent,
    double values[3])
{
    const struct field *field = named(setup, table, name);
    for (size_t axis = 0; axis < 3; axis++) {
        values[axis] = absent;
        if (field == NULL || axis >= field->count) {
            continue;
        }
        /* Three numbers are a row of them; where null stands among them they are a list. */
        if (field->form == FIELD_NUMBERS) {
            values[axis] = field->numbers[axis];
        } else if (field->form == FIELD_LIST && field->items[axis].form == FIELD_NUMBER) {
            values[axis] = field->items[axis].numbers[0];
        }
    }
}
