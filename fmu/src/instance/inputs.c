/* Inputs move at their rates: in Co-Simulation from step to step, in Model Exchange with time. */
#include "instance/instance.h"

#include <math.h>
#include <stddef.h>

/* Doubles of sm_inputs. */
#define INPUT_SLOT(field) ((int32_t)(offsetof(sm_inputs, field) / sizeof(double)))

static int is_of(int32_t slot, int32_t first) { return slot >= first && slot < first + SM_MODES; }

static double *slots(sm_inputs *inputs) { return (double *)(void *)inputs; }

int32_t fmu_rate_slot(int32_t slot) {
    if (slot == INPUT_SLOT(limit_scale)) return INPUT_SLOT(limit_scale_rate);
    const int has = is_of(slot, INPUT_SLOT(force)) || is_of(slot, INPUT_SLOT(frequency)) ||
                    is_of(slot, INPUT_SLOT(phase));
    return has ? slot + SM_MODES : -1;
}

int fmu_input_is_positive(int32_t slot) {
    return is_of(slot, INPUT_SLOT(frequency)) || slot == INPUT_SLOT(limit_scale);
}

void fmu_hold_inputs(fmu_instance *instance) {
    instance->held_inputs = instance->inputs;
    for (size_t k = 0; k < FMU_INPUTS; k++) instance->held_since[k] = instance->outputs[0];
}

/* What moves from here on: the input, or the one whose rate it is. */
static void hold(fmu_instance *instance, int32_t slot) {
    const double *inputs = slots(&instance->inputs);
    double *held = slots(&instance->held_inputs);
    for (int32_t k = 0; k < (int32_t)FMU_INPUTS; k++) {
        if (k != slot && fmu_rate_slot(k) != slot) continue;
        held[k] = inputs[k];
        instance->held_since[k] = instance->outputs[0];
    }
}

void fmu_set_input(fmu_instance *instance, int32_t slot, double value) {
    slots(&instance->inputs)[slot] = value;
    if (instance->interface == FMU_MODEL_EXCHANGE) hold(instance, slot);
    instance->refused_at = NAN; /* a step may go another way now */
    instance->inputs_current = instance->outputs_current = 0;
    instance->rates_current = 0;
    instance->motion_current = FMU_NO_MOTION;
}

void fmu_move_inputs(fmu_instance *instance) {
    double *inputs = slots(&instance->inputs), *held = slots(&instance->held_inputs);
    for (int32_t k = 0; k < (int32_t)FMU_INPUTS; k++) {
        const int32_t rate = fmu_rate_slot(k);
        if (rate < 0 || inputs[rate] == 0.0) continue;
        inputs[k] = held[k] + inputs[rate] * (instance->outputs[0] - instance->held_since[k]);
        instance->outputs_current = instance->rates_current = 0;
    }
}
