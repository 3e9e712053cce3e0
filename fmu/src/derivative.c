/* Directional derivatives of derivatives and outputs by states and inputs. */
#include "instance.h"

#include <string.h>

/* Changes along the seed, and what they do. */
typedef struct {
    double state[SM_OUTPUTS_FIXED]; /* of the outputs that are states */
    sm_inputs inputs;
    double rate[FMU_STATES], power[2];
} direction;

static fmu_status refuse(const fmu_instance *instance, uint32_t reference, const char *why) {
    const int known = reference < (uint32_t)instance->model.variables;
    return fmu_say(instance, FMU_ERROR, "GetDirectionalDerivative: %s, value reference %lu, %s",
                   known ? instance->model.name[reference] : "no variable",
                   (unsigned long)reference, why);
}

static int is_state(const fmu_variable *v) {
    return v->kind == FMU_START ||
           (v->kind == FMU_OUTPUT && (v->slot == 5 || v->slot == 6 || v->slot == 9));
}

static fmu_status read_seed(const fmu_instance *instance, const uint32_t *known, size_t count,
                            const double *seed, direction *along) {
    for (size_t k = 0; k < count; k++) {
        const fmu_variable *v = known[k] < (uint32_t)instance->model.variables
                                    ? &instance->model.variable[known[k]] : NULL;
        if (v && is_state(v))
            along->state[v->slot] += seed[k];
        else if (v && v->kind == FMU_INPUT)
            ((double *)(void *)&along->inputs)[v->slot] += seed[k];
        else
            return refuse(instance, known[k], "is neither a state nor an input");
    }
    fmu_scale_forces(instance, &along->inputs);
    memcpy(along->inputs.angle, along->state + 5, sizeof along->inputs.angle);
    return FMU_OK;
}

/* 0 if the variable has no derivative. */
static int sensitivity_of(const fmu_instance *instance, const fmu_variable *v,
                          const direction *along, double *sensitivity) {
    const double *a = instance->outputs + 1 + 2 * v->slot, *d = along->state + 1 + 2 * v->slot;
    if (is_state(v))
        *sensitivity = along->state[v->slot];
    else if (v->kind == FMU_RATE)
        *sensitivity = along->rate[v->slot];
    else if (v->kind == FMU_OUTPUT && (v->slot == 7 || v->slot == 8))
        *sensitivity = along->power[v->slot - 7];
    else if (v->kind == FMU_MODULUS || v->kind == FMU_PHASE) {
        const double square = a[0] * a[0] + a[1] * a[1];
        const double product = v->kind == FMU_MODULUS ? a[0] * d[0] + a[1] * d[1]
                                                      : a[0] * d[1] - a[1] * d[0];
        if (!(square > 0.0)) return 0;
        *sensitivity = v->kind == FMU_MODULUS ? product / fmu_modulus(a) : product / square;
    } else {
        return 0;
    }
    return 1;
}

fmu_status fmu_directional(fmu_instance *instance, const uint32_t *unknown, size_t unknowns,
                           const uint32_t *known, size_t knowns, const double *seed,
                           double *sensitivity) {
    direction along;
    memset(&along, 0, sizeof along);
    fmu_status status = fmu_evaluate_outputs(instance);
    if (status == FMU_OK) status = read_seed(instance, known, knowns, seed, &along);
    if (status == FMU_OK)
        status = fmu_evaluate_directional(instance, along.state + 1, &along.inputs, along.rate,
                                          along.power);
    for (size_t k = 0; status == FMU_OK && k < unknowns; k++) {
        const fmu_variable *v = unknown[k] < (uint32_t)instance->model.variables
                                    ? &instance->model.variable[unknown[k]] : NULL;
        if (!v || !sensitivity_of(instance, v, &along, &sensitivity[k]))
            return refuse(instance, unknown[k], "has no directional derivative here");
    }
    return status;
}
