/* The object of the core that an instance steps: a component with a friction table, or the flow of
 * modes that share a tone. A step of the flow is one internal step here. */
#include "instance/instance.h"

#include <stdlib.h>

sm_status fmu_core_create(const fmu_model *model, const sm_slow_flow *flow,
                          const sm_motion *motion, double tolerance, fmu_core **core) {
    fmu_core *made = calloc(1, sizeof *made);
    if (!made) return SM_NO_MEMORY;
    const sm_status status =
        model->shares_tone ? sm_tone_create(&model->tone, tolerance, &made->tone)
                           : sm_component_checked_create(flow, &model->contact, motion, tolerance,
                                                         &made->component);
    if (status == SM_OK)
        *core = made;
    else
        free(made);
    return status;
}

void fmu_core_free(fmu_core *core) {
    if (!core) return;
    sm_component_free(core->component);
    sm_tone_free(core->tone);
    free(core);
}

sm_status fmu_core_reset(fmu_core *core, double time, const double *amplitude) {
    return core->tone ? sm_tone_reset(core->tone, time)
                      : sm_component_reset(core->component, time, amplitude);
}

sm_status fmu_core_set_inputs(fmu_core *core, const sm_inputs *inputs) {
    return core->tone ? sm_tone_set_inputs(core->tone, inputs)
                      : sm_component_set_inputs(core->component, inputs);
}

sm_status fmu_core_step(fmu_core *core, double duration) {
    return core->tone ? sm_tone_step(core->tone, duration)
                      : sm_component_step(core->component, duration);
}

sm_status fmu_core_advance(fmu_core *core, double most) {
    double taken;
    return core->tone ? sm_tone_step(core->tone, most)
                      : sm_component_advance(core->component, most, &taken);
}

sm_status fmu_core_slow_outputs(fmu_core *core, double *outputs) {
    return core->tone ? sm_tone_slow_outputs(core->tone, outputs)
                      : sm_component_slow_outputs(core->component, outputs);
}

sm_status fmu_core_motion(fmu_core *core, int elastic, double *outputs) {
    return core->tone ? sm_tone_outputs(core->tone, outputs)
                      : sm_component_motion(core->component, elastic, outputs + SM_OUTPUTS_FIXED);
}

size_t fmu_core_state_count(const fmu_core *core) {
    return core->tone ? sm_tone_state_count(core->tone)
                      : sm_component_state_count(core->component);
}

sm_status fmu_core_get_state(const fmu_core *core, double *state) {
    return core->tone ? sm_tone_get_state(core->tone, state)
                      : sm_component_get_state(core->component, state);
}

sm_status fmu_core_set_state(fmu_core *core, const double *state) {
    return core->tone ? sm_tone_set_state(core->tone, state)
                      : sm_component_set_state(core->component, state);
}
