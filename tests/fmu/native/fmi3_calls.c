#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sequence.h"
#include "fmi3Functions.h"

static void write_message(fmi3InstanceEnvironment environment, fmi3Status given,
                          fmi3String category, fmi3String message) {
    message_log *log = environment;
    snprintf(log->last, sizeof log->last, "%s", message);
    log->count++;
    log->last_status = (status)given;
    if (!category || !*category) abort();
}

static void *stepping; /* the instance whose step is under way */

/* Within a step: some outputs may be read, and nothing else is allowed. What is refused here is
 * nobody's message. */
static void on_update(fmi3InstanceEnvironment environment, fmi3Float64 time,
                      fmi3Boolean set_requested, fmi3Boolean get_allowed, fmi3Boolean finished,
                      fmi3Boolean may_return, fmi3Boolean *early, fmi3Float64 *until) {
    message_log *log = environment;
    const message_log before = *log;
    CHECK(!set_requested && get_allowed && finished && isfinite(time), "update");
    for (int k = 0; k < 4; k++) {
        const fmi3ValueReference vr = (fmi3ValueReference)below(64);
        fmi3Boolean flag[3];
        fmi3FMUState state = NULL;
        double value = NAN;
        const fmi3Status got = fmi3GetFloat64(stepping, &vr, 1, &value, 1);
        CHECK(got != fmi3OK || isfinite(value), "read within a step");
        CHECK(got == fmi3OK || log->count > before.count, "read within a step");
        switch (below(6)) {
        case 0: CHECK(fmi3SetFloat64(stepping, &vr, 1, &value, 1) == fmi3Error, "set"); break;
        case 1:
            CHECK(fmi3DoStep(stepping, time, 1.0, true, flag, flag + 1, flag + 2, &value)
                      == fmi3Error, "step within a step");
            break;
        case 2: CHECK(fmi3GetFMUState(stepping, &state) == fmi3Error, "state"); break;
        case 3: CHECK(fmi3Terminate(stepping) == fmi3Error, "terminate"); break;
        case 4: CHECK(fmi3Reset(stepping) == fmi3Error, "reset"); break;
        default: break;
        }
    }
    *log = before;
    const double ends[] = {time, time - 1.0, time + uniform(), NAN, INFINITY};
    *early = below(8) == 0;
    if (*early) *until = ends[below(5)];
    (void)may_return; /* what may not be is no reason not to ask for it */
}

static void *instantiate(int interface, const char *name, const char *token, const char *folder,
                         message_log *log) {
    if (interface == 0)
        return fmi3InstantiateModelExchange(name, token, folder, false, false, log,
                                            write_message);
    const bool events = interface == 2;
    const int told = below(2);
    const message_log before = *log;
    fmi3ValueReference wanted[6];
    for (int k = 0; k < 6; k++) wanted[k] = (fmi3ValueReference)below(64);
    void *c = told ? fmi3InstantiateCoSimulation(name, token, folder, false, false, events, events,
                                                 wanted, (size_t)below(7), log, write_message,
                                                 below(8) ? on_update : NULL)
                   : NULL;
    if (c) return c;
    CHECK(!told || log->count == before.count + 1, "instantiate");
    *log = before;
    return fmi3InstantiateCoSimulation(name, token, folder, false, false, events, events, NULL, 0,
                                       log, write_message, NULL);
}

static status set_logging(void *c, int on, size_t count, const char *const *categories) {
    return (status)fmi3SetDebugLogging(c, on, count, (const fmi3String *)categories);
}

static status enter_initialization(void *c, double tolerance, double start, double stop) {
    return (status)fmi3EnterInitializationMode(c, tolerance != 0.0, tolerance, start,
                                               stop < INFINITY || isnan(stop), stop);
}

static status get_real(void *c, const uint32_t *vr, size_t count, double *value) {
    return (status)fmi3GetFloat64(c, vr, count, value, count);
}

static status set_real(void *c, const uint32_t *vr, size_t count, const double *value) {
    return (status)fmi3SetFloat64(c, vr, count, value, count);
}

static status get_enumeration(void *c, const uint32_t *vr, size_t count, int32_t *value) {
    fmi3Int64 wide = 0;
    const status got = (status)fmi3GetInt64(c, vr, count, value ? &wide : NULL, count);
    if (got == OK && count > 0) *value = (int32_t)wide;
    return got;
}

static status get_boolean(void *c, const uint32_t *vr, size_t count, int *value) {
    fmi3Boolean narrow = false;
    const status got = (status)fmi3GetBoolean(c, vr, count, value ? &narrow : NULL, count);
    if (got == OK && count > 0) *value = narrow;
    return got;
}

