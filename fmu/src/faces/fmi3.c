/* FMI 3.0: calls an instance by the names and types of the standard. Calls for types, clocks and
 * modes that the FMU does not have are at the end. */
#include "fmi3Functions.h"

#include <stdlib.h>

typedef fmi3Instance fmi_instance;
typedef fmi3FMUState fmi_state;

#define FMI(name) FMI_JOINED(name)
#define FMI_JOINED(name) fmi3##name
#define GET_STATE GetFMUState
#define SET_STATE SetFMUState
#define FREE_STATE FreeFMUState
#define STATE_SIZE SerializedFMUStateSize
#define SERIALIZE SerializeFMUState
#define DESERIALIZE DeserializeFMUState
#define GET_RATES GetContinuousStateDerivatives
#include "faces/calls.h"

/* Refuses NULL for arrays of `count` elements, and another number of values. */
#define NEED_ARRAYS(count, values, call)                                 \
    REFUSE_IF((count) > 0 && (!vr || !value), call, "an array is NULL"); \
    REFUSE_IF((values) != (count), call, "as many values are needed as value references")

static void write_log(const fmu_logger *logger, const char *name, fmu_status status,
                      const char *category, const char *message) {
    const fmi3LogMessageCallback callback = (fmi3LogMessageCallback)logger->callback;
    if (callback) callback(logger->environment, (fmi3Status)status, category, message);
}

static fmu_logger logger_of(fmi3InstanceEnvironment environment, fmi3LogMessageCallback callback,
                            fmi3Boolean logging) {
    const fmu_logger logger = {.write = write_log,
                               .callback = (void (*)(void))callback,
                               .environment = environment,
                               .events = logging};
    return logger;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String path,
                                          fmi3Boolean visible, fmi3Boolean logging,
                                          fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback callback) {
    const fmu_logger logger = logger_of(environment, callback, logging);
    return fmu_instantiate(FMU_MODEL_EXCHANGE, name, token, path, &logger);
}

/* Inputs cannot be set within a step: each moves at its rate. */
static int call_back(const fmu_observer *observer, double time, int may_end, double *end) {
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
    const fmu_logger logger = logger_of(environment, callback, logging);
    const fmu_observer observer = {.update = update ? call_back : NULL,
                                   .callback = (void (*)(void))update,
                                   .environment = environment};
    if (intermediates > 0 && !(intermediate && update)) {
        fmu_log(&logger, name, FMU_ERROR, "required intermediate variables need a callback");
        return NULL;
    }
    fmu_instance *c = fmu_instantiate(FMU_CO_SIMULATION, name, token, path, &logger);
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
    const fmu_logger logger = logger_of(environment, callback, logging);
    fmu_log(&logger, name, FMU_ERROR, "the FMU has no scheduled execution");
    return NULL;
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean tolerance_defined,
                                       fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean stop_defined, fmi3Float64 stop) {
    ALLOW(FMU_INSTANTIATED, EnterInitializationMode);
    const fmu_status status =
        fmu_setup(c, tolerance_defined, tolerance, start, stop_defined, stop);
    if (status == FMU_ERROR) return fmi3Error;
    ((fmu_instance *)c)->state = FMU_INITIALIZATION;
    return (fmi3Status)status;
}

/* ---- variables ------------------------------------------------------------------------- */

fmi3Status fmi3GetFloat64(VARIABLES, fmi3Float64 value[], size_t values) {
    ALLOW(FMU_READABLE, GetFloat64);
    REFUSE_IF(count > 0 && (!vr || !value), GetFloat64, "an array is NULL");
    return (fmi3Status)fmu_get_reals(c, vr, count, value, values, 1);
}

fmi3Status fmi3SetFloat64(VARIABLES, const fmi3Float64 value[], size_t values) {
    ALLOW(FMU_SETTABLE, SetFloat64);
    NEED_ARRAYS(count, values, SetFloat64);
    return (fmi3Status)fmu_set_reals(c, vr, count, value);
}

