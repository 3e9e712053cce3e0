#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "calls.h"
#include "fmi2Functions.h"

static void write_message(fmi2ComponentEnvironment environment, fmi2String name,
                          fmi2Status given, fmi2String category, fmi2String format, ...) {
    message_log *log = environment;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(log->last, sizeof log->last, format, arguments);
    va_end(arguments);
    log->count++;
    log->last_status = (status)given;
    if (!name || !category || !*category) abort();
}

/* The folder as a URI, every character but letters, digits and / by its code. */
static void write_uri(char *to, size_t size, const char *folder) {
    int length = snprintf(to, size, "file://");
    for (; *folder && length + 4 < (int)size; folder++)
        length += snprintf(to + length, size - (size_t)length,
                           isalnum((unsigned char)*folder) || *folder == '/' ? "%c" : "%%%02X",
                           (unsigned char)*folder);
}

static void *instantiate(int interface, const char *name, const char *token, const char *folder,
                         message_log *log) {
    char uri[4096];
    const fmi2CallbackFunctions functions = {write_message, NULL, NULL, NULL, log};
    if (folder) write_uri(uri, sizeof uri, folder);
    return fmi2Instantiate(name, interface ? fmi2CoSimulation : fmi2ModelExchange, token,
                           folder ? uri : NULL, &functions, fmi2False, fmi2False);
}

static status set_logging(void *c, int on, size_t count, const char *const *categories) {
    return (status)fmi2SetDebugLogging(c, on, count, (const fmi2String *)categories);
}

static status enter_initialization(void *c, double tolerance, double start, double stop) {
    const status set = (status)fmi2SetupExperiment(c, tolerance != 0.0, tolerance, start,
                                                   stop < INFINITY || isnan(stop), stop);
    if (set == ERROR) return set;
    const status entered = (status)fmi2EnterInitializationMode(c);
    return entered == OK ? set : entered;
}

static status get_enumeration(void *c, const uint32_t *vr, size_t count, int32_t *value) {
    return (status)fmi2GetInteger(c, vr, count, value);
}

static status update_discrete(void *c, int *states_changed) {
    fmi2EventInfo info = {.valuesOfContinuousStatesChanged = fmi2False};
    const status got = (status)fmi2NewDiscreteStates(c, states_changed ? &info : NULL);
    if (states_changed) *states_changed = info.valuesOfContinuousStatesChanged;
    return got;
}

static status completed_step(void *c, int arguments) {
    fmi2Boolean enter, terminate;
    return (status)fmi2CompletedIntegratorStep(c, fmi2True, arguments ? &enter : NULL, &terminate);
}

static status step(void *c, double time, double length, double *reached) {
    *reached = time + length;
    return (status)fmi2DoStep(c, time, length, fmi2True);
}

static status output_derivatives(void *c, const uint32_t *vr, size_t count, const int32_t *order,
                                 double *value) {
    return (status)fmi2GetRealOutputDerivatives(c, vr, count, (const fmi2Integer *)order, value);
}

static status get_indicators(void *c, size_t count) {
    double value[4];
    return (status)fmi2GetEventIndicators(c, value, count);
}

#define AS(type, function) ((type)(function))
const calls fmi2_calls = {
    .version = "FMI 2.0",
    .instantiate = instantiate,
    .free_instance = fmi2FreeInstance,
    .set_logging = set_logging,
    .enter_initialization = enter_initialization,
    .exit_initialization = AS(status (*)(void *), fmi2ExitInitializationMode),
    .terminate = AS(status (*)(void *), fmi2Terminate),
    .reset = AS(status (*)(void *), fmi2Reset),
    .get_real = AS(status (*)(void *, const uint32_t *, size_t, double *), fmi2GetReal),
    .set_real = AS(status (*)(void *, const uint32_t *, size_t, const double *), fmi2SetReal),
    .get_enumeration = get_enumeration,
    .get_boolean = AS(status (*)(void *, const uint32_t *, size_t, int *), fmi2GetBoolean),
    .set_boolean = AS(status (*)(void *, const uint32_t *, size_t, const int *), fmi2SetBoolean),
    .get_state = AS(status (*)(void *, void **), fmi2GetFMUstate),
    .set_state = AS(status (*)(void *, void *), fmi2SetFMUstate),
    .free_state = AS(status (*)(void *, void **), fmi2FreeFMUstate),
    .serialized_size = AS(status (*)(void *, void *, size_t *), fmi2SerializedFMUstateSize),
    .serialize = AS(status (*)(void *, void *, void *, size_t), fmi2SerializeFMUstate),
    .deserialize = AS(status (*)(void *, const void *, size_t, void **), fmi2DeSerializeFMUstate),
    .step = step,
    .enter_events = AS(status (*)(void *), fmi2EnterEventMode),
    .update_discrete = update_discrete,
    .enter_continuous = AS(status (*)(void *), fmi2EnterContinuousTimeMode),
    .completed_step = completed_step,
    .set_time = AS(status (*)(void *, double), fmi2SetTime),
    .set_states = AS(status (*)(void *, const double *, size_t), fmi2SetContinuousStates),
    .get_states = AS(status (*)(void *, double *, size_t), fmi2GetContinuousStates),
    .get_derivatives = AS(status (*)(void *, double *, size_t), fmi2GetDerivatives),
    .get_nominals = AS(status (*)(void *, double *, size_t), fmi2GetNominalsOfContinuousStates),
    .get_indicators = get_indicators,
    .directional = AS(status (*)(void *, const uint32_t *, size_t, const uint32_t *, size_t,
                                 const double *, double *),
                      fmi2GetDirectionalDerivative),
    .output_derivatives = output_derivatives,
};
