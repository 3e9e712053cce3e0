/* FMI 2.0: the instance behind the names and types of the standard. */
#include "fmi2Functions.h"

#include <stdlib.h>

#include "resources/location.h"
#include "instance/snapshot.h"

#define ALLOW(states, name) \
    if (fmu_allow(c, (states), (name)) != FMU_OK) return fmi2Error
#define REFUSE_IF(condition, reason) \
    if (condition) return (fmi2Status)fmu_say(c, FMU_ERROR, "%s", (reason))
/* As above, of a call with arrays of `count` elements. */
#define NEED_ARRAYS(count, name) \
    REFUSE_IF((count) > 0 && (!vr || !value), name ": an array is NULL")

#define READABLE (FMU_ANY & ~FMU_INSTANTIATED)
#define EXCHANGE (FMU_EVENTS | FMU_CONTINUOUS)

/* The message is the format itself: not every importer looks at the arguments of "%s". */
static void write_log(const fmu_logger *logger, const char *name, fmu_status status,
                      const char *category, const char *message) {
    const fmi2CallbackLogger callback = (fmi2CallbackLogger)logger->callback;
    char format[FMU_MESSAGE], *to = format;
    for (; *message && to + 2 < format + sizeof format; message++) {
        if (*message == '%') *to++ = '%';
        *to++ = *message;
    }
    *to = '\0';
    if (callback) callback(logger->environment, name, (fmi2Status)status, category, format);
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count,
                               const fmi2String categories[]) {
    ALLOW(FMU_ANY, "fmi2SetDebugLogging");
    return (fmi2Status)fmu_set_logging(c, on, count, categories);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String location,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean logging) {
    (void)visible;
    if (!functions) return NULL; /* nobody to tell why */
    const fmu_logger logger = {.write = write_log,
                               .callback = (void (*)(void))functions->logger,
                               .environment = functions->componentEnvironment,
                               .events = logging};
    const char *called = name ? name : "(no name)", *reason;
    if (type != fmi2ModelExchange && type != fmi2CoSimulation) {
        write_log(&logger, called, FMU_ERROR, "logStatusError", "no such interface type");
        return NULL;
    }
    char *folder = location_from_uri(location, &reason);
    if (!folder) {
        write_log(&logger, called, FMU_ERROR, "logStatusError", reason);
        return NULL;
    }
    fmi2Component c = fmu_instantiate(
        type == fmi2CoSimulation ? FMU_CO_SIMULATION : FMU_MODEL_EXCHANGE, name, guid, folder,
        &logger);
    free(folder);
    return c;
}

void fmi2FreeInstance(fmi2Component c) { fmu_free(c); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean stop_defined, fmi2Real stop) {
    ALLOW(FMU_INSTANTIATED, "fmi2SetupExperiment");
    return (fmi2Status)fmu_setup(c, tolerance_defined, tolerance, start, stop_defined, stop);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    ALLOW(FMU_INSTANTIATED, "fmi2EnterInitializationMode");
    return (fmi2Status)fmu_enter_initialization(c);
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    ALLOW(FMU_INITIALIZATION, "fmi2ExitInitializationMode");
    return (fmi2Status)fmu_exit_initialization(c);
}

fmi2Status fmi2Terminate(fmi2Component c) {
    ALLOW(FMU_RUNNING, "fmi2Terminate");
    return (fmi2Status)fmu_terminate(c);
}

fmi2Status fmi2Reset(fmi2Component c) {
    ALLOW(FMU_ANY, "fmi2Reset");
    return (fmi2Status)fmu_reset(c);
}

