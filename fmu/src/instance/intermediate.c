/* Steps of Co-Simulation whose internal steps the importer is told of, and may read at. */
#include "instance/instance.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int is_output(const fmu_variable *variable) {
    return variable->kind == FMU_OUTPUT || variable->kind == FMU_START ||
           variable->kind == FMU_MODULUS || variable->kind == FMU_PHASE ||
           variable->kind == FMU_MARGIN;
}

fmu_status fmu_observe(fmu_instance *instance, const fmu_observer *observer,
                       const uint32_t *wanted, size_t count) {
    const fmu_model *model = instance->model;
    for (size_t k = 0; k < count; k++)
        if (wanted[k] >= (uint32_t)model->variables || !is_output(&model->variable[wanted[k]]))
            return fmu_say(instance, FMU_ERROR,
                           "required intermediate variables: value reference %lu is no output",
                           (unsigned long)wanted[k]);
    uint32_t *kept = calloc(count + 1, sizeof *kept);
    if (!kept) return fmu_say(instance, FMU_ERROR, "required intermediate variables: out of memory");
    if (count > 0) memcpy(kept, wanted, count * sizeof *kept);
    instance->observer = *observer;
    instance->observer.wanted = kept;
    instance->observer.count = count;
    return FMU_OK;
}

int fmu_is_observed(const fmu_instance *instance, uint32_t reference) {
    for (size_t k = 0; k < instance->observer.count; k++)
        if (instance->observer.wanted[k] == reference) return 1;
    return 0;
}

/* Shows where a step is that began with some inputs; seconds that are left of it. */
static double show(fmu_instance *instance, const sm_inputs *begun, double start, double end) {
    const double now = instance->outputs[0];
    double wanted = now;
    instance->inputs = *begun;
    fmu_advance_inputs(&instance->inputs, now - start);
    instance->rates_current = 0;
    instance->motion_current = FMU_NO_MOTION;
    instance->state = FMU_INTERMEDIATE;
    const int may_end = instance->early_return && now < end;
    const int ends = instance->observer.update(&instance->observer, now, may_end, &wanted);
    instance->state = FMU_STEPPING;
    if (!ends) return end - now;
    return wanted > now ? fmin(wanted, end) - now : 0.0;
}

sm_status fmu_step_observed(fmu_instance *instance, double *duration) {
    sm_component *component = instance->component;
    const size_t count = sm_component_state_count(component);
    double *state = calloc(count, sizeof *state), outputs[SM_OUTPUTS_FIXED];
    if (!state) return SM_NO_MEMORY;
    sm_component_get_state(component, state);
    memcpy(outputs, instance->outputs, sizeof outputs);
    const sm_inputs begun = instance->inputs;
    const double start = outputs[0];
    double left = *duration, end = start + left;
    sm_status status = SM_OK;
    while (status == SM_OK && left > 0.0) {
        double taken;
        status = sm_component_advance(component, left, &taken);
        if (status == SM_OK) status = sm_component_slow_outputs(component, instance->outputs);
        if (status != SM_OK) break;
        left = show(instance, &begun, start, end);
        end = fmin(end, instance->outputs[0] + left);
    }
    instance->inputs = begun;
    if (status == SM_OK) {
        if (end < start + *duration) *duration = end - start;
    } else { /* what was shown does not count */
        sm_component_set_state(component, state);
        memcpy(instance->outputs, outputs, sizeof outputs);
        instance->rates_current = 0;
        instance->motion_current = FMU_NO_MOTION;
    }
    free(state);
    return status;
}