/* Enumerations and booleans, which have another width in the instance. */
#define GET_INTEGERS(name, type)                                                              \
    fmi3Status fmi3Get##name(VARIABLES, fmi3##name value[], size_t values) {                  \
        ALLOW(FMU_READABLE, Get##name);                                                           \
        NEED_ARRAYS(count, values, Get##name);                                                \
        for (size_t k = 0; k < count; k++) {                                                  \
            int32_t present;                                                                  \
            const fmu_status status = fmu_get_integers(c, type, &vr[k], 1, &present);         \
            if (status != FMU_OK) return (fmi3Status)status;                                  \
            value[k] = (fmi3##name)present;                                                   \
        }                                                                                     \
        return fmi3OK;                                                                        \
    }
GET_INTEGERS(Int64, FMU_ENUMERATION)
GET_INTEGERS(Boolean, FMU_BOOLEAN)

fmi3Status fmi3SetBoolean(VARIABLES, const fmi3Boolean value[], size_t values) {
    ALLOW(FMU_SETTABLE, SetBoolean);
    NEED_ARRAYS(count, values, SetBoolean);
    for (size_t k = 0; k < count; k++) {
        const int32_t wanted = value[k];
        const fmu_status status = fmu_set_integers(c, FMU_BOOLEAN, &vr[k], 1, &wanted);
        if (status != FMU_OK) return (fmi3Status)status;
    }
    return fmi3OK;
}

typedef fmu_status derivative(fmu_instance *instance, const fmu_derivative *arguments);

/* Calls `find` with arrays among the unknowns as their elements. The unknowns must have
 * `unknown_values` elements, the knowns `known_values`. */
static fmi3Status get_derivative(fmu_instance *c, const char *call, derivative *find,
                                 fmu_derivative arguments, size_t unknown_values,
                                 size_t known_values) {
    uint32_t *scalar = fmu_scalars(c, &arguments);
    if (!scalar) return fmi3Error;
    const int fit = arguments.unknowns == unknown_values && arguments.knowns == known_values;
    const fmu_status status =
        fit ? find(c, &arguments)
            : fmu_say(c, FMU_ERROR, "%s: as many values are needed as the variables have", call);
    free(scalar);
    return (fmi3Status)status;
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknown[],
                                        size_t unknowns, const fmi3ValueReference known[],
                                        size_t knowns, const fmi3Float64 seed[], size_t seeds,
                                        fmi3Float64 sensitivity[], size_t sensitivities) {
    ALLOW(FMU_READABLE, GetDirectionalDerivative);
    REFUSE_IF((unknowns > 0 && (!unknown || !sensitivity)) || (knowns > 0 && (!known || !seed)),
              GetDirectionalDerivative, "an array is NULL");
    const fmu_derivative d = {unknown, unknowns, known, knowns, seed, sensitivity};
    return get_derivative(c, FMI_NAME(GetDirectionalDerivative), fmu_directional, d,
                          sensitivities, seeds);
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance c, const fmi3ValueReference unknown[],
                                    size_t unknowns, const fmi3ValueReference known[],
                                    size_t knowns, const fmi3Float64 seed[], size_t seeds,
                                    fmi3Float64 sensitivity[], size_t sensitivities) {
    ALLOW(FMU_READABLE, GetAdjointDerivative);
    REFUSE_IF((unknowns > 0 && (!unknown || !seed)) || (knowns > 0 && (!known || !sensitivity)),
              GetAdjointDerivative, "an array is NULL");
    const fmu_derivative d = {unknown, unknowns, known, knowns, seed, sensitivity};
    return get_derivative(c, FMI_NAME(GetAdjointDerivative), fmu_adjoint, d, seeds,
                          sensitivities);
}

fmi3Status fmi3GetOutputDerivatives(VARIABLES, const fmi3Int32 order[], fmi3Float64 value[],
                                    size_t values) {
    ALLOW(FMU_STEPPING | FMU_STEP_EVENTS, GetOutputDerivatives);
    REFUSE_IF(count > 0 && (!vr || !value || !order), GetOutputDerivatives, "an array is NULL");
    for (size_t k = 0; k < count; k++)
        REFUSE_IF(order[k] != 1, GetOutputDerivatives, "order must be 1");
    const fmu_derivative d = {.unknown = vr, .unknowns = count, .value = value};
    return get_derivative(c, FMI_NAME(GetOutputDerivatives), fmu_output_derivatives, d, values, 0);
}

/* ---- events ---------------------------------------------------------------------------- */

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *update_needed,
                                    fmi3Boolean *terminate, fmi3Boolean *nominals_changed,
                                    fmi3Boolean *states_changed, fmi3Boolean *next_time_defined,
                                    fmi3Float64 *next_time) {
    ALLOW(FMU_EVENTS | FMU_STEP_EVENTS, UpdateDiscreteStates);
    REFUSE_IF(!update_needed || !terminate || !nominals_changed || !states_changed ||
                  !next_time_defined || !next_time,
              UpdateDiscreteStates, "an argument is NULL");
    int changed;
    const fmu_status status = fmu_update_discrete(c, &changed);
    *update_needed = *terminate = *nominals_changed = *next_time_defined = fmi3False;
    *states_changed = status == FMU_OK && changed;
    *next_time = 0.0;
    return (fmi3Status)status;
}

/* ---- Model Exchange -------------------------------------------------------------------- */

#define GET_NUMBER(call, number)                             \
    fmi3Status fmi3##call(fmi3Instance c, size_t *count) {   \
        ALLOW(FMU_ANY, call);                                \
        REFUSE_IF(!count, call, "the number is NULL");       \
        *count = (number);                                   \
        return fmi3OK;                                       \
    }
GET_NUMBER(GetNumberOfEventIndicators, 0)
GET_NUMBER(GetNumberOfContinuousStates, fmu_state_count(c))

/* ---- Co-Simulation --------------------------------------------------------------------- */

