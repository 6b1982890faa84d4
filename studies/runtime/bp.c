/* Back-propagation network: tansig hidden layers, linear output layer. */
#include <math.h>

#include "../error_model.h"
#include "../numbers.h"

struct layer {
    size_t nodes;
    const double *weights, *biases;
};

struct network {
    struct error_model base;
    size_t inputs, targets, layers;
    const double *input_middle, *input_half, *output_middle, *output_half;
    struct layer *layer;
    double *values, *sums; /* of the widest layer */
};

static struct error_model *make(
    struct setup *setup, const struct field *table, size_t inputs, size_t targets)
{
    struct network *self = setup_take(setup, 1, sizeof *self);
    size_t widest = inputs;
    if (self == NULL) {
        return NULL;
    }
    self->inputs = inputs;
    self->targets = targets;
    self->input_middle = field_numbers(setup, table, "input_middle", NULL);
    self->input_half = field_numbers(setup, table, "input_half", NULL);
    self->output_middle = field_numbers(setup, table, "output_middle", NULL);
    self->output_half = field_numbers(setup, table, "output_half", NULL);
    const struct field *layers = field_list(setup, table, "layers", &self->layers);
    self->layer = setup_take(setup, self->layers, sizeof *self->layer);
    if (self->layer == NULL) {
        return NULL;
    }
    for (size_t number = 0; number < self->layers; number++) {
        struct layer *layer = &self->layer[number];
        layer->biases = field_numbers(setup, &layers[number], "biases", &layer->nodes);
        layer->weights = field_matrix(setup, &layers[number], "weights", NULL);
        widest = layer->nodes > widest ? layer->nodes : widest;
    }
    self->values = setup_take(setup, widest, sizeof *self->values);
    self->sums = setup_take(setup, widest, sizeof *self->sums);
    return &self->base;
}

static void predict(
    const struct error_model *model, double *state, const struct sample *sample, double *targets)
{
    const struct network *self = (const struct network *)model;
    double *values = self->values;
    size_t width = self->inputs;
    (void)state;
    for (size_t i = 0; i < width; i++) {
        values[i] = (sample->inputs[i] - self->input_middle[i]) / self->input_half[i];
    }
    for (size_t number = 0; number < self->layers; number++) {
        const struct layer *layer = &self->layer[number];
        for (size_t node = 0; node < layer->nodes; node++) {
            const double *weights = layer->weights + node * width;
            self->sums[node] = layer->biases[node] + dot(weights, values, width);
        }
        width = layer->nodes;
        for (size_t node = 0; node < width; node++) {
            values[node] = number + 1 == self->layers ? self->sums[node] : tanh(self->sums[node]);
        }
    }
    for (size_t target = 0; target < self->targets; target++) {
        targets[target] = self->output_middle[target] + self->output_half[target] * values[target];
    }
}

const struct error_model_kind bp_kind = {"bp", make, NULL, predict};
/* A genetic algorithm chose its size and start; it runs like any other network. */
const struct error_model_kind ga_bp_kind = {"ga_bp", make, NULL, predict};
