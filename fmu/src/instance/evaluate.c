/* From values that were set to values that are read: start values, inputs, outputs, rates. */
#include "instance/instance.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* As in rom/frequencies.py. */
#define FARTHEST_FORCING 1.5 /* a frequency farther from its mode is logged */

fmu_status fmu_say_outside(const fmu_instance *instance, const double *outputs, const char *doing,
                           const char *consequence) {
    double end[SM_MODES], modulus[SM_MODES];
    fmu_table_range(instance, end);
    for (int j = 0; j < SM_MODES; j++) modulus[j] = fmu_modulus(outputs + FMU_AMPLITUDE + 2 * j);
    const int mode = modulus[1] * end[0] > modulus[0] * end[1]; /* nearest to its end, or beyond */
    const double force = instance->run.inputs.force[mode];
    char lower[FMU_MESSAGE / 4] = "";
    if (force != 0.0)
        snprintf(lower, sizeof lower, "lower %s, now %g, or ",
                 fmu_name_of(instance, FMU_INPUT, FMU_INPUT_SLOT(force) + mode), force);
    return fmu_say(instance, FMU_DISCARD,
                   "%s at t = %g s: an amplitude is outside the friction table%s: at t = %.6g s "
                   "%s is %.4g, the table ends at %.4g; %sexport the model with a larger range "
                   "(--range of slipmode fmu and explore, rom.tabulate amplitude=)",
                   doing, instance->outputs[0], consequence, outputs[0],
                   fmu_name_of(instance, FMU_MODULUS, mode), modulus[mode],
                   end[mode] * instance->run.inputs.limit_scale, lower);
}

/* A computation that fails may succeed with a shorter step; a wrong value cannot. */
fmu_status fmu_status_of(const fmu_instance *instance, sm_status status, const char *doing) {
    if (status == SM_OK) return FMU_OK;
    if (status == SM_OUTSIDE_TABLE) return fmu_say_outside(instance, instance->outputs, doing, "");
    const int retry = status == SM_STEP_TOO_SMALL || status == SM_NOT_CONVERGED
                      || status == SM_NOT_FINITE; /* inputs have moved too far */
    return fmu_say(instance, retry ? FMU_DISCARD : FMU_ERROR, "%s at t = %g s: %s", doing,
                   instance->outputs[0], sm_message(status));
}

/* Returns the status of a refused frequency. An integrator of Model Exchange may try a time at
 * which a frequency has moved too far, and then an earlier time. */
static fmu_status too_far(const fmu_instance *instance, const sm_inputs *inputs) {
    const int moves = inputs->frequency_rate[0] != 0.0 || inputs->frequency_rate[1] != 0.0;
    return moves && instance->state & FMU_EXCHANGE ? FMU_DISCARD : FMU_ERROR;
}

/* The frequencies of two modes must not be equal, nor pass each other between two inputs. */
static fmu_status check_apart(const fmu_instance *instance, const sm_inputs *from,
                              const sm_inputs *to) {
    const double before = from->frequency[1] - from->frequency[0];
    const double after = to->frequency[1] - to->frequency[0];
    const int apart = (before > 0.0 && after > 0.0) || (before < 0.0 && after < 0.0);
    if (instance->model->tones < SM_MODES || apart) return FMU_OK;
    return fmu_say(instance, too_far(instance, to),
                   "frequency_A, frequency_B: must differ at all times, and must not cross");
}

/* Writes advice if a frequency is a factor of about 2 pi from its mode; else "". */
static void unit_hint(double frequency, double natural, char hint[64]) {
    const double two_pi = SM_TWO_PI, ratio = frequency / natural;
    const double near = 0.25; /* a ratio so near to 2 pi is a mistaken unit */
    hint[0] = '\0';
    if (fabs(ratio * two_pi - 1.0) < near)
        snprintf(hint, 64, "; if that is in Hz, give %.4g rad/s", frequency * two_pi);
    else if (fabs(ratio / two_pi - 1.0) < near)
        snprintf(hint, 64, "; if a factor 2 pi was applied twice, give %.4g rad/s",
                 frequency / two_pi);
}

/* Refuses forcing frequencies that the slow flow cannot follow (rom/frequencies.py), and logs the
 * first frequency that is far from its mode. */
