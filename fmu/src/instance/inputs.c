/* Inputs move at their rates: in Co-Simulation from step to step, in Model Exchange with time. */
#include "instance/instance.h"

#include <math.h>
#include <string.h>

double *fmu_slots(sm_inputs *inputs) { return (double *)(void *)inputs; }

int32_t fmu_rate_slot(int32_t slot) {
    for (int k = 0; k < SM_INPUT_VALUES; k++)
        if (sm_value_place(k) == slot) return sm_rate_place(k);
    return -1;
}

int fmu_input_is_positive(int32_t slot) {
    const int32_t mode = slot - FMU_INPUT_SLOT(frequency);
    return (mode >= 0 && mode < SM_MODES) || slot == FMU_INPUT_SLOT(limit_scale);
}

void fmu_note_inputs(fmu_instance *instance) {
    instance->run.given_inputs = instance->run.inputs;
    for (size_t k = 0; k < SM_INPUT_DOUBLES; k++) instance->run.given_at[k] = instance->outputs[0];
}

/* Notes value and time of the input of this slot, or of the input whose rate has this slot. */
static void note(fmu_instance *instance, int32_t slot) {
    const double *inputs = fmu_slots(&instance->run.inputs);
    double *given = fmu_slots(&instance->run.given_inputs);
    for (int32_t k = 0; k < (int32_t)SM_INPUT_DOUBLES; k++) {
        if (k != slot && fmu_rate_slot(k) != slot) continue;
        given[k] = inputs[k];
        instance->run.given_at[k] = instance->outputs[0];
    }
}

void fmu_set_input(fmu_instance *instance, int32_t slot, double value) {
    fmu_slots(&instance->run.inputs)[slot] = value;
    if (instance->interface == FMU_MODEL_EXCHANGE) note(instance, slot);
    instance->refused_at = NAN; /* the next step is no repetition */
    instance->inputs_current = 0;
    fmu_outdate(instance);
}

void fmu_move_inputs(fmu_instance *instance) {
    double *inputs = fmu_slots(&instance->run.inputs);
    const double *given = fmu_slots(&instance->run.given_inputs);
    for (int32_t k = 0; k < (int32_t)SM_INPUT_DOUBLES; k++) {
        const int32_t rate = fmu_rate_slot(k);
        if (rate < 0 || inputs[rate] == 0.0) continue;
        inputs[k] = given[k] + inputs[rate] * (instance->outputs[0] - instance->run.given_at[k]);
        instance->outputs_current = instance->rates_current = 0;
    }
}

void fmu_advance_inputs(sm_inputs *inputs, double duration) {
    double *slot = fmu_slots(inputs);
    for (int k = 0; k < SM_INPUT_VALUES; k++)
        slot[sm_value_place(k)] += slot[sm_rate_place(k)] * duration;
}

void fmu_modal_inputs(const fmu_instance *instance, sm_inputs *inputs) {
    const double ratio = instance->model->flow.ratio;
    if (ratio != 0.0) {
        inputs->frequency[1] = ratio * inputs->frequency[0];
        inputs->frequency_rate[1] = ratio * inputs->frequency_rate[0];
    }
    for (int j = 0; j < SM_MODES; j++) {
        inputs->force[j] *= instance->model->constants->force_factor[j];
        inputs->force_rate[j] *= instance->model->constants->force_factor[j];
    }
}

sm_inputs fmu_inputs_now(const fmu_instance *instance) {
    sm_inputs inputs = instance->run.inputs;
    fmu_modal_inputs(instance, &inputs);
    memcpy(inputs.angle, instance->outputs + FMU_ANGLE, sizeof inputs.angle);
    return inputs;
}
