/* An instance of the FMU, the same behind FMI 2.0 and 3.0.
 *
 * Each section below is a file of this folder, which calls functions of the sections above only.
 *
 * Every function may be called in any state and with any argument. A call that is not allowed is
 * refused with a logged reason, and leaves the instance unchanged.
 */
#ifndef FMU_INSTANCE_H
#define FMU_INSTANCE_H

#include <stddef.h>

#include "base/exact_sum.h"
#include "resources/model.h"
#include "slow/discontinuity.h"
#include "slow/inputs.h"

#define FMU_INPUT_SLOT(field) ((int32_t)(offsetof(sm_inputs, field) / sizeof(double)))
#define FMU_MESSAGE 512 /* bytes of a log message at most */

/* As fmi2Status and fmi3Status count them. */
typedef enum { FMU_OK = 0, FMU_WARNING, FMU_DISCARD, FMU_ERROR } fmu_status;

/* Returns from the calling function with the status of a call, unless it is FMU_OK. */
#define FMU_TRY(call)                          \
    do {                                       \
        const fmu_status called_ = (call);     \
        if (called_ != FMU_OK) return called_; \
    } while (0)

typedef enum { FMU_MODEL_EXCHANGE = 0, FMU_CO_SIMULATION } fmu_interface;

/* States of an instance; a combination states when a call is allowed. */
typedef enum {
    FMU_INSTANTIATED = 1,
    FMU_INITIALIZATION = 2,
    FMU_EVENTS = 4,      /* Model Exchange */
    FMU_CONTINUOUS = 8,  /* Model Exchange */
    FMU_STEPPING = 16,   /* Co-Simulation */
    FMU_TERMINATED = 32,
    FMU_STEP_EVENTS = 64, /* Co-Simulation, FMI 3.0 */
    FMU_INTERMEDIATE = 128, /* likewise, within a step */
    FMU_BEFORE_START = FMU_INSTANTIATED | FMU_INITIALIZATION,
    FMU_EXCHANGE = FMU_EVENTS | FMU_CONTINUOUS,
    FMU_RUNNING = FMU_EXCHANGE | FMU_STEPPING | FMU_STEP_EVENTS,
    FMU_SETTABLE = FMU_BEFORE_START | FMU_RUNNING,
    FMU_ANY = FMU_SETTABLE | FMU_TERMINATED, /* except within a step */
    FMU_READABLE = (FMU_ANY & ~FMU_INSTANTIATED) | FMU_INTERMEDIATE
} fmu_state;

/* How much of the motion the outputs hold. */
typedef enum { FMU_NO_MOTION, FMU_CONTACT_MOTION, FMU_ALL_MOTION } fmu_motion_known;

/* Where messages go; `callback` is the importer's, which only `write` knows how to call. */
typedef struct fmu_logger {
    void (*write)(const struct fmu_logger *logger, const char *instance_name, fmu_status status,
                  const char *category, const char *message);
    void (*callback)(void);
    void *environment;
    int events; /* whether more than warnings and errors is wanted */
} fmu_logger;

/* The importer's callback after each internal step; only `update` knows how to call it. */
typedef struct fmu_observer {
    /* Returns whether the step ends at `end`, if it may end early. NULL: there is no callback. */
    int (*update)(const struct fmu_observer *observer, double time, int may_end, double *end);
    void (*callback)(void);
    void *environment;
    uint32_t *wanted; /* (count) variables that may be read within a step, from malloc */
    size_t count;
} fmu_observer;

/* Values that continue a run, besides the outputs and the state of the component. */
typedef struct {
    double started;                 /* 1: the start values are in effect */
    double start, stop;             /* [s]; stop: infinite if none is given */
    double parameters[FMU_PARAMETERS];
    double amplitude[2 * SM_MODES]; /* at the start */
    sm_inputs inputs;               /* in the importer's units; angles unused */
    sm_inputs given_inputs;         /* Model Exchange: inputs as they were set, */
    double given_at[SM_INPUT_DOUBLES]; /* and when each of them, or its rate, was set [s] */
    sm_previous_force previous;     /* within an event: the force before it */
} fmu_run;