static fmu_status check_carriers(fmu_instance *instance, const sm_inputs *inputs) {
    const fmu_model *model = instance->model;
    char hint[64];
    for (int j = 0; j < model->tones; j++) {
        const double natural = model->flow.natural[j], frequency = inputs->frequency[j];
        const double *range = model->constants->carrier_range, middle = model->constants->middle[j];
        const double low = range[0] * middle, high = range[1] * middle;
        const int is_allowed = frequency >= low && frequency <= high;
        if (is_allowed && frequency * FARTHEST_FORCING >= natural &&
            frequency <= FARTHEST_FORCING * natural)
            continue;
        const char *name = fmu_name_of(instance, FMU_INPUT, FMU_INPUT_SLOT(frequency) + j);
        unit_hint(frequency, natural, hint);
        if (!is_allowed)
            return fmu_say(instance, too_far(instance, inputs),
                           "%s: must be %.6g to %.6g rad/s, got %g%s", name, low, high, frequency,
                           hint);
        if (instance->far_forcing_logged) continue;
        instance->far_forcing_logged = 1;
        fmu_say(instance, FMU_WARNING,
                "%s: is far from its mode: %.4g rad/s is %.3g times the natural frequency of %.4g "
                "rad/s, outside %.2g to %g times%s",
                name, frequency, frequency / natural, natural, 1.0 / FARTHEST_FORCING,
                FARTHEST_FORCING, hint);
    }
    return check_apart(instance, inputs, inputs);
}

/* Replaces the core by one with these parameters, unless it has them, and sets its state unless
 * that is NULL. If this fails, the instance is unchanged. */
static sm_status build(fmu_instance *instance, const double *parameters, const double *state) {
    const size_t size = sizeof instance->built_with;
    const int same =
        instance->core && memcmp(instance->built_with, parameters, size) == 0;
    sm_slow_flow flow;
    sm_motion motion;
    fmu_core *built = instance->core;
    sm_status status = SM_OK;
    fmu_set_parameters(instance->model, parameters, &flow, &motion);
    if (!same)
        status = fmu_core_create(instance->model, &flow, &motion, parameters[FMU_TOLERANCE], &built);
    if (status != SM_OK) return status;
    if (state) status = fmu_core_set_state(built, state);
    fmu_core *unused = status == SM_OK ? instance->core : built;
    if (!same) fmu_core_free(unused);
    if (status != SM_OK) return status;
    instance->flow = flow;
    instance->motion = motion;
    instance->core = built;
    memcpy(instance->built_with, parameters, size);
    return SM_OK;
}

static sm_status pass_inputs(fmu_instance *instance) {
    if (instance->inputs_current) return SM_OK;
    sm_inputs inputs = instance->run.inputs;
    fmu_modal_inputs(instance, &inputs);
    const sm_status status = fmu_core_set_inputs(instance->core, &inputs);
    instance->inputs_current = status == SM_OK;
    return status;
}

/* Applies the start values. */
static fmu_status start(fmu_instance *instance) {
    const double *amplitude = instance->run.amplitude;
    if (instance->run.started) return FMU_OK;
    memset(instance->outputs, 0, instance->output_count * sizeof *instance->outputs);
    instance->outputs[0] = instance->run.start;
    fmu_note_inputs(instance);
    memcpy(instance->outputs + FMU_AMPLITUDE, amplitude, sizeof instance->run.amplitude);
    FMU_TRY(check_carriers(instance, &instance->run.inputs));
    sm_status status = build(instance, instance->run.parameters, NULL);
    if (status != SM_OK) return fmu_status_of(instance, status, "model");
    instance->inputs_current = 0;
    status = pass_inputs(instance);
    if (status == SM_OK)
        status = fmu_core_reset(instance->core, instance->run.start, amplitude);
    if (status != SM_OK) return fmu_status_of(instance, status, "start values");
    instance->run.started = 1;
    fmu_outdate(instance);
    return FMU_OK;
}

fmu_status fmu_read_outputs(fmu_instance *instance) {
    return fmu_status_of(instance, fmu_core_slow_outputs(instance->core, instance->outputs),
                         "outputs");
}

static fmu_status apply_inputs(fmu_instance *instance) {
    FMU_TRY(check_carriers(instance, &instance->run.inputs));
    return fmu_status_of(instance, pass_inputs(instance), "inputs");
}

