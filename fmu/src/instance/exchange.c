/* Events, and Model Exchange. */
#include "instance/instance.h"

#include <math.h>
#include <string.h>

fmu_status fmu_enter_events(fmu_instance *instance) {
    if (instance->interface == FMU_CO_SIMULATION)
        return instance->event_mode
                   ? fmu_enter(instance, FMU_STEP_EVENTS)
                   : fmu_say(instance, FMU_ERROR,
                             "EnterEventMode: the instance was made without event mode");
    const sm_inputs inputs = fmu_inputs_now(instance);
    if (instance->state == FMU_CONTINUOUS) instance->run.previous = sm_force_of(&inputs);
    return fmu_enter(instance, FMU_EVENTS);
}

fmu_status fmu_update_discrete(fmu_instance *instance, int *states_changed) {
    if (instance->interface == FMU_CO_SIMULATION) { /* the next step finds the jump */
        *states_changed = 0;
        return FMU_OK;
    }
    const sm_inputs inputs = fmu_inputs_now(instance);
    double amplitude[2 * SM_MODES];
    memcpy(amplitude, instance->outputs + FMU_AMPLITUDE, sizeof amplitude);
    *states_changed =
        sm_force_discontinuity(&instance->flow, &instance->run.previous, &inputs, amplitude);
    if (!*states_changed) return FMU_OK;
    for (int k = 0; k < 2 * SM_MODES; k++)
        if (!isfinite(amplitude[k]))
            return fmu_say(instance, FMU_ERROR,
                           "the discontinuity of a force is too large: amplitude %g",
                           amplitude[k]);
    memcpy(instance->outputs + FMU_AMPLITUDE, amplitude, sizeof amplitude);
    instance->run.previous = sm_force_of(&inputs);
    fmu_outdate(instance);
    return FMU_OK;
}

fmu_status fmu_enter_continuous(fmu_instance *instance) {
    memset(&instance->run.previous, 0, sizeof instance->run.previous);
    return fmu_enter(instance, FMU_CONTINUOUS);
}

static fmu_status check(const fmu_instance *instance, const double *values, size_t count) {
    if (!values) return fmu_say(instance, FMU_ERROR, "states: the array is NULL");
    if (count == fmu_state_count(instance)) return FMU_OK;
    return fmu_say(instance, FMU_ERROR, "states: must be %lu, got %lu",
                   (unsigned long)fmu_state_count(instance), (unsigned long)count);
}

fmu_status fmu_set_time(fmu_instance *instance, double time) {
    if (!isfinite(time)) return fmu_say(instance, FMU_ERROR, "time: must be finite, got %g", time);
    instance->outputs[0] = time;
    instance->motion_current = FMU_NO_MOTION;
    fmu_move_inputs(instance);
    return FMU_OK;
}

fmu_status fmu_set_states(fmu_instance *instance, const double *states, size_t count) {
    if (check(instance, states, count) != FMU_OK) return FMU_ERROR;
    for (size_t k = 0; k < count; k++)
        if (!isfinite(states[k]))
            return fmu_say(instance, FMU_ERROR, "state %lu: must be finite, got %g",
                           (unsigned long)k, states[k]);
    for (size_t k = 0; k < count; k++) instance->outputs[fmu_state_place(instance, k)] = states[k];
    fmu_outdate(instance);
    return FMU_OK;
}

fmu_status fmu_get_states(fmu_instance *instance, double *states, size_t count) {
    FMU_TRY(check(instance, states, count));
    if (!instance->run.started) FMU_TRY(fmu_evaluate_outputs(instance));
    for (size_t k = 0; k < count; k++) states[k] = instance->outputs[fmu_state_place(instance, k)];
    return FMU_OK;
}

fmu_status fmu_get_rates(fmu_instance *instance, double *rates, size_t count) {
    if (check(instance, rates, count) != FMU_OK) return FMU_ERROR;
    FMU_TRY(fmu_evaluate_rates(instance));
    memcpy(rates, instance->rates, count * sizeof *rates);
    return FMU_OK;
}

fmu_status fmu_get_nominals(fmu_instance *instance, double *nominals, size_t count) {
    if (check(instance, nominals, count) != FMU_OK) return FMU_ERROR;
    memcpy(nominals, instance->model->constants->nominal, count * sizeof *nominals);
    return FMU_OK;
}
