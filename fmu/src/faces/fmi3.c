/* FMI 3.0: the instance behind the names and types of the standard. What the FMU does not have,
 * other types, clocks, intervals, is in fmi3_absent.c. */
#include "faces/fmi3.h"

#include <stdlib.h>

#include "resources/location.h"
#include "instance/snapshot.h"

#define EARLY 1e-9 /* of a step: nothing, but for rounding */
#define EXCHANGE (FMU_EVENTS | FMU_CONTINUOUS)
#define AS_MANY "as many values are needed as the variables have"
/* Of a call with arrays of `count` elements. */
#define NEED_ARRAYS(count, values, name)                                        \
    REFUSE_IF((count) > 0 && (!vr || !value), name ": an array is NULL");       \
    REFUSE_IF((values) != (count), name ": as many values are needed as value references")

static void write_log(const fmu_logger *logger, const char *name, fmu_status status,
                      const char *category, const char *message) {
    (void)name; /* the environment knows it */
    const fmi3LogMessageCallback callback = (fmi3LogMessageCallback)logger->callback;
    if (callback) callback(logger->environment, (fmi3Status)status, category, message);
}

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t count,
                               const fmi3String categories[]) {
    ALLOW(FMU_ANY, "fmi3SetDebugLogging");
    return (fmi3Status)fmu_set_logging(c, on, count, categories);
}

static fmu_logger logger_of(fmi3InstanceEnvironment environment, fmi3LogMessageCallback callback,
                            fmi3Boolean logging) {
    const fmu_logger logger = {.write = write_log,
                               .callback = (void (*)(void))callback,
                               .environment = environment,
                               .events = logging};
    return logger;
}

static fmi3Instance refuse_instance(const fmu_logger *logger, fmi3String name,
                                    const char *reason) {
    write_log(logger, name, FMU_ERROR, "logStatusError", reason);
    return NULL;
}

static fmi3Instance instantiate(fmu_interface interface, fmi3String name, fmi3String token,
                                fmi3String path, const fmu_logger *logger) {
    const char *reason;
    char *folder = location_from_path(path, &reason);
    if (!folder) return refuse_instance(logger, name, reason);
    fmi3Instance c = fmu_instantiate(interface, name, token, folder, logger);
    free(folder);
    return c;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String path,
                                          fmi3Boolean visible, fmi3Boolean logging,
                                          fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback callback) {
    (void)visible;
    const fmu_logger logger = logger_of(environment, callback, logging);
    return instantiate(FMU_MODEL_EXCHANGE, name, token, path, &logger);
}

/* Inputs are not set within a step: each moves at its rate. */
static int tell(const fmu_observer *observer, double time, int may_end, double *end) {
    fmi3Boolean early = fmi3False;
    ((fmi3IntermediateUpdateCallback)observer->callback)(
        observer->environment, time, fmi3False, fmi3True, fmi3True, may_end != 0, &early, end);
    return may_end && early;
}

fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String path, fmi3Boolean visible, fmi3Boolean logging,
    fmi3Boolean event_mode, fmi3Boolean early_return, const fmi3ValueReference intermediate[],
    size_t intermediates, fmi3InstanceEnvironment environment, fmi3LogMessageCallback callback,
    fmi3IntermediateUpdateCallback update) {
    (void)visible;
    const fmu_logger logger = logger_of(environment, callback, logging);
    const fmu_observer observer = {.update = update ? tell : NULL,
                                   .callback = (void (*)(void))update,
                                   .environment = environment};
    if (intermediates > 0 && !(intermediate && update))
        return refuse_instance(&logger, name, "required intermediate variables need a callback");
    fmu_instance *c = instantiate(FMU_CO_SIMULATION, name, token, path, &logger);
    if (!c) return NULL;
    c->event_mode = event_mode;
    c->early_return = early_return;
    if (fmu_observe(c, &observer, intermediate, intermediates) == FMU_OK) return c;
    fmu_free(c);
    return NULL;
}

fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String name, fmi3String token, fmi3String path, fmi3Boolean visible, fmi3Boolean logging,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback callback,
    fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock,
    fmi3UnlockPreemptionCallback unlock) {
    (void)token, (void)path, (void)visible, (void)update, (void)lock, (void)unlock;
    const fmu_logger logger = logger_of(environment, callback, logging);
    return refuse_instance(&logger, name, "the FMU has no scheduled execution");
}