fmu_status fmu_evaluate_rates(fmu_instance *instance) {
    FMU_TRY(start(instance));
    if (instance->rates_current) return FMU_OK;
    FMU_TRY(check_carriers(instance, &instance->run.inputs));
    const int modes = instance->model->modes;
    double *outputs = instance->outputs, *rates = instance->rates, power[2];
    const sm_inputs inputs = fmu_inputs_now(instance);
    const sm_status found =
        sm_slow_flow_rate(&instance->flow, &inputs, 0.0, outputs + FMU_AMPLITUDE, rates, power);
    if (found != SM_OK) return fmu_status_of(instance, found, "derivatives");
    memcpy(rates + 2 * modes, inputs.frequency, (size_t)modes * sizeof *rates);
    rates[3 * modes] = power[1];
    if (instance->interface == FMU_MODEL_EXCHANGE)
        memcpy(outputs + FMU_POWER, power, sizeof power);
    instance->rates_current = 1;
    return FMU_OK;
}

fmu_status fmu_evaluate_outputs(fmu_instance *instance) {
    if (instance->run.started && instance->outputs_current) return FMU_OK;
    instance->outputs_current = 0;
    FMU_TRY(start(instance));
    if (instance->interface == FMU_MODEL_EXCHANGE) {
        FMU_TRY(fmu_evaluate_rates(instance));
    } else {
        FMU_TRY(apply_inputs(instance));
        FMU_TRY(fmu_read_outputs(instance));
    }
    instance->outputs_current = 1;
    return FMU_OK;
}

/* Contacts are marched when they are read. In Model Exchange the march covers the last few
 * periods, which the contacts remember. */
fmu_status fmu_evaluate_motion(fmu_instance *instance, fmu_motion_known needed) {
    FMU_TRY(fmu_evaluate_outputs(instance));
    if (instance->motion_current >= needed || !instance->motion.wanted) return FMU_OK;
    double *outputs = instance->outputs;
    sm_status marched;
    if (instance->interface == FMU_CO_SIMULATION) {
        marched = fmu_core_motion(instance->core, needed == FMU_ALL_MOTION, outputs);
    } else {
        const sm_inputs inputs = fmu_inputs_now(instance);
        needed = FMU_ALL_MOTION;
        marched = sm_component_recent_motion(instance->core->component, &inputs,
                                             outputs + FMU_AMPLITUDE, instance->rates, 0,
                                             outputs + SM_OUTPUTS_FIXED);
    }
    instance->motion_current = marched == SM_OK ? needed : FMU_NO_MOTION;
    return fmu_status_of(instance, marched, "contact motion");
}

fmu_status fmu_evaluate_step_inputs(fmu_instance *instance, double duration) {
    sm_inputs later = instance->run.inputs;
    fmu_advance_inputs(&later, duration);
    FMU_TRY(apply_inputs(instance));
    FMU_TRY(check_carriers(instance, &later));
    return check_apart(instance, &instance->run.inputs, &later);
}

fmu_status fmu_evaluate_inputs(fmu_instance *instance) {
    const int passes = instance->run.started && instance->interface == FMU_CO_SIMULATION;
    return passes ? fmu_status_of(instance, pass_inputs(instance), "inputs") : FMU_OK;
}

fmu_status fmu_retune(fmu_instance *instance, const double *parameters) {
    double *state = calloc(fmu_core_state_count(instance->core), sizeof *state);
    if (!state) return fmu_say(instance, FMU_ERROR, "parameters: out of memory");
    fmu_status status = fmu_evaluate_inputs(instance);
    fmu_core_get_state(instance->core, state);
    if (status == FMU_OK) status = fmu_evaluate_restore(instance, parameters, state, "parameters");
    free(state);
    return status;
}

fmu_status fmu_evaluate_restore(fmu_instance *instance, const double *parameters,
                                const double *core_state, const char *doing) {
    const sm_status status = build(instance, parameters, core_state);
    if (status != SM_OK) {
        fmu_status_of(instance, status, doing);
        return FMU_ERROR;
    }
    memcpy(instance->run.parameters, parameters, sizeof instance->run.parameters);
    instance->inputs_current = instance->terminated = 0;
    fmu_outdate(instance);
    return FMU_OK;
}
