/* Directional derivatives of the motion of contacts and DOFs: central differences of marches over
 * the last few periods, whose steps stay the same. */
#include "instance/instance.h"

#include <math.h>
#include <stdlib.h>

#define STEP 3e-4 /* of what the amplitudes, forces and frequencies may be */

/* How large the change is, relative to that. */
static double size_of(const fmu_instance *instance, const double *d_amplitude,
                      const sm_inputs *d_inputs) {
    const sm_slow_flow *flow = &instance->flow;
    const double *range[SM_MODES] = {flow->table.node_a + flow->table.count_a - 1,
                                     flow->table.node_b + flow->table.count_b - 1};
    double size = fabs(d_inputs->limit_scale) / instance->inputs.limit_scale;
    for (int j = 0; j < instance->model->modes; j++) {
        const double omega = flow->natural[j], most = *range[j];
        const double force = omega * omega * most;
        const double parts[] = {
            fmu_modulus(d_amplitude + 2 * j) / most, d_inputs->force[j] / force,
            d_inputs->force_rate[j] / (omega * force), d_inputs->frequency[j] / omega,
            d_inputs->frequency_rate[j] / (omega * omega), d_inputs->phase[j],
            d_inputs->phase_rate[j] / omega, d_inputs->angle[j],
            d_inputs->limit_scale_rate / omega};
        for (size_t k = 0; k < sizeof parts / sizeof *parts; k++) size = fmax(size, fabs(parts[k]));
    }
    return size;
}

static sm_status motion_at(fmu_instance *instance, const double *d_amplitude,
                           const sm_inputs *d_inputs, double h, double *motion) {
    sm_inputs inputs = fmu_inputs_now(instance);
    const double *change = (const double *)(const void *)d_inputs;
    double amplitude[2 * SM_MODES], rate[FMU_STATES], power[2];
    for (int k = 0; k < 2 * SM_MODES; k++)
        amplitude[k] = instance->outputs[1 + k] + h * d_amplitude[k];
    for (size_t k = 0; k < FMU_INPUTS; k++) ((double *)(void *)&inputs)[k] += h * change[k];
    const sm_status status =
        sm_slow_flow_rate(&instance->flow, &inputs, 0.0, amplitude, rate, power);
    if (status != SM_OK) return status;
    return sm_component_recent_motion(instance->component, &inputs, amplitude, rate, 1, motion);
}

fmu_status fmu_motion_directional(fmu_instance *instance, const double *d_amplitude,
                                  const sm_inputs *d_inputs, double *d_motion) {
    const size_t count = instance->output_count - SM_OUTPUTS_FIXED;
    const double size = size_of(instance, d_amplitude, d_inputs);
    if (!instance->motion.wanted || !(size > 0.0)) return FMU_OK; /* they are 0 */
    double *before = calloc(count, sizeof *before);
    if (!before) return fmu_say(instance, FMU_ERROR, "derivative: out of memory");
    const double h = STEP / size;
    sm_status status = motion_at(instance, d_amplitude, d_inputs, -h, before);
    if (status == SM_OK) status = motion_at(instance, d_amplitude, d_inputs, h, d_motion);
    for (size_t k = 0; status == SM_OK && k < count; k++)
        d_motion[k] = (d_motion[k] - before[k]) / (2.0 * h);
    free(before);
    if (status == SM_OK) return FMU_OK;
    return fmu_say(instance, FMU_DISCARD, "derivative of contact motion at t = %g s: %s",
                   instance->outputs[0], sm_message(status));
}
