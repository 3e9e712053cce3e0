/* An instance of the FMU, the same behind FMI 2.0 and 3.0.
 *
 * Every function may be called in any state and with any argument: what is not allowed is refused
 * with a logged reason, and leaves the instance as it was.
 */
#ifndef FMU_INSTANCE_H
#define FMU_INSTANCE_H

#include "slow/discontinuity.h"
#include "resources/shared.h"

#define FMU_INPUTS (sizeof(sm_inputs) / sizeof(double))
#define FMU_MESSAGE 512 /* bytes of a log message at most */

/* As fmi2Status and fmi3Status count them. */
typedef enum { FMU_OK = 0, FMU_WARNING, FMU_DISCARD, FMU_ERROR } fmu_status;

typedef enum { FMU_MODEL_EXCHANGE = 0, FMU_CO_SIMULATION } fmu_interface;

/* States of an instance, to be combined into those in which a call is allowed. */
typedef enum {
    FMU_INSTANTIATED = 1,
    FMU_INITIALIZATION = 2,
    FMU_EVENTS = 4,      /* Model Exchange */
    FMU_CONTINUOUS = 8,  /* Model Exchange */
    FMU_STEPPING = 16,   /* Co-Simulation */
    FMU_TERMINATED = 32,
    FMU_STEP_EVENTS = 64, /* Co-Simulation, FMI 3.0 */
    FMU_INTERMEDIATE = 128 /* likewise, within a step */
} fmu_state;
#define FMU_BEFORE_START (FMU_INSTANTIATED | FMU_INITIALIZATION)
#define FMU_RUNNING (FMU_EVENTS | FMU_CONTINUOUS | FMU_STEPPING | FMU_STEP_EVENTS)
#define FMU_ANY 127 /* but within a step */

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

/* Who is told of the internal steps of a step; `callback` is the importer's, which only `update`
 * knows how to call. */
typedef struct fmu_observer {
    /* Whether the step is to end at `end` already, where it may. NULL: nobody is told. */
    int (*update)(const struct fmu_observer *observer, double time, int may_end, double *end);
    void (*callback)(void);
    void *environment;
    uint32_t *wanted; /* (count) the variables that may be read meanwhile, from malloc */
    size_t count;
} fmu_observer;

typedef struct {
    fmu_logger logger;
    fmu_observer observer;
    char *name;
    fmu_interface interface;
    fmu_state state;
    const fmu_model *model;  /* shared with other instances */
    sm_slow_flow flow;       /* the model's, with the parameters of this instance; */
    sm_motion motion;        /* likewise */
    sm_component *component; /* in Model Exchange for contact motion alone */
    double built_with[FMU_PARAMETERS]; /* parameters of the component */

    double start, stop;                 /* [s]; stop: infinite where none is given */
    double parameters[FMU_PARAMETERS];
    double amplitude[2 * SM_MODES];     /* at the start */
    sm_inputs inputs;                   /* in the importer's units; angles unused */
    sm_inputs held_inputs;              /* Model Exchange: as they were set, */
    double held_since[FMU_INPUTS];      /* and when each was, or its rate [s] */
    sm_held_force held;                 /* known within an event: what acted before it */
    double rates[FMU_STATES];           /* derivatives, the modes that are not there left out */
    double *outputs;                    /* as sm_component_outputs packs them */
    size_t output_count;
    double refused_at, refused;         /* time and duration of the last step that was discarded */
    int event_mode, early_return;       /* Co-Simulation: what the importer allows */
    int terminated;                     /* whether it was, and to try again would not help */
    int far_forcing_logged;             /* whether a frequency far from its mode was */
    int started;                        /* whether the start values are in effect */
    int inputs_current, outputs_current, rates_current;
    fmu_motion_known motion_current;
} fmu_instance;

/* NULL if the instance cannot be; the reason is logged. `folder` ends in a separator. */
fmu_instance *fmu_instantiate(fmu_interface interface, const char *name, const char *token,
                              const char *folder, const fmu_logger *logger);
void fmu_free(fmu_instance *instance);

