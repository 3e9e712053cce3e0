/* From what was set to what is read: start values, inputs, outputs, derivatives, steps. */
#include "instance/instance.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* As in rom/frequencies.py. */
#define FARTHEST_FORCING 1.5
#define NEAR_TWO_PI 0.25
#define TWO_PI 6.283185307179586
#define HINT 64

/* The core's status as one of FMI's, logged unless it is OK. A computation that fails may succeed
 * with a shorter step; a wrong value cannot. */
static fmu_status status_of(const fmu_instance *instance, sm_status status, const char *doing) {
    if (status == SM_OK) return FMU_OK;
    if (status == SM_OUTSIDE_TABLE) return fmu_say_outside(instance, instance->outputs, doing, "");
    const int retry = status == SM_STEP_TOO_SMALL || status == SM_NOT_CONVERGED
                      || status == SM_NOT_FINITE; /* inputs have moved too far */
    return fmu_say(instance, retry ? FMU_DISCARD : FMU_ERROR, "%s at t = %g s: %s", doing,
                   instance->outputs[0], sm_message(status));
}

void fmu_scale_forces(const fmu_instance *instance, sm_inputs *inputs) {
    for (int j = 0; j < SM_MODES; j++) {
        inputs->force[j] *= instance->model->force_factor[j];
        inputs->force_rate[j] *= instance->model->force_factor[j];
    }
}

/* The inputs as the core takes them: modal forces. */
static sm_inputs modal_inputs(const fmu_instance *instance) {
    sm_inputs inputs = instance->inputs;
    fmu_scale_forces(instance, &inputs);
    return inputs;
}

/* An integrator may try a time at which a frequency has moved too far, and then another time. */
static fmu_status too_far(const fmu_instance *instance, const sm_inputs *inputs) {
    const int moves = inputs->frequency_rate[0] != 0.0 || inputs->frequency_rate[1] != 0.0;
    return moves && instance->state & (FMU_EVENTS | FMU_CONTINUOUS) ? FMU_DISCARD : FMU_ERROR;
}

/* Frequencies of two modes, from inputs to others, may neither be equal nor pass each other. */
static fmu_status check_apart(const fmu_instance *instance, const sm_inputs *from,
                              const sm_inputs *to) {
    const double before = from->frequency[1] - from->frequency[0];
    const double after = to->frequency[1] - to->frequency[0];
    const int apart = (before > 0.0 && after > 0.0) || (before < 0.0 && after < 0.0);
    if (instance->model->modes < SM_MODES || apart) return FMU_OK;
    return fmu_say(instance, too_far(instance, to),
                   "frequency_A, frequency_B: must differ at all times, the same one staying above");
}

/* What to give where a factor 2 pi explains how far a frequency is from its mode; "" if not. */
static const char *unit_hint(double frequency, double natural, char hint[HINT]) {
    const double ratio = frequency / natural;
    hint[0] = 0;
    if (fabs(ratio * TWO_PI - 1.0) < NEAR_TWO_PI)
        snprintf(hint, HINT, "; if that is in Hz, give %.4g rad/s", frequency * TWO_PI);
    else if (fabs(ratio / TWO_PI - 1.0) < NEAR_TWO_PI)
        snprintf(hint, HINT, "; a factor 2 pi explains it: give %.4g rad/s", frequency / TWO_PI);
    return hint;
}

/* Forcing frequencies must be such as the slow flow of their mode can follow, see
 * rom/frequencies.py. The first that is far from its mode is logged. */
static fmu_status check_carriers(fmu_instance *instance, const sm_inputs *inputs) {
    const fmu_model *model = instance->model;
    char hint[HINT];
    for (int j = 0; j < model->modes; j++) {
        const double natural = model->flow.natural[j], frequency = inputs->frequency[j];
        if (frequency * FARTHEST_FORCING >= natural && frequency <= FARTHEST_FORCING * natural)
            continue;
        const int32_t slot = (int32_t)(offsetof(sm_inputs, frequency) / sizeof(double)) + j;
        const char *name = fmu_name_of(instance, FMU_INPUT, slot);
        const double low = model->carrier_range[0] * natural;
        const double high = model->carrier_range[1] * natural;
        unit_hint(frequency, natural, hint);
        if (!(frequency >= low && frequency <= high))
            return fmu_say(instance, too_far(instance, inputs),
                           "%s: must be %.6g to %.6g rad/s, got %g%s", name, low, high, frequency,
                           hint);
        if (instance->far_forcing_logged) continue;
        instance->far_forcing_logged = 1;
        fmu_say(instance, FMU_WARNING,
                "%s: far from its mode, %.4g rad/s is %.3g times the natural frequency of %.4g "
                "rad/s, outside %.2g to %g%s",
                name, frequency, frequency / natural, natural, 1.0 / FARTHEST_FORCING,
                FARTHEST_FORCING, hint);
    }
    return check_apart(instance, inputs, inputs);
}

