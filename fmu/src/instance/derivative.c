/* Directional and adjoint derivatives of state derivatives and outputs by states and inputs, and
 * derivatives of outputs by time. */
#include "instance/instance.h"

#include "base/check.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A direction of states and inputs, and the changes of all else along it. */
typedef struct {
    double state[SM_OUTPUTS_FIXED]; /* of the outputs that are states */
    sm_inputs inputs;               /* forces in the importer's units until `follow` */
    double rate[FMU_STATES], power[2];
    double *motion; /* of contacts and DOFs, from malloc; NULL if no unknown needs it */
    int from_rest;  /* a modulus that is 0 grows, its phase does not change */
} direction;

/* Returns NULL if there is no such variable. */
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

static fmu_status no_memory(const fmu_instance *instance) {
    return fmu_say(instance, FMU_ERROR, "derivative: out of memory");
}

static int is_state(const fmu_variable *v) {
    const int angle = v->slot >= FMU_ANGLE && v->slot < FMU_ANGLE + SM_MODES;
    return v->kind == FMU_START || (v->kind == FMU_OUTPUT && (angle || v->slot == FMU_ENERGY));
}

static int is_motion(const fmu_variable *v) {
    return v && v->kind == FMU_OUTPUT && v->slot >= SM_OUTPUTS_FIXED;
}

/* ---- contact motion -------------------------------------------------------------------- */

/* Returns the size of a direction relative to the largest amplitudes, forces and frequencies. */
static double size_of(const fmu_instance *instance, const direction *along) {
    const sm_inputs *d = &along->inputs;
    double range[SM_MODES];
    fmu_table_range(instance, range);
    double size = fabs(d->limit_scale) / instance->run.inputs.limit_scale;
    for (int j = 0; j < instance->model->modes; j++) {
        const double omega = instance->flow.natural[j], force = omega * omega * range[j];
        const double parts[] = {
            fmu_modulus(along->state + FMU_AMPLITUDE + 2 * j) / range[j],
            d->force[j] / force, d->force_rate[j] / (omega * force),
            d->frequency[j] / omega, d->frequency_rate[j] / (omega * omega),
            d->phase[j], d->phase_rate[j] / omega, d->angle[j], d->limit_scale_rate / omega};
        for (size_t k = 0; k < sizeof parts / sizeof *parts; k++)
            size = fmax(size, fabs(parts[k]));
    }
    return size;
}

/* Marches the motion over the last few periods, at a distance h along the direction. */
static sm_status motion_at(fmu_instance *instance, const direction *along, double h,
                           double *motion) {
    sm_inputs inputs = fmu_inputs_now(instance);
    const double *change = (const double *)(const void *)&along->inputs;
    double amplitude[2 * SM_MODES], rate[FMU_STATES], power[2];
    for (int k = 0; k < 2 * SM_MODES; k++)
        amplitude[k] =
            instance->outputs[FMU_AMPLITUDE + k] + h * along->state[FMU_AMPLITUDE + k];
    for (size_t k = 0; k < SM_INPUT_DOUBLES; k++) fmu_slots(&inputs)[k] += h * change[k];
    SM_TRY(sm_slow_flow_rate(&instance->flow, &inputs, 0.0, amplitude, rate, power));
    return sm_component_recent_motion(instance->core->component, &inputs, amplitude, rate, 1, motion);
}

/* Finds the change of the motion by central differences of marches that have the same steps. Their
 * distance is relative to the largest amplitudes, forces and frequencies. */
static fmu_status differ_motion(fmu_instance *instance, direction *along) {
    const size_t count = instance->output_count - SM_OUTPUTS_FIXED;
    double *after = along->motion = calloc(instance->output_count, sizeof *after);
    double *before = calloc(count, sizeof *before);
    const double size = size_of(instance, along), h = 3e-4 / size;
    sm_status status = after && before ? SM_OK : SM_NO_MEMORY;
    if (status == SM_OK && instance->motion.wanted && size > 0.0) {
        status = motion_at(instance, along, -h, before);
        if (status == SM_OK) status = motion_at(instance, along, h, after);
        for (size_t k = 0; status == SM_OK && k < count; k++)
            after[k] = (after[k] - before[k]) / (2.0 * h);
    }
    free(before);
    if (status == SM_OK) return FMU_OK;
    if (status == SM_NO_MEMORY) return no_memory(instance);
    return fmu_say(instance, FMU_DISCARD, "derivative of contact motion at t = %g s: %s",
                   instance->outputs[0], sm_message(status));
}

/* ---- all variables --------------------------------------------------------------------- */

/* Returns the change of |a| or arg a, where a is not 0. */
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
    } else if (v->kind == FMU_OUTPUT && v->slot >= FMU_POWER && v->slot < FMU_POWER + 2) {
        *sensitivity = along->power[v->slot - FMU_POWER];
    } else if (v->kind == FMU_MODULUS || v->kind == FMU_PHASE) {
        const int place = FMU_AMPLITUDE + 2 * v->slot;
        const double *a = instance->outputs + place, *d = along->state + place;
        if (fmu_modulus(a) > 0.0)
            *sensitivity = polar_sensitivity(v->kind, a, d);
        else if (along->from_rest)
            *sensitivity = v->kind == FMU_MODULUS ? fmu_modulus(d) : 0.0;
        else
            return refuse(instance, FMU_DISCARD, unknown,
                          "has no derivative where the amplitude is zero");
    } else if (is_motion(v)) {
        *sensitivity = along->motion[v->slot - SM_OUTPUTS_FIXED];
    } else {
        return refuse(instance, FMU_ERROR, unknown, "has no derivative");
    }
    return FMU_OK;
}