void fmu_log(const fmu_logger *logger, const char *instance_name, fmu_status status,
             const char *message);
/* Logs the message of a refused or unsuccessful call, and returns its status. */
fmu_status fmu_say(const fmu_instance *instance, fmu_status status, const char *format, ...);
/* FMU_OK if the call is allowed now. */
fmu_status fmu_allow(const fmu_instance *instance, unsigned states, const char *call);
fmu_status fmu_set_logging(fmu_instance *instance, int on, size_t count,
                           const char *const *categories);

/* ---- life cycle ------------------------------------------------------------------------ */

fmu_status fmu_setup(fmu_instance *instance, int tolerance_defined, double tolerance, double start,
                     int stop_defined, double stop);
fmu_status fmu_enter_initialization(fmu_instance *instance);
fmu_status fmu_exit_initialization(fmu_instance *instance);
fmu_status fmu_terminate(fmu_instance *instance);
fmu_status fmu_reset(fmu_instance *instance);
double fmu_time(const fmu_instance *instance);

/* ---- variables ------------------------------------------------------------------------- */

fmu_status fmu_get_reals(fmu_instance *instance, const uint32_t *reference, size_t count,
                         double *value);
/* Likewise of arrays too, whose values lie one after the other; so many in all. */
fmu_status fmu_get_floats(fmu_instance *instance, const uint32_t *reference, size_t count,
                          double *value, size_t values);
/* Reals, and what arrays consist of, from malloc; NULL, with a logged reason, where memory is short. */
uint32_t *fmu_scalars(const fmu_instance *instance, const uint32_t *reference, size_t count,
                      size_t *scalars);
fmu_status fmu_set_reals(fmu_instance *instance, const uint32_t *reference, size_t count,
                         const double *value);
/* Enumerations and booleans, `type` says which. */
fmu_status fmu_get_integers(fmu_instance *instance, int32_t type, const uint32_t *reference,
                            size_t count, int32_t *value);
fmu_status fmu_set_integers(fmu_instance *instance, int32_t type, const uint32_t *reference,
                            size_t count, const int32_t *value);
/* dv/dt of inputs during the steps to come. */
fmu_status fmu_set_input_rates(fmu_instance *instance, const uint32_t *reference, size_t count,
                               const double *value);

/* ---- inputs ---------------------------------------------------------------------------- */

/* The slot of an input's rate among the doubles of sm_inputs; negative for one that has none. */
int32_t fmu_rate_slot(int32_t slot);
int fmu_input_is_positive(int32_t slot);
/* An input, or a rate at which one moves from now on. */
void fmu_set_input(fmu_instance *instance, int32_t slot, double value);
/* Model Exchange: all inputs move from the present time on; and come to where they are then. */
void fmu_hold_inputs(fmu_instance *instance);
void fmu_move_inputs(fmu_instance *instance);

/* ---- derivatives ----------------------------------------------------------------------- */

/* Of the variable of a kind with a slot. */
const char *fmu_name_of(const fmu_instance *instance, int32_t kind, int32_t slot);
double fmu_modulus(const double amplitude[2]);
/* sensitivity = d unknown / d known seed */
fmu_status fmu_directional(fmu_instance *instance, const uint32_t *unknown, size_t unknowns,
                           const uint32_t *known, size_t knowns, const double *seed,
                           double *sensitivity);
/* sensitivity = seed^T d unknown / d known */
fmu_status fmu_adjoint(fmu_instance *instance, const uint32_t *unknown, size_t unknowns,
                       const uint32_t *known, size_t knowns, const double *seed,
                       double *sensitivity);
/* Of outputs by time, as the amplitudes change and the inputs move. */
fmu_status fmu_output_derivatives(fmu_instance *instance, const uint32_t *reference, size_t count,
                                  double *value);
/* Changes of the motion of contacts and DOFs along changes of the amplitudes and of modal inputs
 * with their angles; d_motion is 0 before. */
fmu_status fmu_motion_directional(fmu_instance *instance, const double *d_amplitude,
                                  const sm_inputs *d_inputs, double *d_motion);

