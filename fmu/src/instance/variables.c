/* Access to variables by value reference. Either all values of a call are set or none. */
#include "instance/instance.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define EDGE 0.9 /* of the friction table's range: amplitudes beyond it are near the edge */

enum { INSIDE = 1, NEAR_EDGE }; /* of the enumeration */

static const char *const TYPE_NAME[] = {"a real", "an enumeration", "a boolean", "an array"};

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
    if (instance->state == FMU_INTERMEDIATE && !fmu_is_observed(instance, reference)) {
        fmu_say(instance, FMU_ERROR, "%s: is not among the required intermediate variables",
                instance->model->name[reference]);
        return NULL;
    }
    return variable;
}

/* What must be evaluated before the variable can be read. */
static fmu_status evaluate_for(fmu_instance *instance, const fmu_variable *variable) {
    const int32_t elastic = SM_OUTPUTS_FIXED + 3 * instance->model->contact.contacts;
    switch (variable->kind) {
    case FMU_INPUT:
    case FMU_PARAMETER: return FMU_OK;
    case FMU_RATE: {
        const fmu_status status = fmu_evaluate_outputs(instance);
        return status == FMU_OK ? fmu_evaluate_rates(instance) : status;
    }
    case FMU_OUTPUT:
        if (variable->slot < SM_OUTPUTS_FIXED) return fmu_evaluate_outputs(instance);
        return fmu_evaluate_motion(instance, variable->slot < elastic ? FMU_CONTACT_MOTION
                                                                      : FMU_ALL_MOTION);
    default: return fmu_evaluate_outputs(instance);
    }
}

const char *fmu_name_of(const fmu_instance *instance, int32_t kind, int32_t slot) {
    const fmu_model *model = instance->model;
    for (int32_t k = 0; k < model->variables; k++)
        if (model->variable[k].kind == kind && model->variable[k].slot == slot)
            return model->name[k];
    return "(a variable without a name)";
}

double fmu_modulus(const double amplitude[2]) {
    return sqrt(amplitude[0] * amplitude[0] + amplitude[1] * amplitude[1]);
}

/* A carrier angle in [0, 2 pi), as Co-Simulation has it; as a state it grows without end. */
static double wrapped(double angle) {
    const double turn = 6.283185307179586, rest = angle - turn * floor(angle / turn);
    return rest >= 0.0 && rest < turn ? rest : 0.0; /* either by rounding alone */
}

static double present_value(const fmu_instance *instance, const fmu_variable *variable) {
    const double *amplitude = instance->outputs + 1 + 2 * variable->slot;
    switch (variable->kind) {
    case FMU_INPUT: return ((const double *)(const void *)&instance->inputs)[variable->slot];
    case FMU_PARAMETER: return instance->parameters[variable->slot];
    case FMU_RATE: return instance->rates[variable->slot];
    case FMU_MODULUS: return fmu_modulus(amplitude);
    case FMU_PHASE: return atan2(amplitude[1], amplitude[0]);
    default: break;
    }
    const double value = instance->outputs[variable->slot];
    const int wraps = instance->interface == FMU_MODEL_EXCHANGE &&
                      (variable->slot == 5 || variable->slot == 6);
    return wraps ? wrapped(value) : value;
}

/* Before anything is evaluated: a wrong reference is an error, whatever the state. */
static fmu_status find_all(const fmu_instance *instance, int32_t type, const uint32_t *reference,
                           size_t count) {
    for (size_t k = 0; k < count; k++)
        if (!find(instance, type, reference[k])) return FMU_ERROR;
    return FMU_OK;
}

fmu_status fmu_get_reals(fmu_instance *instance, const uint32_t *reference, size_t count,
                         double *value) {
    if (find_all(instance, FMU_REAL, reference, count) != FMU_OK) return FMU_ERROR;
    for (size_t k = 0; k < count; k++) {
        const fmu_variable *variable = &instance->model->variable[reference[k]];
        const fmu_status status = evaluate_for(instance, variable);
        if (status != FMU_OK) return status;
        value[k] = present_value(instance, variable);
    }
    return FMU_OK;
}

static int is_array(const fmu_instance *instance, uint32_t reference) {
    const fmu_model *model = instance->model;
    return reference < (uint32_t)model->variables && model->variable[reference].type == FMU_ARRAY;
}

fmu_status fmu_get_floats(fmu_instance *instance, const uint32_t *reference, size_t count,
                          double *value, size_t values) {
    const size_t size = (size_t)instance->model->contact.contacts;
    size_t needed = 0;
    for (size_t k = 0; k < count; k++) {
        const int array = is_array(instance, reference[k]);
        if (!find(instance, array ? FMU_ARRAY : FMU_REAL, reference[k])) return FMU_ERROR;
        needed += array ? size : 1;
    }
    if (values != needed)
        return fmu_say(instance, FMU_ERROR, "values: the variables have %lu, not %lu",
                       (unsigned long)needed, (unsigned long)values);
    for (size_t k = 0; k < count; k++) {
        const fmu_variable *variable = &instance->model->variable[reference[k]];
        const fmu_status status = evaluate_for(instance, variable);
        if (status != FMU_OK) return status;
        if (variable->type == FMU_ARRAY) {
            memcpy(value, instance->outputs + variable->slot, size * sizeof *value);
            value += size;
        } else {
            *value++ = present_value(instance, variable);
        }
    }
    return FMU_OK;
}