void fmi3FreeInstance(fmi3Instance c) { fmu_free(c); }

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean tolerance_defined,
                                       fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean stop_defined, fmi3Float64 stop) {
    ALLOW(FMU_INSTANTIATED, "fmi3EnterInitializationMode");
    const fmu_status status =
        fmu_setup(c, tolerance_defined, tolerance, start, stop_defined, stop);
    if (status == FMU_ERROR) return fmi3Error;
    fmu_enter_initialization(c);
    return (fmi3Status)status;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
    ALLOW(FMU_INITIALIZATION, "fmi3ExitInitializationMode");
    return (fmi3Status)fmu_exit_initialization(c);
}

fmi3Status fmi3Terminate(fmi3Instance c) {
    ALLOW(FMU_RUNNING, "fmi3Terminate");
    return (fmi3Status)fmu_terminate(c);
}

fmi3Status fmi3Reset(fmi3Instance c) {
    ALLOW(FMU_ANY, "fmi3Reset");
    return (fmi3Status)fmu_reset(c);
}

/* ---- variables ------------------------------------------------------------------------- */

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t count,
                          fmi3Float64 value[], size_t values) {
    ALLOW(READABLE, "fmi3GetFloat64");
    REFUSE_IF(count > 0 && (!vr || !value), "fmi3GetFloat64: an array is NULL");
    return (fmi3Status)fmu_get_floats(c, vr, count, value, values);
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t count,
                          const fmi3Float64 value[], size_t values) {
    ALLOW(FMU_BEFORE_START | FMU_RUNNING, "fmi3SetFloat64");
    NEED_ARRAYS(count, values, "fmi3SetFloat64");
    return (fmi3Status)fmu_set_reals(c, vr, count, value);
}

/* Enumerations are 64 bits wide here. */
fmi3Status fmi3GetInt64(fmi3Instance c, const fmi3ValueReference vr[], size_t count,
                        fmi3Int64 value[], size_t values) {
    ALLOW(READABLE, "fmi3GetInt64");
    NEED_ARRAYS(count, values, "fmi3GetInt64");
    for (size_t k = 0; k < count; k++) {
        int32_t present;
        const fmu_status status = fmu_get_integers(c, FMU_ENUMERATION, &vr[k], 1, &present);
        if (status != FMU_OK) return (fmi3Status)status;
        value[k] = present;
    }
    return fmi3OK;
}

fmi3Status fmi3GetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t count,
                          fmi3Boolean value[], size_t values) {
    ALLOW(READABLE, "fmi3GetBoolean");
    NEED_ARRAYS(count, values, "fmi3GetBoolean");
    for (size_t k = 0; k < count; k++) {
        int32_t present;
        const fmu_status status = fmu_get_integers(c, FMU_BOOLEAN, &vr[k], 1, &present);
        if (status != FMU_OK) return (fmi3Status)status;
        value[k] = present != 0;
    }
    return fmi3OK;
}

fmi3Status fmi3SetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t count,
                          const fmi3Boolean value[], size_t values) {
    ALLOW(FMU_BEFORE_START | FMU_RUNNING, "fmi3SetBoolean");
    NEED_ARRAYS(count, values, "fmi3SetBoolean");
    for (size_t k = 0; k < count; k++) {
        const int32_t wanted = value[k];
        const fmu_status status = fmu_set_integers(c, FMU_BOOLEAN, &vr[k], 1, &wanted);
        if (status != FMU_OK) return (fmi3Status)status;
    }
    return fmi3OK;
}

/* ---- state ----------------------------------------------------------------------------- */

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state) {
    ALLOW(FMU_ANY, "fmi3GetFMUState");
    return (fmi3Status)fmu_snapshot_take(c, (fmu_snapshot **)state);
}

fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) {
    ALLOW(FMU_ANY, "fmi3SetFMUState");
    return (fmi3Status)fmu_snapshot_apply(c, state);
}

fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state) {
    ALLOW(FMU_ANY, "fmi3FreeFMUState");
    if (!state) return fmi3OK;
    fmu_snapshot_free(*state);
    *state = NULL;
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size) {
    ALLOW(FMU_ANY, "fmi3SerializedFMUStateSize");
    return (fmi3Status)fmu_snapshot_size(c, state, size);
}

fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[],
                                 size_t size) {
    ALLOW(FMU_ANY, "fmi3SerializeFMUState");
    return (fmi3Status)fmu_snapshot_write(c, state, bytes, size);
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size,
                                   fmi3FMUState *state) {
    ALLOW(FMU_ANY, "fmi3DeserializeFMUState");
    return (fmi3Status)fmu_snapshot_read(c, bytes, size, (fmu_snapshot **)state);
}

/* Values along unknowns by knowns, or by time, for which there are none. */
typedef fmu_status derivative(fmu_instance *instance, const uint32_t *unknown, size_t unknowns,
                              const uint32_t *known, size_t knowns, const double *seed,
                              double *value);

/* A derivative of unknowns, arrays as their elements, of which there must be `elements`; `fit`:
 * whether there are as many other values as knowns. */
static fmi3Status get_derivative(fmu_instance *c, const char *call, derivative *find,
                                 const uint32_t *unknown, size_t unknowns, size_t elements,
                                 const uint32_t *known, size_t knowns, int fit,
                                 const double *seed, double *value) {
    size_t scalars;
    uint32_t *scalar = fmu_scalars(c, unknown, unknowns, &scalars);
    if (!scalar) return fmi3Error;
    const fmu_status status =
        fit && elements == scalars
            ? find(c, scalar, scalars, known, knowns, seed, value)
            : fmu_say(c, FMU_ERROR, "%s: " AS_MANY, call);
    free(scalar);
    return (fmi3Status)status;
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknown[],
                                        size_t unknowns, const fmi3ValueReference known[],
                                        size_t knowns, const fmi3Float64 seed[], size_t seeds,
                                        fmi3Float64 sensitivity[], size_t sensitivities) {
    ALLOW(READABLE, "fmi3GetDirectionalDerivative");
    REFUSE_IF((unknowns > 0 && (!unknown || !sensitivity)) || (knowns > 0 && (!known || !seed)),
              "fmi3GetDirectionalDerivative: an array is NULL");
    return get_derivative(c, "fmi3GetDirectionalDerivative", fmu_directional, unknown, unknowns,
                          sensitivities, known, knowns, seeds == knowns, seed, sensitivity);
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance c, const fmi3ValueReference unknown[],
                                    size_t unknowns, const fmi3ValueReference known[],
                                    size_t knowns, const fmi3Float64 seed[], size_t seeds,
                                    fmi3Float64 sensitivity[], size_t sensitivities) {
    ALLOW(READABLE, "fmi3GetAdjointDerivative");
    REFUSE_IF((unknowns > 0 && (!unknown || !seed)) || (knowns > 0 && (!known || !sensitivity)),
              "fmi3GetAdjointDerivative: an array is NULL");
    return get_derivative(c, "fmi3GetAdjointDerivative", fmu_adjoint, unknown, unknowns, seeds,
                          known, knowns, sensitivities == knowns, seed, sensitivity);
}

static fmu_status by_time(fmu_instance *c, const uint32_t *unknown, size_t unknowns,
                          const uint32_t *known, size_t knowns, const double *seed,
                          double *value) {
    (void)known, (void)knowns, (void)seed;
    return fmu_output_derivatives(c, unknown, unknowns, value);
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, const fmi3ValueReference vr[], size_t count,
                                    const fmi3Int32 order[], fmi3Float64 value[], size_t values) {
    ALLOW(FMU_STEPPING | FMU_STEP_EVENTS, "fmi3GetOutputDerivatives");
    REFUSE_IF(count > 0 && (!vr || !value || !order), "fmi3GetOutputDerivatives: an array is NULL");
    for (size_t k = 0; k < count; k++)
        REFUSE_IF(order[k] != 1, "fmi3GetOutputDerivatives: order must be 1");
    return get_derivative(c, "fmi3GetOutputDerivatives", by_time, vr, count, values, NULL, 0, 1,
                          NULL, value);
}

/* ---- events ---------------------------------------------------------------------------- */

