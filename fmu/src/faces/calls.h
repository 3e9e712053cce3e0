/* Calls that FMI 2.0 and 3.0 share. The source of a version defines before it
 *
 *   FMI(call)   the call's name with the version's prefix
 *
 * the types fmi_instance, fmi_status, fmi_boolean, fmi_state, fmi_string and fmi_byte, and as
 * GET_STATE, SET_STATE, FREE_STATE, STATE_SIZE, SERIALIZE, DESERIALIZE and GET_RATES the names that
 * differ. */
#include "instance/instance.h"
#include "resources/files.h"

#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-parameter" /* the standard passes more than is needed */
#endif

#define FMI_NAME(call) FMI_STRING(FMI(call)) /* "fmi3DoStep" */
#define FMI_STRING(name) FMI_QUOTED(name)
#define FMI_QUOTED(name) #name

#define ALLOW(states, call) \
    if (fmu_allow(c, (states), FMI_NAME(call)) != FMU_OK) return (fmi_status)FMU_ERROR
#define REFUSE_IF(condition, call, reason) \
    if (condition) return (fmi_status)fmu_say(c, FMU_ERROR, "%s", FMI_NAME(call) ": " reason)

#define EXCHANGE (FMU_EVENTS | FMU_CONTINUOUS)
#define SETTABLE (FMU_BEFORE_START | FMU_RUNNING)
#define READABLE ((FMU_ANY & ~FMU_INSTANTIATED) | FMU_INTERMEDIATE)

const char *FMI(GetVersion)(void) { return FMI(Version); }

fmi_status FMI(SetDebugLogging)(fmi_instance c, fmi_boolean on, size_t count,
                                const fmi_string categories[]) {
    ALLOW(FMU_ANY, SetDebugLogging);
    return (fmi_status)fmu_set_logging(c, on, count, categories);
}

void FMI(FreeInstance)(fmi_instance c) { fmu_free(c); }

fmi_status FMI(ExitInitializationMode)(fmi_instance c) {
    ALLOW(FMU_INITIALIZATION, ExitInitializationMode);
    return (fmi_status)fmu_exit_initialization(c);
}

fmi_status FMI(Terminate)(fmi_instance c) {
    ALLOW(FMU_RUNNING, Terminate);
    ((fmu_instance *)c)->state = FMU_TERMINATED;
    return (fmi_status)FMU_OK;
}

fmi_status FMI(Reset)(fmi_instance c) {
    ALLOW(FMU_ANY, Reset);
    return (fmi_status)fmu_reset(c);
}

/* ---- state ----------------------------------------------------------------------------- */

fmi_status FMI(GET_STATE)(fmi_instance c, fmi_state *state) {
    ALLOW(FMU_ANY, GET_STATE);
    return (fmi_status)fmu_snapshot_take(c, (fmu_snapshot **)state);
}

fmi_status FMI(SET_STATE)(fmi_instance c, fmi_state state) {
    ALLOW(FMU_ANY, SET_STATE);
    return (fmi_status)fmu_snapshot_apply(c, state);
}

fmi_status FMI(FREE_STATE)(fmi_instance c, fmi_state *state) {
    ALLOW(FMU_ANY, FREE_STATE);
    if (!state) return (fmi_status)FMU_OK;
    fmu_snapshot_free(*state);
    *state = NULL;
    return (fmi_status)FMU_OK;
}

fmi_status FMI(STATE_SIZE)(fmi_instance c, fmi_state state, size_t *size) {
    ALLOW(FMU_ANY, STATE_SIZE);
    return (fmi_status)fmu_snapshot_size(c, state, size);
}

fmi_status FMI(SERIALIZE)(fmi_instance c, fmi_state state, fmi_byte bytes[], size_t size) {
    ALLOW(FMU_ANY, SERIALIZE);
    return (fmi_status)fmu_snapshot_write(c, state, bytes, size);
}

fmi_status FMI(DESERIALIZE)(fmi_instance c, const fmi_byte bytes[], size_t size,
                            fmi_state *state) {
    ALLOW(FMU_ANY, DESERIALIZE);
    return (fmi_status)fmu_snapshot_read(c, bytes, size, (fmu_snapshot **)state);
}

/* ---- Model Exchange -------------------------------------------------------------------- */

fmi_status FMI(EnterContinuousTimeMode)(fmi_instance c) {
    ALLOW(FMU_EVENTS, EnterContinuousTimeMode);
    return (fmi_status)fmu_enter_continuous(c);
}

fmi_status FMI(CompletedIntegratorStep)(fmi_instance c, fmi_boolean no_set_state_before,
                                        fmi_boolean *enter_event_mode, fmi_boolean *terminate) {
    ALLOW(FMU_CONTINUOUS, CompletedIntegratorStep);
    REFUSE_IF(!enter_event_mode || !terminate, CompletedIntegratorStep, "an argument is NULL");
    *enter_event_mode = *terminate = 0;
    return (fmi_status)FMU_OK;
}

fmi_status FMI(SetTime)(fmi_instance c, double time) {
    ALLOW(EXCHANGE, SetTime);
    return (fmi_status)fmu_set_time(c, time);
}

fmi_status FMI(SetContinuousStates)(fmi_instance c, const double states[], size_t count) {
    ALLOW(FMU_CONTINUOUS, SetContinuousStates);
    return (fmi_status)fmu_set_states(c, states, count);
}

fmi_status FMI(GetContinuousStates)(fmi_instance c, double states[], size_t count) {
    ALLOW(EXCHANGE, GetContinuousStates);
    return (fmi_status)fmu_get_states(c, states, count);
}

fmi_status FMI(GET_RATES)(fmi_instance c, double derivatives[], size_t count) {
    ALLOW(EXCHANGE, GET_RATES);
    return (fmi_status)fmu_get_rates(c, derivatives, count);
}

fmi_status FMI(GetNominalsOfContinuousStates)(fmi_instance c, double nominals[], size_t count) {
    ALLOW(EXCHANGE, GetNominalsOfContinuousStates);
    return (fmi_status)fmu_get_nominals(c, nominals, count);
}

fmi_status FMI(GetEventIndicators)(fmi_instance c, double indicators[], size_t count) {
    ALLOW(EXCHANGE, GetEventIndicators);
    REFUSE_IF(count > 0, GetEventIndicators, "there are none");
    return (fmi_status)FMU_OK;
}
