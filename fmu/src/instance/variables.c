/* Access to variables by value reference. */
#include "instance/instance.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const TYPE_NAME[] = {"a real", "an enumeration", "a boolean", "an array"};

/* Returns whether the variable may be read within a step. */
static int is_observed(const fmu_instance *instance, uint32_t reference) {
    for (size_t k = 0; k < instance->observer.count; k++)
        if (instance->observer.wanted[k] == reference) return 1;
    return 0;
}

static const fmu_variable *find(const fmu_instance *instance, int32_t type, uint32_t reference) {
    if (reference >= (uint32_t)instance->model->variables) {
        fmu_say(instance, FMU_ERROR, "value reference %lu: there is no such variable",
                (unsigned long)reference);
        return NULL;
    }
    const fmu_variable *variable = &instance->model->variable[reference];
    if (variable->type != type) {
        fmu_say(instance, FMU_ERROR, "%s: is %s, not %s", instance->model->name[reference],
                TYPE_NAME[variable->type], TYPE_NAME[type]);
        return NULL;
    }
    if (instance->state == FMU_INTERMEDIATE && !is_observed(instance, reference)) {
        fmu_say(instance, FMU_ERROR, "%s: is not among the required intermediate variables",
                instance->model->name[reference]);
        return NULL;
    }
    return variable;
}

/* Evaluates a variable if its value is out of date. */
static fmu_status evaluate_for(fmu_instance *instance, const fmu_variable *variable) {
    if (variable->kind == FMU_INPUT || variable->kind == FMU_PARAMETER) return FMU_OK;
    const fmu_model *model = instance->model;
    const int32_t elastic = model->slow_outputs + 3 * model->contacts;
    if (variable->kind == FMU_OUTPUT && variable->slot >= model->slow_outputs)
        return fmu_evaluate_motion(
            instance, variable->slot < elastic ? FMU_CONTACT_MOTION : FMU_ALL_MOTION);
    FMU_TRY(fmu_evaluate_outputs(instance));
    return variable->kind == FMU_RATE ? fmu_evaluate_rates(instance) : FMU_OK;
}

/* Returns a carrier angle in [0, 2 pi), as in Co-Simulation; the state grows without bound. */
static double wrapped(double angle) {
    const double turn = SM_TWO_PI, rest = angle - turn * floor(angle / turn);
    return rest >= 0.0 && rest < turn ? rest : 0.0; /* outside by rounding */
}

/* Returns 1 if all amplitudes are well inside the friction table, 2 near its edge: beyond 90 % of
 * its range, as fmu/variables/listing.py says. */
static int32_t table_status(const fmu_instance *instance) {
    double range[SM_MODES];
    fmu_table_range(instance, range);
    for (int j = 0; j < instance->model->modes; j++) {
        const double edge = 0.9 * range[j] * instance->run.inputs.limit_scale;
        if (fmu_modulus(instance->outputs + FMU_AMPLITUDE + 2 * j) > edge) return 2;
    }
    return 1;
}

static double present_value(const fmu_instance *instance, const fmu_variable *variable) {
    const double *amplitude = instance->outputs + FMU_AMPLITUDE + 2 * variable->slot;
    switch (variable->kind) {
    case FMU_INPUT: return ((const double *)(const void *)&instance->run.inputs)[variable->slot];
    case FMU_PARAMETER: return instance->run.parameters[variable->slot];
    case FMU_RATE: return instance->rates[variable->slot];
    case FMU_MODULUS: return fmu_modulus(amplitude);
    case FMU_PHASE: return atan2(amplitude[1], amplitude[0]);
    case FMU_MARGIN: return table_status(instance);
    default: break;
    }
    const double value = instance->outputs[variable->slot];
    const int angle = variable->slot >= FMU_ANGLE && variable->slot < FMU_ANGLE + SM_MODES;
    return angle && instance->interface == FMU_MODEL_EXCHANGE ? wrapped(value) : value;
}

/* Wrong references are errors in any state, so they are found before anything is evaluated. */
fmu_status fmu_get_reals(fmu_instance *instance, const uint32_t *reference, size_t count,
                         double *value, size_t values, int arrays) {
    const fmu_model *model = instance->model;
    size_t needed = 0, size = (size_t)model->contacts;
    for (size_t k = 0; k < count; k++) {
        const int array = arrays && reference[k] < (uint32_t)model->variables &&
                          model->variable[reference[k]].type == FMU_ARRAY;
        if (!find(instance, array ? FMU_ARRAY : FMU_REAL, reference[k])) return FMU_ERROR;
        needed += array ? size : 1;
    }
    if (values != needed)
        return fmu_say(instance, FMU_ERROR, "values: must be %lu for these variables, got %lu",
                       (unsigned long)needed, (unsigned long)values);
    for (size_t k = 0; k < count; k++) {
        const fmu_variable *variable = &instance->model->variable[reference[k]];
        FMU_TRY(evaluate_for(instance, variable));
        if (variable->type == FMU_ARRAY) {
            memcpy(value, instance->outputs + variable->slot, size * sizeof *value);
            value += size;
        } else {
            *value++ = present_value(instance, variable);
        }
    }
    return FMU_OK;
}