/* ---- evaluation ------------------------------------------------------------------------ */

/* Brings into effect what was set, and up to date what is read. */
fmu_status fmu_evaluate_outputs(fmu_instance *instance);
fmu_status fmu_evaluate_rates(fmu_instance *instance);
fmu_status fmu_evaluate_motion(fmu_instance *instance, fmu_motion_known needed);
/* Forces in the importer's units become modal ones. */
void fmu_scale_forces(const fmu_instance *instance, sm_inputs *inputs);
/* The inputs as the core takes them, where the importer, or the component, has the angles. */
sm_inputs fmu_inputs_now(const fmu_instance *instance);
/* Changes of the rates of all states, and of input and dissipated power, along changes of the
 * amplitudes and of modal inputs with their angles; the outputs must be up to date. */
fmu_status fmu_evaluate_directional(fmu_instance *instance, const double *d_amplitude,
                                    const sm_inputs *d_inputs, double *d_rates,
                                    double d_power[2]);
/* Advances a component by duration > 0. */
fmu_status fmu_evaluate_step(fmu_instance *instance, double duration);
/* An evaluation or step that leaves the friction table is discarded; `outputs` are where. */
fmu_status fmu_say_outside(const fmu_instance *instance, const double *outputs, const char *doing,
                           const char *consequence);
/* A step that does is, and how far it would go is found out. */
fmu_status fmu_refuse_step(fmu_instance *instance, double duration);
/* Or it is taken as far as it goes: seconds, 0 where that is nowhere; negative on failure. */
double fmu_step_partly(fmu_instance *instance, double duration);
/* Steps that were discarded end the simulation where none can be done, or one is asked for again. */
void fmu_note_refusal(fmu_instance *instance, double duration, int stuck);
/* The inputs move at their rates. */
void fmu_advance_inputs(sm_inputs *inputs, double duration);
/* Advances the component, and tells the observer of each internal step; `duration` becomes shorter
 * where the observer ends the step. On any status but SM_OK all is as before. */
sm_status fmu_step_observed(fmu_instance *instance, double *duration);
/* Goes on with other parameters. */
fmu_status fmu_retune(fmu_instance *instance, const double *parameters);
/* Passes the inputs to a component if that is still to be done. */
void fmu_evaluate_inputs(fmu_instance *instance);
/* Puts a component with these parameters into a state; what was evaluated is forgotten. */
fmu_status fmu_evaluate_restore(fmu_instance *instance, const double *parameters,
                                const double *component_state);

/* ---- Co-Simulation --------------------------------------------------------------------- */

/* `observer` is told of internal steps, and may read so many variables then: outputs. */
fmu_status fmu_observe(fmu_instance *instance, const fmu_observer *observer,
                       const uint32_t *wanted, size_t count);
int fmu_is_observed(const fmu_instance *instance, uint32_t reference);
fmu_status fmu_step(fmu_instance *instance, double time, double duration);

/* ---- Model Exchange -------------------------------------------------------------------- */

/* From here the forces of before are held, but not in the initial event: whatever acts first did
 * before. */
fmu_status fmu_enter_events(fmu_instance *instance);
/* Discontinuities of the forces since then change the amplitudes as they do between the steps of a
 * component, by the free vibrations that are left behind. */
fmu_status fmu_update_discrete(fmu_instance *instance, int *states_changed);
fmu_status fmu_enter_continuous(fmu_instance *instance);
/* Co-Simulation, from event mode. */
fmu_status fmu_enter_steps(fmu_instance *instance);
size_t fmu_state_count(const fmu_instance *instance);
fmu_status fmu_set_time(fmu_instance *instance, double time);
fmu_status fmu_set_states(fmu_instance *instance, const double *states, size_t count);
fmu_status fmu_get_states(fmu_instance *instance, double *states, size_t count);
fmu_status fmu_get_rates(fmu_instance *instance, double *rates, size_t count);
fmu_status fmu_get_nominals(fmu_instance *instance, double *nominals, size_t count);

#endif