/* Finds the changes of the unknowns along a direction whose state and inputs are set. */
static fmu_status follow(fmu_instance *instance, const fmu_derivative *d, direction *along) {
    const int modes = instance->model->modes;
    fmu_modal_inputs(instance, &along->inputs);
    memcpy(along->inputs.angle, along->state + FMU_ANGLE, sizeof along->inputs.angle);
    const sm_inputs inputs = fmu_inputs_now(instance);
    const sm_slow_point at = {instance->outputs + FMU_AMPLITUDE, &inputs};
    const sm_slow_point change = {along->state + FMU_AMPLITUDE, &along->inputs};
    const sm_status found =
        sm_slow_flow_directional(&instance->flow, &at, &change, along->rate, along->power);
    fmu_status status = fmu_status_of(instance, found, "directional derivative");
    memcpy(along->rate + 2 * modes, along->inputs.frequency, (size_t)modes * sizeof(double));
    along->rate[3 * modes] = along->power[1];
    int moves = 0;
    for (size_t k = 0; k < d->unknowns; k++) moves |= is_motion(find(instance, d->unknown[k]));
    if (status == FMU_OK && moves) status = differ_motion(instance, along);
    for (size_t k = 0; status == FMU_OK && k < d->unknowns; k++)
        status = find_sensitivity(instance, d->unknown[k], along, &d->value[k]);
    free(along->motion);
    return status;
}

/* Evaluates the outputs; refuses models that have no derivatives. */
static fmu_status prepare(fmu_instance *instance) {
    if (!instance->model->shares_tone) return fmu_evaluate_outputs(instance);
    return fmu_say(instance, FMU_ERROR, "derivative: not available for modes that share a tone");
}

fmu_status fmu_directional(fmu_instance *instance, const fmu_derivative *d) {
    direction along;
    memset(&along, 0, sizeof along);
    FMU_TRY(prepare(instance));
    for (size_t k = 0; k < d->knowns; k++) {
        const fmu_variable *v = find(instance, d->known[k]);
        if (v && is_state(v))
            along.state[v->slot] += d->seed[k];
        else if (v && v->kind == FMU_INPUT)
            fmu_slots(&along.inputs)[v->slot] += d->seed[k];
        else
            return refuse(instance, FMU_ERROR, d->known[k], "is neither a state nor an input");
    }
    return follow(instance, d, &along);
}

fmu_status fmu_adjoint(fmu_instance *instance, const fmu_derivative *d) {
    const double one = 1.0;
    double *column = calloc(d->unknowns + 1, sizeof *column);
    if (!column) return no_memory(instance);
    fmu_status status = FMU_OK;
    for (size_t k = 0; status == FMU_OK && k < d->knowns; k++) {
        const fmu_derivative by = {d->unknown, d->unknowns, &d->known[k], 1, &one, column};
        status = fmu_directional(instance, &by);
        d->value[k] = 0.0;
        for (size_t u = 0; u < d->unknowns; u++) d->value[k] += d->seed[u] * column[u];
    }
    free(column);
    return status;
}

fmu_status fmu_output_derivatives(fmu_instance *instance, const fmu_derivative *d) {
    for (size_t k = 0; k < d->unknowns; k++) {
        const fmu_variable *v = find(instance, d->unknown[k]);
        const int time = v && v->kind == FMU_OUTPUT && v->slot == 0;
        if (!v || v->type != FMU_REAL || !fmu_is_output(v) || time)
            return refuse(instance, FMU_ERROR, d->unknown[k], "is no output");
    }
    direction along;
    memset(&along, 0, sizeof along);
    along.from_rest = 1;
    FMU_TRY(prepare(instance));
    FMU_TRY(fmu_evaluate_rates(instance));
    for (size_t k = 0; k < fmu_state_count(instance); k++)
        along.state[fmu_state_place(instance, k)] = instance->rates[k];
    for (int32_t slot = 0; slot < (int32_t)SM_INPUT_DOUBLES; slot++)
        if (fmu_rate_slot(slot) >= 0)
            fmu_slots(&along.inputs)[slot] = fmu_slots(&instance->run.inputs)[fmu_rate_slot(slot)];
    return follow(instance, d, &along);
}

static int is_array(const fmu_instance *instance, uint32_t reference) {
    const fmu_variable *v = find(instance, reference);
    return v && v->type == FMU_ARRAY;
}

/* Returns the reference of the real output of this slot. */
static uint32_t output_of(const fmu_model *model, int32_t slot) {
    uint32_t k = 0;
    while (k + 1 < (uint32_t)model->variables &&
           (model->variable[k].kind != FMU_OUTPUT || model->variable[k].type != FMU_REAL ||
            model->variable[k].slot != slot))
        k++;
    return k;
}

uint32_t *fmu_scalars(const fmu_instance *instance, fmu_derivative *d) {
    const int32_t size = instance->model->contacts;
    size_t count = 0;
    for (size_t k = 0; k < d->unknowns; k++)
        count += is_array(instance, d->unknown[k]) ? (size_t)size : 1;
    uint32_t *scalar = calloc(count + 1, sizeof *scalar), *to = scalar;
    if (!scalar) no_memory(instance);
    for (size_t k = 0; scalar && k < d->unknowns; k++) {
        const uint32_t reference = d->unknown[k];
        if (!is_array(instance, reference)) *to++ = reference;
        for (int32_t e = 0; is_array(instance, reference) && e < size; e++)
            *to++ = output_of(instance->model, find(instance, reference)->slot + e);
    }
    d->unknown = scalar;
    d->unknowns = count;
    return scalar;
}
