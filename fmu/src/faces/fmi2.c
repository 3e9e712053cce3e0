/* FMI 2.0: calls an instance by the names and types of the standard. */
#include "fmi2Functions.h"

typedef fmi2Component fmi_instance;
typedef fmi2FMUstate fmi_state;

#define FMI(name) FMI_JOINED(name)
#define FMI_JOINED(name) fmi2##name
#define GET_STATE GetFMUstate
#define SET_STATE SetFMUstate
#define FREE_STATE FreeFMUstate
#define STATE_SIZE SerializedFMUstateSize
#define SERIALIZE SerializeFMUstate
#define DESERIALIZE DeSerializeFMUstate
#define GET_RATES GetDerivatives
#include "faces/calls.h"

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
    if (type == fmi2ModelExchange || type == fmi2CoSimulation)
        return fmu_instantiate(type == fmi2CoSimulation ? FMU_CO_SIMULATION : FMU_MODEL_EXCHANGE,
                               name, guid, location, &logger);
    fmu_log(&logger, name ? name : "(no name)", FMU_ERROR, "no such interface type");
    return NULL;
}

CALL(SetupExperiment, FMU_INSTANTIATED,
     (fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance, fmi2Real start,
      fmi2Boolean stop_defined, fmi2Real stop),
     fmu_setup(c, tolerance_defined, tolerance, start, stop_defined, stop))
CALL(EnterInitializationMode, FMU_INSTANTIATED, (fmi2Component c),
     fmu_enter(c, FMU_INITIALIZATION))

/* ---- variables ------------------------------------------------------------------------- */

#define GET_AND_SET(name, get, set)                                                           \
    fmi2Status fmi2Get##name(VARIABLES, fmi2##name value[]) {                                 \
        ALLOW(FMU_READABLE, Get##name);                                                           \
        REFUSE_IF(count > 0 && (!vr || !value), Get##name, "an array is NULL");               \
        return (fmi2Status)(get);                                                             \
    }                                                                                         \
    fmi2Status fmi2Set##name(VARIABLES, const fmi2##name value[]) {                           \
        ALLOW(FMU_SETTABLE, Set##name);                                                           \
        REFUSE_IF(count > 0 && (!vr || !value), Set##name, "an array is NULL");               \
        return (fmi2Status)(set);                                                             \
    }
GET_AND_SET(Real, fmu_get_reals(c, vr, count, value, count, 0),
            fmu_set_reals(c, vr, count, value))
GET_AND_SET(Integer, fmu_get_integers(c, FMU_ENUMERATION, vr, count, value),
            fmu_set_integers(c, FMU_ENUMERATION, vr, count, value))
GET_AND_SET(Boolean, fmu_get_integers(c, FMU_BOOLEAN, vr, count, value),
            fmu_set_integers(c, FMU_BOOLEAN, vr, count, value))

NO_VALUES(GetString, FMU_READABLE, (VARIABLES, fmi2String value[]), "the FMU has no strings")
NO_VALUES(SetString, FMU_SETTABLE, (VARIABLES, const fmi2String value[]), "the FMU has no strings")

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[],
                                        size_t unknowns, const fmi2ValueReference known[],
                                        size_t knowns, const fmi2Real dv_known[],
                                        fmi2Real dv_unknown[]) {
    ALLOW(FMU_READABLE, GetDirectionalDerivative);
    REFUSE_IF((unknowns > 0 && (!unknown || !dv_unknown)) || (knowns > 0 && (!known || !dv_known)),
              GetDirectionalDerivative, "an array is NULL");
    const fmu_derivative d = {unknown, unknowns, known, knowns, dv_known, dv_unknown};
    return (fmi2Status)fmu_directional(c, &d);
}

/* ---- Model Exchange -------------------------------------------------------------------- */

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

fmi2Status fmi2SetRealInputDerivatives(VARIABLES, const fmi2Integer order[],
                                       const fmi2Real value[]) {
    ALLOW(FMU_INITIALIZATION | FMU_STEPPING, SetRealInputDerivatives);
    REFUSE_IF(count > 0 && (!vr || !order || !value),
              SetRealInputDerivatives, "an array is NULL");
    for (size_t k = 0; k < count; k++)
        REFUSE_IF(order[k] != 1, SetRealInputDerivatives, "order must be 1");
    return (fmi2Status)fmu_set_input_rates(c, vr, count, value);
}

fmi2Status fmi2GetRealOutputDerivatives(VARIABLES, const fmi2Integer order[],
                                        fmi2Real value[]) {
    ALLOW(FMU_STEPPING, GetRealOutputDerivatives);
    REFUSE_IF(count > 0 && (!vr || !order || !value),
              GetRealOutputDerivatives, "an array is NULL");
    for (size_t k = 0; k < count; k++)
        REFUSE_IF(order[k] != 1, GetRealOutputDerivatives, "order must be 1");
    const fmu_derivative d = {.unknown = vr, .unknowns = count, .value = value};
    return (fmi2Status)fmu_output_derivatives(c, &d);
}

CALL(DoStep, FMU_STEPPING,
     (fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_set_state_before),
     fmu_step(c, time, step))
ABSENT(CancelStep, FMU_STEPPING, (fmi2Component c), "no step is under way")

/* A step is over when fmi2DoStep returns: only its end time and termination have a status. */
#define NO_STATUS(call, type)                                                                 \
    CALL(call, FMU_STEPPING | FMU_TERMINATED,                                                 \
         (fmi2Component c, const fmi2StatusKind kind, type *value),                           \
         fmu_say(c, FMU_DISCARD, "%s: steps are never pending", FMI_NAME(call)))
NO_STATUS(GetStatus, fmi2Status)
NO_STATUS(GetIntegerStatus, fmi2Integer)
NO_STATUS(GetStringStatus, fmi2String)

#define ONE_STATUS(call, type, its_kind, present)                                             \
    fmi2Status fmi2##call(fmi2Component c, const fmi2StatusKind kind, type *value) {          \
        ALLOW(FMU_STEPPING | FMU_TERMINATED, call);                                           \
        if (kind != (its_kind))                                                               \
            return (fmi2Status)fmu_say(c, FMU_DISCARD, "%s: steps are never pending",         \
                                       FMI_NAME(call));                                       \
        REFUSE_IF(!value, call, "the value is NULL");                                         \
        *value = ((const fmu_instance *)c)->present;                                          \
        return fmi2OK;                                                                        \
    }
ONE_STATUS(GetRealStatus, fmi2Real, fmi2LastSuccessfulTime, outputs[0])
ONE_STATUS(GetBooleanStatus, fmi2Boolean, fmi2Terminated, terminated)