/* What is stepped; one of both, the other is NULL. */
typedef struct {
    sm_component *component;
    sm_tone_flow *tone;
} fmu_core;

typedef struct {
    fmu_logger logger;
    fmu_observer observer;
    char *name;
    fmu_interface interface;
    fmu_state state;
    const fmu_model *model;  /* shared with other instances */
    sm_slow_flow flow;       /* the model's, with the parameters of this instance; */
    sm_motion motion;        /* likewise */
    fmu_core *core;          /* in Model Exchange for contact motion alone */
    double built_with[FMU_PARAMETERS]; /* parameters of the core */

    fmu_run run;
    double rates[FMU_STATES];           /* derivatives, the modes that are not there left out */
    double *outputs;                    /* as sm_component_outputs or sm_tone_outputs packs them */
    size_t output_count;
    double refused_at, refused;         /* time and duration of the last step that was discarded */
    int event_mode, early_return;       /* Co-Simulation: what the importer allows */
    int terminated;                     /* whether a retry of the discarded step is useless */
    int far_forcing_logged;             /* whether a frequency far from its mode was */
    int inputs_current, outputs_current, rates_current;
    fmu_motion_known motion_current;
} fmu_instance;

/* ---- instance.c: log, allowed states, small helpers -------------------------------------- */

void fmu_log(const fmu_logger *logger, const char *instance_name, fmu_status status,
             const char *message);
/* Logs the message of a refused or unsuccessful call, and returns its status. */
fmu_status fmu_say(const fmu_instance *instance, fmu_status status, const char *format, ...);
/* Returns FMU_OK if the call is allowed in the present state. */
fmu_status fmu_allow(const fmu_instance *instance, unsigned states, const char *call);
fmu_status fmu_enter(fmu_instance *instance, fmu_state state);
fmu_status fmu_set_logging(fmu_instance *instance, int on, size_t count,
                           const char *const *categories);
/* Returns the name of the variable of this kind and slot. */
const char *fmu_name_of(const fmu_instance *instance, int32_t kind, int32_t slot);
int fmu_is_output(const fmu_variable *variable);
double fmu_modulus(const double amplitude[2]);
/* Returns the largest amplitudes of the friction table, at limit scale 1. */
void fmu_table_range(const fmu_instance *instance, double range[SM_MODES]);
/* Marks outputs, rates and motion as not evaluated. */
void fmu_outdate(fmu_instance *instance);
size_t fmu_state_count(const fmu_instance *instance);
/* Returns the place of state k among the outputs. */
size_t fmu_state_place(const fmu_instance *instance, size_t k);

/* ---- core.c: the functions sm_component_... or sm_tone_... of what is stepped -------------- */

sm_status fmu_core_create(const fmu_model *model, const sm_slow_flow *flow,
                          const sm_motion *motion, double tolerance, fmu_core **core);
void fmu_core_free(fmu_core *core);
sm_status fmu_core_reset(fmu_core *core, double time, const double *amplitude);
sm_status fmu_core_set_inputs(fmu_core *core, const sm_inputs *inputs);
sm_status fmu_core_step(fmu_core *core, double duration);
/* Advances by one internal step, at most by `most`. */
sm_status fmu_core_advance(fmu_core *core, double most);
sm_status fmu_core_slow_outputs(fmu_core *core, double *outputs);
/* Adds the motion of the contacts, and of DOFs where `elastic`, to the slow outputs. */
sm_status fmu_core_motion(fmu_core *core, int elastic, double *outputs);
size_t fmu_core_state_count(const fmu_core *core);
sm_status fmu_core_get_state(const fmu_core *core, double *state);
sm_status fmu_core_set_state(fmu_core *core, const double *state);

