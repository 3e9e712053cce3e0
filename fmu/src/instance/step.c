/* Steps of Co-Simulation, with the importer's callback, up to the end of the friction table. */
#include "instance/instance.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* [rad] of mode A: a hundredth of a cycle, below which slow time resolves nothing. Importers that
 * halve refused steps end here (test_fmu_discard.py). */
#define LEAST_REACH 0.06

fmu_status fmu_observe(fmu_instance *instance, const fmu_observer *observer,
                       const uint32_t *wanted, size_t count) {
    const fmu_model *model = instance->model;
    for (size_t k = 0; k < count; k++)
        if (wanted[k] >= (uint32_t)model->variables || !fmu_is_output(&model->variable[wanted[k]]))
            return fmu_say(instance, FMU_ERROR,
                           "required intermediate variables: value reference %lu is no output",
                           (unsigned long)wanted[k]);
    uint32_t *kept = calloc(count + 1, sizeof *kept);
    if (!kept)
        return fmu_say(instance, FMU_ERROR, "required intermediate variables: out of memory");
    if (count > 0) memcpy(kept, wanted, count * sizeof *kept);
    instance->observer = *observer;
    instance->observer.wanted = kept;
    instance->observer.count = count;
    return FMU_OK;
}

/* Calls the importer back; returns the end of the step, which it may move. */
static double show(fmu_instance *instance, const sm_inputs *inputs, double end) {
    const double now = instance->outputs[0];
    double wanted = now;
    instance->run.inputs = *inputs;
    instance->rates_current = 0;
    instance->motion_current = FMU_NO_MOTION;
    instance->state = FMU_INTERMEDIATE;
    const int may_end = instance->early_return && now < end;
    const int ends = instance->observer.update(&instance->observer, now, may_end, &wanted);
    instance->state = FMU_STEPPING;
    if (!ends) return end;
    return wanted > now ? fmin(wanted, end) : now;
}

/* Remembers a discarded step. Another try ends the simulation if no step can be done, or if the
 * step is at least as long as before. */
static void note_refusal(fmu_instance *instance, double duration, int stuck) {
    const double now = instance->outputs[0];
    const int again = instance->refused_at == now && duration >= instance->refused;
    instance->terminated = stuck || again;
    instance->refused_at = now;
    instance->refused = duration;
}

static fmu_status refuse(fmu_instance *instance, double duration, sm_status status,
                         const double *reached) {
    if (status != SM_OUTSIDE_TABLE) {
        const fmu_status refused = fmu_status_of(instance, status, "step");
        if (refused == FMU_DISCARD) note_refusal(instance, duration, 0);
        return refused;
    }
    const double advanced = reached[0] - instance->outputs[0];
    const int stuck = advanced * instance->run.inputs.frequency[0] < LEAST_REACH;
    note_refusal(instance, duration, stuck);
    return fmu_say_outside(instance, reached, "step", stuck ? ", however short the step" : "");
}

/* Advances by internal steps; `duration` becomes the time advanced. Where the friction table ends,
 * the integrator shortens its steps to 1e-3 rad of mode A and stops there. If the step fails, or
 * stops before LEAST_REACH, the instance is unchanged. */
static fmu_status march(fmu_instance *instance, double *duration) {
    fmu_core *core = instance->core;
    const sm_inputs begun = instance->run.inputs;
    const size_t slow = (size_t)instance->model->slow_outputs;
    double *now = instance->outputs;
    const double start = now[0], whole = start + *duration;
    double end = whole;
    double *state = calloc(fmu_core_state_count(core) + 2 * slow, sizeof *state);
    if (!state) return fmu_say(instance, FMU_ERROR, "step: out of memory");
    double *before = state + fmu_core_state_count(core), *reached = before + slow;
    fmu_core_get_state(core, state);
    memcpy(before, now, slow * sizeof *now);
    sm_status marched = SM_OK;
    while (marched == SM_OK && now[0] < end) {
        marched = fmu_core_advance(core, end - now[0]);
        if (marched == SM_OK) marched = fmu_core_slow_outputs(core, now);
        if (marched != SM_OK || !instance->observer.update) continue;
        sm_inputs moved = begun;
        fmu_advance_inputs(&moved, now[0] - start);
        end = show(instance, &moved, end);
    }
    instance->run.inputs = begun;
    fmu_status status = FMU_OK;
    if (marched == SM_OK) {
        if (end < whole) *duration = end - start;
    } else if (marched == SM_OUTSIDE_TABLE && instance->early_return &&
               (now[0] - start) * begun.frequency[0] >= LEAST_REACH) {
        fmu_say(instance, FMU_OK, "step: returns %g s early, where the friction table ends",
                whole - now[0]);
        *duration = now[0] - start;
    } else {
        memcpy(reached, now, slow * sizeof *now);
        memcpy(now, before, slow * sizeof *now);
        fmu_core_set_state(core, state);
        instance->rates_current = 0;
        instance->motion_current = FMU_NO_MOTION;
        status = refuse(instance, *duration, marched, reached);
    }
    free(state);
    return status;
}

static fmu_status check_step(const fmu_instance *instance, double time, double duration) {
    const double now = instance->outputs[0], later = now + duration;
    const double same = 1e-9; /* relative: sums of the same steps may round differently */
    if (!(isfinite(duration) && duration > 0.0))
        return fmu_say(instance, FMU_ERROR, "doStep: step %g s: must be finite and > 0", duration);
    if (duration * instance->run.inputs.frequency[0] < 1e-18) /* [rad] of mode A */
        return fmu_say(instance, FMU_ERROR, "doStep: step %g s: must be longer", duration);
    if (!(fabs(time - now) <= same * fmax(1.0, fabs(now))))
        return fmu_say(instance, FMU_ERROR,
                       "doStep: t = %.17g s: must be the present time of the FMU, %.17g s",
                       time, now);
    if (later > instance->run.stop + same * fmax(1.0, fabs(instance->run.stop)))
        return fmu_say(instance, FMU_ERROR,
                       "doStep: a step to t = %.17g s goes past the stop time %.17g s",
                       later, instance->run.stop);
    return FMU_OK;
}

fmu_status fmu_step(fmu_instance *instance, double time, double duration) {
    FMU_TRY(check_step(instance, time, duration));
    FMU_TRY(fmu_evaluate_step_inputs(instance, duration));
    const int observed = instance->observer.update != NULL;
    double taken = duration;
    const sm_status stepped = observed ? SM_OK : fmu_core_step(instance->core, duration);
    if (observed || stepped == SM_OUTSIDE_TABLE)
        FMU_TRY(march(instance, &taken));
    else if (stepped != SM_OK)
        return refuse(instance, duration, stepped, instance->outputs);
    instance->terminated = 0;
    fmu_advance_inputs(&instance->run.inputs, taken);
    instance->rates_current = 0;
    instance->motion_current = FMU_NO_MOTION;
    return fmu_read_outputs(instance);
}