CALL(EnterStepMode, FMU_STEP_EVENTS, (fmi3Instance c), fmu_enter(c, FMU_STEPPING))

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 step,
                      fmi3Boolean no_set_state_before, fmi3Boolean *event_handling_needed,
                      fmi3Boolean *terminate, fmi3Boolean *early_return, fmi3Float64 *last_time) {
    ALLOW(FMU_STEPPING, DoStep);
    REFUSE_IF(!event_handling_needed || !terminate || !early_return || !last_time,
              DoStep, "an argument is NULL");
    const fmu_status status = fmu_step(c, time, step);
    const fmu_instance *instance = c;
    *event_handling_needed = fmi3False;
    *last_time = instance->outputs[0];
    *early_return = status == FMU_OK && *last_time < time + step - 1e-9 * step; /* not by rounding */
    *terminate = instance->terminated != 0;
    return (fmi3Status)status;
}

/* ---- calls for what the FMU does not have: refused, with a logged reason ----------------- */

/* No variable has this type: only empty lists are allowed. */
#define NO_SETTER(type)                                                                       \
    fmi3Status fmi3Set##type(VARIABLES, const fmi3##type value[], size_t values) {            \
        ALLOW(FMU_SETTABLE, Set##type);                                                           \
        REFUSE_IF(count > 0 || values > 0, Set##type, "no variable of this type is set");     \
        return fmi3OK;                                                                        \
    }
#define NO_SUCH_TYPE(type)                                                                    \
    NO_SETTER(type)                                                                           \
    fmi3Status fmi3Get##type(VARIABLES, fmi3##type value[], size_t values) {                  \
        ALLOW(FMU_READABLE, Get##type);                                                           \
        REFUSE_IF(count > 0 || values > 0, Get##type, "no variable has this type");           \
        return fmi3OK;                                                                        \
    }

NO_SUCH_TYPE(Float32)
NO_SUCH_TYPE(Int8)
NO_SUCH_TYPE(UInt8)
NO_SUCH_TYPE(Int16)
NO_SUCH_TYPE(UInt16)
NO_SUCH_TYPE(Int32)
NO_SUCH_TYPE(UInt32)
NO_SETTER(Int64)
NO_SUCH_TYPE(UInt64)
NO_SUCH_TYPE(String)

ABSENT(GetBinary, FMU_ANY,
       (VARIABLES, size_t sizes[], fmi3Binary value[], size_t values), "no variable has this type")
ABSENT(SetBinary, FMU_ANY,
       (VARIABLES, const size_t sizes[], const fmi3Binary value[], size_t values),
       "no variable has this type")
ABSENT(GetClock, FMU_ANY, (VARIABLES, fmi3Clock value[]), "there are no clocks")
ABSENT(SetClock, FMU_ANY, (VARIABLES, const fmi3Clock value[]), "there are no clocks")
ABSENT(GetNumberOfVariableDependencies, FMU_ANY,
       (fmi3Instance c, fmi3ValueReference vr, size_t *count), "the model description lists all")
ABSENT(GetVariableDependencies, FMU_ANY,
       (fmi3Instance c, fmi3ValueReference dependent, size_t element[],
        fmi3ValueReference independent[], size_t independent_element[],
        fmi3DependencyKind kind[], size_t count),
       "the model description lists all")
ABSENT(EnterConfigurationMode, FMU_ANY, (fmi3Instance c), "there are no structural parameters")
ABSENT(ExitConfigurationMode, FMU_ANY, (fmi3Instance c), "there are no structural parameters")
ABSENT(GetIntervalDecimal, FMU_ANY,
       (VARIABLES, fmi3Float64 interval[], fmi3IntervalQualifier qualifier[]),
       "there are no clocks")
ABSENT(GetIntervalFraction, FMU_ANY,
       (VARIABLES, fmi3UInt64 counter[], fmi3UInt64 resolution[],
        fmi3IntervalQualifier qualifier[]),
       "there are no clocks")
ABSENT(GetShiftDecimal, FMU_ANY, (VARIABLES, fmi3Float64 shift[]), "there are no clocks")
ABSENT(GetShiftFraction, FMU_ANY,
       (VARIABLES, fmi3UInt64 counter[], fmi3UInt64 resolution[]), "there are no clocks")
ABSENT(SetIntervalDecimal, FMU_ANY,
       (VARIABLES, const fmi3Float64 interval[]), "there are no clocks")
ABSENT(SetIntervalFraction, FMU_ANY,
       (VARIABLES, const fmi3UInt64 counter[], const fmi3UInt64 resolution[]),
       "there are no clocks")
ABSENT(SetShiftDecimal, FMU_ANY, (VARIABLES, const fmi3Float64 shift[]), "there are no clocks")
ABSENT(SetShiftFraction, FMU_ANY,
       (VARIABLES, const fmi3UInt64 counter[], const fmi3UInt64 resolution[]),
       "there are no clocks")
ABSENT(EvaluateDiscreteStates, FMU_ANY, (fmi3Instance c), "there are no discrete states")
ABSENT(ActivateModelPartition, FMU_ANY,
       (fmi3Instance c, fmi3ValueReference clock, fmi3Float64 time), "there are no clocks")