/* ---- inputs.c: inputs, which move at their rates until they are set again ---------------- */

/* Returns the inputs by their slots. */
double *fmu_slots(sm_inputs *inputs);
/* Returns the slot of an input's rate among the doubles of sm_inputs; negative if it has none. */
int32_t fmu_rate_slot(int32_t slot);
/* Returns whether values of this input must be positive. */
int fmu_input_is_positive(int32_t slot);
/* Sets an input or a rate, from the present time on. */
void fmu_set_input(fmu_instance *instance, int32_t slot, double value);
/* Moves inputs at their rates for a duration. */
void fmu_advance_inputs(sm_inputs *inputs, double duration);
/* Model Exchange: inputs move from the present values and time on. */
void fmu_note_inputs(fmu_instance *instance);
/* Model Exchange: moves the inputs to the present time. */
void fmu_move_inputs(fmu_instance *instance);
/* Turns forces in the importer's units into modal forces. */
void fmu_modal_inputs(const fmu_instance *instance, sm_inputs *inputs);
/* Returns the inputs of the core, with modal forces and the present carrier angles. */
sm_inputs fmu_inputs_now(const fmu_instance *instance);

/* ---- evaluate.c: from values that were set to values that are read ----------------------- */

/* Evaluates outputs, rates or motion if they are out of date. */
fmu_status fmu_evaluate_outputs(fmu_instance *instance);
fmu_status fmu_evaluate_rates(fmu_instance *instance);
fmu_status fmu_evaluate_motion(fmu_instance *instance, fmu_motion_known needed);
/* Reads the slow outputs of the component. */
fmu_status fmu_read_outputs(fmu_instance *instance);
/* Checks the inputs of a step, now and when it ends, and passes them to the component. */
fmu_status fmu_evaluate_step_inputs(fmu_instance *instance, double duration);
/* Passes the inputs to the component of a started Co-Simulation. */
fmu_status fmu_evaluate_inputs(fmu_instance *instance);
/* Gives the component other parameters; amplitudes and time stay. */
fmu_status fmu_retune(fmu_instance *instance, const double *parameters);
/* Gives the component other parameters and a state. If that fails, the instance is unchanged. */
fmu_status fmu_evaluate_restore(fmu_instance *instance, const double *parameters,
                                const double *core_state, const char *doing);
/* Returns the core's status as an FMI status, logged unless it is OK. */
fmu_status fmu_status_of(const fmu_instance *instance, sm_status status, const char *doing);
/* Logs that an amplitude of these outputs is outside the friction table; returns FMU_DISCARD. */
fmu_status fmu_say_outside(const fmu_instance *instance, const double *outputs, const char *doing,
                           const char *consequence);

/* ---- variables.c: variables by value reference; either all values of a call are set or none - */

/* Reads reals and, if allowed, arrays, whose elements lie one after the other: `values` in all. */
fmu_status fmu_get_reals(fmu_instance *instance, const uint32_t *reference, size_t count,
                         double *value, size_t values, int arrays);
fmu_status fmu_set_reals(fmu_instance *instance, const uint32_t *reference, size_t count,
                         const double *value);
/* Reads or sets enumerations or booleans, according to `type`. */
fmu_status fmu_get_integers(fmu_instance *instance, int32_t type, const uint32_t *reference,
                            size_t count, int32_t *value);
fmu_status fmu_set_integers(fmu_instance *instance, int32_t type, const uint32_t *reference,
                            size_t count, const int32_t *value);
/* Sets the rates d/dt of inputs from the present time on. */
fmu_status fmu_set_input_rates(fmu_instance *instance, const uint32_t *reference, size_t count,
                               const double *value);

/* ---- derivative.c ------------------------------------------------------------------------ */

