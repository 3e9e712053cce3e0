/* The step-able component: slow flow and motion of the contacts. fmu/ and its library call it. */
#ifndef SLIPMODE_STEPPABLE_H
#define SLIPMODE_STEPPABLE_H

#include "slipmode_slow.h"

/* ---- the step-able component ----------------------------------------------------------- */

typedef struct sm_component sm_component;

/* Motion at communication points. The response of the modes to harmonics (n, m) of the contact
 * motion acts on the contacts with the force Re sum G_nm exp(i (n theta_A + m theta_B)), and moves
 * the elastic outputs by Re sum E_nm exp(...). G and E are linear between the nodes of the friction
 * table. Elastic outputs are x = 2 Re sum_j (modes_out_j a_j + forces_out_j F_j exp(i phase_j))
 * exp(i theta_j) + contacts_out x_c + E. */
typedef struct {
    int32_t wanted;              /* 1: contact motion can be read at communication points */
    int32_t elastic;             /* number of elastic outputs */
    const double *modes_out;     /* (elastic, modes, 2) */
    const double *forces_out;    /* (elastic, modes, 2): by the other modes, off resonance */
    const double *contacts_out;  /* (elastic, N_c) */
    int32_t orders_count;        /* harmonics that the modes respond to, 0 or more */
    const int32_t *orders;       /* (orders_count, 2) */
    const double *reaction;          /* (count_a, count_b, orders_count, N_c, 2) G_nm [N] */
    const double *response;        /* (count_a, count_b, orders_count, elastic, 2) E_nm [m] */
    int32_t steps_per_period;    /* of the faster carrier */
    double memory_periods;       /* memory of the contacts: an integration starts at most so many
                                    periods of the slower carrier before a communication point */
} sm_motion;

/* Creates a component. Arrays of the arguments are not copied and must outlive the component. */
SM_API sm_status sm_component_create(const sm_slow_flow *flow, const sm_contact *contact,
                                     const sm_motion *motion, double tolerance,
                                     sm_component **component);
/* Checks the arguments of a component, except its tolerance. */
SM_API sm_status sm_component_check(const sm_slow_flow *flow, const sm_contact *contact,
                                    const sm_motion *motion);
/* Creates a component from arguments that sm_component_check has accepted. Damping and
 * motion.wanted may have changed since. */
SM_API sm_status sm_component_checked_create(const sm_slow_flow *flow, const sm_contact *contact,
                                             const sm_motion *motion, double tolerance,
                                             sm_component **component);
SM_API void sm_component_free(sm_component *component);
/* Sets the state at `time`: amplitudes (modes, 2), angles 0, energy 0, contacts at rest. */
SM_API sm_status sm_component_reset(sm_component *component, double time,
                                    const double *amplitude);
/* Sets the amplitudes (modes, 2) at the present time and angles, for instance after an event. */
SM_API sm_status sm_component_set_amplitude(sm_component *component, const double *amplitude);
/* Sets the inputs from the present time on. SM_BAD_ARGUMENT if the limits are scaled but the law is
 * not homogeneous: tanh, gaps. */
SM_API sm_status sm_component_set_inputs(sm_component *component, const sm_inputs *inputs);
/* Advances by `duration` > 0. On any status but SM_OK the state is as before the call. An amplitude
 * outside the table after a change of force is limited to the edge of the table. */
SM_API sm_status sm_component_step(sm_component *component, double duration);
/* Advances by one internal step, or by several very short ones, at most by `most` > 0. `taken` is
 * the time by which the state has advanced. */
SM_API sm_status sm_component_advance(sm_component *component, double most, double *taken);

/* Outputs without motion: time, (Re, Im) of a_A and a_B, theta_A, theta_B, input power, power and
 * energy dissipated at the contacts. Outputs of a mode that the model does not have are 0. */
#define SM_OUTPUTS_FIXED 10
/* Returns the number of outputs: SM_OUTPUTS_FIXED; with motion.wanted also x_c, v_c, f_c (3 N_c)
 * and the elastic displacements. */
SM_API size_t sm_component_output_count(const sm_component *component);
/* Compute all outputs, and the first SM_OUTPUTS_FIXED outputs. */
SM_API sm_status sm_component_outputs(sm_component *component, double *outputs);
SM_API sm_status sm_component_slow_outputs(const sm_component *component, double *outputs);
/* Computes the other outputs; elastic displacements if `elastic`. The contacts are integrated from
 * their last output on, or over their memory. SM_BAD_ARGUMENT unless motion.wanted. */
SM_API sm_status sm_component_motion(sm_component *component, int elastic, double *motion);

/* Computes x_c, v_c, f_c (3 N_c) and the elastic displacements at given amplitudes that have
 * changed at `rate` (modes, 2 each) over the memory of the contacts; `inputs` with their angles.
 * `smooth`: with equal steps, so that the result is a smooth function of the arguments, for
 * derivatives. The state does not change. SM_BAD_ARGUMENT unless motion.wanted. */
SM_API sm_status sm_component_recent_motion(sm_component *component, const sm_inputs *inputs,
                                            const double *amplitude, const double *rate,
                                            int smooth, double *motion);

/* Makes `steps` steps with inputs[k] over durations[k], and computes the outputs (steps,
 * output_count) after each. `done` is the number of steps by which the state has advanced. If the
 * contact motion after a step cannot be computed, its outputs are NaN, and the step is the last. */
SM_API sm_status sm_component_run(sm_component *component, size_t steps, const double *durations,
                                  const sm_inputs *inputs, double *outputs, size_t *done);

/* Rows of a trace, and its progress: `done` steps and `elapsed` seconds of the next one, 0 in the
 * first call. */
typedef struct {
    size_t capacity, count; /* largest number of rows; rows written by this call */
    double *outputs;        /* (capacity, output_count) */
    size_t done;
    double elapsed;
} sm_trace;

/* Makes the steps of sm_component_run with outputs after each internal step. It returns when the
 * steps are done or all rows are written; the next call continues. */
SM_API sm_status sm_component_trace(sm_component *component, size_t steps, const double *durations,
                                    const sm_inputs *inputs, sm_trace *trace);

/* Returns the number of doubles of the state, which contains no addresses. */
SM_API size_t sm_component_state_count(const sm_component *component);
/* Writes the state; sets the state. */
SM_API sm_status sm_component_get_state(const sm_component *component, double *state);
SM_API sm_status sm_component_set_state(sm_component *component, const double *state);
/* Returns the numbers of accepted and rejected internal steps since creation. */
SM_API void sm_component_work(const sm_component *component, uint64_t *accepted,
                              uint64_t *rejected);

#endif
