#include "instance/instance.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SAME_TIME 1e-9      /* relative: two ways to sum up steps may round differently */
#define LEAST_STEP 1e-18    /* radians of mode A: nothing happens in less */
#define TOLERANCE_LEAST 1e-13
#define TOLERANCE_MOST 1e-2

static const char *state_name(fmu_state state) {
    switch (state) {
    case FMU_INSTANTIATED: return "instantiated";
    case FMU_INITIALIZATION: return "in initialization mode";
    case FMU_EVENTS: return "in event mode";
    case FMU_CONTINUOUS: return "in continuous-time mode";
    case FMU_STEPPING: return "in step mode";
    case FMU_STEP_EVENTS: return "in event mode";
    case FMU_INTERMEDIATE: return "in intermediate update mode";
    default: return "terminated";
    }
}

fmu_status fmu_allow(const fmu_instance *instance, unsigned states, const char *call) {
    if (!instance) return FMU_ERROR;
    if (instance->state & states) return FMU_OK;
    return fmu_say(instance, FMU_ERROR, "%s: not allowed while the instance is %s", call,
                   state_name(instance->state));
}

static void set_defaults(fmu_instance *instance) {
    const fmu_model *model = instance->model;
    instance->state = FMU_INSTANTIATED;
    instance->start = 0.0;
    instance->stop = INFINITY;
    memcpy(instance->parameters, model->parameters, sizeof instance->parameters);
    memcpy(instance->amplitude, model->amplitude, sizeof instance->amplitude);
    instance->inputs = model->inputs;
    memset(&instance->held, 0, sizeof instance->held);
    instance->started = instance->terminated = 0;
    instance->refused_at = NAN;
}

/* What an instance holds of its own; 0 without memory. */
static int allocate(fmu_instance *instance) {
    const fmu_model *model = instance->model;
    instance->flow = model->flow;
    instance->motion = model->motion;
    instance->output_count = SM_OUTPUTS_FIXED + 3 * (size_t)model->contact.contacts
                             + (size_t)model->motion.elastic;
    instance->outputs = calloc(instance->output_count, sizeof *instance->outputs);
    return instance->outputs != NULL;
}

fmu_instance *fmu_instantiate(fmu_interface interface, const char *name, const char *token,
                              const char *folder, const fmu_logger *logger) {
    char reason[FMU_REASON] = "out of memory";
    const char *called = name ? name : "(no name)";
    fmu_instance *instance = calloc(1, sizeof *instance);
    const size_t length = strlen(called) + 1;
    if (instance) instance->name = malloc(length);
    if (instance && instance->name) {
        memcpy(instance->name, called, length);
        instance->logger = *logger;
        instance->interface = interface;
        if (!name || !*name)
            snprintf(reason, sizeof reason, "the instance has no name");
        else if (!token)
            snprintf(reason, sizeof reason, "the instantiation token is NULL");
        else
            instance->model = fmu_model_acquire(folder, token, reason);
        if (instance->model && allocate(instance)) {
            set_defaults(instance);
            if (fmu_evaluate_outputs(instance) == FMU_OK) { /* refuses what the files cannot mean */
                instance->started = 0;
                fmu_say(instance, FMU_OK, "instantiated from %s", folder);
                return instance;
            }
            snprintf(reason, sizeof reason, "the resources do not make a model");
        }
    }
    fmu_log(logger, called, FMU_ERROR, reason);
    fmu_free(instance);
    return NULL;
}

void fmu_free(fmu_instance *instance) {
    if (!instance) return;
    sm_component_free(instance->component);
    fmu_model_release(instance->model);
    free(instance->outputs);
    free(instance->observer.wanted);
    free(instance->name);
    free(instance);
}

fmu_status fmu_setup(fmu_instance *instance, int tolerance_defined, double tolerance, double start,
                     int stop_defined, double stop) {
    if (!isfinite(start) || (stop_defined && !(isfinite(stop) && stop >= start)))
        return fmu_say(instance, FMU_ERROR, "start time %g, stop time %g: must be finite, in order",
                       start, stop_defined ? stop : start);
    if (tolerance_defined && !(isfinite(tolerance) && tolerance > 0.0))
        return fmu_say(instance, FMU_ERROR, "tolerance %g: must be finite and > 0", tolerance);
    instance->start = start;
    instance->stop = stop_defined ? stop : INFINITY;
    instance->started = 0;
    if (!tolerance_defined) return FMU_OK;
    const double kept = fmin(fmax(tolerance, TOLERANCE_LEAST), TOLERANCE_MOST);
    instance->parameters[FMU_TOLERANCE] = kept;
    if (kept == tolerance) return FMU_OK;
    return fmu_say(instance, FMU_WARNING, "tolerance %g: %g is used", tolerance, kept);
}

fmu_status fmu_enter_initialization(fmu_instance *instance) {
    instance->state = FMU_INITIALIZATION;
    return FMU_OK;
}

fmu_status fmu_exit_initialization(fmu_instance *instance) {
    const fmu_status status = fmu_evaluate_outputs(instance);
    if (status != FMU_OK) return status;
    instance->state = instance->interface == FMU_MODEL_EXCHANGE ? FMU_EVENTS
                      : instance->event_mode                    ? FMU_STEP_EVENTS
                                                                : FMU_STEPPING;
    return fmu_say(instance, FMU_OK, "started at t = %g s", instance->start);
}

fmu_status fmu_terminate(fmu_instance *instance) {
    instance->state = FMU_TERMINATED;
    return FMU_OK;
}

fmu_status fmu_reset(fmu_instance *instance) {
    set_defaults(instance);
    return FMU_OK;
}

double fmu_time(const fmu_instance *instance) { return instance->outputs[0]; }

fmu_status fmu_step(fmu_instance *instance, double time, double duration) {
    const double now = instance->outputs[0], later = now + duration;
    if (!(isfinite(duration) && duration > 0.0))
        return fmu_say(instance, FMU_ERROR, "doStep: step %g s, must be finite and > 0", duration);
    if (duration * instance->inputs.frequency[0] < LEAST_STEP)
        return fmu_say(instance, FMU_ERROR, "doStep: step %g s, too short to matter", duration);
    if (!(fabs(time - now) <= SAME_TIME * fmax(1.0, fabs(now))))
        return fmu_say(instance, FMU_ERROR, "doStep: from t = %.17g s, the FMU stands at %.17g s",
                       time, now);
    if (later > instance->stop + SAME_TIME * fmax(1.0, fabs(instance->stop)))
        return fmu_say(instance, FMU_ERROR, "doStep: to t = %.17g s, past the stop time %.17g s",
                       later, instance->stop);
    return fmu_evaluate_step(instance, duration);
}