/* ---- variables ------------------------------------------------------------------------- */

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                       fmi2Real value[]) {
    ALLOW(READABLE, "fmi2GetReal");
    NEED_ARRAYS(count, "fmi2GetReal");
    return (fmi2Status)fmu_get_reals(c, vr, count, value);
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                       const fmi2Real value[]) {
    ALLOW(FMU_BEFORE_START | FMU_RUNNING, "fmi2SetReal");
    NEED_ARRAYS(count, "fmi2SetReal");
    return (fmi2Status)fmu_set_reals(c, vr, count, value);
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                          fmi2Integer value[]) {
    ALLOW(READABLE, "fmi2GetInteger");
    NEED_ARRAYS(count, "fmi2GetInteger");
    return (fmi2Status)fmu_get_integers(c, FMU_ENUMERATION, vr, count, value);
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                          const fmi2Integer value[]) {
    ALLOW(FMU_BEFORE_START | FMU_RUNNING, "fmi2SetInteger");
    NEED_ARRAYS(count, "fmi2SetInteger");
    return (fmi2Status)fmu_set_integers(c, FMU_ENUMERATION, vr, count, value);
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                          fmi2Boolean value[]) {
    ALLOW(READABLE, "fmi2GetBoolean");
    NEED_ARRAYS(count, "fmi2GetBoolean");
    return (fmi2Status)fmu_get_integers(c, FMU_BOOLEAN, vr, count, value);
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                          const fmi2Boolean value[]) {
    ALLOW(FMU_BEFORE_START | FMU_RUNNING, "fmi2SetBoolean");
    NEED_ARRAYS(count, "fmi2SetBoolean");
    return (fmi2Status)fmu_set_integers(c, FMU_BOOLEAN, vr, count, value);
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                         fmi2String value[]) {
    (void)vr, (void)value;
    ALLOW(READABLE, "fmi2GetString");
    REFUSE_IF(count > 0, "fmi2GetString: the FMU has no strings");
    return fmi2OK;
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                         const fmi2String value[]) {
    (void)vr, (void)value;
    ALLOW(FMU_BEFORE_START | FMU_RUNNING, "fmi2SetString");
    REFUSE_IF(count > 0, "fmi2SetString: the FMU has no strings");
    return fmi2OK;
}

/* ---- state ----------------------------------------------------------------------------- */

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    ALLOW(FMU_ANY, "fmi2GetFMUstate");
    return (fmi2Status)fmu_snapshot_take(c, (fmu_snapshot **)state);
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    ALLOW(FMU_ANY, "fmi2SetFMUstate");
    return (fmi2Status)fmu_snapshot_apply(c, state);
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    ALLOW(FMU_ANY, "fmi2FreeFMUstate");
    if (!state) return fmi2OK;
    fmu_snapshot_free(*state);
    *state = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    ALLOW(FMU_ANY, "fmi2SerializedFMUstateSize");
    return (fmi2Status)fmu_snapshot_size(c, state, size);
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[],
                                 size_t size) {
    ALLOW(FMU_ANY, "fmi2SerializeFMUstate");
    return (fmi2Status)fmu_snapshot_write(c, state, bytes, size);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                   fmi2FMUstate *state) {
    ALLOW(FMU_ANY, "fmi2DeSerializeFMUstate");
    return (fmi2Status)fmu_snapshot_read(c, bytes, size, (fmu_snapshot **)state);
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[],
                                        size_t unknowns, const fmi2ValueReference known[],
                                        size_t knowns, const fmi2Real dv_known[],
                                        fmi2Real dv_unknown[]) {
    ALLOW(READABLE, "fmi2GetDirectionalDerivative");
    REFUSE_IF((unknowns > 0 && (!unknown || !dv_unknown)) || (knowns > 0 && (!known || !dv_known)),
              "fmi2GetDirectionalDerivative: an array is NULL");
    return (fmi2Status)fmu_directional(c, unknown, unknowns, known, knowns, dv_known, dv_unknown);
}

/* ---- Model Exchange -------------------------------------------------------------------- */