/* The reference of an output of this slot. */
static uint32_t output_of(const fmu_model *model, int32_t slot) {
    uint32_t k = 0;
    while (k + 1 < (uint32_t)model->variables &&
           (model->variable[k].kind != FMU_OUTPUT || model->variable[k].type != FMU_REAL ||
            model->variable[k].slot != slot))
        k++;
    return k;
}

uint32_t *fmu_scalars(const fmu_instance *instance, const uint32_t *reference, size_t count,
                      size_t *scalars) {
    const fmu_model *model = instance->model;
    const size_t size = (size_t)model->contact.contacts;
    *scalars = 0;
    for (size_t k = 0; k < count; k++) *scalars += is_array(instance, reference[k]) ? size : 1;
    uint32_t *scalar = calloc(*scalars + 1, sizeof *scalar);
    if (!scalar) fmu_say(instance, FMU_ERROR, "derivative: out of memory");
    for (size_t k = 0, at = 0; scalar && k < count; k++) {
        if (!is_array(instance, reference[k])) {
            scalar[at++] = reference[k];
            continue;
        }
        const int32_t first = model->variable[reference[k]].slot;
        for (size_t e = 0; e < size; e++) scalar[at++] = output_of(model, first + (int32_t)e);
    }
    return scalar;
}

/* Whether an amplitude is near the edge of the friction table. */
static int32_t margin(const fmu_instance *instance) {
    const sm_table *table = &instance->flow.table;
    const double range[SM_MODES] = {
        table->node_a[table->count_a - 1],
        table->modes == SM_MODES ? table->node_b[table->count_b - 1] : 1.0};
    for (int j = 0; j < table->modes; j++) {
        const double *a = instance->outputs + 1 + 2 * j;
        const double edge = EDGE * range[j] * instance->inputs.limit_scale;
        if (a[0] * a[0] + a[1] * a[1] > edge * edge) return NEAR_EDGE;
    }
    return INSIDE;
}

fmu_status fmu_get_integers(fmu_instance *instance, int32_t type, const uint32_t *reference,
                            size_t count, int32_t *value) {
    if (find_all(instance, type, reference, count) != FMU_OK) return FMU_ERROR;
    for (size_t k = 0; k < count; k++) {
        const fmu_variable *variable = &instance->model->variable[reference[k]];
        const fmu_status status = evaluate_for(instance, variable);
        if (status != FMU_OK) return status;
        value[k] = variable->kind == FMU_MARGIN ? margin(instance)
                                                : (int32_t)present_value(instance, variable);
    }
    return FMU_OK;
}

/* NULL, or what a value must be. */
static const char *value_needs(const fmu_variable *variable, double value) {
    if (!isfinite(value)) return "finite";
    const int32_t slot = variable->slot;
    if (variable->kind == FMU_INPUT)
        return fmu_input_is_positive(slot) && !(value > 0.0) ? "> 0" : NULL;
    if (variable->kind != FMU_PARAMETER) return NULL;
    if (slot != FMU_TOLERANCE) return NULL; /* damping below 0: the mode is self-excited */
    return value >= 1e-13 && value <= 1e-2 ? NULL : "1e-13 to 0.01";
}

/* Between the steps of a component, or at an event. */
#define TUNABLE_IN (FMU_EVENTS | FMU_STEPPING | FMU_STEP_EVENTS)

static int is_tunable(const fmu_variable *variable) {
    return variable->kind == FMU_PARAMETER && variable->slot != FMU_CONTACT_WANTED;
}

static fmu_status may_set(const fmu_instance *instance, const fmu_variable *variable,
                          const char *name) {
    switch (variable->kind) {
    case FMU_INPUT: return fmu_allow(instance, FMU_BEFORE_START | FMU_RUNNING, name);
    case FMU_PARAMETER:
        return fmu_allow(instance, FMU_BEFORE_START | (is_tunable(variable) ? TUNABLE_IN : 0), name);
    case FMU_START: return fmu_allow(instance, FMU_BEFORE_START, name);
    default: return fmu_say(instance, FMU_ERROR, "%s: is not an input or parameter", name);
    }
}

static void set_value(fmu_instance *instance, const fmu_variable *variable, double value) {
    if (variable->kind == FMU_INPUT) {
        fmu_set_input(instance, variable->slot, value);
        return;
    }
    if (variable->kind == FMU_START)
        instance->amplitude[variable->slot - 1] = value;
    else
        instance->parameters[variable->slot] = value;
    instance->started = 0;
}

fmu_status fmu_set_reals(fmu_instance *instance, const uint32_t *reference, size_t count,
                         const double *value) {
    for (size_t k = 0; k < count; k++) {
        const fmu_variable *variable = find(instance, FMU_REAL, reference[k]);
        if (!variable) return FMU_ERROR;
        const char *name = instance->model->name[reference[k]];
        if (may_set(instance, variable, name) != FMU_OK) return FMU_ERROR;
        const char *needed = value_needs(variable, value[k]);
        if (needed)
            return fmu_say(instance, FMU_ERROR, "%s: must be %s, got %g", name, needed, value[k]);
    }
    double parameters[FMU_PARAMETERS];
    const int running = (instance->state & FMU_RUNNING) != 0;
    int tuned = 0;
    memcpy(parameters, instance->parameters, sizeof parameters);
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