/* The arguments of the derivative calls; output derivatives have unknowns and values only. */
typedef struct {
    const uint32_t *unknown;
    size_t unknowns;
    const uint32_t *known;
    size_t knowns;
    const double *seed; /* (knowns); of an adjoint derivative (unknowns) */
    double *value;      /* (unknowns); of an adjoint derivative (knowns) */
} fmu_derivative;

/* Replaces arrays among the unknowns by their elements. Returns the new unknowns, from malloc;
 * NULL, with a logged reason, without memory. */
uint32_t *fmu_scalars(const fmu_instance *instance, fmu_derivative *d);
/* value = d unknown / d known seed */
fmu_status fmu_directional(fmu_instance *instance, const fmu_derivative *d);
/* value = seed^T d unknown / d known */
fmu_status fmu_adjoint(fmu_instance *instance, const fmu_derivative *d);
/* value = d unknown / dt, as the amplitudes change and the inputs move */
fmu_status fmu_output_derivatives(fmu_instance *instance, const fmu_derivative *d);

/* ---- step.c: Co-Simulation --------------------------------------------------------------- */

/* Sets the callback after internal steps, which may read `count` outputs. */
fmu_status fmu_observe(fmu_instance *instance, const fmu_observer *observer,
                       const uint32_t *wanted, size_t count);
/* Advances from `time`, the present time, by `duration`; less if the step returns early. */
fmu_status fmu_step(fmu_instance *instance, double time, double duration);

/* ---- exchange.c: events, and Model Exchange, where the importer has time and states ------ */

/* Stores the present forces as the forces before the event; not in the initial event. */
fmu_status fmu_enter_events(fmu_instance *instance);
/* Discontinuities of the forces since then change the amplitudes by the free vibrations that they
 * leave, as between two steps of a component. */
fmu_status fmu_update_discrete(fmu_instance *instance, int *states_changed);
fmu_status fmu_enter_continuous(fmu_instance *instance);
fmu_status fmu_set_time(fmu_instance *instance, double time);
fmu_status fmu_set_states(fmu_instance *instance, const double *states, size_t count);
fmu_status fmu_get_states(fmu_instance *instance, double *states, size_t count);
fmu_status fmu_get_rates(fmu_instance *instance, double *rates, size_t count);
fmu_status fmu_get_nominals(fmu_instance *instance, double *nominals, size_t count);

/* ---- lifecycle.c: creation, initialization, reset ---------------------------------------- */

/* Returns NULL and logs the reason if it fails. `location` is the resource folder, as a path or a
 * URI. */
fmu_instance *fmu_instantiate(fmu_interface interface, const char *name, const char *token,
                              const char *location, const fmu_logger *logger);
void fmu_free(fmu_instance *instance);
fmu_status fmu_setup(fmu_instance *instance, int tolerance_defined, double tolerance, double start,
                     int stop_defined, double stop);
fmu_status fmu_exit_initialization(fmu_instance *instance);
fmu_status fmu_reset(fmu_instance *instance);

/* ---- snapshot.c: the state of an instance as one block of bytes, without pointers -------- */

typedef struct fmu_snapshot fmu_snapshot;

/* Writes into *snapshot, a new one if it is NULL. */
fmu_status fmu_snapshot_take(fmu_instance *instance, fmu_snapshot **snapshot);
fmu_status fmu_snapshot_apply(fmu_instance *instance, const fmu_snapshot *snapshot);
fmu_status fmu_snapshot_free(fmu_snapshot **snapshot);
fmu_status fmu_snapshot_size(const fmu_instance *instance, const fmu_snapshot *snapshot,
                             size_t *size);
fmu_status fmu_snapshot_write(const fmu_instance *instance, const fmu_snapshot *snapshot,
                              void *bytes, size_t size);
/* Reads into *snapshot, a new one. Damaged bytes are refused, and bytes of another model. */
fmu_status fmu_snapshot_read(const fmu_instance *instance, const void *bytes, size_t size,
                             fmu_snapshot **snapshot);

#endif
