/* Amplitudes that leave the friction table: which, when, and what would help. */
#include "instance/instance.h"

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#define HALVINGS 24
#define LEAST_REACH 0.06 /* [rad] of mode A: in a hundredth of a cycle slow time knows of nothing */

/* The mode that is nearest to the end of the table, or farthest beyond it. */
static int outermost(const fmu_instance *instance, const double *outputs, double *end) {
    const sm_table *table = &instance->flow.table;
    const double last[SM_MODES] = {
        table->node_a[table->count_a - 1],
        table->modes == SM_MODES ? table->node_b[table->count_b - 1] : 1.0};
    int mode = 0;
    for (int j = 1; j < table->modes; j++)
        if (fmu_modulus(outputs + 1 + 2 * j) * last[0] > fmu_modulus(outputs + 1) * last[j])
            mode = j;
    *end = last[mode] * instance->inputs.limit_scale;
    return mode;
}

fmu_status fmu_say_outside(const fmu_instance *instance, const double *outputs, const char *doing,
                           const char *consequence) {
    double end;
    const int mode = outermost(instance, outputs, &end);
    const double force = instance->inputs.force[mode];
    char lower[FMU_MESSAGE / 4] = "";
    if (force != 0.0) {
        const int32_t slot = (int32_t)(offsetof(sm_inputs, force) / sizeof(double)) + mode;
        snprintf(lower, sizeof lower, "lower %s, now %g, or ",
                 fmu_name_of(instance, FMU_INPUT, slot), force);
    }
    return fmu_say(instance, FMU_DISCARD,
                   "%s at t = %g s: an amplitude is outside the friction table%s: at t = %.6g s "
                   "%s is %.4g, the table ends at %.4g; %sexport the model with a larger range "
                   "(slipmode fmu --range, rom.tabulate amplitude=)",
                   doing, instance->outputs[0], consequence, outputs[0],
                   fmu_name_of(instance, FMU_MODULUS, mode), fmu_modulus(outputs + 1 + 2 * mode),
                   end, lower);
}

/* Seconds that the component goes, as far as it can. */
static double go(sm_component *component, double duration) {
    double reached = 0.0;
    for (int k = 0; k < HALVINGS; k++) {
        duration *= 0.5;
        if (sm_component_step(component, duration) == SM_OK) reached += duration;
    }
    return reached;
}

/* In less slow time knows of nothing. */
static double least_reach(const fmu_instance *instance) {
    return LEAST_REACH / instance->inputs.frequency[0];
}

/* Seconds that the component can go; its slow outputs are those there, itself it comes back. */
static double reach(sm_component *component, double duration, double *state, double *outputs) {
    sm_component_get_state(component, state);
    const double reached = go(component, duration);
    const sm_status read = sm_component_slow_outputs(component, outputs);
    return sm_component_set_state(component, state) == SM_OK && read == SM_OK ? reached : -1.0;
}

fmu_status fmu_refuse_step(fmu_instance *instance, double duration) {
    const size_t count = sm_component_state_count(instance->component);
    double *state = calloc(count + instance->output_count, sizeof *state);
    if (!state) return fmu_say(instance, FMU_ERROR, "step: out of memory");
    double *outputs = state + count;
    const double reached = reach(instance->component, duration, state, outputs);
    const int stuck = reached < least_reach(instance);
    fmu_note_refusal(instance, duration, stuck);
    const char *consequence = stuck ? ", however short the step" : "";
    const fmu_status status = fmu_say_outside(instance, outputs, "step", consequence);
    free(state);
    return status;
}

double fmu_step_partly(fmu_instance *instance, double duration) {
    double *state = calloc(sm_component_state_count(instance->component), sizeof *state);
    if (!state) return -1.0;
    sm_component_get_state(instance->component, state);
    double reached = go(instance->component, duration);
    if (reached < least_reach(instance)) {
        reached = 0.0;
        if (sm_component_set_state(instance->component, state) != SM_OK) reached = -1.0;
    }
    free(state);
    return reached;
}

void fmu_note_refusal(fmu_instance *instance, double duration, int stuck) {
    const double now = instance->outputs[0];
    const int again = instance->refused_at == now && duration >= instance->refused;
    instance->terminated = stuck || again;
    instance->refused_at = now;
    instance->refused = duration;
}