fmi2Status fmi2EnterEventMode(fmi2Component c) {
    ALLOW(EXCHANGE, "fmi2EnterEventMode");
    return (fmi2Status)fmu_enter_events(c);
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    ALLOW(FMU_EVENTS, "fmi2NewDiscreteStates");
    REFUSE_IF(!info, "fmi2NewDiscreteStates: the event info is NULL");
    int states_changed;
    const fmu_status status = fmu_update_discrete(c, &states_changed);
    const fmi2EventInfo nothing_else = {
        .valuesOfContinuousStatesChanged = status == FMU_OK && states_changed};
    *info = nothing_else;
    return (fmi2Status)status;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    ALLOW(FMU_EVENTS, "fmi2EnterContinuousTimeMode");
    return (fmi2Status)fmu_enter_continuous(c);
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no_set_state_before,
                                       fmi2Boolean *enter_event_mode, fmi2Boolean *terminate) {
    (void)no_set_state_before;
    ALLOW(FMU_CONTINUOUS, "fmi2CompletedIntegratorStep");
    REFUSE_IF(!enter_event_mode || !terminate, "fmi2CompletedIntegratorStep: an argument is NULL");
    *enter_event_mode = *terminate = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) {
    ALLOW(EXCHANGE, "fmi2SetTime");
    return (fmi2Status)fmu_set_time(c, time);
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real states[], size_t count) {
    ALLOW(FMU_CONTINUOUS, "fmi2SetContinuousStates");
    return (fmi2Status)fmu_set_states(c, states, count);
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t count) {
    ALLOW(EXCHANGE, "fmi2GetDerivatives");
    return (fmi2Status)fmu_get_rates(c, derivatives, count);
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real indicators[], size_t count) {
    (void)indicators;
    ALLOW(EXCHANGE, "fmi2GetEventIndicators");
    REFUSE_IF(count > 0, "fmi2GetEventIndicators: there are none");
    return fmi2OK;
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real states[], size_t count) {
    ALLOW(EXCHANGE, "fmi2GetContinuousStates");
    return (fmi2Status)fmu_get_states(c, states, count);
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real nominals[], size_t count) {
    ALLOW(EXCHANGE, "fmi2GetNominalsOfContinuousStates");
    return (fmi2Status)fmu_get_nominals(c, nominals, count);
}

/* ---- Co-Simulation --------------------------------------------------------------------- */

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[],
                                       size_t count, const fmi2Integer order[],
                                       const fmi2Real value[]) {
    ALLOW(FMU_INITIALIZATION | FMU_STEPPING, "fmi2SetRealInputDerivatives");
    REFUSE_IF(count > 0 && (!vr || !order || !value),
              "fmi2SetRealInputDerivatives: an array is NULL");
    for (size_t k = 0; k < count; k++)
        REFUSE_IF(order[k] != 1, "fmi2SetRealInputDerivatives: order must be 1");
    return (fmi2Status)fmu_set_input_rates(c, vr, count, value);
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[],
                                        size_t count, const fmi2Integer order[],
                                        fmi2Real value[]) {
    ALLOW(FMU_STEPPING, "fmi2GetRealOutputDerivatives");
    REFUSE_IF(count > 0 && (!vr || !order || !value),
              "fmi2GetRealOutputDerivatives: an array is NULL");
    for (size_t k = 0; k < count; k++)
        REFUSE_IF(order[k] != 1, "fmi2GetRealOutputDerivatives: order must be 1");
    return (fmi2Status)fmu_output_derivatives(c, vr, count, value);
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step,
                      fmi2Boolean no_set_state_before) {
    (void)no_set_state_before;
    ALLOW(FMU_STEPPING, "fmi2DoStep");
    return (fmi2Status)fmu_step(c, time, step);
}

fmi2Status fmi2CancelStep(fmi2Component c) {
    ALLOW(FMU_STEPPING, "fmi2CancelStep");
    REFUSE_IF(1, "fmi2CancelStep: no step is under way");
}

/* A step is over when fmi2DoStep returns: only where it got to can be asked. */
static fmi2Status refuse_status(fmi2Component c, const char *name) {
    ALLOW(FMU_STEPPING | FMU_TERMINATED, name);
    return (fmi2Status)fmu_say(c, FMU_DISCARD, "%s: steps are never pending", name);
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
    (void)kind, (void)value;
    return refuse_status(c, "fmi2GetStatus");
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    ALLOW(FMU_STEPPING | FMU_TERMINATED, "fmi2GetRealStatus");
    if (kind != fmi2LastSuccessfulTime) return refuse_status(c, "fmi2GetRealStatus");
    REFUSE_IF(!value, "fmi2GetRealStatus: the value is NULL");
    *value = fmu_time(c);
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) {
    (void)kind, (void)value;
    return refuse_status(c, "fmi2GetIntegerStatus");
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    ALLOW(FMU_STEPPING | FMU_TERMINATED, "fmi2GetBooleanStatus");
    if (kind != fmi2Terminated) return refuse_status(c, "fmi2GetBooleanStatus");
    REFUSE_IF(!value, "fmi2GetBooleanStatus: the value is NULL");
    *value = ((const fmu_instance *)c)->terminated;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
    (void)kind, (void)value;
    return refuse_status(c, "fmi2GetStringStatus");
}
