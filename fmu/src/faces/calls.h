/* Calls that FMI 2.0 and 3.0 share. The source of a version defines before it
 *
 *   FMI(name)   a call or type by its name without the version's prefix
 *
 * the types fmi_instance and fmi_state, and as GET_STATE, SET_STATE, FREE_STATE, STATE_SIZE,
 * SERIALIZE, DESERIALIZE and GET_RATES the names that differ. */
#include "instance/instance.h"

#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-parameter" /* the standard passes more than is needed */
#endif

#define FMI_NAME(call) FMI_STRING(FMI(call)) /* "fmi3DoStep" */
#define FMI_STRING(name) FMI_QUOTED(name)
#define FMI_QUOTED(name) #name

#define ALLOW(states, call) \
    if (fmu_allow(c, (states), FMI_NAME(call)) != FMU_OK) return (FMI(Status))FMU_ERROR
#define REFUSE_IF(condition, call, reason) \
    if (condition) return (FMI(Status))fmu_say(c, FMU_ERROR, "%s", FMI_NAME(call) ": " reason)

/* A call of an instance c that is allowed in some states, and its result. */
#define CALL(call, states, parameters, result) \
    FMI(Status) FMI(call) parameters {         \
        ALLOW(states, call);                   \
        return (FMI(Status))(result);          \
    }
/* A call that is refused if it has any values, or always. */
#define NO_VALUES(call, states, parameters, reason) \
    FMI(Status) FMI(call) parameters {              \
        ALLOW(states, call);                        \
        REFUSE_IF(count > 0, call, reason);         \
        return (FMI(Status))FMU_OK;                 \
    }
#define ABSENT(call, states, parameters, reason) \
    CALL(call, states, parameters, fmu_say(c, FMU_ERROR, "%s", FMI_NAME(call) ": " reason))

/* The first parameters of calls for variables. */
#define VARIABLES fmi_instance c, const FMI(ValueReference) vr[], size_t count

const char *FMI(GetVersion)(void) { return FMI(Version); }

void FMI(FreeInstance)(fmi_instance c) { fmu_free(c); }

CALL(SetDebugLogging, FMU_ANY,
     (fmi_instance c, FMI(Boolean) on, size_t count, const FMI(String) categories[]),
     fmu_set_logging(c, on, count, categories))
CALL(ExitInitializationMode, FMU_INITIALIZATION, (fmi_instance c), fmu_exit_initialization(c))
CALL(Terminate, FMU_RUNNING, (fmi_instance c), fmu_enter(c, FMU_TERMINATED))
CALL(Reset, FMU_ANY, (fmi_instance c), fmu_reset(c))

/* ---- state ----------------------------------------------------------------------------- */

CALL(GET_STATE, FMU_ANY, (fmi_instance c, fmi_state *state),
     fmu_snapshot_take(c, (fmu_snapshot **)state))
CALL(SET_STATE, FMU_ANY, (fmi_instance c, fmi_state state), fmu_snapshot_apply(c, state))
CALL(FREE_STATE, FMU_ANY, (fmi_instance c, fmi_state *state),
     fmu_snapshot_free((fmu_snapshot **)state))
CALL(STATE_SIZE, FMU_ANY, (fmi_instance c, fmi_state state, size_t *size),
     fmu_snapshot_size(c, state, size))
CALL(SERIALIZE, FMU_ANY, (fmi_instance c, fmi_state state, FMI(Byte) bytes[], size_t size),
     fmu_snapshot_write(c, state, bytes, size))
CALL(DESERIALIZE, FMU_ANY,
     (fmi_instance c, const FMI(Byte) bytes[], size_t size, fmi_state *state),
     fmu_snapshot_read(c, bytes, size, (fmu_snapshot **)state))

/* ---- Model Exchange -------------------------------------------------------------------- */

CALL(EnterEventMode, FMU_EXCHANGE | FMU_STEPPING, (fmi_instance c), fmu_enter_events(c))
CALL(EnterContinuousTimeMode, FMU_EVENTS, (fmi_instance c), fmu_enter_continuous(c))
CALL(SetTime, FMU_EXCHANGE, (fmi_instance c, double time), fmu_set_time(c, time))
CALL(SetContinuousStates, FMU_CONTINUOUS,
     (fmi_instance c, const double states[], size_t count), fmu_set_states(c, states, count))
CALL(GetContinuousStates, FMU_EXCHANGE,
     (fmi_instance c, double states[], size_t count), fmu_get_states(c, states, count))
CALL(GET_RATES, FMU_EXCHANGE,
     (fmi_instance c, double derivatives[], size_t count), fmu_get_rates(c, derivatives, count))
CALL(GetNominalsOfContinuousStates, FMU_EXCHANGE,
     (fmi_instance c, double nominals[], size_t count), fmu_get_nominals(c, nominals, count))
NO_VALUES(GetEventIndicators, FMU_EXCHANGE,
          (fmi_instance c, double indicators[], size_t count), "there are none")

FMI(Status) FMI(CompletedIntegratorStep)(fmi_instance c, FMI(Boolean) no_set_state_before,
                                         FMI(Boolean) *enter_event_mode,
                                         FMI(Boolean) *terminate) {
    ALLOW(FMU_CONTINUOUS, CompletedIntegratorStep);
    REFUSE_IF(!enter_event_mode || !terminate, CompletedIntegratorStep, "an argument is NULL");
    *enter_event_mode = *terminate = 0;
    return (FMI(Status))FMU_OK;
}