/* A component with the present parameters. */
static fmu_status build(fmu_instance *instance) {
    const size_t size = sizeof instance->built_with;
    if (instance->component && memcmp(instance->built_with, instance->parameters, size) == 0)
        return FMU_OK;
    sm_component *built;
    memcpy(instance->flow.damping, instance->parameters + FMU_DAMPING,
           sizeof instance->flow.damping);
    instance->motion.wanted = instance->parameters[FMU_CONTACT_WANTED] != 0.0;
    const sm_status status =
        sm_component_shared_create(&instance->flow, &instance->model->contact, &instance->motion,
                                   instance->parameters[FMU_TOLERANCE], &built);
    if (status != SM_OK) return status_of(instance, status, "model");
    sm_component_free(instance->component);
    instance->component = built;
    memcpy(instance->built_with, instance->parameters, size);
    return FMU_OK;
}

/* Brings the start values into effect. */
static fmu_status start(fmu_instance *instance) {
    if (instance->started) return FMU_OK;
    memset(instance->outputs, 0, instance->output_count * sizeof *instance->outputs);
    instance->outputs[0] = instance->start;
    fmu_hold_inputs(instance);
    memcpy(instance->outputs + 1, instance->amplitude, sizeof instance->amplitude);
    fmu_status built = check_carriers(instance, &instance->inputs);
    if (built == FMU_OK) built = build(instance);
    if (built != FMU_OK) return built;
    const sm_inputs inputs = modal_inputs(instance);
    sm_status status = sm_component_set_inputs(instance->component, &inputs);
    if (status == SM_OK)
        status = sm_component_reset(instance->component, instance->start, instance->amplitude);
    if (status != SM_OK) return status_of(instance, status, "start values");
    instance->started = instance->inputs_current = 1;
    instance->outputs_current = instance->rates_current = 0;
    instance->motion_current = FMU_NO_MOTION;
    return FMU_OK;
}

static sm_status pass_inputs(fmu_instance *instance) {
    if (instance->inputs_current) return SM_OK;
    const sm_inputs inputs = modal_inputs(instance);
    const sm_status status = sm_component_set_inputs(instance->component, &inputs);
    instance->inputs_current = status == SM_OK;
    return status;
}

static fmu_status apply_inputs(fmu_instance *instance) {
    const fmu_status status = check_carriers(instance, &instance->inputs);
    return status == FMU_OK ? status_of(instance, pass_inputs(instance), "inputs") : status;
}

sm_inputs fmu_inputs_now(const fmu_instance *instance) {
    sm_inputs inputs = modal_inputs(instance);
    memcpy(inputs.angle, instance->outputs + 5, sizeof inputs.angle);
    return inputs;
}

/* Rates of amplitudes become those of all states. */
static void complete_rates(int modes, const double *frequency, double dissipated, double *rates) {
    for (int j = 0; j < modes; j++) rates[2 * modes + j] = frequency[j];
    rates[3 * modes] = dissipated;
}

fmu_status fmu_evaluate_rates(fmu_instance *instance) {
    fmu_status status = start(instance);
    if (status != FMU_OK || instance->rates_current) return status;
    status = check_carriers(instance, &instance->inputs);
    if (status != FMU_OK) return status;
    double *outputs = instance->outputs, power[2];
    const sm_inputs inputs = fmu_inputs_now(instance);
    status = status_of(instance,
                       sm_slow_flow_rate(&instance->flow, &inputs, 0.0, outputs + 1,
                                         instance->rates, power),
                       "derivatives");
    if (status != FMU_OK) return status;
    complete_rates(instance->model->modes, inputs.frequency, power[1], instance->rates);
    if (instance->interface == FMU_MODEL_EXCHANGE) memcpy(outputs + 7, power, sizeof power);
    instance->rates_current = 1;
    return FMU_OK;
}

fmu_status fmu_evaluate_directional(fmu_instance *instance, const double *d_amplitude,
                                    const sm_inputs *d_inputs, double *d_rates,
                                    double d_power[2]) {
    const sm_inputs inputs = fmu_inputs_now(instance);
    const sm_slow_point at = {instance->outputs + 1, &inputs}, along = {d_amplitude, d_inputs};
    const fmu_status status =
        status_of(instance,
                  sm_slow_flow_directional(&instance->flow, &at, &along, d_rates, d_power),
                  "directional derivative");
    if (status == FMU_OK)
        complete_rates(instance->model->modes, d_inputs->frequency, d_power[1], d_rates);
    return status;
}

fmu_status fmu_evaluate_outputs(fmu_instance *instance) {
    if (instance->started && instance->outputs_current) return FMU_OK;
    fmu_status status = start(instance);
    if (status != FMU_OK) return status;
    if (instance->interface == FMU_MODEL_EXCHANGE) {
        status = fmu_evaluate_rates(instance);
    } else {
        status = apply_inputs(instance);
        if (status != FMU_OK) return status;
        status = status_of(instance,
                           sm_component_slow_outputs(instance->component, instance->outputs),
                           "outputs");
    }
    instance->outputs_current = status == FMU_OK;
    return status;
}

