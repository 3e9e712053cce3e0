/* Inputs of a slow flow at a time. Forces, frequencies, phases and the scale of the friction limits
 * change linearly in time over a step, so that the carrier angles are theta(t) = theta + Omega t +
 * Omega' t^2 / 2. Stages of time steps (dopri5.c) and entries.c call it. */
#include "slow/inputs.h"

#include "base/check.h"

sm_status sm_inputs_check(const sm_inputs *inputs, int modes) {
    if (!sm_all_finite((const double *)(const void *)inputs, SM_INPUT_DOUBLES))
        return SM_NOT_FINITE;
    sm_status status = sm_check_positive(inputs->limit_scale);
    for (int j = 0; status == SM_OK && j < modes; j++)
        status = sm_check_positive(inputs->frequency[j]);
    return status;
}

sm_inputs sm_inputs_after(const sm_inputs *inputs, int modes, double elapsed) {
    sm_inputs after = *inputs;
    double *value = (double *)(void *)&after;
    for (int j = modes; j < SM_MODES; j++)
        after.force[j] = after.frequency[j] = after.phase[j] = after.angle[j] =
            after.force_rate[j] = after.frequency_rate[j] = after.phase_rate[j] = 0.0;
    for (int j = 0; j < modes; j++)
        after.angle[j] += elapsed * (after.frequency[j] + 0.5 * elapsed * after.frequency_rate[j]);
    for (int k = 0; k < SM_INPUT_VALUES; k++)
        value[sm_value_place(k)] += elapsed * value[sm_rate_place(k)];
    return after;
}
