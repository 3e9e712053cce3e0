/* FMI 2.0: calls an instance by the names and types of the standard. */
#include "fmi2Functions.h"

#include <stdlib.h>

typedef fmi2Component fmi_instance;
typedef fmi2Status fmi_status;
typedef fmi2Boolean fmi_boolean;
typedef fmi2FMUstate fmi_state;
typedef fmi2String fmi_string;
typedef fmi2Byte fmi_byte;

#define FMI(call) FMI_JOINED(call)
#define FMI_JOINED(call) fmi2##call
#define GET_STATE GetFMUstate
#define SET_STATE SetFMUstate
#define FREE_STATE FreeFMUstate
#define STATE_SIZE SerializedFMUstateSize
#define SERIALIZE SerializeFMUstate
#define DESERIALIZE DeSerializeFMUstate
#define GET_RATES GetDerivatives
#include "faces/calls.h"

/* Refuses NULL for arrays of `count` elements. */
#define NEED_ARRAYS(count, call) \
    REFUSE_IF((count) > 0 && (!vr || !value), call, "an array is NULL")

/* Passes the message as the format: some importers do not read the arguments of "%s". */
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

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String location,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean logging) {
    if (!functions) return NULL; /* there is no logger for the reason */
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

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean stop_defined, fmi2Real stop) {
    ALLOW(FMU_INSTANTIATED, SetupExperiment);
    return (fmi2Status)fmu_setup(c, tolerance_defined, tolerance, start, stop_defined, stop);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    ALLOW(FMU_INSTANTIATED, EnterInitializationMode);
    ((fmu_instance *)c)->state = FMU_INITIALIZATION;
    return fmi2OK;
}

/* ---- variables ------------------------------------------------------------------------- */

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                       fmi2Real value[]) {
    ALLOW(READABLE, GetReal);
    NEED_ARRAYS(count, GetReal);
    return (fmi2Status)fmu_get_reals(c, vr, count, value);
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                       const fmi2Real value[]) {
    ALLOW(SETTABLE, SetReal);
    NEED_ARRAYS(count, SetReal);
    return (fmi2Status)fmu_set_reals(c, vr, count, value);
}

#define INTEGERS(name, type)                                                                   \
    fmi2Status fmi2Get##name(fmi2Component c, const fmi2ValueReference vr[], size_t count,     \
                             fmi2##name value[]) {                                             \
        ALLOW(READABLE, Get##name);                                                            \
        NEED_ARRAYS(count, Get##name);                                                         \
        return (fmi2Status)fmu_get_integers(c, type, vr, count, value);                        \
    }                                                                                          \
    fmi2Status fmi2Set##name(fmi2Component c, const fmi2ValueReference vr[], size_t count,     \
                             const fmi2##name value[]) {                                       \
        ALLOW(SETTABLE, Set##name);                                                            \
        NEED_ARRAYS(count, Set##name);                                                         \
        return (fmi2Status)fmu_set_integers(c, type, vr, count, value);                        \
    }
INTEGERS(Integer, FMU_ENUMERATION)
INTEGERS(Boolean, FMU_BOOLEAN)

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                         fmi2String value[]) {
    ALLOW(READABLE, GetString);
    REFUSE_IF(count > 0, GetString, "the FMU has no strings");
    return fmi2OK;
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                         const fmi2String value[]) {
    ALLOW(SETTABLE, SetString);
    REFUSE_IF(count > 0, SetString, "the FMU has no strings");
    return fmi2OK;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[],
                                        size_t unknowns, const fmi2ValueReference known[],
                                        size_t knowns, const fmi2Real dv_known[],
                                        fmi2Real dv_unknown[]) {
    ALLOW(READABLE, GetDirectionalDerivative);
    REFUSE_IF((unknowns > 0 && (!unknown || !dv_unknown)) || (knowns > 0 && (!known || !dv_known)),
              GetDirectionalDerivative, "an array is NULL");
    const fmu_derivative d = {unknown, unknowns, known, knowns, dv_known, dv_unknown};
    return (fmi2Status)fmu_directional(c, &d);
}

/* ---- Model Exchange -------------------------------------------------------------------- */

fmi2Status fmi2EnterEventMode(fmi2Component c) {
    ALLOW(EXCHANGE, EnterEventMode);
    return (fmi2Status)fmu_enter_events(c);
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    ALLOW(FMU_EVENTS, NewDiscreteStates);
    REFUSE_IF(!info, NewDiscreteStates, "the event info is NULL");
    int states_changed;
    const fmu_status status = fmu_update_discrete(c, &states_changed);
    const fmi2EventInfo nothing_else = {
        .valuesOfContinuousStatesChanged = status == FMU_OK && states_changed};
    *info = nothing_else;
    return (fmi2Status)status;
}

/* ---- Co-Simulation --------------------------------------------------------------------- */

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[],
                                       size_t count, const fmi2Integer order[],
                                       const fmi2Real value[]) {
    ALLOW(FMU_INITIALIZATION | FMU_STEPPING, SetRealInputDerivatives);
    REFUSE_IF(count > 0 && (!vr || !order || !value),
              SetRealInputDerivatives, "an array is NULL");
    for (size_t k = 0; k < count; k++)
        REFUSE_IF(order[k] != 1, SetRealInputDerivatives, "order must be 1");
    return (fmi2Status)fmu_set_input_rates(c, vr, count, value);
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[],
                                        size_t count, const fmi2Integer order[],
                                        fmi2Real value[]) {
    ALLOW(FMU_STEPPING, GetRealOutputDerivatives);
    REFUSE_IF(count > 0 && (!vr || !order || !value),
              GetRealOutputDerivatives, "an array is NULL");
    for (size_t k = 0; k < count; k++)
        REFUSE_IF(order[k] != 1, GetRealOutputDerivatives, "order must be 1");
    const fmu_derivative d = {.unknown = vr, .unknowns = count, .value = value};
    return (fmi2Status)fmu_output_derivatives(c, &d);
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step,
                      fmi2Boolean no_set_state_before) {
    ALLOW(FMU_STEPPING, DoStep);
    return (fmi2Status)fmu_step(c, time, step);
}

fmi2Status fmi2CancelStep(fmi2Component c) {
    ALLOW(FMU_STEPPING, CancelStep);
    REFUSE_IF(1, CancelStep, "no step is under way");
}

/* A step is over when fmi2DoStep returns: only its end time and termination have a status. */
static fmi2Status refuse_status(fmi2Component c, const char *call) {
    if (fmu_allow(c, FMU_STEPPING | FMU_TERMINATED, call) != FMU_OK) return fmi2Error;
    return (fmi2Status)fmu_say(c, FMU_DISCARD, "%s: steps are never pending", call);
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
    return refuse_status(c, "fmi2GetStatus");
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    ALLOW(FMU_STEPPING | FMU_TERMINATED, GetRealStatus);
    if (kind != fmi2LastSuccessfulTime) return refuse_status(c, "fmi2GetRealStatus");
    REFUSE_IF(!value, GetRealStatus, "the value is NULL");
    *value = ((const fmu_instance *)c)->outputs[0];
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) {
    return refuse_status(c, "fmi2GetIntegerStatus");
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    ALLOW(FMU_STEPPING | FMU_TERMINATED, GetBooleanStatus);
    if (kind != fmi2Terminated) return refuse_status(c, "fmi2GetBooleanStatus");
    REFUSE_IF(!value, GetBooleanStatus, "the value is NULL");
    *value = ((const fmu_instance *)c)->terminated;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
    return refuse_status(c, "fmi2GetStringStatus");
}