fmi3Status fmi3EnterEventMode(fmi3Instance c) {
    ALLOW(EXCHANGE | FMU_STEPPING, "fmi3EnterEventMode");
    REFUSE_IF(((const fmu_instance *)c)->state == FMU_STEPPING &&
                  !((const fmu_instance *)c)->event_mode,
              "fmi3EnterEventMode: the instance was made without event mode");
    return (fmi3Status)fmu_enter_events(c);
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *update_needed,
                                    fmi3Boolean *terminate, fmi3Boolean *nominals_changed,
                                    fmi3Boolean *states_changed, fmi3Boolean *next_time_defined,
                                    fmi3Float64 *next_time) {
    ALLOW(FMU_EVENTS | FMU_STEP_EVENTS, "fmi3UpdateDiscreteStates");
    REFUSE_IF(!update_needed || !terminate || !nominals_changed || !states_changed ||
                  !next_time_defined || !next_time,
              "fmi3UpdateDiscreteStates: an argument is NULL");
    int changed;
    const fmu_status status = fmu_update_discrete(c, &changed);
    *update_needed = *terminate = *nominals_changed = *next_time_defined = fmi3False;
    *states_changed = status == FMU_OK && changed;
    *next_time = 0.0;
    return (fmi3Status)status;
}

/* ---- Model Exchange -------------------------------------------------------------------- */

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c) {
    ALLOW(FMU_EVENTS, "fmi3EnterContinuousTimeMode");
    return (fmi3Status)fmu_enter_continuous(c);
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean no_set_state_before,
                                       fmi3Boolean *enter_event_mode, fmi3Boolean *terminate) {
    (void)no_set_state_before;
    ALLOW(FMU_CONTINUOUS, "fmi3CompletedIntegratorStep");
    REFUSE_IF(!enter_event_mode || !terminate, "fmi3CompletedIntegratorStep: an argument is NULL");
    *enter_event_mode = *terminate = fmi3False;
    return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 time) {
    ALLOW(EXCHANGE, "fmi3SetTime");
    return (fmi3Status)fmu_set_time(c, time);
}

fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 states[], size_t count) {
    ALLOW(FMU_CONTINUOUS, "fmi3SetContinuousStates");
    return (fmi3Status)fmu_set_states(c, states, count);
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 derivatives[],
                                             size_t count) {
    ALLOW(EXCHANGE, "fmi3GetContinuousStateDerivatives");
    return (fmi3Status)fmu_get_rates(c, derivatives, count);
}

fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 indicators[], size_t count) {
    (void)indicators;
    ALLOW(EXCHANGE, "fmi3GetEventIndicators");
    REFUSE_IF(count > 0, "fmi3GetEventIndicators: there are none");
    return fmi3OK;
}

fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 states[], size_t count) {
    ALLOW(EXCHANGE, "fmi3GetContinuousStates");
    return (fmi3Status)fmu_get_states(c, states, count);
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 nominals[],
                                             size_t count) {
    ALLOW(EXCHANGE, "fmi3GetNominalsOfContinuousStates");
    return (fmi3Status)fmu_get_nominals(c, nominals, count);
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *count) {
    ALLOW(FMU_ANY, "fmi3GetNumberOfEventIndicators");
    REFUSE_IF(!count, "fmi3GetNumberOfEventIndicators: the number is NULL");
    *count = 0;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *count) {
    ALLOW(FMU_ANY, "fmi3GetNumberOfContinuousStates");
    REFUSE_IF(!count, "fmi3GetNumberOfContinuousStates: the number is NULL");
    *count = fmu_state_count(c);
    return fmi3OK;
}

/* ---- Co-Simulation --------------------------------------------------------------------- */

fmi3Status fmi3EnterStepMode(fmi3Instance c) {
    ALLOW(FMU_STEP_EVENTS, "fmi3EnterStepMode");
    return (fmi3Status)fmu_enter_steps(c);
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 step,
                      fmi3Boolean no_set_state_before, fmi3Boolean *event_handling_needed,
                      fmi3Boolean *terminate, fmi3Boolean *early_return, fmi3Float64 *last_time) {
    (void)no_set_state_before;
    ALLOW(FMU_STEPPING, "fmi3DoStep");
    REFUSE_IF(!event_handling_needed || !terminate || !early_return || !last_time,
              "fmi3DoStep: an argument is NULL");
    const fmu_status status = fmu_step(c, time, step);
    *event_handling_needed = fmi3False;
    *early_return = status == FMU_OK && fmu_time(c) < time + step - EARLY * step;
    *terminate = ((const fmu_instance *)c)->terminated != 0;
    *last_time = fmu_time(c);
    return (fmi3Status)status;
}