fmu_status fmu_get_integers(fmu_instance *instance, int32_t type, const uint32_t *reference,
                            size_t count, int32_t *value) {
    for (size_t k = 0; k < count; k++)
        if (!find(instance, type, reference[k])) return FMU_ERROR;
    for (size_t k = 0; k < count; k++) {
        const fmu_variable *variable = &instance->model->variable[reference[k]];
        FMU_TRY(evaluate_for(instance, variable));
        value[k] = (int32_t)present_value(instance, variable);
    }
    return FMU_OK;
}

/* Returns what a value must be; NULL if it is. */
static const char *value_needs(const fmu_model *model, const fmu_variable *variable,
                               double value) {
    if (!isfinite(value)) return "finite";
    if (variable->kind == FMU_INPUT && fmu_input_is_positive(variable->slot) && !(value > 0.0))
        return "> 0";
    if (variable->kind == FMU_PARAMETER && variable->slot == FMU_SAMPLE)
        return value >= 0.0 && value <= model->layout->samples && value == floor(value)
                   ? NULL
                   : "the number of a sample, 0 to the maximum";
    if (variable->kind != FMU_PARAMETER || variable->slot != FMU_TOLERANCE) return NULL;
    return value >= FMU_LEAST_TOLERANCE && value <= FMU_MOST_TOLERANCE ? NULL : "1e-13 to 0.01";
}

/* Returns whether a variable may change between steps and at events, as real parameters may. */
static int is_tunable(const fmu_variable *variable) {
    return variable->kind == FMU_PARAMETER && variable->type == FMU_REAL;
}

static fmu_status may_set(const fmu_instance *instance, const fmu_variable *variable,
                          const char *name) {
    unsigned states = FMU_BEFORE_START;
    if (variable->kind == FMU_INPUT)
        states |= FMU_RUNNING;
    else if (is_tunable(variable))
        states |= FMU_EVENTS | FMU_STEPPING | FMU_STEP_EVENTS;
    else if (variable->kind != FMU_PARAMETER && variable->kind != FMU_START)
        return fmu_say(instance, FMU_ERROR, "%s: is not an input or parameter", name);
    return fmu_allow(instance, states, name);
}

static void set_value(fmu_instance *instance, const fmu_variable *variable, double value) {
    if (variable->kind == FMU_INPUT) {
        fmu_set_input(instance, variable->slot, value);
        return;
    }
    if (variable->kind == FMU_START)
        instance->run.amplitude[variable->slot - FMU_AMPLITUDE] = value;
    else
        instance->run.parameters[variable->slot] = value;
    instance->run.started = 0;
}

fmu_status fmu_set_reals(fmu_instance *instance, const uint32_t *reference, size_t count,
                         const double *value) {
    for (size_t k = 0; k < count; k++) {
        const fmu_variable *variable = find(instance, FMU_REAL, reference[k]);
        if (!variable) return FMU_ERROR;
        const char *name = instance->model->name[reference[k]];
        if (may_set(instance, variable, name) != FMU_OK) return FMU_ERROR;
        const char *needed = value_needs(instance->model, variable, value[k]);
        if (needed)
            return fmu_say(instance, FMU_ERROR, "%s: must be %s, got %g", name, needed, value[k]);
    }
    double parameters[FMU_PARAMETERS];
    const int running = (instance->state & FMU_RUNNING) != 0;
    int tuned = 0;
    memcpy(parameters, instance->run.parameters, sizeof parameters);
    for (size_t k = 0; k < count; k++) {
        const fmu_variable *variable = &instance->model->variable[reference[k]];
        if (!running || !is_tunable(variable)) continue;
        parameters[variable->slot] = value[k];
        tuned = 1;
    }
    if (tuned && fmu_retune(instance, parameters) != FMU_OK) return FMU_ERROR;
    for (size_t k = 0; k < count; k++) {
        const fmu_variable *variable = &instance->model->variable[reference[k]];
        if (!running || !is_tunable(variable)) set_value(instance, variable, value[k]);
    }
    return FMU_OK;
}

fmu_status fmu_set_integers(fmu_instance *instance, int32_t type, const uint32_t *reference,
                            size_t count, const int32_t *value) {
    for (size_t k = 0; k < count; k++) {
        const fmu_variable *variable = find(instance, type, reference[k]);
        if (!variable ||
            may_set(instance, variable, instance->model->name[reference[k]]) != FMU_OK)
            return FMU_ERROR;
    }
    for (size_t k = 0; k < count; k++)
        set_value(instance, &instance->model->variable[reference[k]], (double)(value[k] != 0));
    return FMU_OK;
}

fmu_status fmu_set_input_rates(fmu_instance *instance, const uint32_t *reference, size_t count,
                               const double *value) {
    for (size_t k = 0; k < count; k++) {
        const fmu_variable *variable = find(instance, FMU_REAL, reference[k]);
        if (!variable) return FMU_ERROR;
        const char *name = instance->model->name[reference[k]];
        if (variable->kind != FMU_INPUT || fmu_rate_slot(variable->slot) < 0)
            return fmu_say(instance, FMU_ERROR, "%s: is not an input that has a rate", name);
        if (!isfinite(value[k]))
            return fmu_say(instance, FMU_ERROR, "%s: its rate must be finite, got %g", name,
                           value[k]);
    }
    for (size_t k = 0; k < count; k++) {
        const fmu_variable *variable = &instance->model->variable[reference[k]];
        fmu_set_input(instance, fmu_rate_slot(variable->slot), value[k]);
    }
    return FMU_OK;
}
