#include "error_model.h"

#include <string.h>

#include "model_data.h"

struct error_model *error_model_make(
    struct setup *setup, const struct field *table, size_t inputs, size_t targets)
{
    const char *name = field_text(setup, table, "kind");
    for (size_t i = 0; model_kinds[i] != NULL; i++) {
        if (strcmp(model_kinds[i]->name, name) == 0) {
            struct error_model *model = model_kinds[i]->make(setup, table, inputs, targets);
            if (model != NULL) {
                model->kind = model_kinds[i];
            }
            return model;
        }
    }
    setup_fail(setup, "there is no error model of the kind", name);
    return NULL;
}

void error_model_reset(const struct error_model *model, double *state)
{
    memset(state, 0, model->states * sizeof *state);
    if (model->kind->reset != NULL) {
        model->kind->reset(model, state);
    }
}
