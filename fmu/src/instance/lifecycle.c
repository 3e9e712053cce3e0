/* Life cycle of an instance. */
#include "instance/instance.h"
#include "resources/files.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

fmu_status fmu_reset(fmu_instance *instance) {
    const fmu_model *model = instance->model;
    fmu_run *run = &instance->run;
    run->started = run->start = 0.0;
    run->stop = INFINITY;
    memcpy(run->parameters, model->constants->parameters, sizeof run->parameters);
    memcpy(run->amplitude, model->constants->amplitude, sizeof run->amplitude);
    run->inputs = *model->inputs;
    memset(&run->previous, 0, sizeof run->previous);
    instance->state = FMU_INSTANTIATED;
    instance->terminated = 0;
    instance->refused_at = NAN;
    return FMU_OK;
}

/* Loads the model and evaluates its start values; returns 0 and the reason if it fails. */
static int create(fmu_instance *instance, const char *token, const char *location,
                  char reason[FMU_REASON]) {
    const char *why;
    char *folder = location_folder(location, &why);
    if (folder)
        instance->model = fmu_model_acquire(folder, token, reason);
    else
        snprintf(reason, FMU_REASON, "%s", why);
    free(folder);
    const fmu_model *model = instance->model;
    if (!model) return 0;
    if (model->shares_tone && instance->interface == FMU_MODEL_EXCHANGE) {
        snprintf(reason, FMU_REASON, "Model Exchange: not available for modes that share a tone");
        return 0;
    }
    instance->flow = model->flow;
    instance->motion = model->motion;
    instance->output_count = (size_t)model->outputs;
    instance->outputs = calloc(instance->output_count, sizeof *instance->outputs);
    if (!instance->outputs) return 0;
    fmu_reset(instance);
    snprintf(reason, FMU_REASON, "the resources do not make a model");
    const int whole = fmu_evaluate_outputs(instance) == FMU_OK;
    instance->run.started = 0;
    return whole;
}

fmu_instance *fmu_instantiate(fmu_interface interface, const char *name, const char *token,
                              const char *location, const fmu_logger *logger) {
    char reason[FMU_REASON] = "out of memory";
    const char *called = name ? name : "(no name)";
    fmu_instance *instance = calloc(1, sizeof *instance);
    if (instance) instance->name = malloc(strlen(called) + 1);
    if (instance && instance->name) {
        memcpy(instance->name, called, strlen(called) + 1);
        instance->logger = *logger;
        instance->interface = interface;
        if (!name || !*name)
            snprintf(reason, sizeof reason, "the instance has no name");
        else if (!token)
            snprintf(reason, sizeof reason, "the instantiation token is NULL");
        else if (create(instance, token, location, reason)) {
            fmu_say(instance, FMU_OK, "instantiated from %s", location);
            return instance;
        }
    }
    fmu_log(logger, called, FMU_ERROR, reason);
    fmu_free(instance);
    return NULL;
}

void fmu_free(fmu_instance *instance) {
    if (!instance) return;
    fmu_core_free(instance->core);
    fmu_model_release(instance->model);
    free(instance->outputs);
    free(instance->observer.wanted);
    free(instance->name);
    free(instance);
}

fmu_status fmu_setup(fmu_instance *instance, int tolerance_defined, double tolerance, double start,
                     int stop_defined, double stop) {
    if (!isfinite(start) || (stop_defined && !(isfinite(stop) && stop >= start)))
        return fmu_say(instance, FMU_ERROR,
                       "start time %g, stop time %g: must be finite and in this order", start,
                       stop_defined ? stop : start);
    if (tolerance_defined && !(isfinite(tolerance) && tolerance > 0.0))
        return fmu_say(instance, FMU_ERROR, "tolerance %g: must be finite and > 0", tolerance);
    instance->run.start = start;
    instance->run.stop = stop_defined ? stop : INFINITY;
    instance->run.started = 0;
    if (!tolerance_defined) return FMU_OK;
    const double kept = fmin(fmax(tolerance, FMU_LEAST_TOLERANCE), FMU_MOST_TOLERANCE);
    instance->run.parameters[FMU_TOLERANCE] = kept;
    if (kept == tolerance) return FMU_OK;
    return fmu_say(instance, FMU_WARNING, "tolerance %g: must be %g to %g, so %g is used",
                   tolerance, FMU_LEAST_TOLERANCE, FMU_MOST_TOLERANCE, kept);
}

fmu_status fmu_exit_initialization(fmu_instance *instance) {
    FMU_TRY(fmu_evaluate_outputs(instance));
    instance->state = instance->interface == FMU_MODEL_EXCHANGE ? FMU_EVENTS
                      : instance->event_mode                    ? FMU_STEP_EVENTS
                                                                : FMU_STEPPING;
    return fmu_say(instance, FMU_OK, "started at t = %g s", instance->run.start);
}
