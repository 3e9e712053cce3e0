/* Directional and adjoint derivatives of derivatives and outputs by states and inputs, and the
 * derivatives of outputs by time. */
#include "instance/instance.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Changes along the seed, and what they do. */
typedef struct {
    double state[SM_OUTPUTS_FIXED]; /* of the outputs that are states */
    sm_inputs inputs;
    double rate[FMU_STATES], power[2];
    double *motion; /* of contacts and DOFs, from malloc; NULL: not asked for */
    int from_rest;  /* a modulus that is 0 grows, a phase there rests */
} direction;

/* NULL if there is no such variable. */
static const fmu_variable *find(const fmu_instance *instance, uint32_t reference) {
    const int known = reference < (uint32_t)instance->model->variables;
    return known ? &instance->model->variable[reference] : NULL;
}

static fmu_status refuse(const fmu_instance *instance, fmu_status status, uint32_t reference,
                         const char *why) {
    return fmu_say(instance, status, "derivative: %s, value reference %lu, %s",
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
    return FMU_OK;
}

static int is_marched(const fmu_variable *v) {
    return v && v->kind == FMU_OUTPUT && v->slot >= SM_OUTPUTS_FIXED;
}

/* Of |a| or arg a, not at a = 0. */
static double polar_sensitivity(int32_t kind, const double *a, const double *d) {
    if (kind == FMU_MODULUS) return (a[0] * d[0] + a[1] * d[1]) / fmu_modulus(a);
    return (a[0] * d[1] - a[1] * d[0]) / (a[0] * a[0] + a[1] * a[1]);
}

static fmu_status find_sensitivity(const fmu_instance *instance, uint32_t unknown,
                                   const direction *along, double *sensitivity) {
    const fmu_variable *v = find(instance, unknown);
    if (!v || v->type != FMU_REAL)
        return refuse(instance, FMU_ERROR, unknown, "has no derivative");
    if (is_state(v)) {
        *sensitivity = along->state[v->slot];
    } else if (v->kind == FMU_RATE) {
        *sensitivity = along->rate[v->slot];
    } else if (v->kind == FMU_OUTPUT && (v->slot == 7 || v->slot == 8)) {
        *sensitivity = along->power[v->slot - 7];
    } else if (v->kind == FMU_MODULUS || v->kind == FMU_PHASE) {
        const int place = 1 + 2 * v->slot;
        const double *a = instance->outputs + place, *d = along->state + place;
        const int rests = !(a[0] * a[0] + a[1] * a[1] > 0.0);
        if (rests && along->from_rest)
            *sensitivity = v->kind == FMU_MODULUS ? fmu_modulus(d) : 0.0;
        else if (rests)
            return refuse(instance, FMU_DISCARD, unknown,
                          "has no derivative where the amplitude is zero");
        else
            *sensitivity = polar_sensitivity(v->kind, a, d);
    } else if (is_marched(v)) {
        *sensitivity = along->motion[v->slot - SM_OUTPUTS_FIXED];
    } else {
        return refuse(instance, FMU_ERROR, unknown, "has no derivative");
    }
    return FMU_OK;
}

/* What the unknowns do along a direction whose state and inputs, in the importer's units, are set. */
static fmu_status follow(fmu_instance *instance, const uint32_t *unknown, size_t unknowns,
                         direction *along, double *sensitivity) {
    fmu_scale_forces(instance, &along->inputs);
    memcpy(along->inputs.angle, along->state + 5, sizeof along->inputs.angle);
    fmu_status status = fmu_evaluate_directional(instance, along->state + 1, &along->inputs,
                                                 along->rate, along->power);
    int marched = 0;
    for (size_t k = 0; k < unknowns; k++)
        if (is_marched(find(instance, unknown[k]))) marched = 1;
    if (status == FMU_OK && marched) {
        along->motion = calloc(instance->output_count, sizeof *along->motion);
        if (!along->motion) return fmu_say(instance, FMU_ERROR, "derivative: out of memory");
        status = fmu_motion_directional(instance, along->state + 1, &along->inputs, along->motion);
    }
    for (size_t k = 0; status == FMU_OK && k < unknowns; k++)
        status = find_sensitivity(instance, unknown[k], along, &sensitivity[k]);
    free(along->motion);
    return status;
}

fmu_status fmu_directional(fmu_instance *instance, const uint32_t *unknown, size_t unknowns,
                           const uint32_t *known, size_t knowns, const double *seed,
                           double *sensitivity) {
    direction along;
    memset(&along, 0, sizeof along);
    fmu_status status = fmu_evaluate_outputs(instance);
    if (status == FMU_OK) status = read_seed(instance, known, knowns, seed, &along);
    return status == FMU_OK ? follow(instance, unknown, unknowns, &along, sensitivity) : status;
}

fmu_status fmu_adjoint(fmu_instance *instance, const uint32_t *unknown, size_t unknowns,
                       const uint32_t *known, size_t knowns, const double *seed,
                       double *sensitivity) {
    double *column = calloc(unknowns + 1, sizeof *column);
    if (!column) return fmu_say(instance, FMU_ERROR, "derivative: out of memory");
    fmu_status status = FMU_OK;
    for (size_t k = 0; status == FMU_OK && k < knowns; k++) {
        const double one = 1.0;
        status = fmu_directional(instance, unknown, unknowns, &known[k], 1, &one, column);
        sensitivity[k] = 0.0;
        for (size_t u = 0; u < unknowns; u++) sensitivity[k] += seed[u] * column[u];
    }
    free(column);
    return status;
}

fmu_status fmu_output_derivatives(fmu_instance *instance, const uint32_t *reference, size_t count,
                                  double *value) {
    for (size_t k = 0; k < count; k++) {
        const fmu_variable *v = find(instance, reference[k]);
        const int output = v && v->type == FMU_REAL && v->kind != FMU_INPUT &&
                           v->kind != FMU_PARAMETER && v->kind != FMU_RATE;
        if (!output || (v->kind == FMU_OUTPUT && v->slot == 0))
            return refuse(instance, FMU_ERROR, reference[k], "is no output");
    }
    direction along;
    memset(&along, 0, sizeof along);
    along.from_rest = 1;
    fmu_status status = fmu_evaluate_outputs(instance);
    if (status == FMU_OK) status = fmu_evaluate_rates(instance);
    if (status != FMU_OK) return status;
    const int modes = instance->model->modes;
    memcpy(along.state + 1, instance->rates, 2 * (size_t)modes * sizeof(double));
    memcpy(along.state + 5, instance->rates + 2 * modes, (size_t)modes * sizeof(double));
    along.state[9] = instance->rates[3 * modes];
    const double *inputs = (const double *)(const void *)&instance->inputs;
    for (int32_t slot = 0; slot < (int32_t)FMU_INPUTS; slot++)
        if (fmu_rate_slot(slot) >= 0)
            ((double *)(void *)&along.inputs)[slot] = inputs[fmu_rate_slot(slot)];
    return follow(instance, reference, count, &along, value);
}