static status set_boolean(void *c, const uint32_t *vr, size_t count, const int *value) {
    const fmi3Boolean narrow = value && *value;
    return (status)fmi3SetBoolean(c, vr, count, value ? &narrow : NULL, count);
}

static status update_discrete(void *c, int *states_changed) {
    fmi3Boolean flag[5] = {false};
    double next;
    const status got = (status)fmi3UpdateDiscreteStates(
        c, &flag[0], &flag[1], &flag[2], states_changed ? &flag[3] : NULL, &flag[4], &next);
    if (states_changed) *states_changed = flag[3];
    return got;
}

static status completed_step(void *c, int arguments) {
    fmi3Boolean enter, terminate;
    return (status)fmi3CompletedIntegratorStep(c, true, arguments ? &enter : NULL, &terminate);
}

static status step(void *c, double time, double length, double *reached) {
    fmi3Boolean event, terminate, early = false;
    stepping = c;
    const status got =
        (status)fmi3DoStep(c, time, length, true, &event, &terminate, &early, reached);
    if (got == OK && early != (*reached < time + length * (1.0 - 1e-9))) abort();
    return got;
}

static status adjoint(void *c, const uint32_t *unknown, size_t unknowns, const uint32_t *known,
                      size_t knowns, const double *seed, double *sensitivity) {
    return (status)fmi3GetAdjointDerivative(c, unknown, unknowns, known, knowns, seed, unknowns,
                                            sensitivity, knowns);
}

static status output_derivatives(void *c, const uint32_t *vr, size_t count, const int32_t *order,
                                 double *value) {
    return (status)fmi3GetOutputDerivatives(c, vr, count, order, value, count);
}

static status get_indicators(void *c, size_t count) {
    double value[4];
    return (status)fmi3GetEventIndicators(c, value, count);
}

static status directional(void *c, const uint32_t *unknown, size_t unknowns,
                          const uint32_t *known, size_t knowns, const double *seed,
                          double *sensitivity) {
    return (status)fmi3GetDirectionalDerivative(c, unknown, unknowns, known, knowns, seed, knowns,
                                                sensitivity, unknowns);
}

#define AS(type, function) ((type)(function))
const calls fmi3_calls = {
    .version = "FMI 3.0",
    .instantiate = instantiate,
    .free_instance = fmi3FreeInstance,
    .set_logging = set_logging,
    .enter_initialization = enter_initialization,
    .exit_initialization = AS(status (*)(void *), fmi3ExitInitializationMode),
    .terminate = AS(status (*)(void *), fmi3Terminate),
    .reset = AS(status (*)(void *), fmi3Reset),
    .get_real = get_real,
    .set_real = set_real,
    .get_enumeration = get_enumeration,
    .get_boolean = get_boolean,
    .set_boolean = set_boolean,
    .get_state = AS(status (*)(void *, void **), fmi3GetFMUState),
    .set_state = AS(status (*)(void *, void *), fmi3SetFMUState),
    .free_state = AS(status (*)(void *, void **), fmi3FreeFMUState),
    .serialized_size = AS(status (*)(void *, void *, size_t *), fmi3SerializedFMUStateSize),
    .serialize = AS(status (*)(void *, void *, void *, size_t), fmi3SerializeFMUState),
    .deserialize = AS(status (*)(void *, const void *, size_t, void **), fmi3DeserializeFMUState),
    .step = step,
    .enter_events = AS(status (*)(void *), fmi3EnterEventMode),
    .update_discrete = update_discrete,
    .enter_continuous = AS(status (*)(void *), fmi3EnterContinuousTimeMode),
    .completed_step = completed_step,
    .set_time = AS(status (*)(void *, double), fmi3SetTime),
    .set_states = AS(status (*)(void *, const double *, size_t), fmi3SetContinuousStates),
    .get_states = AS(status (*)(void *, double *, size_t), fmi3GetContinuousStates),
    .get_derivatives = AS(status (*)(void *, double *, size_t), fmi3GetContinuousStateDerivatives),
    .get_nominals = AS(status (*)(void *, double *, size_t), fmi3GetNominalsOfContinuousStates),
    .get_indicators = get_indicators,
    .directional = directional,
    .has_event_mode = 1,
    .enter_steps = AS(status (*)(void *), fmi3EnterStepMode),
    .adjoint = adjoint,
    .output_derivatives = output_derivatives,
};
