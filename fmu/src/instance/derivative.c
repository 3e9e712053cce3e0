/* Directional derivatives of derivatives and outputs by states and inputs. */
#include "instance/instance.h"

#include <string.h>

/* Changes along the seed, and what they do. */
typedef struct {
    double state[SM_OUTPUTS_FIXED]; /* of the outputs that are states */
    sm_inputs inputs;
    double rate[FMU_STATES], power[2];
} direction;

/* NULL if there is no such variable. */
static const fmu_variable *find(const fmu_instance *instance, uint32_t reference) {
    const int known = reference < (uint32_t)instance->model->variables;
    return known ? &instance->model->variable[reference] : NULL;
}

static fmu_status refuse(const fmu_instance *instance, fmu_status status, uint32_t reference,
                         const char *why) {
    return fmu_say(instance, status, "GetDirectionalDerivative: %s, value reference %lu, %s",
                   find(instance, reference) ? instance->model->name[reference] : "no variable",
                   (unsigned long)reference, why);
}

static int is_state(const fmu_variable *v) {
    return v->kind == FMU_START ||
           (v->kind == FMU_OUTPUT && (v->slot == 5 || v->slot == 6 || v->slot == 9));
}

static fmu_status read_seed(const fmu_instance *instance, const uint32_t *known, size_t count,
                            const double *seed, direction *along) {
    for (size_t k = 0; k < count; k++) {
        const fmu_variable *v = find(instance, known[k]);
        if (v && is_state(v))
            along->state[v->slot] += seed[k];
        else if (v && v->kind == FMU_INPUT)
            ((double *)(void *)&along->inputs)[v->slot] += seed[k];
        else
            return refuse(instance, FMU_ERROR, known[k], "is neither a state nor an input");
    }
    fmu_scale_forces(instance, &along->inputs);
    memcpy(along->inputs.angle, along->state + 5, sizeof along->inputs.angle);
    return FMU_OK;
}

/* Of |a| or arg a, not at a = 0. */
static double polar_sensitivity(int32_t kind, const double *a, const double *d) {
    if (kind == FMU_MODULUS) return (a[0] * d[0] + a[1] * d[1]) / fmu_modulus(a);
    return (a[0] * d[1] - a[1] * d[0]) / (a[0] * a[0] + a[1] * a[1]);
}

static fmu_status find_sensitivity(const fmu_instance *instance, uint32_t unknown,
                                   const direction *along, double *sensitivity) {
    const fmu_variable *v = find(instance, unknown);
    if (!v) return refuse(instance, FMU_ERROR, unknown, "has no derivative");
    if (is_state(v)) {
        *sensitivity = along->state[v->slot];
    } else if (v->kind == FMU_RATE) {
        *sensitivity = along->rate[v->slot];
    } else if (v->kind == FMU_OUTPUT && (v->slot == 7 || v->slot == 8)) {
        *sensitivity = along->power[v->slot - 7];
    } else if (v->kind == FMU_MODULUS || v->kind == FMU_PHASE) {
        const int place = 1 + 2 * v->slot;
        const double *a = instance->outputs + place;
        if (!(a[0] * a[0] + a[1] * a[1] > 0.0))
            return refuse(instance, FMU_DISCARD, unknown,
                          "has no derivative where the amplitude is zero");
        *sensitivity = polar_sensitivity(v->kind, a, along->state + place);
    } else {
        const int marched = v->kind == FMU_OUTPUT && v->slot >= SM_OUTPUTS_FIXED;
        return refuse(instance, FMU_ERROR, unknown,
                      marched ? "has no derivative: contacts are marched over the last periods"
                              : "has no derivative");
    }
    return FMU_OK;
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
    for (size_t k = 0; status == FMU_OK && k < unknowns; k++)
        status = find_sensitivity(instance, unknown[k], &along, &sensitivity[k]);
    return status;
}
