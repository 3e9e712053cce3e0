/* Rates of the slow flow, eqs. (18), (19), and its time steps. */
#ifndef SLIPMODE_SLOW_FLOW_H
#define SLIPMODE_SLOW_FLOW_H

#include "slow/friction_model.h"

/* Unknowns: amplitudes (modes, 2), then the energies that the contacts dissipate and the forces
 * supply. */
enum { SM_AMPLITUDES = 2 * SM_MODES, SM_DISSIPATED = SM_AMPLITUDES, SM_PUT_IN, SM_UNKNOWNS };

/* The amplitude equations without a'', at given amplitudes. */
typedef struct {
    sm_complex amplitude[SM_MODES];
    sm_friction friction;
    sm_complex gain[SM_MODES];     /* c s unit_j */
    sm_complex reaction[SM_MODES]; /* c s G_j: force of the contacts on the mode */
    double hardening[SM_MODES];    /* sum_k h_jk |a_k|^2 [rad^2/s^2] */
    sm_complex follow[SM_MODES];   /* (force / 2 + reaction - hardening a) / mass */
    sm_complex rate[SM_MODES];     /* follow - stiffness a / mass */
} sm_flow_state;

/* Returns the friction terms that act in steady motion: for modes on one tone also the combination
 * resonances. */
SM_INLINE sm_friction_terms sm_steady_terms(const sm_slow_flow *flow) {
    return flow->ratio != 0.0 ? SM_ALL_TERMS : SM_CARRIERS;
}

/* Evaluates the equations at amplitudes y (modes, 2) and the inputs of the instant. */
sm_status sm_flow_at(const sm_slow_flow *flow, sm_instant *instant, sm_friction_terms terms,
                     const double *y, sm_flow_state *state);

/* Computes the change of (force / 2 + reaction - hardening a) along changes of amplitudes and coefficients, and
 * the relative change w of the effective amplitudes, d|e| + i |e| d(arg e). d is NULL for constant
 * coefficients. The beat, which is 0 for SM_CARRIERS, is added for a change per second. */
void sm_flow_change(const sm_slow_flow *flow, const sm_instant *instant,
                    const sm_flow_state *state, const sm_complex *amplitude,
                    const sm_coefficients *d, sm_complex *load, sm_complex *w);

/* Computes d rate / d amplitude (2 modes, 2 modes) of the equations without a'', with a column for
 * each real part and each imaginary part. */
void sm_flow_jacobian(const sm_slow_flow *flow, const sm_instant *instant,
                      const sm_flow_state *state, double *jacobian);

/* Computes the derivative of the unknowns at the inputs of the instant. */
sm_status sm_slow_flow_derivative(const sm_slow_flow *flow, sm_instant *instant, const double *y,
                                  double *dy);

/* Checks everything but the contents of the table. */
sm_status sm_slow_flow_check(const sm_slow_flow *flow);

/* Unknowns and their derivative at a time. */
typedef struct {
    double y[SM_UNKNOWNS], dy[SM_UNKNOWNS];
} sm_flow_point;

/* A time step of `h` seconds that starts `elapsed` seconds after the inputs and ends at inputs
 * `end`. */
typedef struct {
    const sm_slow_flow *flow;
    const sm_inputs *inputs;
    sm_inputs end;
    double elapsed, h, tolerance;
} sm_time_step;

/* Integrates over the step; `error` is the error estimate relative to the tolerance (1 is the
 * limit). */
sm_status sm_dopri5(const sm_time_step *step, sm_instant *instant, const sm_flow_point *start,
                    sm_flow_point *end, double *error);

#endif