/* Contacts are marched where they are read. In Model Exchange that is to the present point from
 * rest: what happened before the last few periods does not matter to them. */
fmu_status fmu_evaluate_motion(fmu_instance *instance, fmu_motion_known needed) {
    fmu_status status = fmu_evaluate_outputs(instance);
    if (status != FMU_OK || instance->motion_current >= needed || !instance->motion.wanted)
        return status;
    double *outputs = instance->outputs, *motion = outputs + SM_OUTPUTS_FIXED;
    fmu_motion_known known = FMU_ALL_MOTION;
    if (instance->interface == FMU_CO_SIMULATION) {
        known = needed;
        status = status_of(instance,
                           sm_component_motion(instance->component, known == FMU_ALL_MOTION, motion),
                           "contact motion");
    } else {
        const sm_inputs inputs = fmu_inputs_now(instance);
        status = status_of(instance,
                           sm_component_recent_motion(instance->component, &inputs, outputs + 1,
                                                      instance->rates, 0, motion),
                           "contact motion");
    }
    instance->motion_current = status == FMU_OK ? known : FMU_NO_MOTION;
    return status;
}

void fmu_advance_inputs(sm_inputs *inputs, double duration) {
    for (int j = 0; j < SM_MODES; j++) {
        inputs->force[j] += inputs->force_rate[j] * duration;
        inputs->frequency[j] += inputs->frequency_rate[j] * duration;
        inputs->phase[j] += inputs->phase_rate[j] * duration;
    }
    inputs->limit_scale += inputs->limit_scale_rate * duration;
}

fmu_status fmu_evaluate_step(fmu_instance *instance, double duration) {
    sm_inputs later = instance->inputs;
    fmu_advance_inputs(&later, duration);
    fmu_status status = apply_inputs(instance);
    if (status == FMU_OK && isfinite(duration)) status = check_carriers(instance, &later);
    if (status == FMU_OK && isfinite(duration))
        status = check_apart(instance, &instance->inputs, &later);
    if (status != FMU_OK) return status;
    double taken = duration;
    sm_status stepped = instance->observer.update ? fmu_step_observed(instance, &taken)
                                                  : sm_component_step(instance->component, duration);
    if (stepped == SM_OK && taken < duration) {
        later = instance->inputs;
        fmu_advance_inputs(&later, taken);
    }
    if (stepped == SM_OUTSIDE_TABLE && instance->early_return) {
        const double reached = fmu_step_partly(instance, duration);
        if (reached < 0.0) return fmu_say(instance, FMU_ERROR, "step: cannot go back");
        if (reached > 0.0) {
            later = instance->inputs;
            fmu_advance_inputs(&later, reached);
            stepped = SM_OK;
            fmu_say(instance, FMU_OK, "step: returns %g s early, where the friction table ends",
                    duration - reached);
        }
    }
    if (stepped == SM_OUTSIDE_TABLE) return fmu_refuse_step(instance, duration);
    status = status_of(instance, stepped, "step");
    if (status == FMU_DISCARD) fmu_note_refusal(instance, duration, 0);
    if (status != FMU_OK) return status;
    instance->terminated = 0;
    instance->inputs = later;
    instance->rates_current = 0;
    instance->motion_current = FMU_NO_MOTION;
    return status_of(instance, sm_component_slow_outputs(instance->component, instance->outputs),
                     "outputs");
}

void fmu_evaluate_inputs(fmu_instance *instance) {
    if (instance->started && instance->interface == FMU_CO_SIMULATION) pass_inputs(instance);
}

fmu_status fmu_retune(fmu_instance *instance, const double *parameters) {
    double *state = calloc(sm_component_state_count(instance->component), sizeof *state);
    if (!state) return fmu_say(instance, FMU_ERROR, "parameters: out of memory");
    fmu_evaluate_inputs(instance);
    sm_component_get_state(instance->component, state);
    const fmu_status status = fmu_evaluate_restore(instance, parameters, state);
    free(state);
    return status;
}

fmu_status fmu_evaluate_restore(fmu_instance *instance, const double *parameters,
                                const double *component_state) {
    double before[FMU_PARAMETERS];
    memcpy(before, instance->parameters, sizeof before);
    memcpy(instance->parameters, parameters, sizeof before);
    fmu_status status = build(instance);
    if (status == FMU_OK)
        status = status_of(instance, sm_component_set_state(instance->component, component_state),
                           "SetFMUState");
    if (status != FMU_OK) {
        memcpy(instance->parameters, before, sizeof before);
        return FMU_ERROR;
    }
    instance->inputs_current = instance->outputs_current = 0;
    instance->rates_current = 0;
    instance->motion_current = FMU_NO_MOTION;
    instance->terminated = 0;
    return FMU_OK;
}
